// SPDX-License-Identifier: Apache-2.0
// Functions that fetch memory ahead.
#ifndef CLAST_BASE_PREFETCH_H
#define CLAST_BASE_PREFETCH_H

#include <stddef.h>

// How each function must be declared that does nothing but fetch: GCC takes it for one without effects, and drops calls of
// it, unless it is gone before GCC looks.
#define CLAST_FETCHES static inline __attribute__((always_inline))

enum { CLAST_CACHE_LINE = 64 };

// The lines of so many bytes.
CLAST_FETCHES void clast_prefetch(const void *first, size_t bytes)
{
    for (size_t at = 0; at < bytes; at += CLAST_CACHE_LINE) {
        __builtin_prefetch((const char *)first + at);
    }
}

#endif
