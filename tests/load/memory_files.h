// SPDX-License-Identifier: Apache-2.0
// Files in memory, behind a context's file hooks. Each mapping is a block of exactly the file's size, so that the address
// sanitizer sees a read beyond it; mappings that are left over are counted.
#ifndef CLAST_TESTS_LOAD_MEMORY_FILES_H
#define CLAST_TESTS_LOAD_MEMORY_FILES_H

#include <stdlib.h>
#include <string.h>

#include "clast/context.h"

enum { MEMORY_FILES_MOST = 80 };

typedef struct memory_file {
    const char *name;
    const void *data;
    size_t size;
} memory_file;

typedef struct memory_files {
    memory_file files[MEMORY_FILES_MOST];
    size_t count;
    int mapped; // how many mappings there are now
} memory_files;

// Puts a file there, or replaces it. Name and data stay the caller's.
static inline void memory_files_put(memory_files *files, const char *name, const void *data, size_t size)
{
    size_t at = 0;
    while (at < files->count && strcmp(files->files[at].name, name) != 0) {
        at++;
    }
    if (at == MEMORY_FILES_MOST) {
        abort();
    }
    files->files[at] = (memory_file){name, data, size};
    files->count += at == files->count;
}

static inline clast_status memory_files_map(void *user, const char *path, clast_file_view *view)
{
    memory_files *files = user;
    for (size_t i = 0; i < files->count; i++) {
        if (strcmp(files->files[i].name, path) == 0) {
            size_t size = files->files[i].size;
            void *block = malloc(size != 0 ? size : 1);
            if (block == NULL) {
                return CLAST_ERROR_OUT_OF_MEMORY;
            }
            memcpy(block, files->files[i].data, size);
            *view = (clast_file_view){.data = block, .size = size, .handle = block};
            files->mapped++;
            return CLAST_OK;
        }
    }
    return CLAST_ERROR_FILE_NOT_FOUND;
}

static inline void memory_files_unmap(void *user, clast_file_view *view)
{
    memory_files *files = user;
    files->mapped--;
    free(view->handle);
}

static inline clast_status memory_files_create(void *user, const char *path, void **file)
{
    (void)user;
    (void)path;
    *file = NULL;
    return CLAST_ERROR_FILE_WRITE;
}

static inline clast_status memory_files_write(void *user, void *file, const void *data, size_t size)
{
    (void)user;
    (void)file;
    (void)data;
    (void)size;
    return CLAST_ERROR_FILE_WRITE;
}

static inline clast_status memory_files_commit(void *user, void *file)
{
    (void)user;
    (void)file;
    return CLAST_ERROR_FILE_WRITE;
}

static inline void memory_files_discard(void *user, void *file)
{
    (void)user;
    (void)file;
}

static inline clast_file_hook memory_files_hook(memory_files *files)
{
    return (clast_file_hook){
        .map = memory_files_map,
        .unmap = memory_files_unmap,
        .create = memory_files_create,
        .write = memory_files_write,
        .commit = memory_files_commit,
        .discard = memory_files_discard,
        .user = files,
    };
}

#endif
