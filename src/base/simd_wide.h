// SPDX-License-Identifier: Apache-2.0
// As many floats at once as a register of the instruction set has, at least eight: for kernel files whose items do not come in
// eights, as base/simd.h. All sets give the same bits.
#ifndef CLAST_BASE_SIMD_WIDE_H
#define CLAST_BASE_SIMD_WIDE_H

#include <math.h>

#include "base/simd.h"

#if defined(__AVX512F__)
#define WIDE_LANES 16
#else
#define WIDE_LANES 8
#endif
enum { WIDE_TABLE = 16 }; // entries of a table

typedef float clast_wide __attribute__((vector_size(4 * WIDE_LANES)));
typedef int32_t clast_wide_ints __attribute__((vector_size(4 * WIDE_LANES)));

CLAST_LANES clast_wide wide_splat(float x)
{
    return x - (clast_wide){0};
}

CLAST_LANES clast_wide_ints wide_splat_ints(int32_t x)
{
    return x - (clast_wide_ints){0};
}

CLAST_LANES clast_wide wide_load(const float *from)
{
    clast_wide v;
    memcpy(&v, from, sizeof v);
    return v;
}

CLAST_LANES clast_wide_ints wide_load_ints(const void *from)
{
    clast_wide_ints v;
    memcpy(&v, from, sizeof v);
    return v;
}

CLAST_LANES void wide_store(float *to, clast_wide v)
{
    memcpy(to, &v, sizeof v);
}

// The first `count` words, which need not be aligned, and zeros.
CLAST_LANES clast_wide_ints wide_load_first(const uint32_t *from, uint32_t count)
{
#if defined(__AVX512F__)
    return (clast_wide_ints)_mm512_maskz_loadu_epi32((__mmask16)(count < 16 ? (1u << count) - 1 : 0xffff), from);
#else
    clast_wide_ints v = {0};
    if (count >= WIDE_LANES) {
        return wide_load_ints(from);
    }
    for (uint32_t i = 0; i < count; i++) {
        v[i] = (int32_t)from[i];
    }
    return v;
#endif
}

// a where a < b, else b; as min8 and max8.
CLAST_LANES clast_wide wide_min(clast_wide a, clast_wide b)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_min_ps((__m512)a, (__m512)b);
#else
    return min8(a, b);
#endif
}

CLAST_LANES clast_wide wide_max(clast_wide a, clast_wide b)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_max_ps((__m512)a, (__m512)b);
#else
    return max8(a, b);
#endif
}

// yes where a < b.
CLAST_LANES clast_wide wide_pick_less(clast_wide a, clast_wide b, clast_wide yes, clast_wide no)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_mask_blend_ps(_mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ), (__m512)no,
                                            (__m512)yes);
#else
    return pick8(a < b, yes, no);
#endif
}

// yes where a > b.
CLAST_LANES clast_wide_ints wide_pick_more_ints(clast_wide_ints a, clast_wide_ints b, clast_wide_ints yes,
                                                clast_wide_ints no)
{
#if defined(__AVX512F__)
    return (clast_wide_ints)_mm512_mask_blend_epi32(_mm512_cmpgt_epi32_mask((__m512i)a, (__m512i)b), (__m512i)no,
                                                    (__m512i)yes);
#else
    return (clast_wide_ints)pick8(a > b, (clast_floats8)yes, (clast_floats8)no);
#endif
}

CLAST_LANES bool wide_any_not_zero(clast_wide a)
{
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)a, _mm512_setzero_ps(), _CMP_NEQ_UQ) != 0;
#else
    return bits8(a != (clast_wide){0}) != 0;
#endif
}

CLAST_LANES clast_wide wide_floor(clast_wide a)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_roundscale_ps((__m512)a, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
#elif defined(__AVX2__)
    return (clast_wide)_mm256_floor_ps((__m256)a);
#elif defined(__SSE4_2__)
    return join8(_mm_floor_ps(lower_half8(a)), _mm_floor_ps(upper_half8(a)));
#else
    for (int i = 0; i < WIDE_LANES; i++) {
        a[i] = floorf(a[i]);
    }
    return a;
#endif
}

// Towards zero, within the range of integers.
CLAST_LANES clast_wide_ints wide_to_ints(clast_wide a)
{
    return __builtin_convertvector(a, clast_wide_ints);
}

CLAST_LANES clast_wide wide_to_floats(clast_wide_ints a)
{
    return __builtin_convertvector(a, clast_wide);
}

// Zeros come in.
CLAST_LANES clast_wide_ints wide_shift_right(clast_wide_ints a, int bits)
{
    typedef uint32_t words __attribute__((vector_size(4 * WIDE_LANES)));
    return (clast_wide_ints)((words)a >> bits);
}

// Lane i is table[places[i]], places below WIDE_TABLE.
CLAST_LANES clast_wide wide_look_up(const float table[WIDE_TABLE], clast_wide_ints places)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_permutexvar_ps((__m512i)places, _mm512_loadu_ps(table));
#elif defined(__AVX2__)
    __m256 lower = _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), (__m256i)places);
    __m256 upper = _mm256_permutevar8x32_ps(_mm256_loadu_ps(table + 8), (__m256i)places);
    return (clast_wide)_mm256_blendv_ps(lower, upper, (__m256)(places << 28)); // by the eights' bit
#else
    clast_wide v;
    for (int i = 0; i < WIDE_LANES; i++) {
        v[i] = table[places[i]];
    }
    return v;
#endif
}

CLAST_LANES clast_wide_ints wide_look_up_ints(const int32_t table[WIDE_TABLE], clast_wide_ints places)
{
    float words[WIDE_TABLE];
    memcpy(words, table, sizeof words);
    return (clast_wide_ints)wide_look_up(words, places);
}

#endif
