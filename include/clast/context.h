/* SPDX-License-Identifier: Apache-2.0
 *
 * A context holds what all other objects share: hooks, worker threads, memory accounting and the last error.
 */
#ifndef CLAST_CONTEXT_H
#define CLAST_CONTEXT_H

#include "clast/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A context; opaque. May be used from any thread. Two calls may run at the same time when they concern different
 *  objects made from it. */
typedef struct clast_context clast_context;

/** Memory for clast's own use. `reallocate` works as realloc does: `pointer` null allocates, `new_size` 0 frees and
 *  returns null. Sizes are in bytes; results are aligned to 16 bytes at least. Returns null where memory ran out; the
 *  old block stays valid then. May be called from several threads at once. */
typedef struct clast_memory_hook {
    void *(*reallocate)(void *user, void *pointer, size_t old_size, size_t new_size);
    void *user;
} clast_memory_hook;

/** A whole file's bytes, readable until it is unmapped. */
typedef struct clast_file_view {
    const void *data;
    uint64_t size;
    void *handle; /**< the hook's own */
} clast_file_view;

/** Files. `map` makes a file's bytes readable and returns CLAST_OK, CLAST_ERROR_FILE_NOT_FOUND, CLAST_ERROR_FILE_READ or
 *  CLAST_ERROR_OUT_OF_MEMORY; the bytes must not change until `unmap`. `create` begins an output file and returns a handle in
 *  `*file`; nothing appears under `path` before `commit`, which makes it durable and visible at once; `discard` gives the
 *  output up. `write` appends. */
typedef struct clast_file_hook {
    clast_status (*map)(void *user, const char *path, clast_file_view *view);
    void (*unmap)(void *user, clast_file_view *view);
    clast_status (*create)(void *user, const char *path, void **file);
    clast_status (*write)(void *user, void *file, const void *data, size_t size);
    clast_status (*commit)(void *user, void *file);
    void (*discard)(void *user, void *file);
    void *user;
} clast_file_hook;

/** Lines for a person to read: `text` has no line end and is valid during the call only. */
typedef struct clast_log_hook {
    void (*log)(void *user, clast_log_level level, const char *text);
    void *user;
} clast_log_hook;

/** Called now and then by long work, from the thread that called clast: `stage` names what is done ("render"), `done`
 *  of `total` units of it are. Return false to stop: the call under way then ends with CLAST_ERROR_CANCELLED. */
typedef struct clast_progress_hook {
    bool (*progress)(void *user, const char *stage, uint64_t done, uint64_t total);
    void *user;
} clast_progress_hook;

/** What a context is made from. All zero gives: the C library's memory, the machine's files, no log, no progress, a
 *  thread for each processor, no memory limit, the best instruction set of the machine. */
typedef struct clast_context_desc {
    clast_memory_hook memory;
    clast_file_hook file; /**< all members or none */
    clast_log_hook log;
    clast_progress_hook progress;
    uint32_t threads;      /**< 1 to 1024; 0 is one for each processor that the process may use */
    uint64_t memory_limit; /**< bytes that clast may hold at a time, and as many of a device's memory; 0 is no limit */
    clast_isa isa;         /**< refused where the machine lacks it */
    /** Where what took long to cook is kept for the next run, in files; null is nowhere. Copied. */
    const char *cache_folder;
} clast_context_desc;

/** Makes a context. `desc` may be null, for all defaults.
 *  Errors: INVALID_ARGUMENT, OUT_OF_MEMORY, THREAD, DEVICE (the machine lacks the instruction set). */
CLAST_API clast_status clast_context_create(const clast_context_desc *desc, clast_context **context);

/** Ends a context. Everything made from it must have been destroyed. Null is allowed. */
CLAST_API void clast_context_destroy(clast_context *context);

/** The text of the newest error of this context: one line that says what failed, where, and what was expected. An empty
 *  text where none failed. Valid until the next call that fails. */
CLAST_API const char *clast_context_error(const clast_context *context);

/** Bytes that clast holds now, and the most it has held. */
CLAST_API uint64_t clast_context_memory(const clast_context *context);
CLAST_API uint64_t clast_context_memory_peak(const clast_context *context);

/** The instruction set and the number of threads in use. */
CLAST_API clast_isa clast_context_isa(const clast_context *context);
CLAST_API uint32_t clast_context_threads(const clast_context *context);

#ifdef __cplusplus
}
#endif

#endif
