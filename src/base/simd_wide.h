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

// Whether a <= b in all lanes; not where one is no number.
CLAST_LANES bool wide_all_at_most(clast_wide a, clast_wide b)
{
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ) == 0xffff;
#else
    return bits8(a <= b) == 0xff;
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

// Rows of sixteen floats, one for each lane, become sixteen vectors: row i begins at rows[places[i]]. What nobody looks at is not
// computed.
typedef struct clast_wide_columns {
    clast_wide of[16];
} clast_wide_columns;

CLAST_LANES clast_wide_columns wide_turn(const float *rows, const uint32_t places[WIDE_LANES])
{
    clast_wide_columns all;
#if defined(__AVX512F__)
    __m512 fours[16]; // lane k of quarter q of fours[i + j] is float 4 q + j of row i + k
    for (int i = 0; i < 16; i += 4) {
        __m512 a = _mm512_loadu_ps(rows + places[i]), b = _mm512_loadu_ps(rows + places[i + 1]);
        __m512 c = _mm512_loadu_ps(rows + places[i + 2]), d = _mm512_loadu_ps(rows + places[i + 3]);
        __m512 ab = _mm512_unpacklo_ps(a, b), cd = _mm512_unpacklo_ps(c, d);
        __m512 ab_high = _mm512_unpackhi_ps(a, b), cd_high = _mm512_unpackhi_ps(c, d);
        fours[i] = _mm512_shuffle_ps(ab, cd, 0x44);
        fours[i + 1] = _mm512_shuffle_ps(ab, cd, 0xee);
        fours[i + 2] = _mm512_shuffle_ps(ab_high, cd_high, 0x44);
        fours[i + 3] = _mm512_shuffle_ps(ab_high, cd_high, 0xee);
    }
    for (int j = 0; j < 4; j++) {
        __m512 early = _mm512_shuffle_f32x4(fours[j], fours[j + 4], 0x44); // quarters 0 and 1 of both
        __m512 late = _mm512_shuffle_f32x4(fours[j + 8], fours[j + 12], 0x44);
        all.of[j] = (clast_wide)_mm512_shuffle_f32x4(early, late, 0x88);
        all.of[j + 4] = (clast_wide)_mm512_shuffle_f32x4(early, late, 0xdd);
        early = _mm512_shuffle_f32x4(fours[j], fours[j + 4], 0xee);
        late = _mm512_shuffle_f32x4(fours[j + 8], fours[j + 12], 0xee);
        all.of[j + 8] = (clast_wide)_mm512_shuffle_f32x4(early, late, 0x88);
        all.of[j + 12] = (clast_wide)_mm512_shuffle_f32x4(early, late, 0xdd);
    }
#elif defined(__AVX2__)
    for (int half = 0; half < 16; half += 8) {
        __m256 fours[8];
        for (int i = 0; i < 8; i += 4) {
            __m256 a = _mm256_loadu_ps(rows + places[i] + half), b = _mm256_loadu_ps(rows + places[i + 1] + half);
            __m256 c = _mm256_loadu_ps(rows + places[i + 2] + half), d = _mm256_loadu_ps(rows + places[i + 3] + half);
            __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
            __m256 ab_high = _mm256_unpackhi_ps(a, b), cd_high = _mm256_unpackhi_ps(c, d);
            fours[i] = _mm256_shuffle_ps(ab, cd, 0x44);
            fours[i + 1] = _mm256_shuffle_ps(ab, cd, 0xee);
            fours[i + 2] = _mm256_shuffle_ps(ab_high, cd_high, 0x44);
            fours[i + 3] = _mm256_shuffle_ps(ab_high, cd_high, 0xee);
        }
        for (int j = 0; j < 4; j++) {
            all.of[half + j] = (clast_wide)_mm256_permute2f128_ps(fours[j], fours[j + 4], 0x20);
            all.of[half + j + 4] = (clast_wide)_mm256_permute2f128_ps(fours[j], fours[j + 4], 0x31);
        }
    }
#else
    for (int k = 0; k < 16; k++) {
        float each[WIDE_LANES];
        for (int i = 0; i < WIDE_LANES; i++) {
            each[i] = rows[places[i] + (uint32_t)k];
        }
        all.of[k] = wide_load(each);
    }
#endif
    return all;
}

// Of rows one after the other.
static const uint32_t wide_rows_together[16] = {0, 16, 32, 48, 64, 80, 96, 112, 128, 144, 160, 176, 192, 208, 224, 240};

// Back to rows, one after the other, as many as `count` says.
CLAST_LANES void wide_store_rows(float *rows, uint32_t count, clast_wide_columns columns)
{
    float each[16][WIDE_LANES];
    for (int k = 0; k < 16; k++) {
        wide_store(each[k], columns.of[k]);
    }
#if defined(__AVX512F__)
    clast_wide_columns turned = wide_turn(each[0], wide_rows_together); // a square: turned once more
    for (uint32_t i = 0; i < count && i < WIDE_LANES; i++) {
        wide_store(rows + 16 * i, turned.of[i]);
    }
#else
    for (uint32_t i = 0; i < count && i < WIDE_LANES; i++) {
        for (int k = 0; k < 16; k++) {
            rows[16 * i + k] = each[k][i];
        }
    }
#endif
}

#endif
