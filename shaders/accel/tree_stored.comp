// SPDX-License-Identifier: Apache-2.0
// Trees over items in the order in which they are stored, or in a given one: eight that follow each other are the children of
// a node, eight nodes those of a node of the next level. A work group builds three levels; phase by phase these add up.
#version 460
#extension GL_GOOGLE_include_directive : require
#define GROUP_SIZE 256u
#include "gpu.glsl"
#include "accel/node.glsl"
#define TREE_PUSH
#include "accel/tree_jobs.glsl"

layout(local_size_x = 256) in;

// vulkan/trees.c hands these over.
layout(push_constant, scalar) uniform clast_stored_push {
    uint64_t jobs;
    uint64_t work;         // clast_tree_work of each job
    uint64_t order;        // numbers of items, counted through all jobs; 0: as they are stored
    uint64_t boxes;        // gets the box of each work group
    uint64_t boxes_before; // those of the phase before
    uint job_count;
    uint group_count;
    uint phase;
    uint only_deep;      // only jobs whose other tree is too deep
    clast_tree_job only; // the job, where there is one
}
push;

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

// The last job that begins at or before a work group of this phase.
uint job_of_group(uint group)
{
    uint low = 0u, high = push.job_count;
    while (low + 1u < high) {
        uint middle = (low + high) >> 1u;
        if (tree_jobs(push.jobs).at[middle].first_groups[push.phase] <= group) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

struct phase_job {
    uint64_t boxes, items, nodes, bounds, kept;
    uint count;  // items
    uint inputs; // of this phase: items, or nodes
    uint first;  // among all items
    uint first_input; // among the boxes of the phase before
};

team_child no_child()
{
    team_child child;
    child.there = false;
    child.child = CLAST_NONE;
    child.box.lower = vec3(uintBitsToFloat(TREE_BEYOND_BITS));
    child.box.upper = -child.box.lower;
    return child;
}

// The number of the item at a place of the order.
uint item_at(phase_job job, uint place)
{
    return push.order != 0ul ? uints(push.order).at[job.first + place] - job.first : place;
}

// The child that input `i` of this phase is.
team_child load_input(phase_job job, uint i)
{
    team_child child = no_child();
    child.there = i < job.inputs;
    if (child.there && push.phase == 0u) {
        uint item = item_at(job, i);
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

// Notes what fitting the tree anew needs; `below` is what the child is told as there.
void keep(phase_job job, uint level, uint number, uint below, clast_box box)
{
    uint lane = team_lane(), place = lane % TEAM;
    if (number >= level_nodes(job.count, level)) {
        return;
    }
    uint own = level_first(job.count, level) + number;
    kept_nodes nodes = kept_nodes(kept_nodes_at(job.kept));
    nodes.at[own].children[place] = below;
    if (place == 0u) {
        bool is_root = level_nodes(job.count, level) == 1u;
        nodes.at[own].box = box;
        nodes.at[own].parent = is_root ? CLAST_NONE : level_first(job.count, level + 1u) + number / TEAM;
        nodes.at[own].arrivals = 0u;
        if (level == 1u && number == 0u) {
            clast_tree_kept head;
            head.bottoms = level_nodes(job.count, 1u);
            head.are_in_row = 1u;
            head.first_bottom = own;
            head.room = job.count;
            kept_head(job.kept).of = head;
        }
    }
}

// Steps 0 and 1 are the level of the inputs, half of its nodes each; 2 and 3 are the levels above.
struct step_node {
    uint level, number; // the node that a team writes
    bool own;           // it is one of the group's
    uint below;         // where the nodes of the level below begin
};

step_node node_of_step(phase_job job, uint group, uint step_number, uint team)
{
    uint bottom = 3u * push.phase + 1u;
    step_node result;
    result.level = bottom + max(step_number, 1u) - 1u;
    result.number = step_number < 2u   ? group * BOTTOM_NODES + step_number * TEAMS + team
                    : step_number == 2u ? group * TREE_CHILDREN + team
                                        : group;
    result.own = step_number < 2u || (step_number == 2u ? team < TREE_CHILDREN : team == 0u);
    result.below = level_first(job.count, result.level - 1u);
    return result;
}

void build_levels(phase_job job, uint group)
{
    uint lane = team_lane(), team = lane / TEAM, place = lane % TEAM, bottom = 3u * push.phase + 1u;
    uint steps = level_nodes(job.count, bottom) <= 1u ? 1u : level_nodes(job.count, bottom + 1u) <= 1u ? 3u : 4u;
    clast_box box;
    bool is_half = group * BOTTOM_NODES + TEAMS >= level_nodes(job.count, bottom); // nothing to do in step 1
    [[dont_unroll]] for (uint i = 0u; i < steps; i += i == 0u && is_half ? 2u : 1u) {
        step_node node = node_of_step(job, group, i, team);
        uint from = node.number * TEAM + place;
        team_child child = no_child();
        if (i < 2u) {
            child = load_input(job, from);
        } else if (node.own && from < level_nodes(job.count, node.level - 1u)) {
            clast_box below = middle_boxes[place];
            if (i == 2u) {
                below = bottom_boxes[team * TEAM + place];
            }
            child = team_child(below, node.below + from, true);
        }
        box = write_node(child, node.own ? node_address(job, node.level, node.number) : 0ul);
        if (job.kept != 0ul && node.own) {
            bool is_item = node.level == 1u && child.there;
            uint below = is_item ? CHILD_ITEM | item_at(job, from) : child.there ? child.child : CLAST_NONE;
            keep(job, node.level, node.number, below, box);
        }
        if (place == 0u && i < 2u) {
            bottom_boxes[i * TEAMS + team] = box;
        } else if (place == 0u && i == 2u && node.own) {
            middle_boxes[team] = box;
        }
        barrier();
    }
    if (lane == 0u) { // the first team's is the top
        clast_box top = steps == 1u ? bottom_boxes[0] : box;
        boxes(push.boxes).at[linear_group()] = top;
        bool is_root = level_nodes(job.count, bottom + 2u) <= 1u;
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
    uint number = 0u;
    clast_tree_job own = push.only;
    if (push.job_count > 1u) {
        number = job_of_group(group);
        own = tree_jobs(push.jobs).at[number];
    }
    if (push.only_deep != 0u && tree_works(push.work).at[number].is_deep == 0u) {
        return;
    }
    phase_job job;
    job.boxes = load_address(own.boxes);
    job.items = load_address(own.items);
    job.nodes = load_address(own.nodes);
    job.bounds = load_address(own.bounds);
    job.kept = load_address(own.kept);
    job.count = own.count;
    job.first = own.first;
    job.inputs = level_nodes(job.count, 3u * push.phase);
    job.first_input = push.phase > 0u ? own.first_groups[push.phase - 1u] : 0u;
    build_levels(job, group - own.first_groups[push.phase]);
}
