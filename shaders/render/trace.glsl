// SPDX-License-Identifier: Apache-2.0
// Rays of light paths: what they hit, where alpha decides what counts. A kernel may say where its ray is read (TRACE_RAY of
// accel/trace.glsl) before it includes this.
//
// The build compiles kernels that include this twice: for clast's own structures, and as launches of the driver's ray tracing
// pipeline (GPU_RAY_STAGE).
#ifndef CLAST_RENDER_TRACE_GLSL
#define CLAST_RENDER_TRACE_GLSL

#include "accel/ray.glsl"
#include "render/paths.glsl"

#ifdef GPU_RAY_STAGE
#include "driver/trace.glsl"
#include "render/alpha.glsl"
#else
layout(constant_id = 0) const uint TRACE_GROUP = 64u;    // PATH_TRACE_GROUP; as in accel/trace_rays.glsl, to TRACE_PAIRS
layout(constant_id = 1) const uint TRACE_REFILL = 0u;
layout(constant_id = 2) const uint TRACE_STEPS = 4u;
layout(constant_id = 3) const uint TRACE_PAIRS = 0u;
layout(constant_id = 4) const uint TRACE_FILTERED = 1u;  // 0: every surface is opaque
layout(local_size_x_id = 0) in;

bool accepts(clast_hit hit);
#define TRACE_FILTER(hit) (TRACE_FILTERED == 0u || accepts(hit))

#include "accel/trace_loop.glsl"
#include "render/alpha.glsl"

uint trace_number() { return linear_group() * TRACE_GROUP + gl_LocalInvocationIndex; }
#endif

materials_reference materials_of_render() { return materials_reference(load_address(render_of().of.materials)); }
uint64_t scene_of_render() { return load_address(frame_of_render().of.tree); }

#ifndef GPU_RAY_STAGE
bool accepts(clast_hit hit)
{
    clast_ray ray = TRACE_RAY();
    return hit_accepts_by_chance(frame_of_render(), materials_of_render(), load3(ray.origin), load3(ray.direction),
                                 hit.instance, hit.cluster, hit.triangle, load2(hit.barycentrics));
}
#endif

// clast_visibility_of_hit.
clast_visibility visibility_of_hit(clast_hit hit)
{
    clast_visibility seen;
    seen.instance = hit.instance;
    seen.cluster = hit.cluster;
    seen.triangle = hit.triangle;
    seen.barycentrics = hit.barycentrics;
    seen.distance = hit.t;
    seen.normal = store3(visible_normal(load3(hit.normal)));
    seen.steps = hit.steps;
    return seen;
}

clast_ray make_ray(vec3 origin, float t_min, vec3 direction, float t_max)
{
    clast_ray ray;
    ray.origin = store3(origin);
    ray.t_min = t_min;
    ray.direction = store3(direction);
    ray.t_max = t_max;
    return ray;
}

clast_ray primary_ray_of(clast_path_pixel pixel)
{
    clast_camera_ray ray = primary_ray(frame_of_render().of.camera, render_of().of.width, render_of().of.height,
                                       render_of().of.area_x + pixel.x, render_of().of.area_y + pixel.y,
                                       push.sample_number, samples_of(pixel));
    return make_ray(load3(ray.origin), ray.t_min, load3(ray.direction), ray.t_max);
}

#endif
