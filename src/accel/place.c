// SPDX-License-Identifier: Apache-2.0
// Where instances are.
//
// A ray goes to an instance's object space in float arithmetic. There it is a slightly different ray, and what it hits may
// lie a little beside the instance's box in the world. How far is bounded by the map's condition number, the norm of
// |M| |M^-1| (Bauer, Skeel), times a few units in the last place of the largest distance from the ray's origin and from the
// object's. The part that comes from the object is added to the box here, the part that comes from the ray is added by the
// traversal, which multiplies it by the largest condition number (clast_tlas.spread).
#include <float.h>
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "shared/box.h"

#define SPREAD_STEP (1.0 / 131072.0) // 2^-17; about 30 roundings of 2^-24 are possible
#define SPREAD_MOST 1e20

// The inverse of a 3 x 3 matrix by cofactors; false where there is none that floats can hold.
static bool invert(const double m[3][3], double inverse[3][3], double *determinant)
{
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            inverse[i][j] = m[r][c] * m[s][d] - m[r][d] * m[s][c];
        }
    }
    *determinant = m[0][0] * inverse[0][0] + m[0][1] * inverse[1][0] + m[0][2] * inverse[2][0];
    double scale = 1.0 / *determinant;
    bool holds = isfinite(*determinant) && isfinite(scale);
    for (int i = 0; i < 9; i++) {
        inverse[i / 3][i % 3] *= scale;
        holds &= fabs(inverse[i / 3][i % 3]) <= (double)FLT_MAX;
    }
    return holds;
}

// The largest row sum of |m| |inverse|.
static double condition(const double m[3][3], const double inverse[3][3])
{
    double sums[3], most = 1.0;
    for (int k = 0; k < 3; k++) {
        sums[k] = fabs(inverse[k][0]) + fabs(inverse[k][1]) + fabs(inverse[k][2]);
    }
    for (int i = 0; i < 3; i++) {
        double sum = fabs(m[i][0]) * sums[0] + fabs(m[i][1]) * sums[1] + fabs(m[i][2]) * sums[2];
        most = sum > most ? sum : most;
    }
    return most;
}

// The float next to one below, or above.
static float next_below(float x)
{
    return x == 0.0f ? -0x1p-149f : uintBitsToFloat(floatBitsToUint(x) + (x < 0.0f ? 1u : 0xffffffffu));
}

// Rounded outwards to floats; false where a side is too far away.
static bool store_box(const double lower[3], const double upper[3], clast_box *box)
{
    bool near = true;
    for (int axis = 0; axis < 3; axis++) {
        near &= lower[axis] >= -(double)BOX_COORDINATE_MOST / 2 && upper[axis] <= (double)BOX_COORDINATE_MOST / 2;
        float low = (float)lower[axis], high = (float)upper[axis];
        box->lower.v[axis] = (double)low > lower[axis] ? next_below(low) : low;
        box->upper.v[axis] = (double)high < upper[axis] ? -next_below(-high) : high;
    }
    return near;
}

// The box in the world, padded by what comes from the object's size and its distance from its own origin.
static bool world_box(const double map[3][3], const float origin[3], const clast_box *object, double spread,
                      clast_box *box)
{
    double lower[3], upper[3], farthest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        double low = 0.0, high = 0.0;
        for (int k = 0; k < 3; k++) {
            double a = map[axis][k] * (double)object->lower.v[k];
            double b = map[axis][k] * (double)object->upper.v[k];
            low += a < b ? a : b;
            high += a < b ? b : a;
        }
        double far = fabs(low) > fabs(high) ? fabs(low) : fabs(high);
        farthest = far > farthest ? far : farthest;
        lower[axis] = (double)origin[axis] + low;
        upper[axis] = (double)origin[axis] + high;
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
    if (clast_box_is_empty(&object)) {
        return false;
    }
    double to_world[3][3], to_object[3][3], determinant;
    bool finite = true;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            float element = instance->transform[i][k];
            finite &= isfinite(element);
            placement->to_world[k][i] = element;
            to_world[i][k] = (double)element;
        }
        finite &= isfinite(instance->transform[i][3]);
        placement->origin[i] = instance->transform[i][3];
    }
    if (!finite || !invert(to_world, to_object, &determinant)) {
        return false;
    }
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            placement->to_object[k][i] = (float)to_object[i][k];
        }
    }
    *spread = condition(to_world, to_object);
    placement->mirrored = determinant < 0.0;
    return world_box(to_world, placement->origin, &object, *spread, box);
}

float clast_place(const clast_tlas_instance *instance, clast_placement *placement, clast_box *box)
{
    double spread = 1.0;
    *placement = (clast_placement){.id = instance->id, .filtered = instance->filtered != 0};
    if (!place(instance, placement, box, &spread)) {
        *box = clast_box_empty();
        return 1.0f;
    }
    placement->blas = instance->blas;
    return (float)(spread < SPREAD_MOST ? spread : SPREAD_MOST);
}
