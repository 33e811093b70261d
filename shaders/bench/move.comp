// SPDX-License-Identifier: Apache-2.0
// Moves every vertex of the copies of a mesh by a mild wave.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform clast_bench_move_push {
    uint64_t rest;      // positions of one copy
    uint64_t positions; // of all
    uint vertices;      // of one
    uint copies;
    uint side; // of the lattice in which copies stand
    float time;
}
push;

void main()
{
    uint64_t i = uint64_t(linear_group()) * 256ul + gl_LocalInvocationIndex;
    if (i >= uint64_t(push.vertices) * push.copies) {
        return;
    }
    uint copy = uint(i / push.vertices);
    vec3 p = load3(positions3(push.rest).at[uint(i % push.vertices)]);
    vec3 place = vec3(copy % push.side, copy / push.side % push.side, copy / (push.side * push.side));
    float phase = push.time + float(copy);
    p += 0.05 * vec3(sin(5.0 * p.y + phase), sin(6.0 * p.z + 1.3 * phase), sin(4.0 * p.x - phase));
    p += 2.5 * (place - 0.5 * float(push.side - 1u));
    positions3(push.positions).at[uint(i)] = store3(p);
}
