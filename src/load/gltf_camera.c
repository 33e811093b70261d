// SPDX-License-Identifier: Apache-2.0
// Cameras (section 3.10) and lights (KHR_lights_punctual) of nodes.
#include <float.h>
#include <math.h>
#include <string.h>

#include "load/gltf.h"

static const float HALF_TURN = 3.14159265f;

// A column of a transform, without its scale.
static void axis(const clast_matrix *to_world, int column, double sign, float out[3])
{
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        length += to_world->rows[i][column] * to_world->rows[i][column];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++) {
        out[i] = length > 0.0 ? (float)(sign * to_world->rows[i][column] / length) : 0.0f;
    }
}

static void read_projection(clast_gltf *gltf, const clast_gltf_value *value, clast_camera_desc *camera)
{
    const char *type = clast_gltf_text(gltf, value, "type");
    bool is_perspective = type != NULL && strcmp(type, "perspective") == 0;
    if (!is_perspective && (type == NULL || strcmp(type, "orthographic") != 0)) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "type \"%.40s\": expected perspective or orthographic",
                        type != NULL ? type : "");
        return;
    }
    clast_gltf_value part = clast_gltf_object(gltf, value, is_perspective ? "perspective" : "orthographic");
    if (clast_gltf_ok(gltf) && part.json == NULL) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &part, "missing: expected an object");
    }
    camera->near_plane = clast_gltf_number(gltf, &part, "znear", 0.0f, FLT_MAX, 0.0f);
    camera->far_plane = clast_gltf_number(gltf, &part, "zfar", 0.0f, FLT_MAX, 0.0f);
    if (is_perspective) {
        camera->projection = CLAST_PROJECTION_PERSPECTIVE;
        camera->vertical_angle = clast_gltf_number(gltf, &part, "yfov", FLT_MIN, HALF_TURN - 1e-3f, 0.8f);
    } else {
        camera->projection = CLAST_PROJECTION_ORTHOGRAPHIC;
        camera->height = 2.0f * fabsf(clast_gltf_number(gltf, &part, "ymag", -FLT_MAX / 4.0f, FLT_MAX / 4.0f, 0.0f));
        if (clast_gltf_ok(gltf) && camera->height == 0.0f) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &part,
                            "ymag: expected half the height of what is seen, not 0");
        }
    }
}

// Cameras look along -z with y up; scale does not act on them (section 3.10.2). The aspect ratio is the picture's.
void clast_gltf_add_camera(clast_gltf *gltf, const clast_gltf_value *node, uint32_t number_in_scene,
                           const clast_matrix *to_world)
{
    uint32_t index = clast_gltf_index(gltf, node, "camera", CLAST_GLTF_CAMERAS);
    if (!clast_gltf_ok(gltf) || index == CLAST_NONE) {
        return;
    }
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_CAMERAS, index);
    clast_camera_desc camera = {0};
    read_projection(gltf, &value, &camera);
    const char *name = clast_gltf_text(gltf, node, "name");
    if (name == NULL) {
        name = clast_gltf_text(gltf, &value, "name");
    }
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    float forward[3];
    axis(to_world, 2, -1.0, forward);
    axis(to_world, 1, 1.0, camera.up);
    double reach = 1.0; // far enough that position and target differ as floats
    for (int i = 0; i < 3; i++) {
        reach = fmax(reach, fabs(to_world->rows[i][3]));
    }
    for (int i = 0; i < 3; i++) {
        camera.position[i] = (float)to_world->rows[i][3];
        camera.target[i] = (float)(to_world->rows[i][3] + (double)forward[i] * reach);
    }
    if (forward[0] == 0.0f && forward[1] == 0.0f && forward[2] == 0.0f) {
        clast_gltf_warn(gltf, node, "the camera's direction is scaled to nothing: left out");
        return;
    }
    uint32_t number;
    if (clast_gltf_check(gltf, clast_scene_add_camera(gltf->scene, &camera, name, &number)) &&
        number_in_scene != CLAST_NONE) {
        clast_gltf_check(gltf, clast_scene_attach_camera(gltf->scene, number, number_in_scene));
    }
}

static bool read_light_type(clast_gltf *gltf, const clast_gltf_value *value, clast_light_type *type)
{
    static const char *const names[] = {
#define NAME(name, value, text) [value] = text,
        CLAST_LIGHT_LIST(NAME)
#undef NAME
    };
    const char *text = clast_gltf_text(gltf, value, "type");
    for (size_t i = 0; text != NULL && i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], text) == 0) {
            *type = (clast_light_type)i;
            return true;
        }
    }
    return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "type \"%.40s\": expected point, spot or directional",
                           text != NULL ? text : "");
}

// KHR_lights_punctual. Lights shine along -z.
void clast_gltf_add_light(clast_gltf *gltf, const clast_gltf_value *node, uint32_t number_in_scene,
                          const clast_matrix *to_world)
{
    clast_gltf_value extensions;
    clast_gltf_value use = clast_gltf_extension(gltf, node, &extensions, "KHR_lights_punctual");
    if (use.json == NULL) {
        return;
    }
    clast_gltf_value root_extensions;
    clast_gltf_value list = clast_gltf_extension(gltf, &gltf->root, &root_extensions, "KHR_lights_punctual");
    clast_gltf_value lights = clast_gltf_array(gltf, &list, "lights");
    uint64_t count = clast_gltf_size(&lights);
    uint64_t index = clast_gltf_integer(gltf, &use, "light", 0, count != 0 ? count - 1 : 0, CLAST_GLTF_REQUIRED);
    if (clast_gltf_ok(gltf) && count == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &use,
                        "the file has no lights: expected extensions.KHR_lights_punctual.lights");
    }
    clast_light_desc light = {.colour = {1, 1, 1}};
    if (!clast_gltf_ok(gltf)) {
        return;
    }
    clast_gltf_value value = clast_gltf_element_object(gltf, &lights, (size_t)index);
    if (!clast_gltf_ok(gltf) || !read_light_type(gltf, &value, &light.type)) {
        return;
    }
    clast_gltf_numbers(gltf, &value, "color", 3, 0.0f, FLT_MAX, light.colour);
    light.intensity = clast_gltf_number(gltf, &value, "intensity", 0.0f, FLT_MAX, 1.0f);
    light.range = clast_gltf_number(gltf, &value, "range", 0.0f, FLT_MAX, 0.0f);
    if (light.type == CLAST_LIGHT_SPOT) {
        clast_gltf_value cone = clast_gltf_object(gltf, &value, "spot");
        light.outer_angle = clast_gltf_number(gltf, &cone, "outerConeAngle", 0.0f, HALF_TURN / 2.0f, HALF_TURN / 4.0f);
        light.inner_angle = clast_gltf_number(gltf, &cone, "innerConeAngle", 0.0f, light.outer_angle, 0.0f);
    }
    const char *name = clast_gltf_text(gltf, node, "name");
    name = name != NULL ? name : clast_gltf_text(gltf, &value, "name");
    axis(to_world, 2, -1.0, light.direction);
    for (int i = 0; i < 3; i++) {
        light.position[i] = (float)to_world->rows[i][3];
    }
    if (light.type != CLAST_LIGHT_POINT && light.direction[0] == 0.0f && light.direction[1] == 0.0f &&
        light.direction[2] == 0.0f) {
        clast_gltf_warn(gltf, node, "the light's direction is scaled to nothing: left out");
        return;
    }
    uint32_t number;
    if (clast_gltf_ok(gltf) && clast_gltf_check(gltf, clast_scene_add_light(gltf->scene, &light, name, &number)) &&
        number_in_scene != CLAST_NONE) {
        clast_gltf_check(gltf, clast_scene_attach_light(gltf->scene, number, number_in_scene));
    }
}
