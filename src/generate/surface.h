// SPDX-License-Identifier: Apache-2.0
// Meshes from functions: a sheet is a grid over a function of (u, v), a block the six grids of a cube's surface over a
// function of the point on it. Evaluated in parallel in strips and written at once, so that size costs no memory.
#ifndef CLAST_GENERATE_SURFACE_H
#define CLAST_GENERATE_SURFACE_H

#include "generate/gltf_writer.h"

// A point of a surface. A zero normal is computed from the neighbours.
typedef struct clast_surface_point {
    vec3 position;
    vec3 normal;
    vec3 colour; // linear, 0 to 1: times the material's
    vec2 coordinates;
} clast_surface_point;

typedef struct clast_sheet {
    const void *shape;
    void (*evaluate)(const void *shape, float u, float v, clast_surface_point *point); // u, v in [0, 1]
    uint32_t columns, rows;                                                            // quads
    bool wraps_columns; // u = 1 is u = 0 again; texture coordinates may differ
    bool wraps_rows;
    bool flipped; // faces the other way; else the front is towards d/du x d/dv
} clast_sheet;

// A cube's surface, [-1, 1]^3. Vertices on shared edges come from the same numbers on both sides.
typedef struct clast_block {
    const void *shape;
    void (*evaluate)(const void *shape, vec3 point, uint32_t face,
                     clast_surface_point *result); // face: axis * 2 + (1: positive)
    uint32_t segments[3];                          // along each axis
    uint32_t bevel_segments;                       // of them at each end, within `bevels` of the end
    float bevels[3];
    uint32_t hidden_faces; // bit mask of faces to leave out
} clast_block;

// What building needs, reused from surface to surface.
typedef struct clast_builder {
    clast_context *context;
    clast_gltf_writer *writer;
    uint64_t expected; // triangles, for progress
    clast_surface_point *points;
    size_t point_capacity;
    packed3 *positions, *normals;
    packed4 *tangents;
    packed2 *coordinates;
    uint16_t (*colours)[4];
    uint32_t *indices;
    size_t vertex_capacity, index_capacity;
} clast_builder;

void clast_builder_end(clast_builder *builder);
// Each adds to the primitive under way; failures are kept in the writer's outputs.
void clast_build_sheet(clast_builder *builder, const clast_sheet *sheet);
void clast_build_block(clast_builder *builder, const clast_block *block);

// Columns and rows of a sheet of about `triangles` with squares of equal sides, for lengths along u and v.
void clast_sheet_divide(clast_sheet *sheet, double triangles, float length_u, float length_v);
// Sets the rows, and as many columns as make about `triangles`.
void clast_sheet_set_rows(clast_sheet *sheet, double triangles, uint32_t rows, uint32_t least_columns);

#endif
