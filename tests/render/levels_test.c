// SPDX-License-Identifier: Apache-2.0
// Levels of pictures: what their texels are means of.
#include <math.h>
#include <string.h>

#include "render/levels.h"
#include "shared/random.h"
#include "shared/surface.h"
#include "test.h"

static clast_srgb_table tables;

// A scene with a material that reads an image in one slot.
typedef struct stage {
    clast_context *context;
    clast_scene *scene;
    clast_material_desc material;
    uint32_t image;
    clast_texture_slot slot;
} stage;

static stage open_stage(clast_context *context, const clast_image *image)
{
    stage s = {.context = context, .material = clast_material_defaults()};
    assert_ok(context, clast_scene_create(context, &s.scene));
    assert_ok(context, clast_scene_add_image(s.scene, image, NULL, &s.image));
    clast_texture texture = {s.image, CLAST_WRAP_REPEAT, CLAST_WRAP_REPEAT, CLAST_FILTER_LINEAR};
    s.slot = (clast_texture_slot){.scale = {1.0f, 1.0f}};
    assert_ok(context, clast_scene_add_texture(s.scene, &texture, &s.slot.texture));
    return s;
}

static const clast_image_levels *make(stage *s, clast_encoding encoding)
{
    uint32_t number;
    assert_ok(s->context, clast_scene_add_material(s->scene, &s->material, NULL, &number));
    assert_ok(s->context, clast_make_levels(s->scene));
    return &s->scene->images[s->image].levels[encoding];
}

static vec4 level_texel(const stage *s, clast_encoding encoding, uint32_t level, uint32_t x, uint32_t y)
{
    const clast_scene_image *from = &s->scene->images[s->image];
    clast_image image = clast_level_image(&from->image, &from->levels[encoding], level);
    assert_true(x < image.width && y < image.height);
    return clast_image_texel(&image, x, y, encoding, &tables);
}

static float *noise(size_t count)
{
    float *values = malloc(count * sizeof *values);
    assert_non_null(values);
    for (size_t i = 0; i < count; i++) {
        values[i] = unit_float(hash1((uint32_t)i));
    }
    return values;
}

// The mean of a grey float picture over [x0, x1) x [y0, y1), in texels.
static double area_mean(const float *values, uint32_t width, uint32_t height, double x0, double x1, double y0,
                        double y1)
{
    double sum = 0.0;
    for (uint32_t y = 0; y < height; y++) {
        double down = fmin(y1, y + 1.0) - fmax(y0, (double)y);
        for (uint32_t x = 0; x < width && down > 0.0; x++) {
            double across = fmin(x1, x + 1.0) - fmax(x0, (double)x);
            sum += across > 0.0 ? across * down * (double)values[(size_t)y * width + x] : 0.0;
        }
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

// Also of odd sizes, where texels of a level stand for parts of those before them: 23 x 11, 11 x 5, 5 x 2, 2 x 1, 1 x 1.
static void texels_are_means_of_as_much_as_they_stand_for(void **state)
{
    enum { WIDTH = 23, HEIGHT = 11 };
    float *values = noise((size_t)WIDTH * HEIGHT);
    clast_image image = {WIDTH, HEIGHT, 1, CLAST_PIXEL_FLOAT, values};
    stage s = open_stage(*state, &image);
    s.material.metallic_roughness_texture = s.slot;
    const clast_image_levels *levels = make(&s, CLAST_ENCODING_LINEAR);
    assert_int_equal(levels->count, 4);
    const float *before = values;
    for (uint32_t level = 1; level <= 4; level++) {
        uint32_t width = clast_level_side(WIDTH, level), height = clast_level_side(HEIGHT, level);
        uint32_t width_before = clast_level_side(WIDTH, level - 1), height_before = clast_level_side(HEIGHT, level - 1);
        double across = (double)width_before / width, down = (double)height_before / height;
        for (uint32_t i = 0; i < width * height; i++) {
            uint32_t x = i % width, y = i / width;
            double expected = area_mean(before, width_before, height_before, x * across, (x + 1) * across, y * down,
                                        (y + 1) * down);
            assert_true(fabs((double)level_texel(&s, CLAST_ENCODING_LINEAR, level, x, y)[0] - expected) < 1e-6);
        }
        before = clast_level_image(&image, levels, level).pixels;
    }
    clast_scene_destroy(s.scene);
    free(values);
}

// Half black, half white is half the light, which a display's code of 188 shows; means of codes would be 128.
static void colours_are_averaged_as_light(void **state)
{
    const uint8_t pixels[4] = {0, 255, 255, 0};
    clast_image image = {2, 2, 1, CLAST_PIXEL_UNORM8, pixels};
    stage s = open_stage(*state, &image);
    s.material.base_colour_texture = s.material.metallic_roughness_texture = s.slot;
    const clast_image_levels *levels = make(&s, CLAST_ENCODING_SRGB);
    assert_int_equal(((const uint8_t *)levels->pixels)[0], 188);
    levels = &s.scene->images[s.image].levels[CLAST_ENCODING_LINEAR];
    assert_int_equal(((const uint8_t *)levels->pixels)[0], 128);
    clast_scene_destroy(s.scene);
}

// Every code is found again.
static void codes_are_rounded_to_the_nearest(void **state)
{
    uint8_t pixels[2 * 512];
    for (uint32_t i = 0; i < 512; i++) {
        pixels[i] = pixels[512 + i] = (uint8_t)(i / 2);
    }
    clast_image image = {512, 2, 1, CLAST_PIXEL_UNORM8, pixels};
    stage s = open_stage(*state, &image);
    s.material.base_colour_texture = s.slot;
    const clast_image_levels *levels = make(&s, CLAST_ENCODING_SRGB);
    for (uint32_t i = 0; i < 256; i++) {
        assert_int_equal(((const uint8_t *)levels->pixels)[i], i);
    }
    clast_scene_destroy(s.scene);
}

static void what_is_constant_stays_so_to_the_bit(void **state)
{
    for (uint32_t type = 0; type < 3; type++) {
        uint8_t bytes[21 * 13 * 4];
        uint16_t words[21 * 13 * 4];
        float floats[21 * 13 * 4];
        const void *pixels[] = {bytes, words, floats};
        for (uint32_t i = 0; i < 21 * 13 * 4; i++) {
            bytes[i] = (uint8_t)(7 + 50 * (i % 4));
            words[i] = (uint16_t)(1234 + 15000 * (i % 4));
            floats[i] = 0.3f + 1.7f * (float)(i % 4);
        }
        clast_image image = {21, 13, 4, (clast_pixel_type)type, pixels[type]};
        stage s = open_stage(*state, &image);
        s.material.base_colour_texture = s.slot;
        make(&s, CLAST_ENCODING_SRGB);
        vec4 expected = clast_image_texel(&image, 0, 0, CLAST_ENCODING_SRGB, &tables);
        clast_texture_use use = s.scene->materials[1].record.base_colour_texture;
        for (uint32_t i = 0; i < 2000; i++) {
            float size = exp2f(-8.0f + 10.0f * unit_float(hash2(i, 1)));
            clast_texture_area area = {
                .coordinates = {vec2(3.0f * unit_float(hash2(i, 2)), unit_float(hash2(i, 3))), splat2(0.0f)},
                .footprints = {{{{size, size * unit_float(hash2(i, 4))}},
                                {{0.1f * size, -size * unit_float(hash2(i, 5))}}}},
                .look = i % 3,
            };
            vec4 value = clast_texture_value(s.scene, use, &area, CLAST_ENCODING_SRGB, &tables, expected * 0.0f);
            for (int c = 0; c < 4; c++) {
                assert_true(value[c] == expected[c]);
            }
        }
        clast_scene_destroy(s.scene);
    }
}

// Between red that is there and green that is not, no green shows; where alpha means nothing, both count.
static void colours_of_cutouts_count_as_far_as_they_are_there(void **state)
{
    const uint8_t pixels[2][4] = {{255, 0, 0, 255}, {0, 255, 0, 0}};
    clast_image image = {2, 1, 4, CLAST_PIXEL_UNORM8, pixels};
    stage s = open_stage(*state, &image);
    s.material.base_colour_texture = s.slot;
    s.material.alpha_mode = CLAST_ALPHA_MASK;
    make(&s, CLAST_ENCODING_CUTOUT);
    vec4 texel = level_texel(&s, CLAST_ENCODING_CUTOUT, 1, 0, 0);
    assert_true(texel[0] == 1.0f && texel[1] == 0.0f && fabsf(texel[3] - 0.5f) < 0.003f);
    s.material.alpha_mode = CLAST_ALPHA_OPAQUE;
    make(&s, CLAST_ENCODING_SRGB);
    texel = level_texel(&s, CLAST_ENCODING_SRGB, 1, 0, 0);
    assert_true(fabsf(texel[0] - 0.5f) < 0.003f && fabsf(texel[1] - 0.5f) < 0.003f);
    clast_scene_destroy(s.scene);
}

// Numbers of 16 bits and floats are not brought to 8 bits on the way.
static void precision_is_kept(void **state)
{
    const uint16_t words[] = {1000, 1003};
    const float floats[] = {100.25f, 0.0f};
    clast_image images[] = {{2, 1, 1, CLAST_PIXEL_UNORM16, words}, {2, 1, 1, CLAST_PIXEL_FLOAT, floats}};
    const float expected[] = {1002.0f / 65535.0f, 50.125f};
    for (int i = 0; i < 2; i++) {
        stage s = open_stage(*state, &images[i]);
        s.material.metallic_roughness_texture = s.slot;
        make(&s, CLAST_ENCODING_LINEAR);
        assert_true(fabsf(level_texel(&s, CLAST_ENCODING_LINEAR, 1, 0, 0)[0] - expected[i]) < 1e-7f);
        clast_scene_destroy(s.scene);
    }
}

// Two slopes of 45 degrees make a normal that points up, whose length lacks 1 - cos 45; one slope alone stays what it is.
static void normals_tell_how_far_they_spread(void **state)
{
    const float half = 0.70710678f;
    const float pixels[4][3] = {{0.5f + 0.5f * half, 0.5f, 0.5f + 0.5f * half},
                                {0.5f - 0.5f * half, 0.5f, 0.5f + 0.5f * half},
                                {0.5f + 0.5f * half, 0.5f, 0.5f + 0.5f * half},
                                {0.5f + 0.5f * half, 0.5f, 0.5f + 0.5f * half}};
    clast_image image = {4, 1, 3, CLAST_PIXEL_FLOAT, pixels};
    stage s = open_stage(*state, &image);
    s.material.normal_texture = s.slot;
    make(&s, CLAST_ENCODING_NORMAL);
    vec4 values[3];
    for (uint32_t i = 0; i < 3; i++) { // two texels of the first level, and the second
        uint32_t level = i < 2 ? 1 : 2;
        values[i] = normal_value(normal_vector(level_texel(&s, CLAST_ENCODING_NORMAL, level, i % 2, 0), level));
    }
    assert_true(fabsf(values[0][0] - 0.5f) < 1e-4f && fabsf(values[0][2] - 1.0f) < 1e-4f);
    assert_true(fabsf(values[0][3] - (1.0f - half)) < 1e-4f);
    assert_true(fabsf(values[1][0] - pixels[0][0]) < 1e-4f && values[1][3] == 0.0f);
    assert_true(values[2][3] > 0.1f && values[2][3] < values[0][3]); // three of four agree
    clast_scene_destroy(s.scene);
}

static void spread_normals_make_a_surface_rough(void **state)
{
    (void)state;
    assert_true(widened_roughness(0.1f, 0.0f, 1.0f) == 0.1f);
    float before = 0.1f;
    for (float lost = 0.01f; lost < 1.0f; lost += 0.05f) {
        float roughness = widened_roughness(0.1f, lost, 1.0f);
        assert_true(roughness > before || roughness == 1.0f);
        before = roughness;
    }
    assert_true(before == 1.0f);
    // small slopes: the lobe's width squared grows by twice the slopes' variance, which is what the length lacks of one
    float alpha = widened_roughness(0.3f, 0.001f, 1.0f);
    assert_true(fabsf(powf(alpha, 4.0f) - (powf(0.3f, 4.0f) + 0.002f)) < 1e-5f);
    alpha = widened_roughness(0.3f, 0.001f, 2.0f);
    assert_true(fabsf(powf(alpha, 4.0f) - (powf(0.3f, 4.0f) + 0.008f)) < 1e-5f);
}

// Those of a file are taken as they are, and end where they end: what is below them is made of the last.
static void levels_of_files_are_taken_and_continued(void **state)
{
    uint8_t pixels[8 * 8] = {0};
    clast_image image = {8, 8, 1, CLAST_PIXEL_UNORM8, pixels};
    stage s = open_stage(*state, &image);
    s.material.metallic_roughness_texture = s.slot;
    clast_image_levels stored = {1, 1, CLAST_PIXEL_UNORM8, clast_allocate(*state, 16, 1), 16, {0}};
    assert_non_null(stored.pixels);
    memset(stored.pixels, 200, 16);
    clast_scene_adopt_levels(s.scene, s.image, &stored);
    const clast_image_levels *levels = make(&s, CLAST_ENCODING_LINEAR);
    assert_int_equal(levels->count, 3);
    for (uint32_t level = 1; level <= 3; level++) {
        assert_true(level_texel(&s, CLAST_ENCODING_LINEAR, level, 0, 0)[0] == unorm8(200));
    }
    clast_scene_destroy(s.scene);
}

static void levels_are_the_same_on_any_number_of_threads(void **state)
{
    enum { WIDTH = 301, HEIGHT = 157 };
    float *values = noise((size_t)WIDTH * HEIGHT * 4);
    uint8_t *bytes = (uint8_t *)values;
    clast_image image = {WIDTH, HEIGHT, 4, CLAST_PIXEL_UNORM8, bytes};
    void *first = NULL;
    (void)state;
    for (uint32_t threads = 1; threads <= 3; threads++) {
        clast_context *context;
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads}, &context), CLAST_OK);
        stage s = open_stage(context, &image);
        s.material.base_colour_texture = s.slot;
        s.material.alpha_mode = CLAST_ALPHA_BLEND;
        const clast_image_levels *levels = make(&s, CLAST_ENCODING_CUTOUT);
        for (uint32_t level = 1; level <= levels->count; level++) {
            clast_image made = clast_level_image(&image, levels, level);
            size_t size = (size_t)made.width * made.height * 4, offset = levels->offsets[level - 1];
            if (threads == 1) {
                first = first != NULL ? first : calloc(levels->bytes, 1);
                assert_non_null(first);
                memcpy((char *)first + offset, made.pixels, size);
            }
            assert_memory_equal((char *)first + offset, made.pixels, size);
        }
        clast_scene_destroy(s.scene);
        clast_context_destroy(context);
    }
    free(first);
    free(values);
}

static void levels_are_made_once_and_only_of_what_is_read(void **state)
{
    const uint8_t pixels[4] = {0, 1, 2, 3};
    clast_image image = {2, 2, 1, CLAST_PIXEL_UNORM8, pixels};
    stage s = open_stage(*state, &image);
    s.material.occlusion_texture = s.slot; // which path tracing does not read
    assert_int_equal(make(&s, CLAST_ENCODING_LINEAR)->count, 0);
    assert_int_equal(clast_level_bytes(s.scene), 0);
    s.material.clearcoat_texture = s.slot;
    const void *made = make(&s, CLAST_ENCODING_LINEAR)->pixels;
    assert_non_null(made);
    assert_true(make(&s, CLAST_ENCODING_LINEAR)->pixels == made);
    assert_true(clast_level_bytes(s.scene) >= 1);
    clast_scene_destroy(s.scene);
}

int main(void)
{
    clast_srgb_table_fill(&tables);
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(texels_are_means_of_as_much_as_they_stand_for),
        CONTEXT_TEST(colours_are_averaged_as_light),
        CONTEXT_TEST(codes_are_rounded_to_the_nearest),
        CONTEXT_TEST(what_is_constant_stays_so_to_the_bit),
        CONTEXT_TEST(colours_of_cutouts_count_as_far_as_they_are_there),
        CONTEXT_TEST(precision_is_kept),
        CONTEXT_TEST(normals_tell_how_far_they_spread),
        CONTEXT_TEST(spread_normals_make_a_surface_rough),
        CONTEXT_TEST(levels_of_files_are_taken_and_continued),
        CONTEXT_TEST(levels_are_the_same_on_any_number_of_threads),
        CONTEXT_TEST(levels_are_made_once_and_only_of_what_is_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
