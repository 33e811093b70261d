// SPDX-License-Identifier: Apache-2.0
// A key for each item: its tree, then where in its tree it is, as halves of the cell before: each time along its longest side.
// And nothing waits yet for tree_pairs.comp, and nothing is kept.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;
layout(constant_id = 0) const uint KEY_WORDS = 1u;

uint place_code(vec3 centre, clast_tree_work work)
{
    vec3 at = vec3(0.0), size = vec3(0.0);
    for (uint axis = 0u; axis < 3u; axis++) {
        float lower = ordered_float(work.lower[axis]), extent = ordered_float(work.upper[axis]) - lower;
        size[axis] = extent;
        at[axis] = extent > 0.0 ? clamp((centre[axis] - lower) / extent, 0.0, 1.0) : 0.0; // of its cell
    }
    uint code = 0u;
    for (uint bit = 0u; bit < push.code_bits; bit++) {
        bool is_x = size.x >= size.y && size.x >= size.z, is_y = !is_x && size.y >= size.z;
        bvec3 axis = bvec3(is_x, is_y, !is_x && !is_y);
        float twice = 2.0 * (is_x ? at.x : is_y ? at.y : at.z);
        bool high = twice >= 1.0;
        at = mix(at, vec3(high ? twice - 1.0 : twice), axis);
        size = mix(size, size * 0.5, axis);
        code = code << 1u | (high ? 1u : 0u);
    }
    return code;
}

void main()
{
    uint i = linear_group() * 256u + gl_LocalInvocationIndex;
    if (i >= push.item_count) {
        return;
    }
    uint job = job_of_item(i);
    uints(push.ranges).at[i] = CLAST_NONE;
    clast_tree_job of = tree_jobs(push.jobs).at[job];
    clast_box box = load_item_box(load_address(of.boxes), i - of.first);
    uint64_t kept = load_address(of.kept);
    if (kept != 0ul && i == of.first) {
        kept_head(kept).of.bottoms = 0u;
        kept_head(kept).of.are_in_row = 0u;
        kept_head(kept).of.room = of.count;
    }
    uint code = (1u << push.code_bits) - 1u; // empty ones come last
    if (!box_is_empty(box)) {
        clast_tree_work work = tree_works(push.work).at[job];
        code = place_code(box.lower * 0.5 + box.upper * 0.5, work);
    }
    if (KEY_WORDS == 1u) {
        uints(push.keys).at[i] = push.job_count > 1u ? job << push.code_bits | code : code;
    } else {
        uint64s(push.keys).at[i] = uint64_t(job) << push.code_bits | code;
    }
}
