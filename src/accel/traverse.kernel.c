// SPDX-License-Identifier: Apache-2.0
// Rays through the trees, one by one: a stack for the TLAS and one for the BLAS that the ray is in; no recursion.
#include "accel/ray_hits.h"

typedef struct stack_entry {
    float near;
    uint32_t child;
} stack_entry;

// Puts an entry among those above `bottom`, the nearest on top; of equal ones the first to come.
CLAST_LANES void push_sorted(stack_entry *stack, uint32_t bottom, uint32_t *height, stack_entry entry)
{
    uint32_t place = (*height)++;
    for (; place > bottom && stack[place - 1].near <= entry.near; place--) {
        stack[place] = stack[place - 1];
    }
    stack[place] = entry;
}

// Where a BLAS's nodes and clusters lie.
typedef struct child_arrays {
    const clast_node *nodes;
    const uint8_t *slots;
    size_t stride;
} child_arrays;

// Fetches a child that waits on the stack: two or three lines.
CLAST_LANES void prefetch_child(const child_arrays *arrays, uint32_t child)
{
    size_t size = (child & CLAST_CHILD_ITEM) != 0 ? arrays->stride : sizeof(clast_node);
    const uint8_t *first = (child & CLAST_CHILD_ITEM) != 0 ? arrays->slots : (const uint8_t *)arrays->nodes;
    const uint8_t *at = first + (child & ~CLAST_CHILD_ITEM) * size;
    __builtin_prefetch(at);
    __builtin_prefetch(at + 64);
    __builtin_prefetch(at + 128);
}

// The children of a node that were hit: gives the nearest, pushes the others. There must be one. `arrays` null: nothing is
// fetched ahead.
CLAST_LANES stack_entry nearest_child(stack_entry *stack, uint32_t *height, const uint32_t *children,
                                      const box_hits *hits, const child_arrays *arrays)
{
    float near[TREE_WIDTH];
    memcpy(near, &hits->near, sizeof near);
    uint32_t bits = hits->bits, lane = (uint32_t)__builtin_ctz(bits);
    stack_entry nearest = {near[lane], children[lane]};
    bits &= bits - 1;
    uint32_t bottom = *height;
    while (bits != 0) {
        lane = (uint32_t)__builtin_ctz(bits);
        bits &= bits - 1;
        stack_entry entry = {near[lane], children[lane]};
        if (arrays != NULL) {
            prefetch_child(arrays, entry.child);
        }
        if (entry.near < nearest.near) {
            stack_entry other = nearest;
            nearest = entry;
            entry = other;
        }
        push_sorted(stack, bottom, height, entry);
    }
    return nearest;
}

// The blocks of a cluster whose boxes the ray meets, the nearest first. Gives true where the search is over.
CLAST_LANES bool test_cluster(traversal *w, const space *s, uint32_t slot, const clast_clas *clas)
{
    stack_entry blocks[TEMPLATE_BLOCKS];
    uint32_t count = 0, block_count = clas->block_count;
    grid g = make_grid(s, clas->lower);
    for (uint32_t first = 0; first < block_count; first += TREE_WIDTH) {
        box_hits hits = test_boxes(s, &g, &clas->groups[first / CLUSTER_WIDTH][0][0][first % CLUSTER_WIDTH],
                                   CLUSTER_WIDTH, w->limit);
        uint32_t left = block_count - first;
        uint32_t bits = hits.bits & (left < TREE_WIDTH ? (1u << left) - 1u : 0xffu);
        if (bits == 0) {
            continue;
        }
        float near[TREE_WIDTH];
        memcpy(near, &hits.near, sizeof near);
        while (bits != 0) {
            uint32_t lane = (uint32_t)__builtin_ctz(bits);
            bits &= bits - 1;
            __builtin_prefetch(&clast_clas_topology(clas)->blocks[first + lane]);
            push_sorted(blocks, 0, &count, (stack_entry){near[lane], first + lane});
        }
    }
    if (count > 0) { // the blocks say which vertices they need when they arrive; till then, all of them
        for (uint32_t i = 0; i < clast_clas_topology(clas)->vertex_count; i += 5) {
            __builtin_prefetch(clast_clas_vertices(clas) + 3 * i);
        }
    }
    while (count > 0 && blocks[--count].near <= w->limit) {
        if (test_block(w, slot, clas, &clast_clas_topology(clas)->blocks[blocks[count].child])) {
            return true;
        }
    }
    return false;
}

// ---------------------------------------------------------------------------------------------------------------- trees

// Gives true where the search is over.
static bool traverse_blas(traversal *w)
{
    const clast_blas *blas = w->placement->blas;
    const child_arrays arrays = {blas->tree.nodes, blas->pool->slots, blas->pool->stride};
    const space s = w->object;
    stack_entry stack[TREE_STACK];
    uint32_t height = 0, steps = 0;
    stack_entry top = {-INFINITY, 0};
    for (;;) {
        steps++;
        if ((top.child & CLAST_CHILD_ITEM) == 0) {
            const clast_node *node = &arrays.nodes[top.child];
            grid g = make_grid(&s, node->lower);
            box_hits hits = test_boxes(&s, &g, node->boxes[0][0], TREE_WIDTH, w->limit);
            hits.bits &= (1u << node->child_count) - 1u;
            if (hits.bits != 0) {
                top = nearest_child(stack, &height, node->children, &hits, &arrays);
                continue;
            }
        } else {
            uint32_t slot = top.child & ~CLAST_CHILD_ITEM;
            if (test_cluster(w, &s, slot, (const clast_clas *)(const void *)(arrays.slots + slot * arrays.stride))) {
                w->steps += steps;
                return true;
            }
        }
        do {
            if (height == 0) {
                w->steps += steps;
                return false;
            }
            top = stack[--height];
        } while (top.near > w->limit);
    }
}

// `direction` has its largest component in [1, 2) by 2^exponent.
static void traverse_tlas(const clast_tlas *tlas, traversal *w, clast_floats4 direction, int exponent)
{
    clast_floats4 origin = load_three4(w->ray->origin);
    float reach = reach_of(origin, &tlas->tree.boxes[0]),
          pad = min1(reach * PAD_WORLD * tlas->spread, BOX_COORDINATE_MOST);
    space world = make_space(origin, direction, exponent, reach, pad, w->ray->t_min);
    float limit = scale_by(w->best.t, world.exponent);
    stack_entry stack[TREE_STACK];
    uint32_t height = 0;
    stack_entry top = {-INFINITY, 0};
    for (;;) {
        if ((top.child & CLAST_CHILD_ITEM) == 0) {
            w->steps++;
            const clast_node *node = &tlas->tree.nodes[top.child];
            grid g = make_grid(&world, node->lower);
            box_hits hits = test_boxes(&world, &g, node->boxes[0][0], TREE_WIDTH, limit);
            hits.bits &= (1u << node->child_count) - 1u;
            if (hits.bits != 0) {
                top = nearest_child(stack, &height, node->children, &hits, NULL);
                continue;
            }
        } else if (enter_instance(w, &tlas->placements[top.child & ~CLAST_CHILD_ITEM], direction, exponent)) {
            if (traverse_blas(w)) {
                return;
            }
            limit = scale_by(w->best.t, world.exponent);
        }
        do {
            if (height == 0) {
                return;
            }
            top = stack[--height];
        } while (top.near > limit);
    }
}

CLAST_LANES void traverse(const clast_tlas *tlas, traversal *w)
{
    clast_floats4 direction;
    int exponent;
    if (!begin_ray(w, tlas, &direction, &exponent)) {
        return;
    }
    if (tlas->placement_count > 1) {
        traverse_tlas(tlas, w, direction, exponent);
    } else if (enter_instance(w, &tlas->placements[0], direction, exponent)) {
        traverse_blas(w); // alone: its own tree says whether the ray meets it
    }
}

void CLAST_KERNEL(clast_closest)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                 const clast_hit_filter *filter, clast_hit *hits)
{
    for (size_t i = 0; i < count; i++) {
        traversal w = {.ray = &rays[i], .filter = filter, .any = false};
        traverse(tlas, &w);
        if (w.best_placement != NULL) {
            store_normal(&w);
        }
        w.best.steps = w.steps;
        hits[i] = w.best;
    }
}

void CLAST_KERNEL(clast_any)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                             const clast_hit_filter *filter, uint8_t *occluded)
{
    for (size_t i = 0; i < count; i++) {
        traversal w = {.ray = &rays[i], .filter = filter, .any = true};
        traverse(tlas, &w);
        occluded[i] = w.best_placement != NULL;
    }
}
