// SPDX-License-Identifier: Apache-2.0
// Part of fit.kernel.c, for AVX-512 with byte permutations (VBMI): tables of 128 bytes in registers, one for each axis and
// side, hold the vertices' steps, and one instruction looks up 64 corners. Eight blocks are done at a time.
#ifndef CLAST_ACCEL_FIT_BYTES_H
#define CLAST_ACCEL_FIT_BYTES_H

enum { BYTE_VERTICES = 128, HALF_VERTICES = 64, WIDE = 16 };

// For each axis, its steps down and 255 minus its steps up, of vertices 0 to 63 and 64 to 127.
typedef struct byte_tables {
    __m512i halves[3][2][2];
} byte_tables;

// The first `count` of sixteen lanes; all where there are more.
CLAST_LANES __mmask16 first_lanes(uint32_t count)
{
    return count >= WIDE ? (__mmask16)0xffff : (__mmask16)((1u << count) - 1u);
}

CLAST_LANES uint32_t left_from(uint32_t begin, uint32_t end)
{
    return end > begin ? end - begin : 0;
}

// Sixteen vertices are three vectors; this is the least of the vertices of 48 floats, four at a time, then two, then one.
#define FOLD_WIDE(minimum, a, b, c) \
    do { \
        a = minimum(minimum(a, _mm512_castsi512_ps(TURN(a, b, 12))), \
                    minimum(_mm512_castsi512_ps(TURN(b, c, 8)), _mm512_castsi512_ps(TURN(c, c, 4)))); \
        a = minimum(a, _mm512_castsi512_ps(TURN(a, a, 6))); \
        a = minimum(a, _mm512_castsi512_ps(TURN(a, a, 3))); \
    } while (0)
#define TURN(low, high, lanes) _mm512_alignr_epi32(_mm512_castps_si512(high), _mm512_castps_si512(low), lanes)

CLAST_LANES bool bounds_wide(const float *vertices, uint32_t floats, extent *bounds)
{
    __m512 lower[3], upper[3];
    __mmask16 unordered = 0;
    for (int k = 0; k < 3; k++) {
        lower[k] = _mm512_set1_ps(INFINITY);
        upper[k] = _mm512_set1_ps(-INFINITY);
    }
    uint32_t i = 0;
    for (; i + 3 * WIDE <= floats; i += 3 * WIDE) {
        for (uint32_t k = 0; k < 3; k++) {
            __m512 v = _mm512_loadu_ps(vertices + i + k * WIDE);
            lower[k] = _mm512_min_ps(lower[k], v);
            upper[k] = _mm512_max_ps(upper[k], v);
            unordered |= _mm512_cmp_ps_mask(v, v, _CMP_UNORD_Q);
        }
    }
    for (uint32_t k = 0; k < 3 && i < floats; k++, i += WIDE) {
        __mmask16 lanes = first_lanes(floats - i);
        __m512 v = _mm512_maskz_loadu_ps(lanes, vertices + i);
        lower[k] = _mm512_mask_min_ps(lower[k], lanes, lower[k], v);
        upper[k] = _mm512_mask_max_ps(upper[k], lanes, upper[k], v);
        unordered |= _mm512_cmp_ps_mask(v, v, _CMP_UNORD_Q);
    }
    FOLD_WIDE(_mm512_min_ps, lower[0], lower[1], lower[2]);
    FOLD_WIDE(_mm512_max_ps, upper[0], upper[1], upper[2]);
    bounds->lower = (clast_floats4)_mm512_castps512_ps128(lower[0]);
    bounds->upper = (clast_floats4)_mm512_castps512_ps128(upper[0]);
    return unordered == 0 && is_sound(bounds->lower) && is_sound(bounds->upper);
}

// A vertex's lanes, for vectors that begin with x, with y and with z.
CLAST_LANES void spread_axes(clast_floats4 v, __m512 wide[3])
{
    const __m512i first = _mm512_setr_epi32(0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0);
    const __m512i second = _mm512_setr_epi32(1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1);
    const __m512i third = _mm512_setr_epi32(2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2);
    __m512 one = _mm512_castps128_ps512((__m128)v);
    wide[0] = _mm512_permutexvar_ps(first, one);
    wide[1] = _mm512_permutexvar_ps(second, one);
    wide[2] = _mm512_permutexvar_ps(third, one);
}

typedef struct steps_wide {
    __m512 lower[3], down[3], up[3];
} steps_wide;

typedef struct byte_pack {
    __m512i down, up;
} byte_pack;

// The steps of 64 floats from `begin` on; the first belongs to the axis `phase`. Byte 16 l + 4 g + k of the result is float
// 16 g + 4 l + k: so the instructions pack.
CLAST_LANES byte_pack pack_steps(const float *vertices, uint32_t begin, uint32_t floats, const steps_wide *s, int phase)
{
    __m512i down[4], up[4];
    for (uint32_t g = 0; g < 4; g++) {
        uint32_t at = begin + g * WIDE, axis = ((uint32_t)phase + g) % 3;
        __m512 v = _mm512_maskz_loadu_ps(first_lanes(left_from(at, floats)), vertices + at);
        v = _mm512_sub_ps(v, s->lower[axis]);
        down[g] = _mm512_cvttps_epi32(_mm512_mul_ps(v, s->down[axis]));
        up[g] = _mm512_cvt_roundps_epi32(_mm512_mul_ps(v, s->up[axis]), _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC);
    }
    byte_pack packed = {_mm512_packus_epi16(_mm512_packs_epi32(down[0], down[1]), _mm512_packs_epi32(down[2], down[3])),
                        _mm512_packus_epi16(_mm512_packs_epi32(up[0], up[1]), _mm512_packs_epi32(up[2], up[3]))};
    packed.up = _mm512_xor_si512(packed.up, _mm512_set1_epi8(-1));
    return packed;
}

// Where float f of three packs lies in two of them, or in the third.
#define PACKED_PLACE(f) (uint8_t)(((f) / 64 % 2 * 64) | ((f) / 4 % 4 * 16) | ((f) / 16 % 4 * 4) | (f) % 4)
#define PACKED_PLACES4(f) PACKED_PLACE(f), PACKED_PLACE((f) + 3), PACKED_PLACE((f) + 6), PACKED_PLACE((f) + 9)
#define PACKED_PLACES16(f) \
    PACKED_PLACES4(f), PACKED_PLACES4((f) + 12), PACKED_PLACES4((f) + 24), PACKED_PLACES4((f) + 36)
#define PACKED_PLACES64(f) \
    { \
        PACKED_PLACES16(f), PACKED_PLACES16((f) + 48), PACKED_PLACES16((f) + 96), PACKED_PLACES16((f) + 144) \
    }
static const uint8_t packed_places[3][HALF_VERTICES]
    __attribute__((aligned(64))) = {PACKED_PLACES64(0), PACKED_PLACES64(1), PACKED_PLACES64(2)};

CLAST_LANES __m512i pick_axis(__m512i first, __m512i second, __m512i third, int axis)
{
    // The vertices whose floats are in the third pack: 3 v + axis >= 128.
    const __mmask64 in_third = axis == 2 ? ~(__mmask64)0 << 42 : ~(__mmask64)0 << 43;
    __m512i places = _mm512_load_si512(packed_places[axis]);
    __m512i picked = _mm512_permutex2var_epi8(first, places, second);
    return _mm512_mask_permutexvar_epi8(picked, in_third, places, third);
}

CLAST_LANES void fill_half(byte_tables *tables, int half, const float *vertices, uint32_t floats, const steps_wide *s)
{
    uint32_t begin = (uint32_t)half * 3 * HALF_VERTICES;
    byte_pack first = pack_steps(vertices, begin, floats, s, 0), second = first, third = first;
    if (begin + 64 < floats) {
        second = pack_steps(vertices, begin + 64, floats, s, 1);
    }
    if (begin + 128 < floats) {
        third = pack_steps(vertices, begin + 128, floats, s, 2);
    }
    for (int axis = 0; axis < 3; axis++) {
        tables->halves[axis][0][half] = pick_axis(first.down, second.down, third.down, axis);
        tables->halves[axis][1][half] = pick_axis(first.up, second.up, third.up, axis);
    }
}

// The corners of eight blocks, those that are not there as zeros: eight bytes a block, one vector for each corner.
CLAST_LANES void load_corners(const clast_block *blocks, uint32_t count, __m512i corners[3])
{
    __m512i pairs[4]; // of blocks: for each three qwords of corners, and one of triangle numbers
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t left = left_from(2 * i, count);
        pairs[i] = _mm512_maskz_loadu_epi64(left >= 2 ? 0xff : left == 1 ? 0x0f : 0, blocks + 2 * i);
    }
    const __m512i first_two = _mm512_setr_epi64(0, 4, 8, 12, 1, 5, 9, 13);
    const __m512i last = _mm512_setr_epi64(2, 6, 10, 14, 2, 6, 10, 14);
    __m512i low = _mm512_permutex2var_epi64(pairs[0], first_two, pairs[1]);
    __m512i high = _mm512_permutex2var_epi64(pairs[2], first_two, pairs[3]);
    corners[0] = _mm512_shuffle_i64x2(low, high, 0x44);
    corners[1] = _mm512_shuffle_i64x2(low, high, 0xee);
    low = _mm512_permutex2var_epi64(pairs[0], last, pairs[1]);
    high = _mm512_permutex2var_epi64(pairs[2], last, pairs[3]);
    corners[2] = _mm512_shuffle_i64x2(low, high, 0x44);
}

CLAST_LANES __m512i least_corner(const __m512i corners[3], const __m512i halves[2])
{
    __m512i least = _mm512_permutex2var_epi8(halves[0], corners[0], halves[1]);
    least = _mm512_min_epu8(least, _mm512_permutex2var_epi8(halves[0], corners[1], halves[1]));
    return _mm512_min_epu8(least, _mm512_permutex2var_epi8(halves[0], corners[2], halves[1]));
}

// The smaller of each two dwords, of two vectors: in each 128 bits, two of the first, then two of the second.
CLAST_LANES __m512i halve_dwords(__m512i a, __m512i b)
{
    __m512 x = _mm512_castsi512_ps(a), y = _mm512_castsi512_ps(b);
    return _mm512_min_epu8(_mm512_castps_si512(_mm512_shuffle_ps(x, y, 0x88)),
                           _mm512_castps_si512(_mm512_shuffle_ps(x, y, 0xdd)));
}

// Where, in the last two vectors of `store_eight`, the byte of a plane (0 to 5) and a block (0 to 7) is.
#define DWORD_OF(plane, block) ((block) / 2 * 4 + (plane) % 2 * 2 + (block) % 2)
#define LEAST_PLACE(plane, block) \
    (uint8_t)((plane) < 4 ? 2 * (16 * ((plane) / 2) + DWORD_OF(plane, block)) : 64 + 4 * DWORD_OF(plane, block))
#define LEAST_PLACES(plane) \
    LEAST_PLACE(plane, 0), LEAST_PLACE(plane, 1), LEAST_PLACE(plane, 2), LEAST_PLACE(plane, 3), LEAST_PLACE(plane, 4), \
        LEAST_PLACE(plane, 5), LEAST_PLACE(plane, 6), LEAST_PLACE(plane, 7)
static const uint8_t least_places[64] __attribute__((aligned(64))) = {
    LEAST_PLACES(0), LEAST_PLACES(1), LEAST_PLACES(2), LEAST_PLACES(3), LEAST_PLACES(4), LEAST_PLACES(5)};

// Stores the boxes of eight blocks, of which `count` are there; the others become boxes inside out. `planes` has eight bytes
// a block, the least of which is wanted: for each axis the lower side, and 255 minus the upper one.
CLAST_LANES void store_eight(uint8_t *sides, const __m512i planes[6], uint32_t count)
{
    const __m512i even = _mm512_set_epi16(62, 60, 58, 56, 54, 52, 50, 48, 46, 44, 42, 40, 38, 36, 34, 32, 30, 28, 26,
                                          24, 22, 20, 18, 16, 14, 12, 10, 8, 6, 4, 2, 0);
    const __m512i upper_sides = _mm512_setr_epi64(0, -1, 0, -1, 0, -1, 0, -1);
    __m512i xs = halve_dwords(planes[0], planes[1]), ys = halve_dwords(planes[2], planes[3]),
            zs = halve_dwords(planes[4], planes[5]);
    __m512i xys = _mm512_min_epu8(_mm512_permutex2var_epi16(xs, even, ys),
                                  _mm512_permutex2var_epi16(xs, _mm512_add_epi16(even, _mm512_set1_epi16(1)), ys));
    zs = _mm512_min_epu8(zs, _mm512_srli_epi32(zs, 16));
    xys = _mm512_min_epu8(xys, _mm512_srli_epi16(xys, 8));
    zs = _mm512_min_epu8(zs, _mm512_srli_epi16(zs, 8));
    __m512i least = _mm512_permutex2var_epi8(xys, _mm512_load_si512(least_places), zs);
    uint64_t there = (count >= 8 ? 0xffu : (1u << count) - 1u) * 0x0101010101010101u;
    least = _mm512_mask_mov_epi8(_mm512_set1_epi8(-1), there, least);
    least = _mm512_xor_si512(least, upper_sides);
    __m128i x = _mm512_castsi512_si128(least), y = _mm512_extracti32x4_epi32(least, 1),
            z = _mm512_extracti32x4_epi32(least, 2);
    const __m128i axes[3] = {x, y, z};
    for (int axis = 0; axis < 3; axis++) {
        _mm_storel_epi64((__m128i *)(void *)(sides + 2 * axis * CLUSTER_WIDTH), axes[axis]);
        _mm_storeh_pd((double *)(void *)(sides + (2 * axis + 1) * CLUSTER_WIDTH), _mm_castsi128_pd(axes[axis]));
    }
}

// Of a template that uses all of its vertices, at most 128.
static void fit_bytes(clast_clas *clas, clast_box *box, const clast_template *topology, const float *vertices)
{
    uint32_t floats = 3 * (uint32_t)topology->vertex_count, block_count = topology->block_count;
    extent all;
    if (!bounds_wide(vertices, floats, &all)) {
        fit_sound_triangles(clas, box, topology, vertices);
        return;
    }
    clast_steps s = begin_boxes(clas, box, all, block_count);
    steps_wide wide;
    spread_axes(s.base, wide.lower);
    spread_axes(s.down, wide.down);
    spread_axes(s.up, wide.up);
    byte_tables tables;
    fill_half(&tables, 0, vertices, floats, &wide);
    if (floats > 3 * HALF_VERTICES) {
        fill_half(&tables, 1, vertices, floats, &wide);
    } else {
        for (int axis = 0; axis < 3; axis++) {
            tables.halves[axis][0][1] = tables.halves[axis][1][1] = _mm512_setzero_si512();
        }
    }
    for (uint32_t first = 0; first < group_count_of(block_count) * CLUSTER_WIDTH; first += 8) {
        __m512i corners[3], planes[6];
        load_corners(topology->blocks + first, left_from(first, block_count), corners);
        for (int plane = 0; plane < 6; plane++) {
            planes[plane] = least_corner(corners, tables.halves[plane / 2][plane % 2]);
        }
        store_eight(&clas->groups[first / CLUSTER_WIDTH][0][0][first % CLUSTER_WIDTH], planes,
                    left_from(first, block_count));
    }
}

#endif
