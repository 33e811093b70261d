// SPDX-License-Identifier: Apache-2.0
// Rays as boxes see them: for the kernel files that trace rays.
//
// Boxes never cull what the triangle test would hit. That test (shared/watertight.h) works on vertices that are moved by
// roundings of v - o and of the shear: with M the largest distance from the ray's origin to a side of the tree's box, and
// e = 2^-24, by less than 6 e M; the distance it finds is off by less than 6 e M more. Here, the sides are
// q * (step * inverse) + (base - origin) * inverse -+ pad * |inverse|, of six roundings, on values of 3 M |inverse| at most:
// less than 10 e M. So all sides are moved outwards by pad = 32 e M = 2^-19 M, and ties at the limit are kept.
// Direction components below 2^-30 of the largest are taken as 2^-30: that moves the ray by less than 2^-28 M.
//
// In each space, lengths and distances are scaled by powers of two: the direction's largest component to [1, 2), and M to
// [1, 2), so that nothing overflows, and tiny scenes keep their precision.
#ifndef CLAST_ACCEL_RAY_BOXES_H
#define CLAST_ACCEL_RAY_BOXES_H

#include <float.h>
#include <math.h>

#include "accel/structures.h"
#include "base/simd.h"
#include "shared/box.h"
#include "shared/watertight.h"

#define PAD_OBJECT 1.9073486328125e-6f // 2^-19
#define PAD_WORLD 7.62939453125e-6f    // 2^-17, times the condition of the maps (tlas.c)
#define INVERSE_MOST 1073741824.0f     // 2^30

enum { SCALE_MOST = 86 }; // exponent: of what is smaller, distances stay small

// -------------------------------------------------------------------------------------------------------- powers of two

// 2^exponent, for -126 <= exponent <= 127.
CLAST_LANES float two_to(int exponent)
{
    return power_of_two((uint)(exponent + 127));
}

// x * 2^exponent; exponents beyond what changes a float are cut.
CLAST_LANES float scale_by(float x, int exponent)
{
    exponent = exponent < -252 ? -252 : exponent > 252 ? 252 : exponent;
    int half = exponent / 2;
    return x * two_to(half) * two_to(exponent - half);
}

// The exponent of a positive finite number: x is in [2^e, 2^(e + 1)).
CLAST_LANES int exponent_of(float x)
{
    uint biased = floatBitsToUint(x) >> 23;
    if (biased == 0) {
        return (int)(floatBitsToUint(x * 0x1p64f) >> 23) - 127 - 64;
    }
    return (int)biased - 127;
}

CLAST_LANES float largest_of(const float v[3])
{
    float x = fabsf(v[0]), y = fabsf(v[1]), z = fabsf(v[2]);
    float most = x > y ? x : y;
    return most > z ? most : z;
}

// The largest of three lanes; the fourth is zero.
CLAST_LANES float largest_lane(clast_floats4 v)
{
    float most = v[0] > v[1] ? v[0] : v[1];
    return most > v[2] ? most : v[2];
}

CLAST_LANES clast_floats4 scale_lanes(clast_floats4 v, int exponent)
{
    exponent = exponent < -252 ? -252 : exponent > 252 ? 252 : exponent;
    int half = exponent / 2;
    return v * splat4(two_to(half)) * splat4(two_to(exponent - half));
}

// -------------------------------------------------------------------------------------------------------------- spaces

// A ray as boxes see it. The fourth lanes are zero.
typedef struct space {
    clast_floats4 origin;
    clast_floats4 inverse; // 1 / direction, scaled
    clast_floats4 pad;
    uint32_t first[3]; // for each axis, which sides the ray meets first: 1, the upper ones, where it runs downwards
    int exponent;      // distances here are the ray's t times 2^exponent
    float t_min;
} space;

// The largest distance from a point to a side of a box, along an axis; not finite where that is too far.
CLAST_LANES float reach_of(clast_floats4 origin, const clast_box *box)
{
    return largest_lane(max4(abs4(load_three4(box->lower.v) - origin), abs4(load_three4(box->upper.v) - origin)));
}

// `direction` has its largest component in [1, 2); `exponent` says how the ray's t becomes a multiple of it.
CLAST_LANES space make_space(clast_floats4 origin, clast_floats4 direction, int exponent, float reach, float pad,
                             float t_min)
{
    int scale = reach > 0.0f ? -exponent_of(reach) : SCALE_MOST;
    scale = scale > SCALE_MOST ? SCALE_MOST : scale;
    clast_floats4 inverse = splat4(1.0f) / direction;
    clast_floats4 most = pick4(direction < splat4(0.0f), splat4(-INVERSE_MOST), splat4(INVERSE_MOST));
    inverse = pick4(abs4(inverse) <= splat4(INVERSE_MOST), inverse, most);
    space s = {.origin = origin, .exponent = exponent + scale};
    s.inverse = inverse * splat4(two_to(scale));
    s.inverse[3] = 0.0f;
    s.pad = abs4(s.inverse) * splat4(pad);
    for (uint32_t axis = 0; axis < 3; axis++) {
        s.first[axis] = inverse[axis] < 0.0f;
    }
    s.t_min = scale_by(t_min, s.exponent);
    return s;
}

typedef struct box_hits {
    clast_floats8 near;
    uint32_t bits;
} box_hits;

// How a ray sees quantised boxes over one base: the distance to a side is its number of steps times `step`, plus `near` or
// `far`, one lane for each axis.
typedef struct grid {
    clast_floats4 step, near, far;
} grid;

// `lower` is followed by the three biased exponents and another byte, in nodes and clusters alike.
CLAST_LANES grid make_grid(const space *s, const float *lower)
{
    clast_ints4 exponents = load_bytes4((const uint8_t *)(lower + 3)) << 23;
    clast_floats4 shift = (load_three4(lower) - s->origin) * s->inverse;
    return (grid){(clast_floats4)exponents * s->inverse, shift - s->pad, shift + s->pad};
}

// Which of eight boxes the ray meets between its t_min and `limit`. `sides` are those of a node, or of half a cluster's
// group; from one plane's to the next are `stride` bytes.
CLAST_LANES box_hits test_boxes(const space *s, const grid *g, const uint8_t *sides, size_t stride, float limit)
{
    clast_floats8 near = splat8(s->t_min), far = splat8(limit);
    for (int axis = 0; axis < 3; axis++) {
        clast_floats8 step = splat_lane8(g->step, axis);
        near = max8(load_bytes8(sides + (2 * (size_t)axis + s->first[axis]) * stride) * step +
                        splat_lane8(g->near, axis),
                    near);
        far = min8(load_bytes8(sides + (2 * (size_t)axis + 1 - s->first[axis]) * stride) * step +
                       splat_lane8(g->far, axis),
                   far);
    }
    return (box_hits){near, bits8(near <= far)};
}

#endif
