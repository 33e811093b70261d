// SPDX-License-Identifier: Apache-2.0
// What bench_tess measures on: a ground that is displaced by a map.
#ifndef CLAST_BENCH_TESS_H
#define CLAST_BENCH_TESS_H

#include "accel_job.h"
#include "tess_ground.h"

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
