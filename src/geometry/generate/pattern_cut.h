// SPDX-License-Identifier: Apache-2.0
// How the library's own patterns are found: when it is built, by the generator alone. All of it is integers, so that every
// machine finds the same.
#ifndef CLAST_GEOMETRY_PATTERN_CUT_H
#define CLAST_GEOMETRY_PATTERN_CUT_H

#include "geometry/pattern_shape.h"

// Cuts an ordered triple (x >= y >= z): points inside, and triangles of good shape.
void clast_pattern_cut(clast_pattern_shape *shape, uint32_t factors);

// How many points inside a pattern has.
uint32_t clast_pattern_inside(uint32_t factors);

#endif
