// SPDX-License-Identifier: Apache-2.0
// Points of base triangles, blended and displaced, as many at once as a register holds. What is computed is
// displaced_point() of shared/displacement.h over blends of corners, or over curved_blend() of shared/tessellation.h, in the same
// order of the same operations.
#include "source/displace.h"
#include "source/wide_stable.h"

// A row of texels of 16 bits is read two at a time.
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "pairs of texels are taken apart as a little-endian machine stores them"
#endif

// What is blended, in the order of a corner's floats.
typedef struct blended {
    clast_wide of[DISPLACE_ATTRIBUTES];
} blended;

typedef struct wide_weights {
    clast_wide of[3];
} wide_weights;

// ------------------------------------------------------------------------------------------------------------- weights

CLAST_LANES wide_weights weights_at(const clast_displace_job *job, uint32_t first)
{
    clast_wide_ints words = wide_load_first(job->weights + first, job->count - first);
    clast_wide_ints second = words & wide_splat_ints(65535), third = wide_shift_right(words, 16);
    return (wide_weights){
        {wide_to_floats(wide_splat_ints(32768) - second - third), wide_to_floats(second), wide_to_floats(third)}};
}

// -------------------------------------------------------------------------------------------------------------- blends

CLAST_LANES clast_wide blend(float a, float b, float c, wide_weights w)
{
    return ((wide_splat(a) * w.of[0] + wide_splat(b) * w.of[1]) + wide_splat(c) * w.of[2]) * 0x1p-15f;
}

// All points have the same corners.
CLAST_LANES blended blend_same(const clast_displace_corner *corners, wide_weights w)
{
    const float *a = corners[0].of, *b = corners[1].of, *c = corners[2].of;
    blended all;
    for (int k = 0; k < DISPLACE_ATTRIBUTES; k++) {
        all.of[k] = blend(a[k], b[k], c[k], w);
    }
    return all;
}

// Each point has corners of its own: a point's attributes are blended side by side.
CLAST_LANES blended blend_own(const clast_displace_job *job, uint32_t first, wide_weights w)
{
    _Alignas(64) float points[WIDE_LANES][DISPLACE_FLOATS], weights[3][WIDE_LANES];
    for (int k = 0; k < 3; k++) {
        wide_store(weights[k], w.of[k]);
    }
    uint32_t last = job->count - 1;
    for (uint32_t i = 0; i < WIDE_LANES; i++) {
        uint32_t numbers = job->numbers[first + i < last ? first + i : last];
        const float *a = job->corners[numbers & 255].of, *b = job->corners[numbers >> 8 & 255].of;
        const float *c = job->corners[numbers >> 16 & 255].of;
        for (uint32_t k = 0; k < DISPLACE_FLOATS; k += WIDE_LANES) {
            wide_store(points[i] + k, ((wide_load(a + k) * weights[0][i] + wide_load(b + k) * weights[1][i]) +
                                       wide_load(c + k) * weights[2][i]) *
                                          0x1p-15f);
        }
    }
    clast_wide_columns columns = wide_turn(points[0], wide_rows_together);
    blended all;
    for (int k = 0; k < DISPLACE_ATTRIBUTES; k++) {
        all.of[k] = columns.of[k];
    }
    return all;
}

// -------------------------------------------------------------------------------------------------------------- curves

// curved_blend() along one axis, of weights that add up to one.
CLAST_LANES clast_wide curve(const clast_displace_curve *of, int axis, wide_weights w)
{
    const float p[3] = {of->positions[0][axis], of->positions[1][axis], of->positions[2][axis]};
    float to[6];
    for (int k = 0; k < 6; k++) {
        to[k] = of->controls[k][axis];
    }
    clast_wide a = w.of[0], b = w.of[1], c = w.of[2];
    clast_wide corners = (p[0] * (a * a * a) + p[1] * (b * b * b)) + p[2] * (c * c * c);
    clast_wide edges = ((to[0] * (a * a * b) + to[3] * (b * b * a)) + (to[1] * (b * b * c) + to[4] * (c * c * b))) +
                       (to[2] * (c * c * a) + to[5] * (a * a * c));
    float around = (to[0] + to[3]) + (to[1] + to[4]) + (to[2] + to[5]);
    float centre = around * 0.25f - (p[0] + p[1] + p[2]) * 0.166666667f;
    return (corners + edges * 3.0f) + centre * (6.0f * a * b * c);
}

CLAST_LANES void curve_positions(const clast_displace_job *job, wide_weights w, blended *at)
{
    wide_weights parts = {{w.of[0] * 0x1p-15f, w.of[1] * 0x1p-15f, w.of[2] * 0x1p-15f}};
    for (int axis = 0; axis < 3; axis++) {
        at->of[DISPLACE_POSITION + axis] = curve(job->curve, axis, parts);
    }
}

// weights_within()
CLAST_LANES wide_weights weights_in_whole(const clast_weights *within, wide_weights own)
{
    clast_wide_ints w[3], sums[3], total = wide_splat_ints(0);
    for (int k = 0; k < 3; k++) {
        w[k] = wide_to_ints(own.of[k]);
    }
    for (int k = 0; k < 3; k++) {
        clast_wide_ints products = w[0] * (int32_t)within[0].of[k] + w[1] * (int32_t)within[1].of[k] +
                                   w[2] * (int32_t)within[2].of[k];
        sums[k] = wide_shift_right(products + 16384, 15);
        total += sums[k];
    }
    clast_wide_ints missing = 32768 - total, none = wide_splat_ints(0);
    clast_wide_ints second = wide_pick_more_ints(sums[1], sums[0], missing, none);
    clast_wide_ints larger = wide_pick_more_ints(sums[1], sums[0], sums[1], sums[0]);
    clast_wide_ints third = wide_pick_more_ints(sums[2], larger, missing, none);
    second = wide_pick_more_ints(sums[2], larger, none, second);
    return (wide_weights){{wide_to_floats(sums[0] + (missing - second - third)), wide_to_floats(sums[1] + second),
                           wide_to_floats(sums[2] + third)}};
}

// Of a part of a triangle, or all of it.
CLAST_LANES blended blend_curved(const clast_displace_job *job, wide_weights own)
{
    wide_weights w = job->within != NULL ? weights_in_whole(job->within, own) : own;
    blended at = blend_same(job->corners, w);
    curve_positions(job, w, &at);
    const clast_displace_corner *corners = job->corners;
    at.of[DISPLACE_LEVEL] = blend(corners[0].of[DISPLACE_LEVEL], corners[1].of[DISPLACE_LEVEL],
                                  corners[2].of[DISPLACE_LEVEL], own);
    return at;
}

// What the points are before they are displaced.
CLAST_LANES blended blend_points(const clast_displace_job *job, uint32_t first)
{
    wide_weights w = weights_at(job, first);
    return job->numbers != NULL ? blend_own(job, first, w)
           : job->curve != NULL ? blend_curved(job, w)
                                : blend_same(job->corners, w);
}

// ------------------------------------------------------------------------------------------------------------- heights

// wrap_coordinate()
CLAST_LANES clast_wide wrap(clast_wide coordinate, uint32_t way)
{
    clast_wide wrapped = coordinate;
    if (way == CLAST_WRAP_REPEAT) {
        wrapped = coordinate - wide_floor(coordinate);
    } else if (way == CLAST_WRAP_MIRROR) {
        clast_wide half_turn = coordinate - 2.0f * wide_floor(coordinate * 0.5f);
        wrapped = wide_pick_less(wide_splat(1.0f), half_turn, 2.0f - half_turn, half_turn);
    }
    return wide_clamp1(wrapped, 0.0f, 1.0f);
}

CLAST_LANES clast_wide between(clast_wide a, clast_wide b, clast_wide weight)
{
    return a + (b - a) * weight;
}

// A map's levels, as tables to look up.
typedef struct level_tables {
    _Alignas(64) float widths[WIDE_TABLE], heights[WIDE_TABLE];
    int32_t firsts[WIDE_TABLE], pitches[WIDE_TABLE];
} level_tables;

static void fill_tables(const clast_height_map *map, level_tables *tables)
{
    _Static_assert((int)HEIGHT_LEVELS == (int)WIDE_TABLE, "a table has an entry for each level");
    for (uint32_t i = 0; i < HEIGHT_LEVELS; i++) {
        tables->widths[i] = (float)map->widths[i];
        tables->heights[i] = (float)map->heights[i];
        tables->firsts[i] = (int32_t)map->firsts[i];
        tables->pitches[i] = (int32_t)map->widths[i] + 2;
    }
}

// A texel and the one after it.
typedef struct wide_pair {
    clast_wide first, second;
} wide_pair;

CLAST_LANES wide_pair pair_of_words(clast_wide_ints words)
{
    return (wide_pair){wide_to_floats(words & wide_splat_ints(65535)), wide_to_floats(wide_shift_right(words, 16))};
}

CLAST_LANES wide_pair fetch_integers(const uint16_t *texels, clast_wide_ints places)
{
#if defined(__AVX512F__)
    return pair_of_words((clast_wide_ints)_mm512_i32gather_epi32((__m512i)places, texels, 2));
#elif defined(__AVX2__)
    return pair_of_words(
        (clast_wide_ints)_mm256_i32gather_epi32((const int *)(const void *)texels, (__m256i)places, 2));
#else
    int32_t words[WIDE_LANES];
    for (int i = 0; i < WIDE_LANES; i++) {
        memcpy(&words[i], texels + places[i], sizeof words[i]);
    }
    return pair_of_words(wide_load_ints(words));
#endif
}

CLAST_LANES clast_wide fetch_float(const float *texels, clast_wide_ints places)
{
#if defined(__AVX512F__)
    return (clast_wide)_mm512_i32gather_ps((__m512i)places, texels, 4);
#elif defined(__AVX2__)
    return (clast_wide)_mm256_i32gather_ps(texels, (__m256i)places, 4);
#else
    float each[WIDE_LANES];
    for (int i = 0; i < WIDE_LANES; i++) {
        each[i] = texels[places[i]];
    }
    return wide_load(each);
#endif
}

CLAST_LANES wide_pair fetch_floats(const float *texels, clast_wide_ints places)
{
    return (wide_pair){fetch_float(texels, places), fetch_float(texels + 1, places)};
}

// height_texels() and height_bilinear()
CLAST_LANES clast_wide value_in_level(const clast_height *height, const level_tables *tables, clast_wide u,
                                      clast_wide v, clast_wide_ints level)
{
    clast_wide_ints pitch = wide_look_up_ints(tables->pitches, level);
    clast_wide x = u * wide_look_up(tables->widths, level) + 0.5f, y = v * wide_look_up(tables->heights, level) + 0.5f;
    clast_wide column = wide_floor(x), row = wide_floor(y);
    clast_wide_ints upper = wide_look_up_ints(tables->firsts, level) + wide_to_ints(row) * pitch + wide_to_ints(column);
    wide_pair above, below;
    if (height->map.is_float) {
        above = fetch_floats(height->texels, upper);
        below = fetch_floats(height->texels, upper + pitch);
    } else {
        above = fetch_integers(height->texels, upper);
        below = fetch_integers(height->texels, upper + pitch);
    }
    clast_wide across = x - column;
    return between(between(above.first, above.second, across), between(below.first, below.second, across), y - row);
}

// clast_height_value()
CLAST_LANES clast_wide value_of(const clast_height *height, const level_tables *tables, const blended *at)
{
    const clast_height_map *map = &height->map;
    clast_wide u = wrap(at->of[DISPLACE_COORDINATES], map->wrap_u),
               v = wrap(at->of[DISPLACE_COORDINATES + 1], map->wrap_v);
    clast_wide level = wide_clamp1(at->of[DISPLACE_LEVEL], 0.0f, (float)(map->level_count - 1)),
               whole = wide_floor(level);
    clast_wide_ints finer = wide_to_ints(whole);
    clast_wide value = value_in_level(height, tables, u, v, finer);
    if (wide_any_not_zero(level - whole)) { // else the finer alone counts, and exactly
        clast_wide_ints last = wide_splat_ints((int32_t)map->level_count - 1), next = finer + 1;
        clast_wide coarse = value_in_level(height, tables, u, v, wide_pick_more_ints(next, last, last, next));
        value = between(value, coarse, level - whole);
    }
    return value * map->unit;
}

// ------------------------------------------------------------------------------------------------------------- points

CLAST_LANES clast_wide3 three_of(const blended *at, int first)
{
    return (clast_wide3){at->of[first], at->of[first + 1], at->of[first + 2]};
}

// The first `count` points, to memory as they lie there: three floats each.
CLAST_LANES void store_points(packed3 *to, clast_wide3 p, uint32_t count)
{
    _Alignas(64) float triples[3 * WIDE_LANES];
#if WIDE_LANES == 16
    const __m512i first_xy = _mm512_setr_epi32(0, 16, 0, 1, 17, 0, 2, 18, 0, 3, 19, 0, 4, 20, 0, 5);
    const __m512i second_xy = _mm512_setr_epi32(21, 0, 6, 22, 0, 7, 23, 0, 8, 24, 0, 9, 25, 0, 10, 26);
    const __m512i third_xy = _mm512_setr_epi32(0, 11, 27, 0, 12, 28, 0, 13, 29, 0, 14, 30, 0, 15, 31, 0);
    const __m512i first_z = _mm512_setr_epi32(0, 1, 16, 3, 4, 17, 6, 7, 18, 9, 10, 19, 12, 13, 20, 15);
    const __m512i second_z = _mm512_setr_epi32(0, 21, 2, 3, 22, 5, 6, 23, 8, 9, 24, 11, 12, 25, 14, 15);
    const __m512i third_z = _mm512_setr_epi32(26, 1, 2, 27, 4, 5, 28, 7, 8, 29, 10, 11, 30, 13, 14, 31);
    __m512 x = (__m512)p.x, y = (__m512)p.y, z = (__m512)p.z;
    float *out = count >= WIDE_LANES ? to->v : triples;
    _mm512_storeu_ps(out, _mm512_permutex2var_ps(_mm512_permutex2var_ps(x, first_xy, y), first_z, z));
    _mm512_storeu_ps(out + 16, _mm512_permutex2var_ps(_mm512_permutex2var_ps(x, second_xy, y), second_z, z));
    _mm512_storeu_ps(out + 32, _mm512_permutex2var_ps(_mm512_permutex2var_ps(x, third_xy, y), third_z, z));
    if (count < WIDE_LANES) {
        memcpy(to, triples, count * sizeof *to);
    }
#else
    for (int i = 0; i < WIDE_LANES; i++) {
        triples[3 * i] = p.x[i];
        triples[3 * i + 1] = p.y[i];
        triples[3 * i + 2] = p.z[i];
    }
    memcpy(to, triples, (count < WIDE_LANES ? count : WIDE_LANES) * sizeof *to);
#endif
}

void CLAST_KERNEL(clast_displace)(const clast_displace_job *job)
{
    level_tables tables;
    if (job->height != NULL) {
        fill_tables(&job->height->map, &tables);
    }
    for (uint32_t first = 0; first < job->count; first += WIDE_LANES) {
        blended at = blend_points(job, first);
        clast_wide height = wide_splat(job->offset);
        if (job->height != NULL) {
            height = value_of(job->height, &tables, &at) * job->scale + job->offset;
        }
        clast_wide3 position = three_of(&at, DISPLACE_POSITION), normal = three_of(&at, DISPLACE_NORMAL);
        store_points(job->positions + first, wide_displaced(position, normal, height), job->count - first);
    }
}
