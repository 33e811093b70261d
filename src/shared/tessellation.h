// SPDX-License-Identifier: Apache-2.0
// Adaptive tessellation of triangles: how many segments an edge is cut into, how triangles whose edges need more than a pattern
// has are split, and where points come to lie between corners.
//
// Two triangles that share an edge must come to the same count and the same points. So what decides a count is a function of
// the edge's two ends and its middle, in which the ends may change places; and a point is blended from the corners by integer
// weights, in an order in which a corner of weight zero changes nothing.
#ifndef CLAST_SHARED_TESSELLATION_H
#define CLAST_SHARED_TESSELLATION_H

#include "shared/displacement.h"
#include "shared/pattern.h"
#include "shared/transform.h"

LIMIT(EDGE_SEGMENTS, 360448u, "most segments of an edge: PATTERN_SEGMENTS between neighbouring weights")

// ------------------------------------------------------------------------------------------------------------- blends

FN float blend1(float a, float b, float c, clast_weights at)
{
    float sum = (a * to_float(at.of[0]) + b * to_float(at.of[1])) + c * to_float(at.of[2]);
    return sum * power_of_two(112u); // over WEIGHT_ONE, exactly
}

FN vec2 blend2(vec2 a, vec2 b, vec2 c, clast_weights at)
{
    vec2 sum = (a * to_float(at.of[0]) + b * to_float(at.of[1])) + c * to_float(at.of[2]);
    return sum * power_of_two(112u);
}

FN vec3 blend3(vec3 a, vec3 b, vec3 c, clast_weights at)
{
    vec3 sum = (a * to_float(at.of[0]) + b * to_float(at.of[1])) + c * to_float(at.of[2]);
    return sum * power_of_two(112u);
}

// ------------------------------------------------------------------------------------------------------ curved triangles

// The point of an edge's cubic that is near its first end (Vlachos et al., Curved PN triangles, 2001).
FN vec3 curved_edge(vec3 near, vec3 far, vec3 near_normal)
{
    float along = dot3(far - near, near_normal);
    return ((near + near) + (far - near_normal * along)) * 0.333333333f;
}

FN vec3 curved_edge_term(vec3 a, vec3 b, vec3 normal_a, vec3 normal_b, float s, float t)
{
    return curved_edge(a, b, normal_a) * (s * s * t) + curved_edge(b, a, normal_b) * (t * t * s);
}

// The points of a triangle that control its edges: of edge k the one near its first end, then three more for the second ends.
FN vec3 curved_control(const vec3 p[3], const vec3 n[3], uint number)
{
    uint first = number % 3u;
    uint second = (number + 1u) % 3u;
    uint near_end = number < 3u ? first : second;
    return curved_edge(p[near_end], p[number < 3u ? second : first], n[near_end]);
}

// Of a triangle's corners and the six points that control its edges. On an edge the third corner's terms are zero, and both
// triangles add the same numbers, in pairs.
FN vec3 curved_blend(const vec3 p[3], const vec3 controls[6], vec3 weights)
{
    float a = weights[0];
    float b = weights[1];
    float c = weights[2];
    vec3 corners = (p[0] * (a * a * a) + p[1] * (b * b * b)) + p[2] * (c * c * c);
    vec3 edges = ((controls[0] * (a * a * b) + controls[3] * (b * b * a)) + (controls[1] * (b * b * c) + controls[4] * (c * c * b))) +
                 (controls[2] * (c * c * a) + controls[5] * (a * a * c));
    vec3 around = (controls[0] + controls[3]) + (controls[1] + controls[4]) + (controls[2] + controls[5]);
    vec3 centre = around * 0.25f - (p[0] + p[1] + p[2]) * 0.166666667f;
    return (corners + edges * 3.0f) + centre * (6.0f * a * b * c);
}

FN vec3 curved_position(const vec3 p[3], const vec3 n[3], vec3 weights)
{
    vec3 controls[6];
    for (uint i = 0u; i < 6u; i++) {
        controls[i] = curved_control(p, n, i);
    }
    return curved_blend(p, controls, weights);
}

FN vec3 curved_weights(clast_weights at)
{
    return vec3(to_float(at.of[0]), to_float(at.of[1]), to_float(at.of[2])) * power_of_two(112u);
}

FN vec3 curved_point(const vec3 p[3], const vec3 n[3], clast_weights at) { return curved_position(p, n, curved_weights(at)); }

// ---------------------------------------------------------------------------------------------------------------- view

// What a clast_source_view comes to for rates.
RECORD(clast_rate_view)
{
    clast_transform to_camera;
    packed3 eye;
    uint metric;        // CLAST_METRIC_; PIXELS only where a single instance shows the unit
    uint parallel;      // rays are
    uint looks;         // 1 where edges may be taken for hidden
    uint faces;         // 1 where those that face away may
    packed2 extent;
    packed2 narrowing;  // over the extent: 0.5
    packed2 side_scale; // makes the distance from the planes of the sides out of coordinates
    float near_plane;   // at least EYE_NEAREST
    float pixels;
    float density;        // segments for each unit of the metric
    float hidden_density; // the same of what is not seen, for pixels in those of CLAST_METRIC_SPHERE
    float square_by_distance; // the square of the wanted spacing in the unit's own lengths: times a distance's square,
    float square;             // as it is,
    float square_by_edge;     // times the square of the shortest edge
    float deviation;          // clast_source_view has these
    packed2 places;
    packed2 places_by_slope;  // places across and up for each unit of what a coordinate is over the depth
    uint places_across;
    uint places_down;
    packed_address depths;
};
RECORD_SIZE(clast_rate_view, 48 + 12 + 16 + 24 + 4 * 7 + 36)

FN float squared(float x) { return x * x; }
FN float within_reach(float x) { return clamp1(x, 1e-30f, 1e30f); } // NaN gives the least
FN float root_of(float square)
{
    float sound = clamp1(square, 1e-36f, 1e36f);
    return sound * stable_rsqrt(sound);
}

FN float view_density(clast_source_view view) { return view.rate * stable_reciprocal(within_reach(view.segment)); }

// The mean square of what a length of the unit is in the world.
FN float view_scale_square(clast_source_view view)
{
    float sum = 0.0f;
    for (uint row = 0u; row < 3u; row++) {
        vec4 entries = load4(view.to_camera.rows[row]);
        sum += dot3(vec3(entries[0], entries[1], entries[2]), vec3(entries[0], entries[1], entries[2]));
    }
    return within_reach(sum * 0.333333333f);
}

// `closed`: what faces away is behind what does not. Views through a narrow angle would want more of all that they do not show
// than anybody sees in shadows: from a quarter of a right angle on, it stays as it is.
FN clast_rate_view rate_view(clast_source_view view, uint closed)
{
    clast_rate_view rates;
    vec2 extent = vec2(within_reach(load2(view.extent)[0]), within_reach(load2(view.extent)[1]));
    bool several = view.alone == 0u;
    bool hidden = view.hidden != 0u;
    bool pixels = view.metric == CLAST_METRIC_PIXELS;
    bool fixed_count = view.metric == CLAST_METRIC_FIXED;
    bool around = view.projection == CLAST_PROJECTION_PANORAMA;
    rates.to_camera = view.to_camera;
    rates.eye = view.eye;
    rates.metric = pixels && (several || hidden) ? CLAST_METRIC_SPHERE : view.metric;
    rates.parallel = view.projection == CLAST_PROJECTION_ORTHOGRAPHIC ? 1u : 0u;
    rates.looks = several || hidden || fixed_count || around ? 0u : 1u;
    rates.faces = rates.looks & closed;
    rates.extent = store2(extent);
    rates.narrowing = store2(vec2(0.5f * stable_reciprocal(extent[0]), 0.5f * stable_reciprocal(extent[1])));
    bool parallel = rates.parallel != 0u;
    vec2 inclined = vec2(stable_rsqrt(1.0f + squared(extent[0])), stable_rsqrt(1.0f + squared(extent[1])));
    rates.side_scale = store2(parallel ? splat2(1.0f) : inclined);
    rates.near_plane = within_reach(view.near_plane);
    rates.pixels = view.pixels;

    float density = view_density(view);
    float wide = parallel ? 1.0f : min1(1.0f, 5.0f * max1(extent[0], extent[1]));
    rates.hidden_density = density * view.hidden_fraction * (pixels ? wide : 1.0f);
    rates.density = fixed_count ? view.rate * view.segment : hidden ? rates.hidden_density : density;

    bool sphere = rates.metric == CLAST_METRIC_PIXELS || rates.metric == CLAST_METRIC_SPHERE;
    float unit = sphere ? rates.density * rates.pixels : rates.density;
    float spacing = stable_reciprocal(within_reach(unit));
    float spacing_square = within_reach(squared(spacing));
    float own_square = spacing_square * stable_reciprocal(view_scale_square(view));
    rates.square_by_distance = sphere && !parallel ? own_square : 0.0f;
    rates.square = fixed_count || (sphere && !parallel) ? 0.0f : own_square;
    rates.square_by_edge = fixed_count ? spacing_square : 0.0f;

    vec2 places = load2(view.places);
    rates.deviation = view.deviation;
    rates.places = view.places;
    rates.places_by_slope = store2(vec2(places[0] * load2(rates.narrowing)[0], places[1] * load2(rates.narrowing)[1]));
    rates.places_across = view.places_across;
    rates.places_down = view.places_down;
    rates.depths = view.depths;
    return rates;
}

// -------------------------------------------------------------------------------------------------------------- points

// The level of the map at a vertex, where texels are as long as the wanted segments, but for what its shortest edge would show at
// rest. `camera` is the vertex seen from the camera; the squares are of texels for each length, and of the edge.
FN float vertex_level(clast_rate_view view, vec3 camera, float density_square, float shortest_square)
{
    float distance_square = max1(dot3(camera, camera), squared(view.near_plane));
    float wanted = (distance_square * view.square_by_distance + view.square) + shortest_square * view.square_by_edge;
    float texels_square = density_square * min1(shortest_square, wanted);
    return height_level(clamp1(texels_square, power_of_two(27u), 1e30f), HEIGHT_LEVELS);
}

// At rest, in the same way: as coarse as ever.
FN float vertex_rest_level(float density_square, float shortest_square)
{
    return height_level(clamp1(density_square * shortest_square, power_of_two(27u), 1e30f), HEIGHT_LEVELS);
}

// An end or the middle of an edge, displaced, as rates need it.
RECORD(clast_rate_point)
{
    packed3 camera; // x to the right, y up, z forward
    packed2 screen; // pixels from the middle
    float facing;   // cosine between the normal and the way to the eye
};
RECORD_SIZE(clast_rate_point, 24)

// Within twice of what is seen each way, `screen` is the projection; beyond, it stays on that border, so that what lies beside
// or behind the camera has a size too.
FN clast_rate_point rate_point(clast_rate_view view, vec3 position, vec3 normal)
{
    clast_rate_point point;
    vec3 camera = transform_point(view.to_camera, position);
    point.camera = store3(camera);
    float sideways = max1(abs1(camera[0]) * load2(view.narrowing)[0], abs1(camera[1]) * load2(view.narrowing)[1]);
    float depth = within_reach(max1(max1(view.near_plane, camera[2]), sideways));
    float scale = view.parallel != 0u ? view.pixels : view.pixels * stable_reciprocal(depth);
    point.screen = store2(vec2(camera[0] * scale, camera[1] * scale));
    vec3 away = load3(view.eye) - position;
    float square = clamp1(dot3(away, away), 1e-36f, 1e36f);
    point.facing = dot3(normal, away) * stable_rsqrt(square);
    return point;
}

// --------------------------------------------------------------------------------------------------------------- edges

RECORD(clast_rate_edge)
{
    uint ends;    // two points, 8 bits each; the rest is the user's own
    float height; // of the middle, where the displacement's scale is 1
};
RECORD_SIZE(clast_rate_edge, 8)

FN float min_of_three(float a, float b, float c) { return min1(min1(a, b), c); }

// How far all of three points lie outside of a side of what is seen; negative within. `sign` is that of the side's axis.
FN float outside_side(clast_rate_view view, uint axis, float sign, vec3 a, vec3 middle, vec3 b)
{
    float extent = load2(view.extent)[axis];
    float least = min_of_three(sign * a[axis] - extent * (view.parallel != 0u ? 1.0f : a[2]),
                               sign * b[axis] - extent * (view.parallel != 0u ? 1.0f : b[2]),
                               sign * middle[axis] - extent * (view.parallel != 0u ? 1.0f : middle[2]));
    return least * load2(view.side_scale)[axis];
}

// 1 where an edge, or a triangle at it, may be seen, falling to 0 where neither is: behind the camera, beside the picture or
// facing away. A triangle is taken to reach as far from its edge as this is long; displacement may turn what faces away by 17
// degrees before it counts at all.
FN float edge_seen(clast_rate_view view, clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    vec3 ca = load3(a.camera);
    vec3 cm = load3(middle.camera);
    vec3 cb = load3(b.camera);
    float outside = view.near_plane - max1(max1(ca[2], cb[2]), cm[2]);
    outside = max1(outside, max1(outside_side(view, 0u, 1.0f, ca, cm, cb), outside_side(view, 0u, -1.0f, ca, cm, cb)));
    outside = max1(outside, max1(outside_side(view, 1u, 1.0f, ca, cm, cb), outside_side(view, 1u, -1.0f, ca, cm, cb)));
    vec3 chord = cb - ca;
    float reach = root_of(dot3(chord, chord));
    float breadth = max1(load2(view.extent)[0], load2(view.extent)[1]);
    float margin = 0.1f * breadth * (view.parallel != 0u ? 1.0f : max1(abs1(cm[2]), view.near_plane));
    float softness = within_reach(reach + margin);
    float within = clamp1(1.0f - (outside - reach) * stable_reciprocal(softness), 0.0f, 1.0f);
    float towards = max1(max1(a.facing, b.facing), middle.facing);
    float facing = clamp1((towards + 0.8f) * 2.0f, 0.0f, 1.0f);
    return within * (view.faces != 0u ? facing : 1.0f);
}

FN float edge_pixels(clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    vec2 first = load2(a.screen) - load2(middle.screen);
    vec2 second = load2(b.screen) - load2(middle.screen);
    return root_of(dot2(first, first)) + root_of(dot2(second, second));
}

FN float edge_length(clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    vec3 first = load3(a.camera) - load3(middle.camera);
    vec3 second = load3(b.camera) - load3(middle.camera);
    return root_of(dot3(first, first)) + root_of(dot3(second, second));
}

// Pixels of the edge's length where it is nearest, whichever way it runs.
FN float edge_sphere(clast_rate_view view, clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    float nearest = min1(dot3(load3(a.camera), load3(a.camera)), dot3(load3(b.camera), load3(b.camera)));
    float square = clamp1(max1(squared(view.near_plane), nearest), 1e-36f, 1e36f);
    float scale = view.parallel != 0u ? 1.0f : stable_rsqrt(square);
    return edge_length(a, middle, b) * view.pixels * scale;
}

// The wanted segments of the edge from a to b, as a fraction. `open` is 1 where nothing hides it, falling to 0 where all of it is
// hidden (shared/occlusion.h).
FN float edge_wanted(clast_rate_view view, clast_rate_point a, clast_rate_point middle, clast_rate_point b, float open)
{
    float seen = view.looks != 0u ? edge_seen(view, a, middle, b) * open : 1.0f;
    float wanted = view.density; // FIXED
    if (view.metric == CLAST_METRIC_PIXELS) {
        float shown = edge_pixels(a, middle, b) * view.density;
        float hidden = edge_sphere(view, a, middle, b) * view.hidden_density;
        wanted = seen < 1.0f ? shown * seen + hidden * (1.0f - seen) : shown;
    } else if (view.metric != CLAST_METRIC_FIXED) {
        float size = view.metric == CLAST_METRIC_SPHERE ? edge_sphere(view, a, middle, b) : edge_length(a, middle, b);
        wanted = size * (view.density * seen + view.hidden_density * (1.0f - seen));
    }
    return wanted;
}

// CLAST_METRIC_FIXED, of a part of an edge whose ends' weights are so far apart.
FN float edge_wanted_fixed(clast_rate_view view, uint apart) { return view.density * (to_float(apart) * power_of_two(112u)); }

// Rounded to at least 1, and to no more than fit between the weights of the edge's ends, `apart` of each other.
FN uint edge_factor(float wanted, uint apart)
{
    return to_uint(clamp1(wanted + 0.5f, 1.0f, to_float(apart * PATTERN_SEGMENTS)));
}

// -------------------------------------------------------------------------------------------------------------- splits

// Into how many parts an edge of more segments than a pattern has is split at once.
FN uint edge_splits(uint factor)
{
    return min_uint((factor + (PATTERN_SEGMENTS - 1u)) / PATTERN_SEGMENTS, PATTERN_SEGMENTS);
}

FN uint weight_apart(uint a, uint b) { return a < b ? b - a : a - b; }

// How far apart the weights of two corners are: at least 1 for corners that are not the same.
FN uint weights_apart(clast_weights a, clast_weights b)
{
    uint first = max_uint(weight_apart(a.of[0], b.of[0]), weight_apart(a.of[1], b.of[1]));
    return max_uint(max_uint(first, weight_apart(a.of[2], b.of[2])), 1u);
}

// A point between three corners, as weights of the base triangle: rounded, and the largest makes up what is missing.
FN clast_weights weights_within(clast_weights a, clast_weights b, clast_weights c, clast_weights at)
{
    clast_weights sum;
    for (uint k = 0u; k < 3u; k++) {
        uint products = a.of[k] * at.of[0] + b.of[k] * at.of[1] + c.of[k] * at.of[2];
        sum.of[k] = (products + WEIGHT_ONE / 2u) / WEIGHT_ONE;
    }
    uint total = sum.of[0] + sum.of[1] + sum.of[2];
    uint largest = sum.of[2] > max_uint(sum.of[0], sum.of[1]) ? 2u : sum.of[1] > sum.of[0] ? 1u : 0u;
    for (uint k = 0u; k < 3u; k++) {
        sum.of[k] = k == largest ? WEIGHT_ONE - (total - sum.of[k]) : sum.of[k];
    }
    return sum;
}

FN clast_weights weights_of_corner(uint corner)
{
    clast_weights weights;
    weights.of[0] = corner == 0u ? WEIGHT_ONE : 0u;
    weights.of[1] = corner == 1u ? WEIGHT_ONE : 0u;
    weights.of[2] = corner == 2u ? WEIGHT_ONE : 0u;
    return weights;
}

FN clast_weights weights_of_middle(clast_weights a, clast_weights b)
{
    clast_weights half_way;
    half_way.of[0] = WEIGHT_ONE / 2u;
    half_way.of[1] = WEIGHT_ONE / 2u;
    half_way.of[2] = 0u;
    return weights_within(a, b, b, half_way);
}

LIMIT(WEIGHTS_EDGE, 3u, "the place of points on edge 0")
LIMIT(WEIGHTS_INSIDE, 6u, "the place of points on no edge")

// The corner that has all the weight, WEIGHTS_EDGE and the edge that a point lies on, or WEIGHTS_INSIDE.
FN uint weights_place(clast_weights at)
{
    bool zero[3];
    for (uint k = 0u; k < 3u; k++) {
        zero[k] = at.of[k] == 0u;
    }
    uint corner = !zero[0] ? 0u : !zero[1] ? 1u : 2u;
    uint count = (zero[0] ? 1u : 0u) + (zero[1] ? 1u : 0u) + (zero[2] ? 1u : 0u);
    uint edge = zero[2] ? 0u : zero[0] ? 1u : 2u;
    return count >= 2u ? corner : count == 1u ? WEIGHTS_EDGE + edge : WEIGHTS_INSIDE;
}

#endif
