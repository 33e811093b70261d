// SPDX-License-Identifier: Apache-2.0
// A picture file that a render writes: which views it holds, and how they are written.
#ifndef CLAST_APP_PICTURE_H
#define CLAST_APP_PICTURE_H

#include "app/session.h"
#include "clast/image.h"

typedef enum clast_picture_format { CLAST_PICTURE_PNG, CLAST_PICTURE_EXR, CLAST_PICTURE_PFM, CLAST_PICTURE_HDR } clast_picture_format;

typedef struct clast_picture {
    char *path;
    clast_picture_format format;
    clast_render_output outputs[CLAST_VIEW_COUNT_]; // pixels are blocks of clast_allocate
    size_t output_count;
    uint32_t width, height;
    uint64_t hash; // of what was written, set by clast_picture_write
} clast_picture;

// Decides path, format and views from the command line; checks that the format can hold the view and that the file can be
// written, before any work. Prints the error and gives an exit code other than success.
clast_exit clast_picture_plan(clast_session *session, clast_picture *picture);
// Makes room for the pixels.
clast_status clast_picture_allocate(clast_context *context, clast_picture *picture, uint32_t width, uint32_t height);
clast_status clast_picture_write(clast_context *context, clast_picture *picture, const clast_render_settings *settings);
void clast_picture_free(clast_context *context, clast_picture *picture);

#endif
