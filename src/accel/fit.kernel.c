// SPDX-License-Identifier: Apache-2.0
// Fits a cluster's boxes to its vertices.
//
// Quantising keeps order, so the least of some quantised coordinates is the quantised least of them. So every vertex is
// quantised once, to both sides, and the blocks' boxes are minima over bytes, which vectors look up or load many at a time.
// Upper sides are kept as 255 minus their steps: then all are minima.
//
// Boxes are free of negative zeros, so that they do not depend on the order in which vertices are seen.
#include <string.h>

#include "accel/structures.h"
#include "accel/quantise.h"
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

typedef int16_t words8 __attribute__((vector_size(16)));
typedef uint8_t bytes16 __attribute__((vector_size(16)));

typedef struct extent {
    clast_floats4 lower, upper; // the fourth lanes are never looked at
} extent;

CLAST_LANES extent extent_empty(void)
{
    return (extent){splat4(INFINITY), splat4(-INFINITY)};
}

CLAST_LANES void extend(extent *e, clast_floats4 v)
{
    e->lower = min4(v, e->lower);
    e->upper = max4(v, e->upper);
}

// False for NaN, and for what is too large for differences to be finite.
CLAST_LANES bool is_sound(clast_floats4 v)
{
    clast_ints4 sound = (v <= splat4(BOX_COORDINATE_MOST)) & (v >= splat4(-BOX_COORDINATE_MOST));
    return (sound[0] & sound[1] & sound[2]) != 0;
}

// ------------------------------------------------------------------------------------------------------------- header

// Stores the box around a cluster, and what its blocks' boxes are based on.
CLAST_LANES clast_steps begin_boxes(clast_clas *clas, clast_box *box, extent all, uint32_t block_count)
{
    all.lower += splat4(0.0f);
    all.upper += splat4(0.0f);
    clast_ints4 exponents = box_exponents4(all.upper - all.lower);
    memcpy(clas->lower, &all.lower, sizeof clas->lower);
    memcpy(&box->lower, &all.lower, sizeof box->lower);
    memcpy(&box->upper, &all.upper, sizeof box->upper);
    for (int axis = 0; axis < 3; axis++) {
        clas->exponents[axis] = (uint8_t)exponents[axis];
    }
    clas->block_count = (uint8_t)block_count;
    return steps_from(all.lower, exponents);
}

// ----------------------------------------------------------------------------------------------------- unsound vertices

// Of a block's triangles whose corners are all sound.
static extent sound_extent(const clast_block *block, const float *vertices)
{
    extent e = extent_empty();
    for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
        clast_floats4 v[3];
        for (uint32_t corner = 0; corner < 3; corner++) {
            v[corner] = load_three4(vertices + 3 * (uint32_t)block->corners[corner][lane]);
        }
        if (is_sound(v[0]) && is_sound(v[1]) && is_sound(v[2])) {
            extend(&e, v[0]);
            extend(&e, v[1]);
            extend(&e, v[2]);
        }
    }
    return e;
}

static void store_block(uint8_t group[3][2][CLUSTER_WIDTH], uint32_t lane, const extent *e, const clast_steps *s)
{
    // A block without a sound triangle has no sides: a box inside out, as far as bytes go.
    bool empty = !(e->lower[0] <= e->upper[0]);
    for (int axis = 0; axis < 3; axis++) {
        float down = empty ? (float)STEPS_MOST : floorf((e->lower[axis] - s->base[axis]) * s->down[axis]);
        float up = empty ? 0.0f : ceilf((e->upper[axis] - s->base[axis]) * s->up[axis]);
        group[axis][0][lane] = (uint8_t)down;
        group[axis][1][lane] = (uint8_t)up;
    }
}

static uint32_t group_count_of(uint32_t block_count)
{
    return (block_count + CLUSTER_WIDTH - 1) / CLUSTER_WIDTH;
}

// For any vertices, and templates that leave some of them unused.
static void fit_sound_triangles(clast_clas *clas, clast_box *box, const clast_template *topology, const float *vertices)
{
    extent blocks[TEMPLATE_BLOCKS], all = extent_empty();
    uint32_t block_count = topology->block_count;
    for (uint32_t i = 0; i < block_count; i++) {
        blocks[i] = sound_extent(&topology->blocks[i], vertices);
        all.lower = min4(blocks[i].lower, all.lower);
        all.upper = max4(blocks[i].upper, all.upper);
    }
    if (!(all.lower[0] <= all.upper[0])) {
        *box = (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
        memcpy(clas->lower, &box->lower, sizeof clas->lower);
        memset(clas->exponents, BOX_STEP_LEAST, sizeof clas->exponents);
        clas->block_count = 0;
        return;
    }
    clast_steps s = begin_boxes(clas, box, all, block_count);
    for (uint32_t i = 0; i < group_count_of(block_count) * CLUSTER_WIDTH; i++) {
        extent nothing = extent_empty();
        store_block(clas->groups[i / CLUSTER_WIDTH], i % CLUSTER_WIDTH, i < block_count ? &blocks[i] : &nothing, &s);
    }
}

#if defined(__AVX512VBMI__)
#include "accel/fit_bytes.h"
#endif

// ------------------------------------------------------------------------------------------------------------- bounds

// Four vertices are twelve floats, so three vectors, over and over. This brings the four to lanes of their own.
#define FOLD4(minimum, v) \
    minimum(minimum(v[0], __builtin_shufflevector(v[0], v[1], 3, 4, 5, 5)), \
            minimum(__builtin_shufflevector(v[1], v[2], 2, 3, 4, 4), __builtin_shufflevector(v[2], v[2], 1, 2, 3, 3)))

#if defined(__AVX2__)
enum { BOUND_TOGETHER = 8 };

// Of the first vertices, as many eights as there are. False where one is NaN.
CLAST_LANES bool bound_vectors(const float *vertices, uint32_t end, clast_floats4 lower[3], clast_floats4 upper[3])
{
    const clast_floats8 most = splat8(INFINITY), least = splat8(-INFINITY);
    clast_floats8 low[3] = {most, most, most}, high[3] = {least, least, least};
    clast_ints8 unordered = {0, 0, 0, 0, 0, 0, 0, 0};
    for (uint32_t i = 0; i < end; i += BOUND_TOGETHER) {
        for (uint32_t k = 0; k < 3; k++) {
            clast_floats8 v = load_any8(vertices + 3 * i + 8 * k);
            low[k] = min8(v, low[k]);
            high[k] = max8(v, high[k]);
            unordered |= v != v;
        }
    }
    lower[0] = min4(LOWER_HALF4(low[0]), UPPER_HALF4(low[1]));
    lower[1] = min4(UPPER_HALF4(low[0]), LOWER_HALF4(low[2]));
    lower[2] = min4(LOWER_HALF4(low[1]), UPPER_HALF4(low[2]));
    upper[0] = max4(LOWER_HALF4(high[0]), UPPER_HALF4(high[1]));
    upper[1] = max4(UPPER_HALF4(high[0]), LOWER_HALF4(high[2]));
    upper[2] = max4(LOWER_HALF4(high[1]), UPPER_HALF4(high[2]));
    return bits8(unordered) == 0;
}
#else
enum { BOUND_TOGETHER = 4 };

CLAST_LANES bool bound_vectors(const float *vertices, uint32_t end, clast_floats4 lower[3], clast_floats4 upper[3])
{
    clast_ints4 unordered = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        lower[k] = splat4(INFINITY);
        upper[k] = splat4(-INFINITY);
    }
    for (uint32_t i = 0; i < end; i += BOUND_TOGETHER) {
        for (uint32_t k = 0; k < 3; k++) {
            clast_floats4 v = load_any4(vertices + 3 * i + 4 * k);
            lower[k] = min4(v, lower[k]);
            upper[k] = max4(v, upper[k]);
            unordered |= v != v;
        }
    }
    return (unordered[0] | unordered[1] | unordered[2] | unordered[3]) == 0;
}
#endif

// The box around vertices; false where one is not sound.
static bool bounds_of(const float *vertices, uint32_t count, extent *bounds)
{
    clast_floats4 lower[3], upper[3];
    uint32_t i = count / BOUND_TOGETHER * BOUND_TOGETHER;
    bool ordered = bound_vectors(vertices, i, lower, upper);
    extent e = {FOLD4(min4, lower), FOLD4(max4, upper)};
    for (; i < count; i++) {
        clast_floats4 v = load_three4(vertices + 3 * i);
        ordered = ordered && is_sound(v);
        extend(&e, v);
    }
    *bounds = e;
    return ordered && is_sound(e.lower) && is_sound(e.upper);
}

// ------------------------------------------------------------------------------------------------------------- records

// A vertex as words: for each axis the steps down, then 255 minus the steps up.
CLAST_LANES clast_ints4 make_record(clast_floats4 v, const clast_steps *s)
{
    clast_floats4 away = v - s->base;
    return steps_down4(away, s->down) | (STEPS_MOST - steps_up4(away, s->up)) << 16;
}

static void make_records(const float *vertices, uint32_t count, const clast_steps *s, words8 records[TEMPLATE_VERTICES])
{
    uint32_t i = 0; // what is read beyond a vertex is the next one's
#if defined(__AVX2__)
    clast_floats8 base = JOIN4(s->base, s->base), down = JOIN4(s->down, s->down), up = JOIN4(s->up, s->up);
    for (; i + 3 <= count; i += 2) {
        clast_floats8 away = JOIN4(load_any4(vertices + 3 * i), load_any4(vertices + 3 * i + 3)) - base;
        clast_ints8 pair = steps_down8(away, down) | (STEPS_MOST - steps_up8(away, up)) << 16;
        memcpy(&records[i], &pair, sizeof pair);
    }
#endif
    for (; i + 2 <= count; i++) {
        records[i] = (words8)make_record(load_any4(vertices + 3 * i), s);
    }
    for (; i < count; i++) {
        records[i] = (words8)make_record(load_three4(vertices + 3 * i), s);
    }
}

CLAST_LANES words8 min_words(words8 a, words8 b)
{
#if defined(__SSE2__)
    return (words8)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
    words8 less = a < b;
    return (a & less) | (b & ~less);
#endif
}

CLAST_LANES words8 block_record(const clast_block *block, const words8 *records)
{
    const uint8_t *corners = block->corners[0];
    words8 even = records[corners[0]], odd = records[corners[1]];
    for (uint32_t k = 2; k < 3 * BLOCK_TRIANGLES; k += 2) {
        even = min_words(even, records[corners[k]]);
        odd = min_words(odd, records[corners[k + 1]]);
    }
    return min_words(even, odd);
}

// The low bytes of sixteen words.
CLAST_LANES bytes16 pack_words(words8 a, words8 b)
{
#if defined(__SSE2__)
    return (bytes16)_mm_packus_epi16((__m128i)a, (__m128i)b);
#else
    return __builtin_shufflevector((bytes16)a, (bytes16)b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
#endif
}

#define LOW_PAIRS(a, b) __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23)
#define HIGH_PAIRS(a, b) __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31)

// Sixteen blocks' records become a group. A byte's place is seven bits: four of the block, three of the word. Each round
// turns them by one.
static void store_group(uint8_t group[3][2][CLUSTER_WIDTH], const words8 blocks[CLUSTER_WIDTH])
{
    bytes16 rows[8], turned[8];
    for (int i = 0; i < 8; i++) {
        rows[i] = pack_words(blocks[2 * i], blocks[2 * i + 1]);
    }
    for (int round = 0; round < 4; round++) {
        for (int i = 0; i < 4; i++) {
            turned[2 * i] = LOW_PAIRS(rows[i], rows[i + 4]);
            turned[2 * i + 1] = HIGH_PAIRS(rows[i], rows[i + 4]);
        }
        memcpy(rows, turned, sizeof rows);
    }
    for (int axis = 0; axis < 3; axis++) {
        bytes16 upper = ~rows[2 * axis + 1];
        memcpy(group[axis][0], &rows[2 * axis], sizeof group[axis][0]);
        memcpy(group[axis][1], &upper, sizeof group[axis][1]);
    }
}

void CLAST_KERNEL(clast_fit)(clast_clas *clas, clast_box *box)
{
    const clast_template *topology = clast_clas_topology(clas);
    const float *vertices = clast_clas_vertices(clas);
#if defined(__AVX512VBMI__)
    if (topology->all_used && topology->vertex_count <= BYTE_VERTICES) {
        fit_bytes(clas, box, topology, vertices);
        return;
    }
#endif
    extent all;
    if (!topology->all_used || !bounds_of(vertices, topology->vertex_count, &all)) {
        fit_sound_triangles(clas, box, topology, vertices);
        return;
    }
    words8 records[TEMPLATE_VERTICES], blocks[TEMPLATE_BLOCKS];
    uint32_t block_count = topology->block_count, group_count = group_count_of(block_count);
    clast_steps s = begin_boxes(clas, box, all, block_count);
    make_records(vertices, topology->vertex_count, &s, records);
    for (uint32_t i = 0; i < block_count; i++) {
        blocks[i] = block_record(&topology->blocks[i], records);
    }
    for (uint32_t i = block_count; i < group_count * CLUSTER_WIDTH; i++) {
        blocks[i] = (words8){STEPS_MOST, STEPS_MOST, STEPS_MOST, STEPS_MOST,
                             STEPS_MOST, STEPS_MOST, 0,          0}; // inside out
    }
    for (uint32_t i = 0; i < group_count; i++) {
        store_group(clas->groups[i], &blocks[i * CLUSTER_WIDTH]);
    }
}
