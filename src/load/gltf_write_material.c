// SPDX-License-Identifier: Apache-2.0
// Materials, textures and images of the glTF writer. Displacement is left out: the meshes have it.
#include <stdio.h>
#include <string.h>

#include "load/gltf_write.h"
#include "load/image.h"
#include "shared/tone_map.h"

static void use_extension(clast_gltf_writer *writer, const char *name)
{
    for (size_t i = 0; i < json_array_size(writer->extensions); i++) {
        const char *text = json_string_value(json_array_get(writer->extensions, i));
        if (text != NULL && strcmp(text, name) == 0) {
            return;
        }
    }
    clast_gltf_write_append(writer, writer->extensions, json_string(name));
}

// ------------------------------------------------------------------------------------------------------------ images

// A float image as 8 bits: glTF has no others. Colours get sRGB's curve.
static clast_status to_bytes(clast_context *context, const char *name, const clast_image *image, bool is_colour,
                             clast_image *bytes)
{
    clast_status status = clast_image_allocate(context, name, UINT64_MAX, image->width, image->height, image->channels,
                                               CLAST_PIXEL_UNORM8, bytes);
    if (status != CLAST_OK) {
        return status;
    }
    const float *from = image->pixels;
    uint8_t *to = (uint8_t *)bytes->pixels;
    size_t count = (size_t)image->width * image->height * image->channels;
    for (size_t i = 0; i < count; i++) {
        bool is_alpha = image->channels % 2 == 0 && i % image->channels == image->channels - 1;
        float value = clamp1(from[i], 0.0f, 1.0f);
        to[i] = (uint8_t)((is_colour && !is_alpha ? linear_to_srgb(value) : value) * 255.0f + 0.5f);
    }
    return CLAST_OK;
}

// Adds an image: embedded, or by the name that clast_gltf_write_images will give it.
static uint32_t add_image(clast_gltf_writer *writer, uint32_t image, bool is_colour)
{
    uint32_t *number = &writer->image_numbers[image];
    if (*number != CLAST_NONE || writer->status != CLAST_OK) {
        return *number != CLAST_NONE ? *number : 0;
    }
    const clast_scene_image *source = &writer->model->scene->images[image];
    json_t *object;
    if (writer->is_binary) {
        clast_image bytes = source->image;
        void *block = NULL;
        size_t size = 0;
        bool converts = bytes.type == CLAST_PIXEL_FLOAT;
        if (converts) {
            writer->status = to_bytes(writer->context, writer->path, &source->image, is_colour, &bytes);
        }
        if (writer->status == CLAST_OK) {
            writer->status = clast_png_encode_block(writer->context, writer->path, &bytes, &block, &size);
        }
        if (converts) {
            clast_image_free(writer->context, &bytes);
        }
        uint32_t view = block != NULL ? clast_gltf_write_piece(writer, block, size, block, 0) : 0;
        object = json_pack("{s:i, s:s}", "bufferView", (int)view, "mimeType", "image/png");
    } else {
        char name[240];
        snprintf(name, sizeof name, "%s.%u.png", writer->stem, (unsigned)json_array_size(writer->images));
        object = json_pack("{s:s}", "uri", name);
    }
    writer->image_is_colour[image] = is_colour;
    *number = clast_gltf_write_append(writer, writer->images, object);
    return *number;
}

static clast_status write_image(clast_gltf_writer *writer, size_t number)
{
    const clast_image *image = &writer->model->scene->images[number].image;
    const json_t *object = json_array_get(writer->images, writer->image_numbers[number]);
    const char *name = json_string_value(json_object_get(object, "uri"));
    char *path = name != NULL ? clast_path_beside(writer->context, writer->path, name) : NULL;
    if (path == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_image bytes = *image;
    clast_status status = CLAST_OK;
    if (image->type == CLAST_PIXEL_FLOAT) {
        status = to_bytes(writer->context, path, image, writer->image_is_colour[number], &bytes);
    }
    if (status == CLAST_OK) {
        status = clast_image_write(writer->context, path, &bytes);
    }
    if (image->type == CLAST_PIXEL_FLOAT) {
        clast_image_free(writer->context, &bytes);
    }
    clast_free(writer->context, path);
    return status;
}

clast_status clast_gltf_write_images(clast_gltf_writer *writer)
{
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < writer->model->scene->image_count && status == CLAST_OK; i++) {
        if (writer->image_numbers[i] != CLAST_NONE) {
            status = write_image(writer, i);
        }
    }
    return status;
}

// ---------------------------------------------------------------------------------------------------------- textures

static uint32_t add_sampler(clast_gltf_writer *writer, const clast_texture *texture)
{
    static const int wraps[] = {[CLAST_WRAP_REPEAT] = 10497, [CLAST_WRAP_CLAMP] = 33071, [CLAST_WRAP_MIRROR] = 33648};
    bool is_linear = texture->filter == CLAST_FILTER_LINEAR;
    json_t *sampler = json_pack("{s:i, s:i, s:i, s:i}", "magFilter", is_linear ? 9729 : 9728, "minFilter",
                                is_linear ? 9987 : 9728, "wrapS", wraps[texture->wrap_u], "wrapT",
                                wraps[texture->wrap_v]);
    for (size_t i = 0; i < json_array_size(writer->samplers); i++) {
        if (json_equal(json_array_get(writer->samplers, i), sampler)) {
            json_decref(sampler);
            return (uint32_t)i;
        }
    }
    return clast_gltf_write_append(writer, writer->samplers, sampler);
}

static uint32_t add_texture(clast_gltf_writer *writer, uint32_t texture, bool is_colour)
{
    uint32_t *number = &writer->texture_numbers[texture];
    if (*number == CLAST_NONE) {
        const clast_texture *source = &writer->model->scene->textures[texture];
        json_t *object = json_pack("{s:i, s:i}", "sampler", (int)add_sampler(writer, source), "source",
                                   (int)add_image(writer, source->image, is_colour));
        *number = clast_gltf_write_append(writer, writer->textures, object);
    }
    return *number;
}

// A texture as a material uses it, in `object`; nothing where there is none. `factor_name` may be null.
static void set_texture(clast_gltf_writer *writer, json_t *object, const char *key, const clast_texture_use *use,
                        bool is_colour, const char *factor_name, float factor)
{
    if (use->texture == CLAST_NONE) {
        return;
    }
    json_t *info = json_pack("{s:i}", "index", (int)add_texture(writer, use->texture, is_colour));
    if (use->coordinate_set != 0) {
        clast_gltf_write_set(writer, info, "texCoord", json_integer(use->coordinate_set));
    }
    if (factor_name != NULL && factor != 1.0f) {
        clast_gltf_write_set(writer, info, factor_name, json_real((double)factor));
    }
    bool is_moved = use->offset.v[0] != 0.0f || use->offset.v[1] != 0.0f || use->scale.v[0] != 1.0f ||
                    use->scale.v[1] != 1.0f || use->rotation != 0.0f;
    if (is_moved) {
        use_extension(writer, "KHR_texture_transform");
        json_t *transform = json_pack("{s:o, s:o, s:f}", "offset", clast_gltf_write_numbers(use->offset.v, 2), "scale",
                                      clast_gltf_write_numbers(use->scale.v, 2), "rotation", (double)use->rotation);
        clast_gltf_write_set(writer, info, "extensions", json_pack("{s:o}", "KHR_texture_transform", transform));
    }
    clast_gltf_write_set(writer, object, key, info);
}

// --------------------------------------------------------------------------------------------------------- materials

// Factors above one are written as a strength (KHR_materials_emissive_strength).
static void set_emission(clast_gltf_writer *writer, json_t *object, const clast_material *material)
{
    float emissive[3], strength = 1.0f;
    for (int i = 0; i < 3; i++) {
        emissive[i] = material->emissive.v[i];
        strength = max1(strength, emissive[i]);
    }
    for (int i = 0; i < 3; i++) {
        emissive[i] = emissive[i] / strength;
    }
    if (emissive[0] != 0.0f || emissive[1] != 0.0f || emissive[2] != 0.0f) {
        clast_gltf_write_set(writer, object, "emissiveFactor", clast_gltf_write_numbers(emissive, 3));
    }
    set_texture(writer, object, "emissiveTexture", &material->emissive_texture, true, NULL, 1.0f);
    if (strength > 1.0f) {
        use_extension(writer, "KHR_materials_emissive_strength");
        clast_gltf_write_set(
            writer, object, "extensions",
            json_pack("{s:{s:f}}", "KHR_materials_emissive_strength", "emissiveStrength", (double)strength));
    }
}

static void set_alpha(clast_gltf_writer *writer, json_t *object, const clast_material *material)
{
    static const char *const modes[] = {
#define MODE(name, value, text) [value] = text,
        CLAST_ALPHA_LIST(MODE)
#undef MODE
    };
    if (material->alpha_mode != CLAST_ALPHA_OPAQUE) {
        clast_gltf_write_set(writer, object, "alphaMode", json_string(modes[material->alpha_mode]));
    }
    if (material->alpha_mode == CLAST_ALPHA_MASK) {
        clast_gltf_write_set(writer, object, "alphaCutoff", json_real((double)material->alpha_cutoff));
    }
    if (material->double_sided != 0) {
        clast_gltf_write_set(writer, object, "doubleSided", json_true());
    }
}

uint32_t clast_gltf_write_material(clast_gltf_writer *writer, uint32_t number)
{
    if (writer->material_numbers[number] != CLAST_NONE) {
        return writer->material_numbers[number];
    }
    const clast_scene_material *source = &writer->model->scene->materials[number];
    const clast_material *material = &source->record;
    json_t *surface = json_pack("{s:o, s:f, s:f}", "baseColorFactor",
                                clast_gltf_write_numbers(material->base_colour.v, 4), "metallicFactor",
                                (double)material->metallic, "roughnessFactor", (double)material->roughness);
    set_texture(writer, surface, "baseColorTexture", &material->base_colour_texture, true, NULL, 1.0f);
    set_texture(writer, surface, "metallicRoughnessTexture", &material->metallic_roughness_texture, false, NULL, 1.0f);
    json_t *object = json_object();
    clast_gltf_write_name(writer, object, source->name);
    clast_gltf_write_set(writer, object, "pbrMetallicRoughness", surface);
    set_texture(writer, object, "normalTexture", &material->normal_texture, false, "scale", material->normal_scale);
    set_texture(writer, object, "occlusionTexture", &material->occlusion_texture, false, "strength",
                material->occlusion_strength);
    set_emission(writer, object, material);
    set_alpha(writer, object, material);
    writer->material_numbers[number] = clast_gltf_write_append(writer, writer->materials, object);
    return writer->material_numbers[number];
}
