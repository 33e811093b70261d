// SPDX-License-Identifier: Apache-2.0
// Whole pictures of a device against those of the processor, from the same samples. What is hit is the same; radiance differs
// by rounding, which now and then sends a path another way. All of it twice: through clast's own trees and, where there are
// some, through the driver's acceleration structures.
#include "render/picture.h"

#include <unistd.h>

#include "vulkan/render.h"
#include "vulkan/test_device.h"

static test_device device;
static bool through_driver;

enum { SIZE = 36, SAMPLES = 4 };

static const clast_view every_view[] = {
    CLAST_VIEW_COLOUR,   CLAST_VIEW_ALBEDO,  CLAST_VIEW_NORMAL,   CLAST_VIEW_DEPTH,     CLAST_VIEW_UV,
    CLAST_VIEW_INSTANCE, CLAST_VIEW_CLUSTER, CLAST_VIEW_TRIANGLE, CLAST_VIEW_PRIMITIVE, CLAST_VIEW_SEGMENTS,
    CLAST_VIEW_RATE,     CLAST_VIEW_AREA,    CLAST_VIEW_SAMPLES};
enum { VIEWS = sizeof every_view / sizeof every_view[0] };

#define CHANNELS(name, value, text, channels, is_float, help) [name] = channels,
static const uint32_t channels[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(CHANNELS)};
#define IS_FLOAT(name, value, text, channels, is_float, help) [name] = is_float,
static const bool are_floats[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(IS_FLOAT)};

static bool alike(float a, float b, float tolerance)
{
    return a == b || fabsf(a - b) <= tolerance * (1.0f + fabsf(a) + fabsf(b));
}

// How many pixels of a view differ.
static uint32_t differences(clast_view view, const void *a, const void *b, size_t pixels)
{
    uint32_t count = 0;
    for (size_t i = 0; i < pixels; i++) {
        bool same = true;
        for (uint32_t c = 0; c < channels[view]; c++) {
            size_t place = i * channels[view] + c;
            float x, y;
            memcpy(&x, (const char *)a + 4 * place, sizeof x);
            memcpy(&y, (const char *)b + 4 * place, sizeof y);
            same = same && (memcmp(&x, &y, sizeof x) == 0 || (are_floats[view] && alike(x, y, 2e-3f)));
        }
        count += !same;
    }
    return count;
}

// The device's frame over a picture's scene.
typedef struct twin {
    clast_frame *frame;
    clast_vulkan_frame *made;
} twin;

static twin twin_open(const picture *p)
{
    twin t = {0};
    assert_ok(p->context, clast_frame_create(p->scene, p->cooked, &t.frame));
    assert_ok(p->context, clast_vulkan_frame_create(device.gpu, &t.made));
    if (through_driver) {
        assert_ok(p->context, clast_vulkan_frame_use_driver(t.made));
    }
    t.frame->device = t.made;
    t.frame->settings = p->frame->settings;
    assert_ok(p->context, clast_frame_run(t.frame, &clast_vulkan_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    return t;
}

static void twin_close(twin *t)
{
    clast_vulkan_frame_destroy(t->made);
    clast_frame_destroy(t->frame);
}

static double mean_of(const float *values, size_t count)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        sum += (double)values[i];
    }
    return sum / (double)count;
}

// The digits of rays decide whether blended surfaces let them pass. Those of rays that leave surfaces are others, by the driver
// of most.
static bool has_blended;

// How many pixels may be others, as a sample of them went another way.
static uint32_t most_differences(clast_view view, size_t pixels)
{
    bool by_chance = has_blended && view == CLAST_VIEW_COLOUR;
    return (uint32_t)(!by_chance ? pixels / 100 : through_driver ? pixels / 10 : pixels / 80);
}

// Renders the views with both backends.
static void compare_views(picture *p, twin *t, const clast_view *views, size_t count)
{
    size_t pixels = (size_t)p->settings.width * p->settings.height;
    clast_render_output outputs[CLAST_VIEW_COUNT_];
    clast_render_statistics statistics;
    assert_ok(p->context, picture_try(p, views, count));
    for (size_t i = 0; i < count; i++) {
        outputs[i] = (clast_render_output){views[i], malloc(pixels * 12)};
    }
    assert_ok(p->context,
              clast_render_frame(t->frame, &clast_vulkan_backend, &p->settings, outputs, count, &statistics));
    for (size_t i = 0; i < count; i++) {
        uint32_t differ = differences(views[i], outputs[i].pixels, p->pixels[views[i]], pixels);
        if (differ > 0) {
            print_message("view %d: %u of %zu pixels differ\n", (int)views[i], differ, pixels);
        }
        assert_true(differ <= most_differences(views[i], pixels));
    }
    double mean = mean_of(p->pixels[CLAST_VIEW_COLOUR], 3 * pixels);
    assert_near(mean_of(outputs[0].pixels, 3 * pixels), mean, 0.01 * mean);
    assert_int_equal(statistics.samples, p->statistics.samples);
    assert_int_equal(statistics.primary_rays, p->statistics.primary_rays);
    assert_near((double)statistics.rays / (double)p->statistics.rays, 1.0,
                through_driver && has_blended ? 0.005 : 0.002);
    for (size_t i = 0; i < count; i++) {
        free(outputs[i].pixels);
    }
}

static void compare(picture *p)
{
    picture_build(p);
    twin t = twin_open(p);
    compare_views(p, &t, every_view, VIEWS);
    twin_close(&t);
    picture_close(p);
}

// --------------------------------------------------------------------------------------------------------------- scenes

static uint32_t add_material(picture *p, const clast_material_desc *desc)
{
    uint32_t number;
    assert_ok(p->context, clast_scene_add_material(p->scene, desc, NULL, &number));
    return number;
}

// A checkered texture of four channels, whose values and alpha vary.
static uint32_t add_texture(picture *p, uint32_t seed)
{
    enum { SIDE = 16 };
    uint8_t texels[SIDE * SIDE * 4];
    for (uint32_t i = 0; i < sizeof texels; i++) {
        uint32_t square = i / 16 + i / (SIDE * 16);
        texels[i] = (uint8_t)(60 + hash2(square, seed + i % 4) % 190);
    }
    clast_image image = {SIDE, SIDE, 4, CLAST_PIXEL_UNORM8, texels};
    uint32_t image_number, number;
    assert_ok(p->context, clast_scene_add_image(p->scene, &image, NULL, &image_number));
    clast_texture texture = {image_number, CLAST_WRAP_REPEAT, CLAST_WRAP_MIRROR, CLAST_FILTER_LINEAR};
    assert_ok(p->context, clast_scene_add_texture(p->scene, &texture, &number));
    return number;
}

// A room that is open to the front, with a lamp under its ceiling.
static picture room(void)
{
    picture p = picture_open(device.context, SIZE, SAMPLES);
    uint32_t grey = picture_material(&p, 0.7f, 0.0f, 0.9f, 0.0f);
    picture_add_square(&p, vec3(0, -1, 0), vec3(2, 0, 0), vec3(0, 0, -2), grey);
    picture_add_square(&p, vec3(0, 3, 0), vec3(2, 0, 0), vec3(0, 0, 2), grey);
    picture_add_square(&p, vec3(0, 1, -2), vec3(2, 0, 0), vec3(0, 2, 0), grey);
    picture_add_square(&p, vec3(-2, 1, 0), vec3(0, 0, -2), vec3(0, 2, 0), picture_material(&p, 0.3f, 0.0f, 0.4f, 0.0f));
    picture_add_square(&p, vec3(0.4f, 2.9f, 0), vec3(0.5f, 0, 0), vec3(0, 0, 0.5f),
                       picture_material(&p, 0.5f, 0.0f, 0.5f, 12.0f));
    picture_look(&p, vec3(0, 1, 6), vec3(0, 1, 0), 0.8f);
    return p;
}

static void add_balls(picture *p)
{
    clast_material_desc glass = clast_material_defaults(), coat = clast_material_defaults(), fuzz = coat, metal = coat;
    glass.transmission = 1.0f;
    glass.thickness = 1.0f;
    glass.roughness = 0.2f;
    glass.attenuation_distance = 0.7f;
    glass.attenuation_colour[0] = 0.3f;
    glass.attenuation_colour[1] = glass.attenuation_colour[2] = 0.9f;
    coat.clearcoat = 1.0f;
    coat.clearcoat_roughness = 0.1f;
    coat.base_colour_texture.texture = add_texture(p, 1);
    coat.normal_texture.texture = add_texture(p, 2);
    coat.normal_scale = 0.2f;
    fuzz.sheen_colour[0] = fuzz.sheen_colour[1] = 0.8f;
    fuzz.sheen_roughness = 0.4f;
    metal.metallic = 1.0f;
    metal.roughness = 0.3f;
    metal.anisotropy = 0.7f;
    metal.iridescence = 1.0f;
    metal.iridescence_thickness_maximum = 500.0f;
    fuzz.diffuse_transmission = 0.5f;
    fuzz.diffuse_transmission_colour[0] = 0.4f;
    glass.dispersion = 2.0f;
    picture_add_sphere(p, vec3(-1.1f, -0.2f, 0.4f), 0.7f, 24, add_material(p, &glass));
    picture_add_sphere(p, vec3(0.8f, -0.4f, 0.6f), 0.6f, 24, add_material(p, &coat));
    picture_add_sphere(p, vec3(0.9f, 1.3f, -0.8f), 0.6f, 24, add_material(p, &fuzz));
    picture_add_sphere(p, vec3(-0.9f, 1.6f, -0.8f), 0.6f, 24, add_material(p, &metal));
}

static void lamps_light_a_room(void **state)
{
    (void)state;
    picture p = room();
    compare(&p);
}

static void materials_scatter_alike(void **state)
{
    (void)state;
    picture p = room();
    add_balls(&p);
    clast_environment environment = {
        .type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.3f, 0.5f, 0.9f}, .colour = {0.3f, 0.3f, 0.3f}};
    assert_ok(p.context, clast_scene_set_environment(p.scene, &environment));
    compare(&p);
}

// Masked, blended and single-sided squares before a picture of light.
static void eyes_look_through_alike(void **state)
{
    (void)state;
    picture p = picture_open(device.context, SIZE, SAMPLES);
    clast_material_desc mask = clast_material_defaults(), blend = mask, single = mask;
    mask.alpha_mode = CLAST_ALPHA_MASK;
    mask.alpha_cutoff = 0.6f;
    mask.base_colour_texture.texture = blend.base_colour_texture.texture = add_texture(&p, 3);
    // A hash of the ray's bits decides about blended surfaces: the last of these are others where divisions are not exact.
    if (clast_gpu_features_of(device.gpu)->is_software) {
        blend.alpha_mode = CLAST_ALPHA_BLEND;
        has_blended = true;
    }
    single.double_sided = false;
    picture_add_square(&p, vec3(-0.7f, 0, 1), vec3(1, 0, 0.2f), vec3(0, 1, 0), add_material(&p, &mask));
    picture_add_square(&p, vec3(0.7f, 0, 0.5f), vec3(1, 0, -0.2f), vec3(0, 1, 0), add_material(&p, &blend));
    picture_add_square(&p, vec3(0, 0.5f, 2), vec3(-0.6f, 0, 0), vec3(0, 0.6f, 0), add_material(&p, &single));
    picture_add_square(&p, vec3(0, 0, -1), vec3(3, 0, 0), vec3(0, 3, 0), picture_material(&p, 0.6f, 0, 0.8f, 0));
    float texels[8 * 4 * 3];
    for (uint32_t i = 0; i < sizeof texels / sizeof *texels; i++) {
        texels[i] = 0.2f + 2.0f * unit_float(hash1(i / 3));
    }
    clast_image image = {8, 4, 3, CLAST_PIXEL_FLOAT, texels};
    uint32_t number;
    assert_ok(p.context, clast_scene_add_image(p.scene, &image, NULL, &number));
    clast_environment environment = {.type = CLAST_ENVIRONMENT_IMAGE, .image = number, .rotation = 0.4f};
    assert_ok(p.context, clast_scene_set_environment(p.scene, &environment));
    picture_look(&p, vec3(0, 0, 5), vec3(0, 0, 0), 0.7f);
    compare(&p);
    has_blended = false;
}

static void waves_are_cut_alike(void **state)
{
    (void)state;
    picture p = picture_open(device.context, SIZE, SAMPLES);
    picture_surround(&p, 0.3f);
    clast_light_desc light = {.type = CLAST_LIGHT_SPOT,
                              .position = {1, 4, 1},
                              .direction = {-0.1f, -1, -0.2f},
                              .colour = {1.0f, 0.8f, 0.6f},
                              .intensity = 40.0f,
                              .outer_angle = 0.8f};
    uint32_t number;
    assert_ok(p.context, clast_scene_add_light(p.scene, &light, NULL, &number));
    shape_add_instance(p.context, p.scene, shape_add_wave(p.context, p.scene, 4), 0, 0, 0, 1);
    picture_look(&p, vec3(2, 3, 4), vec3(0, 0, 0), 0.9f);
    compare(&p);
}

static void settings_mean_the_same(void **state)
{
    (void)state;
    picture p = room();
    add_balls(&p);
    picture_surround(&p, 0.2f);
    picture_build(&p);
    twin t = twin_open(&p);
    const clast_view colour = CLAST_VIEW_COLOUR;
    for (uint32_t i = 0; i < 6; i++) {
        p.settings.integrator = i < 3 ? (clast_integrator)(CLAST_INTEGRATOR_DIRECT + i) : CLAST_INTEGRATOR_PATH;
        p.settings.fireflies = i < 3 ? CLAST_FIREFLIES_CLAMPED : (clast_fireflies)(i - 3);
        p.settings.ao_distance = 1.5;
        p.settings.bounces = i == 5 ? 1 : 3;
        p.settings.seed = i;
        p.settings.spp = 2;
        compare_views(&p, &t, &colour, 1);
    }
    twin_close(&t);
    picture_close(&p);
}

static void lenses_and_panoramas_see_alike(void **state)
{
    (void)state;
    picture p = room();
    picture_surround(&p, 0.5f);
    picture_build(&p);
    p.settings.spp = 2;
    for (int i = 0; i < 2; i++) {
        clast_camera *camera = &p.frame->settings.camera;
        camera->lens_radius = i == 0 ? 0.3f : 0.0f;
        camera->focus = 5.0f;
        camera->projection = i == 0 ? CLAST_PROJECTION_PERSPECTIVE : CLAST_PROJECTION_PANORAMA;
        camera->position = i == 0 ? camera->position : (packed3){{0.3f, 1.0f, 0.5f}};
        twin t = twin_open(&p);
        compare_views(&p, &t, every_view, 4);
        twin_close(&t);
    }
    picture_close(&p);
}

// ------------------------------------------------------------------------------------------------------------ progress

// When a render is stopped: at which report of its progress.
static uint64_t reports, last_report = UINT64_MAX;

static bool go_on(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)user;
    (void)done;
    (void)total;
    return strcmp(stage, "render") != 0 || reports++ < last_report;
}

// What was rendered until then is a picture of fewer samples.
static void a_render_can_be_stopped(void **state)
{
    (void)state;
    picture p = room();
    p.settings.spp = 8;
    p.settings.time_limit = 1e-9; // one sample of them
    picture_render(&p);
    p.settings.time_limit = 0.0;
    twin t = twin_open(&p);
    float pixels[SIZE * SIZE * 3];
    clast_render_output output = {CLAST_VIEW_COLOUR, pixels};
    clast_render_statistics statistics;
    reports = 0;
    last_report = 1;
    clast_status status = clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, &output, 1, &statistics);
    last_report = UINT64_MAX;
    assert_int_equal(status, CLAST_ERROR_CANCELLED);
    assert_int_equal(statistics.samples, 1);
    assert_true(differences(CLAST_VIEW_COLOUR, pixels, p.pixels[CLAST_VIEW_COLOUR], SIZE * SIZE) <= SIZE * SIZE / 100);
    twin_close(&t);
    picture_close(&p);
}

// A picture of more paths than are under way at a time, whose sides are no multiples of anything.
static void tiles_make_one_picture(void **state)
{
    (void)state;
    picture p = room();
    picture_build(&p);
    p.settings.width = 203;
    p.settings.height = 215;
    p.settings.spp = 1;
    p.settings.bounces = 2;
    twin t = twin_open(&p);
    compare_views(&p, &t, every_view, 2);
    // Stopped before the second tile: some squares have a sample, the others have none.
    size_t pixels = (size_t)p.settings.width * p.settings.height;
    float *values = malloc(pixels * 12);
    uint32_t *samples = malloc(pixels * 4);
    assert_true(values != NULL && samples != NULL);
    const clast_render_output stopped[] = {{CLAST_VIEW_COLOUR, values}, {CLAST_VIEW_SAMPLES, samples}};
    clast_render_statistics statistics;
    reports = 0;
    last_report = 1;
    clast_status status = clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, stopped, 2, &statistics);
    last_report = UINT64_MAX;
    assert_int_equal(status, CLAST_ERROR_CANCELLED);
    float *whole = p.pixels[CLAST_VIEW_COLOUR];
    uint64_t done = 0;
    for (size_t i = 0; i < pixels; i++) {
        assert_true(samples[i] <= 1);
        done += samples[i];
        for (size_t c = 0; c < 3; c++) {
            whole[3 * i + c] = samples[i] != 0 ? whole[3 * i + c] : 0.0f;
        }
    }
    assert_int_equal(done, statistics.primary_rays);
    // Devices that are no programs have one tile only.
    assert_true(done != 0 && (done != pixels || !clast_gpu_features_of(device.gpu)->is_software));
    assert_true(differences(CLAST_VIEW_COLOUR, values, whole, pixels) <= pixels / 100);
    free(samples);
    free(values);
    twin_close(&t);
    picture_close(&p);
}

// ---------------------------------------------------------------------------------------------------- parts and noise

static void crops_are_those_of_the_whole_picture(void **state)
{
    (void)state;
    picture p = room();
    add_balls(&p);
    picture_surround(&p, 0.2f);
    picture_build(&p);
    twin t = twin_open(&p);
    float whole[SIZE * SIZE * 3], part[17 * 20 * 3];
    clast_render_output output = {CLAST_VIEW_COLOUR, whole};
    clast_render_statistics statistics;
    assert_ok(p.context, clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, &output, 1, &statistics));
    p.settings.crop = "11,13,17,20";
    output.pixels = part;
    assert_ok(p.context, clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, &output, 1, &statistics));
    assert_int_equal(statistics.primary_rays, SAMPLES * 17 * 20);
    for (uint32_t row = 0; row < 20; row++) {
        assert_memory_equal(part + row * 17 * 3, whole + ((row + 13) * SIZE + 11) * 3, 17 * 12);
    }
    twin_close(&t);
    picture_close(&p);
}

// What the device has summed up goes to a file and comes back.
static void interrupted_pictures_go_on(void **state)
{
    (void)state;
    char file[] = "/tmp/clast_checkpoint_XXXXXX";
    int made = mkstemp(file);
    assert_true(made >= 0 && close(made) == 0);
    picture p = room();
    picture_build(&p);
    twin t = twin_open(&p);
    static float whole[SIZE * SIZE * 3], parts[SIZE * SIZE * 3];
    static float depths[2][SIZE * SIZE];
    const clast_render_output outputs[2][2] = {{{CLAST_VIEW_COLOUR, whole}, {CLAST_VIEW_DEPTH, depths[0]}},
                                               {{CLAST_VIEW_COLOUR, parts}, {CLAST_VIEW_DEPTH, depths[1]}}};
    clast_render_statistics statistics;
    p.settings.noise_target = 0.012;
    p.settings.bounces = 1;
    p.settings.spp = 24;
    assert_ok(p.context, clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, outputs[0], 2, &statistics));
    clast_render_request request = {&p.settings, outputs[1], 2, {NULL, file, 1e9}, "device"};
    reports = 0;
    last_report = 18;
    assert_int_equal(clast_render_run(t.frame, &clast_vulkan_backend, &request, &statistics), CLAST_ERROR_CANCELLED);
    last_report = UINT64_MAX;
    assert_int_equal(statistics.samples, 18);
    request.checkpoint = (clast_checkpoint){.resume = file};
    assert_ok(p.context, clast_render_run(t.frame, &clast_vulkan_backend, &request, &statistics));
    assert_memory_equal(parts, whole, sizeof whole);
    assert_memory_equal(depths[1], depths[0], sizeof depths[0]);
    unlink(file);
    twin_close(&t);
    picture_close(&p);
}

// Roundings may make a square end a round earlier or later.
static void noise_ends_squares_alike(void **state)
{
    (void)state;
    const clast_view views[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_SAMPLES};
    picture p = room();
    picture_surround(&p, 0.0f);
    p.settings.spp = 64;
    p.settings.bounces = 1;
    p.settings.noise_target = 0.012;
    picture_build(&p);
    twin t = twin_open(&p);
    static float colours[SIZE * SIZE * 3];
    static uint32_t samples[SIZE * SIZE];
    const clast_render_output outputs[] = {{CLAST_VIEW_COLOUR, colours}, {CLAST_VIEW_SAMPLES, samples}};
    clast_render_statistics statistics;
    assert_ok(p.context, picture_try(&p, views, 2));
    assert_ok(p.context, clast_render_frame(t.frame, &clast_vulkan_backend, &p.settings, outputs, 2, &statistics));
    assert_true(p.statistics.mean_samples > 17.0 && p.statistics.mean_samples < 60.0);
    assert_near(statistics.mean_samples / p.statistics.mean_samples, 1.0, 0.1);
    uint32_t differ = differences(CLAST_VIEW_SAMPLES, samples, p.pixels[CLAST_VIEW_SAMPLES], SIZE * SIZE);
    assert_true(differ <= SIZE * SIZE / 5);
    assert_near(mean_of(colours, SIZE * SIZE * 3) / picture_mean(&p), 1.0, 0.02);
    twin_close(&t);
    picture_close(&p);
}

static int run_all(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_light_a_room),
        cmocka_unit_test(materials_scatter_alike),
        cmocka_unit_test(eyes_look_through_alike),
        cmocka_unit_test(waves_are_cut_alike),
        cmocka_unit_test(settings_mean_the_same),
        cmocka_unit_test(lenses_and_panoramas_see_alike),
        cmocka_unit_test(a_render_can_be_stopped),
        cmocka_unit_test(tiles_make_one_picture),
        cmocka_unit_test(crops_are_those_of_the_whole_picture),
        cmocka_unit_test(noise_ends_squares_alike),
        cmocka_unit_test(interrupted_pictures_go_on),
    };
    device = test_device_open();
    int failed = cmocka_run_group_tests_name("pictures of a device", tests, NULL, NULL);
    return test_device_close(&device) ? failed : 1;
}

static int run_through_driver(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lamps_light_a_room),
        cmocka_unit_test(materials_scatter_alike),
        cmocka_unit_test(eyes_look_through_alike),
        cmocka_unit_test(waves_are_cut_alike),
    };
    device = test_device_open_as(
        &(clast_gpu_desc){.software = true, .hardware = true, .validate = true, .ray_tracing = true});
    through_driver = clast_gpu_features_of(device.gpu)->ray_tracing;
    int failed = 0;
    if (through_driver) {
        failed = cmocka_run_group_tests_name("pictures by the driver's structures", tests, NULL, NULL);
    } else {
        fprintf(stderr, "left out: %s has no ray tracing\n", clast_gpu_features_of(device.gpu)->name);
    }
    return test_device_close(&device) ? failed : 1;
}

int main(void)
{
    test_device_progress.progress = go_on;
    int failed = run_all();
    return failed + run_through_driver();
}
