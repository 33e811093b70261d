/* SPDX-License-Identifier: Apache-2.0
 *
 * Meshes whose vertices move every frame: what a dynamic scene holds elsewhere, in one object.
 *
 *   clast_deforming_mesh_create    once, from positions and indices: clusters, their boxes, a tree (a BLAS) over them
 *   clast_deforming_mesh_update    each frame, from the frame's positions
 *   clast_deforming_mesh_blas      for the instances of a TLAS, which is built or updated after the mesh
 *   clast_deforming_mesh_triangle  the mesh's triangle from a hit
 *
 * Boxes that are only fitted anew fit worse the more a mesh bends, and rays get slower. So each update also measures
 * how much that costs, and spends a bounded amount of work on it: it deals those triangles among their clusters anew
 * that have got the worst; or it builds a part of the next tree over the clusters, which takes the place of the tree
 * when it is done. Work is counted in triangles and clusters, never in time: the same positions give the same
 * structure, on any machine with any number of threads.
 */
#ifndef CLAST_DEFORM_H
#define CLAST_DEFORM_H

#include "clast/accel.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A mesh that deforms. Edited by one call at a time; rays may be traced by any number of threads between updates. */
typedef struct clast_deforming_mesh clast_deforming_mesh;

/** What a deforming mesh is made from. Everything is copied. */
typedef struct clast_deforming_mesh_desc {
    const float *positions;  /**< 3 for each position */
    size_t position_count;   /**< at most 2^32 - 2 */
    const uint32_t *indices; /**< 3 for each triangle, each below position_count; equal positions should share one */
    size_t triangle_count;   /**< at most 2^32 - 2 */
    /** Triangles that updates may cut anew, on average; they are cut in pieces of up to 1024, so an update may have to
     *  wait until there is budget enough for one. 0 is a fiftieth of all, and 1024 at least. With that, an update of a
     *  large mesh takes up to about twice as long as an unwatched one. Rays are the faster the more there is. */
    uint32_t watch_budget;
    bool unwatched; /**< only fit boxes: rays get slower as the mesh bends */
} clast_deforming_mesh_desc;

/** What an update did beside fitting boxes. */
typedef struct clast_deforming_mesh_statistics {
    /** Triangles that were dealt among their clusters anew: at most the budget, or 1024 where that is more. */
    uint32_t cut_triangles;
    /** Clusters that changed so. What was dealt in vain stays as it was. */
    uint32_t changed_clusters;
    /** Clusters that the next tree is over, where this update went on with it instead of cutting; else zero. */
    uint32_t sorted_clusters;
    /** The next tree was done, and is the tree now. */
    bool tree_replaced;
    /** Areas of the tree's boxes in areas of the mesh's box: how many a random ray through that is expected to meet.
     *  Zero where the mesh is not watched. */
    float tree_area;
} clast_deforming_mesh_statistics;

/** Makes a mesh from its positions at some moment. Parallel, deterministic. Allocates all that updates need.
 *  Errors: INVALID_ARGUMENT (an index out of range), OUT_OF_MEMORY. */
CLAST_API clast_status clast_deforming_mesh_create(clast_context *context, const clast_deforming_mesh_desc *desc,
                                                   clast_deforming_mesh **mesh);
CLAST_API void clast_deforming_mesh_destroy(clast_deforming_mesh *mesh);

/** Moves all vertices: `positions` has as many as the mesh was made from, in the same order, and is read during the
 *  call only. Parallel. Allocates nothing. Positions that are not finite make triangles that are never hit.
 *  `statistics` may be null. TLASes with instances of the mesh must be built or updated before rays are traced. */
CLAST_API clast_status clast_deforming_mesh_update(clast_deforming_mesh *mesh, const float *positions,
                                                   clast_deforming_mesh_statistics *statistics);

/** The BLAS for instances of the mesh. It stays the same object, and is the mesh's. */
CLAST_API const clast_blas *clast_deforming_mesh_blas(const clast_deforming_mesh *mesh);

/** The mesh's triangle of a hit's `cluster` and `triangle`; CLAST_NONE where there is none such. An update may renumber
 *  clusters: ask before the next. A hit's u and v weigh the triangle's second and third corner as given. Where two
 *  triangles are hit at the same distance, which one is reported may change with an update too. */
CLAST_API uint32_t clast_deforming_mesh_triangle(const clast_deforming_mesh *mesh, uint32_t cluster, uint32_t triangle);

/** All that the mesh holds. */
CLAST_API uint64_t clast_deforming_mesh_bytes(const clast_deforming_mesh *mesh);

#ifdef __cplusplus
}
#endif

#endif
