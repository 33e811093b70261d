// SPDX-License-Identifier: Apache-2.0
// Vertices of displaced meshes in a pose: the twin of clast_displaced_position() and clast_displaced_normal().
#ifndef CLAST_SOURCE_DISPLACED_POSE_GLSL
#define CLAST_SOURCE_DISPLACED_POSE_GLSL

#include "source/displaced_mesh.glsl"

#define SOURCE_HAS_POSED_ARRAY

ARRAY_OF(displaced_normals, clast_displaced_normal_part, 8)

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

void source_pose(unit_reference unit, uint number, uint64_t to)
{
    displaced_vertices vertices = displaced_vertices(array_of(unit, DISPLACED_ARRAY_VERTICES));
    clast_displaced_vertex vertex = vertices.at[number];
    if (vertex.mesh_vertex != CLAST_NONE) { // else it is the one that ends the array
        uint64_t positions = load_address(unit.of.positions);
        if (positions != 0ul) {
            vertex.position = store3(mesh_value3(positions, vertex.mesh_vertex, 3u));
        }
        vertex.normal = store3(displaced_posed_normal(unit, number));
    }
    displaced_vertices(to).at[number] = vertex;
}

#endif
