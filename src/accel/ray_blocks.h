// SPDX-License-Identifier: Apache-2.0
// A ray through a cluster: which blocks it meets, the nearest first. For the kernel files that trace rays.
#ifndef CLAST_ACCEL_RAY_BLOCKS_H
#define CLAST_ACCEL_RAY_BLOCKS_H

#include "accel/ray_hits.h"

// The blocks of a group that a ray meets: their keys, or the largest integer.
typedef struct block_hits {
    clast_ints8 keys[2];
    uint32_t count;
} block_hits;

// Of a cluster's blocks from `first` on, one group's.
CLAST_LANES block_hits test_group(const space *s, const grid *g, const clast_clas *clas, uint32_t first, float limit)
{
    block_hits found = {.count = 0};
    for (uint32_t half = 0; half < 2; half++) {
        uint32_t before = first + half * TREE_WIDTH,
                 count = clas->block_count > before ? clas->block_count - before : 0;
        box_hits hits = test_boxes(s, g, &clas->groups[first / CLUSTER_WIDTH][0][0][half * TREE_WIDTH], CLUSTER_WIDTH,
                                   count, limit);
        clast_ints8 keys = keys_of8(hits.near, (int32_t)(half * TREE_WIDTH));
        found.keys[half] = pick_ints8(hits.mask, keys, splat_ints8(INT32_MAX));
        found.count += (uint32_t)__builtin_popcount(hits.bits);
    }
    return found;
}

// The nearest one's key. There must be one.
CLAST_LANES int32_t take_nearest(block_hits *hits)
{
    int32_t nearest = least_of8(least_ints8(hits->keys[0], hits->keys[1]));
    for (int half = 0; half < 2; half++) {
        clast_ints8 taken = hits->keys[half] == splat_ints8(nearest);
        hits->keys[half] = (hits->keys[half] & ~taken) | (taken & splat_ints8(INT32_MAX));
    }
    hits->count--;
    return nearest;
}

// Blocks say which vertices they need when they arrive; till then, all of them are fetched.
CLAST_LANES void prefetch_vertices(const clast_clas *clas)
{
    const float *vertices = clast_clas_vertices(clas);
    for (uint32_t i = 0; i < clast_clas_topology(clas)->vertex_count; i += 20) {
        __builtin_prefetch(vertices + 3 * i);
        __builtin_prefetch(vertices + 3 * i + 16);
        __builtin_prefetch(vertices + 3 * i + 32);
        __builtin_prefetch(vertices + 3 * i + 48);
    }
}

// Which blocks are met is known some fifty cycles after the cluster arrives: till then, all of them are on their way.
CLAST_LANES void prefetch_blocks(const clast_clas *clas)
{
    const clast_block *blocks = clast_clas_topology(clas)->blocks;
    for (uint32_t i = 0; i < clas->block_count; i += 8) {
        __builtin_prefetch(&blocks[i]);
        __builtin_prefetch(&blocks[i + 2]);
        __builtin_prefetch(&blocks[i + 4]);
        __builtin_prefetch(&blocks[i + 6]);
    }
}

// The blocks of a cluster whose boxes the ray meets, the nearest of a group first. Gives true where the search is over.
CLAST_LANES bool test_cluster(traversal *w, const space *s, uint32_t slot, const clast_clas *clas)
{
    const clast_block *blocks = clast_clas_topology(clas)->blocks;
    prefetch_blocks(clas);
    grid g = make_grid(s, clas->lower);
    for (uint32_t first = 0; first < clas->block_count; first += CLUSTER_WIDTH) {
        block_hits hits = test_group(s, &g, clas, first, w->limit);
        if (hits.count > 0) {
            prefetch_vertices(clas);
        }
        while (hits.count > 0) {
            int32_t nearest = take_nearest(&hits);
            if (distance_of_key(nearest) > w->cull) {
                if (nearest < 0) {
                    continue; // negative distances come in reverse: a nearer one may follow
                }
                break;
            }
            if (test_block(w, slot, clas, &blocks[first + ((uint32_t)nearest & KEY_LANES)])) {
                return true;
            }
        }
    }
    return false;
}

// The same for any hit, in no order.
CLAST_LANES bool test_cluster_any(traversal *w, const space *s, uint32_t slot, const clast_clas *clas)
{
    const clast_block *blocks = clast_clas_topology(clas)->blocks;
    prefetch_blocks(clas);
    grid g = make_grid(s, clas->lower);
    for (uint32_t first = 0; first < clas->block_count; first += CLUSTER_WIDTH) {
        const uint8_t *sides = clas->groups[first / CLUSTER_WIDTH][0][0];
        uint32_t left = clas->block_count - first, more = left > TREE_WIDTH ? left - TREE_WIDTH : 0;
        uint32_t bits = test_boxes(s, &g, sides, CLUSTER_WIDTH, left, w->limit).bits;
        bits |= test_boxes(s, &g, sides + TREE_WIDTH, CLUSTER_WIDTH, more, w->limit).bits << TREE_WIDTH;
        if (bits != 0) {
            prefetch_vertices(clas);
        }
        for (; bits != 0; bits &= bits - 1) {
            if (test_block(w, slot, clas, &blocks[first + (uint32_t)__builtin_ctz(bits)])) {
                return true;
            }
        }
    }
    return false;
}

#endif
