// SPDX-License-Identifier: Apache-2.0
// Fits the boxes of a cluster to its vertices, and writes its head and nodes (shared/cluster.h). The subgroup that has the
// cluster does it together (accel/lanes.glsl). Where it may have triangles of its own, the kernel defines FIT_OWN_PAIRS, and
// source/source.glsl has their corners.
//
// An invocation has a leaf at a time: it finds the box around the sound triangles of its pairs, as floats for the box of the
// cluster, then as steps. Quantising keeps order, so the boxes of nodes are minima and maxima over steps. Four neighbours have the
// three axes of four leaves, or of a node.
#ifndef CLAST_ACCEL_FIT_GLSL
#define CLAST_ACCEL_FIT_GLSL

#include "accel/lanes.glsl"
#include "shared/cluster.h"
#include "shared/tree.h"

const uint FIT_LEAVES = (CLUSTER_NODES - 1u) * TREE_CHILDREN;
const uint FIT_ROUNDS = (FIT_LEAVES + LANES - 1u) / LANES; // leaves of an invocation at most
const uint FIT_NODE_WORDS = 12u;
const uint FIT_ORDER_WORDS = 5u;
const float FIT_BEYOND = 8e37; // beyond all sound coordinates

ARRAY_OF(fit_pairs, clast_pair, 8)
ARRAY_OF(fit_templates, clast_device_template, 4)

// What is fitted, and where to.
struct fit_target
{
    uint64_t head;     // where the cluster begins
    uint64_t vertices; // where its vertices lie, or will lie
    uint64_t pairs;    // of its topology; its own behind its nodes
    uint64_t box;      // clast_box: gets the box around all; without sound triangles, one inside out
    uint cluster;      // its number in the unit
    uint counts;       // cluster_counts()
    uint own_triangles; // 0: its pairs are its topology's
};

shared uint fit_words[CLUSTERS_TOGETHER * CLUSTER_NODES * FIT_NODE_WORDS];
shared uint fit_orders[CLUSTERS_TOGETHER * FIT_ORDER_WORDS];

uint fit_words_begin() { return cluster_slot() * CLUSTER_NODES * FIT_NODE_WORDS; }
uint fit_orders_begin() { return cluster_slot() * FIT_ORDER_WORDS; }

// ------------------------------------------------------------------------------------------------------------- leaves

struct fit_extent
{
    vec3 lower, upper;
};

fit_extent fit_join(fit_extent a, vec3 v) { return fit_extent(min(a.lower, v), max(a.upper, v)); }

// A pair by its number. A cluster's own is made of its triangles 2 number and 2 number + 1, and written.
clast_pair fit_pair(fit_target target, uint number)
{
#ifdef FIT_OWN_PAIRS
    if (target.own_triangles != 0u) {
        uint first = 2u * number;
        clast_pair pair = lone_pair(cluster_corners(first) | first << 24u);
        if (first + 1u < target.own_triangles) {
            pair = pair_of(cluster_corners(first) | first << 24u, cluster_corners(first + 1u) | (first + 1u) << 24u);
        }
        fit_pairs(target.pairs).at[number] = pair;
        return pair;
    }
#endif
    return fit_pairs(target.pairs).at[number];
}

// The extent with the sound triangles of a pair in it; whether one is not sound.
fit_extent fit_join_pair(fit_extent extent, clast_pair pair, bool all_sound, inout bool unsound)
{
    vec3 a = cluster_point(pair_corner(pair.first, 0u));
    vec3 b = cluster_point(pair_corner(pair.first, 1u));
    vec3 c = cluster_point(pair_corner(pair.first, 2u));
    vec3 d = cluster_point(pair_corner(pair.second, 2u));
    vec3 x = a;
    vec3 y = c;
    if (!pair_is_fan(pair)) {
        x = cluster_point(pair_corner(pair.second, 0u));
        y = cluster_point(pair_corner(pair.second, 1u));
    }
    bool first = all_sound || (is_sound3(a) && is_sound3(b) && is_sound3(c));
    bool second = all_sound || (is_sound3(x) && is_sound3(y) && is_sound3(d));
    if (first) {
        extent = fit_join(fit_join(fit_join(extent, a), b), c);
    }
    if (second && !pair_is_lone(pair)) {
        extent = fit_join(fit_join(fit_join(extent, x), y), d);
    }
    unsound = unsound || !first || !second;
    return extent;
}

fit_extent fit_leaf(fit_target target, uint leaf, bool all_sound, inout bool unsound)
{
    fit_extent extent = fit_extent(vec3(FIT_BEYOND), vec3(-FIT_BEYOND));
    uint shift = cluster_shift(target.counts);
    uint end = min(leaf + 1u << shift, cluster_pairs(target.counts));
    for (uint number = leaf << shift; number < end; number++) {
        extent = fit_join_pair(extent, fit_pair(target, number), all_sound, unsound);
    }
    return extent;
}

// Around the extents of all invocations, by integers in the order of floats: for these, some devices have an operation over a
// subgroup.
fit_extent fit_around(fit_extent own)
{
    fit_extent all;
    cluster_barrier(); // all are here
    [[unroll]] for (uint axis = 0u; axis < 3u; axis++) {
        all.lower[axis] = ordered_float(subgroupMin(ordered_bits(own.lower[axis])));
        all.upper[axis] = ordered_float(subgroupMax(ordered_bits(own.upper[axis])));
    }
    return all;
}

// ------------------------------------------------------------------------------------------------------------- words

// Of four neighbours, each with four bytes: the one with number k gets byte k of each, in their order.
uint fit_turn(uint own)
{
    uint other = subgroupShuffleXor(own, 1u);
    bool odd = (cluster_lane() & 1u) != 0u, high = (cluster_lane() & 2u) != 0u;
    own = odd ? (other >> 8u & 0x00ff00ffu) | (own & 0xff00ff00u) : (own & 0x00ff00ffu) | (other & 0x00ff00ffu) << 8u;
    other = subgroupShuffleXor(own, 2u);
    return high ? other >> 16u | (own & 0xffff0000u) : (own & 0xffffu) | other << 16u;
}

// Writes the words of four leaves, that of each neighbour one of them; boxes without anything sound, and places behind the last
// leaf, are inside out.
void fit_store_leaf(uint leaf, fit_extent extent, vec3 base, uint exponents, uint nodes)
{
    uint lower = 0xffffffu, upper = 0u;
    if (extent.lower.x < FIT_BEYOND) {
        lower = 0u;
        [[unroll]] for (uint axis = 0u; axis < 3u; axis++) {
            uint exponent = exponent_of_axis(exponents, axis);
            lower |= side_down(extent.lower[axis], base[axis], exponent) << 8u * axis;
            upper |= side_up(extent.upper[axis], base[axis], exponent) << 8u * axis;
        }
    }
    cluster_barrier();
    lower = fit_turn(lower);
    upper = fit_turn(upper);
    uint node = leaf / TREE_CHILDREN + (nodes > 1u ? 1u : 0u), axis = leaf & 3u;
    if (node < nodes && axis < 3u) {
        uint at = fit_words_begin() + node * FIT_NODE_WORDS + 4u * axis + (leaf >> 2u & 1u);
        fit_words[at] = lower;
        fit_words[at + 2u] = upper;
    }
}

// The four words of a node's axis.
uvec4 fit_words_of(uint node, uint axis)
{
    uint at = fit_words_begin() + node * FIT_NODE_WORDS + 4u * axis;
    return uvec4(fit_words[at], fit_words[at + 1u], fit_words[at + 2u], fit_words[at + 3u]);
}

uint fit_least_byte(uint a, uint b)
{
    uint least = 255u;
    [[unroll]] for (uint i = 0u; i < 32u; i += 8u) {
        least = min(least, min(a >> i & 255u, b >> i & 255u));
    }
    return least;
}

// A child of the root, along an axis, as the root has it.
void fit_store_child(uint child, uint axis, uvec4 words)
{
    uint least = fit_least_byte(words.x, words.y), most = 255u - fit_least_byte(~words.z, ~words.w);
    uint at = fit_words_begin() + 4u * axis + (child >> 2u), shift = 8u * (child & 3u);
    atomicOr(fit_words[at], least << shift);
    atomicOr(fit_words[at + 2u], most << shift);
}

// ------------------------------------------------------------------------------------------------------------- orders

float fit_component(vec3 v, uint number) { return number == 0u ? v.x : number == 1u ? v.y : v.z; }

// The order of a node, of which each but the last of four neighbours has the words of an axis.
uint fit_order(uvec4 words, uint exponents)
{
    uint axis = cluster_lane() & 3u;
    vec3 own = centre_differences(words.x, words.y, words.z, words.w) * power_of_two(exponent_of_axis(exponents, axis));
    // The first three get what all have for one bit of the places: of number k, from number k ^ mask.
    vec3 differences = vec3(0.0);
    [[unroll]] for (uint mask = 0u; mask < 4u; mask++) {
        uint other = axis ^ mask;
        float taken = subgroupShuffleXor(fit_component(own, other), mask);
        differences = vec3(other == 0u ? taken : differences.x, other == 1u ? taken : differences.y,
                           other == 2u ? taken : differences.z);
    }
    uint order = axis < 3u ? side_of(differences) << 3u * axis : 0u;
    order |= subgroupShuffleXor(order, 1u);
    return order | subgroupShuffleXor(order, 2u);
}

void fit_store_order(uint node, uint order)
{
    atomicOr(fit_orders[fit_orders_begin() + (node >> 1u)], order << 16u * (node & 1u));
}

// --------------------------------------------------------------------------------------------------------------- all

void fit_clear()
{
    for (uint i = cluster_lane(); i < FIT_NODE_WORDS; i += LANES) {
        fit_words[fit_words_begin() + i] = 0u;
    }
    for (uint i = cluster_lane(); i < FIT_ORDER_WORDS; i += LANES) {
        fit_orders[fit_orders_begin() + i] = 0u;
    }
    cluster_barrier();
}

// The root's words, from those of the nodes below, and the orders of all nodes.
void fit_nodes(uint nodes, uint exponents)
{
    if (nodes > 1u) {
        for (uint i = cluster_lane(); i < 4u * TREE_CHILDREN; i += LANES) {
            uint child = i >> 2u, axis = i & 3u;
            bool there = child + 1u < nodes;
            uvec4 words = there && axis < 3u ? fit_words_of(child + 1u, axis) : uvec4(CLAST_NONE, CLAST_NONE, 0u, 0u);
            uint order = fit_order(words, exponents);
            if (axis < 3u) {
                fit_store_child(child, axis, words);
            }
            if (there && axis == 0u) {
                fit_store_order(child + 1u, order);
            }
        }
        cluster_barrier();
    }
    uint axis = min(cluster_lane() & 3u, 2u);
    uint order = fit_order(fit_words_of(0u, axis), exponents);
    if (cluster_lane() == 0u) {
        fit_store_order(0u, order);
    }
    cluster_barrier();
}

void fit_write_head(fit_target target, vec3 base, uint exponents, bool unsound)
{
    uint4s head = uint4s(target.head);
    uint counts = target.counts | (unsound ? CLUSTER_UNSOUND : 0u), from = fit_orders_begin();
    uvec2 vertices = store_address(target.vertices), pairs = store_address(target.pairs);
    head.at[0] = uvec4(floatBitsToUint(base), exponents);
    head.at[1] = uvec4(vertices, pairs);
    head.at[2] = uvec4(target.cluster, counts, fit_orders[from], fit_orders[from + 1u]);
    head.at[3] = uvec4(fit_orders[from + 2u], fit_orders[from + 3u], fit_orders[from + 4u], 0u);
}

// All invocations of the subgroup call this with the same target, after a barrier behind what wrote the points.
void fit_cluster(fit_target target)
{
    uint leaves = cluster_leaves(target.counts), nodes = cluster_nodes(target.counts);
    fit_clear();
    bool all_sound = subgroupAll(are_sound_bits(cluster_size_bits)); // then so are all triangles, and nobody looks at each
    bool unsound = false;
    fit_extent extents[FIT_ROUNDS];
    fit_extent own = fit_extent(vec3(FIT_BEYOND), vec3(-FIT_BEYOND));
    [[unroll]] for (uint round = 0u; round < FIT_ROUNDS; round++) {
        uint leaf = round * LANES + cluster_lane();
        extents[round] = fit_extent(vec3(FIT_BEYOND), vec3(-FIT_BEYOND));
        if (leaf < leaves) {
            extents[round] = fit_leaf(target, leaf, all_sound, unsound);
        }
        own = fit_extent(min(own.lower, extents[round].lower), max(own.upper, extents[round].upper));
    }
    fit_extent all = fit_around(own);
    bool empty = all.lower.x >= FIT_BEYOND;
    vec3 base = empty ? vec3(0.0) : vec3(unsigned_zero(all.lower.x), unsigned_zero(all.lower.y), unsigned_zero(all.lower.z));
    vec3 upper = empty ? vec3(0.0) : vec3(unsigned_zero(all.upper.x), unsigned_zero(all.upper.y), unsigned_zero(all.upper.z));
    uint exponents = box_exponents(upper - base);
    [[unroll]] for (uint round = 0u; round < FIT_ROUNDS; round++) {
        fit_store_leaf(round * LANES + cluster_lane(), extents[round], base, exponents, nodes);
    }
    cluster_barrier();
    fit_nodes(nodes, exponents);
    uints words = uints(target.head + CLUSTER_HEAD_BYTES);
    for (uint i = cluster_lane(); i < nodes * FIT_NODE_WORDS; i += LANES) {
        words.at[i] = fit_words[fit_words_begin() + i];
    }
    unsound = subgroupAny(unsound);
    if (cluster_lane() == 0u) {
        fit_write_head(target, base, exponents, unsound);
        clast_box box;
        box.lower = empty ? vec3(uintBitsToFloat(0x7f800000u)) : base;
        box.upper = empty ? vec3(uintBitsToFloat(0xff800000u)) : upper;
        boxes(target.box).at[0] = box;
    }
}

#endif
