// SPDX-License-Identifier: Apache-2.0
// Cooked data of a frame's units, and what poses move, as a device has them: each array is uploaded once, and again where its
// version says that it is another one.
#ifndef CLAST_VULKAN_MIRROR_H
#define CLAST_VULKAN_MIRROR_H

#include "frame/frame.h"
#include "vulkan/gpu.h"

typedef struct clast_mirror clast_mirror;

clast_status clast_mirror_create(clast_gpu *gpu, clast_mirror **mirror);
void clast_mirror_destroy(clast_mirror *mirror);

// Before the units of a frame.
clast_status clast_mirror_begin(clast_mirror *mirror, size_t unit_count);
// Uploads what is new of a unit and of its pose, and writes into `record` where it lies, and the pose: what follows in `record`
// is the frame's own. The commands need a barrier before what uses it.
clast_status clast_mirror_unit(clast_mirror *mirror, clast_gpu_commands *commands, size_t number,
                               const clast_frame_unit *unit, clast_device_unit *record);
// After them: frees what no unit of the frame has any more.
void clast_mirror_end(clast_mirror *mirror);

// Frees everything.
void clast_mirror_forget(clast_mirror *mirror);

// Bytes of the device's memory.
uint64_t clast_mirror_bytes(const clast_mirror *mirror);

#endif
