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
// In each space, distances are scaled by a power of two, so that M becomes less than 2, and tiny scenes keep their precision.
// Directions are tame: their largest component is in [DIRECTION_LEAST, DIRECTION_MOST], as it is, or is brought to [1, 2) by a
// power of two. So nothing overflows.
#ifndef CLAST_ACCEL_RAY_BOXES_H
#define CLAST_ACCEL_RAY_BOXES_H

#include <float.h>
#include <math.h>

#include "accel/structures.h"
#include "base/simd_order.h"
#include "shared/box.h"
#include "shared/watertight.h"

#define PAD_OBJECT 1.9073486328125e-6f // 2^-19
#define PAD_WORLD 7.62939453125e-6f    // 2^-17, times the condition of the maps (tlas.c)
#define INVERSE_MOST 1073741824.0f     // 2^30

#define DIRECTION_LEAST 9.5367431640625e-7f // 2^-20
#define DIRECTION_MOST 1048576.0f           // 2^20

enum { SCALE_MOST = 60 }; // exponent: of what is smaller, distances stay small

// -------------------------------------------------------------------------------------------------------- powers of two

// 2^exponent, for -126 <= exponent <= 127.
CLAST_LANES float two_to(int exponent)
{
    return power_of_two((uint)(exponent + 127));
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
    float scale[2];    // distances here are the ray's t times both
    float t_min;
} space;

// The largest distance from a point to a side of a box, along an axis; not finite where that is too far.
CLAST_LANES float reach_of(clast_floats4 origin, const clast_box *box)
{
    return largest_lane(max4(abs4(load_three4(box->lower.v) - origin), abs4(load_three4(box->upper.v) - origin)));
}

// A distance along the ray, as the boxes see it.
CLAST_LANES float distance_in(const space *s, float t)
{
    return t * s->scale[0] * s->scale[1];
}

// `direction` is tame, `largest` its largest component; `exponent` says how the ray's t becomes a multiple of it.
CLAST_LANES space make_space(clast_floats4 origin, clast_floats4 direction, float largest, int exponent, float reach,
                             float pad, float t_min)
{
    const clast_floats4 three = {1.0f, 1.0f, 1.0f, 0.0f};
    int scale = 254 - (int)(floatBitsToUint(reach) >> 23); // 2^-exponent_of(reach), biased
    scale = scale < 127 + SCALE_MOST ? scale : 127 + SCALE_MOST;
    clast_floats4 most = splat4(INVERSE_MOST * power_of_two(254 - (floatBitsToUint(largest) >> 23)));
    space s = {.origin = origin, .scale = {power_of_two((uint)scale), 1.0f}};
    s.inverse = min4(max4(splat4(1.0f) / direction, -most), most) * (splat4(s.scale[0]) * three);
    s.pad = abs4(s.inverse) * splat4(pad);
    if (__builtin_expect(exponent != 0, 0)) {
        int all = exponent + scale - 127;
        all = all < -252 ? -252 : all > 252 ? 252 : all;
        s.scale[0] = two_to(all / 2);
        s.scale[1] = two_to(all - all / 2);
    }
    uint32_t signs = bits4((clast_ints4)direction);
    for (uint32_t axis = 0; axis < 3; axis++) {
        s.first[axis] = signs >> axis & 1;
    }
    s.t_min = distance_in(&s, t_min);
    return s;
}

// What of eight boxes was met. `near` is where the ray enters; of boxes that are not hit, it means nothing.
typedef struct box_hits {
    clast_floats8 near;
    clast_mask8 mask;
    uint32_t bits;
} box_hits;

// How a ray sees quantised boxes over one base: the distance to a side is its number of steps times `step`, plus `near` or
// `far`, one lane for each axis.
typedef struct grid {
    clast_floats4 step, near, far;
} grid;

// `lower` is followed by the three biased exponents and another byte, in nodes and clusters alike. Fourth lanes mean nothing.
CLAST_LANES grid make_grid(const space *s, const float *lower)
{
    clast_floats4 base = load_four4(lower);
#if defined(__AVX2__)
    const __m128i to_top = _mm_setr_epi8(-1, -1, -1, 12, -1, -1, -1, 13, -1, -1, -1, 14, -1, -1, -1, -1);
    clast_floats4 step = (clast_floats4)_mm_srli_epi32(_mm_shuffle_epi8((__m128i)base, to_top), 1);
#else
    clast_floats4 step = (clast_floats4)(load_bytes4((const uint8_t *)(lower + 3)) << 23);
#endif
    clast_floats4 shift = (base - s->origin) * s->inverse;
    return (grid){step * s->inverse, shift - s->pad, shift + s->pad};
}

// Which of the first `count` of eight boxes the ray meets between its t_min and `limit`. `sides` are those of a node, or of
// half a cluster's group; from one plane's to the next are `stride` bytes.
CLAST_LANES box_hits test_boxes(const space *s, const grid *g, const uint8_t *sides, size_t stride, uint32_t count,
                                float limit)
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
    clast_mask8 mask = at_most8(near, far) & first_lanes8(count);
    return (box_hits){near, mask, mask_bits8(mask)};
}

CLAST_LANES box_hits test_node(const space *s, const clast_node *node, float limit)
{
    grid g = make_grid(s, node->lower);
    return test_boxes(s, &g, node->boxes[0][0], TREE_WIDTH, node->child_count, limit);
}

// ---------------------------------------------------------------------------------------------------------------- keys

// Where a box is entered, and which of a node's eight or a group's sixteen it is, in one integer: integers order them by
// distance, and none are equal. The lane takes the place of the lowest bits, which moves the distance by 15 units in the last place
// at most, to either side; what is compared with it has to give way by as much (cull_limit). Negative distances come in
// reverse order, which costs time only.
enum { KEY_LANES = 15 };

CLAST_LANES clast_ints8 keys_of8(clast_floats8 near, int32_t first)
{
    const clast_ints8 lanes = {0, 1, 2, 3, 4, 5, 6, 7};
    return ((clast_ints8)near & splat_ints8(~KEY_LANES)) | (lanes + splat_ints8(first));
}

CLAST_LANES float distance_of_key(int32_t key)
{
    return uintBitsToFloat((uint)key);
}

// What a key's distance is compared with, so that it never culls what is at `limit` or before it.
CLAST_LANES float cull_limit(float limit)
{
    return limit + (fabsf(limit) * 1.9073486328125e-6f + 7.8886090522101181e-31f); // 2^-19, 2^-100
}

#endif
