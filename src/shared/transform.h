// SPDX-License-Identifier: Apache-2.0
// Affine maps.
#ifndef CLAST_SHARED_TRANSFORM_H
#define CLAST_SHARED_TRANSFORM_H

#include "shared/records.h"

FN vec3 transform_vector(clast_transform t, vec3 v)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    return vec3(x[0] * v[0] + x[1] * v[1] + x[2] * v[2], y[0] * v[0] + y[1] * v[1] + y[2] * v[2],
                z[0] * v[0] + z[1] * v[1] + z[2] * v[2]);
}

FN vec3 transform_point(clast_transform t, vec3 p)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    return transform_vector(t, p) + vec3(x[3], y[3], z[3]);
}

// By the transposed map: normals go by the inverse's transpose, so hand in the inverse.
FN vec3 transform_transposed(clast_transform t, vec3 v)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    return vec3(x[0] * v[0] + y[0] * v[1] + z[0] * v[2], x[1] * v[0] + y[1] * v[1] + z[1] * v[2],
                x[2] * v[0] + y[2] * v[1] + z[2] * v[2]);
}

FN float transform_determinant(clast_transform t)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    return dot3(vec3(x[0], x[1], x[2]), cross3(vec3(y[0], y[1], y[2]), vec3(z[0], z[1], z[2])));
}

FN clast_transform transform_rows(vec4 x, vec4 y, vec4 z)
{
    clast_transform result;
    result.rows[0] = store4(x);
    result.rows[1] = store4(y);
    result.rows[2] = store4(z);
    return result;
}

FN clast_transform transform_identity(void)
{
    return transform_rows(vec4(1.0f, 0.0f, 0.0f, 0.0f), vec4(0.0f, 1.0f, 0.0f, 0.0f), vec4(0.0f, 0.0f, 1.0f, 0.0f));
}

// a after b.
FN clast_transform transform_product(clast_transform a, clast_transform b)
{
    vec4 bx = load4(b.rows[0]);
    vec4 by = load4(b.rows[1]);
    vec4 bz = load4(b.rows[2]);
    vec4 ax = load4(a.rows[0]);
    vec4 ay = load4(a.rows[1]);
    vec4 az = load4(a.rows[2]);
    return transform_rows(bx * ax[0] + by * ax[1] + bz * ax[2] + vec4(0.0f, 0.0f, 0.0f, ax[3]),
                          bx * ay[0] + by * ay[1] + bz * ay[2] + vec4(0.0f, 0.0f, 0.0f, ay[3]),
                          bx * az[0] + by * az[1] + bz * az[2] + vec4(0.0f, 0.0f, 0.0f, az[3]));
}

// The inverse; all zero where there is none.
FN clast_transform transform_inverse(clast_transform t)
{
    vec4 x = load4(t.rows[0]);
    vec4 y = load4(t.rows[1]);
    vec4 z = load4(t.rows[2]);
    vec3 a = vec3(x[0], y[0], z[0]);
    vec3 b = vec3(x[1], y[1], z[1]);
    vec3 c = vec3(x[2], y[2], z[2]);
    vec3 bc = cross3(b, c);
    vec3 ca = cross3(c, a);
    vec3 ab = cross3(a, b);
    float determinant = dot3(a, bc);
    float scale = determinant == 0.0f ? 0.0f : rough_divide(1.0f, determinant);
    vec3 p = vec3(x[3], y[3], z[3]);
    bc = bc * scale;
    ca = ca * scale;
    ab = ab * scale;
    return transform_rows(vec4(bc[0], bc[1], bc[2], -dot3(bc, p)), vec4(ca[0], ca[1], ca[2], -dot3(ca, p)),
                          vec4(ab[0], ab[1], ab[2], -dot3(ab, p)));
}

#endif
