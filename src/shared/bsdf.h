// SPDX-License-Identifier: Apache-2.0
// All that glTF's material extensions put together: a base (brdf.h), which may be glass instead, under a fuzz, under a clear
// coat. Directions are in the surface's own frame, z along the normal, the view on its side; light may come from below where
// there is glass.
//
// Each layer takes from what is below it as much as it reflects, seen from the viewer (Turquin, Practical Multiple Scattering
// Compensation for Microfacet Models, 2019): white stays white.
#ifndef CLAST_SHARED_BSDF_H
#define CLAST_SHARED_BSDF_H

#include "shared/brdf.h"

TABLE float SHEEN_ALPHA_LEAST = 0.02f;
TABLE float GLASS_LEAST_BEND = 2e-3f; // of an index of refraction over the other, beside one: less would leave half vectors nowhere

RECORD(clast_bsdf_input)
{
    clast_brdf_input base;
    float transmission;        // 0 to 1: how much of what is not metal is glass
    float dispersion;          // of the glass: 20 over its Abbe number
    uint colour;               // 0 red, 1 green, 2 blue: the only light that there is, where glass disperses; else 0
    float through;             // 0 to 1: how much of the diffuse part leaves on the other side
    packed3 through_colour;
    uint thin;                 // 1: glass without a volume: what passes is not refracted
    uint inside;               // 1: the view is in the volume
    float clearcoat;           // 0 to 1
    float clearcoat_roughness;
    packed3 clearcoat_normal;  // in the surface's frame
    packed3 sheen;             // colour; zero is none
    float sheen_roughness;
};
RECORD_SIZE(clast_bsdf_input, 128)

// What a surface with nothing beside its base is.
FN clast_bsdf_input bsdf_input(clast_brdf_input base)
{
    clast_bsdf_input made;
    made.base = base;
    made.transmission = 0.0f;
    made.dispersion = 0.0f;
    made.colour = 0u;
    made.through = 0.0f;
    made.through_colour = store3(splat3(1.0f));
    made.thin = 1u;
    made.inside = 0u;
    made.clearcoat = 0.0f;
    made.clearcoat_roughness = 0.0f;
    made.clearcoat_normal = store3(vec3(0.0f, 0.0f, 1.0f));
    made.sheen = store3(splat3(0.0f));
    made.sheen_roughness = 0.0f;
    return made;
}

RECORD(clast_bsdf)
{
    clast_brdf base;
    packed3 tint;              // of what passes glass
    packed3 through;           // of what leaves diffusely on the other side: as brdf.diffuse
    float glass;               // 0 to 1: of the base
    uint thin;
    float eta;                 // the glass's index of refraction over that on the viewer's side
    packed3 glass_gain;        // over what a single scattering loses
    float glass_specular;      // KHR_materials_specular
    float film;                // 0 to 1: how much of the glass reflects as
    packed3 film_reflects;     // a film on it does
    float coat;
    float coat_alpha;
    packed3 coat_normal;
    packed3 sheen;
    float sheen_alpha;
    float sheen_passed;        // what is left for the layers below, seen from the viewer
    float coat_passed;
    float coat_share;          // of the samples; the base gets the rest
    float sheen_share;
    float glass_share;
    float through_share;
};
RECORD_SIZE(clast_bsdf, 212)

// ---------------------------------------------------------------------------------------------------------------- sheen

// Estevez and Kulla, Production Friendly Microfacet Sheen BRDF, 2017: distribution and the fit of its masking.
FN float sheen_distribution(float alpha, float cosine)
{
    float sine = rough_sqrt(clamp1(1.0f - cosine * cosine, 0.0f, 1.0f));
    float power = rough_divide(1.0f, alpha);
    return (2.0f + power) * rough_pow(max1(sine, 1e-6f), power) * (0.5f * INVERSE_PI);
}

FN float sheen_fit(float x, float alpha)
{
    float t = (1.0f - alpha) * (1.0f - alpha);
    float a = mix1(21.5473f, 25.3245f, t);
    float b = mix1(3.82987f, 3.32435f, t);
    float c = mix1(0.19823f, 0.16801f, t);
    float d = mix1(-1.97760f, -1.27393f, t);
    float e = mix1(-4.32054f, -4.85967f, t);
    return rough_divide(a, 1.0f + b * rough_pow(max1(x, 1e-6f), c)) + d * x + e;
}

FN float sheen_masking(float cosine, float alpha)
{
    return cosine < 0.5f ? rough_exp(sheen_fit(cosine, alpha))
                         : rough_exp(2.0f * sheen_fit(0.5f, alpha) - sheen_fit(1.0f - cosine, alpha));
}

// White fuzz, times the cosine of the light.
FN float sheen_value(float alpha, vec3 view, vec3 light)
{
    vec3 h = normalize3(view + light + vec3(0.0f, 0.0f, 1e-9f));
    float masking = 1.0f + sheen_masking(view[2], alpha) + sheen_masking(light[2], alpha);
    return rough_divide(sheen_distribution(alpha, h[2]), 4.0f * max1(view[2], 1e-4f) * masking);
}

// ---------------------------------------------------------------------------------------------------------------- glass

// Fresnel's equations for unpolarised light; `eta` is the index of refraction beyond over that before. `cosine` is not
// negative.
FN float fresnel_dielectric(float cosine, float eta)
{
    float c = clamp1(cosine, 0.0f, 1.0f);
    float square = rough_divide(1.0f - c * c, eta * eta);
    float t = rough_sqrt(max1(1.0f - square, 0.0f));
    float across = rough_divide(c - eta * t, max1(c + eta * t, 1e-9f));
    float along = rough_divide(eta * c - t, max1(eta * c + t, 1e-9f));
    return square >= 1.0f ? 1.0f : 0.5f * (across * across + along * along);
}

// The index of refraction for red, green or blue light: KHR_materials_dispersion has these differ from green's by its measure of
// Abbe's number. No light is faster than where there is nothing.
FN float dispersed_ior(float ior, float dispersion, uint colour)
{
    float spread = (ior - 1.0f) * 0.025f * dispersion;
    float other = colour == 0u ? ior - spread : colour == 2u ? ior + spread : ior;
    return ior > 0.0f ? max1(other, 1.0f) : ior;
}

// Through a facet of normal h, which faces the view; zero where all is reflected.
FN vec3 refract_view(vec3 view, vec3 h, float eta)
{
    float cosine = dot3(view, h);
    float square = rough_divide(1.0f - cosine * cosine, eta * eta);
    float beyond = rough_sqrt(max1(1.0f - square, 0.0f));
    vec3 light = h * (rough_divide(cosine, eta) - beyond) - view * rough_divide(1.0f, eta);
    return square >= 1.0f ? splat3(0.0f) : light;
}

// Of what a facet does not pass: the dielectric's reflectance, which KHR_materials_specular weakens, or that of a film.
FN vec3 glass_reflectance(clast_bsdf bsdf, float cosine)
{
    float full = fresnel_dielectric(cosine, bsdf.eta);
    vec3 partial = mix3(splat3(full * bsdf.glass_specular), load3(bsdf.film_reflects), bsdf.film);
    return full >= 1.0f ? splat3(1.0f) : partial;
}

// The part of the samples that is reflected.
FN float glass_reflects(vec3 reflectance)
{
    return rough_divide(reflectance[0] + reflectance[1] + reflectance[2], 3.0f);
}

FN float glass_smith(vec2 alpha, vec3 v)
{
    float cosine = abs1(v[2]);
    float root = smith_root(alpha, v);
    return rough_divide(root - cosine, 2.0f * max1(cosine, 1e-6f)); // Smith's lambda
}

// Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. White, times the cosine; light that
// becomes dense in the glass is not counted so, as it leaves it again. Thin glass sends on what it would reflect, to the
// other side.
FN clast_brdf_answer glass_evaluate(clast_bsdf bsdf, vec3 view, vec3 light)
{
    clast_brdf_answer answer;
    answer.value = store3(splat3(0.0f));
    answer.density = 0.0f;
    vec2 alpha = load2(bsdf.base.alpha);
    bool passes = light[2] < 0.0f;
    bool as_mirror = !passes || bsdf.thin != 0u;
    vec3 there = passes && as_mirror ? vec3(light[0], light[1], -light[2]) : light;
    vec3 h = as_mirror ? view + there : (view + there * bsdf.eta) * -1.0f;
    h = normalize3(h);
    h = h[2] < 0.0f ? h * -1.0f : h;
    float from_view = dot3(view, h);
    float from_light = dot3(there, h);
    bool sound = from_view > 0.0f && (as_mirror ? from_light > 0.0f : from_light < 0.0f) && abs1(light[2]) > 1e-6f;
    // Close to no refraction at all, half vectors are nowhere.
    sound = sound && h[2] > 0.0f;
    if (sound) {
        vec3 reflectance = glass_reflectance(bsdf, from_view);
        float reflects = glass_reflects(reflectance);
        float weight = passes ? 1.0f - reflects : reflects;
        float masked = glass_smith(alpha, view);
        float density = rough_divide(ggx_distribution(alpha, h) * from_view, view[2] * (1.0f + masked)); // of h
        float sum = from_view + bsdf.eta * from_light;
        float spread = as_mirror ? rough_divide(1.0f, 4.0f * from_view)
                                 : rough_divide(bsdf.eta * bsdf.eta * abs1(from_light), max1(sum * sum, 1e-20f));
        float shadowed = rough_divide(1.0f + masked, 1.0f + masked + glass_smith(alpha, there)); // G2 / G1
        answer.density = weight * density * spread;
        vec3 colour = passes ? load3(bsdf.tint) * (splat3(1.0f) - reflectance) : reflectance;
        answer.value = store3(colour * load3(bsdf.glass_gain) * (density * spread * shadowed));
    }
    return answer;
}

FN vec3 glass_direction(clast_bsdf bsdf, vec3 view, vec2 u, float choice)
{
    vec3 h = ggx_visible_normal(load2(bsdf.base.alpha), view, u);
    float cosine = dot3(view, h);
    vec3 mirrored = h * (2.0f * cosine) - view;
    bool reflects = choice < glass_reflects(glass_reflectance(bsdf, cosine));
    vec3 passed = bsdf.thin != 0u ? vec3(mirrored[0], mirrored[1], -mirrored[2]) : refract_view(view, h, bsdf.eta);
    vec3 direction = reflects ? mirrored : passed;
    bool sound = reflects ? direction[2] > 0.0f : direction[2] < 0.0f;
    return sound ? direction : splat3(0.0f);
}

// ---------------------------------------------------------------------------------------------------------- all of them

FN vec3 coat_view(clast_bsdf bsdf, vec3 v)
{
    return to_basis(basis_around(load3(bsdf.coat_normal)), v);
}

// What glass gives back of white light, seen from the view: of what it reflects by Fresnel's equations and passes, and
// likewise if facets passed all that they can.
RECORD(clast_glass_albedo)
{
    float full;
    float bare;
};
RECORD_SIZE(clast_glass_albedo, 8)

FN clast_glass_albedo glass_albedo(float full, float bare)
{
    clast_glass_albedo made;
    made.full = full;
    made.bare = bare;
    return made;
}

// Over the index of refraction of what glass lies in.
FN float glass_ior(float ior) { return max1(ior, 1.0f + GLASS_LEAST_BEND); }

// Glass as the view sees it.
FN clast_bsdf glass_make(clast_bsdf bsdf, clast_bsdf_input from, vec3 view, clast_glass_albedo albedo)
{
    float ior = glass_ior(from.base.ior);
    bsdf.tint = from.base.base_colour;
    bsdf.glass = from.transmission * (1.0f - from.base.metallic);
    bsdf.thin = from.thin;
    bsdf.eta = from.inside != 0u && from.thin == 0u ? rough_divide(1.0f, ior) : ior;
    bsdf.glass_specular = from.base.specular;
    bsdf.film = from.base.film;
    bsdf.film_reflects = store3(splat3(0.0f));
    float partial = mix1(albedo.bare, albedo.full, from.base.specular);
    vec3 back = splat3(partial);
    if (from.base.film > 0.0f && bsdf.glass > 0.0f) {
        vec3 reflects = thin_film_reflectance(from.base.film_ior, from.base.film_thickness, view[2],
                                              dielectric_reflectance(from.base));
        bsdf.film_reflects = store3(reflects);
        vec3 with_film = splat3(albedo.bare) + reflects * (1.0f - bsdf.base.loss - albedo.bare);
        back = mix3(back, with_film, from.base.film);
    }
    bsdf.glass_gain = store3(vec3(rough_divide(1.0f, max1(back[0], 0.05f)), rough_divide(1.0f, max1(back[1], 0.05f)),
                                  rough_divide(1.0f, max1(back[2], 0.05f))));
    return bsdf;
}

// What leaves diffusely on the other side, taken from what leaves on the viewer's (KHR_materials_diffuse_transmission).
FN clast_bsdf through_make(clast_bsdf bsdf, clast_bsdf_input from, float rest)
{
    vec3 diffuse = load3(bsdf.base.diffuse);
    float passed = max1(passed_layer(bsdf.base, ggx_mean_albedo(bsdf.base.roughness)), 1e-6f);
    float seen = rough_divide(bsdf.base.layer_passed, passed);
    vec3 through = load3(from.through_colour) * ((1.0f - from.base.metallic) * from.through * seen);
    bsdf.through = store3(through);
    bsdf.base.diffuse = store3(diffuse * (1.0f - from.through));
    float beyond = luminance(through);
    float all = beyond + luminance(load3(bsdf.base.diffuse)) + 1e-6f;
    bsdf.through_share = rest * (1.0f - bsdf.base.specular_share) * rough_divide(beyond, all);
    return bsdf;
}

// `alpha_floor` as lobe_alpha has it. `sheen_albedo` is what white fuzz of this roughness gives back of white light, seen from
// the view.
FN clast_bsdf bsdf_make(clast_bsdf_input from, float alpha_floor, vec3 view, clast_glass_albedo glass, float sheen_albedo)
{
    clast_bsdf bsdf;
    bsdf.base = brdf_make(from.base, alpha_floor, view[2]);
    bsdf = glass_make(bsdf, from, view, glass);
    bsdf.coat = from.clearcoat;
    bsdf.coat_alpha = max1(max1(from.clearcoat_roughness * from.clearcoat_roughness, ALPHA_LEAST), alpha_floor);
    bsdf.coat_normal = from.clearcoat_normal;
    bsdf.sheen = from.sheen;
    bsdf.sheen_alpha = max1(from.sheen_roughness * from.sheen_roughness, SHEEN_ALPHA_LEAST);
    float fuzz = clamp1(largest3(load3(from.sheen)), 0.0f, 1.0f) * sheen_albedo;
    bsdf.sheen_passed = 1.0f - fuzz;
    float on_coat = bsdf.coat > 0.0f ? clamp1(coat_view(bsdf, view)[2], 0.0f, 1.0f) : 1.0f;
    float reflected = 1.0f - passed_below(DIELECTRIC_F0, 1.0f, ggx_albedo(rough_sqrt(bsdf.coat_alpha), on_coat));
    bsdf.coat_passed = 1.0f - bsdf.coat * reflected;
    bsdf.coat_share = bsdf.coat > 0.0f ? clamp1(bsdf.coat * reflected, 0.1f, 0.5f) : 0.0f;
    bsdf.sheen_share = fuzz > 0.0f ? (1.0f - bsdf.coat_share) * clamp1(fuzz, 0.1f, 0.5f) : 0.0f;
    float rest = 1.0f - bsdf.coat_share - bsdf.sheen_share;
    bsdf.glass_share = rest * bsdf.glass;
    bsdf.through = store3(splat3(0.0f));
    bsdf.through_share = 0.0f;
    if (from.through > 0.0f) {
        bsdf = through_make(bsdf, from, rest - bsdf.glass_share);
    }
    return bsdf;
}

// Whether light from the other side is scattered too.
FN bool bsdf_passes(clast_bsdf bsdf) { return bsdf.glass > 0.0f || bsdf.through_share > 0.0f; }

FN clast_brdf_answer coat_evaluate(clast_bsdf bsdf, vec3 view, vec3 light)
{
    clast_brdf_answer answer;
    answer.value = store3(splat3(0.0f));
    answer.density = 0.0f;
    vec3 v = coat_view(bsdf, view);
    vec3 l = coat_view(bsdf, light);
    if (v[2] > 0.0f && l[2] > 0.0f) {
        vec2 alpha = splat2(bsdf.coat_alpha);
        vec3 h = normalize3(v + l + vec3(0.0f, 0.0f, 1e-9f));
        float view_root = smith_root(alpha, v);
        float distribution = ggx_distribution(alpha, h);
        float visibility = rough_divide(0.5f, max1(l[2] * view_root + v[2] * smith_root(alpha, l), 1e-20f));
        float fresnel = mix1(DIELECTRIC_F0, 1.0f, fifth_power(clamp1(1.0f - dot3(v, h), 0.0f, 1.0f)));
        answer.value = store3(splat3(bsdf.coat * fresnel * distribution * visibility * l[2]));
        answer.density = rough_divide(0.5f * distribution, v[2] + view_root);
    }
    return answer;
}

// The scattered part of light from a direction, times the size of its cosine, and the density with which bsdf_direction
// finds it.
FN clast_brdf_answer bsdf_evaluate(clast_bsdf bsdf, vec3 view, vec3 light)
{
    float below = bsdf.coat_passed * bsdf.sheen_passed;
    float base_share = 1.0f - bsdf.coat_share - bsdf.sheen_share - bsdf.glass_share - bsdf.through_share;
    clast_brdf_answer base = brdf_evaluate(bsdf.base, view, light);
    vec3 value = load3(base.value) * (below * (1.0f - bsdf.glass));
    float density = base_share * base.density;
    if (bsdf.glass > 0.0f) {
        clast_brdf_answer glass = glass_evaluate(bsdf, view, light);
        value = value + load3(glass.value) * (below * bsdf.glass);
        density = density + bsdf.glass_share * glass.density;
    }
    if (bsdf.through_share > 0.0f && light[2] < 0.0f) {
        float passed = max1(passed_layer(bsdf.base, ggx_albedo(bsdf.base.roughness, -light[2])), 0.0f);
        float cosine = -light[2] * INVERSE_PI;
        value = value + load3(bsdf.through) * (below * (1.0f - bsdf.glass) * passed * cosine);
        density = density + bsdf.through_share * cosine;
    }
    if (bsdf.sheen_share > 0.0f && light[2] > 0.0f) {
        float fuzz = sheen_value(bsdf.sheen_alpha, view, light);
        value = value + load3(bsdf.sheen) * (fuzz * bsdf.coat_passed);
        density = density + bsdf.sheen_share * (0.5f * INVERSE_PI);
    }
    if (bsdf.coat_share > 0.0f && light[2] > 0.0f) {
        clast_brdf_answer coat = coat_evaluate(bsdf, view, light);
        value = value + load3(coat.value);
        density = density + bsdf.coat_share * coat.density;
    }
    clast_brdf_answer answer;
    answer.value = store3(value);
    answer.density = density;
    return answer;
}

// A direction to follow, and of what kind of lobe it is.
RECORD(clast_bsdf_sample)
{
    packed3 direction; // zero where the path ends
    uint diffuse;      // 1: of a lobe that is wide whatever the roughness
};
RECORD_SIZE(clast_bsdf_sample, 16)

// `lobe` in [0, 1) chooses between the lobes.
FN clast_bsdf_sample bsdf_direction(clast_bsdf bsdf, vec3 view, vec2 u, float lobe)
{
    clast_bsdf_sample made;
    precise float rest = 1.0f - bsdf.coat_share - bsdf.sheen_share - bsdf.glass_share - bsdf.through_share;
    precise float through_end = rest + bsdf.through_share;
    precise float glass_end = through_end + bsdf.glass_share;
    precise float sheen_end = glass_end + bsdf.sheen_share;
    precise bool of_base = lobe < rest;
    precise bool of_through = lobe < through_end;
    precise bool of_glass = lobe < glass_end;
    precise bool of_sheen = lobe < sheen_end;
    made.diffuse = 0u;
    if (of_base) {
        float at = rough_divide(lobe, rest);
        made.direction = store3(brdf_direction(bsdf.base, view, u, at));
        made.diffuse = at < bsdf.base.specular_share ? 0u : 1u;
    } else if (of_through) {
        vec3 up = sample_cosine_hemisphere(u);
        made.direction = store3(vec3(up[0], up[1], -up[2]));
        made.diffuse = 1u;
    } else if (of_glass) {
        made.direction = store3(glass_direction(bsdf, view, u, rough_divide(lobe - through_end, bsdf.glass_share)));
    } else if (of_sheen) {
        vec2 circle = circle_point(u[1]);
        float level = rough_sqrt(max1(1.0f - u[0] * u[0], 0.0f));
        made.direction = store3(vec3(level * circle[0], level * circle[1], u[0]));
        made.diffuse = 1u;
    } else {
        clast_basis around = basis_around(load3(bsdf.coat_normal));
        vec3 v = to_basis(around, view);
        vec3 h = ggx_visible_normal(splat2(bsdf.coat_alpha), vec3(v[0], v[1], max1(v[2], 1e-6f)), u);
        made.direction = store3(from_basis(around, h * (2.0f * dot3(v, h)) - v));
    }
    // Of all lobes, only these go below.
    bool passes = !of_base && of_glass;
    bool ends = !passes && load3(made.direction)[2] <= 0.0f;
    made.direction = ends ? store3(splat3(0.0f)) : made.direction;
    return made;
}

#endif
