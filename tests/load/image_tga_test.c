// SPDX-License-Identifier: Apache-2.0
// TGA files written here by hand.
#include "loader_fixture.h"

#include "load/image.h"

static clast_status decode(fixture *f, const void *data, size_t size, clast_image *image)
{
    void *copy = malloc(size + (size == 0)); // exactly that size: the address sanitizer sees reads beyond it
    assert_non_null(copy);
    memcpy(copy, data, size);
    clast_status status = clast_decode_image(f->context, "picture", copy, size, image);
    free(copy);
    return status;
}

#define DECODE(f, text, image) decode(f, text, sizeof(text) - 1, image)

// The header's parts: palette or not, kind, the palette's first entry, count and bits, then the picture's.
#define NO_PALETTE "\0\0\0\0\0"
#define HEAD(has_palette, kind, palette, width, height, bits, descriptor) \
    "\0" has_palette kind palette "\0\0\0\0" width "\0" height "\0" bits descriptor

static void assert_pixels(fixture *f, const void *data, size_t size, uint32_t channels, const uint8_t *expected,
                          size_t count)
{
    clast_image image;
    assert_ok(f->context, decode(f, data, size, &image));
    assert_int_equal(image.channels, channels);
    assert_int_equal(image.type, CLAST_PIXEL_UNORM8);
    assert_int_equal((size_t)image.width * image.height * channels, count);
    assert_memory_equal(image.pixels, expected, count);
    clast_image_free(f->context, &image);
}

#define ASSERT_PIXELS(f, text, channels, ...) \
    assert_pixels(f, text, sizeof(text) - 1, channels, (const uint8_t[]){__VA_ARGS__}, \
                  sizeof((const uint8_t[]){__VA_ARGS__}))

static void colours_of_all_sizes_are_read(void **state)
{
    fixture *f = *state;
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x18", "\x20") "\1\2\3", 3, 3, 2, 1);
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x20", "\x28") "\1\2\3\4", 4, 3, 2, 1, 4);
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x20", "\x20") "\1\2\3\4", 3, 3, 2, 1);
    // 16 bits: alpha, red 31, green 0, blue 16
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x10", "\x21") "\x10\xfc", 4, 255, 0, 132, 255);
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x10", "\x20") "\x10\xfc", 3, 255, 0, 132);
    ASSERT_PIXELS(f, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x0f", "\x20") "\x10\x7c", 3, 255, 0, 132);
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\1", "\x08", "\x20") "\7\xff", 1, 7, 255);
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\1", "\1", "\x10", "\x28") "\7\x80", 2, 7, 128);
}

static void pictures_begin_at_any_corner(void **state)
{
    fixture *f = *state;
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\2", "\x08", "\x20") "\1\2\3\4", 1, 1, 2, 3, 4);
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\2", "\x08", "\x00") "\1\2\3\4", 1, 3, 4, 1, 2);
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\2", "\x08", "\x30") "\1\2\3\4", 1, 2, 1, 4, 3);
    ASSERT_PIXELS(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\2", "\x08", "\x10") "\1\2\3\4", 1, 4, 3, 2, 1);
}

static void runs_may_pass_the_end_of_a_row(void **state)
{
    fixture *f = *state;
    ASSERT_PIXELS(f, HEAD("\0", "\x0b", NO_PALETTE, "\3", "\2", "\x08", "\x20") "\x83\x09\1\5\6", 1, 9, 9, 9, 9, 5, 6);
    ASSERT_PIXELS(f, HEAD("\0", "\x0a", NO_PALETTE, "\2", "\1", "\x18", "\x20") "\x81\1\2\3", 3, 3, 2, 1, 3, 2, 1);
}

static void palettes_of_all_sizes_are_read(void **state)
{
    fixture *f = *state;
    ASSERT_PIXELS(f, HEAD("\1", "\1", "\0\0\2\0\x18", "\2", "\1", "\x08", "\x20") "\1\2\3\4\5\6\1\0", 3, 6, 5, 4, 3, 2,
                  1);
    ASSERT_PIXELS(f, HEAD("\1", "\1", "\x05\0\1\0\x20", "\1", "\1", "\x08", "\x20") "\1\2\3\4\x05", 4, 3, 2, 1, 4);
    ASSERT_PIXELS(f, HEAD("\1", "\1", "\0\0\1\0\x10", "\1", "\1", "\x10", "\x20") "\x10\x7c\0\0", 3, 255, 0, 132);
    ASSERT_PIXELS(f, HEAD("\1", "\x09", "\0\0\1\0\x18", "\3", "\1", "\x08", "\x20") "\1\2\3\x82\0", 3, 3, 2, 1, 3, 2, 1,
                  3, 2, 1);
}

static void a_footer_says_what_alpha_means(void **state)
{
    fixture *f = *state;
    for (int type = 0; type < 5; type++) {
        unsigned char file[18 + 4 + 495 + 26] = {0};
        memcpy(file, HEAD("\0", "\2", NO_PALETTE, "\1", "\1", "\x20", "\x28") "\x20\x40\x60\x80", 22);
        file[22 + 494] = (unsigned char)type;
        file[22 + 495] = 22; // where the extension area is
        memcpy(file + 22 + 495 + 8, "TRUEVISION-XFILE.", 18);
        if (type < 3) {
            assert_pixels(f, file, sizeof file, 3, (const uint8_t[]){0x60, 0x40, 0x20}, 3);
        } else if (type == 3) {
            assert_pixels(f, file, sizeof file, 4, (const uint8_t[]){0x60, 0x40, 0x20, 0x80}, 4);
        } else {
            assert_pixels(f, file, sizeof file, 4, (const uint8_t[]){191, 128, 64, 0x80}, 4);
        }
    }
}

static void every_cut_and_every_index_outside_is_refused(void **state)
{
    fixture *f = *state;
    static const char file[] = HEAD("\1", "\x09", "\0\0\1\0\x18", "\3", "\1", "\x08", "\x20") "\1\2\3\x81\0\0\0";
    clast_image image;
    for (size_t size = 0; size + 1 < sizeof file; size++) {
        assert_int_not_equal(decode(f, file, size, &image), CLAST_OK);
        assert_null(image.pixels);
    }
    static const char *const words[] = {"palette", "run leaves", "short"};
    for (int i = 0; i < 3; i++) {
        clast_status status =
            i == 0   ? DECODE(f, HEAD("\1", "\1", "\0\0\1\0\x18", "\1", "\1", "\x08", "\x20") "\1\2\3\1", &image)
            : i == 1 ? DECODE(f, HEAD("\0", "\x0b", NO_PALETTE, "\2", "\1", "\x08", "\x20") "\x85\1", &image)
                     : DECODE(f, HEAD("\0", "\x0b", NO_PALETTE, "\xff", "\xff", "\x08", "\x20") "\x85\1", &image);
        assert_int_equal(status, CLAST_ERROR_MALFORMED);
        assert_non_null(strstr(clast_context_error(f->context), words[i]));
    }
}

static void other_files_are_not_taken_for_tga(void **state)
{
    fixture *f = *state;
    clast_image image;
    unsigned char zeros[100] = {0};
    assert_int_equal(decode(f, zeros, sizeof zeros, &image), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(DECODE(f, "{\n    \"asset\": {\"version\": \"2.0\"}}", &image), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(DECODE(f, "# a model\nv 0 0 0\nv 1 0 0\n", &image), CLAST_ERROR_UNSUPPORTED);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    clast_image image;
    for (long blocks = 0; blocks < 2; blocks++) {
        f->blocks_left = blocks;
        assert_int_equal(DECODE(f, HEAD("\0", "\3", NO_PALETTE, "\2", "\1", "\x08", "\x20") "\7\xff", &image),
                         CLAST_ERROR_OUT_OF_MEMORY);
        f->blocks_left = -1;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(colours_of_all_sizes_are_read),     LOADER_TEST(pictures_begin_at_any_corner),
        LOADER_TEST(runs_may_pass_the_end_of_a_row),    LOADER_TEST(palettes_of_all_sizes_are_read),
        LOADER_TEST(a_footer_says_what_alpha_means),    LOADER_TEST(every_cut_and_every_index_outside_is_refused),
        LOADER_TEST(other_files_are_not_taken_for_tga), LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
