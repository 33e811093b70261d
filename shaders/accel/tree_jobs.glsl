// SPDX-License-Identifier: Apache-2.0
// The trees that a run of kernels builds, as vulkan/trees.c lays them out.
#ifndef CLAST_ACCEL_TREE_JOBS_GLSL
#define CLAST_ACCEL_TREE_JOBS_GLSL

#include "shared/tree.h"

ARRAY_OF(tree_jobs, clast_tree_job, 4)
ARRAY_OF(tree_works, clast_tree_work, 4)

ARRAY_OF(kept_nodes, clast_tree_kept_node, 16)
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer kept_head { clast_tree_kept of; };

// The nodes by their numbers follow the head, then the numbers of the bottoms.
uint64_t kept_nodes_at(uint64_t kept) { return kept + 16ul; }
uint64_t kept_bottoms_at(uint64_t kept) { return kept + 16ul + 64ul * kept_head(kept).of.room; }

#ifndef TREE_PUSH // the kernel has its own
// vulkan/trees.c hands these over. What a kernel does not need is not there.
layout(push_constant, scalar) uniform clast_tree_push {
    uint64_t jobs;
    uint64_t work;   // clast_tree_work of each job, and one whose root is how much the queue holds
    uint64_t keys;   // of the items of all jobs, in their order; sorted: in the order of `order`
    uint64_t order;  // numbers of items, counted through all jobs
    uint64_t pairs;  // clast_tree_pair: a job's begin where its items do
    uint64_t slots;  // of tree_pairs.comp: two numbers for each item
    uint64_t ranges; // of tree_pairs.comp: where the range ends that waits at an item; 0xffffffff: none does
    uint64_t queue;  // of tree_widen.comp: two numbers each
    uint job_count;
    uint item_count;  // of all jobs
    uint group_count;
    uint phase;       // of tree_widen.comp
    uint code_bits;   // of a key: those below are the place, those above the job
}
push;

// The last job that begins at or before an item.
uint job_of_item(uint item)
{
    uint low = 0u, high = push.job_count;
    while (low + 1u < high) {
        uint middle = (low + high) >> 1u;
        if (tree_jobs(push.jobs).at[middle].first <= item) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

#endif

clast_box load_item_box(uint64_t boxes_address, uint item)
{
    clast_box box = boxes(boxes_address).at[item];
    return sound_box(box);
}

// What a child that is an item says.
uint item_child(uint64_t items, uint item) { return CHILD_ITEM | (items != 0ul ? uints(items).at[item] : item); }

#endif
