// SPDX-License-Identifier: Apache-2.0
// Instances of a scene, and the scene's bounds.
#include <math.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "scene/scene.h"

static bool transform_is_finite(const float t[12])
{
    for (int i = 0; i < 12; i++) {
        if (!is_finite1(t[i])) {
            return false;
        }
    }
    return true;
}

static clast_transform transform_record(const float t[12])
{
    return transform_rows(vec4(t[0], t[1], t[2], t[3]), vec4(t[4], t[5], t[6], t[7]), vec4(t[8], t[9], t[10], t[11]));
}

clast_status clast_scene_add_instance(clast_scene *scene, uint32_t geometry, const float transform[12],
                                      const char *name, uint32_t *number)
{
    if (scene == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    if (geometry >= scene->geometry_count || (transform != NULL && !transform_is_finite(transform))) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "instance: expected a geometry below %zu and a finite transform", scene->geometry_count);
    }
    if (scene->instance_count >= CLAST_NONE) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "a scene holds at most %u instances", CLAST_NONE);
    }
    clast_status status = CLAST_RESERVE(context, scene->instances, scene->instance_capacity, scene->instance_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    clast_instance added = {
        .geometry = geometry,
        .to_world = transform != NULL ? transform_record(transform) : transform_identity(),
        .visible = true,
    };
    if (name != NULL && name[0] != '\0') {
        added.name = clast_copy_text(context, name);
        if (added.name == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    *number = (uint32_t)scene->instance_count;
    scene->instances[scene->instance_count++] = added;
    scene->instance_version++;
    return CLAST_OK;
}

// The instance of a number that a caller gives; null, with its error, where there is none.
static clast_instance *find_instance(clast_scene *scene, uint32_t number)
{
    if (number >= scene->instance_count || scene->instances[number].removed) {
        clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "instance %u is not in the scene", number);
        return NULL;
    }
    scene->instance_version++;
    return &scene->instances[number];
}

clast_status clast_scene_set_instance_transform(clast_scene *scene, uint32_t number, const float transform[12])
{
    if (scene == NULL || transform == NULL || !transform_is_finite(transform)) {
        return scene == NULL ? CLAST_ERROR_INVALID_ARGUMENT
                             : clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                                          "instance %u: expected a finite transform", number);
    }
    clast_instance *instance = find_instance(scene, number);
    if (instance == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    instance->to_world = transform_record(transform);
    clast_attachment *attachment = clast_scene_find_attachment(scene, number);
    if (attachment != NULL) {
        attachment->in_node = instance->to_world;
        instance->to_world = clast_attachment_to_world(attachment, &scene->motion.nodes[attachment->node].to_world);
    }
    return CLAST_OK;
}

clast_status clast_scene_set_instance_visible(clast_scene *scene, uint32_t number, bool visible)
{
    clast_instance *instance = scene != NULL ? find_instance(scene, number) : NULL;
    if (instance == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    instance->visible = visible;
    return CLAST_OK;
}

clast_status clast_scene_remove_instance(clast_scene *scene, uint32_t number)
{
    clast_instance *instance = scene != NULL ? find_instance(scene, number) : NULL;
    if (instance == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    instance->removed = true;
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------------- bounds

static clast_box empty_box(void)
{
    return (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
}

static void extend_box(clast_box *box, vec3 point)
{
    box->lower = store3(min3(load3(box->lower), point));
    box->upper = store3(max3(load3(box->upper), point));
}

static clast_box geometry_box(const clast_scene *scene, const clast_geometry *geometry)
{
    clast_box box = empty_box();
    if (geometry->kind == CLAST_SOURCE_WAVE) {
        const clast_wave *wave = &geometry->of.wave;
        float half = 0.5f * wave->size, height = abs1(wave->amplitude);
        extend_box(&box, vec3(-half, -height, -half));
        extend_box(&box, vec3(half, height, half));
        return box;
    }
    if (clast_deforms(&geometry->deformation)) {
        return clast_deformed_box(scene, geometry);
    }
    const clast_mesh *mesh = &geometry->of.mesh;
    vec2 heights = geometry->tessellated ? clast_mesh_heights(scene, mesh) : vec2(0.0f, 0.0f);
    bool is_displaced = heights[0] < heights[1];
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        vec3 position = vec3(mesh->positions[3 * i], mesh->positions[3 * i + 1], mesh->positions[3 * i + 2]);
        extend_box(&box, position);
        if (is_displaced && mesh->normals != NULL) {
            vec3 normal = vec3(mesh->normals[3 * i], mesh->normals[3 * i + 1], mesh->normals[3 * i + 2]);
            extend_box(&box, position + normal * heights[0]);
            extend_box(&box, position + normal * heights[1]);
        }
    }
    if (is_displaced && mesh->normals == NULL && mesh->vertex_count != 0) {
        vec3 reach = splat3(max1(-heights[0], heights[1]));
        box = (clast_box){store3(load3(box.lower) - reach), store3(load3(box.upper) + reach)};
    }
    return box;
}

typedef struct box_job {
    const clast_scene *scene;
    clast_box *boxes;
} box_job;

static void find_boxes(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    box_job *job = data;
    for (size_t i = begin; i < end; i++) {
        job->boxes[i] = geometry_box(job->scene, &job->scene->geometries[i]);
    }
}

void clast_scene_bounds(const clast_scene *scene, float lower[3], float upper[3])
{
    clast_box all = empty_box();
    clast_context *context = scene->context;
    clast_box *boxes = clast_allocate(context, scene->geometry_count, sizeof *boxes);
    if (boxes != NULL) {
        box_job job = {scene, boxes};
        clast_parallel_for(context, scene->geometry_count, 1, find_boxes, &job);
    }
    for (size_t i = 0; i < scene->instance_count; i++) {
        const clast_instance *instance = &scene->instances[i];
        if (instance->removed || !instance->visible) {
            continue;
        }
        // Without memory for a box each, they are found one by one: slower, and the same.
        clast_box box = boxes != NULL ? boxes[instance->geometry]
                                      : geometry_box(scene, &scene->geometries[instance->geometry]);
        if (!(box.lower.v[0] <= box.upper.v[0])) {
            continue;
        }
        for (int corner = 0; corner < 8; corner++) {
            vec3 point = vec3(corner & 1 ? box.upper.v[0] : box.lower.v[0],
                              corner & 2 ? box.upper.v[1] : box.lower.v[1],
                              corner & 4 ? box.upper.v[2] : box.lower.v[2]);
            extend_box(&all, transform_point(instance->to_world, point));
        }
    }
    clast_free(context, boxes);
    memcpy(lower, all.lower.v, sizeof all.lower.v);
    memcpy(upper, all.upper.v, sizeof all.upper.v);
}

clast_status clast_scene_repeat(clast_scene *scene, uint32_t copies)
{
    if (scene == NULL || copies == 0) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    size_t before = scene->instance_count, wanted;
    if (!clast_multiply_size(before, copies, &wanted) || wanted >= CLAST_NONE) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%u copies of %zu instances: a scene holds at most %u", copies,
                          before, CLAST_NONE);
    }
    float lower[3], upper[3];
    clast_scene_bounds(scene, lower, upper);
    if (copies == 1 || !(lower[0] <= upper[0])) {
        return CLAST_OK;
    }
    clast_status status = CLAST_RESERVE(context, scene->instances, scene->instance_capacity, wanted);
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t side = (uint32_t)ceil(sqrt((double)copies));
    float gap = 1.05f;
    float step_x = (upper[0] - lower[0]) * gap, step_z = (upper[2] - lower[2]) * gap;
    for (uint32_t copy = 1; copy < copies; copy++) {
        float x = step_x * (float)(copy % side), z = -step_z * (float)(copy / side);
        for (size_t i = 0; i < before; i++) {
            status = clast_scene_copy_instance(scene, i, x, z);
            if (status != CLAST_OK) {
                clast_scene_drop_instances(scene, before);
                return status;
            }
        }
    }
    scene->instance_version++;
    return CLAST_OK;
}
