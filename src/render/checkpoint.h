// SPDX-License-Identifier: Apache-2.0
// Checkpoints: files of what a render has come to, from which it goes on as if it had not been interrupted.
#ifndef CLAST_RENDER_CHECKPOINT_H
#define CLAST_RENDER_CHECKPOINT_H

#include "render/render.h"

#define CLAST_COUNT_SETTING(...) +1
enum {
    CLAST_SETTING_COUNT = CLAST_RENDER_SETTING_LIST(CLAST_COUNT_SETTING, CLAST_COUNT_SETTING, CLAST_COUNT_SETTING,
                                                    CLAST_COUNT_SETTING)
};
extern const char *const clast_setting_names[CLAST_SETTING_COUNT];

// identity.c: numbers that are others where what decides a picture is other.
clast_status clast_scene_identity(const clast_frame *frame, uint64_t *identity);
uint64_t clast_camera_identity(const clast_frame *frame);
void clast_settings_identity(const clast_render_settings *settings, uint64_t numbers[CLAST_SETTING_COUNT]);

// Where a render's checkpoint is, and what the file must be of.
typedef struct clast_checkpoint_keeper {
    clast_checkpoint files;
    const char *device;     // that makes the picture
    uint64_t scene, camera; // as they were before the shutter moved them
    double saved;           // clast_clock() when the last was written
    bool failed;            // the last could not be
} clast_checkpoint_keeper;

// Finds out what decides the picture; where there is a file to go on from, fills the target's sums, squares and sample. Every
// way in which the file is not one of this picture is an error that says so.
clast_status clast_checkpoint_begin(const clast_frame *frame, clast_checkpoint_keeper *keeper,
                                    clast_render_target *target);
// Writes the file. The sums are the target's.
clast_status clast_checkpoint_save(const clast_frame *frame, clast_checkpoint_keeper *keeper,
                                   const clast_render_target *target);

#endif
