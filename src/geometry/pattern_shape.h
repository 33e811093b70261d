// SPDX-License-Identifier: Apache-2.0
// One pattern on its own, and what it must be: for those who make tables of them, the generator of the library's own and the
// reader of others.
#ifndef CLAST_GEOMETRY_PATTERN_SHAPE_H
#define CLAST_GEOMETRY_PATTERN_SHAPE_H

#include "shared/pattern.h"

// In the order of shared/pattern.h. More vertices and triangles than these are a fault, so there is room for no more.
typedef struct clast_pattern_shape {
    uint32_t factors;
    uint32_t vertex_count, triangle_count;
    uint32_t vertices[PATTERN_VERTICES];   // weights_word()
    uint32_t triangles[PATTERN_TRIANGLES]; // three vertices, 8 bits each
} clast_pattern_shape;

// A pattern's corners and the points of its edges: it has no triangles yet.
void clast_pattern_shape_begin(clast_pattern_shape *shape, uint32_t factors);

// What is wrong with a pattern that is built otherwise, or null: points inside lie inside; there are as many triangles as
// Euler's formula wants; all go counter-clockwise and have an area; each side is some segment of an edge or another
// triangle's side; all vertices are used. So the triangles cover the whole exactly once: what they have around them is the
// triangle's border, once.
const char *clast_pattern_shape_fault(const clast_pattern_shape *shape);

// What is wrong between two shapes of a table, which are there by their numbers, or null: points inside never become fewer
// where a count grows, so that neither do triangles and vertices; up to 2 segments an edge there are none. `*first` and
// `*second` are the numbers then. Looks at the ordered ones alone.
const char *clast_pattern_shapes_fault(const clast_pattern_shape *shapes, uint32_t *first, uint32_t *second);

// Orders the triangles so that each eight are compact, as blocks of treelets want them.
void clast_pattern_shape_order(clast_pattern_shape *shape);

// Makes the mirror images of a table's ordered shapes: corners 0 and 1 exchanged, with all vertices and triangles in the
// image's own order.
void clast_pattern_shapes_mirror(clast_pattern_shape *shapes);

// Twice the area of a triangle of three vertices (words), the whole being WEIGHT_ONE squared; negative where it goes
// clockwise.
static inline int64_t clast_pattern_area(uint32_t a, uint32_t b, uint32_t c)
{
    int64_t bx = (int64_t)(b & 65535u) - (a & 65535u), by = (int64_t)(b >> 16) - (a >> 16);
    int64_t cx = (int64_t)(c & 65535u) - (a & 65535u), cy = (int64_t)(c >> 16) - (a >> 16);
    return bx * cy - by * cx;
}

// Mixes a pattern into a hash of a table (the finaliser of MurmurHash3 over each word).
uint64_t clast_pattern_shape_hash(uint64_t hash, const clast_pattern_shape *shape);

#endif
