// SPDX-License-Identifier: Apache-2.0
// Attributes of a point of a mesh.
#include "shared/mesh_surface.h"
#include "source/mesh.h"

typedef struct triangle_corners {
    const uint32_t *vertices;
    vec3 weights;
} triangle_corners;

static vec2 value2(const float *values, uint32_t vertex)
{
    const float *value = values + 2 * (size_t)vertex;
    return vec2(value[0], value[1]);
}

static vec3 value3(const float *values, uint32_t vertex, size_t stride)
{
    const float *value = values + stride * vertex;
    return vec3(value[0], value[1], value[2]);
}

static vec4 value4(const float *values, uint32_t vertex)
{
    const float *value = values + 4 * (size_t)vertex;
    return vec4(value[0], value[1], value[2], value[3]);
}

static vec2 blend2(const float *values, triangle_corners at)
{
    const uint32_t *v = at.vertices;
    return mesh_blend2(value2(values, v[0]), value2(values, v[1]), value2(values, v[2]), at.weights);
}

static vec3 blend3(const float *values, triangle_corners at, size_t stride)
{
    const uint32_t *v = at.vertices;
    return mesh_blend3(value3(values, v[0], stride), value3(values, v[1], stride), value3(values, v[2], stride),
                       at.weights);
}

static vec4 blend4(const float *values, triangle_corners at)
{
    const uint32_t *v = at.vertices;
    return mesh_blend4(value4(values, v[0]), value4(values, v[1]), value4(values, v[2]), at.weights);
}

static clast_mesh_texture texture_of(const clast_mesh *mesh, const uint32_t *vertices, uint32_t set)
{
    const float *values = mesh->coordinates[set];
    return values != NULL
               ? mesh_texture(value2(values, vertices[0]), value2(values, vertices[1]), value2(values, vertices[2]))
               : (clast_mesh_texture){.determinant = 0.0f};
}

static void set_frame(clast_source_surface *surface, const clast_mesh *mesh, triangle_corners at)
{
    const uint32_t *v = at.vertices;
    clast_mesh_edges edges = mesh_edges(value3(mesh->positions, v[0], 3), value3(mesh->positions, v[1], 3),
                                        value3(mesh->positions, v[2], 3));
    clast_mesh_texture texture = texture_of(mesh, v, 0);
    surface->geometric_normal = mesh_edges_normal(edges);
    surface->normal = surface->geometric_normal;
    if (mesh->normals != NULL) {
        surface->normal = mesh_normal(blend3(mesh->normals, at, 3), surface->geometric_normal);
        surface->curvature = mesh_curvature(edges, value3(mesh->normals, v[0], 3), value3(mesh->normals, v[1], 3),
                                            value3(mesh->normals, v[2], 3));
    }
    surface->gradients[0] = mesh_texture_gradient(edges, texture);
    surface->gradients[1] = mesh->coordinates[1] != NULL ? mesh_texture_gradient(edges, texture_of(mesh, v, 1))
                                                         : no_texture_gradient();
    vec4 tangent = mesh_texture_tangent(edges, texture);
    surface->tangent = vec3(tangent[0], tangent[1], tangent[2]);
    surface->bitangent_sign = tangent[3];
    if (mesh->tangents != NULL) {
        vec3 own = blend3(mesh->tangents, at, 4);
        if (mesh_tangent_is_sound(own)) {
            surface->tangent = own;
            surface->bitangent_sign = mesh->tangents[4 * (size_t)v[0] + 3] < 0.0f ? -1.0f : 1.0f;
        }
    }
}

clast_source_surface clast_mesh_evaluate(const clast_mesh *mesh, clast_surface_point point)
{
    triangle_corners at = {mesh->indices + 3 * (size_t)point.primitive, mesh_weights(load2(point.coordinates))};
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
