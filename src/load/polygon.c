// SPDX-License-Identifier: Apache-2.0
#include "load/polygon.h"

#include <math.h>

clast_status clast_polygon_reserve(clast_context *context, clast_polygon *polygon, uint32_t count)
{
    size_t triangles = count > 2 ? count - 2 : 0;
    clast_status status = CLAST_RESERVE(context, polygon->points, polygon->points_capacity, count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, polygon->corners, polygon->corners_capacity, 3 * triangles);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, polygon->next, polygon->next_capacity, count);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, polygon->previous, polygon->previous_capacity, count);
    }
    return status == CLAST_OK ? CLAST_RESERVE(context, polygon->flat, polygon->flat_capacity, count) : status;
}

void clast_polygon_free(clast_context *context, clast_polygon *polygon)
{
    clast_free(context, polygon->points);
    clast_free(context, polygon->corners);
    clast_free(context, polygon->next);
    clast_free(context, polygon->previous);
    clast_free(context, polygon->flat);
    *polygon = (clast_polygon){0};
}

// Newell's normal, relative to the first point so that polygons far from the origin keep their digits. (Sutherland,
// Sproull and Schumacker, A Characterization of Ten Hidden-Surface Algorithms, 1974.)
static void find_normal(clast_polygon *polygon, uint32_t count)
{
    const float *origin = polygon->points[0];
    double sum[3] = {0.0, 0.0, 0.0};
    for (uint32_t i = 1; i + 1 < count; i++) {
        double a[3], b[3];
        for (int c = 0; c < 3; c++) {
            a[c] = (double)polygon->points[i][c] - (double)origin[c];
            b[c] = (double)polygon->points[i + 1][c] - (double)origin[c];
        }
        sum[0] += a[1] * b[2] - a[2] * b[1];
        sum[1] += a[2] * b[0] - a[0] * b[2];
        sum[2] += a[0] * b[1] - a[1] * b[0];
    }
    for (int c = 0; c < 3; c++) {
        polygon->normal[c] = sum[c];
    }
}

// Drops the axis along which the normal is longest, keeping the orientation.
static void flatten(clast_polygon *polygon, uint32_t count)
{
    double size[3] = {fabs(polygon->normal[0]), fabs(polygon->normal[1]), fabs(polygon->normal[2])};
    int drop = size[0] > size[1] ? (size[0] > size[2] ? 0 : 2) : (size[1] > size[2] ? 1 : 2);
    int u = (drop + 1) % 3, v = (drop + 2) % 3;
    double sign = polygon->normal[drop] < 0.0 ? -1.0 : 1.0;
    for (uint32_t i = 0; i < count; i++) {
        polygon->flat[i][0] = sign * ((double)polygon->points[i][u] - (double)polygon->points[0][u]);
        polygon->flat[i][1] = (double)polygon->points[i][v] - (double)polygon->points[0][v];
    }
}

// Twice the signed area of a triangle of corners.
static double area(const clast_polygon *polygon, uint32_t a, uint32_t b, uint32_t c)
{
    const double *p = polygon->flat[a], *q = polygon->flat[b], *r = polygon->flat[c];
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
}

static void emit(clast_polygon *polygon, uint32_t triangle, uint32_t a, uint32_t b, uint32_t c)
{
    polygon->corners[3 * (size_t)triangle] = a;
    polygon->corners[3 * (size_t)triangle + 1] = b;
    polygon->corners[3 * (size_t)triangle + 2] = c;
}

static double distance_squared(const float a[3], const float b[3])
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        double d = (double)a[c] - (double)b[c];
        sum += d * d;
    }
    return sum;
}

static void cut_quad(clast_polygon *polygon)
{
    bool first = area(polygon, 0, 1, 2) > 0.0 && area(polygon, 0, 2, 3) > 0.0;  // along 0, 2
    bool second = area(polygon, 1, 2, 3) > 0.0 && area(polygon, 1, 3, 0) > 0.0; // along 1, 3
    if (first == second) {
        first = distance_squared(polygon->points[0], polygon->points[2]) <=
                distance_squared(polygon->points[1], polygon->points[3]);
    }
    if (first) {
        emit(polygon, 0, 0, 1, 2);
        emit(polygon, 1, 0, 2, 3);
    } else {
        emit(polygon, 0, 0, 1, 3);
        emit(polygon, 1, 1, 2, 3);
    }
}

static bool is_same_point(const clast_polygon *polygon, uint32_t a, uint32_t b)
{
    return polygon->flat[a][0] == polygon->flat[b][0] && polygon->flat[a][1] == polygon->flat[b][1];
}

// Whether the corner can be cut off: it is convex and no reflex corner of the rest lies in its triangle. Corners that
// lie at one of the triangle's own points (bridges to holes) do not count.
static bool is_ear(const clast_polygon *polygon, uint32_t b)
{
    uint32_t a = polygon->previous[b], c = polygon->next[b];
    if (!(area(polygon, a, b, c) > 0.0)) {
        return false;
    }
    for (uint32_t p = polygon->next[c]; p != a; p = polygon->next[p]) {
        if (area(polygon, polygon->previous[p], p, polygon->next[p]) > 0.0) {
            continue;
        }
        if (area(polygon, a, b, p) >= 0.0 && area(polygon, b, c, p) >= 0.0 && area(polygon, c, a, p) >= 0.0 &&
            !is_same_point(polygon, p, a) && !is_same_point(polygon, p, b) && !is_same_point(polygon, p, c)) {
            return false;
        }
    }
    return true;
}

static bool is_convex(const clast_polygon *polygon, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        if (!(area(polygon, i, (i + 1) % count, (i + 2) % count) >= 0.0)) {
            return false;
        }
    }
    // All turns go one way; the polygon must also go round once only. Seen from its first corner, it does not turn back
    // then.
    for (uint32_t i = 1; i + 1 < count; i++) {
        if (!(area(polygon, 0, i, i + 1) >= 0.0)) {
            return false;
        }
    }
    return true;
}

static void cut_fan(clast_polygon *polygon, uint32_t count)
{
    for (uint32_t i = 0; i + 2 < count; i++) {
        emit(polygon, i, 0, i + 1, i + 2);
    }
}

static void clip_ears(clast_polygon *polygon, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        polygon->next[i] = i + 1 < count ? i + 1 : 0;
        polygon->previous[i] = i > 0 ? i - 1 : count - 1;
    }
    uint32_t at = 0;
    uint32_t left = count;
    uint32_t tried = 0;
    uint32_t triangle = 0;
    while (left > 3) {
        // Where no corner is an ear the polygon crosses itself or is degenerate: any is cut off then.
        if (tried >= left || is_ear(polygon, at)) {
            emit(polygon, triangle++, polygon->previous[at], at, polygon->next[at]);
            polygon->next[polygon->previous[at]] = polygon->next[at];
            polygon->previous[polygon->next[at]] = polygon->previous[at];
            left--;
            tried = 0;
            at = polygon->next[polygon->next[at]]; // not the neighbour: strips rather than a fan of slivers
        } else {
            at = polygon->next[at];
            tried++;
        }
    }
    emit(polygon, triangle, polygon->previous[at], at, polygon->next[at]);
}

void clast_polygon_cut(clast_polygon *polygon, uint32_t count)
{
    find_normal(polygon, count);
    if (count == 3) {
        emit(polygon, 0, 0, 1, 2);
        return;
    }
    flatten(polygon, count);
    if (count == 4) {
        cut_quad(polygon);
    } else if (count > CLAST_POLYGON_CORNERS || is_convex(polygon, count)) {
        cut_fan(polygon, count);
    } else {
        clip_ears(polygon, count);
    }
}
