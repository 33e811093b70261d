// SPDX-License-Identifier: Apache-2.0
// What every part of clast takes from a context: memory with accounting, errors, log, progress.
#ifndef CLAST_BASE_CONTEXT_H
#define CLAST_BASE_CONTEXT_H

#include <stdarg.h>
#include <stdatomic.h>

#include "clast/context.h"

#if defined(__GNUC__)
#define CLAST_PRINTF(text, rest) __attribute__((format(printf, text, rest)))
#else
#define CLAST_PRINTF(text, rest)
#endif

struct clast_pool; // base/thread.h

// Records an error's text and returns `status`, so that a function can end with `return clast_fail(...)`.
clast_status clast_fail(clast_context *context, clast_status status, const char *format, ...) CLAST_PRINTF(3, 4);

// Sends a line to the log hook, if there is one.
void clast_log(clast_context *context, clast_log_level level, const char *format, ...) CLAST_PRINTF(3, 4);

// Reports progress; gives CLAST_ERROR_CANCELLED (and its text) where the hook asks to stop. Only from the calling thread.
clast_status clast_progress(clast_context *context, const char *stage, uint64_t done, uint64_t total);

// Memory of `count` elements of `size` bytes, aligned to 64 bytes. The product is checked. Null where memory ran out or
// the limit was reached: the error is recorded then, and the caller returns CLAST_ERROR_OUT_OF_MEMORY. A count of zero
// gives a block that can be freed and not read.
void *clast_allocate(clast_context *context, size_t count, size_t size);
void *clast_allocate_zeroed(clast_context *context, size_t count, size_t size);

// Grows or shrinks a block from clast_allocate, keeping its contents; on failure the old block stays valid.
void *clast_reallocate(clast_context *context, void *pointer, size_t count, size_t size);
void clast_free(clast_context *context, void *pointer);

// Counts memory that was had elsewhere; false where the limit would be passed. What was claimed is returned.
bool clast_context_claim(clast_context *context, uint64_t bytes);
void clast_context_return(clast_context *context, uint64_t bytes);

// A copy of a text, or null where memory ran out.
char *clast_copy_text(clast_context *context, const char *text);

// Makes `*array` hold at least `wanted` elements, doubling, so that appending is linear in sum.
clast_status clast_array_reserve(clast_context *context, void **array, size_t *capacity, size_t wanted, size_t size);
#define CLAST_RESERVE(context, array, capacity, wanted) \
    clast_array_reserve(context, (void **)&(array), &(capacity), wanted, sizeof *(array))

struct clast_pool *clast_context_pool(clast_context *context);
const clast_file_hook *clast_context_files(const clast_context *context);
// Null where there is none.
const char *clast_context_cache_folder(const clast_context *context);
// Of bytes; 0 is none. For memory that is not the processor's, of which as much may be held.
uint64_t clast_context_memory_limit(const clast_context *context);

#endif
