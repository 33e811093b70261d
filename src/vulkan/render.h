// SPDX-License-Identifier: Apache-2.0
// The passes that end in a picture, on a device: the second implementation of render/passes.c. The pictures' sums stay on the
// device until the last sample is done, or the render is cancelled; they are fetched then.
//
// A tile of the picture at a time is under way, of as many paths as memory is set aside for (shared/device_paths.h). Its
// primary rays are generated where they are traced, so they belong to the pass shade here; how long they took is told as
// the pass trace's all the same. Within a tile nothing comes back to the processor: how long lists of paths are, indirect
// dispatches read.
#ifndef CLAST_VULKAN_RENDER_H
#define CLAST_VULKAN_RENDER_H

#include "render/render.h"
#include "vulkan/frame.h"

// What the passes keep from a render to the next.
typedef struct clast_vulkan_render clast_vulkan_render;

void clast_vulkan_render_destroy(clast_vulkan_render *render);

// How long the kernels of the last render took on the device, by what they do.
uint32_t clast_vulkan_render_times(const clast_vulkan_render *render, clast_gpu_time times[CLAST_GPU_TIMES]);

// Pass trace: begins a render at its first sample. Pass shade: a sample. `target` is a clast_render_target.
clast_status clast_vulkan_trace(clast_frame *frame, void *target);
clast_status clast_vulkan_shade(clast_frame *frame, void *target);
// The noise of the active squares, and the sums: backend.h.
clast_status clast_vulkan_measure(clast_frame *frame, void *target);
clast_status clast_vulkan_fetch(clast_frame *frame, void *target);

// The Vulkan backend, whole: for frames whose clast_frame.device is a clast_vulkan_frame.
extern const clast_backend clast_vulkan_backend;

#endif
