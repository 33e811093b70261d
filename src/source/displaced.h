// SPDX-License-Identifier: Apache-2.0
// Meshes that are cut anew each frame, as finely as they are seen, and displaced by maps. An item is a base cluster: a cooked
// cluster of the welded mesh. Its triangles become *leaves*: a triangle, or a part of one that was split, with the pattern that
// its edges' segments ask for. Records are the base cluster as it is, a single leaf, or several small ones.
//
// A vertex of the welded mesh and an edge of it have an *owner*, the lowest of the mesh's triangles that have it: whatever
// texture coordinates and materials meet there, all displace it by the owner's.
#ifndef CLAST_SOURCE_DISPLACED_H
#define CLAST_SOURCE_DISPLACED_H

#include "geometry/pattern.h"
#include "shared/displaced.h"
#include "source/displace.h"
#include "source/mesh.h"
#include "source/rate.h"

enum { DISPLACED_FACTORS = 4096 }; // numbers of pattern_factors()

// What is cooked are the records of shared/displaced.h.
typedef clast_displaced_vertex displaced_vertex;
typedef clast_displaced_normal_part displaced_normal;
typedef clast_displaced_triangle displaced_triangle;
typedef clast_rate_edge displaced_edge;
typedef clast_displaced_seam displaced_seam;
typedef clast_displaced_cluster displaced_cluster;
typedef clast_displaced_gradient displaced_gradient;

// A displacement texture as a material uses it: clast_displaced_map, with the texels.
typedef struct displaced_map {
    const clast_height *height; // null for none
    float scale, offset;        // the height is value * scale + offset
    uint32_t coordinate_set;
    vec2 columns[2], moved; // coordinates of the map: columns[0] * u + columns[1] * v + moved
} displaced_map;

typedef struct displaced_unit {
    clast_unit base;
    const clast_template_set *templates;
    clast_height_store *heights;
    const clast_pattern_table *patterns;
    uint32_t first_pattern; // template of the first pattern
    uint16_t *pattern_uses; // pattern_use() by factors: the number, and above its 9 bits the rotation
    bool curved;
    bool closed;    // each edge has as many triangles to either side
    bool opaque;    // nothing is seen through it
    bool displaced; // some map moves something
    displaced_cluster *clusters;
    displaced_triangle *triangles;
    uint32_t *mesh_triangles; // for each of them
    uint32_t *vertex_numbers; // into vertices, for each of the clusters' vertices
    displaced_edge *edges;
    displaced_seam *seams;
    displaced_vertex *vertices; // and one more: its first_normal is the end
    displaced_normal *normals;
    uint32_t *vertex_of; // by the mesh's vertex: into vertices; CLAST_NONE where no triangle has it
    displaced_gradient *gradients[2];
    displaced_map *maps;
    clast_displaced_map *map_records; // the same, for devices
    uint32_t *map_of_material;
    size_t triangle_count, corner_count, edge_count, seam_count, vertex_count, normal_count, map_count;
    size_t material_count;         // that map_of_material tells of
    clast_box rest;                // of the undisplaced surface
    clast_box reach;               // what displacement adds where pose.displacement_scale is 1
    float height_most;             // the largest height either way, then
    clast_displaced_header header; // of the above, once it is cooked
} displaced_unit;

static inline const displaced_unit *clast_displaced_of(const clast_unit *unit)
{
    return (const displaced_unit *)unit;
}

static inline const displaced_vertex *displaced_vertex_of(const displaced_unit *unit, const displaced_cluster *cluster,
                                                          uint32_t vertex)
{
    return &unit->vertices[unit->vertex_numbers[cluster->first_vertex + vertex]];
}

static inline uint32_t displaced_map_of(const displaced_unit *unit, uint32_t mesh_triangle)
{
    return unit->map_of_material[clast_mesh_material(&unit->base.geometry->of.mesh, mesh_triangle)];
}

// ------------------------------------------------------------------------------------------------------------- cook

clast_status clast_displaced_cook(const clast_cook_job *job, clast_unit **unit);
void clast_displaced_destroy(clast_unit *unit);

// Coordinates of a map at a vertex of the mesh.
vec2 clast_displaced_coordinates(const displaced_map *map, const clast_mesh *mesh, uint32_t vertex);
// The height where pose.displacement_scale is 1.
float clast_displaced_height(const displaced_map *map, vec2 coordinates, float level);

// What displaces by a map in a pose; points are still to be set.
static inline clast_displace_job displaced_job_of(const displaced_map *map, const clast_pose *pose)
{
    return (clast_displace_job){
        .height = map->height,
        .scale = map->scale * pose->displacement_scale,
        .offset = map->height != NULL ? map->offset * pose->displacement_scale : 0.0f,
    };
}

// --------------------------------------------------------------------------------------------------------- vertices

// Position and normal of a vertex in a pose.
vec3 clast_displaced_position(const displaced_unit *unit, const clast_pose *pose, const displaced_vertex *vertex);
vec3 clast_displaced_normal(const displaced_unit *unit, const clast_pose *pose, const displaced_vertex *vertex);

// The box of the surface in a pose where nothing is displaced.
clast_box clast_displaced_rest_box(const displaced_unit *unit, const clast_pose *pose);

// A triangle with all that its points are blended from.
typedef struct displaced_face {
    vec3 positions[3], normals[3];
    vec3 controls[6];    // curved_control(), where it is curved
    vec2 coordinates[3]; // its own
    const displaced_map *map;
    const displaced_vertex *vertices[3];
    const displaced_seam *seams[3]; // of its edges; null where there is none
    bool along[3];                  // the edge has the seam's direction
} displaced_face;

displaced_face clast_displaced_face(const displaced_unit *unit, const clast_pose *pose,
                                    const displaced_cluster *cluster, uint32_t triangle);

// What displaces a point.
typedef struct displaced_site {
    const displaced_map *map;
    vec2 coordinates;
} displaced_site;

// Of a point, by its owner: that of a vertex, an edge or the triangle.
displaced_site clast_displaced_site(const displaced_unit *unit, const displaced_face *face, clast_weights at);
// The same as part of the edge `place` - 3 or, for WEIGHTS_INSIDE, of the triangle: for what is blended from it.
displaced_site clast_displaced_site_within(const displaced_unit *unit, const displaced_face *face, clast_weights at,
                                           uint32_t place);
// Where it is before it is displaced.
vec3 clast_displaced_base(const displaced_unit *unit, const displaced_face *face, clast_weights at);

// ------------------------------------------------------------------------------------------------------------ rates

// Of a cluster in a view: segments of its edges, levels of the maps at its vertices.
typedef struct displaced_rates {
    uint32_t factors[DISPLACED_EDGES];
    uint16_t levels[CLUSTER_VERTICES]; // in HEIGHT_LEVEL_STEPS
} displaced_rates;

clast_rate_view clast_displaced_rate_view(const displaced_unit *unit, const clast_pose *pose,
                                          const clast_source_view *view);
void clast_displaced_rates(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                           const displaced_cluster *cluster, displaced_rates *rates);

// The segments, not rounded, that an edge of a cluster is to have.
float clast_displaced_wanted(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                             const displaced_cluster *cluster, uint32_t edge);

// ----------------------------------------------------------------------------------------------------------- splits

// A corner of a part of a triangle.
typedef struct displaced_leaf_corner {
    clast_weights at;
    uint32_t level; // in HEIGHT_LEVEL_STEPS
} displaced_leaf_corner;

typedef struct displaced_part {
    displaced_leaf_corner corners[3];
    uint32_t factors[3];
} displaced_part;

// Takes the parts of a triangle, of at most PATTERN_SEGMENTS an edge, one after the other; false for no more of them.
typedef bool (*displaced_part_function)(void *user, const displaced_part *part);

// Splits a triangle of a cluster whose edges need more. Depth first, children in the order of their pattern.
void clast_displaced_split(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                           const displaced_cluster *cluster, uint32_t triangle, const displaced_part *whole,
                           displaced_part_function function, void *user);

// ----------------------------------------------------------------------------------------------------------- leaves

typedef struct displaced_leaf {
    uint32_t triangle; // of the cluster
    uint32_t factors;  // pattern_factors()
    bool split;
    displaced_leaf_corner corners[3]; // where it is split
} displaced_leaf;

static inline uint32_t displaced_level_words(const displaced_unit *unit, const displaced_cluster *cluster)
{
    return displaced_words_of_levels(cluster->vertex_count, unit->displaced);
}

// The pattern of a leaf, and the place of its corner k among the leaf's corners: (k + rotation) % 3.
typedef struct displaced_pattern {
    const clast_pattern *pattern;
    uint32_t number;
    uint32_t rotation;
} displaced_pattern;

static inline displaced_pattern displaced_pattern_of(const displaced_unit *unit, uint32_t factors)
{
    uint32_t use = unit->pattern_uses[factors];
    return (displaced_pattern){&unit->patterns->patterns[use & 511], use & 511, use >> 9};
}

// Reads the leaves of a record.
typedef struct displaced_reader {
    const displaced_unit *unit;
    const displaced_cluster *cluster;
    const uint32_t *words;  // of the leaves
    const uint32_t *splits; // of the next one that is split
    const uint32_t *levels; // of the cluster's vertices, two in a word; null where it is not displaced
    uint32_t leaf_count, next;
    // of the leaf that was read
    displaced_leaf leaf;
    displaced_pattern use;
    uint32_t first_triangle;
} displaced_reader;

displaced_reader clast_displaced_read(const displaced_unit *unit, const clast_cluster_record *record,
                                      const uint32_t *words);
// False where there are no more leaves.
bool clast_displaced_next(displaced_reader *reader);
// The level at a vertex of the cluster, and at a corner of the leaf.
static inline float displaced_cluster_level(const displaced_reader *reader, uint32_t vertex)
{
    return displaced_level(reader->levels != NULL ? reader->levels[vertex / 2] >> 16 * (vertex % 2) & 65535 : 0);
}
float clast_displaced_level_of(const displaced_reader *reader, uint32_t corner);

enum { DISPLACED_TOGETHER = 16 }; // places that are found at once: arrays of them have room for some more

// Where a composite's vertices are that leaves share. By vertex and by edge of the cluster, whether or not the record has it: its
// place, and the place of the first point within; whether a vertex is there; an edge's segments, 0 where it is not there.
typedef struct displaced_layout {
    uint8_t vertex_at[CLUSTER_VERTICES + DISPLACED_TOGETHER], edge_at[DISPLACED_EDGES + DISPLACED_TOGETHER];
    uint8_t vertices[CLUSTER_VERTICES + DISPLACED_TOGETHER], factors[DISPLACED_EDGES + DISPLACED_TOGETHER];
    uint16_t vertex_list[CLUSTER_VERTICES + DISPLACED_TOGETHER]; // those that are there
    uint16_t edge_list[DISPLACED_EDGES + DISPLACED_TOGETHER];    // those that have points within
    uint32_t vertex_count, edge_count, shared_count;
    bool by_owners; // a triangle is not plain
} displaced_layout;

typedef struct displaced_kernels {
    // Of a record of which nothing has been read.
    void (*lay_out)(const displaced_reader *reader, displaced_layout *layout);
    // The corners of its triangles. Gives how many vertices its leaves have of their own.
    uint32_t (*place)(const displaced_reader *reader, const displaced_layout *layout,
                      uint8_t corners[3 * TEMPLATE_TRIANGLES]);
} displaced_kernels;
const displaced_kernels *clast_displaced_kernels_of(clast_isa isa);

#define DISPLACED_DECLARE(set) \
    void clast_displaced_lay_out_##set(const displaced_reader *reader, displaced_layout *layout); \
    uint32_t clast_displaced_place_##set(const displaced_reader *reader, const displaced_layout *layout, \
                                         uint8_t corners[3 * TEMPLATE_TRIANGLES]);
CLAST_EACH_ISA(DISPLACED_DECLARE)
#define DISPLACED_KERNELS(set) \
    { \
        clast_displaced_lay_out_##set, clast_displaced_place_##set \
    }

// ------------------------------------------------------------------------------------------------------------- duties

clast_source_count clast_displaced_count(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                                         uint32_t item);
clast_source_count clast_displaced_draft(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                                         uint32_t item, const clast_source_draft *draft);
void clast_displaced_emit(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view, uint32_t item,
                          uint32_t first_vertex, uint32_t first_word, uint32_t *words, clast_cluster_record *records);
void clast_displaced_fill(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                          const uint32_t *words, packed3 *positions);
void clast_displaced_fill_composite(const clast_unit *unit, const clast_pose *pose, const clast_cluster_record *record,
                                    const uint32_t *words, packed3 *positions, uint8_t corners[3 * TEMPLATE_TRIANGLES]);
void clast_displaced_corners(const clast_unit *unit, const clast_cluster_record *record, const uint32_t *words,
                             uint8_t corners[3 * TEMPLATE_TRIANGLES]);
clast_surface_point clast_displaced_locate(const clast_unit *unit, const clast_pose *pose,
                                           const clast_cluster_record *record, const uint32_t *words, uint32_t triangle,
                                           vec2 barycentrics);
float clast_displaced_segments(const clast_unit *unit, const clast_pose *pose, const clast_source_view *view,
                               const clast_cluster_record *record, const uint32_t *words, uint32_t triangle,
                               vec2 barycentrics);
clast_source_surface clast_displaced_evaluate(const clast_unit *unit, const clast_pose *pose,
                                              clast_surface_point point);

#endif
