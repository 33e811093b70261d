// SPDX-License-Identifier: Apache-2.0
// Splitting triangles whose edges need more segments than a pattern has. A split takes a pattern too: the points of that are the
// corners of its children, and each edge between them asks anew how many segments it needs.
#include "source/displaced.h"

enum {
    CHILDREN_MOST = PATTERN_TRIANGLES,
    POINTS_MOST = PATTERN_VERTICES,
    EDGES_MOST = CHILDREN_MOST + POINTS_MOST, // Euler: one less than faces and vertices
    EDGE_SLOTS = 1024,
    LOOKED_AT_MOST = 3 * RATE_POINTS, // POINTS_MOST and EDGES_MOST, in whole steps of RATE_POINTS
};

typedef struct split_job {
    const displaced_unit *unit;
    const clast_pose *pose;
    const clast_rate_view *view;
    const clast_rate_kernels *rate_kernels;
    clast_displace_kernel displace;
    displaced_face face;
    bool plain; // all its points have one owner
} split_job;

// A triangle that is split.
typedef struct split {
    const uint32_t *triangles; // of its pattern
    uint32_t child_count, next;
    displaced_leaf_corner points[POINTS_MOST];
    uint32_t factors[CHILDREN_MOST][3];
} split;

// ------------------------------------------------------------------------------------------------------------ points

static float density_at(const displaced_face *face, clast_weights at)
{
    const displaced_vertex *const *v = face->vertices;
    return blend1(v[0]->density_square, v[1]->density_square, v[2]->density_square, at);
}

static float shortest_at(const displaced_face *face, clast_weights at)
{
    const displaced_vertex *const *v = face->vertices;
    return blend1(v[0]->shortest_square, v[1]->shortest_square, v[2]->shortest_square, at);
}

static void put_point(clast_rate_points *points, uint32_t i, vec3 position)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        points->positions[axis][i] = position[axis];
    }
}

static void put_base_point(const split_job *job, clast_weights at, uint32_t i, clast_rate_points *points)
{
    const displaced_face *face = &job->face;
    put_point(points, i, clast_displaced_base(job->unit, face, at));
    vec3 normal = blend3(face->normals[0], face->normals[1], face->normals[2], at);
    for (uint32_t axis = 0; axis < 3; axis++) {
        points->normals[axis][i] = normal[axis];
    }
    points->heights[i] = 0.0f;
    points->density_squares[i] = density_at(face, at);
    points->shortest_squares[i] = shortest_at(face, at);
}

// Moves points by their owners' maps, those that follow each other and have the same at once.
static void displace_points(const split_job *job, const clast_weights *at, const uint8_t *places,
                            const uint16_t *levels, uint32_t count, clast_rate_points *points)
{
    clast_displace_corner corners[RATE_POINTS];
    uint32_t numbers[RATE_POINTS], weights[RATE_POINTS] = {0}; // all of each point's one corner
    packed3 moved[RATE_POINTS];
    const displaced_map *maps[RATE_POINTS];
    for (uint32_t i = 0; i < count; i++) {
        uint32_t place = places != NULL ? places[i] : WEIGHTS_INSIDE;
        displaced_site site = clast_displaced_site_within(job->unit, &job->face, at[i], place);
        maps[i] = site.map;
        numbers[i] = i * 0x10101u;
        corners[i] = (clast_displace_corner){{
            [DISPLACE_POSITION] = points->positions[0][i],
            points->positions[1][i],
            points->positions[2][i],
            [DISPLACE_NORMAL] = points->normals[0][i],
            points->normals[1][i],
            points->normals[2][i],
            [DISPLACE_COORDINATES] = site.coordinates[0],
            site.coordinates[1],
            [DISPLACE_LEVEL] = displaced_level(levels[i]),
        }};
    }
    for (uint32_t first = 0, end = 0; first < count; first = end) {
        for (end = first + 1; end < count && maps[end] == maps[first]; end++) {
        }
        clast_displace_job run = displaced_job_of(maps[first], job->pose);
        run.corners = corners;
        run.numbers = numbers + first;
        run.weights = weights + first;
        run.count = end - first;
        run.positions = moved + first;
        job->displace(&run);
    }
    for (uint32_t i = 0; i < count; i++) {
        put_point(points, i, load3(moved[i]));
    }
}

// What points come to in the view, displaced, and the levels at them. At most RATE_POINTS; room for as many. They are seen as
// part of the edges `places` or, where it is null, of the triangle.
static void look_at_some(const split_job *job, const clast_weights *at, const uint8_t *places, uint32_t count,
                         clast_rate_site *sites, uint16_t *levels)
{
    clast_rate_points points;
    uint32_t padded = (count + RATE_LANES_MOST - 1) / RATE_LANES_MOST * RATE_LANES_MOST;
    for (uint32_t i = 0; i < padded; i++) {
        put_base_point(job, at[i < count ? i : 0], i, &points);
    }
    uint16_t again[RATE_POINTS];
    job->rate_kernels->points(job->view, &points, count, sites, levels);
    displace_points(job, at, places, levels, count, &points);
    job->rate_kernels->points(job->view, &points, count, sites, again);
}

// ------------------------------------------------------------------------------------------------------------- edges

// The edges between the points of a split whose segments are not known: each once.
typedef struct edge_list {
    uint32_t count;
    clast_rate_edge edges[EDGES_MOST];
    uint16_t slots[EDGE_SLOTS]; // edge plus one; 0 is free
} edge_list;

static uint32_t find_edge(edge_list *list, uint32_t a, uint32_t b)
{
    uint32_t ends = a < b ? a | b << 8 : b | a << 8;
    uint32_t slot = ends * 2654435761u >> 22;
    while (list->slots[slot] != 0 && list->edges[list->slots[slot] - 1].ends != ends) {
        slot = (slot + 1) % EDGE_SLOTS;
    }
    if (list->slots[slot] == 0) {
        list->edges[list->count] = (clast_rate_edge){ends, 0.0f};
        list->slots[slot] = (uint16_t)++list->count;
    }
    return list->slots[slot] - 1u;
}

// The points of a split's pattern, then the middles of its edges.
typedef struct split_points {
    uint32_t count;
    clast_weights at[LOOKED_AT_MOST];
    uint16_t levels[LOOKED_AT_MOST];
    clast_rate_site sites[LOOKED_AT_MOST];
} split_points;

static void look_at_points(const split_job *job, split_points *points)
{
    for (uint32_t first = 0; first < points->count; first += RATE_POINTS) {
        look_at_some(job, points->at + first, NULL, min_uint(points->count - first, RATE_POINTS), points->sites + first,
                     points->levels + first);
    }
}

static void find_factors(const split_job *job, const split_points *points, const edge_list *list,
                         uint32_t factors[EDGES_MOST])
{
    uint32_t apart[EDGES_MOST];
    bool fixed_count = job->view->metric == CLAST_METRIC_FIXED;
    for (uint32_t i = 0; i < list->count; i++) {
        uint32_t ends = list->edges[i].ends;
        apart[i] = weights_apart(points->at[ends & 255], points->at[ends >> 8]);
        factors[i] = fixed_count ? edge_factor(edge_wanted_fixed(*job->view, apart[i]), apart[i]) : 0;
    }
    if (!fixed_count && list->count != 0) {
        clast_rate_edges edges = {
            .sites = points->sites,
            .edges = list->edges,
            .count = list->count,
            .middles = points->sites + (points->count - list->count),
            .apart = apart,
        };
        job->rate_kernels->edges(job->view, &edges, factors);
    }
}

// Where owners differ, an edge inside is measured by what its triangle has, all along, and one at a seam by what the seam has. A
// step beside a seam is no length: else it would be split without end.
static void find_factors_by_owners(const split_job *job, const split_points *points, const edge_list *list,
                                   uint32_t factors[EDGES_MOST])
{
    enum { SOME_EDGES = RATE_POINTS / 3 };
    for (uint32_t first = 0; first < list->count; first += SOME_EDGES) {
        uint32_t count = min_uint(list->count - first, SOME_EDGES), apart[SOME_EDGES];
        clast_weights at[RATE_POINTS];
        uint8_t places[RATE_POINTS];
        clast_rate_edge ends[SOME_EDGES];
        for (uint32_t i = 0; i < count; i++) {
            uint32_t from = list->edges[first + i].ends;
            clast_weights a = points->at[from & 255], b = points->at[from >> 8];
            at[2 * i] = a;
            at[2 * i + 1] = b;
            at[2 * count + i] = weights_of_middle(a, b);
            places[2 * i] = places[2 * i + 1] = places[2 * count + i] = (uint8_t)displaced_place_between(a, b);
            apart[i] = weights_apart(a, b);
            ends[i] = (clast_rate_edge){2 * i | (2 * i + 1) << 8, 0.0f};
        }
        clast_rate_site sites[RATE_POINTS];
        uint16_t levels[RATE_POINTS];
        look_at_some(job, at, places, 3 * count, sites, levels);
        clast_rate_edges edges = {
            .sites = sites,
            .edges = ends,
            .count = count,
            .middles = sites + 2 * count,
            .apart = apart,
        };
        job->rate_kernels->edges(job->view, &edges, factors + first);
    }
}

// ------------------------------------------------------------------------------------------------------------ splits

static bool is_small(const uint32_t factors[3])
{
    return factors[0] <= PATTERN_SEGMENTS && factors[1] <= PATTERN_SEGMENTS && factors[2] <= PATTERN_SEGMENTS;
}

// The edges between a split's points: their numbers in the list, for each child; those that are not split keep their segments.
static void list_edges(const displaced_part *part, uint32_t rotation, split *made, edge_list *list)
{
    list->count = 0;
    memset(list->slots, 0, sizeof list->slots);
    for (uint32_t i = 0; i < made->child_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = made->triangles[i] >> 8 * k & 255, b = made->triangles[i] >> 8 * ((k + 1) % 3) & 255;
            bool kept = a < 3 && b < 3; // corner a to the next one
            made->factors[i][k] = kept ? part->factors[(a + rotation) % 3] : find_edge(list, a, b);
        }
    }
}

static void set_factors(split *made, const uint32_t *factors)
{
    for (uint32_t i = 0; i < made->child_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = made->triangles[i] >> 8 * k & 255, b = made->triangles[i] >> 8 * ((k + 1) % 3) & 255;
            if (a >= 3 || b >= 3) {
                made->factors[i][k] = factors[made->factors[i][k]];
            }
        }
    }
}

static void put_weights(const split_job *job, const displaced_part *part, displaced_pattern use, const edge_list *list,
                        split_points *points)
{
    uint32_t count = pattern_vertices(*use.pattern);
    const uint32_t *words = job->unit->patterns->vertices + use.pattern->first_vertex;
    for (uint32_t i = 0; i < count; i++) {
        clast_weights within = pattern_unrotate(weights_of(words[i]), use.rotation);
        points->at[i] = weights_within(part->corners[0].at, part->corners[1].at, part->corners[2].at, within);
    }
    for (uint32_t i = 0; i < list->count; i++) {
        uint32_t ends = list->edges[i].ends;
        points->at[count + i] = weights_of_middle(points->at[ends & 255], points->at[ends >> 8]);
    }
    points->count = count + list->count;
}

static vec3 flat_position(const split_job *job, clast_weights at)
{
    const vec3 *p = job->face.positions;
    return blend3(p[0], p[1], p[2], at);
}

// Bounds the segments of edges inside the part.
static void bound_factors(const split_job *job, const displaced_part *part, displaced_pattern use,
                          const split_points *points, const edge_list *list, uint32_t factors[EDGES_MOST])
{
    const uint32_t *words = job->unit->patterns->vertices + use.pattern->first_vertex;
    const vec3 corners[3] = {flat_position(job, part->corners[0].at), flat_position(job, part->corners[1].at),
                             flat_position(job, part->corners[2].at)};
    for (uint32_t i = 0; i < list->count; i++) {
        uint32_t a = list->edges[i].ends & 255, b = list->edges[i].ends >> 8;
        if (factors[i] > PATTERN_SEGMENTS) {
            uint32_t most = displaced_split_most(corners, part->factors, weights_of(words[a]), weights_of(words[b]),
                                                 flat_position(job, points->at[a]), flat_position(job, points->at[b]));
            factors[i] = min_uint(factors[i], most);
        }
    }
}

static void split_part(const split_job *job, const displaced_part *part, split *made)
{
    uint32_t key = pattern_factors(edge_splits(part->factors[0]), edge_splits(part->factors[1]),
                                   edge_splits(part->factors[2]));
    displaced_pattern use = displaced_pattern_of(job->unit, key);
    made->triangles = job->unit->patterns->triangles + use.pattern->first_triangle;
    made->child_count = pattern_triangles(*use.pattern);
    made->next = 0;
    edge_list list;
    list_edges(part, use.rotation, made, &list);
    split_points points;
    put_weights(job, part, use, &list, &points);
    look_at_points(job, &points);
    for (uint32_t i = 0; i < pattern_vertices(*use.pattern); i++) {
        made->points[i] = i < 3 ? part->corners[(i + use.rotation) % 3]
                                : (displaced_leaf_corner){points.at[i], points.levels[i]};
    }
    uint32_t factors[EDGES_MOST];
    bool fixed_count = job->view->metric == CLAST_METRIC_FIXED;
    if (job->plain || fixed_count) {
        find_factors(job, &points, &list, factors);
    } else {
        find_factors_by_owners(job, &points, &list, factors);
    }
    if (!fixed_count) {
        bound_factors(job, part, use, &points, &list, factors);
    }
    set_factors(made, factors);
}

static displaced_part next_child(split *parent)
{
    uint32_t child = parent->next++;
    displaced_part part;
    for (uint32_t k = 0; k < 3; k++) {
        part.corners[k] = parent->points[parent->triangles[child] >> 8 * k & 255];
        part.factors[k] = parent->factors[child][k];
    }
    return part;
}

void clast_displaced_split(const displaced_unit *unit, const clast_pose *pose, const clast_rate_view *view,
                           const displaced_cluster *cluster, uint32_t triangle, const displaced_part *whole,
                           displaced_part_function function, void *user)
{
    clast_isa isa = clast_context_isa(unit->base.context);
    split_job job = {
        .unit = unit,
        .pose = pose,
        .view = view,
        .rate_kernels = clast_rate_kernels_of(isa),
        .displace = clast_displace_kernel_of(isa),
        .face = clast_displaced_face(unit, pose, cluster, triangle),
        .plain = displaced_is_plain(unit->triangles[cluster->first_triangle + triangle]),
    };
    split stack[DISPLACED_SPLITS_DEEPEST];
    uint32_t depth = 1;
    split_part(&job, whole, &stack[0]);
    bool more = true;
    while (depth > 0 && more) {
        if (stack[depth - 1].next == stack[depth - 1].child_count) {
            depth--;
            continue;
        }
        displaced_part part = next_child(&stack[depth - 1]);
        if (!is_small(part.factors) && depth < DISPLACED_SPLITS_DEEPEST) {
            split_part(&job, &part, &stack[depth++]);
            continue;
        }
        for (uint32_t k = 0; k < 3; k++) {
            part.factors[k] = min_uint(part.factors[k], PATTERN_SEGMENTS);
        }
        more = function(user, &part);
    }
}
