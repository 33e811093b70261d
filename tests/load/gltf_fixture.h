// SPDX-License-Identifier: Apache-2.0
// What the glTF reader's tests share: a context over files in memory, and glTF texts written with ' for ".
#ifndef CLAST_TESTS_LOAD_GLTF_FIXTURE_H
#define CLAST_TESTS_LOAD_GLTF_FIXTURE_H

#include <string.h>

#include "test.h"

#include "load/load.h"
#include "memory_files.h"

typedef struct fixture {
    clast_context *context;
    memory_files files;
    clast_scene *scene; // of the last load
    char text[65536];   // of the last load, with "
    char log[8192];     // lines of the last load
} fixture;

static inline void fixture_log(void *user, clast_log_level level, const char *text)
{
    (void)level;
    fixture *f = user;
    size_t length = strlen(f->log);
    snprintf(f->log + length, sizeof f->log - length, "%s\n", text);
}

static inline int fixture_setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    clast_context_desc desc = {.threads = 2, .log = {fixture_log, f}};
    if (f == NULL) {
        return -1;
    }
    desc.file = memory_files_hook(&f->files);
    if (clast_context_create(&desc, &f->context) != CLAST_OK) {
        return -1;
    }
    test_memory_before = clast_context_memory(f->context);
    *state = f;
    return 0;
}

static inline int fixture_teardown(void **state)
{
    fixture *f = *state;
    clast_scene_destroy(f->scene);
    f->scene = NULL;
    uint64_t left = clast_context_memory(f->context) - test_memory_before;
    int mapped = f->files.mapped;
    clast_context_destroy(f->context);
    free(f);
    if (left != 0 || mapped != 0) {
        fprintf(stderr, "%llu bytes and %d mappings left over\n", (unsigned long long)left, mapped);
        return -1;
    }
    return 0;
}

#define GLTF_TEST(function) cmocka_unit_test_setup_teardown(function, fixture_setup, fixture_teardown)

// Loads a file of the fixture; its scene lives until the next load.
static inline clast_status load_file(fixture *f, const char *name)
{
    clast_scene_destroy(f->scene);
    f->scene = NULL;
    f->log[0] = '\0';
    clast_file_view file;
    clast_status status = clast_file_map(f->context, name, &file);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_scene_create(f->context, &f->scene);
    if (status == CLAST_OK) {
        status = clast_load_gltf(f->scene, name, &file);
    }
    clast_file_unmap(f->context, &file);
    return status;
}

static inline clast_status load_text(fixture *f, const char *text)
{
    size_t length = strlen(text);
    assert_true(length < sizeof f->text);
    for (size_t i = 0; i <= length; i++) {
        f->text[i] = text[i] == '\'' ? '"' : text[i];
    }
    memory_files_put(&f->files, "scene.gltf", f->text, length);
    return load_file(f, "scene.gltf");
}

static inline void assert_loads(fixture *f, const char *text)
{
    assert_ok(f->context, load_text(f, text));
}

// Refused with that status, by one line that names the file and contains `words`.
static inline void assert_refused(fixture *f, const char *text, clast_status expected, const char *words)
{
    clast_status status = load_text(f, text);
    const char *error = clast_context_error(f->context);
    if (status != expected || strstr(error, words) == NULL || strncmp(error, "scene.gltf: ", 12) != 0 ||
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

static inline void assert_floats(const float *got, const float *expected, size_t count, float tolerance)
{
    assert_non_null(got);
    for (size_t i = 0; i < count; i++) {
        if (!(got[i] - expected[i] <= tolerance && expected[i] - got[i] <= tolerance)) {
            fail_msg("element %zu is %g, expected %g", i, (double)got[i], (double)expected[i]);
        }
    }
}

static inline void assert_indices(const uint32_t *got, const uint32_t *expected, size_t count)
{
    assert_non_null(got);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(got[i], expected[i]);
    }
}

// Pieces of texts.
#define ASSET "'asset':{'version':'2.0'}"
#define NODE "'scene':0,'scenes':[{'nodes':[0]}],'nodes':[{'mesh':0}]"
#define BUFFER(bytes) "'buffers':[{'uri':'data.bin','byteLength':" #bytes "}]"
// A mesh of one primitive.
#define MESH(members) "'meshes':[{'name':'shape','primitives':[{" members "}]}]"
// A text of one triangle from data.bin, with more members.
#define TRIANGLE_WITH(more) \
    "{" ASSET "," NODE "," BUFFER(36) "," MESH( \
        "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]" more \
                                       "}"

static const float TRIANGLE[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};

static inline void put_triangle(fixture *f)
{
    memory_files_put(&f->files, "data.bin", TRIANGLE, sizeof TRIANGLE);
}

#endif
