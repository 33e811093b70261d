// SPDX-License-Identifier: Apache-2.0
// A tree being built: what the steps of tree_split.c and tree_collapse.c share.
#ifndef CLAST_ACCEL_TREE_BUILD_H
#define CLAST_ACCEL_TREE_BUILD_H

#include "accel/structures.h"

enum {
    GRID_MOST = 16383, // coordinates of items have 14 bits, so that sums of two and products of two fit
    MOST_SUBTREES = 4096,
    ITEM_GRAIN = 2048,
};

typedef int16_t clast_words8 __attribute__((vector_size(16)));

// An item: its box on a grid over the items around it. The lower sides are negated, so that a maximum unites boxes.
typedef union clast_build_item {
    clast_words8 lanes;
    struct {
        int16_t minus_lower[3];
        uint16_t number_low;
        int16_t upper[3];
        uint16_t number_high;
    };
} clast_build_item;
_Static_assert(sizeof(clast_build_item) == 16, "a vector");

// In preorder: a node's left half follows it, its right half is told.
typedef struct clast_binary_node {
    float area;     // half a box's, the whole tree's extent being one
    uint32_t right; // zero: a leaf, over the items [first, first + count)
    uint32_t first, count;
} clast_binary_node;

// Part of the tree that is still one range. Its nodes are among the 2 * (end - begin) - 1 from `node` on.
typedef struct clast_build_range {
    uint32_t begin, end, node, depth;
    uint32_t node_count; // of a subtree that is done
    float unit;          // a grid step's share of the whole extent, squared
} clast_build_range;

// The children of a node that is to be, left to right.
typedef struct clast_child_list {
    uint32_t children[TREE_WIDTH]; // items and binary nodes, later numbers of nodes
    uint32_t first;                // number of the first that is a node
    uint8_t count, node_bits, node_count;
} clast_child_list;

typedef struct clast_tree_builder {
    clast_context *context;
    const clast_box *boxes;
    const uint32_t *numbers; // of the items' boxes; null: all from 0 on
    uint32_t count;
    uint32_t leaf_items;    // ranges of so many are not split
    uint32_t bins;          // between which cuts are sought
    int32_t least_steps;    // of the whole's grid; a subtree that covers fewer has a grid of its own
    uint32_t subtree_items; // ranges of fewer are built whole by one thread
    clast_box whole;
    float extent;     // the whole box's longest side
    clast_box *parts; // around each ITEM_GRAIN items
    clast_build_item *order, *spare;
    clast_binary_node *nodes;
    clast_build_range *ranges, *next_ranges;
    uint32_t range_count;
    uint32_t *tops; // nodes above the subtrees, each after its parent
    uint32_t top_count;
    // The least cost of a node's items under at most n roots at n - 1, and how many of these its left half gets; 0 where fewer
    // roots are no worse.
    float (*costs)[TREE_WIDTH];
    uint8_t (*shares)[TREE_WIDTH];
    uint32_t *roots; // binary nodes that became nodes, level by level
    clast_child_list *lists;
} clast_tree_builder;

// A builder over items as clast_tree_build's, with all working memory.
clast_tree_builder clast_tree_builder_make(clast_context *context, const clast_box *boxes, const uint32_t *numbers,
                                           size_t count, clast_build build, clast_arena *scratch);
// Cuts the items into a binary tree and computes the costs of gathering it.
void clast_tree_split(clast_tree_builder *b);
// The same in steps, for those who cannot wait for all of it: the beginning; then large ranges, once each, until there are none;
// then the b->range_count subtrees, any of them at a time; then the rest.
void clast_tree_split_begin(clast_tree_builder *b);
bool clast_tree_split_large(clast_tree_builder *b);
void clast_tree_split_subtrees(clast_tree_builder *b, uint32_t first, uint32_t count);
void clast_tree_split_end(clast_tree_builder *b);
// The costs of a node, from those of its halves.
void clast_tree_costs(clast_tree_builder *b, uint32_t node);
// Gathers binary nodes into nodes of eight. The tree's boxes are not fitted.
clast_status clast_tree_collapse(clast_tree_builder *b, clast_tree *tree);

#endif
