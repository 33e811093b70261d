// SPDX-License-Identifier: Apache-2.0
// A frame's triangles in the driver's own acceleration structures, in place of clast's trees, and light paths through them.
#ifndef CLAST_VULKAN_FRAME_DRIVER_H
#define CLAST_VULKAN_FRAME_DRIVER_H

#include "frame/frame.h"
#include "vulkan/driver.h"

typedef struct clast_frame_driver clast_frame_driver;

// UNSUPPORTED where the device has no ray tracing pipeline, or was not opened for it.
clast_status clast_frame_driver_create(clast_gpu *gpu, clast_frame_driver **driver);
void clast_frame_driver_destroy(clast_frame_driver *driver);

// Record what builds the structures of units that changed, and the one over instances: passes blas and tlas. The frame's
// clusters are fitted before, and its instances known.
clast_status clast_frame_driver_build_units(clast_frame *frame, clast_gpu_commands *commands);
clast_status clast_frame_driver_build_scene(clast_frame *frame, clast_gpu_commands *commands);
// Where the clast_driver_top lies that rays go through.
uint64_t clast_frame_driver_scene(const clast_frame_driver *driver);
// Bytes of the device's memory.
uint64_t clast_frame_driver_bytes(const clast_frame_driver *driver);

// Runs a kernel that traces rays, by its shader for clast's own trees, as a launch: of so many numbers.
void clast_frame_driver_trace(const clast_frame_driver *driver, clast_gpu_commands *commands, clast_shader shader,
                              const void *push, uint32_t push_bytes, uint32_t count);

#endif
