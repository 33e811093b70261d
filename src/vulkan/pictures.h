// SPDX-License-Identifier: Apache-2.0
// A scene's images on a device, each once, and only those that something asks for.
#ifndef CLAST_VULKAN_PICTURES_H
#define CLAST_VULKAN_PICTURES_H

#include "scene/scene.h"
#include "shared/device_materials.h"
#include "vulkan/gpu.h"

typedef struct clast_gpu_pictures {
    clast_gpu *gpu;             // to begin with, this alone
    clast_device_image *images; // by the scene's number; texture CLAST_NONE where it has not been asked for
    size_t count, capacity;
    bool has_16_bits;         // one of them
    clast_gpu_buffer *blocks; // of compressed ones
    size_t block_count, block_capacity;
} clast_gpu_pictures;

// How an image of the scene is read on the device; it is uploaded where it has not been yet. An empty one is no texture. LIMIT
// where it has more texels a side than the device allows. Where this or the commands fail, free the pictures.
clast_status clast_gpu_pictures_need(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                     const clast_scene *scene, uint32_t number, clast_device_image *image);
// What is read of them from then on is undefined.
void clast_gpu_pictures_free(clast_gpu_pictures *pictures);

#endif
