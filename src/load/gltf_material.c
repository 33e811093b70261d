// SPDX-License-Identifier: Apache-2.0
// Materials (section 3.9), with KHR_texture_transform, KHR_materials_emissive_strength and KHR_materials_displacement.
#include <float.h>
#include <string.h>

#include "load/gltf.h"

static void read_transform(clast_gltf *gltf, const clast_gltf_value *object, clast_texture_slot *slot)
{
    clast_gltf_value extensions;
    clast_gltf_value transform = clast_gltf_extension(gltf, object, &extensions, "KHR_texture_transform");
    if (transform.json == NULL) {
        return;
    }
    clast_gltf_numbers(gltf, &transform, "offset", 2, -FLT_MAX, FLT_MAX, slot->offset);
    clast_gltf_numbers(gltf, &transform, "scale", 2, -FLT_MAX, FLT_MAX, slot->scale);
    slot->rotation = clast_gltf_number(gltf, &transform, "rotation", -FLT_MAX, FLT_MAX, 0.0f);
    slot->coordinate_set = (uint32_t)clast_gltf_integer(gltf, &transform, "texCoord", 0, UINT32_MAX - 1,
                                                        slot->coordinate_set);
}

// A texture slot, and its `factor_name` (scale or strength), which only some have.
static void read_slot(clast_gltf *gltf, const clast_gltf_value *material, const char *name, clast_texture_slot *slot,
                      const char *factor_name, float least, float most, float *factor)
{
    clast_gltf_read_slot(gltf, material, name, slot);
    if (factor_name != NULL) {
        clast_gltf_value object = clast_gltf_object(gltf, material, name);
        *factor = clast_gltf_number(gltf, &object, factor_name, least, most, *factor);
    }
}

void clast_gltf_read_slot(clast_gltf *gltf, const clast_gltf_value *holder, const char *name, clast_texture_slot *slot)
{
    clast_gltf_value object = clast_gltf_object(gltf, holder, name);
    if (object.json == NULL) {
        return;
    }
    uint32_t index = clast_gltf_index(gltf, &object, "index", CLAST_GLTF_TEXTURES);
    slot->coordinate_set = (uint32_t)clast_gltf_integer(gltf, &object, "texCoord", 0, UINT32_MAX - 1, 0);
    read_transform(gltf, &object, slot);
    if (clast_gltf_ok(gltf) && index == CLAST_NONE) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &object, "no index: expected that of a texture");
    }
    if (clast_gltf_ok(gltf)) {
        slot->texture = clast_gltf_texture(gltf, index);
    }
}

static clast_alpha_mode read_alpha_mode(clast_gltf *gltf, const clast_gltf_value *material)
{
    static const char *const names[] = {
#define NAME(name, value, text) [value] = text,
        CLAST_ALPHA_LIST(NAME)
#undef NAME
    };
    const char *text = clast_gltf_text(gltf, material, "alphaMode");
    if (text == NULL) {
        return CLAST_ALPHA_OPAQUE;
    }
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], text) == 0) {
            return (clast_alpha_mode)i;
        }
    }
    clast_gltf_value place = clast_gltf_member(material, "alphaMode");
    clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "\"%.40s\": expected OPAQUE, MASK or BLEND", text);
    return CLAST_ALPHA_OPAQUE;
}

static void read_emissive(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_numbers(gltf, material, "emissiveFactor", 3, 0.0f, FLT_MAX, desc->emissive);
    clast_gltf_value strength = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_emissive_strength");
    float factor = clast_gltf_number(gltf, &strength, "emissiveStrength", 0.0f, FLT_MAX, 1.0f);
    for (int i = 0; i < 3; i++) {
        desc->emissive[i] *= factor;
        if (!is_finite1(desc->emissive[i])) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &strength,
                            "emissiveStrength %.9g times emissiveFactor is not finite", (double)factor);
        }
    }
}

// Heights are texel * factor + offset, along the normals. Without a texture there is nothing to displace by.
static void read_displacement(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc)
{
    clast_gltf_value extensions;
    clast_gltf_value displacement = clast_gltf_extension(gltf, material, &extensions, "KHR_materials_displacement");
    if (displacement.json == NULL) {
        return;
    }
    read_slot(gltf, &displacement, "displacementGeometryTexture", &desc->displacement_texture, NULL, 0.0f, 0.0f, NULL);
    desc->displacement_scale = clast_gltf_number(gltf, &displacement, "displacementGeometryFactor", -FLT_MAX, FLT_MAX,
                                                 1.0f);
    desc->displacement_offset = clast_gltf_number(gltf, &displacement, "displacementGeometryOffset", -FLT_MAX, FLT_MAX,
                                                  0.0f);
    if (clast_gltf_ok(gltf) && desc->displacement_texture.texture == CLAST_NONE) {
        clast_gltf_warn(gltf, &displacement, "no texture that can be read: the surface is not displaced");
    }
}

static void read_material(clast_gltf *gltf, const clast_gltf_value *value, clast_material_desc *desc)
{
    clast_gltf_value reflectance = clast_gltf_object(gltf, value, "pbrMetallicRoughness");
    for (int i = 0; i < 4; i++) {
        desc->base_colour[i] = 1.0f;
    }
    clast_gltf_numbers(gltf, &reflectance, "baseColorFactor", 4, 0.0f, 1.0f, desc->base_colour);
    desc->metallic = clast_gltf_number(gltf, &reflectance, "metallicFactor", 0.0f, 1.0f, 1.0f);
    desc->roughness = clast_gltf_number(gltf, &reflectance, "roughnessFactor", 0.0f, 1.0f, 1.0f);
    read_slot(gltf, &reflectance, "baseColorTexture", &desc->base_colour_texture, NULL, 0.0f, 0.0f, NULL);
    read_slot(gltf, &reflectance, "metallicRoughnessTexture", &desc->metallic_roughness_texture, NULL, 0.0f, 0.0f,
              NULL);
    read_slot(gltf, value, "normalTexture", &desc->normal_texture, "scale", -FLT_MAX, FLT_MAX, &desc->normal_scale);
    read_slot(gltf, value, "occlusionTexture", &desc->occlusion_texture, "strength", 0.0f, 1.0f,
              &desc->occlusion_strength);
    read_slot(gltf, value, "emissiveTexture", &desc->emissive_texture, NULL, 0.0f, 0.0f, NULL);
    read_emissive(gltf, value, desc);
    read_displacement(gltf, value, desc);
    desc->alpha_mode = read_alpha_mode(gltf, value);
    desc->alpha_cutoff = clast_gltf_number(gltf, value, "alphaCutoff", 0.0f, FLT_MAX, 0.5f);
    desc->double_sided = clast_gltf_flag(gltf, value, "doubleSided", false);
    clast_gltf_read_layers(gltf, value, desc);
}

// Maps the file's coordinate sets to the two that a mesh has: as they are where 0 and 1 will do, else those in use,
// in order.
static bool map_sets(clast_gltf *gltf, const clast_gltf_value *value, clast_material_desc *desc,
                     clast_gltf_material *made)
{
#define SLOT(slot) &desc->slot,
    clast_texture_slot *slots[] = {CLAST_MATERIAL_TEXTURE_LIST(SLOT)};
#undef SLOT
    enum { SLOT_COUNT = sizeof slots / sizeof *slots };
    uint32_t used[SLOT_COUNT], count = 0, largest = 0;
    for (size_t i = 0; i < SLOT_COUNT; i++) {
        if (slots[i]->texture == CLAST_NONE) {
            slots[i]->coordinate_set = 0;
            continue;
        }
        uint32_t set = slots[i]->coordinate_set, at = 0;
        while (at < count && used[at] != set) {
            at++;
        }
        used[at] = set;
        count += at == count;
        largest = set > largest ? set : largest;
    }
    made->sets[0] = 0;
    made->sets[1] = 1;
    if (largest >= 2) {
        if (count > 2) {
            return clast_gltf_fail(gltf, CLAST_ERROR_LIMIT, value,
                                   "%u sets of texture coordinates: expected at most 2 in a material", count);
        }
        made->sets[0] = used[0];
        made->sets[1] = count == 2 ? used[1] : CLAST_NONE;
        for (size_t i = 0; i < SLOT_COUNT; i++) {
            slots[i]->coordinate_set = slots[i]->texture != CLAST_NONE && slots[i]->coordinate_set != used[0] ? 1 : 0;
        }
    }
    made->needs_tangents = desc->normal_texture.texture != CLAST_NONE || desc->anisotropy > 0.0f ||
                           desc->clearcoat_normal_texture.texture != CLAST_NONE;
    made->normal_set = desc->normal_texture.coordinate_set;
    return true;
}

const clast_gltf_material *clast_gltf_use_material(clast_gltf *gltf, uint32_t index)
{
    clast_gltf_material *made = &gltf->materials[index];
    if (made->number != CLAST_NONE) {
        return made;
    }
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_MATERIALS, index);
    clast_material_desc desc = clast_material_defaults();
    read_material(gltf, &value, &desc);
    const char *name = clast_gltf_text(gltf, &value, "name");
    if (!clast_gltf_ok(gltf) || !map_sets(gltf, &value, &desc, made) ||
        !clast_gltf_check(gltf, clast_scene_add_material(gltf->scene, &desc, name, &made->number))) {
        return NULL;
    }
    return made;
}
