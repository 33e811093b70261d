// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>
#include <string.h>

#include "load/polygon.h"

// Cuts a polygon of the plane z = 0.
static clast_polygon cut(clast_context *context, const float (*points)[2], uint32_t count)
{
    clast_polygon polygon = {0};
    assert_int_equal(clast_polygon_reserve(context, &polygon, count), CLAST_OK);
    for (uint32_t i = 0; i < count; i++) {
        memcpy(polygon.points[i], (float[3]){points[i][0], points[i][1], 0.0f}, 12);
    }
    clast_polygon_cut(&polygon, count);
    return polygon;
}

static double triangle_area(const float (*points)[2], const uint32_t *t)
{
    double ux = (double)points[t[1]][0] - (double)points[t[0]][0],
           uy = (double)points[t[1]][1] - (double)points[t[0]][1];
    double vx = (double)points[t[2]][0] - (double)points[t[0]][0],
           vy = (double)points[t[2]][1] - (double)points[t[0]][1];
    return 0.5 * (ux * vy - uy * vx);
}

static double polygon_area(const float (*points)[2], uint32_t count)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const float *a = points[i], *b = points[(i + 1) % count];
        sum += 0.5 * ((double)a[0] * (double)b[1] - (double)b[0] * (double)a[1]);
    }
    return sum;
}

// All triangles turn as the polygon does and their areas add up to its own: they neither overlap nor leave it.
static void assert_covers(clast_context *context, const float (*points)[2], uint32_t count)
{
    double area = polygon_area(points, count), sum = 0.0;
    bool turns_alike = true;
    clast_polygon polygon = cut(context, points, count);
    for (uint32_t i = 0; i < count - 2; i++) {
        double one = triangle_area(points, polygon.corners + 3 * i);
        turns_alike = turns_alike && one * area >= 0.0;
        sum += one;
    }
    clast_polygon_free(context, &polygon);
    assert_true(turns_alike);
    assert_true(fabs(sum - area) < 1e-6 * fabs(area));
}

static void a_concave_quad_is_cut_at_its_reflex_corner(void **state)
{
    const float arrow[4][2] = {{0, 0}, {2, -1}, {0, 3}, {-2, -1}};
    assert_covers(*state, arrow, 4);
    const float turned[4][2] = {{2, -1}, {0, 3}, {-2, -1}, {0, 0}};
    assert_covers(*state, turned, 4);
}

static void a_quad_is_cut_along_its_shorter_diagonal(void **state)
{
    const float kite[4][2] = {{-5, 0}, {0, -1}, {5, 0}, {0, 1}};
    clast_polygon polygon = cut(*state, kite, 4);
    const uint32_t expected[6] = {0, 1, 3, 1, 2, 3};
    assert_memory_equal(polygon.corners, expected, sizeof expected);
    clast_polygon_free(*state, &polygon);
    const float other[4][2] = {{0, -1}, {5, 0}, {0, 1}, {-5, 0}};
    polygon = cut(*state, other, 4);
    const uint32_t first[6] = {0, 1, 2, 0, 2, 3};
    assert_memory_equal(polygon.corners, first, sizeof first);
    clast_polygon_free(*state, &polygon);
}

static void concave_polygons_are_covered(void **state)
{
    const float comb[11][2] = {{0, 0}, {5, 0}, {5, 5}, {4, 5}, {4, 1}, {3, 1}, {3, 5}, {2, 5}, {2, 1}, {1, 1}, {1, 5}};
    assert_covers(*state, comb, 11);
    float star[40][2], reversed[40][2];
    for (int i = 0; i < 40; i++) {
        double angle = 6.283185307179586 * i / 40, radius = i % 2 ? 0.3 : 1.0;
        star[i][0] = (float)(radius * cos(angle));
        star[i][1] = (float)(radius * sin(angle));
        memcpy(reversed[39 - i], star[i], sizeof star[i]);
    }
    assert_covers(*state, star, 40);
    assert_covers(*state, reversed, 40);
}

static void a_polygon_with_a_bridge_to_its_hole_is_covered(void **state)
{
    const float ring[10][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}};
    assert_covers(*state, ring, 10);
}

static void a_convex_polygon_of_many_corners_is_covered(void **state)
{
    static float circle[5000][2];
    for (int i = 0; i < 5000; i++) {
        circle[i][0] = (float)(100.0 * cos(6.283185307179586 * i / 5000));
        circle[i][1] = (float)(100.0 * sin(6.283185307179586 * i / 5000));
    }
    assert_covers(*state, circle, 5000);
}

static void degenerate_polygons_give_all_their_triangles(void **state)
{
    const float nowhere[6][2] = {{1, 1}, {1, 1}, {1, 1}, {1, 1}, {1, 1}, {1, 1}};
    const float line[6][2] = {{0, 0}, {1, 0}, {2, 0}, {3, 0}, {2, 0}, {1, 0}};
    const float bow[4][2] = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
    const float(*const all[])[2] = {nowhere, line, bow};
    const uint32_t counts[] = {6, 6, 4};
    for (int i = 0; i < 3; i++) {
        clast_polygon polygon = cut(*state, all[i], counts[i]);
        for (uint32_t k = 0; k < 3 * (counts[i] - 2); k++) {
            assert_true(polygon.corners[k] < counts[i]);
        }
        clast_polygon_free(*state, &polygon);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_concave_quad_is_cut_at_its_reflex_corner),
        CONTEXT_TEST(a_quad_is_cut_along_its_shorter_diagonal),
        CONTEXT_TEST(concave_polygons_are_covered),
        CONTEXT_TEST(a_polygon_with_a_bridge_to_its_hole_is_covered),
        CONTEXT_TEST(a_convex_polygon_of_many_corners_is_covered),
        CONTEXT_TEST(degenerate_polygons_give_all_their_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
