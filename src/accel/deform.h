// SPDX-License-Identifier: Apache-2.0
// What a deforming mesh is made of: a pool of clusters with room for any other clusters of the same triangles, and a
// tree.
//
// Clusters have fixed room each, so that their triangles can be dealt anew among them without moving anything else.
// They are watched in pieces: parts of the tree of up to eight clusters. What a piece costs is what a random ray is
// expected to test there, by the surface area heuristic: areas of the clusters' boxes and of their blocks' boxes. A
// piece in good order costs about so many times the area of its own box as in the beginning; what it costs beyond is
// what cutting it anew may save, and the pieces that may save most are cut first.
#ifndef CLAST_ACCEL_DEFORM_H
#define CLAST_ACCEL_DEFORM_H

#include "accel/tree_build.h"
#include "clast/deform.h"

enum {
    PIECE_CLUSTERS = 8,
    PIECE_TRIANGLES = PIECE_CLUSTERS * CLUSTER_TRIANGLES,
    PIECE_VERTICES = PIECE_CLUSTERS * CLUSTER_VERTICES,
    CLUSTER_BLOCKS = CLUSTER_TRIANGLES / BLOCK_TRIANGLES,
};

// Clusters order[first], and so on.
typedef struct clast_piece {
    uint32_t first, count;
} clast_piece;

// What is known of a piece.
typedef struct clast_piece_state {
    float area;  // of its clusters' boxes and their blocks', when last measured, times the mesh's scale squared
    float tried; // that in areas of the piece's own box, after it was cut; 0 where it was not
    float gain;  // what cutting it may save
} clast_piece_state;

// A piece chosen to be cut, and what came of it.
typedef struct clast_piece_choice {
    uint32_t piece;
    float gain;
    uint32_t triangles;
    bool kept;
} clast_piece_choice;

// How far the next tree is.
typedef enum clast_tree_phase {
    CLAST_TREE_IDLE, // there is none
    CLAST_TREE_BEGIN,
    CLAST_TREE_LARGE, // large ranges are being split
    CLAST_TREE_SUBTREES,
    CLAST_TREE_END,
} clast_tree_phase;

// What one thread needs to cut a piece anew (deform_cut.c).
typedef struct clast_piece_cutter clast_piece_cutter;

struct clast_deforming_mesh {
    clast_context *context;
    clast_template_set *set; // empty
    clast_clas_pool *pool;
    clast_blas *blas;
    size_t position_count;
    uint32_t cluster_count;
    // Room of each cluster, by its slot.
    uint32_t vertex_stride;
    uint32_t *first;     // where its vertices are
    uint32_t *numbers;   // of its vertices, among the positions
    uint32_t *triangles; // of its triangles, in the mesh; CLUSTER_TRIANGLES for each
    float *vertices;
    // The next tree (deform_tree.c).
    clast_tree_phase tree_phase;
    clast_tree_builder builder;
    uint32_t next_subtree;
    clast_tree next_tree;
    uint8_t *tree_scratch;
    // The watch.
    bool watched;
    uint32_t budget;     // triangles that updates may cut, on average
    uint32_t credit;     // what is left of it
    float *expected;     // of each cluster: areas of its piece in areas of the piece's box, in the beginning
    uint32_t *order;     // of the clusters in the tree, left to right
    clast_piece *pieces; // of the tree, left to right
    clast_piece_state *states;
    uint32_t piece_count;
    clast_piece_choice *choices;
    uint32_t choice_most;
    uint8_t *cutters;      // for each worker
    uint32_t updates;      // since the beginning: pieces are measured in turns
    uint32_t tree_updates; // since the tree was built
    uint32_t tree_changes; // clusters that were cut since
    float tree_area;       // of its nodes, in areas of the root's box, when it was new; 0 where that is not known yet
    float tree_area_now;
    float scale;  // times lengths: so that no area overflows
    void *memory; // of all arrays
    uint64_t bytes;
};

static inline clast_template *clast_deform_template(const clast_deforming_mesh *mesh, uint32_t slot)
{
    clast_clas *clas = clast_pool_slot(mesh->pool, slot);
    return (clast_template *)((uintptr_t)clas + (uintptr_t)clas->topology); // in the pool: the mesh's own
}

// ------------------------------------------------------------------------------------------------- deform_watch.c

// After the first tree was built.
void clast_deform_watch_begin(clast_deforming_mesh *mesh);
// After clusters were fitted, before the tree is.
void clast_deform_watch(clast_deforming_mesh *mesh, const float *positions,
                        clast_deforming_mesh_statistics *statistics);
// After the tree was fitted.
void clast_deform_watch_end(clast_deforming_mesh *mesh, clast_deforming_mesh_statistics *statistics);

// -------------------------------------------------------------------------------------------------- deform_tree.c

void clast_deform_tree_take(clast_deforming_mesh *mesh, clast_arena *arena);
void clast_deform_tree_begin(clast_deforming_mesh *mesh);
// Goes on by about so much work, in passes over single clusters. True where the next tree is done: the BLAS has it
// then, and its boxes are to be fitted.
bool clast_deform_tree_go_on(clast_deforming_mesh *mesh, uint64_t work);

// --------------------------------------------------------------------------------------------------- deform_cut.c

size_t clast_piece_cutter_size(void);
// Deals the triangles of a piece's clusters anew among the same clusters. False, and nothing is changed, where that is
// no better or the vertices do not fit.
bool clast_deform_cut(clast_deforming_mesh *mesh, clast_piece_cutter *cutter, const clast_piece *piece,
                      const float *positions);

#endif
