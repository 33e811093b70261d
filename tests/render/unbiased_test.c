// SPDX-License-Identifier: Apache-2.0
// What a picture must not depend on: how its samples are shared out over renders, and how its meshes are cut.
#include "picture.h"

static const vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1};

// -------------------------------------------------------------------------------------------------------------- samples

enum { SIZE = 10, RENDERS = 64, FEW = 16 };

// A yard under a sky, with a lamp, glass, metal and a rough floor. The sun is wide: of a real one's light through glass, found by
// chance, 64 renders say too little of how much it spreads.
static picture yard(clast_context *context, uint32_t samples)
{
    picture p = picture_open(context, SIZE, samples);
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.3f, 0.6f, 0.5f}, .sun_size = 0.2f};
    assert_ok(context, clast_scene_set_environment(p.scene, &sky));
    clast_material_desc glass = clast_material_defaults();
    glass.roughness = 0.3f;
    glass.transmission = 1.0f;
    glass.thickness = 1.0f;
    uint32_t number;
    assert_ok(context, clast_scene_add_material(p.scene, &glass, NULL, &number));
    picture_add_square(&p, Y * -1.0f, X * 3.0f, Z * -3.0f, picture_material(&p, 0.6f, 0.0f, 0.7f, 0.0f));
    picture_add_square(&p, vec3(-1.5f, 0.0f, 0.0f), Z * -1.5f, Y * 1.0f, picture_material(&p, 0.7f, 0.0f, 1.0f, 0.0f));
    picture_add_square(&p, vec3(0.0f, 1.4f, -0.5f), X * 0.3f, Z * 0.3f, picture_material(&p, 0.5f, 0.0f, 1.0f, 20.0f));
    picture_add_sphere(&p, vec3(-0.6f, -0.4f, 0.0f), 0.6f, 32, number);
    picture_add_sphere(&p, vec3(0.7f, -0.5f, -0.2f), 0.5f, 32, picture_material(&p, 0.9f, 1.0f, 0.4f, 0.0f));
    picture_look(&p, vec3(0.2f, 0.3f, 4.0f), vec3(0.0f, -0.2f, 0.0f), 0.7f);
    picture_build(&p);
    return p;
}

static double render_mean(picture *p, uint32_t seed, uint32_t samples)
{
    const clast_view colour = CLAST_VIEW_COLOUR;
    p->settings.seed = seed;
    p->settings.spp = samples;
    assert_ok(p->context, picture_try(p, &colour, 1));
    return picture_mean(p);
}

// The mean of many short renders is that of a few long ones, as far as their own spread allows.
static void many_short_renders_are_a_long_one(void **state)
{
    picture p = yard(*state, FEW);
    double sum = 0.0, squares = 0.0, rest = 0.0, rest_squares = 0.0;
    for (uint32_t i = 0; i < RENDERS; i++) {
        double mean = render_mean(&p, 100 + i, FEW);
        sum += mean / RENDERS;
        squares += mean * mean / RENDERS;
    }
    enum { LONG = 4 };
    for (uint32_t i = 0; i < LONG; i++) {
        double mean = render_mean(&p, i, FEW * RENDERS);
        rest += mean / LONG;
        rest_squares += mean * mean / LONG;
    }
    double error = sqrt((squares - sum * sum) / (RENDERS - 1) + (rest_squares - rest * rest) / (LONG - 1));
    print_message("%d renders of %d samples: %.5f; of %d: %.5f; standard error %.5f\n", RENDERS, FEW, sum,
                  FEW * RENDERS, rest, error);
    assert_near(sum, rest, 3.0 * error);
    assert_true(error < 0.005 * rest);
    picture_close(&p);
}

// ---------------------------------------------------------------------------------------------------------------- pieces

enum { COLUMNS = 80, PICTURE = 48 };

static clast_mesh piece_of(const clast_mesh *whole, uint32_t first, uint32_t end, float *positions, float *normals,
                           uint32_t *indices)
{
    for (uint32_t i = 3 * first; i < 3 * end; i++) {
        memcpy(positions + 3 * (i - 3 * first), whole->positions + 3 * whole->indices[i], 12);
        memcpy(normals + 3 * (i - 3 * first), whole->normals + 3 * whole->indices[i], 12);
        indices[i - 3 * first] = i - 3 * first;
    }
    return (clast_mesh){.vertex_count = 3 * (end - first),
                        .triangle_count = end - first,
                        .positions = positions,
                        .normals = normals,
                        .indices = indices,
                        .material = whole->material};
}

// A bumpy sphere over a floor, cut into meshes of consecutive triangles.
static picture cut_sphere(clast_context *context, uint32_t pieces)
{
    picture p = picture_open(context, PICTURE, 8);
    picture_surround(&p, 0.3f);
    uint32_t grey = picture_material(&p, 0.7f, 0.0f, 0.4f, 0.0f), lamp = picture_material(&p, 0.5f, 0.0f, 1.0f, 10.0f);
    picture_add_square(&p, Y * -1.2f, X * 4.0f, Z * -4.0f, grey);
    picture_add_square(&p, vec3(1.5f, 2.5f, 1.0f), X * 0.5f, Z * 0.5f, lamp);
    shape s = shape_sphere(COLUMNS, COLUMNS / 2);
    for (uint32_t v = 0; v < s.mesh.vertex_count; v++) {
        float *at = s.positions + 3 * v;
        float bump = 1.0f + 0.06f * sinf(9.0f * at[0]) * sinf(8.0f * at[1]) * sinf(7.0f * at[2]);
        for (int k = 0; k < 3; k++) {
            at[k] *= bump;
        }
    }
    s.mesh.material = grey;
    size_t corners = 3 * (size_t)s.mesh.triangle_count;
    float *positions = malloc(corners * 12), *normals = malloc(corners * 12);
    uint32_t *indices = malloc(corners * 4);
    assert_true(positions != NULL && normals != NULL && indices != NULL);
    for (uint32_t i = 0; i < pieces; i++) {
        uint32_t first = (uint32_t)((uint64_t)s.mesh.triangle_count * i / pieces),
                 end = (uint32_t)((uint64_t)s.mesh.triangle_count * (i + 1) / pieces), geometry, instance;
        clast_mesh piece = piece_of(&s.mesh, first, end, positions, normals, indices);
        assert_ok(context, clast_scene_add_mesh(p.scene, &piece, "piece", &geometry));
        assert_ok(context, clast_scene_add_instance(p.scene, geometry, NULL, NULL, &instance));
    }
    free(positions);
    free(normals);
    free(indices);
    shape_free(&s);
    picture_look(&p, vec3(0.4f, 0.8f, 4.0f), Y * -0.1f, 0.7f);
    picture_render(&p);
    return p;
}

// Where a ray meets two triangles at their common edge, either may count, and what follows may be another path.
static void the_same_picture_however_meshes_are_cut(void **state)
{
    const uint32_t pieces[] = {7, 1000};
    picture whole = cut_sphere(*state, 1);
    for (size_t i = 0; i < sizeof pieces / sizeof *pieces; i++) {
        picture cut = cut_sphere(*state, pieces[i]);
        uint32_t different = 0;
        for (uint32_t k = 0; k < PICTURE * PICTURE; k++) {
            different += memcmp(picture_pixel(&whole, k % PICTURE, k / PICTURE),
                                picture_pixel(&cut, k % PICTURE, k / PICTURE), 12) != 0;
        }
        print_message("in %u pieces: %u of %d pixels are others\n", pieces[i], different, PICTURE * PICTURE);
        assert_true(different <= PICTURE * PICTURE / 1000);
        assert_near(picture_mean(&cut) / picture_mean(&whole), 1.0, 1e-3);
        picture_close(&cut);
    }
    picture_close(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(many_short_renders_are_a_long_one),
        CONTEXT_TEST(the_same_picture_however_meshes_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
