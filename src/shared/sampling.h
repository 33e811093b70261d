// SPDX-License-Identifier: Apache-2.0
// Points to sample with, and maps from the unit square to what is sampled.
//
// Points are Sobol's first two dimensions with Owen's scrambling by hashes, padded: each use (a lens, a light, a lobe
// at a bounce) has points of its own, decorrelated by its number. Laine and Karras, Stratified Sampling for Stochastic
// Transparency, EGSR 2011; Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020. The hash's constants are
// those that Vegdahl found to scramble better. Every power of two of points is a (0, m, 2)-net.
#ifndef CLAST_SHARED_SAMPLING_H
#define CLAST_SHARED_SAMPLING_H

#include "shared/random.h"
#include "shared/records.h"

TABLE float PI = 3.14159265f;
TABLE float INVERSE_PI = 0.318309886f;

FN uint reverse_bits(uint x)
{
    uint y = (x >> 16u) | (x << 16u);
    y = ((y >> 8u) & 0x00ff00ffu) | ((y & 0x00ff00ffu) << 8u);
    y = ((y >> 4u) & 0x0f0f0f0fu) | ((y & 0x0f0f0f0fu) << 4u);
    y = ((y >> 2u) & 0x33333333u) | ((y & 0x33333333u) << 2u);
    return ((y >> 1u) & 0x55555555u) | ((y & 0x55555555u) << 1u);
}

// Each bit is flipped by a hash of the bits below it: Owen's scrambling of a number whose bits are reversed.
FN uint scramble_reversed(uint x, uint seed)
{
    uint y = x ^ (x * 0x3d20adeau);
    y = y + seed;
    y = y * ((seed >> 16u) | 1u);
    y = y ^ (y * 0x05526c56u);
    return y ^ (y * 0x53a22864u);
}

// Sobol's second dimension, bits reversed. Its matrix is Pascal's triangle modulo 2: bit j is the sum of those bits of
// the index whose places contain j, which takes a step for each bit of a place.
FN uint sobol_second_reversed(uint index)
{
    uint x = index ^ ((index >> 1u) & 0x55555555u);
    x = x ^ ((x >> 2u) & 0x33333333u);
    x = x ^ ((x >> 4u) & 0x0f0f0f0fu);
    x = x ^ ((x >> 8u) & 0x00ff00ffu);
    return x ^ (x >> 16u);
}

// Point `index` of the sequence that belongs to a seed, in [0, 1) both ways.
FN vec2 sample_square(uint index, uint seed)
{
    uint shuffled = reverse_bits(scramble_reversed(reverse_bits(index), hash1(seed)));
    uint x = reverse_bits(scramble_reversed(shuffled, hash1(seed ^ 0x9e3779b9u)));
    uint y = reverse_bits(scramble_reversed(sobol_second_reversed(shuffled), hash1(seed ^ 0x7f4a7c15u)));
    return vec2(unit_float(x), unit_float(y));
}

// ------------------------------------------------------------------------------------------------------ pixels' samples

// What a pixel's points follow from.
RECORD(clast_pixel_samples)
{
    uint place; // of the pixel, along a curve that goes through squares of 2, 4, 8, ... pixels one after the other
    uint seed;  // of the picture
    uint power; // of two: how many samples of a pixel there are to be; at most 20
};
RECORD_SIZE(clast_pixel_samples, 12)

// The 16 low bits, each followed by a zero.
FN uint spread_bits(uint x)
{
    uint y = x & 0xffffu;
    y = (y | (y << 8u)) & 0x00ff00ffu;
    y = (y | (y << 4u)) & 0x0f0f0f0fu;
    y = (y | (y << 2u)) & 0x33333333u;
    return (y | (y << 1u)) & 0x55555555u;
}

FN clast_pixel_samples pixel_samples(uint x, uint y, uint seed, uint power)
{
    clast_pixel_samples made;
    made.place = spread_bits(x) | (spread_bits(y) << 1u);
    made.seed = seed;
    made.power = power;
    return made;
}

// Each bit is flipped by a hash of the bits above it.
FN uint shuffle_bits(uint x, uint seed) { return reverse_bits(scramble_reversed(reverse_bits(x), seed)); }

// Point `number` of a pixel for a use. All pixels share one sequence, of which each takes 2^power points that follow each other:
// a net of its own, and pixels of a square together have a net too, so that their errors cancel: what is left of them
// is fine grain. Which part of the sequence a square has, and a pixel's order within its own, are shuffled from square to square, as
// places along curves would show. Ahmed and Wonka, Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via
// Hierarchical Ordering of Pixels, TOG 39(6), 2020. Numbers beyond take another sequence.
FN vec2 square_of_pixel(uint number, clast_pixel_samples pixel, uint use)
{
    uint mask = (1u << pixel.power) - 1u;
    uint key = hash3(number >> pixel.power, use, pixel.seed);
    uint high = shuffle_bits(pixel.place, hash1(key));
    uint low = shuffle_bits(number & mask, hash2(high, key)) & mask;
    // The index has 32 + power bits. The first dimension takes the lower 32 of it; of the second one's matrix, columns 32 to
    // 63 are columns 0 to 31 as far as 32 rows go: the binomials agree modulo 2 (Lucas).
    uint index = (high << pixel.power) | low;
    uint rest = pixel.power == 0u ? 0u : high >> ((32u - pixel.power) & 31u);
    uint x = reverse_bits(scramble_reversed(index, hash1(key ^ 0x9e3779b9u)));
    uint y = reverse_bits(scramble_reversed(sobol_second_reversed(index ^ rest), hash1(key ^ 0x7f4a7c15u)));
    return vec2(unit_float(x), unit_float(y));
}

// -------------------------------------------------------------------------------------------------------------- maps

// (cos, sin) of a quarter turn times q, for |q| <= 0.5: series, so that no machine's own functions are asked.
FN vec2 cosine_and_sine(float q)
{
    float x = q * 1.57079633f;
    float s = x * x;
    float sine = x * (1.0f + s * (-0.166666667f + s * (8.33333333e-3f + s * (-1.98412698e-4f + s * 2.75573192e-6f))));
    float cosine = 1.0f + s * (-0.5f + s * (4.16666667e-2f + s * (-1.38888889e-3f + s * 2.48015873e-5f)));
    return vec2(cosine, sine);
}

// (cos, sin) of an angle in turns, 0 <= turns <= 1
FN vec2 circle_point(float turns)
{
    float quarters = floor1(turns * 4.0f + 0.5f);
    vec2 p = cosine_and_sine(turns * 4.0f - quarters);
    uint quadrant = to_uint(quarters) & 3u;
    p = (quadrant & 1u) != 0u ? vec2(-p[1], p[0]) : p;
    return quadrant >= 2u ? vec2(-p[0], -p[1]) : p;
}

// Unit disc, area-preserving: Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997.
FN vec2 sample_disc(vec2 u)
{
    float a = 2.0f * u[0] - 1.0f;
    float b = 2.0f * u[1] - 1.0f;
    bool wide = abs1(a) > abs1(b);
    float radius = wide ? a : b;
    float ratio = radius == 0.0f ? 0.0f : rough_divide(wide ? b : a, radius);
    vec2 p = cosine_and_sine(0.5f * ratio);
    return wide ? vec2(radius * p[0], radius * p[1]) : vec2(radius * p[1], radius * p[0]);
}

// Hemisphere around +z; density cos / pi.
FN vec3 sample_cosine_hemisphere(vec2 u)
{
    vec2 p = sample_disc(u);
    float square = 1.0f - p[0] * p[0] - p[1] * p[1];
    return vec3(p[0], p[1], rough_sqrt(max1(square, 1e-12f)));
}

// Directions of a cone around +z, uniform by solid angle. `height` is 1 - cos of its half angle: given so, narrow cones
// keep their precision.
FN vec3 sample_cone(vec2 u, float height)
{
    float below = u[0] * height; // 1 - z
    float radius = rough_sqrt(max1(below * (2.0f - below), 0.0f));
    vec2 p = circle_point(u[1]);
    return vec3(radius * p[0], radius * p[1], 1.0f - below);
}

// Weights of a triangle's second and third corner, uniform by area: Heitz, A Low-Distortion Map Between Triangle and
// Square, 2019.
FN vec2 sample_triangle(vec2 u)
{
    return u[1] > u[0] ? vec2(u[0] * 0.5f, u[1] - u[0] * 0.5f) : vec2(u[0] - u[1] * 0.5f, u[1] * 0.5f);
}

// The share of an estimate that a technique of density `mine` gets beside one of density `other`: Veach's power
// heuristic.
FN float mis_weight(float mine, float other)
{
    float ratio = mine > 0.0f ? rough_divide(other, mine) : 0.0f;
    return mine > 0.0f ? rough_divide(1.0f, 1.0f + ratio * ratio) : 0.0f;
}

// Orthonormal vectors; the third is the one that it was made from.
RECORD(clast_basis)
{
    packed3 x;
    packed3 y;
    packed3 z;
};
RECORD_SIZE(clast_basis, 36)

// Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017.
FN clast_basis basis_around(vec3 n)
{
    float sign = n[2] < 0.0f ? -1.0f : 1.0f;
    float a = rough_divide(-1.0f, sign + n[2]);
    float b = n[0] * n[1] * a;
    clast_basis basis;
    basis.x = store3(vec3(1.0f + sign * n[0] * n[0] * a, sign * b, -sign * n[0]));
    basis.y = store3(vec3(b, sign + n[1] * n[1] * a, -n[1]));
    basis.z = store3(n);
    return basis;
}

FN vec3 from_basis(clast_basis basis, vec3 v)
{
    return load3(basis.x) * v[0] + load3(basis.y) * v[1] + load3(basis.z) * v[2];
}

FN vec3 to_basis(clast_basis basis, vec3 v)
{
    return vec3(dot3(load3(basis.x), v), dot3(load3(basis.y), v), dot3(load3(basis.z), v));
}

#endif
