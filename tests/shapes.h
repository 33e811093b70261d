// SPDX-License-Identifier: Apache-2.0
// Small meshes for tests, added to a scene.
#ifndef CLAST_TESTS_SHAPES_H
#define CLAST_TESTS_SHAPES_H

#include <math.h>

#include "test.h"

#include "clast/scene.h"

// A sphere of radius one around `centre`, with its normals and texture coordinates, a seam of doubled vertices, and
// degenerate triangles at the poles: columns * rows * 2 triangles.
typedef struct shape {
    clast_mesh mesh;
    float *positions, *normals, *coordinates;
    uint32_t *indices;
} shape;

static inline void shape_free(shape *s)
{
    free(s->positions);
    free(s->normals);
    free(s->coordinates);
    free(s->indices);
}

static inline void shape_vertex(shape *s, uint32_t columns, uint32_t rows, uint32_t column, uint32_t row)
{
    size_t v = (size_t)row * (columns + 1) + column;
    float turn = column == columns ? 0.0f : (float)column / (float)columns; // the seam closes to the bit
    float angle = 6.2831853f * turn, height = 3.14159265f * (float)row / (float)rows;
    float radius = row == 0 || row == rows ? 0.0f : sinf(height);
    float normal[3] = {radius * cosf(angle), cosf(height), -radius * sinf(angle)};
    for (int k = 0; k < 3; k++) {
        s->positions[3 * v + k] = s->normals[3 * v + k] = normal[k];
    }
    s->coordinates[2 * v] = (float)column / (float)columns;
    s->coordinates[2 * v + 1] = (float)row / (float)rows;
}

static inline shape shape_sphere(uint32_t columns, uint32_t rows)
{
    size_t vertices = (size_t)(columns + 1) * (rows + 1), triangles = (size_t)columns * rows * 2;
    shape s = {
        .positions = malloc(vertices * 12),
        .normals = malloc(vertices * 12),
        .coordinates = malloc(vertices * 8),
        .indices = malloc(triangles * 12),
    };
    for (uint32_t row = 0; row <= rows; row++) {
        for (uint32_t column = 0; column <= columns; column++) {
            shape_vertex(&s, columns, rows, column, row);
        }
    }
    uint32_t *corner = s.indices;
    for (uint32_t row = 0; row < rows; row++) {
        for (uint32_t column = 0; column < columns; column++) {
            uint32_t a = row * (columns + 1) + column, b = a + columns + 1;
            uint32_t quad[6] = {a, b, b + 1, a, b + 1, a + 1};
            for (int k = 0; k < 6; k++) {
                *corner++ = quad[k];
            }
        }
    }
    s.mesh = (clast_mesh){
        .vertex_count = (uint32_t)vertices,
        .triangle_count = (uint32_t)triangles,
        .positions = s.positions,
        .normals = s.normals,
        .coordinates = {s.coordinates, NULL},
        .indices = s.indices,
        .material = CLAST_NONE,
    };
    return s;
}

static inline uint32_t shape_add_sphere(clast_context *context, clast_scene *scene, uint32_t columns, uint32_t rows)
{
    shape s = shape_sphere(columns, rows);
    uint32_t geometry = CLAST_NONE;
    clast_status status = clast_scene_add_mesh(scene, &s.mesh, "sphere", &geometry);
    shape_free(&s);
    assert_ok(context, status);
    return geometry;
}

// Bumps of 8-bit heights, 16 x 16 texels, the same at both sides and all along the upper and lower one: around a sphere, they
// meet.
static inline uint32_t shape_add_bumps(clast_context *context, clast_scene *scene)
{
    enum { SIDE = 16 };
    uint8_t texels[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        float x = (float)(i % SIDE) / SIDE * 6.2831853f, y = (float)(i / SIDE) / SIDE * 6.2831853f;
        float waves = i / SIDE >= SIDE / 4 && i / SIDE < 3 * SIDE / 4 ? sinf(2.0f * x) * cosf(y) : 0.0f;
        texels[i] = (uint8_t)(127.5f + 80.0f * waves + 40.0f * cosf(3.0f * y));
    }
    clast_image image = {SIDE, SIDE, 1, CLAST_PIXEL_UNORM8, texels};
    clast_texture texture = {0, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    uint32_t number = CLAST_NONE;
    assert_ok(context, clast_scene_add_image(scene, &image, "bumps", &texture.image));
    assert_ok(context, clast_scene_add_texture(scene, &texture, &number));
    return number;
}

// Tessellates a mesh, and displaces whatever has `material` by bumps of this height.
static inline void shape_displace(clast_context *context, clast_scene *scene, uint32_t geometry, uint32_t material,
                                  float height)
{
    clast_material_desc desc = clast_material_defaults();
    desc.displacement_texture.texture = shape_add_bumps(context, scene);
    desc.displacement_scale = height;
    desc.displacement_offset = -0.25f * height;
    assert_ok(context, clast_scene_set_material(scene, material, &desc));
    assert_ok(context, clast_scene_set_tessellation(scene, geometry, &(clast_tessellation){false}));
}

static inline uint32_t shape_add_wave(clast_context *context, clast_scene *scene, uint32_t tiles)
{
    clast_wave wave = {
        .size = 10.0f, .tiles = tiles, .amplitude = 0.25f, .wavelength = 4.0f, .speed = 0.5f, .material = CLAST_NONE};
    uint32_t geometry = CLAST_NONE;
    assert_ok(context, clast_scene_add_wave(scene, &wave, "wave", &geometry));
    return geometry;
}

static inline uint32_t shape_add_instance(clast_context *context, clast_scene *scene, uint32_t geometry, float x,
                                          float y, float z, float scale)
{
    float transform[12] = {scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z};
    uint32_t instance = CLAST_NONE;
    assert_ok(context, clast_scene_add_instance(scene, geometry, transform, NULL, &instance));
    return instance;
}

#endif
