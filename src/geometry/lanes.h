// SPDX-License-Identifier: Apache-2.0
// Boxes in registers of four floats, the last of them zero: what the clusterizer's inner loops need, with the same bits
// on every machine. (SSE2 is part of every x86-64, so no kernels for several instruction sets.)
#ifndef CLAST_GEOMETRY_LANES_H
#define CLAST_GEOMETRY_LANES_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>

typedef __m128 lanes;

static inline lanes lanes_load(const float *values)
{
    return _mm_loadu_ps(values);
}
static inline void lanes_store(void *values, lanes a)
{
    _mm_storeu_ps(values, a);
}
static inline lanes lanes_all(float value)
{
    return _mm_set1_ps(value);
}
static inline lanes lanes_add(lanes a, lanes b)
{
    return _mm_add_ps(a, b);
}
static inline lanes lanes_subtract(lanes a, lanes b)
{
    return _mm_sub_ps(a, b);
}
static inline lanes lanes_multiply(lanes a, lanes b)
{
    return _mm_mul_ps(a, b);
}
static inline lanes lanes_min(lanes a, lanes b)
{
    return _mm_min_ps(a, b);
}
static inline lanes lanes_max(lanes a, lanes b)
{
    return _mm_max_ps(a, b);
}

// The first three lanes; the last becomes zero. What stands in memory there may be an integer: as a float it would be a
// denormal, which some machines add slowly.
static inline lanes lanes_three(const void *values)
{
    return _mm_and_ps(_mm_loadu_ps(values), _mm_castsi128_ps(_mm_setr_epi32(-1, -1, -1, 0)));
}

// All four, the last of which may be any bits.
static inline lanes lanes_four(const void *values)
{
    return _mm_loadu_ps(values);
}

// Three floats where no fourth may be read. What is no finite number becomes 0, a negative zero a positive one.
static inline lanes lanes_finite(const float *values)
{
    double two;
    memcpy(&two, values, sizeof two); // may be misaligned for a double
    __m128 a = _mm_movelh_ps(_mm_castpd_ps(_mm_set_sd(two)), _mm_load_ss(values + 2));
    __m128 magnitude = _mm_and_ps(a, _mm_castsi128_ps(_mm_set1_epi32(0x7fffffff)));
    return _mm_add_ps(_mm_and_ps(a, _mm_cmple_ps(magnitude, _mm_set1_ps(FLT_MAX))), _mm_setzero_ps());
}

// The same where they are known to be ordinary numbers.
static inline lanes lanes_ordinary(const float *values)
{
    double two;
    memcpy(&two, values, sizeof two); // may be misaligned for a double
    return _mm_movelh_ps(_mm_castpd_ps(_mm_set_sd(two)), _mm_load_ss(values + 2));
}

// Marks lanes that are larger in size than `most`, or no numbers.
static inline lanes lanes_wild(lanes a, float most)
{
    __m128 magnitude = _mm_and_ps(a, _mm_castsi128_ps(_mm_set1_epi32(0x7fffffff)));
    return _mm_cmpnle_ps(magnitude, _mm_set1_ps(most));
}

// Marks of either.
static inline lanes lanes_either(lanes a, lanes b)
{
    return _mm_or_ps(a, b);
}

static inline bool lanes_any(lanes marks)
{
    return _mm_movemask_ps(marks) != 0;
}

static inline void lanes_truncate(int32_t *integers, lanes a)
{
    _mm_storeu_si128((__m128i *)integers, _mm_cvttps_epi32(a));
}

static inline float box_half_area(lanes lower, lanes upper)
{
    __m128 d = _mm_sub_ps(upper, lower);
    __m128 products = _mm_mul_ps(d, _mm_shuffle_ps(d, d, _MM_SHUFFLE(3, 0, 2, 1))); // xy, yz, zx
    __m128 sum = _mm_add_ss(products, _mm_shuffle_ps(products, products, _MM_SHUFFLE(1, 1, 1, 1)));
    return _mm_cvtss_f32(_mm_add_ss(sum, _mm_movehl_ps(products, products)));
}

#else

typedef struct lanes {
    float v[4];
} lanes;

#define EACH_LANE(expression) \
    lanes result; \
    for (int i = 0; i < 4; i++) { \
        result.v[i] = (expression); \
    } \
    return result
static inline lanes lanes_load(const float *values)
{
    EACH_LANE(values[i]);
}
static inline void lanes_store(void *values, lanes a)
{
    memcpy(values, a.v, sizeof a.v);
}
static inline lanes lanes_all(float value)
{
    EACH_LANE(value);
}
static inline lanes lanes_add(lanes a, lanes b)
{
    EACH_LANE(a.v[i] + b.v[i]);
}
static inline lanes lanes_subtract(lanes a, lanes b)
{
    EACH_LANE(a.v[i] - b.v[i]);
}
static inline lanes lanes_multiply(lanes a, lanes b)
{
    EACH_LANE(a.v[i] * b.v[i]);
}
static inline lanes lanes_min(lanes a, lanes b)
{
    EACH_LANE(a.v[i] < b.v[i] ? a.v[i] : b.v[i]);
}
static inline lanes lanes_max(lanes a, lanes b)
{
    EACH_LANE(a.v[i] > b.v[i] ? a.v[i] : b.v[i]);
}
static inline lanes lanes_three(const void *values)
{
    lanes result = {{0.0f, 0.0f, 0.0f, 0.0f}};
    memcpy(result.v, values, 3 * sizeof(float));
    return result;
}
static inline lanes lanes_four(const void *values)
{
    return lanes_three(values); // of the last nothing is promised
}

static inline lanes lanes_finite(const float *values)
{
    EACH_LANE(i < 3 && values[i] >= -FLT_MAX && values[i] <= FLT_MAX ? values[i] + 0.0f : 0.0f);
}

static inline lanes lanes_ordinary(const float *values)
{
    EACH_LANE(i < 3 ? values[i] : 0.0f);
}
static inline lanes lanes_wild(lanes a, float most)
{
    EACH_LANE(a.v[i] >= -most && a.v[i] <= most ? 0.0f : 1.0f);
}
static inline lanes lanes_either(lanes a, lanes b)
{
    EACH_LANE(a.v[i] + b.v[i]);
}
#undef EACH_LANE

static inline bool lanes_any(lanes marks)
{
    return marks.v[0] + marks.v[1] + marks.v[2] + marks.v[3] > 0.0f;
}

static inline void lanes_truncate(int32_t *integers, lanes a)
{
    for (int i = 0; i < 4; i++) {
        integers[i] = (int32_t)a.v[i];
    }
}

static inline float box_half_area(lanes lower, lanes upper)
{
    lanes d = lanes_subtract(upper, lower);
    return d.v[0] * d.v[1] + d.v[1] * d.v[2] + d.v[2] * d.v[0];
}

#endif

// A box that any union replaces. Its last lane must stay zero, so that areas do.
static inline lanes box_none_lower(void)
{
    static const float none[4] = {FLT_MAX, FLT_MAX, FLT_MAX, 0.0f};
    return lanes_load(none);
}

static inline lanes box_none_upper(void)
{
    static const float none[4] = {-FLT_MAX, -FLT_MAX, -FLT_MAX, 0.0f};
    return lanes_load(none);
}

#endif
