// SPDX-License-Identifier: Apache-2.0
// What the path tracer gives, against what can be computed by hand.
#include "picture.h"

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1}, ORIGIN = {0, 0, 0};

static void an_empty_scene_shows_its_surroundings(void **state)
{
    picture p = picture_open(*state, 8, 4);
    picture_surround(&p, 0.75f);
    picture_look(&p, Z * 5.0f, ORIGIN, 0.5f);
    const float *pixels = picture_render(&p);
    for (int i = 0; i < 8 * 8 * 3; i++) {
        assert_near(pixels[i], 0.75, 1e-6);
    }
    picture_close(&p);
}

// A white sphere in white surroundings cannot be told from them, but for what the model loses.
static void a_white_sphere_in_a_furnace_vanishes(void **state)
{
    const float materials[][2] = {{0.0f, 1.0f}, {0.0f, 0.3f}, {1.0f, 1.0f}, {1.0f, 0.5f}, {1.0f, 0.1f}, {0.5f, 0.5f}};
    for (size_t i = 0; i < sizeof materials / sizeof materials[0]; i++) {
        picture p = picture_open(*state, 24, 64);
        p.settings.bounces = 16;
        picture_surround(&p, 1.0f);
        picture_add_sphere(&p, ORIGIN, 1.0f, 64, picture_material(&p, 1.0f, materials[i][0], materials[i][1], 0.0f));
        picture_look(&p, Z * 3.0f, ORIGIN, 0.5f); // the sphere fills the picture
        picture_render(&p);
        double mean = picture_mean(&p);
        if (!(mean > 0.97 && mean < 1.02)) {
            fail_msg("metallic %g roughness %g: %g", (double)materials[i][0], (double)materials[i][1], mean);
        }
        picture_close(&p);
    }
}

static double lit_by(clast_context *context, const clast_light_desc *light)
{
    picture p = picture_open(context, 4, 1);
    p.settings.bounces = 1;
    uint32_t number;
    assert_ok(context, clast_scene_add_light(p.scene, light, NULL, &number));
    picture_add_square(&p, ORIGIN, X, Y, picture_material(&p, 0.5f, 0.0f, 1.0f, 0.0f));
    picture_look(&p, vec3(1.0f, 0.0f, 4.0f), ORIGIN, 0.01f);
    picture_render(&p);
    double value = (double)picture_pixel(&p, 2, 2)[1];
    picture_close(&p);
    return value;
}

// Radiance is albedo / pi times irradiance, nearly: the specular layer takes and gives a little.
static void punctual_lights_light_by_their_units(void **state)
{
    const double pi = 3.14159265358979;
    clast_light_desc light = {.type = CLAST_LIGHT_POINT,
                              .position = {0, 0, 2},
                              .direction = {0, 0, -1},
                              .colour = {1, 1, 1},
                              .intensity = 8.0f};
    double expected = 0.5 / pi * 8.0 / 4.0;
    assert_near(lit_by(*state, &light) / expected, 1.0, 0.06);
    light.position[2] = 4.0f;
    assert_near(lit_by(*state, &light) / expected, 0.25, 0.015);
    light.range = 4.0f; // the window ends there
    assert_near(lit_by(*state, &light), 0.0, 1e-6);
    light.type = CLAST_LIGHT_DIRECTIONAL;
    assert_near(lit_by(*state, &light) / (0.5 / pi * 8.0), 1.0, 0.06);
    light.direction[0] = 1.0f; // 45 degrees
    assert_near(lit_by(*state, &light) / (0.5 / pi * 8.0), 0.7071, 0.06);
    light.direction[0] = 0.0f;
    light.direction[2] = 1.0f; // from behind
    assert_near(lit_by(*state, &light), 0.0, 0.0);
}

static void a_spot_light_ends_at_its_cone(void **state)
{
    clast_light_desc light = {.type = CLAST_LIGHT_SPOT,
                              .position = {0, 0, 2},
                              .direction = {0, 0, -1},
                              .colour = {1, 1, 1},
                              .intensity = 8.0f,
                              .inner_angle = 0.2f,
                              .outer_angle = 0.4f};
    double middle = lit_by(*state, &light);
    assert_near(middle, 0.5 / 3.14159 * 2.0, 0.02);
    light.direction[0] = 0.3f; // 0.29 radians off
    double side = lit_by(*state, &light);
    assert_true(side > 0.05 * middle && side < 0.8 * middle);
    light.direction[0] = 0.6f; // outside
    assert_near(lit_by(*state, &light), 0.0, 1e-6);
}

// A lamp over a floor: light samples and followed directions must agree, and with the integral.
static double lamp_over_floor(clast_context *context, float distance, float half_side)
{
    picture p = picture_open(context, 4, 1024);
    p.settings.bounces = 1;
    picture_add_square(&p, ORIGIN, X * 4.0f, Y * 4.0f, picture_material(&p, 0.5f, 0.0f, 1.0f, 0.0f));
    picture_add_square(&p, Z * distance, X * half_side, Y * -half_side, picture_material(&p, 0.0f, 0.0f, 1.0f, 5.0f));
    picture_look(&p, vec3(2.0f, 0.0f, 1.6f), ORIGIN, 0.001f);
    picture_render(&p);
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

static double square_irradiance(double distance, double half_side)
{
    enum { N = 400 };
    double sum = 0.0, cell = 2.0 * half_side / N;
    for (int i = 0; i < N * N; i++) {
        double x = ((i % N) + 0.5) * cell - half_side, y = ((i / N) + 0.5) * cell - half_side,
               square = x * x + y * y + distance * distance;
        sum += distance * distance / (square * square) * cell * cell;
    }
    return sum;
}

static void an_area_light_gives_its_integral_near_and_far(void **state)
{
    double near = lamp_over_floor(*state, 0.5f, 0.5f), far = lamp_over_floor(*state, 2.0f, 0.25f);
    double expected_near = 5.0 * 0.5 / 3.14159265 * square_irradiance(0.5, 0.5),
           expected_far = 5.0 * 0.5 / 3.14159265 * square_irradiance(2.0, 0.25);
    assert_near(near / expected_near, 1.0, 0.06);
    assert_near(far / expected_far, 1.0, 0.06);
}

// The same light as triangles that are known, and as a surface of another kind that is only found by chance, agree.
static void sampled_lights_agree_with_chance(void **state)
{
    double means[2];
    for (int known = 0; known < 2; known++) {
        picture p = picture_open(*state, 8, 2048);
        p.settings.bounces = 1;
        picture_add_square(&p, ORIGIN, X, Y, picture_material(&p, 0.7f, 0.3f, 0.4f, 0.0f));
        picture_add_square(&p, vec3(0.0f, 1.0f, 1.0f), X, normalize3(vec3(0.0f, 1.0f, -1.0f)),
                           picture_material(&p, 0.0f, 0.0f, 1.0f, 2.0f));
        picture_look(&p, vec3(0.0f, -2.0f, 2.0f), ORIGIN, 0.4f);
        picture_build(&p);
        if (!known) {
            p.frame->emitter_count = 0;
        }
        const clast_view colour = CLAST_VIEW_COLOUR;
        assert_ok(p.context, picture_try(&p, &colour, 1));
        means[known] = picture_mean(&p);
        picture_close(&p);
    }
    assert_near(means[1] / means[0], 1.0, 0.02);
}

static void russian_roulette_does_not_change_the_mean(void **state)
{
    // In a closed room of albedo a that shines by e, radiance is e / (1 - a).
    picture p = picture_open(*state, 8, 256);
    p.settings.bounces = 64;
    picture_add_sphere(&p, ORIGIN, 10.0f, 64, picture_material(&p, 0.5f, 0.0f, 1.0f, 1.0f));
    picture_look(&p, ORIGIN, Z, 1.0f);
    picture_render(&p);
    assert_near(picture_mean(&p), 2.0, 0.1);
    picture_close(&p);
}

static void few_bounces_end_the_series_early(void **state)
{
    picture p = picture_open(*state, 8, 256);
    p.settings.bounces = 1;
    picture_add_sphere(&p, ORIGIN, 10.0f, 64, picture_material(&p, 0.5f, 0.0f, 1.0f, 1.0f));
    picture_look(&p, ORIGIN, Z, 1.0f);
    picture_render(&p);
    assert_near(picture_mean(&p), 1.5, 0.05);
    picture_close(&p);
}

// A lit plane and a closed sphere: no pixel may be dark by hitting its own surface, whatever the size of the scene or its
// distance from the origin.
static void size_and_place_do_not_make_speckles(void **state)
{
    const float sizes[] = {1e-3f, 1.0f, 1e3f, 1e6f};
    const float places[] = {0.0f, 100.0f};
    for (size_t s = 0; s < 4; s++) {
        for (size_t o = 0; o < 2; o++) {
            float size = sizes[s];
            vec3 centre = vec3(places[o], places[o] * 0.3f, places[o] * -0.7f) * size;
            picture p = picture_open(*state, 32, 16);
            p.settings.bounces = 32;
            picture_surround(&p, 1.0f);
            picture_add_sphere(&p, centre, size, 48, picture_material(&p, 1.0f, 0.0f, 1.0f, 0.0f));
            picture_add_square(&p, centre - Y * (size * 1.3f), Z * size * 40.0f, X * size * 40.0f,
                               picture_material(&p, 1.0f, 0.0f, 1.0f, 0.0f));
            picture_look(&p, centre + vec3(0.3f, 0.5f, 3.0f) * size, centre, 0.8f);
            picture_render(&p);
            for (uint32_t i = 0; i < 32 * 32; i++) {
                float value = picture_pixel(&p, i % 32, i / 32)[1];
                if (!(value > 0.7f && value < 1.5f)) {
                    fail_msg("size %g, place %g, pixel %u, %u: %g", (double)size, (double)places[o], i % 32, i / 32,
                             (double)value);
                }
            }
            picture_close(&p);
        }
    }
}

// Likewise where the transform, not the mesh, makes the size.
static void scaled_instances_do_not_make_speckles(void **state)
{
    const float scales[] = {1e-5f, 1e5f};
    for (size_t s = 0; s < 2; s++) {
        float scale = scales[s];
        picture p = picture_open(*state, 32, 16);
        p.settings.bounces = 32;
        picture_surround(&p, 1.0f);
        shape sphere = shape_sphere(48, 24);
        for (uint32_t i = 0; i < sphere.mesh.vertex_count * 3; i++) {
            sphere.positions[i] = (sphere.positions[i] + 3.0f) / scale;
        }
        uint32_t geometry;
        sphere.mesh.material = picture_material(&p, 1.0f, 0.0f, 1.0f, 0.0f);
        assert_ok(p.context, clast_scene_add_mesh(p.scene, &sphere.mesh, "far", &geometry));
        shape_free(&sphere);
        shape_add_instance(p.context, p.scene, geometry, -3.0f, -3.0f, -3.0f, scale);
        picture_look(&p, Z * 2.5f, ORIGIN, 0.5f);
        picture_render(&p);
        for (uint32_t i = 0; i < 32 * 32; i++) {
            assert_true(picture_pixel(&p, i % 32, i / 32)[1] > 0.8f);
        }
        picture_close(&p);
    }
}

static void a_closed_room_lets_no_light_in(void **state)
{
    picture p = picture_open(*state, 16, 64);
    picture_surround(&p, 100.0f);
    picture_add_sphere(&p, ORIGIN, 2.0f, 64, picture_material(&p, 0.8f, 0.0f, 0.5f, 0.0f));
    picture_look(&p, ORIGIN, Z, 1.5f);
    picture_render(&p);
    assert_near(picture_mean(&p), 0.0, 0.0);
    picture_close(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(an_empty_scene_shows_its_surroundings),
        CONTEXT_TEST(a_white_sphere_in_a_furnace_vanishes),
        CONTEXT_TEST(punctual_lights_light_by_their_units),
        CONTEXT_TEST(a_spot_light_ends_at_its_cone),
        CONTEXT_TEST(an_area_light_gives_its_integral_near_and_far),
        CONTEXT_TEST(sampled_lights_agree_with_chance),
        CONTEXT_TEST(russian_roulette_does_not_change_the_mean),
        CONTEXT_TEST(few_bounces_end_the_series_early),
        CONTEXT_TEST(size_and_place_do_not_make_speckles),
        CONTEXT_TEST(scaled_instances_do_not_make_speckles),
        CONTEXT_TEST(a_closed_room_lets_no_light_in),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
