// SPDX-License-Identifier: Apache-2.0
// Fits clusters to vertices that several of them share.
#include <stdatomic.h>

#include "accel/structures.h"
#include "base/size.h"
#include "base/thread.h"

enum { GATHER_GRAIN = 32, HEAD_AHEAD = 8, FETCH_AHEAD = 2 };

typedef struct gather_job {
    clast_clas_pool *pool;
    const clast_clas_gather *gather;
    size_t first;
    const clast_accel_kernels *kernels;
    atomic_size_t wrong; // the lowest slot that names a position out of range
} gather_job;

static void note_wrong(gather_job *job, size_t slot)
{
    size_t lowest = atomic_load(&job->wrong);
    while (slot < lowest && !atomic_compare_exchange_weak(&job->wrong, &lowest, slot)) {
    }
}

// The positions of a cluster to come lie in short runs, which no hardware foresees.
static void prefetch_positions(const gather_job *job, size_t slot)
{
    const clast_clas_gather *g = job->gather;
    const clast_clas *clas = clast_pool_slot(job->pool, slot);
    if (clas->topology != 0) {
        const uint32_t *numbers = g->numbers + g->first[slot];
        uint32_t count = clast_clas_topology(clas)->vertex_count;
        for (uint32_t i = 0; i < count; i += 2) {
            __builtin_prefetch((const void *)((uintptr_t)g->positions + 12 * (uintptr_t)numbers[i]));
        }
    }
}

static void prefetch_head(const gather_job *job, size_t slot)
{
    const clast_clas *clas = clast_pool_slot(job->pool, slot);
    if (clas->topology != 0) {
        __builtin_prefetch(clast_clas_topology(clas));
    }
}

static void gather_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    gather_job *job = data;
    const clast_clas_gather *g = job->gather;
    end += job->first;
    for (size_t slot = job->first + begin; slot < end; slot++) {
        if (slot + HEAD_AHEAD < end) {
            prefetch_head(job, slot + HEAD_AHEAD);
        }
        if (slot + FETCH_AHEAD < end) {
            prefetch_positions(job, slot + FETCH_AHEAD);
        }
        clast_clas *clas = clast_pool_slot(job->pool, slot);
        if (clas->topology == 0) {
            continue;
        }
        float *vertices = g->vertices + 3 * (size_t)g->first[slot];
        uint32_t count = clast_clas_topology(clas)->vertex_count;
        if (vertices == clast_clas_vertices(clas) &&
            job->kernels->gather(vertices, g->positions, g->position_count, g->numbers + g->first[slot], count)) {
            job->kernels->fit(clas, &job->pool->boxes[slot]);
        } else {
            note_wrong(job, slot);
        }
    }
}

clast_status clast_clas_refit_gathered(clast_clas_pool *pool, size_t first, size_t count,
                                       const clast_clas_gather *gather)
{
    if (pool == NULL || gather == NULL || gather->positions == NULL || gather->numbers == NULL ||
        gather->first == NULL || gather->vertices == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (!clast_range_fits(first, count, pool->count)) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "clusters %zu and on, %zu of them; the pool has %zu", first, count, pool->count);
    }
    gather_job job = {pool, gather, first, clast_accel_kernels_of(clast_context_isa(pool->context)), SIZE_MAX};
    clast_parallel_for(pool->context, count, GATHER_GRAIN, gather_range, &job);
    size_t wrong = atomic_load(&job.wrong);
    if (wrong != SIZE_MAX) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "cluster %zu takes a position beyond the %zu that there are, or its vertices lie elsewhere",
                          wrong, gather->position_count);
    }
    return CLAST_OK;
}
