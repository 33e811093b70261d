// SPDX-License-Identifier: Apache-2.0
// Cluster structures on a device of the caller's: hits are those of the processor. The device is that of VK_DRIVER_FILES.
#include "test.h"

#include <math.h>

#include "accel/meshes.h"
#include "vulkan/device.h"
#include "vulkan/test_device.h"

#include "clast/vulkan.h"

enum { RAYS = 2000, INSTANCES = 6 };

static test_device device; // the engine's
static clast_vulkan *vulkan;

// ------------------------------------------------------------------------------------------------------------- helpers

static clast_vulkan_desc engine_desc(void)
{
    const clast_gpu *gpu = device.gpu;
    return (clast_vulkan_desc){.get_instance_function = gpu->vk.vkGetInstanceProcAddr,
                               .instance = gpu->instance,
                               .physical_device = gpu->physical_device,
                               .device = gpu->device,
                               .queue = gpu->queue,
                               .queue_family = gpu->queue_family};
}

static clast_gpu_buffer upload(clast_gpu_commands *commands, const void *data, uint64_t bytes)
{
    clast_gpu_buffer buffer;
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, bytes, "test", &buffer));
    if (data != NULL) {
        clast_gpu_write(commands, &buffer, 0, data, bytes);
    }
    return buffer;
}

typedef struct world {
    mesh m;
    clustered c;
    clast_tlas *tlas;
    clast_tlas_instance instances[INSTANCES];
    clast_vulkan_blas *blas;
    clast_vulkan_tlas *there;
    clast_vulkan_instance placed[INSTANCES];
} world;

static void place_instances(world *w)
{
    randoms r = {3};
    for (uint32_t i = 0; i < INSTANCES; i++) {
        w->instances[i] = instance_of(w->c.blas, 10 - i);
        for (uint32_t k = 0; k < 12 && i > 0; k++) {
            w->instances[i].transform[k / 4][k % 4] += random_between(&r, -0.6f, 0.6f);
        }
        for (uint32_t k = 0; k < 4 && i == 2; k++) {
            w->instances[i].transform[0][k] *= -1.0f; // a mirror
        }
        w->instances[i].blas = i == 3 ? NULL : w->c.blas;
        w->placed[i] = (clast_vulkan_instance){.blas = i == 3 ? NULL : w->blas, .id = w->instances[i].id};
        memcpy(w->placed[i].transform, w->instances[i].transform, sizeof w->placed[i].transform);
    }
    assert_ok(device.context, clast_tlas_build(w->tlas, w->instances, INSTANCES, CLAST_BUILD_BEST));
}

static world make_world(void)
{
    world w = {.m = mesh_octasphere(4)};
    mesh_displace(&w.m, 0.3f, 2);
    assert_ok(device.context, clustered_make(device.context, &w.m, 120, &w.c));
    assert_ok(device.context, clast_tlas_create(device.context, &w.tlas));
    clast_vulkan_cluster *clusters = malloc(w.c.cluster_count * sizeof *clusters);
    for (uint32_t i = 0, first = 0; i < w.c.cluster_count; i++) {
        clusters[i] = (clast_vulkan_cluster){i, first};
        first += clast_template_vertex_count(w.c.set, i);
    }
    assert_ok(device.context, clast_vulkan_blas_create(vulkan, w.c.set, clusters, w.c.cluster_count, &w.blas));
    assert_ok(device.context, clast_vulkan_tlas_create(vulkan, INSTANCES, &w.there));
    free(clusters);
    place_instances(&w);
    return w;
}

static void free_world(world *w)
{
    clast_vulkan_tlas_destroy(w->there);
    clast_vulkan_blas_destroy(w->blas);
    clast_vulkan_collect(vulkan);
    clast_tlas_destroy(w->tlas);
    clustered_free(&w->c);
    mesh_free(&w->m);
}

static void make_rays(clast_ray rays[RAYS])
{
    randoms r = {4};
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (clast_ray){.t_max = i % 5 == 0 ? 1.0f : INFINITY};
        for (uint32_t axis = 0; axis < 3; axis++) {
            rays[i].origin[axis] = random_between(&r, -2, 2);
            rays[i].direction[axis] = random_between(&r, -1, 1);
        }
    }
}

static bool same_hit(const clast_hit *a, const clast_hit *b)
{
    return a->instance == b->instance &&
           (a->instance == CLAST_NONE ||
            (a->cluster == b->cluster && a->triangle == b->triangle && a->t == b->t && a->u == b->u && a->v == b->v &&
             a->normal[0] == b->normal[0] && a->normal[1] == b->normal[1] && a->normal[2] == b->normal[2]));
}

// One frame of the engine: builds, and traces both ways.
static void run_frame(world *w, const clast_vulkan_vertices *vertices, clast_vulkan_order order,
                      clast_vulkan_rays_kind kind, clast_gpu_commands *commands, const clast_ray rays[RAYS],
                      clast_hit hits[RAYS], uint32_t occluded[RAYS])
{
    VkCommandBuffer buffer = clast_gpu_command_buffer(commands);
    clast_gpu_buffer from = upload(commands, rays, RAYS * sizeof *rays);
    clast_gpu_buffer to = upload(commands, NULL, RAYS * sizeof *hits), flags = upload(commands, NULL, RAYS * 4);
    assert_ok(device.context, clast_vulkan_blas_build(w->blas, buffer, vertices, order));
    assert_ok(device.context, clast_vulkan_tlas_build(w->there, buffer, w->placed, INSTANCES));
    assert_ok(device.context, clast_vulkan_trace_closest(w->there, buffer, from.address, RAYS, kind, to.address));
    assert_ok(device.context, clast_vulkan_trace_any(w->there, buffer, from.address, RAYS, kind, flags.address));
    clast_gpu_read(commands, &to, 0, hits, RAYS * sizeof *hits);
    clast_gpu_read(commands, &flags, 0, occluded, RAYS * 4);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &from);
    clast_gpu_free(device.gpu, &to);
    clast_gpu_free(device.gpu, &flags);
}

static void assert_same_hits(const world *w, const clast_ray rays[RAYS], const clast_hit hits[RAYS],
                             const uint32_t occluded[RAYS])
{
    static clast_hit here[RAYS];
    uint32_t found = 0;
    clast_trace_closest(w->tlas, rays, RAYS, NULL, here);
    for (uint32_t i = 0; i < RAYS; i++) {
        assert_true(same_hit(&hits[i], &here[i]));
        assert_int_equal(occluded[i], here[i].instance != CLAST_NONE);
        found += occluded[i];
    }
    assert_true(found > RAYS / 10);
}

// --------------------------------------------------------------------------------------------------------------- tests

static void hits_are_those_of_the_processor(void **state)
{
    (void)state;
    static clast_ray rays[RAYS];
    static clast_hit hits[RAYS];
    static uint32_t occluded[RAYS];
    world w = make_world();
    make_rays(rays);
    for (int way = 0; way < 2; way++) {
        clast_gpu_commands *commands;
        assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
        clast_gpu_buffer vertices = upload(commands, w.c.vertices, 12 * (uint64_t)w.c.vertex_count);
        run_frame(&w, &(clast_vulkan_vertices){.vertices = vertices.address},
                  way == 0 ? CLAST_VULKAN_ORDER_ANY : CLAST_VULKAN_ORDER_STORED,
                  way == 0 ? CLAST_VULKAN_RAYS_COHERENT : CLAST_VULKAN_RAYS_INCOHERENT, commands, rays, hits, occluded);
        clast_vulkan_collect(vulkan);
        assert_same_hits(&w, rays, hits, occluded);
        clast_gpu_free(device.gpu, &vertices);
    }
    free_world(&w);
}

static void shared_vertices_move(void **state)
{
    (void)state;
    static clast_ray rays[RAYS];
    static clast_hit hits[RAYS];
    static uint32_t occluded[RAYS];
    world w = make_world();
    make_rays(rays);
    for (uint32_t frame = 0; frame < 2; frame++) {
        mesh_displace(&w.m, 0.1f, 20 + frame);
        clustered_gather(&w.c, &w.m);
        assert_ok(device.context, clast_clas_refit(w.c.pool, 0, w.c.cluster_count));
        assert_ok(device.context, clast_blas_refit(w.c.blas));
        assert_ok(device.context, clast_tlas_build(w.tlas, w.instances, INSTANCES, CLAST_BUILD_BEST));
        clast_gpu_commands *commands;
        assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
        clast_gpu_buffer vertices = upload(commands, NULL, 12 * (uint64_t)w.c.vertex_count);
        clast_gpu_buffer positions = upload(commands, w.m.positions, 12 * (uint64_t)w.m.vertex_count);
        clast_gpu_buffer numbers = upload(commands, w.c.vertex_sources, 4 * (uint64_t)w.c.vertex_count);
        clast_vulkan_vertices gathered = {vertices.address, positions.address, numbers.address, w.m.vertex_count};
        run_frame(&w, &gathered, CLAST_VULKAN_ORDER_ANY, CLAST_VULKAN_RAYS_COHERENT, commands, rays, hits, occluded);
        clast_vulkan_collect(vulkan);
        assert_same_hits(&w, rays, hits, occluded);
        clast_gpu_free(device.gpu, &vertices);
        clast_gpu_free(device.gpu, &positions);
        clast_gpu_free(device.gpu, &numbers);
    }
    free_world(&w);
}

static void wrong_arguments_are_refused(void **state)
{
    (void)state;
    clast_vulkan_desc desc = engine_desc();
    clast_vulkan *none = NULL;
    clast_vulkan_blas *blas = NULL;
    clast_vulkan_tlas *tlas = NULL;
    desc.queue = VK_NULL_HANDLE;
    assert_int_equal(clast_vulkan_create(device.context, &desc, &none), CLAST_ERROR_INVALID_ARGUMENT);
    world w = make_world();
    clast_vulkan_cluster cluster = {clast_template_set_count(w.c.set), 0};
    assert_int_equal(clast_vulkan_blas_create(vulkan, w.c.set, &cluster, 1, &blas), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_vulkan_blas_create(vulkan, w.c.set, &cluster, 0, &blas), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_vulkan_blas_create(vulkan, w.c.set, &cluster, (size_t)1 << 40, &blas), CLAST_ERROR_LIMIT);
    assert_int_equal(clast_vulkan_tlas_create(vulkan, (size_t)1 << 40, &tlas), CLAST_ERROR_LIMIT);
    assert_null(blas);
    assert_null(tlas);
    VkCommandBuffer somewhere = (VkCommandBuffer)(void *)&w; // not looked at
    assert_int_equal(clast_vulkan_tlas_build(w.there, somewhere, w.placed, INSTANCES + 1),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_vulkan_trace_any(w.there, somewhere, 0, 1, CLAST_VULKAN_RAYS_COHERENT, 0),
                     CLAST_ERROR_INVALID_ARGUMENT);
    free_world(&w);
}

static void memory_is_limited(void **state)
{
    (void)state;
    clast_vulkan_desc desc = engine_desc();
    desc.memory_limit = 1 << 16;
    clast_vulkan *small = NULL;
    clast_vulkan_tlas *tlas = NULL;
    clast_status status = clast_vulkan_create(device.context, &desc, &small);
    status = status == CLAST_OK ? clast_vulkan_tlas_create(small, 1000, &tlas) : status;
    assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
    assert_null(tlas);
    clast_vulkan_destroy(small);
}

int main(void)
{
    device = test_device_open();
    clast_vulkan_desc desc = engine_desc();
    if (clast_vulkan_create(device.context, &desc, &vulkan) != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(device.context));
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_the_processor),
        cmocka_unit_test(shared_vertices_move),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(memory_is_limited),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    clast_vulkan_destroy(vulkan);
    return test_device_close(&device) ? failed : 1;
}
