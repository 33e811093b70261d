// SPDX-License-Identifier: Apache-2.0
#include "accel_workloads.h"

#include <stdio.h>
#include <sys/mman.h>

#include "base/thread.h"
#include "scene/scene.h"

enum { MOVE_GRAIN = 4096 };

void *bench_allocate(size_t count, size_t size)
{
    size_t bytes = (count + 1) * size, page = (size_t)1 << 21;
    size_t alignment = bytes >= page ? page : 64; // as packets of 16 rays want it
    void *block = aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (block == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    if (alignment == page) {
        madvise(block, bytes, MADV_HUGEPAGE); // only advice: it may fail
    }
    return memset(block, 0, bytes);
}

// Moves a mesh's arrays to large pages, where clast's own blocks are too.
static void use_large_pages(mesh *m)
{
    float *positions = bench_allocate((size_t)m->vertex_count + 1, 12);
    uint32_t *indices = bench_allocate((size_t)m->triangle_count + 1, 12);
    memcpy(positions, m->positions, (size_t)m->vertex_count * 12);
    memcpy(indices, m->indices, (size_t)m->triangle_count * 12);
    mesh_free(m);
    m->positions = positions;
    m->indices = indices;
}

// ------------------------------------------------------------------------------------------------------------ surfaces

static float height_at(float x, float y)
{
    float height = 0.0f, size = 0.11f, frequency = 7.0f;
    for (int i = 0; i < 7; i++) {
        height += size * sinf(frequency * x + 1.7f * (float)i) * cosf(frequency * 0.93f * y + 0.6f * (float)i);
        size *= 0.5f;
        frequency *= 2.1f;
    }
    return height;
}

// Of a cube's face, projected to the sphere: edges of two faces are the same points.
static void sphere_point(uint32_t sheet, float x, float y, float p[3])
{
    float cube[3];
    uint32_t axis = sheet / 2;
    float side = sheet % 2 != 0 ? 1.0f : -1.0f;
    cube[axis] = side;
    cube[(axis + 1) % 3] = (2.0f * x - 1.0f) * side; // both faces of an axis are seen from the same side
    cube[(axis + 2) % 3] = 2.0f * y - 1.0f;
    float scale = 1.0f / sqrtf(cube[0] * cube[0] + cube[1] * cube[1] + cube[2] * cube[2]);
    for (int i = 0; i < 3; i++) {
        p[i] = cube[i] * scale;
    }
    float factor = 1.0f + 0.4f * height_at(4.0f * p[0] + p[2], 4.0f * p[1] - p[2]);
    for (int i = 0; i < 3; i++) {
        p[i] *= factor;
    }
}

static void terrain_point(uint32_t sheet, float x, float y, float p[3])
{
    (void)sheet;
    p[0] = x;
    p[1] = y;
    p[2] = height_at(x, y);
}

// Folds in all directions, finer ones on coarser ones, so that the sheet lies over itself.
static void cloth_point(uint32_t sheet, float x, float y, float p[3])
{
    (void)sheet;
    p[0] = x;
    p[1] = y;
    p[2] = 0.0f;
    float amplitude = 0.12f, frequency = 5.0f;
    randoms r = {5};
    for (int i = 0; i < 9; i++) {
        float turn = random_between(&r, 0.0f, 6.2831853f), phase = random_between(&r, 0.0f, 6.2831853f);
        float wave = amplitude * sinf(frequency * (x * cosf(turn) + y * sinf(turn)) + phase);
        float z = random_between(&r, -1.0f, 1.0f), around = random_between(&r, 0.0f, 6.2831853f);
        float radius = sqrtf(1.0f - z * z);
        p[0] += wave * radius * cosf(around);
        p[1] += wave * radius * sinf(around);
        p[2] += wave * z;
        amplitude *= 0.62f;
        frequency *= 1.7f;
    }
}

typedef struct surface_job {
    workload *w;
    void (*point)(uint32_t sheet, float x, float y, float p[3]);
} surface_job;

static const struct {
    const char *name;
    uint32_t sheets;
    void (*point)(uint32_t sheet, float x, float y, float p[3]);
    float eye[3], target[3];
} surfaces[SURFACE_COUNT] = {
    [SURFACE_SPHERE] = {"displaced sphere", 6, sphere_point, {0, 0, 0}, {1, 0.2f, 0.1f}},
    [SURFACE_TERRAIN] = {"terrain", 1, terrain_point, {-0.1f, -0.1f, 0.35f}, {0.6f, 0.6f, 0.0f}},
    [SURFACE_CLOTH] = {"crumpled cloth", 1, cloth_point, {-0.2f, -0.35f, 0.7f}, {0.5f, 0.5f, 0.0f}},
};

static void measure_box(workload *w, float lower[3], float upper[3])
{
    for (int axis = 0; axis < 3; axis++) {
        lower[axis] = INFINITY;
        upper[axis] = -INFINITY;
    }
    for (size_t i = 0; i < 3 * (size_t)w->m.vertex_count; i++) {
        lower[i % 3] = fminf(lower[i % 3], w->m.positions[i]);
        upper[i % 3] = fmaxf(upper[i % 3], w->m.positions[i]);
    }
    w->size = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        w->size = fmaxf(w->size, upper[axis] - lower[axis]);
    }
}

// The whole as one part, around the longest axis of its box.
static void make_one_part(workload *w)
{
    float lower[3], upper[3];
    measure_box(w, lower, upper);
    w->parts = bench_allocate(1, sizeof *w->parts);
    w->part_count = 1;
    *w->parts = (workload_part){.vertex_count = w->m.vertex_count};
    for (int axis = 0; axis < 3; axis++) {
        float half = 0.5f * (upper[axis] - lower[axis]);
        w->parts->centre[axis] = lower[axis] + half;
        if (half > w->parts->half) {
            memset(w->parts->axis, 0, sizeof w->parts->axis);
            w->parts->axis[axis] = 1.0f;
            w->parts->half = half;
        }
    }
}

const char *workload_surface_name(surface kind)
{
    return surfaces[kind].name;
}

workload workload_surface(surface kind, uint32_t triangles)
{
    uint32_t sheets = surfaces[kind].sheets;
    uint32_t tiles = (uint32_t)lround(sqrt((double)triangles / (2.0 * TILE_QUADS * TILE_QUADS * sheets)));
    tiles = tiles > 0 ? tiles : 1;
    uint32_t quads = tiles * TILE_QUADS, side = quads + 1;
    workload w = {
        .m = mesh_of(sheets * side * side, 2 * sheets * quads * quads), .sheet_count = sheets, .sheet_tiles = tiles};
    snprintf(w.name, sizeof w.name, "%s", surfaces[kind].name);
    memcpy(w.eye, surfaces[kind].eye, sizeof w.eye);
    memcpy(w.target, surfaces[kind].target, sizeof w.target);
    uint32_t *corner = w.m.indices;
    for (uint32_t sheet = 0; sheet < sheets; sheet++) {
        for (uint32_t j = 0; j < side; j++) {
            for (uint32_t i = 0; i < side; i++) {
                uint32_t v = (sheet * side + j) * side + i;
                surfaces[kind].point(sheet, (float)i / (float)quads, (float)j / (float)quads,
                                     w.m.positions + 3 * (size_t)v);
                if (i < quads && j < quads) {
                    mesh_quad(&corner, v, v + 1, v + side + 1, v + side);
                }
            }
        }
    }
    use_large_pages(&w.m);
    make_one_part(&w);
    return w;
}

// -------------------------------------------------------------------------------------------------------------- models

static mesh append_mesh(mesh *a, const mesh *b)
{
    mesh both = mesh_of(a->vertex_count + b->vertex_count, a->triangle_count + b->triangle_count);
    memcpy(both.positions, a->positions, (size_t)a->vertex_count * 12);
    memcpy(both.positions + 3 * (size_t)a->vertex_count, b->positions, (size_t)b->vertex_count * 12);
    memcpy(both.indices, a->indices, (size_t)a->triangle_count * 12);
    for (size_t i = 0; i < 3 * (size_t)b->triangle_count; i++) {
        both.indices[3 * (size_t)a->triangle_count + i] = a->vertex_count + b->indices[i];
    }
    mesh_free(a);
    return both;
}

// Positions that a file repeats, for their normals' sake, become one.
static void weld(clast_context *context, mesh *m)
{
    uint32_t *remap = bench_allocate(m->vertex_count, sizeof *remap), *number = bench_allocate(m->vertex_count, 4);
    size_t unique;
    bench_check(clast_weld_positions(context, m->positions, m->vertex_count, remap, &unique), context);
    uint32_t next = 0;
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        if (remap[i] == i) {
            memmove(m->positions + 3 * (size_t)next, m->positions + 3 * (size_t)i, 12);
            number[i] = next++;
        }
    }
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        m->indices[i] = number[remap[m->indices[i]]];
    }
    m->vertex_count = next;
    free(remap);
    free(number);
}

// All meshes of a file, without their instances' transforms, around the origin, the longest side of the box 1.
static mesh load_mesh(clast_context *context, const char *name)
{
    mesh all = mesh_of(0, 0);
    const char *assets = getenv("CLAST_ASSETS");
    char path[1024];
    clast_scene *scene;
    snprintf(path, sizeof path, "%s/dense/%s", assets != NULL ? assets : ".", name);
    if (assets == NULL || clast_scene_load(context, path, &scene) != CLAST_OK) {
        return all;
    }
    for (size_t i = 0; i < scene->geometry_count; i++) {
        if (scene->geometries[i].kind == CLAST_SOURCE_CLUSTERS) {
            const clast_mesh *part = &scene->geometries[i].of.mesh;
            mesh m = mesh_of(part->vertex_count, part->triangle_count);
            memcpy(m.positions, part->positions, (size_t)part->vertex_count * 12);
            memcpy(m.indices, part->indices, (size_t)part->triangle_count * 12);
            all = append_mesh(&all, &m);
            mesh_free(&m);
        }
    }
    clast_scene_destroy(scene);
    weld(context, &all);
    workload w = {.m = all};
    float lower[3], upper[3];
    measure_box(&w, lower, upper);
    for (size_t i = 0; i < 3 * (size_t)all.vertex_count; i++) {
        all.positions[i] = (all.positions[i] - 0.5f * (lower[i % 3] + upper[i % 3])) / w.size;
    }
    return all;
}

// Halves all edges: four triangles of one.
static mesh halve_edges(const mesh *m)
{
    uint32_t edges = 3 * m->triangle_count, next = m->vertex_count;
    uint64_t slots = 2;
    while (slots < 2 * (uint64_t)edges) {
        slots *= 2;
    }
    mesh fine = mesh_of(m->vertex_count + edges, 4 * m->triangle_count);
    memcpy(fine.positions, m->positions, (size_t)m->vertex_count * 12);
    uint64_t *keys = bench_allocate(slots, sizeof *keys); // both ends plus one; zero: free
    uint32_t *middles = bench_allocate(slots, sizeof *middles), *corner = fine.indices;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        const uint32_t *v = m->indices + 3 * (size_t)i;
        uint32_t middle[3];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = v[k] < v[(k + 1) % 3] ? v[k] : v[(k + 1) % 3], b = v[k] ^ v[(k + 1) % 3] ^ a;
            uint64_t key = ((uint64_t)a << 32 | b) + 1, slot = key * 0x9e3779b97f4a7c15u >> 20;
            while (keys[slot &= slots - 1] != 0 && keys[slot] != key) {
                slot++;
            }
            if (keys[slot] == 0) {
                keys[slot] = key;
                middles[slot] = next;
                for (uint32_t axis = 0; axis < 3; axis++) {
                    fine.positions[3 * (size_t)next + axis] = 0.5f * (m->positions[3 * (size_t)a + axis] +
                                                                      m->positions[3 * (size_t)b + axis]);
                }
                next++;
            }
            middle[k] = middles[slot];
        }
        const uint32_t corners[12] = {v[0],      middle[0], middle[2], middle[0], v[1],      middle[1],
                                      middle[2], middle[1], v[2],      middle[0], middle[1], middle[2]};
        memcpy(corner, corners, sizeof corners);
        corner += 12;
    }
    free(keys);
    free(middles);
    fine.vertex_count = next;
    return fine;
}

static void look_from_outside(workload *w)
{
    float lower[3], upper[3];
    measure_box(w, lower, upper);
    for (int axis = 0; axis < 3; axis++) {
        w->target[axis] = 0.5f * (lower[axis] + upper[axis]);
        w->eye[axis] = w->target[axis] + w->size * (axis == 2 ? 0.9f : 0.5f);
    }
}

workload workload_model(clast_context *context, const char *file, uint32_t triangles)
{
    workload w = {.m = load_mesh(context, file)};
    snprintf(w.name, sizeof w.name, "%s", file);
    while (w.m.triangle_count > 0 && w.m.triangle_count < triangles) {
        mesh fine = halve_edges(&w.m);
        mesh_free(&w.m);
        w.m = fine;
    }
    if (w.m.triangle_count > 0) {
        use_large_pages(&w.m);
        make_one_part(&w);
        look_from_outside(&w);
    }
    return w;
}

// Copies a model, turned at random, and notes the copy as a part.
static void place_copy(workload *w, const mesh *model, const float centre[3], randoms *r)
{
    float q[4], length = 0.0f;
    for (int i = 0; i < 4; i++) {
        q[i] = random_between(r, -1.0f, 1.0f);
        length += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++) {
        q[i] /= sqrtf(length);
    }
    float x = q[0], y = q[1], z = q[2], s = q[3];
    const float turn[3][3] = {
        {1 - 2 * (y * y + z * z), 2 * (x * y - z * s), 2 * (x * z + y * s)},
        {2 * (x * y + z * s), 1 - 2 * (x * x + z * z), 2 * (y * z - x * s)},
        {2 * (x * z - y * s), 2 * (y * z + x * s), 1 - 2 * (x * x + y * y)},
    };
    workload_part *part = &w->parts[w->part_count++];
    *part = (workload_part){.first_vertex = w->m.vertex_count, .vertex_count = model->vertex_count, .half = 0.5f};
    for (int row = 0; row < 3; row++) {
        part->centre[row] = centre[row];
        part->axis[row] = turn[row][1];
        for (size_t i = 0; i < model->vertex_count; i++) {
            const float *p = model->positions + 3 * i;
            w->m.positions[3 * (w->m.vertex_count + i) + (size_t)row] = centre[row] + turn[row][0] * p[0] +
                                                                        turn[row][1] * p[1] + turn[row][2] * p[2];
        }
    }
    for (size_t i = 0; i < 3 * (size_t)model->triangle_count; i++) {
        w->m.indices[3 * (size_t)w->m.triangle_count + i] = w->m.vertex_count + model->indices[i];
    }
    w->m.vertex_count += model->vertex_count;
    w->m.triangle_count += model->triangle_count;
}

workload workload_pile(clast_context *context, uint32_t triangles)
{
    static const char *const files[] = {"lucy.ply",  "bun_zipper.ply", "nefertiti-lowres.obj",
                                        "koala.obj", "skull.obj",      "pizza.obj"};
    enum { FILES = sizeof files / sizeof files[0] };
    mesh models[FILES];
    uint32_t vertices = 0, count = 0, copies = 0, known = 0;
    for (int i = 0; i < FILES; i++) {
        models[i] = load_mesh(context, files[i]);
        known += models[i].triangle_count;
    }
    workload w = {.name = "pile of scans"};
    for (; known > 0 && count < triangles; copies++) {
        count += models[copies % FILES].triangle_count;
        vertices += models[copies % FILES].vertex_count;
    }
    w.m = mesh_of(vertices, count);
    w.m.vertex_count = w.m.triangle_count = 0;
    w.parts = bench_allocate(copies, sizeof *w.parts);
    randoms r = {9};
    uint32_t side = (uint32_t)ceil(cbrt((double)copies));
    for (uint32_t i = 0; i < copies; i++) {
        float centre[3] = {0.75f * (float)(i % side), 0.75f * (float)(i / side % side),
                           0.75f * (float)(i / side / side)};
        if (models[i % FILES].triangle_count > 0) {
            place_copy(&w, &models[i % FILES], centre, &r);
        }
    }
    for (int i = 0; i < FILES; i++) {
        mesh_free(&models[i]);
    }
    use_large_pages(&w.m);
    look_from_outside(&w);
    return w;
}

void workload_free(workload *w)
{
    mesh_free(&w->m);
    free(w->parts);
}

// -------------------------------------------------------------------------------------------------------------- motion

typedef struct move_job {
    const workload *w;
    const workload_part *part;
    float amount; // phase of the wave, or half turns
    float *moved;
} move_job;

// Along the wave's own direction, so that it stretches and squeezes by amplitude times frequency.
static void wave_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const move_job *job = data;
    const float direction[3] = {0.6f, 0.48f, 0.64f}, strain = 0.3f;
    float frequency = 25.0f / job->w->size, amplitude = strain / frequency;
    for (size_t i = begin; i < end; i++) {
        const float *p = job->w->m.positions + 3 * i;
        float along = direction[0] * p[0] + direction[1] * p[1] + direction[2] * p[2];
        float shift = amplitude * sinf(frequency * along + job->amount);
        for (int axis = 0; axis < 3; axis++) {
            job->moved[3 * i + (size_t)axis] = p[axis] + shift * direction[axis];
        }
    }
}

void workload_wave(clast_context *context, const workload *w, float phase, float *moved)
{
    move_job job = {.w = w, .amount = phase, .moved = moved};
    clast_parallel_for(context, w->m.vertex_count, MOVE_GRAIN, wave_range, &job);
}

static void twist_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const move_job *job = data;
    const workload_part *part = job->part;
    const float *k = part->axis;
    for (size_t i = begin + part->first_vertex; i < end + part->first_vertex; i++) {
        float v[3], *out = job->moved + 3 * i, along = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            v[axis] = job->w->m.positions[3 * i + (size_t)axis] - part->centre[axis];
            along += v[axis] * k[axis];
        }
        float angle = 3.1415927f * job->amount * (0.5f + 0.5f * along / part->half), c = cosf(angle), s = sinf(angle);
        for (int axis = 0; axis < 3; axis++) { // Rodrigues
            int y = (axis + 1) % 3, z = (axis + 2) % 3;
            out[axis] = part->centre[axis] + v[axis] * c + (k[y] * v[z] - k[z] * v[y]) * s + k[axis] * along * (1 - c);
        }
    }
}

void workload_twist(clast_context *context, const workload *w, float turn, float *moved)
{
    memcpy(moved, w->m.positions, (size_t)w->m.vertex_count * 12);
    for (uint32_t i = 0; i < w->part_count; i += 2) {
        move_job job = {w, &w->parts[i], turn, moved};
        clast_parallel_for(context, w->parts[i].vertex_count, MOVE_GRAIN, twist_range, &job);
    }
}
