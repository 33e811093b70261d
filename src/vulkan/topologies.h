// SPDX-License-Identifier: Apache-2.0
// A template set as a device has it: clast_device_template by number, and the pairs and corners that these point to. Sets only grow, and so
// does this: pairs never move.
#ifndef CLAST_VULKAN_TOPOLOGIES_H
#define CLAST_VULKAN_TOPOLOGIES_H

#include "accel/structures.h"
#include "shared/cluster.h"
#include "vulkan/gpu.h"

// All zero is an empty one.
typedef struct clast_topologies {
    const clast_template_set *set;
    uint32_t count;             // templates that the device has
    clast_gpu_buffer templates; // clast_device_template of each
    clast_gpu_buffer *pairs;    // one for each time that some were added
    size_t pair_buffers, pair_capacity;
    clast_device_template *records; // what `templates` holds
    size_t record_capacity;
} clast_topologies;

// Brings the device's up to the set's. Another set than before replaces what was there. The commands need a barrier before what
// uses it, and must not have used it before. Where it fails, what was there stays right. Freed before the set is destroyed.
clast_status clast_topologies_update(clast_topologies *topologies, clast_gpu_commands *commands,
                                     const clast_template_set *set);
void clast_topologies_free(clast_gpu *gpu, clast_topologies *topologies);

#endif
