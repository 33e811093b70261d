// SPDX-License-Identifier: Apache-2.0
// What the program `watertight` decides by is right: exact signs, open edges, crossings, points inside; and a hole is found.
#include "test.h"

#include "accel/watertight.h"

typedef __int128 wide;

static int sign_in_integers(const float origin[3], const float direction[3], const float a[3], const float b[3])
{
    wide p[3], q[3], sum = 0;
    for (int i = 0; i < 3; i++) {
        p[i] = (wide)a[i] - (wide)origin[i];
        q[i] = (wide)b[i] - (wide)origin[i];
    }
    for (int i = 0; i < 3; i++) {
        sum += (wide)direction[i] * (p[(i + 1) % 3] * q[(i + 2) % 3] - p[(i + 2) % 3] * q[(i + 1) % 3]);
    }
    return (sum > 0) - (sum < 0);
}

static float random_whole(randoms *r, int32_t most)
{
    return (float)((int32_t)random_below(r, 2u * (uint32_t)most + 1u) - most);
}

static void exact_sides_are_those_of_integers(void **state)
{
    (void)state;
    randoms r = {1};
    uint32_t zeros = 0;
    for (uint32_t i = 0; i < 200000; i++) {
        float origin[3], direction[3], a[3], b[3];
        int32_t most = i % 2 == 0 ? 1 << 24 : 3;
        for (int axis = 0; axis < 3; axis++) {
            origin[axis] = random_whole(&r, most);
            a[axis] = random_whole(&r, most);
            b[axis] = random_whole(&r, most);
            direction[axis] = random_whole(&r, most);
            if (i % 5 == 0) { // in the plane of the edge, or next to it
                direction[axis] = a[axis] - origin[axis] + (random_below(&r, 8) == 0 ? 1.0f : 0.0f);
            }
        }
        int expected = sign_in_integers(origin, direction, a, b);
        zeros += expected == 0;
        assert_int_equal(exact_side(origin, direction, a, b), expected);
        assert_int_equal(exact_side(origin, direction, b, a), -expected);
    }
    assert_true(zeros > 1000);
}

// A difference of 2^-40 of 2^-40 decides, which no double of the sum shows.
static void exact_sides_see_what_rounding_hides(void **state)
{
    (void)state;
    const float origin[3] = {0, 0, 0}, direction[3] = {0, 0, 1};
    for (int e = -70; e < 0; e++) {
        float small = ldexpf(1.0f, e);
        const float a[3] = {1.0f, small, 1e20f}, b[3] = {1.0f, nextafterf(small, 1.0f), -1e-20f};
        assert_int_equal(exact_side(origin, direction, a, b), 1);
        assert_int_equal(exact_side(origin, direction, b, a), -1);
        assert_int_equal(exact_side(origin, direction, a, a), 0);
    }
}

static surface ball(clast_context *context, uint32_t levels)
{
    mesh m = mesh_octasphere(levels);
    surface s;
    assert_int_equal(surface_make(context, "ball", &m, &s), 0);
    assert_true(surface_find_inside(&s, 1));
    return s;
}

static void open_edges_are_counted(void **state)
{
    mesh m = mesh_octasphere(2);
    surface s;
    m.triangle_count--;
    assert_int_equal(surface_make(*state, "hole", &m, &s), 3);
    surface_free(&s);
    m = mesh_octasphere(2);
    uint32_t corner = m.indices[0];
    m.indices[0] = m.indices[1]; // one triangle turned over: along its edges, both run the same way
    m.indices[1] = corner;
    assert_int_not_equal(surface_make(*state, "turned", &m, &s), 0);
    surface_free(&s);
}

static void seams_of_doubled_vertices_are_closed(void **state)
{
    mesh m = mesh_octasphere(2), apart = mesh_of(3 * m.triangle_count, m.triangle_count);
    for (uint32_t i = 0; i < 3 * m.triangle_count; i++) {
        memcpy(apart.positions + 3 * (size_t)i, m.positions + 3 * (size_t)m.indices[i], 12);
        apart.indices[i] = i;
    }
    surface s;
    assert_int_equal(surface_make(*state, "apart", &apart, &s), 0);
    surface_free(&s);
    mesh_free(&m);
}

static void balls_inside_are_inside(void **state)
{
    surface s = ball(*state, 3);
    for (uint32_t i = 0; i < s.ball_count; i++) {
        const double *c = s.balls[i].centre;
        assert_true(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) + s.balls[i].radius < 1.0);
    }
    surface_free(&s);
}

static placing identity(void)
{
    const float map[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    return placing_of(map);
}

static void rays_from_inside_cross_for_certain(void **state)
{
    surface s = ball(*state, 3);
    placing p = identity();
    randoms r = {2};
    for (uint32_t i = 0; i < 20000; i++) {
        shot a;
        aim(&s, &p, &r, &a, 1);
        double farthest = 0.0;
        if (a.is_inside) {
            assert_int_equal(surface_crossing(&s, &p, &a.ray, a.half_edge, &farthest), CROSSING_SURE);
            assert_true(farthest > 0.9 && farthest < 3.0);
        }
    }
    surface_free(&s);
}

// The octahedron's tip at x = 1, and its rim in the plane x = 0.
static void silhouettes_are_told_from_crossings(void **state)
{
    surface s = ball(*state, 0);
    placing p = identity();
    double farthest;
    uint32_t edge = 0; // one that ends in the tip at y = 1
    while (s.m.positions[3 * s.m.indices[edge] + 1] != 1.0f) {
        edge++;
    }
    const struct {
        float y;
        crossing expected;
    } cases[] = {
        {0.9f, CROSSING_SURE}, {0.999f, CROSSING_SURE},          {1.0f - 0x1p-23f, CROSSING_RIM},
        {1.0f, CROSSING_RIM},  {1.0f + 0x1p-23f, CROSSING_NONE}, {1.001f, CROSSING_NONE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        clast_ray ray = {{0, cases[i].y, -2}, 0, {0, 0, 1}, INFINITY};
        assert_int_equal(surface_crossing(&s, &p, &ray, edge, &farthest), cases[i].expected);
        ray.direction[2] = -1.0f; // away
        assert_int_not_equal(surface_crossing(&s, &p, &ray, edge, &farthest), CROSSING_SURE);
    }
    surface_free(&s);
}

// A tracer without some of the triangles leaks, and by the same means that find no leaks elsewhere.
static void holes_are_found(void **state)
{
    clast_context *context = *state;
    surface s = ball(context, 3);
    placing p = identity();
    clusters c;
    clast_tlas *tlas;
    surface torn = surface_scaled(&s, 1.0f);
    torn.m.triangle_count -= 5;
    assert_ok(context, clusters_make(context, &torn, CLUSTERS_CUT, CLAST_BUILD_BEST, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {3};
    uint32_t leaks = 0, behind = 0;
    for (uint32_t i = 0; i < 50000; i++) {
        shot a;
        aim(&s, &p, &r, &a, 1);
        clast_hit hit;
        double farthest = INFINITY;
        clast_trace_closest(tlas, &a.ray, 1, NULL, &hit);
        bool sure = surface_crossing(&s, &p, &a.ray, a.half_edge, &farthest) == CROSSING_SURE;
        leaks += a.is_inside && hit.instance != 0;
        behind += !a.is_inside && sure && hit.instance == 0 && (double)hit.t > farthest;
    }
    assert_true(leaks > 20);
    assert_true(behind > 5);
    clast_tlas_destroy(tlas);
    clusters_free(&c);
    surface_free(&torn);
    surface_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_sides_are_those_of_integers),
        cmocka_unit_test(exact_sides_see_what_rounding_hides),
        CONTEXT_TEST(open_edges_are_counted),
        CONTEXT_TEST(seams_of_doubled_vertices_are_closed),
        CONTEXT_TEST(balls_inside_are_inside),
        CONTEXT_TEST(rays_from_inside_cross_for_certain),
        CONTEXT_TEST(silhouettes_are_told_from_crossings),
        CONTEXT_TEST(holes_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
