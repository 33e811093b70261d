// SPDX-License-Identifier: Apache-2.0
// What bench_tess measures on: a ground that is displaced by a map.
#ifndef CLAST_BENCH_TESS_H
#define CLAST_BENCH_TESS_H

#include "accel_job.h"

enum { TESS_MAP_BITS = 11, TESS_MAP_SIDE = 1 << TESS_MAP_BITS };

// A sheet of base triangles of about the same sides, hilly, with vertices a little out of line; z is up. Texture coordinates follow the place in the plane.
typedef struct tess_ground {
    mesh base;
    float *coordinates;
    float spacing;      // of the vertices
    uint16_t *map;      // TESS_MAP_SIDE texels a side, and one more row
    float map_scale;    // texels for each length
    float height_scale; // of a texel's value
} tess_ground;

typedef struct tess_subdivision {
    const tess_ground *ground;
    RTCScene scene;
    RTCGeometry geometry;
    float *levels; // of each corner's edge
} tess_subdivision;

tess_subdivision tess_subdivision_make(RTCDevice device, const tess_ground *g, float segment, bool dynamic);
// Segments of the edges, of a length.
void tess_subdivision_levels(tess_subdivision *s, float segment);
// Builds anew, after the levels changed.
void tess_subdivision_commit(tess_subdivision *s);
void tess_subdivision_free(tess_subdivision *s);

#endif
