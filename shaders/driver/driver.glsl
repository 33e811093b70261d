// SPDX-License-Identifier: Apache-2.0
// What the stages of the driver's ray tracing pipeline share. A ray carries as little as can be: what it hit is looked up
// once it has come back.
#ifndef CLAST_DRIVER_GLSL
#define CLAST_DRIVER_GLSL

#define GPU_RAY_STAGE
#extension GL_EXT_ray_tracing : require
#include "gpu.glsl"
#include "shared/driver.h"
#include "shared/transform.h"

// clast_ray and clast_hit of clast/accel.h.
struct driver_ray {
    vec3 origin;
    float t_min;
    vec3 direction;
    float t_max;
};
struct driver_hit {
    float t, u, v;
    vec3 normal;
    uint instance, cluster, triangle, steps;
};
ARRAY_OF(driver_rays, driver_ray, 16)
ARRAY_OF(driver_hits, driver_hit, 8)
ARRAY_OF(driver_shapes, clast_driver_shape, 16)

// vulkan/driver.c hands these over.
layout(push_constant, scalar) uniform clast_driver_push {
    uint64_t structure; // over the instances
    uint64_t shapes;    // clast_driver_shape of each
    uint64_t rays;
    uint64_t results; // of closest hits: as clast_hit; of any hits: 1 or 0, 32 bits each
    uint64_t counts;  // 0, or where the number of rays lies
    uint64_t user;    // the filter's own
    uint count;       // most rays
}
push;

// What a ray brings back.
struct driver_found {
    float t;
    vec2 barycentrics;
    uint instance; // place in the list; CLAST_NONE: nothing was hit
    uint primitive;
};

// A triangle, as clast names it.
struct driver_place {
    uint instance, cluster, triangle;
};

driver_place place_of(clast_driver_shape shape, uint primitive)
{
    uint word = uints(load_address(shape.triangles)).at[primitive];
    return driver_place(shape.id, driver_triangle_cluster(word), driver_triangle_number(word));
}

#endif
