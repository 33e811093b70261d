// SPDX-License-Identifier: Apache-2.0
// What extensions add to a material: KHR_materials_ior, _specular, _clearcoat, _sheen, _anisotropy, _transmission, _volume,
// _dispersion, _iridescence, _diffuse_transmission and _unlit.
#include <float.h>

#include "load/gltf.h"

static void read_factors(clast_gltf *gltf, const clast_gltf_value *object, const char *name, float most,
                         float values[3])
{
    clast_gltf_numbers(gltf, object, name, 3, 0.0f, most, values);
}

static void read_specular(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value ior = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_ior");
    desc->ior = clast_gltf_number(gltf, &ior, "ior", 0.0f, FLT_MAX, 1.5f);
    if (desc->ior > 0.0f && desc->ior < 1.0f) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &ior, "ior %.9g: expected 0, or 1 at least", (double)desc->ior);
    }
    clast_gltf_value specular = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_specular");
    desc->specular = clast_gltf_number(gltf, &specular, "specularFactor", 0.0f, 1.0f, 1.0f);
    read_factors(gltf, &specular, "specularColorFactor", FLT_MAX, desc->specular_colour);
    clast_gltf_read_slot(gltf, &specular, "specularTexture", &desc->specular_texture);
    clast_gltf_read_slot(gltf, &specular, "specularColorTexture", &desc->specular_colour_texture);
}

static void read_clearcoat(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value coat = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_clearcoat");
    desc->clearcoat = clast_gltf_number(gltf, &coat, "clearcoatFactor", 0.0f, 1.0f, 0.0f);
    desc->clearcoat_roughness = clast_gltf_number(gltf, &coat, "clearcoatRoughnessFactor", 0.0f, 1.0f, 0.0f);
    clast_gltf_read_slot(gltf, &coat, "clearcoatTexture", &desc->clearcoat_texture);
    clast_gltf_read_slot(gltf, &coat, "clearcoatRoughnessTexture", &desc->clearcoat_roughness_texture);
    clast_gltf_read_slot(gltf, &coat, "clearcoatNormalTexture", &desc->clearcoat_normal_texture);
    clast_gltf_value map = clast_gltf_object(gltf, &coat, "clearcoatNormalTexture");
    desc->clearcoat_normal_scale = clast_gltf_number(gltf, &map, "scale", -FLT_MAX, FLT_MAX, 1.0f);
}

static void read_sheen(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value sheen = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_sheen");
    read_factors(gltf, &sheen, "sheenColorFactor", 1.0f, desc->sheen_colour);
    desc->sheen_roughness = clast_gltf_number(gltf, &sheen, "sheenRoughnessFactor", 0.0f, 1.0f, 0.0f);
    clast_gltf_read_slot(gltf, &sheen, "sheenColorTexture", &desc->sheen_colour_texture);
    clast_gltf_read_slot(gltf, &sheen, "sheenRoughnessTexture", &desc->sheen_roughness_texture);
}

static void read_anisotropy(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value anisotropy = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_anisotropy");
    desc->anisotropy = clast_gltf_number(gltf, &anisotropy, "anisotropyStrength", 0.0f, 1.0f, 0.0f);
    desc->anisotropy_rotation = clast_gltf_number(gltf, &anisotropy, "anisotropyRotation", -FLT_MAX, FLT_MAX, 0.0f);
    clast_gltf_read_slot(gltf, &anisotropy, "anisotropyTexture", &desc->anisotropy_texture);
}

static void read_transmission(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value clear = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_transmission");
    desc->transmission = clast_gltf_number(gltf, &clear, "transmissionFactor", 0.0f, 1.0f, 0.0f);
    clast_gltf_read_slot(gltf, &clear, "transmissionTexture", &desc->transmission_texture);
    clast_gltf_value volume = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_volume");
    desc->thickness = clast_gltf_number(gltf, &volume, "thicknessFactor", 0.0f, FLT_MAX, 0.0f);
    desc->attenuation_distance = clast_gltf_number(gltf, &volume, "attenuationDistance", 0.0f, FLT_MAX, 0.0f);
    read_factors(gltf, &volume, "attenuationColor", 1.0f, desc->attenuation_colour);
    clast_gltf_value dispersion = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_dispersion");
    desc->dispersion = clast_gltf_number(gltf, &dispersion, "dispersion", 0.0f, FLT_MAX, 0.0f);
}

static void read_iridescence(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value film = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_iridescence");
    desc->iridescence = clast_gltf_number(gltf, &film, "iridescenceFactor", 0.0f, 1.0f, 0.0f);
    desc->iridescence_ior = clast_gltf_number(gltf, &film, "iridescenceIor", 1.0f, FLT_MAX, 1.3f);
    desc->iridescence_thickness_minimum = clast_gltf_number(gltf, &film, "iridescenceThicknessMinimum", 0.0f, FLT_MAX,
                                                            100.0f);
    desc->iridescence_thickness_maximum = clast_gltf_number(gltf, &film, "iridescenceThicknessMaximum", 0.0f, FLT_MAX,
                                                            400.0f);
    clast_gltf_read_slot(gltf, &film, "iridescenceTexture", &desc->iridescence_texture);
    clast_gltf_read_slot(gltf, &film, "iridescenceThicknessTexture", &desc->iridescence_thickness_texture);
}

static void read_diffuse_transmission(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value passes = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_diffuse_transmission");
    desc->diffuse_transmission = clast_gltf_number(gltf, &passes, "diffuseTransmissionFactor", 0.0f, 1.0f, 0.0f);
    read_factors(gltf, &passes, "diffuseTransmissionColorFactor", 1.0f, desc->diffuse_transmission_colour);
    clast_gltf_read_slot(gltf, &passes, "diffuseTransmissionTexture", &desc->diffuse_transmission_texture);
    clast_gltf_read_slot(gltf, &passes, "diffuseTransmissionColorTexture", &desc->diffuse_transmission_colour_texture);
}

void clast_gltf_read_layers(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    read_specular(gltf, material, desc);
    read_clearcoat(gltf, material, desc);
    read_sheen(gltf, material, desc);
    read_anisotropy(gltf, material, desc);
    read_transmission(gltf, material, desc);
    read_iridescence(gltf, material, desc);
    read_diffuse_transmission(gltf, material, desc);
    desc->unlit = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_unlit").json != NULL;
}
