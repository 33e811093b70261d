// SPDX-License-Identifier: Apache-2.0
// Counts where two ways to trace tell different hits of the same rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/ray.glsl"

layout(local_size_x = 256) in;

layout(push_constant, scalar) uniform clast_bench_compare_push {
    uint64_t first, second;
    uint64_t counts; // of hits, of rays that one alone hits, of distances that differ, of triangles that differ
    uint count;
}
push;

void main()
{
    uint i = linear_group() * 256u + gl_LocalInvocationIndex;
    if (i >= push.count) {
        return;
    }
    clast_hit a = hits(push.first).at[i], b = hits(push.second).at[i];
    bool a_hits = a.instance != CLAST_NONE, b_hits = b.instance != CLAST_NONE;
    uints counts = uints(push.counts);
    if (a_hits) {
        atomicAdd(counts.at[0], 1u);
    }
    if (a_hits != b_hits) {
        atomicAdd(counts.at[1], 1u);
    } else if (a_hits && abs(a.t - b.t) > 1e-4 * max(a.t, 1e-2)) {
        atomicAdd(counts.at[2], 1u);
    } else if (a_hits && (a.cluster != b.cluster || a.triangle != b.triangle)) {
        atomicAdd(counts.at[3], 1u);
    }
}
