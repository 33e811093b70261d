// SPDX-License-Identifier: Apache-2.0
// Fits clusters whose vertices lie in a device's memory: clast_clas_refit there, and clast_clas_refit_gathered.
#ifndef CLAST_VULKAN_FIT_H
#define CLAST_VULKAN_FIT_H

#include "shared/cluster.h"
#include "vulkan/gpu.h"

// Addresses in the device's memory.
typedef struct clast_gpu_fit {
    uint64_t templates; // clast_device_template, by number (vulkan/topologies.h)
    uint64_t inputs;    // clast_device_cluster of each cluster
    uint64_t vertices;  // packed3
    uint64_t clusters;  // gets the clusters, each at its place; aligned to CLUSTER_UNIT
    uint64_t boxes;     // clast_box of each cluster
    // Shared vertices, which become those of the clusters first: vertex i becomes position numbers[i]. 0: there are none. A cluster
    // that has a number that is out of range stays as it was, and `faults`, one 32-bit number, becomes 1.
    uint64_t positions, numbers, faults;
    uint32_t position_count;
    uint32_t first, count; // clusters
} clast_gpu_fit;

// How kernels that include shaders/accel/lanes.glsl are called: two constants tell the width of subgroups, and that of a group.
typedef struct clast_gpu_lanes {
    uint32_t lanes; // of a subgroup, which has a cluster: the call asks for that width
    uint32_t group; // invocations of a work group
} clast_gpu_lanes;
clast_gpu_lanes clast_gpu_lanes_of(const clast_gpu *gpu);
static inline uint64_t clast_gpu_lane_groups(clast_gpu_lanes lanes, uint64_t clusters)
{
    uint32_t together = lanes.group / lanes.lanes;
    return (clusters + together - 1) / together;
}

void clast_gpu_fit_clusters(clast_gpu_commands *commands, const clast_gpu_fit *fit);

#endif
