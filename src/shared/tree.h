// SPDX-License-Identifier: Apache-2.0
// Trees being built on a device over boxes of items: what the processor tells the kernels, and what these share. The nodes are
// those of shared/cluster.h.
#ifndef CLAST_SHARED_TREE_H
#define CLAST_SHARED_TREE_H

#include "shared/cluster.h"

LIMIT(TREE_LEVELS, 24u, "most levels of nodes of a tree that a device built")
LIMIT(TREE_ITEMS_BITS, 26u, "trees that are built together have less than so many items, as a power of two")
LIMIT(TREE_PHASES, 3u, "kernels that a tree over stored items takes: each adds three levels of eight")
LIMIT(TREE_PHASE_ITEMS, 512u, "items of a work group of such a kernel")

// A tree of those that are built together. Their items are counted through.
RECORD(clast_tree_job)
{
    packed_address boxes;  // clast_box of each item; a box that is not sound counts as empty
    packed_address items;  // what a child that is the item says; 0: the item's number
    packed_address nodes;  // clast_tree_node: room for as many as there are items, and for one
    packed_address bounds; // clast_box: gets the box around all items; 0: not wanted
    packed_address kept;   // clast_tree_kept: gets what fitting the tree anew needs; 0: not wanted
    uint count;
    uint first; // items of the trees before
    uint first_groups[3]; // work groups of the trees before, in each phase
    uint unused;
};
RECORD_SIZE(clast_tree_job, 64)

// What is kept of a tree to fit it anew, after this head: for each number that a node may have, its children and more.
RECORD(clast_tree_kept)
{
    uint bottoms;      // nodes of items only
    uint are_in_row;   // 1: these are nodes first_bottom and the next; 0: `bottom` of the numbers tells them
    uint first_bottom;
    uint room;         // numbers that nodes may have
};
RECORD_SIZE(clast_tree_kept, 16)
RECORD(clast_tree_kept_node)
{
    uint children[8]; // in any order: items' numbers with CHILD_ITEM, nodes, or CLAST_NONE
    clast_box box;
    uint parent;   // CLAST_NONE: the root
    uint arrivals; // of children that were fitted; 0 between runs
};
RECORD_SIZE(clast_tree_kept_node, 64)

// What is known of a tree while it is built.
RECORD(clast_tree_work)
{
    uint lower[3]; // of the box around the items: ordered_bits()
    uint upper[3];
    uint root;     // of the binary tree
    uint is_deep;  // 1: it would have more than TREE_LEVELS levels
};
RECORD_SIZE(clast_tree_work, 32)

// A node of the binary tree. A half is the number of a node or CHILD_ITEM with an item's number in its tree.
RECORD(clast_tree_pair)
{
    packed3 lower;
    uint left;
    packed3 upper;
    uint right;
    float costs[7]; // least cost of what is below, as children of at most 1 to 7 in number of one node (accel/tree_collapse.c)
    uint shares;    // how many of n children the left half gets, for n from 2 to 8 in bits 3 (n - 2); 0: fewer are no worse
};
RECORD_SIZE(clast_tree_pair, 64)

FN uint share_of(uint shares, uint children) { return shares >> (3u * children - 6u) & 7u; }

// Integers in the order of floats, for minima and maxima by atomic operations.
FN uint ordered_bits(float x)
{
    uint bits = floatBitsToUint(x);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}
FN float ordered_float(uint bits)
{
    return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits);
}

// A power of two that makes the longest side of a box about one. What is next to nothing stays so.
FN float box_scale(vec3 extent)
{
    uint exponent = floatBitsToUint(largest3(extent)) >> 23u;
    return exponent == 0u ? 1.0f : power_of_two(min_uint(254u - min_uint(exponent, 253u), 253u));
}

// Half the area of a box.
FN float half_area(vec3 lower, vec3 upper, float scale)
{
    vec3 size = (upper - lower) * scale;
    float area = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    return size[0] < 0.0f ? 0.0f : area;
}

// A box that is sound, or else inside out, beyond all numbers of sound ones.
LIMIT(TREE_BEYOND_BITS, 0x7e800000u, "2^126, as bits")
FN clast_box sound_box(clast_box box)
{
    vec3 lower = load3(box.lower);
    vec3 upper = load3(box.upper);
    bool sound = is_sound3(lower) && is_sound3(upper) && lower[0] <= upper[0] && lower[1] <= upper[1] && lower[2] <= upper[2];
    float beyond = uintBitsToFloat(TREE_BEYOND_BITS);
    clast_box result;
    result.lower = store3(sound ? lower : splat3(beyond));
    result.upper = store3(sound ? upper : splat3(-beyond));
    return result;
}
FN bool box_is_empty(clast_box box) { return !(load3(box.lower)[0] <= load3(box.upper)[0]); }

// The nodes of a tree of eights over stored items that are as near to them as level `level`, from 1 on: each over eight of the
// level before. The root is alone on its level, and the first node; the levels follow from the top.
FN uint level_nodes(uint items, uint level)
{
    uint shift = 3u * level;
    uint whole = shift < 32u ? items >> shift : 0u;
    bool more = shift < 32u ? (items & ((1u << shift) - 1u)) != 0u : items != 0u;
    return whole + (more ? 1u : 0u);
}

#endif
