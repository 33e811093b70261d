// SPDX-License-Identifier: Apache-2.0
// Views as pictures to look at, made on the device: clast_view_to_display of values that lie there.
#ifndef CLAST_VULKAN_DISPLAY_H
#define CLAST_VULKAN_DISPLAY_H

#include "render/display.h"
#include "vulkan/gpu.h"

typedef struct clast_gpu_display_desc {
    clast_view view;
    uint64_t values; // address of the view's, row by row
    float scale;     // of colour, albedo and normals: one over the samples, where the values are sums
    uint32_t width, height;
    uint32_t bits; // of a channel: 8 or 16
    clast_display how;
    uint64_t pixels; // address of clast_gpu_display_bytes(): three channels a pixel
} clast_gpu_display_desc;

enum { CLAST_GPU_DISPLAY_RANGE = 16 };

uint64_t clast_gpu_display_bytes(uint32_t width, uint32_t height, uint32_t bits);
// Needs a barrier before it, and one after it. `range` is working memory of CLAST_GPU_DISPLAY_RANGE bytes. LIMIT is noted where
// there are too many pixels.
void clast_gpu_display(clast_gpu_commands *commands, const clast_gpu_display_desc *desc, const clast_gpu_buffer *range);

#endif
