// SPDX-License-Identifier: Apache-2.0
// What is reserved for builds: memory of the library's own, or the caller's.
#include "accel/memory.h"

void clast_reserve_free(clast_context *context, clast_reserve *reserve)
{
    if (!reserve->borrowed) {
        clast_free(context, reserve->memory);
    }
    *reserve = (clast_reserve){0};
}

clast_status clast_reserve_own(clast_context *context, clast_reserve *reserve, uint64_t bytes)
{
    if (!reserve->borrowed && reserve->memory != NULL && bytes <= reserve->bytes) {
        return CLAST_OK;
    }
    uint8_t *memory = bytes <= SIZE_MAX ? clast_allocate(context, (size_t)bytes, 1) : NULL;
    if (memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_reserve_free(context, reserve);
    *reserve = (clast_reserve){memory, (size_t)bytes, false};
    return CLAST_OK;
}

clast_status clast_reserve_borrow(clast_context *context, clast_reserve *reserve, void *memory, size_t bytes)
{
    if ((uintptr_t)memory % ARENA_ALIGNMENT != 0) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "the memory given is not aligned to %d bytes",
                          ARENA_ALIGNMENT);
    }
    clast_reserve_free(context, reserve);
    if (memory != NULL) {
        *reserve = (clast_reserve){memory, bytes, true};
    }
    return CLAST_OK;
}

clast_status clast_reserve_fit(clast_context *context, clast_reserve *reserve, uint64_t bytes)
{
    if (!reserve->borrowed) {
        return clast_reserve_own(context, reserve, bytes);
    }
    if (bytes > reserve->bytes) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "%llu bytes are needed; the memory given has %zu",
                          (unsigned long long)bytes, reserve->bytes);
    }
    return CLAST_OK;
}
