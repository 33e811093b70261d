// SPDX-License-Identifier: Apache-2.0
// Views as pictures to look at: display values, 0 to 1, sRGB encoded, of a pixel of each view.
#ifndef CLAST_SHARED_DISPLAY_H
#define CLAST_SHARED_DISPLAY_H

#include "shared/random.h"
#include "shared/tone_map.h"

RECORD(clast_display)
{
    uint curve;  // CLAST_TONE_MAP_
    float gain;  // two to the power of the exposure
    float area;  // of the triangles that are wanted, in pixels
    float low;   // depth, samples: logarithms of the least and the most; steps: 0 and the most
    float high;
};
RECORD_SIZE(clast_display, 20)

#ifdef VULKAN
FN float rough_log2(float x) { return log2(x); }
#else
FN float rough_log2(float x) { return log2f(x); }
#endif

FN vec3 display_albedo(vec3 albedo)
{
    vec3 v = clamp_each(albedo, 1.0f);
    return vec3(linear_to_srgb(v[0]), linear_to_srgb(v[1]), linear_to_srgb(v[2]));
}

FN vec3 display_normal(vec3 normal)
{
    bool none = normal[0] == 0.0f && normal[1] == 0.0f && normal[2] == 0.0f;
    return none ? normal : clamp_each(normal * 0.5f + splat3(0.5f), 1.0f);
}

FN vec3 display_uv(vec2 uv) { return vec3(uv[0] - floor1(uv[0]), uv[1] - floor1(uv[1]), 0.0f); }

// Neighbouring numbers differ in hue by the golden ratio, and in brightness.
FN vec3 display_number(uint number)
{
    uint bits = hash1(number);
    float hue = to_float(number) * 0.618033989f;
    vec3 colour = hsv_to_rgb(vec3(hue - floor1(hue), 0.45f + 0.4f * unit_float(bits), 0.6f + 0.4f * unit_float(hash1(bits))));
    return number == CLAST_NONE ? splat3(0.0f) : colour;
}

FN bool display_is_there(float x) { return x > 0.0f && is_finite1(x); }

// Near is bright, nothing is black.
FN vec3 display_depth(clast_display how, float depth)
{
    float range = how.high - how.low;
    float place = range > 0.0f ? rough_divide(rough_log(max1(depth, 1e-37f)) - how.low, range) : 0.0f;
    return display_is_there(depth) ? splat3(1.0f - 0.9f * clamp1(place, 0.0f, 1.0f)) : splat3(0.0f);
}

// Up the rainbow with each doubling; even counts are darker, so that neighbouring counts are told apart.
FN vec3 display_segments(float segments)
{
    float whole_half = 0.5f * floor1(segments + 0.5f);
    precise bool even = whole_half == floor1(whole_half);
    vec3 colour = heat_colour(rough_divide(rough_log2(max1(segments, 1.0f)), 8.0f)) * (even ? 0.78f : 1.0f);
    return display_is_there(segments) ? colour : splat3(0.0f);
}

// Grey where all is as it should be, blue below (-1), red above (1).
FN vec3 balance_colour(float x)
{
    float t = clamp1(x, -1.0f, 1.0f);
    vec3 end = t < 0.0f ? vec3(0.10f, 0.30f, 0.80f) : vec3(0.85f, 0.13f, 0.08f);
    return mix3(splat3(0.84f), end, abs1(t));
}

// Of how many times as many there are as there should be.
FN vec3 display_balance(float ratio)
{
    return ratio > 0.0f ? balance_colour(rough_divide(rough_log2(max1(ratio, 1e-37f)), 3.0f)) : splat3(0.0f);
}

FN vec3 display_steps(clast_display how, uint steps)
{
    return steps == CLAST_NONE ? splat3(0.0f) : heat_colour(rough_divide(to_float(steps), how.high));
}

// From the least to the most, up the rainbow by how many times as many there are.
FN vec3 display_samples(clast_display how, uint samples)
{
    float range = how.high - how.low;
    float place = range > 0.0f ? rough_divide(rough_log2(to_float(max_uint(samples, 1u))) - how.low, range) : 0.5f;
    return samples == 0u || samples == CLAST_NONE ? splat3(0.0f) : heat_colour(clamp1(place, 0.0f, 1.0f));
}

// A channel as a whole number up to `most`.
FN uint display_level(float value, float most) { return to_uint(clamp1(value, 0.0f, 1.0f) * most + 0.5f); }

#endif
