// SPDX-License-Identifier: Apache-2.0
// Rays of a camera.
#ifndef CLAST_SHARED_CAMERA_H
#define CLAST_SHARED_CAMERA_H

#include "shared/enums.h"
#include "shared/records.h"
#include "shared/sampling.h"

RECORD(clast_camera_ray)
{
    packed3 origin;
    float t_min;
    packed3 direction; // unit length
    float t_max;       // infinite where the camera has no far plane
};
RECORD_SIZE(clast_camera_ray, 32)

// All around the camera: x is longitude, y latitude.
FN vec3 panorama_direction(clast_camera camera, float x, float y)
{
    float longitude = (2.0f * x - 1.0f) * PI;
    float latitude = (0.5f - y) * PI;
    vec3 level = load3(camera.forward) * rough_cos(longitude) + load3(camera.right) * rough_sin(longitude);
    return normalize3(level * rough_cos(latitude) + load3(camera.up) * rough_sin(latitude));
}

// The ray through a point of the picture, x grows to the right from 0 to 1, y downwards, and a point of the lens, a disc of
// radius one. What lies in the plane of focus is seen at the same place through all of the lens.
FN clast_camera_ray camera_lens_ray(clast_camera camera, float x, float y, vec2 lens)
{
    float right = (2.0f * x - 1.0f) * camera.aspect * camera.vertical_extent;
    float up = (1.0f - 2.0f * y) * camera.vertical_extent;
    vec3 across = load3(camera.right) * right + load3(camera.up) * up;
    vec3 forward = load3(camera.forward);
    bool parallel = camera.projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    bool panorama = camera.projection == CLAST_PROJECTION_PANORAMA;
    vec3 direction = parallel ? forward : forward + across;
    vec3 origin = parallel ? load3(camera.position) + across : load3(camera.position);
    if (camera.lens_radius > 0.0f && !panorama) {
        vec3 aside = load3(camera.right) * (lens[0] * camera.lens_radius) + load3(camera.up) * (lens[1] * camera.lens_radius);
        direction = direction * camera.focus - aside;
        origin = origin + aside;
    }
    direction = panorama ? panorama_direction(camera, x, y) : normalize3(direction);
    float cosine = panorama ? 1.0f : dot3(direction, forward);
    clast_camera_ray ray;
    ray.origin = store3(origin);
    ray.t_min = rough_divide(camera.near_plane, cosine);
    ray.direction = store3(direction);
    ray.t_max = camera.far_plane > 0.0f ? rough_divide(camera.far_plane, cosine) : uintBitsToFloat(0x7f800000u);
    return ray;
}

// Through the lens's middle.
FN clast_camera_ray camera_ray(clast_camera camera, float x, float y)
{
    return camera_lens_ray(camera, x, y, vec2(0.0f, 0.0f));
}

// Where in its pixel a sample lies, from a point of the unit square: a tent of radius one pixel around the centre, so
// that the mean of the samples is a filtered picture (Ernst, Stamminger and Greiner, Filter Importance Sampling, 2006).
FN float camera_offset(float u)
{
    float v = 2.0f * u;
    float tent = v < 1.0f ? rough_sqrt(v) - 1.0f : 1.0f - rough_sqrt(2.0f - v);
    return 0.5f + tent;
}

// Distance along the camera's axis of a point at `distance` along a ray; from the camera where it looks all around.
FN float camera_depth(clast_camera camera, clast_camera_ray ray, float distance)
{
    bool panorama = camera.projection == CLAST_PROJECTION_PANORAMA;
    return panorama ? distance : distance * dot3(load3(ray.direction), load3(camera.forward));
}

// A point of the world in a picture of so many rows, in pixels from its middle. What lies before the near plane is taken to
// lie in it. Not for panoramas.
FN vec2 camera_pixels(clast_camera camera, float rows, vec3 point)
{
    vec3 away = point - load3(camera.position);
    float depth = dot3(away, load3(camera.forward));
    bool parallel = camera.projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    float scale = rough_divide(rows, 2.0f * camera.vertical_extent);
    scale = parallel ? scale : rough_divide(scale, max1(depth, max1(camera.near_plane, 1e-30f)));
    return vec2(dot3(away, load3(camera.right)) * scale, dot3(away, load3(camera.up)) * scale);
}

// How many pixels a triangle covers.
FN float camera_area(clast_camera camera, float rows, vec3 a, vec3 b, vec3 c)
{
    vec2 origin = camera_pixels(camera, rows, a);
    vec2 first = camera_pixels(camera, rows, b) - origin;
    vec2 second = camera_pixels(camera, rows, c) - origin;
    return 0.5f * abs1(first[0] * second[1] - first[1] * second[0]);
}

#endif
