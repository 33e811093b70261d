// SPDX-License-Identifier: Apache-2.0
// What the objects of clast/accel.h are made of, and the kernels that run over them.
//
// All trees have one kind of node, with up to eight children whose boxes are quantised (shared/box.h). A cluster is a flat
// node of up to 32 boxes, each around a block of eight triangles, which are tested at once against the cluster's vertices.
// What rays read of a full cluster are two cache lines, lines of the blocks that they meet, and lines of these' vertices.
#ifndef CLAST_ACCEL_STRUCTURES_H
#define CLAST_ACCEL_STRUCTURES_H

#include <stddef.h>

#include "clast/accel.h"
#include "accel/memory.h"
#include "base/context.h"
#include "base/isa.h"
#include "shared/limits.h"
#include "shared/records.h"

enum {
    TREE_WIDTH = 8,
    TEMPLATE_BLOCKS = TEMPLATE_TRIANGLES / BLOCK_TRIANGLES,
    CLUSTER_WIDTH = 16, // blocks whose boxes a cluster holds together: those of a full cluster
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
    uint16_t block_count;
    uint16_t all_used; // 1: each vertex is a corner of some triangle
    clast_block blocks[];
} clast_template;

// Builds a template of a desc that was checked, in room for all its blocks.
void clast_template_build(clast_template *made, const clast_template_desc *desc);
// `what` and `place` tell whose fault it is.
clast_status clast_template_check(clast_context *context, const clast_template_desc *desc, const char *what,
                                  size_t place);

static inline uint32_t clast_blocks_of(uint32_t triangles)
{
    return (triangles + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES;
}

// The corners of a triangle, by its maker's number; false where there is none such.
bool clast_template_corners(const clast_template *topology, uint32_t triangle, uint32_t corners[3]);

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
    // The patterns that were added last (patterns.c).
    bool has_patterns;
    uint32_t first_pattern;
    uint64_t pattern_hash;
};

// ------------------------------------------------------------------------------------------------------------- boxes

// A cluster's CLAS. A pool's slots have one size: with as many groups as its largest template needs. What it points to is
// told as a distance in bytes from the CLAS itself, so that a structure can be stored, and mapped anywhere.
typedef struct clast_clas {
    float lower[3]; // base of the blocks' boxes
    uint8_t exponents[3];
    uint8_t block_count; // zero where nothing can be hit
    int64_t topology;    // zero: nothing there
    int64_t vertices;
    uint8_t groups[][3][2][CLUSTER_WIDTH]; // for each axis, the lower sides of the blocks' boxes, then the upper ones
} clast_clas;
_Static_assert(sizeof(clast_clas) == 32, "with the boxes of a full cluster, two cache lines");

struct clast_clas_pool {
    clast_template_set *set;
    clast_context *context;
    clast_reserve reserve; // what all of this lies in
    uint8_t *slots;
    clast_box *boxes;    // of the slots: around their finite triangles, lower > upper where there are none
    uint8_t *topologies; // of slots that have their own, one for each slot
    uint8_t *own;        // of such slots, one after another, where they were set one by one
    size_t stride, topology_stride, own_bytes;
    size_t count, capacity;
};

// Distances between what the caller and the library allocated: by way of integers, as the language has none.
static inline int64_t clast_distance(const void *from, const void *to)
{
    return (int64_t)((uintptr_t)to - (uintptr_t)from);
}

static inline const clast_template *clast_clas_topology(const clast_clas *clas)
{
    return (const clast_template *)((uintptr_t)clas + (uintptr_t)clas->topology);
}

static inline const float *clast_clas_vertices(const clast_clas *clas)
{
    return (const float *)((uintptr_t)clas + (uintptr_t)clas->vertices);
}

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
    uint8_t boxes[3][2][TREE_WIDTH]; // as a CLAS has them
    uint32_t children[TREE_WIDTH];
} clast_node;
_Static_assert(sizeof(clast_node) == 96, "a node");

// Nodes level by level, the root first.
typedef struct clast_tree {
    clast_node *nodes;
    clast_box *boxes; // of the nodes, not quantised
    uint32_t node_count;
    size_t node_capacity, box_capacity;
    bool placed; // in memory that is not the tree's own
    uint32_t level_count;
    uint32_t levels[TREE_DEPTH + 1]; // where each level begins, and the end
} clast_tree;

// Builds over items `numbers[0..count)`, or 0 to count - 1 where `numbers` is null; `boxes[i]` is item i's, lower > upper
// where it is empty. Empty items keep a place in the tree. Working memory comes from `scratch`, which has at least
// clast_tree_scratch(count) bytes left. Nodes are allocated where the tree was not placed in memory for so many items.
clast_status clast_tree_build(clast_context *context, clast_tree *tree, const clast_box *boxes, const uint32_t *numbers,
                              size_t count, clast_build build, clast_arena *scratch);
// Bytes of working memory that any build over at most `count` items takes.
size_t clast_tree_scratch(size_t count);
// Takes memory for a tree over at most `count` items. The tree is empty then, and no longer needs to be freed.
void clast_tree_place(clast_tree *tree, size_t count, clast_arena *arena);
// Fits all boxes anew. Never fails, allocates nothing.
void clast_tree_refit(clast_context *context, clast_tree *tree, const clast_box *boxes);
// Fits one node, whose children's boxes are right.
void clast_tree_refit_node(clast_tree *tree, const clast_box *boxes, uint32_t number);
void clast_tree_free(clast_context *context, clast_tree *tree);
uint64_t clast_tree_bytes(const clast_tree *tree);
clast_box clast_tree_bounds(const clast_tree *tree);

clast_box clast_box_empty(void);
bool clast_box_is_empty(const clast_box *box);

struct clast_blas {
    clast_clas_pool *pool;
    clast_context *context;
    clast_reserve reserve;
    clast_tree tree;
    size_t mapped_bytes; // of the block that it was mapped from, and which it must not change; else zero
};

// An instance.
typedef struct clast_placement {
    float to_object[3][4]; // columns
    float to_world[3][4];
    float origin[4];        // of object space, in the world
    const clast_blas *blas; // null: nothing can be hit
    uint32_t id;
    bool filtered;
    bool mirrored;
    bool is_identity; // object space is the world
} clast_placement;
_Static_assert(sizeof(clast_placement) == 128, "a placement is two cache lines");

struct clast_tlas {
    clast_context *context;
    clast_reserve reserve;
    clast_tree tree;
    uint8_t *memory;             // of the placements and what goes with them, where nothing is reserved
    clast_placement *placements; // of all instances, in the order given
    clast_box *boxes;            // of the placements
    uint32_t *leaves;            // nodes in which the placements are
    uint64_t *marks;             // a bit for each placement or node; all zero between calls
    uint32_t *parents;           // of the nodes
    size_t placement_count, placement_capacity, parent_capacity;
    float spread; // times a ray's largest distance and 2^-17: how far transforming it may move it, in the world
    bool visible; // something can be hit
};

// ----------------------------------------------------------------------------------------------------------- kernels

// Fits a slot's boxes to its vertices, and gives the box around them.
typedef void (*clast_fit_kernel)(clast_clas *clas, clast_box *box);
// Copies vertices by their numbers; false, and nothing copied, where a number is not below `position_count`.
typedef bool (*clast_gather_kernel)(float *to, const float *positions, size_t position_count, const uint32_t *numbers,
                                    uint32_t count);
// Puts triangles into blocks as they come: as many blocks as there are eights begun.
typedef void (*clast_order_kernel)(clast_block *blocks, const uint8_t *indices, uint32_t count);
// Fits nodes, from the last to the first: what is below them within the range is fitted first.
typedef void (*clast_refit_kernel)(clast_tree *tree, const clast_box *items, uint32_t begin, uint32_t end);
typedef void (*clast_closest_kernel)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                     const clast_hit_filter *filter, clast_hit *hits);
typedef void (*clast_any_kernel)(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                 const clast_hit_filter *filter, uint8_t *occluded);

// The maps of instances, and the boxes of what they place, in the world, padded for what transforming a ray rounds. Instance i's
// place is numbers[i], or first + i where `numbers` is null. Where nothing can be hit, the box is empty. Gives the largest
// condition number of a map, at least 1.
typedef float (*clast_place_kernel)(const clast_tlas_instance *instances, const uint32_t *numbers, size_t first,
                                    size_t count, clast_placement *placements, clast_box *boxes);

typedef struct clast_accel_kernels {
    clast_fit_kernel fit;
    clast_gather_kernel gather;
    clast_order_kernel order;
    clast_refit_kernel refit_nodes;
    clast_place_kernel place;
    clast_closest_kernel closest;
    clast_any_kernel any;
} clast_accel_kernels;

const clast_accel_kernels *clast_accel_kernels_of(clast_isa isa);

#define CLAST_DECLARE_KERNELS(set) \
    void clast_fit_##set(clast_clas *clas, clast_box *box); \
    bool clast_gather_##set(float *to, const float *positions, size_t position_count, const uint32_t *numbers, \
                            uint32_t count); \
    void clast_order_##set(clast_block *blocks, const uint8_t *indices, uint32_t count); \
    void clast_refit_nodes_##set(clast_tree *tree, const clast_box *items, uint32_t begin, uint32_t end); \
    float clast_place_##set(const clast_tlas_instance *instances, const uint32_t *numbers, size_t first, size_t count, \
                            clast_placement *placements, clast_box *boxes); \
    void clast_closest_##set(const clast_tlas *tlas, const clast_ray *rays, size_t count, \
                             const clast_hit_filter *filter, clast_hit *hits); \
    void clast_any_##set(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter, \
                         uint8_t *occluded);
CLAST_EACH_ISA(CLAST_DECLARE_KERNELS)

#endif
