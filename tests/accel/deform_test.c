// SPDX-License-Identifier: Apache-2.0
// Meshes that deform: whatever the watch does to clusters and tree, the same triangles are hit as in a fresh structure.
#include "test.h"

#include "accel/meshes.h"
#include "accel/tap.h"
#include "clast/deform.h"

enum { FRAMES = 24, RAYS = 600 };

// A mesh at a moment: turned about the z axis, the more so the higher.
static void twist(const mesh *m, float amount, float *moved)
{
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        const float *p = m->positions + 3 * (size_t)i;
        float angle = 3.1415927f * amount * p[2] * 2.0f, c = cosf(angle), s = sinf(angle);
        moved[3 * (size_t)i] = p[0] * c - p[1] * s;
        moved[3 * (size_t)i + 1] = p[0] * s + p[1] * c;
        moved[3 * (size_t)i + 2] = p[2];
    }
}

static clast_deforming_mesh_desc desc_of(const mesh *m, const float *positions)
{
    return (clast_deforming_mesh_desc){.positions = positions,
                                       .position_count = m->vertex_count,
                                       .indices = m->indices,
                                       .triangle_count = m->triangle_count};
}

static clast_deforming_mesh *make(clast_context *context, const mesh *m, const float *positions, uint32_t budget,
                                  bool unwatched)
{
    clast_deforming_mesh *made;
    clast_deforming_mesh_desc desc = desc_of(m, positions);
    desc.watch_budget = budget;
    desc.unwatched = unwatched;
    assert_ok(context, clast_deforming_mesh_create(context, &desc, &made));
    return made;
}

static clast_tlas *tlas_of(clast_context *context, const clast_deforming_mesh *deforming)
{
    clast_tlas *tlas;
    clast_tlas_instance instance = instance_of(clast_deforming_mesh_blas(deforming), 0);
    assert_ok(context, clast_tlas_create(context, &tlas));
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    return tlas;
}

static clast_ray random_ray(randoms *r, float extent)
{
    clast_ray ray = {.t_max = INFINITY};
    for (uint32_t axis = 0; axis < 3; axis++) {
        ray.origin[axis] = random_between(r, -extent, extent);
        ray.direction[axis] = random_between(r, -1, 1);
    }
    return ray;
}

// The hit is where its triangle is, by the user's numbers.
static void assert_on_triangle(const mesh *m, const float *positions, uint32_t triangle, const clast_ray *ray,
                               const clast_hit *hit)
{
    assert_true(triangle < m->triangle_count);
    const uint32_t *corner = m->indices + 3 * (size_t)triangle;
    for (uint32_t axis = 0; axis < 3; axis++) {
        float there = positions[3 * (size_t)corner[0] + axis] * (1.0f - hit->u - hit->v) +
                      positions[3 * (size_t)corner[1] + axis] * hit->u +
                      positions[3 * (size_t)corner[2] + axis] * hit->v;
        assert_true(fabsf(ray->origin[axis] + hit->t * ray->direction[axis] - there) < 1e-3f);
    }
}

static void assert_same_hits(clast_context *context, const mesh *m, const float *positions,
                             const clast_deforming_mesh *deforming, uint64_t seed)
{
    clast_deforming_mesh *fresh = make(context, m, positions, 0, true);
    clast_tlas *tlas = tlas_of(context, deforming), *fresh_tlas = tlas_of(context, fresh);
    randoms r = {seed};
    uint32_t hits = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray ray = random_ray(&r, 1.5f);
        clast_hit hit, expected;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        clast_trace_closest(fresh_tlas, &ray, 1, NULL, &expected);
        assert_int_equal(hit.instance, expected.instance);
        if (hit.instance != CLAST_NONE) {
            hits++;
            assert_memory_equal(&hit.t, &expected.t, sizeof hit.t);
            assert_on_triangle(m, positions, clast_deforming_mesh_triangle(deforming, hit.cluster, hit.triangle), &ray,
                               &hit);
        }
    }
    assert_true(hits > RAYS / 20);
    clast_tlas_destroy(tlas);
    clast_tlas_destroy(fresh_tlas);
    clast_deforming_mesh_destroy(fresh);
}

// Each triangle of the mesh is in some cluster, and once.
static void assert_permutation(const clast_deforming_mesh *deforming, uint32_t triangle_count)
{
    uint8_t *seen = calloc(triangle_count, 1);
    uint32_t found = 0;
    for (uint32_t cluster = 0; cluster < triangle_count; cluster++) {
        for (uint32_t i = 0; i < 256; i++) {
            uint32_t triangle = clast_deforming_mesh_triangle(deforming, cluster, i);
            if (triangle != CLAST_NONE) {
                assert_true(triangle < triangle_count);
                assert_int_equal(seen[triangle]++, 0);
                found++;
            }
        }
    }
    assert_int_equal(found, triangle_count);
    free(seen);
}

static void hits_stay_those_of_a_fresh_mesh(clast_context *context, mesh m, uint32_t budget)
{
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    clast_deforming_mesh *deforming = make(context, &m, m.positions, budget, false);
    uint32_t changed = 0, trees = 0;
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        clast_deforming_mesh_statistics statistics;
        twist(&m, (float)frame / FRAMES, moved);
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, &statistics));
        changed += statistics.changed_clusters;
        trees += statistics.tree_replaced;
        if (frame % 4 == 0) {
            assert_permutation(deforming, m.triangle_count);
            assert_same_hits(context, &m, moved, deforming, frame);
        }
    }
    assert_true(changed > 0 && trees > 0);
    clast_deforming_mesh_destroy(deforming);
    free(moved);
    mesh_free(&m);
}

static void a_twisted_torus_is_hit_as_a_fresh_one(void **state)
{
    hits_stay_those_of_a_fresh_mesh(*state, mesh_torus(160, 80, 0.7f, 0.3f), 8000);
}

static void a_twisted_soup_is_hit_as_a_fresh_one(void **state)
{
    hits_stay_those_of_a_fresh_mesh(*state, mesh_soup(12000, 0.05f, 3), 100000);
}

static void the_watch_keeps_rays_fast(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(300, 100, 0.7f, 0.3f);
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    clast_deforming_mesh *watched = make(context, &m, m.positions, 0, false);
    clast_deforming_mesh *unwatched = make(context, &m, m.positions, 0, true);
    for (uint32_t frame = 1; frame <= 2 * FRAMES; frame++) {
        clast_deforming_mesh_statistics statistics;
        twist(&m, (float)frame / FRAMES, moved);
        assert_ok(context, clast_deforming_mesh_update(watched, moved, NULL));
        assert_ok(context, clast_deforming_mesh_update(unwatched, moved, &statistics));
        assert_int_equal(statistics.cut_triangles + statistics.sorted_clusters, 0);
    }
    clast_tlas *tlas = tlas_of(context, watched), *other = tlas_of(context, unwatched);
    uint64_t steps = 0, other_steps = 0;
    randoms r = {5};
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray ray = random_ray(&r, 1.0f);
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        steps += hit.steps;
        clast_trace_closest(other, &ray, 1, NULL, &hit);
        other_steps += hit.steps;
    }
    assert_true(10 * steps < 8 * other_steps);
    clast_tlas_destroy(tlas);
    clast_tlas_destroy(other);
    clast_deforming_mesh_destroy(watched);
    clast_deforming_mesh_destroy(unwatched);
    free(moved);
    mesh_free(&m);
}

// What a mesh in a context of so many threads comes to, as a hash.
static uint64_t hash_with(const mesh *m, uint32_t threads)
{
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads}, &context), CLAST_OK);
    float *moved = malloc(((size_t)m->vertex_count + 1) * 12);
    clast_deforming_mesh *deforming = make(context, m, m->positions, 20000, false);
    uint64_t hash = 1469598103934665603u;
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        clast_deforming_mesh_statistics statistics;
        twist(m, (float)frame / FRAMES, moved);
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, &statistics));
        uint32_t area;
        memcpy(&area, &statistics.tree_area, sizeof area);
        hash = (hash ^ statistics.cut_triangles) * 1099511628211u;
        hash = (hash ^ statistics.changed_clusters) * 1099511628211u;
        hash = (hash ^ area) * 1099511628211u;
    }
    clast_tlas *tlas = tlas_of(context, deforming);
    randoms r = {7};
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray ray = random_ray(&r, 1.0f);
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        hash = (hash ^ hit.steps) * 1099511628211u;
        if (hit.instance != CLAST_NONE) {
            hash = (hash ^ hit.cluster) * 1099511628211u;
            hash = (hash ^ hit.triangle) * 1099511628211u;
        }
    }
    clast_tlas_destroy(tlas);
    clast_deforming_mesh_destroy(deforming);
    clast_context_destroy(context);
    free(moved);
    return hash;
}

static void the_number_of_threads_changes_nothing(void **state)
{
    (void)state;
    mesh m = mesh_torus(200, 80, 0.7f, 0.3f);
    uint64_t hash = hash_with(&m, 1);
    assert_true(hash_with(&m, 2) == hash);
    assert_true(hash_with(&m, 5) == hash);
    mesh_free(&m);
}

static void a_budget_is_kept(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(300, 100, 0.7f, 0.3f);
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    const uint32_t budgets[3] = {300, 5000, 20000};
    for (uint32_t i = 0; i < 3; i++) {
        clast_deforming_mesh *deforming = make(context, &m, m.positions, budgets[i], false);
        uint32_t most = budgets[i] > 1024 ? budgets[i] : 1024, cut = 0; // a piece at a time
        for (uint32_t frame = 1; frame <= FRAMES; frame++) {
            clast_deforming_mesh_statistics statistics;
            twist(&m, (float)frame / FRAMES, moved);
            assert_ok(context, clast_deforming_mesh_update(deforming, moved, &statistics));
            assert_true(statistics.cut_triangles <= most);
            assert_true(statistics.cut_triangles == 0 || statistics.sorted_clusters == 0);
            cut += statistics.cut_triangles;
            assert_true(cut <= frame * budgets[i] + most);
        }
        assert_true(cut > 0);
        clast_deforming_mesh_destroy(deforming);
    }
    free(moved);
    mesh_free(&m);
}

static void a_mesh_at_rest_is_left_alone(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(160, 80, 0.7f, 0.3f);
    clast_deforming_mesh *deforming = make(context, &m, m.positions, 0, false);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        clast_deforming_mesh_statistics statistics;
        assert_ok(context, clast_deforming_mesh_update(deforming, m.positions, &statistics));
        assert_int_equal(statistics.cut_triangles + statistics.sorted_clusters, 0);
        assert_true(statistics.tree_area > 0.0f);
    }
    clast_deforming_mesh_destroy(deforming);
    mesh_free(&m);
}

static void no_ray_leaves_a_twisted_closed_mesh(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(6);
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    clast_deforming_mesh *deforming = make(context, &m, m.positions, 4000, false);
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        twist(&m, (float)frame / FRAMES, moved);
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, NULL));
    }
    clast_tlas *tlas = tlas_of(context, deforming);
    for (uint32_t i = 0; i < m.vertex_count; i++) { // at all vertices
        clast_ray ray = {.t_max = INFINITY};
        memcpy(ray.direction, moved + 3 * (size_t)i, sizeof ray.direction);
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, 0);
    }
    clast_tlas_destroy(tlas);
    clast_deforming_mesh_destroy(deforming);
    free(moved);
    mesh_free(&m);
}

static void positions_that_are_not_finite_are_not_hit(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(160, 80, 0.7f, 0.3f);
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    clast_deforming_mesh *deforming = make(context, &m, m.positions, 100000, false);
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        twist(&m, (float)frame / FRAMES, moved);
        for (uint32_t i = frame; frame < FRAMES && i < m.vertex_count; i += 37) {
            moved[3 * (size_t)i + i % 3] = i % 2 == 0 ? NAN : frame % 2 == 0 ? INFINITY : 3e38f;
        }
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, NULL));
    }
    assert_permutation(deforming, m.triangle_count);
    assert_same_hits(context, &m, moved, deforming, 9); // all came back
    for (uint32_t i = 0; i < 3 * m.vertex_count; i++) {
        moved[i] = NAN;
    }
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, NULL));
    }
    clast_tlas *tlas = tlas_of(context, deforming);
    clast_ray ray = {.direction = {1, 0, 0}, .t_max = INFINITY};
    clast_hit hit;
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    assert_int_equal(hit.instance, CLAST_NONE);
    clast_tlas_destroy(tlas);
    clast_deforming_mesh_destroy(deforming);
    free(moved);
    mesh_free(&m);
}

static void any_scale_will_do(void **state)
{
    clast_context *context = *state;
    const float scales[3] = {1e-20f, 1e20f, 1e-34f};
    for (uint32_t i = 0; i < 3; i++) {
        mesh m = mesh_torus(100, 40, 0.7f, 0.3f);
        float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
        clast_deforming_mesh *deforming = NULL;
        for (uint32_t frame = 0; frame <= FRAMES; frame++) {
            twist(&m, 2.0f * (float)frame / FRAMES, moved);
            for (uint32_t k = 0; k < 3 * m.vertex_count; k++) {
                moved[k] *= scales[i];
            }
            if (frame == 0) {
                deforming = make(context, &m, moved, 0, false);
            }
            assert_ok(context, clast_deforming_mesh_update(deforming, moved, NULL));
        }
        clast_tlas *tlas = tlas_of(context, deforming);
        clast_ray ray = {.origin = {0, 0, scales[i]}, .direction = {0.7f, 0.01f, -1}, .t_max = INFINITY};
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, 0);
        assert_permutation(deforming, m.triangle_count);
        clast_tlas_destroy(tlas);
        clast_deforming_mesh_destroy(deforming);
        free(moved);
        mesh_free(&m);
    }
}

static void small_meshes_work(void **state)
{
    clast_context *context = *state;
    const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint32_t indices[3] = {0, 1, 2};
    for (uint32_t count = 0; count <= 1; count++) {
        clast_deforming_mesh *deforming;
        clast_deforming_mesh_desc desc = {positions, 3, indices, count, 0, false};
        assert_ok(context, clast_deforming_mesh_create(context, &desc, &deforming));
        for (uint32_t frame = 0; frame < FRAMES; frame++) {
            assert_ok(context, clast_deforming_mesh_update(deforming, positions, NULL));
        }
        clast_tlas *tlas = tlas_of(context, deforming);
        clast_ray ray = {{0.2f, 0.2f, 1}, 0, {0, 0, -1}, INFINITY};
        clast_hit hit;
        clast_trace_closest(tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, count == 1 ? 0 : CLAST_NONE);
        assert_int_equal(clast_deforming_mesh_triangle(deforming, 0, 0), count == 1 ? 0 : CLAST_NONE);
        assert_true(clast_deforming_mesh_bytes(deforming) > 0);
        clast_tlas_destroy(tlas);
        clast_deforming_mesh_destroy(deforming);
    }
}

static void wrong_arguments_are_refused(void **state)
{
    clast_context *context = *state;
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t indices[3] = {0, 1, 3};
    clast_deforming_mesh *deforming;
    clast_deforming_mesh_desc desc = {positions, 3, indices, 1, 0, false};
    assert_int_equal(clast_deforming_mesh_create(context, &desc, &deforming), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_deforming_mesh_create(context, NULL, &deforming), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_deforming_mesh_create(NULL, &desc, &deforming), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_deforming_mesh_update(NULL, positions, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    desc.position_count = 4;
    mesh m = mesh_torus(4, 4, 1, 0.5f);
    deforming = make(context, &m, m.positions, 0, false);
    assert_int_equal(clast_deforming_mesh_update(deforming, NULL, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    clast_deforming_mesh_destroy(deforming);
    clast_deforming_mesh_destroy(NULL);
    assert_null(clast_deforming_mesh_blas(NULL));
    mesh_free(&m);
}

// -------------------------------------------------------------------------------------------------------------- memory

static void a_mesh_that_cannot_be_made_leaves_nothing(void **state)
{
    (void)state;
    mesh m = mesh_torus(40, 20, 0.7f, 0.3f);
    for (uint32_t failing = 0;; failing++) {
        tap t = {.left = UINT32_MAX};
        clast_context *context;
        clast_context_desc context_desc = {.memory = {tapped, &t}, .threads = 2};
        assert_int_equal(clast_context_create(&context_desc, &context), CLAST_OK);
        t.left = failing;
        clast_deforming_mesh *deforming;
        clast_deforming_mesh_desc desc = desc_of(&m, m.positions);
        clast_status status = clast_deforming_mesh_create(context, &desc, &deforming);
        if (status == CLAST_OK) {
            clast_deforming_mesh_destroy(deforming);
        }
        clast_context_destroy(context);
        assert_int_equal(t.held, 0);
        if (status == CLAST_OK) {
            assert_true(failing > 8);
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
    }
    mesh_free(&m);
}

static void an_update_allocates_nothing(void **state)
{
    (void)state;
    mesh m = mesh_torus(160, 80, 0.7f, 0.3f);
    float *moved = malloc(((size_t)m.vertex_count + 1) * 12);
    tap t = {.left = UINT32_MAX};
    clast_context *context;
    clast_context_desc context_desc = {.memory = {tapped, &t}, .threads = 2};
    assert_int_equal(clast_context_create(&context_desc, &context), CLAST_OK);
    clast_deforming_mesh *deforming = make(context, &m, m.positions, 8000, false);
    t.left = 0;
    int64_t held = t.held;
    uint32_t trees = 0;
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        clast_deforming_mesh_statistics statistics;
        twist(&m, (float)frame / FRAMES, moved);
        assert_ok(context, clast_deforming_mesh_update(deforming, moved, &statistics));
        trees += statistics.tree_replaced;
    }
    assert_true(trees > 0);
    assert_int_equal(t.left, 0);
    assert_int_equal(t.held, held);
    clast_deforming_mesh_destroy(deforming);
    clast_context_destroy(context);
    assert_int_equal(t.held, 0);
    free(moved);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_twisted_torus_is_hit_as_a_fresh_one),
        CONTEXT_TEST(a_twisted_soup_is_hit_as_a_fresh_one),
        CONTEXT_TEST(the_watch_keeps_rays_fast),
        cmocka_unit_test(the_number_of_threads_changes_nothing),
        CONTEXT_TEST(a_budget_is_kept),
        CONTEXT_TEST(a_mesh_at_rest_is_left_alone),
        CONTEXT_TEST(no_ray_leaves_a_twisted_closed_mesh),
        CONTEXT_TEST(positions_that_are_not_finite_are_not_hit),
        CONTEXT_TEST(any_scale_will_do),
        CONTEXT_TEST(small_meshes_work),
        CONTEXT_TEST(wrong_arguments_are_refused),
        cmocka_unit_test(a_mesh_that_cannot_be_made_leaves_nothing),
        cmocka_unit_test(an_update_allocates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
