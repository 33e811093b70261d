// SPDX-License-Identifier: Apache-2.0
// Pools of clusters.
#include <string.h>

#include "accel/structures.h"
#include "base/size.h"
#include "base/thread.h"

enum { FIT_GRAIN = 64, SLOT_ALIGNMENT = 64 };

static size_t stride_for(uint32_t blocks)
{
    size_t groups = (blocks + CLUSTER_WIDTH - 1) / CLUSTER_WIDTH;
    size_t bytes = sizeof(clast_clas) + groups * sizeof(((clast_clas *)0)->groups[0]);
    return (bytes + SLOT_ALIGNMENT - 1) / SLOT_ALIGNMENT * SLOT_ALIGNMENT;
}

clast_status clast_clas_pool_create(clast_template_set *set, clast_clas_pool **pool)
{
    if (set == NULL || pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *pool = clast_allocate_zeroed(set->context, 1, sizeof **pool);
    if (*pool == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    **pool = (clast_clas_pool){.set = set, .context = set->context, .stride = stride_for(1)};
    return CLAST_OK;
}

void clast_clas_pool_destroy(clast_clas_pool *pool)
{
    if (pool != NULL) {
        clast_free(pool->context, pool->slots);
        clast_free(pool->context, pool->boxes);
        clast_free(pool->context, pool);
    }
}

// Room for `capacity` slots for templates of `blocks` blocks; keeps what is there.
static clast_status make_room(clast_clas_pool *pool, size_t capacity, uint32_t blocks)
{
    size_t stride = stride_for(blocks);
    stride = stride > pool->stride ? stride : pool->stride;
    if (capacity <= pool->capacity && stride == pool->stride) {
        return CLAST_OK;
    }
    capacity = capacity > pool->capacity ? capacity : pool->capacity;
    uint8_t *slots = clast_allocate(pool->context, capacity, stride);
    clast_box *boxes = clast_allocate(pool->context, capacity, sizeof *boxes);
    if (slots == NULL || boxes == NULL) {
        clast_free(pool->context, slots);
        clast_free(pool->context, boxes);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < pool->count; i++) {
        const clast_clas *from = clast_pool_slot(pool, i);
        clast_clas *to = (clast_clas *)(void *)(slots + i * stride);
        memcpy(to, from, pool->stride);
        to->topology += from->topology != 0 ? clast_distance(to, from) : 0;
        to->vertices += from->vertices != 0 ? clast_distance(to, from) : 0;
        boxes[i] = pool->boxes[i];
    }
    clast_free(pool->context, pool->slots);
    clast_free(pool->context, pool->boxes);
    pool->slots = slots;
    pool->boxes = boxes;
    pool->stride = stride;
    pool->capacity = capacity;
    return CLAST_OK;
}

clast_status clast_clas_pool_reserve(clast_clas_pool *pool, size_t count)
{
    if (pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count > CLAST_CHILD_ITEM) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "a pool of %zu clusters; 2^31 are possible",
                          count);
    }
    return make_room(pool, count, pool->set->most_blocks);
}

typedef struct fit_job {
    clast_clas_pool *pool;
    const clast_clas_input *inputs; // null: only the boxes
    size_t first;
    clast_fit_kernel fit;
} fit_job;

static void fit_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    fit_job *job = data;
    for (size_t i = begin; i < end; i++) {
        clast_clas *clas = clast_pool_slot(job->pool, job->first + i);
        if (job->inputs != NULL) {
            clas->topology = clast_distance(clas, job->pool->set->templates[job->inputs[i].template_number]);
            clas->vertices = clast_distance(clas, job->inputs[i].vertices);
        }
        if (clas->topology != 0) {
            job->fit(clas, &job->pool->boxes[job->first + i]);
        }
    }
}

static clast_status check_inputs(const clast_clas_pool *pool, const clast_clas_input *inputs, size_t count,
                                 uint32_t *most_blocks)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t number = inputs[i].template_number;
        if (number >= pool->set->count) {
            return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu: template %u; the set has %zu",
                              i, number, pool->set->count);
        }
        if (inputs[i].vertices == NULL) {
            return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu has no vertices", i);
        }
        uint32_t blocks = pool->set->templates[number]->block_count;
        *most_blocks = blocks > *most_blocks ? blocks : *most_blocks;
    }
    return CLAST_OK;
}

clast_status clast_clas_instantiate(clast_clas_pool *pool, size_t first, size_t count, const clast_clas_input *inputs)
{
    if (pool == NULL || (inputs == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count == 0) {
        return CLAST_OK;
    }
    size_t end;
    if (!clast_add_size(first, count, &end) || end > CLAST_CHILD_ITEM) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "clusters %zu and on, %zu of them; a pool has 2^31 slots", first, count);
    }
    uint32_t most_blocks = 0;
    clast_status status = check_inputs(pool, inputs, count, &most_blocks);
    if (status == CLAST_OK) {
        size_t grown = end <= pool->capacity || end > 2 * pool->capacity ? end : 2 * pool->capacity;
        status = make_room(pool, grown, most_blocks);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (; pool->count < first; pool->count++) {
        memset(clast_pool_slot(pool, pool->count), 0, sizeof(clast_clas)); // skipped over: nothing there
        pool->boxes[pool->count] = clast_box_empty();
    }
    pool->count = end > pool->count ? end : pool->count;
    fit_job job = {pool, inputs, first, clast_accel_kernels_of(clast_context_isa(pool->context))->fit};
    clast_parallel_for(pool->context, count, FIT_GRAIN, fit_range, &job);
    return CLAST_OK;
}

void clast_clas_pool_truncate(clast_clas_pool *pool, size_t count)
{
    if (pool != NULL && count < pool->count) {
        pool->count = count;
    }
}

clast_status clast_clas_refit(clast_clas_pool *pool, size_t first, size_t count)
{
    if (pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (!clast_range_fits(first, count, pool->count)) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "clusters %zu and on, %zu of them; the pool has %zu", first, count, pool->count);
    }
    fit_job job = {pool, NULL, first, clast_accel_kernels_of(clast_context_isa(pool->context))->fit};
    clast_parallel_for(pool->context, count, FIT_GRAIN, fit_range, &job);
    return CLAST_OK;
}

size_t clast_clas_pool_count(const clast_clas_pool *pool)
{
    return pool != NULL ? pool->count : 0;
}

uint64_t clast_clas_pool_bytes(const clast_clas_pool *pool)
{
    return pool != NULL ? sizeof *pool + (uint64_t)pool->capacity * (pool->stride + sizeof *pool->boxes) : 0;
}
