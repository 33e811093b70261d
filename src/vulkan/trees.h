// SPDX-License-Identifier: Apache-2.0
// Trees over boxes, built on the device: the twin of accel/tree.c, for clusters of units and for instances. The nodes are those
// of shared/cluster.h.
//
// How many nodes a tree will have is known on the device only, but never are there more than items, and one. Nodes in between
// may be unused. The same boxes give the same nodes. No tree has more than TREE_LEVELS levels.
#ifndef CLAST_VULKAN_TREES_H
#define CLAST_VULKAN_TREES_H

#include "accel/structures.h"
#include "shared/tree.h"
#include "vulkan/gpu.h"

// Addresses are of the device's memory.
typedef struct clast_gpu_tree {
    uint64_t
        boxes; // clast_box of each item; one that is not sound, or lower > upper, is empty. Empty items keep a place
    uint64_t items;  // 32 bits for each item, below 2^31 - 1: what children tell of it; 0: its number
    uint64_t nodes;  // gets clast_tree_node, the root first: clast_gpu_tree_bytes(count) bytes, aligned to 16
    uint64_t bounds; // gets the clast_box around all items, lower > upper where there is none; 0: not wanted
    uint64_t kept;   // gets what fitting the tree anew needs: clast_gpu_tree_kept_bytes(count) bytes; 0: not wanted
    uint32_t count;  // with 0 items there is no root
} clast_gpu_tree;

typedef enum clast_gpu_tree_order {
    CLAST_GPU_TREE_STORED, // eight items that follow each other are one node's: for items whose order is good already
    CLAST_GPU_TREE_SORTED, // whatever the order
} clast_gpu_tree_order;

static inline uint64_t clast_gpu_tree_bytes(uint32_t count)
{
    return (uint64_t)(count != 0 ? count : 1) * sizeof(clast_tree_node);
}

// What trees in stored order take; less.
static inline uint64_t clast_gpu_tree_stored_bytes(uint32_t count)
{
    uint64_t nodes = 0;
    uint32_t level = 1;
    do {
        nodes += level_nodes(count, level);
    } while (level_nodes(count, level++) > 1);
    return (nodes != 0 ? nodes : 1) * sizeof(clast_tree_node);
}

static inline uint64_t clast_gpu_tree_kept_bytes(uint32_t count)
{
    return sizeof(clast_tree_kept) +
           (uint64_t)(count != 0 ? count : 1) * (sizeof(clast_tree_kept_node) + sizeof(uint32_t));
}

// Working memory, for one build after another.
typedef struct clast_gpu_trees clast_gpu_trees;

clast_status clast_gpu_trees_create(clast_gpu *gpu, clast_gpu_trees **trees);
void clast_gpu_trees_destroy(clast_gpu_trees *trees);

// Builds trees together; all items together are less than 2^26, else LIMIT. Errors are noted in the commands too. Has its own
// barriers, before it and between its kernels; what follows needs one.
clast_status clast_gpu_trees_build(clast_gpu_trees *trees, clast_gpu_commands *commands, const clast_gpu_tree *list,
                                   uint32_t count, clast_gpu_tree_order order);
// Fits trees to new boxes of the same items. What is kept is a build's or a shape's; the other addresses may be others than
// then. One kernel, with a barrier before it; what follows needs one.
clast_status clast_gpu_trees_refit(clast_gpu_trees *trees, clast_gpu_commands *commands, const clast_gpu_tree *list,
                                   uint32_t count);
// What is kept of a tree of the processor's over the same items, so that one that was built with care, once, is fitted on the
// device whenever boxes move: to be written to the device, for clast_gpu_trees_refit. Its nodes take
// clast_gpu_tree_bytes(tree->node_count) bytes. UNSUPPORTED where the tree has more than TREE_LEVELS levels, or no nodes.
uint64_t clast_gpu_tree_shape_bytes(const clast_tree *tree);
clast_status clast_gpu_tree_shape(clast_context *context, const clast_tree *tree, void *memory);
// Bytes of the device's memory that builds have taken for work.
uint64_t clast_gpu_trees_bytes(const clast_gpu_trees *trees);

#endif
