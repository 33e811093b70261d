// SPDX-License-Identifier: Apache-2.0
// A memory hook that counts what is held, and can be made to fail.
#ifndef CLAST_TESTS_ACCEL_TAP_H
#define CLAST_TESTS_ACCEL_TAP_H

#include <stdint.h>
#include <stdlib.h>

typedef struct tap {
    uint32_t left; // allocations until one fails
    int64_t held;
} tap;

static inline void *tapped(void *user, void *pointer, size_t old_size, size_t new_size)
{
    tap *t = user;
    if (new_size != 0 && pointer == NULL && t->left-- == 0) {
        return NULL;
    }
    if (new_size == 0) {
        t->held -= (int64_t)old_size;
        free(pointer);
        return NULL;
    }
    void *moved = realloc(pointer, new_size);
    t->held += moved != NULL ? (int64_t)new_size - (int64_t)(pointer != NULL ? old_size : 0) : 0;
    return moved;
}

#endif
