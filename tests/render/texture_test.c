// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <math.h>

#include "render/texture.h"

#define assert_near(value, expected, tolerance) \
    assert_true(fabs((double)(value) - (double)(expected)) <= (double)(tolerance))

static clast_srgb_table tables;

static const uint8_t two_by_two[] = {0, 85, 170, 255}; // 0, 1/3; 2/3, 1

static clast_texture_use first_texture(void)
{
    return (clast_texture_use){.texture = 0, .scale = {{1.0f, 1.0f}}};
}

static clast_scene *scene_with(clast_context *context, const clast_image *image, clast_wrap wrap, clast_filter filter)
{
    clast_scene *scene;
    uint32_t number;
    assert_ok(context, clast_scene_create(context, &scene));
    assert_ok(context, clast_scene_add_image(scene, image, NULL, &number));
    clast_texture texture = {number, wrap, wrap, filter};
    assert_ok(context, clast_scene_add_texture(scene, &texture, &number));
    return scene;
}

static clast_scene *grey_scene(clast_context *context, clast_wrap wrap, clast_filter filter)
{
    clast_image image = {2, 2, 1, CLAST_PIXEL_UNORM8, two_by_two};
    return scene_with(context, &image, wrap, filter);
}

static float value_at(const clast_scene *scene, float u, float v)
{
    vec2 coordinates[2] = {vec2(u, v), vec2(0.0f, 0.0f)};
    clast_texture_area area = clast_texture_point(coordinates);
    return clast_texture_value(scene, first_texture(), &area, CLAST_ENCODING_LINEAR, &tables, splat3(0.0f))[0];
}

static void texel_centres_give_their_texels(void **state)
{
    clast_scene *scene = grey_scene(*state, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR);
    assert_near(value_at(scene, 0.25f, 0.25f), 0.0, 1e-6);
    assert_near(value_at(scene, 0.75f, 0.25f), 1.0 / 3.0, 1e-6);
    assert_near(value_at(scene, 0.25f, 0.75f), 2.0 / 3.0, 1e-6);
    assert_near(value_at(scene, 0.75f, 0.75f), 1.0, 1e-6);
    clast_scene_destroy(scene);
}

static void the_middle_is_the_mean(void **state)
{
    clast_scene *scene = grey_scene(*state, CLAST_WRAP_CLAMP, CLAST_FILTER_LINEAR);
    assert_near(value_at(scene, 0.5f, 0.5f), 0.5, 1e-6);
    assert_near(value_at(scene, 0.375f, 0.25f), 1.0 / 12.0, 1e-6);
    clast_scene_destroy(scene);
}

static void a_border_blends_by_its_wrap_mode(void **state)
{
    const double expected[] = {1.0 / 6.0, 0.0, 0.0}; // repeat, clamp, mirror
    for (uint32_t wrap = 0; wrap < 3; wrap++) {
        clast_scene *scene = grey_scene(*state, (clast_wrap)wrap, CLAST_FILTER_LINEAR);
        assert_near(value_at(scene, 0.0f, 0.25f), expected[wrap], 1e-6);
        clast_scene_destroy(scene);
    }
}

static void coordinates_outside_wrap(void **state)
{
    // u = 1.25: repeat is 0.25, clamp is 1, mirror is 0.75
    const double expected[] = {0.0, 1.0 / 3.0, 1.0 / 3.0};
    const double below[] = {1.0 / 3.0, 0.0, 0.0}; // u = -0.25: 0.75, 0, 0.25
    for (uint32_t wrap = 0; wrap < 3; wrap++) {
        clast_scene *scene = grey_scene(*state, (clast_wrap)wrap, CLAST_FILTER_NEAREST);
        assert_near(value_at(scene, 1.25f, 0.25f), expected[wrap], 1e-6);
        assert_near(value_at(scene, -0.25f, 0.25f), below[wrap], 1e-6);
        clast_scene_destroy(scene);
    }
}

static void coordinates_that_are_no_numbers_do_no_harm(void **state)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 16777217.0f, -1e-30f, 0.99999994f};
    for (uint32_t wrap = 0; wrap < 3; wrap++) {
        for (uint32_t filter = 0; filter < 2; filter++) {
            clast_scene *scene = grey_scene(*state, (clast_wrap)wrap, (clast_filter)filter);
            for (int i = 0; i < 8; i++) {
                float value = value_at(scene, bad[i], bad[7 - i]);
                assert_true(value >= 0.0f && value <= 1.0f);
            }
            clast_scene_destroy(scene);
        }
    }
}

static void channels_mean_what_gltf_says(void **state)
{
    const uint16_t pixels[4][4] = {
        {65535, 0, 0, 0}, {65535, 13107, 0, 0}, {65535, 0, 13107, 0}, {65535, 0, 13107, 26214}};
    const float expected[4][4] = {{1, 1, 1, 1}, {1, 1, 1, 0.2f}, {1, 0, 0.2f, 1}, {1, 0, 0.2f, 0.4f}};
    for (uint32_t channels = 1; channels <= 4; channels++) {
        clast_image image = {1, 1, channels, CLAST_PIXEL_UNORM16, pixels[channels - 1]};
        vec4 texel = clast_image_texel(&image, 0, 0, CLAST_ENCODING_LINEAR, &tables);
        clast_scene *scene = scene_with(*state, &image, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR);
        vec2 coordinates[2] = {vec2(0.3f, 0.4f), vec2(0.0f, 0.0f)};
        for (int c = 0; c < 4; c++) {
            assert_near(texel[c], expected[channels - 1][c], 1e-6);
        }
        assert_near(clast_texture_alpha(scene, first_texture(), coordinates), expected[channels - 1][3], 1e-6);
        clast_scene_destroy(scene);
    }
}

static void colours_are_decoded_exactly_and_alpha_is_not(void **state)
{
    (void)state;
    const uint8_t pixel[] = {0, 10, 255, 128};
    clast_image image = {1, 1, 4, CLAST_PIXEL_UNORM8, pixel};
    vec4 texel = clast_image_texel(&image, 0, 0, CLAST_ENCODING_SRGB, &tables);
    assert_near(texel[0], 0.0, 0.0);
    assert_near(texel[1], 10.0 / 255.0 / 12.92, 1e-9);
    assert_near(texel[2], 1.0, 0.0);
    assert_near(texel[3], 128.0 / 255.0, 1e-7);
    for (uint32_t i = 0; i < 256; i++) {
        double c = i / 255.0, linear = c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
        assert_near(tables.linear[i], linear, 3e-7);
        assert_int_equal((int)(linear_to_srgb(tables.linear[i]) * 255.0f + 0.5f), i);
    }
}

static void integers_stand_for_what_a_division_gives(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 256; i++) {
        assert_true(unorm8(i) == (float)i / 255.0f);
    }
    for (uint32_t i = 0; i < 65536; i++) {
        assert_true(unorm16(i) == (float)i / 65535.0f);
    }
}

static void float_images_are_linear(void **state)
{
    (void)state;
    const float pixel[] = {0.5f, 7.0f, 0.25f};
    clast_image image = {1, 1, 3, CLAST_PIXEL_FLOAT, pixel};
    vec4 texel = clast_image_texel(&image, 0, 0, CLAST_ENCODING_SRGB, &tables);
    assert_true(texel[0] == 0.5f && texel[1] == 7.0f && texel[2] == 0.25f && texel[3] == 1.0f);
}

// The example of KHR_texture_transform: it shows the lower left quarter of the image, turned clockwise.
static void transforms_scale_then_turn_then_move(void **state)
{
    (void)state;
    clast_texture_use use = {.offset = {{0.0f, 1.0f}}, .scale = {{0.5f, 0.5f}}, .rotation = 1.57079632679f};
    vec2 moved = transform_coordinates(use, vec2(1.0f, 0.0f));
    assert_near(moved[0], 0.0, 1e-6);
    assert_near(moved[1], 0.5, 1e-6);
    moved = transform_coordinates(use, vec2(0.0f, 1.0f));
    assert_near(moved[0], 0.5, 1e-6);
    assert_near(moved[1], 1.0, 1e-6);
}

static void the_second_coordinates_are_used_where_asked(void **state)
{
    clast_scene *scene = grey_scene(*state, CLAST_WRAP_CLAMP, CLAST_FILTER_NEAREST);
    clast_texture_use use = first_texture();
    use.coordinate_set = 1;
    vec2 coordinates[2] = {vec2(0.0f, 0.0f), vec2(1.0f, 1.0f)};
    clast_texture_area area = clast_texture_point(coordinates);
    assert_near(clast_texture_value(scene, use, &area, CLAST_ENCODING_LINEAR, &tables, splat3(0.0f))[0], 1.0, 0.0);
    clast_scene_destroy(scene);
}

int main(void)
{
    clast_srgb_table_fill(&tables);
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(texel_centres_give_their_texels),
        CONTEXT_TEST(the_middle_is_the_mean),
        CONTEXT_TEST(a_border_blends_by_its_wrap_mode),
        CONTEXT_TEST(coordinates_outside_wrap),
        CONTEXT_TEST(coordinates_that_are_no_numbers_do_no_harm),
        CONTEXT_TEST(channels_mean_what_gltf_says),
        cmocka_unit_test(colours_are_decoded_exactly_and_alpha_is_not),
        cmocka_unit_test(integers_stand_for_what_a_division_gives),
        cmocka_unit_test(float_images_are_linear),
        cmocka_unit_test(transforms_scale_then_turn_then_move),
        CONTEXT_TEST(the_second_coordinates_are_used_where_asked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
