// SPDX-License-Identifier: Apache-2.0
// Fits the boxes of a tree's nodes: a node's children are lanes.
#include "accel/quantise.h"
#include "accel/structures.h"

#if defined(__AVX2__)
enum { FETCH_AHEAD = 4 }; // nodes

typedef uint8_t bytes8 __attribute__((vector_size(8)));

static const clast_box no_box = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};

CLAST_LANES const clast_box *child_box(const clast_tree *tree, const clast_box *items, uint32_t child)
{
    const clast_box *boxes = (child & CLAST_CHILD_ITEM) != 0 ? items : tree->boxes;
    return &boxes[child & ~CLAST_CHILD_ITEM];
}

// Items lie anywhere; their boxes are fetched some nodes ahead.
CLAST_LANES void prefetch_items(const clast_tree *tree, const clast_box *items, uint32_t number)
{
    const clast_node *node = &tree->nodes[number];
    for (uint32_t i = 0; i < TREE_WIDTH; i++) {
        if ((node->children[i] & CLAST_CHILD_ITEM) != 0) {
            __builtin_prefetch(&items[node->children[i] & ~CLAST_CHILD_ITEM]);
        }
    }
}

// Eight children's coordinates.
typedef struct child_lanes {
    clast_floats8 lower[3], upper[3];
} child_lanes;

#define LOW_PAIRS(a, b) __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13)
#define HIGH_PAIRS(a, b) __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15)
#define LOW_HALVES(a, b) __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13)
#define HIGH_HALVES(a, b) __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15)

// `fronts` are the first four floats of each two boxes: i and i + 4. `backs` are their last four.
CLAST_LANES child_lanes turn_boxes(const clast_floats8 fronts[4], const clast_floats8 backs[4])
{
    clast_floats8 xy = LOW_PAIRS(fronts[0], fronts[1]), other_xy = LOW_PAIRS(fronts[2], fronts[3]);
    clast_floats8 zx = HIGH_PAIRS(fronts[0], fronts[1]), other_zx = HIGH_PAIRS(fronts[2], fronts[3]);
    clast_floats8 yz = HIGH_PAIRS(backs[0], backs[1]), other_yz = HIGH_PAIRS(backs[2], backs[3]);
    return (child_lanes){
        {LOW_HALVES(xy, other_xy), HIGH_HALVES(xy, other_xy), LOW_HALVES(zx, other_zx)},
        {HIGH_HALVES(zx, other_zx), LOW_HALVES(yz, other_yz), HIGH_HALVES(yz, other_yz)},
    };
}

// The steps of the children; those that are empty, or not there, become boxes inside out.
CLAST_LANES void store_children(clast_node *node, const child_lanes *children, const clast_steps *s)
{
    clast_ints8 there = children->lower[0] <= children->upper[0];
    const clast_ints8 most = {STEPS_MOST, STEPS_MOST, STEPS_MOST, STEPS_MOST,
                              STEPS_MOST, STEPS_MOST, STEPS_MOST, STEPS_MOST};
    for (int axis = 0; axis < 3; axis++) {
        clast_floats8 base = splat_lane8(s->base, axis);
        clast_ints8 down = steps_down8(children->lower[axis] - base, splat_lane8(s->down, axis));
        clast_ints8 up = steps_up8(children->upper[axis] - base, splat_lane8(s->up, axis));
        bytes8 lower = __builtin_convertvector((down & there) | (most & ~there), bytes8);
        bytes8 upper = __builtin_convertvector(up & there, bytes8);
        memcpy(node->boxes[axis][0], &lower, sizeof lower);
        memcpy(node->boxes[axis][1], &upper, sizeof upper);
    }
}

CLAST_LANES void refit_node(clast_tree *tree, const clast_box *items, uint32_t number)
{
    clast_node *node = &tree->nodes[number];
    const clast_box *from[TREE_WIDTH];
    for (uint32_t i = 0; i < TREE_WIDTH; i++) {
        from[i] = i < node->child_count ? child_box(tree, items, node->children[i]) : &no_box;
    }
    clast_floats8 fronts[4], backs[4];
    for (uint32_t i = 0; i < 4; i++) {
        fronts[i] = JOIN4(load_any4(from[i]->lower.v), load_any4(from[i + 4]->lower.v));
        backs[i] = JOIN4(load_any4(from[i]->lower.v + 2), load_any4(from[i + 4]->lower.v + 2));
    }
    child_lanes children = turn_boxes(fronts, backs);
    clast_floats8 least = min8(min8(fronts[0], fronts[1]), min8(fronts[2], fronts[3]));
    clast_floats8 most = max8(max8(backs[0], backs[1]), max8(backs[2], backs[3]));
    clast_floats4 lower = min4(LOWER_HALF4(least), UPPER_HALF4(least)) + splat4(0.0f);
    clast_floats4 upper = max4(LOWER_HALF4(most), UPPER_HALF4(most)) + splat4(0.0f); // in its last three lanes
    upper = __builtin_shufflevector(upper, upper, 1, 2, 3, 3);
    memcpy(&tree->boxes[number].lower, &lower, sizeof(packed3));
    memcpy(&tree->boxes[number].upper, &upper, sizeof(packed3));
    if (!(lower[0] <= upper[0])) {
        lower = upper = splat4(0.0f);
    }
    clast_ints4 exponents = box_exponents4(upper - lower);
    memcpy(node->lower, &lower, sizeof node->lower);
    for (int axis = 0; axis < 3; axis++) {
        node->exponents[axis] = (uint8_t)exponents[axis];
    }
    clast_steps s = steps_from(lower, exponents);
    store_children(node, &children, &s);
}

void CLAST_KERNEL(clast_refit_nodes)(clast_tree *tree, const clast_box *items, uint32_t begin, uint32_t end)
{
    for (uint32_t i = end; i-- > begin;) {
        if (i >= begin + FETCH_AHEAD) {
            prefetch_items(tree, items, i - FETCH_AHEAD);
        }
        refit_node(tree, items, i);
    }
}

#else // narrower lanes gain nothing

void CLAST_KERNEL(clast_refit_nodes)(clast_tree *tree, const clast_box *items, uint32_t begin, uint32_t end)
{
    for (uint32_t i = end; i-- > begin;) {
        clast_tree_refit_node(tree, items, i);
    }
}

#endif
