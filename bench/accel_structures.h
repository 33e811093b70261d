// SPDX-License-Identifier: Apache-2.0
// Both sides' structures over a workload: all that an engine would keep.
#ifndef CLAST_BENCH_ACCEL_STRUCTURES_H
#define CLAST_BENCH_ACCEL_STRUCTURES_H

#include "accel_workloads.h"
#include "embree.h"

// ------------------------------------------------------------------------------------------------------------- clast's

// Cluster i has vertices first_vertex[i] to first_vertex[i + 1]; vertex v of all is number sources[v] of the mesh.
typedef struct structure {
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_tlas *tlas;
    float *vertices;
    uint32_t *sources;
    uint32_t *first_vertex;
    uint32_t *templates; // of each cluster
    uint32_t vertex_count, cluster_count;
    double build_seconds; // from the workload to where rays can be traced
} structure;

// From plain triangles: clusters of at most 128, a template of each.
structure structure_of_clusters(clast_context *context, const workload *w);
// A surface's tiles of 8 x 8 quads, all of one template.
structure structure_of_grids(clast_context *context, const workload *w);
void structure_free(clast_context *context, structure *s);

// Copies the mesh's vertices into the clusters.
void structure_gather(clast_context *context, structure *s, const float *positions);
// Copies them and fits everything to them, in one pass.
void structure_refit_gathered(clast_context *context, structure *s, const float *positions, size_t position_count);
// Fits everything to the vertices, which lie in the clusters.
void structure_refit(clast_context *context, structure *s);
// Fills the pool anew from the vertices, which lie in the clusters, and builds the best trees.
void structure_instantiate(clast_context *context, structure *s);
void structure_build_tlas(clast_context *context, structure *s);
// Templates, slots, boxes, nodes and vertices.
double structure_bytes(const structure *s);

// ------------------------------------------------------------------------------------------------------------- Embree's

typedef enum peer_kind {
    PEER_SAH,    // its default: surface area heuristic, fast ray tests, which leak
    PEER_ROBUST, // the same, watertight
    PEER_SAH_DYNAMIC,
    PEER_FAST, // its fastest build, without the flag for dynamic scenes and with it
    PEER_FAST_DYNAMIC,
    PEER_REFIT, // refits
    PEER_GRIDS, // a surface's tiles as its grid primitive, fastest build
    PEER_GRIDS_DYNAMIC,
} peer_kind;

// Embree's default on machines with vectors of 512 bits is to use half of them; it can be told to use all. Both are tried.
enum { PEER_DEVICES = 2 };

typedef struct peer {
    RTCScene scene;
    RTCGeometry geometry;
    double bytes; // what it allocated, and vertices and indices
} peer;

// Number 0 of them is the default one, number 1 uses vectors as wide as there are.
RTCDevice peer_device(uint32_t threads, uint32_t number);
// Over vertices that may change later, with a vertex to spare.
peer peer_make(RTCDevice device, const workload *w, const float *positions, peer_kind kind);
// Builds or refits anew, after the vertices changed.
void peer_commit(peer *p);
void peer_free(peer *p);

#endif
