// SPDX-License-Identifier: Apache-2.0
// Images from bytes written here by hand, limits, and broken files.
#include "loader_fixture.h"

#include "load/image.h"

static clast_status decode(fixture *f, const void *data, size_t size, clast_image *image)
{
    // a block of exactly that size: the address sanitizer sees reads beyond it
    void *copy = malloc(size + (size == 0));
    assert_non_null(copy);
    memcpy(copy, data, size);
    clast_status status = clast_decode_image(f->context, "picture", copy, size, image);
    free(copy);
    if (status != CLAST_OK) {
        assert_null(image->pixels);
    }
    return status;
}

#define DECODE(f, text, image) decode(f, text, sizeof(text) - 1, image)

static void assert_picture_refused(fixture *f, const void *data, size_t size, clast_status expected, const char *words)
{
    clast_image image;
    clast_status status = decode(f, data, size, &image);
    const char *error = clast_context_error(f->context);
    clast_image_free(f->context, &image);
    if (status != expected || strstr(error, words) == NULL ||
        strncmp(error, "picture: ", 9) * strncmp(error, "picture, ", 9) != 0) {
        fail_msg("expected \"%s\" with \"%s\", got \"%s\" with \"%s\"", clast_status_text(expected), words,
                 clast_status_text(status), error);
    }
}

#define ASSERT_REFUSED(f, text, expected, words) assert_picture_refused(f, text, sizeof(text) - 1, expected, words)

#define HDR "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\n\n"

static void flat_and_old_runs_of_hdr_are_read(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, DECODE(f, HDR "-Y 1 +X 5\n\x80\x40\x20\x81\x01\x01\x01\x03\x10\x10\x10\x80", &image));
    ASSERT_FLOATS(image.pixels, 0, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 1, 0.5f, 0.25f, 0.0625f, 0.0625f,
                  0.0625f);
    clast_image_free(f->context, &image);
}

static void runs_of_old_runs_count_256_fold(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, DECODE(f, HDR "-Y 1 +X 259\n\x80\x80\x80\x81\x01\x01\x01\x02\x01\x01\x01\x01", &image));
    assert_true(((const float *)image.pixels)[3 * 258] == 1.0f);
    clast_image_free(f->context, &image);
}

static void new_runs_of_hdr_are_read(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context,
              DECODE(f, HDR "-Y 1 +X 8\n\x02\x02\x00\x08\x88\x80\x08\1\2\3\4\5\6\7\x08\x88\x20\x88\x88", &image));
    ASSERT_FLOATS(image.pixels, 0, 128, 1, 32, 128, 2, 32, 128, 3, 32);
    clast_image_free(f->context, &image);
}

static void hdr_pictures_may_be_flipped(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, DECODE(f, HDR "+Y 2 -X 2\n\1\0\0\x88\2\0\0\x88\3\0\0\x88\4\0\0\x88", &image));
    ASSERT_FLOATS(image.pixels, 0, 4, 0, 0, 3, 0, 0, 2, 0, 0, 1, 0, 0);
    clast_image_free(f->context, &image);
    ASSERT_REFUSED(f, HDR "+X 2 -Y 2\n", CLAST_ERROR_UNSUPPORTED, "columns");
}

static void exposures_of_hdr_are_taken_out(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, DECODE(f, "#?RGBE\nEXPOSURE=4\nEXPOSURE= 0.5\n\n-Y 1 +X 1\n\x80\x80\x80\x81", &image));
    ASSERT_FLOATS(image.pixels, 0, 0.5f, 0.5f, 0.5f);
    clast_image_free(f->context, &image);
}

static void broken_hdr_is_refused(void **state)
{
    fixture *f = *state;
    ASSERT_REFUSED(f, "#?RADIANCE\n", CLAST_ERROR_MALFORMED, "empty line");
    ASSERT_REFUSED(f, "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", CLAST_ERROR_UNSUPPORTED, "not RGBE");
    ASSERT_REFUSED(f, "#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n", CLAST_ERROR_MALFORMED, "exposure");
    ASSERT_REFUSED(f, HDR "1 1\n", CLAST_ERROR_MALFORMED, "-Y 512 +X 1024");
    ASSERT_REFUSED(f, HDR "-Y 0 +X 1\n", CLAST_ERROR_MALFORMED, "at least 1 x 1");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 100000\n1234", CLAST_ERROR_LIMIT, "65536");
    ASSERT_REFUSED(f, HDR "-Y 60000 +X 60000\n1234", CLAST_ERROR_MALFORMED, "too short");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 2\n\x80\x80\x80\x81", CLAST_ERROR_MALFORMED, "ends inside");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 2\n\1\1\1\1\1\1\1\1", CLAST_ERROR_MALFORMED, "run leaves");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 8\n\2\2\0\x09", CLAST_ERROR_MALFORMED, "another width");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 8\n\2\2\0\x08\x89\1", CLAST_ERROR_MALFORMED, "run leaves");
    ASSERT_REFUSED(f, HDR "-Y 1 +X 8\n\2\2\0\x08\0", CLAST_ERROR_MALFORMED, "run leaves");
}

static void pfm_of_both_orders_is_read_from_the_bottom(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, DECODE(f, "Pf\n1 2\n-1.0\n\0\0\x80\x3f\0\0\0\x40", &image));
    ASSERT_FLOATS(image.pixels, 0, 2, 1);
    clast_image_free(f->context, &image);
    assert_ok(f->context, DECODE(f, "PF 1 1 2 \x3f\x80\0\0\x40\0\0\0\xbf\x80\0\0", &image));
    ASSERT_FLOATS(image.pixels, 0, 1, 2, -1);
    clast_image_free(f->context, &image);
    ASSERT_REFUSED(f, "PF\n1 1\n-1\n\0\0\0\0", CLAST_ERROR_MALFORMED, "row 0");
    ASSERT_REFUSED(f, "PF\n1 x\n-1\n", CLAST_ERROR_MALFORMED, "width, height and scale");
    ASSERT_REFUSED(f, "PF\n1 1\n0\n", CLAST_ERROR_MALFORMED, "scale");
    ASSERT_REFUSED(f, "PF\n-1 1\n1\n", CLAST_ERROR_MALFORMED, "width");
    ASSERT_REFUSED(f, "PF\n30000 30000\n1\n", CLAST_ERROR_LIMIT, "bytes");
}

static void what_is_no_image_is_refused(void **state)
{
    fixture *f = *state;
    ASSERT_REFUSED(f, "", CLAST_ERROR_MALFORMED, "empty");
    ASSERT_REFUSED(f, "GIF89a", CLAST_ERROR_UNSUPPORTED,
                   "expected PNG, JPEG, WebP, Radiance HDR, EXR, PFM, TGA, DDS or KTX");
    clast_image image;
    assert_int_equal(clast_image_read(f->context, "nowhere.png", &image), CLAST_ERROR_FILE_NOT_FOUND);
}

// ------------------------------------------------------------------------------------------------------- broken files

// A PNG of 1 x 1 pixels with the given size in its header; the checksum is right.
static void make_png_header(unsigned char png[33], uint32_t width, uint32_t height)
{
    static const unsigned char head[16] = "\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR";
    memcpy(png, head, 16);
    for (int i = 0; i < 4; i++) {
        png[16 + i] = (unsigned char)(width >> (24 - 8 * i));
        png[20 + i] = (unsigned char)(height >> (24 - 8 * i));
    }
    memcpy(png + 24, (unsigned char[]){8, 6, 0, 0, 0}, 5);
    uint32_t crc = 0xffffffffu;
    for (int i = 12; i < 29; i++) {
        crc ^= png[i];
        for (int k = 0; k < 8; k++) {
            crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
        }
    }
    for (int i = 0; i < 4; i++) {
        png[29 + i] = (unsigned char)(~crc >> (24 - 8 * i));
    }
}

static void sizes_that_the_file_cannot_hold_allocate_nothing(void **state)
{
    fixture *f = *state;
    unsigned char png[33 + 12] = {0};
    make_png_header(png, 16000, 16000);
    memcpy(png + 33, (unsigned char[]){0, 0, 0, 0, 'I', 'D', 'A', 'T', 0x35, 0xaf, 0x06, 0x1e}, 12);
    assert_picture_refused(f, png, sizeof png, CLAST_ERROR_MALFORMED, "too short");
    assert_true(clast_context_memory_peak(f->context) < 1 << 20);
}

static clast_status keep_create(void *user, const char *path, void **file)
{
    (void)path;
    *file = user;
    return CLAST_OK;
}

// Files made by the writers are the samples: the output is kept in memory.
typedef struct sample {
    unsigned char data[8192];
    size_t size;
} sample;

static clast_status keep_write(void *user, void *file, const void *data, size_t size)
{
    (void)file;
    sample *to = user;
    if (size > sizeof to->data - to->size) {
        return CLAST_ERROR_FILE_WRITE;
    }
    memcpy(to->data + to->size, data, size);
    to->size += size;
    return CLAST_OK;
}

static clast_status keep_commit(void *user, void *file)
{
    (void)user;
    (void)file;
    return CLAST_OK;
}

static void keep_discard(void *user, void *file)
{
    (void)user;
    (void)file;
}

static sample make_sample(const char *name, clast_pixel_type type, uint32_t channels)
{
    static sample made;
    static unsigned char pixels[16 * 12 * 3 * 4];
    for (size_t i = 0; i < sizeof pixels; i++) {
        pixels[i] = (unsigned char)(i * i / 7 & 0x7f);
    }
    made.size = 0;
    clast_file_hook hook = {memory_files_map, memory_files_unmap, keep_create, keep_write,
                            keep_commit,      keep_discard,       &made};
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .file = hook}, &context), CLAST_OK);
    clast_image image = {16, 12, channels, type, pixels};
    assert_ok(context, clast_image_write(context, name, &image));
    clast_context_destroy(context);
    return made;
}

static void assert_harmless(fixture *f, const unsigned char *data, size_t size, uint32_t changes)
{
    clast_image image;
    unsigned char copy[8192];
    for (size_t length = 0; length < size; length++) {
        assert_int_not_equal(decode(f, data, length, &image), CLAST_OK);
    }
    uint32_t random = 4711;
    for (uint32_t i = 0; i < changes; i++) {
        memcpy(copy, data, size);
        for (uint32_t k = 0; k <= i % 4; k++) {
            random = random * 1664525u + 1013904223u;
            size_t at = (random >> 8) % size;
            random = random * 1664525u + 1013904223u;
            copy[at] = (unsigned char)(random >> 24);
        }
        decode(f, copy, size, &image);
        clast_image_free(f->context, &image);
    }
}

static void broken_pictures_do_no_harm(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *name;
        clast_pixel_type type;
        uint32_t channels;
    } cases[] = {
        {"a.png", CLAST_PIXEL_UNORM8, 3}, {"a.png", CLAST_PIXEL_UNORM16, 2}, {"a.pfm", CLAST_PIXEL_FLOAT, 1},
        {"a.hdr", CLAST_PIXEL_FLOAT, 3},  {"a.exr", CLAST_PIXEL_FLOAT, 3},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sample made = make_sample(cases[i].name, cases[i].type, cases[i].channels);
        clast_image image;
        assert_ok(f->context, decode(f, made.data, made.size, &image));
        clast_image_free(f->context, &image);
        assert_harmless(f, made.data, made.size, 3000);
    }
}

// A grey picture of 8 x 8 pixels, all of them middle grey.
static const unsigned char jpeg[] = {
    0xff, 0xd8, 0xff, 0xdb, 0x00, 0x43, 0x00, 1, 1,    1,    1,    1,    1,    1,    1,    1, 1, 1, 1, 1,    1,
    1,    1,    1,    1,    1,    1,    1,    1, 1,    1,    1,    1,    1,    1,    1,    1, 1, 1, 1, 1,    1,
    1,    1,    1,    1,    1,    1,    1,    1, 1,    1,    1,    1,    1,    1,    1,    1, 1, 1, 1, 1,    1,
    1,    1,    1,    1,    1,    1,    1,    1, 0xff, 0xc0, 0x00, 0x0b, 8,    0,    8,    0, 8, 1, 1, 0x11, 0,
    0xff, 0xc4, 0x00, 0x14, 0x00, 1,    0,    0, 0,    0,    0,    0,    0,    0,    0,    0, 0, 0, 0, 0,    0,
    0x00, 0xff, 0xc4, 0x00, 0x14, 0x10, 1,    0, 0,    0,    0,    0,    0,    0,    0,    0, 0, 0, 0, 0,    0,
    0,    0x00, 0xff, 0xda, 0x00, 0x08, 1,    1, 0x00, 0,    63,   0,    0x3f, 0xff, 0xd9,
};

static void a_grey_jpeg_is_read(void **state)
{
    fixture *f = *state;
    clast_image image;
    assert_ok(f->context, decode(f, jpeg, sizeof jpeg, &image));
    assert_int_equal(image.width, 8);
    assert_int_equal(image.channels, 1);
    for (int i = 0; i < 64; i++) {
        assert_int_equal(((const uint8_t *)image.pixels)[i], 128);
    }
    clast_image_free(f->context, &image);
}

static void broken_jpegs_do_no_harm(void **state)
{
    fixture *f = *state;
    clast_image image;
    unsigned char copy[sizeof jpeg];
    for (size_t length = 0; length < sizeof jpeg - 2; length++) {
        assert_int_not_equal(decode(f, jpeg, length, &image), CLAST_OK);
    }
    uint32_t random = 1;
    for (int i = 0; i < 3000; i++) {
        memcpy(copy, jpeg, sizeof jpeg);
        random = random * 1664525u + 1013904223u;
        copy[(random >> 8) % sizeof jpeg] = (unsigned char)(random >> 24);
        decode(f, copy, sizeof copy, &image);
        clast_image_free(f->context, &image);
    }
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    static const char *const names[] = {"a.png", "a.pfm", "a.hdr", "a.exr"};
    for (int i = 0; i < 4; i++) {
        sample made = make_sample(names[i], i == 0 ? CLAST_PIXEL_UNORM8 : CLAST_PIXEL_FLOAT, 3);
        clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
        for (long blocks = 0; status != CLAST_OK; blocks++) {
            clast_image image;
            f->blocks_left = blocks;
            status = decode(f, made.data, made.size, &image);
            f->blocks_left = -1;
            assert_true(status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY);
            clast_image_free(f->context, &image);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(flat_and_old_runs_of_hdr_are_read),
        LOADER_TEST(runs_of_old_runs_count_256_fold),
        LOADER_TEST(new_runs_of_hdr_are_read),
        LOADER_TEST(hdr_pictures_may_be_flipped),
        LOADER_TEST(exposures_of_hdr_are_taken_out),
        LOADER_TEST(broken_hdr_is_refused),
        LOADER_TEST(pfm_of_both_orders_is_read_from_the_bottom),
        LOADER_TEST(what_is_no_image_is_refused),
        LOADER_TEST(sizes_that_the_file_cannot_hold_allocate_nothing),
        LOADER_TEST(broken_pictures_do_no_harm),
        LOADER_TEST(a_grey_jpeg_is_read),
        LOADER_TEST(broken_jpegs_do_no_harm),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
