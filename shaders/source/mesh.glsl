// SPDX-License-Identifier: Apache-2.0
// What sources that are made of triangle meshes have in common: the twin of src/source/mesh.h.
#ifndef CLAST_SOURCE_MESH_GLSL
#define CLAST_SOURCE_MESH_GLSL

#include "shared/mesh_surface.h"
#include "source/source.glsl"

// Where the positions, normals and tangents are: the pose's, where something moves them.
uint64_t mesh_positions(unit_reference unit)
{
    uint64_t posed = load_address(unit.of.positions);
    return posed != 0ul ? posed : array_of(unit, MESH_ARRAY_POSITIONS);
}

uint64_t mesh_normals(unit_reference unit)
{
    uint64_t posed = load_address(unit.of.normals);
    return posed != 0ul ? posed : array_of(unit, MESH_ARRAY_NORMALS);
}

uint64_t mesh_tangents(unit_reference unit)
{
    uint64_t posed = load_address(unit.of.tangents);
    return posed != 0ul ? posed : array_of(unit, MESH_ARRAY_TANGENTS);
}

uvec3 mesh_corners(unit_reference unit, uint triangle)
{
    uints indices = uints(array_of(unit, MESH_ARRAY_INDICES) + 12ul * uint64_t(triangle));
    return uvec3(indices.at[0], indices.at[1], indices.at[2]);
}

uint mesh_material(unit_reference unit, uint triangle)
{
    uint64_t materials = array_of(unit, MESH_ARRAY_MATERIALS);
    uint material = materials != 0ul ? uints(materials).at[triangle]
                                     : uints(array_of(unit, MESH_ARRAY_MATERIAL)).at[0];
    return material != CLAST_NONE ? material : 0u;
}

vec2 mesh_value2(uint64_t values, uint vertex)
{
    floats value = floats(values + 8ul * uint64_t(vertex));
    return vec2(value.at[0], value.at[1]);
}

// The first three of `stride` floats of each vertex.
vec3 mesh_value3(uint64_t values, uint vertex, uint stride)
{
    floats value = floats(values + 4ul * uint64_t(stride) * uint64_t(vertex));
    return vec3(value.at[0], value.at[1], value.at[2]);
}

vec4 mesh_value4(uint64_t values, uint vertex)
{
    floats value = floats(values + 16ul * uint64_t(vertex));
    return vec4(value.at[0], value.at[1], value.at[2], value.at[3]);
}

vec2 mesh_blended2(uint64_t values, uvec3 corners, vec3 weights)
{
    return mesh_blend2(mesh_value2(values, corners[0]), mesh_value2(values, corners[1]),
                       mesh_value2(values, corners[2]), weights);
}

vec3 mesh_blended3(uint64_t values, uvec3 corners, uint stride, vec3 weights)
{
    return mesh_blend3(mesh_value3(values, corners[0], stride), mesh_value3(values, corners[1], stride),
                       mesh_value3(values, corners[2], stride), weights);
}

vec4 mesh_blended4(uint64_t values, uvec3 corners, vec3 weights)
{
    return mesh_blend4(mesh_value4(values, corners[0]), mesh_value4(values, corners[1]),
                       mesh_value4(values, corners[2]), weights);
}

clast_mesh_texture mesh_texture_of(unit_reference unit, uint set, uvec3 corners)
{
    uint64_t values = array_of(unit, MESH_ARRAY_COORDINATES_0 + set);
    vec2 zero = vec2(0.0f, 0.0f);
    bool there = values != 0ul;
    return mesh_texture(there ? mesh_value2(values, corners[0]) : zero, there ? mesh_value2(values, corners[1]) : zero,
                        there ? mesh_value2(values, corners[2]) : zero);
}

// The vertex colour at a point, and its texture coordinates of a set.
vec4 mesh_colour(unit_reference unit, uvec3 corners, vec3 weights)
{
    uint64_t values = array_of(unit, MESH_ARRAY_COLOURS);
    return values != 0ul ? mesh_blended4(values, corners, weights) : vec4(1.0f, 1.0f, 1.0f, 1.0f);
}

vec2 mesh_coordinates(unit_reference unit, uint set, uvec3 corners, vec3 weights)
{
    uint64_t values = array_of(unit, MESH_ARRAY_COORDINATES_0 + set);
    return values != 0ul ? mesh_blended2(values, corners, weights) : vec2(0.0f, 0.0f);
}

void mesh_set_frame(inout source_surface surface, unit_reference unit, uvec3 corners, vec3 weights)
{
    uint64_t positions = mesh_positions(unit);
    uint64_t normals = mesh_normals(unit);
    uint64_t tangents = mesh_tangents(unit);
    clast_mesh_edges edges = mesh_edges(mesh_value3(positions, corners[0], 3u), mesh_value3(positions, corners[1], 3u),
                                        mesh_value3(positions, corners[2], 3u));
    clast_mesh_texture texture_edges = mesh_texture_of(unit, 0u, corners);
    surface.geometric_normal = mesh_edges_normal(edges);
    surface.normal = surface.geometric_normal;
    surface.curvature = 0.0f;
    if (normals != 0ul) {
        vec3 a = mesh_value3(normals, corners[0], 3u);
        vec3 b = mesh_value3(normals, corners[1], 3u);
        vec3 c = mesh_value3(normals, corners[2], 3u);
        surface.normal = mesh_normal(mesh_blend3(a, b, c, weights), surface.geometric_normal);
        surface.curvature = mesh_curvature(edges, a, b, c);
    }
    surface.gradients[0] = mesh_texture_gradient(edges, texture_edges);
    surface.gradients[1] = no_texture_gradient();
    if (array_of(unit, MESH_ARRAY_COORDINATES_0 + 1u) != 0ul) {
        surface.gradients[1] = mesh_texture_gradient(edges, mesh_texture_of(unit, 1u, corners));
    }
    vec4 tangent = mesh_texture_tangent(edges, texture_edges);
    surface.tangent = vec3(tangent[0], tangent[1], tangent[2]);
    surface.bitangent_sign = tangent[3];
    if (tangents != 0ul) {
        vec3 own = mesh_blended3(tangents, corners, 4u, weights);
        if (mesh_tangent_is_sound(own)) {
            surface.tangent = own;
            surface.bitangent_sign = mesh_value4(tangents, corners[0])[3] < 0.0f ? -1.0f : 1.0f;
        }
    }
}

source_surface mesh_evaluate(unit_reference unit, clast_surface_point point)
{
    uvec3 corners = mesh_corners(unit, point.primitive);
    vec3 weights = mesh_weights(load2(point.coordinates));
    source_surface surface;
    surface.position = mesh_blended3(mesh_positions(unit), corners, 3u, weights);
    surface.colour = mesh_colour(unit, corners, weights);
    surface.material = mesh_material(unit, point.primitive);
    surface.coordinates[0] = mesh_coordinates(unit, 0u, corners, weights);
    surface.coordinates[1] = mesh_coordinates(unit, 1u, corners, weights);
    mesh_set_frame(surface, unit, corners, weights);
    return surface;
}

#endif
