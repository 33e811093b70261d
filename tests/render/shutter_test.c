// SPDX-License-Identifier: Apache-2.0
// Pictures of what moves while the shutter is open.
#include "picture.h"

#include "clast/animation.h"
#include "render/shutter.h"

enum { SIZE = 48, STEPS = 16, SAMPLES = 64 };

static clast_context *context;

// A square that shines, from x - 0.5 to x + 0.5; x goes from -1 to 1 within a second, by its node or by a morph target.
static picture open_scene(bool morphs)
{
    picture p = picture_open(context, SIZE, SAMPLES);
    p.settings.shutter_steps = STEPS;
    uint32_t node, number;
    uint32_t instance = picture_add_square(&p, vec3(morphs ? -1 : 0, 0, 0), vec3(0.5f, 0, 0), vec3(0, 0.5f, 0),
                                           picture_material(&p, 0, 0, 1, 1));
    assert_ok(context, clast_scene_add_node(p.scene, &(clast_node_desc){.parent = CLAST_NONE}, NULL, &node));
    const float times[] = {0, 1, 2}, places[] = {-1, 0, 0, 1, 0, 0, 1, 0, 0}, weights[] = {0, 1, 1}, rest = 0;
    clast_channel channel = {node, CLAST_ANIMATED_TRANSLATION, CLAST_INTERPOLATION_LINEAR, 3, times, places};
    if (morphs) {
        const float across[] = {2, 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0};
        const clast_morph_target target = {.positions = across};
        assert_ok(context, clast_scene_set_node_weights(p.scene, node, &rest, 1));
        assert_ok(context, clast_scene_set_mesh_morph(p.scene, 0, &target, 1, node));
        channel = (clast_channel){node, CLAST_ANIMATED_WEIGHTS, CLAST_INTERPOLATION_LINEAR, 3, times, weights};
    } else {
        assert_ok(context, clast_scene_attach_instance(p.scene, instance, node));
    }
    assert_ok(context, clast_scene_add_animation(p.scene, &channel, 1, NULL, &number));
    picture_surround(&p, 0);
    picture_look(&p, vec3(0, 0, 2), vec3(0, 0, 0), 1.5707963f); // what is seen is 4 wide
    return p;
}

// The part of the second during which the square is at x.
static double part_of_time(double x)
{
    double from = fmax(0.0, (x + 0.5) / 2.0), to = fmin(1.0, (x + 1.5) / 2.0);
    return fmax(0.0, to - from);
}

static void blur_is_that_of_the_time_in_between(void **state)
{
    (void)state;
    for (int morphs = 0; morphs < 2; morphs++) {
        picture p = open_scene(morphs != 0);
        p.settings.shutter = 1.0;
        picture_render(&p);
        double sum = 0.0, expected = 0.0;
        for (uint32_t x = 0; x < SIZE; x++) {
            double place = ((double)x + 0.5) / SIZE * 4.0 - 2.0, value = (double)picture_pixel(&p, x, SIZE / 2)[0];
            assert_near(value, part_of_time(place), 1.0 / STEPS);
            sum += value;
            expected += part_of_time(place);
        }
        assert_near(sum, expected, 0.02 * expected);
        assert_true(p.frame->settings.time == 0.0); // as it was committed
        picture_close(&p);
    }
}

static void a_moment_is_a_picture_without_a_shutter(void **state)
{
    (void)state;
    picture p = open_scene(false);
    p.settings.shutter = 0.5;
    p.settings.shutter_steps = 1;
    picture_render(&p);
    picture q = open_scene(false);
    picture_build(&q);
    q.frame->settings.time = q.settings.time = 0.25; // the middle of the time
    assert_ok(context, clast_frame_run(q.frame, &clast_cpu_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL));
    const clast_view colour = CLAST_VIEW_COLOUR;
    assert_ok(context, picture_try(&q, &colour, 1));
    assert_memory_equal(p.pixels[colour], q.pixels[colour], SIZE * SIZE * 12);
    picture_close(&p);
    picture_close(&q);
}

// All bits are those of a picture without a shutter.
static void what_stands_still_is_not_blurred(void **state)
{
    (void)state;
    picture pictures[2];
    for (int i = 0; i < 2; i++) {
        picture p = picture_open(context, SIZE, 8);
        picture_add_sphere(&p, vec3(0, 0, 0), 1.0f, 12, picture_material(&p, 0.7f, 0, 0.5f, 0));
        picture_surround(&p, 1);
        picture_look(&p, vec3(0, 1, 4), vec3(0, 0, 0), 0.8f);
        p.settings.shutter_steps = 5;
        p.settings.shutter = i != 0 ? 3.0 : 0.0;
        picture_render(&p);
        pictures[i] = p;
    }
    assert_memory_equal(pictures[0].pixels[CLAST_VIEW_COLOUR], pictures[1].pixels[CLAST_VIEW_COLOUR], SIZE * SIZE * 12);
    picture_close(&pictures[0]);
    picture_close(&pictures[1]);
}

static void samples_are_shared_out_evenly(void **state)
{
    (void)state;
    const uint32_t counts[][2] = {{64, 16}, {10, 4}, {3, 16}, {1, 1}, {1048576, 65536}};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        clast_render_settings settings = {
            .spp = counts[i][0], .shutter_steps = counts[i][1], .shutter = 2.0, .time = 1.0};
        uint32_t moments = counts[i][0] < counts[i][1] ? counts[i][0] : counts[i][1], before = 0, run = 0;
        for (uint32_t sample = 0; sample < settings.spp; sample++) {
            uint32_t moment = clast_shutter_moment(&settings, sample);
            assert_true(moment == before || moment == before + 1);
            run = moment == before ? run + 1 : 1;
            assert_true(run <= (settings.spp + moments - 1) / moments);
            before = moment;
        }
        assert_int_equal(before, moments - 1);
        double first = clast_shutter_time(&settings, 0), last = clast_shutter_time(&settings, moments - 1);
        assert_near(first - 1.0, 3.0 - last, 1e-9);
    }
}

int main(void)
{
    if (clast_context_create(&(clast_context_desc){0}, &context) != CLAST_OK) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blur_is_that_of_the_time_in_between),
        cmocka_unit_test(a_moment_is_a_picture_without_a_shutter),
        cmocka_unit_test(what_stands_still_is_not_blurred),
        cmocka_unit_test(samples_are_shared_out_evenly),
    };
    int failed = cmocka_run_group_tests_name("the shutter", tests, NULL, NULL);
    clast_context_destroy(context);
    return failed;
}
