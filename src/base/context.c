// SPDX-License-Identifier: Apache-2.0
#include "base/context.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "base/file.h"
#include "base/isa.h"
#include "base/size.h"
#include "base/thread.h"

enum {
    ERROR_TEXT_SIZE = 1024,
    BLOCK_ALIGNMENT = 64,
    LARGE_PAGE = 2 << 20,
    LARGE_BLOCK = 1 << 20,
};

struct clast_context {
    clast_context_desc desc;
    char *cache_folder; // a copy
    struct clast_pool *pool;
    pthread_mutex_t error_lock;
    char error[ERROR_TEXT_SIZE];
    atomic_uint_fast64_t memory;
    atomic_uint_fast64_t memory_peak;
};

// Stands before each block, in the BLOCK_ALIGNMENT bytes below the pointer that the caller sees.
typedef struct block_header {
    void *base;       // what the hook gave
    size_t hook_size; // what the hook was asked for
    size_t size;      // what the caller asked for
} block_header;

_Static_assert(sizeof(block_header) <= BLOCK_ALIGNMENT, "the header fits below the block");

// Large blocks ask for large pages: touching memory for the first time costs as much as working through it, page by page.
static void *large_allocate(size_t size)
{
    size_t whole = (size + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE;
    void *pointer = whole >= size ? aligned_alloc(LARGE_PAGE, whole) : NULL;
#ifdef MADV_HUGEPAGE
    if (pointer != NULL) {
        madvise(pointer, whole, MADV_HUGEPAGE); // a wish: where it is not granted, pages are small
    }
#endif
    return pointer;
}

static void *machine_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    return pointer == NULL && new_size >= LARGE_BLOCK ? large_allocate(new_size) : realloc(pointer, new_size);
}

const char *clast_status_text(clast_status status)
{
    switch (status) {
#define CASE(name, value, text) \
    case name: return text;
        CLAST_STATUS_LIST(CASE)
#undef CASE
    }
    return "unknown status";
}

static bool desc_is_valid(const clast_context_desc *desc)
{
    const clast_file_hook *file = &desc->file;
    int members = (file->map != NULL) + (file->unmap != NULL) + (file->create != NULL) + (file->write != NULL) +
                  (file->commit != NULL) + (file->discard != NULL);
    return desc->threads <= CLAST_THREADS_MOST && (members == 0 || members == 6);
}

clast_status clast_context_create(const clast_context_desc *desc, clast_context **context)
{
    static const clast_context_desc defaults;
    desc = desc != NULL ? desc : &defaults;
    if (context == NULL || !desc_is_valid(desc)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *context = NULL;
    clast_context_desc resolved = *desc;
    if (resolved.memory.reallocate == NULL) {
        resolved.memory.reallocate = machine_reallocate;
    }
    if (resolved.file.map == NULL) {
        resolved.file = clast_machine_files;
    }
    if (resolved.isa == CLAST_ISA_AUTOMATIC) {
        resolved.isa = clast_isa_best();
    } else if (resolved.isa > clast_isa_best() || resolved.isa < CLAST_ISA_PLAIN) {
        return CLAST_ERROR_DEVICE;
    }
    if (resolved.threads == 0) {
        resolved.threads = clast_processor_count();
    }
    clast_context *made = resolved.memory.reallocate(resolved.memory.user, NULL, 0, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(made, 0, sizeof *made);
    made->desc = resolved;
    if (pthread_mutex_init(&made->error_lock, NULL) != 0) {
        resolved.memory.reallocate(resolved.memory.user, made, sizeof *made, 0);
        return CLAST_ERROR_THREAD;
    }
    clast_status status = clast_pool_create(made, resolved.threads, &made->pool);
    if (status == CLAST_OK && desc->cache_folder != NULL) {
        made->cache_folder = clast_copy_text(made, desc->cache_folder);
        status = made->cache_folder != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status != CLAST_OK) {
        clast_context_destroy(made);
        return status;
    }
    *context = made;
    return CLAST_OK;
}

void clast_context_destroy(clast_context *context)
{
    if (context == NULL) {
        return;
    }
    if (context->pool != NULL) {
        clast_pool_destroy(context, context->pool);
    }
    clast_free(context, context->cache_folder);
    pthread_mutex_destroy(&context->error_lock);
    clast_memory_hook memory = context->desc.memory;
    memory.reallocate(memory.user, context, sizeof *context, 0);
}

const char *clast_context_error(const clast_context *context)
{
    return context != NULL ? context->error : "";
}

uint64_t clast_context_memory(const clast_context *context)
{
    return atomic_load(&((clast_context *)context)->memory);
}

uint64_t clast_context_memory_peak(const clast_context *context)
{
    return atomic_load(&((clast_context *)context)->memory_peak);
}

clast_isa clast_context_isa(const clast_context *context)
{
    return context->desc.isa;
}

uint32_t clast_context_threads(const clast_context *context)
{
    return context->desc.threads;
}

struct clast_pool *clast_context_pool(clast_context *context)
{
    return context->pool;
}

uint64_t clast_context_memory_limit(const clast_context *context)
{
    return context->desc.memory_limit;
}

const char *clast_context_cache_folder(const clast_context *context)
{
    return context->cache_folder;
}

const clast_file_hook *clast_context_files(const clast_context *context)
{
    return &context->desc.file;
}

// One line, whatever a file's names contain, and nothing that steers a terminal: control characters become spaces, those of
// one byte and those that UTF-8 writes as C2 80 to C2 9F.
static void clean_text(char *text)
{
    for (unsigned char *c = (unsigned char *)text; *c != '\0'; c++) {
        if (c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0) {
            c[0] = c[1] = ' ';
        }
        if (*c < 32 || *c == 127) {
            *c = ' ';
        }
    }
}

clast_status clast_fail(clast_context *context, clast_status status, const char *format, ...)
{
    char text[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    clean_text(text);
    pthread_mutex_lock(&context->error_lock);
    memcpy(context->error, text, sizeof text);
    pthread_mutex_unlock(&context->error_lock);
    return status;
}

void clast_log(clast_context *context, clast_log_level level, const char *format, ...)
{
    if (context->desc.log.log == NULL) {
        return;
    }
    char text[ERROR_TEXT_SIZE];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    clean_text(text);
    context->desc.log.log(context->desc.log.user, level, text);
}

clast_status clast_progress(clast_context *context, const char *stage, uint64_t done, uint64_t total)
{
    const clast_progress_hook *hook = &context->desc.progress;
    if (hook->progress == NULL || hook->progress(hook->user, stage, done, total)) {
        return CLAST_OK;
    }
    return clast_fail(context, CLAST_ERROR_CANCELLED, "%s was cancelled", stage);
}

bool clast_context_claim(clast_context *context, uint64_t size)
{
    uint64_t limit = context->desc.memory_limit;
    uint64_t before = atomic_load(&context->memory);
    do {
        if (size > UINT64_MAX - before || (limit != 0 && before + size > limit)) {
            return false;
        }
    } while (!atomic_compare_exchange_weak(&context->memory, &before, before + size));
    uint64_t peak = atomic_load(&context->memory_peak);
    while (peak < before + size && !atomic_compare_exchange_weak(&context->memory_peak, &peak, before + size)) {
    }
    return true;
}

void clast_context_return(clast_context *context, uint64_t size)
{
    atomic_fetch_sub(&context->memory, size);
}

static clast_status out_of_memory(clast_context *context, size_t count, size_t size)
{
    uint64_t limit = context->desc.memory_limit;
    if (limit != 0) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY,
                          "no memory for %zu elements of %zu bytes within the limit of %llu bytes", count, size,
                          (unsigned long long)limit);
    }
    return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "no memory for %zu elements of %zu bytes", count, size);
}

static block_header *header_of(void *pointer)
{
    return (block_header *)((char *)pointer - BLOCK_ALIGNMENT);
}

void *clast_allocate(clast_context *context, size_t count, size_t size)
{
    size_t bytes, hook_size;
    if (!clast_multiply_size(count, size, &bytes) || !clast_add_size(bytes, 2 * BLOCK_ALIGNMENT, &hook_size) ||
        !clast_context_claim(context, hook_size)) {
        out_of_memory(context, count, size);
        return NULL;
    }
    void *base = context->desc.memory.reallocate(context->desc.memory.user, NULL, 0, hook_size);
    if (base == NULL) {
        clast_context_return(context, hook_size);
        out_of_memory(context, count, size);
        return NULL;
    }
    uintptr_t address = ((uintptr_t)base + 2 * BLOCK_ALIGNMENT - 1) & ~(uintptr_t)(BLOCK_ALIGNMENT - 1);
    void *pointer = (char *)base + (address - (uintptr_t)base);
    *header_of(pointer) = (block_header){base, hook_size, bytes};
    return pointer;
}

void *clast_allocate_zeroed(clast_context *context, size_t count, size_t size)
{
    void *pointer = clast_allocate(context, count, size);
    if (pointer != NULL) {
        memset(pointer, 0, count * size);
    }
    return pointer;
}

void *clast_reallocate(clast_context *context, void *pointer, size_t count, size_t size)
{
    void *moved = clast_allocate(context, count, size);
    if (moved == NULL || pointer == NULL) {
        return moved;
    }
    size_t old_size = header_of(pointer)->size;
    size_t new_size = count * size;
    memcpy(moved, pointer, old_size < new_size ? old_size : new_size);
    clast_free(context, pointer);
    return moved;
}

void clast_free(clast_context *context, void *pointer)
{
    if (pointer == NULL) {
        return;
    }
    block_header header = *header_of(pointer);
    context->desc.memory.reallocate(context->desc.memory.user, header.base, header.hook_size, 0);
    clast_context_return(context, header.hook_size);
}

char *clast_copy_text(clast_context *context, const char *text)
{
    size_t length = strlen(text);
    char *copy = clast_allocate(context, length + 1, 1);
    if (copy != NULL) {
        memcpy(copy, text, length + 1);
    }
    return copy;
}

clast_status clast_array_reserve(clast_context *context, void **array, size_t *capacity, size_t wanted, size_t size)
{
    if (wanted <= *capacity) {
        return CLAST_OK;
    }
    size_t doubled = *capacity > SIZE_MAX / 2 ? SIZE_MAX : *capacity * 2;
    size_t grown = doubled > wanted ? doubled : wanted;
    grown = grown < 8 ? 8 : grown;
    void *moved = clast_reallocate(context, *array, grown, size);
    if (moved == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *array = moved;
    *capacity = grown;
    return CLAST_OK;
}
