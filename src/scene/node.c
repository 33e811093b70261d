// SPDX-License-Identifier: Apache-2.0
// Nodes of a scene, and what hangs from them.
#include <math.h>
#include <string.h>

#include "base/size.h"
#include "scene/scene.h"

void clast_motion_destroy(clast_context *context, clast_motion *motion)
{
    for (size_t i = 0; i < motion->node_count; i++) {
        clast_free(context, motion->nodes[i].name);
    }
    for (size_t i = 0; i < motion->animation_count; i++) {
        clast_free(context, motion->animations[i].channels);
        clast_free(context, motion->animations[i].name);
    }
    for (size_t i = 0; i < motion->skin_count; i++) {
        clast_free(context, motion->skins[i].joints);
        clast_free(context, motion->skins[i].binds);
    }
    for (size_t i = 0; i < motion->block_count; i++) {
        clast_free(context, motion->blocks[i]);
    }
    clast_free(context, motion->nodes);
    clast_free(context, motion->weights);
    clast_free(context, motion->attachments);
    clast_free(context, motion->animations);
    clast_free(context, motion->skins);
    clast_free(context, motion->settings);
    clast_free(context, motion->blocks);
}

clast_status clast_scene_keep_block(clast_scene *scene, void *block)
{
    clast_motion *motion = &scene->motion;
    clast_status status = CLAST_RESERVE(scene->context, motion->blocks, motion->block_capacity,
                                        motion->block_count + 1);
    if (status != CLAST_OK) {
        clast_free(scene->context, block);
        return status;
    }
    motion->blocks[motion->block_count++] = block;
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- nodes

clast_matrix clast_node_at_rest(const clast_scene_node *node)
{
    return node->has_matrix ? node->matrix
                            : clast_matrix_compose(node->parts.translation, node->parts.rotation, node->parts.scale);
}

// False where it leaves single precision.
static bool place_node(const clast_motion *motion, clast_scene_node *node)
{
    clast_transform rounded;
    clast_matrix local = clast_node_at_rest(node);
    node->to_world = node->parent != CLAST_NONE ? clast_matrix_product(&motion->nodes[node->parent].to_world, &local)
                                                : local;
    return clast_matrix_round(&node->to_world, &rounded);
}

clast_status clast_scene_adopt_node(clast_scene *scene, const clast_scene_node *node, const char *name,
                                    uint32_t *number)
{
    clast_context *context = scene->context;
    clast_motion *motion = &scene->motion;
    clast_scene_node added = *node;
    if (motion->node_count >= CLAST_NONE) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "a scene holds at most %u nodes", CLAST_NONE);
    }
    if (!place_node(motion, &added)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "node %zu: the transform to world space is not finite",
                          motion->node_count);
    }
    clast_status status = CLAST_RESERVE(context, motion->nodes, motion->node_capacity, motion->node_count + 1);
    if (status == CLAST_OK && name != NULL && name[0] != '\0') {
        added.name = clast_copy_text(context, name);
        status = added.name != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status == CLAST_OK) {
        *number = (uint32_t)motion->node_count;
        motion->nodes[motion->node_count++] = added;
    }
    return status;
}

static bool all_finite(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (!is_finite1(values[i])) {
            return false;
        }
    }
    return true;
}

static bool all_zero(const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (values[i] != 0.0f) {
            return false;
        }
    }
    return true;
}

static clast_status read_desc(const clast_scene *scene, const clast_node_desc *desc, clast_scene_node *node)
{
    bool sound = all_finite(desc->translation, 3) && all_finite(desc->rotation, 4) && all_finite(desc->scale, 3) &&
                 (desc->matrix == NULL || all_finite(desc->matrix, 12));
    if (!sound) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "node: expected finite numbers");
    }
    bool turns = !all_zero(desc->rotation, 4), scales = !all_zero(desc->scale, 3);
    for (int i = 0; i < 4; i++) {
        node->parts.rotation[i] = turns ? (double)desc->rotation[i] : i < 3 ? 0.0 : 1.0;
    }
    for (int i = 0; i < 3; i++) {
        node->parts.translation[i] = (double)desc->translation[i];
        node->parts.scale[i] = scales ? (double)desc->scale[i] : 1.0;
    }
    node->has_matrix = desc->matrix != NULL;
    for (int i = 0; i < 12 && node->has_matrix; i++) {
        node->matrix.rows[i / 4][i % 4] = (double)desc->matrix[i];
    }
    return CLAST_OK;
}

clast_status clast_scene_add_node(clast_scene *scene, const clast_node_desc *desc, const char *name, uint32_t *number)
{
    if (scene == NULL || desc == NULL || number == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (desc->parent != CLAST_NONE && desc->parent >= scene->motion.node_count) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "node: parent %u: the scene has %zu nodes",
                          desc->parent, scene->motion.node_count);
    }
    clast_scene_node node = {.parent = desc->parent};
    clast_status status = read_desc(scene, desc, &node);
    return status == CLAST_OK ? clast_scene_adopt_node(scene, &node, name, number) : status;
}

static clast_status find_node(const clast_scene *scene, uint32_t number)
{
    return number < scene->motion.node_count
               ? CLAST_OK
               : clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "node %u: the scene has %zu", number,
                            scene->motion.node_count);
}

static bool is_animated(const clast_motion *motion, uint32_t node)
{
    for (size_t i = 0; i < motion->animation_count; i++) {
        const clast_scene_animation *animation = &motion->animations[i];
        for (size_t k = 0; k < animation->channel_count; k++) {
            if (animation->channels[k].node == node && animation->channels[k].animated != CLAST_ANIMATED_WEIGHTS) {
                return true;
            }
        }
    }
    return false;
}

static void put_back(clast_scene *scene, uint32_t from, const clast_scene_node *old)
{
    scene->motion.nodes[from] = *old;
    for (size_t i = from; i < scene->motion.node_count; i++) {
        place_node(&scene->motion, &scene->motion.nodes[i]);
    }
}

// ------------------------------------------------------------------------------------------------------- attachments

static clast_transform place_attached(const clast_scene *scene, const clast_attachment *attachment)
{
    return clast_attachment_to_world(attachment, &scene->motion.nodes[attachment->node].to_world);
}

clast_transform clast_attachment_to_world(const clast_attachment *attachment, const clast_matrix *node)
{
    clast_matrix in_node = clast_matrix_of_transform(&attachment->in_node);
    clast_matrix whole = clast_matrix_product(node, &in_node);
    for (int i = 0; i < 3; i++) {
        whole.rows[i][3] += (double)attachment->offset.v[i];
    }
    clast_transform result;
    clast_matrix_round(&whole, &result);
    return result;
}

clast_status clast_scene_set_node(clast_scene *scene, uint32_t number, const clast_node_desc *desc)
{
    if (scene == NULL || desc == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_motion *motion = &scene->motion;
    clast_status status = find_node(scene, number);
    if (status != CLAST_OK) {
        return status;
    }
    clast_scene_node old = motion->nodes[number];
    status = read_desc(scene, desc, &motion->nodes[number]);
    if (status == CLAST_OK && desc->matrix != NULL && is_animated(motion, number)) {
        status = clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                            "node %u: an animation moves it: expected no matrix", number);
    }
    for (size_t i = number; i < motion->node_count && status == CLAST_OK; i++) {
        if (!place_node(motion, &motion->nodes[i])) {
            status = clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                                "node %zu: the transform to world space is not finite", i);
        }
    }
    if (status != CLAST_OK) {
        put_back(scene, number, &old);
        return status;
    }
    for (size_t i = 0; i < motion->attachment_count; i++) {
        const clast_attachment *attachment = &motion->attachments[i];
        scene->instances[attachment->instance].to_world = place_attached(scene, attachment);
    }
    scene->instance_version++;
    return CLAST_OK;
}

clast_status clast_scene_set_node_weights(clast_scene *scene, uint32_t number, const float *weights, uint32_t count)
{
    if (scene == NULL || (weights == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_motion *motion = &scene->motion;
    clast_status status = find_node(scene, number);
    if (status != CLAST_OK || count == 0) {
        return status;
    }
    clast_scene_node *node = &motion->nodes[number];
    if (!all_finite(weights, count) || (node->weight_count != 0 && node->weight_count != count)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "node %u: expected %u finite weights", number,
                          node->weight_count != 0 ? node->weight_count : count);
    }
    if (node->weight_count == 0) {
        status = CLAST_RESERVE(context, motion->weights, motion->weight_capacity, motion->weight_count + count);
        if (status != CLAST_OK) {
            return status;
        }
        if (motion->weight_count + count > UINT32_MAX) {
            return clast_fail(context, CLAST_ERROR_LIMIT, "a scene holds at most %u weights", UINT32_MAX);
        }
        node->first_weight = (uint32_t)motion->weight_count;
        node->weight_count = count;
        motion->weight_count += count;
    }
    memcpy(motion->weights + node->first_weight, weights, count * sizeof *weights);
    return CLAST_OK;
}

size_t clast_motion_first_attachment(const clast_motion *motion, size_t instance)
{
    size_t low = 0, high = motion->attachment_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (motion->attachments[middle].instance < instance) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

clast_attachment *clast_scene_find_attachment(clast_scene *scene, uint32_t instance)
{
    size_t place = clast_motion_first_attachment(&scene->motion, instance);
    bool is_there = place < scene->motion.attachment_count && scene->motion.attachments[place].instance == instance;
    return is_there ? &scene->motion.attachments[place] : NULL;
}

static clast_status add_attachment(clast_scene *scene, const clast_attachment *added)
{
    clast_motion *motion = &scene->motion;
    clast_attachment *known = clast_scene_find_attachment(scene, added->instance);
    if (known != NULL) {
        *known = *added;
        return CLAST_OK;
    }
    clast_status status = CLAST_RESERVE(scene->context, motion->attachments, motion->attachment_capacity,
                                        motion->attachment_count + 1);
    if (status == CLAST_OK) {
        size_t place = clast_motion_first_attachment(motion, added->instance);
        memmove(motion->attachments + place + 1, motion->attachments + place,
                (motion->attachment_count - place) * sizeof *added);
        motion->attachments[place] = *added;
        motion->attachment_count++;
    }
    return status;
}

clast_status clast_scene_attach_instance(clast_scene *scene, uint32_t instance, uint32_t node)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (instance >= scene->instance_count || scene->instances[instance].removed) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "instance %u is not in the scene", instance);
    }
    clast_status status = find_node(scene, node);
    const clast_attachment *known = clast_scene_find_attachment(scene, instance);
    clast_attachment added = {.instance = instance,
                              .node = node,
                              .in_node = known != NULL ? known->in_node : scene->instances[instance].to_world};
    if (status == CLAST_OK) {
        status = add_attachment(scene, &added);
    }
    if (status == CLAST_OK) {
        scene->instances[instance].to_world = place_attached(scene, &added);
        scene->instance_version++;
    }
    return status;
}

clast_status clast_scene_attach_light(clast_scene *scene, uint32_t light, uint32_t node)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (light >= scene->light_count) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "light %u: the scene has %zu", light,
                          scene->light_count);
    }
    clast_status status = find_node(scene, node);
    if (status == CLAST_OK) {
        scene->lights[light].node = node;
        scene->lights[light].record = clast_light_at(&scene->lights[light].record, &scene->motion.nodes[node].to_world);
        scene->light_version++;
    }
    return status;
}

clast_status clast_scene_attach_camera(clast_scene *scene, uint32_t camera, uint32_t node)
{
    if (scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (camera >= scene->camera_count) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "camera %u: the scene has %zu", camera,
                          scene->camera_count);
    }
    clast_status status = find_node(scene, node);
    if (status == CLAST_OK) {
        scene->cameras[camera].node = node;
        scene->cameras[camera].desc = clast_camera_at(&scene->cameras[camera].desc,
                                                      &scene->motion.nodes[node].to_world);
    }
    return status;
}

clast_status clast_scene_copy_instance(clast_scene *scene, size_t from, float x, float z)
{
    clast_instance instance = scene->instances[from];
    const clast_attachment *known = clast_scene_find_attachment(scene, (uint32_t)from);
    if (known != NULL) {
        clast_attachment copy = *known;
        copy.instance = (uint32_t)scene->instance_count;
        copy.offset.v[0] += x;
        copy.offset.v[2] += z;
        clast_status status = add_attachment(scene, &copy);
        if (status != CLAST_OK) {
            return status;
        }
    }
    instance.name = NULL;
    instance.to_world.rows[0].v[3] += x;
    instance.to_world.rows[2].v[3] += z;
    scene->instances[scene->instance_count++] = instance;
    return CLAST_OK;
}

void clast_scene_drop_instances(clast_scene *scene, size_t first)
{
    scene->instance_count = first;
    scene->motion.attachment_count = clast_motion_first_attachment(&scene->motion, (uint32_t)first);
}

// --------------------------------------------------------------------------------------------- lights and cameras

// A column of a transform, without its scale; zero where there is no length.
static void direction(const clast_matrix *to_world, int column, double sign, float out[3])
{
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        length += to_world->rows[i][column] * to_world->rows[i][column];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++) {
        out[i] = length > 0.0 && isfinite(length) ? (float)(sign * to_world->rows[i][column] / length) : 0.0f;
    }
}

clast_camera_desc clast_camera_at(const clast_camera_desc *desc, const clast_matrix *to_world)
{
    clast_camera_desc camera = *desc;
    float forward[3], reach = 1.0f; // far enough that position and target differ as floats
    direction(to_world, 2, -1.0, forward);
    direction(to_world, 1, 1.0, camera.up);
    if (forward[0] == 0.0f && forward[1] == 0.0f && forward[2] == 0.0f) {
        forward[2] = -1.0f;
    }
    for (int i = 0; i < 3; i++) {
        camera.position[i] = (float)to_world->rows[i][3];
        reach = max1(reach, abs1(camera.position[i]));
    }
    for (int i = 0; i < 3; i++) {
        camera.target[i] = (float)(to_world->rows[i][3] + (double)forward[i] * (double)reach);
    }
    return camera;
}

clast_light clast_light_at(const clast_light *light, const clast_matrix *to_world)
{
    clast_light placed = *light;
    direction(to_world, 2, -1.0, placed.direction.v);
    if (placed.direction.v[0] == 0.0f && placed.direction.v[1] == 0.0f && placed.direction.v[2] == 0.0f) {
        placed.direction.v[2] = -1.0f;
    }
    for (int i = 0; i < 3; i++) {
        placed.position.v[i] = (float)to_world->rows[i][3];
    }
    return placed;
}
