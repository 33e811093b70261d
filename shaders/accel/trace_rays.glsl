// SPDX-License-Identifier: Apache-2.0
// What the kernels over buffers of rays share (vulkan/rays.h): trace_closest.comp and trace_any.comp, which say by TRACE_ANY
// whether any hit will do.
layout(constant_id = 0) const uint TRACE_GROUP = 64u;
layout(constant_id = 1) const uint TRACE_REFILL = 0u; // 0: a ray an invocation
layout(constant_id = 2) const uint TRACE_STEPS = 4u;  // between two looks at who has no ray
layout(constant_id = 3) const uint TRACE_PAIRS = 0u;  // of triangles that follow a node at most; 0: all that it has
layout(constant_id = 4) const uint TRACE_BYTES_AS = 0u;
layout(local_size_x_id = 0) in;
#define TRACE_BYTES TRACE_BYTES_AS

#include "gpu.glsl"

layout(push_constant, scalar) uniform clast_rays_push
{
    uint64_t scene, from, to;
    uint64_t ticket; // one number, 0 before: the next ray that nobody took
    uint count;
}
push;

uint trace_ray_number;
#define TRACE_RAY() rays(push.from).at[trace_ray_number]

#include "accel/trace_loop.glsl"

uint trace_count() { return push.count; }
uint64_t trace_ticket() { return push.ticket; }

void begin_ray(uint number)
{
    trace_ray_number = number;
    begin_trace(push.scene, rays(push.from).at[number], TRACE_ANY);
}

void store_ray()
{
    if (TRACE_ANY) {
        uints(push.to).at[trace_ray_number] = trace_found() ? 1u : 0u;
    } else if (TRACE_REFILL == 0u) {
        hits(push.to).at[trace_ray_number] = traced_hit();
    } else {
        // Few invocations end at a time: what is costly is left to trace_finish.comp.
        hits to = hits(push.to);
        to.at[trace_ray_number].t = trace.t;
        trace_place best = trace_best();
        to.at[trace_ray_number].instance = best.placement;
        to.at[trace_ray_number].cluster = best.cluster;
        to.at[trace_ray_number].triangle = best.triangle;
        to.at[trace_ray_number].steps = trace.steps;
    }
}
