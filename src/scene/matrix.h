// SPDX-License-Identifier: Apache-2.0
// Affine maps in double precision: deep trees of nodes far from the origin keep their places.
#ifndef CLAST_SCENE_MATRIX_H
#define CLAST_SCENE_MATRIX_H

#include "shared/transform.h"

// Three rows of four: x' = row . (x, y, z, 1).
typedef struct clast_matrix {
    double rows[3][4];
} clast_matrix;

static inline clast_matrix clast_matrix_identity(void)
{
    return (clast_matrix){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

// a after b.
static inline clast_matrix clast_matrix_product(const clast_matrix *a, const clast_matrix *b)
{
    clast_matrix result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++) {
            const double *row = a->rows[i];
            result.rows[i][j] = row[0] * b->rows[0][j] + row[1] * b->rows[1][j] + row[2] * b->rows[2][j] +
                                (j == 3 ? row[3] : 0.0);
        }
    }
    return result;
}

// Translation after rotation after scale (glTF 2.0, section 3.5.3). The quaternion is made unit length; zero turns nothing.
static inline clast_matrix clast_matrix_compose(const double translation[3], const double rotation[4],
                                                const double scale[3])
{
    double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    double square = x * x + y * y + z * z + w * w;
    double s = square > 0.0 ? 2.0 / square : 0.0;
    double turn[3][3] = {
        {1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)},
        {s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)},
        {s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)},
    };
    clast_matrix result;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            result.rows[i][j] = turn[i][j] * scale[j];
        }
        result.rows[i][3] = translation[i];
    }
    return result;
}

static inline clast_matrix clast_matrix_of_transform(const clast_transform *from)
{
    clast_matrix result;
    for (int i = 0; i < 12; i++) {
        result.rows[i / 4][i % 4] = (double)from->rows[i / 4].v[i % 4];
    }
    return result;
}

// False where single precision does not hold it.
static inline bool clast_matrix_round(const clast_matrix *from, clast_transform *to)
{
    bool holds = true;
    for (int i = 0; i < 12; i++) {
        to->rows[i / 4].v[i % 4] = (float)from->rows[i / 4][i % 4];
        holds = holds && is_finite1(to->rows[i / 4].v[i % 4]);
    }
    return holds;
}

#endif
