// SPDX-License-Identifier: Apache-2.0
// Views of how geometry is cut.
#include "picture.h"

enum { SIZE = 60 };
static const clast_view cut_views[] = {CLAST_VIEW_PRIMITIVE, CLAST_VIEW_SEGMENTS, CLAST_VIEW_RATE,
                                       CLAST_VIEW_AREA,      CLAST_VIEW_INSTANCE, CLAST_VIEW_CLUSTER};
enum { CUT_VIEWS = sizeof cut_views / sizeof cut_views[0] };

// A waving sheet of 4 x 4 tiles from above, as large as the picture.
static picture sheet_from_above(clast_context *context)
{
    picture p = picture_open(context, SIZE, 2);
    picture_surround(&p, 1.0f);
    shape_add_instance(context, p.scene, shape_add_wave(context, p.scene, 4), 0, 0, 0, 1);
    picture_look(&p, vec3(0.01f, 10.0f, 0.0f), vec3(0, 0, 0), 0.9f);
    return p;
}

static void the_sheet_tells_tiles_and_segments(void **state)
{
    picture p = sheet_from_above(*state);
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, cut_views, CUT_VIEWS));
    const uint32_t *tiles = p.pixels[CLAST_VIEW_PRIMITIVE], *clusters = p.pixels[CLAST_VIEW_CLUSTER];
    const float *segments = p.pixels[CLAST_VIEW_SEGMENTS], *rates = p.pixels[CLAST_VIEW_RATE];
    float n = (float)p.frame->units[0].records[0].detail;
    assert_true(n > 1.0f);
    bool seen[16] = {false};
    for (int i = 0; i < SIZE * SIZE; i++) {
        assert_true(tiles[i] < 16 && tiles[i] == clusters[i]); // a record for each tile, in their order
        assert_true(segments[i] == n && rates[i] == 1.0f);
        seen[tiles[i]] = true;
    }
    for (int i = 0; i < 16; i++) {
        assert_true(seen[i]);
    }
    picture_close(&p);
}

static void a_budget_shows_in_the_rate(void **state)
{
    picture p = sheet_from_above(*state);
    picture_build(&p);
    float wanted = (float)p.frame->units[0].records[0].detail;
    p.frame->settings.max_triangles = 16 * 2;
    assert_ok(p.context, clast_frame_run(p.frame, &clast_cpu_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    assert_ok(p.context, picture_try(&p, cut_views, CUT_VIEWS));
    const float *segments = p.pixels[CLAST_VIEW_SEGMENTS], *rates = p.pixels[CLAST_VIEW_RATE];
    assert_true(segments[SIZE] == 1.0f);
    assert_near(rates[SIZE], 1.0 / (double)wanted, 1e-6);
    picture_close(&p);
}

static void areas_are_in_pixels(void **state)
{
    picture p = picture_open(*state, SIZE, 1);
    picture_surround(&p, 1.0f);
    picture_add_square(&p, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0), picture_material(&p, 0.5f, 0, 0.5f, 0));
    picture_look(&p, vec3(0, 0, 4), vec3(0, 0, 0), 2.0f * atanf(0.5f)); // sees 2 up and down at the square
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, cut_views, CUT_VIEWS));
    const float *areas = p.pixels[CLAST_VIEW_AREA];
    const uint32_t *instances = p.pixels[CLAST_VIEW_INSTANCE], *primitives = p.pixels[CLAST_VIEW_PRIMITIVE];
    uint32_t covered = 0;
    for (int i = 0; i < SIZE * SIZE; i++) {
        if (instances[i] != CLAST_NONE) {
            assert_near(areas[i], SIZE * SIZE / 8, 0.01); // half a square that has half the picture's side
            assert_true(primitives[i] < 2);
            covered++;
        } else {
            assert_true(areas[i] == 0.0f && primitives[i] == CLAST_NONE);
        }
    }
    assert_int_equal(covered, SIZE * SIZE / 4);
    const float *segments = p.pixels[CLAST_VIEW_SEGMENTS], *rates = p.pixels[CLAST_VIEW_RATE];
    assert_true(segments[SIZE * SIZE / 2 + SIZE / 2] == 0.0f && rates[SIZE * SIZE / 2 + SIZE / 2] == 1.0f);
    picture_close(&p);
}

static void every_view_becomes_a_picture(void **state)
{
    picture p = sheet_from_above(*state);
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, cut_views, CUT_VIEWS));
    uint8_t *pixels = malloc(3 * SIZE * SIZE);
    for (int i = 0; i < CUT_VIEWS; i++) {
        assert_ok(p.context,
                  clast_view_to_display(p.context, cut_views[i], p.pixels[cut_views[i]], SIZE, SIZE, NULL, pixels));
        const uint8_t *middle = pixels + 3 * (SIZE * SIZE / 2 + SIZE / 2);
        assert_true(middle[0] + middle[1] + middle[2] > 100); // not black
    }
    free(pixels);
    picture_close(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(the_sheet_tells_tiles_and_segments),
        CONTEXT_TEST(a_budget_shows_in_the_rate),
        CONTEXT_TEST(areas_are_in_pixels),
        CONTEXT_TEST(every_view_becomes_a_picture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
