// SPDX-License-Identifier: Apache-2.0
// Morph targets (section 3.7.2.2) and skins (section 3.7.3), applied once: the pose in which a file shows its meshes
// before any animation.
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "load/gltf.h"

#define FLOAT CLAST_GLTF_BIT(CLAST_GLTF_FLOAT)
#define SIGNED (CLAST_GLTF_BIT(CLAST_GLTF_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_SHORT))
#define UNSIGNED (CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_BYTE) | CLAST_GLTF_BIT(CLAST_GLTF_UNSIGNED_SHORT))

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

// ------------------------------------------------------------------------------------------------------- morph targets

// Adds a target's displacements of one attribute, times its weight, to `width` floats a vertex of which three are
// moved.
static void add_target(clast_gltf *gltf, const clast_gltf_value *target, const char *name, float weight, uint64_t count,
                       size_t width, float *vectors)
{
    clast_gltf_value place = clast_gltf_member(target, name);
    if (place.json == NULL || vectors == NULL || !clast_gltf_ok(gltf)) {
        return;
    }
    float *moves = clast_gltf_read_block(gltf, &place, FLOAT | SIGNED, 1, 3, &count);
    for (size_t i = 0; moves != NULL && i < count; i++) {
        for (size_t k = 0; k < 3; k++) {
            vectors[width * i + k] += weight * moves[3 * i + k];
        }
    }
    clast_free(gltf->context, moves);
}

bool clast_gltf_morph(clast_gltf *gltf, const clast_gltf_value *primitive, const clast_gltf_pose *pose,
                      const clast_mesh *mesh, float *positions, float *normals, float *tangents)
{
    clast_gltf_value targets = clast_gltf_array(gltf, primitive, "targets");
    if (clast_gltf_ok(gltf) && clast_gltf_size(&targets) != pose->weight_count) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, primitive, "%zu morph targets: expected %zu, as there are weights",
                        clast_gltf_size(&targets), pose->weight_count);
    }
    for (size_t i = 0; i < pose->weight_count && clast_gltf_ok(gltf); i++) {
        float weight = pose->weights[i];
        if (weight != 0.0f) {
            clast_gltf_value target = clast_gltf_element_object(gltf, &targets, i);
            add_target(gltf, &target, "POSITION", weight, mesh->vertex_count, 3, positions);
            add_target(gltf, &target, "NORMAL", weight, mesh->vertex_count, 3, normals);
            add_target(gltf, &target, "TANGENT", weight, mesh->vertex_count, 4, tangents);
        }
    }
    return clast_gltf_ok(gltf);
}

// --------------------------------------------------------------------------------------------------------------- skins

// Adds one set of four joints for each vertex, weighted, to the vertices' matrices and the sums of their weights.
// False where the primitive has no such set, or on failure.
static bool add_joint_set(clast_gltf *gltf, const clast_gltf_value *attributes, unsigned set,
                          const clast_gltf_pose *pose, uint64_t count, clast_gltf_transform *blends, double *sums)
{
    char joints_name[24], weights_name[24];
    snprintf(joints_name, sizeof joints_name, "JOINTS_%u", set);
    snprintf(weights_name, sizeof weights_name, "WEIGHTS_%u", set);
    clast_gltf_value joints_place = clast_gltf_member(attributes, joints_name),
                     weights_place = clast_gltf_member(attributes, weights_name);
    if (joints_place.json == NULL || weights_place.json == NULL) {
        return false;
    }
    float *joints = clast_gltf_read_block(gltf, &joints_place, UNSIGNED, 1, 4, &count); // exact: at most 16 bits
    float *weights = joints != NULL ? clast_gltf_read_block(gltf, &weights_place, FLOAT | UNSIGNED, 1, 4, &count)
                                    : NULL;
    for (size_t i = 0; weights != NULL && i < 4 * count && clast_gltf_ok(gltf); i++) {
        double weight = (double)weights[i];
        if (weight == 0.0) {
            continue;
        }
        if (!(joints[i] < (float)pose->joint_count)) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &joints_place, "joint %.0f of %zu (vertex %zu)",
                            (double)joints[i], pose->joint_count, i / 4);
        } else if (!(weight > 0.0 && weight <= (double)FLT_MAX)) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &weights_place, "weight %g (vertex %zu): expected 0 to 1",
                            weight, i / 4);
        } else {
            const clast_gltf_transform *joint = &pose->joints[(size_t)joints[i]];
            for (size_t k = 0; k < 12; k++) {
                blends[i / 4].rows[k / 4][k % 4] += weight * joint->rows[k / 4][k % 4];
            }
            sums[i / 4] += weight;
        }
    }
    clast_free(gltf->context, joints);
    clast_free(gltf->context, weights);
    return clast_gltf_ok(gltf);
}

static void move_direction(const double matrix[3][3], float *vector)
{
    double moved[3], largest = 0.0;
    for (int i = 0; i < 3; i++) {
        moved[i] = matrix[i][0] * (double)vector[0] + matrix[i][1] * (double)vector[1] +
                   matrix[i][2] * (double)vector[2];
        largest = fmax(largest, fabs(moved[i]));
    }
    double length = largest > 0.0 ? largest * sqrt((moved[0] / largest) * (moved[0] / largest) +
                                                   (moved[1] / largest) * (moved[1] / largest) +
                                                   (moved[2] / largest) * (moved[2] / largest))
                                  : 1.0;
    for (int i = 0; i < 3; i++) {
        vector[i] = (float)(moved[i] / length);
    }
}

// Moves a vertex. Normals go by the cofactors, which are the inverse transpose times the determinant.
static void move_vertex(const clast_gltf_transform *blend, double sum, float *position, float *normal, float *tangent)
{
    double m[3][3], cofactors[3][3], moved[3];
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            m[i][j] = blend->rows[i][j] / sum;
        }
        moved[i] = m[i][0] * (double)position[0] + m[i][1] * (double)position[1] + m[i][2] * (double)position[2] +
                   blend->rows[i][3] / sum;
    }
    for (int i = 0; i < 3; i++) {
        int a = (i + 1) % 3, b = (i + 2) % 3;
        for (int j = 0; j < 3; j++) {
            int c = (j + 1) % 3, d = (j + 2) % 3;
            cofactors[i][j] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
        position[i] = (float)moved[i];
    }
    if (normal != NULL) {
        move_direction(cofactors, normal);
    }
    if (tangent != NULL) {
        move_direction(m, tangent);
    }
}

bool clast_gltf_skin(clast_gltf *gltf, const clast_gltf_value *primitive, const clast_gltf_pose *pose,
                     const clast_mesh *mesh, float *positions, float *normals, float *tangents)
{
    clast_gltf_value attributes = clast_gltf_object(gltf, primitive, "attributes");
    size_t count = mesh->vertex_count;
    clast_gltf_transform *blends = clast_allocate_zeroed(gltf->context, count, sizeof *blends);
    double *sums = blends != NULL ? clast_allocate_zeroed(gltf->context, count, sizeof *sums) : NULL;
    if (sums == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    for (unsigned set = 0; clast_gltf_ok(gltf) && add_joint_set(gltf, &attributes, set, pose, count, blends, sums);
         set++) {
    }
    for (size_t i = 0; i < count && clast_gltf_ok(gltf); i++) {
        if (sums[i] > 0.0) { // vertices without weights stay
            move_vertex(&blends[i], sums[i], positions + 3 * i, normals != NULL ? normals + 3 * i : NULL,
                        tangents != NULL ? tangents + 4 * i : NULL);
        }
    }
    clast_free(gltf->context, sums);
    clast_free(gltf->context, blends);
    return clast_gltf_ok(gltf);
}
