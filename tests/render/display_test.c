// SPDX-License-Identifier: Apache-2.0
// Views as pictures to look at: what can be read off their colours.
#include "test.h"

#include <math.h>

#include "clast/render.h"

typedef struct colour {
    int r, g, b;
} colour;

enum { MOST = 16 };

static void show(clast_context *context, clast_view view, const void *values, uint32_t count, colour shown[MOST])
{
    uint8_t bytes[3 * MOST];
    clast_render_settings settings = {.metric = CLAST_METRIC_PIXELS, .segment = 2.0};
    assert_ok(context, clast_view_to_display(context, view, values, count, 1, &settings, bytes));
    for (uint32_t i = 0; i < count; i++) {
        shown[i] = (colour){bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]};
    }
}

static int sum(colour c)
{
    return c.r + c.g + c.b;
}

static bool is_grey(colour c)
{
    return abs(c.r - c.g) <= 2 && abs(c.g - c.b) <= 2;
}

static int distance(colour a, colour b)
{
    return abs(a.r - b.r) + abs(a.g - b.g) + abs(a.b - b.b);
}

static void albedo_is_as_a_screen_shows_it(void **state)
{
    const float values[] = {0.5f, 0.0f, 1.0f};
    colour shown[MOST];
    show(*state, CLAST_VIEW_ALBEDO, values, 1, shown);
    assert_true(shown[0].r == 188 && shown[0].g == 0 && shown[0].b == 255); // sRGB of a half
}

static void normals_are_axes_as_colours(void **state)
{
    const float values[] = {0, 0, 1, 1, 0, 0, 0, -1, 0, 0, 0, 0};
    colour shown[MOST];
    show(*state, CLAST_VIEW_NORMAL, values, 4, shown);
    assert_true(abs(shown[0].r - 128) <= 1 && abs(shown[0].g - 128) <= 1 && shown[0].b == 255);
    assert_true(shown[1].r == 255 && abs(shown[1].b - 128) <= 1);
    assert_true(shown[2].g == 0);
    assert_int_equal(sum(shown[3]), 0); // nothing is there
}

static void near_is_bright_and_nothing_is_black(void **state)
{
    const float values[] = {1.0f, 10.0f, 100.0f, INFINITY};
    colour shown[MOST];
    show(*state, CLAST_VIEW_DEPTH, values, 4, shown);
    assert_true(is_grey(shown[0]) && is_grey(shown[1]) && is_grey(shown[2]));
    assert_true(shown[0].r == 255 && shown[2].r > 10);
    assert_true(abs(2 * shown[1].r - shown[0].r - shown[2].r) <= 2); // as many times as far, as much darker
    assert_int_equal(sum(shown[3]), 0);
}

static void texture_coordinates_are_red_and_green_and_repeat(void **state)
{
    const float values[] = {0.25f, 0.75f, 3.25f, -0.25f};
    colour shown[MOST];
    show(*state, CLAST_VIEW_UV, values, 2, shown);
    assert_true(abs(shown[0].r - 64) <= 1 && abs(shown[0].g - 191) <= 1 && shown[0].b == 0);
    assert_int_equal(distance(shown[0], shown[1]), 0);
}

// Grey where all is as it should be, blue for less, red for more.
static void rates_and_areas_show_balance(void **state)
{
    const float rates[] = {1.0f, 0.25f, 4.0f, 0.125f};
    const float wanted = 0.4330127f * 4.0f, areas[] = {wanted, 0.25f * wanted, 4.0f * wanted, 0.0f};
    for (int i = 0; i < 2; i++) {
        colour shown[MOST];
        show(*state, i == 0 ? CLAST_VIEW_RATE : CLAST_VIEW_AREA, i == 0 ? rates : areas, 4, shown);
        assert_true(is_grey(shown[0]) && shown[0].r > 200);
        assert_true(shown[1].b > shown[1].r + 50);
        assert_true(shown[2].r > shown[2].b + 50);
    }
}

static void segments_go_up_the_rainbow(void **state)
{
    const float values[] = {1.0f, 16.0f, 256.0f, 15.0f, 0.0f};
    colour shown[MOST];
    show(*state, CLAST_VIEW_SEGMENTS, values, 5, shown);
    assert_true(shown[0].b > shown[0].r && shown[0].b > shown[0].g);
    assert_true(shown[1].g > shown[1].r && shown[1].g > shown[1].b);
    assert_true(shown[2].r > shown[2].g && shown[2].r > shown[2].b);
    assert_true(distance(shown[1], shown[3]) > 20); // neighbouring counts are told apart
    assert_int_equal(sum(shown[4]), 0);
}

static void steps_and_samples_go_from_blue_to_red(void **state)
{
    const uint32_t steps[] = {1, 500, 1000, CLAST_NONE}, samples[] = {32, 181, 1024, 0};
    for (int i = 0; i < 2; i++) {
        colour shown[MOST];
        show(*state, i == 0 ? CLAST_VIEW_STEPS : CLAST_VIEW_SAMPLES, i == 0 ? steps : samples, 4, shown);
        assert_true(shown[0].b > shown[0].r && shown[0].b > shown[0].g);
        assert_true(shown[1].g > shown[1].b);
        assert_true(shown[2].r > shown[2].g && shown[2].r > shown[2].b);
        assert_int_equal(sum(shown[3]), 0);
    }
    const uint32_t alike[] = {16, 16};
    colour shown[MOST];
    show(*state, CLAST_VIEW_SAMPLES, alike, 2, shown);
    assert_true(sum(shown[0]) > 200 && distance(shown[0], shown[1]) == 0);
}

// Numbers of things side by side differ by a few, or by one.
static void numbers_are_told_apart(void **state)
{
    const clast_view views[] = {CLAST_VIEW_INSTANCE, CLAST_VIEW_CLUSTER, CLAST_VIEW_TRIANGLE, CLAST_VIEW_PRIMITIVE};
    const uint32_t values[] = {0, 1, 2, 3, 7, 8, 128, 129, 1000000, 1000001, CLAST_NONE};
    for (size_t v = 0; v < sizeof views / sizeof *views; v++) {
        colour shown[MOST];
        show(*state, views[v], values, 11, shown);
        for (int i = 0; i < 10; i++) {
            assert_true(sum(shown[i]) > 150);
            assert_true(i == 0 || distance(shown[i], shown[i - 1]) > 60);
        }
        assert_int_equal(sum(shown[10]), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(albedo_is_as_a_screen_shows_it),
        CONTEXT_TEST(normals_are_axes_as_colours),
        CONTEXT_TEST(near_is_bright_and_nothing_is_black),
        CONTEXT_TEST(texture_coordinates_are_red_and_green_and_repeat),
        CONTEXT_TEST(rates_and_areas_show_balance),
        CONTEXT_TEST(segments_go_up_the_rainbow),
        CONTEXT_TEST(steps_and_samples_go_from_blue_to_red),
        CONTEXT_TEST(numbers_are_told_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
