// SPDX-License-Identifier: Apache-2.0
// Instances: transforms, normals, filters, ties; pools and templates as their headers promise.
#include "test.h"

#include "accel/meshes.h"

typedef struct stage {
    clustered c;
    mesh m;
    clast_tlas *tlas;
} stage;

static stage stage_of(clast_context *context, mesh m)
{
    stage s = {.m = m};
    assert_ok(context, clustered_make(context, &s.m, 128, &s.c));
    assert_ok(context, clast_tlas_create(context, &s.tlas));
    return s;
}

static void stage_end(stage *s)
{
    clast_tlas_destroy(s->tlas);
    clustered_free(&s->c);
    mesh_free(&s->m);
}

static clast_hit trace(const clast_tlas *tlas, const clast_ray *ray)
{
    clast_hit hit;
    clast_trace_closest(tlas, ray, 1, NULL, &hit);
    return hit;
}

// A random map; mirrored where `sign` is -1.
static void random_map(randoms *r, float sign, float map[3][4])
{
    for (int i = 0; i < 12; i++) {
        map[i / 4][i % 4] = random_between(r, -1, 1) + (i % 5 == 0 ? 2.0f : 0.0f);
    }
    for (int k = 0; k < 4; k++) {
        map[0][k] *= sign;
    }
}

static void apply(const float map[3][4], const float p[3], float w, float out[3])
{
    for (int i = 0; i < 3; i++) {
        out[i] = map[i][0] * p[0] + map[i][1] * p[1] + map[i][2] * p[2] + map[i][3] * w;
    }
}

// From inside a ball, every ray hits, where it should, and the normal points away from the middle: outside is the front.
static void transformed_balls_are_hit_from_inside_and_keep_their_front(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_octasphere(4));
    randoms r = {1};
    for (int i = 0; i < 40; i++) {
        clast_tlas_instance instance = instance_of(s.c.blas, 3);
        random_map(&r, i % 2 == 0 ? 1.0f : -1.0f, instance.transform);
        assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
        for (int k = 0; k < 100; k++) {
            float object[3] = {random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1)},
                  world[3];
            const float middle[3] = {0, 0, 0};
            clast_ray ray = {.t_max = INFINITY};
            apply((const float(*)[4])instance.transform, middle, 1, ray.origin);
            apply((const float(*)[4])instance.transform, object, 0, ray.direction);
            clast_hit hit = trace(s.tlas, &ray);
            assert_int_equal(hit.instance, 3);
            float length = sqrtf(object[0] * object[0] + object[1] * object[1] + object[2] * object[2]);
            assert_true(hit.t * length > 0.98f && hit.t * length < 1.0001f);
            memcpy(world, ray.direction, sizeof world);
            assert_true(hit.normal[0] * world[0] + hit.normal[1] * world[1] + hit.normal[2] * world[2] > 0.0f);
        }
    }
    stage_end(&s);
}

static void normals_are_perpendicular_to_transformed_triangles(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_octasphere(2));
    randoms r = {9};
    for (int i = 0; i < 200; i++) {
        clast_tlas_instance instance = instance_of(s.c.blas, 3);
        random_map(&r, i % 2 == 0 ? 1.0f : -1.0f, instance.transform);
        assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
        clast_ray ray = {.direction = {random_between(&r, -1, 1), random_between(&r, -1, 1), 1}, .t_max = INFINITY};
        const float middle[3] = {0, 0, 0};
        apply((const float(*)[4])instance.transform, middle, 1, ray.origin);
        clast_hit hit = trace(s.tlas, &ray);
        float corner[3][3];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t vertex = s.m.indices[3 * (s.c.first_triangles[hit.cluster] + hit.triangle) + k];
            apply((const float(*)[4])instance.transform, s.m.positions + 3 * (size_t)vertex, 1, corner[k]);
        }
        float most = fmaxf(fabsf(hit.normal[0]), fmaxf(fabsf(hit.normal[1]), fabsf(hit.normal[2])));
        assert_true(most > 0.0f);
        for (uint32_t k = 1; k < 3; k++) {
            float dot = 0.0f, size = 0.0f;
            for (uint32_t axis = 0; axis < 3; axis++) {
                dot += hit.normal[axis] / most * (corner[k][axis] - corner[0][axis]);
                size = fmaxf(size, fabsf(corner[k][axis] - corner[0][axis]));
            }
            assert_true(fabsf(dot) < 1e-4f * size);
        }
    }
    stage_end(&s);
}

static void distances_are_in_units_of_the_given_direction(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_terrain(4, 0.0f, 1));
    clast_tlas_instance instance = instance_of(s.c.blas, 0);
    instance.transform[2][2] = -1e-3f; // mirrored, too
    instance.transform[2][3] = 10.0f;
    assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
    clast_ray ray = {{0.3f, 0.3f, 2}, 0, {0, 0, 4}, INFINITY};
    clast_hit hit = trace(s.tlas, &ray);
    assert_int_equal(hit.instance, 0);
    assert_float_equal(hit.t, 2.0, 1e-6);
    stage_end(&s);
}

static void ties_go_to_the_lower_instance(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_terrain(20, 0.1f, 1));
    clast_tlas_instance instances[20];
    for (uint32_t i = 0; i < 20; i++) {
        instances[i] = instance_of(s.c.blas, (i * 7 + 3) % 20 + 100);
    }
    assert_ok(context, clast_tlas_build(s.tlas, instances, 20, CLAST_BUILD_BEST));
    randoms r = {2};
    for (int i = 0; i < 200; i++) {
        clast_ray ray = {{random_float(&r), random_float(&r), 1}, 0, {0, 0, -1}, INFINITY};
        assert_int_equal(trace(s.tlas, &ray).instance, 100);
    }
    stage_end(&s);
}

typedef struct counter {
    uint32_t calls;
    float beyond; // what is nearer does not count
} counter;

static bool is_beyond(void *user, const clast_ray *ray, const clast_hit *hit)
{
    counter *c = user;
    c->calls++;
    assert_true(hit->t >= ray->t_min && hit->t <= ray->t_max);
    assert_true(hit->u >= 0.0f && hit->v >= 0.0f && hit->u + hit->v <= 1.000001f);
    return hit->t > c->beyond;
}

static void refused_hits_let_the_ray_pass(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_terrain(10, 0.0f, 1));
    clast_tlas_instance instances[4];
    for (uint32_t i = 0; i < 4; i++) {
        instances[i] = instance_of(s.c.blas, i);
        instances[i].transform[2][3] = (float)i;
        instances[i].filtered = 1;
    }
    clast_ray ray = {{0.33f, 0.41f, -1}, 0, {0, 0, 1}, INFINITY};
    counter c = {0, 2.5f};
    clast_hit_filter filter = {is_beyond, &c};
    clast_hit hit;
    uint8_t occluded;
    assert_ok(context, clast_tlas_build(s.tlas, instances, 4, CLAST_BUILD_BEST));
    clast_trace_closest(s.tlas, &ray, 1, &filter, &hit);
    assert_int_equal(hit.instance, 2);
    assert_true(c.calls >= 3);
    clast_trace_any(s.tlas, &ray, 1, &filter, &occluded);
    assert_int_equal(occluded, 1);
    c.beyond = 4.5f;
    clast_trace_closest(s.tlas, &ray, 1, &filter, &hit);
    assert_int_equal(hit.instance, CLAST_NONE);
    clast_trace_any(s.tlas, &ray, 1, &filter, &occluded);
    assert_int_equal(occluded, 0);
    instances[1].filtered = 0; // this one is not asked
    assert_ok(context, clast_tlas_build(s.tlas, instances, 4, CLAST_BUILD_BEST));
    clast_trace_closest(s.tlas, &ray, 1, &filter, &hit);
    assert_int_equal(hit.instance, 1);
    stage_end(&s);
}

static void grids_have_the_documented_corners(void **state)
{
    clast_context *context = *state;
    clast_template_set *set;
    assert_ok(context, clast_template_set_create(context, &set));
    for (uint32_t rows = 1; rows <= 11; rows++) {
        for (uint32_t columns = 1; columns <= 11; columns++) {
            uint32_t number, again, corners[3];
            assert_ok(context, clast_template_set_add_grid(set, columns, rows, &number));
            assert_ok(context, clast_template_set_add_grid(set, columns, rows, &again));
            assert_int_equal(number, again);
            assert_int_equal(clast_template_triangle_count(set, number), 2 * columns * rows);
            assert_int_equal(clast_template_vertex_count(set, number), (columns + 1) * (rows + 1));
            for (uint32_t quad = 0; quad < columns * rows; quad++) {
                uint32_t a = quad / columns * (columns + 1) + quad % columns;
                clast_template_triangle(set, number, 2 * quad, corners);
                assert_true(corners[0] == a && corners[1] == a + 1 && corners[2] == a + columns + 2);
                clast_template_triangle(set, number, 2 * quad + 1, corners);
                assert_true(corners[0] == a && corners[1] == a + columns + 2 && corners[2] == a + columns + 1);
            }
        }
    }
    assert_int_equal(clast_template_set_count(set), 121);
    clast_template_set_destroy(set);
}

static void templates_give_back_their_triangles(void **state)
{
    clast_context *context = *state;
    randoms r = {4};
    for (uint32_t count = 1; count <= 256; count += 15) {
        uint8_t indices[768];
        float positions[768];
        for (uint32_t i = 0; i < 768; i++) {
            indices[i] = (uint8_t)random_bits(&r);
            positions[i] = random_bits(&r) % 20 == 0 ? NAN : random_between(&r, -1e30f, 1e30f);
        }
        clast_template_set *set;
        assert_ok(context, clast_template_set_create(context, &set));
        clast_template_desc descs[2] = {{count, 256, indices, positions}, {count, 256, indices, NULL}};
        uint32_t first;
        assert_ok(context, clast_template_set_add(set, descs, 2, &first));
        for (uint32_t i = 0; i < 2 * count; i++) {
            uint32_t corners[3];
            clast_template_triangle(set, first + i / count, i % count, corners);
            for (uint32_t k = 0; k < 3; k++) {
                assert_int_equal(corners[k], indices[3 * (i % count) + k]);
            }
        }
        clast_template_set_destroy(set);
    }
}

static void reserved_slots_need_no_memory_later(void **state)
{
    clast_context *context = *state;
    clast_template_set *set;
    clast_clas_pool *pool;
    uint32_t small, large;
    float vertices[3 * 144] = {0};
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_template_set_add_grid(set, 1, 1, &small));
    assert_ok(context, clast_template_set_add_grid(set, 11, 11, &large));
    assert_ok(context, clast_clas_pool_create(set, &pool));
    assert_ok(context, clast_clas_pool_reserve(pool, 100));
    uint64_t held = clast_context_memory(context), peak = clast_context_memory_peak(context);
    for (uint32_t i = 0; i < 100; i++) {
        clast_clas_input input = {i % 2 == 0 ? small : large, vertices};
        assert_ok(context, clast_clas_instantiate(pool, i, 1, &input));
    }
    assert_int_equal(clast_clas_pool_count(pool), 100);
    assert_int_equal(clast_context_memory(context), held);
    assert_int_equal(clast_context_memory_peak(context), peak);
    clast_clas_pool_truncate(pool, 7);
    assert_int_equal(clast_clas_pool_count(pool), 7);
    assert_int_equal(clast_clas_refit(pool, 0, 8), CLAST_ERROR_INVALID_ARGUMENT);
    clast_clas_pool_destroy(pool);
    clast_template_set_destroy(set);
}

static void larger_templates_find_room_in_a_pool_of_small_ones(void **state)
{
    clast_context *context = *state;
    stage s = stage_of(context, mesh_terrain(5, 0.0f, 1)); // 50 triangles: one group of boxes
    uint32_t large;
    float vertices[3 * 144];
    for (uint32_t i = 0; i < 144; i++) {
        vertices[3 * i] = 5.0f + (float)(i % 12) / 11.0f;
        vertices[3 * i + 1] = (float)(i / 12) / 11.0f;
        vertices[3 * i + 2] = 0.0f;
    }
    assert_ok(context, clast_template_set_add_grid(s.c.set, 11, 11, &large));
    clast_clas_input input = {large, vertices};
    size_t slot = clast_clas_pool_count(s.c.pool) + 3; // some slots are left empty
    assert_ok(context, clast_clas_instantiate(s.c.pool, slot, 1, &input));
    assert_ok(context, clast_blas_build(s.c.blas, NULL, slot + 1, CLAST_BUILD_BEST));
    clast_tlas_instance instance = instance_of(s.c.blas, 0);
    assert_ok(context, clast_tlas_build(s.tlas, &instance, 1, CLAST_BUILD_BEST));
    clast_ray ray = {{0.31f, 0.45f, 1}, 0, {0, 0, -1}, INFINITY};
    assert_int_equal(trace(s.tlas, &ray).cluster, 0);
    ray.origin[0] = 5.31f;
    clast_hit hit = trace(s.tlas, &ray);
    assert_int_equal(hit.instance, 0);
    assert_int_equal(hit.cluster, slot);
    stage_end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(transformed_balls_are_hit_from_inside_and_keep_their_front),
        CONTEXT_TEST(normals_are_perpendicular_to_transformed_triangles),
        CONTEXT_TEST(distances_are_in_units_of_the_given_direction),
        CONTEXT_TEST(ties_go_to_the_lower_instance),
        CONTEXT_TEST(refused_hits_let_the_ray_pass),
        CONTEXT_TEST(grids_have_the_documented_corners),
        CONTEXT_TEST(templates_give_back_their_triangles),
        CONTEXT_TEST(reserved_slots_need_no_memory_later),
        CONTEXT_TEST(larger_templates_find_room_in_a_pool_of_small_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
