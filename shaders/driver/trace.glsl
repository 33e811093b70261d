// SPDX-License-Identifier: Apache-2.0
// Rays by the driver's ray tracing pipeline, in place of accel/trace.glsl and accel/trace_loop.glsl: with the same functions, for
// kernels that are compiled for both. Each launch is one ray of a list. There is no filter here: the pipeline's any-hit
// shader is it.
#ifndef CLAST_DRIVER_TRACE_GLSL
#define CLAST_DRIVER_TRACE_GLSL

#include "driver/hits.glsl"

layout(location = 0) rayPayloadEXT driver_found found;

uint trace_count();
void begin_ray(uint number);
void store_ray();

struct trace_state
{
    uint64_t scene;
    bool more; // never: a ray is traced at once
} trace;

uint trace_number() { return gl_LaunchIDEXT.y * gl_LaunchSizeEXT.x + gl_LaunchIDEXT.x; }

// Drivers need ranges that begin at zero or later: an earlier one is moved.
void begin_trace(uint64_t scene, clast_ray ray, bool any)
{
    trace.scene = scene;
    trace.more = false;
    found.t = min(ray.t_max, NUMBER_MOST);
    found.instance = CLAST_NONE;
    if (!is_valid_ray(ray)) {
        return;
    }
    float moved = min(ray.t_min, 0.0);
    vec3 direction = load3(ray.direction);
    uint flags = any ? gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT : gl_RayFlagsNoneEXT;
    found.instance = 0u; // of any hits, it stays unless the ray misses
    traceRayEXT(accelerationStructureEXT(load_address(driver_scene_reference(scene).of.structure)), flags, 0xffu, 0u, 0u,
                0u, load3(ray.origin) + direction * moved, ray.t_min - moved, direction,
                min(min(ray.t_max, NUMBER_MOST) - moved, NUMBER_MOST), 0);
    found.t += moved;
}

bool trace_found() { return found.instance != CLAST_NONE; }

clast_hit traced_hit() { return hit_of(trace.scene, found); }

clast_hit trace_closest(uint64_t scene, clast_ray ray)
{
    begin_trace(scene, ray, false);
    return traced_hit();
}

void trace_one()
{
    uint number = trace_number();
    if (number < trace_count()) {
        begin_ray(number);
        store_ray();
    }
}

void trace_all() { trace_one(); }

#endif
