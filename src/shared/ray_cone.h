// SPDX-License-Identifier: Apache-2.0
// How much of a surface a sample of a pixel sees: a cone around its path (Akenine-Moeller et al., Texture Level of Detail
// Strategies for Real-Time Ray Tracing, Ray Tracing Gems, 2019, chapter 20; and Improved Shader and Texture Level of Detail
// Using Ray Cones, JCGT 2021), and which texels of a texture its ellipse on the surface covers.
#ifndef CLAST_SHARED_RAY_CONE_H
#define CLAST_SHARED_RAY_CONE_H

#include "shared/camera.h"
#include "shared/texture_filter.h"

TABLE float CONE_LOBE = 0.140625f;    // sqrt(4 / (64 pi)): as if 64 paths shared what a surface scatters
TABLE float CONE_SPREAD_MOST = 1.0f;  // radians: wider ones see no more than half of what surrounds them
TABLE float CONE_NARROW = 0.02f;      // radians
TABLE float CONE_COSINE_LEAST = 1e-3f;
TABLE float TAPS_MOST = 16.0f;        // along the longer axis of what the first sample sees
TABLE float LINE_TAPS_MOST = 8.0f;    // and the others

LIMIT(LOOK_POINT, 0u, "at one point, on the finer of two levels")
LIMIT(LOOK_LINE, 1u, "at points on a line, on the finer of two levels")
LIMIT(LOOK_WHOLE, 2u, "at points on a line, between levels")
LIMIT(LINE_SAMPLES, 16u, "of a pixel, the first, that look at more than a point")
TABLE float NORMAL_ROUNDING = 5e-5f; // of a vector's length, that its three numbers of 16 bits leave open

// A circle around a ray: its diameter at the ray's origin, and how much that grows for each length.
RECORD(clast_ray_cone)
{
    float width;
    float spread;
};
RECORD_SIZE(clast_ray_cone, 8)

// The part of a pixel's side that a sample stands for. The first sees all of the pixel, so that a picture of one sample shows no
// texels that come and go; the next three share it, and those that follow are so many that the pixel's own filter does the rest:
// textures blur what it makes by a few hundredths only.
FN float sample_share(uint sample_number) { return sample_number == 0u ? 1.0f : sample_number < 4u ? 0.5f : 0.25f; }

// How closely a sample looks at what its cone covers, as it comes from the camera or by way of mirrors: the first sample finds all
// of it, those that follow enough to leave little to chance. What a wide cone finds counts by chance anyhow, and many samples find
// the rest.
FN uint cone_look(clast_ray_cone cone, uint sample_number)
{
    bool is_wide = abs1(cone.spread) >= CONE_NARROW;
    return is_wide || sample_number >= LINE_SAMPLES ? LOOK_POINT : sample_number > 0u ? LOOK_LINE : LOOK_WHOLE;
}

// Around the ray of a pixel's sample, in a picture of so many rows.
FN clast_ray_cone camera_cone(clast_camera camera, uint rows, vec3 direction, uint sample_number)
{
    bool parallel = camera.projection == CLAST_PROJECTION_ORTHOGRAPHIC;
    bool panorama = camera.projection == CLAST_PROJECTION_PANORAMA;
    float pixel = rough_divide(2.0f * camera.vertical_extent, to_float(rows)) * sample_share(sample_number);
    clast_ray_cone cone;
    cone.width = parallel ? pixel : 0.0f;
    cone.spread = parallel ? 0.0f : panorama ? pixel : pixel * dot3(direction, load3(camera.forward));
    return cone;
}

// Where its ray has come so far. Behind a focus it is as wide as before it.
FN clast_ray_cone cone_at(clast_ray_cone cone, float distance)
{
    clast_ray_cone there;
    there.width = abs1(cone.width + cone.spread * distance);
    there.spread = cone.width + cone.spread * distance < 0.0f ? -cone.spread : cone.spread;
    return there;
}

// Behind a surface that scatters it into a direction of a density, by solid angle. `bend` is the surface's curvature times the
// cone's width: a mirror turns by it, and what it reflects by twice of that. The lobe widens the cone as much as a share of the
// solid angle that the direction stands for (Suykens and Willems, Path Differentials and Applications, 2001).
FN clast_ray_cone cone_scattered(clast_ray_cone cone, float bend, bool passes, float density, uint sample_number)
{
    float lobe = CONE_LOBE * sample_share(sample_number) * rough_divide(1.0f, rough_sqrt(max1(density, 1e-6f)));
    clast_ray_cone after;
    after.width = cone.width;
    after.spread = clamp1(cone.spread + (passes ? 0.0f : 2.0f * bend) + lobe, -CONE_SPREAD_MOST, CONE_SPREAD_MOST);
    return after;
}

// ------------------------------------------------------------------------------------------------------------ surfaces

// The axes of the ellipse that a cone covers on a surface, from one end to the other: the first along the slant.
RECORD(clast_cone_axes)
{
    packed3 first;
    packed3 second;
};
RECORD_SIZE(clast_cone_axes, 24)

FN clast_cone_axes cone_axes(vec3 normal, vec3 direction, float width)
{
    float cosine = dot3(normal, direction);
    vec3 slant = direction - normal * cosine;
    bool slanted = dot3(slant, slant) > 1e-12f;
    vec3 along = slanted ? normalize3(slant) : load3(basis_around(normal).x);
    clast_cone_axes axes;
    axes.first = store3(along * rough_divide(width, max1(abs1(cosine), CONE_COSINE_LEAST)));
    axes.second = store3(cross3(normal, along) * width);
    return axes;
}

// An ellipse in texture coordinates: two axes, from one end to the other, which need not stand at right angles.
RECORD(clast_footprint)
{
    packed2 first;
    packed2 second;
};
RECORD_SIZE(clast_footprint, 16)

FN clast_footprint no_footprint(void)
{
    clast_footprint at;
    at.first = store2(splat2(0.0f));
    at.second = store2(splat2(0.0f));
    return at;
}

// `first` and `second` are the axes on the surface, in the space of the gradient. What stands out from the surface does not count,
// so this holds for displaced ones with the gradient of what they were made of.
FN clast_footprint footprint_of(clast_texture_gradient gradient, vec3 first, vec3 second)
{
    clast_footprint at;
    at.first = store2(vec2(dot3(load3(gradient.u), first), dot3(load3(gradient.v), first)));
    at.second = store2(vec2(dot3(load3(gradient.u), second), dot3(load3(gradient.v), second)));
    return at;
}

// ------------------------------------------------------------------------------------------------------------ textures

// Where a texture is read: at points on a line, all on one level.
RECORD(clast_texture_taps)
{
    packed2 first; // from the middle to the first point, in texture coordinates
    packed2 step;  // from a point to the next
    float level;   // 0 is the finest; between two, both are blended
    uint count;
};
RECORD_SIZE(clast_texture_taps, 24)

FN clast_texture_taps no_taps(void)
{
    clast_texture_taps taps;
    taps.first = store2(splat2(0.0f));
    taps.step = store2(splat2(0.0f));
    taps.level = 0.0f;
    taps.count = 1u;
    return taps;
}

// Of a texture with so many texels and so many levels below the finest. The level is that whose texels are as large as the
// ellipse is thick, so that nothing is lost across it, and points follow each other along it. `look` is one of LOOK_: where what a
// sample sees is less than the picture can show, the finer of two levels and fewer points do.
FN clast_texture_taps texture_taps(clast_footprint at, uint width, uint height, uint levels, uint look)
{
    clast_texture_taps taps = no_taps();
    vec2 size = vec2(to_float(width), to_float(height));
    vec2 a = load2(at.first) * size;
    vec2 b = load2(at.second) * size;
    float xx = a[0] * a[0] + b[0] * b[0];
    float yy = a[1] * a[1] + b[1] * b[1];
    precise bool fits = xx + yy <= 1.0f; // no axis is longer than a texel
    if (fits || levels == 0u) {
        return taps;
    }
    float xy = a[0] * a[1] + b[0] * b[1];
    float difference = 0.5f * (xx - yy);
    float root = rough_sqrt(difference * difference + xy * xy);
    float major = rough_sqrt(0.5f * (xx + yy) + root); // the longer of the ellipse's own axes
    precise bool magnifies = !(major > 1.0f);          // also where it is no number
    if (magnifies) {
        return taps;
    }
    float most = to_float(levels);
    bool finite = is_finite1(major);
    float minor = max1(rough_divide(abs1(a[0] * b[1] - a[1] * b[0]), major), rough_divide(major, TAPS_MOST));
    float thick = clamp1(minor, 1.0f, 65536.0f);
    uint exponent = (floatBitsToUint(thick) >> 23u) - 127u; // the level below, whole
    float level = look == LOOK_WHOLE ? rough_log(thick) * 1.44269504f : to_float(exponent);
    taps.level = finite ? min1(level, most) : most;
    if (look != LOOK_POINT && finite) {
        float most_points = look == LOOK_WHOLE ? TAPS_MOST : LINE_TAPS_MOST;
        float points = clamp1(rough_divide(major, thick), 1.0f, most_points);
        taps.count = to_uint(points + 0.999f);
        // the ellipse's direction: of two forms, the one that does not cancel
        vec2 along = difference >= 0.0f ? vec2(difference + root, xy) : vec2(xy, root - difference);
        float scale = rough_divide(major, max1(rough_sqrt(dot2(along, along)), 1e-30f));
        vec2 reach = vec2(rough_divide(along[0] * scale, size[0]), rough_divide(along[1] * scale, size[1]));
        vec2 step = reach * rough_divide(1.0f, to_float(taps.count));
        taps.step = store2(step);
        taps.first = store2((step - reach) * 0.5f);
    }
    return taps;
}

// Whether one value of the finest level is all that is read.
FN bool taps_are_one_point(clast_texture_taps taps) { return taps.count == 1u && taps.level == 0.0f; }

// A footprint under KHR_texture_transform, whose offset moves no difference.
FN clast_footprint transform_footprint(clast_texture_use use, clast_footprint at)
{
    clast_texture_use turned = use;
    turned.offset = store2(splat2(0.0f));
    clast_footprint made;
    made.first = store2(transform_coordinates(turned, load2(at.first)));
    made.second = store2(transform_coordinates(turned, load2(at.second)));
    return made;
}

// The mean of values of which `before` came before this one. Of equal ones, that value to the bit.
FN vec4 mean_with(vec4 mean, vec4 value, uint before)
{
    return before == 0u ? value : mean + (value - mean) * rough_divide(1.0f, to_float(before + 1u));
}

// A value of a normal map at a level, as a vector that is as long as the directions it stands for agree. The finest level's stand
// for one; below it, values are means of such vectors, so that their blends are, too.
FN vec4 normal_vector(vec4 value, uint level)
{
    vec3 vector = vec3(2.0f * value[0] - 1.0f, 2.0f * value[1] - 1.0f, 2.0f * value[2] - 1.0f);
    vector = level == 0u ? normalize3(vector) : vector;
    return vec4(vector[0], vector[1], vector[2], 0.0f);
}

// Such a vector as a value of a normal map, with what its length lacks of one. Less than what rounding may make of it is nothing:
// what is a mirror stays one.
FN vec4 normal_value(vec4 mean)
{
    vec3 vector = vec3(mean[0], mean[1], mean[2]);
    float agreement = length3(vector);
    vec3 halved = agreement > 1e-6f ? vector * rough_divide(0.5f, agreement) : vec3(0.0f, 0.0f, 0.5f);
    return vec4(halved[0] + 0.5f, halved[1] + 0.5f, halved[2] + 0.5f, clamp1(1.0f - NORMAL_ROUNDING - agreement, 0.0f, 1.0f));
}

#endif
