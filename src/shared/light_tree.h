// SPDX-License-Identifier: Apache-2.0
// A tree over all lights that are somewhere, and how one of them is chosen for a point: from the root down, each time by how much
// light either side may send there. Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting,
// 2018; Pharr, Jakob and Humphreys, Physically Based Rendering, fourth edition, 2023, section 12.6.3. Nodes and lights are read
// by the callers: formulas are here.
//
// Places, radii and powers are in the tree's own scale, a power of two that brings what there is to a size of about one, so
// that no square of a distance overflows or vanishes.
#ifndef CLAST_SHARED_LIGHT_TREE_H
#define CLAST_SHARED_LIGHT_TREE_H

#include "shared/light.h"

LIMIT(LIGHT_LEAF_MOST, 8u, "lights of a leaf, at most: each is weighed by itself")
LIMIT(LIGHT_TREE_LEVELS, 32u, "turns from the root to a leaf, at most: a trail has a bit for each")
TABLE float LIGHT_SLACK = 1e-3f;         // that cosines get on top: rounding must not make a light vanish
TABLE float LIGHT_NEAREST = 1e-9f;       // least distance, in the tree's scale
TABLE float LIGHT_SPREAD = 0.5f;         // of the square of a sphere's radius: least square of the distance to what it holds

// -------------------------------------------------------------------------------------------------------- directions

LIMIT(DIRECTION_NONE, 0xffffffffu, "in place of a packed direction: none")
TABLE float DIRECTION_STEPS = 32767.0f; // of a coordinate, either way

FN float packed_coordinate(uint bits) { return (to_float(bits) - DIRECTION_STEPS) * 3.0518509e-5f; }

FN uint pack_coordinate(float x) { return to_uint(clamp1(x, -1.0f, 1.0f) * DIRECTION_STEPS + (DIRECTION_STEPS + 0.5f)); }

// The square as an octahedron that is unfolded (Meyer and others, On Floating-Point Normal Vectors, 2010). Where the vector is
// zero or not finite, DIRECTION_NONE.
FN uint pack_direction(vec3 v)
{
    float size = abs1(v[0]) + abs1(v[1]) + abs1(v[2]);
    bool sound = size > 0.0f && size < 3e38f;
    float scale = sound ? rough_divide(1.0f, size) : 0.0f;
    float x = v[0] * scale;
    float y = v[1] * scale;
    bool folds = v[2] < 0.0f;
    float a = folds ? (1.0f - abs1(y)) * (x < 0.0f ? -1.0f : 1.0f) : x;
    float b = folds ? (1.0f - abs1(x)) * (y < 0.0f ? -1.0f : 1.0f) : y;
    uint bits = pack_coordinate(sound ? a : 0.0f) | pack_coordinate(sound ? b : 0.0f) << 16u;
    return sound ? bits : DIRECTION_NONE;
}

// Unit length; zero for DIRECTION_NONE.
FN vec3 unpack_direction(uint bits)
{
    float x = packed_coordinate(bits & 65535u);
    float y = packed_coordinate(bits >> 16u);
    float z = 1.0f - abs1(x) - abs1(y);
    float fold = max1(-z, 0.0f);
    vec3 v = vec3(x < 0.0f ? x + fold : x - fold, y < 0.0f ? y + fold : y - fold, z);
    return bits != DIRECTION_NONE ? normalize3(v) : splat3(0.0f);
}

// Where light is asked for. What a path hits is weighed by the same numbers that chose a light where its ray began, so these
// are kept with the path as they are.
RECORD(clast_lit_point)
{
    packed3 position;
    uint normal; // packed, on the side that is lit; DIRECTION_NONE where light from all sides counts
};
RECORD_SIZE(clast_lit_point, 16)

// `passes`: light from behind counts too.
FN clast_lit_point lit_point(vec3 position, vec3 normal, bool passes)
{
    clast_lit_point point;
    point.position = store3(position);
    point.normal = passes ? DIRECTION_NONE : pack_direction(normal);
    return point;
}

// The same in the tree's scale.
RECORD(clast_light_view)
{
    packed3 position;
    packed3 normal; // zero where light from all sides counts
    float scale;
    uint all_sides;
};
RECORD_SIZE(clast_light_view, 32)

FN clast_light_view light_view(clast_lit_point point, float scale)
{
    clast_light_view view;
    view.position = store3(load3(point.position) * scale);
    view.normal = store3(unpack_direction(point.normal));
    view.scale = scale;
    view.all_sides = point.normal == DIRECTION_NONE ? 1u : 0u;
    return view;
}

// ------------------------------------------------------------------------------------------------------------- bounds

// What is known of some lights together. They lie in a sphere, and shine within `emission` of a direction that is itself
// within `spread` of the axis; either way, where `two_sided` is.
RECORD(clast_light_bounds)
{
    packed3 centre;
    float radius;
    packed3 axis; // unit length
    float spread_cosine;
    float emission_cosine;
    uint two_sided;
    float power; // irradiance at a distance of one, straight ahead
    float reach; // 0: endless
};
RECORD_SIZE(clast_light_bounds, 48)

// The same in 32 bytes, rounded so that nothing that was within is without.
RECORD(clast_light_node)
{
    packed3 centre;
    float radius;
    float power;
    uint axis;   // packed
    uint bounds; // light_node_bits()
    uint first;  // the first of its two children, the other follows it; of a leaf: its first light
};
RECORD_SIZE(clast_light_node, 32)

// A light of a leaf.
RECORD(clast_light_entry)
{
    uint number; // emissive triangles first, then the scene's punctual lights
    float power;
};
RECORD_SIZE(clast_light_entry, 8)

// Reaches are a power of two times one of four factors, from 2^-40 to almost 2^24.
LIMIT(LIGHT_REACH_CODES, 256u, "that there are; 0 is endless")
TABLE float LIGHT_REACH_FACTORS[4] = {1.0f, 1.1892072f, 1.4142137f, 1.6817930f};

FN float light_reach(uint code)
{
    float scale = power_of_two(127u - 40u + (code >> 2u));
    return code == 0u ? 0.0f : scale * LIGHT_REACH_FACTORS[code & 3u];
}

// Cosines of 11 and 8 bits, how many lights a leaf has (0: it is none), the reach.
FN uint light_node_bits(uint spread, uint emission, uint two_sided, uint count, uint reach)
{
    return spread | emission << 11u | two_sided << 19u | count << 20u | reach << 24u;
}
FN float light_node_spread(uint bits) { return to_float(bits & 2047u) * 9.770395e-4f - 1.0f; }
FN float light_node_emission(uint bits) { return to_float(bits >> 11u & 255u) * 7.843137e-3f - 1.0f; }
FN uint light_node_count(clast_light_node node) { return node.bounds >> 20u & 15u; }

FN clast_light_bounds light_node_bounds(clast_light_node node)
{
    clast_light_bounds made;
    made.centre = node.centre;
    made.radius = node.radius;
    made.axis = store3(unpack_direction(node.axis));
    made.spread_cosine = light_node_spread(node.bounds);
    made.emission_cosine = light_node_emission(node.bounds);
    made.two_sided = node.bounds >> 19u & 1u;
    made.power = node.power;
    made.reach = light_reach(node.bounds >> 24u);
    return made;
}

// --------------------------------------------------------------------------------------------------------- importance

// An angle by its cosine and sine.
RECORD(clast_light_angle)
{
    float cosine;
    float sine;
};
RECORD_SIZE(clast_light_angle, 8)

FN clast_light_angle light_angle(float cosine)
{
    clast_light_angle angle;
    angle.cosine = clamp1(cosine, -1.0f, 1.0f);
    angle.sine = rough_sqrt(max1(1.0f - angle.cosine * angle.cosine, 0.0f));
    return angle;
}

// a - b; 0 where b is the wider.
FN clast_light_angle light_angle_less(clast_light_angle a, clast_light_angle b)
{
    bool is_within = a.cosine > b.cosine;
    clast_light_angle angle;
    angle.cosine = is_within ? 1.0f : a.cosine * b.cosine + a.sine * b.sine;
    angle.sine = is_within ? 0.0f : a.sine * b.cosine - a.cosine * b.sine;
    return angle;
}

// How much of light from a direction a surface receives, at most, where the direction is known up to an angle.
FN float light_received(clast_light_view view, vec3 towards, clast_light_angle about)
{
    clast_light_angle angle = light_angle_less(light_angle(dot3(load3(view.normal), towards)), about);
    return view.all_sides != 0u ? 1.0f : max1(angle.cosine + LIGHT_SLACK, 0.0f);
}

// How much of their power lights send towards a point, at most.
FN float light_sent(clast_light_bounds lights, vec3 towards, clast_light_angle about)
{
    float cosine = -dot3(load3(lights.axis), towards);
    clast_light_angle angle = light_angle(lights.two_sided != 0u ? abs1(cosine) : cosine);
    angle = light_angle_less(light_angle_less(angle, light_angle(lights.spread_cosine)), about);
    bool sends = angle.cosine + LIGHT_SLACK > lights.emission_cosine;
    return sends ? max1(angle.cosine, 0.0f) + LIGHT_SLACK : 0.0f;
}

// How much light may arrive at a point: zero only where none can.
FN float light_importance(clast_light_bounds lights, clast_light_view view)
{
    vec3 away = load3(lights.centre) - load3(view.position);
    float square = dot3(away, away);
    float radius_square = lights.radius * lights.radius;
    bool outside = square > radius_square;
    float distance = rough_sqrt(square);
    float scale = outside ? rough_divide(1.0f, distance) : 0.0f;
    vec3 towards = away * scale;
    clast_light_angle about;
    about.sine = lights.radius * scale;
    about.cosine = outside ? rough_sqrt(max1(1.0f - about.sine * about.sine, 0.0f)) : -1.0f;
    // A sphere around the point may still lie behind the surface.
    bool behind = view.all_sides == 0u && dot3(load3(view.normal), away) < -1.0001f * lights.radius - LIGHT_SLACK * distance;
    bool beyond = lights.reach > 0.0f && distance - lights.radius > lights.reach * 1.0001f;
    float facing = light_received(view, towards, about) * light_sent(lights, towards, about);
    float least = max1(LIGHT_SPREAD * radius_square, LIGHT_NEAREST * LIGHT_NEAREST);
    float importance = rough_divide(lights.power * facing, max1(square, least));
    bool counts = importance > 0.0f && !behind && !beyond;
    return counts ? importance : 0.0f;
}

FN float light_node_importance(clast_light_node node, clast_light_view view)
{
    return light_importance(light_node_bounds(node), view);
}

// Of a punctual light that is somewhere, at a point that is not scaled.
FN float light_punctual_importance(clast_light light, float power, vec3 position, clast_light_view view)
{
    vec3 away = load3(light.position) - position;
    float distance = length3(away);
    float scaled = max1(distance * view.scale, LIGHT_NEAREST);
    vec3 towards = distance > 0.0f ? away * rough_divide(1.0f, distance) : load3(light.direction) * -1.0f;
    clast_light_angle about = light_angle(1.0f);
    float importance = rough_divide(power * light_reaching(light, towards, distance), scaled * scaled);
    importance = importance * light_received(view, towards, about);
    bool counts = importance > 0.0f;
    return counts ? importance : 0.0f;
}

// Of a light from far away.
FN float light_directional_importance(clast_light light, clast_light_view view)
{
    return light_strength(load3(light.radiance)) * light_received(view, load3(light.direction) * -1.0f, light_angle(1.0f));
}

// Of a triangle that shines to both sides.
FN float light_triangle_importance(vec3 a, vec3 b, vec3 c, float power, clast_light_view view)
{
    vec3 p = a * view.scale;
    vec3 ab = (b - a) * view.scale;
    vec3 ac = (c - a) * view.scale;
    vec3 middle = (ab + ac) * 0.333333343f;
    float square = max1(dot3(middle, middle), max1(dot3(ab - middle, ab - middle), dot3(ac - middle, ac - middle)));
    clast_light_bounds lights;
    lights.centre = store3(p + middle);
    lights.radius = rough_sqrt(square) * 1.00001f;
    lights.axis = store3(normalize3(cross3(ab, ac)));
    lights.spread_cosine = 1.0f;
    lights.emission_cosine = 0.0f;
    lights.two_sided = 1u;
    lights.power = power;
    lights.reach = 0.0f;
    return light_importance(lights, view);
}

// ------------------------------------------------------------------------------------------------------------- choices

// One of a few by weights that are seen one after the other, and what is left of the number that chose. Where no weight is
// above zero, nothing can come from any of them, and all are as likely: so probabilities always add up to one.
RECORD(clast_light_pick)
{
    uint chosen;
    float weight;
    float sum; // of weights so far
    float u;   // in [0, 1)
};
RECORD_SIZE(clast_light_pick, 16)

FN clast_light_pick pick_begin(float u)
{
    clast_light_pick pick;
    pick.chosen = 0u;
    pick.weight = 0.0f;
    pick.sum = 0.0f;
    pick.u = u;
    return pick;
}

FN float below_one(float u) { return clamp1(u, 0.0f, 0.99999994f); }

FN clast_light_pick pick_step(clast_light_pick pick, uint number, float weight)
{
    clast_light_pick next = pick;
    next.sum = pick.sum + weight;
    float chance = next.sum > 0.0f ? rough_divide(weight, next.sum) : 0.0f;
    bool takes = pick.u < chance;
    float rest = rough_divide(takes ? pick.u : pick.u - chance, takes ? chance : max1(1.0f - chance, 1e-30f));
    next.chosen = takes ? number : pick.chosen;
    next.weight = takes ? weight : pick.weight;
    next.u = weight > 0.0f ? below_one(rest) : pick.u;
    return next;
}

// After the last of `count`. One that was chosen by number alone has a weight of zero.
FN clast_light_pick pick_end(clast_light_pick pick, uint count)
{
    clast_light_pick made = pick;
    bool even = !(pick.sum > 0.0f);
    float place = pick.u * to_float(count);
    uint number = min_uint(to_uint(clamp1(place, 0.0f, 1e9f)), count - 1u);
    made.chosen = even ? number : pick.chosen;
    made.u = even ? below_one(place - to_float(number)) : pick.u;
    return made;
}

// The chance of an entry of a weight among `count`.
FN float pick_chance(float weight, float sum, uint count)
{
    return sum > 0.0f ? rough_divide(weight, sum) : rough_divide(1.0f, to_float(count));
}

// Which of two children a descent turns to: 1 for the second.
RECORD(clast_light_turn)
{
    uint second;
    float chance;
    float u; // what is left of the number
};
RECORD_SIZE(clast_light_turn, 12)

FN float turn_chance(float first, float second, uint is_second)
{
    return pick_chance(is_second != 0u ? second : first, first + second, 2u);
}

FN clast_light_turn light_turn(float first, float second, float u)
{
    float before = turn_chance(first, second, 0u);
    clast_light_turn turn;
    turn.second = u < before ? 0u : 1u;
    turn.chance = turn_chance(first, second, turn.second);
    turn.u = below_one(rough_divide(turn.second != 0u ? u - before : u, max1(turn.chance, 1e-30f)));
    return turn;
}

#endif
