// SPDX-License-Identifier: Apache-2.0
// What lights send to a point, and how surroundings are laid out in a picture.
#ifndef CLAST_SHARED_LIGHT_H
#define CLAST_SHARED_LIGHT_H

#include "shared/enums.h"
#include "shared/sampling.h"

// Light that arrives at a point from one direction.
RECORD(clast_incoming)
{
    packed3 direction; // towards the light, unit length
    float distance;    // infinite for directional lights
    packed3 irradiance; // on a surface that faces the light
};
RECORD_SIZE(clast_incoming, 28)

// How bright light of a colour is; not zero where any of it is there.
FN float light_strength(vec3 radiance) { return max1(luminance(radiance), 0.01f * max1(largest3(radiance), 0.0f)); }

// KHR_lights_punctual's range: brings the inverse square to zero there.
FN float light_window(float distance, float range)
{
    float ratio = range > 0.0f ? rough_divide(distance, range) : 0.0f;
    return clamp1(1.0f - ratio * ratio * ratio * ratio, 0.0f, 1.0f);
}

// KHR_lights_punctual's cone.
FN float light_cone(clast_light light, float cosine)
{
    float width = max1(light.inner_cosine - light.outer_cosine, 0.001f);
    float inside = clamp1(rough_divide(cosine - light.outer_cosine, width), 0.0f, 1.0f);
    return inside * inside;
}

// What its cone and its range let through, of a light that is somewhere. `towards` it, unit length.
FN float light_reaching(clast_light light, vec3 towards, float distance)
{
    float reaching = light_window(distance, light.range);
    if (light.type == CLAST_LIGHT_SPOT) {
        reaching = reaching * light_cone(light, -dot3(towards, load3(light.direction)));
    }
    return reaching;
}

FN clast_incoming light_incoming(clast_light light, vec3 place)
{
    clast_incoming incoming;
    vec3 shines = load3(light.direction);
    vec3 away = load3(light.position) - place;
    float distance = length3(away);
    vec3 towards = distance > 0.0f ? away * rough_divide(1.0f, distance) : shines * -1.0f;
    bool directional = light.type == CLAST_LIGHT_DIRECTIONAL;
    float strength = rough_divide(light_reaching(light, towards, distance), max1(distance * distance, 1e-20f));
    incoming.direction = store3(directional ? shines * -1.0f : towards);
    incoming.distance = directional ? uintBitsToFloat(0x7f800000u) : distance;
    incoming.irradiance = store3(load3(light.radiance) * (directional ? 1.0f : strength));
    return incoming;
}

// Where in a latitude-longitude picture a direction is, 0 to 1 both ways, y up. Its middle is +x turned towards -z by
// `rotation`; from there to the right is towards +z.
FN vec2 surroundings_place(vec3 direction, float rotation)
{
    float turns = rough_atan2(direction[2], direction[0]);
    float u = 0.5f + (turns + rotation) * (0.5f * INVERSE_PI);
    float v = rough_acos(clamp1(direction[1], -1.0f, 1.0f)) * INVERSE_PI;
    return vec2(u - floor1(u), v);
}

// The inverse; `place` may also be outside in u.
FN vec3 surroundings_direction(vec2 place, float rotation)
{
    float azimuth = (place[0] - 0.5f) * (2.0f * PI) - rotation;
    float polar = place[1] * PI;
    float sine = rough_sin(polar);
    return vec3(sine * rough_cos(azimuth), rough_cos(polar), sine * rough_sin(azimuth));
}

// The sun's disc, darker towards its limb: Eddington's profile with a slope of 0.6, over its mean.
FN float sun_profile(float below, float height)
{
    float ratio = clamp1(rough_divide(below, height), 0.0f, 1.0f); // square of the distance from the middle
    return (0.4f + 0.6f * rough_sqrt(1.0f - ratio)) * 1.25f;
}

#endif
