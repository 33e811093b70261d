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

// `measured`: how it is seen matters, not the level alone.
displaced_look displaced_look_at(unit_reference unit, clast_displaced_cluster cluster, displaced_face face, clast_weights at,
                                 uint place, bool measured)
{
    vec3 base = displaced_base(face, at, displaced_is_curved(unit));
    displaced_look look;
    look.steps = displaced_point_level(face, base, at);
    if (measured) {
        vec3 normal = displaced_face_normal(face, at);
        displaced_site site = displaced_site_within(unit, cluster, face, at, place);
        site.coordinates = displaced_alone(site.coordinates);
        vec3 moved = displaced_moved(unit, site, base, normal, displaced_level(look.steps));
        look.point = rate_point(displaced_view, moved, normal);
    }
    return look;
}

clast_weights displaced_part_weights(displaced_part part, clast_weights within)
{
    return weights_within(weights_of(part.corners[0]), weights_of(part.corners[1]), weights_of(part.corners[2]), within);
}

// ------------------------------------------------------------------------------------------------------------- splits

uint displaced_split_factors(displaced_part part)
{
    return pattern_factors(edge_splits(part.factors[0]), edge_splits(part.factors[1]), edge_splits(part.factors[2]));
}

// Something of a batch that has to be looked at.
struct displaced_task
{
    bool is_edge;
    uint to;             // number of the point, or 3 * child + edge
    uint triangle;
    clast_weights at;    // of the point, or of the middle of the edge
    uint first, second;  // points that are the edge's ends
    uint kept;           // of a point: the level, where it is a corner of its part; else CLAST_NONE
    displaced_part part; // of an edge: what it is within, and its ends as points of the pattern, weights_word()
    uint within_first, within_second;
};

FN vec3 displaced_flat_position(displaced_face face, uint word)
{
    return blend3(face.positions[0], face.positions[1], face.positions[2], weights_of(word));
}

FN uint displaced_task_most(displaced_task task, displaced_face face)
{
    vec3 corners[3];
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        corners[k] = displaced_flat_position(face, task.part.corners[k]);
    }
    return displaced_split_most(corners, task.part.factors, weights_of(task.within_first), weights_of(task.within_second),
                                displaced_flat_position(face, displaced_point_weights[task.first]),
                                displaced_flat_position(face, displaced_point_weights[task.second]));
}

displaced_task displaced_point_task(unit_reference unit, displaced_part part, uint use, uint vertex, uint number)
{
    displaced_task task;
    task.is_edge = false;
    task.to = number;
    task.triangle = part.triangle;
    uint rotation = use >> 9u & 3u;
    clast_pattern pattern = displaced_pattern_at(unit, use & 511u);
    clast_weights within = pattern_unrotate(weights_of(displaced_pattern_vertex(unit, pattern, vertex)), rotation);
    task.at = displaced_part_weights(part, within);
    uint corner = (vertex + rotation) % 3u;
    uint level = corner == 0u ? part.levels[0] : corner == 1u ? part.levels[1] : part.levels[2];
    task.kept = vertex < 3u ? level : CLAST_NONE;
    task.first = 0u;
    task.second = 0u;
    return task;
}

uint displaced_part_factor(displaced_part part, uint edge)
{
    return edge == 0u ? part.factors[0] : edge == 1u ? part.factors[1] : part.factors[2];
}

// Looks at what a task names, and keeps what it comes to: a point's level and what it is like in the view, or an edge's
// segments.
void displaced_run_task(unit_reference unit, clast_displaced_cluster cluster, uint list, displaced_task task)
{
    displaced_face face = displaced_face_of(unit, cluster, task.triangle);
    bool fixed_count = displaced_view.metric == CLAST_METRIC_FIXED;
    uint place = WEIGHTS_INSIDE;
    clast_weights a = task.at;
    clast_weights b = task.at;
    clast_rate_point from;
    clast_rate_point to;
    uint look_number = 2u;
    if (task.is_edge) {
        a = weights_of(displaced_point_weights[task.first]);
        b = weights_of(displaced_point_weights[task.second]);
        if (face.plain) { // the ends are known already
            from = displaced_get_site(task.first);
            to = displaced_get_site(task.second);
        } else { // where owners differ, an edge is measured by what its triangle or its seam has, all along
            place = displaced_place_between(a, b);
            look_number = 0u;
        }
    }
    displaced_look look;
    [[dont_unroll]] for (; look_number < 3u; look_number++) {
        clast_weights at = task.at;
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            at.of[k] = look_number == 0u ? a.of[k] : look_number == 1u ? b.of[k] : at.of[k];
        }
        bool measured = task.is_edge || (face.plain && !fixed_count);
        look = displaced_look_at(unit, cluster, face, at, place, measured);
        if (look_number == 0u) {
            from = look.point;
        } else if (look_number == 1u) {
            to = look.point;
        }
    }
    if (task.is_edge) {
        float open = displaced_edge_open(displaced_view, from, look.point, to);
        uint factor = edge_factor(edge_wanted(displaced_view, from, look.point, to, open), weights_apart(a, b));
        displaced_put_factor(list + 1u, task.to / 3u, task.to % 3u, min_uint(factor, displaced_task_most(task, face)));
        return;
    }
    if (face.plain && !fixed_count) {
        displaced_put_site(task.to, look.point);
    }
    displaced_point_weights[task.to] = weights_word(task.at);
    displaced_point_levels[task.to] = task.kept != CLAST_NONE ? task.kept : look.steps;
}

// What is known of a child's edge without a look: 0, or its segments.
uint displaced_known_factor(displaced_part part, uint use, uint a, uint b, uint k, uint first, uint second)
{
    if (use == 0u) {
        return displaced_part_factor(part, k);
    }
    if (a < 3u && b < 3u) { // corner a to the next one
        return displaced_part_factor(part, (a + (use >> 9u & 3u)) % 3u);
    }
    if (displaced_view.metric != CLAST_METRIC_FIXED) {
        return 0u;
    }
    uint apart = weights_apart(weights_of(displaced_point_weights[first]), weights_of(displaced_point_weights[second]));
    return edge_factor(edge_wanted_fixed(displaced_view, apart), apart);
}

// A point of the batch or, of the second phase, the edge of a child.
void displaced_make_point_or_edge(unit_reference unit, clast_displaced_cluster cluster, uint list, uint first, uint count,
                                  bool edges, uint number)
{
    uint shift = edges ? 0u : 16u;
    uint child = edges ? number / 3u : number;
    uint at_part = displaced_part_with(child, count, shift);
    displaced_part part = displaced_part_at(unit, cluster, list, first + at_part);
    uint use = displaced_batch_use[at_part];
    uint within = child - displaced_batch_before(at_part, shift);
    displaced_task task;
    if (edges) {
        uint k = number % 3u;
        uint word = use == 0u ? 0u : displaced_pattern_triangle(unit, displaced_pattern_at(unit, use & 511u), within);
        uint a = word >> 8u * k & 255u;
        uint b = word >> 8u * ((k + 1u) % 3u) & 255u;
        uint points = displaced_batch_before(at_part, 16u);
        task.is_edge = true;
        task.to = number;
        task.triangle = part.triangle;
        task.first = points + min_uint(a, b);
        task.second = points + max_uint(a, b);
        task.kept = CLAST_NONE;
        task.part = part;
        uint known = displaced_known_factor(part, use, a, b, k, task.first, task.second);
        if (known != 0u) {
            displaced_put_factor(list + 1u, child, k, known);
            return;
        }
        task.at = weights_of_middle(weights_of(displaced_point_weights[task.first]),
                                    weights_of(displaced_point_weights[task.second]));
        clast_pattern pattern = displaced_pattern_at(unit, use & 511u);
        task.within_first = displaced_pattern_vertex(unit, pattern, min_uint(a, b));
        task.within_second = displaced_pattern_vertex(unit, pattern, max_uint(a, b));
    } else {
        task = displaced_point_task(unit, part, use, within, number);
    }
    displaced_run_task(unit, cluster, list, task);
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
    [[dont_unroll]] for (uint phase = 0u; phase < 2u; phase++) {
        uint tasks = phase == 0u ? last >> 16u : 3u * result.children;
        for (uint i = lane; i < tasks; i += GROUP_SIZE) {
            displaced_make_point_or_edge(unit, cluster, list, first, result.parts, phase == 1u, i);
        }
        barrier();
    }
    for (uint i = lane; i < result.children; i += GROUP_SIZE) {
        displaced_make_child(unit, cluster, list, first, result.parts, i);
    }
    barrier();
    return result;
}

#endif
