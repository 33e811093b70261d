// SPDX-License-Identifier: Apache-2.0
// What bench_accel measures on: surfaces that exist as grids and as indexed meshes, and piles of real models; and how
// they move.
#ifndef CLAST_BENCH_ACCEL_WORKLOADS_H
#define CLAST_BENCH_ACCEL_WORKLOADS_H

#include "accel/meshes.h"
#include "bench.h"
#include "clast/clast.h"

enum { TILE_QUADS = 8, TILE_VERTICES = (TILE_QUADS + 1) * (TILE_QUADS + 1) };

// A piece that moves by itself: a range of vertices around an axis.
typedef struct workload_part {
    uint32_t first_vertex, vertex_count;
    float centre[3];
    float axis[3]; // unit
    float half;    // reaches this far from the centre along the axis
} workload_part;

// The mesh's vertices are at rest. A surface has square sheets of vertices, one after another, each of sheet_tiles tiles of
// quads a side, and nothing else; other meshes have none.
typedef struct workload {
    char name[BENCH_NAME_SIZE];
    mesh m; // with a vertex to spare
    uint32_t sheet_count, sheet_tiles;
    workload_part *parts;
    uint32_t part_count;
    float eye[3], target[3];
    float size; // the longest side of its box
} workload;

typedef enum surface { SURFACE_SPHERE, SURFACE_TERRAIN, SURFACE_CLOTH, SURFACE_COUNT } surface;

workload workload_surface(surface kind, uint32_t triangles);
const char *workload_surface_name(surface kind);
// A model of the folder that CLAST_ASSETS names, its edges halved until there are enough triangles. No triangles where there
// is no such file.
workload workload_model(clast_context *context, const char *file, uint32_t triangles);
// All scans of that folder, copied into a loose pile of as many triangles.
workload workload_pile(clast_context *context, uint32_t triangles);
void workload_free(workload *w);

// Writes the vertices at a moment of a mild wave, which stretches by up to 30 %.
void workload_wave(clast_context *context, const workload *w, float phase, float *moved);
// And with every second part twisted, one end against the other, by `turn` half turns.
void workload_twist(clast_context *context, const workload *w, float turn, float *moved);

// Zeroed, with an element to spare, in large pages where there are; free with free.
void *bench_allocate(size_t count, size_t size);

#endif
