// SPDX-License-Identifier: Apache-2.0
// What unit tests share. CONTEXT_TEST hands a test a context of two threads, and fails it where memory is left over.
#ifndef CLAST_TESTS_TEST_H
#define CLAST_TESTS_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "clast/context.h"

static uint64_t test_memory_before;

static inline int test_context_setup(void **state)
{
    clast_context *context = NULL;
    if (clast_context_create(&(clast_context_desc){.threads = 2}, &context) != CLAST_OK) {
        return -1;
    }
    test_memory_before = clast_context_memory(context);
    *state = context;
    return 0;
}

static inline int test_context_teardown(void **state)
{
    clast_context *context = *state;
    uint64_t left = clast_context_memory(context) - test_memory_before;
    clast_context_destroy(context);
    if (left != 0) {
        fprintf(stderr, "%llu bytes left over\n", (unsigned long long)left);
        return -1;
    }
    return 0;
}

#define CONTEXT_TEST(function) cmocka_unit_test_setup_teardown(function, test_context_setup, test_context_teardown)

// Fails with the context's error text.
#define assert_ok(context, call) \
    do { \
        clast_status status_ = (call); \
        if (status_ != CLAST_OK) { \
            fail_msg("%s: %s (%s)", #call, clast_status_text(status_), clast_context_error(context)); \
        } \
    } while (0)

// The folder of real models, from CLAST_ASSETS. Without it the test program ends as skipped.
static inline const char *test_assets(void)
{
    const char *folder = getenv("CLAST_ASSETS");
    if (folder == NULL || folder[0] == '\0') {
        printf("skipped: CLAST_ASSETS is not set\n");
        exit(77);
    }
    return folder;
}

#endif
