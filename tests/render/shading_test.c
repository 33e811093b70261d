// SPDX-License-Identifier: Apache-2.0
// Coarse spheres with smooth normals beside fine ones: where light grazes them, and at their rims, no facet turns black.
#include "picture.h"

enum { SIZE = 64, COARSE = 32, FINE = 192 };

static const vec3 Z = {0, 0, 1}, ORIGIN = {0, 0, 0};

typedef struct surroundings {
    float radiance; // of all sides
    float sun;      // of a light that grazes the sphere as it is seen
} surroundings;

static picture sphere_in(clast_context *context, uint32_t columns, float metallic, float roughness, surroundings around)
{
    picture p = picture_open(context, SIZE, 32);
    p.settings.bounces = 4;
    if (around.radiance > 0.0f) {
        picture_surround(&p, around.radiance);
    }
    if (around.sun > 0.0f) {
        clast_light_desc light = {.type = CLAST_LIGHT_DIRECTIONAL,
                                  .direction = {-1.0f, -0.3f, -0.15f},
                                  .colour = {1, 1, 1},
                                  .intensity = around.sun};
        uint32_t number;
        assert_ok(context, clast_scene_add_light(p.scene, &light, NULL, &number));
    }
    picture_add_sphere(&p, ORIGIN, 1.0f, columns, picture_material(&p, 0.8f, metallic, roughness, 0.0f));
    picture_look(&p, Z * 5.0f, ORIGIN, 0.45f);
    picture_render(&p);
    return p;
}

// Within what both spheres cover.
static bool covered(uint32_t x, uint32_t y)
{
    float across = ((float)x + 0.5f) / SIZE - 0.5f, down = ((float)y + 0.5f) / SIZE - 0.5f;
    return across * across + down * down < 0.39f * 0.39f;
}

// `most` is how much darker a pixel of the coarse sphere may be than the fine one's, in parts of it where that is bright, and of
// a tenth where it is dark.
static void compare(clast_context *context, const char *name, float metallic, float roughness, surroundings around,
                    double most)
{
    picture coarse = sphere_in(context, COARSE, metallic, roughness, around),
            fine = sphere_in(context, FINE, metallic, roughness, around);
    double sums[2] = {0.0, 0.0}, worst = 0.0;
    for (uint32_t i = 0; i < SIZE * SIZE; i++) {
        if (covered(i % SIZE, i / SIZE)) {
            double a = (double)picture_pixel(&coarse, i % SIZE, i / SIZE)[1],
                   b = (double)picture_pixel(&fine, i % SIZE, i / SIZE)[1];
            sums[0] += fmin(a, 1.5);
            sums[1] += fmin(b, 1.5);
            worst = fmax(worst, (b - a) / fmax(b, 0.1));
        }
    }
    print_message("%s: mean %.4f of the fine sphere's; a pixel is up to %.2f darker\n", name, sums[0] / sums[1], worst);
    assert_near(sums[0] / sums[1], 1.0, 0.03);
    assert_true(worst < most);
    picture_close(&coarse);
    picture_close(&fine);
}

static void grazing_light_leaves_no_black_facets(void **state)
{
    compare(*state, "chalk in the sun", 0.0f, 1.0f, (surroundings){0.0f, 3.0f}, 0.75);
    compare(*state, "chalk in shade and sun", 0.0f, 1.0f, (surroundings){0.1f, 3.0f}, 0.5);
    compare(*state, "glossy paint", 0.0f, 0.4f, (surroundings){0.1f, 3.0f}, 0.6);
}

static void rims_of_shining_spheres_are_not_black(void **state)
{
    compare(*state, "metal", 1.0f, 0.3f, (surroundings){1.0f, 0.0f}, 0.2);
    compare(*state, "smooth metal", 1.0f, 0.0f, (surroundings){1.0f, 0.0f}, 0.2);
    compare(*state, "paint", 0.0f, 0.3f, (surroundings){1.0f, 0.0f}, 0.2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(grazing_light_leaves_no_black_facets),
        CONTEXT_TEST(rims_of_shining_spheres_are_not_black),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
