// SPDX-License-Identifier: Apache-2.0
// Patterns: how a triangle is cut for each count of segments of its edges, 1 to 11 each. The patterns themselves are arrays
// (geometry/pattern.h); here is which of them a triangle takes, and what follows from an edge's count alone, so that both
// triangles of an edge put the same points on it.
//
// Edge k goes from corner k to corner k + 1. A point is three weights of the corners that add up to WEIGHT_ONE. The vertices
// of a pattern are its 3 corners, the points within edge 0, edge 1 and edge 2, each along its edge, then those inside.
//
// A pattern begins at the corner from which its counts are largest, compared as (count 0, count 1, count 2): 451 patterns
// for 1331 triples. Where the counts then grow instead (x > z > y), the pattern is the mirror image of (x, z, y): corners 0
// and 1 exchanged, triangles the other way round; it has vertices and triangles of its own, so that nobody mirrors later.
#ifndef CLAST_SHARED_PATTERN_H
#define CLAST_SHARED_PATTERN_H

#include "shared/dialect.h"

LIMIT(PATTERN_SEGMENTS, 11u, "most segments of a pattern's edge")
LIMIT(PATTERN_ORDERED, 286u, "patterns of counts x >= y >= z: the first ones")
LIMIT(PATTERN_COUNT, 451u, "patterns with the mirror images of those whose three counts differ")
LIMIT(PATTERN_TRIANGLES, 128u, "most triangles of a pattern")
LIMIT(PATTERN_VERTICES, 128u, "most vertices of a pattern")
LIMIT(WEIGHT_ONE, 32768u, "what the weights of a point add up to")

RECORD(clast_pattern)
{
    uint first_vertex;   // weights of corners 1 and 2: w1 | w2 << 16
    uint first_triangle; // three vertices, counter-clockwise: a | b << 8 | c << 16
    uint counts;         // pattern_counts()
};
RECORD_SIZE(clast_pattern, 12)

FN uint pattern_counts(uint factors, uint triangles, uint vertices) { return factors | triangles << 12u | vertices << 20u; }
FN uint pattern_own_factors(clast_pattern pattern) { return pattern.counts & 4095u; }
FN uint pattern_triangles(clast_pattern pattern) { return pattern.counts >> 12u & 255u; }
FN uint pattern_vertices(clast_pattern pattern) { return pattern.counts >> 20u; }

// ----------------------------------------------------------------------------------------------------------- weights

RECORD(clast_weights)
{
    uint of[3]; // the corners
};
RECORD_SIZE(clast_weights, 12)

FN uint weights_word(clast_weights weights) { return weights.of[1] | weights.of[2] << 16u; }
FN clast_weights weights_of(uint word)
{
    clast_weights weights;
    weights.of[1] = word & 65535u;
    weights.of[2] = word >> 16u;
    weights.of[0] = WEIGHT_ONE - weights.of[1] - weights.of[2];
    return weights;
}

// ----------------------------------------------------------------------------------------------------------- factors

// The counts of a triangle's edges, 4 bits each.
FN uint pattern_factors(uint first, uint second, uint third) { return first | second << 4u | third << 8u; }
FN uint pattern_factor(uint factors, uint edge) { return factors >> (edge * 4u) & 15u; }

// As seen from corner `rotation`, 0 to 2.
FN uint pattern_rotate(uint factors, uint rotation)
{
    return (factors >> (rotation * 4u) | factors << (12u - rotation * 4u)) & 4095u;
}

FN uint pattern_rank(uint factors)
{
    return pattern_factor(factors, 0u) << 8u | pattern_factor(factors, 1u) << 4u | pattern_factor(factors, 2u);
}

// Ordered triples by their counts; then, of those whose counts differ, the mirror images in the same order. Factors that
// begin at the pattern's corner.
FN uint pattern_number(uint factors)
{
    uint x = pattern_factor(factors, 0u);
    uint y = max_uint(pattern_factor(factors, 1u), pattern_factor(factors, 2u));
    uint z = min_uint(pattern_factor(factors, 1u), pattern_factor(factors, 2u));
    uint ordered = (x + 1u) * x * (x - 1u) / 6u + y * (y - 1u) / 2u + z - 1u;
    uint mirrored = (x - 1u) * (x - 2u) * (x - 3u) / 6u + (y - 1u) * (y - 2u) / 2u + z - 1u;
    bool grows = pattern_factor(factors, 2u) > pattern_factor(factors, 1u);
    return grows ? PATTERN_ORDERED + mirrored : ordered;
}

// The pattern of a triangle: its corner k is the triangle's corner (k + rotation) % 3, its edge k likewise.
RECORD(clast_pattern_use)
{
    uint number;
    uint rotation;
};
RECORD_SIZE(clast_pattern_use, 8)

FN clast_pattern_use pattern_use(uint factors)
{
    uint here = pattern_rank(factors);
    uint next = pattern_rank(pattern_rotate(factors, 1u));
    uint last = pattern_rank(pattern_rotate(factors, 2u));
    clast_pattern_use use;
    use.rotation = last > here && last > next ? 2u : next > here ? 1u : 0u;
    use.number = pattern_number(pattern_rotate(factors, use.rotation));
    return use;
}

// A pattern's point as weights of the triangle's corners.
FN clast_weights pattern_unrotate(clast_weights weights, uint rotation)
{
    clast_weights turned;
    turned.of[0] = rotation == 0u ? weights.of[0] : rotation == 1u ? weights.of[2] : weights.of[1];
    turned.of[1] = rotation == 0u ? weights.of[1] : rotation == 1u ? weights.of[0] : weights.of[2];
    turned.of[2] = rotation == 0u ? weights.of[2] : rotation == 1u ? weights.of[1] : weights.of[0];
    return turned;
}

// ------------------------------------------------------------------------------------------------------------- edges

// The weight of an edge's second corner at the end of segment `step`, 0 to `segments`. The weight at `segments - step` is
// the rest to WEIGHT_ONE, so that it does not matter from which end an edge is seen.
FN uint pattern_edge_weight(uint segments, uint step) { return (step * (2u * WEIGHT_ONE) + segments) / (2u * segments); }

FN clast_weights pattern_edge_point(uint edge, uint segments, uint step)
{
    uint second = pattern_edge_weight(segments, step);
    clast_weights weights;
    weights.of[0] = edge == 0u ? WEIGHT_ONE - second : edge == 2u ? second : 0u;
    weights.of[1] = edge == 1u ? WEIGHT_ONE - second : edge == 0u ? second : 0u;
    weights.of[2] = edge == 2u ? WEIGHT_ONE - second : edge == 1u ? second : 0u;
    return weights;
}

// Where the points within an edge begin among the vertices; for edge 3, those inside.
FN uint pattern_edge_begin(uint factors, uint edge)
{
    uint begin = 3u;
    begin += edge > 0u ? pattern_factor(factors, 0u) - 1u : 0u;
    begin += edge > 1u ? pattern_factor(factors, 1u) - 1u : 0u;
    begin += edge > 2u ? pattern_factor(factors, 2u) - 1u : 0u;
    return begin;
}

// Vertices and triangles are bound to each other by Euler's formula: all a pattern may choose are its points inside.
FN uint pattern_triangles_of(uint factors, uint inside)
{
    uint around = pattern_edge_begin(factors, 3u);
    return around - 2u + 2u * inside;
}

#endif
