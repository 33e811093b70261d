// SPDX-License-Identifier: Apache-2.0
// Scene files: docs/scene-file.md says what they hold.
#include <math.h>

#include "load/account.h"
#include "load/image.h"
#include "load/json_text.h"
#include "load/load.h"
#include "load/scene_json.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const float degree = 0.0174532925f; // in radians

typedef struct scene_reader {
    clast_json json;
    clast_scene *scene;
} scene_reader;

// ------------------------------------------------------------------------------------------------------------ placing

// What a translation, rotation and scale of an object come to. The rotation is a quaternion x, y, z, w.
static clast_transform read_transform(scene_reader *reader, const clast_json_place *object)
{
    clast_json *json = &reader->json;
    float t[3] = {0.0f, 0.0f, 0.0f}, q[4] = {0.0f, 0.0f, 0.0f, 1.0f}, s[3] = {1.0f, 1.0f, 1.0f};
    clast_json_place translation = clast_json_member(object, "translation");
    clast_json_place rotation = clast_json_member(object, "rotation");
    clast_json_place scale = clast_json_member(object, "scale");
    clast_json_vector(json, &translation, t, 3);
    clast_json_vector(json, &rotation, q, 4);
    if (json_is_number(scale.value)) {
        clast_json_float(json, &scale, -HUGE_VAL, HUGE_VAL, &s[0]);
        s[1] = s[2] = s[0];
    } else {
        clast_json_vector(json, &scale, s, 3);
    }
    double length = sqrt((double)q[0] * (double)q[0] + (double)q[1] * (double)q[1] + (double)q[2] * (double)q[2] +
                         (double)q[3] * (double)q[3]);
    if (!(length > 0.0)) {
        clast_json_fail(json, &rotation, CLAST_ERROR_MALFORMED, "expected a quaternion x, y, z, w that is not zero");
        return transform_identity();
    }
    float x = (float)((double)q[0] / length), y = (float)((double)q[1] / length), z = (float)((double)q[2] / length);
    float w = (float)((double)q[3] / length);
    return transform_rows(vec4((1.0f - 2.0f * (y * y + z * z)) * s[0], 2.0f * (x * y - z * w) * s[1],
                               2.0f * (x * z + y * w) * s[2], t[0]),
                          vec4(2.0f * (x * y + z * w) * s[0], (1.0f - 2.0f * (x * x + z * z)) * s[1],
                               2.0f * (y * z - x * w) * s[2], t[1]),
                          vec4(2.0f * (x * z - y * w) * s[0], 2.0f * (y * z + x * w) * s[1],
                               (1.0f - 2.0f * (x * x + y * y)) * s[2], t[2]));
}

static bool is_finite_transform(const clast_transform *transform)
{
    for (int i = 0; i < 12; i++) {
        if (!isfinite(transform->rows[i / 4].v[i % 4])) {
            return false;
        }
    }
    return true;
}

static vec3 vector_of(const float v[3])
{
    return vec3(v[0], v[1], v[2]);
}

static void store_vector(vec3 v, float to[3])
{
    to[0] = v[0];
    to[1] = v[1];
    to[2] = v[2];
}

static void move_camera(clast_camera_desc *camera, clast_transform transform)
{
    vec3 up = vector_of(camera->up);
    up = dot3(up, up) > 0.0f ? up : vec3(0.0f, 1.0f, 0.0f);
    vec3 moved_up = transform_vector(transform, up);
    float growth = sqrtf(dot3(moved_up, moved_up) / dot3(up, up));
    store_vector(transform_point(transform, vector_of(camera->position)), camera->position);
    store_vector(transform_point(transform, vector_of(camera->target)), camera->target);
    store_vector(moved_up, camera->up);
    camera->height *= growth;
}

static void move_light(clast_light *light, clast_transform transform)
{
    light->position = store3(transform_point(transform, load3(light->position)));
    light->direction = store3(normalize3(transform_vector(transform, load3(light->direction))));
}

// How much of a scene was there before something was added.
typedef struct scene_mark {
    size_t instances, lights, cameras;
} scene_mark;

static scene_mark mark(const clast_scene *scene)
{
    return (scene_mark){scene->instance_count, scene->light_count, scene->camera_count};
}

static void place(scene_reader *reader, const clast_json_place *object, scene_mark from, clast_transform transform)
{
    clast_scene *scene = reader->scene;
    bool finite = is_finite_transform(&transform);
    for (size_t i = from.instances; i < scene->instance_count; i++) {
        scene->instances[i].to_world = transform_product(transform, scene->instances[i].to_world);
        finite = finite && is_finite_transform(&scene->instances[i].to_world);
    }
    for (size_t i = from.lights; i < scene->light_count; i++) {
        move_light(&scene->lights[i].record, transform);
    }
    for (size_t i = from.cameras; i < scene->camera_count; i++) {
        move_camera(&scene->cameras[i].desc, transform);
    }
    if (!finite) {
        clast_json_fail(&reader->json, object, CLAST_ERROR_MALFORMED, "the model leaves the range of single precision");
    }
}

// Repeats the instances since `from` in a square grid, as clast_scene_repeat does for a whole scene.
static clast_status repeat(clast_scene *scene, scene_mark from, uint32_t copies)
{
    size_t end = scene->instance_count, added, wanted;
    float lower[3], upper[3];
    if (!clast_multiply_size(end - from.instances, copies, &added) || !clast_add_size(from.instances, added, &wanted) ||
        wanted >= CLAST_NONE) {
        return clast_fail(scene->context, CLAST_ERROR_LIMIT, "%u copies are more instances than a scene holds", copies);
    }
    clast_status fits = clast_account_make(scene, "the copies", added, sizeof *scene->instances);
    if (fits != CLAST_OK) {
        return fits;
    }
    clast_scene part = *scene; // these instances alone, for their bounds
    part.instances = scene->instances + from.instances;
    part.instance_count = end - from.instances;
    clast_scene_bounds(&part, lower, upper);
    clast_status status = CLAST_RESERVE(scene->context, scene->instances, scene->instance_capacity, wanted);
    if (status != CLAST_OK || !(lower[0] <= upper[0])) {
        return status;
    }
    uint32_t side = (uint32_t)ceil(sqrt((double)copies));
    for (uint32_t copy = 1; copy < copies; copy++) {
        float x = (upper[0] - lower[0]) * 1.05f * (float)(copy % side);
        float z = (upper[2] - lower[2]) * -1.05f * (float)(copy / side);
        for (size_t i = from.instances; i < end; i++) {
            status = clast_scene_copy_instance(scene, i, x, z);
            if (status == CLAST_OK && !is_finite_transform(&scene->instances[scene->instance_count - 1].to_world)) {
                status = clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                                    "the copies leave the range of single precision");
            }
            if (status != CLAST_OK) {
                return status;
            }
        }
    }
    scene->instance_version++;
    return CLAST_OK;
}

// A path of the file, as one that can be opened; null after a failure.
static char *path_of(scene_reader *reader, const clast_json_place *place)
{
    const char *relative = NULL;
    if (!clast_json_require(&reader->json, place) || !clast_json_text(&reader->json, place, &relative)) {
        return NULL;
    }
    char *path = clast_path_beside(reader->json.context, reader->json.path, relative);
    if (path == NULL) {
        reader->json.status = CLAST_ERROR_OUT_OF_MEMORY;
    }
    return path;
}

// Loads a model and places it: what moves in it hangs from a node that does, all else is moved once.
static void load_model(scene_reader *reader, const clast_json_place *model, const char *path, clast_transform transform)
{
    clast_json *json = &reader->json;
    clast_motion *motion = &reader->scene->motion;
    scene_mark from = mark(reader->scene);
    clast_scene_node base = {.parent = CLAST_NONE, .has_matrix = true, .matrix = clast_matrix_of_transform(&transform)};
    uint32_t number = CLAST_NONE;
    clast_json_check(json, model, clast_scene_adopt_node(reader->scene, &base, NULL, &number));
    if (json->status != CLAST_OK) {
        return;
    }
    motion->base = number + 1;
    clast_json_check(json, model, clast_load_model(reader->scene, path));
    motion->base = 0;
    if (json->status == CLAST_OK && motion->node_count == number + 1) {
        motion->node_count--;
        place(reader, model, from, transform);
    }
}

// ------------------------------------------------------------------------------------------------------- displacement

// The displacement of a model's materials, for files that cannot say it.
typedef struct model_displacement {
    bool given;
    clast_texture_use use;
    float scale, offset;
} model_displacement;

static model_displacement read_displacement(scene_reader *reader, const clast_json_place *object)
{
    static const clast_json_choice wraps[] = {CLAST_WRAP_LIST(CLAST_JSON_CHOICE)};
    clast_json *json = &reader->json;
    model_displacement displacement = {.use = {.texture = CLAST_NONE, .scale = {{1.0f, 1.0f}}}, .scale = 1.0f};
    if (!clast_json_object(json, object, "image scale offset coordinate_set repeat wrap")) {
        return displacement;
    }
    uint32_t wrap = CLAST_WRAP_REPEAT;
    clast_json_place image = clast_json_member(object, "image");
    clast_json_place place = clast_json_member(object, "scale");
    clast_json_float(json, &place, -HUGE_VAL, HUGE_VAL, &displacement.scale);
    place = clast_json_member(object, "offset");
    clast_json_float(json, &place, -HUGE_VAL, HUGE_VAL, &displacement.offset);
    place = clast_json_member(object, "coordinate_set");
    clast_json_uint(json, &place, 0, 1, &displacement.use.coordinate_set);
    place = clast_json_member(object, "repeat");
    clast_json_vector(json, &place, displacement.use.scale.v, 2);
    place = clast_json_member(object, "wrap");
    clast_json_choose(json, &place, wraps, COUNT(wraps), &wrap);
    char *path = path_of(reader, &image);
    clast_image pixels;
    clast_texture texture = {.wrap_u = (clast_wrap)wrap, .wrap_v = (clast_wrap)wrap};
    if (path != NULL && json->status == CLAST_OK) {
        clast_json_check(json, &image, clast_account_image(reader->scene, path, &pixels));
    }
    if (path != NULL && json->status == CLAST_OK) {
        clast_json_check(json, &image, clast_scene_adopt_image(reader->scene, &pixels, path, &texture.image));
    }
    if (path != NULL && json->status == CLAST_OK) {
        clast_json_check(json, &image, clast_scene_add_texture(reader->scene, &texture, &displacement.use.texture));
    }
    clast_free(json->context, path);
    displacement.given = json->status == CLAST_OK;
    return displacement;
}

static void displace(clast_scene *scene, uint32_t material, const model_displacement *displacement)
{
    clast_material *record = &scene->materials[material].record;
    record->displacement_texture = displacement->use;
    record->displacement_scale = displacement->scale;
    record->displacement_offset = displacement->offset;
    scene->material_version++;
}

// Displaces the materials from `first_material` on, and meshes without material by one of their own.
static void displace_model(scene_reader *reader, const clast_json_place *place, size_t first_geometry,
                           size_t first_material, const model_displacement *displacement)
{
    clast_scene *scene = reader->scene;
    uint32_t plain = CLAST_NONE;
    size_t end = scene->material_count;
    for (size_t i = first_material; i < end; i++) {
        displace(scene, (uint32_t)i, displacement);
    }
    for (size_t i = first_geometry; i < scene->geometry_count; i++) {
        clast_mesh *mesh = &scene->geometries[i].of.mesh;
        if (!clast_geometry_is_mesh(&scene->geometries[i]) || mesh->triangle_materials != NULL || mesh->material != 0) {
            continue;
        }
        if (plain == CLAST_NONE) {
            clast_material_desc desc = clast_material_defaults();
            clast_json_check(&reader->json, place, clast_scene_add_material(scene, &desc, NULL, &plain));
            if (reader->json.status != CLAST_OK) {
                return;
            }
            displace(scene, plain, displacement);
        }
        mesh->material = plain;
    }
}

// How the meshes of a model are tessellated: those that are displaced, all, or none.
static void tessellate_model(scene_reader *reader, const clast_json_place *model, size_t first_geometry)
{
    clast_json *json = &reader->json;
    clast_scene *scene = reader->scene;
    clast_tessellation tessellation = {.curved = false};
    bool wanted = true;
    clast_json_place tessellated = clast_json_member(model, "tessellated");
    clast_json_place curved = clast_json_member(model, "curved");
    clast_json_bool(json, &tessellated, &wanted);
    clast_json_bool(json, &curved, &tessellation.curved);
    bool all = wanted && (tessellated.value != NULL || tessellation.curved);
    for (size_t i = first_geometry; i < scene->geometry_count && json->status == CLAST_OK; i++) {
        const clast_geometry *geometry = &scene->geometries[i];
        if (clast_geometry_is_mesh(geometry) && (all || geometry->tessellated)) {
            clast_json_check(json, model,
                             clast_scene_set_tessellation(scene, (uint32_t)i, wanted ? &tessellation : NULL));
        }
    }
}

// What a model says of its file's scenes and variants goes before what the caller said for all.
static void choose_model(scene_reader *reader, const clast_json_place *model)
{
    clast_scene_choice *choice = &reader->scene->choice;
    clast_json_place scene = clast_json_member(model, "scene"), variant = clast_json_member(model, "variant");
    const char *text;
    if (clast_json_text(&reader->json, &scene, &text)) {
        choice->scene = text;
    }
    if (clast_json_text(&reader->json, &variant, &text)) {
        choice->variant = text;
    }
}

static void read_model(scene_reader *reader, const clast_json_place *model)
{
    clast_json *json = &reader->json;
    if (!clast_json_object(json, model,
                           "path scene variant translation rotation scale copies displacement tessellated curved")) {
        return;
    }
    uint32_t copies = 1;
    clast_transform transform = read_transform(reader, model);
    clast_json_place copies_place = clast_json_member(model, "copies");
    clast_json_place path_place = clast_json_member(model, "path");
    clast_json_uint(json, &copies_place, 1, UINT32_MAX, &copies);
    clast_json_place displacement_place = clast_json_member(model, "displacement");
    model_displacement displacement = read_displacement(reader, &displacement_place);
    char *path = path_of(reader, &path_place);
    if (path != NULL && json->status == CLAST_OK) {
        scene_mark from = mark(reader->scene);
        size_t first_geometry = reader->scene->geometry_count, first_material = reader->scene->material_count;
        clast_scene_choice before = reader->scene->choice;
        choose_model(reader, model);
        if (json->status == CLAST_OK) {
            load_model(reader, model, path, transform);
        }
        reader->scene->choice = before;
        if (json->status == CLAST_OK && displacement.given) {
            displace_model(reader, &displacement_place, first_geometry, first_material, &displacement);
            clast_json_check(json, &displacement_place,
                             clast_scene_tessellate_displaced(reader->scene, first_geometry));
        }
        if (json->status == CLAST_OK) {
            tessellate_model(reader, model, first_geometry);
        }
        if (json->status == CLAST_OK && copies > 1) {
            clast_json_check(json, &copies_place, repeat(reader->scene, from, copies));
        }
    }
    clast_free(json->context, path);
}

// -------------------------------------------------------------------------------------------------------- environment

static void read_sky(scene_reader *reader, const clast_json_place *sky, clast_environment *environment)
{
    clast_json *json = &reader->json;
    if (!clast_json_object(json, sky, "sun_direction turbidity sun_size colour")) {
        return;
    }
    clast_json_place direction = clast_json_member(sky, "sun_direction");
    clast_json_place turbidity = clast_json_member(sky, "turbidity");
    clast_json_place size = clast_json_member(sky, "sun_size");
    clast_json_place colour = clast_json_member(sky, "colour");
    environment->type = CLAST_ENVIRONMENT_SKY;
    clast_json_require(json, &direction);
    clast_json_vector(json, &direction, environment->sun_direction, 3);
    clast_json_float(json, &turbidity, 1.0, 10.0, &environment->turbidity);
    clast_json_vector(json, &colour, environment->colour, 3);
    if (clast_json_float(json, &size, 0.0, 28.0, &environment->sun_size)) {
        environment->sun_size *= degree;
    }
}

static void read_environment_image(scene_reader *reader, const clast_json_place *object, const clast_json_place *image,
                                   clast_environment *environment)
{
    clast_json *json = &reader->json;
    clast_json_place rotation = clast_json_member(object, "rotation");
    clast_json_place intensity = clast_json_member(object, "intensity");
    float factor = 1.0f;
    environment->type = CLAST_ENVIRONMENT_IMAGE;
    if (clast_json_float(json, &rotation, -1e6, 1e6, &environment->rotation)) {
        environment->rotation *= degree;
    }
    clast_json_float(json, &intensity, 1e-30, 1e30, &factor); // a factor of zero would mean one
    environment->colour[0] = environment->colour[1] = environment->colour[2] = factor;
    char *path = path_of(reader, image);
    clast_image pixels;
    if (path != NULL && json->status == CLAST_OK) {
        clast_json_check(json, image, clast_account_image(reader->scene, path, &pixels));
        if (json->status == CLAST_OK) {
            clast_json_check(json, image, clast_scene_adopt_image(reader->scene, &pixels, path, &environment->image));
        }
    }
    clast_free(json->context, path);
}

static void read_environment(scene_reader *reader, const clast_json_place *object)
{
    clast_json *json = &reader->json;
    clast_json_place sky = clast_json_member(object, "sky");
    clast_json_place image = clast_json_member(object, "image");
    clast_json_place colour = clast_json_member(object, "colour");
    if (!clast_json_object(json, object, image.value != NULL ? "image rotation intensity" : "sky image colour")) {
        return;
    }
    if ((sky.value != NULL) + (image.value != NULL) + (colour.value != NULL) != 1) {
        clast_json_fail(json, object, CLAST_ERROR_MALFORMED, "expected one of sky, image and colour");
        return;
    }
    clast_environment environment = {.image = CLAST_NONE};
    if (sky.value != NULL) {
        read_sky(reader, &sky, &environment);
    } else if (image.value != NULL) {
        read_environment_image(reader, object, &image, &environment);
    } else {
        environment.type = CLAST_ENVIRONMENT_CONSTANT;
        clast_json_vector(json, &colour, environment.colour, 3);
    }
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_set_environment(reader->scene, &environment));
    }
}

// ------------------------------------------------------------------------------------------------- cameras and lights

static void read_camera(scene_reader *reader, const clast_json_place *object)
{
    static const clast_json_choice projections[] = {CLAST_PROJECTION_LIST(CLAST_JSON_CHOICE)};
    clast_json *json = &reader->json;
    if (!clast_json_object(json, object,
                           "name projection position target up vertical_angle height near_plane far_plane aperture "
                           "focus")) {
        return;
    }
    clast_camera_desc camera = {0};
    const char *name = NULL;
    uint32_t projection = CLAST_PROJECTION_PERSPECTIVE;
    clast_json_place place = clast_json_member(object, "name");
    clast_json_text(json, &place, &name);
    place = clast_json_member(object, "projection");
    clast_json_choose(json, &place, projections, COUNT(projections), &projection);
    camera.projection = (clast_projection)projection;
    place = clast_json_member(object, "position");
    clast_json_require(json, &place);
    clast_json_vector(json, &place, camera.position, 3);
    place = clast_json_member(object, "target");
    clast_json_require(json, &place);
    clast_json_vector(json, &place, camera.target, 3);
    place = clast_json_member(object, "up");
    clast_json_vector(json, &place, camera.up, 3);
    place = clast_json_member(object, "vertical_angle");
    if (clast_json_float(json, &place, 1e-3, 179.99, &camera.vertical_angle)) {
        camera.vertical_angle *= degree;
    }
    place = clast_json_member(object, "height");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &camera.height);
    place = clast_json_member(object, "near_plane");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &camera.near_plane);
    place = clast_json_member(object, "far_plane");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &camera.far_plane);
    place = clast_json_member(object, "aperture");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &camera.aperture);
    place = clast_json_member(object, "focus");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &camera.focus);
    uint32_t number;
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_add_camera(reader->scene, &camera, name, &number));
    }
}

static void read_light(scene_reader *reader, const clast_json_place *object)
{
    static const clast_json_choice types[] = {CLAST_LIGHT_LIST(CLAST_JSON_CHOICE)};
    clast_json *json = &reader->json;
    if (!clast_json_object(json, object,
                           "type name position direction colour intensity range inner_angle outer_angle")) {
        return;
    }
    clast_light_desc light = {.colour = {1.0f, 1.0f, 1.0f}, .intensity = 1.0f, .outer_angle = 45.0f};
    const char *name = NULL;
    uint32_t type = 0;
    clast_json_place place = clast_json_member(object, "type");
    clast_json_require(json, &place);
    clast_json_choose(json, &place, types, COUNT(types), &type);
    light.type = (clast_light_type)type;
    place = clast_json_member(object, "name");
    clast_json_text(json, &place, &name);
    place = clast_json_member(object, "position");
    if (light.type != CLAST_LIGHT_DIRECTIONAL) {
        clast_json_require(json, &place);
    }
    clast_json_vector(json, &place, light.position, 3);
    place = clast_json_member(object, "direction");
    if (light.type != CLAST_LIGHT_POINT) {
        clast_json_require(json, &place);
    }
    clast_json_vector(json, &place, light.direction, 3);
    place = clast_json_member(object, "colour");
    clast_json_vector(json, &place, light.colour, 3);
    place = clast_json_member(object, "intensity");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &light.intensity);
    place = clast_json_member(object, "range");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &light.range);
    place = clast_json_member(object, "inner_angle");
    clast_json_float(json, &place, 0.0, 90.0, &light.inner_angle);
    place = clast_json_member(object, "outer_angle");
    clast_json_float(json, &place, 0.0, 90.0, &light.outer_angle);
    light.inner_angle *= degree;
    light.outer_angle *= degree;
    uint32_t number;
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_add_light(reader->scene, &light, name, &number));
    }
}

// -------------------------------------------------------------------------------------------------------------- waves

static uint32_t read_material(scene_reader *reader, const clast_json_place *object)
{
    clast_json *json = &reader->json;
    if (!clast_json_object(json, object, "base_colour metallic roughness emissive double_sided")) {
        return CLAST_NONE;
    }
    clast_material_desc material = clast_material_defaults();
    material.double_sided = true;
    clast_json_place place = clast_json_member(object, "base_colour");
    clast_json_vector(json, &place, material.base_colour, json_array_size(place.value) == 4 ? 4 : 3);
    material.alpha_mode = material.base_colour[3] < 1.0f ? CLAST_ALPHA_BLEND : CLAST_ALPHA_OPAQUE;
    place = clast_json_member(object, "metallic");
    clast_json_float(json, &place, 0.0, 1.0, &material.metallic);
    place = clast_json_member(object, "roughness");
    clast_json_float(json, &place, 0.0, 1.0, &material.roughness);
    place = clast_json_member(object, "emissive");
    clast_json_vector(json, &place, material.emissive, 3);
    place = clast_json_member(object, "double_sided");
    clast_json_bool(json, &place, &material.double_sided);
    uint32_t number = CLAST_NONE;
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_add_material(reader->scene, &material, NULL, &number));
    }
    return number;
}

static void read_wave(scene_reader *reader, const clast_json_place *object)
{
    clast_json *json = &reader->json;
    if (!clast_json_object(json, object,
                           "name size tiles amplitude wavelength speed material translation rotation scale")) {
        return;
    }
    clast_wave wave = {.tiles = 8, .speed = 1.0f};
    const char *name = NULL;
    clast_transform transform = read_transform(reader, object);
    clast_json_place place = clast_json_member(object, "name");
    clast_json_text(json, &place, &name);
    place = clast_json_member(object, "size");
    clast_json_require(json, &place);
    clast_json_float(json, &place, 0.0, HUGE_VAL, &wave.size);
    wave.amplitude = wave.size / 50.0f;
    wave.wavelength = wave.size / 5.0f;
    place = clast_json_member(object, "tiles");
    clast_json_uint(json, &place, 1, 1024, &wave.tiles);
    place = clast_json_member(object, "amplitude");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &wave.amplitude);
    place = clast_json_member(object, "wavelength");
    clast_json_float(json, &place, 0.0, HUGE_VAL, &wave.wavelength);
    place = clast_json_member(object, "speed");
    clast_json_float(json, &place, -HUGE_VAL, HUGE_VAL, &wave.speed);
    place = clast_json_member(object, "material");
    wave.material = read_material(reader, &place);
    float rows[12];
    memcpy(rows, &transform, sizeof rows);
    uint32_t geometry, instance;
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_add_wave(reader->scene, &wave, name, &geometry));
    }
    if (json->status == CLAST_OK) {
        clast_json_check(json, object, clast_scene_add_instance(reader->scene, geometry, rows, name, &instance));
    }
}

// ----------------------------------------------------------------------------------------------------------- settings

// The environment's setting may name a file: "sky" and colours (1,1,1) are none.
static bool names_a_file(const char *text)
{
    return text[0] != '\0' && strcmp(text, "sky") != 0 && strspn(text, "0123456789.,+-eE ") != strlen(text);
}

static void read_text_setting(scene_reader *reader, const clast_json_place *settings, const char *name, char **block,
                              const char **text)
{
    clast_json *json = &reader->json;
    clast_json_place place = clast_json_member(settings, name);
    const char *given = NULL;
    if (!clast_json_text(json, &place, &given)) {
        return;
    }
    bool is_file = (strcmp(name, "patterns") == 0 && given[0] != '\0') ||
                   (strcmp(name, "env") == 0 && names_a_file(given));
    char *copy = is_file ? clast_path_beside(json->context, json->path, given) : clast_copy_text(json->context, given);
    if (copy == NULL) {
        json->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    clast_free(json->context, *block);
    *block = copy;
    *text = copy;
}

// A setting of a real number.
typedef struct setting_range {
    size_t offset;
    bool has_default; // other than zero
    double minimum, maximum;
} setting_range;

// {"keys": [[time, value], ...]}: a setting that changes with time.
static void read_keys(scene_reader *reader, const clast_json_place *object, setting_range range)
{
    clast_json *json = &reader->json;
    clast_motion *motion = &reader->scene->motion;
    clast_json_place array = clast_json_member(object, "keys");
    if (!clast_json_object(json, object, "keys") || !clast_json_require(json, &array)) {
        return;
    }
    size_t count = clast_json_array(json, &array);
    if (json->status == CLAST_OK && count == 0) {
        clast_json_fail(json, &array, CLAST_ERROR_MALFORMED, "expected a key at least: a time and a value");
    }
    double *keys = json->status == CLAST_OK ? clast_allocate(json->context, count, 2 * sizeof *keys) : NULL;
    for (size_t i = 0; i < count && keys != NULL && json->status == CLAST_OK; i++) {
        clast_json_place key = clast_json_element(&array, i);
        clast_json_place time = clast_json_element(&key, 0), value = clast_json_element(&key, 1);
        if (clast_json_array(json, &key) != 2) {
            clast_json_fail(json, &key, CLAST_ERROR_MALFORMED, "expected a time and a value");
        }
        clast_json_real(json, &time, -1e9, 1e9, &keys[2 * i]);
        clast_json_real(json, &value, range.minimum, range.maximum, &keys[2 * i + 1]);
        if (json->status == CLAST_OK && i > 0 && keys[2 * i] <= keys[2 * i - 2]) {
            clast_json_fail(json, &key, CLAST_ERROR_MALFORMED, "expected a time after the one before");
        }
    }
    if (keys == NULL || json->status != CLAST_OK) {
        json->status = json->status == CLAST_OK ? CLAST_ERROR_OUT_OF_MEMORY : json->status;
        clast_free(json->context, keys);
        return;
    }
    clast_json_check(json, object, clast_scene_keep_block(reader->scene, keys));
    if (json->status == CLAST_OK) {
        clast_json_check(
            json, object,
            CLAST_RESERVE(json->context, motion->settings, motion->setting_capacity, motion->setting_count + 1));
    }
    if (json->status == CLAST_OK) {
        motion->settings[motion->setting_count++] = (clast_setting_keys){
            .offset = range.offset, .has_default = range.has_default, .keys = keys, .key_count = count};
    }
}

static void read_real_setting(scene_reader *reader, const clast_json_place *settings, const char *name,
                              setting_range range, double *value)
{
    clast_json_place place = clast_json_member(settings, name);
    if (json_is_object(place.value) && range.offset != offsetof(clast_render_settings, time)) {
        read_keys(reader, &place, range);
    } else if (clast_json_real(&reader->json, &place, range.minimum, range.maximum, value) && *value == 0.0) {
        *value = range.has_default ? CLAST_ZERO : 0.0;
    }
}

#define NAME(name, ...) #name " "
#define READ_UINT(name, initial, minimum, maximum, ...) \
    place = clast_json_member(object, #name); \
    clast_json_uint(json, &place, minimum, maximum, &settings->name);
#define READ_REAL(name, initial, minimum, maximum, ...) \
    read_real_setting(reader, object, #name, \
                      (setting_range){offsetof(clast_render_settings, name), (initial) != 0.0, minimum, maximum}, \
                      &settings->name);
#define READ_CHOICE(name, list, ...) \
    { \
        static const clast_json_choice choices[] = {list(CLAST_JSON_CHOICE)}; \
        place = clast_json_member(object, #name); \
        clast_json_choose(json, &place, choices, COUNT(choices), &settings->name); \
    }
#define READ_TEXT(name, ...) \
    read_text_setting(reader, object, #name, &reader->scene->settings_texts[texts++], &settings->name);

static void read_settings(scene_reader *reader, const clast_json_place *object)
{
    clast_json *json = &reader->json;
    clast_render_settings *settings = &reader->scene->settings;
    clast_json_place place;
    size_t texts = 0;
    if (!clast_json_object(json, object, CLAST_RENDER_SETTING_LIST(NAME, NAME, NAME, NAME))) {
        return;
    }
    CLAST_RENDER_SETTING_LIST(READ_UINT, READ_REAL, READ_CHOICE, READ_TEXT)
}

// ----------------------------------------------------------------------------------------------------------- the file

static void read_each(scene_reader *reader, const clast_json_place *root, const char *key,
                      void (*read)(scene_reader *reader, const clast_json_place *element))
{
    clast_json_place array = clast_json_member(root, key);
    size_t count = clast_json_array(&reader->json, &array);
    for (size_t i = 0; i < count && reader->json.status == CLAST_OK; i++) {
        clast_json_place element = clast_json_element(&array, i);
        read(reader, &element);
    }
}

static void read_root(scene_reader *reader, json_t *value)
{
    clast_json *json = &reader->json;
    clast_json_place root = {.value = value};
    if (!clast_json_object(json, &root, "clast models environment cameras lights waves settings")) {
        return;
    }
    clast_json_place version = clast_json_member(&root, "clast");
    if (!json_is_integer(version.value)) {
        clast_json_fail(json, &version, CLAST_ERROR_MALFORMED, "expected the format's version, 1");
    } else if (json_integer_value(version.value) != 1) {
        clast_json_fail(json, &version, CLAST_ERROR_UNSUPPORTED,
                        "version %" JSON_INTEGER_FORMAT ": this clast reads version 1",
                        json_integer_value(version.value));
    }
    clast_json_place environment = clast_json_member(&root, "environment");
    clast_json_place settings = clast_json_member(&root, "settings");
    read_each(reader, &root, "models", read_model);
    if (environment.value != NULL) {
        read_environment(reader, &environment);
    }
    read_each(reader, &root, "cameras", read_camera);
    read_each(reader, &root, "lights", read_light);
    read_each(reader, &root, "waves", read_wave);
    read_settings(reader, &settings);
}

clast_status clast_load_scene_file(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_context *context = scene->context;
    json_t *root;
    clast_status status = clast_json_parse(context, path, (clast_bytes){file->data, file->size}, &root);
    if (status != CLAST_OK) {
        return status;
    }
    scene_reader reader = {.json = {.context = context, .path = path}, .scene = scene};
    read_root(&reader, root);
    json_decref(root);
    return reader.json.status;
}
