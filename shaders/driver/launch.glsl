// SPDX-License-Identifier: Apache-2.0
// Rays of a buffer, as they are launched: one each.
#ifndef CLAST_DRIVER_LAUNCH_GLSL
#define CLAST_DRIVER_LAUNCH_GLSL

#include "driver/driver.glsl"
#include "shared/box.h"

layout(location = 0) rayPayloadEXT driver_found found;

const float FLOAT_MOST = 3.402823466e38;

uint launch_number() { return gl_LaunchIDEXT.y * gl_LaunchSizeEXT.x + gl_LaunchIDEXT.x; }

bool is_launched(uint number)
{
    return number < push.count && (push.counts == 0ul || number < uints(push.counts).at[0]);
}

bool is_at_most3(vec3 v, float most) { return abs(v[0]) <= most && abs(v[1]) <= most && abs(v[2]) <= most; }

// What is not finite hits nothing, nor does what has no direction or no range.
bool can_hit(driver_ray ray)
{
    bool directed = ray.direction[0] != 0.0 || ray.direction[1] != 0.0 || ray.direction[2] != 0.0;
    return is_at_most3(ray.origin, BOX_COORDINATE_MOST) && is_at_most3(ray.direction, FLOAT_MOST) && directed &&
           abs(ray.t_min) <= FLOAT_MOST && ray.t_min <= ray.t_max;
}

// Fills `found`. Drivers need ranges that begin at zero or later: an earlier one is moved.
void trace_ray(driver_ray ray, uint flags)
{
    float moved = min(ray.t_min, 0.0);
    float t_max = min(ray.t_max, FLOAT_MOST) - moved;
    traceRayEXT(accelerationStructureEXT(push.structure), flags, 0xffu, 0u, 0u, 0u, ray.origin + ray.direction * moved,
                ray.t_min - moved, ray.direction, min(t_max, FLOAT_MOST), 0);
    found.t += moved;
}

#endif
