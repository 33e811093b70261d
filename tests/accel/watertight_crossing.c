// SPDX-License-Identifier: Apache-2.0
// Whether a ray crosses a closed surface near an edge, whatever a tracer rounds.
//
// Look along the ray: the surface is a plane of triangles, and the ray a point. A tracer that decides by shared edges sees
// each vertex moved by at most some `reach`, in a way that depends on the vertex and the ray alone; so it sees another closed
// surface with the same triangles. Take faces that hang together by edges that pass the point within `reach`: all other edges
// around them, their rim, pass farther away. The rim winds around the point some number of times, which does not change while
// no edge of it moves over the point; and where that number is not zero, the faces cover the point, however they are moved
// inside (a disk whose rim winds around a point cannot avoid it). So a ray around which a rim winds must hit, at a distance
// among those of these faces. This is decided in double precision: its errors, 2^-50 of the distances, are nothing beside
// `reach`, which is 2^-20 of them, and the rim is farther away than that; so the number is that of real numbers.
//
// Where that number is zero a surface may still be crossed, by less than `reach`: near a silhouette. Exact signs tell.
#include "accel/watertight.h"

#define ROUNDING 0x1p-24 // of a float
#define DISTANCE 0x1p-20 // times the largest distance to the surface's box: how far a tracer may move a vertex

enum { FACES_MOST = 4096, TABLE_SIZE = 4 * FACES_MOST };

placing placing_of(const float to_world[3][4])
{
    placing p;
    memcpy(p.to_world, to_world, sizeof p.to_world);
    double m[3][3], determinant = 0.0;
    for (int i = 0; i < 9; i++) {
        m[i / 3][i % 3] = (double)to_world[i / 3][i % 3];
    }
    for (int i = 0; i < 9; i++) {
        int row = i / 3, column = i % 3, r = (column + 1) % 3, s = (column + 2) % 3, c = (row + 1) % 3,
            d = (row + 2) % 3;
        p.to_object[row][column] = m[r][c] * m[s][d] - m[r][d] * m[s][c];
    }
    for (int k = 0; k < 3; k++) {
        determinant += m[0][k] * p.to_object[k][0];
    }
    for (int i = 0; i < 9; i++) {
        p.to_object[i / 3][i % 3] /= determinant;
    }
    return p;
}

// How the ray sees points: two axes across it, and t.
typedef struct view {
    double origin[3];
    double shear[2], along; // of the axes after the direction's largest; one over its largest component
    uint32_t axis;
    double reach;   // across
    double t_reach; // along
} view;

typedef struct seen {
    double x, y, t;
} seen;

static bool is_identity(const placing *p)
{
    static const float identity[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    return memcmp(p->to_world, identity, sizeof identity) == 0;
}

static view view_of(const surface *s, const placing *p, const clast_ray *ray)
{
    view v = {.axis = 0};
    double direction[3] = {0}, largest = 0.0, distance = 0.0, origin_error = 0.0, direction_error = 0.0;
    for (int i = 0; i < 3; i++) {
        double origin_sum = 0.0, direction_sum = 0.0;
        for (int k = 0; k < 3; k++) {
            double from = (double)ray->origin[k] - (double)p->to_world[k][3];
            v.origin[i] += p->to_object[i][k] * from;
            direction[i] += p->to_object[i][k] * (double)ray->direction[k];
            origin_sum += fabs(p->to_object[i][k] * from);
            direction_sum += fabs(p->to_object[i][k] * (double)ray->direction[k]);
        }
        origin_error = fmax(origin_error, origin_sum);
        direction_error = fmax(direction_error, direction_sum);
        if (fabs(direction[i]) > largest) {
            largest = fabs(direction[i]);
            v.axis = (uint32_t)i;
        }
        distance = fmax(distance, fabs(v.origin[i] - s->centre[i]) + s->radius);
    }
    v.along = 1.0 / direction[v.axis];
    v.shear[0] = direction[(v.axis + 1) % 3] * v.along;
    v.shear[1] = direction[(v.axis + 2) % 3] * v.along;
    v.reach = distance * DISTANCE;
    if (!is_identity(
            p)) { // the ray's way to the object: six roundings a component, of which the shear keeps two thirds
        v.reach += 16.0 * ROUNDING * (origin_error + direction_error * fabs(v.along) * distance);
    }
    v.t_reach = 4.0 * v.reach * fabs(v.along);
    return v;
}

static seen see(const view *v, const float position[3])
{
    double to[3];
    for (int axis = 0; axis < 3; axis++) {
        to[axis] = (double)position[axis] - v->origin[axis];
    }
    double z = to[v->axis];
    return (seen){to[(v->axis + 1) % 3] - v->shear[0] * z, to[(v->axis + 2) % 3] - v->shear[1] * z, z * v->along};
}

static double edge_distance(seen a, seen b)
{
    double x = b.x - a.x, y = b.y - a.y, square = x * x + y * y;
    double place = square > 0.0 ? -(a.x * x + a.y * y) / square : 0.0;
    place = place < 0.0 ? 0.0 : place > 1.0 ? 1.0 : place;
    return hypot(a.x + place * x, a.y + place * y);
}

// What an edge adds to the number of turns around the point: crossings of the half line y = 0, x > 0.
static int turns_of(seen a, seen b)
{
    double area = a.x * b.y - a.y * b.x;
    return a.y <= 0.0 && b.y > 0.0 && area > 0.0 ? 1 : a.y > 0.0 && b.y <= 0.0 && area < 0.0 ? -1 : 0;
}

typedef struct search {
    const surface *s;
    view v;
    uint32_t table[TABLE_SIZE]; // faces seen, plus one
    uint32_t stack[FACES_MOST], seen_faces[FACES_MOST];
    uint32_t height, count;
} search;

static bool visit(search *w, uint32_t face)
{
    uint32_t slot = face * 2654435761u % TABLE_SIZE;
    for (; w->table[slot] != 0; slot = (slot + 1) % TABLE_SIZE) {
        if (w->table[slot] == face + 1) {
            return false;
        }
    }
    if (w->count == FACES_MOST) {
        return false;
    }
    w->table[slot] = face + 1;
    w->seen_faces[w->count++] = face;
    w->stack[w->height++] = face;
    return true;
}

static const float *corner_of(const surface *s, uint32_t face, uint32_t corner)
{
    return s->m.positions + 3 * (size_t)s->m.indices[3 * (size_t)face + corner % 3];
}

static bool is_face(const surface *s, uint32_t face)
{
    return s->opposite[3 * (size_t)face] != CLAST_NONE;
}

typedef struct group {
    int turns; // of the rim around the ray
    double nearest, farthest;
} group;

// The faces that hang together with those on the stack.
static group wind(search *w)
{
    group g = {0, INFINITY, -INFINITY};
    while (w->height > 0) {
        uint32_t face = w->stack[--w->height];
        seen v[3];
        for (uint32_t k = 0; k < 3; k++) {
            v[k] = see(&w->v, corner_of(w->s, face, k));
            g.nearest = fmin(g.nearest, v[k].t);
            g.farthest = fmax(g.farthest, v[k].t);
        }
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t other = w->s->opposite[3 * (size_t)face + k] / 3;
            if (edge_distance(v[k], v[(k + 1) % 3]) > w->v.reach) {
                g.turns += turns_of(v[k], v[(k + 1) % 3]);
            } else {
                visit(w, other);
            }
        }
    }
    return g;
}

// Whether the ray's line meets a face, its edges and corners included, in real numbers.
static bool meets_exactly(const surface *s, const placing *p, const clast_ray *ray, const view *v, uint32_t face)
{
    int least = 1, most = -1;
    for (uint32_t k = 0; k < 3; k++) {
        const float *a = corner_of(s, face, k), *b = corner_of(s, face, k + 1);
        int sign;
        if (is_identity(p)) {
            sign = exact_side(ray->origin, ray->direction, a, b);
        } else {
            seen one = see(v, a), two = see(v, b);
            double area = one.x * two.y - one.y * two.x;
            sign = (area > 0.0) - (area < 0.0);
        }
        least = sign < least ? sign : least;
        most = sign > most ? sign : most;
    }
    return (least >= 0 || most <= 0) && least != most;
}

crossing surface_crossing(const surface *s, const placing *p, const clast_ray *ray, uint32_t half_edge,
                          double *farthest)
{
    static _Thread_local search w;
    w.s = s;
    w.v = view_of(s, p, ray);
    w.count = w.height = 0;
    memset(w.table, 0, sizeof w.table);
    const uint32_t *corners = s->m.indices + 3 * (size_t)(half_edge / 3);
    for (uint32_t end = 0; end < 2; end++) {
        uint32_t vertex = corners[(half_edge % 3 + end) % 3];
        for (uint32_t i = s->first_faces[vertex]; i < s->first_faces[vertex + 1]; i++) {
            if (!is_face(s, s->faces[i]) || !visit(&w, s->faces[i])) {
                continue;
            }
            group g = wind(&w);
            if (w.count == FACES_MOST) {
                return CROSSING_RIM; // too many faces for what rounding may do
            }
            if (g.turns != 0 && g.nearest > w.v.t_reach) { // in front of the origin
                *farthest = g.farthest + w.v.t_reach;
                return CROSSING_SURE;
            }
        }
    }
    for (uint32_t i = 0; i < w.count; i++) {
        if (meets_exactly(s, p, ray, &w.v, w.seen_faces[i])) {
            return CROSSING_RIM;
        }
    }
    return CROSSING_NONE;
}
