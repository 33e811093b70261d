// SPDX-License-Identifier: Apache-2.0
// Eight integers at once, and putting them in order without a branch: for kernel files, as base/simd.h.
#ifndef CLAST_BASE_SIMD_ORDER_H
#define CLAST_BASE_SIMD_ORDER_H

#include "base/simd.h"

// Which lanes are meant: a bit each where the machine has registers for that, else all ones or all zeros.
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
typedef uint8_t clast_mask8;
#else
typedef clast_ints8 clast_mask8;
#endif

CLAST_LANES clast_ints8 splat_ints8(int32_t x)
{
    return (clast_ints8){x, x, x, x, x, x, x, x};
}

// Lanes where a <= b.
CLAST_LANES clast_mask8 at_most8(clast_floats8 a, clast_floats8 b)
{
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return _mm256_cmp_ps_mask((__m256)a, (__m256)b, _CMP_LE_OQ);
#else
    return a <= b;
#endif
}

// The first `count` lanes; all where there are more.
CLAST_LANES clast_mask8 first_lanes8(uint32_t count)
{
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return (clast_mask8)_bzhi_u32(0xff, count);
#else
    return splat_ints8((int32_t)count) > (clast_ints8){0, 1, 2, 3, 4, 5, 6, 7};
#endif
}

CLAST_LANES uint32_t mask_bits8(clast_mask8 mask)
{
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return mask;
#else
    return bits8(mask);
#endif
}

CLAST_LANES clast_ints8 pick_ints8(clast_mask8 mask, clast_ints8 yes, clast_ints8 no)
{
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return (clast_ints8)_mm256_mask_blend_epi32(mask, (__m256i)no, (__m256i)yes);
#else
    return (clast_ints8)pick8(mask, (clast_floats8)yes, (clast_floats8)no);
#endif
}

CLAST_LANES clast_ints8 least_ints8(clast_ints8 a, clast_ints8 b)
{
#if defined(__AVX2__)
    return (clast_ints8)_mm256_min_epi32((__m256i)a, (__m256i)b);
#else
    return (clast_ints8)pick8(a < b, (clast_floats8)a, (clast_floats8)b);
#endif
}

CLAST_LANES clast_ints8 most_ints8(clast_ints8 a, clast_ints8 b)
{
#if defined(__AVX2__)
    return (clast_ints8)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    return (clast_ints8)pick8(a > b, (clast_floats8)a, (clast_floats8)b);
#endif
}

// The least of all lanes.
CLAST_LANES int32_t least_of8(clast_ints8 v)
{
#if defined(__AVX2__)
    __m128i half = _mm_min_epi32(_mm256_castsi256_si128((__m256i)v), _mm256_extracti128_si256((__m256i)v, 1));
    half = _mm_min_epi32(half, _mm_shuffle_epi32(half, 0x4e));
    half = _mm_min_epi32(half, _mm_shuffle_epi32(half, 0xb1));
    return _mm_cvtsi128_si32(half);
#else
    int32_t least = v[0];
    for (int i = 1; i < 8; i++) {
        least = v[i] < least ? v[i] : least;
    }
    return least;
#endif
}

// Lane i of the result is the table's lane lanes[i], of which the lower three bits count.
CLAST_LANES clast_ints8 look_up8(clast_ints8 table, clast_ints8 lanes)
{
#if defined(__AVX2__)
    return (clast_ints8)_mm256_permutevar8x32_epi32((__m256i)table, (__m256i)lanes);
#else
    clast_ints8 result;
    for (int i = 0; i < 8; i++) {
        result[i] = table[lanes[i] & 7];
    }
    return result;
#endif
}

// The largest first: Batcher's network for eight.
CLAST_LANES clast_ints8 sort_down8(clast_ints8 v)
{
    clast_ints8 p;
    // Each lane meets its partner; the larger of both stays in the first lane of the two. Kept from 8 on: the smaller.
#define ROUND(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, q) \
    p = __builtin_shufflevector(v, v, a, b, c, d, e, f, g, h); \
    v = __builtin_shufflevector(most_ints8(v, p), least_ints8(v, p), i, j, k, l, m, n, o, q);
    ROUND(1, 0, 3, 2, 5, 4, 7, 6, 0, 9, 2, 11, 4, 13, 6, 15)
    ROUND(3, 2, 1, 0, 7, 6, 5, 4, 0, 1, 10, 11, 4, 5, 14, 15)
    ROUND(1, 0, 3, 2, 5, 4, 7, 6, 0, 9, 2, 11, 4, 13, 6, 15)
    ROUND(7, 6, 5, 4, 3, 2, 1, 0, 0, 1, 2, 3, 12, 13, 14, 15)
    ROUND(2, 3, 0, 1, 6, 7, 4, 5, 0, 1, 10, 11, 4, 5, 14, 15)
    ROUND(1, 0, 3, 2, 5, 4, 7, 6, 0, 9, 2, 11, 4, 13, 6, 15)
#undef ROUND
    return v;
}

#endif
