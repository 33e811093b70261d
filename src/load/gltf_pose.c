// SPDX-License-Identifier: Apache-2.0
// What moves a primitive's vertices: morph targets (section 3.7.2.2), and the joints that vertices follow (section 3.7.3).
#include <float.h>
#include <stdio.h>
#include <string.h>

#include "load/gltf.h"

#define FLOAT CLAST_GLTF_BIT(CLAST_GLTF_FLOAT)
#define SIGNED (CLAST_GLTF_BIT(CLAST_GLTF_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_SHORT))
#define UNSIGNED (CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_SHORT))

enum { JOINTS_OF_SET = 4, SETS_MOST = 64 };

float *clast_gltf_read_weights(clast_gltf *gltf, const clast_gltf_value *object, size_t *count)
{
    clast_gltf_value list = clast_gltf_array(gltf, object, "weights");
    *count = clast_gltf_size(&list);
    if (!clast_gltf_ok(gltf) || *count == 0) {
        return NULL;
    }
    float *weights = clast_allocate_zeroed(gltf->context, *count, sizeof *weights);
    if (weights == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    clast_gltf_numbers(gltf, object, "weights", *count, -FLT_MAX, FLT_MAX, weights);
    return weights;
}

size_t clast_gltf_count_targets(clast_gltf *gltf, uint32_t mesh)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_MESHES, mesh);
    clast_gltf_value primitives = clast_gltf_array(gltf, &value, "primitives");
    clast_gltf_value first = clast_gltf_element(&primitives, 0);
    clast_gltf_value targets = clast_gltf_array(gltf, &first, "targets");
    return clast_gltf_size(&targets);
}

// ------------------------------------------------------------------------------------------------------- morph targets

// The displacements of one attribute, kept by the scene; null where there are none, or on failure.
static const float *read_moves(clast_gltf *gltf, const clast_gltf_value *target, const char *name,
                               clast_gltf_window window)
{
    clast_gltf_value place = clast_gltf_member(target, name);
    if (place.json == NULL || !clast_gltf_ok(gltf)) {
        return NULL;
    }
    void *block;
    const float *moves = clast_gltf_read_vertices(gltf, &place, window, FLOAT | SIGNED, 3, &block);
    bool is_kept = block == NULL || clast_gltf_check(gltf, clast_scene_keep_block(gltf->scene, block));
    return is_kept ? moves : NULL;
}

static bool morph(clast_gltf *gltf, const clast_gltf_value *primitive, clast_gltf_window window, uint32_t node,
                  const clast_deformation *known, uint32_t geometry)
{
    clast_scene *scene = gltf->scene;
    clast_gltf_value list = clast_gltf_array(gltf, primitive, "targets");
    size_t count = clast_gltf_size(&list);
    uint32_t wanted = scene->motion.nodes[node].weight_count;
    if (clast_gltf_ok(gltf) && count != wanted) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, primitive, "%zu morph targets: expected %u, as there are weights",
                        count, wanted);
    }
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (known != NULL && known->target_count == wanted) {
        return clast_gltf_check(gltf, clast_scene_adopt_morph(scene, geometry, known->targets, wanted, node));
    }
    clast_morph_target *targets = clast_allocate_zeroed(gltf->context, count, sizeof *targets);
    if (targets == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    for (size_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value target = clast_gltf_element_object(gltf, &list, i);
        targets[i].positions = read_moves(gltf, &target, "POSITION", window);
        targets[i].normals = read_moves(gltf, &target, "NORMAL", window);
        targets[i].tangents = read_moves(gltf, &target, "TANGENT", window);
    }
    if (!clast_gltf_ok(gltf)) {
        clast_free(gltf->context, targets);
        return false;
    }
    return clast_gltf_check(gltf, clast_scene_keep_block(scene, targets)) &&
           clast_gltf_check(gltf, clast_scene_adopt_morph(scene, geometry, targets, wanted, node));
}

// --------------------------------------------------------------------------------------------------------------- skins

// Joints and weights of each vertex, all sets side by side.
typedef struct influence_block {
    float *weights;
    uint16_t *joints; // in the same block
    uint32_t width;
} influence_block;

static clast_gltf_value set_member(const clast_gltf_value *attributes, const char *name, unsigned set, char text[24])
{
    snprintf(text, 24, "%s_%u", name, set);
    return clast_gltf_member(attributes, text);
}

static unsigned count_sets(const clast_gltf_value *attributes)
{
    char joints[24], weights[24];
    unsigned set = 0;
    while (set < SETS_MOST && set_member(attributes, "JOINTS", set, joints).json != NULL &&
           set_member(attributes, "WEIGHTS", set, weights).json != NULL) {
        set++;
    }
    return set;
}

static bool read_set(clast_gltf *gltf, const clast_gltf_value *attributes, unsigned set, clast_gltf_window window,
                     uint32_t joint_count, influence_block *made)
{
    char joints_name[24], weights_name[24];
    clast_gltf_value joints_place = set_member(attributes, "JOINTS", set, joints_name),
                     weights_place = set_member(attributes, "WEIGHTS", set, weights_name);
    void *joints_block, *weights_block = NULL;
    // exact: at most 16 bits
    const float *joints = clast_gltf_read_vertices(gltf, &joints_place, window, UNSIGNED, 4, &joints_block);
    const float *weights = joints != NULL ? clast_gltf_read_vertices(gltf, &weights_place, window, FLOAT | UNSIGNED, 4,
                                                                     &weights_block)
                                          : NULL;
    for (size_t i = 0; weights != NULL && i < (size_t)window.count * JOINTS_OF_SET && clast_gltf_ok(gltf); i++) {
        size_t vertex = i / JOINTS_OF_SET, place = vertex * made->width + set * JOINTS_OF_SET + i % JOINTS_OF_SET;
        if (!(weights[i] >= 0.0f)) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &weights_place, "weight %g (vertex %zu): expected 0 to 1",
                            (double)weights[i], window.first + vertex);
        } else if (weights[i] > 0.0f && !(joints[i] < (float)joint_count)) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &joints_place, "joint %.0f of %u (vertex %zu)",
                            (double)joints[i], joint_count, window.first + vertex);
        } else {
            made->weights[place] = weights[i];
            made->joints[place] = (uint16_t)joints[i];
        }
    }
    clast_free(gltf->context, joints_block);
    clast_free(gltf->context, weights_block);
    return clast_gltf_ok(gltf);
}

static bool read_influences(clast_gltf *gltf, const clast_gltf_value *primitive, clast_gltf_window window,
                            uint32_t joint_count, influence_block *made)
{
    clast_gltf_value attributes = clast_gltf_object(gltf, primitive, "attributes");
    unsigned sets = count_sets(&attributes);
    *made = (influence_block){.width = sets * JOINTS_OF_SET};
    if (!clast_gltf_ok(gltf) || sets == 0) {
        return clast_gltf_ok(gltf);
    }
    size_t count = (size_t)window.count * made->width;
    if (!clast_gltf_account(gltf, &attributes, count, sizeof *made->weights + sizeof *made->joints)) {
        return false;
    }
    made->weights = clast_allocate(gltf->context, count, sizeof *made->weights + sizeof *made->joints);
    if (made->weights == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    made->joints = (uint16_t *)(made->weights + count);
    for (unsigned set = 0; set < sets && clast_gltf_ok(gltf); set++) {
        read_set(gltf, &attributes, set, window, joint_count, made);
    }
    size_t wrong;
    if (clast_gltf_ok(gltf) &&
        !clast_weigh_joints(made->joints, made->weights, window.count, made->width, joint_count, &wrong)) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &attributes, "weight %g (vertex %zu): expected 0 to 1",
                        (double)made->weights[wrong], window.first + wrong / made->width);
    }
    if (!clast_gltf_ok(gltf)) {
        clast_free(gltf->context, made->weights);
        return false;
    }
    return clast_gltf_check(gltf, clast_scene_keep_block(gltf->scene, made->weights));
}

static bool skin(clast_gltf *gltf, const clast_gltf_value *primitive, clast_gltf_window window, uint32_t index,
                 const clast_deformation *known, uint32_t geometry)
{
    clast_scene *scene = gltf->scene;
    uint32_t number = clast_gltf_use_skin(gltf, index);
    if (number == CLAST_NONE) {
        return false;
    }
    uint32_t joint_count = scene->motion.skins[number].joint_count;
    if (known != NULL && known->influences != 0 && scene->motion.skins[known->skin].joint_count == joint_count) {
        return clast_gltf_check(gltf, clast_scene_adopt_skinning(scene, geometry, number, known->influences,
                                                                 known->joints, known->joint_weights));
    }
    influence_block made;
    return read_influences(gltf, primitive, window, joint_count, &made) &&
           clast_gltf_check(gltf,
                            clast_scene_adopt_skinning(scene, geometry, number, made.width, made.joints, made.weights));
}

bool clast_gltf_deform(clast_gltf *gltf, const clast_gltf_value *primitive, clast_gltf_window window,
                       const clast_gltf_use *use, uint32_t known, uint32_t geometry)
{
    // A copy: the list of geometries does not grow here, and their deformations change.
    clast_deformation other = {0};
    if (known != CLAST_NONE) {
        other = gltf->scene->geometries[known].deformation;
    }
    const clast_deformation *source = known != CLAST_NONE ? &other : NULL;
    return (!use->has_weights || morph(gltf, primitive, window, use->node, source, geometry)) &&
           (use->skin == CLAST_NONE || skin(gltf, primitive, window, use->skin, source, geometry));
}
