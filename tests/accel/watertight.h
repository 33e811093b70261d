// SPDX-License-Identifier: Apache-2.0
// The parts of the program `watertight`: closed surfaces, trees over them, rays at their edges, and what decides, apart from
// any tracer, whether a ray crosses.
#ifndef CLAST_TESTS_ACCEL_WATERTIGHT_H
#define CLAST_TESTS_ACCEL_WATERTIGHT_H

#include <stdbool.h>

#include "accel/meshes.h"
#include "clast/deform.h"

enum { WATERTIGHT_MAPS = 8, WATERTIGHT_BALLS = 24 };

// ------------------------------------------------------------------------------------------------------------ surfaces

// A ball without any of the surface, whose points are inside: the surface winds around them.
typedef struct inner_ball {
    double centre[3];
    double radius;
} inner_ball;

// A closed mesh: equal positions have one number; along each edge runs one triangle forth and one back. Triangles with two
// equal corners are ignored there: they are no surface.
typedef struct surface {
    char name[200];
    mesh m;
    uint32_t columns, rows;   // of quads where the mesh is made of such sheets, side by side in m.indices; else zero
    uint32_t sheets;          // how many
    uint32_t *opposite;       // of each half edge, 3 * triangle + corner where it begins; CLAST_NONE for those ignored
    uint32_t *first_faces;    // of each vertex, in `faces`, and the end
    uint32_t *faces;          // triangles around the vertices
    double centre[3], radius; // of a ball around all
    inner_ball balls[WATERTIGHT_BALLS];
    uint32_t ball_count;
} surface;

// Takes over the mesh, and welds its positions. Gives the number of edges that have not two faces; the surface is complete where that is zero.
uint32_t surface_make(clast_context *context, const char *name, const mesh *m, surface *s);
// Finds balls inside; false where there are none.
bool surface_find_inside(surface *s, uint64_t seed);
void surface_free(surface *s);
surface surface_scaled(const surface *s, float size);

mesh mesh_cube_sphere(uint32_t segments); // six sheets of segments x segments quads
// The closed meshes of all models below a folder; appends them, and prints a line for each that is not closed.
// `count` surfaces are there already. Gives how many there are then.
uint32_t surfaces_load(clast_context *context, const char *folder, surface **surfaces, uint32_t count);
// All meshes, whether closed or not; with nothing inside.
uint32_t surfaces_load_all(clast_context *context, const char *folder, surface **surfaces);

// ------------------------------------------------------------------------------------------------------------ clusters

typedef struct clusters {
    clast_context *context;
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *tree, *mapped;
    void *block; // of the mapped one
    clast_deforming_mesh *deforming;
    const clast_blas *blas; // what rays are traced through: one of these
    float *vertices;        // of all clusters
    uint32_t *sources;      // their numbers in the mesh
    uint32_t *firsts;       // of each cluster, in sources
    uint32_t *templates;    // of each cluster
    size_t vertex_count, cluster_count;
} clusters;

typedef enum cluster_kind {
    CLUSTERS_CUT,     // clast_clusterize, 128 triangles at most
    CLUSTERS_FULL,    // 256 triangles, no rest positions
    CLUSTERS_TINY,    // 5 triangles
    CLUSTERS_IN_TURN, // 100 consecutive triangles: with gaps between
    CLUSTERS_OWN,     // built one by one, without templates
    CLUSTERS_MAPPED,  // written as a block and used in place
    CLUSTERS_WATCHED, // of a deforming mesh, which cuts them anew as it moves
    CLUSTERS_GRIDS,   // grids of many sizes
    CLUSTER_KINDS
} cluster_kind;

const char *cluster_kind_name(cluster_kind kind);
clast_status clusters_make(clast_context *context, const surface *s, cluster_kind kind, clast_build build, clusters *c);
// Takes the vertices from the surface anew, and fits all boxes to them.
clast_status clusters_refit(clusters *c, const surface *s);
// The corners of a cluster's triangle, by their numbers in the mesh.
void clusters_corners(const clusters *c, uint32_t cluster, uint32_t triangle, uint32_t corners[3]);
void clusters_free(clusters *c);

// ------------------------------------------------------------------------------------------------------------ crossing

// A map from object to world, and back.
typedef struct placing {
    float to_world[3][4];
    double to_object[3][3];
} placing;

placing placing_of(const float to_world[3][4]);

typedef enum crossing {
    CROSSING_NONE,
    CROSSING_RIM,  // by less than a tracer rounds, or too near to tell
    CROSSING_SURE, // and would, if each vertex, seen along the ray, were moved as far as a tracer may round
} crossing;

// Whether a ray crosses the surface near a half edge; where it is sure, `farthest` is no less than its t there.
crossing surface_crossing(const surface *s, const placing *p, const clast_ray *ray, uint32_t half_edge,
                          double *farthest);

// The sign, in real numbers, of direction . ((a - origin) x (b - origin)): on which side of the edge the ray passes.
int exact_side(const float origin[3], const float direction[3], const float a[3], const float b[3]);

// ----------------------------------------------------------------------------------------------------------------- aim

// A ray through a point of an edge, or next to it; the point is at t = 1, but for rounding.
typedef struct shot {
    clast_ray ray;
    uint32_t half_edge;
    bool is_inside; // begins inside the surface; else far outside
} shot;

// Rays from one origin, at edges next to each other.
void aim(const surface *s, const placing *p, randoms *r, shot *shots, size_t count);

// ----------------------------------------------------------------------------------------------------------- displaced

// A flight around displaced meshes, each frame of which is made as it is for a picture.
typedef struct displaced_flight displaced_flight;
typedef struct displaced_moment {
    surface s;          // the caller's
    uint32_t open;      // its edges along which not as many triangles run forth as back
    uint32_t collapsed; // and those that have not two faces: there, nothing can be aimed at
    placing map;        // of the one instance
    clast_tlas *tlas;   // until the next moment
} displaced_moment;

// With the models of the folder `assets`, where it is not null. Null, and the error printed, where that fails.
displaced_flight *displaced_flight_create(clast_context *context, const char *assets);
void displaced_flight_destroy(displaced_flight *f);
uint32_t displaced_flight_frames(const displaced_flight *f);
clast_status displaced_flight_fly(displaced_flight *f, uint32_t number, displaced_moment *moment);

// -------------------------------------------------------------------------------------------------------------- device

// A Vulkan device, to trace there what the processor built trees over: clusters are fitted and trees built there. Null, and the reason printed,
// where there is none.
typedef struct device_tracer device_tracer;
device_tracer *device_tracer_create(clast_context *context);
void device_tracer_destroy(device_tracer *d);

// A TLAS there. `first`, which may be null, has all of its BLASes already, and must live as long. Null, and the error printed,
// where that fails.
typedef struct device_tlas device_tlas;
device_tlas *device_tlas_create(device_tracer *d, const clast_tlas *tlas, const device_tlas *first);
void device_tlas_destroy(device_tracer *d, device_tlas *tlas);

// Rays through one of them: the nearest hits, or whether there is any.
typedef struct device_batch {
    const device_tlas *tlas;
    bool any, incoherent;
    uint32_t count;
    const clast_ray *rays;
    clast_hit *hits;    // where not any
    uint32_t *occluded; // where any
} device_batch;
// False, and the error printed, where that fails.
bool device_trace(device_tracer *d, const device_batch *batches, size_t count);

// ---------------------------------------------------------------------------------------------------------------- peer

// Another tracer over the same surfaces, in two modes, the fast and the robust one. All null where there is none.
typedef struct peer peer;
peer *peer_create(void);
void peer_destroy(peer *p);
typedef struct peer_scene peer_scene;
peer_scene *peer_scene_create(peer *p, const surface *s, const float maps[WATERTIGHT_MAPS][3][4]);
void peer_scene_destroy(peer_scene *scene);
// Gives the distance, or an infinite one.
float peer_trace(const peer_scene *scene, uint32_t map, bool robust, const clast_ray *ray);

#endif
