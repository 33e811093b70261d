// SPDX-License-Identifier: Apache-2.0
// Trees over instances.
//
// A ray goes to an instance's object space in float arithmetic. There it is a slightly different ray, and what it hits may
// lie a little beside the instance's box in the world. How far is bounded by the map's condition number, the norm of
// |M| |M^-1| (Bauer, Skeel), times a few units in the last place of the largest distance from the ray's origin and from the
// object's. The part that comes from the object is added to the box here, the part that comes from the ray is added by the
// traversal, which multiplies it by the largest condition number (`spread`).
#include <float.h>
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "shared/box.h"

#define SPREAD_STEP (1.0 / 131072.0) // 2^-17; about 30 roundings of 2^-24 are possible

clast_status clast_tlas_create(clast_context *context, clast_tlas **tlas)
{
    if (context == NULL || tlas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *tlas = clast_allocate_zeroed(context, 1, sizeof **tlas);
    if (*tlas == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    (*tlas)->context = context;
    return CLAST_OK;
}

void clast_tlas_destroy(clast_tlas *tlas)
{
    if (tlas != NULL) {
        clast_tree_free(tlas->context, &tlas->tree);
        clast_free(tlas->context, tlas->placements);
        clast_free(tlas->context, tlas->boxes);
        clast_free(tlas->context, tlas);
    }
}

// The inverse of a 3 x 3 matrix by cofactors, in double precision; false where there is none that floats can hold.
static bool invert(const double m[3][3], double inverse[3][3], double *determinant)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            inverse[i][j] = m[r][c] * m[s][d] - m[r][d] * m[s][c];
        }
    }
    *determinant = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
    if (*determinant == 0.0 || !isfinite(*determinant)) {
        return false;
    }
    for (int i = 0; i < 9; i++) {
        inverse[i / 3][i % 3] /= *determinant;
        if (!(fabs(inverse[i / 3][i % 3]) <= (double)FLT_MAX)) {
            return false;
        }
    }
    return true;
}

// The largest row sum of |m| |inverse|.
static double condition(const double m[3][3], const double inverse[3][3])
{
    double most = 1.0;
    for (int i = 0; i < 3; i++) {
        double sum = 0.0;
        for (int j = 0; j < 3; j++) {
            for (int k = 0; k < 3; k++) {
                sum += fabs(m[i][k]) * fabs(inverse[k][j]);
            }
        }
        most = sum > most ? sum : most;
    }
    return most;
}

// Rounded outwards to floats; false where a side is too far away.
static bool store_box(const double lower[3], const double upper[3], clast_box *box)
{
    for (int axis = 0; axis < 3; axis++) {
        if (!(lower[axis] >= -(double)BOX_COORDINATE_MOST / 2 && upper[axis] <= (double)BOX_COORDINATE_MOST / 2)) {
            return false;
        }
        float low = (float)lower[axis], high = (float)upper[axis];
        box->lower.v[axis] = (double)low > lower[axis] ? nextafterf(low, -INFINITY) : low;
        box->upper.v[axis] = (double)high < upper[axis] ? nextafterf(high, INFINITY) : high;
    }
    return true;
}

// The box in the world, padded by what comes from the object's size and its distance from its own origin.
static bool world_box(const clast_tlas_instance *instance, const clast_box *object, double spread, clast_box *box)
{
    double lower[3], upper[3], farthest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        double low = 0.0, high = 0.0;
        for (int k = 0; k < 3; k++) {
            double a = (double)instance->transform[axis][k] * (double)object->lower.v[k];
            double b = (double)instance->transform[axis][k] * (double)object->upper.v[k];
            low += a < b ? a : b;
            high += a < b ? b : a;
        }
        farthest = fmax(farthest, fmax(fabs(low), fabs(high)));
        lower[axis] = (double)instance->transform[axis][3] + low;
        upper[axis] = (double)instance->transform[axis][3] + high;
    }
    double pad = farthest * spread * SPREAD_STEP;
    for (int axis = 0; axis < 3; axis++) {
        lower[axis] -= pad;
        upper[axis] += pad;
    }
    return store_box(lower, upper, box);
}

// False where nothing of the instance can be hit.
static bool place(const clast_tlas_instance *instance, clast_placement *placement, clast_box *box, double *spread)
{
    clast_box object = instance->blas != NULL ? clast_tree_bounds(&instance->blas->tree) : clast_box_empty();
    double to_world[3][3], to_object[3][3], determinant;
    memset(placement, 0, sizeof *placement);
    if (clast_box_is_empty(&object)) {
        return false;
    }
    for (int i = 0; i < 12; i++) {
        float element = instance->transform[i / 4][i % 4];
        if (!isfinite(element)) {
            return false;
        }
        if (i % 4 == 3) {
            placement->origin[i / 4] = element;
        } else {
            placement->to_world[i % 4][i / 4] = element;
            to_world[i / 4][i % 4] = (double)element;
        }
    }
    if (!invert(to_world, to_object, &determinant)) {
        return false;
    }
    for (int i = 0; i < 9; i++) {
        placement->to_object[i % 3][i / 3] = (float)to_object[i / 3][i % 3];
    }
    *spread = condition(to_world, to_object);
    placement->blas = instance->blas;
    placement->id = instance->id;
    placement->filtered = instance->filtered != 0;
    placement->mirrored = determinant < 0.0;
    return world_box(instance, &object, *spread, box);
}

static clast_status check_instances(clast_context *context, const clast_tlas_instance *instances, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (instances[i].id == CLAST_NONE) {
            return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                              "instance %zu has the id %u, which says that nothing was hit", i, CLAST_NONE);
        }
    }
    return CLAST_OK;
}

clast_status clast_tlas_build(clast_tlas *tlas, const clast_tlas_instance *instances, size_t count, clast_build build)
{
    if (tlas == NULL || (instances == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count >= CLAST_CHILD_ITEM) {
        return clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "a TLAS over %zu instances; less than 2^31 are possible", count);
    }
    clast_status status = check_instances(tlas->context, instances, count);
    if (status != CLAST_OK) {
        return status;
    }
    // From here on a failure leaves an empty tree.
    tlas->tree.node_count = 0;
    tlas->tree.level_count = 0;
    tlas->placement_count = 0;
    double spread = 1.0;
    if (CLAST_RESERVE(tlas->context, tlas->placements, tlas->placement_capacity, count) != CLAST_OK ||
        CLAST_RESERVE(tlas->context, tlas->boxes, tlas->box_capacity, count) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        clast_placement *placement = &tlas->placements[tlas->placement_count];
        double own_spread = 1.0;
        if (place(&instances[i], placement, &tlas->boxes[tlas->placement_count], &own_spread)) {
            placement->index = (uint32_t)i;
            spread = own_spread > spread ? own_spread : spread;
            tlas->placement_count++;
        }
    }
    tlas->spread = (float)(spread < 1e20 ? spread : 1e20);
    clast_arena scratch = {clast_allocate(tlas->context, clast_tree_scratch(count), 1), 0};
    if (scratch.memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    status = clast_tree_build(tlas->context, &tlas->tree, tlas->boxes, NULL, tlas->placement_count, build, &scratch);
    clast_free(tlas->context, scratch.memory);
    return status;
}

void clast_tlas_bounds(const clast_tlas *tlas, float lower[3], float upper[3])
{
    clast_box box = tlas != NULL ? clast_tree_bounds(&tlas->tree) : clast_box_empty();
    memcpy(lower, box.lower.v, sizeof box.lower.v);
    memcpy(upper, box.upper.v, sizeof box.upper.v);
}

uint64_t clast_tlas_bytes(const clast_tlas *tlas)
{
    return tlas != NULL
               ? sizeof *tlas + clast_tree_bytes(&tlas->tree) + tlas->placement_capacity * sizeof *tlas->placements +
                     tlas->box_capacity * sizeof *tlas->boxes
               : 0;
}
