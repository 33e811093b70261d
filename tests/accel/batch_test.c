// SPDX-License-Identifier: Apache-2.0
// Rays in batches of any size hit what they hit alone, whatever the instruction set: alike rays and others, the nearest hit and
// any, with filters, with broken rays among them.
#include "test.h"

#include "accel/meshes.h"

#if defined(__x86_64__)
enum { RAYS = 1500 };
#else
enum { RAYS = 400 }; // perhaps under emulation
#endif
enum { INSTANCES = 12, KINDS = 3 };

typedef struct world {
    clustered terrain, ball;
    mesh terrain_mesh, ball_mesh;
    clast_tlas *tlas;
} world;

// Instances overlap, share ids, are mirrored, and one lies exactly on another.
static world make_world(clast_context *context, uint32_t instance_count)
{
    world w = {.terrain_mesh = mesh_terrain(50, 0.2f, 1), .ball_mesh = mesh_octasphere(4)};
    clast_tlas_instance instances[INSTANCES];
    randoms r = {5};
    mesh_displace(&w.ball_mesh, 0.3f, 2);
    assert_ok(context, clustered_make(context, &w.terrain_mesh, 128, &w.terrain));
    assert_ok(context, clustered_make(context, &w.ball_mesh, 60, &w.ball));
    for (uint32_t i = 0; i < instance_count; i++) {
        instances[i] = instance_of(i % 2 == 0 ? w.terrain.blas : w.ball.blas, i / 2 * 3);
        instances[i].filtered = i % 4 != 3;
        for (uint32_t k = 0; k < 12 && i > 0; k++) {
            instances[i].transform[k / 4][k % 4] += random_between(&r, -0.7f, 0.7f);
        }
        for (uint32_t k = 0; k < 4 && i % 3 == 1; k++) {
            instances[i].transform[1][k] *= -1.0f;
        }
    }
    if (instance_count > 3) {
        instances[instance_count - 1] = instances[2];
        instances[instance_count - 1].id = 1;
    }
    assert_ok(context, clast_tlas_create(context, &w.tlas));
    assert_ok(context, clast_tlas_build(w.tlas, instances, instance_count, CLAST_BUILD_BEST));
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

// A camera's rays: 64 that go together, then 64 elsewhere.
static clast_ray camera_ray(uint32_t i)
{
    uint32_t tile = i / 64 * 11 % 24, x = i % 8 + tile % 6 * 16, y = i / 8 % 8 + tile / 6 * 16;
    clast_ray ray = {{0.3f, 0.4f, 3.0f}, 0, {0, 0, -1}, INFINITY};
    ray.direction[0] = ((float)x - 48.0f) / 96.0f;
    ray.direction[1] = ((float)y - 32.0f) / 96.0f;
    return ray;
}

static clast_ray random_ray(randoms *r)
{
    clast_ray ray = {.t_min = random_below(r, 4) == 0 ? -0.5f : 0.0f,
                     .t_max = random_below(r, 4) == 0 ? random_float(r) : INFINITY};
    for (uint32_t axis = 0; axis < 3; axis++) {
        ray.origin[axis] = random_between(r, -2, 2);
        ray.direction[axis] = random_below(r, 7) == 0 ? 0.0f : random_between(r, -1, 1);
    }
    return ray;
}

// Kinds: alike, unlike, and a mixture with many that cannot hit anything.
static clast_ray *make_rays(uint32_t kind)
{
    clast_ray *rays = malloc(RAYS * sizeof *rays);
    randoms r = {3};
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = kind == 0 || (kind == 2 && random_below(&r, 2) == 0) ? camera_ray(i) : random_ray(&r);
        if (kind == 2 && random_below(&r, 6) == 0) {
            const float broken[] = {NAN, INFINITY, 0.0f, 1e30f, -1e-42f};
            float *place = random_below(&r, 2) == 0 ? rays[i].origin : rays[i].direction;
            place[random_below(&r, 3)] = broken[random_below(&r, 5)];
            rays[i].t_max = random_below(&r, 4) == 0 ? NAN : rays[i].t_max;
        }
    }
    return rays;
}

// By the hit's own numbers, and the ray's: a ray's filter must see the ray itself.
static bool is_accepted(void *user, const clast_ray *ray, const clast_hit *hit)
{
    (void)user;
    return (hit->triangle + hit->cluster + hit->instance + (ray->direction[0] > 0.0f ? 1u : 0u)) % 3 != 0;
}

static void assert_same(const clast_hit *hit, const clast_hit *expected)
{
    assert_int_equal(hit->instance, expected->instance);
    if (hit->instance != CLAST_NONE) {
        clast_hit a = *hit, b = *expected;
        a.steps = b.steps = 0; // batches may share nodes
        assert_memory_equal(&a, &b, sizeof a);
    }
}

typedef struct results {
    clast_hit hits[RAYS];
    uint8_t occluded[RAYS];
} results;

static void trace_by(const world *w, const clast_ray *rays, const clast_hit_filter *filter, uint32_t batch, results *r)
{
    memset(r, 0xaa, sizeof *r);
    for (uint32_t i = 0; i < RAYS; i += batch) {
        uint32_t count = RAYS - i < batch ? RAYS - i : batch;
        clast_trace_closest(w->tlas, rays + i, count, filter, r->hits + i);
        clast_trace_any(w->tlas, rays + i, count, filter, r->occluded + i);
    }
}

static void compare_batches(const world *w, const clast_ray *rays, const clast_hit_filter *filter,
                            const results *expected)
{
    static const uint32_t batches[] = {1, 2, 7, 16, 64, 1000, RAYS};
    results *r = malloc(sizeof *r);
    for (size_t k = 0; k < sizeof batches / sizeof batches[0]; k++) {
        trace_by(w, rays, filter, batches[k], r);
        for (uint32_t i = 0; i < RAYS; i++) {
            assert_same(&r->hits[i], &expected->hits[i]);
            assert_int_equal(r->occluded[i], expected->hits[i].instance != CLAST_NONE);
        }
    }
    free(r);
}

static void compare_all(uint32_t instance_count)
{
    static const clast_isa isas[] = {
#define ENTRY(name, value, text) name,
        CLAST_ISA_LIST(ENTRY)
#undef ENTRY
    };
    const clast_hit_filter filter = {is_accepted, NULL};
    results *expected = malloc(sizeof *expected * KINDS * 2);
    for (size_t k = 0; k < sizeof isas / sizeof isas[0]; k++) {
        clast_context *context;
        clast_context_desc desc = {.isa = isas[k], .threads = 1};
        if (clast_context_create(&desc, &context) != CLAST_OK) {
            continue; // the machine lacks it
        }
        world w = make_world(context, instance_count);
        for (uint32_t kind = 0; kind < KINDS * 2; kind++) {
            clast_ray *rays = make_rays(kind / 2);
            const clast_hit_filter *used = kind % 2 == 0 ? NULL : &filter;
            if (k == 0) { // the plain one, ray by ray
                trace_by(&w, rays, used, 1, &expected[kind]);
            }
            compare_batches(&w, rays, used, &expected[kind]);
            free(rays);
        }
        free_world(&w);
        clast_context_destroy(context);
    }
    uint32_t found = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        found += expected[0].hits[i].instance != CLAST_NONE;
    }
    assert_true(found > RAYS / 20);
    free(expected);
}

static void batches_give_the_hits_of_single_rays(void **state)
{
    (void)state;
    compare_all(INSTANCES);
}

static void batches_give_the_hits_of_single_rays_at_one_instance(void **state)
{
    (void)state;
    compare_all(1);
}

static void an_empty_batch_does_nothing(void **state)
{
    world w = make_world(*state, 2);
    clast_ray ray = camera_ray(0);
    clast_hit hit, before;
    uint8_t occluded = 7;
    memset(&hit, 0x55, sizeof hit);
    before = hit;
    clast_trace_closest(w.tlas, &ray, 0, NULL, &hit);
    clast_trace_any(w.tlas, &ray, 0, NULL, &occluded);
    assert_memory_equal(&hit, &before, sizeof hit);
    assert_int_equal(occluded, 7);
    free_world(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_give_the_hits_of_single_rays),
        cmocka_unit_test(batches_give_the_hits_of_single_rays_at_one_instance),
        CONTEXT_TEST(an_empty_batch_does_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
