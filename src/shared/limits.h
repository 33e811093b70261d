// SPDX-License-Identifier: Apache-2.0
// Every limit that both backends know, once.
#ifndef CLAST_SHARED_LIMITS_H
#define CLAST_SHARED_LIMITS_H

#include "clast/lists.h"
#include "shared/dialect.h"

LIMIT(CLUSTER_TRIANGLES, 128u, "most triangles of a cooked cluster")
LIMIT(CLUSTER_VERTICES, 128u, "most vertices of a cooked cluster")
LIMIT(TEMPLATE_TRIANGLES, 256u, "most triangles of any template; grids reach 242")
LIMIT(TEMPLATE_VERTICES, 256u, "most vertices of any template, so that an index fits 8 bits")
LIMIT(BLOCK_TRIANGLES, 8u, "triangles of a block of a treelet, tested at once")
LIMIT(GRID_SEGMENTS, 11u, "most segments along a side of a grid template")
LIMIT(RATE_STEPS, 16u, "steps of the rate ladder to the next power of two: 2^(-k/16)")

#endif
