// SPDX-License-Identifier: Apache-2.0
// Clusters, trees and instances as they lie in a device's memory, for rays: what fits clusters, builds trees and traverses
// them shares. The processor's own are in accel/structures.h.
//
// From the top: a tree over placements (clast_device_scene), for each of these a tree over the clusters of a unit
// (clast_tree_node), and in each cluster a tree of one or two levels over pairs of triangles (clast_cluster_head). All boxes
// are in 8 bits a side, quantised as shared/box.h does and proves: a base, which is the exact lower corner of what is
// inside, and biased exponents of the steps. In trees, each node has its own base; in a cluster, all boxes have one. Quantising
// keeps order, so the box of some boxes has the least of their lower steps and the largest of their upper ones.
//
// A box without a sound triangle (shared/box.h: corners of at most BOX_COORDINATE_MOST) is inside out: lower steps 255, upper
// ones 0. Rays from far away may meet such a box all the same: what it stands for must be there, and hold nothing to hit.
#ifndef CLAST_SHARED_CLUSTER_H
#define CLAST_SHARED_CLUSTER_H

#include "shared/box.h"
#include "shared/limits.h"
#include "shared/records.h"

LIMIT(TREE_CHILDREN, 8u, "boxes of a node")
LIMIT(CHILD_ITEM, 0x80000000u, "of a child: what follows is an item; without it, a node")
LIMIT(SIDES_NONE_LOWER, 0xffffffffu, "lower sides of four boxes inside out")
LIMIT(SIDES_NONE_UPPER, 0u, "upper sides of four boxes inside out")

// ------------------------------------------------------------------------------------------------------------- trees

// A node of a tree. The root is the first of its tree's. Children's sides are bytes, that of child 0 the lowest: for each axis
// 4 axis + 0 and 1 are the lower sides, + 2 and 3 the upper ones.
//
// Children stand in an order that lets rays meet near ones first: bit j of a child's place tells to which side it lies
// along the axis order_axis(order, j). A ray looks at places 0 ^ m, 1 ^ m, ..., with bit j of m the sign of its direction along
// that axis. Any order is right; a good one is faster.
//
// Places without a child come last, have boxes inside out, and repeat child 0.
RECORD(clast_tree_node)
{
    packed3 lower;
    uint exponents; // of x, y and z, 8 bits each; the order in the highest 8
    uint sides[12];
    uint children[8]; // numbers of nodes, or CHILD_ITEM with what stands for an item
};
RECORD_SIZE(clast_tree_node, 96)

FN uint box_exponents(vec3 extent)
{
    return box_exponent(extent[0]) | box_exponent(extent[1]) << 8u | box_exponent(extent[2]) << 16u;
}
FN uint exponent_of_axis(uint exponents, uint axis) { return exponents >> (axis * 8u) & 255u; }

// The order of a tree's node: three axes, 0 to 2; that of bit 0 of the place first.
FN uint tree_order(uint axis_0, uint axis_1, uint axis_2) { return axis_0 | axis_1 << 2u | axis_2 << 4u; }
FN uint order_axis(uint order, uint bit) { return order >> (2u * bit) & 3u; }

// The steps of a box's sides along an axis, in a node with that base and exponent. The box lies in the node's.
FN uint side_down(float lower, float base, uint exponent) { return to_uint(box_quantise_down(lower, base, exponent)); }
FN uint side_up(float upper, float base, uint exponent) { return to_uint(box_quantise_up(upper, base, exponent)); }

// Whether a coordinate is a number that boxes can hold; by its bits, as devices need not know what is not a number.
FN uint size_bits(float x) { return floatBitsToUint(x) & 0x7fffffffu; }
FN uint size_bits3(vec3 v) { return max_uint(max_uint(size_bits(v[0]), size_bits(v[1])), size_bits(v[2])); }
FN bool are_sound_bits(uint size) { return size <= floatBitsToUint(BOX_COORDINATE_MOST); }
FN bool is_sound1(float x) { return are_sound_bits(size_bits(x)); }
FN bool is_sound3(vec3 v) { return are_sound_bits(size_bits3(v)); }

// ---------------------------------------------------------------------------------------------------------- clusters

LIMIT(CLUSTER_UNIT, 32u, "bytes; clusters begin at multiples of it")
LIMIT(CLUSTER_NODES, 9u, "most nodes of a cluster: a root and eight below it")
LIMIT(CLUSTER_NODE_BYTES, 48u, "of a node of a cluster: sides[12] as a tree's node has them")
LIMIT(CLUSTER_HEAD_BYTES, 64u, "where a cluster's nodes begin")
LIMIT(PAIR_BYTES, 8u, "of a pair of triangles")
LIMIT(CLUSTERS_TOGETHER, 4u, "most clusters that a work group fits, each by a subgroup of its own")

// Two triangles: what a leaf of a cluster holds. `first` is the corners of one triangle, in their order, 8 bits each, then its
// number. `second` is the same of another. Where two triangles share an edge, `second` tells less: its first two
// bytes are equal, which they are in no triangle worth hitting. Then the third byte is the corner d that the first triangle
// has not, the fourth is the second triangle's number, and the first byte tells how the triangles turn (pair_turns): with the
// fan (a, b, c), (a, c, d), corner k of the first triangle is number (k + turn) % 3 of (a, b, c); of the second, of (a, c, d). `first`
// then holds a, b and c. The first byte is PAIR_LONE where there is no second triangle, and d repeats c then.
RECORD(clast_pair)
{
    uint first;
    uint second;
};
RECORD_SIZE(clast_pair, 8)

LIMIT(PAIR_LONE, 16u, "as a pair's turns: there is no second triangle")

FN bool pair_is_fan(clast_pair pair) { return (pair.second & 255u) == (pair.second >> 8u & 255u); }
FN bool pair_is_lone(clast_pair pair) { return pair_is_fan(pair) && (pair.second & PAIR_LONE) != 0u; }
FN uint pair_corner(uint word, uint corner) { return word >> (corner * 8u) & 255u; }
FN uint pair_turns(uint first, uint second) { return first | second << 2u; }
FN uint pair_first_turn(clast_pair pair) { return pair.second & 3u; }
FN uint pair_second_turn(clast_pair pair) { return pair.second >> 2u & 3u; }
FN clast_pair make_fan(uint a, uint b, uint c, uint d, uint first, uint second, uint turns)
{
    clast_pair pair;
    pair.first = a | b << 8u | c << 16u | first << 24u;
    pair.second = turns | turns << 8u | d << 16u | second << 24u;
    return pair;
}

// Three corners and a number, as `first` has them.
FN uint triangle_word(uint a, uint b, uint c, uint number) { return a | b << 8u | c << 16u | number << 24u; }

// A pair of the first triangle alone.
FN clast_pair lone_pair(uint first)
{
    uint c = pair_corner(first, 2u);
    return make_fan(pair_corner(first, 0u), pair_corner(first, 1u), c, c, first >> 24u, first >> 24u, PAIR_LONE);
}

// The pair of two triangles, by their words. It is a fan where an edge of one, the other way round, is one of the other.
FN clast_pair pair_of(uint first, uint second)
{
    clast_pair pair;
    pair.first = first;
    pair.second = second;
    for (uint k = 0u; k < 3u; k++) {
        uint c = pair_corner(first, k);
        uint a = pair_corner(first, (k + 1u) % 3u);
        for (uint m = 0u; m < 3u; m++) {
            if (pair_corner(second, m) == a && pair_corner(second, (m + 1u) % 3u) == c) {
                return make_fan(a, pair_corner(first, (k + 2u) % 3u), c, pair_corner(second, (m + 2u) % 3u), first >> 24u,
                                second >> 24u, pair_turns((2u - k) % 3u, (3u - m) % 3u));
            }
        }
    }
    // What looks like a fan, and is none, has two corners that are one: it can never be hit.
    return pair_is_fan(pair) ? lone_pair(first) : pair;
}

// A topology: pairs in the order of the leaves, and how many a leaf has. A cluster's own counts are the same word.
RECORD(clast_device_template)
{
    packed_address pairs;
    packed_address corners; // of each triangle, by its number: three vertices, 8 bits each
    uint counts; // cluster_counts()
    uint vertices;
};
RECORD_SIZE(clast_device_template, 24)

// Of 1 to 128 pairs, in leaves of 2^shift: at most 64 leaves. With CLUSTER_UNSOUND, there may be triangles that are not sound.
LIMIT(CLUSTER_UNSOUND, 1024u, "a bit of a cluster's counts")
FN uint cluster_counts(uint pairs, uint shift) { return pairs | shift << 8u; }
FN uint cluster_pairs(uint counts) { return counts & 255u; }
FN uint cluster_shift(uint counts) { return counts >> 8u & 3u; }
FN uint cluster_leaves(uint counts)
{
    return (cluster_pairs(counts) + (1u << cluster_shift(counts)) - 1u) >> cluster_shift(counts);
}
// Up to eight leaves are in one node; more are in nodes of eight below a root, which come in its order after it.
FN uint cluster_nodes(uint counts)
{
    uint leaves = cluster_leaves(counts);
    return leaves <= TREE_CHILDREN ? 1u : 1u + (leaves + TREE_CHILDREN - 1u) / TREE_CHILDREN;
}
// What any topology of so many triangles has: all are in pairs but one.
FN uint triangles_counts(uint triangles)
{
    return cluster_counts((triangles + 1u) / 2u, triangles > CLUSTER_TRIANGLES ? 1u : 0u);
}
// The memory that a cluster takes, in CLUSTER_UNITs; `own_pairs` where its pairs lie behind its nodes and are no template's.
FN uint cluster_space(uint counts, bool own_pairs)
{
    uint bytes = CLUSTER_HEAD_BYTES + CLUSTER_NODE_BYTES * cluster_nodes(counts) +
                 (own_pairs ? PAIR_BYTES * cluster_pairs(counts) : 0u);
    return (bytes + CLUSTER_UNIT - 1u) / CLUSTER_UNIT;
}
FN uint cluster_pairs_offset(uint counts) { return CLUSTER_HEAD_BYTES + CLUSTER_NODE_BYTES * cluster_nodes(counts); }

// A cluster whose vertices lie in memory (vulkan/fit.h).
RECORD(clast_device_cluster)
{
    uint template_number;
    uint first_vertex; // among all
    uint place;        // where it begins, in CLUSTER_UNITs
};
RECORD_SIZE(clast_device_cluster, 12)

// Where a cluster begins; its nodes follow. A tree over clusters has as items where these begin, in CLUSTER_UNITs from the
// unit's clusters on.
//
// Leaf i is child i % 8 of node 1 + i / 8, or of the root where it is alone; it has pairs (i << shift) and the next ones, up to
// the last pair. An order has 9 bits: order_sides(). Bit j of a child's place divides along an axis as in a tree's node, but
// the upper half may come first.
RECORD(clast_cluster_head)
{
    packed3 lower; // base of all boxes
    uint exponents; // of their steps: x, y and z
    packed_address vertices; // packed3
    packed_address pairs;
    uint cluster; // its number in the unit, as hits tell it
    uint counts;  // cluster_counts(), perhaps with CLUSTER_UNSOUND
    uint orders[5]; // of nodes, 16 bits each
    uint unused;
};
RECORD_SIZE(clast_cluster_head, 64)

// Three sides, of bits 0 to 2 of a place: an axis, plus 3 where the upper half comes first.
FN uint order_sides(uint side_0, uint side_1, uint side_2) { return side_0 | side_1 << 3u | side_2 << 6u; }
FN uint order_side(uint order, uint bit) { return order >> (3u * bit) & 7u; }

// The side towards which a sum of differences between the halves points.
FN uint side_of(vec3 difference)
{
    float x = abs1(difference[0]);
    float y = abs1(difference[1]);
    float z = abs1(difference[2]);
    uint axis = x >= y && x >= z ? 0u : y >= z ? 1u : 2u;
    float along = axis == 0u ? difference[0] : axis == 1u ? difference[1] : difference[2];
    return along < 0.0f ? axis + 3u : axis;
}

// Sums over sides of eight boxes along an axis, in steps: bytes 0 and 2, then 1 and 3, of twice the centres.
FN uint even_centres(uint lower, uint upper) { return (lower & 0xff00ffu) + (upper & 0xff00ffu); }
FN uint odd_centres(uint lower, uint upper) { return (lower >> 8u & 0xff00ffu) + (upper >> 8u & 0xff00ffu); }
FN uint sum_of_halves(uint pair) { return (pair & 0xffffu) + (pair >> 16u); }

// How much higher the upper halves of the places lie along an axis, for each bit of the place: by twice the centres of the boxes, in
// steps. Boxes that are inside out count as in the middle. The four words are those of sides[], from 4 * axis on.
FN vec3 centre_differences(uint lower_0, uint lower_4, uint upper_0, uint upper_4)
{
    uint even_0 = even_centres(lower_0, upper_0);
    uint even_4 = even_centres(lower_4, upper_4);
    uint odd_0 = odd_centres(lower_0, upper_0);
    uint odd_4 = odd_centres(lower_4, upper_4);
    uint all_0 = even_0 + odd_0;
    uint all_4 = even_4 + odd_4;
    float low_1 = to_float((all_0 & 0xffffu) + (all_4 & 0xffffu));
    float high_1 = to_float((all_0 >> 16u) + (all_4 >> 16u));
    return vec3(to_float(sum_of_halves(odd_0 + odd_4)) - to_float(sum_of_halves(even_0 + even_4)), high_1 - low_1,
                to_float(sum_of_halves(all_4)) - to_float(sum_of_halves(all_0)));
}

// -------------------------------------------------------------------------------------------------------- placements

LIMIT(PLACEMENT_FILTERED, 1u, "hits are put to the filter")
LIMIT(PLACEMENT_MIRRORED, 2u, "the map turns space inside out")

// An instance: clast_placement of accel/structures.h. Maps are columns.
RECORD(clast_device_placement)
{
    packed3 to_object[3];
    packed3 origin; // of object space, in the world
    packed_address nodes;    // of the unit's tree; 0: nothing can be hit
    packed_address clusters; // of the unit
    clast_box box;           // around the unit's sound triangles, not quantised
    uint id;                 // what hits report
    uint flags;              // PLACEMENT_ bits
    packed3 to_world[3];
    uint unit;
    uint unused[2];
};
RECORD_SIZE(clast_device_placement, 144)

// A tree over clusters, for placements that are made of it.
RECORD(clast_device_tree)
{
    packed_address nodes;
    packed_address clusters;
    packed_address bounds; // clast_box around all, not quantised
};
RECORD_SIZE(clast_device_tree, 24)

// What rays are traced through. The items of its tree are numbers of placements.
RECORD(clast_device_scene)
{
    packed_address nodes;
    packed_address placements;
    clast_box box; // around all, not quantised
    float spread;  // clast_tlas.spread of accel/structures.h
    uint placement_count; // 0: nothing is there
};
RECORD_SIZE(clast_device_scene, 48)

#endif
