// SPDX-License-Identifier: Apache-2.0
// Clusters by subgroups: each subgroup of a work group has a cluster to itself, so that it waits for no other. What it knows
// of the cluster's vertices is in shared memory.
//
// The kernel tells by LANES_CONSTANT and GROUP_CONSTANT which specialisation constants say how wide subgroups are, and how many
// invocations a work group has: CLUSTERS_TOGETHER subgroups at most, all full (clast_gpu_lanes of vulkan/fit.h).
#ifndef CLAST_ACCEL_LANES_GLSL
#define CLAST_ACCEL_LANES_GLSL

#include "gpu.glsl"
#include "shared/cluster.h"

layout(constant_id = LANES_CONSTANT) const uint LANES = 32u;
layout(local_size_x_id = GROUP_CONSTANT) in;

const uint CLUSTER_FLOATS = 3u * TEMPLATE_VERTICES;
shared float cluster_floats[CLUSTERS_TOGETHER * CLUSTER_FLOATS];

uint cluster_lane() { return gl_SubgroupInvocationID; }

// The number of the cluster that a subgroup has, in the dispatch; and among those of its work group.
uint cluster_of_group() { return linear_group() * gl_NumSubgroups + gl_SubgroupID; }
uint cluster_slot() { return gl_SubgroupID; }

// What the cluster's invocations wrote to shared memory before, all of them read behind this.
void cluster_barrier()
{
    subgroupMemoryBarrierShared();
    subgroupBarrier();
}

vec3 cluster_point(uint number)
{
    uint at = cluster_slot() * CLUSTER_FLOATS + 3u * number;
    return vec3(cluster_floats[at], cluster_floats[at + 1u], cluster_floats[at + 2u]);
}

// The size of the largest coordinate that this invocation set: are_sound_bits() tells of all points then.
uint cluster_size_bits = 0u;

void set_cluster_point(uint number, vec3 point)
{
    cluster_size_bits = max(cluster_size_bits, size_bits3(point));
    uint at = cluster_slot() * CLUSTER_FLOATS + 3u * number;
    cluster_floats[at] = point.x;
    cluster_floats[at + 1u] = point.y;
    cluster_floats[at + 2u] = point.z;
}

// Writes points to memory: float by float, as neighbours then write side by side.
void store_cluster_points(uint64_t address, uint count)
{
    floats to = floats(address);
    for (uint i = cluster_lane(); i < 3u * count; i += LANES) {
        to.at[i] = cluster_floats[cluster_slot() * CLUSTER_FLOATS + i];
    }
}

#endif
