// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <string.h>

#include "base/thread.h"

// Around the sizes of the blocks that scan and sort work on.
static const size_t counts[] = {0, 1, 2, 1000, 16383, 16384, 16385, 49152, 100000};
enum { COUNTS = sizeof counts / sizeof counts[0] };

static uint64_t next_number(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static void a_scan_gives_the_sums_before(void **state)
{
    uint64_t numbers = 5;
    for (size_t c = 0; c < COUNTS; c++) {
        uint32_t *values = malloc((counts[c] + 1) * sizeof *values),
                 *scanned = malloc((counts[c] + 1) * sizeof *scanned);
        for (size_t i = 0; i < counts[c]; i++) {
            values[i] = scanned[i] = (uint32_t)(next_number(&numbers) % 1000);
        }
        uint32_t total = 7, sum = 0;
        assert_true(clast_exclusive_scan(*state, scanned, counts[c], &total));
        for (size_t i = 0; i < counts[c]; i++) {
            assert_int_equal(scanned[i], sum);
            sum += values[i];
        }
        assert_int_equal(total, sum);
        free(values);
        free(scanned);
    }
}

static bool scan_fits(clast_context *context, size_t count, uint32_t each, uint32_t last)
{
    uint32_t *values = malloc(count * sizeof *values), total;
    for (size_t i = 0; i < count; i++) {
        values[i] = i + 1 < count ? each : last;
    }
    bool fits = clast_exclusive_scan(context, values, count, &total);
    free(values);
    return fits;
}

static void a_sum_that_does_not_fit_is_told(void **state)
{
    assert_true(scan_fits(*state, 1, 0, UINT32_MAX));
    assert_true(scan_fits(*state, 65536, 65535, 65535 + 65535));
    assert_false(scan_fits(*state, 65536, 65535, 65536 + 65535));
    assert_true(scan_fits(*state, 3, 0, UINT32_MAX));
    assert_false(scan_fits(*state, 3, 1, UINT32_MAX));
    assert_false(scan_fits(*state, 100000, UINT32_MAX, UINT32_MAX));
}

// A scan needs memory for its sums where there are many, and does without where there is none.
static void a_scan_without_memory_is_right(void **state)
{
    (void)state;
    clast_context *context;
    size_t count = 3000000;
    uint32_t *values = malloc(count * sizeof *values), total;
    clast_context_desc desc = {.threads = 2, .memory_limit = 2048};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    void *rest = NULL;
    for (size_t size = 2048; rest == NULL && size > 0; size -= 16) {
        rest = clast_allocate(context, size, 1);
    }
    for (size_t i = 0; i < count; i++) {
        values[i] = 3;
    }
    assert_true(clast_exclusive_scan(context, values, count, &total));
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(values[i], 3 * i);
    }
    assert_int_equal(total, 3 * count);
    for (size_t i = 0; i < count; i++) {
        values[i] = 2000;
    }
    assert_false(clast_exclusive_scan(context, values, count, &total));
    clast_free(context, rest);
    clast_context_destroy(context);
    free(values);
}

typedef struct pair {
    uint64_t key;
    uint32_t value;
} pair;

// Values are the places before the sort, so this order is the only stable one.
static int compare(const void *a, const void *b)
{
    const pair *x = a, *y = b;
    return x->key != y->key ? (x->key < y->key ? -1 : 1) : (x->value < y->value ? -1 : 1);
}

static void check_sort(clast_context *context, size_t count, uint64_t mask, uint64_t seed)
{
    uint64_t *keys = malloc((count + 1) * sizeof *keys);
    uint32_t *values = malloc((count + 1) * sizeof *values);
    pair *pairs = malloc((count + 1) * sizeof *pairs);
    for (size_t i = 0; i < count; i++) {
        keys[i] = (next_number(&seed) & mask) | (~mask & 0x5555555555555555u);
        values[i] = (uint32_t)i;
        pairs[i] = (pair){keys[i], values[i]};
    }
    qsort(pairs, count, sizeof *pairs, compare);
    assert_ok(context, clast_sort_pairs(context, keys, values, count));
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(keys[i], pairs[i].key);
        assert_int_equal(values[i], pairs[i].value);
    }
    free(keys);
    free(values);
    free(pairs);
}

static void pairs_are_sorted_by_key_and_stable(void **state)
{
    for (size_t c = 0; c < COUNTS; c++) {
        check_sort(*state, counts[c], UINT64_MAX, 11 + c);
        check_sort(*state, counts[c], 0x3f, 12 + c);
    }
}

// Digits that are the same for all keys are left out: an odd number of rounds remains for some.
static void any_set_of_digits_sorts(void **state)
{
    static const uint64_t masks[] = {0,
                                     0xff,
                                     0xffff,
                                     0xff00,
                                     0xff0000ff,
                                     0xffffff,
                                     0xff00000000000000u,
                                     0x00ff00ff00ff0000u,
                                     0x0101010101010101u,
                                     1ull << 63};
    for (size_t m = 0; m < sizeof masks / sizeof masks[0]; m++) {
        check_sort(*state, 20000, masks[m], 3);
    }
}

static void a_sort_without_memory_says_so(void **state)
{
    (void)state;
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .memory_limit = 100000};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    uint64_t before = clast_context_memory(context);
    size_t count = 100000;
    uint64_t *keys = calloc(count, sizeof *keys);
    uint32_t *values = calloc(count, sizeof *values);
    assert_int_equal(clast_sort_pairs(context, keys, values, count), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(clast_context_memory(context), before);
    free(keys);
    free(values);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_scan_gives_the_sums_before),
        CONTEXT_TEST(a_sum_that_does_not_fit_is_told),
        cmocka_unit_test(a_scan_without_memory_is_right),
        CONTEXT_TEST(pairs_are_sorted_by_key_and_stable),
        CONTEXT_TEST(any_set_of_digits_sorts),
        cmocka_unit_test(a_sort_without_memory_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
