// SPDX-License-Identifier: Apache-2.0
// Noise for procedural shapes and textures: functions of position and seed alone, built from integer hashes and from
// + - x / and square roots, so that every machine gives the same bits.
//
// Gradient noise: Perlin, Improving Noise, SIGGRAPH 2002. Cellular noise: Worley, A Cellular Texture Basis Function,
// SIGGRAPH 1996. Ridged noise and domain warping: Musgrave in Ebert et al., Texturing and Modeling, 3rd edition.
#ifndef CLAST_GENERATE_NOISE_H
#define CLAST_GENERATE_NOISE_H

#include "shared/random.h"

// Smooth noise, about -1 to 1, features about one unit large.
float clast_noise2(vec2 p, uint seed);
float clast_noise3(vec3 p, uint seed);
// The same, repeating every `period` units along both axes: for textures that tile.
float clast_noise2_tiled(vec2 p, uint period, uint seed);

// Sums of octaves, each twice as fine and half as strong as the one before; about -1 to 1.
float clast_fractal2(vec2 p, uint octaves, uint seed);
float clast_fractal3(vec3 p, uint octaves, uint seed);
float clast_fractal2_tiled(vec2 p, uint period, uint octaves, uint seed);
// With a period for each axis: for grain that runs along one.
float clast_fractal2_banded(vec2 p, uint period_x, uint period_y, uint octaves, uint seed);
// Octaves of 1 - |noise|, weighted by the octave before: sharp crests, smooth valleys. 0 to 1.
float clast_ridged2(vec2 p, uint octaves, uint seed);
float clast_ridged3(vec3 p, uint octaves, uint seed);

// The nearest and second nearest of scattered points, one in each unit cell.
typedef struct clast_cells {
    float nearest, second; // distances
    uint id;               // hash of the nearest
} clast_cells;

clast_cells clast_cells2(vec2 p, uint seed);
clast_cells clast_cells3(vec3 p, uint seed);
clast_cells clast_cells2_tiled(vec2 p, uint period, uint seed);

// Sine of an angle in turns, to about 1e-6; exact at multiples of a quarter turn.
static inline float wave_sine(float turns)
{
    float t = turns - floor1(turns + 0.5f); // -0.5 to 0.5
    t = t > 0.25f ? 0.5f - t : t < -0.25f ? -0.5f - t : t;
    float x = t * 4.0f, x2 = x * x; // -1 to 1, odd polynomial of sin(pi / 2 x)
    return x * (1.57079633f +
                x2 * (-0.64596410f +
                      x2 * (0.079692626f + x2 * (-0.0046817541f + x2 * (0.00016044118f + x2 * -0.0000035988f)))));
}

static inline float wave_cosine(float turns)
{
    return wave_sine(turns + 0.25f);
}

// 0 below `low`, 1 above `high`, smooth between. `low` may be above `high`.
static inline float smooth_step(float low, float high, float x)
{
    float t = clamp1((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// A smooth minimum: differs from the least where the two are within `width` of each other.
static inline float smooth_minimum(float a, float b, float width)
{
    float h = max1(width - abs1(a - b), 0.0f) / width;
    return min1(a, b) - h * h * width * 0.25f;
}

static inline float square(float x)
{
    return x * x;
}
static inline float fraction(float x)
{
    return x - floor1(x);
}
static inline float root(float x)
{
    return sqrtf(max1(x, 0.0f));
}
static inline float length2(vec2 v)
{
    return sqrtf(dot2(v, v));
}
// The angle of a vector in turns, -0.5 to 0.5, to about 1e-4.
static inline float turns_of(float y, float x)
{
    float ax = abs1(x), ay = abs1(y);
    float small = min1(ax, ay), large = max1(ax, ay);
    float t = large > 0.0f ? small / large : 0.0f, t2 = t * t;
    float a = t * (0.15913f + t2 * (-0.0528f + t2 * (0.0287f + t2 * -0.01003f)));
    a = ay > ax ? 0.25f - a : a;
    a = x < 0.0f ? 0.5f - a : a;
    return y < 0.0f ? -a : a;
}

// [0, 1), of a seed and numbers.
static inline float chance(uint seed, uint a, uint b)
{
    return unit_float(hash3(seed, a, b));
}
// [-1, 1)
static inline float swing(uint seed, uint a, uint b)
{
    return 2.0f * chance(seed, a, b) - 1.0f;
}

#endif
