// SPDX-License-Identifier: Apache-2.0
// As many floats as one register of the instruction set holds, for kernels that take a ray to a lane: sixteen with
// AVX-512, eight elsewhere. Masks are what comparisons give there; mask_bits has bit i where lane i is set.
#ifndef CLAST_ACCEL_RAY_LANES_H
#define CLAST_ACCEL_RAY_LANES_H

#include "base/simd.h"

#if defined(__AVX512F__)

enum { LANES = 16 };
typedef float lanes __attribute__((vector_size(64)));
typedef int32_t lane_ints __attribute__((vector_size(64)));
typedef __mmask16 lane_mask;

CLAST_LANES lanes splat(float x)
{
    return (lanes)_mm512_set1_ps(x);
}

CLAST_LANES lane_ints splat_int(int32_t x)
{
    return (lane_ints)_mm512_set1_epi32(x);
}

CLAST_LANES lane_mask is_less(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
}

CLAST_LANES lane_mask is_at_most(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
}

CLAST_LANES lane_mask is_equal(lanes a, lanes b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_EQ_OQ);
}

CLAST_LANES lane_mask is_equal_int(lane_ints a, lane_ints b)
{
    return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b);
}

CLAST_LANES uint32_t mask_bits(lane_mask mask)
{
    return mask;
}

CLAST_LANES lane_mask mask_of(uint32_t bits)
{
    return (lane_mask)bits;
}

CLAST_LANES lanes pick(lane_mask mask, lanes yes, lanes no)
{
    return (lanes)_mm512_mask_blend_ps(mask, (__m512)no, (__m512)yes);
}

CLAST_LANES lane_ints pick_int(lane_mask mask, lane_ints yes, lane_ints no)
{
    return (lane_ints)_mm512_mask_blend_epi32(mask, (__m512i)no, (__m512i)yes);
}

CLAST_LANES lanes minimum(lanes a, lanes b)
{
    return (lanes)_mm512_min_ps((__m512)a, (__m512)b);
}

CLAST_LANES lanes maximum(lanes a, lanes b)
{
    return (lanes)_mm512_max_ps((__m512)a, (__m512)b);
}

#else

enum { LANES = 8 };
typedef clast_floats8 lanes;
typedef clast_ints8 lane_ints;
typedef clast_ints8 lane_mask;

CLAST_LANES lanes splat(float x)
{
    return splat8(x);
}

CLAST_LANES lane_ints splat_int(int32_t x)
{
    return (lane_ints){x, x, x, x, x, x, x, x};
}

CLAST_LANES lane_mask is_less(lanes a, lanes b)
{
    return a < b;
}

CLAST_LANES lane_mask is_at_most(lanes a, lanes b)
{
    return a <= b;
}

CLAST_LANES lane_mask is_equal(lanes a, lanes b)
{
    return a == b;
}

CLAST_LANES lane_mask is_equal_int(lane_ints a, lane_ints b)
{
    return a == b;
}

CLAST_LANES uint32_t mask_bits(lane_mask mask)
{
    return bits8(mask);
}

CLAST_LANES lane_mask mask_of(uint32_t bits)
{
    const lane_ints each = {1, 2, 4, 8, 16, 32, 64, 128};
    return (splat_int((int32_t)bits) & each) == each;
}

CLAST_LANES lanes pick(lane_mask mask, lanes yes, lanes no)
{
    return pick8(mask, yes, no);
}

CLAST_LANES lane_ints pick_int(lane_mask mask, lane_ints yes, lane_ints no)
{
    return (lane_ints)pick8(mask, (clast_floats8)yes, (clast_floats8)no);
}

CLAST_LANES lanes minimum(lanes a, lanes b)
{
    return min8(a, b);
}

CLAST_LANES lanes maximum(lanes a, lanes b)
{
    return max8(a, b);
}

#endif

CLAST_LANES lanes absolute(lanes a)
{
    return (lanes)((lane_ints)a & splat_int(INT32_MAX));
}

// Of the lanes in `bits`; `other` where there are none.
CLAST_LANES float least_lane(lanes a, uint32_t bits)
{
    a = pick(mask_of(bits), a, splat(INFINITY));
#if defined(__AVX512F__)
    return _mm512_reduce_min_ps((__m512)a);
#else
    float least = a[0];
    for (int i = 1; i < LANES; i++) {
        least = a[i] < least ? a[i] : least;
    }
    return least;
#endif
}

CLAST_LANES float most_lane(lanes a, uint32_t bits)
{
    return -least_lane(-a, bits);
}

#endif
