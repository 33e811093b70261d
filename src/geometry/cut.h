// SPDX-License-Identifier: Apache-2.0
// The steps of the clusterizer: cells.c makes cells of a few triangles each; cut.c parts the cells, then the triangles
// of a part, into groups, top down, in place; group.c cuts a group into clusters.
#ifndef CLAST_GEOMETRY_CUT_H
#define CLAST_GEOMETRY_CUT_H

#include "clast/geometry.h"
#include "geometry/lanes.h"

enum {
    CUT_GROUP_MOST = 2048, // triangles of a group; below 65536 / 3, as corners are numbered by 16 bits
};

// The box of a cell or of a triangle, as two registers whose last lanes are put to use.
typedef struct cut_corner {
    float v[3];
    uint32_t number; // lower: the triangle, or where those of a cell begin; upper: how many they are
} cut_corner;

typedef struct cut_box {
    cut_corner lower, upper;
} cut_box;

// A range of boxes, and the box of their centres. Its triangles will stand at `first` of the result.
typedef struct cut_range {
    uint32_t begin, count;
    uint32_t first, triangles;
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

// Parts a range of two boxes or more in two, each with one at least, and sorts the boxes accordingly; on all threads,
// or on this one.
typedef struct cut_pair {
    cut_range left, right;
} cut_pair;
clast_status clast_cut_in_two(clast_context *context, cut_box *boxes, const cut_range *range, const cut_limits *limits,
                              cut_pair *pair);
void clast_cut_in_two_alone(cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair);
// Any halves, by number. Boxes stay where they are.
void clast_cut_halve(const cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair);

// What one thread needs to cut groups.
typedef struct group group;
size_t clast_group_size(void);
// Makes memory of that size, aligned to 64 bytes, ready for groups.
void clast_group_begin(group *scratch, const cut_limits *limits);

// The clusters of a range of triangles, as they come: the vertices of each from the front of `words` on, and from the
// back for each cluster its triangles * 65536 + vertices. Where triangles share little, there is no room for the
// vertices: they are left out then.
typedef struct group_output {
    uint32_t *words; // two for each triangle of the range
    size_t word_count;
    size_t triangles_left; // of the range, to be cut yet
    size_t clusters, vertices;
    bool vertices_fit;
} group_output;

typedef struct group_job {
    const cut_box *boxes; // of triangles
    const uint32_t *mesh_indices;
    uint32_t *triangles;
    uint8_t *indices;
} group_job;

// Cuts a range of at most CUT_GROUP_MOST triangles into clusters: writes `triangles` and `indices` of that range.
void clast_group_cut(group *scratch, const group_job *job, const cut_range *range, group_output *output);

#endif
