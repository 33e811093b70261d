// SPDX-License-Identifier: Apache-2.0
// Splitting triangles whose edges need more segments than a pattern has, by a work group: the twin of
// src/source/displaced_split.c. There, parts are split one after the other, depth first. Here, as many neighbours of a list as
// give no more than a list's room of children are split at once, into the next list; two lists take turns, and one that has
// been written over is made again when it is gone on with. So the parts come in the same order.
#ifndef CLAST_SOURCE_DISPLACED_SPLIT_GLSL
#define CLAST_SOURCE_DISPLACED_SPLIT_GLSL

#include "source/displaced_rate.glsl"

const uint DISPLACED_LIST = 128u; // room of a list: as much as one split may need, and one invocation for each part
const uint DISPLACED_PART_WORDS = 8u;

shared uint displaced_parts[2u * DISPLACED_PART_WORDS * DISPLACED_LIST];
shared uint displaced_batch[DISPLACED_LIST];     // children up to and with each part, and points above 16 bits
shared uint displaced_batch_use[DISPLACED_LIST]; // of each part that is split: number and rotation of its pattern, and 1
shared uint displaced_point_weights[DISPLACED_SITES];
shared uint displaced_point_levels[DISPLACED_SITES];

// A triangle of the cluster, or a part of one.
struct displaced_part
{
    uint corners[3]; // weights_word()
    uint levels[3];
    uint triangle;
    uint depth;      // splits above it
    uint factors[3];
};

bool displaced_is_leaf(displaced_part part)
{
    bool small = part.factors[0] <= PATTERN_SEGMENTS && part.factors[1] <= PATTERN_SEGMENTS &&
                 part.factors[2] <= PATTERN_SEGMENTS;
    return small || part.depth >= DISPLACED_SPLITS_DEEPEST;
}

// -------------------------------------------------------------------------------------------------------------- lists

// Where a word of a part lies. List 0 is the cluster's triangles themselves; the others take turns.
uint displaced_part_place(uint list, uint word, uint number)
{
    return ((list & 1u) * DISPLACED_PART_WORDS + word) * DISPLACED_LIST + number;
}

displaced_part displaced_whole_triangle(unit_reference unit, clast_displaced_cluster cluster, uint number)
{
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, number);
    displaced_part part;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        part.corners[k] = weights_word(weights_of_corner(k));
        part.levels[k] = displaced_levels[displaced_corner(triangle, k)];
        part.factors[k] = displaced_factors[displaced_edge_of(triangle, k)];
    }
    part.triangle = number;
    part.depth = 0u;
    return part;
}

displaced_part displaced_part_at(unit_reference unit, clast_displaced_cluster cluster, uint list, uint number)
{
    if (list == 0u) {
        return displaced_whole_triangle(unit, cluster, number);
    }
    displaced_part part;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        part.corners[k] = displaced_parts[displaced_part_place(list, k, number)];
        part.factors[k] = displaced_parts[displaced_part_place(list, 5u + k, number)];
    }
    uint levels = displaced_parts[displaced_part_place(list, 3u, number)];
    uint rest = displaced_parts[displaced_part_place(list, 4u, number)];
    part.levels[0] = levels & 65535u;
    part.levels[1] = levels >> 16u;
    part.levels[2] = rest & 65535u;
    part.triangle = rest >> 16u & 255u;
    part.depth = rest >> 24u;
    return part;
}

// All but the factors.
void displaced_put_part(uint list, uint number, displaced_part part)
{
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        displaced_parts[displaced_part_place(list, k, number)] = part.corners[k];
    }
    displaced_parts[displaced_part_place(list, 3u, number)] = part.levels[0] | part.levels[1] << 16u;
    displaced_parts[displaced_part_place(list, 4u, number)] = part.levels[2] | part.triangle << 16u | part.depth << 24u;
}

void displaced_put_factor(uint list, uint number, uint k, uint factor)
{
    displaced_parts[displaced_part_place(list, 5u + k, number)] = factor;
}

// The lowest of the group's invocations for which `here` is true; GROUP_SIZE where there is none.
uint displaced_lowest(bool here)
{
    uint own = subgroupMin(here ? group_lane() : GROUP_SIZE);
    barrier(); // what was read of earlier sums has been read
    if (subgroupElect()) {
        group_sums[gl_SubgroupID] = own;
    }
    barrier();
    uint lowest = GROUP_SIZE;
    for (uint i = 0u; i < gl_NumSubgroups; i++) {
        lowest = min_uint(lowest, group_sums[i]);
    }
    return lowest;
}

// Which part of the batch has the child or, 16 bits up, the point of a number.
uint displaced_part_with(uint number, uint count, uint shift)
{
    uint low = 0u;
    uint high = count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        bool before = (displaced_batch[middle] >> shift & 65535u) <= number;
        low = before ? middle + 1u : low;
        high = before ? high : middle;
    }
    return low;
}

uint displaced_batch_before(uint part, uint shift)
{
    return part == 0u ? 0u : displaced_batch[part - 1u] >> shift & 65535u;
}

// ------------------------------------------------------------------------------------------------------------- points

// What a point of a triangle comes to in the view, and the level at it.
struct displaced_look
{
    clast_rate_point point;
    uint steps;
};

FN float displaced_density(displaced_face face, clast_weights at)
{
    return blend1(face.density_squares[0], face.density_squares[1], face.density_squares[2], at);
}

FN float displaced_shortest(displaced_face face, clast_weights at)
{
    return blend1(face.shortest_squares[0], face.shortest_squares[1], face.shortest_squares[2], at);
}

FN uint displaced_point_level(displaced_face face, vec3 base, clast_weights at)
{
    return displaced_vertex_level(base, displaced_density(face, at), displaced_shortest(face, at));
}

displaced_look displaced_look_at(unit_reference unit, clast_displaced_cluster cluster, displaced_face face, clast_weights at,
                                 uint place)
{
    vec3 base = displaced_base(face, at, displaced_is_curved(unit));
    vec3 normal = displaced_face_normal(face, at);
    displaced_site site = displaced_site_within(unit, cluster, face, at, place);
    site.coordinates = displaced_alone(site.coordinates);
    displaced_look look;
    look.steps = displaced_point_level(face, base, at);
    vec3 moved = displaced_moved(unit, site, base, normal, displaced_level(look.steps));
    look.point = rate_point(displaced_view, moved, normal);
    return look;
}

clast_weights displaced_part_weights(displaced_part part, clast_weights within)
{
    return weights_within(weights_of(part.corners[0]), weights_of(part.corners[1]), weights_of(part.corners[2]), within);
}

// Whether the points of a triangle's split are sites: their edges are measured between them.
bool displaced_measures_points(displaced_face face)
{
    return face.plain && displaced_view.metric != CLAST_METRIC_FIXED;
}

// A point of the batch.
void displaced_make_point(unit_reference unit, clast_displaced_cluster cluster, uint list, uint first, uint count, uint number)
{
    uint at_part = displaced_part_with(number, count, 16u);
    uint vertex = number - displaced_batch_before(at_part, 16u);
    displaced_part part = displaced_part_at(unit, cluster, list, first + at_part);
    uint use = displaced_batch_use[at_part];
    uint rotation = use >> 9u & 3u;
    clast_pattern pattern = displaced_pattern_at(unit, use & 511u);
    clast_weights within = pattern_unrotate(weights_of(displaced_pattern_vertex(unit, pattern, vertex)), rotation);
    clast_weights at = displaced_part_weights(part, within);
    displaced_face face = displaced_face_of(unit, cluster, part.triangle);
    uint steps;
    if (displaced_measures_points(face)) {
        displaced_look look = displaced_look_at(unit, cluster, face, at, WEIGHTS_INSIDE);
        displaced_put_site(number, look.point);
        steps = look.steps;
    } else {
        steps = displaced_point_level(face, displaced_base(face, at, displaced_is_curved(unit)), at);
    }
    uint corner = (vertex + rotation) % 3u;
    uint kept = corner == 0u ? part.levels[0] : corner == 1u ? part.levels[1] : part.levels[2];
    displaced_point_weights[number] = weights_word(at);
    displaced_point_levels[number] = vertex < 3u ? kept : steps;
}

// The segments of an edge between two points of the batch, of which the first has the lower number.
uint displaced_measure(unit_reference unit, clast_displaced_cluster cluster, uint triangle, uint first, uint second)
{
    clast_weights a = weights_of(displaced_point_weights[first]);
    clast_weights b = weights_of(displaced_point_weights[second]);
    uint apart = weights_apart(a, b);
    if (displaced_view.metric == CLAST_METRIC_FIXED) {
        return edge_factor(edge_wanted_fixed(displaced_view, apart), apart);
    }
    displaced_face face = displaced_face_of(unit, cluster, triangle);
    // where owners differ, an edge is measured by what its triangle or its seam has, all along
    uint place = face.plain ? WEIGHTS_INSIDE : displaced_place_between(a, b);
    clast_rate_point from = face.plain ? displaced_get_site(first)
                                       : displaced_look_at(unit, cluster, face, a, place).point;
    clast_rate_point to = face.plain ? displaced_get_site(second)
                                     : displaced_look_at(unit, cluster, face, b, place).point;
    displaced_look middle = displaced_look_at(unit, cluster, face, weights_of_middle(a, b), place);
    return edge_factor(edge_wanted(displaced_view, from, middle.point, to), apart);
}

// ------------------------------------------------------------------------------------------------------------- splits

uint displaced_split_factors(displaced_part part)
{
    return pattern_factors(edge_splits(part.factors[0]), edge_splits(part.factors[1]), edge_splits(part.factors[2]));
}

// A child's edge: its segments.
void displaced_make_edge(unit_reference unit, clast_displaced_cluster cluster, uint list, uint first, uint count, uint side)
{
    uint child = side / 3u;
    uint k = side % 3u;
    uint at_part = displaced_part_with(child, count, 0u);
    displaced_part part = displaced_part_at(unit, cluster, list, first + at_part);
    uint use = displaced_batch_use[at_part];
    if (use == 0u) {
        displaced_put_factor(list + 1u, child, k, k == 0u ? part.factors[0] : k == 1u ? part.factors[1] : part.factors[2]);
        return;
    }
    clast_pattern pattern = displaced_pattern_at(unit, use & 511u);
    uint word = displaced_pattern_triangle(unit, pattern, child - displaced_batch_before(at_part, 0u));
    uint a = word >> 8u * k & 255u;
    uint b = word >> 8u * ((k + 1u) % 3u) & 255u;
    uint factor;
    if (a < 3u && b < 3u) { // corner a to the next one
        uint edge = (a + (use >> 9u & 3u)) % 3u;
        factor = edge == 0u ? part.factors[0] : edge == 1u ? part.factors[1] : part.factors[2];
    } else {
        uint points = displaced_batch_before(at_part, 16u);
        factor = displaced_measure(unit, cluster, part.triangle, points + min_uint(a, b), points + max_uint(a, b));
    }
    displaced_put_factor(list + 1u, child, k, factor);
}

// The rest of a child.
void displaced_make_child(unit_reference unit, clast_displaced_cluster cluster, uint list, uint first, uint count, uint child)
{
    uint at_part = displaced_part_with(child, count, 0u);
    displaced_part part = displaced_part_at(unit, cluster, list, first + at_part);
    uint use = displaced_batch_use[at_part];
    if (use != 0u) {
        clast_pattern pattern = displaced_pattern_at(unit, use & 511u);
        uint word = displaced_pattern_triangle(unit, pattern, child - displaced_batch_before(at_part, 0u));
        uint points = displaced_batch_before(at_part, 16u);
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            uint point = points + (word >> 8u * k & 255u);
            part.corners[k] = displaced_point_weights[point];
            part.levels[k] = displaced_point_levels[point];
        }
        part.depth++;
    }
    displaced_put_part(list + 1u, child, part);
}

// How many parts of a list were taken, and how many children they came to.
struct displaced_expansion
{
    uint parts, children;
};

// Writes the next list: the children of the first parts from `first` on, as many as there is room for; leaves are their own.
displaced_expansion displaced_expand(unit_reference unit, clast_displaced_cluster cluster, uint list, uint first, uint end)
{
    uint lane = group_lane();
    bool there = first + lane < end;
    uint children = there ? 1u : 0u;
    uint points = 0u;
    uint use_word = 0u;
    if (there) {
        displaced_part part = displaced_part_at(unit, cluster, list, first + lane);
        if (!displaced_is_leaf(part)) {
            clast_pattern_use use = pattern_use(displaced_split_factors(part));
            clast_pattern pattern = displaced_pattern_at(unit, use.number);
            children = pattern_triangles(pattern);
            points = pattern_vertices(pattern);
            use_word = use.number | use.rotation << 9u | 1u << 11u;
        }
    }
    uint own = children | points << 16u;
    uint sum = sum_over_group(own).before + own;
    displaced_expansion result;
    result.parts = displaced_lowest(!there || (sum & 65535u) > DISPLACED_LIST);
    displaced_batch[lane] = sum;
    displaced_batch_use[lane] = use_word;
    barrier();
    uint last = displaced_batch[result.parts - 1u];
    result.children = last & 65535u;
    for (uint i = lane; i < last >> 16u; i += GROUP_SIZE) {
        displaced_make_point(unit, cluster, list, first, result.parts, i);
    }
    barrier();
    for (uint i = lane; i < 3u * result.children; i += GROUP_SIZE) {
        displaced_make_edge(unit, cluster, list, first, result.parts, i);
    }
    for (uint i = lane; i < result.children; i += GROUP_SIZE) {
        displaced_make_child(unit, cluster, list, first, result.parts, i);
    }
    barrier();
    return result;
}

#endif
