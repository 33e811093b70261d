// SPDX-License-Identifier: Apache-2.0
// Memory that runs out in the middle of cooking or of a frame: a clean error, nothing that dangles, and the next run makes
// what was missing.
#include "frame/stage.h"
#include "scarce.h"

static void fill_scene(stage *s)
{
    uint32_t sphere = shape_add_sphere(s->context, s->scene, 12, 12);
    uint32_t wave = shape_add_wave(s->context, s->scene, 2);
    shape_add_instance(s->context, s->scene, sphere, 0, 0, 0, 1);
    shape_add_instance(s->context, s->scene, wave, 0, -2, 0, 1);
    clast_material_desc lamp = clast_material_defaults();
    lamp.emissive[0] = 1.0f;
    assert_ok(s->context, clast_scene_set_material(s->scene, 0, &lamp));
}

// Opens the seam, so that the sphere is cooked anew.
static void tear_sphere(stage *s)
{
    shape sphere = shape_sphere(12, 12);
    for (uint32_t i = 0; i < sphere.mesh.vertex_count; i++) {
        sphere.positions[3 * i] += 1e-4f * (float)i;
    }
    assert_ok(s->context, clast_scene_set_mesh_positions(s->scene, 0, sphere.positions, NULL));
    shape_free(&sphere);
}

// Runs with the nth allocation failing; true where there was one.
static bool run_short(stage *s, shortage *shortage, int64_t n)
{
    uint32_t failed = shortage->failed;
    shortage->left = n;
    clast_status status = stage_try(s);
    shortage->left = -1;
    bool hit = shortage->failed != failed;
    assert_int_equal(status, hit ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_OK);
    if (hit) { // what rays see is nothing, or what was there: never what is no more
        stage_trace(s->frame, 0.1f, 0.1f, 10, 0, 0, -1);
        stage_run(s);
    }
    assert_int_equal(stage_trace(s->frame, 0.1f, 0.1f, 10, 0, 0, -1).instance, 0);
    assert_int_equal(stage_trace(s->frame, 3.1f, 0.1f, 0.2f, 0, -1, 0).instance, 1);
    assert_true(s->frame->emitter_count > 0);
    return hit;
}

static void a_frame_recovers_from_want_of_memory(void **state)
{
    (void)state;
    shortage shortage;
    clast_context *context = scarce_context(&shortage);
    uint64_t memory = clast_context_memory(context);
    bool more = true;
    for (int64_t n = 0; more; n++) {
        stage s = stage_open(context);
        fill_scene(&s);
        more = run_short(&s, &shortage, n);
        stage_close(&s);
        assert_int_equal(clast_context_memory(context), memory);
    }
    assert_true(shortage.failed > 20);
    clast_context_destroy(context);
}

static void a_change_recovers_from_want_of_memory(void **state)
{
    (void)state;
    shortage shortage;
    clast_context *context = scarce_context(&shortage);
    uint64_t memory = clast_context_memory(context);
    bool more = true;
    for (int64_t n = 0; more; n++) {
        stage s = stage_open(context);
        fill_scene(&s);
        s.frame->settings.rate_camera.position.v[2] = 1000.0f; // coarse first, so that all grows
        stage_run(&s);
        s.frame->settings.rate_camera = stage_camera();
        tear_sphere(&s);
        more = run_short(&s, &shortage, n);
        stage_close(&s);
        assert_int_equal(clast_context_memory(context), memory);
    }
    assert_true(shortage.failed > 10);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_recovers_from_want_of_memory),
        cmocka_unit_test(a_change_recovers_from_want_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
