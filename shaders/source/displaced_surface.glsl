// SPDX-License-Identifier: Apache-2.0
// Points of displaced surfaces: where a hit is on the mesh, and what is there. The twin of src/source/displaced_surface.c.
#ifndef CLAST_SOURCE_DISPLACED_SURFACE_GLSL
#define CLAST_SOURCE_DISPLACED_SURFACE_GLSL

#include "shared/occlusion.h"
#include "source/displaced_reader.glsl"

// ------------------------------------------------------------------------------------------------------------- locate

// A point of a base triangle.
struct displaced_base_point
{
    uint triangle; // of the cluster
    vec3 weights;
    float level;
};

// Of the leaf's corners, in the base triangle.
FN vec3 displaced_weights_in_base(displaced_leaf leaf, vec3 at)
{
    if (!displaced_leaf_is_split(leaf.word)) {
        return at;
    }
    vec3 sum = splat3(0.0f);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        clast_weights corner = leaf.corners[k];
        vec3 weights = vec3(to_float(corner.of[0]), to_float(corner.of[1]), to_float(corner.of[2]));
        sum += weights * (at[k] * power_of_two(112u));
    }
    return sum;
}

FN float displaced_blend_levels(float a, float b, float c, vec3 weights)
{
    return ((0.0f + a * weights[0]) + b * weights[1]) + c * weights[2];
}

// Of a record that is the cluster as it was cooked.
displaced_base_point displaced_cooked_point(unit_reference unit, clast_displaced_cluster cluster, uint64_t words,
                                            uint triangle, vec3 within)
{
    clast_displaced_triangle corners = displaced_triangle_of(unit, cluster, triangle);
    uint64_t levels = displaced_levels_of(unit, words);
    displaced_base_point point;
    point.triangle = triangle;
    point.weights = within;
    point.level = displaced_blend_levels(displaced_vertex_level_of(levels, displaced_corner(corners, 0u)),
                                         displaced_vertex_level_of(levels, displaced_corner(corners, 1u)),
                                         displaced_vertex_level_of(levels, displaced_corner(corners, 2u)), within);
    return point;
}

// The weights of a pattern's vertex as numbers up to 1, of the leaf's corners.
FN vec3 displaced_vertex_weights(unit_reference unit, clast_pattern pattern, uint rotation, uint vertex)
{
    clast_weights at = pattern_unrotate(weights_of(displaced_pattern_vertex(unit, pattern, vertex)), rotation);
    return vec3(to_float(at.of[0]), to_float(at.of[1]), to_float(at.of[2])) * power_of_two(112u);
}

// A point of a pattern's triangle, of the leaf's corners.
FN vec3 displaced_weights_in_leaf(unit_reference unit, clast_pattern pattern, uint rotation, uint corners, vec3 within)
{
    vec3 a = displaced_vertex_weights(unit, pattern, rotation, corners & 255u);
    vec3 b = displaced_vertex_weights(unit, pattern, rotation, corners >> 8u & 255u);
    vec3 c = displaced_vertex_weights(unit, pattern, rotation, corners >> 16u & 255u);
    return ((splat3(0.0f) + a * within[0]) + b * within[1]) + c * within[2];
}

displaced_base_point displaced_find_point(unit_reference unit, clast_displaced_cluster cluster,
                                          clast_cluster_record record, uint64_t words, uint triangle, vec2 barycentrics)
{
    vec3 within = mesh_weights(barycentrics);
    if (record.detail == 0u) {
        return displaced_cooked_point(unit, cluster, words, triangle, within);
    }
    uint number = displaced_find_leaf(words, record.detail, triangle);
    displaced_leaf leaf = displaced_read_leaf(unit, cluster, words, record.detail, number,
                                              displaced_splits_before(words, number));
    clast_pattern_use use = pattern_use(displaced_leaf_factors(leaf.word));
    clast_pattern pattern = displaced_pattern_at(unit, use.number);
    uint corners = displaced_pattern_triangle(unit, pattern, triangle - displaced_leaf_first(leaf.word));
    vec3 at = displaced_weights_in_leaf(unit, pattern, use.rotation, corners, within);
    displaced_base_point point;
    point.triangle = displaced_leaf_triangle(leaf.word);
    point.weights = displaced_weights_in_base(leaf, at);
    point.level = displaced_blend_levels(leaf.levels[0], leaf.levels[1], leaf.levels[2], at);
    return point;
}

clast_surface_point locate_displaced(unit_reference unit, clast_cluster_record record, uint64_t words, uint triangle,
                                     vec2 barycentrics)
{
    clast_displaced_cluster cluster = displaced_cluster_of(unit, record.item);
    displaced_base_point found = displaced_find_point(unit, cluster, record, words, triangle, barycentrics);
    clast_surface_point point;
    point.primitive = uints(array_of(unit, DISPLACED_ARRAY_MESH_TRIANGLES)).at[cluster.first_triangle + found.triangle];
    point.coordinates = store2(vec2(found.weights[1], found.weights[2]));
    point.level = found.level;
    return point;
}

// ----------------------------------------------------------------------------------------------------------- segments

FN clast_rate_point displaced_end_point(clast_rate_view view, clast_displaced_vertex vertex, float scale)
{
    vec3 normal = load3(vertex.normal);
    return rate_point(view, displaced_point(load3(vertex.position), normal, vertex.height * scale), normal);
}

// How far an edge is from lying behind what the frame's depths tell of: clast_rate_open().
FN float displaced_edge_open(clast_rate_view view, clast_rate_point a, clast_rate_point middle, clast_rate_point b)
{
    uint64_t address = load_address(view.depths);
    if (view.looks == 0u || address == 0ul) {
        return 1.0f;
    }
    clast_edge_place edge = edge_place(view, a, middle, b);
    floats depths = floats(address);
    uint first = edge.place * OCCLUSION_DEPTHS;
    float radius = 0.0f;
    [[dont_unroll]] for (uint i = 0u; i < OCCLUSION_DEPTHS; i++) {
        radius += occlusion_part(edge, depths.at[first + i], i);
    }
    return occlusion_open(edge, radius);
}

// clast_displaced_wanted()
FN float displaced_wanted(unit_reference unit, clast_displaced_cluster cluster, clast_rate_view view, uint number)
{
    clast_rate_edge edge = displaced_edge_at(unit, cluster, number);
    float scale = unit.of.displacement_scale;
    clast_displaced_vertex a = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, edge.ends & 255u));
    clast_displaced_vertex b = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, edge.ends >> 8u & 255u));
    vec3 normal = (load3(a.normal) + load3(b.normal)) * 0.5f;
    vec3 middle = displaced_middle(load3(a.position), load3(b.position), load3(a.normal), load3(b.normal),
                                   displaced_is_curved(unit));
    clast_rate_point between = rate_point(view, displaced_point(middle, normal, edge.height * scale), normal);
    clast_rate_point first = displaced_end_point(view, a, scale);
    clast_rate_point second = displaced_end_point(view, b, scale);
    return edge_wanted(view, first, between, second, displaced_edge_open(view, first, between, second));
}

// clast_displaced_rate_view()
clast_rate_view displaced_rate_view(unit_reference unit, clast_source_view view)
{
    clast_displaced_header header = displaced_headers(array_of(unit, DISPLACED_ARRAY_HEADER)).at[0];
    bool still = !displaced_is_posed(unit);
    return rate_view(view, displaced_faces(header, unit.of.displacement_scale, load3(view.eye), still));
}

float segments_displaced(unit_reference unit, clast_source_view view, clast_cluster_record record, uint64_t words,
                         uint triangle, vec2 barycentrics)
{
    clast_displaced_cluster cluster = displaced_cluster_of(unit, record.item);
    displaced_base_point at = displaced_find_point(unit, cluster, record, words, triangle, barycentrics);
    vec3 w = at.weights;
    uint opposite = w[0] < w[1] ? (w[0] < w[2] ? 0u : 2u) : (w[1] < w[2] ? 1u : 2u);
    clast_displaced_triangle corners = displaced_triangle_of(unit, cluster, at.triangle);
    return displaced_wanted(unit, cluster, displaced_rate_view(unit, view), displaced_edge_of(corners, (opposite + 1u) % 3u));
}

// ----------------------------------------------------------------------------------------------------------- evaluate

// A mesh's triangle with what its points are blended from.
struct displaced_base_triangle
{
    uvec3 vertices;
    vec3 weights;
    vec3 positions[3];
    vec3 normals[3];
    uint map;
};

displaced_base_triangle displaced_base_triangle_at(unit_reference unit, clast_surface_point point)
{
    displaced_base_triangle triangle;
    triangle.vertices = mesh_corners(unit, point.primitive);
    triangle.weights = mesh_weights(load2(point.coordinates));
    triangle.map = displaced_map_of(unit, point.primitive);
    uints vertex_of = uints(array_of(unit, DISPLACED_ARRAY_VERTEX_OF));
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        clast_displaced_vertex vertex = displaced_vertex_at(unit, vertex_of.at[triangle.vertices[k]]);
        triangle.positions[k] = load3(vertex.position);
        triangle.normals[k] = load3(vertex.normal);
    }
    return triangle;
}

FN vec3 displaced_posed_slope(unit_reference unit, displaced_base_triangle triangle, vec3 slope)
{
    uint64_t rest = array_of(unit, MESH_ARRAY_POSITIONS);
    vec3 origin = mesh_value3(rest, triangle.vertices[0], 3u);
    return displaced_posed_gradient(slope, mesh_value3(rest, triangle.vertices[1], 3u) - origin,
                                    mesh_value3(rest, triangle.vertices[2], 3u) - origin,
                                    triangle.positions[1] - triangle.positions[0],
                                    triangle.positions[2] - triangle.positions[0]);
}

// The slope of the height along the surface: a vector towards which it grows, by how much for each length. The map's own
// derivatives jump from texel to texel; differences over a texel do not.
FN vec3 displaced_slope_at(unit_reference unit, displaced_base_triangle triangle, vec2 coordinates, float level)
{
    clast_displaced_map map = displaced_map_at(unit, triangle.map);
    device_heights heights = device_heights(load_address(unit.of.heights));
    vec2 texel = displaced_half_texel(exp2(level), heights.at[triangle.map].map.widths[0],
                                      heights.at[triangle.map].map.heights[0]);
    vec2 right = vec2(texel[0], 0.0f);
    vec2 below = vec2(0.0f, texel[1]);
    float across = displaced_value(unit, triangle.map, coordinates + right, level) -
                   displaced_value(unit, triangle.map, coordinates - right, level);
    float down = displaced_value(unit, triangle.map, coordinates + below, level) -
                 displaced_value(unit, triangle.map, coordinates - below, level);
    vec2 by_mesh = displaced_mesh_slope(map, map.scale * unit.of.displacement_scale, across, down, texel);
    displaced_gradients gradients = displaced_gradients(array_of(unit, DISPLACED_ARRAY_GRADIENTS_0 + map.coordinate_set));
    vec3 u = splat3(0.0f);
    vec3 v = splat3(0.0f);
    for (uint k = 0u; k < 3u; k++) {
        clast_displaced_gradient gradient = gradients.at[triangle.vertices[k]];
        u += load3(gradient.u) * triangle.weights[k];
        v += load3(gradient.v) * triangle.weights[k];
    }
    vec3 slope = u * by_mesh[0] + v * by_mesh[1];
    return load_address(unit.of.positions) != 0ul ? displaced_posed_slope(unit, triangle, slope) : slope;
}

FN vec2 displaced_coordinates_at(unit_reference unit, displaced_base_triangle triangle)
{
    clast_displaced_map map = displaced_map_at(unit, triangle.map);
    uint64_t values = array_of(unit, MESH_ARRAY_COORDINATES_0 + map.coordinate_set);
    vec2 coordinates = splat2(0.0f);
    for (uint k = 0u; k < 3u; k++) {
        vec2 own = displaced_coordinates(map, mesh_value2(values, triangle.vertices[k]));
        coordinates += own * triangle.weights[k];
    }
    return coordinates;
}

source_surface evaluate_displaced(unit_reference unit, clast_surface_point point)
{
    source_surface surface = mesh_evaluate(unit, point);
    displaced_base_triangle triangle = displaced_base_triangle_at(unit, point);
    vec3 flat_normal = displaced_unit_or(surface.geometric_normal, splat3(0.0f));
    vec3 blended = mesh_blend3(triangle.normals[0], triangle.normals[1], triangle.normals[2], triangle.weights);
    vec3 towards = displaced_unit_or(blended, splat3(0.0f));
    surface.position = displaced_is_curved(unit)
                           ? curved_position(triangle.positions, triangle.normals, triangle.weights)
                           : mesh_blend3(triangle.positions[0], triangle.positions[1], triangle.positions[2], triangle.weights);
    if (triangle.map == DISPLACED_NO_MAP) {
        return surface;
    }
    vec2 coordinates = displaced_coordinates_at(unit, triangle);
    surface.position += towards * displaced_height(unit, triangle.map, coordinates, point.level);
    vec3 slope = displaced_slope_at(unit, triangle, coordinates, point.level);
    surface.geometric_normal = displaced_geometric_normal(towards, flat_normal, slope);
    surface.normal = displaced_shading_normal(surface.normal, towards, flat_normal, slope);
    return surface;
}

#endif
