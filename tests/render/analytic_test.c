// SPDX-License-Identifier: Apache-2.0
// The path tracer against formulas of optics: light of spheres, squares and the sun's disc, blur of a thin lens, absorption, and
// white spheres of every material in white surroundings.
#include "picture.h"

#include "render/sky.h"

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1}, ORIGIN = {0, 0, 0};
static const double TURN = 6.283185307179586;

static uint32_t add_material(picture *p, const clast_material_desc *desc)
{
    uint32_t number;
    assert_ok(p->context, clast_scene_add_material(p->scene, desc, NULL, &number));
    return number;
}

// Lambert's law and nothing else.
static uint32_t add_chalk(picture *p, float grey)
{
    clast_material_desc desc = clast_material_defaults();
    desc.base_colour[0] = desc.base_colour[1] = desc.base_colour[2] = grey;
    desc.specular = 0.0f;
    return add_material(p, &desc);
}

// --------------------------------------------------------------------------------------------------------------- lights

// A sphere of radiance L and radius r, seen at distance d in a direction of cosine c with the normal: E = pi L (r / d)^2 c.
static void a_sphere_lights_as_its_solid_angle_says(void **state)
{
    const vec3 places[] = {{0, 0, 3}, {2, 1, 2}, {-3, 0, 1}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        picture p = picture_open(*state, 4, 1024);
        p.settings.bounces = 1;
        picture_add_square(&p, ORIGIN, X * 0.1f, Y * 0.1f, add_chalk(&p, 0.8f));
        picture_add_sphere(&p, places[i], 0.6f, 96, picture_material(&p, 0.0f, 0.0f, 1.0f, 5.0f));
        picture_look(&p, vec3(0.5f, -2.0f, 1.0f), ORIGIN, 1e-3f);
        picture_render(&p);
        double square = (double)dot3(places[i], places[i]), cosine = (double)places[i][2] / sqrt(square);
        double irradiance = 0.5 * TURN * 5.0 * 0.36 / square * cosine;
        assert_near(picture_mean(&p) / (0.8 / (0.5 * TURN) * irradiance), 1.0, 0.01);
        picture_close(&p);
    }
}

// Lambert's formula for a polygon: E = L / 2 times the sum over its edges of the angle that an edge subtends, times the cosine
// between the normal and that of the plane through the edge and the point.
static double polygon_irradiance(const vec3 *corners, size_t count, double radiance, vec3 normal)
{
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        vec3 a = normalize3(corners[i]), b = normalize3(corners[(i + 1) % count]);
        vec3 across = normalize3(cross3(a, b));
        sum += acos((double)clamp1(dot3(a, b), -1.0f, 1.0f)) * (double)dot3(across, normal);
    }
    return 0.5 * radiance * fabs(sum);
}

static void a_square_lights_as_lambert_says(void **state)
{
    const vec3 centres[] = {{0, 0, 0.5f}, {1, 1, 1}, {0, 2, 3}};
    for (size_t i = 0; i < sizeof centres / sizeof *centres; i++) {
        picture p = picture_open(*state, 4, 1024);
        p.settings.bounces = 1;
        vec3 right = normalize3(vec3(1.0f, 0.2f, 0.0f)) * 0.6f, up = normalize3(vec3(-0.2f, 1.0f, 0.0f)) * -0.4f;
        picture_add_square(&p, ORIGIN, X * 0.1f, Y * 0.1f, add_chalk(&p, 0.8f));
        picture_add_square(&p, centres[i], right, up, picture_material(&p, 0.0f, 0.0f, 1.0f, 5.0f));
        picture_look(&p, vec3(2.0f, -2.0f, 0.4f), ORIGIN, 1e-3f);
        picture_render(&p);
        vec3 corners[4] = {centres[i] - right - up, centres[i] + right - up, centres[i] + right + up,
                           centres[i] - right + up};
        double irradiance = polygon_irradiance(corners, 4, 5.0, Z);
        assert_near(picture_mean(&p) / (0.8 / (0.5 * TURN) * irradiance), 1.0, 0.01);
        picture_close(&p);
    }
}

// --------------------------------------------------------------------------------------------------------------- the sun

static const float SUN_SIZE = 0.05f;
static const vec3 SUN = {0.0f, 0.8f, 0.6f};

static void set_sky(picture *p)
{
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.0f, 0.8f, 0.6f}, .sun_size = SUN_SIZE};
    assert_ok(p->context, clast_scene_set_environment(p->scene, &sky));
}

static vec3 sun_irradiance(clast_context *context)
{
    clast_sky sky = {0};
    assert_ok(context, clast_sky_create(context, SUN, 2.5f, &sky));
    vec3 irradiance = sky.sun_irradiance;
    clast_sky_destroy(context, &sky);
    return irradiance;
}

// What a floor shows at a place along z, behind a wall above x = 0 whose edge is at height 1 over z = 0. `lit`: without the wall.
static double floor_at(clast_context *context, float z, bool lit, bool shaded)
{
    picture p = picture_open(context, 4, 512);
    p.settings.bounces = 1;
    set_sky(&p);
    picture_add_square(&p, ORIGIN, Z * 20.0f, X * 20.0f, add_chalk(&p, 0.8f));
    if (!lit) {
        // A plate square to the sun whose edge, through (0, 0.8, 0.6), hides the sun from z = 0 on.
        vec3 down = vec3(0.0f, 0.6f, -0.8f);
        float half = shaded ? 0.12f : 0.06f;
        vec3 centre = SUN + down * (shaded ? 0.0f : half);
        picture_add_square(&p, centre, X * 0.12f, down * half, add_chalk(&p, 0.0f));
    }
    picture_look(&p, vec3(3.0f, 1.5f, z), vec3(0.0f, 0.0f, z), 1e-4f);
    picture_render(&p);
    double mean = picture_mean(&p);
    picture_close(&p);
    return mean;
}

// The sun's irradiance on a floor, and what its disc sends through a window that it fills a part of.
static void the_suns_disc_lights_by_its_irradiance(void **state)
{
    vec3 irradiance = sun_irradiance(*state);
    double mean = (double)(irradiance[0] + irradiance[1] + irradiance[2]) / 3.0;
    double sun = floor_at(*state, 0.0f, true, false) - floor_at(*state, 0.0f, false, true);
    // The plate hides some of the sky around the sun as well: a hundredth.
    assert_near(sun / (0.8 / (0.5 * TURN) * mean * (double)SUN[1]), 1.0, 0.03);
    picture p = picture_open(*state, 64, 64);
    set_sky(&p);
    float angle = 3.0f * SUN_SIZE;
    picture_look(&p, ORIGIN, SUN, angle);
    picture_render(&p);
    double side = 2.0 * tan(0.5 * (double)angle);
    double through = picture_mean(&p) * side * side;
    assert_near(through / mean, 1.0, 0.03); // with the sky behind
    picture_close(&p);
}

// Half of a disc is hidden by an edge through its middle, nothing and all at one radius to either side.
static void shadows_of_the_sun_are_as_soft_as_its_disc_is_wide(void **state)
{
    double lit = floor_at(*state, 0.0f, true, false), shaded = floor_at(*state, 0.0f, false, true);
    double middle = (floor_at(*state, 0.0f, false, false) - shaded) / (lit - shaded);
    assert_near(middle, 0.5, 0.02);
    float radius = SUN_SIZE / SUN[1]; // on the floor, along z, from a distance of one
    double inner = (floor_at(*state, -1.05f * radius, false, false) - shaded) / (lit - shaded);
    double outer = (floor_at(*state, 1.05f * radius, false, false) - shaded) / (lit - shaded);
    double quarter = (floor_at(*state, 0.5f * radius, false, false) - shaded) / (lit - shaded);
    assert_near(fmin(inner, outer), 0.0, 0.02);
    assert_near(fmax(inner, outer), 1.0, 0.02);
    // A disc's part beyond a line at half its radius is 0.1955, of one that is darker at its edge less.
    assert_true(fmin(quarter, 1.0 - quarter) > 0.12 && fmin(quarter, 1.0 - quarter) < 0.2);
}

// ------------------------------------------------------------------------------------------------------------- the lens

static const float LENS_SPOT = 0.02f; // half the side of what is looked at

// A point at distance d, through a lens of diameter A that is focused on f, is a disc of diameter A |d - f| / d where it is sharp.
static double blur_square(clast_context *context, float distance)
{
    enum { SIZE = 64 };
    const float focus = 4.0f, aperture = 0.5f, angle = 0.4f;
    picture p = picture_open(context, SIZE, 1024);
    picture_add_square(&p, Z * -distance, X * LENS_SPOT, Y * LENS_SPOT, picture_material(&p, 0.0f, 0.0f, 1.0f, 1e4f));
    clast_camera_desc camera = {.vertical_angle = angle, .target = {0, 0, -1}, .aperture = aperture, .focus = focus};
    uint32_t number;
    assert_ok(context, clast_scene_add_camera(p.scene, &camera, NULL, &number));
    picture_render(&p);
    double sum = 0.0, moment = 0.0, pixel = 2.0 * tan(0.5 * (double)angle) * (double)focus / SIZE;
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        double value = (double)picture_pixel(&p, i % SIZE, i / SIZE)[1];
        double x = (i % SIZE + 0.5 - SIZE / 2) * pixel, y = (i / SIZE + 0.5 - SIZE / 2) * pixel;
        sum += value;
        moment += value * (x * x + y * y);
    }
    picture_close(&p);
    double spot = (double)LENS_SPOT * 4.0 / (double)distance;
    return 2.0 * moment / sum -
           spot * spot * 4.0 / 3.0; // of an even disc the square of its radius, without the spot's own
}

static void a_lens_blurs_as_its_equation_says(void **state)
{
    const float distances[] = {2.0f, 3.0f, 6.0f, 12.0f};
    double sharp = blur_square(*state, 4.0f); // that of a pixel's filter
    assert_true(sharp < 0.001);
    for (size_t i = 0; i < sizeof distances / sizeof *distances; i++) {
        double expected = 0.5 * 0.5 * fabs((double)distances[i] - 4.0) / (double)distances[i];
        assert_near(sqrt(blur_square(*state, distances[i]) - sharp) / expected, 1.0, 0.02);
    }
}

// --------------------------------------------------------------------------------------------------------------- glass

// A slab of clear glass before white surroundings.
static void look_through_slab(clast_context *context, float ior, float thickness, vec3 from, double colour[3])
{
    picture p = picture_open(context, 4, 1024);
    p.settings.bounces = 32;
    picture_surround(&p, 1.0f);
    clast_material_desc desc = clast_material_defaults();
    desc.base_colour[0] = desc.base_colour[1] = desc.base_colour[2] = 1.0f;
    desc.roughness = 0.0f;
    desc.transmission = 1.0f;
    desc.thickness = 1.0f;
    desc.ior = ior;
    desc.attenuation_distance = 2.0f;
    desc.attenuation_colour[0] = 0.25f;
    desc.attenuation_colour[1] = 0.5f;
    uint32_t glass = add_material(&p, &desc);
    float half = 0.5f * thickness;
    picture_add_square(&p, Z * half, X * 1000.0f, Y * 1000.0f, glass);
    picture_add_square(&p, Z * -half, X * 1000.0f, Y * -1000.0f, glass);
    picture_look(&p, from, ORIGIN, 1e-3f);
    picture_render(&p);
    for (int c = 0; c < 3; c++) {
        colour[c] = 0.0;
        for (uint32_t i = 0; i < 16; i++) {
            colour[c] += (double)picture_pixel(&p, i % 4, i / 4)[c] / 16.0;
        }
    }
    picture_close(&p);
}

// Beer and Lambert: of light that goes a length, colour^(length / distance) is left. Where glass is as dense as air, there is
// nothing else.
static void volumes_absorb_by_length(void **state)
{
    const double colours[3] = {0.25, 0.5, 1.0};
    const vec3 ways[] = {{0, 0, 5}, {3, 0, 4}, {0, 4, 3}};
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        double colour[3], thickness = 1.5, length = thickness * 5.0 / (double)ways[i][2];
        look_through_slab(*state, 1.0f, (float)thickness, ways[i], colour);
        for (int c = 0; c < 3; c++) {
            assert_near(colour[c], pow(colours[c], length / 2.0), 0.01);
        }
    }
}

// What both sides reflect, again and again, is added up.
static void slabs_reflect_and_pass_by_fresnel_and_absorption(void **state)
{
    double colour[3], thickness = 1.0;
    look_through_slab(*state, 1.5f, (float)thickness, Z * 5.0f, colour);
    const double colours[3] = {0.25, 0.5, 1.0}, r = 0.04;
    for (int c = 0; c < 3; c++) {
        double once = pow(colours[c], thickness / 2.0), back = 1.0 - r * r * once * once;
        double passed = (1.0 - r) * (1.0 - r) * once / back,
               reflected = r + (1.0 - r) * (1.0 - r) * r * once * once / back;
        assert_near(colour[c], passed + reflected, 0.01);
    }
}

// ------------------------------------------------------------------------------------------------------------- furnaces

typedef struct furnace_case {
    const char *name;
    void (*set)(clast_material_desc *desc);
} furnace_case;

static void set_rough_metal(clast_material_desc *d)
{
    d->metallic = 1.0f;
}

static void set_smooth_metal(clast_material_desc *d)
{
    d->metallic = 1.0f;
    d->roughness = 0.1f;
}

static void set_dielectric(clast_material_desc *d)
{
    d->roughness = 0.3f;
}

static void set_dense_dielectric(clast_material_desc *d)
{
    d->ior = 2.4f;
}

static void set_stretched(clast_material_desc *d)
{
    d->metallic = 1.0f;
    d->roughness = 0.3f;
    d->anisotropy = 0.6f;
}

static void set_coated(clast_material_desc *d)
{
    d->clearcoat = 1.0f;
    d->clearcoat_roughness = 0.2f;
}

static void set_fuzzy(clast_material_desc *d)
{
    d->sheen_colour[0] = d->sheen_colour[1] = d->sheen_colour[2] = 1.0f;
    d->sheen_roughness = 0.4f;
}

static void set_smooth_glass(clast_material_desc *d)
{
    d->roughness = 0.0f;
    d->transmission = 1.0f;
    d->thickness = 1.0f;
}

static void set_rough_glass(clast_material_desc *d)
{
    set_smooth_glass(d);
    d->roughness = 0.5f;
}

static void set_dispersing_glass(clast_material_desc *d)
{
    set_rough_glass(d);
    d->roughness = 0.2f;
    d->dispersion = 4.0f;
}

static void set_filmed_glass(clast_material_desc *d)
{
    set_smooth_glass(d);
    d->iridescence = 1.0f;
}

static void set_thin_glass(clast_material_desc *d)
{
    d->roughness = 0.3f;
    d->transmission = 1.0f;
}

static void set_leaf(clast_material_desc *d)
{
    d->diffuse_transmission = 0.7f;
}

// A white sphere in white surroundings cannot be told from them.
static void white_spheres_of_all_materials_vanish(void **state)
{
    const furnace_case cases[] = {
        {"rough metal", set_rough_metal},
        {"smooth metal", set_smooth_metal},
        {"dielectric", set_dielectric},
        {"dense dielectric", set_dense_dielectric},
        {"stretched", set_stretched},
        {"coated", set_coated},
        {"fuzzy", set_fuzzy},
        {"smooth glass", set_smooth_glass},
        {"rough glass", set_rough_glass},
        {"dispersing glass", set_dispersing_glass},
        {"filmed glass", set_filmed_glass},
        {"thin glass", set_thin_glass},
        {"leaf", set_leaf},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        picture p = picture_open(*state, 16, 144);
        p.settings.bounces = 64;
        picture_surround(&p, 1.0f);
        clast_material_desc desc = clast_material_defaults();
        desc.base_colour[0] = desc.base_colour[1] = desc.base_colour[2] = 1.0f;
        cases[i].set(&desc);
        picture_add_sphere(&p, ORIGIN, 1.0f, 128, add_material(&p, &desc));
        picture_look(&p, Z * 3.0f, ORIGIN, 0.5f);
        picture_render(&p);
        double mean = picture_mean(&p);
        if (!(fabs(mean - 1.0) < 0.01)) {
            fail_msg("%s: %g", cases[i].name, mean);
        }
        picture_close(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_sphere_lights_as_its_solid_angle_says),
        CONTEXT_TEST(a_square_lights_as_lambert_says),
        CONTEXT_TEST(the_suns_disc_lights_by_its_irradiance),
        CONTEXT_TEST(shadows_of_the_sun_are_as_soft_as_its_disc_is_wide),
        CONTEXT_TEST(a_lens_blurs_as_its_equation_says),
        CONTEXT_TEST(volumes_absorb_by_length),
        CONTEXT_TEST(slabs_reflect_and_pass_by_fresnel_and_absorption),
        CONTEXT_TEST(white_spheres_of_all_materials_vanish),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
