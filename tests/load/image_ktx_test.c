// SPDX-License-Identifier: Apache-2.0
// KTX files of both versions, written here by hand.
#include "loader_fixture.h"

#include <zstd.h>

#include "load/image.h"

enum { FILE_SIZE = 1024 };

typedef struct ktx_file {
    unsigned char data[FILE_SIZE];
    size_t size;
    bool is_swapped;
} ktx_file;

static void put_word(ktx_file *file, size_t at, uint32_t word)
{
    for (size_t i = 0; i < 4; i++) {
        file->data[at + i] = (unsigned char)(word >> 8 * (file->is_swapped ? 3 - i : i));
    }
}

static void append(ktx_file *file, const void *data, size_t size)
{
    assert_true(file->size + size <= FILE_SIZE);
    memcpy(file->data + file->size, data, size);
    file->size += size;
}

static clast_status decode(fixture *f, const ktx_file *file, clast_image *image)
{
    void *copy = malloc(file->size + (file->size == 0)); // exactly that size, for the address sanitizer
    assert_non_null(copy);
    memcpy(copy, file->data, file->size);
    clast_status status = clast_decode_image(f->context, "picture", copy, file->size, image);
    free(copy);
    return status;
}

static void assert_pixels(fixture *f, const ktx_file *file, uint32_t channels, clast_pixel_type type,
                          const void *expected, size_t size)
{
    clast_image image;
    assert_ok(f->context, decode(f, file, &image));
    assert_int_equal(image.channels, channels);
    assert_int_equal(image.type, type);
    assert_memory_equal(image.pixels, expected, size);
    clast_image_free(f->context, &image);
}

static void assert_refused_file(fixture *f, const ktx_file *file, clast_status expected, const char *words)
{
    clast_image image;
    assert_int_equal(decode(f, file, &image), expected);
    assert_null(image.pixels);
    if (strstr(clast_context_error(f->context), words) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", clast_context_error(f->context), words);
    }
}

// --------------------------------------------------------------------------------------------------- the older version

typedef struct older_kind {
    uint32_t type, type_size, layout, internal_format;
} older_kind;

static const older_kind older_rgb = {0x1401, 1, 0x1907, 0x8051}, older_bgra = {0x1401, 1, 0x80e1, 0x8058},
                        older_grey = {0x1401, 1, 0x1909, 0x8040}, older_deep = {0x1403, 2, 0x1903, 0x822a},
                        older_half = {0x140b, 2, 0x1908, 0x881a}, older_bc1 = {0, 1, 0, 0x83f0},
                        older_565 = {0x8363, 2, 0x1907, 0x8d62}, older_whole = {0x1405, 4, 0x8d94, 0x8236};

static ktx_file begin_older(older_kind kind, uint32_t width, uint32_t height, bool is_swapped)
{
    ktx_file file = {.is_swapped = is_swapped};
    append(&file, "\xabKTX 11\xbb\r\n\x1a\n", 12);
    const uint32_t words[13] = {
        0x04030201, kind.type, kind.type_size, kind.layout, kind.internal_format, 0, width, height, 0, 0, 1, 1, 0};
    for (size_t i = 0; i < 13; i++) {
        put_word(&file, 12 + 4 * i, words[i]);
    }
    file.size = 64 + 4;
    return file;
}

static void older_rows_are_padded_to_four_bytes(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_older(older_rgb, 1, 2, false);
    append(&file, "\1\2\3\0\4\5\6\0", 8);
    assert_pixels(f, &file, 3, CLAST_PIXEL_UNORM8, (const uint8_t[]){1, 2, 3, 4, 5, 6}, 6);
    file.size--; // nobody needs the last padding, but a writer that left it out is not to be trusted
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "too short");
}

static void layouts_say_the_order_of_channels(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_older(older_bgra, 1, 1, false);
    append(&file, "\1\2\3\4", 4);
    assert_pixels(f, &file, 4, CLAST_PIXEL_UNORM8, (const uint8_t[]){3, 2, 1, 4}, 4);
    file = begin_older(older_grey, 4, 1, false);
    append(&file, "\1\2\3\4", 4);
    assert_pixels(f, &file, 1, CLAST_PIXEL_UNORM8, (const uint8_t[]){1, 2, 3, 4}, 4);
    file = begin_older(older_565, 2, 1, false);
    append(&file, "\x1f\xf8\xe0\x07", 4);
    assert_pixels(f, &file, 3, CLAST_PIXEL_UNORM8, (const uint8_t[]){255, 0, 255, 0, 255, 0}, 6);
}

static void older_files_have_either_order_of_bytes(void **state)
{
    fixture *f = *state;
    for (int swapped = 0; swapped < 2; swapped++) {
        ktx_file file = begin_older(older_deep, 2, 1, swapped != 0);
        append(&file, swapped ? "\x12\x34\x56\x78" : "\x34\x12\x78\x56", 4);
        assert_pixels(f, &file, 1, CLAST_PIXEL_UNORM16, (const uint16_t[]){0x1234, 0x5678}, 4);
    }
    ktx_file file = begin_older(older_half, 1, 1, true);
    append(&file, "\x3c\0\xc0\0\0\0\x38\0", 8);
    assert_pixels(f, &file, 4, CLAST_PIXEL_FLOAT, (const float[]){1.0f, -2.0f, 0.0f, 0.5f}, 16);
}

static void orientation_turns_pictures(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *value;
        uint8_t expected[8];
    } cases[] = {{"S=r,T=d", {1, 2, 3, 4, 5, 6, 7, 8}},
                 {"S=r,T=u", {5, 6, 7, 8, 1, 2, 3, 4}},
                 {"S=l,T=d", {4, 3, 2, 1, 8, 7, 6, 5}}};
    for (size_t i = 0; i < 3; i++) {
        ktx_file file = begin_older(older_grey, 4, 2, false);
        put_word(&file, 60, 28);
        put_word(&file, 64, 23);
        memcpy(file.data + 68, "KTXorientation", 15);
        memcpy(file.data + 83, cases[i].value, 8);
        file.size = 64 + 28 + 4;
        append(&file, "\1\2\3\4\5\6\7\10", 8);
        assert_pixels(f, &file, 1, CLAST_PIXEL_UNORM8, cases[i].expected, 8);
    }
}

static void broken_older_files_are_refused(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_older(older_bc1, 8, 8, false);
    append(&file, "\0\xf8\0\xf8\0\0\0\0\0\xf8\0\xf8\0\0\0\0\0\xf8\0\xf8\0\0\0\0\0\xf8\0\xf8\0\0\0\0", 32);
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    assert_memory_equal(image.pixels, ((const uint8_t[]){255, 0, 0, 255}), 4);
    clast_image_free(f->context, &image);
    size_t whole = file.size;
    for (file.size = 12; file.size < whole; file.size++) {
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_MALFORMED);
    }
    put_word(&file, 52, 6);
    assert_refused_file(f, &file, CLAST_ERROR_UNSUPPORTED, "one plane image");
    file = begin_older(older_whole, 1, 1, false);
    append(&file, "\0\0\0\0", 4);
    assert_refused_file(f, &file, CLAST_ERROR_UNSUPPORTED, "0x8236");
    file = begin_older(older_rgb, 0xffffffff, 0xffffffff, false);
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "too short");
    file = begin_older(older_grey, 1, 1, false);
    put_word(&file, 60, 0xffffffff);
    append(&file, "\0\0\0\0", 4);
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "ends before");
    put_word(&file, 12, 0);
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "orders of bytes");
}

// --------------------------------------------------------------------------------------------------- the newer version

enum { DESCRIPTOR = 104, LEVEL = 152 };

// A file whose data format descriptor has a colour model and flags.
static ktx_file begin_newer(uint32_t format, uint32_t width, uint32_t height, uint32_t scheme, unsigned char model,
                            unsigned char flags)
{
    ktx_file file = {0};
    append(&file, "\xabKTX 20\xbb\r\n\x1a\n", 12);
    const uint32_t words[] = {format, 1, width, height, 0, 0, 1, 1, scheme, DESCRIPTOR, 44, 0, 0, 0, 0, 0, 0, LEVEL};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        put_word(&file, 12 + 4 * i, words[i]);
    }
    put_word(&file, DESCRIPTOR, 44);
    file.data[DESCRIPTOR + 12] = model;
    file.data[DESCRIPTOR + 15] = flags;
    file.size = LEVEL;
    return file;
}

static void add_level(ktx_file *file, const void *data, size_t size, size_t unpacked)
{
    put_word(file, 88, (uint32_t)size);
    put_word(file, 96, (uint32_t)unpacked);
    append(file, data, size);
}

static void plain_and_packed_levels_are_read(void **state)
{
    fixture *f = *state;
    static const uint8_t rows[6] = {1, 2, 3, 4, 5, 6}; // rows have no padding here
    ktx_file file = begin_newer(23, 1, 2, 0, 1, 0);
    add_level(&file, rows, 6, 6);
    assert_pixels(f, &file, 3, CLAST_PIXEL_UNORM8, rows, 6);
    char packed[256];
    size_t size = ZSTD_compress(packed, sizeof packed, rows, 6, 3);
    assert_false(ZSTD_isError(size));
    file = begin_newer(23, 1, 2, 2, 1, 0);
    add_level(&file, packed, size, 6);
    assert_pixels(f, &file, 3, CLAST_PIXEL_UNORM8, rows, 6);
    put_word(&file, 96, 7);
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "another size");
    put_word(&file, 96, 6);
    file.data[LEVEL] ^= 1;
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "zstd");
    file.data[LEVEL] ^= 1;
    for (size_t cut = 1; cut < size; cut++) {
        put_word(&file, 88, (uint32_t)(size - cut));
        assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "zstd");
    }
}

// 4 x 2, 2 x 1 and 1 x 1 pixels. `cut` bytes are missing at the end; as many levels below the first are expected.
static void assert_levels(fixture *f, const ktx_file *file, size_t cut, uint32_t expected)
{
    clast_image image;
    clast_image_parts parts;
    assert_ok(f->context,
              clast_decode_image_parts(f->context, "picture", file->data, file->size - cut, &image, &parts));
    assert_int_equal(image.width, 4);
    assert_int_equal(parts.levels.count, expected);
    for (uint32_t level = 1; level <= expected; level++) {
        clast_image made = clast_level_image(&image, &parts.levels, level);
        assert_memory_equal(made.pixels, level == 1 ? "\12\13" : "\14", level == 1 ? 2 : 1);
    }
    clast_image_free(f->context, &image);
    clast_levels_free(f->context, &parts.levels);
}

static void levels_of_both_versions_are_read(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_older(older_grey, 4, 2, false);
    put_word(&file, 56, 3);
    put_word(&file, 64, 8);
    append(&file, "\1\2\3\4\5\6\7\10\4\0\0\0\12\13\0\0\4\0\0\0\14\0\0\0", 24);
    assert_levels(f, &file, 0, 2);
    assert_levels(f, &file, 4, 1);
    assert_levels(f, &file, 12, 0);
    put_word(&file, 56, 1);
    assert_levels(f, &file, 0, 0);
    put_word(&file, 56, 0xffffffff);
    assert_levels(f, &file, 0, 2);

    file = begin_newer(9, 4, 2, 0, 1, 0);
    put_word(&file, 40, 3);
    put_word(&file, 48, 200); // the index of three levels lies where the descriptor was
    memset(file.data + 80, 0, 72);
    memset(file.data + 200, 0, 44);
    put_word(&file, 200, 44);
    file.data[212] = 1;
    file.size = 256;
    append(&file, "\14\12\13\1\2\3\4\5\6\7\10", 11); // the smallest comes first
    const uint32_t places[3][2] = {{259, 8}, {257, 2}, {256, 1}};
    for (size_t level = 0; level < 3; level++) {
        put_word(&file, 80 + 24 * level, places[level][0]);
        put_word(&file, 88 + 24 * level, places[level][1]);
        put_word(&file, 96 + 24 * level, places[level][1]);
    }
    assert_levels(f, &file, 0, 2);
    put_word(&file, 128, 0xfffffff0); // the smallest lies beyond the file
    assert_levels(f, &file, 0, 1);
    put_word(&file, 112, 1); // and the other is too short
    assert_levels(f, &file, 0, 0);
}

static void colours_multiplied_by_alpha_are_divided(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_newer(37, 1, 1, 0, 1, 1);
    add_level(&file, "\x20\x40\x80\x80", 4, 4);
    assert_pixels(f, &file, 4, CLAST_PIXEL_UNORM8, (const uint8_t[]){64, 128, 255, 128}, 4);
    file = begin_newer(109, 1, 1, 0, 1, 1);
    add_level(&file, (const float[]){1.0f, 0.5f, 4.0f, 0.5f}, 16, 16);
    assert_pixels(f, &file, 4, CLAST_PIXEL_FLOAT, (const float[]){2.0f, 1.0f, 8.0f, 0.5f}, 16);
}

static void basis_universal_is_refused_by_name(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_newer(0, 4, 4, 1, 163, 0);
    add_level(&file, "\0\0\0\0", 4, 0);
    assert_refused_file(f, &file, CLAST_ERROR_UNSUPPORTED, "Basis Universal");
    file = begin_newer(0, 4, 4, 2, 166, 0);
    add_level(&file, "\0\0\0\0", 4, 16);
    assert_refused_file(f, &file, CLAST_ERROR_UNSUPPORTED, "Basis Universal");
    file = begin_newer(157, 4, 4, 0, 162, 0); // ASTC
    add_level(&file, "\0\0\0\0", 4, 16);
    assert_refused_file(f, &file, CLAST_ERROR_UNSUPPORTED, "Vulkan format 157");
}

static void broken_newer_files_are_refused(void **state)
{
    fixture *f = *state;
    ktx_file file = begin_newer(37, 2, 2, 0, 1, 0);
    add_level(&file, "\1\2\3\4\1\2\3\4\1\2\3\4\1\2\3\4", 16, 16);
    clast_image image;
    assert_ok(f->context, decode(f, &file, &image));
    clast_image_free(f->context, &image);
    size_t whole = file.size;
    for (file.size = 12; file.size < whole; file.size++) {
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_MALFORMED);
    }
    put_word(&file, 84, 0xffffffff); // the level's offset, high word
    assert_refused_file(f, &file, CLAST_ERROR_MALFORMED, "ends before");
    put_word(&file, 84, 0);
    put_word(&file, 36 + 12, 0xfffffff0); // a descriptor outside tells nothing
    assert_ok(f->context, decode(f, &file, &image));
    clast_image_free(f->context, &image);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    char packed[256];
    size_t size = ZSTD_compress(packed, sizeof packed, "\1\2\3\4", 4, 3);
    ktx_file file = begin_newer(37, 1, 1, 2, 1, 0);
    add_level(&file, packed, size, 4);
    clast_image image;
    for (long blocks = 0; blocks < 2; blocks++) {
        f->blocks_left = blocks;
        assert_int_equal(decode(f, &file, &image), CLAST_ERROR_OUT_OF_MEMORY);
        f->blocks_left = -1;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(older_rows_are_padded_to_four_bytes),    LOADER_TEST(layouts_say_the_order_of_channels),
        LOADER_TEST(older_files_have_either_order_of_bytes), LOADER_TEST(orientation_turns_pictures),
        LOADER_TEST(broken_older_files_are_refused),         LOADER_TEST(plain_and_packed_levels_are_read),
        LOADER_TEST(levels_of_both_versions_are_read),       LOADER_TEST(colours_multiplied_by_alpha_are_divided),
        LOADER_TEST(basis_universal_is_refused_by_name),     LOADER_TEST(broken_newer_files_are_refused),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
