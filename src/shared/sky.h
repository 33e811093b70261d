// SPDX-License-Identifier: Apache-2.0
// An atmosphere as the earth's: air, haze and ozone over a sphere. Densities and scattering at a height, for red,
// green and blue (680, 550, 440 nm), in 1 / km. Coefficients: Bruneton, A Qualitative and Quantitative Evaluation of 8
// Clear Sky Models, TVCG 23(12), 2017; haze after Angstrom. Lengths are kilometres.
#ifndef CLAST_SHARED_SKY_H
#define CLAST_SHARED_SKY_H

#include "shared/sampling.h"

TABLE float SKY_GROUND = 6360.0f;      // radius of the earth
TABLE float SKY_TOP = 6460.0f;         // radius of the end of the air
TABLE float SKY_EYE = 6360.2f;         // where the sky is seen from
TABLE float SKY_AIR_HEIGHT = 8.0f;     // over which the density falls by e
TABLE float SKY_HAZE_HEIGHT = 1.2f;
TABLE float SKY_HAZE_FORWARD = 0.76f;  // mean cosine of haze's scattering
TABLE float SKY_HAZE_ALBEDO = 0.94f;
TABLE float SKY_GROUND_ALBEDO = 0.25f;
TABLE float SKY_SUN_IRRADIANCE = 6.0f; // of a surface that faces the sun, above the air: the unit of all radiance here
TABLE float SKY_TURBIDITY = 2.5f;      // where none is given
TABLE float SKY_SUN_RADIUS = 0.00465f; // where none is given: angular, radians

// What happens to light on a kilometre at some height.
RECORD(clast_air)
{
    packed3 air;        // scattered by air
    packed3 haze;       // scattered by haze
    packed3 extinction; // scattered or absorbed by anything
};
RECORD_SIZE(clast_air, 36)

// Turbidity is the optical depth of air and haze over that of air alone, at 550 nm: Linke's measure as Preetham,
// Shirley and Smits (A Practical Analytic Model for Daylight, 1999) use it.
FN clast_air sky_air(float radius, float turbidity)
{
    float height = max1(radius - SKY_GROUND, 0.0f);
    vec3 air = vec3(5.802e-3f, 13.558e-3f, 33.1e-3f) * rough_exp(-rough_divide(height, SKY_AIR_HEIGHT));
    float depth = 13.558e-3f * SKY_AIR_HEIGHT * max1(turbidity - 1.0f, 0.0f);
    float density = rough_divide(depth, SKY_HAZE_HEIGHT) * rough_exp(-rough_divide(height, SKY_HAZE_HEIGHT));
    vec3 haze = vec3(0.759f, 1.0f, 1.337f) * density;
    vec3 ozone = vec3(0.650e-3f, 1.881e-3f, 0.085e-3f) * max1(1.0f - abs1(height - 25.0f) * 0.0666666667f, 0.0f);
    clast_air result;
    result.air = store3(air);
    result.haze = store3(haze * SKY_HAZE_ALBEDO);
    result.extinction = store3(air + haze + ozone);
    return result;
}

FN float sky_air_phase(float cosine) { return 0.0596831037f * (1.0f + cosine * cosine); }

// Cornette and Shanks, Physically Reasonable Analytic Expression for the Single-scattering Phase Function, 1992.
FN float sky_haze_phase(float cosine)
{
    float g = SKY_HAZE_FORWARD;
    float base = max1(1.0f + g * g - 2.0f * g * cosine, 1e-6f);
    float scale = rough_divide(0.119366207f * (1.0f - g * g), 2.0f + g * g);
    return rough_divide(scale * (1.0f + cosine * cosine), base * rough_sqrt(base));
}

// Distance from a point at `radius`, looking up by `cosine`, to a sphere around the earth's centre; negative where it
// is missed. `inside`: the far side.
FN float sky_distance(float radius, float cosine, float sphere, bool inside)
{
    float b = radius * cosine;
    float root = b * b - (radius - sphere) * (radius + sphere);
    float s = rough_sqrt(max1(root, 0.0f));
    float near = -b - s;
    return root < 0.0f ? -1.0f : inside ? s - b : near;
}

// Radius after `distance` along such a ray.
FN float sky_radius(float radius, float cosine, float distance)
{
    return rough_sqrt(max1(radius * radius + distance * (distance + 2.0f * radius * cosine), 1.0f));
}

#endif
