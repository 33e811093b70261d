// SPDX-License-Identifier: Apache-2.0
// Eight floats at once, and four, in the compiler's vector types; what those lack is here, for each instruction set. All
// sets give the same bits: the operations are those of IEEE 754, and where it leaves a choice (minimum, maximum) the
// choice is fixed. For kernel files, which are compiled once for each set (base/isa.h).
#ifndef CLAST_BASE_SIMD_H
#define CLAST_BASE_SIMD_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__AVX2__) || defined(__SSE4_2__)
#include <immintrin.h>
#endif

typedef float clast_floats4 __attribute__((vector_size(16)));
typedef int32_t clast_ints4 __attribute__((vector_size(16)));
typedef float clast_floats8 __attribute__((vector_size(32)));
typedef int32_t clast_ints8 __attribute__((vector_size(32))); // also masks: each lane all ones or all zeros

// Vectors wider than the machine's must never become arguments of real calls.
#define CLAST_LANES static inline __attribute__((always_inline))

CLAST_LANES clast_floats8 splat8(float x)
{
    return (clast_floats8){x, x, x, x, x, x, x, x};
}

CLAST_LANES clast_floats4 splat4(float x)
{
    return (clast_floats4){x, x, x, x};
}

CLAST_LANES clast_floats8 pick8(clast_ints8 mask, clast_floats8 yes, clast_floats8 no)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_blendv_ps((__m256)no, (__m256)yes, (__m256)mask);
#else
    return (clast_floats8)((mask & (clast_ints8)yes) | (~mask & (clast_ints8)no));
#endif
}

CLAST_LANES clast_floats4 pick4(clast_ints4 mask, clast_floats4 yes, clast_floats4 no)
{
    return (clast_floats4)((mask & (clast_ints4)yes) | (~mask & (clast_ints4)no));
}

#if defined(__AVX2__) || defined(__SSE4_2__)
CLAST_LANES __m128 lower_half8(clast_floats8 a)
{
    __m128 half;
    memcpy(&half, &a, sizeof half);
    return half;
}

CLAST_LANES __m128 upper_half8(clast_floats8 a)
{
    __m128 half;
    memcpy(&half, (const char *)&a + sizeof half, sizeof half);
    return half;
}

CLAST_LANES clast_floats8 join8(__m128 lower, __m128 upper)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_insertf128_ps(_mm256_castps128_ps256(lower), upper, 1);
#else
    clast_floats8 joined;
    memcpy(&joined, &lower, sizeof lower);
    memcpy((char *)&joined + sizeof lower, &upper, sizeof upper);
    return joined;
#endif
}
#endif

// a where a < b, else b: b where one is NaN or both are zero, as the MINPS and MAXPS instructions have it.
CLAST_LANES clast_floats8 min8(clast_floats8 a, clast_floats8 b)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_min_ps((__m256)a, (__m256)b);
#elif defined(__SSE4_2__)
    return join8(_mm_min_ps(lower_half8(a), lower_half8(b)), _mm_min_ps(upper_half8(a), upper_half8(b)));
#else
    return pick8(a < b, a, b);
#endif
}

CLAST_LANES clast_floats8 max8(clast_floats8 a, clast_floats8 b)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_max_ps((__m256)a, (__m256)b);
#elif defined(__SSE4_2__)
    return join8(_mm_max_ps(lower_half8(a), lower_half8(b)), _mm_max_ps(upper_half8(a), upper_half8(b)));
#else
    return pick8(a > b, a, b);
#endif
}

CLAST_LANES clast_floats4 abs4(clast_floats4 a)
{
    return (clast_floats4)((clast_ints4)a & (clast_ints4){INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX});
}

CLAST_LANES clast_floats4 min4(clast_floats4 a, clast_floats4 b)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    return (clast_floats4)_mm_min_ps((__m128)a, (__m128)b);
#else
    return pick4(a < b, a, b);
#endif
}

CLAST_LANES clast_floats4 max4(clast_floats4 a, clast_floats4 b)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    return (clast_floats4)_mm_max_ps((__m128)a, (__m128)b);
#else
    return pick4(a > b, a, b);
#endif
}

// Bit i is set where lane i of the mask is.
CLAST_LANES uint32_t bits8(clast_ints8 mask)
{
#if defined(__AVX2__)
    return (uint32_t)_mm256_movemask_ps((__m256)mask);
#elif defined(__SSE4_2__)
    clast_floats8 lanes = (clast_floats8)mask;
    return (uint32_t)(_mm_movemask_ps(lower_half8(lanes)) | _mm_movemask_ps(upper_half8(lanes)) << 4);
#else
    uint32_t bits = 0;
    for (int i = 0; i < 8; i++) {
        bits |= (uint32_t)(mask[i] & 1) << i;
    }
    return bits;
#endif
}

// Bit i is set where lane i is negative.
CLAST_LANES uint32_t bits4(clast_ints4 mask)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    return (uint32_t)_mm_movemask_ps((__m128)mask);
#else
    mask >>= 31;
    return (uint32_t)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}

// Eight bytes as floats.
CLAST_LANES clast_floats8 load_bytes8(const uint8_t *bytes)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)bytes)));
#elif defined(__SSE4_2__)
    __m128i all = _mm_loadl_epi64((const __m128i *)bytes);
    return join8(_mm_cvtepi32_ps(_mm_cvtepu8_epi32(all)), _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_srli_si128(all, 4))));
#else
    clast_floats8 floats;
    for (int i = 0; i < 8; i++) {
        floats[i] = (float)bytes[i];
    }
    return floats;
#endif
}

// Four bytes as integers.
CLAST_LANES clast_ints4 load_bytes4(const uint8_t *bytes)
{
#if defined(__AVX2__) || defined(__SSE4_2__)
    int32_t all;
    memcpy(&all, bytes, sizeof all);
    return (clast_ints4)_mm_cvtepu8_epi32(_mm_cvtsi32_si128(all));
#else
    return (clast_ints4){bytes[0], bytes[1], bytes[2], bytes[3]};
#endif
}

// One lane of four, eight times.
CLAST_LANES clast_floats8 splat_lane8(clast_floats4 v, int lane)
{
#if defined(__AVX2__)
    return (clast_floats8)_mm256_permutevar8x32_ps(_mm256_castps128_ps256((__m128)v), _mm256_set1_epi32(lane));
#else
    return splat8(v[lane]);
#endif
}

CLAST_LANES clast_floats4 load_four4(const float *p)
{
    clast_floats4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

// Three floats and a zero. Reads nothing beyond the three.
CLAST_LANES clast_floats4 load_three4(const float *p)
{
#if defined(__AVX2__)
    return (clast_floats4)_mm_maskload_ps(p, _mm_setr_epi32(-1, -1, -1, 0));
#elif defined(__SSE4_2__)
    // By way of integers: the load for doubles promises an alignment that floats do not have.
    __m128 first_two = _mm_castsi128_ps(_mm_loadl_epi64((const __m128i *)(const void *)p));
    return (clast_floats4)_mm_movelh_ps(first_two, _mm_load_ss(p + 2));
#else
    return (clast_floats4){p[0], p[1], p[2], 0.0f};
#endif
}

typedef struct clast_points8 {
    clast_floats8 x, y, z;
} clast_points8;

// Eight points, by their numbers in an array of three floats each.
CLAST_LANES clast_points8 load_points8(const float *points, const uint8_t numbers[8])
{
    clast_points8 result;
#if defined(__AVX2__) || defined(__SSE4_2__)
#define POINT(i) ((__m128)load_three4(points + 3 * (uint32_t)numbers[i]))
#endif
#if defined(__AVX2__)
    __m256 a = (__m256)join8(POINT(0), POINT(4)), b = (__m256)join8(POINT(1), POINT(5));
    __m256 c = (__m256)join8(POINT(2), POINT(6)), d = (__m256)join8(POINT(3), POINT(7));
    __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
    __m256 ab_z = _mm256_unpackhi_ps(a, b), cd_z = _mm256_unpackhi_ps(c, d);
    result.x = (clast_floats8)_mm256_shuffle_ps(ab, cd, 0x44);
    result.y = (clast_floats8)_mm256_shuffle_ps(ab, cd, 0xee);
    result.z = (clast_floats8)_mm256_shuffle_ps(ab_z, cd_z, 0x44);
#elif defined(__SSE4_2__)
    __m128 x[2], y[2], z[2];
    for (int half = 0; half < 2; half++) {
        __m128 a = POINT(4 * half), b = POINT(4 * half + 1), c = POINT(4 * half + 2), d = POINT(4 * half + 3);
        __m128 ab = _mm_unpacklo_ps(a, b), cd = _mm_unpacklo_ps(c, d);
        x[half] = _mm_movelh_ps(ab, cd);
        y[half] = _mm_movehl_ps(cd, ab);
        z[half] = _mm_movelh_ps(_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
    }
    result.x = join8(x[0], x[1]);
    result.y = join8(y[0], y[1]);
    result.z = join8(z[0], z[1]);
#else
    for (int i = 0; i < 8; i++) {
        const float *p = points + 3 * (uint32_t)numbers[i];
        result.x[i] = p[0];
        result.y[i] = p[1];
        result.z[i] = p[2];
    }
#endif
#undef POINT
    return result;
}

#endif
