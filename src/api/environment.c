// SPDX-License-Identifier: Apache-2.0
// What surrounds a scene in a render: the setting, the scene's own, or a sky where it would be dark.
#include <stdlib.h>
#include <string.h>

#include "api/renderer.h"
#include "clast/image.h"

// A sky with the sun high at the right, behind a camera that looks from the front; dimmed, so that a white surface in the sun is
// not overexposed.
static clast_environment plain_sky(void)
{
    return (clast_environment){
        .type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.45f, 0.7f, 0.55f}, .colour = {0.35f, 0.35f, 0.35f}};
}

// "r,g,b": three numbers of at least 0, and nothing else. A file of such a name can be given as ./1,1,1.
static bool parse_colour(const char *text, float colour[3])
{
    float parsed[3];
    for (int i = 0; i < 3; i++) {
        char *end = NULL;
        parsed[i] = strtof(text, &end);
        char expected = i < 2 ? ',' : '\0';
        if (end == text || *end != expected || !is_finite1(parsed[i]) || parsed[i] < 0.0f) {
            return false;
        }
        text = end + 1;
    }
    memcpy(colour, parsed, sizeof parsed);
    return true;
}

// Reads the image into the scene, once for the same path: images are never taken out of a scene.
static clast_status load_environment_image(clast_renderer *renderer, const char *path)
{
    if (renderer->environment_path != NULL && strcmp(renderer->environment_path, path) == 0) {
        return CLAST_OK;
    }
    char *copy = clast_copy_text(renderer->context, path);
    if (copy == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_image image = {0};
    uint32_t number = CLAST_NONE;
    clast_status status = clast_image_read(renderer->context, path, &image);
    if (status == CLAST_OK) {
        status = clast_scene_adopt_image(renderer->scene, &image, path, &number);
    }
    if (status != CLAST_OK) {
        clast_free(renderer->context, copy);
        return status;
    }
    clast_free(renderer->context, renderer->environment_path);
    renderer->environment_path = copy;
    renderer->environment_image = number;
    return CLAST_OK;
}

// A picture of an emission of at most one is a display or a glowing detail, not what a scene is lit by.
static bool is_lamp(const clast_material *material)
{
    return material->emissive_texture.texture == CLAST_NONE || largest3(load3(material->emissive)) > 1.0f;
}

static bool scene_is_dark(const clast_renderer *renderer)
{
    const clast_scene *scene = renderer->scene;
    const clast_frame *frame = clast_picture_frame(renderer);
    if (scene->has_environment || scene->light_count != 0) {
        return false;
    }
    for (size_t i = 0; i < frame->emitter_count; i++) {
        if (is_lamp(&scene->materials[frame->emitters[i].material].record)) {
            return false;
        }
    }
    return true;
}

clast_status clast_environment_begin(clast_renderer *renderer, const clast_render_settings *settings,
                                     clast_kept_environment *kept)
{
    clast_scene *scene = renderer->scene;
    *kept = (clast_kept_environment){scene->environment, scene->has_environment};
    clast_environment environment = plain_sky();
    if (settings->env[0] == '\0') {
        if (!scene_is_dark(renderer)) {
            return CLAST_OK;
        }
    } else if (parse_colour(settings->env, environment.colour)) {
        environment.type = CLAST_ENVIRONMENT_CONSTANT;
    } else if (strcmp(settings->env, "sky") != 0) {
        clast_status status = load_environment_image(renderer, settings->env);
        if (status != CLAST_OK) {
            return status;
        }
        environment = (clast_environment){.type = CLAST_ENVIRONMENT_IMAGE, .image = renderer->environment_image};
    }
    scene->environment = environment;
    scene->has_environment = true;
    scene->light_version++;
    return CLAST_OK;
}

void clast_environment_end(clast_renderer *renderer, const clast_kept_environment *kept)
{
    renderer->scene->environment = kept->environment;
    renderer->scene->has_environment = kept->was_there;
    renderer->scene->light_version++;
}
