// SPDX-License-Identifier: Apache-2.0
// What took long to cook, in files of a folder, one for each key: a cache on disk. A file that is damaged, or no cache file, is
// not believed: it is made anew.
#ifndef CLAST_COOK_CACHE_H
#define CLAST_COOK_CACHE_H

#include "source/source.h"

// A cache of files in a folder, which is made when something is kept first. Both outlive the cache.
typedef struct clast_file_cache {
    clast_context *context;
    const char *folder;
} clast_file_cache;

// The hooks for sources. Safe to call from one thread at a time.
clast_cook_cache clast_file_cache_hooks(clast_file_cache *cache);

#endif
