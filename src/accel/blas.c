// SPDX-License-Identifier: Apache-2.0
// Trees over a pool's clusters.
#include <string.h>

#include "accel/structures.h"

clast_status clast_blas_create(clast_clas_pool *pool, clast_blas **blas)
{
    if (pool == NULL || blas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *blas = clast_allocate_zeroed(pool->context, 1, sizeof **blas);
    if (*blas == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    (*blas)->pool = pool;
    (*blas)->context = pool->context;
    return CLAST_OK;
}

void clast_blas_destroy(clast_blas *blas)
{
    if (blas != NULL) {
        clast_tree_free(blas->context, &blas->tree);
        clast_reserve_free(blas->context, &blas->reserve);
        clast_free(blas->context, blas);
    }
}

uint64_t clast_blas_memory(size_t count)
{
    if (count >= CLAST_CHILD_ITEM) {
        return UINT64_MAX;
    }
    clast_tree counted;
    clast_arena arena = {NULL, 0};
    clast_tree_place(&counted, count, &arena);
    return arena.used + clast_tree_scratch(count);
}

// A BLAS that was mapped stays as it is.
static clast_status check_editable(const clast_blas *blas)
{
    if (blas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    return blas->mapped_bytes == 0
               ? CLAST_OK
               : clast_fail(blas->context, CLAST_ERROR_STATE, "a BLAS that was mapped is only read");
}

clast_status clast_blas_reserve(clast_blas *blas, size_t count)
{
    clast_status status = check_editable(blas);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_reserve_fit(blas->context, &blas->reserve, clast_blas_memory(count));
    if (status == CLAST_OK) {
        clast_tree_free(blas->context, &blas->tree);
    }
    return status;
}

clast_status clast_blas_use_memory(clast_blas *blas, void *memory, size_t bytes)
{
    clast_status status = check_editable(blas);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_reserve_borrow(blas->context, &blas->reserve, memory, bytes);
    if (status == CLAST_OK) {
        clast_tree_free(blas->context, &blas->tree);
    }
    return status;
}

// Memory for a build: the arena is what is left for work. `*temporary` is to be freed afterwards.
static clast_status make_room(clast_blas *blas, size_t count, clast_arena *arena, void **temporary)
{
    *temporary = NULL;
    if (blas->reserve.memory != NULL) {
        clast_status status = clast_reserve_fit(blas->context, &blas->reserve, clast_blas_memory(count));
        if (status == CLAST_OK) {
            *arena = (clast_arena){blas->reserve.memory, 0};
            clast_tree_place(&blas->tree, count, arena);
        }
        return status;
    }
    *temporary = clast_allocate(blas->context, clast_tree_scratch(count), 1);
    *arena = (clast_arena){*temporary, 0};
    return *temporary != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

clast_status clast_blas_build(clast_blas *blas, const uint32_t *slots, size_t count, clast_build build)
{
    clast_status status = check_editable(blas);
    if (status != CLAST_OK) {
        return status;
    }
    if (count >= CLAST_CHILD_ITEM || (slots == NULL && count > blas->pool->count)) {
        return clast_fail(blas->context, CLAST_ERROR_INVALID_ARGUMENT, "a BLAS over %zu clusters; the pool has %zu",
                          count, blas->pool->count);
    }
    for (size_t i = 0; slots != NULL && i < count; i++) {
        if (slots[i] >= blas->pool->count) {
            return clast_fail(blas->context, CLAST_ERROR_INVALID_ARGUMENT, "a BLAS over cluster %u; the pool has %zu",
                              slots[i], blas->pool->count);
        }
    }
    clast_arena arena;
    void *temporary;
    status = make_room(blas, count, &arena, &temporary);
    if (status == CLAST_OK) {
        status = clast_tree_build(blas->context, &blas->tree, blas->pool->boxes, slots, count, build, &arena);
    }
    clast_free(blas->context, temporary);
    if (status != CLAST_OK) {
        blas->tree.node_count = blas->tree.level_count = 0;
    }
    return status;
}

clast_status clast_blas_refit(clast_blas *blas)
{
    clast_status status = check_editable(blas);
    if (status != CLAST_OK) {
        return status;
    }
    clast_tree_refit(blas->context, &blas->tree, blas->pool->boxes);
    return CLAST_OK;
}

void clast_blas_bounds(const clast_blas *blas, float lower[3], float upper[3])
{
    clast_box box = blas != NULL ? clast_tree_bounds(&blas->tree) : clast_box_empty();
    memcpy(lower, box.lower.v, sizeof box.lower.v);
    memcpy(upper, box.upper.v, sizeof box.upper.v);
}

uint64_t clast_blas_bytes(const clast_blas *blas)
{
    if (blas == NULL) {
        return 0;
    }
    if (blas->mapped_bytes != 0) {
        return sizeof *blas + sizeof *blas->pool + blas->mapped_bytes;
    }
    return sizeof *blas + (blas->reserve.memory != NULL ? blas->reserve.bytes : clast_tree_bytes(&blas->tree));
}
