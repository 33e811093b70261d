// SPDX-License-Identifier: Apache-2.0
#include "picture.h"

#include "render/lights.h"
#include "shared/tone_map.h"

static const double TAU = 6.28318530717959;

static void sums_are_chosen_from_by_weight(void **state)
{
    (void)state;
    float sums[] = {0.0f, 1.0f, 0.0f, 3.0f};
    assert_near(clast_sums_make(sums, 3), 4.0, 0.0);
    float rest;
    assert_int_equal(clast_sums_find(sums, 3, 0.0f, &rest), 0);
    assert_int_equal(clast_sums_find(sums, 3, 0.249f, &rest), 0);
    assert_int_equal(clast_sums_find(sums, 3, 0.25f, &rest), 2);
    assert_near(rest, 0.0, 0.0);
    assert_int_equal(clast_sums_find(sums, 3, 0.99999994f, &rest), 2);
    assert_true(rest <= 1.0f);
}

static void no_weight_at_all_is_an_even_choice(void **state)
{
    (void)state;
    float sums[] = {0.0f, 0.0f, 0.0f}, rest;
    assert_near(clast_sums_make(sums, 2), 0.0, 0.0);
    assert_int_equal(clast_sums_find(sums, 2, 0.6f, &rest), 1);
}

static void places_and_directions_are_inverse(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        vec2 u = sample_square(i, 3);
        vec2 place = vec2(u[0], 0.001f + 0.998f * u[1]);
        vec2 back = surroundings_place(surroundings_direction(place, 0.7f), 0.7f);
        assert_near(back[0], place[0], 2e-4);
        assert_near(back[1], place[1], 1e-5);
    }
    // The middle of the picture is +x, turned towards -z by the rotation.
    vec3 middle = surroundings_direction(vec2(0.5f, 0.5f), 1.57079633f);
    assert_near(middle[2], -1.0, 1e-6);
    vec3 right = surroundings_direction(vec2(0.75f, 0.5f), 0.0f);
    assert_near(right[2], 1.0, 1e-6);
}

// A picture of one bright texel and a gradient.
static picture image_scene(clast_context *context, uint32_t width, uint32_t height)
{
    picture p = picture_open(context, 4, 1);
    float *pixels = malloc(sizeof(float) * 3 * width * height);
    for (uint32_t i = 0; i < 3 * width * height; i++) {
        pixels[i] = 0.1f + (float)(i / 3 % width) / (float)width;
    }
    for (int c = 0; c < 3; c++) {
        pixels[3 * (width * (height / 3) + width / 5) + (uint32_t)c] = 500.0f;
    }
    clast_image image = {width, height, 3, CLAST_PIXEL_FLOAT, pixels};
    uint32_t number;
    assert_ok(context, clast_scene_add_image(p.scene, &image, NULL, &number));
    free(pixels);
    clast_environment environment = {.type = CLAST_ENVIRONMENT_IMAGE, .image = number, .rotation = 0.4f};
    assert_ok(context, clast_scene_set_environment(p.scene, &environment));
    picture_build(&p);
    return p;
}

static void check_sampling(const clast_lights *lights, double tolerance)
{
    enum { SAMPLES = 1 << 16, ROWS = 512, COLUMNS = 1024 };
    const clast_surroundings *cells = &lights->surroundings;
    double by_samples = 0.0, density_sum = 0.0, by_grid = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        float density;
        vec3 direction = clast_surroundings_sample(cells, sample_square(i, 1), &density);
        assert_near(length3(direction), 1.0, 1e-5);
        by_samples += (double)(luminance(clast_surroundings_radiance(lights, direction)) / density) / SAMPLES;
    }
    for (uint32_t i = 0; i < ROWS * COLUMNS; i++) {
        vec2 place = vec2(((float)(i % COLUMNS) + 0.5f) / COLUMNS, ((float)(i / COLUMNS) + 0.5f) / ROWS);
        vec3 direction = surroundings_direction(place, 0.0f);
        double solid = TAU / COLUMNS * TAU / 2.0 / ROWS * sin(TAU / 2.0 * (double)place[1]);
        density_sum += (double)clast_surroundings_density(cells, direction) * solid;
        by_grid += (double)luminance(clast_surroundings_radiance(lights, direction)) * solid;
    }
    assert_near(density_sum, 1.0, 0.01);
    assert_near(by_samples / by_grid, 1.0, tolerance);
}

static void an_image_is_sampled_by_its_brightness(void **state)
{
    picture p = image_scene(*state, 64, 32);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    clast_lights *lights;
    assert_ok(p.context, clast_lights_create(p.frame, &table, &lights));
    check_sampling(lights, 0.02);
    // The bright texel gets its share.
    vec3 bright = surroundings_direction(vec2((12 + 0.5f) / 64.0f, (10 + 0.5f) / 32.0f), 0.4f);
    assert_true(clast_surroundings_density(&lights->surroundings, bright) > 20.0f);
    clast_lights_destroy(p.context, lights);
    picture_close(&p);
}

static void a_picture_of_one_pixel_will_do(void **state)
{
    picture p = image_scene(*state, 1, 1);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    clast_lights *lights;
    assert_ok(p.context, clast_lights_create(p.frame, &table, &lights));
    check_sampling(lights, 0.01);
    clast_lights_destroy(p.context, lights);
    picture_close(&p);
}

static void sky_at(clast_context *context, picture *p, float elevation, float turbidity)
{
    *p = picture_open(context, 4, 1);
    clast_environment environment = {
        .type = CLAST_ENVIRONMENT_SKY,
        .turbidity = turbidity,
        .sun_direction = {0.6f * cosf(elevation), sinf(elevation), 0.8f * cosf(elevation)}};
    assert_ok(context, clast_scene_set_environment(p->scene, &environment));
    picture_build(p);
}

static void the_sky_and_its_sun_are_sampled_rightly(void **state)
{
    picture p;
    sky_at(*state, &p, 0.3f, 3.0f);
    clast_srgb_table table;
    clast_srgb_table_fill(&table);
    clast_lights *lights;
    assert_ok(p.context, clast_lights_create(p.frame, &table, &lights));
    check_sampling(lights, 0.02);
    clast_light_shares shares = {.sun = 1.0f};
    double irradiance = 0.0;
    for (uint32_t i = 0; i < 4096; i++) {
        clast_light_sample sun = clast_lights_sample_sun(lights, &shares, sample_square(i, 2));
        irradiance += (double)(sun.radiance.v[1] / sun.density) / 4096.0;
    }
    assert_near(irradiance / (double)lights->sun_irradiance[1], 1.0, 0.02);
    clast_lights_destroy(p.context, lights);
    picture_close(&p);
}

static void the_sky_is_blue_above_and_the_low_sun_red(void **state)
{
    clast_sky high, low, gone;
    clast_context *context = *state;
    assert_ok(context, clast_sky_create(context, vec3(0.6f, 0.8f, 0.0f), 2.5f, &high));
    assert_ok(context, clast_sky_create(context, vec3(0.99619f, 0.08716f, 0.0f), 2.5f, &low));
    assert_ok(context, clast_sky_create(context, vec3(0.98481f, -0.17365f, 0.0f), 2.5f, &gone));
    const float *zenith = high.radiance[CLAST_SKY_WIDTH / 4].v;
    assert_true(zenith[2] > 1.5f * zenith[0] && zenith[0] > 0.01f);
    assert_true(high.sun_irradiance[0] < 1.5f * high.sun_irradiance[2] && high.sun_irradiance[1] > 4.0f);
    assert_true(low.sun_irradiance[0] > 4.0f * low.sun_irradiance[2]);
    assert_true(largest3(gone.sun_irradiance) < 1e-3f);
    for (uint32_t i = 0; i < CLAST_SKY_WIDTH * CLAST_SKY_HEIGHT; i++) {
        assert_true(is_finite3(load3(high.radiance[i])) && high.radiance[i].v[1] >= 0.0f &&
                    gone.radiance[i].v[1] < low.radiance[i].v[1] + 0.05f);
    }
    clast_sky_destroy(context, &high);
    clast_sky_destroy(context, &low);
    clast_sky_destroy(context, &gone);
}

static void dark_surroundings_give_no_light_and_no_error(void **state)
{
    picture p = picture_open(*state, 8, 4);
    picture_surround(&p, 0.0f);
    picture_add_square(&p, splat3(0.0f), vec3(1, 0, 0), vec3(0, 1, 0), CLAST_NONE);
    picture_look(&p, vec3(0, 0, 3), splat3(0.0f), 0.5f);
    picture_render(&p);
    assert_near(picture_mean(&p), 0.0, 0.0);
    picture_close(&p);
}

static void tone_maps_keep_black_grey_and_white_in_order(void **state)
{
    (void)state;
    for (uint32_t curve = 0; curve < 2; curve++) {
        float before = -1.0f;
        const float levels[] = {0.0f, 0.01f, 0.18f, 0.5f, 0.9f, 1.0f};
        for (int i = 0; i < 6; i++) {
            vec3 shown = tone_map(splat3(levels[i]), 1.0f, curve);
            assert_true(shown[1] > before && shown[1] <= 1.0f);
            assert_near(shown[0], shown[2], 2e-3);
            before = shown[1];
        }
    }
    assert_near(tone_map(splat3(0.18f), 1.0f, CLAST_TONE_MAP_ACES)[1], linear_to_srgb(0.18f), 0.003);
    assert_near(tone_map(splat3(0.25f), 4.0f, CLAST_TONE_MAP_NONE)[1], 1.0, 1e-6);
    vec3 wild = tone_map(vec3(INFINITY, NAN, -INFINITY), 1.0f, CLAST_TONE_MAP_ACES);
    assert_true(wild[0] >= 0.0f && wild[0] <= 1.0f && wild[1] >= 0.0f && wild[2] >= 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sums_are_chosen_from_by_weight),
        cmocka_unit_test(no_weight_at_all_is_an_even_choice),
        cmocka_unit_test(places_and_directions_are_inverse),
        CONTEXT_TEST(an_image_is_sampled_by_its_brightness),
        CONTEXT_TEST(a_picture_of_one_pixel_will_do),
        CONTEXT_TEST(the_sky_and_its_sun_are_sampled_rightly),
        CONTEXT_TEST(the_sky_is_blue_above_and_the_low_sun_red),
        CONTEXT_TEST(dark_surroundings_give_no_light_and_no_error),
        cmocka_unit_test(tone_maps_keep_black_grey_and_white_in_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
