// SPDX-License-Identifier: Apache-2.0
// What ends a render, and what of a picture is rendered: crops, limits of time, noise targets.
#include "picture.h"

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1}, ORIGIN = {0, 0, 0};
static const clast_view colour = CLAST_VIEW_COLOUR;

#define LAYOUT(name, value, text, channels, is_float, help) [name] = channels,
static const uint32_t channels[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(LAYOUT)};

// A lamp over a floor with a ball, before nothing: noisy here, and dark and still there.
static picture lamp_scene(clast_context *context, uint32_t size, uint32_t samples)
{
    picture p = picture_open(context, size, samples);
    picture_surround(&p, 0.0f);
    picture_add_square(&p, Y * -1.0f, Z * 2.0f, X * 2.0f, picture_material(&p, 0.6f, 0.0f, 0.8f, 0.0f));
    picture_add_sphere(&p, ORIGIN, 0.7f, 32, picture_material(&p, 0.7f, 0.0f, 0.3f, 0.0f));
    picture_add_square(&p, vec3(0.5f, 2, 0), Z * -0.4f, X * 0.4f, picture_material(&p, 0.0f, 0.0f, 1.0f, 8.0f));
    picture_look(&p, vec3(0, 2, 7), vec3(0, 1, 0), 0.8f);
    return p;
}

// ---------------------------------------------------------------------------------------------------------------- crop

// Steps of the primary rays are those of rays that go together, which are others.
static const clast_view cropped_views[] = {CLAST_VIEW_COLOUR,   CLAST_VIEW_ALBEDO,   CLAST_VIEW_NORMAL,
                                           CLAST_VIEW_DEPTH,    CLAST_VIEW_UV,       CLAST_VIEW_INSTANCE,
                                           CLAST_VIEW_CLUSTER,  CLAST_VIEW_TRIANGLE, CLAST_VIEW_PRIMITIVE,
                                           CLAST_VIEW_SEGMENTS, CLAST_VIEW_AREA,     CLAST_VIEW_SAMPLES};
enum { CROPPED = sizeof cropped_views / sizeof *cropped_views };

static void check_crop(picture *p, void *const whole[CLAST_VIEW_COUNT_], uint32_t x, uint32_t y, uint32_t width,
                       uint32_t height)
{
    char text[64];
    snprintf(text, sizeof text, "%u,%u,%u,%u", x, y, width, height);
    p->settings.crop = text;
    assert_ok(p->context, picture_try(p, cropped_views, CROPPED));
    assert_int_equal(p->statistics.primary_rays, (uint64_t)p->settings.spp * width * height);
    for (int i = 0; i < CROPPED; i++) {
        clast_view view = cropped_views[i];
        size_t pixel = channels[view] * sizeof(float);
        for (uint32_t row = 0; row < height; row++) {
            const char *from = (const char *)whole[view] + ((y + row) * (size_t)p->settings.width + x) * pixel;
            assert_memory_equal((const char *)p->pixels[view] + row * width * pixel, from, width * pixel);
        }
    }
}

static void a_crop_has_the_bits_of_the_whole_picture(void **state)
{
    picture p = lamp_scene(*state, 45, 3);
    void *whole[CLAST_VIEW_COUNT_];
    picture_build(&p);
    assert_ok(p.context, picture_try(&p, cropped_views, CROPPED));
    memcpy(whole, p.pixels, sizeof whole);
    memset(p.pixels, 0, sizeof p.pixels);
    check_crop(&p, whole, 13, 5, 22, 31);
    check_crop(&p, whole, 16, 24, 8, 8);
    check_crop(&p, whole, 44, 44, 1, 1);
    check_crop(&p, whole, 0, 20, 45, 3);
    check_crop(&p, whole, 0, 0, 45, 45);
    for (int i = 0; i < CLAST_VIEW_COUNT_; i++) {
        free(i < CROPPED ? whole[cropped_views[i]] : NULL);
    }
    picture_close(&p);
}

static void a_crop_outside_of_the_picture_is_refused(void **state)
{
    const char *const wrong[] = {"0,0,46,45",
                                 "0,0,45,46",
                                 "45,0,1,1",
                                 "0,45,1,1",
                                 "0,0,0,1",
                                 "0,0,1,0",
                                 "1,1,1",
                                 "1,1,1,1,1",
                                 "1,1,1,1 ",
                                 "-1,0,1,1",
                                 "a",
                                 "1,1,1,",
                                 "1.0,1,1,1",
                                 "4294967296,0,1,1",
                                 "40,0,4294967290,1",
                                 ",,,",
                                 "0,0,1,99999999999999999999"};
    picture p = lamp_scene(*state, 45, 1);
    picture_build(&p);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        p.settings.crop = wrong[i];
        assert_int_equal(picture_try(&p, &colour, 1), CLAST_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(clast_context_error(p.context), "45 x 45"));
    }
    picture_close(&p);
}

// ---------------------------------------------------------------------------------------------------------------- time

static void a_picture_has_a_sample_however_short_the_time(void **state)
{
    picture p = lamp_scene(*state, 16, 16);
    picture_render(&p);
    double mean = picture_mean(&p);
    p.settings.spp = 64;
    p.settings.time_limit = 1e-9;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    assert_int_equal(p.statistics.samples, 1);
    assert_near(picture_mean(&p), mean, 0.2 * mean);
    p.settings.spp = 3;
    p.settings.time_limit = 1e9;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    assert_int_equal(p.statistics.samples, 3);
    picture_close(&p);
}

// --------------------------------------------------------------------------------------------------------------- noise

enum { SIZE = 40, PIXELS = SIZE * SIZE };

static void set_noise(picture *p, double target)
{
    p->settings.spp = 4096;
    p->settings.min_spp = 32;
    p->settings.noise_target = target;
}

static void noise_decides_how_many_samples_pixels_get(void **state)
{
    const clast_view views[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_SAMPLES};
    picture p = lamp_scene(*state, SIZE, 1);
    picture_build(&p);
    double before = 0.0;
    for (int i = 0; i < 2; i++) {
        set_noise(&p, 0.005 / (1 << i));
        assert_ok(p.context, picture_try(&p, views, 2));
        const uint32_t *samples = p.pixels[CLAST_VIEW_SAMPLES];
        double sum = 0.0;
        uint32_t most = 0;
        for (uint32_t k = 0; k < PIXELS; k++) {
            assert_int_equal(samples[k] % ROUND_SAMPLES, 0);
            assert_int_equal(samples[k],
                             samples[k / SIZE / 8 * 8 * SIZE + k % SIZE / 8 * 8]); // as the rest of its square
            sum += samples[k];
            most = max_uint(most, samples[k]);
        }
        assert_int_equal(samples[0], 32); // nothing is there
        assert_int_equal(most, p.statistics.samples);
        assert_near(sum / PIXELS, p.statistics.mean_samples, 1e-9 * sum);
        assert_int_equal((uint64_t)sum, p.statistics.primary_rays);
        assert_int_equal(p.statistics.pixels_above_target, 0);
        assert_true(p.statistics.mean_samples > (i == 0 ? 32.0 : 1.5 * before));
        before = p.statistics.mean_samples;
    }
    assert_true(p.statistics.mean_samples < 0.7 * p.statistics.samples); // what most pixels were spared
    picture_close(&p);
}

// The noise that is asked for is the noise that there is, as an eye sees it: of square roots.
static void noise_is_as_much_as_was_asked_for(void **state)
{
    const double target = 0.004;
    picture p = lamp_scene(*state, SIZE, 2048);
    picture_build(&p);
    p.settings.seed = 7;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    float *truth = p.pixels[colour];
    p.pixels[colour] = NULL;
    p.settings.seed = 0;
    set_noise(&p, target);
    assert_ok(p.context, picture_try(&p, &colour, 1));
    const float *found = p.pixels[colour];
    double noise = 0.0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        const float *a = found + 3 * i, *b = truth + 3 * i; // all is grey
        noise += fabs(sqrt((double)a[0]) - sqrt((double)b[0])) / PIXELS;
    }
    assert_true(noise < target && noise > 0.15 * target);
    free(truth);
    picture_close(&p);
}

// Squares end when they look clean, which must not favour those that are clean by luck: over many seeds the mean is that of
// renders where all pixels get as many samples.
static void noise_targets_do_not_change_the_mean(void **state)
{
    enum { SEEDS = 12 };
    picture p = lamp_scene(*state, SIZE, 2048);
    picture_build(&p);
    p.settings.seed = 1000;
    assert_ok(p.context, picture_try(&p, &colour, 1));
    double truth = picture_mean(&p), sum = 0.0, square = 0.0;
    set_noise(&p, 0.004);
    for (uint32_t seed = 0; seed < SEEDS; seed++) {
        p.settings.seed = seed;
        assert_ok(p.context, picture_try(&p, &colour, 1));
        double mean = picture_mean(&p);
        sum += mean;
        square += mean * mean;
    }
    double mean = sum / SEEDS, error = sqrt((square / SEEDS - mean * mean) / (SEEDS - 1));
    assert_near(mean, truth, 3.0 * error + 5e-4 * truth);
    picture_close(&p);
}

static void noise_does_not_depend_on_threads(void **state)
{
    (void)state;
    const clast_view views[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_SAMPLES};
    float *colours[2] = {NULL, NULL};
    for (uint32_t i = 0; i < 2; i++) {
        clast_context *context;
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1 + 4 * i}, &context), CLAST_OK);
        picture p = lamp_scene(context, SIZE, 1);
        picture_build(&p);
        set_noise(&p, 0.004);
        assert_ok(context, picture_try(&p, views, 2));
        colours[i] = p.pixels[CLAST_VIEW_COLOUR];
        p.pixels[CLAST_VIEW_COLOUR] = NULL;
        picture_close(&p);
        clast_context_destroy(context);
    }
    assert_memory_equal(colours[0], colours[1], PIXELS * 12);
    free(colours[0]);
    free(colours[1]);
}

// Where nobody asks for colour, noise is measured of it all the same; where samples run out before, the statistics say so.
static void noise_is_that_of_colour_whatever_is_shown(void **state)
{
    const clast_view samples = CLAST_VIEW_SAMPLES;
    picture p = lamp_scene(*state, SIZE, 1);
    picture_build(&p);
    set_noise(&p, 0.004);
    assert_ok(p.context, picture_try(&p, &colour, 1));
    double mean = p.statistics.mean_samples;
    assert_ok(p.context, picture_try(&p, &samples, 1));
    assert_near(p.statistics.mean_samples, mean, 0.0);
    p.settings.spp = 40;
    assert_ok(p.context, picture_try(&p, &samples, 1));
    assert_int_equal(p.statistics.samples, 40);
    assert_true(p.statistics.pixels_above_target > 0 && p.statistics.pixels_above_target < PIXELS);
    picture_close(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_crop_has_the_bits_of_the_whole_picture),
        CONTEXT_TEST(a_crop_outside_of_the_picture_is_refused),
        CONTEXT_TEST(a_picture_has_a_sample_however_short_the_time),
        CONTEXT_TEST(noise_decides_how_many_samples_pixels_get),
        CONTEXT_TEST(noise_is_as_much_as_was_asked_for),
        CONTEXT_TEST(noise_targets_do_not_change_the_mean),
        cmocka_unit_test(noise_does_not_depend_on_threads),
        CONTEXT_TEST(noise_is_that_of_colour_whatever_is_shown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
