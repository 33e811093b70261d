// SPDX-License-Identifier: Apache-2.0
// A frame's lights on a device: what render/lights.h made of them, mirrored.
#ifndef CLAST_VULKAN_LIGHTS_H
#define CLAST_VULKAN_LIGHTS_H

#include "render/lights.h"
#include "shared/device_lights.h"
#include "vulkan/gpu.h"

typedef struct clast_gpu_lights {
    clast_gpu *gpu;        // to begin with, this alone
    clast_gpu_buffer head; // clast_device_lights: what kernels are handed the address of
    clast_gpu_buffer tables;
} clast_gpu_lights;

// Uploads the lights of a frame. `image` is the picture of its surroundings on the device; its texture is CLAST_NONE where there
// is none. The commands need a barrier before what uses them.
clast_status clast_gpu_lights_update(clast_gpu_lights *mirror, clast_gpu_commands *commands, const clast_lights *lights,
                                     clast_device_image image);
void clast_gpu_lights_free(clast_gpu_lights *mirror);

#endif
