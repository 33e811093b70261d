// SPDX-License-Identifier: Apache-2.0
// What decides a picture, as numbers: a scene is what is drawn of it at the moment of a frame, whatever file it came from.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "render/checkpoint.h"
#include "render/lights.h"

static void add(XXH3_state_t *state, const void *data, size_t count, size_t size)
{
    uint64_t bytes = data != NULL ? (uint64_t)count * size : 0;
    XXH3_64bits_update(state, &bytes, sizeof bytes);
    if (bytes != 0) {
        XXH3_64bits_update(state, data, (size_t)bytes);
    }
}

static void add_number(XXH3_state_t *state, uint64_t number)
{
    XXH3_64bits_update(state, &number, sizeof number);
}

static void add_mesh(XXH3_state_t *state, const clast_mesh *mesh, const clast_pose *pose)
{
    size_t vertices = mesh->vertex_count;
    add(state, pose->positions != NULL ? (const void *)pose->positions : mesh->positions, vertices, sizeof(packed3));
    add(state, pose->normals != NULL ? (const void *)pose->normals : mesh->normals, vertices, sizeof(packed3));
    add(state, pose->tangents != NULL ? (const void *)pose->tangents : mesh->tangents, vertices, sizeof(packed4));
    add(state, mesh->coordinates[0], vertices, sizeof(packed2));
    add(state, mesh->coordinates[1], vertices, sizeof(packed2));
    add(state, mesh->colours, vertices, sizeof(packed4));
    add(state, mesh->indices, mesh->triangle_count, 3 * sizeof *mesh->indices);
    add(state, mesh->triangle_materials, mesh->triangle_count, sizeof *mesh->triangle_materials);
    add_number(state, mesh->material);
}

static void add_unit(XXH3_state_t *state, const clast_geometry *geometry, const clast_frame_unit *unit)
{
    add_number(state, geometry->kind);
    if (clast_geometry_is_mesh(geometry)) {
        add_number(state, (geometry->tessellated ? 1u : 0u) | (geometry->tessellation.curved ? 2u : 0u));
        add_mesh(state, &geometry->of.mesh, &unit->pose);
    } else {
        add(state, &geometry->of.wave, 1, sizeof geometry->of.wave);
    }
}

static void add_surfaces(XXH3_state_t *state, const clast_scene *scene)
{
    for (size_t i = 0; i < scene->image_count; i++) {
        const clast_image *image = &scene->images[i].image;
        size_t element = image->type == CLAST_PIXEL_UNORM8 ? 1 : image->type == CLAST_PIXEL_UNORM16 ? 2 : 4;
        add_number(state, (uint64_t)image->width << 32 | image->height);
        add_number(state, (uint64_t)image->channels << 32 | (uint64_t)image->type);
        add(state, image->pixels, (size_t)image->width * image->height, image->channels * element);
    }
    add(state, scene->textures, scene->texture_count, sizeof *scene->textures);
    for (size_t i = 0; i < scene->material_count; i++) {
        add(state, &scene->materials[i].record, 1, sizeof scene->materials[i].record);
    }
}

static void add_lights(XXH3_state_t *state, const clast_frame *frame)
{
    const clast_environment *environment = &frame->scene->environment;
    add(state, frame->motion.lights, frame->scene->light_count, sizeof *frame->motion.lights);
    add_number(state, frame->scene->has_environment);
    if (frame->scene->has_environment) {
        const float numbers[] = {
            environment->rotation,         environment->colour[0],        environment->colour[1],
            environment->colour[2],        environment->sun_direction[0], environment->sun_direction[1],
            environment->sun_direction[2], environment->turbidity,        environment->sun_size};
        add_number(state, (uint64_t)environment->type << 32 | environment->image);
        add(state, numbers, sizeof numbers / sizeof *numbers, sizeof *numbers);
    }
}

clast_status clast_scene_identity(const clast_frame *frame, uint64_t *identity)
{
    XXH3_state_t *state = clast_allocate(frame->context, 1, sizeof *state);
    if (state == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    XXH3_64bits_reset(state);
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (frame->units[i].used) {
            add_number(state, i);
            add_unit(state, &frame->scene->geometries[i], &frame->units[i]);
        }
    }
    for (size_t i = 0; i < frame->instance_count; i++) {
        add_number(state, (uint64_t)frame->instances[i].scene_instance << 32 | frame->instances[i].unit);
        add(state, &frame->instances[i].to_world, 1, sizeof frame->instances[i].to_world);
    }
    add_surfaces(state, frame->scene);
    add_lights(state, frame);
    add_number(state, frame->clusters); // tables of patterns, too, decide these
    add_number(state, frame->triangles);
    add_number(state, frame->vertices);
    *identity = XXH3_64bits_digest(state);
    clast_free(frame->context, state);
    return CLAST_OK;
}

uint64_t clast_camera_identity(const clast_frame *frame)
{
    const clast_camera cameras[] = {frame->settings.camera, frame->settings.rate_camera};
    return XXH3_64bits(cameras, sizeof cameras);
}

// --------------------------------------------------------------------------------------------------------- settings

// Those that do not decide what samples are, and those that are compared by what comes of them.
static bool is_compared(const char *name, bool by_noise)
{
    static const char *const others[] = {"width", "height",     "crop",    "camera",      "device",
                                         "spp",   "time_limit", "tonemap", "device_name", "shaders"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        if (strcmp(name, others[i]) == 0) {
            return false;
        }
    }
    return by_noise || strcmp(name, "exposure") != 0;
}

const char *const clast_setting_names[CLAST_SETTING_COUNT] = {
#define SETTING_NAME(name, ...) #name,
    CLAST_RENDER_SETTING_LIST(SETTING_NAME, SETTING_NAME, SETTING_NAME, SETTING_NAME)};

void clast_settings_identity(const clast_render_settings *settings, uint64_t numbers[CLAST_SETTING_COUNT])
{
    bool by_noise = settings->noise_target > 0.0;
    size_t count = 0;
#define NUMBER(name, ...) \
    numbers[count++] = is_compared(#name, by_noise) ? XXH3_64bits(&settings->name, sizeof settings->name) : 0;
#define TEXT(name, ...) \
    numbers[count++] = is_compared(#name, by_noise) && settings->name != NULL \
                           ? XXH3_64bits(settings->name, strlen(settings->name)) \
                           : 0;
    CLAST_RENDER_SETTING_LIST(NUMBER, NUMBER, NUMBER, TEXT)
}
