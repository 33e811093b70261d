// SPDX-License-Identifier: Apache-2.0
// Temporary folders for tests that write scenes, and what lies in them.
#ifndef CLAST_TESTS_GENERATE_FOLDER_H
#define CLAST_TESTS_GENERATE_FOLDER_H

#include <dirent.h>
#include <string.h>
#include <unistd.h>

#include "test.h"

typedef struct folder {
    char path[64];
} folder;

static inline folder folder_make(void)
{
    folder made = {"/tmp/clast_generate_XXXXXX"};
    assert_non_null(mkdtemp(made.path));
    return made;
}

static inline void folder_file(const folder *folder, const char *name, char path[512])
{
    snprintf(path, 512, "%s/%s", folder->path, name);
}

// Calls `visit` (where not null) for each file; gives how many there are.
static inline uint32_t folder_each(const folder *folder, void (*visit)(const char *path, const char *name, void *data),
                                   void *data)
{
    DIR *directory = opendir(folder->path);
    assert_non_null(directory);
    uint32_t count = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0) {
            continue;
        }
        char path[512];
        folder_file(folder, entry->d_name, path);
        count++;
        if (visit != NULL) {
            visit(path, entry->d_name, data);
        }
    }
    closedir(directory);
    return count;
}

static inline void folder_remove_file(const char *path, const char *name, void *data)
{
    (void)name, (void)data;
    unlink(path);
}

static inline void folder_remove(const folder *folder)
{
    folder_each(folder, folder_remove_file, NULL);
    rmdir(folder->path);
}

static inline unsigned char *read_whole(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        fail_msg("%s cannot be read", path);
    }
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    unsigned char *data = malloc(*size + 1);
    assert_non_null(data);
    assert_int_equal(fread(data, 1, *size, file), *size);
    data[*size] = '\0';
    fclose(file);
    return data;
}

#endif
