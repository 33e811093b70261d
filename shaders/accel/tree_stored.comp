// SPDX-License-Identifier: Apache-2.0
// Trees over items in the order in which they are stored, or in a given one: eight that follow each other are the children of
// a node, eight nodes those of a node of the next level. A work group builds three levels; phase by phase these add up.
#version 460
#extension GL_GOOGLE_include_directive : require
#define GROUP_SIZE 256u
#include "gpu.glsl"
#include "accel/node.glsl"
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;

const uint BOTTOM_NODES = TREE_PHASE_ITEMS / TREE_CHILDREN; // of a group

shared clast_box bottom_boxes[BOTTOM_NODES];
shared clast_box middle_boxes[TREE_CHILDREN];

// Where the nodes of a level begin: after all levels above.
uint level_first(uint items, uint level)
{
    uint first = 0u;
    for (uint above = level; level_nodes(items, above) > 1u;) {
        above++;
        first += level_nodes(items, above);
    }
    return first;
}

struct phase_job {
    uint64_t boxes, items, nodes, bounds;
    uint count;  // items
    uint inputs; // of this phase: items, or nodes
    uint first;  // among all items
    uint first_input; // among the boxes of the phase before
};

// The child that input `i` of this phase is.
team_child load_input(phase_job job, uint i)
{
    team_child child;
    child.there = i < job.inputs;
    child.child = CLAST_NONE;
    child.box.lower = vec3(uintBitsToFloat(TREE_BEYOND_BITS));
    child.box.upper = -child.box.lower;
    if (child.there && push.phase == 0u) {
        uint item = push.order != 0ul ? uints(push.order).at[job.first + i] - job.first : i;
        child.child = item_child(job.items, item);
        child.box = load_item_box(job.boxes, item);
    } else if (child.there) {
        child.child = level_first(job.count, 3u * push.phase) + i;
        clast_box box = boxes(push.boxes_before).at[job.first_input + i];
        child.box = box;
    }
    return child;
}

// Of the node that a team writes on a level: 0 where there is none.
uint64_t node_address(phase_job job, uint level, uint number)
{
    bool there = number < level_nodes(job.count, level);
    return there ? job.nodes + NODE_BYTES * (level_first(job.count, level) + number) : 0ul;
}

void build_levels(phase_job job, uint group)
{
    uint lane = team_lane(), team = lane / TEAM, place = lane % TEAM, level = 3u * push.phase + 1u;
    for (uint round = 0u; round < BOTTOM_NODES; round += TEAMS) {
        uint local = round + team, number = group * BOTTOM_NODES + local;
        team_child child = load_input(job, number * TEAM + place);
        clast_box box = write_node(child, node_address(job, level, number));
        if (place == 0u) {
            bottom_boxes[local] = box;
        }
    }
    barrier();
    clast_box top = bottom_boxes[0];
    if (level_nodes(job.count, level) > 1u) {
        uint below = level_first(job.count, level), nodes = level_nodes(job.count, level);
        uint number = group * TREE_CHILDREN + team, from = number * TEAM + place;
        bool own = team < TREE_CHILDREN;
        team_child child = team_child(bottom_boxes[own ? team * TEAM + place : 0u], below + from, own && from < nodes);
        clast_box box = write_node(child, own ? node_address(job, level + 1u, number) : 0ul);
        if (own && place == 0u) {
            middle_boxes[team] = box;
        }
        barrier();
        top = middle_boxes[0];
        if (level_nodes(job.count, level + 1u) > 1u) {
            below = level_first(job.count, level + 1u);
            nodes = level_nodes(job.count, level + 1u);
            from = group * TEAM + place;
            child = team_child(middle_boxes[place], below + from, team == 0u && from < nodes);
            box = write_node(child, team == 0u ? node_address(job, level + 2u, group) : 0ul);
            top = box; // of the first team
        }
    }
    if (lane == 0u) {
        boxes(push.boxes).at[linear_group()] = top;
        bool is_root = level_nodes(job.count, level + 2u) <= 1u;
        if (is_root && job.bounds != 0ul) {
            boxes(job.bounds).at[0] = top;
        }
    }
}

void main()
{
    uint group = linear_group();
    if (group >= push.group_count) {
        return;
    }
    uint number = job_of_group(group, push.phase);
    tree_jobs jobs = tree_jobs(push.jobs);
    if (push.only_deep != 0u && tree_works(push.work).at[number].is_deep == 0u) {
        return;
    }
    phase_job job;
    job.boxes = load_address(jobs.at[number].boxes);
    job.items = load_address(jobs.at[number].items);
    job.nodes = load_address(jobs.at[number].nodes);
    job.bounds = load_address(jobs.at[number].bounds);
    job.count = jobs.at[number].count;
    job.first = jobs.at[number].first;
    job.inputs = level_nodes(job.count, 3u * push.phase);
    job.first_input = push.phase > 0u ? jobs.at[number].first_groups[push.phase - 1u] : 0u;
    build_levels(job, group - jobs.at[number].first_groups[push.phase]);
}
