// SPDX-License-Identifier: Apache-2.0
// Whether two tracers agree about a ray. Where they name different triangles, both are tested in double precision: it is a tie
// where each was a candidate within float's precision (the ray passes within a small part of its size of each, at distances
// that agree, or the one that was missed is passed at its rim). Where Embree alone names a triangle that the ray passes well
// beside, as in instances that are almost flat, the ray tells nothing of ours, and is counted apart. Anything else is wrong.
#ifndef CLAST_TESTS_EMBREE_AGREEMENT_H
#define CLAST_TESTS_EMBREE_AGREEMENT_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "accel/meshes.h"

typedef struct agreement {
    float scale; // the largest coordinate that matters: of the rays' origins and the mesh
    uint64_t hits, ties, wrong;
    uint64_t theirs; // Embree alone is wrong
} agreement;

// A triangle's corners; null corners where there is none.
typedef struct corners {
    const float *v[3];
} corners;

static inline corners agreement_corners(const mesh *m, uint32_t triangle)
{
    corners c = {{NULL, NULL, NULL}};
    for (uint32_t k = 0; k < 3 && triangle < m->triangle_count; k++) {
        c.v[k] = m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + k];
    }
    return c;
}

typedef struct double_hit {
    double t, u, v;      // u and v undefined where the ray is in the triangle's plane
    double height, size; // of the triangle: the smallest height, the longest edge
    double sine;         // of the angle between the ray and the plane
} double_hit;

static inline void cross_double(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    }
}

static inline double dot_double(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double_hit hit_in_double(const clast_ray *ray, corners c)
{
    double e1[3], e2[3], from[3], d[3], p[3], q[3], normal[3], e3[3];
    for (int i = 0; i < 3; i++) {
        e1[i] = (double)c.v[1][i] - (double)c.v[0][i];
        e2[i] = (double)c.v[2][i] - (double)c.v[0][i];
        e3[i] = e2[i] - e1[i];
        from[i] = (double)ray->origin[i] - (double)c.v[0][i];
        d[i] = (double)ray->direction[i];
    }
    cross_double(d, e2, p);
    cross_double(from, e1, q);
    cross_double(e1, e2, normal);
    double determinant = dot_double(e1, p), area = sqrt(dot_double(normal, normal));
    double longest = sqrt(fmax(dot_double(e1, e1), fmax(dot_double(e2, e2), dot_double(e3, e3))));
    return (double_hit){dot_double(e2, q) / determinant,
                        dot_double(from, p) / determinant,
                        dot_double(d, q) / determinant,
                        longest > 0.0 ? area / longest : 0.0,
                        longest,
                        fabs(determinant) / (area * sqrt(dot_double(d, d)))};
}

static inline double length_double(const float v[3])
{
    return sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2]);
}

// How good barycentric weights can be in float: rounding moves corners, seen along the ray, by some parts of 1e-7 of the
// distances, and the triangle is as high as this, seen so.
static inline double weights_precision(const agreement *a, const clast_ray *ray, double_hit h)
{
    double reach = (double)a->scale + fabs(h.t) * length_double(ray->direction);
    return 1e-6 * reach / fmax(h.height * h.sine, 1e-300);
}

// And distances: weights times the triangle's size, and rounding.
static inline double distance_precision(const agreement *a, const clast_ray *ray, double_hit h)
{
    double length = length_double(ray->direction);
    return 1e-5 * (fabs(h.t) + (double)a->scale / length) + weights_precision(a, ray, h) * h.size / length;
}

// Whether floats cannot tell if the triangle is hit: near its rim, or at an end of the ray.
static inline bool is_doubtful(const agreement *a, const clast_ray *ray, double_hit h)
{
    double inside = fmin(h.u, fmin(h.v, 1.0 - h.u - h.v)), precision = distance_precision(a, ray, h);
    return !(fabs(inside) > weights_precision(a, ray, h)) || fabs(h.t - (double)ray->t_max) < precision ||
           fabs(h.t - (double)ray->t_min) < precision;
}

static inline bool is_passed_by(const agreement *a, const clast_ray *ray, corners c)
{
    double_hit h = hit_in_double(ray, c);
    return fmin(h.u, fmin(h.v, 1.0 - h.u - h.v)) < -weights_precision(a, ray, h);
}

static inline void agreement_count(agreement *a, const clast_ray *ray, corners ours, float our_t, corners theirs,
                                   float their_t)
{
    a->hits += ours.v[0] != NULL;
    bool same = ours.v[0] == theirs.v[0] && ours.v[1] == theirs.v[1] && ours.v[2] == theirs.v[2];
    if (same && ours.v[0] == NULL) {
        return;
    }
    double_hit h = {0}, g = {0};
    if (ours.v[0] != NULL) {
        h = hit_in_double(ray, ours);
    }
    if (theirs.v[0] != NULL) {
        g = hit_in_double(ray, theirs);
    }
    if (same) {
        if (!(fabs((double)our_t - h.t) <= distance_precision(a, ray, h)) && a->wrong++ < 5) {
            fprintf(stderr, "one triangle: t %.9g, Embree %.9g, double %.9g, sine %g, size %g, height %g\n",
                    (double)our_t, (double)their_t, h.t, h.sine, h.size, h.height);
        }
        return;
    }
    double apart = fabs((double)our_t - (double)their_t);
    if (ours.v[0] != NULL && theirs.v[0] != NULL &&
        apart <= fmax(distance_precision(a, ray, h), distance_precision(a, ray, g))) {
        a->ties++; // two at the same distance
        return;
    }
    // The nearer of the two was missed by one of them: was it doubtful?
    bool ours_first = theirs.v[0] == NULL || (ours.v[0] != NULL && our_t < their_t);
    h = ours_first ? h : g;
    if (is_doubtful(a, ray, h)) {
        a->ties++;
        return;
    }
    if (!ours_first && is_passed_by(a, ray, theirs) && (ours.v[0] == NULL || !is_passed_by(a, ray, ours))) {
        a->theirs++;
        return;
    }
    if (a->wrong++ < 5) {
        fprintf(
            stderr,
            "from %.9g %.9g %.9g towards %.9g %.9g %.9g: t %.9g, Embree %.9g; in double t %.9g, u %.9g, v %.9g, sine %g\n",
            (double)ray->origin[0], (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0],
            (double)ray->direction[1], (double)ray->direction[2], ours.v[0] != NULL ? (double)our_t : -1.0,
            theirs.v[0] != NULL ? (double)their_t : -1.0, h.t, h.u, h.v, h.sine);
    }
}

#endif
