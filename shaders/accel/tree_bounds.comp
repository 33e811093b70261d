// SPDX-License-Identifier: Apache-2.0
// The box around each tree's items. Minima and maxima do not depend on the order in which they are taken.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;

const uint ITEMS = 8u; // for each invocation

shared uint group_lower[3];
shared uint group_upper[3];

void note(uint job, uint lower[3], uint upper[3])
{
    tree_works works = tree_works(push.work);
    for (uint axis = 0u; axis < 3u; axis++) {
        if (lower[axis] <= upper[axis]) {
            atomicMin(works.at[job].lower[axis], lower[axis]);
            atomicMax(works.at[job].upper[axis], upper[axis]);
        }
    }
}

void main()
{
    uint lane = gl_LocalInvocationIndex;
    uint first = linear_group() * (256u * ITEMS), end = min(first + 256u * ITEMS, push.item_count);
    if (first >= end) {
        return;
    }
    if (lane < 3u) {
        group_lower[lane] = CLAST_NONE;
        group_upper[lane] = 0u;
    }
    barrier();
    // Most groups have items of one tree.
    uint first_job = job_of_item(first), last_job = job_of_item(end - 1u);
    uint lower[3] = uint[3](CLAST_NONE, CLAST_NONE, CLAST_NONE);
    uint upper[3] = uint[3](0u, 0u, 0u);
    for (uint i = first + lane; i < end; i += 256u) {
        uint job = first_job == last_job ? first_job : job_of_item(i);
        clast_tree_job of = tree_jobs(push.jobs).at[job];
        clast_box box = load_item_box(load_address(of.boxes), i - of.first);
        if (box_is_empty(box)) {
            continue;
        }
        if (first_job != last_job) {
            lower = uint[3](CLAST_NONE, CLAST_NONE, CLAST_NONE);
            upper = uint[3](0u, 0u, 0u);
        }
        for (uint axis = 0u; axis < 3u; axis++) {
            lower[axis] = min(lower[axis], ordered_bits(unsigned_zero(box.lower[axis])));
            upper[axis] = max(upper[axis], ordered_bits(unsigned_zero(box.upper[axis])));
        }
        if (first_job != last_job) {
            note(job, lower, upper);
        }
    }
    if (first_job != last_job) {
        return;
    }
    for (uint axis = 0u; axis < 3u; axis++) {
        uint least = subgroupMin(lower[axis]), most = subgroupMax(upper[axis]);
        if (subgroupElect() && least <= most) {
            atomicMin(group_lower[axis], least);
            atomicMax(group_upper[axis], most);
        }
    }
    barrier();
    if (lane == 0u) {
        note(first_job, group_lower, group_upper);
    }
}
