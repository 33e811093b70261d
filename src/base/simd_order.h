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

CLAST_LANES clast_ints4 least_ints4(clast_ints4 a, clast_ints4 b)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    return (clast_ints4)_mm_min_epi32((__m128i)a, (__m128i)b);
#else
    return (clast_ints4)pick4(a < b, (clast_floats4)a, (clast_floats4)b);
#endif
}

CLAST_LANES clast_ints4 most_ints4(clast_ints4 a, clast_ints4 b)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    return (clast_ints4)_mm_max_epi32((__m128i)a, (__m128i)b);
#else
    return (clast_ints4)pick4(a > b, (clast_floats4)a, (clast_floats4)b);
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

#if defined(__AVX2__) && !defined(__AVX512VL__)
// For each set of lanes their numbers, the least first, a byte each.
#define CLAST_LANE_(bits, i) ((bits) >> (i)&1 ? (uint64_t)(i) << 8 * __builtin_popcount((bits) & ((1 << (i)) - 1)) : 0)
#define CLAST_ORDER_(bits) \
    (CLAST_LANE_(bits, 0) | CLAST_LANE_(bits, 1) | CLAST_LANE_(bits, 2) | CLAST_LANE_(bits, 3) | \
     CLAST_LANE_(bits, 4) | CLAST_LANE_(bits, 5) | CLAST_LANE_(bits, 6) | CLAST_LANE_(bits, 7))
#define CLAST_ORDERS4_(bits) \
    CLAST_ORDER_(bits), CLAST_ORDER_((bits) + 1), CLAST_ORDER_((bits) + 2), CLAST_ORDER_((bits) + 3)
#define CLAST_ORDERS16_(bits) \
    CLAST_ORDERS4_(bits), CLAST_ORDERS4_((bits) + 4), CLAST_ORDERS4_((bits) + 8), CLAST_ORDERS4_((bits) + 12)
#define CLAST_ORDERS64_(bits) \
    CLAST_ORDERS16_(bits), CLAST_ORDERS16_((bits) + 16), CLAST_ORDERS16_((bits) + 32), CLAST_ORDERS16_((bits) + 48)
static const uint64_t clast_lane_orders[256] = {CLAST_ORDERS64_(0), CLAST_ORDERS64_(64), CLAST_ORDERS64_(128),
                                                CLAST_ORDERS64_(192)};
#endif

// The lanes whose bits are set, moved to the front; what follows them means nothing.
CLAST_LANES clast_ints8 gather_lanes8(clast_ints8 v, uint32_t bits)
{
#if defined(__AVX512VL__) && defined(__AVX512DQ__)
    return (clast_ints8)_mm256_maskz_compress_epi32((__mmask8)bits, (__m256i)v);
#elif defined(__AVX2__)
    __m128i order = _mm_loadl_epi64((const __m128i *)(const void *)&clast_lane_orders[bits]);
    return look_up8(v, (clast_ints8)_mm256_cvtepu8_epi32(order));
#else
    clast_ints8 result = v;
    for (int to = 0; bits != 0; bits &= bits - 1) {
        result[to++] = v[__builtin_ctz(bits)];
    }
    return result;
#endif
}

// The first four lanes with the largest first, by Batcher's network; the others stay.
CLAST_LANES clast_ints8 sort_four_down8(clast_ints8 v)
{
    clast_ints4 four = __builtin_shufflevector(v, v, 0, 1, 2, 3), other;
    // Each lane meets its partner; the larger of both stays in the first lane of the two. Kept from 4 on: the smaller.
#define ROUND(a, b, c, d, e, f, g, h) \
    other = __builtin_shufflevector(four, four, a, b, c, d); \
    four = __builtin_shufflevector(most_ints4(four, other), least_ints4(four, other), e, f, g, h);
    ROUND(1, 0, 3, 2, 0, 5, 2, 7)
    ROUND(3, 2, 1, 0, 0, 1, 6, 7)
    ROUND(1, 0, 3, 2, 0, 5, 2, 7)
#undef ROUND
    clast_ints8 sorted = __builtin_shufflevector(four, four, 0, 1, 2, 3, -1, -1, -1, -1);
    return __builtin_shufflevector(sorted, v, 0, 1, 2, 3, 12, 13, 14, 15);
}

#endif
