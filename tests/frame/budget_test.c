// SPDX-License-Identifier: Apache-2.0
// The ladder of rates, views, and budgets.
#include "frame/stage.h"

#include <string.h>

static void the_ladder_falls_by_sixteenths_of_a_power_of_two(void **state)
{
    (void)state;
    assert_true(clast_frame_rate_step(0) == 1.0f);
    for (uint32_t step = 0; step < CLAST_FRAME_LAST_RATE_STEP; step++) {
        float rate = clast_frame_rate_step(step);
        assert_true(fabs((double)rate - pow(2.0, -(double)step / 16.0)) <= 1e-7 * (double)rate);
        assert_true(clast_frame_rate_step(step + 1) < rate);
    }
    assert_true(clast_frame_rate_step(16) == 0.5f);
    assert_true(clast_frame_rate_step(CLAST_FRAME_LAST_RATE_STEP) == CLAST_RATE_LEAST);
    assert_true(clast_frame_rate_step(UINT32_MAX) == CLAST_RATE_LEAST);
}

static stage open_sea(clast_context *context)
{
    stage s = stage_open(context);
    shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 8), 0, -1, 0, 1);
    shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 3), 0, -3, -20, 1);
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 10, 10), 0, 0, 0, 1);
    return s;
}

static void budgets_are_kept_and_used(void **state)
{
    stage s = open_sea(*state);
    stage_run(&s);
    uint64_t all = s.frame->triangles, minimum = s.frame->minimum.triangles;
    assert_int_equal(minimum, 8 * 8 * 2 + 3 * 3 * 2 + 200);
    assert_true(all > 4 * minimum);
    float last_rate = 0.0f;
    uint64_t last = 0;
    for (uint64_t budget = minimum; budget < all + 200; budget += 97) {
        s.frame->settings.max_triangles = budget;
        stage_run(&s);
        assert_true(s.frame->triangles <= budget);
        assert_true(s.frame->fitted_rate >= last_rate && s.frame->triangles >= last);
        last_rate = s.frame->fitted_rate;
        last = s.frame->triangles;
        uint64_t sum = 0;
        for (size_t i = 0; i < s.frame->unit_count; i++) {
            for (size_t r = 0; r < s.frame->units[i].record_count; r++) {
                sum += clast_template_triangle_count(s.cooked->templates, s.frame->units[i].records[r].template_index);
            }
        }
        assert_int_equal(sum, s.frame->triangles);
    }
    assert_true(last_rate == 1.0f);
    assert_int_equal(last, all);
    stage_close(&s);
}

static uint64_t triangles_at(stage *s, double rate)
{
    clast_frame *frame = stage_add_frame(s);
    frame->settings.rate = rate;
    assert_ok(s->context, clast_frame_run(frame, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_FIT, NULL));
    uint64_t triangles = frame->triangles;
    clast_frame_destroy(frame);
    return triangles;
}

static void the_first_step_that_fits_is_taken(void **state)
{
    stage s = open_sea(*state);
    stage_run(&s);
    for (uint64_t budget = s.frame->minimum.triangles; budget < s.frame->triangles; budget += 511) {
        uint32_t expected = 0;
        while (triangles_at(&s, (double)clast_frame_rate_step(expected)) > budget) {
            expected++;
        }
        clast_frame *frame = stage_add_frame(&s);
        frame->settings.max_triangles = budget;
        assert_ok(s.context, clast_frame_run(frame, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_FIT, NULL));
        assert_true(frame->fitted_rate == clast_frame_rate_step(expected));
        clast_frame_destroy(frame);
    }
    stage_close(&s);
}

static void a_budget_below_the_minimum_is_refused_with_the_number(void **state)
{
    clast_context *context = *state;
    stage s = open_sea(context);
    s.frame->settings.max_triangles = 346;
    stage_run(&s);
    assert_true(s.frame->fitted_rate == CLAST_RATE_LEAST || s.frame->triangles == 346);
    s.frame->settings.max_triangles = 345;
    assert_int_equal(stage_try(&s), CLAST_ERROR_BUDGET);
    assert_non_null(strstr(clast_context_error(context), "345"));
    assert_non_null(strstr(clast_context_error(context), "346"));
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, CLAST_NONE);
    s.frame->settings.max_triangles = 0;
    stage_run(&s);
    assert_int_equal(stage_trace(s.frame, 0, 0.1f, 10, 0, 0, -1).instance, 2);
    stage_close(&s);
}

// Bytes that the frame holds, all of them.
static uint64_t held_bytes(const clast_frame *frame)
{
    clast_frame_bytes bytes = clast_frame_count_bytes(frame);
    return bytes.records + bytes.vertices + bytes.clas + bytes.blas + bytes.tlas;
}

static void clusters_and_memory_are_bounded_too_and_it_is_told_what_bound(void **state)
{
    stage s = stage_open(*state);
    shape_add_instance(s.context, s.scene, shape_add_wave(s.context, s.scene, 8), 0, -1, 0, 1);
    shape_add_instance(s.context, s.scene, shape_add_sphere(s.context, s.scene, 10, 10), 0, 0, 0, 1);
    stage_run(&s);
    clast_frame_need all = s.frame->wanted;
    assert_int_equal(s.frame->bound, CLAST_BOUND_NONE);
    assert_memory_equal(&all, &s.frame->granted, sizeof all);
    assert_true(held_bytes(s.frame) <= all.bytes);
    s.frame->settings.max_bytes = (s.frame->minimum.bytes + all.bytes) / 2;
    stage_run(&s);
    assert_int_equal(s.frame->bound, CLAST_BOUND_MEMORY);
    assert_true(s.frame->granted.bytes <= s.frame->settings.max_bytes && s.frame->granted.bytes < all.bytes);
    assert_true(held_bytes(s.frame) <= s.frame->settings.max_bytes); // what was there before gave way
    assert_memory_equal(&all, &s.frame->wanted, sizeof all);
    uint64_t triangles = s.frame->triangles;
    s.frame->settings.max_triangles = triangles - 1;
    stage_run(&s);
    assert_int_equal(s.frame->bound, CLAST_BOUND_TRIANGLES);
    assert_true(s.frame->triangles < triangles);
    s.frame->settings.max_triangles = 0;
    s.frame->settings.max_bytes = 0;
    s.frame->settings.max_clusters = s.frame->minimum.clusters; // a tile is a cluster at any rate
    stage_run(&s);
    assert_int_equal(s.frame->bound, CLAST_BOUND_NONE);
    assert_int_equal(s.frame->triangles, all.triangles);
    stage_close(&s);
}

static void each_budget_below_its_minimum_is_refused_before_anything_is_made(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 8), 0, -1, 0, 1);
    shape_add_instance(context, s.scene, shape_add_sphere(context, s.scene, 100, 100), 0, 0, 0, 1);
    s.frame->settings.max_bytes = 10000;
    assert_int_equal(stage_try(&s), CLAST_ERROR_BUDGET);
    char number[32];
    snprintf(number, sizeof number, "%llu", (unsigned long long)s.frame->minimum.bytes);
    assert_non_null(strstr(clast_context_error(context), number));
    assert_true(held_bytes(s.frame) < 10000);
    s.frame->settings.max_bytes = s.frame->minimum.bytes;
    stage_run(&s);
    assert_true(held_bytes(s.frame) <= s.frame->minimum.bytes);
    s.frame->settings.max_bytes = 0;
    s.frame->settings.max_clusters = s.frame->minimum.clusters - 1;
    assert_int_equal(stage_try(&s), CLAST_ERROR_BUDGET);
    assert_non_null(strstr(clast_context_error(context), "clusters"));
    stage_close(&s);
}

static void instances_do_not_count_twice(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 10, 10);
    for (int i = 0; i < 5; i++) {
        shape_add_instance(context, s.scene, sphere, 3.0f * (float)i - 6.0f, 0, 0, 1);
    }
    s.frame->settings.max_triangles = 200;
    stage_run(&s);
    assert_int_equal(s.frame->triangles, 200);
    assert_int_equal(s.frame->instanced_triangles, 1000);
    stage_close(&s);
}

// --------------------------------------------------------------------------------------------------------------- views

static void what_the_camera_cannot_see_is_hidden_and_coarser_but_there(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t seen = shape_add_wave(context, s.scene, 4), behind = shape_add_wave(context, s.scene, 4);
    shape_add_instance(context, s.scene, seen, 0, -1, 0, 1);
    shape_add_instance(context, s.scene, behind, 0, -1, 20, 1); // as far away, on the other side
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    assert_true(s.frame->instances[1].hidden);
    assert_int_equal(s.frame->units[seen].view.hidden, 0);
    assert_int_equal(s.frame->units[behind].view.hidden, 1);
    assert_true(s.frame->units[behind].sum.triangles < s.frame->units[seen].sum.triangles);
    assert_int_equal(stage_trace(s.frame, 0.2f, 5, 20.1f, 0, -1, 0).instance, 1);
    shape_add_instance(context, s.scene, behind, 0, -1, 0, 1);
    stage_run(&s);
    assert_int_equal(s.frame->units[behind].view.hidden, 0);
    stage_close(&s);
}

static void every_side_of_the_frustum_hides(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t sphere = shape_add_sphere(context, s.scene, 8, 8);
    // at the origin the camera sees 4.2 up and down, 7.5 left and right
    const float places[][4] = {{9.5f, 0, 0, 1},  {-9.5f, 0, 0, 1}, {0, 6, 0, 1},     {0, -6, 0, 1},
                               {0, 0, 11.5f, 1}, {0, 0, -32, 1},   {8, 0, 0, 0},     {-8, 0, 0, 0},
                               {0, 4.9f, 0, 0},  {0, -4.9f, 0, 0}, {0, 0, 10.5f, 0}, {0, 0, -29, 0}};
    enum { PLACES = sizeof places / sizeof places[0] };
    for (int i = 0; i < PLACES; i++) {
        shape_add_instance(context, s.scene, sphere, places[i][0], places[i][1], places[i][2], 1);
    }
    s.frame->settings.rate_camera.far_plane = 40.0f;
    stage_run(&s);
    for (int i = 0; i < PLACES; i++) {
        if (s.frame->instances[i].hidden != (places[i][3] != 0.0f)) {
            fail_msg("place %d", i);
        }
    }
    stage_close(&s);
}

static void an_orthographic_camera_sees_all_at_the_same_rate(void **state)
{
    clast_context *context = *state;
    uint64_t triangles[2];
    for (int far_away = 0; far_away < 2; far_away++) {
        stage s = stage_open(context);
        shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 4), 0, 0, far_away ? -1000.0f : 0.0f, 1);
        clast_camera_desc desc = {.projection = CLAST_PROJECTION_ORTHOGRAPHIC, .position = {0, 0, 10}, .height = 8.0f};
        s.frame->settings.rate_camera = clast_camera_record(&desc, 640, 360);
        stage_run(&s);
        assert_false(s.frame->instances[0].hidden);
        triangles[far_away] = s.frame->triangles;
        stage_close(&s);
    }
    assert_int_equal(triangles[0], triangles[1]);
    assert_true(triangles[0] > 4 * 4 * 2);
}

static void the_nearest_instance_decides_and_its_scale_counts(void **state)
{
    clast_context *context = *state;
    stage s = stage_open(context);
    uint32_t wave = shape_add_wave(context, s.scene, 4);
    shape_add_instance(context, s.scene, wave, 0, 0, -200, 1);
    stage_run(&s);
    uint64_t alone = s.frame->triangles;
    uint32_t near = shape_add_instance(context, s.scene, wave, 0, -1, 0, 1);
    stage_run(&s);
    assert_true(s.frame->triangles > alone);
    uint64_t both = s.frame->triangles;
    assert_ok(context, clast_scene_remove_instance(s.scene, near));
    // ten times as large, ten times as far: seen alike
    shape_add_instance(context, s.scene, wave, 0, -10, -90, 10);
    stage_run(&s);
    assert_int_equal(s.frame->triangles, both);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_ladder_falls_by_sixteenths_of_a_power_of_two),
        CONTEXT_TEST(budgets_are_kept_and_used),
        CONTEXT_TEST(the_first_step_that_fits_is_taken),
        CONTEXT_TEST(a_budget_below_the_minimum_is_refused_with_the_number),
        CONTEXT_TEST(clusters_and_memory_are_bounded_too_and_it_is_told_what_bound),
        CONTEXT_TEST(each_budget_below_its_minimum_is_refused_before_anything_is_made),
        CONTEXT_TEST(instances_do_not_count_twice),
        CONTEXT_TEST(what_the_camera_cannot_see_is_hidden_and_coarser_but_there),
        CONTEXT_TEST(every_side_of_the_frustum_hides),
        CONTEXT_TEST(an_orthographic_camera_sees_all_at_the_same_rate),
        CONTEXT_TEST(the_nearest_instance_decides_and_its_scale_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
