// SPDX-License-Identifier: Apache-2.0
// Filling records of displaced meshes by a work group: each vertex of a record is told what it is, then all are computed at
// once. The twin of src/source/displaced_fill.c and displaced_leaves.c, whose order of vertices it keeps.
#ifndef CLAST_SOURCE_DISPLACED_FILL_GLSL
#define CLAST_SOURCE_DISPLACED_FILL_GLSL

#include "source/displaced_reader.glsl"

#define GROUP_SIZE 128
#include "accel/group.glsl"

// What a vertex of a record is: a vertex of the cluster; a point within an edge of it; or a vertex of a leaf's pattern.
const uint DISPLACED_VERTEX = 0u;
const uint DISPLACED_EDGE = 1u; // and the step along it 16 bits up
const uint DISPLACED_LEAF = 2u; // and the vertex of the pattern 16 bits up
const uint DISPLACED_WHAT_SHIFT = 30u;
shared uint displaced_what[TEMPLATE_VERTICES];

// Of a composite's leaves that are whole triangles: vertices and edges of the cluster that they share. By vertex: 1 where it is
// there, and its place 16 bits up. By edge: its segments, 0 where it is not there; one more than the leaf whose triangle its
// points are blended in, where that matters, 8 bits up; and the place of the first point 16 bits up.
shared uint displaced_vertex_places[CLUSTER_VERTICES];
shared uint displaced_edge_places[DISPLACED_EDGES];
// By leaf: where its own vertices begin, and 16 bits up how many before it are split.
shared uint displaced_own_places[DISPLACED_RECORD_TRIANGLES];

uint displaced_word_of(uint64_t words, uint leaf) { return uints(words).at[1u + leaf]; }

// -------------------------------------------------------------------------------------------------------------- layout

void displaced_mark_shared(unit_reference unit, clast_displaced_cluster cluster, uint leaf, uint word, bool curved)
{
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(word));
    uint factors = displaced_leaf_factors(word);
    uint user = curved || !displaced_is_plain(triangle) ? leaf + 1u << 8u : 0u;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        atomicOr(displaced_vertex_places[displaced_corner(triangle, k)], 1u);
        atomicMax(displaced_edge_places[displaced_edge_of(triangle, k)], pattern_factor(factors, k) | user);
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

const uint DISPLACED_EDGES_EACH = DISPLACED_EDGES / 128u;

// Where the vertices of a composite are, and what they are.
void displaced_lay_out(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count)
{
    uint lane = group_lane();
    displaced_vertex_places[lane] = 0u;
    for (uint i = lane; i < DISPLACED_EDGES; i += GROUP_SIZE) {
        displaced_edge_places[i] = 0u;
    }
    barrier();
    uint own_begin = 0u;
    uint own = 0u;
    uint split = 0u;
    if (lane < leaf_count) {
        uint word = displaced_word_of(words, lane);
        clast_pattern pattern = displaced_pattern_at(unit, pattern_use(displaced_leaf_factors(word)).number);
        own_begin = displaced_own_begin(word, pattern);
        own = pattern_vertices(pattern) - own_begin;
        split = displaced_leaf_is_split(word) ? 1u : 0u;
        if (!displaced_leaf_is_split(word)) {
            displaced_mark_shared(unit, cluster, lane, word, displaced_is_curved(unit));
        }
    }
    barrier();
    uint vertex = displaced_vertex_places[lane];
    uint edges[DISPLACED_EDGES_EACH]; // neighbours, so that their order is that of the sums
    uint within = 0u;
    [[unroll]] for (uint i = 0u; i < DISPLACED_EDGES_EACH; i++) {
        edges[i] = displaced_edge_places[DISPLACED_EDGES_EACH * lane + i];
        within += displaced_points_within(edges[i]);
    }
    // at most 128, 253, 256 and 85: a record has no more than TEMPLATE_VERTICES in all
    group_sum sums = sum_over_group(vertex | within << 8u | own << 16u | split << 25u);
    uint vertex_at = sums.before & 255u;
    uint edge_at = (sums.all & 255u) + (sums.before >> 8u & 255u);
    uint own_at = (sums.all & 255u) + (sums.all >> 8u & 255u) + (sums.before >> 16u & 511u);
    if (vertex != 0u) {
        displaced_what[vertex_at] = DISPLACED_VERTEX << DISPLACED_WHAT_SHIFT | lane;
    }
    displaced_vertex_places[lane] = vertex | vertex_at << 16u;
    [[unroll]] for (uint i = 0u; i < DISPLACED_EDGES_EACH; i++) {
        uint number = DISPLACED_EDGES_EACH * lane + i;
        displaced_edge_places[number] = edges[i] | edge_at << 16u;
        for (uint step = 1u; step < (edges[i] & 255u); step++) {
            displaced_what[edge_at++] = DISPLACED_EDGE << DISPLACED_WHAT_SHIFT | step << 16u | number;
        }
    }
    displaced_own_places[lane] = own_at | sums.before >> 25u << 16u;
    for (uint i = 0u; i < own; i++) {
        displaced_what[own_at + i] = DISPLACED_LEAF << DISPLACED_WHAT_SHIFT | own_begin + i << 16u | lane;
    }
    barrier();
}

// -------------------------------------------------------------------------------------------------------------- points

// A corner that points are blended from.
struct displaced_source
{
    vec3 position, normal;
    vec2 coordinates;
    float level;
};

displaced_source displaced_vertex_source(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint vertex)
{
    clast_displaced_vertex from = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, vertex));
    displaced_source source;
    source.position = load3(from.position);
    source.normal = load3(from.normal);
    source.coordinates = load2(from.coordinates);
    source.level = displaced_vertex_level_of(unit, words, vertex);
    return source;
}

// A point within a triangle whose attributes are blended, as part of `place`.
displaced_source displaced_face_source(unit_reference unit, clast_displaced_cluster cluster, displaced_face face,
                                       clast_weights at, uint place, float level)
{
    displaced_source source;
    source.position = blend3(face.positions[0], face.positions[1], face.positions[2], at);
    source.normal = displaced_face_normal(face, at);
    source.coordinates = displaced_site_within(unit, cluster, face, at, place).coordinates;
    source.level = level;
    return source;
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

uint displaced_vertex_map(unit_reference unit, clast_displaced_cluster cluster, uint vertex)
{
    uint number = displaced_vertex_number(unit, cluster, vertex);
    return displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES)).at[number].map;
}

// A point between three vertices of the cluster that have one map.
vec3 displaced_plain_point(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uvec3 corners,
                              clast_weights at)
{
    displaced_source a = displaced_vertex_source(unit, cluster, words, corners[0]);
    displaced_source b = displaced_vertex_source(unit, cluster, words, corners[1]);
    displaced_source c = displaced_vertex_source(unit, cluster, words, corners[2]);
    return displaced_blend_point(unit, displaced_vertex_map(unit, cluster, corners[0]), a, b, c, at);
}

vec3 displaced_vertex_position(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint vertex)
{
    return displaced_plain_point(unit, cluster, words, uvec3(vertex, vertex, vertex), weights_of_corner(0u));
}

// Curved triangles are not blended from their corners: each point is one by itself. `own` are weights of the leaf's corners.
vec3 displaced_curved_leaf_point(unit_reference unit, clast_displaced_cluster cluster, displaced_face face,
                                    displaced_leaf leaf, clast_weights own)
{
    clast_weights at = displaced_leaf_weights(leaf, own);
    float level = blend1(leaf.levels[0], leaf.levels[1], leaf.levels[2], own);
    displaced_site site = displaced_site_of(unit, cluster, face, at);
    site.coordinates = displaced_alone(site.coordinates);
    return displaced_moved(unit, site, curved_point(face.positions, face.normals, at), displaced_face_normal(face, at),
                           level);
}

// The place that the points of a pattern's edge have in the base triangle.
uint displaced_place_of_edge(displaced_leaf leaf, uint own)
{
    uint next = own == 2u ? 0u : own + 1u;
    return displaced_leaf_is_split(leaf.word)
               ? displaced_place_between(displaced_leaf_corner_weights(leaf, own), displaced_leaf_corner_weights(leaf, next))
               : WEIGHTS_EDGE + own;
}

// A point blended from the corners of a leaf, all three as part of `place`.
vec3 displaced_leaf_blend(unit_reference unit, clast_displaced_cluster cluster, displaced_face face, displaced_leaf leaf,
                             uint rotation, uint place, clast_weights at)
{
    displaced_source sources[3];
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        uint own = (k + rotation) % 3u;
        sources[k] = displaced_face_source(unit, cluster, face, displaced_leaf_corner_weights(leaf, own), place,
                                           displaced_leaf_corner_level(leaf, own));
    }
    uint map = displaced_site_within(unit, cluster, face, displaced_leaf_corner_weights(leaf, rotation), place).map;
    return displaced_blend_point(unit, map, sources[0], sources[1], sources[2], at);
}

// The part of a pattern that a vertex of it belongs to: 0 to 2 a corner, then the edges, then what is inside.
uint displaced_pattern_part(clast_pattern pattern, uint vertex)
{
    uint factors = pattern_own_factors(pattern);
    return vertex < 3u                                  ? vertex
           : vertex < pattern_edge_begin(factors, 1u) ? WEIGHTS_EDGE
           : vertex < pattern_edge_begin(factors, 2u) ? WEIGHTS_EDGE + 1u
           : vertex < pattern_edge_begin(factors, 3u) ? WEIGHTS_EDGE + 2u
                                                      : WEIGHTS_INSIDE;
}

// A corner of a leaf, by its owner.
vec3 displaced_leaf_corner_point(unit_reference unit, clast_displaced_cluster cluster, uint64_t words,
                                    displaced_face face, displaced_leaf leaf, uint own)
{
    clast_weights at = displaced_leaf_corner_weights(leaf, own);
    uint place = weights_place(at);
    if (place < WEIGHTS_EDGE) {
        return displaced_vertex_position(unit, cluster, words, displaced_corner(face.triangle, place));
    }
    displaced_source source = displaced_face_source(unit, cluster, face, at, place, displaced_leaf_corner_level(leaf, own));
    uint map = displaced_site_within(unit, cluster, face, at, place).map;
    return displaced_blend_point(unit, map, source, source, source, weights_of_corner(0u));
}

// A vertex of a leaf's pattern, by its owner.
vec3 displaced_leaf_point(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count,
                             uint number, uint vertex)
{
    uint splits = leaf_count > 1u ? displaced_own_places[number] >> 16u : 0u;
    displaced_leaf leaf = displaced_read_leaf(unit, cluster, words, leaf_count, number, splits);
    clast_pattern_use use = pattern_use(displaced_leaf_factors(leaf.word));
    clast_pattern pattern = displaced_pattern_at(unit, use.number);
    clast_weights at = weights_of(displaced_pattern_vertex(unit, pattern, vertex));
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(leaf.word));
    bool plain = displaced_is_plain(triangle);
    bool curved = displaced_is_curved(unit);
    if (plain && !curved && !displaced_leaf_is_split(leaf.word)) {
        uvec3 corners = uvec3(displaced_corner(triangle, use.rotation), displaced_corner(triangle, (use.rotation + 1u) % 3u),
                              displaced_corner(triangle, (use.rotation + 2u) % 3u));
        return displaced_plain_point(unit, cluster, words, corners, at);
    }
    displaced_face face = displaced_face_of(unit, cluster, displaced_leaf_triangle(leaf.word));
    if (curved) {
        return displaced_curved_leaf_point(unit, cluster, face, leaf, pattern_unrotate(at, use.rotation));
    }
    uint part = displaced_pattern_part(pattern, vertex);
    if (plain || part == WEIGHTS_INSIDE) {
        return displaced_leaf_blend(unit, cluster, face, leaf, use.rotation, WEIGHTS_INSIDE, at);
    }
    if (part < WEIGHTS_EDGE) {
        return displaced_leaf_corner_point(unit, cluster, words, face, leaf, (part + use.rotation) % 3u);
    }
    uint place = displaced_place_of_edge(leaf, (part - WEIGHTS_EDGE + use.rotation) % 3u);
    return displaced_leaf_blend(unit, cluster, face, leaf, use.rotation, place, at);
}

// A point within an edge that leaves of a composite share: between its ends, or in the triangle of a leaf that has it.
vec3 displaced_edge_point(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count,
                             uint number, uint step)
{
    uint place = displaced_edge_places[number];
    uint factor = place & 255u;
    uint user = place >> 8u & 255u;
    if (user == 0u) {
        uint ends = displaced_edge_at(unit, cluster, number).ends;
        uint first = ends & 255u;
        return displaced_plain_point(unit, cluster, words, uvec3(first, ends >> 8u & 255u, first),
                                     weights_of(pattern_edge_weight(factor, step)));
    }
    displaced_leaf leaf = displaced_read_leaf(unit, cluster, words, leaf_count, user - 1u, 0u);
    displaced_face face = displaced_face_of(unit, cluster, displaced_leaf_triangle(leaf.word));
    uint edge = displaced_edge_of(face.triangle, 2u) == number   ? 2u
                : displaced_edge_of(face.triangle, 1u) == number ? 1u
                                                                 : 0u;
    bool along = displaced_goes_along(face.triangle, edge);
    if (displaced_is_curved(unit)) {
        return displaced_curved_leaf_point(unit, cluster, face, leaf,
                                           pattern_edge_point(edge, factor, along ? step : factor - step));
    }
    uint next = edge == 2u ? 0u : edge + 1u;
    uint first = along ? edge : next;
    uint second = along ? next : edge;
    displaced_source a = displaced_face_source(unit, cluster, face, weights_of_corner(first), WEIGHTS_EDGE + edge,
                                               displaced_leaf_corner_level(leaf, first));
    displaced_source b = displaced_face_source(unit, cluster, face, weights_of_corner(second), WEIGHTS_EDGE + edge,
                                               displaced_leaf_corner_level(leaf, second));
    uint map = displaced_site_within(unit, cluster, face, weights_of_corner(first), WEIGHTS_EDGE + edge).map;
    return displaced_blend_point(unit, map, a, b, a, weights_of(pattern_edge_weight(factor, step)));
}

vec3 displaced_point_of(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count, uint what)
{
    uint kind = what >> DISPLACED_WHAT_SHIFT;
    uint number = what & 65535u;
    uint detail = what >> 16u & 0x3fffu;
    if (kind == DISPLACED_VERTEX) {
        return displaced_vertex_position(unit, cluster, words, number);
    }
    return kind == DISPLACED_EDGE ? displaced_edge_point(unit, cluster, words, leaf_count, number, detail)
                                  : displaced_leaf_point(unit, cluster, words, leaf_count, number, detail);
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
    for (uint i = group_lane(); i < count; i += GROUP_SIZE) {
        uint what = composite ? displaced_what[i] : whole | i << shift;
        cluster_points[i] = displaced_point_of(unit, cluster, words, record.detail, what);
    }
    barrier();
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
        return displaced_vertex_places[displaced_corner(triangle, (part + rotation) % 3u)] >> 16u;
    }
    uint edge = part - WEIGHTS_EDGE;
    uint own = (edge + rotation) % 3u;
    uint step = vertex - pattern_edge_begin(factors, edge);
    uint within = pattern_factor(factors, edge) - 1u;
    uint first = displaced_edge_places[displaced_edge_of(triangle, own)] >> 16u;
    return first + (displaced_goes_along(triangle, own) ? step : within - 1u - step);
}

// Of the composite that was filled last: how it is laid out is known still.
void source_corners(unit_reference unit, clast_cluster_record record, uint64_t words)
{
    clast_displaced_cluster cluster = displaced_cluster_of(unit, record.item);
    for (uint i = group_lane(); i < record_triangles(record); i += GROUP_SIZE) {
        uint number = displaced_find_leaf(words, record.detail, i);
        uint word = displaced_word_of(words, number);
        clast_pattern_use use = pattern_use(displaced_leaf_factors(word));
        clast_pattern pattern = displaced_pattern_at(unit, use.number);
        clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(word));
        uint corners = displaced_pattern_triangle(unit, pattern, i - displaced_leaf_first(word));
        uint placed = 0u;
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            uint place = displaced_place_in_record(word, triangle, pattern, use.rotation,
                                                   displaced_own_places[number] & 65535u,
                                                   corners >> 8u * k & 255u);
            placed |= place << 8u * k;
        }
        cluster_corners[i] = placed;
    }
    barrier();
}

#endif
