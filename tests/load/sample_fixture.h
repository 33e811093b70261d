// SPDX-License-Identifier: Apache-2.0
// The samples as files of a context, any of which can be replaced; and what a load of a changed one may come to.
#ifndef CLAST_TESTS_LOAD_SAMPLE_FIXTURE_H
#define CLAST_TESTS_LOAD_SAMPLE_FIXTURE_H

#include "test.h"

#include "load/load.h"
#include "load/memory_files.h"
#include "load/samples.h"

typedef struct sample_fixture {
    clast_context *context;
    memory_files files;
    samples all;
    uint64_t memory_before;
} sample_fixture;

static inline sample_fixture *sample_fixture_make(void)
{
    sample_fixture *f = calloc(1, sizeof *f);
    assert_non_null(f);
    f->all = samples_make();
    for (size_t i = 0; i < f->all.count; i++) {
        memory_files_put(&f->files, f->all.list[i].name, f->all.list[i].data, f->all.list[i].size);
    }
    clast_context_desc desc = {.threads = 1, .file = memory_files_hook(&f->files)};
    assert_int_equal(clast_context_create(&desc, &f->context), CLAST_OK);
    f->memory_before = clast_context_memory(f->context);
    return f;
}

static inline void sample_fixture_free(sample_fixture *f)
{
    clast_context_destroy(f->context);
    samples_free(&f->all);
    free(f);
}

// Reads a picture, or loads a scene, and lets it go: nothing may be left over.
static inline clast_status read_sample(sample_fixture *f, const char *name, bool is_picture)
{
    clast_status status;
    if (is_picture) {
        clast_image image;
        status = clast_image_read(f->context, name, &image);
        clast_image_free(f->context, &image);
    } else {
        clast_scene *scene = NULL;
        status = clast_scene_load(f->context, name, &scene);
        clast_scene_destroy(scene);
    }
    if (clast_context_memory(f->context) != f->memory_before || f->files.mapped != 0) {
        fail_msg("%s: something is left over", name);
    }
    return status;
}

// What is broken is an error of the file, with one line of text that is about it.
static inline bool is_sound_outcome(const sample_fixture *f, clast_status status)
{
    const char *text = clast_context_error(f->context);
    return status == CLAST_OK || ((status == CLAST_ERROR_MALFORMED || status == CLAST_ERROR_UNSUPPORTED ||
                                   status == CLAST_ERROR_LIMIT || status == CLAST_ERROR_FILE_NOT_FOUND) &&
                                  text[0] != '\0' && strchr(text, '\n') == NULL);
}

#endif
