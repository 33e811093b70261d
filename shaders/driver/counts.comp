// SPDX-License-Identifier: Apache-2.0
// How many triangles each record of a unit has.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform clast_driver_counts_push {
    uint64_t records;
    uint64_t triangles;
    uint count;
}
push;

void main()
{
    uint i = linear_group() * 256u + gl_LocalInvocationIndex;
    if (i < push.count) {
        uints(push.triangles).at[i] = record_triangles(cluster_records(push.records).at[i]);
    }
}
