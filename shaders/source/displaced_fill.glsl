// SPDX-License-Identifier: Apache-2.0
// Filling records of displaced meshes by a subgroup: each vertex of a record is told what it is, then all are computed at
// once. The twin of src/source/displaced_fill.c and displaced_leaves.c, whose order of vertices it keeps.
#ifndef CLAST_SOURCE_DISPLACED_FILL_GLSL
#define CLAST_SOURCE_DISPLACED_FILL_GLSL

#include "source/displaced_reader.glsl"

// What a vertex of a record is: a vertex of the cluster; a point within an edge of it; or a vertex of a leaf's pattern.
const uint DISPLACED_VERTEX = 0u;
const uint DISPLACED_EDGE = 1u; // and the step along it 16 bits up
const uint DISPLACED_LEAF = 2u; // and the vertex of the pattern 16 bits up
const uint DISPLACED_WHAT_SHIFT = 30u;
shared uint displaced_whats[CLUSTERS_TOGETHER * TEMPLATE_VERTICES];

// Of a composite's leaves that are whole triangles: vertices and edges of the cluster that they share. By vertex: 1 where it is
// there, and its place 16 bits up. By edge: its segments, 0 where it is not there; one more than the leaf whose triangle its
// points are blended in, where that matters, 8 bits up; and the place of the first point 16 bits up.
shared uint displaced_vertex_places[CLUSTERS_TOGETHER * CLUSTER_VERTICES];
shared uint displaced_edge_places[CLUSTERS_TOGETHER * DISPLACED_EDGES];
// By leaf: where its own vertices begin, and 16 bits up how many before it are split.
shared uint displaced_own_places[CLUSTERS_TOGETHER * DISPLACED_RECORD_TRIANGLES];

// Where these are of the subgroup's record.
uint displaced_what_place(uint vertex) { return cluster_slot() * TEMPLATE_VERTICES + vertex; }
uint displaced_vertex_place(uint vertex) { return cluster_slot() * CLUSTER_VERTICES + vertex; }
uint displaced_edge_place(uint edge) { return cluster_slot() * DISPLACED_EDGES + edge; }
uint displaced_own_place(uint leaf) { return cluster_slot() * DISPLACED_RECORD_TRIANGLES + leaf; }

uint displaced_word_of(uint64_t words, uint leaf) { return uints(words).at[1u + leaf]; }

// -------------------------------------------------------------------------------------------------------------- layout

void displaced_mark_shared(unit_reference unit, clast_displaced_cluster cluster, uint leaf, uint word, bool curved)
{
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(word));
    uint factors = displaced_leaf_factors(word);
    uint user = curved || !displaced_is_plain(triangle) ? leaf + 1u << 8u : 0u;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        atomicOr(displaced_vertex_places[displaced_vertex_place(displaced_corner(triangle, k))], 1u);
        atomicMax(displaced_edge_places[displaced_edge_place(displaced_edge_of(triangle, k))],
                  pattern_factor(factors, k) | user);
    }
}

uint displaced_points_within(uint edge_place)
{
    uint factor = edge_place & 255u;
    return factor != 0u ? factor - 1u : 0u;
}

// A leaf's vertices that no other has: of parts of split triangles all, else those inside.
uint displaced_own_begin(uint word, clast_pattern pattern)
{
    return displaced_leaf_is_split(word) ? 0u : pattern_edge_begin(pattern_own_factors(pattern), 3u);
}

// What comes before, by invocation, and in all.
struct displaced_sum {
    uint before, all;
};

displaced_sum displaced_sum_of(uint value)
{
    cluster_barrier(); // all are here
    return displaced_sum(subgroupExclusiveAdd(value), subgroupAdd(value));
}

// An invocation has neighbours among vertices, edges and leaves, so that sums over invocations follow their order.
const uint DISPLACED_VERTICES_EACH = (CLUSTER_VERTICES + LANES - 1u) / LANES;
const uint DISPLACED_EDGES_EACH = DISPLACED_EDGES / LANES;
const uint DISPLACED_LEAVES_EACH = DISPLACED_RECORD_TRIANGLES / LANES;

void displaced_clear()
{
    for (uint i = cluster_lane(); i < CLUSTER_VERTICES; i += LANES) {
        displaced_vertex_places[displaced_vertex_place(i)] = 0u;
    }
    for (uint i = cluster_lane(); i < DISPLACED_EDGES; i += LANES) {
        displaced_edge_places[displaced_edge_place(i)] = 0u;
    }
    cluster_barrier();
}

// Of a leaf: how many vertices are its own, the first of them in the pattern 9 bits up, and 1 above 20 bits where it is split.
uint displaced_own_of(unit_reference unit, uint word)
{
    clast_pattern pattern = displaced_pattern_at(unit, pattern_use(displaced_leaf_factors(word)).number);
    uint begin = displaced_own_begin(word, pattern);
    return pattern_vertices(pattern) - begin | begin << 9u | (displaced_leaf_is_split(word) ? 1u << 20u : 0u);
}

// Marks what leaves share. What is known of an invocation's leaves is kept where their places will be.
displaced_sum displaced_mark_leaves(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count)
{
    bool curved = displaced_is_curved(unit);
    uint sum = 0u; // own vertices; split ones 16 bits up
    for (uint i = 0u; i < DISPLACED_LEAVES_EACH; i++) {
        uint leaf = cluster_lane() * DISPLACED_LEAVES_EACH + i;
        if (leaf >= leaf_count) {
            break;
        }
        uint word = displaced_word_of(words, leaf), own = displaced_own_of(unit, word);
        displaced_own_places[displaced_own_place(leaf)] = own;
        sum += (own & 511u) | own >> 20u << 16u;
        if (!displaced_leaf_is_split(word)) {
            displaced_mark_shared(unit, cluster, leaf, word, curved);
        }
    }
    cluster_barrier();
    return displaced_sum_of(sum);
}

// Places the vertices of the cluster that are there; how many there are.
uint displaced_place_vertices()
{
    uint count = 0u;
    for (uint i = 0u; i < DISPLACED_VERTICES_EACH; i++) {
        count += displaced_vertex_places[displaced_vertex_place(cluster_lane() * DISPLACED_VERTICES_EACH + i)];
    }
    displaced_sum sum = displaced_sum_of(count);
    uint at = sum.before;
    for (uint i = 0u; i < DISPLACED_VERTICES_EACH; i++) {
        uint vertex = cluster_lane() * DISPLACED_VERTICES_EACH + i, place = displaced_vertex_place(vertex);
        if (displaced_vertex_places[place] != 0u) {
            displaced_vertex_places[place] = 1u | at << 16u;
            displaced_whats[displaced_what_place(at++)] = DISPLACED_VERTEX << DISPLACED_WHAT_SHIFT | vertex;
        }
    }
    return sum.all;
}

// Places the points within edges, from `begin` on; where they end.
uint displaced_place_edges(uint begin)
{
    uint count = 0u;
    for (uint i = 0u; i < DISPLACED_EDGES_EACH; i++) {
        uint number = cluster_lane() * DISPLACED_EDGES_EACH + i;
        count += displaced_points_within(displaced_edge_places[displaced_edge_place(number)]);
    }
    displaced_sum sum = displaced_sum_of(count);
    uint at = begin + sum.before;
    for (uint i = 0u; i < DISPLACED_EDGES_EACH; i++) {
        uint number = cluster_lane() * DISPLACED_EDGES_EACH + i, place = displaced_edge_place(number);
        uint edge = displaced_edge_places[place];
        displaced_edge_places[place] = edge | at << 16u;
        for (uint step = 1u; step < (edge & 255u); step++) {
            displaced_whats[displaced_what_place(at++)] = DISPLACED_EDGE << DISPLACED_WHAT_SHIFT | step << 16u | number;
        }
    }
    return begin + sum.all;
}

// Places the leaves' own vertices, from `begin` on.
void displaced_place_own(uint leaf_count, uint begin, uint before)
{
    uint at = begin + (before & 65535u), split = before >> 16u;
    for (uint i = 0u; i < DISPLACED_LEAVES_EACH; i++) {
        uint leaf = cluster_lane() * DISPLACED_LEAVES_EACH + i;
        if (leaf >= leaf_count) {
            break;
        }
        uint own = displaced_own_places[displaced_own_place(leaf)];
        displaced_own_places[displaced_own_place(leaf)] = at | split << 16u;
        split += own >> 20u;
        uint first = own >> 9u & 511u, end = first + (own & 511u);
        for (uint vertex = first; vertex < end; vertex++) {
            displaced_whats[displaced_what_place(at++)] = DISPLACED_LEAF << DISPLACED_WHAT_SHIFT | vertex << 16u | leaf;
        }
    }
}

// Where the vertices of a composite are, and what they are.
void displaced_lay_out(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count)
{
    displaced_clear();
    displaced_sum own = displaced_mark_leaves(unit, cluster, words, leaf_count);
    uint vertices = displaced_place_vertices();
    displaced_place_own(leaf_count, displaced_place_edges(vertices), own.before);
    cluster_barrier();
}

// -------------------------------------------------------------------------------------------------------------- points

// The part of a pattern that a vertex of it belongs to: 0 to 2 a corner, then the edges, then what is inside.
uint displaced_pattern_part(clast_pattern pattern, uint vertex)
{
    uint factors = pattern_own_factors(pattern);
    uint part = vertex < pattern_edge_begin(factors, 3u) ? WEIGHTS_EDGE + 2u : WEIGHTS_INSIDE;
    part = vertex < pattern_edge_begin(factors, 2u) ? WEIGHTS_EDGE + 1u : part;
    part = vertex < pattern_edge_begin(factors, 1u) ? WEIGHTS_EDGE : part;
    return vertex < 3u ? vertex : part;
}

// How a point is made: blended from three vertices of the cluster; or, by a face, from three points in a triangle that are
// blended from its corners; or, where it is curved, in the triangle by itself.
struct displaced_recipe
{
    uvec3 corners;            // vertices of the cluster: of a face, the triangle's corners
    bool by_face;
    uint triangle;            // by a face
    clast_weights sources[3]; // the points that it is blended from
    vec3 levels;              // at them
    uint place;               // that they are part of
    clast_weights at;         // the weights of what it is blended from
};

displaced_recipe displaced_from_vertices(uvec3 corners, clast_weights at)
{
    displaced_recipe recipe;
    recipe.corners = corners;
    recipe.by_face = false;
    recipe.at = at;
    return recipe;
}

displaced_recipe displaced_from_vertex(uint vertex)
{
    return displaced_from_vertices(uvec3(vertex, vertex, vertex), weights_of_corner(0u));
}

displaced_recipe displaced_from_leaf(displaced_leaf leaf, clast_displaced_triangle triangle, uvec3 own, uint place,
                                     clast_weights at)
{
    displaced_recipe recipe;
    recipe.corners = uvec3(displaced_corner(triangle, 0u), displaced_corner(triangle, 1u), displaced_corner(triangle, 2u));
    recipe.by_face = true;
    recipe.triangle = displaced_leaf_triangle(leaf.word);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        recipe.sources[k] = displaced_leaf_corner_weights(leaf, own[k]);
        recipe.levels[k] = displaced_leaf_corner_level(leaf, own[k]);
    }
    recipe.place = place;
    recipe.at = at;
    return recipe;
}

// The place that the points of a leaf's edge have in the base triangle.
uint displaced_place_of_edge(displaced_leaf leaf, uint own)
{
    uint next = own == 2u ? 0u : own + 1u;
    return displaced_leaf_is_split(leaf.word)
               ? displaced_place_between(displaced_leaf_corner_weights(leaf, own), displaced_leaf_corner_weights(leaf, next))
               : WEIGHTS_EDGE + own;
}

// A vertex of a leaf's pattern, by its owner.
displaced_recipe displaced_leaf_recipe(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count,
                                       uint number, uint vertex, bool curved)
{
    uint word = displaced_word_of(words, number);
    clast_pattern_use use = pattern_use(displaced_leaf_factors(word));
    clast_pattern pattern = displaced_pattern_at(unit, use.number);
    clast_weights at = weights_of(displaced_pattern_vertex(unit, pattern, vertex));
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(word));
    uvec3 turned = uvec3(use.rotation, use.rotation + 1u, use.rotation + 2u) % 3u;
    bool plain = displaced_is_plain(triangle);
    if (plain && !curved && !displaced_leaf_is_split(word)) {
        return displaced_from_vertices(uvec3(displaced_corner(triangle, turned[0]), displaced_corner(triangle, turned[1]),
                                             displaced_corner(triangle, turned[2])),
                                       at);
    }
    uint splits = leaf_count > 1u ? displaced_own_places[displaced_own_place(number)] >> 16u : 0u;
    displaced_leaf leaf = displaced_read_leaf(unit, cluster, words, leaf_count, number, splits);
    if (curved) {
        return displaced_from_leaf(leaf, triangle, uvec3(0u, 1u, 2u), 0u, pattern_unrotate(at, use.rotation));
    }
    if (plain) {
        return displaced_from_leaf(leaf, triangle, turned, WEIGHTS_INSIDE, at);
    }
    uint part = displaced_pattern_part(pattern, vertex);
    if (part >= WEIGHTS_EDGE) {
        uint place = part == WEIGHTS_INSIDE ? WEIGHTS_INSIDE
                                            : displaced_place_of_edge(leaf, (part - WEIGHTS_EDGE + use.rotation) % 3u);
        return displaced_from_leaf(leaf, triangle, turned, place, at);
    }
    uint own = (part + use.rotation) % 3u;
    uint place = weights_place(displaced_leaf_corner_weights(leaf, own));
    if (place < WEIGHTS_EDGE) {
        return displaced_from_vertex(displaced_corner(triangle, place));
    }
    return displaced_from_leaf(leaf, triangle, uvec3(own, own, own), place, weights_of_corner(0u));
}

// A point within an edge that leaves of a composite share: between its ends, or in the triangle of a leaf that has it.
displaced_recipe displaced_edge_recipe(unit_reference unit, clast_displaced_cluster cluster, uint64_t words,
                                       uint leaf_count, uint number, uint step, bool curved)
{
    uint place = displaced_edge_places[displaced_edge_place(number)];
    uint factor = place & 255u;
    uint user = place >> 8u & 255u;
    clast_weights at = weights_of(pattern_edge_weight(factor, step));
    if (user == 0u) {
        uint ends = displaced_edge_at(unit, cluster, number).ends;
        return displaced_from_vertices(uvec3(ends & 255u, ends >> 8u & 255u, ends & 255u), at);
    }
    displaced_leaf leaf = displaced_read_leaf(unit, cluster, words, leaf_count, user - 1u, 0u);
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(leaf.word));
    uint edge = displaced_edge_of(triangle, 1u) == number ? 1u : 0u;
    edge = displaced_edge_of(triangle, 2u) == number ? 2u : edge;
    uint next = edge == 2u ? 0u : edge + 1u;
    bool along = displaced_goes_along(triangle, edge);
    if (curved) {
        return displaced_from_leaf(leaf, triangle, uvec3(0u, 1u, 2u), 0u,
                                   pattern_edge_point(edge, factor, along ? step : factor - step));
    }
    uvec3 own = along ? uvec3(edge, next, edge) : uvec3(next, edge, next);
    return displaced_from_leaf(leaf, triangle, own, WEIGHTS_EDGE + edge, at);
}

displaced_recipe displaced_recipe_of(unit_reference unit, clast_displaced_cluster cluster, uint64_t words,
                                     uint leaf_count, uint what, bool curved)
{
    uint kind = what >> DISPLACED_WHAT_SHIFT;
    uint number = what & 65535u;
    uint detail = what >> 16u & 0x3fffu;
    if (kind == DISPLACED_VERTEX) {
        return displaced_from_vertex(number);
    }
    if (kind == DISPLACED_EDGE) {
        return displaced_edge_recipe(unit, cluster, words, leaf_count, number, detail, curved);
    }
    return displaced_leaf_recipe(unit, cluster, words, leaf_count, number, detail, curved);
}

// What a point is blended from.
struct displaced_source
{
    vec3 position, normal;
    vec2 coordinates;
    float level;
};

displaced_source displaced_vertex_source(uint64_t levels, clast_displaced_vertex from, uint vertex)
{
    displaced_source source;
    source.position = load3(from.position);
    source.normal = load3(from.normal);
    source.coordinates = load2(from.coordinates);
    source.level = displaced_vertex_level_of(levels, vertex);
    return source;
}

displaced_source displaced_face_source(displaced_face face, displaced_place_site site, clast_weights at, float level)
{
    displaced_source source;
    source.position = blend3(face.positions[0], face.positions[1], face.positions[2], at);
    source.normal = displaced_face_normal(face, at);
    source.coordinates = displaced_coordinates_in(face, site, at);
    source.level = level;
    return source;
}

// Curved triangles are not blended from their corners: each point is one by itself.
FN vec3 displaced_curved_leaf_point(unit_reference unit, clast_displaced_cluster cluster, displaced_face face,
                                    displaced_recipe recipe)
{
    clast_weights own = recipe.at;
    clast_weights at = weights_within(recipe.sources[0], recipe.sources[1], recipe.sources[2], own);
    float level = blend1(recipe.levels[0], recipe.levels[1], recipe.levels[2], own);
    displaced_site site = displaced_site_of(unit, cluster, face, at);
    site.coordinates = displaced_alone(site.coordinates);
    return displaced_moved(unit, site, curved_point(face.positions, face.normals, at), displaced_face_normal(face, at),
                           level);
}

FN vec3 displaced_blend_point(unit_reference unit, uint map, displaced_source a, displaced_source b, displaced_source c,
                              clast_weights at)
{
    displaced_site site;
    site.map = map;
    site.coordinates = blend2(a.coordinates, b.coordinates, c.coordinates, at);
    return displaced_moved(unit, site, blend3(a.position, b.position, c.position, at),
                           blend3(a.normal, b.normal, c.normal, at), blend1(a.level, b.level, c.level, at));
}

vec3 displaced_point_of(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count, uint what)
{
    bool curved = displaced_is_curved(unit);
    displaced_recipe recipe = displaced_recipe_of(unit, cluster, words, leaf_count, what, curved);
    clast_displaced_vertex vertices[3];
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        vertices[k] = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, recipe.corners[k]));
    }
    displaced_source sources[3];
    uint map = vertices[0].map;
    if (recipe.by_face) {
        displaced_face face = displaced_face_from(unit, cluster, recipe.triangle, vertices);
        if (curved) {
            return displaced_curved_leaf_point(unit, cluster, face, recipe);
        }
        displaced_place_site site = displaced_site_in(unit, cluster, face, recipe.place);
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            sources[k] = displaced_face_source(face, site, recipe.sources[k], recipe.levels[k]);
        }
        map = site.map;
    } else {
        uint64_t levels = displaced_levels_of(unit, words);
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            sources[k] = displaced_vertex_source(levels, vertices[k], recipe.corners[k]);
        }
    }
    return displaced_blend_point(unit, map, sources[0], sources[1], sources[2], recipe.at);
}

// -------------------------------------------------------------------------------------------------------------- duties

void source_fill(unit_reference unit, clast_cluster_record record, uint64_t words)
{
    clast_displaced_cluster cluster = displaced_cluster_of(unit, record.item);
    uint count = record_vertices(record);
    bool composite = record_form(record) == FORM_COMPOSITE;
    if (composite) {
        displaced_lay_out(unit, cluster, words, record.detail);
    }
    uint whole = (record.detail != 0u ? DISPLACED_LEAF : DISPLACED_VERTEX) << DISPLACED_WHAT_SHIFT;
    uint shift = record.detail != 0u ? 16u : 0u;
    for (uint i = cluster_lane(); i < count; i += LANES) {
        uint what = composite ? displaced_whats[displaced_what_place(i)] : whole | i << shift;
        set_cluster_point(i, displaced_point_of(unit, cluster, words, record.detail, what));
    }
    cluster_barrier();
}

// The place in the record of a vertex of a leaf's pattern.
uint displaced_place_in_record(uint word, clast_displaced_triangle triangle, clast_pattern pattern, uint rotation,
                               uint own_at, uint vertex)
{
    if (displaced_leaf_is_split(word)) {
        return own_at + vertex;
    }
    uint factors = pattern_own_factors(pattern);
    uint part = displaced_pattern_part(pattern, vertex);
    if (part == WEIGHTS_INSIDE) {
        return own_at + vertex - pattern_edge_begin(factors, 3u);
    }
    if (part < WEIGHTS_EDGE) {
        return displaced_vertex_places[displaced_vertex_place(displaced_corner(triangle, (part + rotation) % 3u))] >> 16u;
    }
    uint edge = part - WEIGHTS_EDGE;
    uint own = (edge + rotation) % 3u;
    uint step = vertex - pattern_edge_begin(factors, edge);
    uint within = pattern_factor(factors, edge) - 1u;
    uint first = displaced_edge_places[displaced_edge_place(displaced_edge_of(triangle, own))] >> 16u;
    return first + (displaced_goes_along(triangle, own) ? step : within - 1u - step);
}

// Of the composite that was filled last: how it is laid out is known still.
void source_corners(unit_reference unit, clast_cluster_record record, uint64_t words)
{
    clast_displaced_cluster cluster = displaced_cluster_of(unit, record.item);
    for (uint i = cluster_lane(); i < record_triangles(record); i += LANES) {
        uint number = displaced_find_leaf(words, record.detail, i);
        uint word = displaced_word_of(words, number);
        clast_pattern_use use = pattern_use(displaced_leaf_factors(word));
        clast_pattern pattern = displaced_pattern_at(unit, use.number);
        clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(word));
        uint corners = displaced_pattern_triangle(unit, pattern, i - displaced_leaf_first(word));
        uint placed = 0u;
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            uint place = displaced_place_in_record(word, triangle, pattern, use.rotation,
                                                   displaced_own_places[displaced_own_place(number)] & 65535u,
                                                   corners >> 8u * k & 255u);
            placed |= place << 8u * k;
        }
        set_cluster_corners(i, placed);
    }
    cluster_barrier();
}

#endif
