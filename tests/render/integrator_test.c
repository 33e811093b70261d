// SPDX-License-Identifier: Apache-2.0
// What cameras other than the usual one see, and what integrators show, in scenes of which that is known.
#include "picture.h"

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1}, ORIGIN = {0, 0, 0};

static void look_with(picture *p, const clast_camera_desc *camera)
{
    uint32_t number;
    assert_ok(p->context, clast_scene_add_camera(p->scene, camera, NULL, &number));
}

static const uint32_t *render_instances(picture *p)
{
    const clast_view instance = CLAST_VIEW_INSTANCE;
    picture_build(p);
    assert_ok(p->context, picture_try(p, &instance, 1));
    return p->pixels[CLAST_VIEW_INSTANCE];
}

// ------------------------------------------------------------------------------------------------------------- cameras

// Forward in the middle, right at three quarters, behind at both edges, up at the top.
static void a_panorama_shows_all_directions_where_they_are(void **state)
{
    enum { SIZE = 33 };
    picture p = picture_open(*state, SIZE, 1);
    uint32_t grey = picture_material(&p, 0.5f, 0.0f, 1.0f, 0.0f);
    uint32_t front = picture_add_square(&p, Z * -3.0f, X, Y, grey), back = picture_add_square(&p, Z * 3.0f, X, Y, grey);
    uint32_t right = picture_add_square(&p, X * 3.0f, Z, Y, grey), left = picture_add_square(&p, X * -3.0f, Z, Y, grey);
    uint32_t above = picture_add_square(&p, Y * 3.0f, X, Z, grey),
             below = picture_add_square(&p, Y * -3.0f, X, Z, grey);
    look_with(&p, &(clast_camera_desc){.projection = CLAST_PROJECTION_PANORAMA, .target = {0, 0, -1}});
    const uint32_t *seen = render_instances(&p);
    const uint32_t *middle = seen + SIZE / 2 * SIZE;
    assert_int_equal(middle[SIZE / 2], front);
    assert_int_equal(middle[SIZE * 3 / 4], right);
    assert_int_equal(middle[SIZE / 4], left);
    assert_int_equal(middle[0], back);
    assert_int_equal(middle[SIZE - 1], back);
    for (uint32_t x = 0; x < SIZE; x++) { // a row at a pole is one direction, nearly
        assert_int_equal(seen[x], above);
        assert_int_equal(seen[(SIZE - 1) * SIZE + x], below);
    }
    assert_int_equal(middle[SIZE * 5 / 8], CLAST_NONE); // between them
    picture_close(&p);
}

static uint32_t count_of(const uint32_t *seen, uint32_t pixels, uint32_t instance)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < pixels; i++) {
        count += seen[i] == instance;
    }
    return count;
}

// Things are as large far away as near: as the camera's height says.
static void an_orthographic_camera_does_not_make_far_things_small(void **state)
{
    enum { SIZE = 40 };
    picture p = picture_open(*state, SIZE, 1);
    uint32_t grey = picture_material(&p, 0.5f, 0.0f, 1.0f, 0.0f);
    uint32_t near = picture_add_square(&p, vec3(-1, 0, 4), X * 0.5f, Y, grey);
    uint32_t far = picture_add_square(&p, vec3(1, 0, -90), X * 0.5f, Y, grey);
    look_with(&p,
              &(clast_camera_desc){.projection = CLAST_PROJECTION_ORTHOGRAPHIC, .position = {0, 0, 5}, .height = 4.0f});
    const uint32_t *seen = render_instances(&p);
    assert_int_equal(count_of(seen, SIZE * SIZE, near), 10 * 20); // 1 x 2 of 4 x 4
    assert_int_equal(count_of(seen, SIZE * SIZE, far), 10 * 20);
    picture_close(&p);
}

// How many pixels the bright spot has that a small lamp becomes.
static uint32_t lit_pixels(clast_context *context, float distance, float focus)
{
    enum { SIZE = 48 };
    picture p = picture_open(context, SIZE, 64);
    picture_surround(&p, 0.0f);
    picture_add_square(&p, Z * -distance, X * (0.01f * distance), Y * (0.01f * distance),
                       picture_material(&p, 0.0f, 0.0f, 1.0f, 50.0f));
    look_with(&p, &(clast_camera_desc){.target = {0, 0, -1}, .vertical_angle = 0.6f, .aperture = 0.4f, .focus = focus});
    const float *pixels = picture_render(&p);
    uint32_t count = 0;
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        count += pixels[3 * i] > 0.0f;
    }
    picture_close(&p);
    return count;
}

// A point at distance d through a lens of diameter A that is focused on f is a disc of diameter A |1 / d - 1 / f| in a picture plane at
// distance one, here of 0.6187 and 48 pixels.
static void what_is_out_of_focus_becomes_a_disc(void **state)
{
    const double pi = 3.14159265358979, per_unit = 48.0 / 0.6187;
    uint32_t sharp = lit_pixels(*state, 4.0f, 4.0f);
    assert_true(sharp <= 25); // 1.6 pixels, and a filter of one around each
    for (int i = 0; i < 2; i++) {
        double distance = i == 0 ? 2.0 : 40.0, radius = 0.5 * 0.4 * fabs(1.0 / distance - 1.0 / 4.0) * per_unit;
        double found = sqrt(lit_pixels(*state, (float)distance, 4.0f) / pi);
        assert_true(found > radius && found < radius + 2.5); // the lamp's own size and the filter's
    }
}

// ----------------------------------------------------------------------------------------------------------- integrators

static double openness_at(clast_context *context, bool corner, float away, double most)
{
    picture p = picture_open(context, 8, 256);
    uint32_t grey = picture_material(&p, 0.2f, 0.0f, 1.0f, 0.0f);
    p.settings.integrator = CLAST_INTEGRATOR_AO;
    p.settings.ao_distance = most;
    picture_surround(&p, 7.0f); // light does not matter
    picture_add_square(&p, ORIGIN, Z * 1000.0f, X * 1000.0f, grey);
    if (corner) {
        picture_add_square(&p, Y * 1000.0f, Z * 1000.0f, Y * 1000.0f, grey);
    }
    picture_look(&p, vec3(away + 2.0f, 3.0f, 0.0f), vec3(away, 0, 0), 1e-4f);
    picture_render(&p);
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

static void openness_is_one_on_a_plane_and_a_half_in_a_corner(void **state)
{
    assert_near(openness_at(*state, false, 1.0f, 0.0), 1.0, 1e-5);
    assert_near(openness_at(*state, true, 0.01f, 0.0), 0.5, 0.01);
    assert_near(openness_at(*state, true, 1.0f, 0.5), 1.0, 1e-5); // the wall is too far away
    double near = openness_at(*state, true, 1.0f, 1.5), far = openness_at(*state, true, 1.0f, 0.0);
    assert_true(near > far + 0.05 && near < 0.95);
    assert_near(far, 0.5, 0.02); // a wall that is as high as the sky
}

// A floor under a roof, which no light reaches straight.
static double under_a_roof(clast_context *context, clast_integrator integrator)
{
    picture p = picture_open(context, 8, 256);
    uint32_t white = picture_material(&p, 0.9f, 0.0f, 1.0f, 0.0f), number;
    p.settings.integrator = integrator;
    clast_light_desc sun = {
        .type = CLAST_LIGHT_DIRECTIONAL, .direction = {0, -1, 0}, .colour = {1, 1, 1}, .intensity = 3};
    assert_ok(context, clast_scene_add_light(p.scene, &sun, NULL, &number));
    picture_add_square(&p, ORIGIN, Z * 10.0f, X * 10.0f, white);
    picture_add_square(&p, Y, Z * -2.0f, X * 2.0f, white);
    picture_look(&p, vec3(4.0f, 0.5f, 0.0f), vec3(1.0f, 0, 0), 0.01f);
    picture_render(&p);
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

static void direct_light_does_not_go_round_corners(void **state)
{
    assert_near(under_a_roof(*state, CLAST_INTEGRATOR_DIRECT), 0.0, 0.0);
    assert_true(under_a_roof(*state, CLAST_INTEGRATOR_PATH) > 0.01);
}

// And is all that paths of one bounce find.
static void direct_light_is_that_of_one_bounce(void **state)
{
    double means[2];
    for (int i = 0; i < 2; i++) {
        picture p = picture_open(*state, 16, 16);
        p.settings.integrator = i == 0 ? CLAST_INTEGRATOR_DIRECT : CLAST_INTEGRATOR_PATH;
        p.settings.bounces = i == 0 ? 8 : 1;
        picture_surround(&p, 0.3f);
        picture_add_sphere(&p, ORIGIN, 1.0f, 32, picture_material(&p, 0.8f, 0.5f, 0.4f, 0.1f));
        picture_look(&p, Z * 4.0f, ORIGIN, 0.5f);
        picture_render(&p);
        means[i] = picture_mean(&p);
        picture_close(&p);
    }
    assert_near(means[0], means[1], 0.0);
}

// Base colours times the cosine to the eye, and emission, whatever the light.
static void primary_is_lit_from_the_eye(void **state)
{
    for (int i = 0; i < 2; i++) {
        picture p = picture_open(*state, 8, 4);
        p.settings.integrator = CLAST_INTEGRATOR_PRIMARY;
        picture_surround(&p, i == 0 ? 5.0f : 0.0f);
        picture_add_square(&p, ORIGIN, X * 9.0f, Y * 9.0f,
                           picture_material(&p, 0.6f, 1.0f, 0.2f, i == 0 ? 0.0f : 0.25f));
        picture_look(&p, i == 0 ? vec3(0, 0, 3) : vec3(3.0f * sqrtf(3.0f), 0, 3), ORIGIN, 1e-3f);
        picture_render(&p);
        assert_near(picture_mean(&p), i == 0 ? 0.6 : 0.25 + 0.6 * 0.5, 1e-3);
        picture_close(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_panorama_shows_all_directions_where_they_are),
        CONTEXT_TEST(an_orthographic_camera_does_not_make_far_things_small),
        CONTEXT_TEST(what_is_out_of_focus_becomes_a_disc),
        CONTEXT_TEST(openness_is_one_on_a_plane_and_a_half_in_a_corner),
        CONTEXT_TEST(direct_light_does_not_go_round_corners),
        CONTEXT_TEST(direct_light_is_that_of_one_bounce),
        CONTEXT_TEST(primary_is_lit_from_the_eye),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
