// SPDX-License-Identifier: Apache-2.0
#include "geometry/clusters.h"

// The lowest vertex of the same position, found the slow way.
static uint32_t lowest_equal(const float *positions, uint32_t vertex)
{
    const float *p = positions + 3 * (size_t)vertex;
    for (uint32_t i = 0; i < vertex; i++) {
        const float *q = positions + 3 * (size_t)i;
        if (p[0] == q[0] && p[1] == q[1] && p[2] == q[2]) {
            return i;
        }
    }
    return vertex;
}

static void check_weld(clast_context *context, const float *positions, size_t count)
{
    uint32_t *remap = malloc((count + 1) * sizeof *remap);
    size_t unique, expected = 0;
    assert_ok(context, clast_weld_positions(context, positions, count, remap, &unique));
    for (uint32_t i = 0; i < count; i++) {
        uint32_t lowest = lowest_equal(positions, i);
        assert_int_equal(remap[i], lowest);
        expected += lowest == i;
    }
    assert_int_equal(unique, expected);
    free(remap);
}

static void each_vertex_gets_the_lowest_of_its_position(void **state)
{
    uint32_t numbers = 5;
    for (int round = 0; round < 6; round++) {
        size_t count = 1 + next_number(&numbers) % 3000;
        uint32_t places = 1 + next_number(&numbers) % 20;
        float *positions = malloc(count * 12);
        for (size_t i = 0; i < 3 * count; i++) {
            positions[i] = (float)(next_number(&numbers) % places) - 3.0f;
        }
        check_weld(*state, positions, count);
        free(positions);
    }
}

static void no_vertices_are_no_positions(void **state)
{
    size_t unique = 7;
    assert_ok(*state, clast_weld_positions(*state, NULL, 0, NULL, &unique));
    assert_int_equal(unique, 0);
}

static void zeros_of_both_signs_are_one_place(void **state)
{
    float positions[] = {0.0f, -0.0f, 1.0f, -0.0f, 0.0f, 1.0f, 0.0f, 0.0f, -1.0f};
    check_weld(*state, positions, 3);
}

static void what_is_no_number_is_equal_to_nothing(void **state)
{
    float positions[] = {NAN, 0, 0, NAN, 0, 0, INFINITY, 0, 0, INFINITY, 0, 0, 0, 0, NAN, 0, 0, NAN, -INFINITY, 0, 0};
    check_weld(*state, positions, 7);
}

static void neighbours_by_one_bit_stay_apart(void **state)
{
    float positions[3 * 64];
    for (size_t i = 0; i < 64; i++) {
        positions[3 * i] = 1.0f;
        positions[3 * i + 1] = nextafterf(2.0f, i % 2 != 0 ? 3.0f : 1.0f);
        positions[3 * i + 2] = (float)(i / 4);
    }
    check_weld(*state, positions, 64);
}

static void one_place_for_all(void **state)
{
    size_t count = 300000;
    float *positions = calloc(count, 12);
    uint32_t *remap = malloc(count * sizeof *remap);
    size_t unique;
    assert_ok(*state, clast_weld_positions(*state, positions, count, remap, &unique));
    assert_int_equal(unique, 1);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(remap[i], 0);
    }
    free(remap);
    free(positions);
}

// Undoes x ^ x >> shift.
static uint64_t undo_shift(uint64_t x, int shift)
{
    uint64_t result = x;
    for (int done = shift; done < 64; done += shift) {
        result = x ^ result >> shift;
    }
    return result;
}

// The inverse of an odd number modulo 2^64, by Newton's method.
static uint64_t inverse(uint64_t a)
{
    uint64_t x = a;
    for (int i = 0; i < 6; i++) {
        x *= 2 - a * x;
    }
    return x;
}

// Positions made to fall into one bucket and one slot of the hash table: it must not take quadratic time, and weld right.
// What the hash does last is undone from a chosen end: equal in its upper and lower bits.
static void positions_made_to_collide_are_welded(void **state)
{
    size_t count = 0, wanted = 20000;
    float *positions = malloc((wanted + 1) * 12);
    for (uint64_t i = 1; count < wanted; i++) {
        uint64_t hash = (i & 0xffff) << 24 | (i >> 16) << 44;
        uint64_t x = undo_shift(undo_shift(hash, 30) * inverse(0x94d049bb133111ebu), 31);
        x = undo_shift(x * inverse(0xbf58476d1ce4e5b9u), 29);
        uint32_t bits[3] = {(uint32_t)(x >> 32), (uint32_t)x, 0};
        if ((bits[0] & 0x7fffffffu) > 0x7f800000u || (bits[1] & 0x7fffffffu) > 0x7f800000u || i > 1u << 26) {
            if (i > 1u << 26) {
                break;
            }
            continue;
        }
        memcpy(positions + 3 * count++, bits, sizeof bits);
    }
    assert_true(count > 1000);
    memcpy(positions + 3 * (count - 1), positions + 3 * 17, 12); // one that is equal
    uint32_t *remap = malloc(count * sizeof *remap);
    size_t unique;
    assert_ok(*state, clast_weld_positions(*state, positions, count, remap, &unique));
    assert_int_equal(unique, count - 1);
    assert_int_equal(remap[count - 1], 17);
    for (size_t i = 0; i + 1 < count; i++) {
        assert_int_equal(remap[i], i);
    }
    free(remap);
    free(positions);
}

static void the_number_of_threads_changes_nothing(void **state)
{
    (void)state;
    static const uint32_t threads[] = {1, 2, 5};
    size_t count = 400000;
    float *positions = malloc(count * 12);
    uint32_t *remap[3], numbers = 99;
    for (size_t i = 0; i < 3 * count; i++) {
        positions[i] = (float)(next_number(&numbers) % 50);
    }
    for (size_t t = 0; t < 3; t++) {
        clast_context *context;
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads[t]}, &context), CLAST_OK);
        remap[t] = malloc(count * sizeof *remap[t]);
        size_t unique;
        assert_ok(context, clast_weld_positions(context, positions, count, remap[t], &unique));
        assert_memory_equal(remap[t], remap[0], count * sizeof *remap[t]);
        clast_context_destroy(context);
    }
    for (size_t t = 0; t < 3; t++) {
        free(remap[t]);
    }
    free(positions);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(each_vertex_gets_the_lowest_of_its_position),
        CONTEXT_TEST(no_vertices_are_no_positions),
        CONTEXT_TEST(zeros_of_both_signs_are_one_place),
        CONTEXT_TEST(what_is_no_number_is_equal_to_nothing),
        CONTEXT_TEST(neighbours_by_one_bit_stay_apart),
        CONTEXT_TEST(one_place_for_all),
        CONTEXT_TEST(positions_made_to_collide_are_welded),
        cmocka_unit_test(the_number_of_threads_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
