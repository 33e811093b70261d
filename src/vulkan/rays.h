// SPDX-License-Identifier: Apache-2.0
// Rays in a device's memory, through a scene there (shared/cluster.h): clast_trace_closest and clast_trace_any, with the same
// hits to the bit, but for their steps.
#ifndef CLAST_VULKAN_RAYS_H
#define CLAST_VULKAN_RAYS_H

#include "vulkan/gpu.h"

// How rays of a buffer that follow each other go.
typedef enum clast_gpu_rays_kind {
    CLAST_GPU_RAYS_COHERENT,   // much the same way: as those of a camera, or towards a light
    CLAST_GPU_RAYS_INCOHERENT, // any way
} clast_gpu_rays_kind;

// How the kernel goes about it; all zero is a good choice.
typedef struct clast_gpu_rays_tuning {
    uint32_t group;  // invocations of a work group
    uint32_t refill; // invocations that wait before they take rays; 0: as the kind of rays suggests, UINT32_MAX: never
    uint32_t steps;  // between two looks at who waits
    uint32_t pairs;  // of triangles that follow a node; 0: one, UINT32_MAX: all
    uint32_t bytes;  // TRACE_BYTES of shaders/accel/trace.glsl
    uint32_t groups; // work groups, where invocations take rays
} clast_gpu_rays_tuning;

// Addresses in the device's memory.
typedef struct clast_gpu_rays {
    uint64_t scene;                  // clast_device_scene
    uint64_t rays;                   // clast_ray
    uint64_t to;                     // closest: clast_hit of each, or any: 32 bits of each, 1 where something is hit
    const clast_gpu_buffer *scratch; // CLAST_GPU_RAYS_SCRATCH bytes, which commands under way do not share
    uint32_t count;
    clast_gpu_rays_kind kind;
    clast_gpu_rays_tuning tuning;
} clast_gpu_rays;

enum { CLAST_GPU_RAYS_SCRATCH = 16 };

// There are no filters here: all hits count. Has its own barrier before it where it needs one.
void clast_gpu_trace_closest(clast_gpu_commands *commands, const clast_gpu_rays *rays);
void clast_gpu_trace_any(clast_gpu_commands *commands, const clast_gpu_rays *rays);

#endif
