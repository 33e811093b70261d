// SPDX-License-Identifier: Apache-2.0
// A renderer, as the files of this folder see it.
#ifndef CLAST_API_RENDERER_H
#define CLAST_API_RENDERER_H

#include "render/render.h"
#include "vulkan/frame.h"

struct clast_renderer {
    clast_context *context;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;    // the processor's
    bool is_device_chosen; // for the next three
    uint32_t device;       // CLAST_DEVICE_
    uint32_t accel;        // CLAST_ACCEL_
    char *device_name;
    char *shader_folder;
    clast_gpu *gpu;            // null where the processor makes pictures
    clast_frame *device_frame; // what the device makes, of pictures only; null likewise
    clast_vulkan_frame *vulkan_frame;
    bool is_committed;              // rays may be traced, where the next is the scene's
    uint32_t position_version;      // of the scene, when it was committed
    clast_pattern_table **patterns; // read for settings.patterns; units may point to any of them
    size_t pattern_count, pattern_capacity;
    char *patterns_path;        // of the last of them; null where the library's own are in use
    char *environment_path;     // the image that settings.env named last; null where none
    uint32_t environment_image; // its number in the scene
};

// Gives the scene the environment of a render: settings->env, or its own, or, where it is dark, a sky. The frame's emitters
// are known. What the scene had is put back by clast_environment_end.
typedef struct clast_kept_environment {
    clast_environment environment;
    bool was_there;
} clast_kept_environment;

clast_status clast_environment_begin(clast_renderer *renderer, const clast_render_settings *settings,
                                     clast_kept_environment *kept);
void clast_environment_end(clast_renderer *renderer, const clast_kept_environment *kept);

// device.c: opens the device that a picture is wanted from, unless it is open.
clast_status clast_choose_device(clast_renderer *renderer, const clast_render_settings *settings);
void clast_forget_device(clast_renderer *renderer);
// Of the picture that is made now, or was made last: its frame, and what runs the passes.
clast_frame *clast_picture_frame(const clast_renderer *renderer);
const clast_backend *clast_picture_backend(const clast_renderer *renderer);
void clast_collect_device(const clast_renderer *renderer, clast_render_statistics *statistics);

// patterns.c: has triangles cut by the table that settings.patterns names.
clast_status clast_use_patterns(clast_renderer *renderer, const clast_render_settings *settings);
void clast_free_patterns(clast_renderer *renderer);

// statistics.c: what a committed frame takes; adds nothing that a render alone knows.
void clast_collect_statistics(const clast_renderer *renderer, const clast_frame *frame,
                              clast_render_statistics *statistics);

#endif
