// SPDX-License-Identifier: Apache-2.0
// From two children to eight, at the least expected cost, by dynamic programming (Ylitie, Karras, Laine, Efficient Incoherent
// Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017, section 3).
#include <math.h>
#include <string.h>

#include "accel/tree_build.h"
#include "base/simd.h"
#include "base/thread.h"

enum { COLLAPSE_GRAIN = 128 };

// -------------------------------------------------------------------------------------------------------------- costs

// Items are visited alike, however they are gathered: they cost nothing. A leaf's stay together, or each goes alone.
static void leaf_costs(const clast_binary_node *node, float costs[TREE_WIDTH], uint8_t shares[TREE_WIDTH])
{
    for (uint32_t n = 1; n <= TREE_WIDTH; n++) {
        costs[n - 1] = n >= node->count ? 0.0f : node->area;
        shares[n - 1] = 0;
    }
}

// The least of some lanes so far, and where it was found.
typedef struct least_lanes {
    clast_floats4 costs;
    clast_ints4 shares;
} least_lanes;

static inline void try_share(least_lanes *least, int share, float left, clast_floats4 right)
{
    clast_floats4 cost = splat4(left) + right;
    clast_ints4 less = cost < least->costs;
    least->costs = pick4(less, cost, least->costs);
    least->shares = (less & share) | (~less & least->shares);
}

// Lanes of two vectors from the `first` on.
#define LANES_FROM(a, b, first) __builtin_shufflevector(a, b, first, (first) + 1, (first) + 2, (first) + 3)

static inline clast_floats4 running_least(clast_floats4 v, clast_floats4 none)
{
    v = min4(v, LANES_FROM(none, v, 3));
    return min4(v, LANES_FROM(none, v, 2));
}

void clast_tree_costs(clast_tree_builder *b, uint32_t number)
{
    const clast_binary_node *node = &b->nodes[number];
    if (node->right == 0) {
        leaf_costs(node, b->costs[number], b->shares[number]);
        return;
    }
    // Lane n - 1 is for n roots: the left half gets `share` of them, the right half what is left.
    const float *left = b->costs[number + 1];
    const clast_floats4 none = splat4(INFINITY);
    clast_floats4 few, many; // of the right half: one to four roots, five to eight
    memcpy(&few, b->costs[node->right], sizeof few);
    memcpy(&many, b->costs[node->right] + 4, sizeof many);
    least_lanes low = {none, {1, 1, 1, 1}}, high = low;
    try_share(&low, 1, left[0], LANES_FROM(none, few, 3));
    try_share(&low, 2, left[1], LANES_FROM(none, few, 2));
    try_share(&low, 3, left[2], LANES_FROM(none, few, 1));
    try_share(&high, 1, left[0], LANES_FROM(few, many, 3));
    try_share(&high, 2, left[1], LANES_FROM(few, many, 2));
    try_share(&high, 3, left[2], LANES_FROM(few, many, 1));
    try_share(&high, 4, left[3], few);
    try_share(&high, 5, left[4], LANES_FROM(none, few, 3));
    try_share(&high, 6, left[5], LANES_FROM(none, few, 2));
    try_share(&high, 7, left[6], LANES_FROM(none, few, 1));
    // As one root it is opened with all eight, and no number of roots costs more than fewer do. The last lane is for this node
    // as a root: it must be opened.
    clast_floats4 lowest = low.costs;
    lowest[0] = node->area + high.costs[3];
    lowest = running_least(lowest, none);
    low.shares &= ~(low.costs >= LANES_FROM(none, lowest, 3));
    clast_floats4 highest = min4(running_least(high.costs, none), splat4(lowest[3]));
    clast_ints4 worse = high.costs >= LANES_FROM(lowest, highest, 3);
    worse[3] = 0;
    highest[3] = high.costs[3];
    high.shares &= ~worse;
    memcpy(b->costs[number], &lowest, sizeof lowest);
    memcpy(b->costs[number] + 4, &highest, sizeof highest);
    for (int i = 0; i < 4; i++) {
        b->shares[number][i] = (uint8_t)low.shares[i];
        b->shares[number][i + 4] = (uint8_t)high.shares[i];
    }
}

// ------------------------------------------------------------------------------------------------------------ children

static uint32_t item_number(const clast_build_item *item)
{
    return item->number_low | (uint32_t)item->number_high << 16;
}

static void add_items(const clast_tree_builder *b, const clast_binary_node *leaf, clast_child_list *list)
{
    for (uint32_t i = 0; i < leaf->count; i++) {
        list->children[list->count++] = CLAST_CHILD_ITEM | item_number(&b->order[leaf->first + i]);
    }
}

static void add_node(clast_child_list *list, uint32_t number)
{
    list->node_bits |= (uint8_t)(1u << list->count);
    list->node_count++;
    list->children[list->count++] = number;
}

// The children of a node that stands for a binary one: those under which its items are gathered.
static void list_children(const clast_tree_builder *b, uint32_t root, clast_child_list *list)
{
    struct {
        uint32_t node, roots;
    } stack[TREE_WIDTH + 1];
    uint32_t waiting = 0, number = root, roots = TREE_WIDTH;
    list->count = list->node_bits = list->node_count = 0;
    for (;;) {
        const clast_binary_node *node = &b->nodes[number];
        while (roots > 1 && b->shares[number][roots - 1] == 0 && node->right != 0) {
            roots--;
        }
        if (node->right == 0 && node->count <= roots) {
            add_items(b, node, list);
        } else if (node->right == 0 || roots == 1) {
            add_node(list, number);
        } else {
            uint32_t share = b->shares[number][roots - 1];
            stack[waiting].node = node->right;
            stack[waiting++].roots = roots - share;
            number++;
            roots = share;
            continue;
        }
        if (waiting == 0) {
            return;
        }
        number = stack[--waiting].node;
        roots = stack[waiting].roots;
    }
}

// ------------------------------------------------------------------------------------------------------------- levels

typedef struct collapse_job {
    clast_tree_builder *b;
    clast_tree *tree;
    uint32_t first; // node of the level
} collapse_job;

static void list_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    collapse_job *job = data;
    for (size_t i = job->first + begin; i < job->first + end; i++) {
        list_children(job->b, job->b->roots[i], &job->b->lists[i]);
    }
}

static void number_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    collapse_job *job = data;
    for (size_t i = job->first + begin; i < job->first + end; i++) {
        clast_child_list *list = &job->b->lists[i];
        uint32_t number = list->first;
        for (uint32_t k = 0; k < list->count; k++) {
            if ((list->node_bits >> k & 1) != 0) {
                job->b->roots[number] = list->children[k];
                list->children[k] = number++;
            }
        }
    }
}

static void store_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    collapse_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const clast_child_list *list = &job->b->lists[i];
        clast_node *node = &job->tree->nodes[i];
        memset(node, 0, sizeof *node);
        node->child_count = list->count;
        memcpy(node->children, list->children, list->count * sizeof *list->children);
    }
}

clast_status clast_tree_collapse(clast_tree_builder *b, clast_tree *tree)
{
    collapse_job job = {b, tree, 0};
    uint32_t found = 1;
    b->roots[0] = 0;
    tree->level_count = 0;
    while (job.first < found) {
        uint32_t level_end = found;
        tree->levels[tree->level_count++] = job.first;
        clast_parallel_for(b->context, level_end - job.first, COLLAPSE_GRAIN, list_range, &job);
        for (uint32_t i = job.first; i < level_end; i++) {
            b->lists[i].first = found;
            found += b->lists[i].node_count;
        }
        clast_parallel_for(b->context, level_end - job.first, COLLAPSE_GRAIN, number_range, &job);
        job.first = level_end;
    }
    tree->levels[tree->level_count] = found;
    if (CLAST_RESERVE(b->context, tree->nodes, tree->node_capacity, found) != CLAST_OK ||
        CLAST_RESERVE(b->context, tree->boxes, tree->box_capacity, found) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    tree->node_count = found;
    clast_parallel_for(b->context, found, COLLAPSE_GRAIN, store_range, &job);
    return CLAST_OK;
}
