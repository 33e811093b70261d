// SPDX-License-Identifier: Apache-2.0
// A worker pool with deterministic splits: what each chunk covers depends on the count and the grain only, never on the
// number of threads or on timing.
#ifndef CLAST_BASE_THREAD_H
#define CLAST_BASE_THREAD_H

#include "base/context.h"

enum { CLAST_THREADS_MOST = 1024 };

// Elements [begin, end). `worker` is below clast_worker_count() and unique among those running at the same time for one
// call of clast_parallel_for: an index for scratch memory.
typedef void (*clast_range_function)(void *data, size_t begin, size_t end, uint32_t worker);

// Calls `function` for [0, count) in chunks of `grain` elements (0 gives 1), on all threads, and returns when all is
// done. Called from inside such a function, or while another thread's call is under way, it runs on the calling thread.
void clast_parallel_for(clast_context *context, size_t count, size_t grain, clast_range_function function, void *data);

// How many different `worker` numbers there are; at least 1.
uint32_t clast_worker_count(const clast_context *context);

// Replaces values[i] by the sum of those before it, and gives the sum of all. False where a sum passes UINT32_MAX; the
// values are undefined then.
bool clast_exclusive_scan(clast_context *context, uint32_t *values, size_t count, uint32_t *total);

// Sorts pairs by key, stable, by radix: the order of equal keys is kept. Needs scratch memory of the same size.
clast_status clast_sort_pairs(clast_context *context, uint64_t *keys, uint32_t *values, size_t count);

// For base/context.c.
clast_status clast_pool_create(clast_context *context, uint32_t threads, struct clast_pool **pool);
void clast_pool_destroy(clast_context *context, struct clast_pool *pool);
uint32_t clast_processor_count(void);

// Seconds from a clock that only goes forwards.
double clast_clock(void);

// The most memory that the process has held, in bytes; 0 where the system does not tell.
uint64_t clast_process_memory_peak(void);

#endif
