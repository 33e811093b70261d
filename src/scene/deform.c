// SPDX-License-Identifier: Apache-2.0
// Meshes whose vertices move: morph targets (glTF 2.0, section 3.7.2.2) and skins (section 3.7.3).
#include <math.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "scene/scene.h"

enum { JOINTS_MOST = 65536 };

// ----------------------------------------------------------------------------------------------------------- editing

// The mesh of that number; null, with its error, where there is none.
static clast_geometry *find_mesh(clast_scene *scene, uint32_t number)
{
    if (number >= scene->geometry_count || !clast_geometry_is_mesh(&scene->geometries[number])) {
        clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "geometry %u is no mesh of the scene", number);
        return NULL;
    }
    return &scene->geometries[number];
}

clast_status clast_scene_share_mesh(clast_scene *scene, uint32_t number, const char *name, uint32_t *shared)
{
    if (scene == NULL || shared == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_motion *motion = &scene->motion;
    clast_geometry *geometry = find_mesh(scene, number);
    if (geometry == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = CLAST_RESERVE(context, motion->blocks, motion->block_capacity,
                                        motion->block_count + geometry->block_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, scene->geometries, scene->geometry_capacity, scene->geometry_count + 1);
    }
    if (status != CLAST_OK) {
        return status;
    }
    geometry = &scene->geometries[number];
    clast_geometry added = *geometry;
    added.name = name != NULL && name[0] != '\0' ? clast_copy_text(context, name) : NULL;
    if (added.name == NULL && name != NULL && name[0] != '\0') {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    // From now on the scene frees what both point to.
    while (geometry->block_count > 0) {
        motion->blocks[motion->block_count++] = geometry->blocks[--geometry->block_count];
    }
    added.block_count = 0;
    added.deformation = (clast_deformation){0};
    added.version = 1;
    *shared = (uint32_t)scene->geometry_count;
    scene->geometries[scene->geometry_count++] = added;
    return CLAST_OK;
}

static void deform(clast_geometry *geometry, const clast_deformation *deformation)
{
    geometry->deformation = *deformation;
    geometry->version++;
}

clast_status clast_scene_adopt_morph(clast_scene *scene, uint32_t number, const clast_morph_target *targets,
                                     uint32_t count, uint32_t node)
{
    clast_geometry *geometry = find_mesh(scene, number);
    if (geometry == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count != 0 && (node >= scene->motion.node_count || scene->motion.nodes[node].weight_count != count)) {
        return clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%u morph targets: expected a node with as many weights", count);
    }
    clast_deformation changed = geometry->deformation;
    changed.target_count = count;
    changed.targets = targets;
    changed.weights_node = node;
    deform(geometry, &changed);
    return CLAST_OK;
}

static const float *copy_vectors(float **next, const float *vectors, size_t count)
{
    if (vectors == NULL) {
        return NULL;
    }
    const float *copy = memcpy(*next, vectors, count * sizeof *vectors);
    *next += count;
    return copy;
}

clast_status clast_scene_set_mesh_morph(clast_scene *scene, uint32_t number, const clast_morph_target *targets,
                                        uint32_t count, uint32_t node)
{
    if (scene == NULL || (targets == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_geometry *geometry = find_mesh(scene, number);
    if (geometry == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    size_t width = 3 * (size_t)geometry->of.mesh.vertex_count, arrays = 0, floats = 0;
    for (uint32_t i = 0; i < count; i++) {
        arrays += targets[i].positions != NULL;
        arrays += targets[i].normals != NULL;
        arrays += targets[i].tangents != NULL;
    }
    if (!clast_multiply_size(arrays, width, &floats)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%u morph targets of %zu numbers", count, width);
    }
    float *block = clast_allocate(context, floats, sizeof *block), *next = block;
    clast_morph_target *copies = block != NULL ? clast_allocate(context, count, sizeof *copies) : NULL;
    if (copies == NULL) {
        clast_free(context, block);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < count; i++) {
        copies[i].positions = copy_vectors(&next, targets[i].positions, width);
        copies[i].normals = copy_vectors(&next, targets[i].normals, width);
        copies[i].tangents = copy_vectors(&next, targets[i].tangents, width);
    }
    clast_status status = clast_scene_keep_block(scene, block);
    if (status != CLAST_OK) {
        clast_free(context, copies);
        return status;
    }
    status = clast_scene_keep_block(scene, copies);
    return status == CLAST_OK ? clast_scene_adopt_morph(scene, number, copies, count, node) : status;
}

clast_status clast_scene_add_skin(clast_scene *scene, const clast_skin_desc *desc, uint32_t *number)
{
    if (scene == NULL || desc == NULL || number == NULL || desc->joints == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_motion *motion = &scene->motion;
    if (desc->joint_count == 0 || desc->joint_count > JOINTS_MOST) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "skin: %u joints: expected 1 to %d", desc->joint_count,
                          JOINTS_MOST);
    }
    clast_skin added = {.joint_count = desc->joint_count};
    clast_status status = CLAST_RESERVE(context, motion->skins, motion->skin_capacity, motion->skin_count + 1);
    if (status == CLAST_OK) {
        added.joints = clast_allocate(context, desc->joint_count, sizeof *added.joints);
        added.binds = clast_allocate(context, desc->joint_count, sizeof *added.binds);
        status = added.joints != NULL && added.binds != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < desc->joint_count && status == CLAST_OK; i++) {
        added.joints[i] = desc->joints[i];
        added.binds[i] = clast_matrix_identity();
        bool sound = desc->joints[i] < motion->node_count;
        for (size_t k = 0; k < 12 && desc->inverse_binds != NULL; k++) {
            float value = desc->inverse_binds[12 * (size_t)i + k];
            sound = sound && is_finite1(value);
            added.binds[i].rows[k / 4][k % 4] = (double)value;
        }
        if (!sound) {
            status = clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                                "skin: joint %u: expected a node of the scene's %zu, and a finite matrix", i,
                                motion->node_count);
        }
    }
    if (status != CLAST_OK) {
        clast_free(context, added.joints);
        clast_free(context, added.binds);
        return status;
    }
    *number = (uint32_t)motion->skin_count;
    motion->skins[motion->skin_count++] = added;
    return CLAST_OK;
}

clast_status clast_scene_adopt_skinning(clast_scene *scene, uint32_t number, uint32_t skin, uint32_t influences,
                                        const uint16_t *joints, const float *weights)
{
    clast_geometry *geometry = find_mesh(scene, number);
    clast_status status = geometry != NULL ? CLAST_OK : CLAST_ERROR_INVALID_ARGUMENT;
    if (status == CLAST_OK && influences != 0 && skin >= scene->motion.skin_count) {
        status = clast_fail(scene->context, CLAST_ERROR_INVALID_ARGUMENT, "skin %u: the scene has %zu", skin,
                            scene->motion.skin_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_deformation changed = geometry->deformation;
    changed.influences = influences;
    changed.skin = skin;
    changed.joints = joints;
    changed.joint_weights = weights;
    deform(geometry, &changed);
    return CLAST_OK;
}

bool clast_weigh_joints(const uint16_t *joints, float *weights, size_t vertex_count, uint32_t influences,
                        uint32_t joint_count, size_t *wrong)
{
    for (size_t vertex = 0; vertex < vertex_count; vertex++) {
        const uint16_t *joint = joints + vertex * influences;
        float *weight = weights + vertex * influences;
        double sum = 0.0;
        for (uint32_t k = 0; k < influences; k++) {
            if (!(weight[k] >= 0.0f) || !is_finite1(weight[k]) || (weight[k] > 0.0f && joint[k] >= joint_count)) {
                *wrong = vertex * influences + k;
                return false;
            }
            sum += (double)weight[k];
        }
        for (uint32_t k = 0; k < influences && sum > 0.0; k++) {
            weight[k] = (float)((double)weight[k] / sum);
        }
    }
    return true;
}

clast_status clast_scene_set_mesh_skin(clast_scene *scene, uint32_t number, uint32_t skin, uint32_t influences,
                                       const uint16_t *joints, const float *weights)
{
    if (scene == NULL || (influences != 0 && (joints == NULL || weights == NULL))) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_context *context = scene->context;
    clast_geometry *geometry = find_mesh(scene, number);
    clast_status status = geometry != NULL ? CLAST_OK : CLAST_ERROR_INVALID_ARGUMENT;
    if (status == CLAST_OK && influences != 0 && skin >= scene->motion.skin_count) {
        status = clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "skin %u: the scene has %zu", skin,
                            scene->motion.skin_count);
    }
    size_t count, wrong = 0, vertices = status == CLAST_OK ? geometry->of.mesh.vertex_count : 0;
    if (status == CLAST_OK && !clast_multiply_size(vertices, influences, &count)) {
        status = clast_fail(context, CLAST_ERROR_LIMIT, "%u joints for each of %zu vertices", influences, vertices);
    }
    if (status != CLAST_OK || influences == 0) {
        return status == CLAST_OK ? clast_scene_adopt_skinning(scene, number, 0, 0, NULL, NULL) : status;
    }
    float *block = clast_allocate(context, count, sizeof *weights + sizeof *joints);
    if (block == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint16_t *joint_copies = (uint16_t *)(block + count);
    memcpy(block, weights, count * sizeof *weights);
    memcpy(joint_copies, joints, count * sizeof *joints);
    if (!clast_weigh_joints(joint_copies, block, vertices, influences, scene->motion.skins[skin].joint_count, &wrong)) {
        status = clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                            "vertex %zu: joint %u of weight %g: expected one of the skin's %u, and 0 or more",
                            wrong / influences, joints[wrong], (double)weights[wrong],
                            scene->motion.skins[skin].joint_count);
        clast_free(context, block);
        return status;
    }
    status = clast_scene_keep_block(scene, block);
    return status == CLAST_OK ? clast_scene_adopt_skinning(scene, number, skin, influences, joint_copies, block)
                              : status;
}

// ----------------------------------------------------------------------------------------------------------- posing

bool clast_scene_pose_joints(const clast_scene *scene, uint32_t number, const clast_posed_node *nodes,
                             clast_transform *joints)
{
    const clast_skin *skin = &scene->motion.skins[number];
    bool is_finite = true;
    for (uint32_t i = 0; i < skin->joint_count; i++) {
        uint32_t node = skin->joints[i];
        const clast_matrix *to_world = nodes != NULL ? &nodes[node].to_world : &scene->motion.nodes[node].to_world;
        clast_matrix moved = clast_matrix_product(to_world, &skin->binds[i]);
        is_finite = clast_matrix_round(&moved, &joints[i]) && is_finite;
    }
    return is_finite;
}

// Unit length; what has no direction stays. Null does nothing.
static void make_unit(float *vector)
{
    if (vector == NULL) {
        return;
    }
    float largest = max1(max1(abs1(vector[0]), abs1(vector[1])), abs1(vector[2]));
    if (!(largest > 0.0f) || !is_finite1(largest)) {
        return;
    }
    // Scaled first: the squares of very small and very large vectors are no numbers.
    float down = largest > 1e-15f && largest < 1e15f ? 1.0f : 1.0f / largest;
    float x = vector[0] * down, y = vector[1] * down, z = vector[2] * down;
    float scale = 1.0f / sqrtf(x * x + y * y + z * z);
    vector[0] = x * scale;
    vector[1] = y * scale;
    vector[2] = z * scale;
}

static void move_direction(const float rows[3][3], float *vector)
{
    float moved[3];
    for (int i = 0; i < 3; i++) {
        moved[i] = rows[i][0] * vector[0] + rows[i][1] * vector[1] + rows[i][2] * vector[2];
    }
    memcpy(vector, moved, sizeof moved);
    make_unit(vector);
}

// Inverse transpose times determinant, which normals go by; of the matrix scaled so that nothing vanishes.
static void find_cofactors(const float m[3][3], float cofactors[3][3])
{
    float largest = 0.0f;
    for (int i = 0; i < 9; i++) {
        largest = max1(largest, abs1(m[i / 3][i % 3]));
    }
    float down = largest > 1e-15f && largest < 1e15f ? 1.0f : largest > 0.0f ? 1.0f / largest : 1.0f;
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        for (int j = 0; j < 3; j++) {
            int c = (j + 1) % 3, d = (j + 2) % 3;
            cofactors[i][j] = m[a][c] * down * (m[b][d] * down) - m[a][d] * down * (m[b][c] * down);
        }
    }
}

static void skin_vertex(const clast_deform_job *job, size_t vertex, float *position, float *normal, float *tangent)
{
    const clast_deformation *deformation = &job->geometry->deformation;
    size_t first = vertex * deformation->influences;
    float m[3][4] = {{0.0f}}, turn[3][3], cofactors[3][3], sum = 0.0f;
    for (size_t k = first; k < first + deformation->influences; k++) {
        float weight = deformation->joint_weights[k];
        if (weight != 0.0f) {
            const clast_transform *joint = &job->joints[deformation->joints[k]];
            for (int i = 0; i < 12; i++) {
                m[i / 4][i % 4] += weight * joint->rows[i / 4].v[i % 4];
            }
            sum += weight;
        }
    }
    if (sum == 0.0f) { // a vertex without weights stays
        return;
    }
    float x = position[0], y = position[1], z = position[2];
    for (int i = 0; i < 3; i++) {
        position[i] = m[i][0] * x + m[i][1] * y + m[i][2] * z + m[i][3];
        memcpy(turn[i], m[i], sizeof turn[i]);
    }
    if (normal != NULL) {
        find_cofactors((const float(*)[3])turn, cofactors);
        move_direction((const float(*)[3])cofactors, normal);
    }
    if (tangent != NULL) {
        move_direction((const float(*)[3])turn, tangent);
    }
}

static void begin_at_rest(const clast_deform_job *job, size_t begin, size_t end)
{
    const clast_mesh *mesh = &job->geometry->of.mesh;
    size_t at = begin - job->first, count = end - begin;
    memcpy(job->positions + at, mesh->positions + 3 * begin, count * sizeof *job->positions);
    if (job->normals != NULL) {
        memcpy(job->normals + at, mesh->normals + 3 * begin, count * sizeof *job->normals);
    }
    if (job->tangents != NULL) {
        memcpy(job->tangents + at, mesh->tangents + 4 * begin, count * sizeof *job->tangents);
    }
}

// Adds a target's displacements, times its weight, to `width` floats a vertex of which three are moved.
static void add_moves(const float *moves, float weight, size_t begin, size_t end, size_t width, float *vectors)
{
    for (size_t i = begin; i < end && moves != NULL && vectors != NULL; i++, vectors += width) {
        for (size_t k = 0; k < 3; k++) {
            vectors[k] += weight * moves[3 * i + k];
        }
    }
}

static void add_targets(const clast_deform_job *job, size_t begin, size_t end)
{
    const clast_deformation *deformation = &job->geometry->deformation;
    size_t at = begin - job->first;
    for (uint32_t i = 0; i < deformation->target_count; i++) {
        const clast_morph_target *target = &deformation->targets[i];
        float weight = job->weights[i];
        if (weight != 0.0f) {
            add_moves(target->positions, weight, begin, end, 3, job->positions[at].v);
            add_moves(target->normals, weight, begin, end, 3, job->normals != NULL ? job->normals[at].v : NULL);
            add_moves(target->tangents, weight, begin, end, 4, job->tangents != NULL ? job->tangents[at].v : NULL);
        }
    }
}

bool clast_deform(const clast_deform_job *job, size_t begin, size_t end)
{
    uint32_t wrong = 0;
    begin_at_rest(job, begin, end);
    add_targets(job, begin, end);
    for (size_t i = begin; i < end; i++) {
        float *position = job->positions[i - job->first].v;
        float *normal = job->normals != NULL ? job->normals[i - job->first].v : NULL;
        float *tangent = job->tangents != NULL ? job->tangents[i - job->first].v : NULL;
        if (job->geometry->deformation.influences != 0) {
            skin_vertex(job, i, position, normal, tangent);
        } else {
            make_unit(normal);
            make_unit(tangent);
        }
        for (int k = 0; k < 3; k++) {
            wrong |= !is_finite1(position[k]) || (normal != NULL && !is_finite1(normal[k])) ||
                     (tangent != NULL && !is_finite1(tangent[k]));
        }
    }
    return wrong == 0;
}

// ------------------------------------------------------------------------------------------------------------ bounds

// Where memory runs out, what moves is taken to be where its arrays have it.
clast_box clast_deformed_box(const clast_scene *scene, const clast_geometry *geometry)
{
    enum { PART = 256 };
    const clast_motion *motion = &scene->motion;
    const clast_deformation *deformation = &geometry->deformation;
    size_t count = geometry->of.mesh.vertex_count;
    packed3 positions[PART];
    clast_transform *joints = NULL;
    clast_deform_job job = {.geometry = geometry, .positions = positions};
    if (deformation->influences != 0) {
        joints = clast_allocate(scene->context, motion->skins[deformation->skin].joint_count, sizeof *joints);
        if (joints != NULL) {
            clast_scene_pose_joints(scene, deformation->skin, NULL, joints);
        }
    }
    if (deformation->target_count != 0) {
        job.weights = motion->weights + motion->nodes[deformation->weights_node].first_weight;
    }
    job.joints = joints;
    clast_box box = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    for (; job.first < count; job.first += PART) {
        size_t end = count - job.first < PART ? count : job.first + PART;
        if (deformation->influences != 0 && joints == NULL) {
            begin_at_rest(&job, job.first, end);
        } else {
            clast_deform(&job, job.first, end);
        }
        for (size_t i = 0; i < end - job.first; i++) {
            box.lower = store3(min3(load3(box.lower), load3(positions[i])));
            box.upper = store3(max3(load3(box.upper), load3(positions[i])));
        }
    }
    clast_free(scene->context, joints);
    return box;
}
