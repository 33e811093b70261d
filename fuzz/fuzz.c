// SPDX-License-Identifier: Apache-2.0
#include "fuzz.h"

#include "load/memory_files.h"
#include "load/samples.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define MEMORY_MOST ((uint64_t)1 << 30)

static memory_files files;
static uint64_t kept; // of the context, from input to input

void *fuzz_copy(const void *data, size_t size)
{
    void *copy = malloc(size != 0 ? size : 1);
    FUZZ_CHECK(copy != NULL);
    memcpy(copy, data, size);
    return copy;
}

void fuzz_put_file(const char *name, const void *data, size_t size)
{
    memory_files_put(&files, name, data, size);
}

// Short traces of where blocks came from, and few that wait for being used after they are freed: inputs are seconds apart from
// none. ASAN_OPTIONS overrides these, to look at what was found.
const char *__asan_default_options(void);

const char *__asan_default_options(void)
{
    return "malloc_context_size=2:quarantine_size_mb=4:thread_local_quarantine_size_kb=256:detect_stack_use_after_return=0";
}

void fuzz_keep(const clast_context *context)
{
    kept = clast_context_memory(context);
}

// ------------------------------------------------------------------------------------------------------------- targets

// One thread: the same input does the same each time. The samples are beside the input until the process ends.
static clast_context *make_context(void)
{
    clast_context *context = NULL;
    clast_context_desc desc = {.threads = 1, .memory_limit = MEMORY_MOST, .file = memory_files_hook(&files)};
    FUZZ_CHECK(clast_context_create(&desc, &context) == CLAST_OK);
    static samples beside;
    beside = samples_make();
    for (size_t i = 0; i < beside.count; i++) {
        memory_files_put(&files, beside.list[i].name, beside.list[i].data, beside.list[i].size);
    }
    return context;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static clast_context *context;
    if (context == NULL) {
        context = make_context();
        fuzz_keep(context);
    }
    fuzz_one(context, data, size);
    FUZZ_CHECK(clast_context_memory(context) == kept);
    FUZZ_CHECK(files.mapped == 0);
    return 0;
}

// A failure has one line of text, and is none of those that would be our own fault.
void fuzz_check_outcome(clast_context *context, clast_status status)
{
    const char *text = clast_context_error(context);
    FUZZ_CHECK(status != CLAST_ERROR_INVALID_ARGUMENT && status != CLAST_ERROR_STATE && status != CLAST_ERROR_DEVICE);
    FUZZ_CHECK(status == CLAST_OK || (text[0] != '\0' && strchr(text, '\n') == NULL));
}

void fuzz_load(clast_context *context, fuzz_loader *load, const char *name, const uint8_t *data, size_t size)
{
    if (size == 0) {
        return; // the caller of loaders refuses it
    }
    clast_scene *scene;
    clast_file_view file;
    fuzz_put_file(name, data, size);
    FUZZ_CHECK(clast_file_map(context, name, &file) == CLAST_OK);
    FUZZ_CHECK(clast_scene_create(context, &scene) == CLAST_OK);
    fuzz_check_outcome(context, load(scene, name, &file));
    clast_file_unmap(context, &file);
    clast_scene_destroy(scene);
}

void fuzz_decode(clast_context *context, fuzz_decoder *decode, const char *signature, size_t signature_size,
                 const uint8_t *data, size_t size)
{
    if (size < signature_size) {
        return;
    }
    uint8_t *copy = fuzz_copy(data, size);
    memcpy(copy, signature, signature_size);
    clast_image image = {0};
    clast_status status = decode(context, "input", (clast_bytes){copy, size}, &image);
    free(copy);
    fuzz_check_outcome(context, status);
    FUZZ_CHECK((status == CLAST_OK) == (image.pixels != NULL));
    clast_image_free(context, &image);
}
