// SPDX-License-Identifier: Apache-2.0
// What the programs share that write seeds, in a folder for each target.
#ifndef CLAST_FUZZ_SEEDS_H
#define CLAST_FUZZ_SEEDS_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char *seeds_folder;

static inline void stop(const char *what)
{
    perror(what);
    exit(1);
}

static inline void seeds_begin(const char *folder)
{
    seeds_folder = folder;
    mkdir(folder, 0777);
}

static inline void write_seed(const char *target, const char *name, const void *data, size_t size)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", seeds_folder, target);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/%s/%s", seeds_folder, target, name);
    FILE *file = fopen(path, "wb");
    if (file == NULL || fwrite(data, 1, size, file) != size || fclose(file) != 0) {
        stop(path);
    }
}

#endif
