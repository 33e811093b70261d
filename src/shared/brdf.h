// SPDX-License-Identifier: Apache-2.0
// How surfaces scatter light: glTF 2.0's metallic-roughness model (its appendix B), with the light that a rough surface
// scatters more than once given back, and with a thin film where there is one. Directions are in the surface's own frame, z along the normal, both on its side.
#ifndef CLAST_SHARED_BRDF_H
#define CLAST_SHARED_BRDF_H

#include "shared/thin_film.h"

LIMIT(GGX_SIDE, 16u, "rows and columns of GGX_LOSS and GGX_RIM")
LIMIT(GGX_CELLS, 256u, "values of each")
LIMIT(GGX_TABLES, 544u, "of GGX_LOSS, GGX_RIM, GGX_MEAN_LOSS and GGX_MEAN_RIM")
TABLE float DIELECTRIC_F0 = 0.04f;
TABLE float ALPHA_LEAST = 1e-3f; // narrower lobes than the sun's disc look no different, and cost precision

// What single scattering loses of white light under GGX without Fresnel: rows by roughness (square root of alpha),
// columns by the square root of the cosine, both from 0 to 1. The means weigh by cosine.
TABLE float GGX_LOSS[256] = {
    0.0204f, 0.0295f, 0.0018f, 0.0004f, 0.0000f, 0.0000f, 0.0000f, 0.0000f,
    0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f,
    0.0047f, 0.1079f, 0.0355f, 0.0073f, 0.0022f, 0.0009f, 0.0005f, 0.0001f,
    0.0001f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f, 0.0000f,
    0.0012f, 0.0475f, 0.1080f, 0.0779f, 0.0355f, 0.0154f, 0.0073f, 0.0038f,
    0.0022f, 0.0013f, 0.0009f, 0.0006f, 0.0004f, 0.0001f, 0.0000f, 0.0000f,
    0.0005f, 0.0228f, 0.0757f, 0.1090f, 0.0952f, 0.0623f, 0.0363f, 0.0208f,
    0.0124f, 0.0079f, 0.0053f, 0.0039f, 0.0031f, 0.0028f, 0.0024f, 0.0020f,
    0.0003f, 0.0138f, 0.0505f, 0.0909f, 0.1122f, 0.1052f, 0.0821f, 0.0578f,
    0.0392f, 0.0266f, 0.0186f, 0.0136f, 0.0105f, 0.0083f, 0.0067f, 0.0061f,
    0.0002f, 0.0101f, 0.0368f, 0.0719f, 0.1030f, 0.1186f, 0.1151f, 0.0989f,
    0.0785f, 0.0597f, 0.0449f, 0.0341f, 0.0265f, 0.0210f, 0.0173f, 0.0146f,
    0.0002f, 0.0089f, 0.0308f, 0.0608f, 0.0921f, 0.1171f, 0.1297f, 0.1286f,
    0.1172f, 0.1007f, 0.0833f, 0.0678f, 0.0551f, 0.0453f, 0.0378f, 0.0323f,
    0.0002f, 0.0090f, 0.0291f, 0.0565f, 0.0867f, 0.1150f, 0.1363f, 0.1477f,
    0.1485f, 0.1408f, 0.1277f, 0.1124f, 0.0973f, 0.0837f, 0.0722f, 0.0628f,
    0.0002f, 0.0094f, 0.0301f, 0.0573f, 0.0875f, 0.1175f, 0.1437f, 0.1633f,
    0.1747f, 0.1775f, 0.1730f, 0.1632f, 0.1503f, 0.1363f, 0.1226f, 0.1101f,
    0.0003f, 0.0105f, 0.0329f, 0.0617f, 0.0936f, 0.1257f, 0.1556f, 0.1811f,
    0.2005f, 0.2128f, 0.2179f, 0.2167f, 0.2104f, 0.2004f, 0.1884f, 0.1755f,
    0.0003f, 0.0120f, 0.0372f, 0.0690f, 0.1038f, 0.1392f, 0.1729f, 0.2034f,
    0.2293f, 0.2496f, 0.2639f, 0.2720f, 0.2745f, 0.2722f, 0.2660f, 0.2570f,
    0.0004f, 0.0139f, 0.0426f, 0.0784f, 0.1174f, 0.1570f, 0.1953f, 0.2308f,
    0.2626f, 0.2899f, 0.3121f, 0.3292f, 0.3410f, 0.3480f, 0.3505f, 0.3492f,
    0.0004f, 0.0162f, 0.0489f, 0.0896f, 0.1336f, 0.1784f, 0.2218f, 0.2627f,
    0.3002f, 0.3338f, 0.3632f, 0.3880f, 0.4085f, 0.4246f, 0.4366f, 0.4448f,
    0.0005f, 0.0186f, 0.0560f, 0.1021f, 0.1519f, 0.2024f, 0.2515f, 0.2981f,
    0.3413f, 0.3808f, 0.4163f, 0.4479f, 0.4756f, 0.4995f, 0.5199f, 0.5369f,
    0.0006f, 0.0212f, 0.0637f, 0.1158f, 0.1718f, 0.2284f, 0.2835f, 0.3358f,
    0.3846f, 0.4294f, 0.4704f, 0.5074f, 0.5407f, 0.5705f, 0.5970f, 0.6206f,
    0.0007f, 0.0241f, 0.0719f, 0.1303f, 0.1929f, 0.2558f, 0.3170f, 0.3749f,
    0.4288f, 0.4785f, 0.5238f, 0.5650f, 0.6022f, 0.6358f, 0.6660f, 0.6931f
};
TABLE float GGX_MEAN_LOSS[16] = {
    0.00000f, 0.00009f, 0.00119f, 0.00602f, 0.01590f, 0.03322f, 0.05958f, 0.09581f,
    0.14194f, 0.19707f, 0.25942f, 0.32657f, 0.39578f, 0.46433f, 0.52993f, 0.59085f
};


// Laid out alike: the mean of (1 - VH)^5 over what is reflected: the share of white light that comes back because of
// Schlick's term, so that a surface of reflectance f0 gives back f0 (1 - loss - rim) + rim.
TABLE float GGX_RIM[256] = {
    0.9539f, 0.9449f, 0.9116f, 0.8147f, 0.6913f, 0.5548f, 0.4182f, 0.2928f,
    0.1876f, 0.1074f, 0.0529f, 0.0211f, 0.0060f, 0.0010f, 0.0000f, 0.0000f,
    0.9073f, 0.8282f, 0.8658f, 0.8024f, 0.6866f, 0.5527f, 0.4172f, 0.2925f,
    0.1875f, 0.1074f, 0.0530f, 0.0211f, 0.0061f, 0.0010f, 0.0000f, 0.0000f,
    0.7617f, 0.7359f, 0.6970f, 0.6855f, 0.6305f, 0.5269f, 0.4053f, 0.2873f,
    0.1857f, 0.1071f, 0.0532f, 0.0214f, 0.0063f, 0.0010f, 0.0000f, 0.0000f,
    0.6116f, 0.6016f, 0.5742f, 0.5437f, 0.5101f, 0.4516f, 0.3656f, 0.2687f,
    0.1783f, 0.1052f, 0.0535f, 0.0222f, 0.0068f, 0.0012f, 0.0001f, 0.0000f,
    0.4790f, 0.4732f, 0.4557f, 0.4291f, 0.3965f, 0.3552f, 0.2996f, 0.2314f,
    0.1609f, 0.0990f, 0.0525f, 0.0229f, 0.0075f, 0.0016f, 0.0002f, 0.0000f,
    0.3701f, 0.3659f, 0.3530f, 0.3323f, 0.3048f, 0.2714f, 0.2315f, 0.1847f,
    0.1345f, 0.0873f, 0.0491f, 0.0229f, 0.0083f, 0.0020f, 0.0003f, 0.0000f,
    0.2845f, 0.2810f, 0.2707f, 0.2542f, 0.2321f, 0.2054f, 0.1749f, 0.1412f,
    0.1059f, 0.0719f, 0.0429f, 0.0216f, 0.0086f, 0.0024f, 0.0004f, 0.0000f,
    0.2192f, 0.2161f, 0.2075f, 0.1939f, 0.1761f, 0.1549f, 0.1313f, 0.1061f,
    0.0807f, 0.0564f, 0.0352f, 0.0189f, 0.0083f, 0.0027f, 0.0005f, 0.0000f,
    0.1702f, 0.1674f, 0.1600f, 0.1486f, 0.1341f, 0.1171f, 0.0986f, 0.0794f,
    0.0606f, 0.0430f, 0.0277f, 0.0157f, 0.0074f, 0.0026f, 0.0006f, 0.0000f,
    0.1338f, 0.1313f, 0.1248f, 0.1150f, 0.1029f, 0.0891f, 0.0744f, 0.0596f,
    0.0454f, 0.0324f, 0.0213f, 0.0125f, 0.0062f, 0.0024f, 0.0006f, 0.0000f,
    0.1070f, 0.1046f, 0.0987f, 0.0902f, 0.0799f, 0.0685f, 0.0567f, 0.0450f,
    0.0341f, 0.0244f, 0.0161f, 0.0097f, 0.0050f, 0.0021f, 0.0006f, 0.0000f,
    0.0872f, 0.0849f, 0.0795f, 0.0719f, 0.0629f, 0.0533f, 0.0436f, 0.0343f,
    0.0258f, 0.0183f, 0.0122f, 0.0074f, 0.0039f, 0.0017f, 0.0005f, 0.0000f,
    0.0726f, 0.0703f, 0.0651f, 0.0582f, 0.0503f, 0.0421f, 0.0340f, 0.0264f,
    0.0196f, 0.0139f, 0.0092f, 0.0056f, 0.0030f, 0.0014f, 0.0004f, 0.0000f,
    0.0618f, 0.0595f, 0.0544f, 0.0480f, 0.0409f, 0.0337f, 0.0268f, 0.0205f,
    0.0151f, 0.0105f, 0.0069f, 0.0042f, 0.0023f, 0.0011f, 0.0004f, 0.0000f,
    0.0536f, 0.0513f, 0.0463f, 0.0402f, 0.0337f, 0.0273f, 0.0214f, 0.0161f,
    0.0117f, 0.0081f, 0.0053f, 0.0032f, 0.0018f, 0.0008f, 0.0003f, 0.0000f,
    0.0475f, 0.0451f, 0.0401f, 0.0342f, 0.0282f, 0.0224f, 0.0173f, 0.0128f,
    0.0091f, 0.0062f, 0.0040f, 0.0024f, 0.0013f, 0.0006f, 0.0002f, 0.0000f
};
TABLE float GGX_MEAN_RIM[16] = {
    0.04763f, 0.04750f, 0.04626f, 0.04312f, 0.03826f, 0.03244f, 0.02652f, 0.02110f,
    0.01648f, 0.01274f, 0.00979f, 0.00752f, 0.00580f, 0.00449f, 0.00351f, 0.00276f
};

// How the tables are read, unless a shader has said otherwise before.
#ifndef GGX_LOSS_AT
#define GGX_LOSS_AT(i) GGX_LOSS[i]
#define GGX_RIM_AT(i) GGX_RIM[i]
#define GGX_MEAN_LOSS_AT(i) GGX_MEAN_LOSS[i]
#define GGX_MEAN_RIM_AT(i) GGX_MEAN_RIM[i]
#endif

// A surface's specular layer and what is below it, for one view.
RECORD(clast_brdf)
{
    packed3 diffuse;         // c_diff, times what the layer above lets through on the viewer's side
    packed3 specular;        // reflectance head on, f0
    packed3 edge;            // and at grazing angles, f90
    packed3 multiple;        // share of what single scattering loses that comes out in the end, over the mean loss
    packed2 alpha;           // roughness squared, along x and y
    float layer;             // f0 and f90 of the layer over the diffuse part
    float layer_edge;
    float layer_again;       // of what single scattering by the layer loses, the share that comes out of it in the end
    float layer_passed;      // what it lets through, seen from the viewer
    float roughness;         // of a lobe as wide both ways
    float loss;              // of single scattering, seen from the viewer
    float specular_share;    // of the samples
};
RECORD_SIZE(clast_brdf, 84)

// The scattered part of light from a direction, times the cosine, and the density with which brdf_direction finds it.
RECORD(clast_brdf_answer)
{
    packed3 value;
    float density;
};
RECORD_SIZE(clast_brdf_answer, 16)

// What a surface is made of: glTF 2.0's metallic-roughness model with KHR_materials_ior, _specular, _anisotropy and
// _iridescence.
RECORD(clast_brdf_input)
{
    packed3 base_colour;
    float metallic;
    float roughness;
    float ior;               // zero is infinite
    float specular;
    packed3 specular_colour;
    float anisotropy;        // 0 to 1: how much wider highlights are along x
    float film;              // 0 to 1: how much of it has a thin film
    float film_ior;
    float film_thickness;    // nanometres
};
RECORD_SIZE(clast_brdf_input, 56)

FN clast_brdf_input brdf_input(vec3 base_colour, float metallic, float roughness)
{
    clast_brdf_input made;
    made.base_colour = store3(base_colour);
    made.metallic = metallic;
    made.roughness = roughness;
    made.ior = 1.5f;
    made.specular = 1.0f;
    made.specular_colour = store3(splat3(1.0f));
    made.anisotropy = 0.0f;
    made.film = 0.0f;
    made.film_ior = 1.3f;
    made.film_thickness = 0.0f;
    return made;
}

// Loss and rim.
FN vec2 ggx_albedo(float roughness, float cosine)
{
    float row = clamp1(roughness, 0.0f, 1.0f) * 15.0f;
    float column = rough_sqrt(clamp1(cosine, 0.0f, 1.0f)) * 15.0f;
    uint r = min_uint(to_uint(row), 14u);
    uint c = min_uint(to_uint(column), 14u);
    float s = column - to_float(c);
    float t = row - to_float(r);
    uint low = r * GGX_SIDE + c;
    uint high = low + GGX_SIDE;
    float loss = mix1(mix1(GGX_LOSS_AT(low), GGX_LOSS_AT(low + 1u), s),
                      mix1(GGX_LOSS_AT(high), GGX_LOSS_AT(high + 1u), s), t);
    float rim = mix1(mix1(GGX_RIM_AT(low), GGX_RIM_AT(low + 1u), s), mix1(GGX_RIM_AT(high), GGX_RIM_AT(high + 1u), s), t);
    return vec2(loss, rim);
}

FN vec2 ggx_mean_albedo(float roughness)
{
    float row = clamp1(roughness, 0.0f, 1.0f) * 15.0f;
    uint r = min_uint(to_uint(row), 14u);
    float t = row - to_float(r);
    return vec2(mix1(GGX_MEAN_LOSS_AT(r), GGX_MEAN_LOSS_AT(r + 1u), t),
                mix1(GGX_MEAN_RIM_AT(r), GGX_MEAN_RIM_AT(r + 1u), t));
}

// What a specular layer of reflectance f0, f90 at grazing angles, does not reflect.
FN float passed_below(float f0, float f90, vec2 albedo)
{
    return 1.0f - f90 * albedo[1] - f0 * max1(1.0f - albedo[0] - albedo[1], 0.0f);
}

FN float fifth_power(float x)
{
    float square = x * x;
    return square * square * x;
}

FN vec3 fresnel_schlick(vec3 f0, vec3 f90, float cosine)
{
    float rise = fifth_power(clamp1(1.0f - cosine, 0.0f, 1.0f));
    return f0 + (f90 - f0) * rise;
}

// Reflectance, head on, of the border between air and a medium.
FN float reflectance_of_ior(float ior)
{
    float root = rough_divide(ior - 1.0f, ior + 1.0f);
    return ior > 0.0f ? root * root : 1.0f;
}

// Of light that single scattering loses, the share that comes out in the end.
FN vec3 again_and_again(vec3 f0, vec3 f90, float mean_loss)
{
    vec3 again = f0 * 0.952380952f + f90 * 0.0476190476f; // mean reflectance
    vec3 rest = splat3(1.0f) - again * mean_loss;
    vec3 gain = again * again * (1.0f - mean_loss);
    return vec3(rough_divide(gain[0], rest[0]), rough_divide(gain[1], rest[1]), rough_divide(gain[2], rest[2]));
}

// A lobe as wide both ways that loses as much, to half a percent: the power of the mean was found by trying.
FN float lobe_roughness(vec2 alpha)
{
    float mean_power = 0.5f * (rough_pow(alpha[0], 1.75f) + rough_pow(alpha[1], 1.75f));
    return alpha[0] != alpha[1] ? rough_pow(mean_power, 0.285714286f) : rough_sqrt(alpha[0]);
}

// How wide a surface's lobes are, along x and y. `alpha_floor` widens them: a path's later surfaces need not be sharper than
// its first.
FN vec2 lobe_alpha(clast_brdf_input from, float alpha_floor)
{
    float least = max1(ALPHA_LEAST, alpha_floor);
    float across = from.roughness * from.roughness;
    float along = mix1(across, 1.0f, from.anisotropy * from.anisotropy); // KHR_materials_anisotropy
    return vec2(max1(along, least), max1(across, least));
}

// Reflectance head on of what is not metal.
FN vec3 dielectric_reflectance(clast_brdf_input from)
{
    return min3(load3(from.specular_colour) * reflectance_of_ior(from.ior), splat3(1.0f)) * from.specular;
}

// Reflectances head on and at grazing angles, both of what is not metal and of metal.
RECORD(clast_reflectances)
{
    packed3 dielectric;
    packed3 dielectric_edge;
    packed3 metal;
    packed3 metal_edge;
};
RECORD_SIZE(clast_reflectances, 48)

// Where there is a film, it decides, for the whole lobe by the angle of the view, as glTF has it.
FN clast_reflectances surface_reflectances(clast_brdf_input from, float cosine)
{
    vec3 dielectric = dielectric_reflectance(from);
    vec3 dielectric_edge = splat3(from.specular);
    vec3 metal = load3(from.base_colour);
    vec3 metal_edge = splat3(1.0f);
    if (from.film > 0.0f) {
        vec3 on_dielectric = thin_film_reflectance(from.film_ior, from.film_thickness, cosine, dielectric);
        vec3 on_metal = thin_film_reflectance(from.film_ior, from.film_thickness, cosine, metal);
        dielectric = mix3(dielectric, on_dielectric, from.film);
        dielectric_edge = mix3(dielectric_edge, on_dielectric, from.film);
        metal = mix3(metal, on_metal, from.film);
        metal_edge = mix3(metal_edge, on_metal, from.film);
    }
    clast_reflectances made;
    made.dielectric = store3(dielectric);
    made.dielectric_edge = store3(dielectric_edge);
    made.metal = store3(metal);
    made.metal_edge = store3(metal_edge);
    return made;
}

// What the layer over the diffuse part lets through, with all that it scatters.
FN float passed_layer(clast_brdf brdf, vec2 albedo)
{
    return passed_below(brdf.layer, brdf.layer_edge, albedo) - brdf.layer_again * albedo[0];
}

// A surface seen under a cosine.
FN clast_brdf brdf_make(clast_brdf_input from, float alpha_floor, float cosine)
{
    clast_brdf brdf;
    float metallic = from.metallic;
    clast_reflectances reflects = surface_reflectances(from, cosine);
    vec3 dielectric = load3(reflects.dielectric);
    vec3 f0 = mix3(dielectric, load3(reflects.metal), metallic);
    vec3 f90 = mix3(load3(reflects.dielectric_edge), load3(reflects.metal_edge), metallic);
    vec3 diffuse = load3(from.base_colour) * (1.0f - metallic);
    brdf.alpha = store2(lobe_alpha(from, alpha_floor));
    brdf.roughness = lobe_roughness(load2(brdf.alpha));
    vec2 seen = ggx_albedo(brdf.roughness, cosine);
    vec2 mean = ggx_mean_albedo(brdf.roughness);
    brdf.loss = seen[0];
    // Kulla and Conty, Revisiting Physically Based Shading at Imageworks, 2017: what is scattered again leaves
    // diffusely, and meets the mean Fresnel reflectance at each bounce.
    float scale = mean[0] > 1e-4f ? rough_divide(1.0f, mean[0]) : 0.0f;
    vec3 again = again_and_again(dielectric, load3(reflects.dielectric_edge), mean[0]);
    vec3 metal_again = again_and_again(load3(reflects.metal), load3(reflects.metal_edge), mean[0]);
    brdf.multiple = store3(mix3(again, metal_again, metallic) * scale);
    brdf.specular = store3(f0);
    brdf.edge = store3(f90);
    // glTF weighs the diffuse part by 1 - F of the half vector, which gives more than all light back at grazing angles.
    // Kelemen and Szirmay-Kalos, A Microfacet Based Coupled Specular-Matte BRDF Model, 2001, let through what the layer
    // does not reflect. The layer over the diffuse part is the dielectric's, also where metal is mixed in: glTF mixes
    // whole surfaces. Of a coloured one, the brightest colour counts for all, as KHR_materials_specular has it.
    brdf.layer = largest3(dielectric);
    brdf.layer_edge = largest3(load3(reflects.dielectric_edge));
    brdf.layer_again = largest3(again);
    float passed = max1(passed_layer(brdf, seen), 0.0f);
    brdf.layer_passed = passed;
    brdf.diffuse = store3(diffuse * rough_divide(passed, max1(passed_layer(brdf, mean), 1e-6f)));
    float specular = luminance(f90) * seen[1] + luminance(f0) * max1(1.0f - seen[0] - seen[1], 0.0f);
    float other = luminance(diffuse) * passed + luminance(load3(brdf.multiple)) * mean[0] * brdf.loss;
    float likely = rough_divide(specular, max1(specular + other, 1e-6f));
    brdf.specular_share = other > 1e-4f ? clamp1(likely, 0.1f, 0.95f) : 1.0f;
    return brdf;
}

// GGX's density of microfacet normals. As squares of the half vector's own parts: near the peak 1 - z^2 would cancel.
FN float ggx_distribution(vec2 alpha, vec3 h)
{
    float product = alpha[0] * alpha[1];
    float x = rough_divide(h[0], alpha[0]);
    float y = rough_divide(h[1], alpha[1]);
    float t = x * x + y * y + h[2] * h[2];
    return rough_divide(1.0f, PI * max1(product * t * t, 1e-20f));
}

// cosine + root: the denominator of Smith's masking function G1 = 2 cosine / (cosine + root)
FN float smith_root(vec2 alpha, vec3 v)
{
    float x = alpha[0] * v[0];
    float y = alpha[1] * v[1];
    return rough_sqrt(x * x + y * y + v[2] * v[2]);
}

// View and light on the surface's side (z > 0); zero where they are not.
FN clast_brdf_answer brdf_evaluate(clast_brdf brdf, vec3 view, vec3 light)
{
    clast_brdf_answer answer;
    answer.value = store3(splat3(0.0f));
    answer.density = 0.0f;
    if (view[2] > 0.0f && light[2] > 0.0f) {
        vec2 alpha = load2(brdf.alpha);
        vec3 h = normalize3(view + light + vec3(0.0f, 0.0f, 1e-9f));
        float facing = clamp1(dot3(view, h), 0.0f, 1.0f);
        vec3 fresnel = fresnel_schlick(load3(brdf.specular), load3(brdf.edge), facing);
        float view_root = smith_root(alpha, view);
        float light_root = smith_root(alpha, light);
        float distribution = ggx_distribution(alpha, h);
        // Height-correlated Smith (Heitz, Understanding the Masking-Shadowing Function, JCGT 3(2), 2014) over 4 NV NL.
        float visibility = rough_divide(0.5f, max1(light[2] * view_root + view[2] * light_root, 1e-20f));
        vec2 lit = ggx_albedo(brdf.roughness, light[2]);
        vec3 diffuse = load3(brdf.diffuse) * max1(passed_layer(brdf, lit), 0.0f);
        diffuse = diffuse + load3(brdf.multiple) * (brdf.loss * lit[0]);
        vec3 sum = diffuse * INVERSE_PI + fresnel * (distribution * visibility);
        answer.value = store3(sum * light[2]);
        float lobe = rough_divide(0.5f * distribution, view[2] + view_root); // G1 D / (4 NV)
        answer.density = brdf.specular_share * lobe + (1.0f - brdf.specular_share) * light[2] * INVERSE_PI;
    }
    return answer;
}

// A microfacet normal that the view sees, by density G1 D VH / NV: Heitz, Sampling the GGX Distribution of Visible
// Normals, JCGT 7(4), 2018, in the form of Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, 2023.
FN vec3 ggx_visible_normal(vec2 alpha, vec3 view, vec2 u)
{
    vec3 standard = normalize3(vec3(view[0] * alpha[0], view[1] * alpha[1], view[2]));
    vec2 circle = circle_point(u[0]);
    float z = (1.0f - u[1]) * (1.0f + standard[2]) - standard[2];
    float radius = rough_sqrt(clamp1(1.0f - z * z, 0.0f, 1.0f));
    vec3 h = vec3(radius * circle[0], radius * circle[1], z) + standard;
    return normalize3(vec3(h[0] * alpha[0], h[1] * alpha[1], max1(h[2], 1e-9f)));
}

// A direction to follow; below the surface (z <= 0) where the path ends. `lobe` in [0, 1) chooses between the lobes.
FN vec3 brdf_direction(clast_brdf brdf, vec3 view, vec2 u, float lobe)
{
    vec3 direction;
    if (lobe < brdf.specular_share) {
        vec3 h = ggx_visible_normal(load2(brdf.alpha), view, u);
        direction = h * (2.0f * dot3(view, h)) - view;
    } else {
        direction = sample_cosine_hemisphere(u);
    }
    return direction;
}

// Pulls a shading normal up until the view is on its side and a mirror's reflection does not enter the geometry, so
// that no normal map makes black edges (Keller et al., The Iray Light Transport Simulation and Rendering System, 2017,
// A.3). Both normals have unit length; the geometric one faces the view.
FN vec3 shading_normal_repair(vec3 normal, vec3 geometric, vec3 view)
{
    vec3 reflected = normal * (2.0f * dot3(normal, view)) - view;
    float above = dot3(reflected, geometric);
    float least = min1(0.1f, 0.9f * dot3(geometric, view)); // the reflection is left at least as steep as this
    vec3 repaired = normal;
    if (above < least || dot3(normal, view) <= 0.0f) {
        vec3 lifted = normalize3(reflected + geometric * (least - above));
        vec3 half_way = normalize3(view + lifted);
        repaired = dot3(half_way, view) > 0.0f && dot3(half_way, geometric) > 0.0f ? half_way : geometric;
    }
    return repaired;
}

// Fades light out where the shading normal still faces it and the geometry no longer does: Chiang, Li and Burley,
// Taming the Shadow Terminator, 2019. Cosines of the light with the two normals, and of the normals with each other.
FN float shadow_terminator(float geometric_cosine, float shading_cosine, float normals_cosine)
{
    float g = clamp1(rough_divide(geometric_cosine, max1(shading_cosine * normals_cosine, 1e-6f)), 0.0f, 1.0f);
    return g * (1.0f + g * (1.0f - g));
}

#endif
