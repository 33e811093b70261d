// SPDX-License-Identifier: Apache-2.0
// After a step of the paths: how many groups work on the lists that it made. A single invocation does it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/paths.glsl"
layout(local_size_x = 1) in;

// Most work groups that trace the rays of a list: enough to fill the device.
layout(constant_id = 0) const uint TRACE_GROUPS = 4096u;

const uint GROUPS_ACROSS = 32768u;

void main()
{
    if (linear_group() != 0u) {
        return;
    }
    queue_reference queue = queue_of();
    uint64_t rays = load_address(queue.of.rays);
    for (uint list = 0u; list < LISTS; list++) {
        uint length = queue.of.growing[list];
        uint groups = (length + PATH_GROUP - 1u) / PATH_GROUP;
        uint enough = PATH_TRACE_GROUP * PATH_TRACE_RAYS;
        queue.of.growing[list] = 0u;
        queue.of.lengths[list] = length;
        queue.of.tickets[list] = 0u;
        queue.of.groups[3u * list] = min_uint(groups, GROUPS_ACROSS);
        queue.of.groups[3u * list + 1u] = (groups + GROUPS_ACROSS - 1u) / GROUPS_ACROSS;
        queue.of.groups[3u * list + 2u] = 1u;
        queue.of.trace_groups[3u * list] = min_uint((length + enough - 1u) / enough, TRACE_GROUPS);
        queue.of.trace_groups[3u * list + 1u] = 1u;
        queue.of.trace_groups[3u * list + 2u] = 1u;
        rays += uint64_t(length);
    }
    queue.of.rays = store_address(rays);
}
