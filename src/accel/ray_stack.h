// SPDX-License-Identifier: Apache-2.0
// What waits for a ray, the next on top: keys (ray_boxes.h) and children. For the kernel files that trace rays.
//
// What a ray meets next is hard to foresee, so steps avoid branches: the children that were hit are put in order by a
// sorting network, and all lanes are written to the stack, whose height then says how many of them count: there must be
// room for TREE_WIDTH more.
#ifndef CLAST_ACCEL_RAY_STACK_H
#define CLAST_ACCEL_RAY_STACK_H

#include "accel/ray_blocks.h"

// Takes the nearest of a node's children that were hit, and puts the others on the stack: the nearest on top, where they are no
// more than four. There must be one.
CLAST_LANES uint32_t push_children(int32_t *stack_keys, uint32_t *stack, uint32_t *height, const clast_node *node,
                                   const box_hits *hits)
{
    if ((hits->bits & (hits->bits - 1)) == 0) {
        return node->children[__builtin_ctz(hits->bits)]; // the most frequent case, and the child is known earlier
    }
    clast_ints8 keys = keys_of8(hits->near, 0), children;
    uint32_t nearest = (uint32_t)least_of8(pick_ints8(hits->mask, keys, splat_ints8(INT32_MAX))) & (TREE_WIDTH - 1);
    uint32_t others = hits->bits & ~(1u << nearest);
    keys = pick_ints8(first_lanes8((uint32_t)__builtin_popcount(others)), gather_lanes8(keys, others),
                      splat_ints8(INT32_MIN));
    keys = sort_four_down8(keys);
    memcpy(&children, node->children, sizeof children);
    children = look_up8(children, keys);
    memcpy(stack_keys + *height, &keys, sizeof keys);
    memcpy(stack + *height, &children, sizeof children);
    *height += (uint32_t)__builtin_popcount(others);
    return node->children[nearest];
}

// The next child that is not beyond `cull`; false where there is none.
CLAST_LANES bool pop_child(const int32_t *stack_keys, const uint32_t *stack, uint32_t *height, float cull,
                           uint32_t *child)
{
    uint32_t left = *height;
    do {
        if (left == 0) {
            return false;
        }
        left--;
    } while (distance_of_key(stack_keys[left]) > cull);
    *child = stack[left];
    *height = left;
    return true;
}

#endif
