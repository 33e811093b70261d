// SPDX-License-Identifier: Apache-2.0
#include "generate/outputs.h"

#include <stdio.h>
#include <string.h>

void clast_outputs_begin(clast_outputs *outputs, clast_context *context, const char *folder)
{
    *outputs = (clast_outputs){.context = context, .folder = folder};
}

void clast_outputs_note(clast_outputs *outputs, clast_status status)
{
    if (outputs->status == CLAST_OK) {
        outputs->status = status;
    }
}

clast_file_output *clast_outputs_open(clast_outputs *outputs, const char *name)
{
    if (outputs->status != CLAST_OK) {
        return NULL;
    }
    if (outputs->count == CLAST_OUTPUTS_MOST) {
        clast_outputs_note(outputs, clast_fail(outputs->context, CLAST_ERROR_LIMIT,
                                               "%s: more than %d files of one scene", name, CLAST_OUTPUTS_MOST));
        return NULL;
    }
    size_t size = strlen(outputs->folder) + strlen(name) + 2;
    char *path = clast_allocate(outputs->context, size, 1);
    if (path == NULL) {
        clast_outputs_note(outputs, CLAST_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    snprintf(path, size, "%s/%s", outputs->folder, name);
    clast_file_output *file = &outputs->files[outputs->count];
    clast_status status = clast_file_create(outputs->context, path, file);
    if (status != CLAST_OK) {
        clast_free(outputs->context, path);
        clast_outputs_note(outputs, status);
        return NULL;
    }
    outputs->paths[outputs->count++] = path;
    return file;
}

static void end(clast_outputs *outputs)
{
    for (uint32_t i = 0; i < outputs->count; i++) {
        clast_free(outputs->context, outputs->paths[i]);
    }
    outputs->count = 0;
}

clast_status clast_outputs_commit(clast_outputs *outputs)
{
    for (uint32_t i = 0; i < outputs->count; i++) {
        clast_outputs_note(outputs, outputs->files[i].status);
    }
    for (uint32_t i = 0; i < outputs->count; i++) {
        if (outputs->status == CLAST_OK) {
            clast_outputs_note(outputs, clast_file_commit(&outputs->files[i]));
        } else {
            clast_file_discard(&outputs->files[i]);
        }
    }
    end(outputs);
    return outputs->status;
}

void clast_outputs_discard(clast_outputs *outputs)
{
    for (uint32_t i = 0; i < outputs->count; i++) {
        clast_file_discard(&outputs->files[i]);
    }
    end(outputs);
}
