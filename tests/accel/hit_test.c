// SPDX-License-Identifier: Apache-2.0
// A hit lies on its triangle, within the bounds that clast/accel.h states.
//
// Why they hold. Let e = 2^-24, M as there, d the direction with its largest component d_z, and L the longest edge. Seen along
// the ray, a vertex is x = v_x - s v_z with v counted from the origin and |s| <= 1: it is off by e M for the difference, and as
// much for each of the shear's quotient, product, and the difference below it; the last, of 2 M, counts twice: 6 e M. So the
// ray's line passes the triangle within 6 sqrt(2) e M < 2^-20 M, for the signs that decide are those of real numbers.
//
// The weights are differences of rounded products of coordinates. The ray is inside, so these are at most l = sqrt(3) L in
// size, and a weight is off by at most 3 e l^2. Over their sum, which is the triangle's doubled area A seen along the ray or
// more, this moves the point of the weights, across the ray, by 3 * 3 e l^2 * l / A = 47 e L^3 / A; and it cannot leave the
// triangle, as weights have one sign. The distance is a mean of the corners' by these same weights, off by 11 e M at most.
// Both together: less than 2^-19 M + 2^-17 L^3 / A. Of A almost nothing may be left where a triangle is seen edge on; but
// then, too, the point of the weights is one of the triangle, the ray passes the triangle within 2^-20 M, and the two are no
// farther apart than the triangle is large, and so less than 2^-19 M + 4 L.
#include "test.h"

#include "accel/meshes.h"

#define LINE_BOUND 0x1p-20
#define REACH_BOUND 0x1p-19
#define SLIVER_BOUND 0x1p-17

typedef struct vector {
    double v[3];
} vector;

static vector vector_of(const float p[3])
{
    return (vector){{(double)p[0], (double)p[1], (double)p[2]}};
}

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

static double length(vector a)
{
    return sqrt(dot(a, a));
}

// Between a line through the origin and an edge, across the line, where the line does not pass between.
static double line_to_edge(vector unit, vector a, vector b)
{
    vector p = along(a, -dot(a, unit), unit), q = along(b, -dot(b, unit), unit), edge = minus(q, p);
    double square = dot(edge, edge), place = square > 0.0 ? -dot(p, edge) / square : 0.0;
    place = place < 0.0 ? 0.0 : place > 1.0 ? 1.0 : place;
    return length(along(p, place, edge));
}

static double line_to_triangle(vector unit, const vector corners[3])
{
    double sides[3], least = INFINITY;
    for (int k = 0; k < 3; k++) {
        sides[k] = dot(unit, cross(corners[k], corners[(k + 1) % 3]));
        least = fmin(least, line_to_edge(unit, corners[k], corners[(k + 1) % 3]));
    }
    bool passes = (sides[0] >= 0.0 && sides[1] >= 0.0 && sides[2] >= 0.0) ||
                  (sides[0] <= 0.0 && sides[1] <= 0.0 && sides[2] <= 0.0);
    return passes ? 0.0 : least;
}

typedef struct worst {
    double line, point; // the largest part of its bound that a hit took
    uint32_t hits;
} worst;

static void check_hit(const mesh *m, uint32_t triangle, const clast_ray *ray, const clast_hit *hit, double reach,
                      worst *w)
{
    vector origin = vector_of(ray->origin), direction = vector_of(ray->direction), corners[3];
    double longest = 0.0;
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = minus(vector_of(m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + k]), origin);
    }
    vector e1 = minus(corners[1], corners[0]), e2 = minus(corners[2], corners[0]);
    longest = fmax(length(e1), fmax(length(e2), length(minus(e2, e1))));
    vector unit = along((vector){{0}}, 1.0 / length(direction), direction);
    double area = fabs(dot(unit, cross(e1, e2)));
    vector weighted = along(along(corners[0], (double)hit->u, e1), (double)hit->v, e2);
    double apart = length(minus(along((vector){{0}}, (double)hit->t, direction), weighted));
    double sliver = fmin(SLIVER_BOUND * longest * longest * longest / area, 4.0 * longest);
    assert_true(hit->u >= 0.0f && hit->v >= 0.0f && (double)hit->u + (double)hit->v <= 1.0 + 0x1p-22);
    w->line = fmax(w->line, line_to_triangle(unit, corners) / (LINE_BOUND * reach));
    w->point = fmax(w->point, apart / (REACH_BOUND * reach + sliver));
    w->hits++;
}

static double reach_of(const clast_blas *blas, const float origin[3])
{
    float lower[3], upper[3];
    double reach = 0.0;
    clast_blas_bounds(blas, lower, upper);
    for (int axis = 0; axis < 3; axis++) {
        reach = fmax(reach, fabs((double)lower[axis] - (double)origin[axis]));
        reach = fmax(reach, fabs((double)upper[axis] - (double)origin[axis]));
    }
    return reach;
}

// From near and far, at points in or on the rim of triangles, next to them, or along them.
static clast_ray ray_at(const mesh *m, randoms *r)
{
    const uint32_t *v = m->indices + 3 * (size_t)random_below(r, m->triangle_count);
    float weights[3] = {random_float(r), random_float(r), random_float(r)}, sum = 0.0f;
    uint32_t zero = random_below(r, 6);
    clast_ray ray = {.t_max = INFINITY};
    for (uint32_t k = 0; k < 3; k++) {
        weights[k] = k == zero ? 0.0f : weights[k];
        sum += weights[k];
    }
    float distance = exp2f(random_between(r, -3.0f, random_below(r, 2) == 0 ? 3.0f : 14.0f));
    uint32_t kind = random_below(r, 3);
    for (int axis = 0; axis < 3; axis++) {
        float at = 0.0f, edge = m->positions[3 * v[1] + (uint32_t)axis] - m->positions[3 * v[0] + (uint32_t)axis];
        for (uint32_t k = 0; k < 3; k++) {
            at += weights[k] / sum * m->positions[3 * v[k] + (uint32_t)axis];
        }
        float way = random_between(r, -1, 1); // or almost in the triangle's plane
        way = kind == 0 ? edge + 1e-6f * way : kind == 1 ? edge + 1e-3f * way : way;
        ray.origin[axis] = at - distance * way;
        ray.direction[axis] = way;
        if (random_below(r, 8) == 0) {
            ray.direction[axis] = at - ray.origin[axis];
        }
    }
    return ray;
}

static void hits_lie_on_triangles(clast_context *context, mesh m, uint32_t rays)
{
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, &m, 128, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {5};
    worst w = {0};
    for (uint32_t i = 0; i < rays; i++) {
        clast_ray ray = ray_at(&m, &r);
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        if (hit.instance == 0) {
            check_hit(&m, c.first_triangles[hit.cluster] + hit.triangle, &ray, &hit, reach_of(c.blas, ray.origin), &w);
        }
    }
    printf("%u hits; %.3f of the bound for lines, %.3f of that for points\n", w.hits, w.line, w.point);
    assert_true(w.hits > rays / 5);
    assert_true(w.line <= 1.0);
    assert_true(w.point <= 1.0);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    mesh_free(&m);
}

static void hits_lie_on_triangles_of_a_soup(void **state)
{
    hits_lie_on_triangles(*state, mesh_soup(2000, 0.2f, 1), 20000);
}

static void hits_lie_on_large_triangles(void **state)
{
    hits_lie_on_triangles(*state, mesh_soup(20, 1.0f, 2), 20000);
}

static void hits_lie_on_the_triangles_of_a_closed_mesh(void **state)
{
    mesh m = mesh_octasphere(4);
    mesh_displace(&m, 0.2f, 3);
    hits_lie_on_triangles(*state, m, 20000);
}

// Long, and as thin as floats can make them.
static void hits_lie_on_slivers(void **state)
{
    mesh m = mesh_soup(1000, 0.5f, 4);
    randoms r = {6};
    for (uint32_t i = 0; i < m.triangle_count; i++) {
        float *p = m.positions + 9 * (size_t)i, thin = exp2f(random_between(&r, -24, -5));
        float place = random_float(&r);
        for (int axis = 0; axis < 3; axis++) {
            p[6 + axis] = p[axis] + place * (p[3 + axis] - p[axis]) + thin * random_between(&r, -1, 1);
        }
    }
    hits_lie_on_triangles(*state, m, 40000);
}

// In the plane z = 0.3 x + 0.1: seen along it, triangles are lines.
static void hits_lie_on_the_triangles_of_a_plane_seen_edge_on(void **state)
{
    mesh m = mesh_terrain(16, 0.0f, 1);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        m.positions[3 * i + 2] = 0.3f * m.positions[3 * i] + 0.1f;
    }
    hits_lie_on_triangles(*state, m, 20000);
}

// Small ones far from the middle, where floats have few steps left.
static void hits_lie_on_triangles_far_away(void **state)
{
    mesh m = mesh_soup(500, 0.2f, 7);
    mesh_transform(&m, 1.0f, 3000.0f, -70000.0f, 12.0f);
    hits_lie_on_triangles(*state, m, 20000);
}

// The largest row sum of |m| |m^-1|.
static double condition_of(const float map[3][4])
{
    double inverse[3][3], determinant = 0.0, most = 0.0;
    for (int i = 0; i < 9; i++) {
        int r = (i % 3 + 1) % 3, s = (i % 3 + 2) % 3, c = (i / 3 + 1) % 3, d = (i / 3 + 2) % 3;
        inverse[i / 3][i % 3] = (double)map[r][c] * (double)map[s][d] - (double)map[r][d] * (double)map[s][c];
    }
    for (int k = 0; k < 3; k++) {
        determinant += (double)map[0][k] * inverse[k][0];
    }
    for (int i = 0; i < 3; i++) {
        double sum = 0.0;
        for (int k = 0; k < 9; k++) {
            sum += fabs((double)map[i][k / 3]) * fabs(inverse[k / 3][k % 3] / determinant);
        }
        most = fmax(most, sum);
    }
    return most;
}

static mesh placed(const mesh *m, const float map[3][4])
{
    mesh world = mesh_of(m->vertex_count, m->triangle_count);
    memcpy(world.indices, m->indices, 12 * (size_t)m->triangle_count);
    for (uint32_t i = 0; i < 3 * m->vertex_count; i++) {
        const float *p = m->positions + 3 * (size_t)(i / 3), *row = map[i % 3];
        world.positions[i] = (float)((double)row[0] * (double)p[0] + (double)row[1] * (double)p[1] +
                                     (double)row[2] * (double)p[2] + (double)row[3]);
    }
    return world;
}

// The bounds of the world's boxes: 2^-17 times the condition, of the distance and of the object's size.
static void hits_lie_on_transformed_triangles(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_soup(500, 0.2f, 8);
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, &m, 128, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    randoms r = {9};
    worst w = {0};
    for (uint32_t turn = 0; turn < 25; turn++) {
        clast_tlas_instance instance = instance_of(c.blas, 0);
        for (uint32_t k = 0; k < 12; k++) {
            float most = k % 4 == 3 ? (turn % 3 == 0 ? 100.0f : 1.0f) : 1.5f;
            instance.transform[k / 4][k % 4] += random_between(&r, -most, most);
        }
        double condition = condition_of((const float(*)[4])instance.transform);
        if (condition > 1e3) {
            continue;
        }
        mesh world = placed(&m, (const float(*)[4])instance.transform);
        assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
        for (uint32_t i = 0; i < 2000; i++) {
            clast_ray ray = ray_at(&world, &r);
            clast_hit hit;
            clast_trace_closest(tlas, &ray, 1, NULL, &hit);
            if (hit.instance == 0) {
                uint32_t triangle = c.first_triangles[hit.cluster] + hit.triangle;
                const float *p = world.positions + 3 * (size_t)world.indices[3 * triangle];
                double reach = 10.0;
                for (int axis = 0; axis < 3; axis++) { // the instance is not larger than ten
                    reach = fmax(reach, 10.0 + fabs((double)p[axis] - (double)ray.origin[axis]));
                    reach = fmax(reach, fabs((double)ray.origin[axis] - (double)instance.transform[axis][3]));
                }
                check_hit(&world, triangle, &ray, &hit, 8.0 * condition * reach, &w);
            }
        }
        mesh_free(&world);
    }
    printf("%u hits; %.3f of the bound for lines, %.3f of that for points\n", w.hits, w.line, w.point);
    assert_true(w.hits > 5000);
    assert_true(w.line <= 1.0);
    assert_true(w.point <= 1.0);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(hits_lie_on_triangles_of_a_soup),
        CONTEXT_TEST(hits_lie_on_large_triangles),
        CONTEXT_TEST(hits_lie_on_the_triangles_of_a_closed_mesh),
        CONTEXT_TEST(hits_lie_on_slivers),
        CONTEXT_TEST(hits_lie_on_the_triangles_of_a_plane_seen_edge_on),
        CONTEXT_TEST(hits_lie_on_triangles_far_away),
        CONTEXT_TEST(hits_lie_on_transformed_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
