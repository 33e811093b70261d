// SPDX-License-Identifier: Apache-2.0
// Frames made on a device against those that the processor makes of the same scene: counts, records, words and vertices are the
// same to the bit, whatever the budget and whatever was made before.
#include "frame/stage.h"

#include <string.h>

#include "clast/animation.h"

#include "vulkan/frame.h"
#include "vulkan/rays.h"
#include "vulkan/test_device.h"

static const clast_backend device_backend = {.name = "vulkan",
                                             .passes = {CLAST_FRAME_VULKAN_PASSES(STAGE_PASS)},
                                             .count = clast_vulkan_count_units,
                                             .coarse = clast_vulkan_trace_coarse,
                                             .forget = clast_vulkan_forget};
static test_device device;

// A scene with two frames over it: the stage's is the processor's, the other the device's.
typedef struct twins {
    stage stage;
    clast_frame *frame;
    clast_vulkan_frame *made;
} twins;

static twins twins_open(void)
{
    twins t = {.stage = stage_open(device.context)};
    t.frame = stage_add_frame(&t.stage);
    assert_ok(device.context, clast_vulkan_frame_create(device.gpu, &t.made));
    t.frame->device = t.made;
    return t;
}

static void twins_close(twins *t)
{
    clast_vulkan_frame_destroy(t->made);
    clast_frame_destroy(t->frame);
    stage_close(&t->stage);
}

static clast_status twins_try(twins *t)
{
    clast_status status = clast_cooked_update(t->stage.cooked, t->stage.scene);
    t->frame->settings = t->stage.frame->settings;
    return status != CLAST_OK ? status
                              : clast_frame_run(t->frame, &device_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL);
}

static bool same_need(const clast_frame_need *a, const clast_frame_need *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

static void compare_records(twins *t, size_t number)
{
    const clast_frame_unit *unit = &t->stage.frame->units[number];
    clast_cluster_record *records = malloc(unit->record_count * sizeof *records + 1);
    assert_non_null(records);
    assert_ok(device.context, clast_vulkan_frame_read_records(t->frame, number, 0, unit->record_count, records));
    assert_memory_equal(records, unit->records, unit->record_count * sizeof *records);
    free(records);
}

static void compare_words(twins *t, size_t number)
{
    const clast_frame_unit *unit = &t->stage.frame->units[number];
    uint32_t *words = malloc(unit->word_count * sizeof *words + 1);
    assert_non_null(words);
    assert_ok(device.context, clast_vulkan_frame_read_words(t->frame, number, 0, unit->word_count, words));
    assert_memory_equal(words, unit->words, unit->word_count * sizeof *words);
    free(words);
}

static void compare_vertices(twins *t, size_t number)
{
    const clast_frame_unit *unit = &t->stage.frame->units[number];
    packed3 *vertices = malloc(unit->vertex_count * sizeof *vertices + 1);
    assert_non_null(vertices);
    assert_ok(device.context, clast_vulkan_frame_read_vertices(t->frame, number, 0, unit->vertex_count, vertices));
    for (size_t i = 0; i < unit->vertex_count; i++) {
        for (int k = 0; k < 3; k++) { // signs of zeros may differ
            if (vertices[i].v[k] != unit->vertices[i].v[k]) {
                print_message("unit %zu, vertex %zu, axis %d: %.9g, expected %.9g\n", number, i, k,
                              (double)vertices[i].v[k], (double)unit->vertices[i].v[k]);
            }
            assert_true(vertices[i].v[k] == unit->vertices[i].v[k]);
        }
    }
    free(vertices);
}

static void compare(twins *t)
{
    const clast_frame *a = t->stage.frame, *b = t->frame;
    assert_true(same_need(&a->wanted, &b->wanted));
    assert_true(same_need(&a->granted, &b->granted));
    assert_true(same_need(&a->minimum, &b->minimum));
    assert_true(a->fitted_rate == b->fitted_rate);
    assert_int_equal(a->bound, b->bound);
    assert_int_equal(a->clusters, b->clusters);
    assert_int_equal(a->vertices, b->vertices);
    assert_int_equal(a->triangles, b->triangles);
    assert_int_equal(a->instanced_triangles, b->instanced_triangles);
    assert_int_equal(a->instance_count, b->instance_count);
    for (size_t i = 0; i < a->instance_count; i++) {
        assert_int_equal(a->instances[i].hidden, b->instances[i].hidden);
        assert_int_equal(a->instances[i].occluded, b->instances[i].occluded);
    }
    assert_int_equal(a->unit_count, b->unit_count);
    for (size_t i = 0; i < a->unit_count; i++) {
        assert_int_equal(a->units[i].used, b->units[i].used);
        if (a->units[i].used) {
            assert_int_equal(a->units[i].record_count, b->units[i].record_count);
            assert_int_equal(a->units[i].vertex_count, b->units[i].vertex_count);
            assert_int_equal(a->units[i].word_count, b->units[i].word_count);
            compare_records(t, i);
            compare_words(t, i);
            compare_vertices(t, i);
        }
    }
}

enum { RAYS_ACROSS = 20, RAYS = RAYS_ACROSS * RAYS_ACROSS };

// From the camera's place, and from within the scene: a fan each.
static void make_rays(clast_ray *rays)
{
    for (int i = 0; i < RAYS; i++) {
        float x = (float)(i % RAYS_ACROSS) / RAYS_ACROSS * 2.0f - 1.0f, y = (float)i / RAYS * 2.0f - 1.0f;
        rays[i] = i % 2 == 0 ? (clast_ray){{0.1f, 0.2f, 10.0f}, 0.0f, {0.6f * x, 0.5f * y, -1.0f}, INFINITY}
                             : (clast_ray){{0.1f, 0.05f, 0.2f}, 0.0f, {x, y, x * y - 0.3f}, INFINITY};
    }
}

static void trace_on_device(const twins *t, const clast_ray *rays, clast_hit *hits)
{
    clast_gpu_buffer from, to, scratch;
    clast_gpu_commands *commands;
    clast_gpu_memory memory = CLAST_GPU_DEVICE;
    assert_ok(device.context, clast_gpu_allocate(device.gpu, memory, RAYS * sizeof *rays, "rays", &from));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, memory, RAYS * sizeof *hits, "hits", &to));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, memory, CLAST_GPU_RAYS_SCRATCH, "scratch", &scratch));
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &from, 0, rays, RAYS * sizeof *rays);
    clast_gpu_barrier(commands);
    clast_gpu_trace_closest(commands, &(clast_gpu_rays){.scene = clast_vulkan_frame_scene(t->made),
                                                        .rays = from.address,
                                                        .to = to.address,
                                                        .scratch = &scratch,
                                                        .count = RAYS});
    clast_gpu_read(commands, &to, 0, hits, RAYS * sizeof *hits);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &from);
    clast_gpu_free(device.gpu, &to);
    clast_gpu_free(device.gpu, &scratch);
}

static void compare_hits(const twins *t)
{
    static clast_ray rays[RAYS];
    static clast_hit expected[RAYS], hits[RAYS];
    make_rays(rays);
    clast_trace_closest(t->stage.frame->tlas, rays, RAYS, NULL, expected);
    trace_on_device(t, rays, hits);
    for (int i = 0; i < RAYS; i++) {
        assert_int_equal(hits[i].instance, expected[i].instance);
        if (hits[i].instance != CLAST_NONE) {
            assert_int_equal(hits[i].cluster, expected[i].cluster);
            assert_int_equal(hits[i].triangle, expected[i].triangle);
            assert_true(hits[i].t == expected[i].t && hits[i].u == expected[i].u && hits[i].v == expected[i].v);
        }
    }
}

static void run_and_compare(twins *t)
{
    stage_run(&t->stage);
    assert_ok(device.context, twins_try(t));
    compare(t);
    compare_hits(t);
}

static void add_sea(twins *t)
{
    clast_context *context = device.context;
    clast_scene *scene = t->stage.scene;
    shape_add_instance(context, scene, shape_add_wave(context, scene, 8), 0, -1, 0, 1);
    shape_add_instance(context, scene, shape_add_wave(context, scene, 3), 0, -3, -20, 1);
    shape_add_instance(context, scene, shape_add_sphere(context, scene, 10, 10), 0, 0, 0, 1);
}

static void add_bumps(twins *t)
{
    uint32_t geometry = shape_add_sphere(device.context, t->stage.scene, 24, 13);
    shape_displace(device.context, t->stage.scene, geometry, 0, 0.2f);
    shape_add_instance(device.context, t->stage.scene, geometry, 0.5f, 0, 1, 1);
}

static void a_frame_has_the_same_records_and_vertices(void **state)
{
    (void)state;
    twins t = twins_open();
    add_sea(&t);
    run_and_compare(&t);
    assert_true(t.frame->clusters > 0 && t.frame->vertices > 0);
    twins_close(&t);
}

static void what_moves_is_filled_anew(void **state)
{
    (void)state;
    twins t = twins_open();
    add_sea(&t);
    for (int i = 0; i < 4; i++) {
        t.stage.frame->settings.time = i == 2 ? 0.25 : 0.25 * i;
        t.stage.frame->settings.rate = i == 3 ? 0.3 : 1.0;
        run_and_compare(&t);
    }
    twins_close(&t);
}

static void budgets_give_the_same_at_every_step(void **state)
{
    (void)state;
    twins t = twins_open();
    add_sea(&t);
    run_and_compare(&t);
    uint64_t all = t.frame->triangles, minimum = t.frame->minimum.triangles;
    for (uint64_t budget = minimum; budget < all + 400; budget += 391) {
        t.stage.frame->settings.max_triangles = budget;
        run_and_compare(&t);
    }
    t.stage.frame->settings.max_triangles = minimum - 1;
    assert_int_equal(stage_try(&t.stage), CLAST_ERROR_BUDGET);
    char refusal[256];
    snprintf(refusal, sizeof refusal, "%s", clast_context_error(device.context));
    assert_int_equal(twins_try(&t), CLAST_ERROR_BUDGET);
    assert_string_equal(clast_context_error(device.context), refusal);
    t.stage.frame->settings.max_triangles = 0;
    t.stage.frame->settings.max_bytes = t.frame->minimum.bytes + 100000;
    run_and_compare(&t);
    twins_close(&t);
}

static void displaced_meshes_are_the_same(void **state)
{
    (void)state;
    twins t = twins_open();
    add_bumps(&t);
    run_and_compare(&t);
    assert_true(t.frame->triangles > 2000);
    t.stage.frame->settings.rate = 0.4;
    run_and_compare(&t);
    t.stage.frame->settings.displacement_scale = 0.5;
    run_and_compare(&t);
    t.stage.frame->settings.max_triangles = t.frame->minimum.triangles + 300;
    run_and_compare(&t);
    twins_close(&t);
}

static void edits_between_frames_are_followed(void **state)
{
    (void)state;
    twins t = twins_open();
    add_sea(&t);
    run_and_compare(&t);
    add_bumps(&t);
    run_and_compare(&t);
    shape s = shape_sphere(10, 10);
    for (uint32_t i = 0; i < 3 * s.mesh.vertex_count; i++) {
        s.positions[i] *= 1.5f;
    }
    assert_ok(device.context, clast_scene_set_mesh_positions(t.stage.scene, 2, s.positions, NULL));
    shape_free(&s);
    run_and_compare(&t);
    for (int visible = 0; visible < 2; visible++) { // what was out of a frame comes back
        assert_ok(device.context, clast_scene_set_instance_visible(t.stage.scene, 1, visible != 0));
        run_and_compare(&t);
    }
    assert_ok(device.context, clast_scene_remove_instance(t.stage.scene, 0));
    run_and_compare(&t);
    twins_close(&t);
}

// A sphere that swells as the weight of its node grows.
static uint32_t add_swelling(twins *t, bool displaced)
{
    clast_scene *scene = t->stage.scene;
    shape s = shape_sphere(12, 9);
    uint32_t geometry = shape_add_sphere(device.context, scene, 12, 9), node = CLAST_NONE;
    const float rest = 0.0f;
    if (displaced) {
        shape_displace(device.context, scene, geometry, 0, 0.2f);
    }
    const clast_morph_target target = {.positions = s.positions, .normals = s.positions};
    assert_ok(device.context, clast_scene_add_node(scene, &(clast_node_desc){.parent = CLAST_NONE}, NULL, &node));
    assert_ok(device.context, clast_scene_set_node_weights(scene, node, &rest, 1));
    assert_ok(device.context, clast_scene_set_mesh_morph(scene, geometry, &target, 1, node));
    shape_free(&s);
    shape_add_instance(device.context, scene, geometry, 0, 0, 0, 1);
    return node;
}

static void swell(bool displaced)
{
    twins t = twins_open();
    uint32_t node = add_swelling(&t, displaced);
    for (int i = 0; i < 3; i++) {
        const float weight = 0.25f * (float)(i != 2 ? i : 1);
        assert_ok(device.context, clast_scene_set_node_weights(t.stage.scene, node, &weight, 1));
        run_and_compare(&t);
    }
    twins_close(&t);
}

static void meshes_that_morph_are_the_same(void **state)
{
    (void)state;
    swell(false);
    swell(true);
}

static void what_lies_behind_is_hidden_alike(void **state)
{
    (void)state;
    twins t = twins_open();
    clast_context *context = device.context;
    clast_scene *scene = t.stage.scene;
    shape_add_instance(context, scene, shape_add_sphere(context, scene, 24, 16), 0, 0, 4, 2);
    shape_add_instance(context, scene, shape_add_wave(context, scene, 4), 0, 0, -30, 0.2f);
    add_bumps(&t);
    run_and_compare(&t);
    assert_true(t.frame->instances[1].occluded && !t.frame->instances[0].occluded);
    const float aside[12] = {2, 0, 0, 5, 0, 2, 0, 0, 0, 0, 2, 4};
    assert_ok(context, clast_scene_set_instance_transform(scene, 0, aside));
    run_and_compare(&t);
    assert_true(!t.frame->instances[1].occluded);
    twins_close(&t);
}

static uint64_t triangles_behind(twins *t, float x)
{
    const float at[12] = {1.5f, 0, 0, x, 0, 1.5f, 0, 0, 0, 0, 1.5f, 4};
    assert_ok(device.context, clast_scene_set_instance_transform(t->stage.scene, 1, at));
    run_and_compare(t);
    return t->frame->triangles;
}

// A sphere goes by before another: it hides some of its edges, and then none.
static void edges_that_lie_behind_are_hidden_alike(void **state)
{
    (void)state;
    twins t = twins_open();
    clast_scene *scene = t.stage.scene;
    t.stage.frame->settings.width = 1280;
    t.stage.frame->settings.height = 720;
    uint32_t geometry = shape_add_sphere(device.context, scene, 32, 21);
    shape_displace(device.context, scene, geometry, 0, 0.01f);
    shape_add_instance(device.context, scene, geometry, 0, 0, -2, 3);
    shape_add_instance(device.context, scene, shape_add_sphere(device.context, scene, 24, 16), 0, 0, 4, 1);
    uint64_t open = triangles_behind(&t, 20), last = open;
    assert_true(load_address(t.frame->units[0].view.depths) != 0); // it hides itself
    for (int i = 0; i < 3; i++) {
        uint64_t triangles = triangles_behind(&t, 2.0f - (float)i);
        assert_true(triangles < last);
        last = triangles;
    }
    assert_true(last < open * 9 / 10);
    assert_int_equal(triangles_behind(&t, 20), open);
    t.stage.frame->settings.hidden_fraction = 1.0;
    assert_true(triangles_behind(&t, 0) > open);
    twins_close(&t);
}

static void frames_do_not_depend_on_those_before(void **state)
{
    (void)state;
    twins t = twins_open();
    add_sea(&t);
    add_bumps(&t);
    const double rates[] = {1.0, 0.05, 1.5, 0.0, 0.7};
    for (int i = 0; i < 10; i++) {
        t.stage.frame->settings.rate = rates[i % 5];
        t.stage.frame->settings.max_bytes = i >= 5 ? (uint64_t)1 << 30 : 0; // rooms are as large as is needed, no more
        run_and_compare(&t);
    }
    twins_close(&t);
}

static void frames_without_anything_are_empty(void **state)
{
    (void)state;
    twins t = twins_open();
    run_and_compare(&t);
    assert_int_equal(t.frame->triangles, 0);
    add_sea(&t);
    run_and_compare(&t);
    for (uint32_t i = 0; i < 3; i++) {
        assert_ok(device.context, clast_scene_remove_instance(t.stage.scene, i));
    }
    run_and_compare(&t);
    twins_close(&t);
}

static void what_does_not_fit_the_device_is_refused(void **state)
{
    (void)state;
    clast_gpu *whole = device.gpu;
    clast_gpu_desc desc = {.software = true, .hardware = true, .memory_limit = (uint64_t)96 << 20};
    assert_ok(device.context, clast_gpu_create(device.context, &desc, &device.gpu));
    twins t = twins_open();
    uint32_t geometry = shape_add_wave(device.context, t.stage.scene, 300);
    shape_add_instance(device.context, t.stage.scene, geometry, 0, -1, 0, 1);
    t.stage.frame->settings.rate = 100.0;
    assert_ok(device.context, clast_cooked_update(t.stage.cooked, t.stage.scene));
    assert_int_equal(twins_try(&t), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(clast_vulkan_frame_scene(t.made), 0);
    t.stage.frame->settings.rate = 0.0;
    run_and_compare(&t);
    twins_close(&t);
    clast_gpu_destroy(device.gpu);
    device.gpu = whole;
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_has_the_same_records_and_vertices),
        cmocka_unit_test(what_moves_is_filled_anew),
        cmocka_unit_test(budgets_give_the_same_at_every_step),
        cmocka_unit_test(displaced_meshes_are_the_same),
        cmocka_unit_test(edits_between_frames_are_followed),
        cmocka_unit_test(meshes_that_morph_are_the_same),
        cmocka_unit_test(what_lies_behind_is_hidden_alike),
        cmocka_unit_test(edges_that_lie_behind_are_hidden_alike),
        cmocka_unit_test(frames_do_not_depend_on_those_before),
        cmocka_unit_test(frames_without_anything_are_empty),
        cmocka_unit_test(what_does_not_fit_the_device_is_refused),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) && failed == 0 ? 0 : 1;
}
