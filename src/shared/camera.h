// SPDX-License-Identifier: Apache-2.0
// Rays of a camera.
#ifndef CLAST_SHARED_CAMERA_H
#define CLAST_SHARED_CAMERA_H

#include "shared/enums.h"
#include "shared/records.h"

RECORD(clast_camera_ray)
{
    packed3 origin;
    float t_min;
    packed3 direction; // unit length
    float t_max;       // infinite where the camera has no far plane
};
RECORD_SIZE(clast_camera_ray, 32)

// The ray through a point of the picture: x grows to the right from 0 to 1, y downwards.
FN clast_camera_ray camera_ray(clast_camera camera, float x, float y)
{
    float right = (2.0f * x - 1.0f) * camera.aspect * camera.vertical_extent;
    float up = (1.0f - 2.0f * y) * camera.vertical_extent;
    vec3 across = load3(camera.right) * right + load3(camera.up) * up;
    vec3 forward = load3(camera.forward);
    bool is_perspective = camera.projection == CLAST_PROJECTION_PERSPECTIVE;
    vec3 direction = is_perspective ? normalize3(forward + across) : forward;
    vec3 origin = is_perspective ? load3(camera.position) : load3(camera.position) + across;
    float cosine = dot3(direction, forward);
    clast_camera_ray ray;
    ray.origin = store3(origin);
    ray.t_min = rough_divide(camera.near_plane, cosine);
    ray.direction = store3(direction);
    ray.t_max = camera.far_plane > 0.0f ? rough_divide(camera.far_plane, cosine) : uintBitsToFloat(0x7f800000u);
    return ray;
}

// Where in its pixel a sample lies, from a point of the unit square: a tent of radius one pixel around the centre, so
// that the mean of the samples is a filtered picture (Ernst, Stamminger and Greiner, Filter Importance Sampling, 2006).
FN float camera_offset(float u)
{
    float v = 2.0f * u;
    float tent = v < 1.0f ? rough_sqrt(v) - 1.0f : 1.0f - rough_sqrt(2.0f - v);
    return 0.5f + tent;
}

// Distance along the camera's axis of a point at `distance` along a ray.
FN float camera_depth(clast_camera camera, clast_camera_ray ray, float distance)
{
    return distance * dot3(load3(ray.direction), load3(camera.forward));
}

#endif
