// SPDX-License-Identifier: Apache-2.0
// A picture file that a render writes: which views it holds, and how they are written.
#ifndef CLAST_APP_OUTPUT_H
#define CLAST_APP_OUTPUT_H

#include "app/session.h"
#include "clast/image.h"

typedef enum clast_output_format {
    CLAST_OUTPUT_PNG,
    CLAST_OUTPUT_EXR,
    CLAST_OUTPUT_PFM,
    CLAST_OUTPUT_HDR,
    CLAST_OUTPUT_JPEG,
} clast_output_format;

typedef struct clast_output {
    char *path;
    clast_output_format format;
    uint32_t bits;                                  // of a channel, where the format has a choice
    clast_render_output outputs[CLAST_VIEW_COUNT_]; // pixels are blocks of clast_allocate
    size_t output_count;
    clast_render_area area; // of the picture, what the file has
    uint32_t width, height; // of the whole picture
    uint64_t hash;          // of what was written, set by clast_output_write
} clast_output;

// Decides path, format and views from the command line; checks that the format can hold the view and that the file can be
// written, before any work. Prints the error and gives an exit code other than success.
clast_exit clast_output_plan(clast_session *session, clast_output *picture);
// The path of a frame's picture: its number in place of %d, as %04d, or with four digits before the extension. A block of
// clast_allocate; null where memory ran out.
char *clast_output_frame_path(clast_context *context, const char *path, uint32_t frame);
// Makes room for the pixels.
clast_status clast_output_allocate(clast_context *context, clast_output *picture, const clast_render_settings *settings,
                                   const clast_render_area *area);
clast_status clast_output_write(clast_context *context, clast_output *picture, const clast_render_settings *settings);
void clast_output_free(clast_context *context, clast_output *picture);

#endif
