// SPDX-License-Identifier: Apache-2.0
// Batches give the hits of single rays, to the bit: whatever their size, whatever they hold, on every instruction set.
#include "test.h"

#include "accel/batch.h"
#include "accel/meshes.h"

enum { SIDE = 40, RAYS = SIDE * SIDE, INSTANCES = 40 };

typedef struct world {
    clast_context *context;
    clustered terrain, ball;
    mesh terrain_mesh, ball_mesh;
    clast_tlas *tlas;
    clast_ray rays[RAYS];
    clast_hit expected[RAYS], found[RAYS];
    uint8_t occluded[RAYS];
    clast_hit_filter filter;
} world;

typedef void (*ray_maker)(world *w);

// Every third candidate does not count, by its own numbers.
static bool is_accepted(void *user, const clast_ray *ray, const clast_hit *hit)
{
    (void)ray;
    (void)user;
    return (hit->triangle + hit->cluster + hit->instance) % 3 != 0;
}

// `count` instances, and so many with nothing in them that there are `all`: batches take other ways through large trees.
static void build_instances(world *w, uint32_t count, uint32_t all)
{
    clast_tlas_instance *instances = calloc(all, sizeof *instances);
    randoms r = {5};
    for (uint32_t i = 0; i < count; i++) {
        instances[i] = instance_of(i % 2 == 0 ? w->terrain.blas : w->ball.blas, i / 2 * 3); // ids are shared
        instances[i].filtered = i % 4 != 3;
        for (uint32_t k = 0; k < 12 && i > 0; k++) {
            instances[i].transform[k / 4][k % 4] += random_between(&r, -0.7f, 0.7f);
        }
        if (i % 5 == 2) { // on top of another: every hit is a tie
            memcpy(instances[i].transform, instances[i - 2].transform, sizeof instances[i].transform);
            instances[i].id = instances[i - 2].id;
        }
    }
    assert_ok(w->context, clast_tlas_build(w->tlas, instances, all, CLAST_BUILD_BEST));
    free(instances);
}

static world *make_world(clast_isa isa)
{
    world *w = calloc(1, sizeof *w);
    if (clast_context_create(&(clast_context_desc){.isa = isa, .threads = 1}, &w->context) != CLAST_OK) {
        free(w);
        return NULL; // the machine lacks it
    }
    w->terrain_mesh = mesh_terrain(60, 0.2f, 1);
    w->ball_mesh = mesh_octasphere(4);
    mesh_displace(&w->ball_mesh, 0.3f, 2);
    assert_ok(w->context, clustered_make(w->context, &w->terrain_mesh, 256, &w->terrain)); // two groups of blocks
    assert_ok(w->context, clustered_make(w->context, &w->ball_mesh, 100, &w->ball));
    assert_ok(w->context, clast_tlas_create(w->context, &w->tlas));
    return w;
}

static void free_world(world *w)
{
    clast_tlas_destroy(w->tlas);
    clustered_free(&w->terrain);
    clustered_free(&w->ball);
    mesh_free(&w->terrain_mesh);
    mesh_free(&w->ball_mesh);
    clast_context_destroy(w->context);
    free(w);
}

// ---------------------------------------------------------------------------------------------------------------- rays

// A camera's, line by line. Its axis is one of the world's, so that the main axis of directions changes within packets,
// and rays pass exactly through edges of the terrain.
static void camera_rays(world *w)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        float x = (float)(i % SIDE) / (SIDE / 2) - 1.0f, y = (float)(i / SIDE) / (SIDE / 2) - 1.0f;
        w->rays[i] = (clast_ray){.origin = {0.5f, 0.5f, 2.0f}, .direction = {x, y, -1.0f}, .t_max = INFINITY};
    }
}

// From a surface to a lamp: origins differ.
static void lamp_rays(world *w)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        float x = (float)(i % SIDE) / SIDE, y = (float)(i / SIDE) / SIDE;
        w->rays[i] = (clast_ray){.origin = {x, y, -0.4f}, .direction = {0.3f - x, 0.6f - y, 2.0f}, .t_max = 1.0f};
    }
}

// Parallel.
static void sun_rays(world *w)
{
    lamp_rays(w);
    for (uint32_t i = 0; i < RAYS; i++) {
        w->rays[i].direction[0] = w->rays[i].direction[1] = 0.0f;
        w->rays[i].t_min = 0.05f;
    }
}

static void scattered_rays(world *w)
{
    randoms r = {3};
    for (uint32_t i = 0; i < RAYS; i++) {
        w->rays[i] = (clast_ray){.t_min = i % 3 == 0 ? -0.5f : 0.0f, .t_max = i % 5 == 0 ? 1.0f : INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            w->rays[i].origin[axis] = random_between(&r, -2, 2);
            w->rays[i].direction[axis] = (i + axis) % 7 == 0 ? 0.0f : random_between(&r, -1, 1);
        }
    }
}

// Runs of both kinds, and within runs of like rays some that are not: of other lengths, from behind, and none at all.
static void mixed_rays(world *w)
{
    static const float lengths[] = {1e-25f, 1e-12f, 1.0f, 1e12f, 1e25f};
    static clast_ray scattered[RAYS];
    scattered_rays(w);
    memcpy(scattered, w->rays, sizeof scattered);
    camera_rays(w);
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_ray *ray = &w->rays[i];
        if (i / 100 % 3 == 0 || i % 37 == 5) {
            *ray = scattered[i];
        } else if (i % 11 == 3) {
            ray->t_min = -1.0f;
        } else if (i % 29 == 4) {
            ray->direction[i % 3] = NAN;
        } else if (i % 31 == 4) {
            ray->origin[i % 3] = i % 2 == 0 ? INFINITY : NAN;
        } else if (i % 23 == 4) {
            ray->t_max = i % 2 == 0 ? NAN : -1.0f;
        } else if (i % 7 == 4) {
            for (int axis = 0; axis < 3; axis++) {
                ray->direction[axis] *= lengths[i % 5];
            }
        }
    }
}

static const ray_maker makers[] = {camera_rays, lamp_rays, sun_rays, scattered_rays, mixed_rays};
enum { MAKERS = sizeof makers / sizeof makers[0] };

// ---------------------------------------------------------------------------------------------------------- comparison

static bool is_same_hit(clast_hit a, clast_hit b)
{
    a.steps = b.steps = 0;
    return a.instance == CLAST_NONE ? b.instance == CLAST_NONE : memcmp(&a, &b, sizeof a) == 0;
}

static const clast_hit_filter *filter_of(world *w, bool filtered)
{
    w->filter.accepts = is_accepted;
    return filtered ? &w->filter : NULL;
}

static uint32_t trace_singly(world *w, const clast_hit_filter *filter)
{
    uint32_t hits = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        clast_trace_closest(w->tlas, &w->rays[i], 1, filter, &w->expected[i]);
        hits += w->expected[i].instance != CLAST_NONE;
    }
    return hits;
}

static void assert_batches_agree(world *w, const clast_hit_filter *filter, uint32_t size)
{
    for (uint32_t first = 0; first < RAYS; first += size) {
        uint32_t count = RAYS - first < size ? RAYS - first : size;
        clast_trace_closest(w->tlas, w->rays + first, count, filter, w->found + first);
        clast_trace_any(w->tlas, w->rays + first, count, filter, w->occluded + first);
    }
    for (uint32_t i = 0; i < RAYS; i++) {
        assert_true(is_same_hit(w->found[i], w->expected[i]));
        assert_int_equal(w->occluded[i], w->expected[i].instance != CLAST_NONE);
    }
}

static void assert_all_agree(world *w, bool filtered)
{
    static const uint32_t sizes[] = {2, 7, 16, 64, 65, 1000, RAYS};
    const clast_hit_filter *filter = filter_of(w, filtered);
    for (int maker = 0; maker < MAKERS; maker++) {
        makers[maker](w);
        assert_true(trace_singly(w, filter) > RAYS / 200);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
            assert_batches_agree(w, filter, sizes[i]);
        }
    }
}

static void for_all_sets(uint32_t instances, bool filtered)
{
    for (int isa = CLAST_ISA_PLAIN; isa <= CLAST_ISA_AVX512; isa++) {
        world *w = make_world((clast_isa)isa);
        if (w != NULL) {
            build_instances(w, instances, instances);
            assert_all_agree(w, filtered);
            build_instances(w, instances, STREAM_CLUSTERS);
            assert_all_agree(w, filtered);
            free_world(w);
        }
    }
}

static void batches_give_the_hits_of_single_rays(void **state)
{
    (void)state;
    for_all_sets(1, false);
}

static void batches_give_the_hits_of_single_rays_through_many_instances(void **state)
{
    (void)state;
    for_all_sets(INSTANCES, false);
}

static void batches_give_the_hits_of_single_rays_through_a_filter(void **state)
{
    (void)state;
    for_all_sets(INSTANCES, true);
}

static clast_hit *hits_of_set(clast_isa isa, ray_maker maker)
{
    world *w = make_world(isa);
    if (w == NULL) {
        return NULL;
    }
    build_instances(w, INSTANCES, STREAM_CLUSTERS);
    maker(w);
    clast_hit *hits = calloc(RAYS, sizeof *hits);
    clast_trace_closest(w->tlas, w->rays, RAYS, NULL, hits);
    free_world(w);
    return hits;
}

// Pictures of steps must not depend on the machine.
static void every_instruction_set_takes_the_same_steps(void **state)
{
    (void)state;
    for (int maker = 0; maker < MAKERS; maker++) {
        clast_hit *expected = hits_of_set(CLAST_ISA_PLAIN, makers[maker]);
        for (int isa = CLAST_ISA_SSE42; isa <= CLAST_ISA_AVX512; isa++) {
            clast_hit *hits = hits_of_set((clast_isa)isa, makers[maker]);
            for (uint32_t i = 0; i < RAYS && hits != NULL; i++) {
                assert_true(is_same_hit(hits[i], expected[i]));
                assert_int_equal(hits[i].steps, expected[i].steps);
            }
            free(hits);
        }
        free(expected);
    }
}

// Scenes of sizes that packets do not take, and nothing at all.
static void batches_of_scenes_of_any_size_agree(void **state)
{
    (void)state;
    world *w = make_world(CLAST_ISA_AUTOMATIC);
    static const float sizes[] = {1e-30f, 1e-20f, 1e-10f, 1e10f, 1e20f, 1e30f};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        clast_tlas_instance instance = instance_of(w->terrain.blas, 0);
        for (int axis = 0; axis < 3; axis++) {
            instance.transform[axis][axis] = sizes[i];
        }
        assert_ok(w->context, clast_tlas_build(w->tlas, &instance, 1, CLAST_BUILD_BEST));
        camera_rays(w);
        for (uint32_t k = 0; k < 3 * RAYS; k++) {
            w->rays[k / 3].origin[k % 3] *= sizes[i];
        }
        assert_true(trace_singly(w, NULL) > RAYS / 50);
        assert_batches_agree(w, NULL, RAYS);
    }
    assert_ok(w->context, clast_tlas_build(w->tlas, NULL, 0, CLAST_BUILD_BEST));
    assert_int_equal(trace_singly(w, NULL), 0);
    assert_batches_agree(w, NULL, RAYS);
    free_world(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_give_the_hits_of_single_rays),
        cmocka_unit_test(batches_give_the_hits_of_single_rays_through_many_instances),
        cmocka_unit_test(batches_give_the_hits_of_single_rays_through_a_filter),
        cmocka_unit_test(every_instruction_set_takes_the_same_steps),
        cmocka_unit_test(batches_of_scenes_of_any_size_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
