// SPDX-License-Identifier: Apache-2.0
// Files of a cache: a header, then the data. Files appear whole (written beside, made durable, renamed) and are checked whole.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <inttypes.h>
#include <stdio.h>

#include "base/file.h"
#include "cook/cache.h"

// As it lies in the file. Numbers are the machine's: files of others have another signature.
typedef struct cache_header {
    char signature[8];
    uint32_t order, version;
    uint64_t key[2];
    uint64_t size;
    uint64_t checksum; // of all of the header but this, then of the data
} cache_header;

static const char signature[8] = "clastck";
static const uint32_t order_here = 0x01020304;
static const uint32_t version_here = 1;

static uint64_t checksum_of(const cache_header *header, const void *data, size_t size)
{
    return XXH3_64bits_withSeed(data, size, XXH3_64bits(header, offsetof(cache_header, checksum)));
}

static cache_header header_of(clast_cook_key key, const void *data, size_t size)
{
    cache_header header = {
        .order = order_here,
        .version = version_here,
        .key = {key.low, key.high},
        .size = size,
    };
    memcpy(header.signature, signature, sizeof signature);
    header.checksum = checksum_of(&header, data, size);
    return header;
}

static char *path_of(const clast_file_cache *cache, clast_cook_key key)
{
    enum { NAME = 64 };
    size_t length = strlen(cache->folder) + NAME;
    char *path = clast_allocate(cache->context, length, 1);
    if (path != NULL) {
        snprintf(path, length, "%s/%016" PRIx64 "%016" PRIx64 ".cache", cache->folder, key.high, key.low);
    }
    return path;
}

static bool is_sound(const clast_file_view *file, clast_cook_key key, size_t size)
{
    if (file->size != sizeof(cache_header) + size) {
        return false;
    }
    const char *data = (const char *)file->data + sizeof(cache_header);
    cache_header header = header_of(key, data, size);
    return memcmp(&header, file->data, sizeof header) == 0;
}

static bool find(void *user, clast_cook_key key, void *data, size_t size)
{
    const clast_file_cache *cache = user;
    char *path = path_of(cache, key);
    if (path == NULL) {
        return false;
    }
    // not by clast_file_map: that a file is not there is no error
    const clast_file_hook *files = clast_context_files(cache->context);
    clast_file_view file;
    clast_status status = files->map(files->user, path, &file);
    bool found = status == CLAST_OK && is_sound(&file, key, size);
    if (found) {
        memcpy(data, (const char *)file.data + sizeof(cache_header), size);
    } else if (status != CLAST_ERROR_FILE_NOT_FOUND) {
        clast_log(cache->context, CLAST_LOG_WARNING, "%s: not a whole cache file: it is made anew", path);
    }
    if (status == CLAST_OK) {
        files->unmap(files->user, &file);
    }
    clast_free(cache->context, path);
    return found;
}

static void keep(void *user, clast_cook_key key, const void *data, size_t size)
{
    const clast_file_cache *cache = user;
    clast_context *context = cache->context;
    cache_header header = header_of(key, data, size);
    char *path = path_of(cache, key);
    clast_status status = path != NULL ? clast_make_folder(context, cache->folder) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        clast_file_output output;
        status = clast_file_create(context, path, &output);
        if (status == CLAST_OK) {
            clast_file_write(&output, &header, sizeof header);
            clast_file_write(&output, data, size);
            status = clast_file_commit(&output);
        }
    }
    if (status != CLAST_OK) {
        clast_log(context, CLAST_LOG_WARNING, "%s: nothing is kept in the cache: %s", cache->folder,
                  clast_status_text(status));
    }
    clast_free(context, path);
}

clast_cook_cache clast_file_cache_hooks(clast_file_cache *cache)
{
    return (clast_cook_cache){cache, find, keep};
}
