// SPDX-License-Identifier: Apache-2.0
// A picture's rays, and those that leave their hits, through clast's trees and through the driver's.
#ifndef CLAST_BENCH_VULKAN_RAYS_H
#define CLAST_BENCH_VULKAN_RAYS_H

#include "vulkan_work.h"

typedef struct vulkan_rays {
    vulkan_work *work;
    uint32_t width, height;
    clast_gpu_buffer primary, diffuse; // clast_ray
    clast_gpu_buffer hits, peer_hits;  // clast_hit
    clast_gpu_buffer counts;
    uint32_t primary_count, diffuse_count; // those that are there
} vulkan_rays;

// How two ways to trace agree.
typedef struct vulkan_agreement {
    uint32_t hits;      // of clast's
    uint32_t one_alone; // rays that only one of them hits
    uint32_t distances; // that differ
    uint32_t triangles; // that differ, at the same distance
} vulkan_agreement;

void vulkan_rays_make(vulkan_work *work, uint32_t width, uint32_t height, vulkan_rays *rays);
void vulkan_rays_free(vulkan_rays *rays);
void vulkan_trace(const vulkan_rays *rays, clast_gpu_commands *commands, bool diffuse);
void vulkan_trace_peer(const vulkan_rays *rays, clast_gpu_commands *commands, bool diffuse);
vulkan_agreement vulkan_compare(const vulkan_rays *rays, bool diffuse);

#endif
