// SPDX-License-Identifier: Apache-2.0
// Tone maps against what their makers publish of them.
#include "test.h"

#include <math.h>

#include "clast/render.h"
#include "shared/tone_map.h"

#define assert_near(value, expected, tolerance) \
    do { \
        double value_ = (double)(value), expected_ = (double)(expected); \
        if (!(fabs(value_ - expected_) <= (double)(tolerance))) { \
            fail_msg("%s is %g, not %g", #value, value_, expected_); \
        } \
    } while (0)

// IEC 61966-2-1
static double srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

static double linear_of(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

static double grey_of(float grey, clast_tone_map curve)
{
    vec3 shown = tone_map(splat3(grey), 1.0f, curve);
    assert_near(shown[1], shown[0], 0.002); // greys stay grey
    assert_near(shown[2], shown[0], 0.002);
    return linear_of((double)shown[0]);
}

static void none_is_the_encoding_alone(void **state)
{
    (void)state;
    const float values[] = {0.0f, 0.001f, 0.0031308f, 0.18f, 0.5f, 1.0f};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        vec3 shown = tone_map(vec3(values[i], 0.0f, 4.0f), 1.0f, CLAST_TONE_MAP_NONE);
        assert_near(shown[0], srgb((double)values[i]), 2e-4);
        assert_near(shown[1], 0.0, 0.0);
        assert_near(shown[2], 1.0, 1e-6);
    }
    assert_near(tone_map(splat3(0.25f), 2.0f, CLAST_TONE_MAP_NONE)[0], srgb(0.5), 2e-4); // the gain comes before
}

// Khronos PBR Neutral Tone Mapper, 2024: f90 = 0.04 is taken off, compression begins at 0.8 - f90, and up to there colours come
// through; below 0.08 the offset is x - 6.25 x x.
static void neutral_leaves_base_colours(void **state)
{
    (void)state;
    assert_near(grey_of(0.5f, CLAST_TONE_MAP_NEUTRAL), 0.46, 1e-3);
    assert_near(grey_of(0.79f, CLAST_TONE_MAP_NEUTRAL), 0.75, 1e-3);
    assert_near(grey_of(0.04f, CLAST_TONE_MAP_NEUTRAL), 6.25 * 0.04 * 0.04, 1e-3);
    assert_near(grey_of(1.0f, CLAST_TONE_MAP_NEUTRAL), 1.0 - 0.24 * 0.24 / (0.96 + 0.24 - 0.76), 1e-3);
    assert_near(grey_of(100.0f, CLAST_TONE_MAP_NEUTRAL), 1.0, 2e-3);
    vec3 shown = tone_map(vec3(0.7f, 0.3f, 0.1f), 1.0f, CLAST_TONE_MAP_NEUTRAL); // hues stay
    assert_near(linear_of((double)shown[0]), 0.66, 1e-3);
    assert_near(linear_of((double)shown[1]), 0.26, 1e-3);
    assert_near(linear_of((double)shown[2]), 0.06, 1e-3);
    shown = tone_map(vec3(30.0f, 1.0f, 1.0f), 1.0f, CLAST_TONE_MAP_NEUTRAL); // what is far too bright pales
    assert_true(linear_of((double)shown[1]) > 0.7);
}

// The Academy's transform shows a mid grey of 0.18 at a tenth of the display's white; clast's gain before it makes it 0.18.
static void aces_is_the_academys_curve(void **state)
{
    (void)state;
    assert_near(grey_of(0.18f / 1.462f, CLAST_TONE_MAP_ACES), 0.10, 0.01);
    assert_near(grey_of(0.18f, CLAST_TONE_MAP_ACES), 0.18, 0.003);
    assert_near(grey_of(0.0f, CLAST_TONE_MAP_ACES), 0.0, 1e-6);
    assert_true(grey_of(16.29f / 1.462f, CLAST_TONE_MAP_ACES) > 0.95); // its white is 6.5 stops above grey
    vec3 shown = tone_map(vec3(30.0f, 0.0f, 0.0f), 1.0f, CLAST_TONE_MAP_ACES);
    assert_true(shown[1] > 0.3f); // pure light that is far too bright pales
}

// AgX covers 10 stops below mid grey and 6.5 above; grey is shown at half of a display of power 2.2.
static void agx_shows_sixteen_stops(void **state)
{
    (void)state;
    assert_near(pow(grey_of(0.18f, CLAST_TONE_MAP_AGX), 1.0 / 2.2), 0.5, 0.01);
    assert_near(grey_of(0.18f * exp2f(-10.0f), CLAST_TONE_MAP_AGX), 0.0, 1e-3);
    assert_near(grey_of(0.18f * exp2f(6.5f), CLAST_TONE_MAP_AGX), 1.0, 0.01);
    double before = -1.0;
    for (float stop = -9.0f; stop <= 6.0f; stop += 0.5f) {
        double shown = grey_of(0.18f * exp2f(stop), CLAST_TONE_MAP_AGX);
        assert_true(shown > before);
        before = shown;
    }
    vec3 shown = tone_map(vec3(0.0f, 0.0f, 40.0f), 1.0f, CLAST_TONE_MAP_AGX);
    assert_true(shown[0] > 0.5f && shown[1] > 0.5f);
}

static void pictures_go_through_the_curve_that_is_set(void **state)
{
    const float grey[3] = {0.25f, 0.25f, 0.25f};
    const double expected[] = {[CLAST_TONE_MAP_NONE] = srgb(0.5), [CLAST_TONE_MAP_NEUTRAL] = srgb(0.46)};
    const clast_tone_map curves[] = {CLAST_TONE_MAP_NONE, CLAST_TONE_MAP_NEUTRAL};
    for (int i = 0; i < 2; i++) {
        clast_render_settings settings = {.tonemap = curves[i], .exposure = 1.0};
        uint8_t shown[3];
        uint16_t fine[3];
        assert_ok(*state, clast_view_to_display(*state, CLAST_VIEW_COLOUR, grey, 1, 1, &settings, shown));
        assert_ok(*state, clast_view_to_display_16(*state, CLAST_VIEW_COLOUR, grey, 1, 1, &settings, fine));
        assert_near(shown[1], 255.0 * expected[curves[i]], 1.0);
        assert_near(fine[1], 65535.0 * expected[curves[i]], 30.0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(none_is_the_encoding_alone),
        cmocka_unit_test(neutral_leaves_base_colours),
        cmocka_unit_test(aces_is_the_academys_curve),
        cmocka_unit_test(agx_shows_sixteen_stops),
        CONTEXT_TEST(pictures_go_through_the_curve_that_is_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
