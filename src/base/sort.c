// SPDX-License-Identifier: Apache-2.0
// Parallel scan and stable radix sort. Both work on fixed blocks of elements, so their results do not depend on the
// number of threads.
#include <string.h>

#include "base/thread.h"

enum { SCAN_BLOCK = 16384, SORT_BLOCK = 16384, RADIX_BITS = 8, RADIX = 1 << RADIX_BITS };

typedef struct scan_job {
    uint32_t *values;
    uint64_t *sums; // one for each block
} scan_job;

static void sum_block(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    scan_job *job = data;
    uint64_t sum = 0;
    for (size_t i = begin; i < end; i++) {
        sum += job->values[i];
    }
    job->sums[begin / SCAN_BLOCK] = sum;
}

static void scan_block(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    scan_job *job = data;
    uint32_t sum = (uint32_t)job->sums[begin / SCAN_BLOCK];
    for (size_t i = begin; i < end; i++) {
        uint32_t value = job->values[i];
        job->values[i] = sum;
        sum += value;
    }
}

bool clast_exclusive_scan(clast_context *context, uint32_t *values, size_t count, uint32_t *total)
{
    size_t blocks = (count + SCAN_BLOCK - 1) / SCAN_BLOCK;
    uint64_t few[64]; // enough for a million values; more come from the heap, or from one serial pass
    uint64_t *sums = blocks <= 64 ? few : clast_allocate(context, blocks, sizeof *sums);
    if (sums == NULL) {
        uint64_t sum = 0;
        for (size_t i = 0; i < count; i++) {
            uint32_t value = values[i];
            values[i] = (uint32_t)sum;
            sum += value;
        }
        *total = (uint32_t)sum;
        return sum <= UINT32_MAX;
    }
    scan_job job = {values, sums};
    clast_parallel_for(context, count, SCAN_BLOCK, sum_block, &job);
    uint64_t sum = 0;
    for (size_t i = 0; i < blocks; i++) {
        uint64_t block_sum = sums[i];
        sums[i] = sum;
        sum += block_sum;
    }
    bool fits = sum <= UINT32_MAX;
    if (fits) {
        clast_parallel_for(context, count, SCAN_BLOCK, scan_block, &job);
    }
    *total = (uint32_t)sum;
    if (sums != few) {
        clast_free(context, sums);
    }
    return fits;
}

typedef struct sort_job {
    const uint64_t *keys;
    const uint32_t *values;
    uint64_t *sorted_keys;
    uint32_t *sorted_values;
    size_t *places; // [block][digit]: first how many, then where they go
    uint32_t shift;
} sort_job;

static void count_digits(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    sort_job *job = data;
    size_t *places = job->places + begin / SORT_BLOCK * RADIX;
    memset(places, 0, RADIX * sizeof *places);
    for (size_t i = begin; i < end; i++) {
        places[(job->keys[i] >> job->shift) & (RADIX - 1)]++;
    }
}

static void scatter(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    sort_job *job = data;
    size_t *places = job->places + begin / SORT_BLOCK * RADIX;
    for (size_t i = begin; i < end; i++) {
        size_t place = places[(job->keys[i] >> job->shift) & (RADIX - 1)]++;
        job->sorted_keys[place] = job->keys[i];
        job->sorted_values[place] = job->values[i];
    }
}

// Turns counts into places. False where all keys have the same digit: the round would move nothing.
static bool place_digits(const sort_job *job, size_t count, size_t blocks)
{
    size_t sum = 0;
    for (size_t digit = 0; digit < RADIX; digit++) {
        size_t before = sum;
        for (size_t block = 0; block < blocks; block++) {
            size_t here = job->places[block * RADIX + digit];
            job->places[block * RADIX + digit] = sum;
            sum += here;
        }
        if (sum - before == count) {
            return false;
        }
    }
    return true;
}

static void swap_arrays(sort_job *job)
{
    const uint64_t *keys = job->sorted_keys;
    const uint32_t *values = job->sorted_values;
    job->sorted_keys = (uint64_t *)job->keys;
    job->sorted_values = (uint32_t *)job->values;
    job->keys = keys;
    job->values = values;
}

clast_status clast_sort_pairs(clast_context *context, uint64_t *keys, uint32_t *values, size_t count)
{
    size_t blocks = (count + SORT_BLOCK - 1) / SORT_BLOCK;
    uint64_t *other_keys = clast_allocate(context, count, sizeof *other_keys);
    uint32_t *other_values = clast_allocate(context, count, sizeof *other_values);
    size_t *places = clast_allocate(context, blocks, RADIX * sizeof *places);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (other_keys != NULL && other_values != NULL && places != NULL) {
        sort_job job = {keys, values, other_keys, other_values, places, 0};
        for (; job.shift < 64; job.shift += RADIX_BITS) {
            clast_parallel_for(context, count, SORT_BLOCK, count_digits, &job);
            if (place_digits(&job, count, blocks)) {
                clast_parallel_for(context, count, SORT_BLOCK, scatter, &job);
                swap_arrays(&job);
            }
        }
        if (job.keys != keys) {
            memcpy(keys, job.keys, count * sizeof *keys);
            memcpy(values, job.values, count * sizeof *values);
        }
        status = CLAST_OK;
    }
    clast_free(context, other_keys);
    clast_free(context, other_values);
    clast_free(context, places);
    return status;
}
