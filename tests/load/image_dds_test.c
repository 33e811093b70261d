// SPDX-License-Identifier: Apache-2.0
// DDS files: real ones beside pictures of them that another program made, and headers written here.
#include "loader_fixture.h"

#include <dirent.h>

#include "load/image.h"
#include "load/texel.h"
#include "shared/block.h"
#include "shared/random.h"

// ----------------------------------------------------------------------------------------------------------- real files

// What the pictures made of the files show: 8 bits, and floats as a screen shows them.
static float shown(const clast_image *image, size_t i)
{
    if (image->type == CLAST_PIXEL_UNORM8) {
        return (float)((const uint8_t *)image->pixels)[i] / 255.0f;
    }
    if (image->type == CLAST_PIXEL_UNORM16) {
        return (float)((const uint16_t *)image->pixels)[i] / 65535.0f;
    }
    float v = ((const float *)image->pixels)[i];
    return v <= 0.0f ? 0.0f : v >= 1.0f ? 1.0f : v;
}

static float screen(float v)
{
    return v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1.0f / 2.4f) - 0.055f;
}

// Red, green, blue, alpha of a pixel.
static void pixel_of(const clast_image *image, size_t i, float rgba[4])
{
    uint32_t n = image->channels;
    for (uint32_t c = 0; c < 3; c++) {
        rgba[c] = shown(image, i * n + (n < 3 ? 0 : c));
    }
    rgba[3] = n == 2 || n == 4 ? shown(image, i * n + n - 1) : 1.0f;
}

// The mean difference, with floats as they are or as on a screen, whichever is nearer: the pictures have both.
static float difference_of(const clast_image *a, const clast_image *b)
{
    double sums[2] = {0.0, 0.0};
    size_t count = (size_t)a->width * a->height;
    for (size_t i = 0; i < count; i++) {
        float x[4], y[4];
        pixel_of(a, i, x);
        pixel_of(b, i, y);
        for (uint32_t c = 0; c < 4; c++) {
            bool is_hidden = c < 3 && y[3] == 0.0f; // colours that nobody sees may be anything
            sums[0] += is_hidden ? 0.0 : (double)fabsf(x[c] - y[c]);
            sums[1] += is_hidden ? 0.0 : (double)fabsf((c < 3 ? screen(x[c]) : x[c]) - y[c]);
        }
    }
    return (float)(fmin(sums[0], sums[1]) / (4.0 * (double)count));
}

static bool is_one_of(const char *name, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strcmp(names[i], name) == 0) {
            return true;
        }
    }
    return false;
}

// Kinds that are no plane textures of colours.
static const char *const refused[] = {
    "ASTC 10x10.dds",
    "ASTC 10x6.dds",
    "ASTC 12x10.dds",
    "ASTC 4x4.dds",
    "ASTC 5x5.dds",
    "ASTC 6x6.dds",
    "ASTC 8x6.dds",
    "DX10 P010.dds",
    "DX10 G8R8_G8B8_UNORM.dds",
    "DX10 Y210.dds",
    "DX9 G8R8_G8B8_UNORM.dds",
    "DX9 UYVY.dds",
    "DX10 AYUV.dds",
    "DX10 R1_UNORM.dds",
    "DX10 Y416.dds",
    "BC1 Pretoria Gardens DX10.dds",
    "Pretoria Gardens DX10.dds",
    "SYSTEX_ENVLIGHT.dds",
    "TestVolume_Noise3D BC1.dds",
    "BC3n AGBR.dds",
};
// Luminance with alpha, of which the picture makes red and green.
static const char *const otherwise[] = {"DX9 R8G8_UNORM.dds"};

static void compare_file(clast_context *context, const char *folder, const char *name)
{
    char path[1024];
    clast_image image, expected;
    snprintf(path, sizeof path, "%s/images/dds/%s/%s", test_assets(), folder, name);
    clast_status status = clast_image_read(context, path, &image);
    if (is_one_of(name, refused, sizeof refused / sizeof *refused)) {
        if (status != CLAST_ERROR_UNSUPPORTED) {
            fail_msg("%s: expected a refusal", name);
        }
        return;
    }
    assert_ok(context, status);
    int length = (int)strlen(name) - 4;
    snprintf(path, sizeof path, "%s/images/dds-ref/%s/%.*s.png", test_assets(), folder, length, name);
    assert_ok(context, clast_image_read(context, path, &expected));
    assert_int_equal(image.width, expected.width);
    assert_int_equal(image.height, expected.height);
    float difference = difference_of(&image, &expected);
    if (difference > 0.004f && !is_one_of(name, otherwise, sizeof otherwise / sizeof *otherwise)) {
        fail_msg("%s/%s differs by %g in the mean", folder, name, (double)difference);
    }
    clast_image_free(context, &image);
    clast_image_free(context, &expected);
}

static void real_files_are_as_pictures_of_them(void **state)
{
    fixture *f = *state;
    if (test_assets() == NULL) {
        skip();
    }
    static const char *const folders[] = {"astc",  "bc",          "bi-planar",    "cube",  "nvtt",
                                          "other", "sub-sampled", "uncompressed", "volume"};
    clast_context *context;
    assert_ok(f->context, clast_context_create(NULL, &context));
    size_t count = 0;
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        char path[1024];
        snprintf(path, sizeof path, "%s/images/dds/%s", test_assets(), folders[i]);
        DIR *folder = opendir(path);
        assert_non_null(folder);
        for (struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
            if (strstr(entry->d_name, ".dds") != NULL) {
                compare_file(context, folders[i], entry->d_name);
                count++;
            }
        }
        closedir(folder);
    }
    clast_context_destroy(context);
    assert_true(count > 60);
}

// ------------------------------------------------------------------------------------------------------------- headers

typedef struct dds_file {
    unsigned char bytes[512];
    size_t size;
} dds_file;

static void put_word(dds_file *file, size_t place, uint32_t word)
{
    for (uint32_t i = 0; i < 4; i++) {
        file->bytes[place + i] = (unsigned char)(word >> (8 * i));
    }
}

// A file of `width` x `height` pixels without any; `code` null: masks follow.
static dds_file begin_file(uint32_t width, uint32_t height, const char *code)
{
    dds_file file = {.bytes = "DDS ", .size = 128};
    put_word(&file, 4, 124);
    put_word(&file, 12, height);
    put_word(&file, 16, width);
    put_word(&file, 76, 32);
    if (code != NULL) {
        put_word(&file, 80, 4);
        memcpy(file.bytes + 84, code, 4);
    }
    return file;
}

static void put_masks(dds_file *file, uint32_t flags, uint32_t bits, uint32_t red, uint32_t green, uint32_t blue,
                      uint32_t alpha)
{
    put_word(file, 80, flags);
    put_word(file, 88, bits);
    put_word(file, 92, red);
    put_word(file, 96, green);
    put_word(file, 100, blue);
    put_word(file, 104, alpha);
}

static clast_status decode(fixture *f, const dds_file *file, clast_image *image)
{
    unsigned char *copy = malloc(file->size); // of exactly that size: a sanitizer sees reads beyond it
    memcpy(copy, file->bytes, file->size);
    clast_status status = clast_decode_image(f->context, "picture", copy, file->size, image);
    free(copy);
    return status;
}

static void masks_find_channels_anywhere(void **state)
{
    fixture *f = *state;
    dds_file file = begin_file(1, 1, NULL);
    put_masks(&file, 0x41, 16, 0x0f00, 0x00f0, 0x000f, 0xf000);
    file.bytes[128] = 0x21;
    file.bytes[129] = 0x43;
    file.size = 130;
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    const uint8_t expected[4] = {3 * 17, 2 * 17, 1 * 17, 4 * 17};
    assert_int_equal(image.channels, 4);
    assert_memory_equal(image.pixels, expected, 4);
    clast_image_free(f->context, &image);
}

static void luminance_and_alpha_are_two_channels(void **state)
{
    fixture *f = *state;
    dds_file file = begin_file(1, 1, NULL);
    put_masks(&file, 0x20001, 16, 0xff, 0, 0, 0xff00);
    file.bytes[128] = 9;
    file.bytes[129] = 8;
    file.size = 130;
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    assert_int_equal(image.channels, 2);
    assert_int_equal(((const uint8_t *)image.pixels)[0], 9);
    assert_int_equal(((const uint8_t *)image.pixels)[1], 8);
    clast_image_free(f->context, &image);
}

static void masks_with_holes_or_outside_are_refused(void **state)
{
    fixture *f = *state;
    enum { COLOURS = 0x40, DIFFERENCES = 0x80000 };
    static const uint32_t masks[][3] = {{16, 0x0f0f, COLOURS}, {16, 0xff0000, COLOURS}, {8, 0x1ff, COLOURS},
                                        {12, 0xf, COLOURS},    {32, 0x1ffff, COLOURS},  {0, 0xff, COLOURS},
                                        {64, 0xff, COLOURS},   {32, 1, DIFFERENCES}};
    for (size_t i = 0; i < sizeof masks / sizeof *masks; i++) {
        dds_file file = begin_file(1, 1, NULL);
        put_masks(&file, masks[i][2], masks[i][0], masks[i][1], 0, 0, 0);
        file.size = 160;
        clast_image image;
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_UNSUPPORTED);
    }
}

static void a_block_has_sixteen_pixels_of_which_the_image_takes_some(void **state)
{
    fixture *f = *state;
    dds_file file = begin_file(3, 2, "DXT1");
    static const unsigned char block[8] = {0x00, 0xf8, 0x1f, 0x00,
                                           0x55, 0x00, 0xff, 0xff}; // red over blue; the first row blue
    memcpy(file.bytes + 128, block, sizeof block);
    file.size = 136;
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    const uint8_t expected[6][4] = {{0, 0, 255, 255}, {0, 0, 255, 255}, {0, 0, 255, 255},
                                    {255, 0, 0, 255}, {255, 0, 0, 255}, {255, 0, 0, 255}};
    assert_memory_equal(image.pixels, expected, sizeof expected);
    clast_image_free(f->context, &image);
}

// Blocks are kept as they are in the file, where devices make the same of them.
static void blocks_are_kept_for_devices(void **state)
{
    fixture *f = *state;
    static const struct {
        char code[5];
        bool kept;
        clast_block_format format;
        size_t bytes;
    } cases[] = {
        {"DXT1", true, CLAST_BLOCK_BC1, 16},        {"DXT3", true, CLAST_BLOCK_BC2, 32},
        {"DXT5", true, CLAST_BLOCK_BC3, 32},        {"ATI1", true, CLAST_BLOCK_BC4, 16},
        {"ATI2", true, CLAST_BLOCK_BC5, 32},        {"DXT2", false, CLAST_BLOCK_BC2, 0},
        {"DXT4", false, CLAST_BLOCK_BC3, 0},        {"BC4S", false, CLAST_BLOCK_BC4_SIGNED, 0},
        {"BC5S", false, CLAST_BLOCK_BC5_SIGNED, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        dds_file file = begin_file(5, 3, cases[i].code);
        for (size_t k = 128; k < 160; k++) {
            file.bytes[k] = (unsigned char)(k * 37 + i);
        }
        file.size = 160;
        clast_image image;
        clast_image_parts parts;
        assert_ok(f->context, clast_decode_image_parts(f->context, "picture", file.bytes, file.size, &image, &parts));
        assert_true((parts.blocks.data != NULL) == cases[i].kept);
        assert_int_equal(parts.blocks.bytes, cases[i].bytes);
        if (cases[i].kept) {
            assert_int_equal(parts.blocks.format, cases[i].format);
            assert_memory_equal(parts.blocks.data, file.bytes + 128, parts.blocks.bytes);
        }
        clast_image_free(f->context, &image);
        clast_free(f->context, parts.blocks.data);
        assert_int_equal(parts.levels.count, 0);
    }
}

// 5 x 3, 2 x 1 and 1 x 1 pixels of 8 bits, one after the other. Where the file ends, levels do; a count means no more than there
// can be.
static void levels_follow_the_picture(void **state)
{
    fixture *f = *state;
    for (uint32_t there = 0; there <= 3; there++) {
        dds_file file = begin_file(5, 3, "DX10");
        put_word(&file, 128, 61); // one channel
        put_word(&file, 132, 3);
        put_word(&file, 140, 1);
        put_word(&file, 28, there == 0 ? 1 : 1000);
        for (size_t i = 0; i < 18; i++) {
            file.bytes[148 + i] = (unsigned char)(i + 1);
        }
        file.size = 148 + 15 + there;
        clast_image image;
        clast_image_parts parts;
        assert_ok(f->context, clast_decode_image_parts(f->context, "picture", file.bytes, file.size, &image, &parts));
        assert_int_equal(parts.levels.count, there < 2 ? 0 : there - 1);
        if (there == 3) {
            const unsigned char *first = clast_level_image(&image, &parts.levels, 1).pixels;
            const unsigned char *second = clast_level_image(&image, &parts.levels, 2).pixels;
            assert_true(first[0] == 16 && first[1] == 17 && second[0] == 18);
        }
        clast_image_free(f->context, &image);
        clast_levels_free(f->context, &parts.levels);
    }
}

static void every_cut_and_every_size_beyond_the_file_is_refused(void **state)
{
    fixture *f = *state;
    dds_file file = begin_file(8, 8, "DX10");
    put_word(&file, 128, 98);
    put_word(&file, 132, 3);
    put_word(&file, 140, 1);
    file.size = 148 + 64;
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    clast_image_free(f->context, &image);
    size_t whole = file.size;
    for (file.size = 4; file.size < whole; file.size++) {
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_MALFORMED);
    }
    put_word(&file, 16, 0x40000000);
    put_word(&file, 12, 0x40000000);
    assert_int_equal(decode(f, &file, &image), CLAST_ERROR_MALFORMED);
    put_word(&file, 12, 0);
    assert_int_equal(decode(f, &file, &image), CLAST_ERROR_MALFORMED);
}

static void arrays_cubes_and_volumes_are_refused(void **state)
{
    fixture *f = *state;
    static const uint32_t fields[][3] = {{4, 0, 1}, {3, 4, 1}, {3, 0, 2}}; // dimension, flags, images
    for (size_t i = 0; i < 3; i++) {
        dds_file file = begin_file(4, 4, "DX10");
        put_word(&file, 128, 71);
        put_word(&file, 132, fields[i][0]);
        put_word(&file, 136, fields[i][1]);
        put_word(&file, 140, fields[i][2]);
        file.size = 300;
        clast_image image;
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_UNSUPPORTED);
    }
}

// -------------------------------------------------------------------------------------------------------------- blocks

// Whatever a block holds means something: no read beyond tables, no value out of range.
static void any_block_decodes(void **state)
{
    (void)state;
    uint64_t random = 1;
    for (uint32_t round = 0; round < 20000; round++) {
        unsigned char block[16];
        for (uint32_t i = 0; i < 16; i++) {
            random = random * 6364136223846793005u + 1442695040888963407u;
            block[i] = (unsigned char)(random >> 56);
        }
        block[0] = round % 3 == 0 ? (unsigned char)(1u << round / 3 % 8) : block[0]; // the rarer modes
        for (int format = 0; format < CLAST_BLOCK_COUNT; format++) {
            float pixels[CLAST_BLOCK_BYTES_MOST / sizeof(float)];
            clast_block_decode((clast_block_format)format, block, pixels);
            for (uint32_t i = 0; clast_block_type((clast_block_format)format) == CLAST_PIXEL_FLOAT && i < 48; i++) {
                assert_true(fabsf(pixels[i]) <= 65504.0f);
            }
        }
    }
}

static uint32_t bytes_at(const unsigned char *pixels, uint32_t channels)
{
    uint32_t value = 0;
    for (uint32_t c = 0; c < channels; c++) {
        value |= (uint32_t)pixels[c] << 8 * c;
    }
    return value;
}

// Kernels of devices look into blocks for single texels (shared/block.h).
static void single_texels_are_those_of_whole_blocks(void **state)
{
    (void)state;
    static const struct {
        clast_block_format format;
        uint32_t kind;
    } kinds[] = {{CLAST_BLOCK_BC1, BLOCK_BC1},
                 {CLAST_BLOCK_BC2, BLOCK_BC2},
                 {CLAST_BLOCK_BC3, BLOCK_BC3},
                 {CLAST_BLOCK_BC4, BLOCK_BC4},
                 {CLAST_BLOCK_BC5, BLOCK_BC5}};
    for (uint32_t round = 0; round < 20000; round++) {
        uint32_t words[4];
        unsigned char block[16], pixels[64];
        for (uint32_t i = 0; i < 4; i++) {
            words[i] = hash2(round, i);
        }
        memcpy(block, words, sizeof block);
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
            uint32_t channels = clast_block_channels(kinds[k].format);
            clast_block_decode(kinds[k].format, block, pixels);
            for (uint32_t i = 0; i < 16; i++) {
                assert_int_equal(block_texel(kinds[k].kind, words[0], words[1], words[2], words[3], i),
                                 bytes_at(pixels + i * channels, channels));
            }
        }
    }
}

// By the rule: the nearest whole number to what lies so many steps between the ends.
static void values_between_ends_are_rounded_to_the_nearest(void **state)
{
    (void)state;
    for (uint32_t ends = 0; ends < 65536; ends++) {
        uint32_t a = ends & 255, b = ends >> 8, steps = a > b ? 7 : 5;
        for (uint32_t k = 1; k < steps; k++) {
            double exact = ((double)(steps - k) * a + (double)k * b) / steps;
            assert_int_equal(block_value(a, b, k + 1), (uint32_t)floor(exact + 0.5));
        }
    }
}

static void signed_channels_have_zero_in_the_middle(void **state)
{
    (void)state;
    static const struct {
        unsigned char first;
        uint8_t expected;
    } ends[] = {{0x00, 128}, {0x7f, 255}, {0x81, 0}, {0x80, 0}};
    for (size_t i = 0; i < 4; i++) {
        const unsigned char block[8] = {ends[i].first, ends[i].first};
        uint8_t pixels[16];
        clast_block_decode(CLAST_BLOCK_BC4_SIGNED, block, pixels);
        assert_int_equal(pixels[7], ends[i].expected);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(real_files_are_as_pictures_of_them),
        LOADER_TEST(masks_find_channels_anywhere),
        LOADER_TEST(luminance_and_alpha_are_two_channels),
        LOADER_TEST(masks_with_holes_or_outside_are_refused),
        LOADER_TEST(a_block_has_sixteen_pixels_of_which_the_image_takes_some),
        LOADER_TEST(blocks_are_kept_for_devices),
        LOADER_TEST(levels_follow_the_picture),
        LOADER_TEST(every_cut_and_every_size_beyond_the_file_is_refused),
        LOADER_TEST(arrays_cubes_and_volumes_are_refused),
        cmocka_unit_test(any_block_decodes),
        cmocka_unit_test(single_texels_are_those_of_whole_blocks),
        cmocka_unit_test(values_between_ends_are_rounded_to_the_nearest),
        cmocka_unit_test(signed_channels_have_zero_in_the_middle),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
