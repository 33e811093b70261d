// SPDX-License-Identifier: Apache-2.0
// Trees over boxes. First a binary tree, cut top down by the surface area heuristic (tree_split.c); then its nodes are
// gathered into nodes of eight children, at the least expected cost (tree_collapse.c); then boxes are fitted
// (tree_refit.c). What each step does depends on the boxes alone, not on threads. A fast build leaves ranges of up to eight
// items uncut and seeks among fewer cuts.
#include <string.h>

#include "accel/tree_build.h"

enum {
    FAST_LEAF_ITEMS = 8,
    FAST_BINS = 16,
    BEST_BINS = 32,
    FAST_STEPS = 1024,
    BEST_STEPS = 8192,
    SUBTREES = 64,
    SUBTREE_LEAST = 256,
    SUBTREE_MOST = 4096
};

// All working memory of a build over b->count items. Without memory in the arena this only counts.
static void take_scratch(clast_tree_builder *b, clast_arena *arena)
{
    size_t nodes = 2 * (size_t)b->count - 1;
    // Ranges are not empty, and all of them are cut in two at once.
    size_t ranges = nodes < MOST_SUBTREES ? nodes + 1 : MOST_SUBTREES;
    b->parts = clast_arena_take(arena, b->count / ITEM_GRAIN + 1, sizeof *b->parts);
    b->order = clast_arena_take(arena, b->count, sizeof *b->order);
    b->spare = clast_arena_take(arena, b->count, sizeof *b->spare);
    b->nodes = clast_arena_take(arena, nodes, sizeof *b->nodes);
    b->ranges = clast_arena_take(arena, ranges, sizeof *b->ranges);
    b->next_ranges = clast_arena_take(arena, ranges, sizeof *b->next_ranges);
    b->tops = clast_arena_take(arena, ranges, sizeof *b->tops);
    b->costs = clast_arena_take(arena, nodes, sizeof *b->costs);
    b->shares = clast_arena_take(arena, nodes, sizeof *b->shares);
    b->roots = clast_arena_take(arena, b->count, sizeof *b->roots);
    b->lists = clast_arena_take(arena, b->count, sizeof *b->lists);
}

size_t clast_tree_scratch(size_t count)
{
    clast_tree_builder b = {.count = (uint32_t)count};
    clast_arena arena = {NULL, 0};
    if (count != 0) {
        take_scratch(&b, &arena);
    }
    return arena.used;
}

void clast_tree_place(clast_tree *tree, size_t count, clast_arena *arena)
{
    // Each node but a root over a single item has two children or more.
    size_t nodes = count > 1 ? count - 1 : count;
    *tree = (clast_tree){.node_capacity = nodes, .box_capacity = nodes, .placed = true};
    tree->nodes = clast_arena_take(arena, nodes, sizeof *tree->nodes);
    tree->boxes = clast_arena_take(arena, nodes, sizeof *tree->boxes);
}

clast_tree_builder clast_tree_builder_make(clast_context *context, const clast_box *boxes, const uint32_t *numbers,
                                           size_t count, clast_build build, clast_arena *scratch)
{
    clast_tree_builder b = {.context = context,
                            .boxes = boxes,
                            .numbers = numbers,
                            .count = (uint32_t)count,
                            .leaf_items = build == CLAST_BUILD_FAST ? FAST_LEAF_ITEMS : 1,
                            .bins = build == CLAST_BUILD_FAST ? FAST_BINS : BEST_BINS,
                            .least_steps = build == CLAST_BUILD_FAST ? FAST_STEPS : BEST_STEPS,
                            .subtree_items = (uint32_t)count / SUBTREES};
    b.subtree_items = b.subtree_items < SUBTREE_LEAST ? SUBTREE_LEAST : b.subtree_items;
    b.subtree_items = b.subtree_items > SUBTREE_MOST ? SUBTREE_MOST : b.subtree_items;
    take_scratch(&b, scratch);
    return b;
}

clast_status clast_tree_build(clast_context *context, clast_tree *tree, const clast_box *boxes, const uint32_t *numbers,
                              size_t count, clast_build build, clast_arena *scratch)
{
    tree->node_count = 0;
    tree->level_count = 0;
    if (count == 0) {
        return CLAST_OK;
    }
    clast_tree_builder b = clast_tree_builder_make(context, boxes, numbers, count, build, scratch);
    clast_tree_split(&b);
    clast_status status = clast_tree_collapse(&b, tree);
    if (status == CLAST_OK) {
        clast_tree_refit(context, tree, boxes);
    } else {
        tree->level_count = 0;
    }
    return status;
}

void clast_tree_free(clast_context *context, clast_tree *tree)
{
    if (!tree->placed) {
        clast_free(context, tree->nodes);
        clast_free(context, tree->boxes);
    }
    memset(tree, 0, sizeof *tree);
}

uint64_t clast_tree_bytes(const clast_tree *tree)
{
    return tree->node_capacity * sizeof *tree->nodes + tree->box_capacity * sizeof *tree->boxes;
}

clast_box clast_tree_bounds(const clast_tree *tree)
{
    return tree->node_count != 0 ? tree->boxes[0] : clast_box_empty();
}
