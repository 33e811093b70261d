// SPDX-License-Identifier: Apache-2.0
// Fits clusters to vertices that several of them share.
#include <stdatomic.h>

#include "accel/structures.h"
#include "base/prefetch.h"
#include "base/size.h"
#include "base/thread.h"

enum { GATHER_GRAIN = 32, HEAD_AHEAD = 8, FETCH_AHEAD = 2, TOGETHER = 4 };

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

static float *vertices_of(const gather_job *job, size_t slot)
{
    return job->gather->vertices + 3 * (size_t)job->gather->first[slot];
}

// What a cluster to come reads lies in short runs, which no hardware foresees; and what is written waits for its lines, too.
CLAST_FETCHES void prefetch_cluster(const gather_job *job, size_t slot)
{
    const clast_clas *clas = clast_pool_slot(job->pool, slot);
    if (clas->topology == 0) {
        return;
    }
    uint32_t count = clast_clas_topology(clas)->vertex_count;
    const uint32_t *numbers = job->gather->numbers + job->gather->first[slot];
    for (uint32_t i = 0; i < count; i += 2) {
        __builtin_prefetch((const void *)((uintptr_t)job->gather->positions + 12 * (uintptr_t)numbers[i]));
    }
    for (size_t at = 0; at < 3 * (size_t)count; at += 16) {
        __builtin_prefetch(vertices_of(job, slot) + at, 1);
    }
}

CLAST_FETCHES void prefetch_head(const gather_job *job, size_t slot)
{
    const clast_clas *clas = clast_pool_slot(job->pool, slot);
    if (clas->topology != 0) {
        __builtin_prefetch(clast_clas_topology(clas));
    }
}

// False where there is nothing to fit.
static bool gather_cluster(gather_job *job, size_t slot)
{
    const clast_clas_gather *g = job->gather;
    const clast_clas *clas = clast_pool_slot(job->pool, slot);
    float *vertices = vertices_of(job, slot);
    if (clas->topology == 0) {
        return false;
    }
    if (vertices != clast_clas_vertices(clas) ||
        !job->kernels->gather(vertices, g->positions, g->position_count, g->numbers + g->first[slot],
                              clast_clas_topology(clas)->vertex_count)) {
        note_wrong(job, slot);
        return false;
    }
    return true;
}

static void gather_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    gather_job *job = data;
    size_t last = job->first + end;
    // Some clusters are copied before the first of them is fitted: wide loads wait for what narrow stores wrote just before.
    for (size_t first = job->first + begin; first < last; first += TOGETHER) {
        size_t next = first + TOGETHER < last ? first + TOGETHER : last;
        bool fits[TOGETHER];
        for (size_t slot = first; slot < next; slot++) {
            if (slot + HEAD_AHEAD < last) {
                prefetch_head(job, slot + HEAD_AHEAD);
            }
            if (slot + FETCH_AHEAD < last) {
                prefetch_cluster(job, slot + FETCH_AHEAD);
            }
            fits[slot - first] = gather_cluster(job, slot);
        }
        for (size_t slot = first; slot < next; slot++) {
            if (fits[slot - first]) {
                job->kernels->fit(clast_pool_slot(job->pool, slot), &job->pool->boxes[slot]);
            }
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
