// SPDX-License-Identifier: Apache-2.0
// The edge functions' signs are those of real numbers.
#include "test.h"

#include "accel/meshes.h"
#include "shared/watertight.h"

// Products of floats are exact in double, and their comparison is.
static int true_sign(float a, float b, float c, float d)
{
    double ab = (double)a * (double)b, cd = (double)c * (double)d;
    return (ab > cd) - (ab < cd);
}

static void assert_sign(float a, float b, float c, float d)
{
    float value = signed_difference(a, b, c, d);
    assert_int_equal((value > 0.0f) - (value < 0.0f), true_sign(a, b, c, d));
    assert_true(signed_difference(c, d, a, b) == -value); // the other triangle sees the negative
    assert_true(signed_difference(b, a, d, c) == value);
}

static float nudged(float x, randoms *r)
{
    uint32_t way = random_below(r, 3);
    return way == 0 ? x : nextafterf(x, way == 1 ? INFINITY : -INFINITY);
}

static void signs_are_exact(void **state)
{
    (void)state;
    randoms r = {1};
    for (int i = 0; i < 1000000; i++) {
        int exponent = (int)random_below(&r, 80) - 40;
        float a = ldexpf(random_between(&r, -1, 1), exponent), b = ldexpf(random_between(&r, -1, 1), exponent);
        float scale = (float)(1 + random_below(&r, 100)) / (float)(1 + random_below(&r, 100));
        assert_sign(a, b, ldexpf(random_between(&r, -1, 1), exponent), ldexpf(random_between(&r, -1, 1), exponent));
        assert_sign(a, b, nudged(a * scale, &r), nudged(b / scale, &r)); // almost parallel
        assert_sign(a, b, b, a);
        assert_sign(a, b, nudged(b, &r), nudged(a, &r));
        assert_sign(a, 0.0f, b, ldexpf(random_float(&r), -40));
    }
}

static void a_vertex_does_not_depend_on_its_triangle(void **state)
{
    (void)state;
    randoms r = {2};
    for (int i = 0; i < 100000; i++) {
        vec3 direction = vec3(random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1));
        vec3 origin = vec3(random_between(&r, -9, 9), random_between(&r, -9, 9), random_between(&r, -9, 9));
        clast_watertight_ray ray = watertight_ray(origin, direction, 0x1p30f);
        vec3 v[4];
        for (int k = 0; k < 4; k++) {
            v[k] = watertight_vertex(
                ray, vec3(random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1)));
        }
        clast_watertight_edges first = watertight_edges(v[0], v[1], v[2]), second = watertight_edges(v[1], v[0], v[3]);
        assert_true(first.c == -second.c);
    }
}

static void triangles_that_are_no_numbers_are_not_passed(void **state)
{
    (void)state;
    const float broken[] = {NAN, INFINITY, -INFINITY};
    clast_watertight_ray ray = watertight_ray(vec3(0, 0, 0), vec3(0.1f, 0.2f, 1), 1.0f);
    for (int i = 0; i < 3; i++) {
        for (int corner = 0; corner < 3; corner++) {
            vec3 v[3] = {vec3(-1, -1, 2), vec3(3, -1, 2), vec3(0, 3, 2)};
            v[corner][0] = NAN;
            v[corner][1] = broken[i];
            clast_watertight_edges e = watertight_edges(watertight_vertex(ray, v[0]), watertight_vertex(ray, v[1]),
                                                        watertight_vertex(ray, v[2]));
            assert_false(watertight_passes(e));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(signs_are_exact),
        cmocka_unit_test(a_vertex_does_not_depend_on_its_triangle),
        cmocka_unit_test(triangles_that_are_no_numbers_are_not_passed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
