// SPDX-License-Identifier: Apache-2.0
// What the kernels over buffers of rays share (vulkan/rays.h): trace_closest.comp and trace_any.comp.
//
// Rays that go the same way are best taken one by an invocation. Of others, some end long before their neighbours: then
// invocations that have none take the next ones of the buffer, by a ticket; how many wait for that is TRACE_REFILL. The order in
// which rays are taken changes nothing of what they hit.
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

#include "accel/trace.glsl"

void begin_ray(uint number, bool any)
{
    trace_ray_number = number;
    begin_trace(push.scene, rays(push.from).at[number], any);
}

// A node, and pairs of triangles that follow from it.
void step_ray()
{
    if (!has_leaves()) {
        step_node();
    }
    for (uint i = 0u; has_leaves() && trace.more && (TRACE_PAIRS == 0u || i < TRACE_PAIRS); i++) {
        step_pair();
    }
}

void store_ray(bool any)
{
    if (any) {
        uints(push.to).at[trace_ray_number] = trace_found() ? 1u : 0u;
    } else {
        hits(push.to).at[trace_ray_number] = traced_hit();
    }
}

void trace_one(bool any)
{
    uint number = linear_group() * TRACE_GROUP + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    begin_ray(number, any);
    while (trace.more) {
        step_ray();
    }
    store_ray(any);
}

// Whichever of a subgroup's invocations are together here share tickets: what they do depends on no other.
void trace_many(bool any)
{
    bool alive = false, exhausted = false;
    while (true) {
        uvec4 idle = subgroupBallot(!alive && !exhausted);
        uint count = subgroupBallotBitCount(idle);
        if (count >= min(TRACE_REFILL, gl_SubgroupSize) || !subgroupAny(alive)) {
            uint first = 0u;
            if (subgroupElect()) {
                first = count != 0u ? atomicAdd(uints(push.ticket).at[0], count) : 0u;
            }
            first = subgroupBroadcastFirst(first);
            uint number = first + subgroupBallotExclusiveBitCount(idle);
            if (!alive && !exhausted) {
                exhausted = number >= push.count;
                alive = !exhausted;
                if (alive) {
                    begin_ray(number, any);
                }
            }
        }
        if (!subgroupAny(alive)) {
            break;
        }
        for (uint i = 0u; i < TRACE_STEPS; i++) {
            if (alive && trace.more) {
                step_ray();
            }
            if (alive && !trace.more) {
                store_ray(any);
                alive = false;
            }
        }
    }
}

void trace_all(bool any)
{
    if (TRACE_REFILL == 0u) {
        trace_one(any);
    } else {
        trace_many(any);
    }
}
