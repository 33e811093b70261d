// SPDX-License-Identifier: Apache-2.0
// Closed surfaces: whether they are closed, and what lies inside.
#include <stdio.h>

#include "accel/watertight.h"
#include "clast/geometry.h"

// ------------------------------------------------------------------------------------------------------------- edges

static bool weld(clast_context *context, mesh *m)
{
    uint32_t *numbers = malloc(4 * (size_t)m->vertex_count + 4);
    size_t unique = 0;
    bool done = clast_weld_positions(context, m->positions, m->vertex_count, numbers, &unique) == CLAST_OK;
    for (size_t i = 0; done && i < 3 * (size_t)m->triangle_count; i++) {
        m->indices[i] = numbers[m->indices[i]];
    }
    free(numbers);
    return done;
}

static void list_faces(surface *s)
{
    const mesh *m = &s->m;
    s->first_faces = calloc((size_t)m->vertex_count + 2, 4);
    s->faces = malloc(12 * (size_t)m->triangle_count + 4);
    uint32_t *ends = s->first_faces + 1;
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        ends[m->indices[i]]++;
    }
    for (uint32_t i = 0, sum = 0; i < m->vertex_count; i++) {
        uint32_t count = ends[i];
        ends[i] = sum; // where the vertex begins, for now; where it ends, when all are listed
        sum += count;
    }
    for (size_t i = 0; i < 3 * (size_t)m->triangle_count; i++) {
        s->faces[ends[m->indices[i]]++] = (uint32_t)(i / 3);
    }
}

static bool is_surface(const mesh *m, uint32_t triangle)
{
    const uint32_t *v = m->indices + 3 * (size_t)triangle;
    return v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
}

// The half edge from `from` to `to`, where there is exactly one; else CLAST_NONE.
static uint32_t half_edge_between(const surface *s, uint32_t from, uint32_t to)
{
    uint32_t found = CLAST_NONE;
    for (uint32_t i = s->first_faces[from]; i < s->first_faces[from + 1]; i++) {
        const uint32_t *v = s->m.indices + 3 * (size_t)s->faces[i];
        for (uint32_t k = 0; k < 3 && is_surface(&s->m, s->faces[i]); k++) {
            if (v[k] == from && v[(k + 1) % 3] == to) {
                if (found != CLAST_NONE) {
                    return CLAST_NONE;
                }
                found = 3 * s->faces[i] + k;
            }
        }
    }
    return found;
}

static uint32_t pair_edges(surface *s)
{
    uint32_t open = 0;
    s->opposite = malloc(12 * (size_t)s->m.triangle_count + 4);
    for (uint32_t i = 0; i < 3 * s->m.triangle_count; i++) {
        uint32_t from = s->m.indices[i], to = s->m.indices[i % 3 == 2 ? i - 2 : i + 1];
        s->opposite[i] = CLAST_NONE;
        if (is_surface(&s->m, i / 3)) {
            s->opposite[i] = half_edge_between(s, to, from);
            open += s->opposite[i] == CLAST_NONE || half_edge_between(s, from, to) != i;
        }
    }
    return open;
}

static void find_ball(surface *s)
{
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY}, square = 0.0;
    for (size_t i = 0; i < 3 * (size_t)s->m.triangle_count; i++) {
        const float *p = s->m.positions + 3 * (size_t)s->m.indices[i];
        for (int axis = 0; axis < 3; axis++) {
            lower[axis] = fmin(lower[axis], (double)p[axis]);
            upper[axis] = fmax(upper[axis], (double)p[axis]);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        s->centre[axis] = (lower[axis] + upper[axis]) / 2.0;
        square += (upper[axis] - lower[axis]) * (upper[axis] - lower[axis]) / 4.0;
    }
    s->radius = sqrt(square);
}

uint32_t surface_make(clast_context *context, const char *name, const mesh *m, surface *s)
{
    *s = (surface){.m = *m};
    snprintf(s->name, sizeof s->name, "%s", name);
    if (m->triangle_count == 0 || !weld(context, &s->m)) {
        return 1;
    }
    list_faces(s);
    find_ball(s);
    return pair_edges(s);
}

void surface_free(surface *s)
{
    mesh_free(&s->m);
    free(s->opposite);
    free(s->first_faces);
    free(s->faces);
}

static void *copy_of(const void *data, size_t bytes)
{
    void *copy = malloc(bytes + 4);
    memcpy(copy, data, bytes);
    return copy;
}

surface surface_scaled(const surface *s, float size)
{
    surface scaled = *s;
    scaled.m = mesh_of(s->m.vertex_count, s->m.triangle_count);
    memcpy(scaled.m.positions, s->m.positions, 12 * (size_t)s->m.vertex_count);
    memcpy(scaled.m.indices, s->m.indices, 12 * (size_t)s->m.triangle_count);
    mesh_transform(&scaled.m, size, 0, 0, 0);
    scaled.opposite = copy_of(s->opposite, 12 * (size_t)s->m.triangle_count);
    scaled.first_faces = copy_of(s->first_faces, 4 * (size_t)s->m.vertex_count + 4);
    scaled.faces = copy_of(s->faces, 12 * (size_t)s->m.triangle_count);
    find_ball(&scaled);
    for (uint32_t i = 0; i < s->ball_count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            scaled.balls[i].centre[axis] *= (double)size;
        }
        scaled.balls[i].radius *= (double)size;
    }
    return scaled;
}

// ------------------------------------------------------------------------------------------------------------ vectors

typedef struct vector {
    double v[3];
} vector;

static vector minus(vector a, vector b)
{
    return (vector){{a.v[0] - b.v[0], a.v[1] - b.v[1], a.v[2] - b.v[2]}};
}

static vector along(vector from, double t, vector direction)
{
    return (vector){{from.v[0] + t * direction.v[0], from.v[1] + t * direction.v[1], from.v[2] + t * direction.v[2]}};
}

static double dot(vector a, vector b)
{
    return a.v[0] * b.v[0] + a.v[1] * b.v[1] + a.v[2] * b.v[2];
}

static vector cross(vector a, vector b)
{
    return (vector){
        {a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2], a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

static vector corner_at(const surface *s, uint32_t triangle, uint32_t corner)
{
    const float *p = s->m.positions + 3 * (size_t)s->m.indices[3 * (size_t)triangle + corner];
    return (vector){{(double)p[0], (double)p[1], (double)p[2]}};
}

// ------------------------------------------------------------------------------------------------------------- inside

// How often the surface winds around a point, counted along a ray; false where it passes too near to an edge to be sure.
// `nearest` is the least distance of a crossing, times the direction's length.
static bool winding_at(const surface *s, vector from, vector direction, int *winding, double *nearest)
{
    *winding = 0;
    *nearest = INFINITY;
    for (uint32_t i = 0; i < s->m.triangle_count; i++) {
        vector a = minus(corner_at(s, i, 0), from), b = minus(corner_at(s, i, 1), from);
        vector c = minus(corner_at(s, i, 2), from);
        double sides[3] = {dot(direction, cross(a, b)), dot(direction, cross(b, c)), dot(direction, cross(c, a))};
        double sure = 1e-12 * s->radius * s->radius * sqrt(dot(direction, direction));
        bool positive = sides[0] > sure && sides[1] > sure && sides[2] > sure;
        bool negative = sides[0] < -sure && sides[1] < -sure && sides[2] < -sure;
        if (positive || negative) {
            double t = dot(a, cross(minus(b, a), minus(c, a))) / (sides[0] + sides[1] + sides[2]);
            if (fabs(t) < 1e-9) {
                return false;
            }
            if (t > 0.0) {
                *winding += positive ? 1 : -1;
                *nearest = fmin(*nearest, t);
            }
        } else if (fmin(sides[0], fmin(sides[1], sides[2])) > -sure ||
                   fmax(sides[0], fmax(sides[1], sides[2])) < sure) {
            if (is_surface(&s->m, i)) {
                return false;
            }
        }
    }
    return true;
}

// The squared distance from the origin to the triangle (Ericson, Real-Time Collision Detection, 5.1.5).
static double square_distance(vector a, vector b, vector c)
{
    vector ab = minus(b, a), ac = minus(c, a), bc = minus(c, b);
    double d1 = -dot(ab, a), d2 = -dot(ac, a), d3 = -dot(ab, b), d4 = -dot(ac, b), d5 = -dot(ab, c), d6 = -dot(ac, c);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    vector nearest;
    if (d1 <= 0.0 && d2 <= 0.0) {
        nearest = a;
    } else if (d3 >= 0.0 && d4 <= d3) {
        nearest = b;
    } else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) {
        nearest = along(a, d1 / (d1 - d3), ab);
    } else if (d6 >= 0.0 && d5 <= d6) {
        nearest = c;
    } else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) {
        nearest = along(a, d2 / (d2 - d6), ac);
    } else if (va <= 0.0 && d4 >= d3 && d5 >= d6) {
        nearest = along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), bc);
    } else {
        double sum = va + vb + vc;
        nearest = along(along(a, vb / sum, ab), vc / sum, ac);
    }
    return dot(nearest, nearest);
}

static double distance_to(const surface *s, vector from)
{
    double least = INFINITY;
    for (uint32_t i = 0; i < s->m.triangle_count; i++) {
        double square = square_distance(minus(corner_at(s, i, 0), from), minus(corner_at(s, i, 1), from),
                                        minus(corner_at(s, i, 2), from));
        least = square < least ? square : least;
    }
    return sqrt(least);
}

// From the middle of a face into the depth, on either side, half way or less to the next one.
static bool find_ball_behind(const surface *s, uint32_t triangle, randoms *r, inner_ball *ball)
{
    vector a = corner_at(s, triangle, 0), b = corner_at(s, triangle, 1), c = corner_at(s, triangle, 2);
    vector normal = cross(minus(b, a), minus(c, a)), middle = along(along(a, 0.31, minus(b, a)), 0.37, minus(c, a));
    double length = sqrt(dot(normal, normal)), depth = 0.0;
    if (!(length > 0.0)) {
        return false;
    }
    normal = along((vector){{0}}, (random_bits(r) % 2 == 0 ? 1.0 : -1.0) / length, normal);
    vector start = along(middle, 1e-4 * s->radius, normal);
    int winding = 0;
    if (!winding_at(s, start, normal, &winding, &depth) || winding == 0 || !isfinite(depth)) {
        return false;
    }
    vector centre = along(start, depth * (0.2 + 0.3 * (double)random_float(r)), normal);
    vector way = {
        {(double)random_between(r, -1, 1), (double)random_between(r, -1, 1), (double)random_between(r, -1, 1)}};
    if (!winding_at(s, centre, way, &winding, &depth) || winding == 0) {
        return false;
    }
    memcpy(ball->centre, centre.v, sizeof ball->centre);
    ball->radius = 0.8 * distance_to(s, centre);
    return ball->radius > 1e-3 * s->radius;
}

bool surface_find_inside(surface *s, uint64_t seed)
{
    randoms r = {seed};
    s->ball_count = 0;
    for (uint32_t tries = 0; tries < 400 && s->ball_count < WATERTIGHT_BALLS; tries++) {
        inner_ball ball;
        if (find_ball_behind(s, random_below(&r, s->m.triangle_count), &r, &ball)) {
            uint32_t place = s->ball_count++; // the largest first
            for (; place > 0 && s->balls[place - 1].radius < ball.radius; place--) {
                s->balls[place] = s->balls[place - 1];
            }
            s->balls[place] = ball;
        }
    }
    return s->ball_count > 0;
}

// --------------------------------------------------------------------------------------------------------------- a cube

// The number of a point of a cube's surface, by its lattice coordinates: the same from all sides that share it.
static uint32_t lattice_vertex(mesh *m, uint32_t *numbers, uint32_t segments, const uint32_t at[3])
{
    size_t side = (size_t)segments + 1;
    uint32_t *number = &numbers[(at[2] * side + at[1]) * side + at[0]];
    if (*number == 0) {
        float p[3], square = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            p[axis] = 2.0f * (float)at[axis] / (float)segments - 1.0f;
            square += p[axis] * p[axis];
        }
        for (int axis = 0; axis < 3; axis++) {
            m->positions[3 * (size_t)m->vertex_count + (size_t)axis] = p[axis] / sqrtf(square);
        }
        *number = ++m->vertex_count;
    }
    return *number - 1;
}

mesh mesh_cube_sphere(uint32_t segments)
{
    mesh m = mesh_of(6 * (segments + 1) * (segments + 1), 12 * segments * segments);
    uint32_t *numbers = calloc((size_t)(segments + 1) * (segments + 1) * (segments + 1), 4), *corner = m.indices;
    m.vertex_count = 0;
    for (uint32_t face = 0; face < 6; face++) {
        uint32_t axis = face / 2, across = (axis + 1 + face % 2) % 3, up = (axis + 2 - face % 2) % 3; // outwards
        for (uint32_t quad = 0; quad < segments * segments; quad++) {
            uint32_t corners[4];
            for (uint32_t k = 0; k < 4; k++) {
                uint32_t at[3];
                at[axis] = face % 2 == 0 ? segments : 0;
                at[across] = quad % segments + (k == 1 || k == 2);
                at[up] = quad / segments + (k >= 2);
                corners[k] = lattice_vertex(&m, numbers, segments, at);
            }
            mesh_quad(&corner, corners[0], corners[1], corners[2], corners[3]);
        }
    }
    free(numbers);
    return m;
}
