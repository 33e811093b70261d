// SPDX-License-Identifier: Apache-2.0
// Hits by the driver's ray tracing pipeline. A ray carries as little as can be: what it hit is looked up once it has come back.
#ifndef CLAST_DRIVER_HITS_GLSL
#define CLAST_DRIVER_HITS_GLSL

#include "accel/ray.glsl"
#include "shared/driver.h"
#include "shared/transform.h"

ARRAY_OF(driver_shapes, clast_driver_shape, 16)
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer driver_scene_reference { clast_driver_top of; };

// What a ray brings back.
struct driver_found
{
    float t;
    vec2 barycentrics;
    uint instance; // place in the list; CLAST_NONE: nothing was hit
    uint primitive;
};

// A triangle, as clast names it.
struct driver_place
{
    uint instance, cluster, triangle;
};

clast_driver_shape shape_of(uint64_t scene, uint instance)
{
    return driver_shapes(load_address(driver_scene_reference(scene).of.shapes)).at[instance];
}

driver_place place_of(clast_driver_shape shape, uint primitive)
{
    uint word = uints(load_address(shape.triangles)).at[primitive];
    return driver_place(shape.id, driver_triangle_cluster(word), driver_triangle_number(word));
}

vec3 corner_of(clast_driver_shape shape, uint primitive, uint corner)
{
    uint vertex = uints(load_address(shape.indices)).at[3u * primitive + corner];
    return load3(positions3(load_address(shape.positions)).at[vertex]);
}

// By a power of two, so that its largest component is about one: products neither overflow nor vanish.
vec3 scale_edge(vec3 edge)
{
    uint exponent = floatBitsToUint(largest_size(edge)) >> 23u;
    return exponent > 0u && exponent < 254u ? edge * uintBitsToFloat((254u - exponent) << 23u) : edge;
}

vec3 normal_of(clast_driver_shape shape, uint primitive)
{
    vec3 a = corner_of(shape, primitive, 0u);
    vec3 b = transform_vector(shape.to_world, corner_of(shape, primitive, 1u) - a);
    vec3 c = transform_vector(shape.to_world, corner_of(shape, primitive, 2u) - a);
    vec3 normal = cross3(scale_edge(b), scale_edge(c));
    return (shape.flags & DRIVER_MIRRORED) != 0u ? -normal : normal;
}

// As clast's own rays tell it.
clast_hit hit_of(uint64_t scene, driver_found found)
{
    clast_hit hit;
    hit.t = found.t;
    hit.barycentrics = store2(vec2(0.0));
    hit.normal = store3(vec3(0.0));
    hit.instance = CLAST_NONE;
    hit.cluster = hit.triangle = hit.steps = 0u;
    if (found.instance != CLAST_NONE) {
        clast_driver_shape shape = shape_of(scene, found.instance);
        driver_place place = place_of(shape, found.primitive);
        hit.barycentrics = store2(found.barycentrics);
        hit.normal = store3(normal_of(shape, found.primitive));
        hit.instance = place.instance;
        hit.cluster = place.cluster;
        hit.triangle = place.triangle;
    }
    return hit;
}

#endif
