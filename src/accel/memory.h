// SPDX-License-Identifier: Apache-2.0
// Memory of objects that are built again and again. A build takes all its arrays from one arena, by one function that is
// also run over an arena without memory, to learn how much there must be: so what is promised and what is taken agree.
#ifndef CLAST_ACCEL_MEMORY_H
#define CLAST_ACCEL_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"

enum { ARENA_ALIGNMENT = 64 };

// A block that is handed out piece by piece, from its front.
typedef struct clast_arena {
    uint8_t *memory; // null: only counts
    size_t used;
} clast_arena;

// Memory of `count` elements of `size` bytes, both far below what makes the sum overflow: counts of items are below 2^31.
static inline void *clast_arena_take(clast_arena *arena, size_t count, size_t size)
{
    void *piece = arena->memory != NULL ? arena->memory + arena->used : NULL;
    arena->used += (count * size + ARENA_ALIGNMENT - 1) / ARENA_ALIGNMENT * ARENA_ALIGNMENT;
    return piece;
}

// Memory that an object holds from one build to the next, so that none need be allocated.
typedef struct clast_reserve {
    uint8_t *memory; // null: nothing is reserved
    size_t bytes;
    bool borrowed; // the caller's
} clast_reserve;

// Each of these leaves the reserve as it was where it fails. What lay in it is lost where it succeeds, unless the reserve
// was large enough.
clast_status clast_reserve_own(clast_context *context, clast_reserve *reserve, uint64_t bytes);
// Null memory gives up what is reserved.
clast_status clast_reserve_borrow(clast_context *context, clast_reserve *reserve, void *memory, size_t bytes);
// Makes sure of so many bytes: own memory grows, the caller's cannot.
clast_status clast_reserve_fit(clast_context *context, clast_reserve *reserve, uint64_t bytes);
void clast_reserve_free(clast_context *context, clast_reserve *reserve);

#endif
