// SPDX-License-Identifier: Apache-2.0
// Templates of patterns.
#include "test.h"

#include "accel/patterns.h"

static void each_pattern_is_a_template(void **state)
{
    clast_context *context = *state;
    clast_template_set *set;
    uint32_t other, first;
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_template_set_add_grid(set, 2, 3, &other));
    assert_ok(context, clast_template_set_add_patterns(set, &clast_patterns, &first));
    assert_int_equal(first, other + 1);
    assert_int_equal(clast_template_set_count(set), first + PATTERN_COUNT);
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        const clast_pattern *pattern = &clast_patterns.patterns[i];
        assert_int_equal(clast_template_triangle_count(set, first + i), pattern_triangles(*pattern));
        assert_int_equal(clast_template_vertex_count(set, first + i), pattern_vertices(*pattern));
        for (uint32_t k = 0; k < pattern_triangles(*pattern); k++) {
            uint32_t corners[3], word = clast_patterns.triangles[pattern->first_triangle + k];
            clast_template_triangle(set, first + i, k, corners);
            assert_int_equal(corners[0] | corners[1] << 8 | corners[2] << 16, word);
        }
    }
    clast_template_set_destroy(set);
}

static void a_set_takes_a_table_once(void **state)
{
    clast_context *context = *state;
    clast_template_set *set;
    uint32_t first, again;
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_template_set_add_patterns(set, &clast_patterns, &first));
    uint64_t bytes = clast_template_set_bytes(set);
    clast_pattern_table copy = clast_patterns;
    assert_ok(context, clast_template_set_add_patterns(set, &copy, &again));
    assert_int_equal(again, first);
    assert_int_equal(clast_template_set_bytes(set), bytes);
    copy.hash++; // another table
    assert_ok(context, clast_template_set_add_patterns(set, &copy, &again));
    assert_int_equal(again, first + PATTERN_COUNT);
    clast_template_set_destroy(set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(each_pattern_is_a_template),
        CONTEXT_TEST(a_set_takes_a_table_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
