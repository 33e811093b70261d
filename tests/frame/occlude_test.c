// SPDX-License-Identifier: Apache-2.0
// What lies behind other things is coarser, and there all the same.
#include "frame/stage.h"

#include "shared/occlusion.h"
#include "source/displaced.h"

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

// -------------------------------------------------------------------------------------------------------------- edges

enum { SHEET_CELLS = 24, SHEET_SIDE = SHEET_CELLS + 1, SHEET_VERTICES = SHEET_SIDE * SHEET_SIDE };

// Squares that face the eye, around the origin: all before `bend` are at z = 0, the others so far behind.
static uint32_t add_sheet(stage *s, float half, uint32_t bend, float behind)
{
    float positions[SHEET_VERTICES][3], coordinates[SHEET_VERTICES][2];
    uint32_t indices[SHEET_CELLS * SHEET_CELLS][6];
    for (uint32_t i = 0; i < SHEET_VERTICES; i++) {
        uint32_t x = i % SHEET_SIDE, y = i / SHEET_SIDE;
        coordinates[i][0] = (float)x / SHEET_CELLS;
        coordinates[i][1] = (float)y / SHEET_CELLS;
        positions[i][0] = half * (2.0f * coordinates[i][0] - 1.0f);
        positions[i][1] = half * (2.0f * coordinates[i][1] - 1.0f);
        positions[i][2] = y < bend ? 0.0f : -behind;
    }
    for (uint32_t i = 0; i < SHEET_CELLS * SHEET_CELLS; i++) {
        uint32_t at = i / SHEET_CELLS * SHEET_SIDE + i % SHEET_CELLS;
        const uint32_t quad[6] = {at, at + 1, at + SHEET_SIDE + 1, at, at + SHEET_SIDE + 1, at + SHEET_SIDE};
        memcpy(indices[i], quad, sizeof quad);
    }
    clast_mesh mesh = {.vertex_count = SHEET_VERTICES,
                       .triangle_count = 2 * SHEET_CELLS * SHEET_CELLS,
                       .positions = positions[0],
                       .coordinates = {coordinates[0], NULL},
                       .indices = indices[0],
                       .material = 0};
    uint32_t geometry;
    assert_ok(s->context, clast_scene_add_mesh(s->scene, &mesh, NULL, &geometry));
    shape_displace(s->context, s->scene, geometry, 0, 0.01f);
    return shape_add_instance(s->context, s->scene, geometry, 0, 0, 0, 1);
}

static stage displaced_sheet(clast_context *context)
{
    stage s = stage_open(context);
    s.frame->settings.width = 1280;
    s.frame->settings.height = 720;
    add_sheet(&s, 3.0f, SHEET_SIDE, 0.0f);
    return s;
}

// The segments, not rounded, of all edges of a unit, one after the other; room for as many as its cook found.
static size_t segments_of(const clast_frame_unit *unit, float segments[])
{
    const displaced_unit *of = clast_displaced_of(unit->unit);
    clast_rate_view view = clast_displaced_rate_view(of, &unit->pose, &unit->view);
    size_t count = 0;
    for (uint32_t item = 0; item < unit->unit->item_count; item++) {
        for (uint32_t i = 0; i < of->clusters[item].edge_count; i++) {
            segments[count++] = clast_displaced_wanted(of, &unit->pose, &view, &of->clusters[item], i);
        }
    }
    return count;
}

enum { SHEET_EDGES_MOST = 4096 };

// The middle of an edge across, of a unit that does not move.
static float across_of(const clast_frame_unit *unit, size_t number)
{
    const displaced_unit *of = clast_displaced_of(unit->unit);
    uint32_t item = 0;
    for (; number >= of->clusters[item].edge_count; item++) {
        number -= of->clusters[item].edge_count;
    }
    const displaced_cluster *cluster = &of->clusters[item];
    uint32_t ends = of->edges[cluster->first_edge + number].ends;
    return 0.5f * (displaced_vertex_of(of, cluster, ends & 255)->position.v[0] +
                   displaced_vertex_of(of, cluster, ends >> 8 & 255)->position.v[0]);
}

// The wall hides what is left of its edge, from the eye: edges farther from that than the margin are as coarse as ever, those
// to the right of it as fine.
static void edges_behind_a_wall_are_coarser(void **state)
{
    stage s = displaced_sheet(*state);
    static float seen[SHEET_EDGES_MOST], hidden[SHEET_EDGES_MOST];
    stage_run(&s);
    uint64_t triangles = s.frame->triangles;
    const clast_frame_unit *unit = &s.frame->units[0];
    assert_true(load_address(unit->view.depths) == 0); // nothing is before it
    size_t count = segments_of(unit, seen);
    add_wall(&s, 4.0f, 5.0f, true, CLAST_NONE);
    const float aside[12] = {1, 0, 0, -4, 0, 1, 0, 0, 0, 0, 1, 0};
    assert_ok(s.context, clast_scene_set_instance_transform(s.scene, 1, aside));
    stage_run(&s);
    unit = &s.frame->units[0];
    assert_int_equal(unit->view.hidden, 0);
    assert_true(load_address(unit->view.depths) != 0);
    assert_int_equal(segments_of(unit, hidden), count);
    uint32_t fine = 0, coarse = 0;
    for (size_t i = 0; i < count; i++) {
        float across = across_of(unit, i);
        assert_true(hidden[i] <= seen[i] * 1.0001f);
        if (across > 0.0f) {
            assert_true(hidden[i] == seen[i]);
            fine++;
        }
        if (across < -1.5f) {
            assert_true(hidden[i] < 0.5f * seen[i]);
            coarse++;
        }
    }
    assert_true(fine > 400 && coarse > 400);
    assert_true(s.frame->triangles < triangles * 3 / 4);
    assert_int_equal(stage_trace(s.frame, -2, 0.1f, 1, 0, 0, -1).instance, 0); // and it is there
    stage_close(&s);
}

// A wall goes by in small steps: no edge changes by more than a part of what it has when it is seen.
static void edges_change_little_by_little(void **state)
{
    stage s = displaced_sheet(*state);
    static float seen[SHEET_EDGES_MOST], now[SHEET_EDGES_MOST], before[SHEET_EDGES_MOST];
    stage_run(&s);
    size_t count = segments_of(&s.frame->units[0], seen);
    add_wall(&s, 2.5f, 5.0f, true, CLAST_NONE); // from top to bottom
    float least = 1.0f;
    for (int step = 0; step <= 160; step++) {
        float x = -5.0f + 0.04f * (float)step; // less than a place
        const float aside[12] = {1, 0, 0, x, 0, 1, 0, 0.002f * (float)(step - 80), 0, 0, 1, 0};
        assert_ok(s.context, clast_scene_set_instance_transform(s.scene, 1, aside));
        stage_run(&s);
        assert_int_equal(segments_of(&s.frame->units[0], now), count);
        for (size_t i = 0; i < count && step > 0; i++) {
            if (fabsf(now[i] - before[i]) >= 0.18f * seen[i])
                print_message("step %d edge %zu x %g: %g -> %g of %g\n", step, i,
                              (double)across_of(&s.frame->units[0], i), (double)before[i], (double)now[i],
                              (double)seen[i]);
            least = fminf(least, now[i] / seen[i]);
        }
        memcpy(before, now, count * sizeof *now);
    }
    assert_true(least < 0.4f);
    stage_close(&s);
}

// The lower half of a sheet hides the upper one, which bends back, from an eye below: one thing hides itself.
static void a_thing_hides_its_own_edges(void **state)
{
    stage s = stage_open(*state);
    s.frame->settings.width = 1280;
    s.frame->settings.height = 720;
    add_sheet(&s, 3.0f, SHEET_SIDE, 0.0f);
    stage_run(&s);
    assert_true(s.frame->pyramid.row_count > 0);
    assert_true(load_address(s.frame->units[0].view.depths) == 0);
    stage_close(&s);
    s = stage_open(*state);
    s.frame->settings.width = 1280;
    s.frame->settings.height = 720;
    add_sheet(&s, 3.0f, SHEET_SIDE / 2, 12.0f);
    clast_camera_desc desc = {.position = {0, -2, 8}, .target = {0, -1, 0}, .vertical_angle = 0.8f};
    s.frame->settings.rate_camera = clast_camera_record(&desc, 1280, 720);
    stage_run(&s);
    static float now[SHEET_EDGES_MOST], open[SHEET_EDGES_MOST];
    clast_frame_unit *unit = &s.frame->units[0];
    size_t count = segments_of(unit, now), coarser = 0;
    unit->view.depths = store_address(0);
    segments_of(unit, open);
    for (size_t i = 0; i < count; i++) {
        coarser += now[i] < 0.9f * open[i];
    }
    assert_true(load_address(s.frame->units[0].view.depths) == 0 && coarser > 100);
    stage_close(&s);
}

// What changes behind a thing, or far from it in the picture, makes nothing of it anew.
static void only_what_may_hide_edges_changes_them(void **state)
{
    stage s = displaced_sheet(*state);
    add_wall(&s, 1.0f, 5.0f, true, CLAST_NONE);
    uint32_t behind = add_wall(&s, 1.0f, -3.0f, true, CLAST_NONE);
    stage_run(&s);
    for (int i = 1; i < 4; i++) {
        const float moved[12] = {1, 0, 0, 3.0f - 0.5f * (float)i, 0, 1, 0, 0, 0, 0, 1, 0};
        assert_ok(s.context, clast_scene_set_instance_transform(s.scene, i < 3 ? behind : 1, moved));
        stage_run(&s);
        assert_int_equal(s.frame->units[0].change, i < 3 ? CLAST_CHANGE_NOTHING : CLAST_CHANGE_TOPOLOGY);
    }
    stage_run(&s);
    assert_int_equal(s.frame->units[0].change, CLAST_CHANGE_NOTHING);
    stage_close(&s);
}

static void edges_that_no_place_tells_of_stay_as_they_are(void **state)
{
    stage s = displaced_sheet(*state);
    add_wall(&s, 1.0f, 5.0f, true, CLAST_NONE);
    stage_run(&s);
    assert_true(load_address(s.frame->units[0].view.depths) != 0);
    s.frame->settings.metric = CLAST_METRIC_FIXED;
    stage_run(&s);
    assert_true(load_address(s.frame->units[0].view.depths) == 0);
    s.frame->settings.metric = CLAST_METRIC_PIXELS;
    shape_add_instance(s.context, s.scene, 0, 0, 0, -1, 1); // a second of the same
    stage_run(&s);
    assert_true(load_address(s.frame->units[0].view.depths) == 0);
    assert_ok(s.context, clast_scene_remove_instance(s.scene, 2));
    clast_camera_desc around = {.projection = CLAST_PROJECTION_PANORAMA, .position = {0, 0, 10}};
    s.frame->settings.rate_camera = clast_camera_record(&around, 1280, 720);
    stage_run(&s);
    assert_int_equal(s.frame->pyramid.level_count, 0);
    s.frame->settings.rate_camera = stage_camera();
    s.frame->settings.rate_camera.lens_radius = 2.0f; // which sees past the wall
    s.frame->settings.rate_camera.focus = 10.0f;
    stage_run(&s);
    assert_true(load_address(s.frame->units[0].view.depths) == 0);
    stage_close(&s);
}

// As many places as a large picture has would take much memory.
static void large_pictures_have_coarser_places(void **state)
{
    stage s = stage_open(*state);
    add_sheet(&s, 1.0f, SHEET_SIDE, 0.0f);
    add_wall(&s, 0.4f, 5.0f, true, CLAST_NONE);
    s.frame->settings.segment = 20.0;
    s.frame->settings.width = 9000;
    s.frame->settings.height = 5063;
    stage_run(&s);
    const clast_source_view *view = &s.frame->units[0].view;
    assert_true(s.frame->pyramid.width == 1125 && s.frame->pyramid.height == 633);
    assert_true(view->places_across == 563 && view->places_down == 317);
    assert_true(load2(view->places)[0] == 562.5f && load2(view->places)[1] == 316.5f);
    static float now[SHEET_EDGES_MOST];
    size_t count = segments_of(&s.frame->units[0], now), coarse = 0;
    for (size_t i = 0; i < count; i++) {
        coarse += now[i] < 0.3f * now[0];
    }
    assert_true(coarse > 20);
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
        CONTEXT_TEST(edges_behind_a_wall_are_coarser),
        CONTEXT_TEST(edges_change_little_by_little),
        CONTEXT_TEST(a_thing_hides_its_own_edges),
        CONTEXT_TEST(only_what_may_hide_edges_changes_them),
        CONTEXT_TEST(edges_that_no_place_tells_of_stay_as_they_are),
        CONTEXT_TEST(large_pictures_have_coarser_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
