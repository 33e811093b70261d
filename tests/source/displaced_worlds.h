// SPDX-License-Identifier: Apache-2.0
// Displaced meshes of all sorts, and views of them, for tests of what is tessellated.
#ifndef CLAST_TESTS_SOURCE_DISPLACED_WORLDS_H
#define CLAST_TESTS_SOURCE_DISPLACED_WORLDS_H

#include <string.h>

#include "source/displaced.h"
#include "source/kinds.h"

// ------------------------------------------------------------------------------------------------------------- worlds

typedef struct numbers {
    uint32_t state;
} numbers;

static inline float next_number(numbers *n) // -1 to 1
{
    n->state = n->state * 1664525u + 1013904223u;
    return (float)(n->state >> 8) / 8388608.0f - 1.0f;
}

// A pyramid of a small foot, 300 high.
static inline clast_mesh spike_mesh(const float positions[4][3])
{
    static const float coordinates[4][2] = {{0, 0}, {1, 0}, {0, 1}, {9, 7}};
    static const uint32_t indices[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    return (clast_mesh){.vertex_count = 4,
                        .triangle_count = 4,
                        .positions = positions[0],
                        .coordinates = {coordinates[0], NULL},
                        .indices = indices,
                        .material = CLAST_NONE};
}

static const float broad_spike[4][3] = {{0, 0, 0}, {5, 0, 0}, {2.5f, 4.33f, 0}, {2.5f, 1.5f, 300}};
static const float needle[4][3] = {{0, 0, 0}, {0.01f, 0, 0}, {0.005f, 0.009f, 0}, {0.005f, 0.003f, 300}};

// A mesh of which nothing is shared but where its points are: each triangle has its own vertices, with normals and texture
// coordinates at random, and one of three materials.
typedef struct loose {
    clast_mesh mesh;
    float *positions, *normals, *coordinates;
    uint32_t *indices, *materials;
} loose;

static inline loose loosen(const clast_mesh *from, bool normals)
{
    size_t corners = 3 * (size_t)from->triangle_count;
    loose result = {
        .positions = malloc(corners * 12),
        .normals = malloc(corners * 12),
        .coordinates = malloc(corners * 8),
        .indices = malloc(corners * 4),
        .materials = malloc((size_t)from->triangle_count * 4),
    };
    numbers random = {7};
    for (size_t i = 0; i < corners; i++) {
        const float *position = from->positions + 3 * (size_t)from->indices[i];
        float normal[3], length = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            result.positions[3 * i + axis] = position[axis];
            normal[axis] = position[axis] + 0.7f * next_number(&random);
            length += normal[axis] * normal[axis];
        }
        for (int axis = 0; axis < 3; axis++) {
            result.normals[3 * i + axis] = normal[axis] / sqrtf(length + 1e-20f);
        }
        result.coordinates[2 * i] = next_number(&random);
        result.coordinates[2 * i + 1] = next_number(&random);
        result.indices[i] = (uint32_t)i;
        result.materials[i / 3] = (uint32_t)(i / 3 * 7 % 3);
    }
    result.mesh = (clast_mesh){
        .vertex_count = (uint32_t)corners,
        .triangle_count = from->triangle_count,
        .positions = result.positions,
        .normals = normals ? result.normals : NULL,
        .coordinates = {result.coordinates, NULL},
        .indices = result.indices,
        .triangle_materials = result.materials,
        .material = CLAST_NONE,
    };
    return result;
}

static inline void loose_free(loose *l)
{
    free(l->positions);
    free(l->normals);
    free(l->coordinates);
    free(l->indices);
    free(l->materials);
}

static inline kind_world world_of(clast_context *context, const clast_mesh *mesh, float height, bool curved)
{
    kind_world world = {.context = context, .source = clast_sources[CLAST_SOURCE_DISPLACED]};
    assert_ok(context, clast_scene_create(context, &world.scene));
    assert_ok(context, clast_template_set_create(context, &world.templates));
    assert_ok(context, clast_height_store_create(context, &world.heights));
    clast_material_desc plain = clast_material_defaults(), other = plain;
    other.displacement_texture.texture = shape_add_bumps(context, world.scene);
    other.displacement_texture.scale[0] = 3.0f;
    other.displacement_texture.rotation = 0.5f;
    other.displacement_scale = -0.6f * height;
    other.displacement_offset = 0.1f * height;
    uint32_t number, geometry;
    assert_ok(context, clast_scene_add_material(world.scene, &other, "other", &number));
    assert_ok(context, clast_scene_add_material(world.scene, &plain, "plain", &number));
    assert_int_equal(number, 2);
    assert_ok(context, clast_scene_add_mesh(world.scene, mesh, "mesh", &geometry));
    shape_displace(context, world.scene, geometry, 0, height);
    assert_ok(context, clast_scene_set_tessellation(world.scene, geometry, &(clast_tessellation){curved}));
    kind_cook(&world, geometry);
    return world;
}

// A box, of which each face has vertices of its own: hard edges, and an island of texture coordinates each.
static inline void make_box(float positions[24][3], float normals[24][3], float coordinates[24][2],
                            uint32_t indices[36])
{
    static const float sizes[3] = {1.0f, 1.5f, 0.7f};
    for (uint32_t face = 0; face < 6; face++) {
        uint32_t axis = face / 2;
        float side = face % 2 == 0 ? -1.0f : 1.0f;
        for (uint32_t corner = 0; corner < 4; corner++) {
            uint32_t i = 4 * face + corner;
            float u = corner == 1 || corner == 2 ? 1.0f : -1.0f, v = corner >= 2 ? 1.0f : -1.0f;
            positions[i][axis] = side * sizes[axis];
            positions[i][(axis + 1) % 3] = u * side * sizes[(axis + 1) % 3];
            positions[i][(axis + 2) % 3] = v * sizes[(axis + 2) % 3];
            memset(normals[i], 0, sizeof normals[i]);
            normals[i][axis] = side;
            coordinates[i][0] = 0.3f * (float)face + 0.2f * u;
            coordinates[i][1] = 0.7f * (float)face + 0.5f * v;
        }
        const uint32_t quad[6] = {0, 1, 2, 0, 2, 3};
        for (uint32_t k = 0; k < 6; k++) {
            indices[6 * face + k] = 4 * face + quad[k];
        }
    }
}

// A box with hard edges, seams and three materials.
typedef struct box_mesh {
    clast_mesh mesh;
    float positions[24][3], normals[24][3], coordinates[24][2];
    uint32_t indices[36], materials[12];
} box_mesh;

static inline void box_mesh_make(box_mesh *box)
{
    static const uint32_t materials[12] = {0, 0, 1, 1, 2, 2, 0, 1, 1, 0, 2, 0};
    memcpy(box->materials, materials, sizeof materials);
    make_box(box->positions, box->normals, box->coordinates, box->indices);
    box->mesh = (clast_mesh){.vertex_count = 24,
                             .triangle_count = 12,
                             .positions = box->positions[0],
                             .normals = box->normals[0],
                             .coordinates = {box->coordinates[0], NULL},
                             .indices = box->indices,
                             .triangle_materials = box->materials,
                             .material = CLAST_NONE};
}

// -------------------------------------------------------------------------------------------------------------- views

static inline clast_source_view view_from(vec3 eye, vec3 at, float pixels)
{
    vec3 forward = normalize3(at - eye);
    vec3 right = normalize3(cross3(forward, vec3(0.3f, 1.0f, 0.1f))), up = cross3(right, forward);
    const vec3 rows[3] = {right, up, forward};
    clast_source_view view = {
        .eye = store3(eye),
        .pixels_per_unit = pixels,
        .rate = 1.0f,
        .extent = {{0.8f, 0.45f}},
        .pixels = pixels,
        .near_plane = 1e-4f,
        .segment = 4.0f,
        .hidden_fraction = 0.2f,
        .alone = 1,
    };
    for (int row = 0; row < 3; row++) {
        view.to_camera.rows[row] = (packed4){{rows[row][0], rows[row][1], rows[row][2], -dot3(rows[row], eye)}};
    }
    return view;
}

// Eyes at random, from far away down to the surface; each metric, both projections.
static inline clast_source_view random_view(numbers *random, uint32_t number)
{
    float distance = powf(10.0f, 1.5f * next_number(random)) * 0.3f;
    vec3 way = normalize3(vec3(next_number(random), next_number(random), next_number(random)));
    vec3 at = way + vec3(next_number(random), next_number(random), next_number(random)) * (0.4f * distance);
    clast_source_view view = view_from(way * (1.0f + distance), at, fminf(300.0f, 150.0f * distance));
    view.near_plane = 0.3f * distance;
    view.metric = number % 4;
    if (view.metric == CLAST_METRIC_LENGTH) {
        view.segment = 0.04f + 0.2f * fabsf(next_number(random));
    } else if (view.metric == CLAST_METRIC_FIXED) {
        view.segment = 1.0f + floorf(30.0f * fabsf(next_number(random)));
    }
    view.alone = number / 4 % 4 != 3;
    view.hidden = number % 11 == 10;
    if (number % 5 == 4) {
        view.projection = CLAST_PROJECTION_ORTHOGRAPHIC;
        view.extent = (packed2){{0.5f, 0.5f}};
    }
    return view;
}

static const clast_pose at_rest = {.displacement_scale = 1.0f};

#endif
