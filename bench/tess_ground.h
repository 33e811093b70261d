// SPDX-License-Identifier: Apache-2.0
// The ground that tessellation is measured on: displaced by a map.
#ifndef CLAST_BENCH_TESS_GROUND_H
#define CLAST_BENCH_TESS_GROUND_H

#include "accel/meshes.h"
#include "bench.h"
#include "frame/frame.h"

enum { TESS_MAP_BITS = 11, TESS_MAP_SIDE = 1 << TESS_MAP_BITS };

// A sheet of base triangles of about the same sides, hilly, with vertices a little out of line; z is up. Texture coordinates
// follow the place in the plane.
typedef struct tess_ground {
    mesh base;
    float *coordinates;
    float spacing;      // of the vertices
    uint16_t *map;      // TESS_MAP_SIDE texels a side, and one more row
    float map_scale;    // texels for each length
    float height_scale; // of a texel's value
} tess_ground;

tess_ground tess_ground_make(uint32_t base_triangles);
void tess_ground_free(tess_ground *g);
// A scene of it alone; and what frames of it are asked for: segments of that length, as seen from above a corner.
clast_scene *tess_ground_scene(const tess_ground *g, clast_context *context);
clast_frame_settings tess_ground_settings(double segment);

#endif
