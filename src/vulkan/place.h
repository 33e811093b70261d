// SPDX-License-Identifier: Apache-2.0
// Placements of trees, and boxes around them, made on the device.
#ifndef CLAST_VULKAN_PLACE_H
#define CLAST_VULKAN_PLACE_H

#include "vulkan/gpu.h"

// Addresses in the device's memory.
typedef struct clast_gpu_place {
    uint64_t maps;       // clast_device_map: the unit is a number in `trees`
    uint64_t trees;      // clast_device_tree
    uint64_t placements; // gets clast_device_placement
    uint64_t boxes;      // gets the clast_box of each
    uint32_t count;
} clast_gpu_place;

void clast_gpu_place_instances(clast_gpu_commands *commands, const clast_gpu_place *place);

#endif
