// SPDX-License-Identifier: Apache-2.0
// The two halves of the clusterizer. cut.c sorts the boxes of a mesh's triangles into small groups, top down, in place;
// group.c cuts a group into clusters.
#ifndef CLAST_GEOMETRY_CUT_H
#define CLAST_GEOMETRY_CUT_H

#include "clast/geometry.h"
#include "geometry/lanes.h"

enum {
    CUT_GROUP_MOST = 2048,  // triangles of a group; below 65536 / 3, as corners are numbered by 16 bits
    CUT_ALONE_MOST = 32768, // triangles that one thread cuts alone
};

// A triangle's box, as two registers whose last lanes are put to use.
typedef struct cut_corner {
    float v[3];
    uint32_t
        number; // lower: the triangle. upper: of a cluster's first triangle, the cluster's triangles * 65536 + vertices
} cut_corner;

typedef struct cut_box {
    cut_corner lower, upper;
} cut_box;

// A range of boxes, and the box of their centres.
typedef struct cut_range {
    uint32_t begin, count;
    lanes centre_lower, centre_upper;
} cut_range;

typedef struct cut_limits {
    uint32_t triangles, vertices;
} cut_limits;

// Twice the centre of a box.
static inline lanes cut_centre(const cut_box *box)
{
    return lanes_add(lanes_three(&box->lower), lanes_three(&box->upper));
}

// Along an axis that is shorter than this, nothing is told apart: the reciprocal must stay finite.
#define CUT_FLAT 1e-30f
// Coordinates are clamped to this before they steer the cut, so that sums and differences stay finite.
#define CUT_FAR 1e37f

// A scale for a box's coordinates that keeps products of its sides finite.
float clast_cut_scale(lanes lower, lanes upper);

// The range's box of centres.
void clast_cut_measure(const cut_box *boxes, cut_range *range);

// Parts a range in two, each with one triangle at least, and sorts the boxes accordingly. With `context`, on all threads;
// null on this one.
typedef struct cut_pair {
    cut_range left, right;
} cut_pair;
clast_status clast_cut_in_two(clast_context *context, cut_box *boxes, const cut_range *range, const cut_limits *limits,
                              cut_pair *pair);
void clast_cut_in_two_alone(cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair);

// What one thread needs to cut groups.
typedef struct group group;
size_t clast_group_size(void);

// Cuts boxes [begin, begin + count), at most CUT_GROUP_MOST, into clusters: writes `triangles` and `indices` of that range
// and the boxes' `cluster`. Adds to the counts.
typedef struct group_job {
    cut_box *boxes;
    const uint32_t *mesh_indices;
    cut_limits limits;
    uint32_t *triangles;
    uint8_t *indices;
} group_job;
void clast_group_cut(group *scratch, const group_job *job, uint32_t begin, uint32_t count, uint32_t *clusters,
                     uint64_t *vertices);

#endif
