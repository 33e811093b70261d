// SPDX-License-Identifier: Apache-2.0
// Nothing is known yet: of the trees, of the ranges that tree_pairs.comp meets, of what tree_widen.comp is to do.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;

void main()
{
    uint i = linear_group() * 256u + gl_LocalInvocationIndex;
    if (i < push.item_count) {
        uints(push.ranges).at[i] = CLAST_NONE;
    }
    if (i < push.job_count) {
        clast_tree_work work;
        for (uint axis = 0u; axis < 3u; axis++) {
            work.lower[axis] = CLAST_NONE;
            work.upper[axis] = 0u;
        }
        work.root = CLAST_NONE;
        work.is_deep = 0u;
        tree_works(push.work).at[i] = work;
        uint64_t kept = load_address(tree_jobs(push.jobs).at[i].kept);
        if (kept != 0ul) {
            kept_head(kept).of.bottoms = 0u;
            kept_head(kept).of.are_in_row = 0u;
        }
    }
    if (i == 0u) {
        uints(push.queue).at[0] = 0u;
    }
}
