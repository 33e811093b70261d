// SPDX-License-Identifier: Apache-2.0
// The upper part of the clusterizer: triangles in Morton order, cut into cells of a few neighbours each. The cuts above
// work on cells, of which there are many times fewer than triangles (Pantaleoni and Luebke 2010, "HLBVH", has trees
// over Morton clusters).
#ifndef CLAST_GEOMETRY_CELLS_H
#define CLAST_GEOMETRY_CELLS_H

#include "base/prefetch.h"
#include "geometry/cut.h"

typedef struct cells {
    cut_box *boxes; // lower.number: where the cell's triangles begin in `order`; upper.number: how many they are
    size_t count;
    uint64_t *order; // the lower half of each: a triangle
    uint64_t *spare; // as many words, free for other use
    bool tame;       // all corners are ordinary numbers
    cut_range whole;
} cells;

// Makes the cells of all triangles, at least one. Frees nothing of what it made where it fails: clast_cells_free does.
// Errors: INVALID_ARGUMENT (an index out of range), OUT_OF_MEMORY.
clast_status clast_cells_make(clast_context *context, const clast_clusterize_desc *desc, cells *made);
void clast_cells_free(clast_context *context, cells *made);

// A corner as far as it steers the cut: finite, and not so large that sums are not.
static inline lanes steering(const float *positions, uint32_t corner, bool tame)
{
    if (tame) {
        return lanes_ordinary(positions + 3 * (size_t)corner);
    }
    lanes position = lanes_finite(positions + 3 * (size_t)corner);
    return lanes_max(lanes_min(position, lanes_all(CUT_FAR)), lanes_all(-CUT_FAR));
}

typedef struct lanes_box {
    lanes lower, upper;
} lanes_box;

// A triangle's box.
static inline lanes_box steering_box(const float *positions, const uint32_t *corner, bool tame)
{
    lanes p = steering(positions, corner[0], tame), q = steering(positions, corner[1], tame);
    lanes r = steering(positions, corner[2], tame);
    return (lanes_box){lanes_min(lanes_min(p, q), r), lanes_max(lanes_max(p, q), r)};
}

// Triangles that are neighbours in space lie apart in memory: asks for one that is needed later, and for the corners of
// one that was asked for and is needed soon.
enum { CELLS_LATER = 64, CELLS_SOON = 32 };
CLAST_FETCHES void cells_prefetch(const clast_clusterize_desc *desc, uint32_t later, uint32_t soon)
{
    __builtin_prefetch(desc->indices + 3 * (size_t)later);
    const uint32_t *corner = desc->indices + 3 * (size_t)soon;
    for (int k = 0; k < 3; k++) {
        __builtin_prefetch(desc->positions + 3 * (size_t)corner[k]);
    }
}

#endif
