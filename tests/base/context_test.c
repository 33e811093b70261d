// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <string.h>

#include "base/context.h"
#include "base/isa.h"
#include "base/size.h"

// --------------------------------------------------------------------------------------------------------------- sizes

static void sums_and_products_that_overflow_are_refused(void **state)
{
    (void)state;
    size_t result = 7;
    assert_true(clast_add_size(SIZE_MAX - 1, 1, &result));
    assert_int_equal(result, SIZE_MAX);
    assert_false(clast_add_size(SIZE_MAX, 1, &result));
    assert_true(clast_multiply_size(SIZE_MAX / 3, 3, &result));
    assert_int_equal(result, SIZE_MAX / 3 * 3);
    assert_false(clast_multiply_size(SIZE_MAX / 3 + 1, 3, &result));
    assert_true(clast_multiply_size(0, SIZE_MAX, &result));
    assert_int_equal(result, 0);
    assert_false(clast_multiply_size(SIZE_MAX, SIZE_MAX, &result));
    assert_int_equal(result, 0); // left alone
}

static void ranges_end_within_the_bytes(void **state)
{
    (void)state;
    assert_true(clast_range_fits(0, 10, 10));
    assert_true(clast_range_fits(10, 0, 10));
    assert_false(clast_range_fits(11, 0, 10));
    assert_false(clast_range_fits(1, 10, 10));
    assert_false(clast_range_fits(5, UINT64_MAX, 10));
    assert_false(clast_range_fits(UINT64_MAX, 5, 10));
}

static void elements_end_within_the_bytes(void **state)
{
    (void)state;
    assert_true(clast_elements_fit(4, 3, 8, 4, 24)); // the last one without the rest of its stride
    assert_false(clast_elements_fit(4, 3, 8, 4, 23));
    assert_false(clast_elements_fit(4, 4, 8, 4, 24));
    assert_true(clast_elements_fit(24, 0, 8, 4, 24));
    assert_false(clast_elements_fit(25, 0, 8, 4, 24));
    assert_true(clast_elements_fit(0, 5, 0, 4, 4)); // all the same
    assert_false(clast_elements_fit(0, UINT64_MAX, 8, 4, 1 << 20));
    assert_false(clast_elements_fit(0, UINT64_MAX / 8 + 2, 8, 4, 1 << 20));
    assert_false(clast_elements_fit(0, 2, UINT64_MAX, 4, 1 << 20));
    assert_false(clast_elements_fit(0, 1, 1, UINT64_MAX, 1 << 20));
}

// -------------------------------------------------------------------------------------------------------------- errors

static void an_error_is_one_line_that_steers_no_terminal(void **state)
{
    clast_context *context = *state;
    assert_string_equal(clast_context_error(context), "");
    assert_int_equal(clast_fail(context, CLAST_ERROR_MALFORMED, "%s: line %d",
                                "a\n\x1b[2Jb\t\x7f\xc2\x9b"
                                "c\xc3\xa9",
                                3),
                     CLAST_ERROR_MALFORMED);
    assert_string_equal(clast_context_error(context), "a  [2Jb    c\xc3\xa9: line 3");
}

static void a_long_error_is_cut(void **state)
{
    clast_context *context = *state;
    char text[5000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    clast_fail(context, CLAST_ERROR_MALFORMED, "%s", text);
    assert_in_range(strlen(clast_context_error(context)), 500, 4998);
}

static void every_status_has_a_text(void **state)
{
    (void)state;
#define CHECK(name, value, text) assert_string_equal(clast_status_text(name), text);
    CLAST_STATUS_LIST(CHECK)
#undef CHECK
    assert_true(strlen(clast_status_text((clast_status)9999)) > 0);
    assert_string_equal(clast_context_error(NULL), "");
}

static char logged[200];
static clast_log_level logged_level;

static void keep_line(void *user, clast_log_level level, const char *text)
{
    (void)user;
    logged_level = level;
    snprintf(logged, sizeof logged, "%s", text);
}

static void a_log_line_is_one_line(void **state)
{
    clast_context *context;
    clast_log(*state, CLAST_LOG_WARNING, "to no one");
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .log = {keep_line, NULL}}, &context),
                     CLAST_OK);
    clast_log(context, CLAST_LOG_WARNING, "%s and %d", "a\nb", 5);
    assert_string_equal(logged, "a b and 5");
    assert_int_equal(logged_level, CLAST_LOG_WARNING);
    clast_context_destroy(context);
}

// ------------------------------------------------------------------------------------------------------------ progress

static bool stop_at_half(void *user, const char *stage, uint64_t done, uint64_t total)
{
    ++*(int *)user;
    assert_string_equal(stage, "render");
    return 2 * done < total;
}

static void the_progress_hook_can_stop_the_work(void **state)
{
    int calls = 0;
    clast_context *context;
    assert_ok(*state, clast_progress(*state, "render", 9, 10)); // without a hook nothing stops
    assert_int_equal(
        clast_context_create(&(clast_context_desc){.threads = 1, .progress = {stop_at_half, &calls}}, &context),
        CLAST_OK);
    assert_ok(context, clast_progress(context, "render", 4, 10));
    assert_int_equal(clast_progress(context, "render", 5, 10), CLAST_ERROR_CANCELLED);
    assert_non_null(strstr(clast_context_error(context), "render"));
    assert_int_equal(calls, 2);
    clast_context_destroy(context);
}

// ------------------------------------------------------------------------------------------------------------ creation

typedef struct counted {
    long left;   // blocks that are still given
    long open;   // blocks not yet freed
    size_t size; // of those
} counted;

static void *counted_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    counted *c = user;
    if (new_size == 0) {
        c->open--;
        c->size -= old_size;
        free(pointer);
        return NULL;
    }
    if (c->left-- <= 0) {
        return NULL;
    }
    c->open++;
    c->size += new_size - old_size;
    return realloc(pointer, new_size);
}

static void a_context_without_memory_is_not_made(void **state)
{
    (void)state;
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    long tried = 0;
    for (; status != CLAST_OK; tried++) {
        counted c = {.left = tried};
        clast_context *context = (clast_context *)&c;
        status = clast_context_create(&(clast_context_desc){.memory = {counted_reallocate, &c}, .threads = 3},
                                      &context);
        if (status == CLAST_OK) {
            clast_context_destroy(context);
        } else {
            assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
            assert_null(context);
        }
        assert_int_equal(c.open, 0);
        assert_int_equal(c.size, 0);
    }
    assert_in_range(tried, 3, 10);
}

static void wrong_arguments_make_no_context(void **state)
{
    (void)state;
    clast_context *context;
    assert_int_equal(clast_context_create(NULL, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1025}, &context),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_context_create(&(clast_context_desc){.isa = (clast_isa)77}, &context), CLAST_ERROR_DEVICE);
    assert_int_equal(clast_context_create(&(clast_context_desc){.isa = (clast_isa)-1}, &context), CLAST_ERROR_DEVICE);
    clast_context_destroy(NULL);
}

static void the_instruction_set_can_be_chosen(void **state)
{
    (void)state;
    for (clast_isa isa = CLAST_ISA_PLAIN; isa <= clast_isa_best(); isa = (clast_isa)(isa + 1)) {
        clast_context *context;
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .isa = isa}, &context), CLAST_OK);
        assert_int_equal(clast_context_isa(context), isa);
        clast_context_destroy(context);
    }
    clast_context *context;
    assert_int_equal(clast_context_create(NULL, &context), CLAST_OK);
    assert_int_equal(clast_context_isa(context), clast_isa_best());
    assert_true(strlen(clast_isa_text(clast_context_isa(context))) > 0);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_and_products_that_overflow_are_refused),
        cmocka_unit_test(ranges_end_within_the_bytes),
        cmocka_unit_test(elements_end_within_the_bytes),
        CONTEXT_TEST(an_error_is_one_line_that_steers_no_terminal),
        CONTEXT_TEST(a_long_error_is_cut),
        cmocka_unit_test(every_status_has_a_text),
        CONTEXT_TEST(a_log_line_is_one_line),
        CONTEXT_TEST(the_progress_hook_can_stop_the_work),
        cmocka_unit_test(a_context_without_memory_is_not_made),
        cmocka_unit_test(wrong_arguments_make_no_context),
        cmocka_unit_test(the_instruction_set_can_be_chosen),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
