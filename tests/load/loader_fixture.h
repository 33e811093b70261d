// SPDX-License-Identifier: Apache-2.0
// What the tests of text and image loaders share: a context over files in memory whose allocations can be made to fail, and
// the scene of the last load.
#ifndef CLAST_TESTS_LOAD_LOADER_FIXTURE_H
#define CLAST_TESTS_LOAD_LOADER_FIXTURE_H

#include <math.h>
#include <string.h>

#include "test.h"

#include "load/load.h"
#include "memory_files.h"

typedef struct fixture {
    clast_context *context;
    memory_files files;
    clast_scene *scene;
    char log[8192];   // lines of the last load
    long blocks_left; // allocations until one fails; negative: none fails
    uint64_t memory_before;
} fixture;

static inline void fixture_log(void *user, clast_log_level level, const char *text)
{
    (void)level;
    fixture *f = user;
    size_t length = strlen(f->log);
    snprintf(f->log + length, sizeof f->log - length, "%s\n", text);
}

static inline void *fixture_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)old_size;
    fixture *f = user;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    if (f->blocks_left == 0) {
        return NULL;
    }
    f->blocks_left -= f->blocks_left > 0;
    return realloc(pointer, new_size);
}

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return -1;
    }
    f->blocks_left = -1;
    clast_context_desc desc = {.threads = 1, .log = {fixture_log, f}, .memory = {fixture_reallocate, f}};
    desc.file = memory_files_hook(&f->files);
    if (clast_context_create(&desc, &f->context) != CLAST_OK) {
        return -1;
    }
    f->memory_before = clast_context_memory(f->context);
    *state = f;
    return 0;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    clast_scene_destroy(f->scene);
    uint64_t left = clast_context_memory(f->context) - f->memory_before;
    int mapped = f->files.mapped;
    clast_context_destroy(f->context);
    free(f);
    if (left != 0 || mapped != 0) {
        fprintf(stderr, "%llu bytes and %d mappings left over\n", (unsigned long long)left, mapped);
        return -1;
    }
    return 0;
}

#define LOADER_TEST(function) cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

static inline void put_text(fixture *f, const char *name, const char *text)
{
    memory_files_put(&f->files, name, text, strlen(text));
}

static inline clast_status load(fixture *f, const char *name)
{
    clast_scene_destroy(f->scene);
    f->scene = NULL;
    f->log[0] = '\0';
    return clast_scene_load(f->context, name, &f->scene);
}

static inline void assert_loads(fixture *f, const char *name, const char *text)
{
    put_text(f, name, text);
    assert_ok(f->context, load(f, name));
}

// Refused with that status, by one line that begins with the file's name and contains `words`.
static inline void assert_refused(fixture *f, const char *name, const char *text, clast_status expected,
                                  const char *words)
{
    put_text(f, name, text);
    clast_status status = load(f, name);
    const char *error = clast_context_error(f->context);
    if (status != expected || strstr(error, words) == NULL || strncmp(error, name, strlen(name)) != 0 ||
        strchr(error, '\n') != NULL) {
        fail_msg("expected \"%s\" with \"%s\", got \"%s\" with \"%s\"", clast_status_text(expected), words,
                 clast_status_text(status), status != CLAST_OK ? error : "");
    }
}

static inline const clast_mesh *mesh_of(const fixture *f, size_t geometry)
{
    assert_true(geometry < f->scene->geometry_count);
    return &f->scene->geometries[geometry].of.mesh;
}

static inline void assert_floats(const float *got, const float *expected, size_t count, double tolerance)
{
    assert_non_null(got);
    for (size_t i = 0; i < count; i++) {
        if (!(fabs((double)got[i] - (double)expected[i]) <= tolerance)) {
            fail_msg("element %zu is %.9g, expected %.9g", i, (double)got[i], (double)expected[i]);
        }
    }
}
#define ASSERT_FLOATS(got, tolerance, ...) \
    assert_floats(got, (const float[]){__VA_ARGS__}, sizeof((const float[]){__VA_ARGS__}) / sizeof(float), tolerance)

static inline void assert_indices(const uint32_t *got, const uint32_t *expected, size_t count)
{
    assert_non_null(got);
    for (size_t i = 0; i < count; i++) {
        if (got[i] != expected[i]) {
            fail_msg("element %zu is %u, expected %u", i, got[i], expected[i]);
        }
    }
}
#define ASSERT_INDICES(got, ...) \
    assert_indices(got, (const uint32_t[]){__VA_ARGS__}, sizeof((const uint32_t[]){__VA_ARGS__}) / sizeof(uint32_t))

// Loads every beginning of a file, and the file with bytes changed at random: whatever comes, no crash, and the teardown
// finds nothing left over.
static inline void load_broken(fixture *f, const char *name, const void *data, size_t size, uint32_t changes)
{
    unsigned char *copy = malloc(size + 1);
    assert_non_null(copy);
    memcpy(copy, data, size);
    for (size_t length = 0; length < size; length++) {
        memory_files_put(&f->files, name, copy, length);
        load(f, name);
    }
    uint32_t random = 12345;
    for (uint32_t i = 0; i < changes; i++) {
        memcpy(copy, data, size);
        for (uint32_t k = 0; k <= i % 3; k++) {
            random = random * 1664525u + 1013904223u;
            size_t at = (random >> 8) % size;
            random = random * 1664525u + 1013904223u;
            copy[at] = (unsigned char)(random >> 24);
        }
        memory_files_put(&f->files, name, copy, size);
        load(f, name);
    }
    memory_files_put(&f->files, name, "", 0);
    free(copy);
}

// Loads with each allocation failing in turn, until one load gets through.
static inline void load_without_memory(fixture *f, const char *name)
{
    assert_ok(f->context, load(f, name));
    clast_scene_destroy(f->scene);
    f->scene = NULL;
    for (long blocks = 0;; blocks++) {
        f->blocks_left = blocks;
        clast_status status = load(f, name);
        f->blocks_left = -1;
        if (status == CLAST_OK) {
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
        assert_int_equal(clast_context_memory(f->context), f->memory_before);
    }
}

#endif
