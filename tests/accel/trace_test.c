// SPDX-License-Identifier: Apache-2.0
// Rays through trees, against every triangle tested by the shared formulas, one after the other.
#include "test.h"

#include <float.h>

#include "accel/meshes.h"
#include "shared/watertight.h"

// The nearest triangle of a mesh, in one instance without a transform. The scale is that of the kernel.
static clast_hit nearest(const mesh *m, const clustered *c, const clast_ray *ray, float scale)
{
    clast_hit best = {.t = ray->t_max < FLT_MAX ? ray->t_max : FLT_MAX, .instance = CLAST_NONE};
    vec3 direction = vec3(ray->direction[0], ray->direction[1], ray->direction[2]);
    clast_watertight_ray test = watertight_ray(vec3(ray->origin[0], ray->origin[1], ray->origin[2]), direction, scale);
    uint32_t cluster = 0;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        vec3 v[3];
        while (cluster + 1 < c->cluster_count && c->first_triangles[cluster + 1] <= i) {
            cluster++;
        }
        for (uint32_t k = 0; k < 3; k++) {
            const float *p = m->positions + 3 * (size_t)m->indices[3 * i + k];
            v[k] = watertight_vertex(test, vec3(p[0], p[1], p[2]));
        }
        clast_watertight_edges e = watertight_edges(v[0], v[1], v[2]);
        float t = e.depth / e.sum * (1.0f / component3(direction, test.axis) / scale);
        if (watertight_passes(e) && t >= ray->t_min && (t < best.t || (t == best.t && best.instance == CLAST_NONE))) {
            best = (clast_hit){.t = t, .u = e.b / e.sum, .v = e.c / e.sum, .instance = 0, .cluster = cluster};
            best.triangle = i - c->first_triangles[cluster];
        }
    }
    return best;
}

static void assert_same_hit(const clast_hit *hit, const clast_hit *expected)
{
    assert_int_equal(hit->instance, expected->instance);
    if (expected->instance != CLAST_NONE) {
        assert_int_equal(hit->cluster, expected->cluster);
        assert_int_equal(hit->triangle, expected->triangle);
        assert_true(hit->t == expected->t && hit->u == expected->u && hit->v == expected->v);
    }
}

static clast_ray random_ray(randoms *r, float extent)
{
    clast_ray ray = {.t_min = 0.0f, .t_max = random_bits(r) % 4 == 0 ? random_float(r) * extent : INFINITY};
    for (int axis = 0; axis < 3; axis++) {
        ray.origin[axis] = random_between(r, -extent, extent);
        // a power of two as the largest component would be luck: let directions have any length
        ray.direction[axis] = random_bits(r) % 8 == 0 ? 0.0f : random_between(r, -1.0f, 1.0f);
    }
    if (ray.direction[0] == 0.0f && ray.direction[1] == 0.0f && ray.direction[2] == 0.0f) {
        ray.direction[0] = 1.0f;
    }
    return ray;
}

// Brute force knows no power of two that fits all rays; the kernel takes one for each. Neither changes a bit of a sound test.
static void compare_with_brute_force(clast_context *context, mesh *m, uint32_t most, uint32_t rays, float extent)
{
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, m, most, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {7};
    uint32_t hits = 0;
    for (uint32_t i = 0; i < rays; i++) {
        clast_ray ray = random_ray(&r, extent);
        clast_hit hit, expected = nearest(m, &c, &ray, 1.0f);
        uint8_t occluded;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        clast_trace_any(tlas, &ray, 1, NULL, &occluded);
        assert_same_hit(&hit, &expected);
        assert_int_equal(occluded, expected.instance != CLAST_NONE);
        hits += occluded;
    }
    assert_true(hits > rays / 50);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    mesh_free(m);
}

static void the_nearest_triangle_of_a_soup_is_found(void **state)
{
    mesh m = mesh_soup(3000, 0.1f, 1);
    compare_with_brute_force(*state, &m, 85, 3000, 1.5f);
}

static void the_nearest_triangle_of_a_terrain_is_found(void **state)
{
    mesh m = mesh_terrain(40, 0.3f, 2);
    compare_with_brute_force(*state, &m, 128, 3000, 1.2f);
}

static void small_clusters_and_large_triangles_work(void **state)
{
    mesh m = mesh_soup(500, 1.0f, 3);
    compare_with_brute_force(*state, &m, 3, 1000, 2.0f);
}

static void a_single_triangle_works(void **state)
{
    mesh m = mesh_soup(1, 2.0f, 4);
    compare_with_brute_force(*state, &m, 128, 2000, 2.0f);
}

// Through vertices, along edges: edge functions that are zero, or are so but for rounding.
static void rays_on_the_lines_of_a_grid_agree(void **state)
{
    mesh m = mesh_terrain(16, 0.0f, 2);
    for (uint32_t i = 0; i < m.vertex_count; i++) {
        m.positions[3 * i + 2] = 0.3f * m.positions[3 * i] + 0.1f;
    }
    clustered c;
    clast_tlas *tlas;
    assert_ok(*state, clustered_make(*state, &m, 128, &c));
    assert_ok(*state, clast_tlas_create(*state, &tlas));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(*state, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {17};
    for (uint32_t i = 0; i < 3000; i++) {
        clast_ray ray = {
            {(float)random_below(&r, 17) / 16, (float)random_below(&r, 33) / 32, 3}, 0, {0, 0, -1}, INFINITY};
        if (i % 2 == 0) { // at a point of the grid from far beside it
            float to[3] = {(float)(1 + random_below(&r, 15)) / 16, (float)(1 + random_below(&r, 15)) / 16, 0};
            to[2] = 0.3f * to[0] + 0.1f;
            for (int axis = 0; axis < 3; axis++) {
                ray.direction[axis] = to[axis] - ray.origin[axis];
            }
        }
        clast_hit hit, expected = nearest(&m, &c, &ray, 1.0f);
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        assert_int_equal(expected.instance, 0);
        assert_same_hit(&hit, &expected);
    }
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    mesh_free(&m);
}

static void full_templates_work(void **state)
{
    mesh m = mesh_terrain(30, 0.3f, 5);
    compare_with_brute_force(*state, &m, 256, 2000, 1.2f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(the_nearest_triangle_of_a_soup_is_found),
        CONTEXT_TEST(the_nearest_triangle_of_a_terrain_is_found),
        CONTEXT_TEST(small_clusters_and_large_triangles_work),
        CONTEXT_TEST(a_single_triangle_works),
        CONTEXT_TEST(full_templates_work),
        CONTEXT_TEST(rays_on_the_lines_of_a_grid_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
