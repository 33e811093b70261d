// SPDX-License-Identifier: Apache-2.0
// The same bits whatever the instruction set, the threads, the batch, the order of instances, or the way a tree came about.
#include "test.h"

#include "accel/meshes.h"

enum { RAYS = 4000, INSTANCES = 9 };

typedef struct world {
    clustered terrain, ball;
    mesh terrain_mesh, ball_mesh;
    clast_tlas *tlas;
    clast_tlas_instance instances[INSTANCES];
} world;

static void make_instances(world *w)
{
    randoms r = {5};
    for (uint32_t i = 0; i < INSTANCES; i++) {
        w->instances[i] = instance_of(i % 2 == 0 ? w->terrain.blas : w->ball.blas, i / 2 * 3); // ids are shared
        for (uint32_t k = 0; k < 12 && i > 0; k++) {
            w->instances[i].transform[k / 4][k % 4] += random_between(&r, -0.7f, 0.7f);
        }
        if (i % 3 == 1) {
            for (uint32_t k = 0; k < 4; k++) {
                w->instances[i].transform[1][k] *= -1.0f; // a mirror
            }
        }
    }
    w->instances[INSTANCES - 1] = w->instances[2]; // on top of another: every hit is a tie
    w->instances[INSTANCES - 1].id = 1;
}

static world make_world(clast_context *context)
{
    world w = {.terrain_mesh = mesh_terrain(60, 0.2f, 1), .ball_mesh = mesh_octasphere(4)};
    mesh_displace(&w.ball_mesh, 0.3f, 2);
    assert_ok(context, clustered_make(context, &w.terrain_mesh, 128, &w.terrain));
    assert_ok(context, clustered_make(context, &w.ball_mesh, 100, &w.ball));
    assert_ok(context, clast_tlas_create(context, &w.tlas));
    make_instances(&w);
    assert_ok(context, clast_tlas_build(w.tlas, w.instances, INSTANCES, CLAST_BUILD_BEST));
    return w;
}

static void free_world(world *w)
{
    clast_tlas_destroy(w->tlas);
    clustered_free(&w->terrain);
    clustered_free(&w->ball);
    mesh_free(&w->terrain_mesh);
    mesh_free(&w->ball_mesh);
}

static clast_ray *make_rays(void)
{
    clast_ray *rays = malloc(RAYS * sizeof *rays);
    randoms r = {3};
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (clast_ray){.t_min = -0.5f, .t_max = i % 5 == 0 ? 1.0f : INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            rays[i].origin[axis] = random_between(&r, -2, 2);
            rays[i].direction[axis] = (i + axis) % 7 == 0 ? 0.0f : random_between(&r, -1, 1);
        }
    }
    return rays;
}

// Every third candidate counts, by its own numbers.
static bool is_accepted(void *user, const clast_ray *ray, const clast_hit *hit)
{
    (void)user;
    (void)ray;
    return (hit->triangle + hit->cluster + hit->instance) % 3 != 0;
}

static clast_hit *trace_all(const clast_tlas *tlas, const clast_ray *rays, bool filtered)
{
    clast_hit *hits = calloc(RAYS, sizeof *hits);
    clast_hit_filter filter = {is_accepted, NULL};
    clast_trace_closest(tlas, rays, RAYS, filtered ? &filter : NULL, hits);
    return hits;
}

static bool same_hit(const clast_hit *a, const clast_hit *b)
{
    if (a->instance == CLAST_NONE || b->instance == CLAST_NONE) {
        return a->instance == b->instance && a->steps == b->steps;
    }
    return memcmp(a, b, sizeof *a) == 0;
}

static void assert_same_hits(const clast_hit *a, const clast_hit *b)
{
    uint32_t found = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        assert_true(same_hit(&a[i], &b[i]));
        found += a[i].instance != CLAST_NONE;
    }
    assert_true(found > RAYS / 200);
}

static clast_hit *trace_in_context(clast_isa isa, uint32_t threads, const clast_ray *rays, bool filtered)
{
    clast_context *context;
    clast_hit *hits = NULL;
    clast_context_desc desc = {.isa = isa, .threads = threads};
    if (clast_context_create(&desc, &context) == CLAST_OK) {
        world w = make_world(context);
        for (uint32_t i = 0; i < INSTANCES; i++) {
            w.instances[i].filtered = filtered;
        }
        assert_ok(context, clast_tlas_build(w.tlas, w.instances, INSTANCES, CLAST_BUILD_BEST));
        hits = trace_all(w.tlas, rays, filtered);
        free_world(&w);
        clast_context_destroy(context);
    }
    return hits;
}

static void every_instruction_set_gives_the_same_hits(void **state)
{
    (void)state;
    clast_ray *rays = make_rays();
    for (int filtered = 0; filtered < 2; filtered++) {
        clast_hit *expected = trace_in_context(CLAST_ISA_PLAIN, 1, rays, filtered);
        assert_non_null(expected);
        for (int isa = CLAST_ISA_SSE42; isa <= CLAST_ISA_AVX512; isa++) {
            clast_hit *hits = trace_in_context((clast_isa)isa, 1, rays, filtered);
            if (hits != NULL) { // else the machine lacks it
                assert_same_hits(expected, hits);
            }
            free(hits);
        }
        free(expected);
    }
    free(rays);
}

static void every_number_of_threads_gives_the_same_hits(void **state)
{
    (void)state;
    clast_ray *rays = make_rays();
    clast_hit *expected = trace_in_context(CLAST_ISA_AUTOMATIC, 1, rays, false);
    for (uint32_t threads = 2; threads <= 5; threads += 3) {
        clast_hit *hits = trace_in_context(CLAST_ISA_AUTOMATIC, threads, rays, false);
        assert_same_hits(expected, hits);
        free(hits);
    }
    free(expected);
    free(rays);
}

static void single_rays_and_batches_give_the_same_hits(void **state)
{
    world w = make_world(*state);
    clast_ray *rays = make_rays();
    clast_hit *expected = trace_all(w.tlas, rays, false);
    uint8_t *occluded = malloc(RAYS);
    clast_trace_any(w.tlas, rays, RAYS, NULL, occluded);
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_hit hit;
        uint8_t any;
        memset(&hit, 0, sizeof hit);
        clast_trace_closest(w.tlas, &rays[i], 1, NULL, &hit);
        clast_trace_any(w.tlas, &rays[i], 1, NULL, &any);
        assert_true(same_hit(&hit, &expected[i]));
        assert_int_equal(any, hit.instance != CLAST_NONE);
        assert_int_equal(any, occluded[i]);
    }
    free(occluded);
    free(expected);
    free(rays);
    free_world(&w);
}

static void assert_same_surfaces(clast_hit *a, clast_hit *b)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        a[i].steps = b[i].steps = 0;
    }
    assert_same_hits(a, b);
}

static void the_order_of_instances_does_not_matter(void **state)
{
    clast_context *context = *state;
    world w = make_world(context);
    clast_ray *rays = make_rays();
    clast_hit *expected = trace_all(w.tlas, rays, false);
    clast_tlas_instance turned[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        turned[i] = w.instances[INSTANCES - 1 - i];
    }
    assert_ok(context, clast_tlas_build(w.tlas, turned, INSTANCES, CLAST_BUILD_BEST));
    clast_hit *hits = trace_all(w.tlas, rays, false);
    assert_same_surfaces(expected, hits);
    free(hits);
    free(expected);
    free(rays);
    free_world(&w);
}

static void a_refitted_tree_gives_the_hits_of_a_built_one(void **state)
{
    clast_context *context = *state;
    world w = make_world(context);
    clast_ray *rays = make_rays();
    mesh_displace(&w.ball_mesh, 0.5f, 77);
    mesh_transform(&w.ball_mesh, 1.3f, 0.1f, 0.2f, 0.3f);
    clustered_gather(&w.ball, &w.ball_mesh);
    uint64_t before = clast_context_memory_peak(context), held = clast_context_memory(context);
    assert_ok(context, clast_clas_refit(w.ball.pool, 0, w.ball.cluster_count));
    assert_ok(context, clast_blas_refit(w.ball.blas));
    assert_int_equal(clast_context_memory(context), held); // and nothing for a moment, either
    assert_int_equal(clast_context_memory_peak(context), before);
    assert_ok(context, clast_tlas_build(w.tlas, w.instances, INSTANCES, CLAST_BUILD_BEST));
    clast_hit *refitted = trace_all(w.tlas, rays, false);
    assert_ok(context, clast_blas_build(w.ball.blas, NULL, w.ball.cluster_count, CLAST_BUILD_BEST));
    assert_ok(context, clast_tlas_build(w.tlas, w.instances, INSTANCES, CLAST_BUILD_BEST));
    clast_hit *built = trace_all(w.tlas, rays, false);
    assert_same_surfaces(refitted, built);
    free(refitted);
    free(built);
    free(rays);
    free_world(&w);
}

static void trees_share_the_clusters_of_a_pool(void **state)
{
    clast_context *context = *state;
    world w = make_world(context);
    clast_blas *parts[2];
    uint32_t *slots = malloc(4 * (size_t)w.terrain.cluster_count);
    clast_tlas_instance instances[2];
    for (uint32_t part = 0; part < 2; part++) { // every other cluster
        uint32_t count = 0;
        for (uint32_t i = part; i < w.terrain.cluster_count; i += 2) {
            slots[count++] = i;
        }
        assert_ok(context, clast_blas_create(w.terrain.pool, &parts[part]));
        assert_ok(context, clast_blas_build(parts[part], slots, count, CLAST_BUILD_BEST));
        instances[part] = instance_of(parts[part], 4);
    }
    clast_ray *rays = make_rays();
    assert_ok(context, clast_tlas_build(w.tlas, instances, 2, CLAST_BUILD_BEST));
    clast_hit *in_parts = trace_all(w.tlas, rays, false);
    instances[0] = instance_of(w.terrain.blas, 4);
    assert_ok(context, clast_tlas_build(w.tlas, instances, 1, CLAST_BUILD_BEST));
    clast_hit *whole = trace_all(w.tlas, rays, false);
    assert_same_surfaces(whole, in_parts);
    free(whole);
    free(in_parts);
    free(rays);
    free(slots);
    clast_blas_destroy(parts[0]);
    clast_blas_destroy(parts[1]);
    free_world(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_gives_the_same_hits),
        cmocka_unit_test(every_number_of_threads_gives_the_same_hits),
        CONTEXT_TEST(single_rays_and_batches_give_the_same_hits),
        CONTEXT_TEST(the_order_of_instances_does_not_matter),
        CONTEXT_TEST(a_refitted_tree_gives_the_hits_of_a_built_one),
        CONTEXT_TEST(trees_share_the_clusters_of_a_pool),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
