// SPDX-License-Identifier: Apache-2.0
// Filling records of displaced meshes. The points of a leaf come in groups, its corners, those within an edge and those inside,
// since each may belong to another owner; points that one map displaces are handed on together.
#include "source/displaced.h"

enum { CORNERS_MOST = 256 }; // that numbers of 8 bits tell apart

typedef struct batch {
    const displaced_unit *unit;
    const clast_pose *pose;
    const displaced_cluster *cluster;
    clast_displace_kernel kernel;
    const displaced_map *map;
    uint32_t corner_count, count;
    packed3 *positions; // of the first of the points
    uint64_t known_vertices[2];
    uint8_t corner_of_vertex[CLUSTER_VERTICES]; // of the cluster
    uint32_t numbers[TEMPLATE_VERTICES], weights[TEMPLATE_VERTICES];
    clast_displace_corner corners[CORNERS_MOST];
} batch;

static void flush(batch *b)
{
    if (b->count != 0) {
        clast_displace_job job = {
            .height = b->map->height,
            .scale = b->map->scale * b->pose->displacement_scale,
            .offset = b->map->height != NULL ? b->map->offset * b->pose->displacement_scale : 0.0f,
            .corners = b->corners,
            .numbers = b->numbers,
            .weights = b->weights,
            .count = b->count,
            .positions = b->positions,
        };
        b->kernel(&job);
    }
    b->positions += b->count;
    b->count = 0;
    b->corner_count = 0;
    memset(b->known_vertices, 0, sizeof b->known_vertices);
}

// Makes room for corners and points of a map.
static void prepare(batch *b, const displaced_map *map, uint32_t corners, uint32_t points)
{
    if (b->map != map || b->corner_count + corners > CORNERS_MOST || b->count + points > TEMPLATE_VERTICES) {
        flush(b);
        b->map = map;
    }
}

static uint32_t add_corner(batch *b, vec3 position, vec3 normal, vec2 coordinates, float level)
{
    b->corners[b->corner_count] = (clast_displace_corner){{
        [DISPLACE_POSITION] = position[0],
        position[1],
        position[2],
        [DISPLACE_NORMAL] = normal[0],
        normal[1],
        normal[2],
        [DISPLACE_COORDINATES] = coordinates[0],
        coordinates[1],
        [DISPLACE_LEVEL] = level,
    }};
    return b->corner_count++;
}

// A vertex of the cluster with what its owner has.
static uint32_t add_vertex(batch *b, const displaced_reader *reader, uint32_t vertex)
{
    uint64_t bit = 1ull << vertex % 64;
    if ((b->known_vertices[vertex / 64] & bit) == 0) {
        const displaced_vertex *from = displaced_vertex_of(b->unit, b->cluster, vertex);
        b->known_vertices[vertex / 64] |= bit;
        b->corner_of_vertex[vertex] = (uint8_t)add_corner(
            b, clast_displaced_position(b->unit, b->pose, from), clast_displaced_normal(b->unit, b->pose, from),
            load2(from->coordinates), clast_displaced_cluster_level(reader, vertex));
    }
    return b->corner_of_vertex[vertex];
}

// Points between three corners of the batch: weights as the pattern has them.
static void add_points(batch *b, const uint32_t corners[3], const uint32_t *weights, uint32_t count)
{
    uint32_t numbers = corners[0] | corners[1] << 8 | corners[2] << 16;
    for (uint32_t i = 0; i < count; i++) {
        b->numbers[b->count + i] = numbers;
        b->weights[b->count + i] = weights[i];
    }
    b->count += count;
}

static void add_vertex_point(batch *b, const displaced_reader *reader, uint32_t vertex)
{
    static const uint32_t all_of_first = 0;
    prepare(b, &b->unit->maps[displaced_vertex_of(b->unit, b->cluster, vertex)->map], 1, 1);
    uint32_t corner = add_vertex(b, reader, vertex);
    add_points(b, (uint32_t[3]){corner, corner, corner}, &all_of_first, 1);
}

// ----------------------------------------------------------------------------------------------------------- leaves

typedef struct leaf_state {
    batch *b;
    const displaced_reader *reader;
    displaced_triangle triangle;
    const uint32_t *weights; // of the pattern's vertices
    bool plain;
    displaced_face face; // where it is split, curved or not plain
} leaf_state;

static clast_weights corner_weights(const leaf_state *leaf, uint32_t k)
{
    return leaf->reader->leaf.split ? leaf->reader->leaf.corners[k].at : weights_of_corner(k);
}

// A corner of the leaf as part of the edge `place` or of the triangle.
static uint32_t add_leaf_corner(const leaf_state *leaf, uint32_t k, displaced_site site)
{
    const displaced_face *face = &leaf->face;
    clast_weights at = corner_weights(leaf, k);
    return add_corner(leaf->b, clast_displaced_base(leaf->b->unit, face, at),
                      blend3(face->normals[0], face->normals[1], face->normals[2], at), site.coordinates,
                      clast_displaced_level_of(leaf->reader, k));
}

// The corners that points of a place are blended from, in the pattern's order.
static void add_corners_of(const leaf_state *leaf, uint32_t place, uint32_t points, uint32_t corners[3])
{
    batch *b = leaf->b;
    uint32_t rotation = leaf->reader->use.rotation;
    if (leaf->plain && !leaf->reader->leaf.split) {
        prepare(b, &b->unit->maps[displaced_vertex_of(b->unit, b->cluster, displaced_corner(leaf->triangle, 0))->map],
                3, points);
        for (uint32_t k = 0; k < 3; k++) {
            corners[k] = add_vertex(b, leaf->reader, displaced_corner(leaf->triangle, (k + rotation) % 3));
        }
        return;
    }
    displaced_site sites[3];
    for (uint32_t k = 0; k < 3; k++) {
        sites[k] = clast_displaced_site_within(b->unit, &leaf->face, corner_weights(leaf, k), place);
    }
    prepare(b, sites[0].map, 3, points);
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = add_leaf_corner(leaf, (k + rotation) % 3, sites[(k + rotation) % 3]);
    }
}

// The edge of the base triangle that an edge of the leaf lies on, as a place.
static uint32_t place_of_edge(const leaf_state *leaf, uint32_t own)
{
    if (!leaf->reader->leaf.split) {
        return WEIGHTS_EDGE + own;
    }
    const displaced_leaf_corner *corners = leaf->reader->leaf.corners;
    clast_weights a = corners[own].at, b = corners[(own + 1) % 3].at;
    uint32_t place = WEIGHTS_INSIDE;
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t opposite = (edge + 2) % 3;
        place = a.of[opposite] == 0 && b.of[opposite] == 0 ? WEIGHTS_EDGE + edge : place;
    }
    return place;
}

static void fill_corner(const leaf_state *leaf, uint32_t k)
{
    uint32_t own = (k + leaf->reader->use.rotation) % 3;
    clast_weights at = corner_weights(leaf, own);
    uint32_t place = weights_place(at);
    if (place < WEIGHTS_EDGE) {
        add_vertex_point(leaf->b, leaf->reader, displaced_corner(leaf->triangle, place));
        return;
    }
    static const uint32_t all_of_first = 0;
    displaced_site site = clast_displaced_site_within(leaf->b->unit, &leaf->face, at, place);
    prepare(leaf->b, site.map, 1, 1);
    uint32_t corner = add_leaf_corner(leaf, own, site);
    add_points(leaf->b, (uint32_t[3]){corner, corner, corner}, &all_of_first, 1);
}

// Group by group, each for its owner.
static void fill_by_owners(const leaf_state *leaf)
{
    const displaced_reader *reader = leaf->reader;
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    uint32_t corners[3];
    for (uint32_t k = 0; k < 3; k++) {
        if (reader->corner_is_new[k]) {
            fill_corner(leaf, k);
        }
    }
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t begin = pattern_edge_begin(factors, k), count = pattern_edge_begin(factors, k + 1) - begin;
        if (reader->edge_is_new[k] && count != 0) {
            add_corners_of(leaf, place_of_edge(leaf, (k + reader->use.rotation) % 3), count, corners);
            add_points(leaf->b, corners, leaf->weights + begin, count);
        }
    }
    uint32_t begin = pattern_edge_begin(factors, 3), count = pattern_vertices(*reader->use.pattern) - begin;
    if (count != 0) {
        add_corners_of(leaf, WEIGHTS_INSIDE, count, corners);
        add_points(leaf->b, corners, leaf->weights + begin, count);
    }
}

// All points have the same owners' coordinates and map: those that the record does not have already.
static void fill_plain(const leaf_state *leaf)
{
    const displaced_reader *reader = leaf->reader;
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    uint32_t vertices = pattern_vertices(*reader->use.pattern);
    uint32_t corners[3];
    add_corners_of(leaf, WEIGHTS_INSIDE, vertices, corners);
    for (uint32_t k = 0; k < 3; k++) {
        add_points(leaf->b, corners, leaf->weights + k, reader->corner_is_new[k] ? 1 : 0);
    }
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t begin = pattern_edge_begin(factors, k), count = pattern_edge_begin(factors, k + 1) - begin;
        add_points(leaf->b, corners, leaf->weights + begin, reader->edge_is_new[k] ? count : 0);
    }
    uint32_t begin = pattern_edge_begin(factors, 3);
    add_points(leaf->b, corners, leaf->weights + begin, vertices - begin);
}

// Curved triangles are not blended from their corners: each point is one by itself.
static void fill_curved_point(const leaf_state *leaf, uint32_t vertex)
{
    static const uint32_t all_of_first = 0;
    const displaced_reader *reader = leaf->reader;
    const displaced_face *face = &leaf->face;
    clast_weights own = pattern_unrotate(weights_of(leaf->weights[vertex]), reader->use.rotation), at = own;
    if (reader->leaf.split) {
        const displaced_leaf_corner *corners = reader->leaf.corners;
        at = weights_within(corners[0].at, corners[1].at, corners[2].at, own);
    }
    float level = blend1(clast_displaced_level_of(reader, 0), clast_displaced_level_of(reader, 1),
                         clast_displaced_level_of(reader, 2), own);
    displaced_site site = clast_displaced_site(leaf->b->unit, face, at);
    prepare(leaf->b, site.map, 1, 1);
    uint32_t corner = add_corner(leaf->b, clast_displaced_base(leaf->b->unit, face, at),
                                 blend3(face->normals[0], face->normals[1], face->normals[2], at), site.coordinates,
                                 level);
    add_points(leaf->b, (uint32_t[3]){corner, corner, corner}, &all_of_first, 1);
}

static void fill_curved(const leaf_state *leaf)
{
    const displaced_reader *reader = leaf->reader;
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    for (uint32_t i = 0; i < pattern_vertices(*reader->use.pattern); i++) {
        bool is_new = i < 3 ? reader->corner_is_new[i] : true;
        for (uint32_t k = 0; k < 3; k++) {
            bool on_edge = i >= pattern_edge_begin(factors, k) && i < pattern_edge_begin(factors, k + 1);
            is_new = on_edge ? reader->edge_is_new[k] : is_new;
        }
        if (is_new) {
            fill_curved_point(leaf, i);
        }
    }
}

static void fill_leaf(batch *b, const displaced_reader *reader)
{
    leaf_state leaf = {.b = b, .reader = reader};
    leaf.triangle = b->unit->triangles[b->cluster->first_triangle + reader->leaf.triangle];
    leaf.weights = b->unit->patterns->vertices + reader->use.pattern->first_vertex;
    leaf.plain = displaced_is_plain(leaf.triangle);
    if (!leaf.plain || reader->leaf.split || b->unit->curved) {
        leaf.face = clast_displaced_face(b->unit, b->pose, b->cluster, reader->leaf.triangle);
    }
    if (b->unit->curved) {
        fill_curved(&leaf);
    } else if (leaf.plain) {
        fill_plain(&leaf);
    } else {
        fill_by_owners(&leaf);
    }
}

// ------------------------------------------------------------------------------------------------------------ fill

void clast_displaced_fill(const clast_unit *base, const clast_pose *pose, const clast_cluster_record *record,
                          const uint32_t *words, packed3 *positions)
{
    const displaced_unit *unit = clast_displaced_of(base);
    displaced_reader reader = clast_displaced_read(unit, record, words);
    batch b;
    b.unit = unit;
    b.pose = pose;
    b.cluster = reader.cluster;
    b.kernel = clast_displace_kernel_of(clast_context_isa(base->context));
    b.map = NULL;
    b.count = b.corner_count = 0;
    b.positions = positions;
    memset(b.known_vertices, 0, sizeof b.known_vertices);
    if (record->detail == 0) {
        for (uint32_t i = 0; i < b.cluster->vertex_count; i++) {
            add_vertex_point(&b, &reader, i);
        }
    }
    while (clast_displaced_next(&reader)) {
        fill_leaf(&b, &reader);
    }
    flush(&b);
}
