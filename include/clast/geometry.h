/* SPDX-License-Identifier: Apache-2.0
 *
 * Pure functions over arrays of geometry, usable alone.
 */
#ifndef CLAST_GEOMETRY_H
#define CLAST_GEOMETRY_H

#include "clast/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A cluster of a mesh: ranges of clast_clusters's arrays. */
typedef struct clast_cluster {
    uint32_t first_triangle;
    uint32_t triangle_count; /**< 1 to max_triangles */
    uint32_t first_vertex;
    uint32_t vertex_count; /**< 3 to max_vertices; 1 or 2 where all triangles are degenerate */
} clast_cluster;

/** What clast_clusterize gives. Free with clast_clusters_free. */
typedef struct clast_clusters {
    clast_cluster *clusters;
    size_t cluster_count;
    /** For each triangle of the clusters, its number in the mesh: a permutation of all. Each eight of a cluster that follow
     *  each other are neighbours: templates of clusters need no rest positions (clast_template_desc). */
    uint32_t *triangles;
    uint8_t *indices;   /**< 3 for each triangle, into its cluster's vertices; winding and first corner are kept */
    uint32_t *vertices; /**< for each vertex of the clusters, the number of its position in the mesh */
    size_t vertex_count;
} clast_clusters;

typedef struct clast_clusterize_desc {
    const float *positions;  /**< 3 for each position */
    size_t position_count;   /**< at most 2^32 - 2 */
    const uint32_t *indices; /**< 3 for each triangle, each below position_count */
    size_t triangle_count;   /**< at most 2^32 - 2 */
    uint32_t max_triangles;  /**< 1 to 256; 0 is 128 */
    uint32_t max_vertices;   /**< 3 to 256; 0 is 128 */
} clast_clusterize_desc;

/** Cuts a mesh into clusters that are good for ray tracing: surface area heuristic, top down, with a term that fills
 *  clusters to the limits. Clusters come in the order of the cut, so that neighbours in the array are neighbours in
 *  space. Positions that are equal bit by bit should share an index (clast_weld_positions) so that clusters fill up.
 *  Deterministic, parallel. Large meshes report progress, and may be cancelled. Errors: INVALID_ARGUMENT (an index out of
 *  range), OUT_OF_MEMORY, CANCELLED. */
CLAST_API clast_status clast_clusterize(clast_context *context, const clast_clusterize_desc *desc,
                                        clast_clusters *clusters);
CLAST_API void clast_clusters_free(clast_context *context, clast_clusters *clusters);

/** For each vertex, the lowest vertex with the same position bit by bit (zeros of both signs are equal; NaNs are equal to
 *  nothing). `remap` has vertex_count elements. Gives the number of different positions. */
CLAST_API clast_status clast_weld_positions(clast_context *context, const float *positions, size_t vertex_count,
                                            uint32_t *remap, size_t *unique_count);

#ifdef __cplusplus
}
#endif

#endif
