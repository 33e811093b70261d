// SPDX-License-Identifier: Apache-2.0
// From radiance to what a display shows.
#ifndef CLAST_SHARED_TONE_MAP_H
#define CLAST_SHARED_TONE_MAP_H

#include "shared/enums.h"
#include "shared/texture_filter.h"

FN float aces_curve(float x)
{
    return rough_divide(x * (x + 0.0245786f) - 0.000090537f, x * (0.983729f * x + 0.4329510f) + 0.238081f);
}

// The Academy's reference rendering and output transform for an sRGB display, as Stephen Hill fitted it: into its
// primaries, a curve for each, back. The gain before it leaves a mid grey of 0.18 as bright as it was.
FN vec3 tone_map_aces(vec3 colour)
{
    vec3 c = colour * 1.462f;
    float r = aces_curve(0.59719f * c[0] + 0.35458f * c[1] + 0.04823f * c[2]);
    float g = aces_curve(0.07600f * c[0] + 0.90834f * c[1] + 0.01566f * c[2]);
    float b = aces_curve(0.02840f * c[0] + 0.13383f * c[1] + 0.83777f * c[2]);
    return vec3(1.60475f * r - 0.53108f * g - 0.07367f * b, -0.10208f * r + 1.10813f * g - 0.00605f * b,
                -0.00327f * r - 0.07276f * g + 1.07602f * b);
}

// Sobotka's AgX, by Wrensch's fit of its curve. What it gives is for a display with a plain power of 2.2.
FN float agx_curve(float x)
{
    float x2 = x * x;
    float x4 = x2 * x2;
    return 15.5f * x4 * x2 - 40.14f * x4 * x + 31.96f * x4 - 6.868f * x2 * x + 0.4298f * x2 + 0.1191f * x - 0.00232f;
}

FN float agx_place(float x)
{
    float stops = rough_log(max1(x, 1e-10f)) * 1.44269504f; // of two
    return clamp1(rough_divide(stops + 12.47393f, 16.5f), 0.0f, 1.0f);
}

FN vec3 tone_map_agx(vec3 c)
{
    float r = agx_curve(agx_place(0.842479062f * c[0] + 0.0784335999f * c[1] + 0.0792237451f * c[2]));
    float g = agx_curve(agx_place(0.0423282422f * c[0] + 0.878468636f * c[1] + 0.0791661275f * c[2]));
    float b = agx_curve(agx_place(0.0423756549f * c[0] + 0.0784336f * c[1] + 0.879142974f * c[2]));
    vec3 display = vec3(1.196879f * r - 0.0980208811f * g - 0.0990297441f * b,
                        -0.0528968518f * r + 1.15190313f * g - 0.0989611768f * b,
                        -0.0529716355f * r - 0.0980434501f * g + 1.15107367f * b);
    return vec3(rough_pow(max1(display[0], 0.0f), 2.2f), rough_pow(max1(display[1], 0.0f), 2.2f),
                rough_pow(max1(display[2], 0.0f), 2.2f));
}

// The Khronos PBR neutral tone map: base colours up to 0.8 come through as they are.
FN vec3 tone_map_neutral(vec3 c)
{
    float least = min1(c[0], min1(c[1], c[2]));
    float offset = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    vec3 lowered = c - splat3(offset);
    float peak = largest3(lowered);
    float start = 0.8f - 0.04f;
    float room = 1.0f - start;
    float squeezed = 1.0f - rough_divide(room * room, max1(peak + room - start, 1e-6f));
    float white = 1.0f - rough_divide(1.0f, 0.15f * (peak - squeezed) + 1.0f);
    vec3 bright = mix3(lowered * rough_divide(squeezed, max1(peak, 1e-6f)), splat3(squeezed), white);
    return peak < start ? lowered : bright;
}

// Each component to 0 at least, and `high` at most.
FN vec3 clamp_each(vec3 v, float high)
{
    return vec3(clamp1(v[0], 0.0f, high), clamp1(v[1], 0.0f, high), clamp1(v[2], 0.0f, high));
}

// Display values in [0, 1], sRGB encoded. `gain` is two to the power of the exposure.
FN vec3 tone_map(vec3 radiance, float gain, uint curve)
{
    // Beyond 1e6 all curves are flat; their squares would not be finite.
    vec3 c = clamp_each(radiance * gain, 1e6f);
    if (curve == CLAST_TONE_MAP_ACES) {
        c = tone_map_aces(c);
    } else if (curve == CLAST_TONE_MAP_AGX) {
        c = tone_map_agx(c);
    } else if (curve == CLAST_TONE_MAP_NEUTRAL) {
        c = tone_map_neutral(c);
    }
    c = clamp_each(c, 1.0f);
    return vec3(linear_to_srgb(c[0]), linear_to_srgb(c[1]), linear_to_srgb(c[2]));
}

// Hue, saturation, value, each 0 to 1.
FN vec3 hsv_to_rgb(vec3 hsv)
{
    float h = 6.0f * (hsv[0] - floor1(hsv[0]));
    vec3 full = clamp_each(vec3(abs1(h - 3.0f) - 1.0f, 2.0f - abs1(h - 2.0f), 2.0f - abs1(h - 4.0f)), 1.0f);
    return mix3(splat3(1.0f), full, hsv[1]) * hsv[2];
}

// Dark blue, blue, cyan, green, yellow, red, dark red: brightest in the middle, so that steps stay apart at both ends.
FN vec3 heat_colour(float x)
{
    float t = clamp1(x, 0.0f, 1.0f);
    float low = min1(t * 4.0f, 1.0f);
    float high = min1((1.0f - t) * 4.0f, 1.0f);
    vec3 hue = hsv_to_rgb(vec3(0.68f * (1.0f - t), 0.9f, 1.0f));
    return hue * (0.35f + 0.65f * min1(low, high));
}

// Black, violet, red, orange, pale yellow: brighter with every step, also to eyes that see no colours.
FN vec3 ember_colour(float x)
{
    float t = clamp1(x, 0.0f, 1.0f);
    float red = clamp1(2.6f * t - 0.05f, 0.0f, 1.0f);
    float green = clamp1(1.7f * t - 0.75f, 0.0f, 0.97f);
    float violet = 1.9f * t * clamp1(1.0f - 1.35f * t, 0.0f, 1.0f);
    float pale = clamp1(5.0f * t - 4.3f, 0.0f, 0.7f);
    return vec3(red, green, max1(violet, pale));
}

#endif
