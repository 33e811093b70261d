// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <stdint.h>
#include <string.h>

#include "base/context.h"

static void freed_blocks_leave_nothing(void **state)
{
    clast_context *context = *state;
    uint64_t before = clast_context_memory(context);
    void *block = clast_allocate(context, 100, 8);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    assert_true(clast_context_memory(context) >= before + 800);
    memset(block, 1, 800);
    block = clast_reallocate(context, block, 1000, 8);
    assert_int_equal(((unsigned char *)block)[799], 1);
    clast_free(context, block);
    assert_int_equal(clast_context_memory(context), before);
    assert_true(clast_context_memory_peak(context) >= before + 8000);
}

static void a_product_that_overflows_is_refused(void **state)
{
    clast_context *context = *state;
    assert_null(clast_allocate(context, SIZE_MAX / 2, 3));
    assert_null(clast_allocate(context, SIZE_MAX, 1));
    assert_true(strlen(clast_context_error(context)) > 0);
}

static void the_memory_limit_holds(void **state)
{
    (void)state;
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .memory_limit = 1 << 20}, &context),
                     CLAST_OK);
    void *block = clast_allocate(context, 1 << 19, 1);
    assert_non_null(block);
    assert_null(clast_allocate(context, 1 << 19, 1));
    clast_free(context, block);
    block = clast_allocate(context, 1 << 19, 1);
    assert_non_null(block);
    clast_free(context, block);
    clast_context_destroy(context);
}

static void a_large_block_is_one_like_any(void **state)
{
    clast_context *context = *state;
    uint64_t before = clast_context_memory(context);
    size_t size = ((size_t)40 << 20) + 5;
    unsigned char *block = clast_allocate(context, size, 1);
    assert_non_null(block);
    assert_int_equal((uintptr_t)block % 64, 0);
    block[0] = 7;
    block[size - 1] = 9;
    block = clast_reallocate(context, block, 2 * size, 1);
    assert_non_null(block);
    assert_int_equal(block[0], 7);
    assert_int_equal(block[size - 1], 9);
    block[2 * size - 1] = 1;
    block = clast_reallocate(context, block, 10, 1);
    assert_int_equal(block[0], 7);
    clast_free(context, block);
    assert_int_equal(clast_context_memory(context), before);
}

static void an_array_grows_and_keeps_its_elements(void **state)
{
    clast_context *context = *state;
    uint32_t *numbers = NULL;
    size_t capacity = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        assert_int_equal(CLAST_RESERVE(context, numbers, capacity, i + 1), CLAST_OK);
        numbers[i] = i;
    }
    for (uint32_t i = 0; i < 1000; i++) {
        assert_int_equal(numbers[i], i);
    }
    clast_free(context, numbers);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(freed_blocks_leave_nothing),
        CONTEXT_TEST(a_product_that_overflows_is_refused),
        cmocka_unit_test(the_memory_limit_holds),
        CONTEXT_TEST(a_large_block_is_one_like_any),
        CONTEXT_TEST(an_array_grows_and_keeps_its_elements),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
