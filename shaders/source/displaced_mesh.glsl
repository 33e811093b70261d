// SPDX-License-Identifier: Apache-2.0
// Displaced meshes as they lie in a device's memory: vertices in a pose, patterns, maps, and triangles with all that their
// points are blended from. The twin of what src/source/displaced.h declares, and of src/source/height.c.
#ifndef CLAST_SOURCE_DISPLACED_MESH_GLSL
#define CLAST_SOURCE_DISPLACED_MESH_GLSL

#include "shared/displaced.h"
#include "source/mesh.glsl"

ARRAY_OF(displaced_headers, clast_displaced_header, 4)
ARRAY_OF(displaced_clusters, clast_displaced_cluster, 16)
ARRAY_OF(displaced_triangles, clast_displaced_triangle, 8)
ARRAY_OF(displaced_edges, clast_rate_edge, 8)
ARRAY_OF(displaced_seams, clast_displaced_seam, 4)
ARRAY_OF(displaced_vertices, clast_displaced_vertex, 16)
ARRAY_OF(displaced_normals, clast_displaced_normal_part, 8)
ARRAY_OF(displaced_gradients, clast_displaced_gradient, 8)
ARRAY_OF(displaced_maps, clast_displaced_map, 8)
ARRAY_OF(displaced_patterns, clast_pattern, 4)

uint displaced_flags(unit_reference unit)
{
    return displaced_headers(array_of(unit, DISPLACED_ARRAY_HEADER)).at[0].flags;
}

bool displaced_is_curved(unit_reference unit) { return (displaced_flags(unit) & DISPLACED_CURVED) != 0u; }
bool displaced_is_moved(unit_reference unit) { return (displaced_flags(unit) & DISPLACED_MOVED) != 0u; }

// What a pose moves has positions or normals of its own.
bool displaced_is_posed(unit_reference unit)
{
    return load_address(unit.of.positions) != 0ul || load_address(unit.of.normals) != 0ul;
}

clast_displaced_cluster displaced_cluster_of(unit_reference unit, uint item)
{
    return displaced_clusters(array_of(unit, DISPLACED_ARRAY_CLUSTERS)).at[item];
}

clast_displaced_triangle displaced_triangle_of(unit_reference unit, clast_displaced_cluster cluster, uint number)
{
    return displaced_triangles(array_of(unit, DISPLACED_ARRAY_TRIANGLES)).at[cluster.first_triangle + number];
}

clast_rate_edge displaced_edge_at(unit_reference unit, clast_displaced_cluster cluster, uint number)
{
    return displaced_edges(array_of(unit, DISPLACED_ARRAY_EDGES)).at[cluster.first_edge + number];
}

// ----------------------------------------------------------------------------------------------------------- patterns

clast_pattern displaced_pattern_at(unit_reference unit, uint number)
{
    return displaced_patterns(array_of(unit, DISPLACED_ARRAY_PATTERNS)).at[number];
}

uint displaced_pattern_vertex(unit_reference unit, clast_pattern pattern, uint vertex)
{
    return uints(array_of(unit, DISPLACED_ARRAY_PATTERN_VERTICES)).at[pattern.first_vertex + vertex];
}

uint displaced_pattern_triangle(unit_reference unit, clast_pattern pattern, uint triangle)
{
    return uints(array_of(unit, DISPLACED_ARRAY_PATTERN_TRIANGLES)).at[pattern.first_triangle + triangle];
}

// The weight of a corner, without an index into registers.
FN uint displaced_weight(clast_weights at, uint corner)
{
    return corner == 0u ? at.of[0] : corner == 1u ? at.of[1] : at.of[2];
}

// ----------------------------------------------------------------------------------------------------------- vertices

FN vec3 displaced_posed_vertex_normal(unit_reference unit, uint vertex)
{
    return stable_normalize3(mesh_value3(mesh_normals(unit), vertex, 3u));
}

FN vec3 displaced_posed_triangle_normal(unit_reference unit, uint triangle)
{
    uvec3 corners = mesh_corners(unit, triangle);
    uint64_t positions = mesh_positions(unit);
    return displaced_triangle_normal(mesh_value3(positions, corners[0], 3u), mesh_value3(positions, corners[1], 3u),
                                     mesh_value3(positions, corners[2], 3u));
}

// clast_displaced_normal() of what a pose moves.
FN vec3 displaced_posed_normal(unit_reference unit, uint number)
{
    displaced_vertices vertices = displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES));
    displaced_normals parts = displaced_normals(array_of(unit, DISPLACED_ARRAY_NORMALS));
    bool by_vertex = array_of(unit, MESH_ARRAY_NORMALS) != 0ul;
    uint first = vertices.at[number].first_normal;
    uint end = vertices.at[number + 1u].first_normal;
    vec3 sum = splat3(0.0f);
    for (uint i = first; i < end; i++) {
        clast_displaced_normal_part part = parts.at[i];
        vec3 normal = by_vertex ? displaced_posed_vertex_normal(unit, part.number)
                                : displaced_posed_triangle_normal(unit, part.number);
        sum += normal * part.weight;
    }
    return first == end ? displaced_posed_vertex_normal(unit, vertices.at[number].mesh_vertex) : stable_normalize3(sum);
}

uint displaced_vertex_number(unit_reference unit, clast_displaced_cluster cluster, uint vertex)
{
    return uints(array_of(unit, DISPLACED_ARRAY_VERTEX_NUMBERS)).at[cluster.first_vertex + vertex];
}

// A vertex of the welded mesh, with the position and the normal that a pose gives it.
clast_displaced_vertex displaced_vertex_at(unit_reference unit, uint number)
{
    clast_displaced_vertex vertex = displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES)).at[number];
    if (displaced_is_posed(unit)) {
        uint64_t positions = load_address(unit.of.positions);
        if (positions != 0ul) {
            vertex.position = store3(mesh_value3(positions, vertex.mesh_vertex, 3u));
        }
        vertex.normal = store3(displaced_posed_normal(unit, number));
    }
    return vertex;
}

// ---------------------------------------------------------------------------------------------------------------- maps

// The map of a triangle of the mesh.
uint displaced_map_of(unit_reference unit, uint mesh_triangle)
{
    return uints(array_of(unit, DISPLACED_ARRAY_MAP_OF_MATERIAL)).at[mesh_material(unit, mesh_triangle)];
}

clast_displaced_map displaced_map_at(unit_reference unit, uint map)
{
    return displaced_maps(array_of(unit, DISPLACED_ARRAY_MAPS)).at[map];
}

// A texel, and the one after it.
FN vec2 displaced_texels(uint64_t texels, bool are_floats, uint first)
{
    if (are_floats) {
        floats values = floats(texels);
        return vec2(values.at[first], values.at[first + 1u]);
    }
    uints words = uints(texels);
    uint word = words.at[first >> 1u];
    bool odd = (first & 1u) != 0u;
    uint next = odd ? words.at[(first >> 1u) + 1u] & 65535u : word >> 16u;
    return vec2(to_float(odd ? word >> 16u : word & 65535u), to_float(next));
}

FN float displaced_value_in_level(device_heights heights, uint map, uint level, vec2 wrapped)
{
    uint64_t texels = load_address(heights.at[map].texels);
    bool are_floats = heights.at[map].map.is_float != 0u;
    clast_height_texels place = height_texels_in(heights.at[map].map.firsts[level], heights.at[map].map.widths[level],
                                                 heights.at[map].map.heights[level], wrapped);
    vec2 upper = displaced_texels(texels, are_floats, place.upper);
    vec2 lower = displaced_texels(texels, are_floats, place.lower);
    return height_bilinear(place, upper[0], upper[1], lower[0], lower[1]);
}

// clast_height_value(): of a map that is there.
FN float displaced_value(unit_reference unit, uint map, vec2 coordinates, float level)
{
    device_heights heights = device_heights(load_address(unit.of.heights));
    clast_height_levels levels = height_levels_of(heights.at[map].map.level_count, level);
    vec2 wrapped = vec2(wrap_coordinate(coordinates[0], heights.at[map].map.wrap_u),
                        wrap_coordinate(coordinates[1], heights.at[map].map.wrap_v));
    float value = displaced_value_in_level(heights, map, levels.finer, wrapped);
    if (levels.weight != 0.0f) { // else the finer counts alone, exactly
        float coarser = displaced_value_in_level(heights, map, levels.coarser, wrapped);
        value = height_between(value, coarser, levels.weight);
    }
    return value * heights.at[map].map.unit;
}

// The height of a point in the pose.
FN float displaced_height(unit_reference unit, uint map, vec2 coordinates, float level)
{
    if (map == DISPLACED_NO_MAP) {
        return 0.0f;
    }
    clast_displaced_map use = displaced_map_at(unit, map);
    float scale = use.scale * unit.of.displacement_scale;
    float offset = use.offset * unit.of.displacement_scale;
    return displaced_value(unit, map, coordinates, level) * scale + offset;
}

// --------------------------------------------------------------------------------------------------------------- faces

// What displaces a point.
struct displaced_site
{
    uint map;
    vec2 coordinates;
};

// A triangle of a cluster with all that its points are blended from.
struct displaced_face
{
    clast_displaced_triangle triangle;
    vec3 positions[3];
    vec3 normals[3];
    vec2 coordinates[3]; // its own
    uint map;
    bool plain;
    float density_squares[3];
    float shortest_squares[3];
};

displaced_face displaced_face_of(unit_reference unit, clast_displaced_cluster cluster, uint number)
{
    displaced_face face;
    face.triangle = displaced_triangle_of(unit, cluster, number);
    face.plain = displaced_is_plain(face.triangle);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        uint vertex_number = displaced_vertex_number(unit, cluster, displaced_corner(face.triangle, k));
        clast_displaced_vertex vertex = displaced_vertex_at(unit, vertex_number);
        face.positions[k] = load3(vertex.position);
        face.normals[k] = load3(vertex.normal);
        face.coordinates[k] = load2(vertex.coordinates);
        face.map = k == 0u ? vertex.map : face.map;
        face.density_squares[k] = vertex.density_square;
        face.shortest_squares[k] = vertex.shortest_square;
    }
    if (!face.plain) {
        uint mesh_triangle = uints(array_of(unit, DISPLACED_ARRAY_MESH_TRIANGLES)).at[cluster.first_triangle + number];
        face.map = displaced_map_of(unit, mesh_triangle);
        clast_displaced_map use = displaced_map_at(unit, face.map);
        uint64_t coordinates = array_of(unit, MESH_ARRAY_COORDINATES_0 + use.coordinate_set);
        uvec3 corners = mesh_corners(unit, mesh_triangle);
        [[unroll]] for (uint k = 0u; k < 3u; k++) {
            face.coordinates[k] = coordinates != 0ul ? displaced_coordinates(use, mesh_value2(coordinates, corners[k]))
                                                     : splat2(0.0f);
        }
    }
    return face;
}

FN vec3 displaced_base(displaced_face face, clast_weights at, bool curved)
{
    return curved ? curved_point(face.positions, face.normals, at)
                  : blend3(face.positions[0], face.positions[1], face.positions[2], at);
}

FN vec3 displaced_face_normal(displaced_face face, clast_weights at)
{
    return blend3(face.normals[0], face.normals[1], face.normals[2], at);
}

FN vec2 displaced_face_coordinates(displaced_face face, clast_weights at)
{
    return blend2(face.coordinates[0], face.coordinates[1], face.coordinates[2], at);
}

FN vec2 displaced_seam_coordinates(clast_displaced_seam seam, bool along, uint first, uint second)
{
    vec2 a = load2(seam.coordinates[0]);
    vec2 b = load2(seam.coordinates[1]);
    return along ? displaced_seam_blend(a, b, first, second) : displaced_seam_blend(b, a, first, second);
}

// A point's, as part of the edge `place` - WEIGHTS_EDGE or, for WEIGHTS_INSIDE, of the triangle.
displaced_site displaced_site_within(unit_reference unit, clast_displaced_cluster cluster, displaced_face face,
                                     clast_weights at, uint place)
{
    displaced_site site;
    site.map = face.map;
    site.coordinates = displaced_face_coordinates(face, at);
    if (!face.plain && place < WEIGHTS_INSIDE) {
        uint edge = place - WEIGHTS_EDGE;
        uint seam = displaced_seam_of(displaced_edge_at(unit, cluster, displaced_edge_of(face.triangle, edge)));
        if (seam != DISPLACED_NO_SEAM) {
            clast_displaced_seam of = displaced_seams(array_of(unit, DISPLACED_ARRAY_SEAMS)).at[cluster.first_seam + seam];
            site.map = of.map;
            site.coordinates = displaced_seam_coordinates(of, displaced_goes_along(face.triangle, edge),
                                                          displaced_weight(at, edge),
                                                          displaced_weight(at, edge == 2u ? 0u : edge + 1u));
        }
    }
    return site;
}

// A point's by its owner: that of a vertex, an edge or the triangle.
displaced_site displaced_site_of(unit_reference unit, clast_displaced_cluster cluster, displaced_face face, clast_weights at)
{
    uint place = weights_place(at);
    if (place >= WEIGHTS_EDGE) {
        return displaced_site_within(unit, cluster, face, at, place);
    }
    uint number = displaced_vertex_number(unit, cluster, displaced_corner(face.triangle, place));
    displaced_vertices vertices = displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES));
    displaced_site site;
    site.map = vertices.at[number].map;
    site.coordinates = load2(vertices.at[number].coordinates);
    return site;
}

// Coordinates that are blended from one point alone: what is not finite becomes what it does on the processor.
FN vec2 displaced_alone(vec2 coordinates) { return blend2(coordinates, coordinates, coordinates, weights_of_corner(0u)); }

// A point moved by what displaces it.
FN vec3 displaced_moved(unit_reference unit, displaced_site site, vec3 position, vec3 normal, float level)
{
    return displaced_point(position, normal, displaced_height(unit, site.map, site.coordinates, level));
}

#endif
