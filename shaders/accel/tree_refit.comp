// SPDX-License-Identifier: Apache-2.0
// Fits trees anew to boxes of the same items: from the bottom up. A team takes a node that has no nodes below; of the teams that
// come to a node from below, the last one takes it. What is below has been written then. No team waits for others, but for
// those of its group, step by step.
#version 460
#extension GL_GOOGLE_include_directive : require
#define GROUP_SIZE 64u
#include "gpu.glsl"
#include "accel/node.glsl"
#define TREE_PUSH
#include "accel/tree_jobs.glsl"

layout(local_size_x = 64) in;

// vulkan/trees.c hands these over.
layout(push_constant, scalar) uniform clast_refit_push {
    uint64_t jobs;
    uint job_count;
    uint group_count;
    clast_tree_job only; // the job, where there is one
}
push;

// Other groups write these at the same time.
layout(buffer_reference, scalar, buffer_reference_align = 16) coherent buffer shared_nodes { clast_tree_kept_node at[]; };

shared uint walking;
shared uint next_numbers[TEAMS];

clast_tree_job job_of_group(uint group)
{
    if (push.job_count == 1u) {
        return push.only;
    }
    uint low = 0u, high = push.job_count;
    while (low + 1u < high) {
        uint middle = (low + high) >> 1u;
        if (tree_jobs(push.jobs).at[middle].first_groups[0] <= group) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return tree_jobs(push.jobs).at[low];
}

team_child load_child(clast_tree_job job, uint below)
{
    team_child child;
    child.there = below != CLAST_NONE;
    child.child = below;
    child.box.lower = vec3(uintBitsToFloat(TREE_BEYOND_BITS));
    child.box.upper = -child.box.lower;
    if (child.there && (below & CHILD_ITEM) != 0u) {
        uint item = below & ~CHILD_ITEM;
        child.child = item_child(load_address(job.items), item);
        child.box = load_item_box(load_address(job.boxes), item);
    } else if (child.there) {
        clast_box box = shared_nodes(kept_nodes_at(load_address(job.kept))).at[below].box;
        child.box = box;
    }
    return child;
}

// How many nodes a node waits for.
uint nodes_below(kept_nodes nodes, uint number)
{
    uint count = 0u;
    for (uint i = 0u; i < TREE_CHILDREN; i++) {
        count += (nodes.at[number].children[i] & CHILD_ITEM) == 0u ? 1u : 0u;
    }
    return count;
}

// The node that the team takes next: above its own, where it is the last to come. One lane asks.
uint step_up(uint64_t kept, uint number)
{
    kept_nodes fixed_nodes = kept_nodes(kept_nodes_at(kept));
    shared_nodes nodes = shared_nodes(kept_nodes_at(kept));
    uint parent = fixed_nodes.at[number].parent;
    if (parent == CLAST_NONE) {
        return CLAST_NONE;
    }
    uint arrived = atomicAdd(nodes.at[parent].arrivals, 1u) + 1u;
    if (arrived < nodes_below(fixed_nodes, parent)) {
        return CLAST_NONE;
    }
    nodes.at[parent].arrivals = 0u;
    return parent;
}

// Fits the node of each team, and those above it for which it is the last.
void walk_up(clast_tree_job job, uint number)
{
    uint lane = team_lane(), team = lane / TEAM, place = lane % TEAM;
    uint64_t kept = load_address(job.kept);
    uint64_t bounds = load_address(job.bounds);
    for (;;) {
        if (lane == 0u) {
            walking = 0u;
        }
        barrier();
        bool there = number != CLAST_NONE;
        uint below = CLAST_NONE;
        if (there) {
            below = kept_nodes(kept_nodes_at(kept)).at[number].children[place];
        }
        uint64_t node = there ? load_address(job.nodes) + NODE_BYTES * number : 0ul;
        clast_box box = write_node(load_child(job, below), node);
        if (place == 0u) {
            uint next = CLAST_NONE;
            if (there) {
                shared_nodes(kept_nodes_at(kept)).at[number].box = box;
                if (number == 0u && bounds != 0ul) {
                    boxes(bounds).at[0] = box;
                }
                memoryBarrierBuffer();
                next = step_up(kept, number);
                memoryBarrierBuffer();
            }
            next_numbers[team] = next;
            if (next != CLAST_NONE) {
                walking = 1u;
            }
        }
        barrier();
        number = next_numbers[team];
        bool goes_on = walking != 0u;
        barrier();
        if (!goes_on) {
            break;
        }
    }
}

void main()
{
    uint group = linear_group();
    if (group >= push.group_count) {
        return;
    }
    clast_tree_job job = job_of_group(group);
    uint64_t kept = load_address(job.kept);
    uint bottoms = kept_head(kept).of.bottoms;
    uint team = (group - job.first_groups[0]) * TEAMS + team_lane() / TEAM;
    uint step_teams = job.first_groups[1] * TEAMS; // all of the tree's
    for (uint first = 0u; first < bottoms; first += step_teams) {
        uint i = first + team;
        uint number = CLAST_NONE;
        if (i < bottoms) {
            bool in_row = kept_head(kept).of.are_in_row != 0u;
            number = in_row ? kept_head(kept).of.first_bottom + i : uints(kept_bottoms_at(kept)).at[i];
        }
        walk_up(job, number);
    }
}
