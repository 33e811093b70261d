// SPDX-License-Identifier: Apache-2.0
// What surfaces are made of, on a device: a scene's materials, the pictures that their textures show, and the tables that
// shading reads (render/texture.h, render/scatter.h).
#ifndef CLAST_VULKAN_MATERIALS_H
#define CLAST_VULKAN_MATERIALS_H

#include "vulkan/pictures.h"

typedef struct clast_gpu_materials {
    clast_gpu *gpu; // to begin with, this and that of `pictures` alone
    clast_gpu_pictures pictures;
    clast_gpu_buffer head; // clast_device_materials: what kernels are handed the address of
    clast_gpu_buffer records, tables;
    clast_device_image surroundings; // the picture of these
    bool made;
    uint32_t version; // of the scene's materials that were made
    uint32_t surroundings_image;
} clast_gpu_materials;

// Makes them those that the scene has now, of which it uploads what has changed. It is always the same scene. `surroundings` is
// the number of the image that surrounds it, CLAST_NONE for none. Where this or the commands fail, free them.
clast_status clast_gpu_materials_update(clast_gpu_materials *materials, clast_gpu_commands *commands,
                                        const clast_scene *scene, uint32_t surroundings);
void clast_gpu_materials_free(clast_gpu_materials *materials);

#endif
