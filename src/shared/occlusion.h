// SPDX-License-Identifier: Apache-2.0
// Edges behind other things. Of each place of the picture it is known how far away the farthest is that is seen around it, within
// ever more places: a row of depths that never falls. Where an edge lies behind the first of them it lies behind what is within
// their radius, and that radius over the edge's own says how far from sight it is. So edges become coarser little by little
// behind what hides them, and never where any part of them may be seen; all at once only where the last gap closes.
//
// Depths err to the far side, edges to the near side: an edge is a ball around its middle that holds its ends, the triangles at
// it if these are no longer than it is, and what displacement may do in between.
#ifndef CLAST_SHARED_OCCLUSION_H
#define CLAST_SHARED_OCCLUSION_H

#include "shared/tessellation.h"

LIMIT(OCCLUSION_DEPTHS, 16u, "of a place, one after the other")
LIMIT(OCCLUSION_RADIUS, 22u, "places to each side that the last of them tells of")

// By how many places the radius of a depth is larger than that of the one before it.
FN uint occlusion_step(uint number) { return number < 10u ? 1u : 2u; }

// Where an edge is in the picture.
RECORD(clast_edge_place)
{
    uint place;     // whose depths tell of it
    float depth;    // where it is nearest
    float softness; // times how far it is behind a depth: 1 is all of the way
    float radius;   // in places
};
RECORD_SIZE(clast_edge_place, 16)

// What is out of the picture is taken to be at its border: no farther from what of it is in the picture than it was. What reaches
// the near plane covers all.
FN clast_edge_place edge_place(clast_rate_view view, clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    bool parallel = view.parallel != 0u;
    vec3 ca = load3(a.camera);
    vec3 cm = load3(middle.camera);
    vec3 cb = load3(b.camera);
    vec3 chord = cb - ca;
    vec3 from_a = ca - cm;
    vec3 from_b = cb - cm;
    float square = max1(dot3(chord, chord), max1(dot3(from_a, from_a), dot3(from_b, from_b)));
    float ball = root_of(square) + view.deviation;
    float nearest = cm[2] - ball;
    float shrink = parallel ? 1.0f : stable_reciprocal(within_reach(max1(cm[2], view.near_plane)));
    float grow = parallel ? 1.0f : stable_reciprocal(within_reach(max1(nearest, view.near_plane)));
    vec2 slope = vec2(cm[0] * shrink, cm[1] * shrink);
    // off the middle a ball covers more, by the root of 1 + slope squared, which is less than this
    float inclined = parallel ? 1.0f : 1.0f + 0.5f * (squared(slope[0]) + squared(slope[1]));
    vec2 by_slope = load2(view.places_by_slope);
    vec2 places = load2(view.places);
    float radius = ball * grow * inclined * max1(by_slope[0], by_slope[1]);
    float across = clamp1(0.5f * places[0] + slope[0] * by_slope[0], 0.0f, to_float(view.places_across) - 1.0f);
    float down = clamp1(0.5f * places[1] - slope[1] * by_slope[1], 0.0f, to_float(view.places_down) - 1.0f);
    precise bool sound = nearest > view.near_plane && radius < 1000.0f;
    clast_edge_place result;
    result.place = to_uint(down) * view.places_across + to_uint(across);
    result.depth = sound ? nearest : 0.0f;
    result.softness = stable_reciprocal(within_reach(0.05f * nearest));
    result.radius = sound ? radius : 1000.0f;
    return result;
}

// How much of the radius within which an edge is hidden one of its place's depths makes up: they add up in order.
FN float occlusion_part(clast_edge_place edge, float depth, uint number)
{
    return clamp1((edge.depth - depth) * edge.softness, 0.0f, 1.0f) * to_float(occlusion_step(number));
}

// 1 where something of an edge that is hidden within `radius` may be seen, or soon, falling to 0.
FN float occlusion_open(clast_edge_place edge, float radius)
{
    float margin = 8.0f + 0.5f * edge.radius;
    return clamp1(1.0f - (radius - edge.radius) * stable_reciprocal(margin), 0.0f, 1.0f);
}

#endif
