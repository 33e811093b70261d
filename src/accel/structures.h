// SPDX-License-Identifier: Apache-2.0
// What the objects of clast/accel.h are made of, and the kernels that run over them.
//
// All trees have one kind of node, with up to eight children whose boxes are quantised (shared/box.h). A cluster is a flat
// node of up to 32 boxes, each around a block of eight triangles, which are tested at once against the cluster's vertices.
#ifndef CLAST_ACCEL_STRUCTURES_H
#define CLAST_ACCEL_STRUCTURES_H

#include <stddef.h>

#include "clast/accel.h"
#include "base/context.h"
#include "base/isa.h"
#include "shared/limits.h"
#include "shared/records.h"

enum {
    TREE_WIDTH = 8,
    TEMPLATE_BLOCKS = TEMPLATE_TRIANGLES / BLOCK_TRIANGLES,
    CLUSTER_GROUPS = TEMPLATE_BLOCKS / TREE_WIDTH,
    // Binary trees are split by the surface area heuristic down to this depth, by halves below it: no deeper than 63.
    TREE_DEPTH_HEURISTIC = 32,
    TREE_DEPTH = 64,
    TREE_STACK = TREE_DEPTH * (TREE_WIDTH - 1) + 1, // of a traversal that pushes all children but one at each level
};

// ---------------------------------------------------------------------------------------------------------- templates

// Eight triangles. Lanes beyond the last one repeat a triangle of the block, under the same number, and so change nothing.
typedef struct clast_block {
    uint8_t corners[3][BLOCK_TRIANGLES]; // vertices of the cluster
    uint8_t triangles[BLOCK_TRIANGLES];  // as the template's maker counts them
} clast_block;

typedef struct clast_template {
    uint16_t triangle_count;
    uint16_t vertex_count;
    uint32_t block_count;
    clast_block blocks[];
} clast_template;

// Template data lie in blocks of memory, one for each call that added some, so that they never move.
struct clast_template_set {
    clast_context *context;
    const clast_template **templates; // by number
    size_t count, capacity;
    void **memory;
    size_t memory_count, memory_capacity;
    uint64_t bytes; // of that memory
    uint32_t most_blocks;
    uint32_t grids[GRID_SEGMENTS][GRID_SEGMENTS]; // [rows - 1][columns - 1]: number plus one, or zero
};

// ------------------------------------------------------------------------------------------------------------- boxes

// Eight boxes: lower x, y, z, then upper x, y, z.
typedef struct clast_box_group {
    uint8_t planes[6][TREE_WIDTH];
} clast_box_group;

// A cluster's CLAS. A pool's slots have one size: with as many groups as its largest template needs.
typedef struct clast_clas {
    float
        lower[3]; // the box around its finite triangles, and the base of the blocks' boxes; lower > upper where none is
    uint8_t exponents[3];
    uint8_t block_count; // zero where nothing can be hit
    float upper[3];
    uint32_t unused;
    const clast_template *topology;
    const float *vertices;
    clast_box_group groups[];
} clast_clas;
_Static_assert(sizeof(clast_clas) == 48, "a slot's header");

struct clast_clas_pool {
    clast_template_set *set;
    clast_context *context;
    uint8_t *slots;
    size_t stride;
    size_t count, capacity;
};

static inline clast_clas *clast_pool_slot(const clast_clas_pool *pool, size_t slot)
{
    return (clast_clas *)(void *)(pool->slots + slot * pool->stride);
}

// ------------------------------------------------------------------------------------------------------------- trees

#define CLAST_CHILD_ITEM 0x80000000u // what follows is an item; without it, a node

typedef struct clast_node {
    float lower[3]; // base of the children's boxes
    uint8_t exponents[3];
    uint8_t child_count;
    clast_box_group boxes;
    uint32_t children[TREE_WIDTH];
} clast_node;
_Static_assert(sizeof(clast_node) == 96, "a node");

// Nodes level by level, the root first.
typedef struct clast_tree {
    clast_node *nodes;
    clast_box *boxes; // of the nodes, not quantised
    uint32_t node_count;
    size_t node_capacity, box_capacity;
    uint32_t level_count;
    uint32_t levels[TREE_DEPTH + 1]; // where each level begins, and the end
} clast_tree;

// Gives the box of an item; lower > upper where it is empty.
typedef clast_box (*clast_item_box)(const void *items, uint32_t item);

// Builds over items `numbers[0..count)`, or 0 to count - 1 where `numbers` is null. Empty items keep a place in the tree.
clast_status clast_tree_build(clast_context *context, clast_tree *tree, clast_item_box item_box, const void *items,
                              const uint32_t *numbers, size_t count);
// Fits all boxes anew. Never fails, allocates nothing.
void clast_tree_refit(clast_context *context, clast_tree *tree, clast_item_box item_box, const void *items);
void clast_tree_free(clast_context *context, clast_tree *tree);
uint64_t clast_tree_bytes(const clast_tree *tree);
clast_box clast_tree_bounds(const clast_tree *tree);

clast_box clast_box_empty(void);
bool clast_box_is_empty(const clast_box *box);

struct clast_blas {
    clast_clas_pool *pool;
    clast_context *context;
    clast_tree tree;
};

// An instance that can be hit.
typedef struct clast_placement {
    float to_object[3][4]; // columns
    float to_world[3][4];
    float origin[4]; // of object space, in the world
    uint32_t id;
    const clast_blas *blas;
    uint32_t index; // in the array given
    bool filtered;
    bool mirrored;
    clast_box box; // in the world, padded for what transforming a ray rounds
} clast_placement;

struct clast_tlas {
    clast_context *context;
    clast_tree tree;
    clast_placement *placements;
    size_t placement_count, placement_capacity;
    float spread; // times a ray's largest distance and 2^-17: how far transforming it may move it, in the world
};

// ----------------------------------------------------------------------------------------------------------- kernels

// Fits the boxes of a slot to its vertices.
typedef void (*clast_fit_kernel)(clast_clas *clas);
typedef void (*clast_closest_kernel)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                     const clast_hit_filter *filter, clast_hit *hits);
typedef void (*clast_any_kernel)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                 const clast_hit_filter *filter, uint8_t *occluded);

typedef struct clast_accel_kernels {
    clast_fit_kernel fit;
    clast_closest_kernel closest;
    clast_any_kernel any;
} clast_accel_kernels;

const clast_accel_kernels *clast_accel_kernels_of(clast_isa isa);

#define CLAST_DECLARE_KERNELS(set) \
    void clast_fit_##set(clast_clas *clas); \
    void clast_closest_##set(const clast_tlas *tlas, const clast_ray *rays, size_t count, \
                             const clast_hit_filter *filter, clast_hit *hits); \
    void clast_any_##set(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter, \
                         uint8_t *occluded);
CLAST_DECLARE_KERNELS(plain)
CLAST_DECLARE_KERNELS(sse42)
CLAST_DECLARE_KERNELS(avx2)

#endif
