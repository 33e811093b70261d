// SPDX-License-Identifier: Apache-2.0
// Filling records of displaced meshes: corners, points within edges and points inside, each for their owners, in the order of the
// record's layout. Points that one map displaces are handed on together.
#include "source/displaced.h"

enum {
    CORNERS_MOST = 256,                 // that numbers of 8 bits tell apart: those of the cluster, then others
    WITHIN_MOST = PATTERN_SEGMENTS - 1, // points within an edge
};

typedef struct batch {
    const displaced_reader *reader;
    const displaced_unit *unit;
    const clast_pose *pose;
    const displaced_cluster *cluster;
    clast_displace_kernel kernel;
    const displaced_map *map;
    uint32_t other_count, count;
    packed3 *positions; // of the first of the points
    bool known[CLUSTER_VERTICES];
    uint32_t numbers[TEMPLATE_VERTICES + WITHIN_MOST], weights[TEMPLATE_VERTICES + WITHIN_MOST];
    clast_displace_corner corners[CORNERS_MOST];
} batch;

static void flush(batch *b)
{
    if (b->count != 0) {
        clast_displace_job job = displaced_job_of(b->map, b->pose);
        job.corners = b->corners;
        job.numbers = b->numbers;
        job.weights = b->weights;
        job.count = b->count;
        job.positions = b->positions;
        b->kernel(&job);
    }
    b->positions += b->count;
    b->count = 0;
    b->other_count = 0;
}

// Makes room for points of a map, and for corners that are not vertices of the cluster.
static void prepare(batch *b, const displaced_map *map, uint32_t others, uint32_t points)
{
    if (b->map != map || CLUSTER_VERTICES + b->other_count + others > CORNERS_MOST ||
        b->count + points > TEMPLATE_VERTICES) {
        flush(b);
        b->map = map;
    }
}

static void put_corner(clast_displace_corner *corner, vec3 position, vec3 normal, vec2 coordinates, float level)
{
    *corner = (clast_displace_corner){{
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
}

static uint32_t add_corner(batch *b, vec3 position, vec3 normal, vec2 coordinates, float level)
{
    uint32_t number = CLUSTER_VERTICES + b->other_count++;
    put_corner(&b->corners[number], position, normal, coordinates, level);
    return number;
}

// A vertex of the cluster, with what its owner has, is the corner of that number.
static void put_vertex(batch *b, uint32_t vertex, const displaced_vertex *from)
{
    b->known[vertex] = true;
    put_corner(&b->corners[vertex], clast_displaced_position(b->unit, b->pose, from),
               clast_displaced_normal(b->unit, b->pose, from), load2(from->coordinates),
               displaced_cluster_level(b->reader, vertex));
}

static inline void put_resting_vertex(batch *b, uint32_t vertex, const displaced_vertex *from)
{
    b->known[vertex] = true;
    float *of = b->corners[vertex].of;
    memcpy(of + DISPLACE_POSITION, from->position.v, sizeof from->position);
    memcpy(of + DISPLACE_NORMAL, from->normal.v, sizeof from->normal);
    memcpy(of + DISPLACE_COORDINATES, from->coordinates.v, sizeof from->coordinates);
    memset(of + DISPLACE_LEVEL, 0, (DISPLACE_FLOATS - DISPLACE_LEVEL) * sizeof *of);
    of[DISPLACE_LEVEL] = displaced_cluster_level(b->reader, vertex);
}

static uint32_t add_vertex(batch *b, uint32_t vertex)
{
    if (!b->known[vertex]) {
        put_vertex(b, vertex, displaced_vertex_of(b->unit, b->cluster, vertex));
    }
    return vertex;
}

static const displaced_map *map_of_vertex(const batch *b, uint32_t vertex)
{
    return &b->unit->maps[displaced_vertex_of(b->unit, b->cluster, vertex)->map];
}

static void add_point(batch *b, uint32_t corner)
{
    b->numbers[b->count] = corner * 0x010101u;
    b->weights[b->count] = 0; // all of the first
    b->count++;
}

static void add_vertex_point(batch *b, uint32_t vertex)
{
    prepare(b, map_of_vertex(b, vertex), 0, 1);
    add_point(b, add_vertex(b, vertex));
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

// By segments: the weights of the points within an edge.
#define WITHIN(n, step) ((step) < (n) ? ((step)*2 * WEIGHT_ONE + (n)) / (2 * (n)) : 0) // pattern_edge_weight()
#define ALL_WITHIN(n) \
    { \
        WITHIN(n, 1), WITHIN(n, 2), WITHIN(n, 3), WITHIN(n, 4), WITHIN(n, 5), WITHIN(n, 6), WITHIN(n, 7), \
            WITHIN(n, 8), WITHIN(n, 9), WITHIN(n, 10) \
    }
static const uint32_t weights_within_edge[PATTERN_SEGMENTS + 1][WITHIN_MOST] = {
    {0},           ALL_WITHIN(1), ALL_WITHIN(2), ALL_WITHIN(3), ALL_WITHIN(4),  ALL_WITHIN(5),
    ALL_WITHIN(6), ALL_WITHIN(7), ALL_WITHIN(8), ALL_WITHIN(9), ALL_WITHIN(10), ALL_WITHIN(11),
};

// The points within an edge from corner a to b. As many are written as there ever are: those that follow write over them.
static void add_edge_points(batch *b, uint32_t first, uint32_t second, uint32_t factor)
{
    uint32_t three = first | second << 8 | first << 16;
    const uint32_t numbers[WITHIN_MOST] = {three, three, three, three, three, three, three, three, three, three};
    memcpy(b->numbers + b->count, numbers, sizeof numbers);
    memcpy(b->weights + b->count, weights_within_edge[factor], sizeof weights_within_edge[factor]);
    b->count += factor - 1;
}

// ----------------------------------------------------------------------------------------------------------- leaves

typedef struct leaf_state {
    batch *b;
    displaced_triangle triangle;
    const uint32_t *weights; // of the pattern's vertices
    bool plain;
    displaced_face face; // where it is split, curved or not plain
} leaf_state;

static leaf_state state_of(batch *b, uint32_t number)
{
    leaf_state leaf = {.b = b, .triangle = b->unit->triangles[b->cluster->first_triangle + number]};
    leaf.weights = b->unit->patterns->vertices + b->reader->use.pattern->first_vertex;
    leaf.plain = displaced_is_plain(leaf.triangle);
    if (!leaf.plain || b->reader->leaf.split || b->unit->curved) {
        leaf.face = clast_displaced_face(b->unit, b->pose, b->cluster, number);
    }
    return leaf;
}

static clast_weights corner_weights(const leaf_state *leaf, uint32_t k)
{
    return leaf->b->reader->leaf.split ? leaf->b->reader->leaf.corners[k].at : weights_of_corner(k);
}

// A corner of the leaf as part of an edge or of the triangle.
static uint32_t add_leaf_corner(const leaf_state *leaf, uint32_t k, displaced_site site)
{
    const displaced_face *face = &leaf->face;
    clast_weights at = corner_weights(leaf, k);
    return add_corner(leaf->b, clast_displaced_base(leaf->b->unit, face, at),
                      blend3(face->normals[0], face->normals[1], face->normals[2], at), site.coordinates,
                      clast_displaced_level_of(leaf->b->reader, k));
}

// The corners that points of a place are blended from, in the pattern's order.
static void add_corners_of(const leaf_state *leaf, uint32_t place, uint32_t points, uint32_t corners[3])
{
    batch *b = leaf->b;
    uint32_t rotation = b->reader->use.rotation;
    if (leaf->plain && !b->reader->leaf.split) {
        prepare(b, map_of_vertex(b, displaced_corner(leaf->triangle, 0)), 0, points);
        for (uint32_t k = 0; k < 3; k++) {
            corners[k] = add_vertex(b, displaced_corner(leaf->triangle, (k + rotation) % 3));
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
    if (!leaf->b->reader->leaf.split) {
        return WEIGHTS_EDGE + own;
    }
    const displaced_leaf_corner *corners = leaf->b->reader->leaf.corners;
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
    uint32_t own = (k + leaf->b->reader->use.rotation) % 3;
    clast_weights at = corner_weights(leaf, own);
    uint32_t place = weights_place(at);
    if (place < WEIGHTS_EDGE) {
        add_vertex_point(leaf->b, displaced_corner(leaf->triangle, place));
        return;
    }
    displaced_site site = clast_displaced_site_within(leaf->b->unit, &leaf->face, at, place);
    prepare(leaf->b, site.map, 1, 1);
    add_point(leaf->b, add_leaf_corner(leaf, own, site));
}

static void fill_inside(const leaf_state *leaf)
{
    clast_pattern pattern = *leaf->b->reader->use.pattern;
    uint32_t begin = pattern_edge_begin(pattern_own_factors(pattern), 3), count = pattern_vertices(pattern) - begin;
    if (count != 0) {
        uint32_t corners[3];
        add_corners_of(leaf, WEIGHTS_INSIDE, count, corners);
        add_points(leaf->b, corners, leaf->weights + begin, count);
    }
}

// Group by group, each for its owner.
static void fill_by_owners(const leaf_state *leaf)
{
    uint32_t factors = pattern_own_factors(*leaf->b->reader->use.pattern);
    for (uint32_t k = 0; k < 3; k++) {
        fill_corner(leaf, k);
    }
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t begin = pattern_edge_begin(factors, k), count = pattern_factor(factors, k) - 1, corners[3];
        if (count != 0) {
            add_corners_of(leaf, place_of_edge(leaf, (k + leaf->b->reader->use.rotation) % 3), count, corners);
            add_points(leaf->b, corners, leaf->weights + begin, count);
        }
    }
    fill_inside(leaf);
}

// All points have the same owners' coordinates and map.
static void fill_plain(const leaf_state *leaf)
{
    batch *b = leaf->b;
    uint32_t count = pattern_vertices(*b->reader->use.pattern), corners[3];
    add_corners_of(leaf, WEIGHTS_INSIDE, count, corners);
    if (b->count != 0) {
        add_points(b, corners, leaf->weights, count);
        return;
    }
    // nothing waits to go with them: they need no numbers
    const clast_displace_corner three[3] = {b->corners[corners[0]], b->corners[corners[1]], b->corners[corners[2]]};
    clast_displace_job job = displaced_job_of(b->map, b->pose);
    job.corners = three;
    job.weights = leaf->weights;
    job.count = count;
    job.positions = b->positions;
    b->kernel(&job);
    b->positions += count;
}

// A point whose owner may be another triangle than its own: by itself. `own` are weights of the leaf's corners.
static void fill_curved_point(const leaf_state *leaf, clast_weights own)
{
    const displaced_reader *reader = leaf->b->reader;
    const displaced_face *face = &leaf->face;
    const displaced_leaf_corner *corners = reader->leaf.corners;
    clast_weights at = reader->leaf.split ? weights_within(corners[0].at, corners[1].at, corners[2].at, own) : own;
    float level = blend1(clast_displaced_level_of(reader, 0), clast_displaced_level_of(reader, 1),
                         clast_displaced_level_of(reader, 2), own);
    displaced_site site = clast_displaced_site(leaf->b->unit, face, at);
    prepare(leaf->b, site.map, 1, 1);
    add_point(leaf->b,
              add_corner(leaf->b, clast_displaced_base(leaf->b->unit, face, at),
                         blend3(face->normals[0], face->normals[1], face->normals[2], at), site.coordinates, level));
}

static clast_displace_curve curve_of(const displaced_face *face)
{
    clast_displace_curve curve;
    for (uint32_t axis = 0; axis < 3; axis++) {
        for (uint32_t k = 0; k < 3; k++) {
            curve.positions[k][axis] = face->positions[k][axis];
        }
        for (uint32_t k = 0; k < 6; k++) {
            curve.controls[k][axis] = face->controls[k][axis];
        }
    }
    return curve;
}

// Curved triangles are not blended from their corners: nothing goes with their points. `own` are weights_word() of the leaf's corners.
static void fill_curved_points(const leaf_state *leaf, const uint32_t *own, uint32_t count)
{
    batch *b = leaf->b;
    const displaced_face *face = &leaf->face;
    if (!leaf->plain) {
        for (uint32_t i = 0; i < count; i++) {
            fill_curved_point(leaf, weights_of(own[i]));
        }
        return;
    }
    flush(b);
    clast_displace_corner corners[3];
    clast_weights within[3];
    for (uint32_t k = 0; k < 3; k++) {
        put_corner(&corners[k], face->positions[k], face->normals[k], face->coordinates[k],
                   clast_displaced_level_of(b->reader, k));
        within[k] = corner_weights(leaf, k);
    }
    clast_displace_curve curve = curve_of(face);
    clast_displace_job job = displaced_job_of(face->map, b->pose);
    job.corners = corners;
    job.weights = own;
    job.within = b->reader->leaf.split ? within : NULL;
    job.curve = &curve;
    job.count = count;
    job.positions = b->positions;
    b->kernel(&job);
    b->positions += count;
}

// The pattern's vertices from `begin` on.
static void fill_curved(const leaf_state *leaf, uint32_t begin)
{
    const displaced_reader *reader = leaf->b->reader;
    uint32_t own[TEMPLATE_VERTICES], count = pattern_vertices(*reader->use.pattern) - begin;
    for (uint32_t i = 0; i < count; i++) {
        own[i] = weights_word(pattern_unrotate(weights_of(leaf->weights[begin + i]), reader->use.rotation));
    }
    fill_curved_points(leaf, own, count);
}

// All of a leaf's points.
static void fill_alone(batch *b)
{
    leaf_state leaf = state_of(b, b->reader->leaf.triangle);
    if (b->unit->curved) {
        fill_curved(&leaf, 0);
    } else if (leaf.plain) {
        fill_plain(&leaf);
    } else {
        fill_by_owners(&leaf);
    }
}

// ------------------------------------------------------------------------------------------------------- composites

// A leaf that has an edge, where it matters which.
typedef struct edge_user {
    uint8_t triangle, edge; // of the cluster, of the triangle
    bool is_there;
} edge_user;

// Points within an edge of a triangle whose points have owners, or that is curved. They run along the cluster's edge.
static void fill_edge_of(batch *b, displaced_reader *reader, edge_user user, uint32_t factor)
{
    reader->leaf.triangle = user.triangle;
    leaf_state leaf = state_of(b, user.triangle);
    bool along = displaced_goes_along(leaf.triangle, user.edge);
    if (b->unit->curved) {
        uint32_t own[WITHIN_MOST];
        for (uint32_t step = 1; step < factor; step++) {
            own[step - 1] = weights_word(pattern_edge_point(user.edge, factor, along ? step : factor - step));
        }
        fill_curved_points(&leaf, own, factor - 1);
        return;
    }
    uint32_t first = along ? user.edge : (user.edge + 1) % 3, second = along ? (user.edge + 1) % 3 : user.edge;
    displaced_site sites[2] = {
        clast_displaced_site_within(b->unit, &leaf.face, weights_of_corner(first), WEIGHTS_EDGE + user.edge),
        clast_displaced_site_within(b->unit, &leaf.face, weights_of_corner(second), WEIGHTS_EDGE + user.edge),
    };
    prepare(b, sites[0].map, 2, factor - 1);
    uint32_t corner = add_leaf_corner(&leaf, first, sites[0]);
    add_edge_points(b, corner, add_leaf_corner(&leaf, second, sites[1]), factor);
}

static void find_users(displaced_reader reader, edge_user users[DISPLACED_EDGES])
{
    memset(users, 0, DISPLACED_EDGES * sizeof *users);
    while (clast_displaced_next(&reader)) {
        uint32_t number = reader.leaf.triangle;
        displaced_triangle triangle = reader.unit->triangles[reader.cluster->first_triangle + number];
        for (uint32_t k = 0; k < 3 && !reader.leaf.split; k++) {
            if (reader.unit->curved || !displaced_is_plain(triangle)) {
                users[displaced_edge_of(triangle, k)] = (edge_user){(uint8_t)number, (uint8_t)k, true};
            }
        }
    }
}

// What the leaves share where one map displaces all of it at rest; false where it is not so.
static bool fill_plainly(batch *b, const displaced_layout *layout)
{
    if (layout->by_owners || b->unit->curved || b->pose->positions != NULL || b->pose->normals != NULL ||
        layout->vertex_count == 0) {
        return false;
    }
    const uint32_t *vertex_numbers = b->unit->vertex_numbers + b->cluster->first_vertex;
    uint32_t map = b->unit->vertices[vertex_numbers[layout->vertex_list[0]]].map, others = 0;
    for (uint32_t i = 0; i < layout->vertex_count; i++) {
        uint32_t vertex = layout->vertex_list[i];
        const displaced_vertex *from = &b->unit->vertices[vertex_numbers[vertex]];
        others |= from->map ^ map;
        put_resting_vertex(b, vertex, from);
        b->numbers[i] = vertex * 0x010101u;
        b->weights[i] = 0; // all of the first
    }
    if (others != 0) {
        return false;
    }
    b->map = &b->unit->maps[map];
    b->count = layout->vertex_count; // all points of a record have room in a batch
    const displaced_edge *edges = b->unit->edges + b->cluster->first_edge;
    for (uint32_t i = 0; i < layout->edge_count; i++) {
        uint32_t number = layout->edge_list[i], ends = edges[number].ends;
        add_edge_points(b, ends & 255, ends >> 8 & 255, layout->factors[number]);
    }
    return true;
}

// What the leaves share.
static void fill_shared(batch *b, displaced_reader *reader, const displaced_layout *layout)
{
    if (fill_plainly(b, layout)) {
        return;
    }
    edge_user users[DISPLACED_EDGES];
    bool by_users = layout->by_owners || b->unit->curved;
    if (by_users) {
        find_users(*reader, users);
    }
    for (uint32_t i = 0; i < layout->vertex_count; i++) {
        add_vertex_point(b, layout->vertex_list[i]);
    }
    for (uint32_t i = 0; i < layout->edge_count; i++) {
        uint32_t number = layout->edge_list[i], factor = layout->factors[number];
        if (by_users && users[number].is_there) {
            fill_edge_of(b, reader, users[number], factor);
            continue;
        }
        uint32_t ends = b->unit->edges[b->cluster->first_edge + number].ends;
        prepare(b, map_of_vertex(b, ends & 255), 0, factor - 1);
        add_edge_points(b, ends & 255, ends >> 8 & 255, factor);
    }
}

static void fill_composite(batch *b, displaced_reader *reader, const displaced_layout *layout, bool leaves_have_own)
{
    reader->leaf.split = false;
    reader->use = displaced_pattern_of(b->unit, pattern_factors(1, 1, 1));
    fill_shared(b, reader, layout);
    while (leaves_have_own && clast_displaced_next(reader)) {
        if (reader->leaf.split) {
            fill_alone(b);
            continue;
        }
        clast_pattern pattern = *reader->use.pattern;
        uint32_t begin = pattern_edge_begin(pattern_own_factors(pattern), 3);
        if (pattern_vertices(pattern) == begin) {
            continue;
        }
        leaf_state leaf = state_of(b, reader->leaf.triangle);
        if (b->unit->curved) {
            fill_curved(&leaf, begin);
        } else {
            fill_inside(&leaf);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------ fill

static void begin_batch(batch *b, const displaced_reader *reader, const clast_pose *pose, packed3 *positions)
{
    b->reader = reader;
    b->unit = reader->unit;
    b->pose = pose;
    b->cluster = reader->cluster;
    b->kernel = clast_displace_kernel_of(clast_context_isa(reader->unit->base.context));
    b->map = NULL;
    b->count = b->other_count = 0;
    b->positions = positions;
    memset(b->known, 0, sizeof b->known);
}

void clast_displaced_fill(const clast_unit *base, const clast_pose *pose, const clast_cluster_record *record,
                          const uint32_t *words, packed3 *positions)
{
    displaced_reader reader = clast_displaced_read(clast_displaced_of(base), record, words);
    batch b;
    begin_batch(&b, &reader, pose, positions);
    if (record_form(*record) == FORM_COMPOSITE) {
        displaced_layout layout;
        clast_displaced_kernels_of(clast_context_isa(base->context))->lay_out(&reader, &layout);
        fill_composite(&b, &reader, &layout, true);
    } else if (clast_displaced_next(&reader)) {
        fill_alone(&b);
    } else {
        for (uint32_t i = 0; i < b.cluster->vertex_count; i++) {
            add_vertex_point(&b, i);
        }
    }
    flush(&b);
}

void clast_displaced_fill_composite(const clast_unit *base, const clast_pose *pose, const clast_cluster_record *record,
                                    const uint32_t *words, packed3 *positions, uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    displaced_reader reader = clast_displaced_read(clast_displaced_of(base), record, words);
    const displaced_kernels *kernels = clast_displaced_kernels_of(clast_context_isa(base->context));
    displaced_layout layout;
    kernels->lay_out(&reader, &layout);
    bool leaves_have_own = kernels->place(&reader, &layout, corners) != 0;
    batch b;
    begin_batch(&b, &reader, pose, positions);
    fill_composite(&b, &reader, &layout, leaves_have_own);
    flush(&b);
}
