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

uint displaced_vertex_number(unit_reference unit, clast_displaced_cluster cluster, uint vertex)
{
    return uints(array_of(unit, DISPLACED_ARRAY_VERTEX_NUMBERS)).at[cluster.first_vertex + vertex];
}

// A vertex of the welded mesh, with the position and the normal that a pose gives it: where there is one, the array is another.
clast_displaced_vertex displaced_vertex_at(unit_reference unit, uint number)
{
    return displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES)).at[number];
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

displaced_face displaced_face_from(unit_reference unit, clast_displaced_cluster cluster, uint number,
                                   clast_displaced_vertex vertices[3])
{
    displaced_face face;
    face.triangle = displaced_triangle_of(unit, cluster, number);
    face.plain = displaced_is_plain(face.triangle);
    face.map = vertices[0].map;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        face.positions[k] = load3(vertices[k].position);
        face.normals[k] = load3(vertices[k].normal);
        face.coordinates[k] = load2(vertices[k].coordinates);
        face.density_squares[k] = vertices[k].density_square;
        face.shortest_squares[k] = vertices[k].shortest_square;
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

displaced_face displaced_face_of(unit_reference unit, clast_displaced_cluster cluster, uint number)
{
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, number);
    clast_displaced_vertex vertices[3];
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        vertices[k] = displaced_vertex_at(unit, displaced_vertex_number(unit, cluster, displaced_corner(triangle, k)));
    }
    return displaced_face_from(unit, cluster, number, vertices);
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

// What displaces points of an edge of a triangle, or of the triangle.
struct displaced_place_site
{
    uint map;
    bool has_seam;
    uint first, second; // corners of the triangle between which it runs
    vec2 ends[2];       // coordinates at them
};

// Of the edge `place` - WEIGHTS_EDGE or, for WEIGHTS_INSIDE, of the triangle.
displaced_place_site displaced_site_in(unit_reference unit, clast_displaced_cluster cluster, displaced_face face, uint place)
{
    displaced_place_site site;
    site.map = face.map;
    site.has_seam = false;
    site.first = 0u;
    site.second = 0u;
    site.ends[0] = splat2(0.0f);
    site.ends[1] = splat2(0.0f);
    if (!face.plain && place < WEIGHTS_INSIDE) {
        uint edge = place - WEIGHTS_EDGE;
        uint number = displaced_seam_of(displaced_edge_at(unit, cluster, displaced_edge_of(face.triangle, edge)));
        if (number != DISPLACED_NO_SEAM) {
            clast_displaced_seam seam =
                displaced_seams(array_of(unit, DISPLACED_ARRAY_SEAMS)).at[cluster.first_seam + number];
            bool along = displaced_goes_along(face.triangle, edge);
            site.map = seam.map;
            site.has_seam = true;
            site.first = edge;
            site.second = edge == 2u ? 0u : edge + 1u;
            site.ends[0] = along ? load2(seam.coordinates[0]) : load2(seam.coordinates[1]);
            site.ends[1] = along ? load2(seam.coordinates[1]) : load2(seam.coordinates[0]);
        }
    }
    return site;
}

FN vec2 displaced_coordinates_in(displaced_face face, displaced_place_site site, clast_weights at)
{
    vec2 blended = displaced_face_coordinates(face, at);
    vec2 between = displaced_seam_blend(site.ends[0], site.ends[1], displaced_weight(at, site.first),
                                        displaced_weight(at, site.second));
    return site.has_seam ? between : blended;
}

// A point's, as part of a place.
displaced_site displaced_site_within(unit_reference unit, clast_displaced_cluster cluster, displaced_face face,
                                     clast_weights at, uint place)
{
    displaced_place_site in_place = displaced_site_in(unit, cluster, face, place);
    displaced_site site;
    site.map = in_place.map;
    site.coordinates = displaced_coordinates_in(face, in_place, at);
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
