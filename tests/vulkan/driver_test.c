// SPDX-License-Identifier: Apache-2.0
// The driver's structures and rays, against clast's own rays on the processor.
#include "test.h"

#include "accel/meshes.h"
#include "vulkan/device_scene.h"
#include "vulkan/driver.h"
#include "vulkan/test_device.h"

static test_device device;

enum { RAYS = 4096, SHAPES = 2, INSTANCES = 5 };

// ------------------------------------------------------------------------------------------------------------ shapes

// A mesh on both sides.
typedef struct shape {
    mesh m;
    clustered c;
    device_blas clusters;
    clast_gpu_buffer firsts, indices, triangles;
    uint32_t triangle_count;
    clast_driver_structure structure;
    clast_driver_scratch scratch;
} shape;

static clast_driver_triangles triangles_of(const shape *s)
{
    return (clast_driver_triangles){.positions = s->clusters.vertices.address,
                                    .indices = s->indices.address,
                                    .vertex_count = s->c.vertex_count,
                                    .triangle_count = s->triangle_count};
}

static void make_triangles(clast_gpu_commands *commands, shape *s)
{
    clast_device_cluster *in = s->clusters.clusters_in;
    size_t count = s->clusters.count;
    uint32_t *firsts = calloc(count + 1, sizeof *firsts), *places = calloc(count + 1, sizeof *places);
    for (size_t i = 0; i < count; i++) {
        firsts[i] = s->c.first_triangles[i];
        places[i] = in[i].place;
    }
    firsts[count] = s->m.triangle_count;
    clast_gpu_buffer place_buffer;
    assert_ok(device.context, device_upload(commands, firsts, (count + 1) * sizeof *firsts, &s->firsts));
    assert_ok(device.context, device_upload(commands, places, (count + 1) * sizeof *places, &place_buffer));
    free(firsts);
    free(places);
    s->triangle_count = s->m.triangle_count;
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, (uint64_t)s->triangle_count * 12, "i", &s->indices));
    assert_ok(device.context,
              clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, (uint64_t)s->triangle_count * 4, "t", &s->triangles));
    clast_gpu_barrier(commands);
    device_fit(commands, &s->clusters);
    clast_gpu_barrier(commands);
    clast_driver_make_triangles(commands,
                                &(clast_driver_clusters){.clusters = s->clusters.clusters.address,
                                                         .places = place_buffer.address,
                                                         .firsts = s->firsts.address,
                                                         .positions = s->clusters.vertices.address,
                                                         .count = (uint32_t)count},
                                s->indices.address, s->triangles.address);
    clast_gpu_barrier(commands);
    clast_gpu_free(device.gpu, &place_buffer);
}

static void shape_make(mesh m, uint32_t most, const clast_driver_structure_desc *desc, shape *s)
{
    *s = (shape){.m = m};
    assert_ok(device.context, clustered_make(device.context, &s->m, most, &s->c));
    s->clusters.blas = s->c.blas;
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, device_clusters(commands, &s->clusters));
    make_triangles(commands, s);
    clast_driver_structure_desc sized = *desc;
    sized.triangle_count = s->triangle_count;
    sized.vertex_count = s->c.vertex_count;
    assert_ok(device.context, clast_driver_reserve(device.gpu, &sized, &s->structure));
    clast_driver_build_all(commands, &(clast_driver_job){.structure = &s->structure, .triangles = triangles_of(s)}, 1,
                           &s->scratch);
    assert_ok(device.context, clast_gpu_finish(commands));
}

static void shape_free(shape *s)
{
    clast_driver_free(device.gpu, &s->structure);
    clast_gpu_free(device.gpu, &s->scratch.buffer);
    clast_gpu_free(device.gpu, &s->firsts);
    clast_gpu_free(device.gpu, &s->indices);
    clast_gpu_free(device.gpu, &s->triangles);
    device_blas_free(device.gpu, &s->clusters);
    clustered_free(&s->c);
    mesh_free(&s->m);
}

// ------------------------------------------------------------------------------------------------------------ scenes

// Instances on both sides.
typedef struct stage {
    shape shapes[SHAPES];
    size_t shape_count;
    clast_tlas *tlas;
    clast_driver_scene scene;
    clast_driver *driver;
} stage;

static clast_driver_instance driver_instance_of(const shape *s, const clast_tlas_instance *from)
{
    clast_driver_instance made = {.structure = &s->structure,
                                  .positions = s->clusters.vertices.address,
                                  .indices = s->indices.address,
                                  .triangles = s->triangles.address,
                                  .id = from->id,
                                  .filtered = from->filtered != 0};
    memcpy(&made.to_world, from->transform, sizeof made.to_world);
    return made;
}

// `of` tells which shape each instance shows; those of SHAPES show nothing.
static void stage_place(stage *s, const clast_tlas_instance *instances, const size_t *of, size_t count)
{
    clast_tlas_instance list[INSTANCES];
    clast_driver_instance driver_list[INSTANCES];
    for (size_t i = 0; i < count; i++) {
        list[i] = instances[i];
        list[i].blas = of[i] < SHAPES ? s->shapes[of[i]].c.blas : NULL;
        driver_list[i] = driver_instance_of(&s->shapes[of[i] % SHAPES], &list[i]);
        driver_list[i].structure = of[i] < SHAPES ? driver_list[i].structure : NULL;
    }
    if (s->tlas == NULL) {
        assert_ok(device.context, clast_tlas_create(device.context, &s->tlas));
    }
    assert_ok(device.context, clast_tlas_build(s->tlas, list, count, CLAST_BUILD_BEST));
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_driver_scene_build(commands, driver_list, count, CLAST_DRIVER_FAST_TRACE, &s->scene);
    assert_ok(device.context, clast_gpu_finish(commands));
}

static void stage_end(stage *s)
{
    clast_tlas_destroy(s->tlas);
    clast_driver_scene_free(device.gpu, &s->scene);
    clast_driver_destroy(s->driver);
    for (size_t i = 0; i < s->shape_count; i++) {
        shape_free(&s->shapes[i]);
    }
}

static const clast_tlas_instance unmoved = {.transform = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .id = 7};

// A single shape, where it is.
static void stage_single(stage *s, mesh m, const clast_driver_structure_desc *desc)
{
    *s = (stage){.shape_count = 1};
    assert_ok(device.context,
              clast_driver_create(device.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_COUNT_}, &s->driver));
    shape_make(m, 128, desc, &s->shapes[0]);
    stage_place(s, &unmoved, &(size_t){0}, 1);
}

// -------------------------------------------------------------------------------------------------------------- rays

static void trace(const stage *s, const clast_ray *rays, uint32_t count, bool any, uint32_t launched, void *results)
{
    uint64_t bytes = (uint64_t)launched * (any ? sizeof(uint32_t) : sizeof(clast_hit));
    clast_gpu_buffer ray_buffer, result_buffer, count_buffer;
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, device_upload(commands, rays, launched * sizeof *rays, &ray_buffer));
    assert_ok(device.context, device_upload(commands, results, bytes, &result_buffer));
    assert_ok(device.context, device_upload(commands, &count, sizeof count, &count_buffer));
    clast_gpu_barrier(commands);
    clast_driver_trace(commands, s->driver, &s->scene,
                       &(clast_driver_rays){.rays = ray_buffer.address,
                                            .results = result_buffer.address,
                                            .counts = count != launched ? count_buffer.address : 0,
                                            .count = launched,
                                            .any = any});
    clast_gpu_read(commands, &result_buffer, 0, results, bytes);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &ray_buffer);
    clast_gpu_free(device.gpu, &result_buffer);
    clast_gpu_free(device.gpu, &count_buffer);
}

static void random_rays(float reach, uint64_t seed, clast_ray *rays, uint32_t count)
{
    randoms r = {seed};
    for (uint32_t i = 0; i < count; i++) {
        rays[i] = (clast_ray){.t_max = i % 3 == 0 ? INFINITY : random_between(&r, 0.5f, 4.0f) * reach};
        for (int k = 0; k < 3; k++) {
            float from = random_between(&r, -reach, reach), to = random_between(&r, -reach, reach);
            rays[i].origin[k] = from;
            rays[i].direction[k] = i % 2 == 0 ? to - from : (to - from) * 0.01f;
        }
        rays[i].t_min = i % 7 == 0 ? 0.4f : 0.0f;
    }
}

static bool is_near(float a, float b, float tolerance)
{
    return fabsf(a - b) <= tolerance;
}

static float cosine(const float a[3], const float b[3])
{
    float ab = 0, aa = 0, bb = 0;
    for (int k = 0; k < 3; k++) {
        ab += a[k] * b[k];
        aa += a[k] * a[k];
        bb += b[k] * b[k];
    }
    return ab / sqrtf(aa * bb);
}

// Where both hit the same triangle, distances differ by rounding, weights by what that is seen at a slant. Else the ray meets
// both triangles at their edge or at the same distance, or passes an edge: these are counted.
static uint32_t count_differences(const stage *s, const clast_ray *rays, uint32_t count, const clast_hit *hits,
                                  const clast_hit_filter *filter, uint32_t *hit_count)
{
    clast_hit *expected = malloc(count * sizeof *expected);
    clast_trace_closest(s->tlas, rays, count, filter, expected);
    uint32_t differ = 0;
    for (uint32_t i = 0; i < count; i++) {
        const clast_hit *a = &expected[i], *b = &hits[i];
        *hit_count += a->instance != CLAST_NONE;
        if (a->instance == CLAST_NONE && b->instance == CLAST_NONE) {
            continue;
        }
        if (a->instance != b->instance || a->cluster != b->cluster || a->triangle != b->triangle) {
            differ++;
            continue;
        }
        assert_true(is_near(a->t, b->t, 1e-4f * (1.0f + a->t)));
        assert_true(cosine(a->normal, b->normal) > 0.999f);
        bool slanted = fabsf(cosine(a->normal, rays[i].direction)) < 0.05f;
        assert_true(slanted || (is_near(a->u, b->u, 2e-3f) && is_near(a->v, b->v, 2e-3f)));
    }
    free(expected);
    return differ;
}

// At most one ray of a thousand differs in which triangle it hits, or whether it hits.
static void compare(const stage *s, float reach, uint64_t seed, const clast_hit_filter *filter)
{
    clast_ray *rays = malloc(RAYS * sizeof *rays);
    clast_hit *hits = calloc(RAYS, sizeof *hits);
    uint32_t *occluded = calloc(RAYS, sizeof *occluded);
    uint8_t *expected = calloc(RAYS, 1);
    random_rays(reach, seed, rays, RAYS);
    trace(s, rays, RAYS, false, RAYS, hits);
    trace(s, rays, RAYS, true, RAYS, occluded);
    uint32_t hit_count = 0, differ = count_differences(s, rays, RAYS, hits, filter, &hit_count);
    clast_trace_any(s->tlas, rays, RAYS, filter, expected);
    uint32_t any_differ = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        any_differ += occluded[i] != expected[i];
    }
    print_message("%u of %d rays hit, %u differ in what they hit, %u in whether they do\n", hit_count, RAYS, differ,
                  any_differ);
    assert_true(hit_count > RAYS / 25);
    assert_true(differ <= RAYS / 1000);
    assert_true(any_differ <= RAYS / 1000);
    free(rays);
    free(hits);
    free(occluded);
    free(expected);
}

// ------------------------------------------------------------------------------------------------------------- tests

static const clast_driver_structure_desc plain = {.build = CLAST_DRIVER_FAST_TRACE};

static void hits_on_meshes_are_those_of_the_processor(void **state)
{
    (void)state;
    stage s;
    stage_single(&s, mesh_soup(1500, 0.2f, 1), &plain);
    compare(&s, 1.5f, 2, NULL);
    stage_end(&s);
    stage_single(&s, mesh_terrain(40, 0.1f, 3), &(clast_driver_structure_desc){.build = CLAST_DRIVER_FAST_BUILD});
    compare(&s, 1.0f, 4, NULL);
    stage_end(&s);
}

static void place(clast_tlas_instance *to, randoms *r, float sign)
{
    for (int i = 0; i < 12; i++) {
        to->transform[i / 4][i % 4] = random_between(r, -1, 1) + (i % 5 == 0 ? 1.5f : 0.0f);
    }
    for (int k = 0; k < 4; k++) {
        to->transform[0][k] *= sign;
    }
}

static void instances_are_placed_mirrored_and_left_out(void **state)
{
    (void)state;
    stage s = {.shape_count = 2};
    assert_ok(device.context,
              clast_driver_create(device.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_COUNT_}, &s.driver));
    shape_make(mesh_torus(40, 20, 1.0f, 0.4f), 100, &plain, &s.shapes[0]);
    shape_make(mesh_soup(300, 0.3f, 5), 31, &plain, &s.shapes[1]);
    clast_tlas_instance instances[INSTANCES];
    randoms r = {6};
    for (uint32_t i = 0; i < INSTANCES; i++) {
        instances[i] = (clast_tlas_instance){.id = 100 + 17 * i};
        place(&instances[i], &r, i == 1 ? -1.0f : 1.0f);
    }
    for (int k = 0; k < 4; k++) { // flat: it cannot be inverted
        instances[3].transform[2][k] = instances[3].transform[1][k];
    }
    stage_place(&s, instances, (const size_t[]){0, 0, 1, 1, SHAPES}, INSTANCES);
    compare(&s, 4.0f, 7, NULL);
    stage_place(&s, instances, (const size_t[]){1}, 1); // fewer than before
    compare(&s, 2.0f, 8, NULL);
    stage_end(&s);
}

static void structures_are_fitted_to_vertices_that_moved(void **state)
{
    (void)state;
    stage s;
    stage_single(&s, mesh_octasphere(4),
                 &(clast_driver_structure_desc){.build = CLAST_DRIVER_FAST_BUILD, .updated = true});
    shape *moved = &s.shapes[0];
    for (uint64_t round = 0; round < 2; round++) {
        mesh_displace(&moved->m, 0.3f, 9 + round);
        clustered_gather(&moved->c, &moved->m);
        assert_ok(device.context, clast_clas_refit(moved->c.pool, 0, moved->c.cluster_count));
        assert_ok(device.context, clast_blas_refit(moved->c.blas));
        clast_gpu_commands *commands;
        assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
        clast_gpu_write(commands, &moved->clusters.vertices, 0, moved->c.vertices,
                        (uint64_t)moved->c.vertex_count * 12);
        clast_gpu_barrier(commands);
        clast_driver_build_all(
            commands,
            &(clast_driver_job){.structure = &moved->structure, .triangles = triangles_of(moved), .update = true}, 1,
            &moved->scratch);
        assert_ok(device.context, clast_gpu_finish(commands));
        stage_place(&s, &unmoved, &(size_t){0}, 1);
        compare(&s, 1.5f, 10 + round, NULL);
    }
    stage_end(&s);
}

static void compact_structures_are_hit_alike_and_no_larger(void **state)
{
    (void)state;
    stage s;
    stage_single(&s, mesh_soup(1000, 0.2f, 11),
                 &(clast_driver_structure_desc){.build = CLAST_DRIVER_FAST_TRACE, .compacted = true});
    uint64_t before = s.shapes[0].structure.bytes;
    assert_ok(device.context, clast_driver_compact(device.gpu, &s.shapes[0].structure));
    assert_true(s.shapes[0].structure.bytes <= before);
    stage_place(&s, &unmoved, &(size_t){0}, 1);
    compare(&s, 1.5f, 12, NULL);
    assert_int_equal(clast_driver_compact(device.gpu, &s.shapes[0].structure), CLAST_ERROR_INVALID_ARGUMENT);
    stage_end(&s);
}

static bool is_odd(void *user, const clast_ray *ray, const clast_hit *hit)
{
    (void)user;
    (void)ray;
    return ((hit->instance + hit->cluster + hit->triangle) & 1) != 0;
}

static void only_hits_of_filtered_instances_are_put_to_the_filter(void **state)
{
    (void)state;
    stage s = {.shape_count = 1};
    assert_ok(device.context,
              clast_driver_create(device.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_PROBE_FILTER}, &s.driver));
    shape_make(mesh_soup(700, 0.3f, 13), 64, &plain, &s.shapes[0]);
    clast_tlas_instance instances[2] = {unmoved, unmoved};
    instances[0].filtered = 1;
    instances[1].id = 8;
    instances[1].transform[0][3] = 1.5f;
    stage_place(&s, instances, (const size_t[]){0, 0}, 2);
    compare(&s, 2.0f, 14, &(clast_hit_filter){.accepts = is_odd});
    instances[1].filtered = 1;
    stage_place(&s, instances, (const size_t[]){0, 0}, 2);
    compare(&s, 2.0f, 15, &(clast_hit_filter){.accepts = is_odd});
    stage_end(&s);
}

static void triangles_and_rays_that_are_not_sound_hit_nothing(void **state)
{
    (void)state;
    mesh m = mesh_terrain(30, 0.1f, 16);
    for (uint32_t i = 0; i < m.vertex_count; i += 11) {
        m.positions[3 * (size_t)i + i % 3] = i % 2 == 0 ? NAN : 1e37f;
    }
    stage s;
    stage_single(&s, m, &plain);
    compare(&s, 1.0f, 17, NULL);
    clast_ray rays[6];
    clast_hit hits[6];
    for (int i = 0; i < 6; i++) {
        rays[i] = (clast_ray){.origin = {0.43f, 0.51f, 2.0f}, .direction = {0, 0, -1}, .t_max = 1e30f};
        hits[i].instance = 0;
    }
    rays[0].direction[2] = 0.0f;
    rays[1].origin[0] = NAN;
    rays[2].t_max = NAN;
    rays[3].direction[1] = INFINITY;
    rays[4].t_max = -1.0f;
    rays[5].origin[1] = 3e37f;
    trace(&s, rays, 6, false, 6, hits);
    for (int i = 0; i < 6; i++) {
        assert_int_equal(hits[i].instance, CLAST_NONE);
    }
    stage_end(&s);
}

static void ranges_may_begin_before_the_origin(void **state)
{
    (void)state;
    stage s;
    stage_single(&s, mesh_octasphere(3), &plain);
    clast_ray ray = {.origin = {3, 0.1f, 0.2f}, .direction = {1, 0, 0}, .t_min = -2.5f, .t_max = 10};
    clast_hit hit = {0}, expected;
    trace(&s, &ray, 1, false, 1, &hit);
    clast_trace_closest(s.tlas, &ray, 1, NULL, &expected);
    assert_int_not_equal(expected.instance, CLAST_NONE);
    assert_int_equal(hit.triangle, expected.triangle);
    assert_true(is_near(hit.t, expected.t, 1e-5f));
    stage_end(&s);
}

static void rays_beyond_the_number_on_the_device_are_left_alone(void **state)
{
    (void)state;
    stage s;
    stage_single(&s, mesh_octasphere(2), &plain);
    clast_ray rays[64];
    clast_hit hits[64];
    for (int i = 0; i < 64; i++) {
        rays[i] = (clast_ray){.origin = {0, 0, 0}, .direction = {1, 0.5f, 0.25f}, .t_max = INFINITY};
        hits[i] = (clast_hit){.instance = 12345};
    }
    trace(&s, rays, 40, false, 64, hits);
    for (int i = 0; i < 64; i++) {
        assert_int_equal(hits[i].instance, i < 40 ? unmoved.id : 12345);
    }
    stage_end(&s);
}

static void nothing_is_hit_where_nothing_is(void **state)
{
    (void)state;
    stage s = {0};
    assert_ok(device.context,
              clast_driver_create(device.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_COUNT_}, &s.driver));
    stage_place(&s, &unmoved, &(size_t){SHAPES}, 0);
    clast_ray ray = {.direction = {1, 0, 0}, .t_max = INFINITY};
    clast_hit hit = {0};
    uint32_t occluded = 1;
    trace(&s, &ray, 1, false, 1, &hit);
    trace(&s, &ray, 1, true, 1, &occluded);
    assert_int_equal(hit.instance, CLAST_NONE);
    assert_int_equal(occluded, 0);
    stage_end(&s);
}

static void what_cannot_be_built_is_refused(void **state)
{
    (void)state;
    clast_driver_structure structure = {0};
    assert_int_equal(
        clast_driver_reserve(
            device.gpu, &(clast_driver_structure_desc){.triangle_count = UINT32_MAX, .vertex_count = 3}, &structure),
        CLAST_ERROR_LIMIT);
    assert_ok(device.context,
              clast_driver_reserve(device.gpu, &(clast_driver_structure_desc){.triangle_count = 10, .vertex_count = 30},
                                   &structure));
    clast_driver_job jobs[2] = {
        {.structure = &structure, .triangles = {.triangle_count = 11, .vertex_count = 30}},
        {.structure = &structure, .triangles = {.triangle_count = 10, .vertex_count = 30}, .update = true}};
    clast_driver_scratch scratch = {0};
    for (int i = 0; i < 2; i++) {
        clast_gpu_commands *commands;
        assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
        clast_driver_build_all(commands, &jobs[i], 1, &scratch);
        assert_int_equal(clast_gpu_finish(commands), CLAST_ERROR_INVALID_ARGUMENT);
    }
    clast_driver_free(device.gpu, &structure);
    clast_gpu_free(device.gpu, &scratch.buffer);
}

static void a_device_that_was_not_opened_for_it_is_refused(void **state)
{
    (void)state;
    test_device other = test_device_open();
    clast_driver *driver;
    assert_int_equal(clast_driver_create(other.gpu, &(clast_driver_desc){.filter = CLAST_SHADER_COUNT_}, &driver),
                     CLAST_ERROR_UNSUPPORTED);
    assert_null(driver);
    assert_true(test_device_close(&other));
}

int main(void)
{
    device = test_device_open_as(
        &(clast_gpu_desc){.software = true, .hardware = true, .validate = true, .ray_tracing = true});
    if (!clast_gpu_features_of(device.gpu)->ray_tracing) {
        fprintf(stderr, "skipped: %s has no ray tracing\n", clast_gpu_features_of(device.gpu)->name);
        return test_device_close(&device) ? 77 : 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_on_meshes_are_those_of_the_processor),
        cmocka_unit_test(instances_are_placed_mirrored_and_left_out),
        cmocka_unit_test(structures_are_fitted_to_vertices_that_moved),
        cmocka_unit_test(compact_structures_are_hit_alike_and_no_larger),
        cmocka_unit_test(only_hits_of_filtered_instances_are_put_to_the_filter),
        cmocka_unit_test(triangles_and_rays_that_are_not_sound_hit_nothing),
        cmocka_unit_test(ranges_may_begin_before_the_origin),
        cmocka_unit_test(rays_beyond_the_number_on_the_device_are_left_alone),
        cmocka_unit_test(nothing_is_hit_where_nothing_is),
        cmocka_unit_test(what_cannot_be_built_is_refused),
        cmocka_unit_test(a_device_that_was_not_opened_for_it_is_refused),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failures : 1;
}
