// SPDX-License-Identifier: Apache-2.0
// Copies memory, 16 bytes an invocation: how fast that can be at all.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform clast_bench_copy_push {
    uint64_t from, to;
    uint count;
}
push;

void main()
{
    uint i = linear_group() * 256u + gl_LocalInvocationIndex;
    if (i < push.count) {
        uint4s(push.to).at[i] = uint4s(push.from).at[i];
    }
}
