// SPDX-License-Identifier: Apache-2.0
// How a kernel's invocations share out rays.
//
// Rays that go the same way are best taken one by an invocation. Of others, some end long before their neighbours: then
// invocations that have none take the next ones of the list, by a ticket; how many wait for that is TRACE_REFILL. The order in
// which rays are taken changes nothing of what they hit.
//
// The kernel gives:
//   uint trace_count()         how many rays there are
//   uint64_t trace_ticket()    address of one number, 0 before: the next ray that nobody took
//   void begin_ray(uint)       begins the search of a ray (begin_trace)
//   void store_ray()           keeps what it found
#ifndef CLAST_ACCEL_TRACE_LOOP_GLSL
#define CLAST_ACCEL_TRACE_LOOP_GLSL

#include "accel/trace.glsl"

uint trace_count();
uint64_t trace_ticket();
void begin_ray(uint number);
void store_ray();

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

void trace_one()
{
    uint number = linear_group() * TRACE_GROUP + gl_LocalInvocationIndex;
    if (number >= trace_count()) {
        return;
    }
    begin_ray(number);
    while (trace.more) {
        step_ray();
    }
    store_ray();
}

// Whichever of a subgroup's invocations are together here share tickets: what they do depends on no other. Those whose ray has
// ended keep what it found until they take the next one, so that some do both together.
void trace_many()
{
    bool alive = false, exhausted = false;
    while (true) {
        bool busy = alive && trace.more;
        uvec4 idle = subgroupBallot(!busy && !exhausted);
        uint count = subgroupBallotBitCount(idle);
        if (count >= min(TRACE_REFILL, gl_SubgroupSize) || !subgroupAny(busy)) {
            if (alive && !busy) {
                store_ray();
                alive = false;
            }
            uint first = 0u;
            if (subgroupElect()) {
                first = count != 0u ? atomicAdd(uints(trace_ticket()).at[0], count) : 0u;
            }
            first = subgroupBroadcastFirst(first);
            uint number = first + subgroupBallotExclusiveBitCount(idle);
            if (!busy && !exhausted) {
                exhausted = number >= trace_count();
                alive = !exhausted;
                if (alive) {
                    begin_ray(number);
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
        }
    }
}

void trace_all()
{
    if (TRACE_REFILL == 0u) {
        trace_one();
    } else {
        trace_many();
    }
}

#endif
