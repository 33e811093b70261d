// SPDX-License-Identifier: Apache-2.0
// What attributes of a triangle's corners make of a point on it: normals, tangents, how texture coordinates grow, how it bends.
#ifndef CLAST_SHARED_MESH_SURFACE_H
#define CLAST_SHARED_MESH_SURFACE_H

#include "shared/texture_filter.h"

// `weights` are those of the three corners.
FN vec4 mesh_blend4(vec4 a, vec4 b, vec4 c, vec3 weights) { return a * weights[0] + b * weights[1] + c * weights[2]; }
FN vec3 mesh_blend3(vec3 a, vec3 b, vec3 c, vec3 weights) { return a * weights[0] + b * weights[1] + c * weights[2]; }
FN vec2 mesh_blend2(vec2 a, vec2 b, vec2 c, vec3 weights) { return a * weights[0] + b * weights[1] + c * weights[2]; }

FN vec3 mesh_weights(vec2 barycentrics)
{
    return vec3(1.0f - barycentrics[0] - barycentrics[1], barycentrics[0], barycentrics[1]);
}

// Two edges of a triangle, scaled by a power of two so that their products neither overflow nor vanish.
RECORD(clast_mesh_edges)
{
    packed3 first;
    packed3 second;
    float scale; // what they were multiplied by; 0 where there is no triangle to speak of
};
RECORD_SIZE(clast_mesh_edges, 28)

FN clast_mesh_edges mesh_edges(vec3 a, vec3 b, vec3 c)
{
    vec3 first = b - a;
    vec3 second = c - a;
    float largest = 0.0f;
    for (uint axis = 0u; axis < 3u; axis++) {
        largest = max1(largest, max1(abs1(first[axis]), abs1(second[axis])));
    }
    bool sound = largest > 0.0f && is_finite1(largest);
    // 2^120 is the most that is needed to stay clear of denormals, 2^-126 the least that is none
    uint exponent = max_uint(floatBitsToUint(largest) >> 23u, 6u); // largest < 2^(exponent - 126)
    float scale = sound ? power_of_two(253u - min_uint(exponent, 252u)) : 0.0f;
    clast_mesh_edges edges;
    edges.first = store3(sound ? first * scale : splat3(0.0f));
    edges.second = store3(sound ? second * scale : splat3(0.0f));
    edges.scale = scale;
    return edges;
}

FN vec3 mesh_edges_normal(clast_mesh_edges edges) { return cross3(load3(edges.first), load3(edges.second)); }

// Texture space of a triangle: edges of the first coordinates.
RECORD(clast_mesh_texture)
{
    packed2 first;
    packed2 second;
    float determinant;
};
RECORD_SIZE(clast_mesh_texture, 20)

FN clast_mesh_texture mesh_texture(vec2 a, vec2 b, vec2 c)
{
    vec2 first = b - a;
    vec2 second = c - a;
    clast_mesh_texture texture_edges;
    texture_edges.first = store2(first);
    texture_edges.second = store2(second);
    texture_edges.determinant = first[0] * second[1] - first[1] * second[0];
    return texture_edges;
}

// In the triangle's plane; zero where that is none.
FN clast_texture_gradient mesh_texture_gradient(clast_mesh_edges edges, clast_mesh_texture texture_edges)
{
    vec3 normal = mesh_edges_normal(edges);
    float square = dot3(normal, normal);
    float inverse = rough_divide(edges.scale, square);
    vec3 first = cross3(load3(edges.second), normal) * inverse; // one along the first edge, zero along the second
    vec3 second = cross3(normal, load3(edges.first)) * inverse;
    vec3 u = first * load2(texture_edges.first)[0] + second * load2(texture_edges.second)[0];
    vec3 v = first * load2(texture_edges.first)[1] + second * load2(texture_edges.second)[1];
    bool sound = square > 1e-30f && is_finite3(u) && is_finite3(v);
    clast_texture_gradient gradient;
    gradient.u = store3(sound ? u : splat3(0.0f));
    gradient.v = store3(sound ? v : splat3(0.0f));
    return gradient;
}

// How far unit normals turn for each length, more than zero where the surface bulges: the mean over a triangle's edges.
FN float mesh_curvature(clast_mesh_edges edges, vec3 a, vec3 b, vec3 c)
{
    vec3 first = load3(edges.first);
    vec3 second = load3(edges.second);
    vec3 third = second - first;
    float turned = dot3(b - a, first) + dot3(c - a, second) + dot3(c - b, third);
    float squares = dot3(first, first) + dot3(second, second) + dot3(third, third);
    float curvature = rough_divide(turned, squares) * edges.scale;
    bool sound = squares > 0.0f && is_finite1(curvature);
    return sound ? curvature : 0.0f;
}

// The way in which the first texture coordinate grows, for meshes that bring no tangents. The fourth is the sign of the
// bitangent, which follows glTF: it points to where the second coordinate falls.
FN vec4 mesh_texture_tangent(clast_mesh_edges edges, clast_mesh_texture texture_edges)
{
    vec2 first = load2(texture_edges.first);
    vec2 second = load2(texture_edges.second);
    float sign_of_area = texture_edges.determinant > 0.0f ? 1.0f : -1.0f;
    vec3 tangent = (load3(edges.first) * second[1] - load3(edges.second) * first[1]) * sign_of_area;
    bool sound = texture_edges.determinant != 0.0f && is_finite3(tangent);
    tangent = sound ? tangent : splat3(0.0f);
    return vec4(tangent[0], tangent[1], tangent[2], -sign_of_area);
}

// The blend of the corners' normals, which vanishes where opposite ones meet.
FN vec3 mesh_normal(vec3 blended, vec3 geometric_normal)
{
    float square = dot3(blended, blended);
    bool sound = square > 1e-12f && is_finite1(square);
    return sound ? blended : geometric_normal;
}

// Whether a blend of the corners' own tangents can be used.
FN bool mesh_tangent_is_sound(vec3 blended)
{
    precise float square = dot3(blended, blended);
    return is_finite3(blended) && square > 1e-12f;
}

#endif
