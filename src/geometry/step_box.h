// SPDX-License-Identifier: Apache-2.0
// Boxes on a grid of 32,760 steps a side: what the lower levels of the clusterizer and the treelets of templates
// compare. A box is one register of eight 16-bit integers: the lower sides, and the upper ones negated, so that the box
// around two is one minimum. Areas are exact integers: the same cuts on every machine. (SSE2 is part of every x86-64,
// so no kernels for several instruction sets.)
#ifndef CLAST_GEOMETRY_STEP_BOX_H
#define CLAST_GEOMETRY_STEP_BOX_H

#include "geometry/lanes.h"

// The longest side of what is compared. With the padding it stays below 2^15, and an area below 2^32.
#define STEP_BOX_STEPS 32760.0f
// Boxes count as wider by this, so that those of flat, thin and equal triangles have areas to compare.
#define STEP_BOX_PADDING 3

#if defined(__SSE2__)

typedef __m128i step_box; // lower x, y, z, 0, -upper x, y, z, 0

// From sides in steps, 0 to STEP_BOX_STEPS, within what sums round.
static inline step_box step_box_from(lanes lower, lanes upper)
{
    return _mm_packs_epi32(_mm_cvttps_epi32(lower), _mm_sub_epi32(_mm_setzero_si128(), _mm_cvttps_epi32(upper)));
}

// Joined with any other gives the other.
static inline step_box step_box_none(void)
{
    return _mm_set1_epi16(INT16_MAX);
}

static inline step_box step_box_join(step_box a, step_box b)
{
    return _mm_min_epi16(a, b);
}

// xy + yz + zx of the padded sides.
static inline uint32_t step_box_area(step_box a)
{
    const short pad = -STEP_BOX_PADDING;
    __m128i sides = _mm_add_epi16(_mm_add_epi16(a, _mm_srli_si128(a, 8)), _mm_setr_epi16(pad, pad, pad, 0, 0, 0, 0, 0));
    __m128i next = _mm_shufflelo_epi16(sides, _MM_SHUFFLE(3, 0, 2, 1));
    __m128i sums = _mm_madd_epi16(sides, next); // xy + yz, zx: wraps to the right bits of 32, as all are negated sides
    return (uint32_t)_mm_cvtsi128_si32(_mm_add_epi32(sums, _mm_srli_epi64(sums, 32)));
}

// Twice the centre along each axis, 0 to 2 * STEP_BOX_STEPS, without its lowest bits.
static inline void step_box_keys(step_box a, int dropped, uint16_t keys[3])
{
    __m128i sums = _mm_srl_epi16(_mm_sub_epi16(a, _mm_srli_si128(a, 8)), _mm_cvtsi32_si128(dropped));
    keys[0] = (uint16_t)_mm_extract_epi16(sums, 0);
    keys[1] = (uint16_t)_mm_extract_epi16(sums, 1);
    keys[2] = (uint16_t)_mm_extract_epi16(sums, 2);
}

#else

typedef struct step_box {
    int16_t v[6];
} step_box;

static inline step_box step_box_from(lanes lower, lanes upper)
{
    int32_t low[4], high[4];
    lanes_truncate(low, lower);
    lanes_truncate(high, upper);
    return (step_box){
        {(int16_t)low[0], (int16_t)low[1], (int16_t)low[2], (int16_t)-high[0], (int16_t)-high[1], (int16_t)-high[2]}};
}

static inline step_box step_box_none(void)
{
    return (step_box){{INT16_MAX, INT16_MAX, INT16_MAX, INT16_MAX, INT16_MAX, INT16_MAX}};
}

static inline step_box step_box_join(step_box a, step_box b)
{
    step_box result;
    for (int i = 0; i < 6; i++) {
        result.v[i] = a.v[i] < b.v[i] ? a.v[i] : b.v[i];
    }
    return result;
}

static inline uint32_t step_box_area(step_box a)
{
    uint32_t side[3];
    for (int axis = 0; axis < 3; axis++) {
        side[axis] = (uint32_t)(STEP_BOX_PADDING - a.v[axis] - a.v[axis + 3]);
    }
    return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

static inline void step_box_keys(step_box a, int dropped, uint16_t keys[3])
{
    for (int axis = 0; axis < 3; axis++) {
        keys[axis] = (uint16_t)((a.v[axis] - a.v[axis + 3]) >> dropped);
    }
}

#endif

#endif
