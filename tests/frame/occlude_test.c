// SPDX-License-Identifier: Apache-2.0
// What lies behind other things is coarser, and there all the same.
#include "frame/stage.h"

// A square in the plane z, facing the eye, or away from it.
static uint32_t add_wall(stage *s, float half, float z, bool faces_eye, uint32_t material)
{
    const float positions[] = {-half, -half, z, half, -half, z, half, half, z, -half, half, z};
    const uint32_t indices[2][6] = {{0, 2, 1, 0, 3, 2}, {0, 1, 2, 0, 2, 3}};
    clast_mesh mesh = {.vertex_count = 4,
                       .triangle_count = 2,
                       .positions = positions,
                       .indices = indices[faces_eye ? 1 : 0],
                       .material = material};
    uint32_t geometry;
    assert_ok(s->context, clast_scene_add_mesh(s->scene, &mesh, NULL, &geometry));
    return shape_add_instance(s->context, s->scene, geometry, 0, 0, 0, 1);
}

// A sheet around the origin; the eye is ten before it.
static stage open_sheet(clast_context *context)
{
    stage s = stage_open(context);
    shape_add_instance(context, s.scene, shape_add_wave(context, s.scene, 4), 0, -1, 0, 1);
    return s;
}

static void what_lies_behind_a_wall_is_coarser_but_there(void **state)
{
    stage s = open_sheet(*state);
    stage_run(&s);
    uint64_t seen = s.frame->units[0].sum.triangles;
    assert_false(s.frame->instances[0].occluded);
    uint32_t wall = add_wall(&s, 9.0f, 7.0f, true, CLAST_NONE);
    stage_run(&s);
    assert_true(s.frame->instances[0].occluded && s.frame->instances[0].hidden);
    assert_int_equal(s.frame->units[0].view.hidden, 1);
    assert_true(s.frame->units[0].sum.triangles < seen);
    assert_int_equal(stage_trace(s.frame, 0.2f, 5, 0.1f, 0, -1, 0).instance, 0);
    assert_int_equal(stage_trace(s.frame, 0.2f, 0, 10, 0, 0, -1).instance, wall);
    assert_ok(s.context, clast_scene_remove_instance(s.scene, wall));
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    assert_int_equal(s.frame->units[0].sum.triangles, seen);
    stage_close(&s);
}

static void what_is_seen_past_a_wall_is_not_hidden(void **state)
{
    const float halves[] = {0.5f, 1.5f, 2.5f};
    for (int i = 0; i < 3; i++) {
        stage s = open_sheet(*state);
        add_wall(&s, halves[i], 5.5f, true, CLAST_NONE);
        stage_run(&s);
        assert_false(s.frame->instances[0].hidden);
        stage_close(&s);
    }
    stage s = open_sheet(*state);
    add_wall(&s, 50.0f, -7.0f, true, CLAST_NONE); // behind the sheet
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    stage_close(&s);
}

static void backs_and_transparent_surfaces_hide_nothing(void **state)
{
    stage s = open_sheet(*state);
    add_wall(&s, 9.0f, 7.0f, false, CLAST_NONE);
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    clast_material_desc glass = clast_material_defaults();
    glass.alpha_mode = CLAST_ALPHA_BLEND;
    glass.base_colour[3] = 0.5f;
    uint32_t material;
    assert_ok(s.context, clast_scene_add_material(s.scene, &glass, NULL, &material));
    add_wall(&s, 9.0f, 7.0f, true, material);
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    stage_close(&s);
}

static void sheets_hide_each_other_but_not_themselves(void **state)
{
    stage s = open_sheet(*state);
    uint32_t small = shape_add_wave(s.context, s.scene, 2);
    shape_add_instance(s.context, s.scene, small, 0, -2.2f, 0, 0.05f); // under the first
    s.frame->settings.camera.position.v[1] = s.frame->settings.rate_camera.position.v[1] = 1.0f;
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    assert_false(s.frame->instances[1].hidden); // the first moves further than a depth is wide
    stage_close(&s);
    clast_wave flat = {.size = 10, .tiles = 2, .amplitude = 1e-3f, .wavelength = 4, .material = CLAST_NONE};
    s = stage_open(*state);
    uint32_t geometry;
    assert_ok(s.context, clast_scene_add_wave(s.scene, &flat, NULL, &geometry));
    shape_add_instance(s.context, s.scene, geometry, 0, -1, 0, 1);
    small = shape_add_wave(s.context, s.scene, 2);
    shape_add_instance(s.context, s.scene, small, 0, -2.2f, 0, 0.05f);
    s.frame->settings.rate_camera.position.v[1] = 1.0f;
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    assert_true(s.frame->instances[1].occluded);
    stage_close(&s);
}

static void nothing_is_done_where_it_would_change_nothing(void **state)
{
    stage s = open_sheet(*state);
    add_wall(&s, 9.0f, 7.0f, true, CLAST_NONE);
    stage_run(&s);
    assert_true(s.frame->pyramid.level_count > 0 && s.frame->occlude_bytes > 0);
    s.frame->settings.hidden_fraction = 1.0;
    stage_run(&s);
    assert_true(s.frame->pyramid.level_count == 0 && s.frame->occlude_bytes == 0);
    assert_false(s.frame->instances[0].hidden);
    stage_close(&s);
    s = stage_open(*state);
    shape_add_instance(s.context, s.scene, shape_add_sphere(s.context, s.scene, 10, 10), 0, 0, 0, 1);
    stage_run(&s);
    assert_int_equal(s.frame->pyramid.level_count, 0);
    assert_null(s.frame->coarse_tlas);
    stage_close(&s);
}

static void it_is_the_frame_itself_that_decides(void **state)
{
    stage s = open_sheet(*state);
    add_wall(&s, 9.0f, 7.0f, true, CLAST_NONE);
    clast_frame_settings wanted = s.frame->settings;
    stage_run(&s);
    uint64_t expected = s.frame->triangles;
    s.frame->settings.rate_camera.position.v[2] = 6.5f; // before the wall
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    assert_true(s.frame->triangles > expected);
    s.frame->settings = wanted;
    stage_run(&s);
    assert_true(s.frame->instances[0].occluded);
    assert_int_equal(s.frame->triangles, expected);
    stage_close(&s);
}

static void parallel_rays_find_what_is_hidden_too(void **state)
{
    stage s = open_sheet(*state);
    clast_camera_desc desc = {.projection = CLAST_PROJECTION_ORTHOGRAPHIC, .position = {0, 0, 10}, .height = 12.0f};
    s.frame->settings.rate_camera = clast_camera_record(&desc, 640, 360);
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    uint32_t wall = add_wall(&s, 6.5f, 7.0f, true, CLAST_NONE);
    stage_run(&s);
    assert_true(s.frame->instances[0].occluded);
    assert_ok(s.context, clast_scene_remove_instance(s.scene, wall));
    add_wall(&s, 4.5f, 7.0f, true, CLAST_NONE);
    stage_run(&s);
    assert_false(s.frame->instances[0].hidden);
    stage_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(what_lies_behind_a_wall_is_coarser_but_there),
        CONTEXT_TEST(what_is_seen_past_a_wall_is_not_hidden),
        CONTEXT_TEST(backs_and_transparent_surfaces_hide_nothing),
        CONTEXT_TEST(sheets_hide_each_other_but_not_themselves),
        CONTEXT_TEST(nothing_is_done_where_it_would_change_nothing),
        CONTEXT_TEST(it_is_the_frame_itself_that_decides),
        CONTEXT_TEST(parallel_rays_find_what_is_hidden_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
