// SPDX-License-Identifier: Apache-2.0
// Rays at edges: through their ends, their middles, between, and beside them by one unit in the last place.
#include "accel/watertight.h"

static float nudge(float x, randoms *r)
{
    uint32_t way = random_below(r, 3);
    return way == 0 ? x : nextafterf(x, way == 1 ? INFINITY : -INFINITY);
}

static void nudge3(float v[3], randoms *r)
{
    for (int axis = 0; axis < 3; axis++) {
        v[axis] = nudge(v[axis], r);
    }
}

static uint32_t random_half_edge(const surface *s, randoms *r)
{
    uint32_t edge = random_below(r, 3 * s->m.triangle_count);
    while (s->opposite[edge] == CLAST_NONE) {
        edge = (edge + 1) % (3 * s->m.triangle_count);
    }
    return edge;
}

// An end of the edge, its middle, or a point between; where those are, or next to it.
static void edge_point(const surface *s, uint32_t edge, randoms *r, float point[3])
{
    const float *a = s->m.positions + 3 * (size_t)s->m.indices[edge];
    const float *b = s->m.positions + 3 * (size_t)s->m.indices[edge % 3 == 2 ? edge - 2 : edge + 1];
    const float places[4] = {0.0f, 0.5f, 1.0f, random_float(r)};
    float t = places[random_below(r, 4)];
    uint32_t nudged = random_below(r, 4);
    t = nudged == 0 ? nudge(t, r) : t;
    for (int axis = 0; axis < 3; axis++) {
        point[axis] = t == 1.0f ? b[axis] : a[axis] + t * (b[axis] - a[axis]);
    }
    if (nudged == 1) {
        nudge3(point, r);
    }
}

// A point inside; with coordinates of the point that is aimed at, so that the ray keeps to a plane or line of the grid,
// where that is inside too.
static void inside_point(const surface *s, const float at[3], randoms *r, float point[3])
{
    const inner_ball *ball = &s->balls[random_below(r, 2) == 0 ? 0 : random_below(r, s->ball_count)];
    float half = (float)(0.55 * ball->radius); // a cube's corner is 1.73 away
    uint32_t keep = random_below(r, 8);
    float aligned[3];
    double square = 0.0;
    for (uint32_t axis = 0; axis < 3; axis++) {
        point[axis] = (float)ball->centre[axis] + random_between(r, -half, half);
        aligned[axis] = (keep >> axis & 1) != 0 ? at[axis] : point[axis];
        square += ((double)aligned[axis] - ball->centre[axis]) * ((double)aligned[axis] - ball->centre[axis]);
    }
    if (keep != 7 && square < 0.9 * ball->radius * ball->radius) {
        memcpy(point, aligned, sizeof aligned);
    }
}

// A point outside the ball around all, up to 1e5 times its size away.
static void outside_point(const surface *s, const float at[3], randoms *r, float point[3])
{
    double distance = s->radius * (double)exp2f(random_between(r, 0.5f, 16.6f)), way[3], square = 0.0;
    if (random_below(r, 4) == 0) { // along an axis
        uint32_t axis = random_below(r, 3);
        memcpy(point, at, 12);
        point[axis] = (float)(s->centre[axis] + (random_below(r, 2) == 0 ? distance : -distance));
        return;
    }
    for (int axis = 0; axis < 3; axis++) {
        way[axis] = (double)random_between(r, -1, 1) + 1e-3;
        square += way[axis] * way[axis];
    }
    for (int axis = 0; axis < 3; axis++) {
        point[axis] = (float)(s->centre[axis] + way[axis] * distance / sqrt(square));
    }
}

static void to_world(const float map[3][4], const float p[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = (float)((double)map[i][0] * (double)p[0] + (double)map[i][1] * (double)p[1] +
                         (double)map[i][2] * (double)p[2] + (double)map[i][3]);
    }
}

// From one origin, through a point of an edge or next to it.
static shot aim_from(const placing *p, randoms *r, uint32_t edge, const float at[3], const float from[3])
{
    float target[3];
    shot a = {.half_edge = edge, .ray.t_max = INFINITY};
    to_world(p->to_world, at, target);
    to_world(p->to_world, from, a.ray.origin);
    for (int axis = 0; axis < 3; axis++) {
        a.ray.direction[axis] = target[axis] - a.ray.origin[axis];
    }
    if (random_below(r, 2) == 0) {
        nudge3(a.ray.direction, r);
    }
    return a;
}

// Another edge of the same face or of one beside it.
static uint32_t next_edge(const surface *s, uint32_t edge, randoms *r)
{
    uint32_t turned = edge / 3 * 3 + (edge + 1 + random_below(r, 2)) % 3;
    return random_below(r, 2) == 0 ? turned : s->opposite[turned];
}

void aim(const surface *s, const placing *p, randoms *r, shot *shots, size_t count)
{
    bool is_inside = random_below(r, 3) != 0;
    uint32_t edge = random_half_edge(s, r);
    float at[3], from[3];
    edge_point(s, edge, r, at);
    if (is_inside) {
        inside_point(s, at, r, from);
    } else {
        outside_point(s, at, r, from);
    }
    for (size_t i = 0; i < count; i++) {
        shots[i] = aim_from(p, r, edge, at, from);
        shots[i].is_inside = is_inside;
        edge = next_edge(s, edge, r);
        edge_point(s, edge, r, at);
    }
}
