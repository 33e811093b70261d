// SPDX-License-Identifier: Apache-2.0
// JPEG and WebP pictures that their own libraries wrote here.
#include "loader_fixture.h"

#include <turbojpeg.h>
#include <webp/encode.h>

#include "load/image.h"

enum { WIDTH = 24, HEIGHT = 16 };

static clast_status decode(fixture *f, const void *data, size_t size, clast_image *image)
{
    void *copy = malloc(size + (size == 0)); // exactly that size, for the address sanitizer
    assert_non_null(copy);
    memcpy(copy, data, size);
    clast_status status = clast_decode_image(f->context, "picture", copy, size, image);
    free(copy);
    return status;
}

// ---------------------------------------------------------------------------------------------------------------- JPEG

// A picture of one colour, of three or four components.
static unsigned char *write_jpeg(const unsigned char *colour, int format, int sampling, int flags, unsigned long *size)
{
    unsigned char pixels[WIDTH * HEIGHT * 4], *jpeg = NULL;
    int components = format == TJPF_CMYK ? 4 : 3;
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        memcpy(pixels + i * (size_t)components, colour, (size_t)components);
    }
    tjhandle handle = tjInitCompress();
    assert_non_null(handle);
    assert_int_equal(tjCompress2(handle, pixels, WIDTH, 0, HEIGHT, format, &jpeg, size, sampling, 100, flags), 0);
    tjDestroy(handle);
    return jpeg;
}

static void assert_colour(const clast_image *image, int red, int green, int blue)
{
    const uint8_t *pixels = image->pixels;
    assert_int_equal(image->width, WIDTH);
    assert_int_equal(image->height, HEIGHT);
    assert_int_equal(image->channels, 3);
    for (size_t i = 0; i < WIDTH * HEIGHT; i++) {
        if (abs(pixels[3 * i] - red) > 2 || abs(pixels[3 * i + 1] - green) > 2 || abs(pixels[3 * i + 2] - blue) > 2) {
            fail_msg("pixel %zu is %d %d %d, expected %d %d %d", i, pixels[3 * i], pixels[3 * i + 1], pixels[3 * i + 2],
                     red, green, blue);
        }
    }
}

static void progressive_jpeg_is_read(void **state)
{
    fixture *f = *state;
    static const unsigned char colour[3] = {200, 100, 50};
    for (int sampling = TJSAMP_444; sampling <= TJSAMP_420; sampling++) {
        unsigned long size = 0;
        unsigned char *jpeg = write_jpeg(colour, TJPF_RGB, sampling, TJFLAG_PROGRESSIVE, &size);
        clast_image image;
        assert_ok(f->context, decode(f, jpeg, size, &image));
        assert_colour(&image, 200, 100, 50);
        clast_image_free(f->context, &image);
        tjFree(jpeg);
    }
}

// The library writes the segment by which Adobe's programs say that inks are inverted: 255 is no ink.
static void inks_of_adobe_are_inverted(void **state)
{
    fixture *f = *state;
    static const unsigned char inks[4] = {255, 128, 64, 200};
    unsigned long size = 0;
    unsigned char *jpeg = write_jpeg(inks, TJPF_CMYK, TJSAMP_444, 0, &size);
    clast_image image;
    assert_ok(f->context, decode(f, jpeg, size, &image));
    assert_colour(&image, 200, 100, 50);
    clast_image_free(f->context, &image);
    tjFree(jpeg);
}

// The library stores luma and chroma; without the segment they are taken for inks: 55, 128, 128 of 255, and black.
static void inks_of_others_are_as_they_are(void **state)
{
    fixture *f = *state;
    static const unsigned char inks[4] = {200, 200, 200, 55};
    unsigned long size = 0;
    unsigned char *jpeg = write_jpeg(inks, TJPF_CMYK, TJSAMP_444, 0, &size);
    size_t at = 2; // without the segment
    while (at + 16 < size && !(jpeg[at] == 0xff && jpeg[at + 1] == 0xee && memcmp(jpeg + at + 4, "Adobe", 5) == 0)) {
        at++;
    }
    assert_true(at + 16 < size);
    memmove(jpeg + at, jpeg + at + 16, size - at - 16);
    clast_image image;
    assert_ok(f->context, decode(f, jpeg, size - 16, &image));
    assert_colour(&image, 157, 100, 100);
    clast_image_free(f->context, &image);
    tjFree(jpeg);
}

// ---------------------------------------------------------------------------------------------------------------- WebP

static void fill(uint8_t *pixels, size_t channels)
{
    for (size_t i = 0; i < WIDTH * HEIGHT * channels; i++) {
        pixels[i] = (uint8_t)(i * i / 11 + (channels == 4 && i % 4 == 3 ? i : 0)); // no alpha of 0, which hides colours
        pixels[i] |= channels == 4 && i % 4 == 3 ? 1 : 0;
    }
}

static void lossless_webp_keeps_every_bit(void **state)
{
    fixture *f = *state;
    for (uint32_t channels = 3; channels <= 4; channels++) {
        uint8_t pixels[WIDTH * HEIGHT * 4], *webp = NULL;
        fill(pixels, channels);
        size_t size = channels == 3 ? WebPEncodeLosslessRGB(pixels, WIDTH, HEIGHT, WIDTH * 3, &webp)
                                    : WebPEncodeLosslessRGBA(pixels, WIDTH, HEIGHT, WIDTH * 4, &webp);
        assert_true(size > 0);
        clast_image image;
        assert_ok(f->context, decode(f, webp, size, &image));
        assert_int_equal(image.width, WIDTH);
        assert_int_equal(image.channels, channels);
        assert_int_equal(image.type, CLAST_PIXEL_UNORM8);
        assert_memory_equal(image.pixels, pixels, (size_t)WIDTH * HEIGHT * channels);
        clast_image_free(f->context, &image);
        WebPFree(webp);
    }
}

static void lossy_webp_is_read(void **state)
{
    fixture *f = *state;
    uint8_t pixels[WIDTH * HEIGHT * 3], *webp = NULL;
    for (size_t i = 0; i < sizeof pixels; i++) {
        pixels[i] = (uint8_t)(i % 3 == 0 ? 200 : i % 3 == 1 ? 100 : 50);
    }
    size_t size = WebPEncodeRGB(pixels, WIDTH, HEIGHT, WIDTH * 3, 100.0f, &webp);
    assert_true(size > 0);
    clast_image image;
    assert_ok(f->context, decode(f, webp, size, &image));
    assert_colour(&image, 200, 100, 50);
    clast_image_free(f->context, &image);
    WebPFree(webp);
}

static void broken_webp_is_refused(void **state)
{
    fixture *f = *state;
    uint8_t pixels[WIDTH * HEIGHT * 4], *webp = NULL;
    fill(pixels, 4);
    size_t size = WebPEncodeRGBA(pixels, WIDTH, HEIGHT, WIDTH * 4, 60.0f, &webp);
    assert_true(size > 40);
    clast_image image;
    for (size_t cut = 0; cut + 2 < size; cut++) { // the last byte may be padding
        assert_int_not_equal(decode(f, webp, cut, &image), CLAST_OK);
        assert_null(image.pixels);
    }
    uint32_t random = 1;
    for (int i = 0; i < 2000; i++) {
        size_t at = (random >> 8) % size;
        uint8_t kept = webp[at];
        webp[at] = (uint8_t)(random >> 24);
        decode(f, webp, size, &image);
        clast_image_free(f->context, &image);
        webp[at] = kept;
        random = random * 1664525u + 1013904223u;
    }
    f->blocks_left = 0;
    assert_int_equal(decode(f, webp, size, &image), CLAST_ERROR_OUT_OF_MEMORY);
    f->blocks_left = -1;
    WebPFree(webp);
}

// The header of the extended format, which says that frames follow.
static void moving_webp_is_refused_by_name(void **state)
{
    fixture *f = *state;
    static const char file[] = "RIFF\x20\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x07\0\0\x07\0\0ANIM\x06\0\0\0\0\0\0\0\0\0";
    clast_image image;
    assert_int_equal(decode(f, file, sizeof file - 1, &image), CLAST_ERROR_UNSUPPORTED);
    assert_non_null(strstr(clast_context_error(f->context), "moving picture"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(progressive_jpeg_is_read),
        LOADER_TEST(inks_of_adobe_are_inverted),
        LOADER_TEST(inks_of_others_are_as_they_are),
        LOADER_TEST(lossless_webp_keeps_every_bit),
        LOADER_TEST(lossy_webp_is_read),
        LOADER_TEST(broken_webp_is_refused),
        LOADER_TEST(moving_webp_is_refused_by_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
