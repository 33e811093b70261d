// SPDX-License-Identifier: Apache-2.0
// How much of a texture a sample sees: against brute force, and in pictures.
#include "picture.h"

#include "render/levels.h"
#include "render/texture.h"

static clast_srgb_table tables;

enum { SIDE = 256, CHECK = 8 };

// A board of squares of CHECK texels; the scene has a material that reads it.
static clast_scene *board(clast_context *context, uint32_t across, uint32_t down)
{
    static uint8_t pixels[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        pixels[i] = (i % SIDE / across + i / SIDE / down) % 2 != 0 ? 255 : 0;
    }
    clast_scene *scene;
    uint32_t number;
    assert_ok(context, clast_scene_create(context, &scene));
    clast_image image = {SIDE, SIDE, 1, CLAST_PIXEL_UNORM8, pixels};
    assert_ok(context, clast_scene_add_image(scene, &image, NULL, &number));
    clast_texture texture = {number, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    clast_material_desc material = clast_material_defaults();
    assert_ok(context, clast_scene_add_texture(scene, &texture, &material.metallic_roughness_texture.texture));
    assert_ok(context, clast_scene_add_material(scene, &material, NULL, &number));
    assert_ok(context, clast_make_levels(scene));
    return scene;
}

static float value_of(const clast_scene *scene, const clast_texture_area *area)
{
    clast_texture_use use = scene->materials[1].record.metallic_roughness_texture;
    return clast_texture_value(scene, use, area, CLAST_ENCODING_LINEAR, &tables, vec4(0.0f, 0.0f, 0.0f, 0.0f))[0];
}

// A floor at height 0, seen from above by a camera that looks along -z and down; a length of one is one texture.
typedef struct floor_view {
    clast_camera camera;
    clast_texture_gradient gradient;
} floor_view;

static floor_view look_at_floor(uint32_t rows)
{
    clast_camera_desc desc = {.position = {0.3f, 1.0f, 0.0f}, .target = {0.37f, 0.0f, -4.0f}, .vertical_angle = 0.6f};
    return (floor_view){clast_camera_record(&desc, rows, rows), {{{1.0f, 0.0f, 0.0f}}, {{0.0f, 0.0f, 1.0f}}}};
}

// What a sample through a point of the picture sees there; `share` of a pixel.
static clast_texture_area floor_area(const floor_view *view, uint32_t rows, double x, double y)
{
    clast_camera_ray ray = camera_ray(view->camera, (float)(x / rows), (float)(y / rows));
    vec3 direction = load3(ray.direction), normal = vec3(0.0f, 1.0f, 0.0f);
    float distance = load3(ray.origin)[1] / -direction[1];
    vec3 place = load3(ray.origin) + direction * distance;
    clast_ray_cone cone = cone_at(camera_cone(view->camera, rows, direction, 0), distance);
    clast_cone_axes axes = cone_axes(normal, direction, cone.width);
    return (clast_texture_area){
        .coordinates = {vec2(place[0], place[2]), splat2(0.0f)},
        .footprints = {footprint_of(view->gradient, load3(axes.first), load3(axes.second)), no_footprint()},
        .look = LOOK_WHOLE,
    };
}

// The mean of the finest level over a pixel.
static double brute_force(const clast_scene *scene, const floor_view *view, uint32_t rows, uint32_t x, uint32_t y)
{
    enum { ACROSS = 24 };
    double sum = 0.0;
    for (uint32_t i = 0; i < ACROSS * ACROSS; i++) {
        clast_texture_area area = floor_area(view, rows, x + (i % ACROSS + 0.5) / ACROSS,
                                             y + (i / ACROSS + 0.5) / ACROSS);
        area.footprints[0] = no_footprint();
        sum += (double)value_of(scene, &area);
    }
    return sum / (ACROSS * ACROSS);
}

// With one sample a pixel, a board that recedes to the horizon is what many samples show; without levels it is noise there.
static void one_sample_shows_what_its_pixel_sees(void **state)
{
    enum { ROWS = 48 };
    clast_scene *scene = board(*state, CHECK, CHECK);
    floor_view view = look_at_floor(ROWS);
    double errors = 0.0, plain_errors = 0.0, largest = 0.0;
    for (uint32_t i = 0; i < ROWS * ROWS; i++) {
        uint32_t x = i % ROWS, y = i / ROWS;
        clast_texture_area area = floor_area(&view, ROWS, x + 0.5, y + 0.5);
        double expected = brute_force(scene, &view, ROWS, x, y), filtered = (double)value_of(scene, &area);
        area.footprints[0] = no_footprint();
        double plain = (double)value_of(scene, &area);
        errors += (filtered - expected) * (filtered - expected);
        plain_errors += (plain - expected) * (plain - expected);
        largest = fmax(largest, fabs(filtered - expected));
    }
    errors = sqrt(errors / (ROWS * ROWS));
    plain_errors = sqrt(plain_errors / (ROWS * ROWS));
    print_message("error %.4f, %.4f without levels; largest %.3f\n", errors, plain_errors, largest);
    assert_true(errors < 0.08 && errors < 0.3 * plain_errors && largest < 0.35);
    clast_scene_destroy(scene);
}

// Stripes of four texels, seen by what is 1 texel across them and 32 along them, stay as they are; turned, they become grey.
static void what_is_long_and_thin_is_sharp_across(void **state)
{
    for (int turned = 0; turned < 2; turned++) {
        clast_scene *scene = turned ? board(*state, 4, SIDE) : board(*state, SIDE, 4);
        double least = 1.0, most = 0.0;
        for (uint32_t i = 0; i < 512; i++) {
            clast_texture_area area = {
                .coordinates = {splat2((float)i / 512.0f), splat2(0.0f)},
                .footprints = {{{{32.0f / SIDE, 0.0f}}, {{0.0f, 1.0f / SIDE}}}, no_footprint()},
                .look = LOOK_WHOLE,
            };
            double value = (double)value_of(scene, &area);
            least = fmin(least, value);
            most = fmax(most, value);
        }
        print_message("%g to %g\n", least, most);
        assert_true(turned ? most - least < 0.3 : least < 0.2 && most > 0.8);
        clast_scene_destroy(scene);
    }
}

// What a sample sees is bounded in points, whatever is asked.
static void odd_footprints_do_no_harm(void **state)
{
    clast_scene *scene = board(*state, CHECK, CHECK);
    const float odd[] = {NAN, INFINITY, -INFINITY, 1e38f, -1e30f, 1e-38f, 0.0f, 0.5f};
    for (uint32_t i = 0; i < 4096; i++) {
        clast_footprint at = {{{odd[i % 8], odd[i / 8 % 8]}}, {{odd[i / 64 % 8], odd[i / 512]}}};
        for (uint32_t look = LOOK_POINT; look <= LOOK_WHOLE; look++) {
            clast_texture_taps taps = texture_taps(at, SIDE, SIDE, 8, look);
            assert_true(taps.count >= 1 && taps.count <= 16 && taps.level >= 0.0f && taps.level <= 8.0f);
            clast_texture_area area = {
                .coordinates = {splat2(0.3f), splat2(0.3f)}, .footprints = {at, at}, .look = look};
            float value = value_of(scene, &area);
            assert_true(value >= 0.0f && value <= 1.0f);
        }
    }
    clast_scene_destroy(scene);
}

static void a_cone_grows_with_distance_and_bends_at_mirrors(void **state)
{
    (void)state;
    clast_camera_desc desc = {.position = {0, 0, 0}, .target = {0, 0, -1}, .vertical_angle = 1.0f};
    clast_camera camera = clast_camera_record(&desc, 100, 100);
    clast_ray_cone cone = camera_cone(camera, 100, vec3(0.0f, 0.0f, -1.0f), 0);
    float pixel = 2.0f * tanf(0.5f) / 100.0f;
    assert_near(cone_at(cone, 10.0f).width, 10.0f * pixel, 1e-6);
    assert_near(camera_cone(camera, 100, vec3(0.0f, 0.0f, -1.0f), 7).spread, 0.25f * pixel, 1e-7);
    desc.projection = CLAST_PROJECTION_ORTHOGRAPHIC;
    desc.height = 4.0f;
    clast_ray_cone parallel = camera_cone(clast_camera_record(&desc, 100, 100), 100, vec3(0.0f, 0.0f, -1.0f), 0);
    assert_near(cone_at(parallel, 10.0f).width, 0.04, 1e-6);
    clast_ray_cone there = cone_at(cone, 10.0f), flat = cone_scattered(there, 0.0f, false, 1e9f, 0);
    assert_near(flat.width, there.width, 0.0);
    assert_near(flat.spread, there.spread, 1e-4);
    float bend = there.width / 2.0f; // of a sphere of radius 2
    assert_near(cone_scattered(there, bend, false, 1e9f, 0).spread, there.spread + 2.0f * bend, 1e-4);
    assert_near(cone_scattered(there, bend, true, 1e9f, 0).spread, there.spread, 1e-4);
    assert_true(cone_scattered(there, 0.0f, false, 0.3f, 0).spread > 0.1f); // off what is dull
    clast_ray_cone focused = cone_scattered(there, -10.0f * there.width, false, 1e9f, 0);
    assert_true(cone_at(focused, 0.04f).width < there.width && cone_at(focused, 10.0f).width > there.width);
}

// ------------------------------------------------------------------------------------------------------------- pictures

enum { PICTURE = 40 };

// A floor with a board of 64 x 64 squares to the horizon, as it is lit from all around.
static picture floor_picture(clast_context *context, uint32_t samples, bool has_levels)
{
    static uint8_t pixels[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        pixels[i] = (i % SIDE / 4 + i / SIDE / 4) % 2 != 0 ? 255 : 20;
    }
    picture p = picture_open(context, PICTURE, samples);
    uint32_t number;
    clast_image image = {SIDE, SIDE, 1, CLAST_PIXEL_UNORM8, pixels};
    assert_ok(context, clast_scene_add_image(p.scene, &image, NULL, &number));
    clast_texture texture = {number, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    clast_material_desc material = clast_material_defaults();
    material.unlit = true;
    for (int c = 0; c < 3; c++) {
        material.base_colour[c] = 1.0f;
    }
    assert_ok(context, clast_scene_add_texture(p.scene, &texture, &material.base_colour_texture.texture));
    assert_ok(context, clast_scene_add_material(p.scene, &material, NULL, &number));
    picture_add_square(&p, vec3(0.0f, 0.0f, -10.0f), vec3(12.0f, 0.0f, 0.0f), vec3(0.0f, 0.0f, -12.0f), number);
    picture_look(&p, vec3(0.3f, 1.0f, 0.0f), vec3(0.0f, 0.4f, -4.0f), 0.7f);
    p.scene->has_levels = !has_levels; // says that they are there already
    p.scene->levels_version = p.scene->material_version;
    picture_render(&p);
    return p;
}

static double difference(const picture *a, const picture *b)
{
    const float *x = a->pixels[CLAST_VIEW_COLOUR], *y = b->pixels[CLAST_VIEW_COLOUR];
    double sum = 0.0;
    for (size_t i = 0; i < 3 * PICTURE * PICTURE; i++) {
        sum += ((double)x[i] - (double)y[i]) * ((double)x[i] - (double)y[i]);
    }
    return sqrt(sum / (3 * PICTURE * PICTURE));
}

// Contrast from pixel to pixel.
static double sharpness(const picture *p)
{
    double sum = 0.0;
    for (uint32_t y = 0; y < PICTURE; y++) {
        for (uint32_t x = 1; x < PICTURE; x++) {
            sum += fabs((double)picture_pixel(p, x, y)[0] - (double)picture_pixel(p, x - 1, y)[0]);
        }
    }
    return sum;
}

// Few samples come nearer to the picture of many than without levels, and that is as sharp as without them to a few percent.
static void few_samples_are_smooth_and_many_are_sharp(void **state)
{
    picture many = floor_picture(*state, 512, true), many_plain = floor_picture(*state, 512, false);
    double kept = sharpness(&many) / sharpness(&many_plain), apart = difference(&many, &many_plain);
    print_message("sharpness %.3f of that without levels, %.4f apart\n", kept, apart);
    assert_true(kept > 0.98 && apart < 0.005);
    for (uint32_t samples = 1; samples <= 16; samples *= 4) {
        picture few = floor_picture(*state, samples, true), plain = floor_picture(*state, samples, false);
        double error = difference(&few, &many_plain), plain_error = difference(&plain, &many_plain);
        print_message("%u samples: error %.4f, %.4f without levels\n", samples, error, plain_error);
        assert_true(error < (samples == 1 ? 0.4 : 0.7) * plain_error);
        picture_close(&few);
        picture_close(&plain);
    }
    picture_close(&many);
    picture_close(&many_plain);
}

// Bumps from waves that go all ways: their slopes are spread as those of a rough surface.
static const uint8_t *bumps(void)
{
    static uint8_t pixels[SIDE * SIDE * 3];
    const float waves[8][2] = {{5, 12}, {-9, 11}, {14, 3}, {13, -7}, {3, 15}, {-4, 13}, {10, 10}, {12, -2}};
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        vec3 normal = vec3(0.0f, 0.0f, 1.0f);
        for (int k = 0; k < 8; k++) {
            const float *w = waves[k];
            float at = 6.2831853f / SIDE * (w[0] * (float)(i % SIDE) + w[1] * (float)(i / SIDE)) + (float)k;
            normal = normal + vec3(w[0], w[1], 0.0f) * (0.006f * cosf(at));
        }
        normal = normalize3(normal);
        for (int c = 0; c < 3; c++) {
            pixels[3 * i + (uint32_t)c] = (uint8_t)(127.5f * normal[c] + 128.0f);
        }
    }
    return pixels;
}

// A glossy square of bumps in the sun, far away: how much its pixels differ, in parts of their mean.
static double sparkle(clast_context *context, uint32_t samples, bool has_levels, double *mean)
{
    picture p = picture_open(context, PICTURE, samples);
    uint32_t number;
    clast_image image = {SIDE, SIDE, 3, CLAST_PIXEL_UNORM8, bumps()};
    assert_ok(context, clast_scene_add_image(p.scene, &image, NULL, &number));
    clast_texture texture = {number, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    clast_material_desc material = clast_material_defaults();
    material.metallic = 1.0f;
    material.roughness = 0.1f;
    material.normal_texture.scale[0] = material.normal_texture.scale[1] = 8.0f; // two waves a pixel
    assert_ok(context, clast_scene_add_texture(p.scene, &texture, &material.normal_texture.texture));
    assert_ok(context, clast_scene_add_material(p.scene, &material, NULL, &number));
    picture_add_square(&p, vec3(0.0f, 0.0f, 0.0f), vec3(1.0f, 0.0f, 0.0f), vec3(0.0f, 1.0f, 0.0f), number);
    picture_look(&p, vec3(0.0f, -2.0f, 10.0f), vec3(0.0f, 0.0f, 0.0f), 0.15f);
    clast_light_desc light = {.type = CLAST_LIGHT_DIRECTIONAL,
                              .direction = {0.0f, -0.2f, -1.0f},
                              .colour = {1.0f, 1.0f, 1.0f},
                              .intensity = 1.0f};
    assert_ok(context, clast_scene_add_light(p.scene, &light, NULL, &number));
    p.settings.integrator = CLAST_INTEGRATOR_DIRECT;
    p.scene->has_levels = !has_levels;
    p.scene->levels_version = p.scene->material_version;
    picture_render(&p);
    *mean = picture_mean(&p);
    double sum = 0.0;
    for (uint32_t y = 10; y < PICTURE - 10; y++) {
        for (uint32_t x = 10; x < PICTURE - 10; x++) {
            double apart = (double)picture_pixel(&p, x, y)[0] - (double)picture_pixel(&p, x - 1, y)[0];
            sum += apart * apart;
        }
    }
    picture_close(&p);
    return sqrt(sum) / PICTURE / *mean;
}

static void glossy_bumps_far_away_do_not_sparkle(void **state)
{
    double mean, few_mean, plain_mean;
    double without = sparkle(*state, 4, false, &few_mean), with = sparkle(*state, 4, true, &mean);
    sparkle(*state, 1024, false, &plain_mean);
    print_message("sparkle %.3f, %.3f without levels; mean %.4f, %.4f\n", with, without, mean, plain_mean);
    assert_true(with < 0.2 * without);
    assert_near(mean, plain_mean, 0.2 * plain_mean); // slopes of waves are not quite those of a rough surface
}

int main(void)
{
    clast_srgb_table_fill(&tables);
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(one_sample_shows_what_its_pixel_sees),
        CONTEXT_TEST(what_is_long_and_thin_is_sharp_across),
        CONTEXT_TEST(odd_footprints_do_no_harm),
        CONTEXT_TEST(a_cone_grows_with_distance_and_bends_at_mirrors),
        CONTEXT_TEST(few_samples_are_smooth_and_many_are_sharp),
        CONTEXT_TEST(glossy_bumps_far_away_do_not_sparkle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
