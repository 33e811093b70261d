// SPDX-License-Identifier: Apache-2.0
// Rays through a device's scene hit what those of the processor hit, to the bit.
#include "test.h"

#include "accel/meshes.h"
#include "vulkan/device_scene.h"
#include "vulkan/rays.h"
#include "vulkan/test_device.h"

enum { RAYS = 2000 };

static test_device device;
static clast_gpu_trees *trees;

// ------------------------------------------------------------------------------------------------------------- tracing

typedef struct traced {
    clast_hit hits[RAYS];
    uint32_t occluded[RAYS];
} traced;

static void trace_there(const device_scene *scene, const clast_ray *rays, clast_gpu_rays_kind kind,
                        const clast_gpu_rays_tuning *tuning, traced *out)
{
    clast_gpu_buffer from, hits, flags, scratch;
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, device_upload(commands, rays, RAYS * sizeof *rays, &from));
    assert_ok(device.context, device_upload(commands, out->hits, sizeof out->hits, &hits));
    assert_ok(device.context, device_upload(commands, out->occluded, sizeof out->occluded, &flags));
    assert_ok(device.context, device_upload(commands, NULL, 0, &scratch));
    clast_gpu_barrier(commands);
    clast_gpu_rays call = {.scene = scene->scene.address,
                           .rays = from.address,
                           .to = hits.address,
                           .scratch = &scratch,
                           .count = RAYS,
                           .kind = kind,
                           .tuning = *tuning};
    clast_gpu_trace_closest(commands, &call);
    call.to = flags.address;
    clast_gpu_trace_any(commands, &call);
    clast_gpu_read(commands, &hits, 0, out->hits, sizeof out->hits);
    clast_gpu_read(commands, &flags, 0, out->occluded, sizeof out->occluded);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &from);
    clast_gpu_free(device.gpu, &hits);
    clast_gpu_free(device.gpu, &flags);
    clast_gpu_free(device.gpu, &scratch);
}

// Zeros may have either sign.
static bool same_float(float a, float b)
{
    return a == b || floatBitsToUint(a) == floatBitsToUint(b);
}

static void assert_same_hit(const clast_hit *a, const clast_hit *b)
{
    assert_int_equal(a->instance, b->instance);
    if (a->instance != CLAST_NONE) {
        assert_int_equal(a->cluster, b->cluster);
        assert_int_equal(a->triangle, b->triangle);
        assert_true(same_float(a->t, b->t) && same_float(a->u, b->u) && same_float(a->v, b->v));
        for (int axis = 0; axis < 3; axis++) {
            assert_true(same_float(a->normal[axis], b->normal[axis]));
        }
        assert_true(a->steps > 0);
    }
}

static const clast_gpu_rays_tuning plain_tuning;

// Traces on both, and compares; gives how many rays hit something. Trees are the processor's, or built on the device.
static uint32_t compare_with(const clast_tlas *tlas, const clast_ray *rays, clast_gpu_rays_kind kind,
                             const clast_gpu_rays_tuning *tuning, clast_gpu_trees *builder)
{
    traced *there = calloc(1, sizeof *there);
    clast_hit *here = calloc(RAYS, sizeof *here);
    uint8_t *occluded = calloc(RAYS, 1);
    device_scene scene;
    uint32_t found = 0;
    assert_ok(device.context, device_scene_make_with(device.gpu, tlas, NULL, builder, &scene));
    clast_trace_closest(tlas, rays, RAYS, NULL, here);
    clast_trace_any(tlas, rays, RAYS, NULL, occluded);
    trace_there(&scene, rays, kind, tuning, there);
    for (uint32_t i = 0; i < RAYS; i++) {
        assert_same_hit(&there->hits[i], &here[i]);
        assert_int_equal(there->occluded[i], occluded[i]);
        found += here[i].instance != CLAST_NONE;
    }
    device_scene_free(&scene);
    free(there);
    free(here);
    free(occluded);
    return found;
}

static uint32_t compare_as(const clast_tlas *tlas, const clast_ray *rays, clast_gpu_rays_kind kind,
                           const clast_gpu_rays_tuning *tuning)
{
    return compare_with(tlas, rays, kind, tuning, NULL);
}

static uint32_t compare(const clast_tlas *tlas, const clast_ray *rays)
{
    compare_with(tlas, rays, CLAST_GPU_RAYS_INCOHERENT, &plain_tuning, trees);
    return compare_as(tlas, rays, CLAST_GPU_RAYS_COHERENT, &plain_tuning);
}

// ---------------------------------------------------------------------------------------------------------------- rays

static clast_ray *random_rays(uint64_t seed, float reach)
{
    clast_ray *rays = malloc(RAYS * sizeof *rays);
    randoms r = {seed};
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (clast_ray){.t_min = i % 3 == 0 ? -0.5f : 0.0f, .t_max = i % 5 == 0 ? 1.0f : INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            rays[i].origin[axis] = reach * random_between(&r, -2, 2);
            rays[i].direction[axis] = (i + axis) % 7 == 0 ? 0.0f : random_between(&r, -1, 1);
        }
    }
    return rays;
}

// From anywhere towards corners and edges of a mesh: zeros among the edge functions, and ties.
static void aim_at_mesh(clast_ray *rays, const mesh *m, uint64_t seed)
{
    randoms r = {seed};
    for (uint32_t i = 0; i < RAYS; i++) {
        const uint32_t *corner = m->indices + 3 * (size_t)random_below(&r, m->triangle_count);
        const float *a = m->positions + 3 * (size_t)corner[0], *b = m->positions + 3 * (size_t)corner[1];
        for (uint32_t axis = 0; axis < 3; axis++) {
            float target = i % 2 == 0 ? a[axis] : 0.5f * (a[axis] + b[axis]);
            if (i % 4 < 2) { // straight down on it
                rays[i].origin[axis] = axis == 2 ? 3.0f : target;
                rays[i].direction[axis] = axis == 2 ? -1.0f : 0.0f;
            } else {
                rays[i].direction[axis] = target - rays[i].origin[axis];
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- scenes

typedef struct world {
    clustered parts[2];
    clast_tlas *tlas;
} world;

static void make_tlas(world *w, const clast_tlas_instance *instances, uint32_t count)
{
    assert_ok(device.context, clast_tlas_create(device.context, &w->tlas));
    assert_ok(device.context, clast_tlas_build(w->tlas, instances, count, CLAST_BUILD_BEST));
}

static void free_world(world *w)
{
    clast_tlas_destroy(w->tlas);
    clustered_free(&w->parts[0]);
    if (w->parts[1].set != NULL) {
        clustered_free(&w->parts[1]);
    }
}

static world one_mesh(const mesh *m, uint32_t most)
{
    world w = {0};
    assert_ok(device.context, clustered_make(device.context, m, most, &w.parts[0]));
    clast_tlas_instance instance = instance_of(w.parts[0].blas, 5);
    make_tlas(&w, &instance, 1);
    return w;
}

static void a_mesh_alone(void **state)
{
    (void)state;
    mesh m = mesh_terrain(60, 0.2f, 1);
    world w = one_mesh(&m, 128);
    clast_ray *rays = random_rays(1, 1.0f);
    assert_true(compare(w.tlas, rays) > RAYS / 200);
    aim_at_mesh(rays, &m, 2);
    assert_true(compare(w.tlas, rays) > RAYS / 2);
    free(rays);
    free_world(&w);
    mesh_free(&m);
}

static void clusters_of_all_sizes(void **state)
{
    (void)state;
    const uint32_t sizes[] = {1, 2, 3, 15, 16, 17, 100, 129, 200, 256};
    mesh m = mesh_octasphere(4);
    mesh_displace(&m, 0.3f, 2);
    clast_ray *rays = random_rays(3, 0.7f);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        world w = one_mesh(&m, sizes[i]);
        assert_true(compare(w.tlas, rays) > RAYS / 5);
        free_world(&w);
    }
    free(rays);
    mesh_free(&m);
}

// Triangles that share nothing, some of them on top of others.
static void soups(void **state)
{
    (void)state;
    mesh m = mesh_soup(900, 0.3f, 4);
    memcpy(m.positions + 9 * 500, m.positions + 9 * 100, 9 * 200 * sizeof(float));
    world w = one_mesh(&m, 64);
    clast_ray *rays = random_rays(5, 1.0f);
    assert_true(compare(w.tlas, rays) > RAYS / 20);
    aim_at_mesh(rays, &m, 6);
    assert_true(compare(w.tlas, rays) > RAYS / 20);
    free(rays);
    free_world(&w);
    mesh_free(&m);
}

static void corners_that_are_no_numbers(void **state)
{
    (void)state;
    mesh m = mesh_terrain(30, 0.2f, 7);
    randoms r = {8};
    for (uint32_t i = 0; i < 60; i++) {
        const float wild[] = {NAN, INFINITY, -INFINITY, 1e37f, -3e38f};
        m.positions[random_below(&r, 3 * m.vertex_count)] = wild[i % 5];
    }
    world w = one_mesh(&m, 128);
    clast_ray *rays = random_rays(9, 1.0f);
    assert_true(compare(w.tlas, rays) > RAYS / 100);
    free(rays);
    free_world(&w);
    mesh_free(&m);
}

static void triangles_without_area(void **state)
{
    (void)state;
    mesh m = mesh_terrain(20, 0.2f, 10);
    for (uint32_t i = 0; i < m.triangle_count; i += 3) {
        m.indices[3 * i + i % 3] = m.indices[3 * i + (i + 1) % 3];
    }
    for (uint32_t i = 0; i < m.vertex_count; i += 5) { // on a line with others
        memcpy(m.positions + 3 * (size_t)i, m.positions + 3 * (size_t)(m.vertex_count - 1), 12);
    }
    world w = one_mesh(&m, 128);
    clast_ray *rays = random_rays(11, 1.0f);
    compare(w.tlas, rays);
    aim_at_mesh(rays, &m, 12);
    compare(w.tlas, rays);
    free(rays);
    free_world(&w);
    mesh_free(&m);
}

static void tiny_and_huge_ones(void **state)
{
    (void)state;
    const float sizes[] = {1e-15f, 1e15f, 1e-20f, 1e5f};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        mesh m = mesh_octasphere(3);
        mesh_displace(&m, 0.2f, 13);
        mesh_transform(&m, sizes[i], 0, 0, 0);
        world w = one_mesh(&m, 128);
        clast_ray *rays = random_rays(14, sizes[i]);
        for (uint32_t k = 0; k < RAYS; k++) {
            rays[k].t_min = 0.0f;
            rays[k].t_max = INFINITY;
            for (uint32_t axis = 0; k % 3 == 0 && axis < 3; axis++) {
                rays[k].direction[axis] *= sizes[i];
            }
        }
        assert_true(compare(w.tlas, rays) > RAYS / 20);
        free(rays);
        free_world(&w);
        mesh_free(&m);
    }
}

enum { INSTANCES = 12 };

// Sheared, mirrored, flat, on top of each other, and absent.
static world many_instances(void)
{
    world w = {0};
    mesh terrain = mesh_terrain(40, 0.2f, 1), ball = mesh_octasphere(3);
    mesh_displace(&ball, 0.3f, 2);
    assert_ok(device.context, clustered_make(device.context, &terrain, 128, &w.parts[0]));
    assert_ok(device.context, clustered_make(device.context, &ball, 100, &w.parts[1]));
    clast_tlas_instance instances[INSTANCES];
    randoms r = {5};
    for (uint32_t i = 0; i < INSTANCES; i++) {
        instances[i] = instance_of(w.parts[i % 2].blas, i / 2 * 3); // ids are shared
        for (uint32_t k = 0; k < 12 && i > 0; k++) {
            instances[i].transform[k / 4][k % 4] += random_between(&r, -0.7f, 0.7f);
        }
        for (uint32_t k = 0; k < 4 && i % 3 == 1; k++) {
            instances[i].transform[1][k] *= -1.0f; // a mirror
        }
    }
    instances[3] = instances[2]; // on top of another: every hit is a tie
    instances[3].id = 1;
    instances[4].blas = NULL;
    memset(instances[5].transform[0], 0, sizeof instances[5].transform[0]); // flat: invisible
    memcpy(instances[6].transform[1], instances[6].transform[0], sizeof instances[6].transform[0]);
    make_tlas(&w, instances, INSTANCES);
    mesh_free(&terrain);
    mesh_free(&ball);
    return w;
}

static void instances_of_all_sorts(void **state)
{
    (void)state;
    world w = many_instances();
    clast_ray *rays = random_rays(15, 1.0f);
    assert_true(compare(w.tlas, rays) > RAYS / 10);
    free(rays);
    free_world(&w);
}

static void odd_rays(void **state)
{
    (void)state;
    world w = many_instances();
    clast_ray *rays = random_rays(16, 1.0f);
    const float wild[] = {NAN, INFINITY, -INFINITY, 0.0f, 1e37f, 3e38f, 1e-30f};
    // devices of other kinds may take numbers for zero that are as small as what the last, and short directions, lead to
    bool is_software = clast_gpu_features_of(device.gpu)->is_software;
    uint32_t kinds = is_software ? 7 : 6;
    for (uint32_t i = 0; i < RAYS; i++) {
        float *part = &rays[i].origin[0];
        part[i / 7 % 8] = wild[i % kinds]; // of the origin, t_min, the direction, t_max
        for (uint32_t axis = 0; is_software && i % 11 == 0 && axis < 3; axis++) {
            rays[i].direction[axis] *= i % 2 == 0 ? 1e-25f : 1e25f;
        }
    }
    compare(w.tlas, rays);
    free(rays);
    free_world(&w);
}

static void nothing_at_all(void **state)
{
    (void)state;
    world w = {0};
    mesh m = mesh_octasphere(1);
    assert_ok(device.context, clustered_make(device.context, &m, 128, &w.parts[0]));
    clast_tlas_instance nothing[2] = {instance_of(NULL, 1), instance_of(NULL, 2)};
    clast_ray *rays = random_rays(17, 1.0f);
    for (uint32_t count = 0; count <= 2; count++) {
        make_tlas(&w, nothing, count);
        assert_int_equal(compare(w.tlas, rays), 0);
        clast_tlas_destroy(w.tlas);
    }
    w.tlas = NULL;
    free(rays);
    free_world(&w);
    mesh_free(&m);
}

// However the kernel goes about it.
static void tunings_change_nothing(void **state)
{
    (void)state;
    world w = many_instances();
    clast_ray *rays = random_rays(18, 1.0f);
    const clast_gpu_rays_tuning tunings[] = {{.refill = 1},
                                             {.refill = 4, .steps = 1},
                                             {.group = 32, .pairs = UINT32_MAX},
                                             {.group = 128, .bytes = 1, .pairs = 2}};
    for (size_t i = 0; i < sizeof tunings / sizeof *tunings; i++) {
        assert_true(compare_as(w.tlas, rays, CLAST_GPU_RAYS_INCOHERENT, &tunings[i]) > RAYS / 10);
    }
    free(rays);
    free_world(&w);
}

int main(void)
{
    device = test_device_open();
    if (clast_gpu_trees_create(device.gpu, &trees) != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(device.context));
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_alone),
        cmocka_unit_test(clusters_of_all_sizes),
        cmocka_unit_test(soups),
        cmocka_unit_test(corners_that_are_no_numbers),
        cmocka_unit_test(triangles_without_area),
        cmocka_unit_test(tiny_and_huge_ones),
        cmocka_unit_test(instances_of_all_sorts),
        cmocka_unit_test(odd_rays),
        cmocka_unit_test(nothing_at_all),
        cmocka_unit_test(tunings_change_nothing),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    clast_gpu_trees_destroy(trees);
    return test_device_close(&device) ? failed : 1;
}
