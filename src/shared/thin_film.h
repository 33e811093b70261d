// SPDX-License-Identifier: Apache-2.0
// What a thin film on a surface reflects: light from its two sides interferes. Belcour and Barla, A Practical Extension to
// Microfacet Theory for the Modeling of Varying Iridescence, SIGGRAPH 2017, in the form that KHR_materials_iridescence gives
// it: Schlick's reflectances, and two terms of the series.
#ifndef CLAST_SHARED_THIN_FILM_H
#define CLAST_SHARED_THIN_FILM_H

#include "shared/sampling.h"

TABLE float FILM_LONGEST_PATH = 1e-3f; // metres: nothing is left of interference long before

// The spectrum of a wave of interference as the eye's sensitivities see it, in linear sRGB. `path` is by how much one way is
// longer than the other, in metres; `shift` is by how much its phases are apart beside that.
FN vec3 interference_colour(float path, vec3 shift)
{
    float phase = 2.0f * PI * path;
    float square = phase * phase;
    // Gaussians in frequency: value * sqrt(2 pi variance) over the whole's 1.0685e-7, place, variance.
    float x = 0.84659000f * rough_cos(1.6810e6f * phase + shift[0]) * rough_exp(-4.3278e9f * square) +
              0.15386831f * rough_cos(2.2399e6f * phase + shift[0]) * rough_exp(-4.5282e9f * square);
    float y = 1.00022189f * rough_cos(1.7953e6f * phase + shift[1]) * rough_exp(-9.3046e9f * square);
    float z = 1.00112249f * rough_cos(2.2084e6f * phase + shift[2]) * rough_exp(-6.6121e9f * square);
    return vec3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z, -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
                0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
}

FN float film_schlick(float f0, float cosine)
{
    float rest = clamp1(1.0f - cosine, 0.0f, 1.0f);
    float square = rest * rest;
    return f0 + (1.0f - f0) * (square * square * rest);
}

FN float film_border(float ior, float other)
{
    float root = rough_divide(ior - other, ior + other);
    return root * root;
}

// The index of refraction of what reflects as much head on.
FN float film_base_ior(float f0)
{
    float root = rough_sqrt(clamp1(f0, 0.0f, 0.9999f));
    return rough_divide(1.0f + root, 1.0f - root);
}

// Reflectance seen under a cosine of a film of an index of refraction and a thickness in nanometres, on a base that reflects
// `base` head on without it.
FN vec3 thin_film_reflectance(float ior, float thickness, float cosine, vec3 base)
{
    float inside = 1.0f - rough_divide(1.0f - cosine * cosine, ior * ior);
    float beyond = rough_sqrt(max1(inside, 0.0f)); // cosine in the film
    float outer = film_schlick(film_border(ior, 1.0f), cosine);
    float passed = 1.0f - outer;
    vec3 shift = splat3(PI);
    vec3 inner = splat3(0.0f);
    for (uint i = 0u; i < 3u; i++) {
        float base_ior = film_base_ior(base[i]);
        inner[i] = film_schlick(film_border(base_ior, ior), beyond);
        shift[i] = base_ior < ior ? 2.0f * PI : PI;
    }
    float path = min1(2e-9f * ior * thickness * beyond, FILM_LONGEST_PATH);
    vec3 both = min3(inner * outer, splat3(0.9999f));
    vec3 root = vec3(rough_sqrt(both[0]), rough_sqrt(both[1]), rough_sqrt(both[2]));
    vec3 again = vec3(rough_divide(inner[0], 1.0f - both[0]), rough_divide(inner[1], 1.0f - both[1]),
                      rough_divide(inner[2], 1.0f - both[2])) *
                 (passed * passed);
    vec3 once = (again - splat3(passed)) * root;
    vec3 first = interference_colour(path, shift);
    vec3 second = interference_colour(2.0f * path, shift * 2.0f);
    vec3 sum = splat3(outer) + again + (once * first + once * root * second) * 2.0f;
    return min3(max3(sum, splat3(0.0f)), splat3(1.0f));
}

#endif
