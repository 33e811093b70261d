// SPDX-License-Identifier: Apache-2.0
// Memory that runs out at a chosen allocation.
#ifndef CLAST_TESTS_SCARCE_H
#define CLAST_TESTS_SCARCE_H

#include "test.h"

typedef struct shortage {
    int64_t left; // allocations until the one that fails; negative: none does
    uint32_t failed;
} shortage;

static inline void *scarce_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)old_size;
    shortage *s = user;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    if (s->left >= 0 && s->left-- == 0) {
        s->failed++;
        return NULL;
    }
    return realloc(pointer, new_size);
}

// A context of one thread whose memory `s` bounds from now on.
static inline clast_context *scarce_context(shortage *s)
{
    *s = (shortage){-1, 0};
    clast_context *context;
    clast_context_desc desc = {.memory = {scarce_reallocate, s}, .threads = 1};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    return context;
}

#endif
