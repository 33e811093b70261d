/* SPDX-License-Identifier: Apache-2.0
 *
 * Cluster acceleration structures, usable alone: an engine brings vertices and gets ray hits.
 *
 *   clast_template_set   topologies of clusters, each with a small fixed tree (a treelet) and no positions
 *   clast_clas_pool      clusters: a template, where its vertices lie, and boxes fitted to them (a CLAS each)
 *   clast_blas           a tree over some of a pool's clusters
 *   clast_tlas           a tree over instances of BLASes; rays go here
 *
 * When vertices move: clast_clas_refit, then clast_blas_refit (or clast_blas_build), then clast_tlas_build (or _update). Ray tests are
 * watertight: a ray cannot pass between triangles that share an edge (Woop, Benthin and Wald, Watertight Ray/Triangle
 * Intersection, JCGT 2(1), 2013). Results do not depend on the number of threads or the instruction set.
 *
 * Coordinates, of vertices, of rays and in the world, larger than 2^120 (1.3e36) in size count as not finite.
 *
 * Objects are edited by one call at a time; rays may be traced by any number of threads while nothing is edited.
 */
#ifndef CLAST_ACCEL_H
#define CLAST_ACCEL_H

#include "clast/context.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A ray: points `origin + t * direction` with t_min <= t <= t_max. The direction need not have unit length. A ray with a
 *  value that is not finite (t_max may be infinite), or with a zero direction, hits nothing. */
typedef struct clast_ray {
    float origin[3];
    float t_min;
    float direction[3];
    float t_max;
} clast_ray;

/** What a ray hit. `instance` is CLAST_NONE where it hit nothing; the rest is undefined then, but for `steps`.
 *
 *  A hit lies on its triangle. In the BLAS's own space let M be the largest distance, along an axis, from the ray's origin to a
 *  side of the BLAS's box, L the triangle's longest edge, and A twice its area as seen along the ray. Then the ray's line
 *  passes the triangle within 2^-20 M, and `origin + t * direction` is within 2^-19 M + 2^-17 L^3 / A of the point with weights
 *  u and v, and within 2^-19 M + 4 L where A is almost nothing: only a triangle seen edge on is hit anywhere but where the
 *  ray passes it. u and v are not negative, and their sum is at most 1 but for rounding. A transform T with condition C,
 *  the largest row sum of |T| |T^-1|, adds 2^-17 C D to both in the world, where D is the largest distance from the ray's
 *  origin to the instance's box there or to where T puts the object's origin. */
typedef struct clast_hit {
    float t;
    float u, v; /**< weights of the triangle's second and third corner */
    /** Perpendicular to the triangle in world space, of any length. It points to the side from which the triangle is seen
     *  counter-clockwise in object space, through mirroring transforms too: what is the front there stays the front, as
     *  glTF 2.0 has it. */
    float normal[3];
    uint32_t instance; /**< clast_tlas_instance.id */
    uint32_t cluster;  /**< slot in the instance's BLAS's pool */
    uint32_t triangle; /**< triangle of the template, in the order in which it was given */
    uint32_t steps;    /**< tree nodes visited: those of all rays that went together, where rays of a batch did */
} clast_hit;

/** Decides whether a hit counts (alpha). Called for candidates in no particular order, from the tracing thread; must give
 *  the same answer for the same hit. `hit->normal` and `hit->steps` are not set yet. */
typedef struct clast_hit_filter {
    bool (*accepts)(void *user, const clast_ray *ray, const clast_hit *hit);
    void *user;
} clast_hit_filter;

/* -------------------------------------------------------------------------------------------------------- templates */

typedef struct clast_template_set clast_template_set;

/** A cluster's topology. */
typedef struct clast_template_desc {
    uint32_t triangle_count; /**< 1 to 256 */
    uint32_t vertex_count;   /**< 1 to 256 */
    const uint8_t *indices;  /**< 3 for each triangle, each below vertex_count */
    /** 3 for each vertex, typical, to build the treelet from. Null: each eight triangles that follow each other become a
     *  block; clast_clusterize gives clusters in an order made for that. */
    const float *rest_positions;
} clast_template_desc;

CLAST_API clast_status clast_template_set_create(clast_context *context, clast_template_set **set);
CLAST_API void clast_template_set_destroy(clast_template_set *set);

/** Adds templates; theirs are the numbers *first, *first + 1, ... Built in parallel. What the descs point to may be freed
 *  afterwards. Errors: INVALID_ARGUMENT, OUT_OF_MEMORY; the set is unchanged then. */
CLAST_API clast_status clast_template_set_add(clast_template_set *set, const clast_template_desc *descs, size_t count,
                                              uint32_t *first);

/** Adds the template of a grid of `columns` x `rows` quads (1 to 11 each). Vertex (i, j) is number j * (columns + 1) + i.
 *  Quad (i, j) is triangles 2 q and 2 q + 1 with q = j * columns + i: (v00, v10, v11) and (v00, v11, v01).
 *  The same grid added twice gives the same number. */
CLAST_API clast_status clast_template_set_add_grid(clast_template_set *set, uint32_t columns, uint32_t rows,
                                                   uint32_t *number);

CLAST_API uint32_t clast_template_set_count(const clast_template_set *set);
CLAST_API uint32_t clast_template_triangle_count(const clast_template_set *set, uint32_t number);
CLAST_API uint32_t clast_template_vertex_count(const clast_template_set *set, uint32_t number);
/** The corners of a triangle, as given. */
CLAST_API void clast_template_triangle(const clast_template_set *set, uint32_t number, uint32_t triangle,
                                       uint32_t corners[3]);
CLAST_API uint64_t clast_template_set_bytes(const clast_template_set *set);

/* ------------------------------------------------------------------------------------------------------------- CLAS */

typedef struct clast_clas_pool clast_clas_pool;

/** A cluster: a template and its vertices, 3 floats each, which stay the caller's and must live as long as the slot. */
typedef struct clast_clas_input {
    uint32_t template_number;
    const float *vertices;
} clast_clas_input;

/** Makes an empty pool over a set's templates. The set must outlive it. */
CLAST_API clast_status clast_clas_pool_create(clast_template_set *set, clast_clas_pool **pool);
CLAST_API void clast_clas_pool_destroy(clast_clas_pool *pool);
/** The bytes that a pool of `count` slots takes: of any templates that the set has now and, where `own_triangles` is not zero, of
 *  clusters with up to so many triangles of their own (clast_clas_build). UINT64_MAX where no pool can have so many. */
CLAST_API uint64_t clast_clas_pool_memory(const clast_template_set *set, size_t count, uint32_t own_triangles);
/** Makes room for `count` slots of any templates that the set has now; afterwards instantiating that many of them allocates
 *  nothing. */
CLAST_API clast_status clast_clas_pool_reserve(clast_clas_pool *pool, size_t count);
/** The same, and for clusters of up to `own_triangles` triangles of their own: building that many allocates nothing either. */
CLAST_API clast_status clast_clas_pool_reserve_own(clast_clas_pool *pool, size_t count, uint32_t own_triangles);
/** Keeps the pool in the caller's memory, aligned to 64 bytes, from now on; null goes back to the context's. It has as many slots
 *  as fit, of the templates that the set has now, and with `own_triangles` as above. The memory must stay until then, or until the
 *  pool is destroyed. A call that needs more fails with OUT_OF_MEMORY and a text that names both numbers; the pool is unchanged
 *  then. The pool has no clusters afterwards. */
CLAST_API clast_status clast_clas_pool_use_memory(clast_clas_pool *pool, void *memory, size_t bytes,
                                                  uint32_t own_triangles);
/** Fills slots [first, first + count), extending the pool to first + count slots if it is shorter, and fits their boxes to
 *  the vertices. Parallel. Vertices that are not finite make triangles that are never hit. */
CLAST_API clast_status clast_clas_instantiate(clast_clas_pool *pool, size_t first, size_t count,
                                              const clast_clas_input *inputs);

/** A cluster with triangles of its own. */
typedef struct clast_clas_desc {
    uint32_t triangle_count; /**< 1 to 256 */
    uint32_t vertex_count;   /**< 1 to 256 */
    const uint8_t *indices;  /**< 3 for each triangle, each below vertex_count; read during the call only */
    const float *vertices;   /**< 3 floats each; they stay the caller's, and must live as long as the slot */
    /** Not zero: each eight triangles that follow each other are close together, and become a block as they come, as those of
     *  a template without rest positions do; and each vertex is a corner of some triangle (others make boxes larger than need
     *  be). Takes a tenth of the time. */
    uint32_t ordered;
} clast_clas_desc;

/** Fills slots [first, first + count) as clast_clas_instantiate does, with clusters that no template describes: what an engine
 *  streams in. Their topology lies in the pool, and takes the place of what the slot had. Takes longer than instantiating, as
 *  triangles are sorted into blocks. Parallel. */
CLAST_API clast_status clast_clas_build(clast_clas_pool *pool, size_t first, size_t count,
                                        const clast_clas_desc *clusters);

/** What a pool has room for whose clusters are set one by one. */
typedef struct clast_clas_room {
    size_t count;            /**< clusters, at most 2^31 */
    uint32_t most_triangles; /**< of any cluster, of a template or of its own: 1 to 256 */
    size_t own_bytes;        /**< for clusters with triangles of their own: the sum of their clast_clas_own_bytes */
} clast_clas_room;

/** The bytes of a pool that a cluster's own triangles take: a multiple of 8. */
CLAST_API size_t clast_clas_own_bytes(uint32_t triangle_count);
/** The bytes that a pool of such room takes; UINT64_MAX where none can have it. */
CLAST_API uint64_t clast_clas_room_bytes(const clast_clas_room *room);
/** Gives the pool `room->count` slots with nothing there, in place of those that it has; for callers that make vertices in a loop
 *  of their own, and have them in the cache. Memory that is large enough is used again; where it is not, and the pool had
 *  some, a little more is taken than is needed. Errors: INVALID_ARGUMENT, OUT_OF_MEMORY; the pool is unchanged then. */
CLAST_API clast_status clast_clas_pool_resize(clast_clas_pool *pool, const clast_clas_room *room);
/** Sets a slot, as clast_clas_instantiate does. Calls for different slots may run at the same time, on any threads.
 *  INVALID_ARGUMENT, and nothing is changed, where there is no such slot or template, no vertices, or a template has more
 *  triangles than there is room for. */
CLAST_API clast_status clast_clas_set(clast_clas_pool *pool, size_t slot, const clast_clas_input *input);
/** Sets a slot, as clast_clas_build does, of a pool that was resized. The triangles go to the pool's own bytes from `place` on, a
 *  multiple of 8: clusters set at the same time must not share any. Otherwise as clast_clas_set. */
CLAST_API clast_status clast_clas_set_own(clast_clas_pool *pool, size_t slot, size_t place,
                                          const clast_clas_desc *cluster);
/** The corners of a slot's triangle, as hits number it: where its vertices are now. False, and zeros, where there is none. */
CLAST_API bool clast_clas_corners(const clast_clas_pool *pool, size_t slot, uint32_t triangle, float corners[3][3]);
/** Forgets the slots from `count` on. */
CLAST_API void clast_clas_pool_truncate(clast_clas_pool *pool, size_t count);
/** Fits the boxes of slots [first, first + count) anew, after their vertices changed. Parallel. */
CLAST_API clast_status clast_clas_refit(clast_clas_pool *pool, size_t first, size_t count);

/** Where clusters take their vertices from: a mesh's own array, which several clusters share. */
typedef struct clast_clas_gather {
    const float *positions; /**< the shared vertices, 3 floats each */
    size_t position_count;
    const uint32_t *numbers; /**< of the position of each vertex of each cluster; each below position_count */
    /** For each slot of the pool: where its vertices begin in `numbers` and, times 3, in `vertices`. */
    const uint32_t *first;
    float *vertices; /**< what the clusters were instantiated with: a slot's are at vertices + 3 * first[slot] */
} clast_clas_gather;

/** Copies the vertices of slots [first, first + count) from shared ones, and fits the slots' boxes, in one pass. Parallel.
 *  INVALID_ARGUMENT where a number is out of range or a slot's vertices lie elsewhere: such a slot keeps its boxes, and the
 *  others are fitted. */
CLAST_API clast_status clast_clas_refit_gathered(clast_clas_pool *pool, size_t first, size_t count,
                                                 const clast_clas_gather *gather);
CLAST_API size_t clast_clas_pool_count(const clast_clas_pool *pool);
CLAST_API uint64_t clast_clas_pool_bytes(const clast_clas_pool *pool);

/* ------------------------------------------------------------------------------------------------------------- BLAS */

typedef struct clast_blas clast_blas;

/** Makes an empty BLAS over a pool's clusters. The pool must outlive it. */
CLAST_API clast_status clast_blas_create(clast_clas_pool *pool, clast_blas **blas);
CLAST_API void clast_blas_destroy(clast_blas *blas);
/** The most bytes that builds over up to `count` clusters take, working memory included; UINT64_MAX from 2^31 on. */
CLAST_API uint64_t clast_blas_memory(size_t count);
/** Takes that memory now and keeps it: builds over up to `count` clusters allocate nothing, and larger ones take more. Without a
 *  reserve, a build keeps what the tree needs, and frees its working memory. The tree is empty afterwards. */
CLAST_API clast_status clast_blas_reserve(clast_blas *blas, size_t count);
/** Keeps the tree in the caller's memory, aligned to 64 bytes, from now on; null goes back to the context's. The memory must stay
 *  until then, or until the BLAS is destroyed. A build that needs more than `bytes` fails with OUT_OF_MEMORY and a text that
 *  names both numbers. The tree is empty afterwards. */
CLAST_API clast_status clast_blas_use_memory(clast_blas *blas, void *memory, size_t bytes);
/** Builds the tree over `count` slots of the pool; `slots` null means slots 0 to count - 1. Deterministic, parallel.
 *  Reuses the memory of the tree before. Where memory runs out, the tree is empty afterwards. */
CLAST_API clast_status clast_blas_build(clast_blas *blas, const uint32_t *slots, size_t count, clast_build build);
/** Fits the tree to the clusters' boxes anew, keeping its shape. */
CLAST_API clast_status clast_blas_refit(clast_blas *blas);
/** The box of all finite vertices; lower > upper where there are none. */
CLAST_API void clast_blas_bounds(const clast_blas *blas, float lower[3], float upper[3]);
CLAST_API uint64_t clast_blas_bytes(const clast_blas *blas);

/** Writes a BLAS, with its clusters and their vertices, as one block that can be stored, and used again wherever it lies: to the
 *  caller's memory, aligned to 64 bytes, of `size` bytes. Gives how many it takes in `*needed`; `memory` null asks for no more.
 *  Clusters are numbered anew, from zero, in the order of their slots: a BLAS over slots 0 to n - 1 keeps their numbers. Vertices
 *  should be those that the boxes were last fitted to. The same BLAS gives the same bytes.
 *  INVALID_ARGUMENT where the memory is too small or not aligned; OUT_OF_MEMORY. */
CLAST_API clast_status clast_blas_serialise(const clast_blas *blas, void *memory, size_t size, uint64_t *needed);
/** Makes a BLAS that uses such a block in place: nothing is copied, the block is never written to, and must stay as it is until
 *  the BLAS is destroyed. It must be aligned to 64 bytes, as a mapped file is. Whatever the bytes are, rays read nothing outside the block and
 *  come to an end; with `checksum`, changes to what decides hits are found too, at the cost of reading all bytes. It is for
 *  machines of the same byte order and this version of the format. Such a BLAS cannot be built or refitted: STATE.
 *  MALFORMED where the block is not what was written; UNSUPPORTED where the version or the byte order is another;
 *  INVALID_ARGUMENT, OUT_OF_MEMORY. */
CLAST_API clast_status clast_blas_map(clast_context *context, const void *memory, size_t size, bool checksum,
                                      clast_blas **blas);

/* ------------------------------------------------------------------------------------------------------------- TLAS */

typedef struct clast_tlas clast_tlas;

/** An instance. */
typedef struct clast_tlas_instance {
    const clast_blas *blas; /**< null: nothing there */
    float transform[3][4];  /**< object to world, rows; one that cannot be inverted makes the instance invisible */
    uint32_t id;            /**< what hits report; not CLAST_NONE */
    uint32_t filtered;      /**< 1: hits are put to the filter, where there is one; 0: they count at once */
} clast_tlas_instance;

CLAST_API clast_status clast_tlas_create(clast_context *context, clast_tlas **tlas);
CLAST_API void clast_tlas_destroy(clast_tlas *tlas);
/** The most bytes that builds over up to `count` instances take, working memory included; UINT64_MAX from 2^31 on. */
CLAST_API uint64_t clast_tlas_memory(size_t count);
/** Takes that memory now and keeps it: builds over up to `count` instances allocate nothing, and larger ones take more. Without a
 *  reserve, a build allocates working memory and frees it. The TLAS is empty afterwards. */
CLAST_API clast_status clast_tlas_reserve(clast_tlas *tlas, size_t count);
/** Keeps the TLAS in the caller's memory, aligned to 64 bytes, from now on; null goes back to the context's. The memory must stay
 *  until then, or until the TLAS is destroyed. A build that needs more than `bytes` fails with OUT_OF_MEMORY and a text that
 *  names both numbers. The TLAS is empty afterwards. */
CLAST_API clast_status clast_tlas_use_memory(clast_tlas *tlas, void *memory, size_t bytes);
/** Builds the tree over instances, which are copied. Their BLASes must stay as they are until the next build or update of the
 *  instance. Where it fails, the TLAS is empty. */
CLAST_API clast_status clast_tlas_build(clast_tlas *tlas, const clast_tlas_instance *instances, size_t count,
                                        clast_build build);
/** Replaces instances of the last build: number numbers[i] (i where `numbers` is null) becomes instances[i]. They may move,
 *  vanish, appear, and have another BLAS. The tree keeps its shape, and only boxes above these instances are fitted anew: the cost
 *  follows `count`. Where many instances move far, a build makes rays faster again. Allocates nothing. INVALID_ARGUMENT where a
 *  number is not below the last build's count or is there twice; nothing is changed then. */
CLAST_API clast_status clast_tlas_update(clast_tlas *tlas, const uint32_t *numbers,
                                         const clast_tlas_instance *instances, size_t count);
CLAST_API void clast_tlas_bounds(const clast_tlas *tlas, float lower[3], float upper[3]);
CLAST_API uint64_t clast_tlas_bytes(const clast_tlas *tlas);

/** The nearest hit of each ray. `filter` may be null. Ties at equal t go to the lower (instance id, cluster, triangle).
 *  Runs on the calling thread and never allocates: split large batches over threads as you like. */
CLAST_API void clast_trace_closest(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                   const clast_hit_filter *filter, clast_hit *hits);
/** Whether each ray hits anything: 1 or 0. */
CLAST_API void clast_trace_any(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                               const clast_hit_filter *filter, uint8_t *occluded);

#ifdef __cplusplus
}
#endif

#endif
