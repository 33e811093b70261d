// SPDX-License-Identifier: Apache-2.0
// A ray in a space: as boxes see it, and as the watertight test does (shared/watertight.h). The twin of src/accel/ray_boxes.h
// and of what src/accel/ray_hits.h does when a ray enters an instance, with the same bits where these decide hits: the ray in
// object space, its shear, and the distance of a hit.
//
// Boxes never cull what the triangle test would hit. With M the largest distance from the ray's origin to a side of the
// tree's box, and e = 2^-24, the test and the distance that it finds are off by less than 12 e M (ray_boxes.h). Here, a
// side is found with an inverse that is off by 2.5 units (15 e M), from steps that were moved by STEP_SHIFT, which rounds
// with 11 e M, and some more roundings of 5 e M. So sides are moved outwards by 64 e M.
#ifndef CLAST_ACCEL_RAY_GLSL
#define CLAST_ACCEL_RAY_GLSL

#include "gpu.glsl"
#include "shared/cluster.h"
#include "shared/quotient.h"
#include "shared/watertight.h"

const float PAD_OBJECT = 3.814697265625e-6;   // 2^-18
const float PAD_WORLD = 1.52587890625e-5;     // 2^-16, times the condition of the maps
const float INVERSE_MOST = 1073741824.0;      // 2^30
const float DIRECTION_LEAST = 9.5367431640625e-7; // 2^-20
const float DIRECTION_MOST = 1048576.0;           // 2^20
const float NUMBER_MOST = 3.4028234e38;
const uint SPACE_EXPONENT_MOST = 187u; // biased: 2^60

// clast_ray and clast_hit of clast/accel.h.
struct clast_ray
{
    packed3 origin;
    float t_min;
    packed3 direction;
    float t_max;
};

struct clast_hit
{
    float t;
    packed2 barycentrics;
    packed3 normal;
    uint instance;
    uint cluster;
    uint triangle;
    uint steps;
};

ARRAY_OF(rays, clast_ray, 4)
ARRAY_OF(hits, clast_hit, 4)
ARRAY_OF(placements, clast_device_placement, 16)
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer scene_reference { clast_device_scene of; };

// A direction whose largest component is in [DIRECTION_LEAST, DIRECTION_MOST], and the exponent of the power of two by which it
// was divided.
struct tame_direction
{
    vec3 direction;
    int exponent;
};

// 2^exponent, in two factors that are in range.
precise vec2 powers_of_two(int exponent)
{
    exponent = clamp(exponent, -252, 252);
    int first = exponent / 2;
    return vec2(power_of_two(uint(first + 127)), power_of_two(uint(exponent - first + 127)));
}

// The exponent of a positive number.
int exponent_of(float x)
{
    uint biased = floatBitsToUint(x) >> 23u;
    if (biased == 0u) {
        precise float scaled = x * 1.8446744e19; // 2^64
        return int(floatBitsToUint(scaled) >> 23u) - 191;
    }
    return int(biased) - 127;
}

float largest_size(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

tame_direction tame(vec3 direction, int exponent)
{
    tame_direction result = tame_direction(direction, exponent);
    float largest = largest_size(direction);
    if (!(largest >= DIRECTION_LEAST && largest <= DIRECTION_MOST)) {
        int own = exponent_of(largest);
        vec2 scale = powers_of_two(-own);
        precise vec3 scaled = direction * scale.x * scale.y;
        result.direction = scaled;
        result.exponent += own;
    }
    return result;
}

// All finite but t_max, a direction, a range. By bits: what is not a number need not be known as such.
bool is_valid_ray(clast_ray ray)
{
    vec3 origin = load3(ray.origin), direction = load3(ray.direction);
    uvec3 size = floatBitsToUint(direction) & 0x7fffffffu;
    uint t_max = floatBitsToUint(ray.t_max);
    bool range = is_finite1(ray.t_min) && ((t_max & 0x7fffffffu) <= 0x7f800000u) && ray.t_min <= ray.t_max;
    return is_sound3(origin) && is_finite3(direction) && largest_size(direction) > 0.0 && range &&
           max(max(size.x, size.y), size.z) != 0u;
}

// ------------------------------------------------------------------------------------------------------------- spaces

// A ray as boxes see it: distances are scaled so that M becomes less than 2.
struct ray_space
{
    vec3 origin;
    vec3 inverse;
    float pad;   // by which sides are moved outwards, as a length
    vec2 scale;  // distances here are the ray's t times both
    float t_min;
    uint octant; // bits 0 to 2: the direction is negative there; bits 3 to 5 the opposite
};

float reach_of(vec3 origin, clast_box box)
{
    precise vec3 below = load3(box.lower) - origin;
    precise vec3 above = load3(box.upper) - origin;
    return max(largest_size(below), largest_size(above));
}

float distance_in(ray_space space, float t)
{
    return t * space.scale.x * space.scale.y;
}

ray_space make_space(vec3 origin, tame_direction tamed, float reach, float pad, float t_min)
{
    ray_space space;
    vec3 direction = tamed.direction;
    uint exponent = min(254u - min(floatBitsToUint(reach) >> 23u, 253u), SPACE_EXPONENT_MOST);
    float scale = power_of_two(exponent);
    float most = INVERSE_MOST * power_of_two(254u - (floatBitsToUint(largest_size(direction)) >> 23u));
    vec3 size = max(abs(direction), vec3(1.0 / most));
    vec3 inverse = min(vec3(1.0) / size, vec3(most)) * scale;
    space.octant = (direction.x < 0.0 ? 1u : 0u) | (direction.y < 0.0 ? 2u : 0u) | (direction.z < 0.0 ? 4u : 0u);
    space.octant |= (space.octant ^ 7u) << 3u;
    space.inverse = vec3(direction.x < 0.0 ? -inverse.x : inverse.x, direction.y < 0.0 ? -inverse.y : inverse.y,
                         direction.z < 0.0 ? -inverse.z : inverse.z);
    space.origin = origin;
    space.pad = pad;
    space.scale = vec2(scale, 1.0);
    if (tamed.exponent != 0) {
        space.scale = powers_of_two(tamed.exponent + int(exponent) - 127);
    }
    space.t_min = distance_in(space, t_min);
    return space;
}

// -------------------------------------------------------------------------------------------------------------- tests

// A ray as the watertight test sees it, and what makes a distance of a depth: depth / sum * along * along_rest.
struct ray_shear
{
    clast_watertight_ray ray;
    float along;
    float along_rest;
};

ray_shear make_shear(vec3 origin, tame_direction tamed, float reach)
{
    ray_shear shear;
    vec3 direction = tamed.direction;
    int scale = min(254 + int(WATERTIGHT_EXPONENT) - int(floatBitsToUint(reach) >> 23u), 253);
    vec3 size = abs(direction);
    uint axis = size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u;
    float along = component3(direction, axis);
    shear.ray.origin = store3(origin);
    shear.ray.scale = power_of_two(uint(scale));
    shear.ray.axis = axis;
    float x = exact_divide(component3(direction, (axis + 1u) % 3u), along);
    float y = exact_divide(component3(direction, (axis + 2u) % 3u), along);
    shear.ray.shear_x = abs(x) >= WATERTIGHT_SHEAR_LEAST ? x : 0.0;
    shear.ray.shear_y = abs(y) >= WATERTIGHT_SHEAR_LEAST ? y : 0.0;
    shear.along = exact_divide(1.0, along);
    shear.along_rest = power_of_two(uint(254 - scale));
    if (tamed.exponent != 0) {
        int rest = 127 - scale - tamed.exponent;
        int first = rest < -252 ? -126 : rest > 252 ? 126 : rest / 2;
        int second = clamp(rest - first, -126, 126);
        precise float scaled = shear.along * power_of_two(uint(first + 127));
        shear.along = scaled;
        shear.along_rest = power_of_two(uint(second + 127));
    }
    return shear;
}

// By a map's columns.
precise vec3 apply_map(packed3 columns[3], vec3 v)
{
    return load3(columns[0]) * v.x + load3(columns[1]) * v.y + load3(columns[2]) * v.z;
}

// A ray in an instance's object space.
struct object_ray
{
    vec3 origin;
    tame_direction tamed;
    float reach;
    bool there; // false where it cannot hit anything
};

object_ray enter_placement(clast_ray ray, tame_direction world, uint64_t address)
{
    object_ray result;
    placements from = placements(address);
    precise vec3 away = load3(ray.origin) - load3(from.at[0].origin);
    result.origin = apply_map(from.at[0].to_object, away);
    vec3 direction = apply_map(from.at[0].to_object, world.direction);
    result.there = load_address(from.at[0].nodes) != 0ul && largest_size(direction) > 0.0 && is_finite3(direction) &&
                   is_sound3(result.origin);
    result.tamed = tame(direction, world.exponent);
    result.reach = reach_of(result.origin, from.at[0].box);
    return result;
}

#endif
