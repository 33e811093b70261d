// SPDX-License-Identifier: Apache-2.0
// Points of triangles, blended and displaced, many at once: what `fill` does most. The kernels restate displaced_point()
// and clast_height_value(), to the bit.
#ifndef CLAST_SOURCE_DISPLACE_H
#define CLAST_SOURCE_DISPLACE_H

#include "base/isa.h"
#include "shared/pattern.h"
#include "source/height.h"

// A corner of a triangle: all that is blended, in one line of the cache.
enum {
    DISPLACE_POSITION = 0,
    DISPLACE_NORMAL = 3,
    DISPLACE_COORDINATES = 6, // of the map
    DISPLACE_LEVEL = 8,       // of the map
    DISPLACE_ATTRIBUTES = 9,
    DISPLACE_FLOATS = 16, // those beyond the attributes are any that are no denormals
};
typedef struct clast_displace_corner {
    _Alignas(64) float of[DISPLACE_FLOATS];
} clast_displace_corner;

// What gives points of a curved triangle their positions, in place of its corners': curved_blend() of shared/tessellation.h.
typedef struct clast_displace_curve {
    float positions[3][3], controls[6][3];
} clast_displace_curve;

// Points that one map displaces.
typedef struct clast_displace_job {
    const clast_height *height; // null: `offset` is the height everywhere
    float scale, offset;        // height = value * scale + offset
    const clast_displace_corner *corners;
    const uint32_t *numbers;           // by point: its three corners, 8 bits each; null: corners 0, 1 and 2 for all
    const uint32_t *weights;           // by point: weights_word()
    const clast_displace_curve *curve; // null where the triangle is flat; else numbers are null
    // Null, or of a part of the curved triangle: what its corners weigh there. Levels are its own, and so are weights.
    const clast_weights *within;
    uint32_t count;
    packed3 *positions; // by point: written
} clast_displace_job;

typedef void (*clast_displace_kernel)(const clast_displace_job *job);
clast_displace_kernel clast_displace_kernel_of(clast_isa isa);

#define CLAST_DECLARE_DISPLACE(set) void clast_displace_##set(const clast_displace_job *job);
CLAST_EACH_ISA(CLAST_DECLARE_DISPLACE)

#endif
