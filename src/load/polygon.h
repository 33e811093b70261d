// SPDX-License-Identifier: Apache-2.0
// Polygons of files become triangles here.
#ifndef CLAST_LOAD_POLYGON_H
#define CLAST_LOAD_POLYGON_H

#include "base/context.h"

// More corners than this are cut as a fan, which is right for convex polygons: clipping ears takes the square of the
// number.
enum { CLAST_POLYGON_CORNERS = 16384 };

// Scratch memory that lives from polygon to polygon. Zero is empty.
typedef struct clast_polygon {
    float (*points)[3]; // the corners, in order; the caller fills them after clast_polygon_reserve
    uint32_t *corners;  // the triangles: 3 numbers of corners for each of (count - 2)
    uint32_t *next, *previous;
    double (*flat)[2];
    size_t points_capacity, corners_capacity, next_capacity, previous_capacity, flat_capacity;
    double normal[3]; // area-weighted (Newell), of the polygon last cut
} clast_polygon;

clast_status clast_polygon_reserve(clast_context *context, clast_polygon *polygon, uint32_t count);
void clast_polygon_free(clast_context *context, clast_polygon *polygon);

// Cuts the polygon of the first `count` (at least 3) points into count - 2 triangles with the polygon's orientation:
// quads along the shorter diagonal that lies inside, others by clipping ears in the polygon's plane. Always gives that
// many, also where the polygon is degenerate or crosses itself. Nothing is allocated.
void clast_polygon_cut(clast_polygon *polygon, uint32_t count);

#endif
