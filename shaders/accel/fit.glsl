// SPDX-License-Identifier: Apache-2.0
// Fits the boxes of a cluster to its vertices, and writes its head and nodes (shared/cluster.h). A work group of 128 does it
// together, from vertices in shared memory: `cluster_points`, which the kernel declares (source/source.glsl does), and where
// the cluster has triangles of its own, `cluster_corners`, for which it defines FIT_OWN_PAIRS.
//
// An invocation has a pair of triangles: it finds the box around those that are sound, as float sides for the box of the
// cluster, then as steps. The boxes of nodes are minima and maxima over steps.
#ifndef CLAST_ACCEL_FIT_GLSL
#define CLAST_ACCEL_FIT_GLSL

#include "gpu.glsl"
#include "shared/cluster.h"
#include "shared/tree.h"

const uint FIT_GROUP = 128u;
const uint FIT_NODE_WORDS = 12u;
const float FIT_BEYOND = 8e37; // beyond all sound coordinates

ARRAY_OF(fit_pairs, clast_pair, 8)
ARRAY_OF(fit_templates, clast_device_template, 4)

// What is fitted, and where to.
struct fit_target
{
    uint64_t head;     // where the cluster begins
    uint64_t vertices; // where its vertices lie, or will lie
    uint64_t pairs;    // of its topology; fit_own_pairs() tells for clusters that have their own
    uint64_t box;      // clast_box: gets the box around all; without sound triangles, one inside out
    uint cluster;      // its number in the unit
    uint counts;       // cluster_counts()
};

shared uint fit_sides[6u * FIT_GROUP]; // of subgroups: the least lower sides, and the least of the upper ones' opposites
shared uint fit_lower[FIT_GROUP];       // of pairs: steps of x, y and z, 8 bits each
shared uint fit_upper[FIT_GROUP];
shared uint fit_words[CLUSTER_NODES * FIT_NODE_WORDS];
shared uint fit_orders[CLUSTER_NODES + 1u];
shared uint fit_unsound;

// ------------------------------------------------------------------------------------------------------------- pairs

// Sides as minima: those of the upper ones are opposites.
struct fit_extent
{
    vec3 lower, opposite;
};

fit_extent fit_join(fit_extent a, vec3 v)
{
    return fit_extent(min(a.lower, v), min(a.opposite, -v));
}

// Around the sound triangles of a pair; whether one is not sound.
fit_extent fit_pair_extent(clast_pair pair, out bool unsound)
{
    fit_extent extent = fit_extent(vec3(FIT_BEYOND), vec3(FIT_BEYOND));
    vec3 a = cluster_points[pair_corner(pair.first, 0u)];
    vec3 b = cluster_points[pair_corner(pair.first, 1u)];
    vec3 c = cluster_points[pair_corner(pair.first, 2u)];
    bool fan = pair_is_fan(pair);
    vec3 d = cluster_points[pair_corner(pair.second, 2u)];
    vec3 x = fan ? a : cluster_points[pair_corner(pair.second, 0u)];
    vec3 y = fan ? c : cluster_points[pair_corner(pair.second, 1u)];
    bool first = is_sound3(a) && is_sound3(b) && is_sound3(c);
    bool second = is_sound3(x) && is_sound3(y) && is_sound3(d);
    if (first) {
        extent = fit_join(fit_join(fit_join(extent, a), b), c);
    }
    if (second && !pair_is_lone(pair)) {
        extent = fit_join(fit_join(fit_join(extent, x), y), d);
    }
    unsound = !first || !second;
    return extent;
}

// Around the extents of all invocations, of which those from `count` on have none. Minima are of integers in the order of floats,
// for which some devices have an operation over a subgroup.
fit_extent fit_reduce(fit_extent own, uint count)
{
    if (gl_SubgroupID * gl_SubgroupSize < count) {
        for (uint axis = 0u; axis < 3u; axis++) {
            uint lower = subgroupMin(ordered_bits(own.lower[axis]));
            uint opposite = subgroupMin(ordered_bits(own.opposite[axis]));
            if (subgroupElect()) {
                fit_sides[gl_SubgroupID * 6u + axis] = lower;
                fit_sides[gl_SubgroupID * 6u + axis + 3u] = opposite;
            }
        }
    }
    barrier();
    uint sides[6] = {CLAST_NONE, CLAST_NONE, CLAST_NONE, CLAST_NONE, CLAST_NONE, CLAST_NONE};
    for (uint i = 0u; i * gl_SubgroupSize < count; i++) {
        [[unroll]] for (uint side = 0u; side < 6u; side++) {
            sides[side] = min(sides[side], fit_sides[i * 6u + side]);
        }
    }
    return fit_extent(vec3(ordered_float(sides[0]), ordered_float(sides[1]), ordered_float(sides[2])),
                      vec3(ordered_float(sides[3]), ordered_float(sides[4]), ordered_float(sides[5])));
}

// The number of an invocation: those of a subgroup follow each other.
uint fit_lane() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }

// Stores a pair's steps; the box is inside out where nothing in it is sound.
void fit_store_steps(uint lane, uint pairs, fit_extent extent, vec3 base, uint exponents)
{
    if (lane >= pairs) {
        fit_lower[lane] = 0xffffffu;
        fit_upper[lane] = 0u;
        return;
    }
    bool empty = extent.lower.x >= FIT_BEYOND;
    uint lower = 0u;
    uint upper = 0u;
    for (uint axis = 0u; axis < 3u; axis++) {
        uint exponent = exponent_of_axis(exponents, axis);
        lower |= (empty ? 255u : side_down(extent.lower[axis], base[axis], exponent)) << (8u * axis);
        upper |= (empty ? 0u : side_up(-extent.opposite[axis], base[axis], exponent)) << (8u * axis);
    }
    fit_lower[lane] = lower;
    fit_upper[lane] = upper;
}

// ------------------------------------------------------------------------------------------------------------- nodes

// A side of a leaf, whose pairs are those of its number and, where shift is 1, the one after.
uint fit_leaf_side(uint leaf, uint shift, uint axis, bool upper)
{
    uint pair = leaf << shift;
    uint side = (upper ? fit_upper[pair] : fit_lower[pair]) >> (8u * axis) & 255u;
    if (shift != 0u) {
        uint other = (upper ? fit_upper[pair + 1u] : fit_lower[pair + 1u]) >> (8u * axis) & 255u;
        side = upper ? max(side, other) : min(side, other);
    }
    return side;
}

// Word `number` of the sides of a node above leaves, of which it has those from `first` on.
uint fit_leaf_word(uint first, uint number, uint leaves, uint shift)
{
    uint axis = number >> 2u;
    bool upper = (number & 2u) != 0u;
    first += (number & 1u) * 4u;
    uint word = 0u;
    for (uint i = 0u; i < 4u; i++) {
        uint none = upper ? 0u : 255u;
        word |= (first + i < leaves ? fit_leaf_side(first + i, shift, axis, upper) : none) << (8u * i);
    }
    return word;
}

// The least or the largest byte of two words.
uint fit_side_of_words(uint a, uint b, bool upper)
{
    uint side = upper ? 0u : 255u;
    for (uint i = 0u; i < 32u; i += 8u) {
        uint one = a >> i & 255u, other = b >> i & 255u;
        side = upper ? max(side, max(one, other)) : min(side, min(one, other));
    }
    return side;
}

// Word `number` of the sides of the root, from those of the nodes below.
uint fit_root_word(uint number, uint nodes)
{
    uint first = 1u + (number & 1u) * 4u, from = number & ~1u;
    bool upper = (number & 2u) != 0u;
    uint word = 0u;
    for (uint i = 0u; i < 4u; i++) {
        uint node = (first + i) * FIT_NODE_WORDS + from;
        uint none = upper ? 0u : 255u;
        uint side = first + i < nodes ? fit_side_of_words(fit_words[node], fit_words[node + 1u], upper) : none;
        word |= side << (8u * i);
    }
    return word;
}

uint fit_order(uint node, uint exponents)
{
    vec3 differences[3];
    for (uint axis = 0u; axis < 3u; axis++) {
        uint from = node * FIT_NODE_WORDS + axis * 4u;
        differences[axis] = centre_differences(fit_words[from], fit_words[from + 1u], fit_words[from + 2u],
                                               fit_words[from + 3u]) *
                            power_of_two(exponent_of_axis(exponents, axis));
    }
    uint sides[3];
    for (uint bit = 0u; bit < 3u; bit++) {
        sides[bit] = side_of(vec3(differences[0][bit], differences[1][bit], differences[2][bit]));
    }
    return order_sides(sides[0], sides[1], sides[2]);
}

// --------------------------------------------------------------------------------------------------------------- all

// The pair of an invocation, which has one where it is below the number of pairs.
clast_pair fit_template_pair(fit_target target)
{
    uint lane = fit_lane();
    return fit_pairs(target.pairs).at[min(lane, cluster_pairs(target.counts) - 1u)];
}

#ifdef FIT_OWN_PAIRS
// The same of a cluster whose triangles are in cluster_corners[]: triangles 2 i and 2 i + 1 are pair i. Writes the pairs behind
// the nodes, and tells the target where that is.
clast_pair fit_own_pair(inout fit_target target, uint triangles)
{
    uint lane = fit_lane(), pairs = cluster_pairs(target.counts);
    uint pair_number = min(lane, pairs - 1u), first = 2u * pair_number;
    uint word = (cluster_corners[first] & 0xffffffu) | first << 24u;
    clast_pair pair = lone_pair(word);
    if (first + 1u < triangles) {
        pair = pair_of(word, (cluster_corners[first + 1u] & 0xffffffu) | (first + 1u) << 24u);
    }
    target.pairs = target.head + cluster_pairs_offset(target.counts);
    if (lane < pairs) {
        fit_pairs(target.pairs).at[lane] = pair;
    }
    return pair;
}
#endif

void fit_write_head(fit_target target, vec3 base, uint exponents)
{
    uint4s head = uint4s(target.head);
    uint counts = target.counts | (fit_unsound != 0u ? CLUSTER_UNSOUND : 0u);
    uvec2 vertices = store_address(target.vertices), pairs = store_address(target.pairs);
    head.at[0] = uvec4(floatBitsToUint(base), exponents);
    head.at[1] = uvec4(vertices, pairs);
    head.at[2] = uvec4(target.cluster, counts, fit_orders[0] | fit_orders[1] << 16u,
                       fit_orders[2] | fit_orders[3] << 16u);
    head.at[3] = uvec4(fit_orders[4] | fit_orders[5] << 16u, fit_orders[6] | fit_orders[7] << 16u, fit_orders[8], 0u);
}

// All 128 invocations call this with the same target, after a barrier behind what wrote the points, and each with its pair.
// Ends with a barrier.
void fit_cluster(fit_target target, clast_pair pair)
{
    uint lane = fit_lane(), pairs = cluster_pairs(target.counts), shift = cluster_shift(target.counts);
    uint leaves = cluster_leaves(target.counts), nodes = cluster_nodes(target.counts);
    if (lane == 0u) {
        fit_unsound = 0u;
    }
    if (lane <= CLUSTER_NODES) {
        fit_orders[lane] = 0u;
    }
    fit_extent extent = fit_extent(vec3(FIT_BEYOND), vec3(FIT_BEYOND));
    bool unsound = false;
    if (lane < pairs) {
        extent = fit_pair_extent(pair, unsound);
    }
    fit_extent all = fit_reduce(extent, pairs);
    if (unsound) {
        atomicOr(fit_unsound, 1u); // after the barrier of fit_reduce
    }
    bool empty = all.lower.x >= FIT_BEYOND;
    vec3 base = empty ? vec3(0.0) : vec3(unsigned_zero(all.lower.x), unsigned_zero(all.lower.y), unsigned_zero(all.lower.z));
    vec3 upper = empty ? vec3(0.0)
                       : vec3(unsigned_zero(-all.opposite.x), unsigned_zero(-all.opposite.y), unsigned_zero(-all.opposite.z));
    uint exponents = box_exponents(upper - base);
    fit_store_steps(lane, pairs, extent, base, exponents);
    barrier();
    uint first_node = nodes > 1u ? 1u : 0u;
    uint node = lane / FIT_NODE_WORDS + first_node, number = lane % FIT_NODE_WORDS;
    if (node < nodes) {
        fit_words[node * FIT_NODE_WORDS + number] =
            fit_leaf_word((node - first_node) * TREE_CHILDREN, number, leaves, shift);
    }
    barrier();
    if (nodes > 1u && lane < FIT_NODE_WORDS) {
        fit_words[lane] = fit_root_word(lane, nodes);
    }
    barrier();
    if (lane < nodes) {
        fit_orders[lane] = fit_order(lane, exponents);
    }
    uints words = uints(target.head + CLUSTER_HEAD_BYTES);
    if (lane < nodes * FIT_NODE_WORDS) {
        words.at[lane] = fit_words[lane];
    }
    barrier();
    if (lane == 0u) {
        fit_write_head(target, base, exponents);
        clast_box box;
        box.lower = empty ? vec3(uintBitsToFloat(0x7f800000u)) : base;
        box.upper = empty ? vec3(uintBitsToFloat(0xff800000u)) : upper;
        boxes(target.box).at[0] = box;
    }
    barrier();
}

#endif
