// SPDX-License-Identifier: Apache-2.0
// What is at the edge: broken rays, broken vertices, broken transforms, extreme sizes, nothing at all.
#include "test.h"

#include <float.h>

#include "accel/meshes.h"

typedef struct stage {
    clustered c;
    clast_tlas *tlas;
} stage;

static stage stage_of(clast_context *context, const mesh *m)
{
    stage s;
    assert_ok(context, clustered_make(context, m, 128, &s.c));
    assert_ok(context, clast_tlas_create(context, &s.tlas));
    clast_tlas_instance instance = instance_of(s.c.blas, 5);
    assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
    return s;
}

static void stage_end(stage *s)
{
    clast_tlas_destroy(s->tlas);
    clustered_free(&s->c);
}

enum { BATCH = 37 };

// The same among other rays: like it, broken, and its copies.
static void trace_in_batch(const clast_tlas *tlas, clast_ray ray, const clast_hit *expected)
{
    static uint32_t turn;
    uint32_t place = turn++ % BATCH;
    clast_ray rays[BATCH];
    clast_hit hits[BATCH];
    uint8_t occluded[BATCH];
    for (uint32_t i = 0; i < BATCH; i++) {
        rays[i] = ray;
        if (i % 3 == 1 && i != place) {
            rays[i].direction[i % 2] += 0.01f * (float)i;
        } else if (i % 5 == 2 && i != place) {
            rays[i].origin[i % 3] = NAN;
        }
    }
    clast_trace_closest(tlas, rays, BATCH, NULL, hits);
    clast_trace_any(tlas, rays, BATCH, NULL, occluded);
    const clast_hit *hit = &hits[place];
    assert_int_equal(hit->instance, expected->instance);
    assert_int_equal(occluded[place], expected->instance != CLAST_NONE);
    if (hit->instance != CLAST_NONE) {
        assert_true(hit->t == expected->t && hit->u == expected->u && hit->v == expected->v);
        assert_int_equal(hit->cluster, expected->cluster);
        assert_int_equal(hit->triangle, expected->triangle);
    }
}

static clast_hit trace(const clast_tlas *tlas, clast_ray ray)
{
    clast_hit hit;
    uint8_t occluded;
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    clast_trace_any(tlas, &ray, 1, NULL, &occluded);
    assert_int_equal(occluded, hit.instance != CLAST_NONE);
    trace_in_batch(tlas, ray, &hit);
    return hit;
}

static clast_ray ray_along_z(float x, float y)
{
    return (clast_ray){{x, y, -3}, 0, {0, 0, 1}, INFINITY};
}

static mesh one_triangle(float scale)
{
    mesh m = mesh_of(3, 1);
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (uint32_t i = 0; i < 3; i++) {
        m.indices[i] = i;
    }
    memcpy(m.positions, positions, sizeof positions);
    mesh_transform(&m, scale, 0, 0, 0);
    return m;
}

static void broken_rays_hit_nothing(void **state)
{
    mesh m = mesh_octasphere(3);
    stage s = stage_of(*state, &m);
    const float broken[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3; i++) {
        for (int axis = 0; axis < 3; axis++) {
            clast_ray ray = ray_along_z(0.1f, 0.1f);
            assert_int_equal(trace(s.tlas, ray).instance, 5);
            ray.origin[axis] = broken[i];
            assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
            ray = ray_along_z(0.1f, 0.1f);
            ray.direction[axis] = broken[i];
            assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
        }
        clast_ray ray = ray_along_z(0.1f, 0.1f);
        ray.t_min = broken[i];
        assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    }
    clast_ray ray = ray_along_z(0.1f, 0.1f);
    ray.t_max = NAN;
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    ray.t_max = -INFINITY;
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    ray = ray_along_z(0.1f, 0.1f);
    ray.direction[2] = 0.0f;
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    stage_end(&s);
    mesh_free(&m);
}

static void both_ends_of_the_range_count(void **state)
{
    mesh m = one_triangle(1.0f);
    stage s = stage_of(*state, &m);
    clast_ray ray = ray_along_z(0.25f, 0.25f);
    clast_hit hit = trace(s.tlas, ray);
    assert_true(hit.t == 3.0f);
    ray.t_max = 3.0f;
    assert_int_equal(trace(s.tlas, ray).instance, 5);
    ray.t_max = nextafterf(3.0f, 0.0f);
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    ray.t_max = INFINITY;
    ray.t_min = 3.0f;
    assert_int_equal(trace(s.tlas, ray).instance, 5);
    ray.t_min = nextafterf(3.0f, 4.0f);
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    ray = ray_along_z(0.25f, 0.25f);
    ray.origin[2] = 3.0f; // behind: only where the range says so
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    ray.t_min = -5.0f;
    assert_int_equal(trace(s.tlas, ray).instance, 5);
    stage_end(&s);
    mesh_free(&m);
}

static void directions_of_any_length_give_the_same_point(void **state)
{
    mesh m = one_triangle(1.0f);
    stage s = stage_of(*state, &m);
    for (int e = -120; e <= 120; e += 10) {
        clast_ray ray = ray_along_z(0.25f, 0.25f);
        ray.direction[2] = ldexpf(1.0f, e);
        clast_hit hit = trace(s.tlas, ray);
        assert_int_equal(hit.instance, 5);
        assert_true(hit.t == ldexpf(3.0f, -e));
    }
    clast_ray ray = ray_along_z(0.25f, 0.25f);
    ray.direction[2] = 0x1p-127f; // the distance is 3 * 2^127: not a float
    assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
    stage_end(&s);
    mesh_free(&m);
}

static void an_empty_structure_hits_nothing(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_of(0, 0);
    stage s = stage_of(context, &m);
    float lower[3], upper[3];
    clast_blas_bounds(s.c.blas, lower, upper);
    assert_true(lower[0] > upper[0]);
    assert_int_equal(trace(s.tlas, ray_along_z(0, 0)).instance, CLAST_NONE);
    assert_ok(context, clast_blas_refit(s.c.blas));
    assert_ok(context, clast_tlas_build(s.tlas, NULL, 0, CLAST_BUILD_BEST));
    assert_int_equal(trace(s.tlas, ray_along_z(0, 0)).instance, CLAST_NONE);
    clast_tlas_bounds(s.tlas, lower, upper);
    assert_true(lower[0] > upper[0]);
    clast_tlas_instance nothing = instance_of(NULL, 0);
    assert_ok(context, clast_tlas_build(s.tlas, &nothing, 1, CLAST_BUILD_BEST));
    assert_int_equal(trace(s.tlas, ray_along_z(0, 0)).instance, CLAST_NONE);
    stage_end(&s);
    mesh_free(&m);
}

static void degenerate_triangles_are_not_hit(void **state)
{
    mesh m = mesh_of(4, 30);
    const float positions[12] = {0, 0, 0, 0.5f, 0.5f, 0, 1, 1, 0, 0, 0, 0};
    memcpy(m.positions, positions, sizeof positions);
    for (uint32_t i = 0; i < 90; i++) {
        m.indices[i] = i % 3 == 0 ? 0 : i % 4; // lines and points
    }
    stage s = stage_of(*state, &m);
    randoms r = {1};
    for (uint32_t i = 0; i < 1000; i++) {
        float x = random_between(&r, -0.5f, 1.5f);
        assert_int_equal(trace(s.tlas, ray_along_z(x, x)).instance, CLAST_NONE);
        assert_int_equal(trace(s.tlas, ray_along_z(x, random_float(&r))).instance, CLAST_NONE);
    }
    stage_end(&s);
    mesh_free(&m);
}

static void coincident_triangles_give_the_lowest_number(void **state)
{
    mesh m = mesh_of(3, 1000);
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    memcpy(m.positions, positions, sizeof positions);
    for (uint32_t i = 0; i < 3000; i++) {
        m.indices[i] = (i + i / 3) % 3; // any corner first
    }
    stage s = stage_of(*state, &m);
    clast_hit hit = trace(s.tlas, ray_along_z(0.25f, 0.125f));
    assert_int_equal(hit.instance, 5);
    assert_int_equal(hit.cluster, 0);
    assert_int_equal(hit.triangle, 0);
    stage_end(&s);
    mesh_free(&m);
}

static void vertices_that_are_not_finite_hide_their_triangles_only(void **state)
{
    clast_context *context = *state;
    const float broken[] = {NAN, INFINITY, -INFINITY, 3e38f};
    for (int kind = 0; kind < 4; kind++) {
        mesh m = mesh_terrain(8, 0.0f, 1);
        for (uint32_t i = 0; i < m.vertex_count; i++) {
            m.positions[3 * i + 2] = 0.5f;
        }
        m.positions[3 * 40 + (uint32_t)kind % 3] = broken[kind]; // the middle: (0.5, 0.5)
        stage s = stage_of(context, &m);
        for (uint32_t j = 0; j < 8; j++) {
            for (uint32_t i = 0; i < 8; i++) {
                clast_hit hit = trace(s.tlas, ray_along_z(((float)i + 0.25f) / 8.0f, ((float)j + 0.125f) / 8.0f));
                bool hidden = (i == 3 || i == 4) && (j == 3 || j == 4) && !(i == 4 && j == 3);
                assert_int_equal(hit.instance, hidden ? CLAST_NONE : 5);
            }
        }
        float lower[3], upper[3];
        clast_blas_bounds(s.c.blas, lower, upper);
        assert_true(lower[0] == 0.0f && upper[0] == 1.0f && lower[2] == 0.5f && upper[2] == 0.5f);
        // they come back
        m.positions[3 * 40] = m.positions[3 * 40 + 1] = m.positions[3 * 40 + 2] = 0.5f;
        clustered_gather(&s.c, &m);
        assert_ok(context, clast_clas_refit(s.c.pool, 0, s.c.cluster_count));
        assert_ok(context, clast_blas_refit(s.c.blas));
        clast_tlas_instance instance = instance_of(s.c.blas, 5);
        assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
        assert_int_equal(trace(s.tlas, ray_along_z(0.53f, 0.52f)).instance, 5);
        stage_end(&s);
        mesh_free(&m);
    }
}

static void a_cluster_without_a_finite_vertex_comes_back_when_it_has_some(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_terrain(16, 0.1f, 1);
    mesh broken = mesh_terrain(16, 0.1f, 1);
    for (uint32_t i = 0; i < 3 * broken.vertex_count; i++) {
        broken.positions[i] = NAN;
    }
    stage s = stage_of(context, &broken);
    assert_int_equal(trace(s.tlas, ray_along_z(0.3f, 0.3f)).instance, CLAST_NONE);
    clustered_gather(&s.c, &m);
    assert_ok(context, clast_clas_refit(s.c.pool, 0, s.c.cluster_count));
    assert_ok(context, clast_blas_refit(s.c.blas));
    clast_tlas_instance instance = instance_of(s.c.blas, 5);
    assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
    for (uint32_t i = 1; i < 16; i++) {
        assert_int_equal(trace(s.tlas, ray_along_z((float)i / 16.0f, 0.3f)).instance, 5);
    }
    stage_end(&s);
    mesh_free(&m);
    mesh_free(&broken);
}

static void flat_boxes_are_hit(void **state)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        mesh m = mesh_terrain(16, 0.0f, 1);
        for (uint32_t i = 0; i < m.vertex_count; i++) { // turn the plane's normal to the axis
            float *p = m.positions + 3 * (size_t)i, turned[3];
            turned[axis] = 0.7f;
            turned[(axis + 1) % 3] = p[0];
            turned[(axis + 2) % 3] = p[1];
            memcpy(p, turned, sizeof turned);
        }
        stage s = stage_of(*state, &m);
        randoms r = {3};
        for (uint32_t i = 0; i < 2000; i++) {
            clast_ray ray = {.t_max = INFINITY};
            ray.origin[axis] = 5.0f;
            ray.origin[(axis + 1) % 3] = (float)random_below(&r, 17) / 16.0f; // on the grid's lines
            ray.origin[(axis + 2) % 3] = random_float(&r);
            ray.direction[axis] = -1.0f;
            assert_int_equal(trace(s.tlas, ray).instance, 5);
            ray.origin[axis] = 0.7f; // within the plane: seen edge on
            ray.direction[axis] = 0.0f;
            ray.direction[(axis + 1) % 3] = 1.0f;
            assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
        }
        stage_end(&s);
        mesh_free(&m);
    }
}

// Normals have any length: here, they differ by a power of two.
static void assert_same_way(const float a[3], const float b[3])
{
    int exponents[2] = {-1000, -1000};
    for (int axis = 0; axis < 3; axis++) {
        exponents[0] = a[axis] != 0.0f && ilogbf(a[axis]) > exponents[0] ? ilogbf(a[axis]) : exponents[0];
        exponents[1] = b[axis] != 0.0f && ilogbf(b[axis]) > exponents[1] ? ilogbf(b[axis]) : exponents[1];
    }
    for (int axis = 0; axis < 3; axis++) {
        assert_true(ldexpf(a[axis], -exponents[0]) == ldexpf(b[axis], -exponents[1]));
    }
}

static void sizes_from_1e_20_to_1e20_give_the_same_hits(void **state)
{
    mesh unit = mesh_octasphere(4);
    mesh_displace(&unit, 0.2f, 9);
    stage expected = stage_of(*state, &unit);
    for (int e = -66; e <= 66; e += 11) { // powers of two: 1e-20 to 1e20, to the bit the same geometry
        mesh m = mesh_octasphere(4);
        mesh_displace(&m, 0.2f, 9);
        mesh_transform(&m, ldexpf(1.0f, e), 0, 0, 0);
        stage s = stage_of(*state, &m);
        randoms r = {11};
        for (uint32_t i = 0; i < 500; i++) {
            clast_ray ray = {.t_max = INFINITY}, scaled = ray;
            for (uint32_t axis = 0; axis < 3; axis++) {
                ray.origin[axis] = random_between(&r, -2, 2);
                ray.direction[axis] = scaled.direction[axis] = random_between(&r, -1, 1);
                scaled.origin[axis] = ldexpf(ray.origin[axis], e);
            }
            clast_hit a = trace(expected.tlas, ray), b = trace(s.tlas, scaled);
            assert_int_equal(a.instance, b.instance);
            if (a.instance != CLAST_NONE) {
                assert_true(ldexpf(a.t, e) == b.t && a.u == b.u && a.v == b.v);
                assert_int_equal(a.cluster, b.cluster);
                assert_int_equal(a.triangle, b.triangle);
                assert_same_way(a.normal, b.normal);
            }
        }
        stage_end(&s);
        mesh_free(&m);
    }
    stage_end(&expected);
    mesh_free(&unit);
}

static void denormal_and_huge_coordinates_neither_hang_nor_invent_hits(void **state)
{
    const float scales[] = {1e-45f, 1e-40f, 1e-30f, 1e30f, 1e36f, 3e38f};
    for (int i = 0; i < 6; i++) {
        mesh m = mesh_octasphere(3);
        mesh_transform(&m, scales[i], 0, 0, 0);
        stage s = stage_of(*state, &m);
        clast_ray beside = {{scales[i] < 1.0f ? 1.0f : -1e37f, 0, 0}, 0, {0, 1, 0}, INFINITY};
        assert_int_equal(trace(s.tlas, beside).instance, CLAST_NONE);
        clast_ray inside = {{0, 0, 0}, 0, {0.3f, 0.7f, 0.2f}, INFINITY};
        clast_hit hit = trace(s.tlas, inside);
        if (scales[i] > 1e-38f && scales[i] < 1e36f) {
            assert_int_equal(hit.instance, 5);
        }
        stage_end(&s);
        mesh_free(&m);
    }
}

// One cluster with triangles of all sizes: the small ones are lost in its boxes, and must be found nevertheless.
static void sizes_mixed_in_one_cluster_are_all_hit(void **state)
{
    mesh m = mesh_of(3 * 41, 41);
    for (uint32_t i = 0; i < 41; i++) { // in the planes z = 1e-20 to 1e20, one behind the other
        float size = powf(10.0f, (float)i - 20.0f);
        const float corners[9] = {-size, -size, size, size, -size, size, 0, size, size};
        memcpy(m.positions + 9 * (size_t)i, corners, sizeof corners);
        for (uint32_t k = 0; k < 3; k++) {
            m.indices[3 * i + k] = 3 * i + k;
        }
    }
    stage s = stage_of(*state, &m);
    for (uint32_t i = 0; i < 41; i++) {
        float size = powf(10.0f, (float)i - 20.0f);
        clast_ray ray = {{0.9f * size, -0.95f * size, -size}, 0, {0, 0, 1}, INFINITY}; // passes those before
        clast_hit hit = trace(s.tlas, ray);
        assert_int_equal(hit.instance, 5);
        if (hit.triangle != i) { // which of those is hit that are nothing beside the whole, is within the bound
            assert_true(size < 0x1p-19f * 1e20f && powf(10.0f, (float)hit.triangle - 20.0f) < 0x1p-19f * 1e20f);
        }
    }
    stage_end(&s);
    mesh_free(&m);
}

static void clusters_without_extent_are_not_hit(void **state)
{
    for (uint32_t kind = 0; kind < 2; kind++) { // a point; a line along an axis
        mesh m = mesh_terrain(8, 0.0f, 1);
        for (uint32_t i = 0; i < m.vertex_count; i++) {
            m.positions[3 * i + 1] = 0.5f;
            m.positions[3 * i + 2] = 0.25f;
            if (kind == 0) {
                m.positions[3 * i] = 0.5f;
            }
        }
        stage s = stage_of(*state, &m);
        randoms r = {8};
        for (uint32_t i = 0; i < 1000; i++) {
            float x = random_between(&r, -0.5f, 1.5f);
            assert_int_equal(trace(s.tlas, ray_along_z(i % 2 == 0 ? 0.5f : x, 0.5f)).instance, CLAST_NONE);
            clast_ray ray = {{-1, 0.5f, 0.25f}, 0, {1, 0, 0}, INFINITY};
            ray.direction[i % 3] += i % 4 == 0 ? 1e-8f : 0.0f;
            assert_int_equal(trace(s.tlas, ray).instance, CLAST_NONE);
        }
        stage_end(&s);
        mesh_free(&m);
    }
}

static void directions_almost_along_an_axis_are_hit(void **state)
{
    mesh m = mesh_octasphere(3);
    stage s = stage_of(*state, &m);
    for (int e = -149; e <= 0; e++) {
        for (int axis = 0; axis < 3; axis++) {
            clast_ray ray = {.t_max = INFINITY};
            ray.direction[axis] = 1.0f;
            ray.direction[(axis + 1) % 3] = ldexpf(1.0f, e);
            ray.direction[(axis + 2) % 3] = -ldexpf(1.0f, e / 2);
            assert_int_equal(trace(s.tlas, ray).instance, 5);
            ray.direction[(axis + 2) % 3] = -0.0f;
            assert_int_equal(trace(s.tlas, ray).instance, 5);
        }
    }
    stage_end(&s);
    mesh_free(&m);
}

static void transforms_that_cannot_be_inverted_hide_the_instance(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(3);
    stage s = stage_of(context, &m);
    clast_tlas_instance instances[6];
    for (int i = 0; i < 6; i++) {
        instances[i] = instance_of(s.c.blas, (uint32_t)i);
    }
    memset(instances[0].transform, 0, sizeof instances[0].transform);
    instances[1].transform[0][0] = NAN;
    instances[2].transform[1][3] = INFINITY;
    instances[3].transform[2][2] = 0.0f;
    memcpy(instances[4].transform[1], instances[4].transform[0], sizeof instances[4].transform[0]); // two equal rows
    instances[5].transform[0][3] = 3e38f;
    assert_ok(context, clast_tlas_build(s.tlas, instances, 6, CLAST_BUILD_BEST));
    assert_int_equal(trace(s.tlas, ray_along_z(0.1f, 0.1f)).instance, CLAST_NONE);
    stage_end(&s);
    mesh_free(&m);
}

static void wrong_arguments_are_refused(void **state)
{
    clast_context *context = *state;
    mesh m = one_triangle(1.0f);
    stage s = stage_of(context, &m);
    uint8_t indices[3] = {0, 1, 3};
    float vertices[9] = {0};
    clast_template_desc desc = {1, 3, indices, NULL};
    uint32_t number, before = clast_template_set_count(s.c.set), slots[2] = {0, 1};
    assert_int_equal(clast_template_set_add(s.c.set, &desc, 1, &number), CLAST_ERROR_INVALID_ARGUMENT);
    desc.triangle_count = 257;
    assert_int_equal(clast_template_set_add(s.c.set, &desc, 1, &number), CLAST_ERROR_INVALID_ARGUMENT);
    desc.triangle_count = 0;
    assert_int_equal(clast_template_set_add(s.c.set, &desc, 1, &number), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_template_set_add_grid(s.c.set, 12, 1, &number), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_template_set_add_grid(s.c.set, 1, 0, &number), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_template_set_count(s.c.set), before);
    clast_clas_input input = {before, vertices};
    assert_int_equal(clast_clas_instantiate(s.c.pool, 0, 1, &input), CLAST_ERROR_INVALID_ARGUMENT);
    input = (clast_clas_input){0, NULL};
    assert_int_equal(clast_clas_instantiate(s.c.pool, 0, 1, &input), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_instantiate(s.c.pool, SIZE_MAX, 2, &input), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_refit(s.c.pool, 0, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_blas_build(s.c.blas, slots, 2, CLAST_BUILD_BEST), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_blas_build(s.c.blas, NULL, 2, CLAST_BUILD_BEST), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(trace(s.tlas, ray_along_z(0.1f, 0.1f)).instance, 5); // all is as before
    clast_tlas_instance instance = instance_of(s.c.blas, CLAST_NONE);
    assert_int_equal(clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(trace(s.tlas, ray_along_z(0.1f, 0.1f)).instance, CLAST_NONE); // empty, where that fails
    stage_end(&s);
    mesh_free(&m);
}

static void deep_trees_do_not_overflow_the_stack(void **state)
{
    mesh m = mesh_of(3 * 2000, 2000); // each triangle half as far as the one before: every cut is lopsided
    for (uint32_t i = 0; i < 2000; i++) {
        float size = ldexpf(1.0f, -(int)(i % 100));
        const float corners[9] = {size, 0, (float)i * 1e-3f, size, size * 0.1f, 0, size, 0, size};
        memcpy(m.positions + 9 * (size_t)i, corners, sizeof corners);
        for (uint32_t k = 0; k < 3; k++) {
            m.indices[3 * i + k] = 3 * i + k;
        }
    }
    stage s;
    assert_ok(*state, clustered_make(*state, &m, 1, &s.c));
    assert_ok(*state, clast_tlas_create(*state, &s.tlas));
    clast_tlas_instance instance = instance_of(s.c.blas, 5);
    assert_ok(*state, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {1};
    for (uint32_t i = 0; i < 2000; i++) {
        clast_ray ray = {.t_max = INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            ray.origin[axis] = random_between(&r, -1, 1);
            ray.direction[axis] = random_between(&r, -1, 1);
        }
        trace(s.tlas, ray);
    }
    stage_end(&s);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(broken_rays_hit_nothing),
        CONTEXT_TEST(both_ends_of_the_range_count),
        CONTEXT_TEST(directions_of_any_length_give_the_same_point),
        CONTEXT_TEST(an_empty_structure_hits_nothing),
        CONTEXT_TEST(degenerate_triangles_are_not_hit),
        CONTEXT_TEST(coincident_triangles_give_the_lowest_number),
        CONTEXT_TEST(vertices_that_are_not_finite_hide_their_triangles_only),
        CONTEXT_TEST(a_cluster_without_a_finite_vertex_comes_back_when_it_has_some),
        CONTEXT_TEST(flat_boxes_are_hit),
        CONTEXT_TEST(sizes_from_1e_20_to_1e20_give_the_same_hits),
        CONTEXT_TEST(denormal_and_huge_coordinates_neither_hang_nor_invent_hits),
        CONTEXT_TEST(sizes_mixed_in_one_cluster_are_all_hit),
        CONTEXT_TEST(clusters_without_extent_are_not_hit),
        CONTEXT_TEST(directions_almost_along_an_axis_are_hit),
        CONTEXT_TEST(transforms_that_cannot_be_inverted_hide_the_instance),
        CONTEXT_TEST(wrong_arguments_are_refused),
        CONTEXT_TEST(deep_trees_do_not_overflow_the_stack),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
