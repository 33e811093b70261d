// SPDX-License-Identifier: Apache-2.0
// Sorts keys with values on the device: stable, and the same whatever the device.
#ifndef CLAST_VULKAN_SORT_H
#define CLAST_VULKAN_SORT_H

#include "vulkan/gpu.h"

enum {
    CLAST_GPU_SORT_CHUNKS = 256, // the most that keys are cut into
    CLAST_GPU_SORT_DIGITS = 8,   // passes over eight bits each, at most
};
// Bytes of working memory.
#define CLAST_GPU_SORT_SCRATCH (UINT64_C(1) * CLAST_GPU_SORT_DIGITS * CLAST_GPU_SORT_CHUNKS * 256 * sizeof(uint32_t))

// Addresses are of arrays of `count` elements; none overlap.
typedef struct clast_gpu_sort_desc {
    uint64_t keys;   // 32 bits each, or 64
    uint64_t values; // 32 bits each
    uint64_t spare_keys, spare_values;
    uint64_t scratch; // CLAST_GPU_SORT_SCRATCH bytes
    uint64_t count;   // at most 2^31
    uint32_t bits;    // the lowest of a key, by which it is sorted: 1 to 32, or 64 where keys are wide
    bool wide;        // keys have 64 bits
    bool numbered;    // the values are not read: they are 0, 1, 2 and so on
} clast_gpu_sort_desc;

// A kernel for each eight bits and one before, with barriers between them. Gives whether the result lies in the spare arrays, and not
// in the others, which hold something else then. LIMIT is noted in the commands where there are too many.
bool clast_gpu_sort(clast_gpu_commands *commands, const clast_gpu_sort_desc *desc);

#endif
