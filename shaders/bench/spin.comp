// SPDX-License-Identifier: Apache-2.0
// Keeps a device busy for a while: one that has been idle runs slowly at first.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform clast_bench_spin_push {
    uint64_t to; // one number
    uint turns;
}
push;

void main()
{
    float x = float(gl_LocalInvocationIndex);
    for (uint i = 0u; i < push.turns; i++) {
        x = fma(x, 0.999, 1.0);
    }
    if (x < 0.0) { // never
        floats(push.to).at[0] = x;
    }
}
