// SPDX-License-Identifier: Apache-2.0
// Cameras of a scene, and the choice of one.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

static const float HALF_TURN = 3.14159265f;

static bool is_finite_vector(const float v[3])
{
    return is_finite1(v[0]) && is_finite1(v[1]) && is_finite1(v[2]);
}

clast_status clast_scene_add_camera(clast_scene *scene, const clast_camera_desc *camera, const char *name,
                                    uint32_t *number)
{
    if (scene == NULL || camera == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    const float *p = camera->position, *t = camera->target;
    const char *wrong = NULL;
    if (!is_finite_vector(p) || !is_finite_vector(t) || !is_finite_vector(camera->up)) {
        wrong = "position, target and up must be finite";
    } else if (p[0] == t[0] && p[1] == t[1] && p[2] == t[2]) {
        wrong = "the target must not be the position";
    } else if ((unsigned)camera->projection > CLAST_PROJECTION_PANORAMA) {
        wrong = "the projection is none of the list";
    } else if (!(camera->vertical_angle >= 0.0f && camera->vertical_angle < HALF_TURN)) {
        wrong = "the vertical angle must lie between 0 and pi";
    } else if (camera->projection == CLAST_PROJECTION_ORTHOGRAPHIC &&
               !(camera->height > 0.0f && is_finite1(camera->height))) {
        wrong = "an orthographic camera needs a height above 0";
    } else if (!(camera->near_plane >= 0.0f) || !(camera->far_plane >= 0.0f)) {
        wrong = "the near and far plane must not be negative";
    } else if (!(camera->aperture >= 0.0f && is_finite1(camera->aperture)) ||
               !(camera->focus >= 0.0f && is_finite1(camera->focus))) {
        wrong = "the aperture and the focus must be finite and not negative";
    }
    if (wrong != NULL) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "camera: %s", wrong);
    }
    clast_status status = CLAST_RESERVE(context, scene->cameras, scene->camera_capacity, scene->camera_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    clast_scene_camera added = {.desc = *camera, .node = CLAST_NONE};
    if (name != NULL && name[0] != '\0') {
        added.name = clast_copy_text(context, name);
        if (added.name == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    *number = (uint32_t)scene->camera_count;
    scene->cameras[scene->camera_count++] = added;
    return CLAST_OK;
}

static clast_camera_desc default_camera(const clast_scene *scene, float aspect)
{
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    clast_camera_desc camera = {.position = {0.0f, 0.0f, 1.0f}};
    if (!(lower[0] <= upper[0])) {
        return camera;
    }
    vec3 low = vec3(lower[0], lower[1], lower[2]), high = vec3(upper[0], upper[1], upper[2]);
    vec3 centre = low * 0.5f + high * 0.5f;
    vec3 view = normalize3(vec3(0.55f, 0.4f, 1.0f));
    vec3 right = normalize3(cross3(vec3(0.0f, 1.0f, 0.0f), view)), up = cross3(view, right);
    const float tangent = 0.4227932f; // of half the angle that vertical_angle 0 stands for
    float distance = 0.0f;
    for (int corner = 0; corner < 8; corner++) { // the nearest place from which every corner of the box is seen
        vec3 offset =
            vec3(corner & 1 ? high[0] : low[0], corner & 2 ? high[1] : low[1], corner & 4 ? high[2] : low[2]) - centre;
        float aside = max1(abs1(dot3(offset, right)) / aspect, abs1(dot3(offset, up)));
        distance = max1(distance, dot3(offset, view) + aside / tangent);
    }
    vec3 position = centre + view * (distance > 0.0f ? 1.08f * distance : 1.0f);
    for (int i = 0; i < 3; i++) {
        camera.position[i] = position[i];
        camera.target[i] = centre[i];
    }
    return camera;
}

clast_status clast_scene_add_default_camera(clast_scene *scene, uint32_t *number)
{
    if (scene == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_camera_desc camera = default_camera(scene, 16.0f / 9.0f);
    return clast_scene_add_camera(scene, &camera, "default", number);
}

clast_camera clast_camera_record(const clast_camera_desc *desc, uint32_t width, uint32_t height)
{
    vec3 position = vec3(desc->position[0], desc->position[1], desc->position[2]);
    vec3 target = vec3(desc->target[0], desc->target[1], desc->target[2]);
    vec3 up = vec3(desc->up[0], desc->up[1], desc->up[2]);
    up = dot3(up, up) > 0.0f ? normalize3(up) : vec3(0.0f, 1.0f, 0.0f);
    vec3 away = target - position;
    // Scaled first: scenes may be so small that the square of a distance is none.
    vec3 forward = normalize3(away * (1.0f / largest3(vec3(abs1(away[0]), abs1(away[1]), abs1(away[2])))));
    vec3 right = cross3(forward, up);
    if (dot3(right, right) < 1e-10f) { // looking along `up`: any other will do
        right = cross3(forward, abs1(forward[0]) < 0.5f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 0.0f, -1.0f));
    }
    right = normalize3(right);
    float angle = desc->vertical_angle != 0.0f ? desc->vertical_angle : 0.8f;
    float extents[] = {
        [CLAST_PROJECTION_PERSPECTIVE] = tanf(0.5f * angle),
        [CLAST_PROJECTION_ORTHOGRAPHIC] = 0.5f * desc->height,
        [CLAST_PROJECTION_PANORAMA] = 0.5f * HALF_TURN,
    };
    return (clast_camera){
        .projection = desc->projection,
        .position = store3(position),
        .right = store3(right),
        .up = store3(cross3(right, forward)),
        .forward = store3(forward),
        .vertical_extent = extents[desc->projection],
        .aspect = (float)width / (float)height,
        .near_plane = desc->near_plane,
        .far_plane = desc->far_plane,
        .lens_radius = 0.5f * desc->aperture,
        .focus = desc->focus > 0.0f ? desc->focus : length3(away),
    };
}

// Reads up to `most` numbers divided by commas; gives how many, or -1 where the text is none.
static int read_numbers(const char *text, size_t length, float *numbers, int most)
{
    char copy[256];
    if (length == 0 || length >= sizeof copy) {
        return -1;
    }
    memcpy(copy, text, length);
    copy[length] = '\0';
    int count = 0;
    for (char *place = copy;; place++) {
        char *end;
        float number = strtof(place, &end);
        if (end == place || !is_finite1(number) || count == most) {
            return -1;
        }
        numbers[count++] = number;
        place = end;
        if (*place == '\0') {
            return count;
        }
        if (*place != ',') {
            return -1;
        }
    }
}

// eye/target[/up[/fov in degrees]], as 0,1,4/0,0,0/0,1,0/45. False where the text is not of that form.
static bool parse_camera(const char *text, clast_camera_desc *camera)
{
    *camera = (clast_camera_desc){0};
    float *parts[4] = {camera->position, camera->target, camera->up, &camera->vertical_angle};
    int part = 0;
    while (part < 4) {
        const char *slash = strchr(text, '/');
        size_t length = slash != NULL ? (size_t)(slash - text) : strlen(text);
        int wanted = part < 3 ? 3 : 1;
        if (read_numbers(text, length, parts[part], wanted) != wanted) {
            return false;
        }
        part++;
        if (slash == NULL) {
            break;
        }
        text = slash + 1;
        if (part == 4) {
            return false;
        }
    }
    if (part == 4) {
        if (!(camera->vertical_angle > 0.0f && camera->vertical_angle < 180.0f)) {
            return false;
        }
        camera->vertical_angle *= HALF_TURN / 180.0f;
    }
    const float *p = camera->position, *t = camera->target;
    return part >= 2 && !(p[0] == t[0] && p[1] == t[1] && p[2] == t[2]);
}

uint32_t clast_scene_find_camera(const clast_scene *scene, const char *text)
{
    if (text == NULL || text[0] == '\0') {
        return scene->camera_count != 0 ? 0 : CLAST_NONE;
    }
    for (size_t i = 0; i < scene->camera_count; i++) {
        char number[24];
        snprintf(number, sizeof number, "%zu", i);
        const char *name = scene->cameras[i].name;
        if ((name != NULL && strcmp(name, text) == 0) || strcmp(number, text) == 0) {
            return (uint32_t)i;
        }
    }
    return CLAST_NONE;
}

clast_status clast_scene_choose_camera(clast_scene *scene, const char *text, uint32_t width, uint32_t height,
                                       clast_camera *camera)
{
    uint32_t number = clast_scene_find_camera(scene, text);
    if (number != CLAST_NONE) {
        *camera = clast_camera_record(&scene->cameras[number].desc, width, height);
        return CLAST_OK;
    }
    clast_camera_desc desc;
    if (text == NULL || text[0] == '\0') {
        desc = default_camera(scene, (float)width / (float)height);
        *camera = clast_camera_record(&desc, width, height);
        return CLAST_OK;
    }
    if (parse_camera(text, &desc)) {
        *camera = clast_camera_record(&desc, width, height);
        return CLAST_OK;
    }
    return clast_fail(
        scene->context, CLAST_ERROR_INVALID_ARGUMENT,
        "camera \"%s\": expected the name or number of one of the scene's %zu cameras, or eye/target[/up[/fov]]", text,
        scene->camera_count);
}
