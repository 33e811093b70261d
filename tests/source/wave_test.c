// SPDX-License-Identifier: Apache-2.0
#include "source/kinds.h"

#include <string.h>

#include "shared/wave.h"

static kind_world open_wave(clast_context *context)
{
    return kind_open(context, CLAST_SOURCE_WAVE);
}

// A view from which tiles have n segments: found by moving away.
static clast_source_view view_of_segments(const kind_world *world, uint32_t n)
{
    clast_source_view view = KIND_VIEW(0, 2, 0, 900, 1, 0);
    for (float height = 1.0f; height < 1e6f; height *= 1.02f) {
        view.eye.v[1] = height;
        if (world->source->count(world->unit, &kind_poses[0], &view, 0).triangles == 2 * n * n) {
            return view;
        }
    }
    fail_msg("no view gives %u segments", n);
    return view;
}

// Each vertex of the sheet by its place in the sheet's grid: those of several tiles must be the same bits.
static void check_borders(const kind_world *world, const clast_pose *pose, uint32_t n)
{
    clast_source_view view = view_of_segments(world, n);
    kind_emission all = kind_emit(world, pose, &view);
    uint32_t tiles = 3, side = tiles * n + 1, shared = 0;
    packed3 *grid = malloc((size_t)side * side * sizeof *grid);
    bool *known = calloc((size_t)side * side, sizeof *known);
    for (size_t i = 0; i < all.record_count; i++) {
        const packed3 *vertices = kind_vertices(world, &all, i);
        for (uint32_t v = 0; v < (n + 1) * (n + 1); v++) {
            uint32_t column = all.records[i].item % tiles * n + v % (n + 1);
            uint32_t row = all.records[i].item / tiles * n + v / (n + 1);
            size_t place = (size_t)row * side + column;
            if (known[place]) {
                assert_memory_equal(&grid[place], &vertices[v], sizeof *vertices);
                shared++;
            }
            known[place] = true;
            grid[place] = vertices[v];
        }
    }
    assert_int_equal(shared, tiles * tiles * (n + 1) * (n + 1) - side * side);
    free(grid);
    free(known);
    kind_emission_free(&all);
}

static void tiles_share_their_borders_to_the_bit(void **state)
{
    kind_world world = open_wave(*state);
    for (uint32_t n = 1; n <= GRID_SEGMENTS; n++) {
        for (uint32_t pose = 0; pose < KIND_POSES; pose++) {
            check_borders(&world, &kind_poses[pose], n);
        }
    }
    kind_close(&world);
}

static void the_sine_is_one(void **state)
{
    (void)state;
    for (int i = -100000; i <= 100000; i++) {
        float turns = (float)i * 1e-4f;
        assert_true(fabs((double)wave_sine(turns) - sin(6.283185307179586 * (double)turns)) < 1e-5);
    }
}

static void slopes_are_those_of_the_height(void **state)
{
    kind_world world = open_wave(*state);
    for (uint32_t i = 0; i < 50; i++) {
        vec2 place = vec2(0.1f + 0.015f * (float)i, 0.8f - 0.01f * (float)i);
        float step = 1e-3f;
        clast_surface_point here = {.primitive = 4, .coordinates = store2(place)}, right = here, up = here;
        right.coordinates = store2(place + vec2(step, 0.0f));
        up.coordinates = store2(place + vec2(0.0f, step));
        clast_source_surface surface = world.source->evaluate(world.unit, &kind_poses[1], here);
        vec3 along = world.source->evaluate(world.unit, &kind_poses[1], right).position - surface.position;
        vec3 across = world.source->evaluate(world.unit, &kind_poses[1], up).position - surface.position;
        vec3 normal = normalize3(surface.normal);
        assert_true(abs1(dot3(normal, normalize3(along))) < 2e-3f);
        assert_true(abs1(dot3(normal, normalize3(across))) < 2e-3f);
        assert_true(dot3(normalize3(surface.tangent), normalize3(along)) > 0.999f);
    }
    kind_close(&world);
}

static void the_place_of_a_point_does_not_depend_on_the_segments(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= GRID_SEGMENTS; n++) {
        // the tile's middle: on a diagonal, in the middle of a quad or at its corner
        uint32_t quad = n / 2 * n + n / 2;
        vec2 at = n % 2 == 1 ? vec2(0.0f, 0.5f) : vec2(0.0f, 0.0f);
        vec2 place = wave_locate(n, 2 * quad, at);
        assert_true(abs1(place[0] - 0.5f) < 1e-6f && abs1(place[1] - 0.5f) < 1e-6f);
        // the last triangle's last corners
        place = wave_locate(n, 2 * n * n - 1, vec2(1.0f, 0.0f));
        assert_true(abs1(place[0] - 1.0f) < 1e-6f && abs1(place[1] - 1.0f) < 1e-6f);
    }
}

static void hidden_sheets_are_coarser_and_near_ones_finer(void **state)
{
    kind_world world = open_wave(*state);
    clast_source_view view = view_of_segments(&world, 8);
    uint32_t seen = world.source->count(world.unit, &kind_poses[0], &view, 0).triangles;
    view.hidden = 1;
    uint32_t hidden = world.source->count(world.unit, &kind_poses[0], &view, 0).triangles;
    assert_true(hidden < seen && hidden >= 2);
    view = (clast_source_view)KIND_VIEW(1, 0, 1, 900, 1, 0);
    assert_int_equal(world.source->count(world.unit, &kind_poses[0], &view, 0).triangles,
                     2 * GRID_SEGMENTS * GRID_SEGMENTS);
    kind_close(&world);
}

static void a_sheet_repeats_after_whole_waves(void **state)
{
    kind_world world = open_wave(*state); // half a wavelength a second; the second wave has 5/4 of its turns
    clast_pose late = {.time = 8.0e6};
    assert_int_equal(world.source->changed(world.unit, &kind_poses[0], &kind_views[0], &late, &kind_views[0]),
                     CLAST_CHANGE_NOTHING);
    clast_pose later = {.time = 8.0e6 + 0.125};
    assert_int_equal(world.source->changed(world.unit, &late, &kind_views[0], &later, &kind_views[0]),
                     CLAST_CHANGE_VERTICES);
    kind_close(&world);
}

static void more_waves_than_single_precision_tells_apart_are_refused(void **state)
{
    clast_context *context = *state;
    kind_world world = open_wave(context);
    clast_geometry geometry = world.scene->geometries[0];
    geometry.of.wave.wavelength = 1e-30f;
    clast_unit *unit = NULL;
    clast_cook_job job = {.context = context,
                          .scene = world.scene,
                          .geometry = &geometry,
                          .templates = world.templates,
                          .heights = world.heights};
    assert_int_equal(world.source->cook(&job, &unit), CLAST_ERROR_LIMIT);
    assert_null(unit);
    kind_close(&world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(tiles_share_their_borders_to_the_bit),
        cmocka_unit_test(the_sine_is_one),
        CONTEXT_TEST(slopes_are_those_of_the_height),
        cmocka_unit_test(the_place_of_a_point_does_not_depend_on_the_segments),
        CONTEXT_TEST(hidden_sheets_are_coarser_and_near_ones_finer),
        CONTEXT_TEST(a_sheet_repeats_after_whole_waves),
        CONTEXT_TEST(more_waves_than_single_precision_tells_apart_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
