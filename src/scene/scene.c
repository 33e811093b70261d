// SPDX-License-Identifier: Apache-2.0
// A scene's life, and its images, textures, materials, lights and environment. Geometry and instances are in geometry.c and
// instance.c, cameras in camera.c.
#include "scene/scene.h"

#include <math.h>
#include <string.h>

#include "base/file.h"
#include "base/size.h"

enum { IMAGE_SIDE_MOST = 65536, IMAGE_CHANNELS_MOST = 4 };

static const float HALF_TURN = 3.14159265f;

clast_status clast_scene_create(clast_context *context, clast_scene **scene)
{
    if (context == NULL || scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *scene = NULL;
    clast_scene *made = clast_allocate_zeroed(context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->context = context;
    clast_material_desc plain = clast_material_defaults();
    uint32_t number;
    clast_status status = clast_scene_add_material(made, &plain, NULL, &number);
    if (status != CLAST_OK) {
        clast_scene_destroy(made);
        return status;
    }
    *scene = made;
    return CLAST_OK;
}

void clast_scene_destroy(clast_scene *scene)
{
    if (scene == NULL) {
        return;
    }
    clast_context *context = scene->context;
    for (size_t i = 0; i < scene->image_count; i++) {
        clast_free(context, scene->images[i].name);
        clast_free(context, scene->images[i].blocks.data);
        clast_free(context, scene->images[i].stored.pixels);
        for (uint32_t encoding = 0; encoding < ENCODINGS; encoding++) {
            clast_free(context, scene->images[i].levels[encoding].pixels);
        }
        if (scene->images[i].owned) {
            clast_free(context, (void *)scene->images[i].image.pixels);
        }
    }
    for (size_t i = 0; i < scene->material_count; i++) {
        clast_free(context, scene->materials[i].name);
    }
    for (size_t i = 0; i < scene->geometry_count; i++) {
        clast_geometry *geometry = &scene->geometries[i];
        clast_free(context, geometry->name);
        for (uint32_t block = 0; block < geometry->block_count; block++) {
            clast_free(context, geometry->blocks[block]);
        }
    }
    for (size_t i = 0; i < scene->instance_count; i++) {
        clast_free(context, scene->instances[i].name);
    }
    for (size_t i = 0; i < scene->light_count; i++) {
        clast_free(context, scene->lights[i].name);
    }
    for (size_t i = 0; i < scene->camera_count; i++) {
        clast_free(context, scene->cameras[i].name);
    }
    for (size_t i = 0; i < scene->file_count; i++) {
        clast_file_unmap(context, &scene->files[i]);
    }
    clast_motion_destroy(context, &scene->motion);
    for (size_t i = 0; i < CLAST_SETTING_TEXTS; i++) {
        clast_free(context, scene->settings_texts[i]);
    }
    clast_free(context, scene->images);
    clast_free(context, scene->textures);
    clast_free(context, scene->materials);
    clast_free(context, scene->geometries);
    clast_free(context, scene->instances);
    clast_free(context, scene->lights);
    clast_free(context, scene->cameras);
    clast_free(context, scene->files);
    clast_free(context, scene);
}

// A copy of an optional name; false where memory ran out.
static bool copy_name(clast_context *context, const char *name, char **copy)
{
    *copy = name != NULL && name[0] != '\0' ? clast_copy_text(context, name) : NULL;
    return *copy != NULL || name == NULL || name[0] == '\0';
}

// -------------------------------------------------------------------------------------------------------------- images

static size_t pixel_bytes(clast_pixel_type type)
{
    switch (type) {
    case CLAST_PIXEL_UNORM8: return 1;
    case CLAST_PIXEL_UNORM16: return 2;
    case CLAST_PIXEL_FLOAT: return 4;
    }
    return 0;
}

// Bytes of an image's pixels; false where its description is none of an image.
static bool image_bytes(const clast_image *image, size_t *bytes)
{
    size_t pixels, element = pixel_bytes(image->type);
    return element != 0 && image->width >= 1 && image->width <= IMAGE_SIDE_MOST && image->height >= 1 &&
           image->height <= IMAGE_SIDE_MOST && image->channels >= 1 && image->channels <= IMAGE_CHANNELS_MOST &&
           clast_multiply_size(image->width, image->height, &pixels) &&
           clast_multiply_size(pixels, image->channels * element, bytes);
}

clast_status clast_scene_adopt_image(clast_scene *scene, const clast_image *image, const char *name, uint32_t *number)
{
    clast_context *context = scene->context;
    clast_scene_image added = {.image = *image, .owned = true};
    size_t bytes;
    clast_status status = CLAST_OK;
    if (!image_bytes(image, &bytes)) {
        status = clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                            "an image of %u x %u pixels of %u channels: expected 1 to %d a side, 1 to 4 channels",
                            image->width, image->height, image->channels, IMAGE_SIDE_MOST);
    } else {
        status = CLAST_RESERVE(context, scene->images, scene->image_capacity, scene->image_count + 1);
    }
    if (status == CLAST_OK && !copy_name(context, name, &added.name)) {
        status = CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status != CLAST_OK) {
        clast_free(context, (void *)image->pixels);
        return status;
    }
    *number = (uint32_t)scene->image_count;
    scene->images[scene->image_count++] = added;
    return CLAST_OK;
}

void clast_scene_adopt_blocks(clast_scene *scene, uint32_t image, clast_image_blocks *blocks)
{
    clast_free(scene->context, scene->images[image].blocks.data);
    scene->images[image].blocks = *blocks;
    *blocks = (clast_image_blocks){0};
}

void clast_scene_adopt_levels(clast_scene *scene, uint32_t image, clast_image_levels *levels)
{
    clast_free(scene->context, scene->images[image].stored.pixels);
    scene->images[image].stored = *levels;
    *levels = (clast_image_levels){0};
}

clast_status clast_scene_add_image(clast_scene *scene, const clast_image *image, const char *name, uint32_t *number)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    size_t bytes;
    if (image == NULL || number == NULL || image->pixels == NULL || !image_bytes(image, &bytes)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "an image needs pixels, 1 to %d a side, and 1 to 4 channels", IMAGE_SIDE_MOST);
    }
    void *pixels = clast_allocate(context, bytes, 1);
    if (pixels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memcpy(pixels, image->pixels, bytes);
    clast_image copy = *image;
    copy.pixels = pixels;
    return clast_scene_adopt_image(scene, &copy, name, number);
}

clast_status clast_scene_add_texture(clast_scene *scene, const clast_texture *texture, uint32_t *number)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (texture == NULL || number == NULL || texture->image >= scene->image_count) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "a texture names image %u: the scene has %zu",
                          texture != NULL ? texture->image : 0, scene->image_count);
    }
    clast_status status = CLAST_RESERVE(scene->context, scene->textures, scene->texture_capacity,
                                        scene->texture_count + 1);
    if (status == CLAST_OK) {
        *number = (uint32_t)scene->texture_count;
        scene->textures[scene->texture_count++] = *texture;
    }
    return status;
}

// ----------------------------------------------------------------------------------------------------------- materials

static clast_texture_slot empty_slot(void)
{
    return (clast_texture_slot){.texture = CLAST_NONE, .scale = {1.0f, 1.0f}};
}

clast_material_desc clast_material_defaults(void)
{
    return (clast_material_desc){.base_colour = {0.8f, 0.8f, 0.8f, 1.0f},
                                 .roughness = 1.0f,
                                 .normal_scale = 1.0f,
                                 .occlusion_strength = 1.0f,
                                 .alpha_cutoff = 0.5f,
                                 .displacement_scale = 1.0f,
                                 .double_sided = true,
                                 .ior = 1.5f,
                                 .specular = 1.0f,
                                 .specular_colour = {1.0f, 1.0f, 1.0f},
                                 .clearcoat_normal_scale = 1.0f,
                                 .attenuation_colour = {1.0f, 1.0f, 1.0f},
                                 .iridescence_ior = 1.3f,
                                 .iridescence_thickness_minimum = 100.0f,
                                 .iridescence_thickness_maximum = 400.0f,
                                 .diffuse_transmission_colour = {1.0f, 1.0f, 1.0f},
#define EMPTY(slot) .slot = empty_slot(),
                                 CLAST_MATERIAL_TEXTURE_LIST(EMPTY)
#undef EMPTY
    };
}

static clast_texture_use texture_use(const clast_texture_slot *slot)
{
    return (clast_texture_use){
        .texture = slot->texture,
        .coordinate_set = slot->coordinate_set,
        .offset = {{slot->offset[0], slot->offset[1]}},
        .scale = {{slot->scale[0], slot->scale[1]}},
        .rotation = slot->rotation,
    };
}

static bool slot_is_valid(const clast_scene *scene, const clast_texture_slot *slot)
{
    return (slot->texture == CLAST_NONE || slot->texture < scene->texture_count) && slot->coordinate_set < 2 &&
           isfinite(slot->offset[0]) && isfinite(slot->offset[1]) && isfinite(slot->scale[0]) &&
           isfinite(slot->scale[1]) && isfinite(slot->rotation);
}

static bool in_unit_range(float value)
{
    return value >= 0.0f && value <= 1.0f;
}

static bool in_unit_range3(const float values[3])
{
    return in_unit_range(values[0]) && in_unit_range(values[1]) && in_unit_range(values[2]);
}

static bool at_least_zero(float value)
{
    return value >= 0.0f && isfinite(value);
}

static bool at_least_zero3(const float values[3])
{
    return at_least_zero(values[0]) && at_least_zero(values[1]) && at_least_zero(values[2]);
}

// What is wrong with the base, or null.
static const char *fault_of_base(const clast_material_desc *m)
{
    return !in_unit_range3(m->base_colour) || !in_unit_range(m->base_colour[3]) ? "base_colour must lie between 0 and 1"
           : !at_least_zero3(m->emissive) ? "emissive must be finite and not negative"
           : !in_unit_range(m->metallic) || !in_unit_range(m->roughness)
               ? "metallic and roughness must lie between 0 and 1"
           : !isfinite(m->normal_scale) || !in_unit_range(m->occlusion_strength)
               ? "normal_scale must be finite, occlusion_strength between 0 and 1"
           : !at_least_zero(m->alpha_cutoff) ? "alpha_cutoff must be finite and not negative"
           : !isfinite(m->displacement_scale) || !isfinite(m->displacement_offset)
               ? "displacement_scale and displacement_offset must be finite"
           : (unsigned)m->alpha_mode > CLAST_ALPHA_BLEND ? "alpha_mode is none of the list"
                                                         : NULL;
}

static const char *fault_of_layers(const clast_material_desc *m)
{
    return !isfinite(m->ior) || (m->ior != 0.0f && m->ior < 1.0f) ? "ior must be finite, and 0 or at least 1"
           : !in_unit_range(m->specular) || !at_least_zero3(m->specular_colour)
               ? "specular must lie between 0 and 1, specular_colour be finite and not negative"
           : !in_unit_range(m->clearcoat) || !in_unit_range(m->clearcoat_roughness) ||
                   !isfinite(m->clearcoat_normal_scale)
               ? "clearcoat and clearcoat_roughness must lie between 0 and 1, clearcoat_normal_scale be finite"
           : !in_unit_range3(m->sheen_colour) || !in_unit_range(m->sheen_roughness)
               ? "sheen_colour and sheen_roughness must lie between 0 and 1"
           : !in_unit_range(m->anisotropy) || !isfinite(m->anisotropy_rotation)
               ? "anisotropy must lie between 0 and 1, anisotropy_rotation be finite"
           : !in_unit_range(m->transmission) ? "transmission must lie between 0 and 1"
           : !at_least_zero(m->thickness) || !at_least_zero(m->attenuation_distance) ||
                   !in_unit_range3(m->attenuation_colour)
               ? "thickness and attenuation_distance must be finite and not negative, attenuation_colour between 0 and 1"
               : NULL;
}

// What is wrong with what colours light by its way through, or null.
static const char *fault_of_passage(const clast_material_desc *m)
{
    return !at_least_zero(m->dispersion) ? "dispersion must be finite and not negative"
           : !in_unit_range(m->iridescence) || !isfinite(m->iridescence_ior) || m->iridescence_ior < 1.0f
               ? "iridescence must lie between 0 and 1, iridescence_ior be finite and at least 1"
           : !at_least_zero(m->iridescence_thickness_minimum) || !at_least_zero(m->iridescence_thickness_maximum)
               ? "iridescence_thickness_minimum and _maximum must be finite and not negative"
           : !in_unit_range(m->diffuse_transmission) || !in_unit_range3(m->diffuse_transmission_colour)
               ? "diffuse_transmission and diffuse_transmission_colour must lie between 0 and 1"
               : NULL;
}

static clast_status check_material(const clast_scene *scene, const clast_material_desc *material)
{
    const char *wrong = fault_of_base(material);
    wrong = wrong != NULL ? wrong : fault_of_layers(material);
    wrong = wrong != NULL ? wrong : fault_of_passage(material);
#define CHECK(slot) \
    wrong = slot_is_valid(scene, &material->slot) ? wrong \
                                                  : #slot " names a texture or coordinate set that is not there";
    CLAST_MATERIAL_TEXTURE_LIST(CHECK)
#undef CHECK
    return wrong == NULL ? CLAST_OK : clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "material: %s", wrong);
}

static packed3 packed(const float v[3])
{
    return (packed3){{v[0], v[1], v[2]}};
}

// Beer and Lambert: after attenuation_distance, attenuation_colour is left. Of black, as little as can be told apart.
static packed3 absorption_of(const clast_material_desc *desc)
{
    packed3 absorption = {{0.0f, 0.0f, 0.0f}};
    for (int i = 0; i < 3 && desc->attenuation_distance > 0.0f; i++) {
        float colour = desc->attenuation_colour[i] > 1e-6f ? desc->attenuation_colour[i] : 1e-6f;
        absorption.v[i] = clamp1(-logf(colour) / desc->attenuation_distance, 0.0f, 1e30f);
    }
    return absorption;
}

static uint32_t layers_of(const clast_material_desc *desc)
{
    const float *tint = desc->specular_colour;
    bool plain = desc->ior == 1.5f && desc->specular == 1.0f && tint[0] == 1.0f && tint[1] == 1.0f && tint[2] == 1.0f;
    bool fuzzy = desc->sheen_colour[0] > 0.0f || desc->sheen_colour[1] > 0.0f || desc->sheen_colour[2] > 0.0f;
    return (plain ? 0 : MATERIAL_SPECULAR) | (desc->clearcoat > 0.0f ? MATERIAL_CLEARCOAT : 0) |
           (fuzzy ? MATERIAL_SHEEN : 0) | (desc->anisotropy > 0.0f ? MATERIAL_ANISOTROPY : 0) |
           (desc->transmission > 0.0f ? MATERIAL_TRANSMISSION : 0) |
           (desc->iridescence > 0.0f ? MATERIAL_IRIDESCENCE : 0) |
           (desc->diffuse_transmission > 0.0f ? MATERIAL_DIFFUSE_TRANSMISSION : 0) |
           (desc->specular_texture.texture != CLAST_NONE || desc->specular_colour_texture.texture != CLAST_NONE
                ? MATERIAL_SPECULAR
                : 0);
}

static clast_material material_record(const clast_material_desc *desc)
{
    return (clast_material){
        .base_colour = {{desc->base_colour[0], desc->base_colour[1], desc->base_colour[2], desc->base_colour[3]}},
        .emissive = packed(desc->emissive),
        .metallic = desc->metallic,
        .roughness = desc->roughness,
        .normal_scale = desc->normal_scale,
        .occlusion_strength = desc->occlusion_strength,
        .alpha_cutoff = desc->alpha_cutoff,
        .alpha_mode = desc->alpha_mode,
        .double_sided = desc->double_sided,
        .displacement_scale = desc->displacement_scale,
        .displacement_offset = desc->displacement_offset,
        .layers = layers_of(desc),
        .ior = desc->ior,
        .specular = desc->specular,
        .specular_colour = packed(desc->specular_colour),
        .clearcoat = desc->clearcoat,
        .clearcoat_roughness = desc->clearcoat_roughness,
        .clearcoat_normal_scale = desc->clearcoat_normal_scale,
        .sheen_colour = packed(desc->sheen_colour),
        .sheen_roughness = desc->sheen_roughness,
        .anisotropy = desc->anisotropy,
        .anisotropy_direction = {{cosf(desc->anisotropy_rotation), sinf(desc->anisotropy_rotation)}},
        .transmission = desc->transmission,
        .thickness = desc->thickness,
        .absorption = absorption_of(desc),
        .dispersion = desc->dispersion,
        .iridescence = desc->iridescence,
        .iridescence_ior = desc->iridescence_ior,
        .iridescence_thickness_minimum = desc->iridescence_thickness_minimum,
        .iridescence_thickness_maximum = desc->iridescence_thickness_maximum,
        .diffuse_transmission = desc->diffuse_transmission,
        .diffuse_transmission_colour = packed(desc->diffuse_transmission_colour),
        .unlit = desc->unlit,
#define USE(slot) .slot = texture_use(&desc->slot),
        CLAST_MATERIAL_TEXTURE_LIST(USE)
#undef USE
    };
}

clast_status clast_scene_add_material(clast_scene *scene, const clast_material_desc *material, const char *name,
                                      uint32_t *number)
{
    if (scene == NULL || material == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_status status = check_material(scene, material);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, scene->materials, scene->material_capacity, scene->material_count + 1);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_scene_material added = {.record = material_record(material)};
    if (!copy_name(context, name, &added.name)) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *number = (uint32_t)scene->material_count;
    scene->materials[scene->material_count++] = added;
    scene->material_version++;
    return CLAST_OK;
}

// Tessellated meshes hold what their materials say of displacement.
static void note_displacement(clast_scene *scene, const clast_material *before, const clast_material *now)
{
    bool same = memcmp(&before->displacement_texture, &now->displacement_texture, sizeof now->displacement_texture) ==
                    0 &&
                before->displacement_scale == now->displacement_scale &&
                before->displacement_offset == now->displacement_offset;
    for (size_t i = 0; !same && i < scene->geometry_count; i++) {
        scene->geometries[i].version += scene->geometries[i].tessellated ? 1 : 0;
    }
}

clast_status clast_scene_set_material(clast_scene *scene, uint32_t number, const clast_material_desc *material)
{
    if (scene == NULL || material == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (number >= scene->material_count) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "material %u of %zu", number,
                          scene->material_count);
    }
    clast_status status = check_material(scene, material);
    if (status == CLAST_OK) {
        clast_material before = scene->materials[number].record;
        scene->materials[number].record = material_record(material);
        scene->material_version++;
        note_displacement(scene, &before, &scene->materials[number].record);
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- lights

static bool vector_is_finite(const float v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

clast_status clast_scene_add_light(clast_scene *scene, const clast_light_desc *light, const char *name,
                                   uint32_t *number)
{
    if (scene == NULL || light == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    vec3 direction = normalize3(vec3(light->direction[0], light->direction[1], light->direction[2]));
    vec3 radiance = vec3(light->colour[0], light->colour[1], light->colour[2]) * light->intensity;
    bool sound = vector_is_finite(light->position) && vector_is_finite(light->direction) && is_finite3(radiance) &&
                 isfinite(light->intensity) && light->intensity >= 0.0f && light->range >= 0.0f &&
                 (unsigned)light->type <= CLAST_LIGHT_DIRECTIONAL;
    if (light->type != CLAST_LIGHT_POINT) {
        sound = sound && dot3(direction, direction) > 0.5f;
    }
    if (light->type == CLAST_LIGHT_SPOT) {
        sound = sound && light->inner_angle >= 0.0f && light->inner_angle <= light->outer_angle &&
                light->outer_angle <= 0.5f * HALF_TURN + 1e-5f;
    }
    if (!sound) {
        return clast_fail(
            context, CLAST_ERROR_INVALID_ARGUMENT,
            "light: expected finite values, a direction, intensity >= 0 and 0 <= inner <= outer <= half pi");
    }
    clast_status status = CLAST_RESERVE(context, scene->lights, scene->light_capacity, scene->light_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    clast_scene_light added = {.record =
                                   {
                                       .type = light->type,
                                       .position = {{light->position[0], light->position[1], light->position[2]}},
                                       .direction = store3(direction),
                                       .radiance = store3(radiance),
                                       .range = light->range,
                                       .inner_cosine = cosf(light->inner_angle),
                                       .outer_cosine = cosf(light->outer_angle),
                                   },
                               .node = CLAST_NONE};
    if (!copy_name(context, name, &added.name)) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *number = (uint32_t)scene->light_count;
    scene->lights[scene->light_count++] = added;
    scene->light_version++;
    return CLAST_OK;
}

clast_status clast_scene_set_environment(clast_scene *scene, const clast_environment *environment)
{
    if (scene == NULL || environment == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_environment resolved = *environment;
    const float *colour = resolved.colour;
    const float *sun = resolved.sun_direction;
    bool is_sky = resolved.type == CLAST_ENVIRONMENT_SKY;
    const char *wrong = NULL;
    if ((unsigned)resolved.type > CLAST_ENVIRONMENT_CONSTANT) {
        wrong = "the type is none of the list";
    } else if (!vector_is_finite(colour) || colour[0] < 0.0f || colour[1] < 0.0f || colour[2] < 0.0f) {
        wrong = "the colour must be finite and not negative";
    } else if (resolved.type == CLAST_ENVIRONMENT_IMAGE && resolved.image >= scene->image_count) {
        wrong = "the image is not there";
    } else if (!isfinite(resolved.rotation)) {
        wrong = "the rotation must be finite";
    } else if (is_sky && (!vector_is_finite(sun) || (sun[0] == 0.0f && sun[1] == 0.0f && sun[2] == 0.0f))) {
        wrong = "a sky needs the sun's direction";
    } else if (is_sky && resolved.turbidity != 0.0f && !(resolved.turbidity >= 1.0f && resolved.turbidity <= 10.0f)) {
        wrong = "the turbidity must lie between 1 and 10";
    } else if (is_sky && !(resolved.sun_size >= 0.0f && resolved.sun_size <= 0.5f)) {
        wrong = "the sun's size must lie between 0 and 0.5";
    }
    if (wrong != NULL) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "environment: %s", wrong);
    }
    if (resolved.type != CLAST_ENVIRONMENT_CONSTANT && colour[0] == 0.0f && colour[1] == 0.0f && colour[2] == 0.0f) {
        resolved.colour[0] = resolved.colour[1] = resolved.colour[2] = 1.0f;
    }
    resolved.turbidity = resolved.turbidity != 0.0f ? resolved.turbidity : 2.5f;
    resolved.sun_size = resolved.sun_size != 0.0f ? resolved.sun_size : 0.00465f;
    if (is_sky) {
        vec3 direction = normalize3(vec3(sun[0], sun[1], sun[2]));
        for (int i = 0; i < 3; i++) {
            resolved.sun_direction[i] = direction[i];
        }
    }
    scene->environment = resolved;
    scene->has_environment = true;
    scene->light_version++;
    return CLAST_OK;
}

clast_status clast_scene_keep_file(clast_scene *scene, clast_file_view file)
{
    clast_status status = CLAST_RESERVE(scene->context, scene->files, scene->file_capacity, scene->file_count + 1);
    if (status != CLAST_OK) {
        clast_file_unmap(scene->context, &file);
        return status;
    }
    scene->files[scene->file_count++] = file;
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- queries

void clast_scene_count(const clast_scene *scene, clast_scene_counts *counts)
{
    *counts = (clast_scene_counts){
        .images = (uint32_t)scene->image_count,
        .textures = (uint32_t)scene->texture_count,
        .materials = (uint32_t)scene->material_count,
        .geometries = (uint32_t)scene->geometry_count,
        .lights = (uint32_t)scene->light_count,
        .cameras = (uint32_t)scene->camera_count,
    };
    for (size_t i = 0; i < scene->geometry_count; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        counts->triangles += clast_geometry_is_mesh(geometry) ? geometry->of.mesh.triangle_count : 0;
    }
    for (size_t i = 0; i < scene->instance_count; i++) {
        const clast_instance *instance = &scene->instances[i];
        if (instance->removed) {
            continue;
        }
        counts->instances++;
        const clast_geometry *geometry = &scene->geometries[instance->geometry];
        counts->instanced_triangles += clast_geometry_is_mesh(geometry) ? geometry->of.mesh.triangle_count : 0;
    }
    for (size_t i = 0; i < scene->image_count; i++) {
        size_t bytes = 0;
        image_bytes(&scene->images[i].image, &bytes);
        counts->image_bytes += bytes;
    }
}
