// SPDX-License-Identifier: Apache-2.0
// Closed meshes that are displaced and cut anew in each frame of a flight around and down to them, by the frame's own passes:
// some with smooth normals, some with hard edges, all with seams of their texture coordinates; budgets bind in some frames.
#include <stdio.h>

#include "accel/watertight.h"
#include "frame/backend.h"

enum { SCENES_MOST = 8, FRAMES = 100 };

struct displaced_flight {
    clast_context *context;
    clast_scene *scenes[SCENES_MOST];
    char names[SCENES_MOST][100];
    uint32_t scene_count, current; // the scene that is open
    clast_cooked *cooked;
    clast_frame *frame;
};

#define CPU_PASS(pass, function) [pass] = function,
static const clast_backend backend = {.name = "cpu", .passes = {CLAST_FRAME_CPU_PASSES(CPU_PASS)}};

// ------------------------------------------------------------------------------------------------------------ scenes

// Heights of 16 bits, rough in all places.
static clast_status add_heights(clast_scene *scene, clast_material_desc *material)
{
    enum { SIDE = 64 };
    static uint16_t texels[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        float x = (float)(i % SIDE) * 6.2831853f / SIDE, y = (float)(i / SIDE) * 6.2831853f / SIDE;
        float waves = sinf(3.0f * x) * cosf(2.0f * y) + 0.5f * sinf(7.0f * x + 5.0f * y);
        texels[i] = (uint16_t)(32768.0f + 20000.0f * waves);
    }
    clast_image image = {SIDE, SIDE, 1, CLAST_PIXEL_UNORM16, texels};
    clast_texture texture = {0, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    clast_status status = clast_scene_add_image(scene, &image, "heights", &texture.image);
    return status == CLAST_OK ? clast_scene_add_texture(scene, &texture, &material->displacement_texture.texture)
                              : status;
}

// Each triangle with vertices of its own, and texture coordinates from the two axes that it faces least: where these change,
// there is a seam.
static clast_status add_loose(clast_scene *scene, const mesh *m, bool smooth, uint32_t *geometry)
{
    size_t corners = 3 * (size_t)m->triangle_count;
    float *positions = malloc(corners * 12), *normals = malloc(corners * 12), *coordinates = malloc(corners * 8);
    uint32_t *indices = malloc(corners * 4);
    for (size_t i = 0; i < corners; i++) {
        const float *p[3], *own = m->positions + 3 * (size_t)m->indices[i];
        float facing[3];
        for (uint32_t k = 0; k < 3; k++) {
            p[k] = m->positions + 3 * (size_t)m->indices[i / 3 * 3 + k];
        }
        for (uint32_t axis = 0; axis < 3; axis++) {
            uint32_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            facing[axis] = fabsf((p[1][u] - p[0][u]) * (p[2][v] - p[0][v]) - (p[1][v] - p[0][v]) * (p[2][u] - p[0][u]));
            positions[3 * i + axis] = own[axis];
            normals[3 * i + axis] = own[axis] / sqrtf(own[0] * own[0] + own[1] * own[1] + own[2] * own[2]);
        }
        uint32_t axis = facing[1] > facing[0] ? 1 : 0;
        axis = facing[2] > facing[axis] ? 2 : axis;
        coordinates[2 * i] = 0.7f * own[(axis + 1) % 3] + 0.3f * (float)axis;
        coordinates[2 * i + 1] = 0.7f * own[(axis + 2) % 3];
        indices[i] = (uint32_t)i;
    }
    clast_mesh loose = {.vertex_count = (uint32_t)corners,
                        .triangle_count = m->triangle_count,
                        .positions = positions,
                        .normals = smooth ? normals : NULL,
                        .coordinates = {coordinates, NULL},
                        .indices = indices,
                        .material = 0};
    clast_status status = clast_scene_add_mesh(scene, &loose, "loose", geometry);
    free(positions);
    free(normals);
    free(coordinates);
    free(indices);
    return status;
}

static clast_status fill_scene(clast_scene *scene, const mesh *m, bool smooth, bool curved)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    clast_material_desc material = clast_material_defaults();
    material.displacement_scale = 0.12f;
    material.displacement_offset = -0.06f;
    uint32_t geometry, instance;
    clast_tessellation tessellation = {curved};
    clast_status status = add_heights(scene, &material);
    status = status == CLAST_OK ? clast_scene_set_material(scene, 0, &material) : status;
    status = status == CLAST_OK ? add_loose(scene, m, smooth, &geometry) : status;
    status = status == CLAST_OK ? clast_scene_set_tessellation(scene, geometry, &tessellation) : status;
    return status == CLAST_OK ? clast_scene_add_instance(scene, geometry, identity, NULL, &instance) : status;
}

static clast_status add_scene(displaced_flight *f, const char *name, mesh m, bool smooth, bool curved)
{
    clast_scene **scene = &f->scenes[f->scene_count];
    snprintf(f->names[f->scene_count], sizeof f->names[0], "displaced %s", name);
    clast_status status = clast_scene_create(f->context, scene);
    f->scene_count += status == CLAST_OK;
    status = status == CLAST_OK ? fill_scene(*scene, &m, smooth, curved) : status;
    mesh_free(&m);
    return status;
}

static mesh box(void)
{
    mesh m = mesh_cube_sphere(2);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        float *p = m.positions + 3 * (size_t)i, largest = fmaxf(fabsf(p[0]), fmaxf(fabsf(p[1]), fabsf(p[2])));
        for (uint32_t axis = 0; axis < 3; axis++) {
            p[axis] = p[axis] / largest * (1.0f + 0.3f * (float)axis);
        }
    }
    return m;
}

static bool is_alone(const clast_scene *scene)
{
    return scene->instance_count == 1 && scene->geometry_count == 1;
}

// Models of a folder of assets that are closed: others are told, and left out.
static void add_models(displaced_flight *f, const char *assets)
{
    static const char *const models[] = {"sphere_stone_tile", "spot_rock"};
    for (uint32_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        char path[1000];
        snprintf(path, sizeof path, "%s/displaced-gltf/%s/%s.gltf", assets, models[i], models[i]);
        clast_scene *scene = NULL;
        if (clast_scene_load(f->context, path, &scene) != CLAST_OK || !is_alone(scene)) {
            printf("%s: left out: %s\n", path, scene != NULL ? "more than one thing" : clast_context_error(f->context));
            clast_scene_destroy(scene);
            continue;
        }
        snprintf(f->names[f->scene_count], sizeof f->names[0], "%s", models[i]);
        f->scenes[f->scene_count++] = scene;
    }
}

displaced_flight *displaced_flight_create(clast_context *context, const char *assets)
{
    displaced_flight *f = calloc(1, sizeof *f);
    f->context = context;
    f->current = CLAST_NONE;
    clast_status status = add_scene(f, "sphere", mesh_sphere(14, 9), true, false);
    status = status == CLAST_OK ? add_scene(f, "torus", mesh_torus(18, 9, 1.0f, 0.4f), false, false) : status;
    status = status == CLAST_OK ? add_scene(f, "box", box(), false, false) : status;
    status = status == CLAST_OK ? add_scene(f, "curved sphere", mesh_octasphere(2), true, true) : status;
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(context));
        displaced_flight_destroy(f);
        return NULL;
    }
    if (assets != NULL && assets[0] != '\0') {
        add_models(f, assets);
    }
    return f;
}

static void close_scene(displaced_flight *f)
{
    clast_frame_destroy(f->frame);
    clast_cooked_destroy(f->cooked);
    f->frame = NULL;
    f->cooked = NULL;
}

void displaced_flight_destroy(displaced_flight *f)
{
    close_scene(f);
    for (uint32_t i = 0; i < f->scene_count; i++) {
        clast_scene_destroy(f->scenes[i]);
    }
    free(f);
}

// ------------------------------------------------------------------------------------------------------------ frames

static clast_status open_scene(displaced_flight *f, uint32_t number)
{
    if (f->current == number) {
        return CLAST_OK;
    }
    close_scene(f);
    f->current = number;
    clast_status status = clast_cooked_create(f->context, &f->cooked);
    status = status == CLAST_OK ? clast_cooked_update(f->cooked, f->scenes[number]) : status;
    return status == CLAST_OK ? clast_frame_create(f->scenes[number], f->cooked, &f->frame) : status;
}

// Twice around the middle, from three times its size away down to near the surface. Nearer still, parts of triangles would be as
// small as weights tell apart, and collapse in pairs: closed, but no surface to aim at.
static clast_camera camera_at(const clast_scene *scene, float part)
{
    const clast_instance *instance = &scene->instances[0];
    const clast_mesh *m = &scene->geometries[0].of.mesh;
    float radius = 0.0f, scale = 0.0f;
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        const float *p = m->positions + 3 * (size_t)i;
        radius = fmaxf(radius, sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
    }
    clast_transform map = instance->to_world;
    for (uint32_t row = 0; row < 3; row++) {
        scale = fmaxf(scale, sqrtf(map.rows[row].v[0] * map.rows[row].v[0] + map.rows[row].v[1] * map.rows[row].v[1] +
                                   map.rows[row].v[2] * map.rows[row].v[2]));
    }
    float angle = 4.0f * 3.14159265f * part, distance = radius * scale * (1.4f + 2.0f * (1.0f - part));
    clast_camera_desc desc = {.vertical_angle = 0.8f};
    const float way[3] = {cosf(angle) * 0.9f, 0.4f * sinf(1.7f * angle), sinf(angle) * 0.9f};
    for (uint32_t axis = 0; axis < 3; axis++) {
        desc.target[axis] = map.rows[axis].v[3];
        desc.position[axis] = desc.target[axis] + way[axis] * distance;
    }
    return clast_camera_record(&desc, 640, 360);
}

static void copy_record(const clast_frame *frame, const clast_frame_unit *unit, size_t number, mesh *m)
{
    const clast_source *source = clast_source_of(unit->unit);
    const clast_cluster_record *record = &unit->records[number];
    const packed3 *vertices = source->resident(unit->unit, record);
    uint8_t all[3 * TEMPLATE_TRIANGLES];
    if (record_form(*record) == FORM_COMPOSITE) {
        source->corners(unit->unit, record, clast_frame_words(unit, record), all);
    }
    for (uint32_t i = 0; i < record_triangles(*record); i++) {
        uint32_t corners[3] = {all[3 * i], all[3 * i + 1], all[3 * i + 2]};
        if (record_form(*record) == FORM_WHOLE) {
            clast_template_triangle(frame->cooked->templates, record->template_index, i, corners);
        }
        for (uint32_t k = 0; k < 3; k++) {
            m->indices[3 * (size_t)m->triangle_count + k] = m->vertex_count + corners[k];
        }
        m->triangle_count++;
    }
    memcpy(m->positions + 3 * (size_t)m->vertex_count,
           vertices != NULL ? vertices : unit->vertices + record->first_vertex,
           record_vertices(*record) * sizeof *vertices);
    m->vertex_count += record_vertices(*record);
}

static mesh copy_frame(const clast_frame *frame)
{
    const clast_frame_unit *unit = &frame->units[0];
    mesh m = mesh_of((uint32_t)unit->cluster_vertices, (uint32_t)unit->sum.triangles);
    m.vertex_count = m.triangle_count = 0;
    for (size_t i = 0; i < unit->record_count; i++) {
        copy_record(frame, unit, i, &m);
    }
    return m;
}

// Half edges from one vertex to another.
static uint32_t count_sides(const surface *s, uint32_t from, uint32_t to)
{
    uint32_t count = 0;
    for (uint32_t i = s->first_faces[from]; i < s->first_faces[from + 1]; i++) {
        const uint32_t *v = s->m.indices + 3 * (size_t)s->faces[i];
        bool is_line = v[0] == v[1] || v[1] == v[2] || v[2] == v[0]; // its sides cancel
        for (uint32_t k = 0; k < 3 && !is_line; k++) {
            count += v[k] == from && v[(k + 1) % 3] == to;
        }
    }
    return count;
}

// Edges along which not as many triangles run forth as back.
static uint32_t count_open(const surface *s)
{
    uint32_t open = 0;
    for (uint32_t i = 0; i < 3 * s->m.triangle_count; i++) {
        uint32_t from = s->m.indices[i], to = s->m.indices[i % 3 == 2 ? i - 2 : i + 1];
        open += from != to && count_sides(s, from, to) != count_sides(s, to, from);
    }
    return open;
}

uint32_t displaced_flight_frames(const displaced_flight *f)
{
    (void)f;
    return FRAMES;
}

clast_status displaced_flight_fly(displaced_flight *f, uint32_t number, displaced_moment *moment)
{
    // each scene's part of the flight is a flight of its own
    uint32_t scene = number * f->scene_count / FRAMES;
    uint32_t first = (scene * FRAMES + f->scene_count - 1) / f->scene_count;
    uint32_t end = ((scene + 1) * FRAMES + f->scene_count - 1) / f->scene_count;
    clast_status status = open_scene(f, scene);
    if (status != CLAST_OK) {
        return status;
    }
    clast_camera camera = camera_at(f->scenes[scene], (float)(number - first) / (float)(end - first));
    f->frame->settings = (clast_frame_settings){
        .camera = camera,
        .camera_number = CLAST_NONE,
        .rate_camera = camera,
        .rate_camera_number = CLAST_NONE,
        .width = 640,
        .height = 360,
        .metric = number % 2 == 0 ? CLAST_METRIC_PIXELS : CLAST_METRIC_SPHERE,
        .rate = 1.0,
        .segment = 3.0,
        .hidden_fraction = 0.25,
        .displacement_scale = 1.0,
        .max_triangles = number % 3 == 0 ? 20000 : 60000,
    };
    status = clast_frame_run(f->frame, &backend, CLAST_PASS_ANIMATE, CLAST_PASS_TLAS, NULL);
    if (status != CLAST_OK) {
        return status;
    }
    char name[150];
    snprintf(name, sizeof name, "%s, frame %u", f->names[scene], number);
    mesh m = copy_frame(f->frame);
    *moment = (displaced_moment){.tlas = f->frame->tlas};
    moment->collapsed = surface_make(f->context, name, &m, &moment->s);
    moment->open = moment->collapsed != 0 ? count_open(&moment->s) : 0;
    float map[3][4];
    memcpy(map, &f->frame->instances[0].to_world, sizeof map);
    moment->map = placing_of(map);
    return CLAST_OK;
}
