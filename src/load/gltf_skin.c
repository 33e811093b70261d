// SPDX-License-Identifier: Apache-2.0
// Skins (section 3.7.3): joints, and how they were bound.
#include "load/gltf.h"

enum { JOINTS_MOST = 65536, ROWS = 3, COLUMNS = 4 };

// For each joint three rows of four, in a new block; null where the skin has none, or on failure.
static float *read_binds(clast_gltf *gltf, const clast_gltf_value *skin, size_t joint_count)
{
    clast_gltf_value place = clast_gltf_member(skin, "inverseBindMatrices");
    if (place.json == NULL) {
        return NULL;
    }
    uint64_t count = 0; // there may be more matrices than joints
    float *matrices = clast_gltf_read_block(gltf, &place, CLAST_GLTF_BIT(CLAST_GLTF_FLOAT), 4, 4, &count);
    if (matrices == NULL) {
        return NULL;
    }
    if (count < joint_count) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "%llu matrices: expected one for each of the %zu joints",
                        (unsigned long long)count, joint_count);
    }
    for (size_t i = 0; i < joint_count && clast_gltf_ok(gltf); i++) { // in place: rows take less room than columns
        float columns[16];
        for (size_t k = 0; k < 16; k++) {
            columns[k] = matrices[16 * i + k];
            if (!is_finite1(columns[k])) {
                clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "matrix %zu is not finite", i);
            }
        }
        for (size_t k = 0; k < ROWS * COLUMNS; k++) {
            matrices[ROWS * COLUMNS * i + k] = columns[k % COLUMNS * 4 + k / COLUMNS];
        }
    }
    return matrices;
}

static uint32_t read_skin(clast_gltf *gltf, uint32_t index)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_SKINS, index);
    clast_gltf_value list = clast_gltf_array(gltf, &value, "joints");
    size_t count = clast_gltf_size(&list);
    if (clast_gltf_ok(gltf) && count == 0) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "no joints: expected at least one");
    } else if (count > JOINTS_MOST) {
        clast_gltf_fail(gltf, CLAST_ERROR_LIMIT, &list, "%zu joints: expected at most %d", count, JOINTS_MOST);
    }
    uint32_t *joints = clast_gltf_ok(gltf) ? clast_allocate(gltf->context, count, sizeof *joints) : NULL;
    if (joints == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return CLAST_NONE;
    }
    for (size_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        clast_gltf_value element = clast_gltf_element(&list, i);
        uint32_t node = clast_gltf_value_index(gltf, &element, CLAST_GLTF_NODES);
        joints[i] = node != CLAST_NONE ? gltf->node_numbers[node] : 0;
    }
    float *binds = clast_gltf_ok(gltf) ? read_binds(gltf, &value, count) : NULL;
    uint32_t number = CLAST_NONE;
    if (clast_gltf_ok(gltf)) {
        clast_skin_desc desc = {.joint_count = (uint32_t)count, .joints = joints, .inverse_binds = binds};
        clast_gltf_check(gltf, clast_scene_add_skin(gltf->scene, &desc, &number));
    }
    clast_free(gltf->context, binds);
    clast_free(gltf->context, joints);
    return clast_gltf_ok(gltf) ? number : CLAST_NONE;
}

uint32_t clast_gltf_use_skin(clast_gltf *gltf, uint32_t skin)
{
    if (gltf->skins[skin] == CLAST_NONE) {
        gltf->skins[skin] = read_skin(gltf, skin);
    }
    return gltf->skins[skin];
}
