// SPDX-License-Identifier: Apache-2.0
// Rays through the trees, one by one: a stack for the TLAS and one for the BLAS that the ray is in; no recursion.
#include "accel/ray_stack.h"

// What waits, the next on top: keys and children.
#define RAY_STACK_ROOM (TREE_STACK + TREE_WIDTH)

// Fetches what waits on top, as it comes next unless something near is hit: two lines.
CLAST_LANES void prefetch_top(const clast_blas *blas, const uint32_t *stack, uint32_t height)
{
    if (height > 0) {
        uint32_t child = stack[height - 1];
        const uint8_t *at = (child & CLAST_CHILD_ITEM) != 0
                                ? (const uint8_t *)clast_pool_slot(blas->pool, child & ~CLAST_CHILD_ITEM)
                                : (const uint8_t *)&blas->tree.nodes[child];
        __builtin_prefetch(at);
        __builtin_prefetch(at + 64);
    }
}

// The nearest hit within the ray's instance. Gives true where the search is over.
static bool closest_in_blas(traversal *w)
{
    const clast_blas *blas = w->placement->blas;
    const clast_node *nodes = blas->tree.nodes;
    const space s = w->object;
    int32_t stack_keys[RAY_STACK_ROOM];
    uint32_t stack[RAY_STACK_ROOM], height = 0, child = 0, steps = 0;
    do {
        steps++;
        if ((child & CLAST_CHILD_ITEM) == 0) {
            box_hits hits = test_node(&s, &nodes[child], w->limit);
            if (hits.bits != 0) {
                child = push_children(stack_keys, stack, &height, &nodes[child], &hits);
                continue;
            }
        } else {
            uint32_t slot = child & ~CLAST_CHILD_ITEM;
            prefetch_top(blas, stack, height);
            test_cluster(w, &s, slot, clast_pool_slot(blas->pool, slot));
        }
        if (!pop_child(stack_keys, stack, &height, w->cull, &child)) {
            break;
        }
    } while (true);
    w->steps += steps;
    return false;
}

// Whether there is any hit within the ray's instance: then the search is over. Children come as they lie in their node: what
// finding the nearest would save is less than what it takes.
static bool any_in_blas(traversal *w)
{
    const clast_blas *blas = w->placement->blas;
    const clast_node *nodes = blas->tree.nodes;
    const space s = w->object;
    uint32_t stack[RAY_STACK_ROOM], height = 0, child = 0;
    do {
        if ((child & CLAST_CHILD_ITEM) == 0) {
            const clast_node *node = &nodes[child];
            uint32_t bits = test_node(&s, node, w->limit).bits;
            if (bits != 0) {
                clast_ints8 children;
                memcpy(&children, node->children, sizeof children);
                children = gather_lanes8(children, bits & (bits - 1));
                memcpy(stack + height, &children, sizeof children);
                height += (uint32_t)__builtin_popcount(bits) - 1;
                child = node->children[__builtin_ctz(bits)];
                continue;
            }
        } else {
            uint32_t slot = child & ~CLAST_CHILD_ITEM;
            prefetch_top(blas, stack, height);
            if (test_cluster_any(w, &s, slot, clast_pool_slot(blas->pool, slot))) {
                return true;
            }
        }
        if (height == 0) {
            return false;
        }
        child = stack[--height];
    } while (true);
}

CLAST_LANES bool traverse_blas(traversal *w)
{
    return w->any ? any_in_blas(w) : closest_in_blas(w);
}

// `direction` is tame, by 2^exponent.
CLAST_LANES void traverse_tlas(const clast_tlas *tlas, traversal *w, clast_floats4 direction, int exponent)
{
    clast_floats4 origin = load_three4(w->ray->origin);
    float reach = reach_of(origin, &tlas->tree.boxes[0]),
          pad = min1(reach * PAD_WORLD * tlas->spread, BOX_COORDINATE_MOST);
    const space world = make_space(origin, direction, largest_lane(abs4(direction)), exponent, reach, pad,
                                   w->ray->t_min);
    float limit = distance_in(&world, w->best.t), cull = cull_limit(limit);
    int32_t stack_keys[RAY_STACK_ROOM];
    uint32_t stack[RAY_STACK_ROOM], height = 0;
    uint32_t child = 0;
    do {
        if ((child & CLAST_CHILD_ITEM) == 0) {
            w->steps++;
            const clast_node *node = &tlas->tree.nodes[child];
            box_hits hits = test_node(&world, node, limit);
            if (hits.bits != 0) {
                child = push_children(stack_keys, stack, &height, node, &hits);
                continue;
            }
        } else if (enter_instance(w, &tlas->placements[child & ~CLAST_CHILD_ITEM], direction, exponent)) {
            if (traverse_blas(w)) {
                return;
            }
            limit = distance_in(&world, w->best.t);
            cull = cull_limit(limit);
        }
        if (!pop_child(stack_keys, stack, &height, cull, &child)) {
            return;
        }
    } while (true);
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
        traversal w;
        w.ray = &rays[i];
        w.filter = filter;
        w.any = false;
        traverse(tlas, &w);
        store_hit(&w, &hits[i]);
    }
}

void CLAST_KERNEL(clast_any)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                             const clast_hit_filter *filter, uint8_t *occluded)
{
    for (size_t i = 0; i < count; i++) {
        traversal w;
        w.ray = &rays[i];
        w.filter = filter;
        w.any = true;
        traverse(tlas, &w);
        occluded[i] = w.best_placement != NULL;
    }
}
