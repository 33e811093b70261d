// SPDX-License-Identifier: Apache-2.0
// Attributes of a point of a mesh.
#include <math.h>

#include "source/mesh.h"

typedef struct triangle_corners {
    const uint32_t *vertices;
    vec3 weights;
} triangle_corners;

static vec3 blend3(const float *values, triangle_corners at, size_t stride)
{
    vec3 sum = splat3(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        const float *value = values + stride * at.vertices[k];
        sum += vec3(value[0], value[1], value[2]) * at.weights[k];
    }
    return sum;
}

static vec2 blend2(const float *values, triangle_corners at)
{
    vec2 sum = splat2(0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        const float *value = values + 2 * (size_t)at.vertices[k];
        sum += vec2(value[0], value[1]) * at.weights[k];
    }
    return sum;
}

static vec4 blend4(const float *values, triangle_corners at)
{
    vec4 sum = vec4(0.0f, 0.0f, 0.0f, 0.0f);
    for (uint32_t k = 0; k < 3; k++) {
        const float *value = values + 4 * (size_t)at.vertices[k];
        sum += vec4(value[0], value[1], value[2], value[3]) * at.weights[k];
    }
    return sum;
}

// Two edges of a triangle, scaled by a power of two so that their products neither overflow nor vanish.
typedef struct scaled_edges {
    vec3 first, second;
    float scale; // what they were multiplied by; 0 where there is no triangle to speak of
} scaled_edges;

static scaled_edges edges_of(const clast_mesh *mesh, const uint32_t *vertices)
{
    vec3 origin = load3(clast_mesh_position(mesh, vertices[0]));
    vec3 first = load3(clast_mesh_position(mesh, vertices[1])) - origin;
    vec3 second = load3(clast_mesh_position(mesh, vertices[2])) - origin;
    float largest = 0.0f;
    for (uint32_t axis = 0; axis < 3; axis++) {
        largest = max1(largest, max1(abs1(first[axis]), abs1(second[axis])));
    }
    if (!(largest > 0.0f) || !is_finite1(largest)) {
        return (scaled_edges){splat3(0.0f), splat3(0.0f), 0.0f};
    }
    int exponent = 0;
    frexpf(largest, &exponent);
    exponent = exponent < -120 ? -120 : exponent; // 2^120 is the most that is needed to stay clear of denormals
    float scale = ldexpf(1.0f, -exponent);
    return (scaled_edges){first * scale, second * scale, scale};
}

// Texture space of a triangle: edges of the first coordinates.
typedef struct texture_edges {
    vec2 first, second;
    float determinant;
} texture_edges;

static texture_edges texture_edges_of(const clast_mesh *mesh, const uint32_t *vertices)
{
    const float *coordinates = mesh->coordinates[0];
    if (coordinates == NULL) {
        return (texture_edges){splat2(0.0f), splat2(0.0f), 0.0f};
    }
    const float *a = coordinates + 2 * (size_t)vertices[0];
    const float *b = coordinates + 2 * (size_t)vertices[1];
    const float *c = coordinates + 2 * (size_t)vertices[2];
    vec2 first = vec2(b[0] - a[0], b[1] - a[1]);
    vec2 second = vec2(c[0] - a[0], c[1] - a[1]);
    return (texture_edges){first, second, first[0] * second[1] - first[1] * second[0]};
}

static float texels_per_length(scaled_edges edges, texture_edges texture, vec3 normal)
{
    float area = length3(normal); // of the scaled triangle
    float ratio = sqrtf(abs1(texture.determinant) / area) * edges.scale;
    return area > 0.0f && is_finite1(ratio) ? ratio : 0.0f;
}

// The way in which the first texture coordinate grows, for meshes that bring no tangents. The sign follows glTF: the
// bitangent points to where the second coordinate falls.
static void tangent_of_texture(clast_source_surface *surface, scaled_edges edges, texture_edges texture)
{
    float sign = texture.determinant > 0.0f ? 1.0f : -1.0f;
    vec3 tangent = (edges.first * texture.second[1] - edges.second * texture.first[1]) * sign;
    bool sound = texture.determinant != 0.0f && is_finite3(tangent);
    surface->tangent = sound ? tangent : splat3(0.0f);
    surface->bitangent_sign = -sign;
}

static void set_frame(clast_source_surface *surface, const clast_mesh *mesh, triangle_corners at)
{
    scaled_edges edges = edges_of(mesh, at.vertices);
    texture_edges texture = texture_edges_of(mesh, at.vertices);
    surface->geometric_normal = cross3(edges.first, edges.second);
    surface->texels_per_length = texels_per_length(edges, texture, surface->geometric_normal);
    surface->normal = surface->geometric_normal;
    if (mesh->normals != NULL) {
        vec3 normal = blend3(mesh->normals, at, 3);
        float square = dot3(normal, normal); // zero where opposite normals meet
        surface->normal = square > 1e-12f && is_finite1(square) ? normal : surface->geometric_normal;
    }
    tangent_of_texture(surface, edges, texture);
    if (mesh->tangents != NULL) {
        vec3 tangent = blend3(mesh->tangents, at, 4);
        if (is_finite3(tangent) && dot3(tangent, tangent) > 1e-12f) {
            surface->tangent = tangent;
            surface->bitangent_sign = mesh->tangents[4 * (size_t)at.vertices[0] + 3] < 0.0f ? -1.0f : 1.0f;
        }
    }
}

clast_source_surface clast_mesh_evaluate(const clast_mesh *mesh, clast_surface_point point)
{
    vec2 weights = load2(point.coordinates);
    triangle_corners at = {
        mesh->indices + 3 * (size_t)point.primitive,
        vec3(1.0f - weights[0] - weights[1], weights[0], weights[1]),
    };
    clast_source_surface surface = {
        .position = blend3(mesh->positions, at, 3),
        .colour = mesh->colours != NULL ? blend4(mesh->colours, at) : vec4(1.0f, 1.0f, 1.0f, 1.0f),
        .material = clast_mesh_material(mesh, point.primitive),
    };
    for (uint32_t set = 0; set < 2; set++) {
        surface.coordinates[set] = mesh->coordinates[set] != NULL ? blend2(mesh->coordinates[set], at) : splat2(0.0f);
    }
    set_frame(&surface, mesh, at);
    return surface;
}
