// SPDX-License-Identifier: Apache-2.0
// A scene's images on a device, each once, and only those that something asks for.
#ifndef CLAST_VULKAN_PICTURES_H
#define CLAST_VULKAN_PICTURES_H

#include "scene/scene.h"
#include "shared/device_materials.h"
#include "vulkan/gpu.h"

// An image, and its levels by what its values mean; texture CLAST_NONE where that has not been asked for, or is not there.
typedef struct clast_gpu_levels {
    clast_device_image finest;
    clast_device_image levels[ENCODINGS];
} clast_gpu_levels;

typedef struct clast_gpu_pictures {
    clast_gpu *gpu;           // to begin with, this alone
    clast_gpu_levels *images; // by the scene's number
    size_t count, capacity;
    bool has_16_bits;         // one of them
    clast_gpu_buffer *blocks; // of compressed ones
    size_t block_count, block_capacity;
} clast_gpu_pictures;

// How an image of the scene is read on the device; it is uploaded where it has not been yet. An empty one is no texture. LIMIT
// where it has more texels a side than the device allows. Where this or the commands fail, free the pictures.
clast_status clast_gpu_pictures_need(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                     const clast_scene *scene, uint32_t number, clast_device_image *image);
// The same of the levels below it, of which the finest is the first; `count` of them. None where the scene has none yet.
clast_status clast_gpu_pictures_need_levels(clast_gpu_pictures *pictures, clast_gpu_commands *commands,
                                            const clast_scene *scene, uint32_t number, uint32_t encoding,
                                            clast_device_image *levels, uint32_t *count);
// What is read of them from then on is undefined.
void clast_gpu_pictures_free(clast_gpu_pictures *pictures);

#endif
