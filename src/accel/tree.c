// SPDX-License-Identifier: Apache-2.0
// Trees over boxes. First a binary tree, cut top down by the surface area heuristic over bins (Wald, On fast Construction of
// SAH-based Bounding Volume Hierarchies, 2007); then its nodes are gathered into nodes of eight children, at the least
// expected cost, by dynamic programming (Ylitie, Karras, Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed
// Wide BVHs, HPG 2017, section 3). What each step does depends on the boxes alone, not on threads.
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "base/simd.h"
#include "base/thread.h"
#include "shared/box.h"

enum {
    BINS = 16,
    SUBTREE_ITEMS = 1024, // ranges of fewer items are built whole by one thread
    MOST_SUBTREES = 4096,
    GATHER_GRAIN = 2048,
    ROOTS = TREE_WIDTH + 1, // costs are kept for 1 to 8 roots, by number
};

static void box_include(clast_box *to, const clast_box *box)
{
    to->lower = store3(min3(load3(to->lower), load3(box->lower)));
    to->upper = store3(max3(load3(to->upper), load3(box->upper)));
}

// -------------------------------------------------------------------------------------------------------- binary tree

// An item, its box scaled so that all lie within [0, 1].
typedef struct build_item {
    clast_floats4 lower, upper;
    uint32_t number;
} build_item;

// In preorder: a node over the items [begin, end) is followed by its left half, then its right.
typedef struct binary_node {
    clast_floats4 lower, upper;
    uint32_t right; // 0: a leaf, over one item
    uint32_t item;
} binary_node;

// Part of the tree that is still one range.
typedef struct build_range {
    uint32_t begin, end, node, depth;
} build_range;

typedef struct builder {
    clast_context *context;
    const clast_box *boxes;
    const uint32_t *numbers;
    uint32_t count;
    build_item *order;
    binary_node *nodes; // 2 * count - 1
    build_range *ranges, *next_ranges;
    uint32_t range_count;
    clast_box whole;
    float scale;
    // the gathering
    float (*costs)[ROOTS];    // of a node as at most so many roots
    uint8_t (*shares)[ROOTS]; // how many of these the left half gets; 0: fewer roots are no worse
    uint32_t *roots;          // binary nodes that became wide ones, level by level
    uint32_t wide_count;
} builder;

typedef struct span {
    clast_floats4 lower, upper;
} span;

CLAST_LANES span span_empty(void)
{
    return (span){splat4(INFINITY), splat4(-INFINITY)};
}

CLAST_LANES void span_include(span *s, clast_floats4 lower, clast_floats4 upper)
{
    s->lower = min4(lower, s->lower);
    s->upper = max4(upper, s->upper);
}

CLAST_LANES float span_area(clast_floats4 lower, clast_floats4 upper)
{
    clast_floats4 size = upper - lower;
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

static span range_span(const builder *b, uint32_t begin, uint32_t end)
{
    span s = span_empty();
    for (uint32_t i = begin; i < end; i++) {
        span_include(&s, b->order[i].lower, b->order[i].upper);
    }
    return s;
}

typedef struct bins {
    span spans[3][BINS];
    uint32_t counts[3][BINS];
} bins;

typedef struct bin_map {
    clast_floats4 base, scale; // bin = (lower + upper - base) * scale
} bin_map;

CLAST_LANES clast_ints4 bin_of(const bin_map *map, const build_item *item)
{
    clast_floats4 place = (item->lower + item->upper - map->base) * map->scale;
    return __builtin_convertvector(min4(place, splat4(BINS - 1)), clast_ints4);
}

static void fill_bins(const builder *b, const build_range *range, const bin_map *map, bins *filled)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < BINS; i++) {
            filled->spans[axis][i] = span_empty();
            filled->counts[axis][i] = 0;
        }
    }
    for (uint32_t i = range->begin; i < range->end; i++) {
        const build_item *item = &b->order[i];
        clast_ints4 bin = bin_of(map, item);
        for (int axis = 0; axis < 3; axis++) {
            span_include(&filled->spans[axis][bin[axis]], item->lower, item->upper);
            filled->counts[axis][bin[axis]]++;
        }
    }
}

// The cheapest cut between bins: axis, and the first bin on its right; 0 where there is none.
typedef struct bin_cut {
    float cost;
    int axis, bin;
} bin_cut;

static void try_cuts(const bins *filled, int axis, bin_cut *best)
{
    float right_costs[BINS];
    span s = span_empty();
    uint32_t count = 0;
    for (int i = BINS - 1; i > 0; i--) {
        span_include(&s, filled->spans[axis][i].lower, filled->spans[axis][i].upper);
        count += filled->counts[axis][i];
        right_costs[i] = count != 0 ? span_area(s.lower, s.upper) * (float)count : INFINITY;
    }
    s = span_empty();
    count = 0;
    for (int i = 1; i < BINS; i++) {
        span_include(&s, filled->spans[axis][i - 1].lower, filled->spans[axis][i - 1].upper);
        count += filled->counts[axis][i - 1];
        float cost = count != 0 ? span_area(s.lower, s.upper) * (float)count + right_costs[i] : INFINITY;
        if (cost < best->cost) {
            *best = (bin_cut){cost, axis, i};
        }
    }
}

// Brings the items on the left of a cut to the front; gives where the right begins.
static uint32_t partition_range(builder *b, const build_range *range, const bin_map *map, const bin_cut *cut)
{
    uint32_t left = range->begin, right = range->end;
    while (left < right) {
        if (bin_of(map, &b->order[left])[cut->axis] < cut->bin) {
            left++;
        } else {
            right--;
            build_item item = b->order[left];
            b->order[left] = b->order[right];
            b->order[right] = item;
        }
    }
    return left;
}

// Where to cut a range of two items or more. Halves where no cut between bins tells items apart, and far down, so that no
// input makes a deep tree.
static uint32_t cut_range(builder *b, const build_range *range)
{
    uint32_t half = range->begin + (range->end - range->begin) / 2;
    if (range->depth >= TREE_DEPTH_HEURISTIC) {
        return half;
    }
    span centres = span_empty();
    for (uint32_t i = range->begin; i < range->end; i++) {
        clast_floats4 centre = b->order[i].lower + b->order[i].upper;
        span_include(&centres, centre, centre);
    }
    clast_floats4 size = centres.upper - centres.lower;
    bin_map map = {centres.lower, splat4(0.0f)};
    for (int axis = 0; axis < 3; axis++) {
        map.scale[axis] = size[axis] > 1e-30f ? (float)BINS / size[axis] : 0.0f;
    }
    bins filled;
    fill_bins(b, range, &map, &filled);
    bin_cut best = {INFINITY, 0, 0};
    for (int axis = 0; axis < 3; axis++) {
        try_cuts(&filled, axis, &best);
    }
    return best.bin != 0 ? partition_range(b, range, &map, &best) : half;
}

// Makes a range's node. False where it is a leaf; else gives the halves.
static bool split_range(builder *b, const build_range *range, build_range *left, build_range *right)
{
    binary_node *node = &b->nodes[range->node];
    if (range->end - range->begin == 1) {
        const build_item *item = &b->order[range->begin];
        *node = (binary_node){item->lower, item->upper, 0, item->number};
        return false;
    }
    span s = range_span(b, range->begin, range->end);
    uint32_t middle = cut_range(b, range);
    uint32_t right_node = range->node + 2 * (middle - range->begin);
    *node = (binary_node){s.lower, s.upper, right_node, 0};
    *left = (build_range){range->begin, middle, range->node + 1, range->depth + 1};
    *right = (build_range){middle, range->end, right_node, range->depth + 1};
    return true;
}

static void build_subtree(builder *b, build_range range)
{
    build_range stack[TREE_DEPTH + 1];
    uint32_t waiting = 0;
    for (;;) {
        build_range left, right;
        if (split_range(b, &range, &left, &right)) {
            stack[waiting++] = right;
            range = left;
        } else if (waiting > 0) {
            range = stack[--waiting];
        } else {
            return;
        }
    }
}

static void subtree_job(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    builder *b = data;
    for (size_t i = begin; i < end; i++) {
        build_subtree(b, b->ranges[i]);
    }
}

static void split_job(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    builder *b = data;
    for (size_t i = begin; i < end; i++) {
        build_range *halves = &b->next_ranges[2 * i];
        if (b->ranges[i].end - b->ranges[i].begin <= SUBTREE_ITEMS ||
            !split_range(b, &b->ranges[i], &halves[0], &halves[1])) {
            halves[0] = b->ranges[i];
            halves[1].end = halves[1].begin = 0;
        }
    }
}

// Splits all large ranges once, in parallel. False where none is large.
static bool split_ranges(builder *b)
{
    clast_parallel_for(b->context, b->range_count, 1, split_job, b);
    uint32_t count = 0;
    for (uint32_t i = 0; i < 2 * b->range_count; i++) {
        if (b->next_ranges[i].end != 0) {
            b->ranges[count++] = b->next_ranges[i];
        }
    }
    bool any = count != b->range_count;
    b->range_count = count;
    return any;
}

static void build_binary(builder *b)
{
    b->ranges[0] = (build_range){0, b->count, 0, 0};
    b->range_count = 1;
    while (b->range_count <= MOST_SUBTREES / 2 && split_ranges(b)) {
    }
    clast_parallel_for(b->context, b->range_count, 1, subtree_job, b);
}

// ---------------------------------------------------------------------------------------------------------- gathering

// The least cost of a node's items under at most `n` roots, for n = 1 to 8, from those of its halves.
static void gather_costs(builder *b, uint32_t number)
{
    const binary_node *node = &b->nodes[number];
    float *costs = b->costs[number];
    uint8_t *shares = b->shares[number];
    float area = span_area(node->lower, node->upper);
    if (node->right == 0) {
        for (int n = 1; n < ROOTS; n++) {
            costs[n] = 0.0f; // items are visited alike, however they are gathered
            shares[n] = 0;
        }
        return;
    }
    const float *left = b->costs[number + 1], *right = b->costs[node->right];
    for (int n = 2; n < ROOTS; n++) {
        costs[n] = INFINITY;
        shares[n] = 1;
        for (int share = 1; share < n; share++) {
            float cost = left[share] + right[n - share];
            if (cost < costs[n]) {
                costs[n] = cost;
                shares[n] = (uint8_t)share;
            }
        }
    }
    costs[1] = area + costs[TREE_WIDTH];
    shares[1] = 0;
    for (int n = 2; n < TREE_WIDTH; n++) { // the last is for this node as a root: it must be opened
        if (costs[n] >= costs[n - 1]) {
            costs[n] = costs[n - 1];
            shares[n] = 0;
        }
    }
}

// The children of a wide node: the binary nodes under which its items are gathered, left to right.
static uint32_t gather_children(const builder *b, uint32_t root, uint32_t children[TREE_WIDTH])
{
    struct {
        uint32_t node;
        uint32_t roots;
    } stack[TREE_WIDTH + 1];
    uint32_t waiting = 0, count = 0;
    if (b->nodes[root].right == 0) {
        children[0] = root;
        return 1;
    }
    uint32_t share = b->shares[root][TREE_WIDTH];
    stack[waiting].node = b->nodes[root].right;
    stack[waiting++].roots = TREE_WIDTH - share;
    stack[waiting].node = root + 1;
    stack[waiting++].roots = share;
    while (waiting > 0) {
        waiting--;
        uint32_t node = stack[waiting].node, roots = stack[waiting].roots;
        while (roots > 1 && b->shares[node][roots] == 0) {
            roots--;
        }
        share = b->shares[node][roots];
        if (roots == 1 || b->nodes[node].right == 0) {
            children[count++] = node;
            continue;
        }
        stack[waiting].node = b->nodes[node].right;
        stack[waiting++].roots = roots - share;
        stack[waiting].node = node + 1;
        stack[waiting++].roots = share;
    }
    return count;
}

// Finds the wide nodes, level by level, and how their children are numbered.
static void number_nodes(builder *b, clast_tree *tree)
{
    uint32_t found = 1, done = 0;
    b->roots[0] = 0;
    tree->level_count = 0;
    while (done < found) {
        tree->levels[tree->level_count++] = done;
        for (uint32_t level_end = found; done < level_end; done++) {
            uint32_t children[TREE_WIDTH];
            uint32_t count = gather_children(b, b->roots[done], children);
            for (uint32_t i = 0; i < count; i++) {
                if (b->nodes[children[i]].right != 0) {
                    b->roots[found++] = children[i];
                }
            }
        }
    }
    tree->levels[tree->level_count] = found;
    b->wide_count = found;
}

static void link_nodes(const builder *b, clast_tree *tree)
{
    uint32_t next = 1;
    for (uint32_t i = 0; i < tree->node_count; i++) {
        clast_node *node = &tree->nodes[i];
        memset(node, 0, sizeof *node);
        uint32_t children[TREE_WIDTH];
        node->child_count = (uint8_t)gather_children(b, b->roots[i], children);
        for (uint32_t k = 0; k < node->child_count; k++) {
            const binary_node *child = &b->nodes[children[k]];
            node->children[k] = child->right != 0 ? next++ : (CLAST_CHILD_ITEM | child->item);
        }
    }
}

static clast_status gather(builder *b, clast_tree *tree)
{
    for (uint32_t i = 2 * b->count - 1; i-- > 0;) {
        gather_costs(b, i);
    }
    number_nodes(b, tree);
    if (CLAST_RESERVE(b->context, tree->nodes, tree->node_capacity, b->wide_count) != CLAST_OK ||
        CLAST_RESERVE(b->context, tree->boxes, tree->box_capacity, b->wide_count) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    tree->node_count = b->wide_count;
    link_nodes(b, tree);
    return CLAST_OK;
}

// ---------------------------------------------------------------------------------------------------------------- all

static void gather_items(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    builder *b = data;
    for (size_t i = begin; i < end; i++) {
        uint32_t number = b->numbers != NULL ? b->numbers[i] : (uint32_t)i;
        clast_box box = b->boxes[number];
        build_item *item = &b->order[i];
        item->number = number;
        if (clast_box_is_empty(&box)) {
            box = (clast_box){b->whole.lower, b->whole.lower};
        }
        for (int axis = 0; axis < 3; axis++) {
            item->lower[axis] = (box.lower.v[axis] - b->whole.lower.v[axis]) * b->scale;
            item->upper[axis] = (box.upper.v[axis] - b->whole.lower.v[axis]) * b->scale;
        }
        item->lower[3] = item->upper[3] = 0.0f;
    }
}

static void begin_build(builder *b)
{
    b->whole = clast_box_empty();
    for (uint32_t i = 0; i < b->count; i++) {
        clast_box box = b->boxes[b->numbers != NULL ? b->numbers[i] : i];
        box_include(&b->whole, &box);
    }
    if (clast_box_is_empty(&b->whole)) {
        memset(&b->whole, 0, sizeof b->whole);
    }
    float size = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        size = max1(size, b->whole.upper.v[axis] - b->whole.lower.v[axis]);
    }
    b->scale = size > 1e-37f ? 1.0f / size : 0.0f;
    clast_parallel_for(b->context, b->count, GATHER_GRAIN, gather_items, b);
}

// All working memory of a build over b->count items. Without memory in the arena this only counts.
static void take_scratch(builder *b, clast_arena *arena)
{
    size_t nodes = 2 * (size_t)b->count - 1;
    b->order = clast_arena_take(arena, b->count, sizeof *b->order);
    b->nodes = clast_arena_take(arena, nodes, sizeof *b->nodes);
    b->ranges = clast_arena_take(arena, MOST_SUBTREES, sizeof *b->ranges);
    b->next_ranges = clast_arena_take(arena, MOST_SUBTREES, sizeof *b->next_ranges);
    b->costs = clast_arena_take(arena, nodes, sizeof *b->costs);
    b->shares = clast_arena_take(arena, nodes, sizeof *b->shares);
    b->roots = clast_arena_take(arena, b->count, sizeof *b->roots);
}

size_t clast_tree_scratch(size_t count)
{
    builder b = {.count = (uint32_t)count};
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

clast_status clast_tree_build(clast_context *context, clast_tree *tree, const clast_box *boxes, const uint32_t *numbers,
                              size_t count, clast_build build, clast_arena *scratch)
{
    (void)build;
    tree->node_count = 0;
    tree->level_count = 0;
    if (count == 0) {
        return CLAST_OK;
    }
    builder b = {.context = context, .boxes = boxes, .numbers = numbers, .count = (uint32_t)count};
    take_scratch(&b, scratch);
    begin_build(&b);
    build_binary(&b);
    clast_status status = gather(&b, tree);
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
