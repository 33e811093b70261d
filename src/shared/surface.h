// SPDX-License-Identifier: Apache-2.0
// From a hit to what is there: where it is, its normals, what its material and its textures' values make of it, and whether
// its alpha lets it count. Who reads textures hands their values in here.
#ifndef CLAST_SHARED_SURFACE_H
#define CLAST_SHARED_SURFACE_H

#include "shared/bsdf.h"
#include "shared/enums.h"
#include "shared/transform.h"

FN vec3 absolute3(vec3 v) { return vec3(abs1(v[0]), abs1(v[1]), abs1(v[2])); }

FN vec3 clamp_unit3(vec3 v)
{
    return vec3(clamp1(v[0], 0.0f, 1.0f), clamp1(v[1], 0.0f, 1.0f), clamp1(v[2], 0.0f, 1.0f));
}

// Scaled first: the squares of very small and very large vectors are not numbers.
FN vec3 direction_of(vec3 v, vec3 otherwise)
{
    float largest = largest3(absolute3(v));
    bool sound = largest > 0.0f && is_finite1(largest);
    return sound ? normalize3(v * rough_divide(1.0f, largest)) : otherwise;
}

// The normal of the visibility buffer, from what the ray test gives.
FN vec3 visible_normal(vec3 normal) { return direction_of(normal, vec3(0.0f, 1.0f, 0.0f)); }

// ------------------------------------------------------------------------------------------------- where rays begin

// |M| v
FN vec3 transform_absolute(clast_transform t, vec3 v)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    return vec3(abs1(x[0]) * v[0] + abs1(x[1]) * v[1] + abs1(x[2]) * v[2],
                abs1(y[0]) * v[0] + abs1(y[1]) * v[1] + abs1(y[2]) * v[2],
                abs1(z[0]) * v[0] + abs1(z[1]) * v[1] + abs1(z[2]) * v[2]);
}

FN vec3 transform_translation(clast_transform t)
{
    return vec3(load4(t.rows[0])[3], load4(t.rows[1])[3], load4(t.rows[2])[3]);
}

// An upper bound of what arithmetic may displace a point of an instance by, on each axis of the world, on the way to world
// space and back: `largest` bounds the object's coordinates there, `size` the sides of its triangles; `position` is in world
// space.
//
// Running error analysis as in Pharr, Jakob and Humphreys, Physically Based Rendering, 3rd ed., 3.9: a sum of n products is off
// by at most n + 1 roundings of the sum of their sizes. Into the object's space and back, since the next ray is brought there
// with an error of its own. The ray test mixes the axes of differences of corners, so a triangle's size counts on all of them;
// this also keeps the bound above zero where all else is exact.
FN vec3 position_error(clast_transform to_world, clast_transform to_object, vec3 largest, float size, vec3 position)
{
    float rounding = 5.9604645e-8f; // half a unit of the last place of 1
    vec3 there = absolute3(position);
    vec3 object = largest * (8.0f * rounding) + splat3(16.0f * rounding * size);
    vec3 back = transform_absolute(to_object, there) + absolute3(transform_translation(to_object));
    object = object + back * (4.0f * rounding);
    vec3 world = transform_absolute(to_world, largest) + absolute3(transform_translation(to_world));
    world = world * (4.0f * rounding);
    return transform_absolute(to_world, object) + world + there * (2.0f * rounding);
}

RECORD(clast_surface_place)
{
    packed3 position; // world space
    float offset;     // how far along the normal a ray must begin, so that it cannot hit this surface again
};
RECORD_SIZE(clast_surface_place, 16)

// Of the triangle that was traced, not of the source's smooth surface: rays that leave a curved surface would begin behind
// the triangles that stand for it.
FN clast_surface_place surface_place(clast_transform to_world, clast_transform to_object, vec3 a, vec3 b, vec3 c,
                                     vec2 weights, vec3 geometric_normal)
{
    vec3 first = b - a;
    vec3 second = c - a;
    vec3 object = a + first * weights[0] + second * weights[1];
    vec3 largest = max3(max3(absolute3(a), absolute3(b)), absolute3(c));
    vec3 position = transform_point(to_world, object);
    float size = largest3(max3(absolute3(first), absolute3(second)));
    clast_surface_place place;
    place.position = store3(position);
    vec3 error = position_error(to_world, to_object, largest, size, position);
    place.offset = 2.0f * dot3(absolute3(geometric_normal), error);
    return place;
}

// ---------------------------------------------------------------------------------------------------------- normals

// The normal of an instance, from that of its object.
FN vec3 instance_normal(clast_transform to_object, vec3 normal, vec3 geometric_normal)
{
    return direction_of(transform_transposed(to_object, normal), geometric_normal);
}

// Seen from behind, all normals turn around (glTF 2.0, double sided).
FN float normal_side(vec3 normal, vec3 geometric_normal)
{
    return dot3(normal, geometric_normal) < 0.0f ? -1.0f : 1.0f;
}

// The axes that a normal map's values mean, in the world; the first two are zero where nothing tells them.
FN clast_basis map_axes(clast_transform to_world, vec3 object_tangent, float bitangent_sign, vec3 normal)
{
    vec3 tangent = direction_of(transform_vector(to_world, object_tangent), splat3(0.0f));
    tangent = direction_of(tangent - normal * dot3(normal, tangent), splat3(0.0f));
    // A mirrored instance turns the cross product around.
    float sign = transform_determinant(to_world) < 0.0f ? -bitangent_sign : bitangent_sign;
    clast_basis axes;
    axes.x = store3(tangent);
    axes.y = store3(cross3(normal, tangent) * sign);
    axes.z = store3(normal);
    return axes;
}

FN bool has_axes(clast_basis axes)
{
    return dot3(load3(axes.x), load3(axes.x)) > 0.0f;
}

FN vec3 mapped_normal(clast_basis axes, float scale, vec4 texel)
{
    vec3 normal = load3(axes.z);
    float x = (2.0f * texel[0] - 1.0f) * scale;
    float y = (2.0f * texel[1] - 1.0f) * scale;
    return direction_of(load3(axes.x) * x + load3(axes.y) * y + normal * (2.0f * texel[2] - 1.0f), normal);
}

// What roughness stands for normals that were averaged: `lost` is what the mean's length lacks of one, which tells how far
// they spread (the concentration of directions as Banerjee et al., JMLR 6, 2005, fit it), and slopes add to the lobe's width by
// their variance (Olano and Baker, LEAN Mapping, 2010; Tokuyoshi and Kaplanyan, Improved Geometric Specular Antialiasing, 2019).
// `scale` is the normal map's.
FN float widened_roughness(float roughness, float lost, float scale)
{
    float agreement = max1(1.0f - lost, 1e-3f);
    float square = agreement * agreement;
    float variance = rough_divide(1.0f - square, agreement * (3.0f - square)) * scale * scale;
    float alpha = roughness * roughness;
    return lost > 0.0f ? min1(rough_sqrt(rough_sqrt(alpha * alpha + 2.0f * variance)), 1.0f) : roughness;
}

// How highlights stretch: along which direction of a map's axes, and how much (KHR_materials_anisotropy).
RECORD(clast_stretch)
{
    packed2 along;
    float strength;
};
RECORD_SIZE(clast_stretch, 12)

// A material's, with its texture's value.
FN clast_stretch stretch_by_texel(vec2 along, float strength, vec4 texel)
{
    vec2 d = vec2(2.0f * texel[0] - 1.0f, 2.0f * texel[1] - 1.0f);
    clast_stretch stretch;
    stretch.along = store2(vec2(along[0] * d[0] - along[1] * d[1], along[1] * d[0] + along[0] * d[1]));
    stretch.strength = clamp1(strength * texel[2], 0.0f, 1.0f);
    return stretch;
}

// The direction along which highlights stretch, at right angles to the normal; zero where there is none.
FN vec3 stretch_direction(clast_basis axes, vec2 along, vec3 normal)
{
    vec3 direction = load3(axes.x) * along[0] + load3(axes.y) * along[1];
    return direction_of(direction - normal * dot3(normal, direction), splat3(0.0f));
}

FN clast_basis stretch_basis(vec3 direction, vec3 normal)
{
    clast_basis basis;
    basis.x = store3(direction);
    basis.y = store3(cross3(normal, direction));
    basis.z = store3(normal);
    return basis;
}

// -------------------------------------------------------------------------------------------------------- materials

// What a texture's value makes of a factor of a material.
FN float texture_factor(float factor, float texel) { return clamp1(factor * texel, 0.0f, 1.0f); }
FN vec3 texture_colour(vec4 texel) { return max3(vec3(texel[0], texel[1], texel[2]), splat3(0.0f)); }

// KHR_materials_iridescence: where there is no texture, its value is one.
FN float film_thickness(float least, float most, float texel) { return max1(mix1(least, most, texel), 0.0f); }

// glTF 2.0's metallic-roughness model: roughness is the texel's green, metallic its blue. `colour` is the vertices'.
FN clast_bsdf_input surface_base(vec4 base_colour, vec4 colour, vec4 colour_texel, float metallic, float roughness,
                                 vec4 rough_texel)
{
    vec4 c = base_colour * colour * colour_texel;
    return bsdf_input(brdf_input(clamp_unit3(vec3(c[0], c[1], c[2])), texture_factor(metallic, rough_texel[2]),
                                 texture_factor(roughness, rough_texel[1])));
}

// ------------------------------------------------------------------------------------------------------------ alpha

// Whether a hit counts. Blended surfaces count from an alpha of a half on.
FN bool alpha_accepts(uint mode, float alpha, float cutoff)
{
    return mode == CLAST_ALPHA_MASK ? alpha >= cutoff : mode == CLAST_ALPHA_BLEND ? alpha >= 0.5f : true;
}

// A number in [0, 1) for a ray and a primitive: the same whenever a traversal comes upon it, in whatever order, and however
// the mesh was cut into clusters.
FN float alpha_chance(vec3 origin, vec3 direction, uint instance, uint primitive)
{
    uint bits = hash2(instance, primitive);
    for (uint i = 0u; i < 3u; i++) {
        bits = hash2(bits, floatBitsToUint(unsigned_zero(direction[i])));
        bits = hash2(bits, floatBitsToUint(unsigned_zero(origin[i])));
    }
    return unit_float(bits);
}

// The same, but blended surfaces count with a chance of their alpha.
FN bool alpha_accepts_by_chance(uint mode, float alpha, float cutoff, float chance)
{
    return mode == CLAST_ALPHA_BLEND ? chance < alpha : alpha_accepts(mode, alpha, cutoff);
}

// Whether a ray sees the back of a surface, whose normal is on the counter-clockwise side.
FN bool sees_back(vec3 normal, vec3 direction)
{
    return dot3(normal, direction) > 0.0f;
}

// The least distance beyond that of a hit, which is not negative.
FN float beyond_hit(float distance)
{
    float next = uintBitsToFloat(floatBitsToUint(distance) + 1u);
    return distance > 0.0f ? next : 1.17549435e-38f;
}

LIMIT(BACKS_MOST, 64u, "backs that an eye looks through; what lies behind as many is seen all the same")

#endif
