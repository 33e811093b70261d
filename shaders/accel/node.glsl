// SPDX-License-Identifier: Apache-2.0
// Writes nodes of trees: eight invocations, a team, a node, each a child. All invocations of a group of GROUP_SIZE call
// these together; a team may have nothing to write.
#ifndef CLAST_ACCEL_NODE_GLSL
#define CLAST_ACCEL_NODE_GLSL

#include "shared/cluster.h"
#include "shared/tree.h"

// 1: subgroups are at least as wide as a team, so that a team is within one.
layout(constant_id = 0) const uint TEAMS_TOGETHER = 0u;

const uint TEAM = TREE_CHILDREN;
const uint TEAMS = GROUP_SIZE / TEAM;
const uint64_t NODE_BYTES = 96ul; // of a clast_tree_node
// Where children without a box, and places without a child, sort: behind twice any centre.
const float KEY_EMPTY = 1e37;
const float KEY_NONE = 2e37;

shared vec4 team_exchange[GROUP_SIZE];

struct team_child {
    clast_box box; // sound, or inside out (sound_box)
    uint child;
    bool there;
};

// The number of an invocation in its group: teams are within subgroups.
uint team_lane() { return gl_SubgroupID * gl_SubgroupSize + gl_SubgroupInvocationID; }

void team_barrier()
{
    if (TEAMS_TOGETHER != 0u) {
        subgroupMemoryBarrierShared();
        subgroupBarrier();
    } else {
        barrier();
    }
}

// What the lane with number `from` has.
vec4 team_take(vec4 own, uint from)
{
    team_barrier();
    team_exchange[team_lane()] = own;
    team_barrier();
    return team_exchange[from];
}

// What a lane of the team has: bits of `mask` tell which others they are from each.
vec3 team_xor(vec3 own, uint mask)
{
    if (TEAMS_TOGETHER != 0u) {
        return subgroupShuffleXor(own, mask);
    }
    return team_take(vec4(own, 0.0), team_lane() ^ mask).xyz;
}

float team_xor(float own, uint mask)
{
    if (TEAMS_TOGETHER != 0u) {
        return subgroupShuffleXor(own, mask);
    }
    return team_take(vec4(own), team_lane() ^ mask).x;
}

uint longest_axis(vec3 v) { return v.x >= v.y ? (v.x >= v.z ? 0u : 2u) : (v.y >= v.z ? 1u : 2u); }

// How far centres are spread within each part of so many lanes, added up over the parts of a team. Only those of boxes count.
vec3 spread_of_parts(vec3 centre, uint part)
{
    bool counts = centre.x < KEY_EMPTY;
    vec3 least = counts ? centre : vec3(KEY_EMPTY), most = counts ? centre : vec3(-KEY_EMPTY);
    for (uint mask = 1u; mask < part; mask <<= 1u) {
        least = min(least, team_xor(least, mask));
        most = max(most, team_xor(most, mask));
    }
    vec3 spread = max(most - least, vec3(0.0));
    for (uint mask = part; mask < TEAM; mask <<= 1u) {
        spread += team_xor(spread, mask);
    }
    return spread;
}

struct team_places {
    vec3 centre; // of the child whose place the lane's number is
    uint from;   // the lane that has it
    uint order;  // the axes so far
};

// Sorts the places of each part along the axis on which they are spread most; where two are alike the order stays.
team_places sort_parts(team_places places, uint part)
{
    uint lane = team_lane();
    uint axis = longest_axis(spread_of_parts(places.centre, part));
    float key = places.centre[axis];
    uint rank = 0u;
    for (uint mask = 1u; mask < part; mask++) {
        float other = team_xor(key, mask);
        bool before = other < key || (other == key && (lane ^ mask) < lane);
        rank += before ? 1u : 0u;
    }
    // To where it belongs: a lane writes at its place, and reads at its own.
    team_barrier();
    team_exchange[(lane & ~(part - 1u)) + rank] = vec4(places.centre, uintBitsToFloat(0x3f800000u | places.from));
    team_barrier();
    vec4 own = team_exchange[lane];
    return team_places(own.xyz, floatBitsToUint(own.w) & 0xffffu, places.order << 2u | axis);
}

// Four steps as bytes: word `number` of a node's sides. `team_exchange` has the steps of lower and upper sides by places.
uint side_word(uint base, uint number)
{
    uint axis = number >> 2u, is_upper = number >> 1u & 1u, first = base + (number & 1u) * 4u;
    uint word = 0u;
    for (uint i = 0u; i < 4u; i++) {
        vec4 steps = team_exchange[first + i];
        uint bits = floatBitsToUint(is_upper != 0u ? steps.y : steps.x);
        word |= (bits >> (8u * axis) & 255u) << (8u * i);
    }
    return word;
}

// The steps of three sides, in a word that is no special float.
uint steps_of(vec3 side, bool upper, bool empty, vec3 base, uint exponents)
{
    uint word = 0x40000000u;
    for (uint axis = 0u; axis < 3u; axis++) {
        uint exponent = exponent_of_axis(exponents, axis);
        uint steps = upper ? side_up(side[axis], base[axis], exponent) : side_down(side[axis], base[axis], exponent);
        word |= (empty ? (upper ? 0u : 255u) : steps) << (8u * axis);
    }
    return word;
}

clast_box bound_team(clast_box box)
{
    vec3 lower = box.lower, upper = box.upper;
    for (uint mask = 1u; mask < TEAM; mask <<= 1u) {
        lower = min(lower, team_xor(lower, mask));
        upper = max(upper, team_xor(upper, mask));
    }
    box.lower = vec3(unsigned_zero(lower.x), unsigned_zero(lower.y), unsigned_zero(lower.z));
    box.upper = vec3(unsigned_zero(upper.x), unsigned_zero(upper.y), unsigned_zero(upper.z));
    return box;
}

// Writes a node at an address, where it is not 0, and gives the box around its children.
clast_box write_node(team_child child, uint64_t node)
{
    uint lane = team_lane(), place = lane % TEAM, base = lane - place;
    clast_box box = bound_team(child.box);
    bool none = box_is_empty(box), empty = box_is_empty(child.box);
    vec3 lower = none ? vec3(0.0) : box.lower;
    uint exponents = box_exponents(none ? vec3(0.0) : box.upper - box.lower);
    vec3 centre = !child.there ? vec3(KEY_NONE) : empty ? vec3(KEY_EMPTY) : child.box.lower + child.box.upper;
    team_places places = team_places(centre, lane, 0u);
    for (uint part = TEAM; part > 1u; part >>= 1u) {
        places = sort_parts(places, part);
    }
    // What the lane has itself goes to the place that took it.
    vec3 own_lower = empty ? lower : child.box.lower, own_upper = empty ? lower : child.box.upper;
    uint own = child.there ? child.child : CLAST_NONE;
    vec4 told = vec4(uintBitsToFloat(steps_of(own_lower, false, empty, lower, exponents)),
                     uintBitsToFloat(steps_of(own_upper, true, empty, lower, exponents)),
                     uintBitsToFloat(0x40000000u | own & 0xffffu), uintBitsToFloat(0x40000000u | own >> 16u));
    told = team_take(told, places.from);
    team_barrier();
    team_exchange[lane] = told;
    team_barrier();
    if (node != 0ul) {
        uints words = uints(node);
        vec4 nearest = team_exchange[base];
        uint taken = floatBitsToUint(told.z) & 0xffffu | floatBitsToUint(told.w) << 16u;
        uint first = floatBitsToUint(nearest.z) & 0xffffu | floatBitsToUint(nearest.w) << 16u;
        words.at[16u + place] = taken == CLAST_NONE ? first : taken;
        words.at[4u + place] = side_word(base, place);
        if (place < 4u) {
            words.at[12u + place] = side_word(base, 8u + place);
            words.at[place] = place < 3u ? floatBitsToUint(lower[place]) : exponents | places.order << 24u;
        }
    }
    return box;
}

#endif
