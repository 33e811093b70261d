// SPDX-License-Identifier: Apache-2.0
// Leaves of a record, as they are read: the twin of clast_displaced_read() and what follows it (source/displaced.h).
#ifndef CLAST_SOURCE_DISPLACED_READER_GLSL
#define CLAST_SOURCE_DISPLACED_READER_GLSL

#include "source/displaced_mesh.glsl"

struct displaced_leaf
{
    uint word;              // displaced_leaf_word()
    clast_weights corners[3];
    float levels[3];
};

// Where the levels of the cluster's vertices lie, for the first word of a record; 0 where nothing is displaced.
uint64_t displaced_levels_of(unit_reference unit, uint64_t words)
{
    return displaced_is_moved(unit) ? words - 4ul * uint64_t(uints(words).at[0]) : 0ul;
}

// The level at a vertex of the cluster.
float displaced_vertex_level_of(uint64_t levels, uint vertex)
{
    return levels != 0ul ? displaced_level(uints(levels).at[vertex / 2u] >> 16u * (vertex & 1u) & 65535u) : 0.0f;
}

// How many of the leaves before one are split.
uint displaced_splits_before(uint64_t words, uint leaf)
{
    uint count = 0u;
    for (uint i = 0u; i < leaf; i++) {
        count += displaced_leaf_is_split(uints(words).at[1u + i]) ? 1u : 0u;
    }
    return count;
}

// `splits`: displaced_splits_before(), where the leaf is split.
displaced_leaf displaced_read_leaf(unit_reference unit, clast_displaced_cluster cluster, uint64_t words, uint leaf_count,
                                   uint number, uint splits)
{
    displaced_leaf leaf;
    leaf.word = uints(words).at[1u + number];
    if (displaced_leaf_is_split(leaf.word)) {
        uint first = 1u + leaf_count + DISPLACED_SPLIT_WORDS * splits;
        uint levels = uints(words).at[first + 3u];
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            leaf.corners[k] = weights_of(uints(words).at[first + k]);
        }
        leaf.levels[0] = displaced_level(levels & 65535u);
        leaf.levels[1] = displaced_level(levels >> 16u);
        leaf.levels[2] = displaced_level(uints(words).at[first + 4u]);
        return leaf;
    }
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, displaced_leaf_triangle(leaf.word));
    uint64_t levels = displaced_levels_of(unit, words);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        leaf.corners[k] = weights_of_corner(k);
        leaf.levels[k] = displaced_vertex_level_of(levels, displaced_corner(triangle, k));
    }
    return leaf;
}

// Without an index into registers.
clast_weights displaced_leaf_corner_weights(displaced_leaf leaf, uint corner)
{
    clast_weights weights;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        weights.of[k] = corner == 0u ? leaf.corners[0].of[k] : corner == 1u ? leaf.corners[1].of[k] : leaf.corners[2].of[k];
    }
    return weights;
}

float displaced_leaf_corner_level(displaced_leaf leaf, uint corner)
{
    return corner == 0u ? leaf.levels[0] : corner == 1u ? leaf.levels[1] : leaf.levels[2];
}

// Which leaf of a record has a triangle.
uint displaced_find_leaf(uint64_t words, uint leaf_count, uint triangle)
{
    uint low = 0u;
    uint high = leaf_count - 1u;
    while (low < high) {
        uint middle = (low + high + 1u) / 2u;
        bool begins = displaced_leaf_first(uints(words).at[1u + middle]) <= triangle;
        low = begins ? middle : low;
        high = begins ? high : middle - 1u;
    }
    return low;
}

#endif
