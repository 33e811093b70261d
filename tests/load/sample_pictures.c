// SPDX-License-Identifier: Apache-2.0
// Pictures of a few pixels, in every way of storing them that their writers have.
#include "load/sample_pictures.h"

#include <openexr.h>
#include <png.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <turbojpeg.h>
#include <webp/encode.h>

#include "clast/image.h"

enum { WIDTH = 7, HEIGHT = 5, MOST = 1 << 16 };

// What a writer has given so far.
typedef struct kept {
    unsigned char data[MOST];
    size_t size;
} kept;

static void keep(kept *to, size_t offset, const void *data, size_t size)
{
    sample_check(offset <= sizeof to->data && size <= sizeof to->data - offset ? to : NULL);
    memcpy(to->data + offset, data, size);
    to->size = offset + size > to->size ? offset + size : to->size;
}

static void fill(void *pixels, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        ((unsigned char *)pixels)[i] = (unsigned char)((i * i / 3 + i) & 0x7f); // floats of such bytes are finite
    }
}

static void add(samples *all, const char *name, const void *data, size_t size, size_t header)
{
    sample *added = sample_add(all, name, data, size);
    added->is_picture = true;
    added->header = header < size ? header : size;
}

// ----------------------------------------------------------------------------------------------------- clast's writers

static clast_status hook_map(void *user, const char *path, clast_file_view *view)
{
    (void)user;
    (void)path;
    (void)view;
    return CLAST_ERROR_FILE_NOT_FOUND;
}

static void hook_unmap(void *user, clast_file_view *view)
{
    (void)user;
    (void)view;
}

static clast_status hook_create(void *user, const char *path, void **file)
{
    (void)path;
    *file = user;
    return CLAST_OK;
}

static clast_status hook_write(void *user, void *file, const void *data, size_t size)
{
    (void)user;
    kept *to = file;
    keep(to, to->size, data, size);
    return CLAST_OK;
}

static clast_status hook_commit(void *user, void *file)
{
    (void)user;
    (void)file;
    return CLAST_OK;
}

static void hook_discard(void *user, void *file)
{
    (void)user;
    (void)file;
}

static void add_written(samples *all, const char *name, clast_pixel_type type, uint32_t channels, size_t header)
{
    static kept made;
    static float pixels[WIDTH * 2 * HEIGHT * 4];
    made.size = 0;
    fill(pixels, sizeof pixels);
    clast_context *context = NULL;
    clast_context_desc desc = {
        .threads = 1, .file = {hook_map, hook_unmap, hook_create, hook_write, hook_commit, hook_discard, &made}};
    clast_image image = {WIDTH * 2, HEIGHT, channels, type, pixels};
    bool written = clast_context_create(&desc, &context) == CLAST_OK &&
                   clast_image_write(context, name, &image) == CLAST_OK;
    sample_check(written ? all : NULL);
    clast_context_destroy(context);
    add(all, name, made.data, made.size, header);
}

// ----------------------------------------------------------------------------------------------------------------- PNG

static void png_write(png_structp png, png_bytep data, size_t size)
{
    kept *to = png_get_io_ptr(png);
    keep(to, to->size, data, size);
}

static void png_flush_none(png_structp png)
{
    (void)png;
}

static void add_png(samples *all, const char *name, int bits, int type, bool is_interlaced)
{
    static kept made;
    static unsigned char rows[HEIGHT][WIDTH * 8];
    png_bytep pointers[HEIGHT];
    made.size = 0;
    fill(rows, sizeof rows);
    for (int y = 0; y < HEIGHT; y++) {
        pointers[y] = rows[y];
        for (int x = 0; type == PNG_COLOR_TYPE_PALETTE && x < WIDTH; x++) {
            rows[y][x] &= 3;
        }
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(sample_check(png));
    png_color palette[4] = {{1, 2, 3}, {50, 60, 70}, {200, 0, 0}, {255, 255, 255}};
    png_byte alphas[2] = {0, 100};
    png_set_write_fn(png, &made, png_write, png_flush_none);
    png_set_IHDR(png, info, WIDTH, HEIGHT, bits, type, is_interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (type == PNG_COLOR_TYPE_PALETTE) {
        png_set_PLTE(png, info, palette, 4);
        png_set_tRNS(png, info, alphas, 2, NULL);
    }
    png_set_rows(png, info, pointers);
    png_write_png(png, info, PNG_TRANSFORM_IDENTITY, NULL);
    png_destroy_write_struct(&png, &info);
    add(all, name, made.data, made.size, made.size);
}

// ---------------------------------------------------------------------------------------------------------------- JPEG

static void add_jpeg(samples *all, const char *name, int format, int sampling, int flags)
{
    static unsigned char pixels[16 * 16 * 4];
    unsigned char *made = NULL;
    unsigned long size = 0;
    fill(pixels, sizeof pixels);
    tjhandle handle = sample_check(tjInitCompress());
    int failed = tjCompress2(handle, pixels, 16, 0, 16, format, &made, &size, sampling, 60, flags);
    sample_check(failed == 0 ? made : NULL);
    add(all, name, made, size, size);
    tjFree(made);
    tjDestroy(handle);
}

// ----------------------------------------------------------------------------------------------------------------- EXR

static int64_t exr_write(exr_const_context_t file, void *user, const void *data, uint64_t size, uint64_t offset,
                         exr_stream_error_func_ptr_t error)
{
    (void)file;
    (void)error;
    keep(user, (size_t)offset, data, (size_t)size);
    return (int64_t)size;
}

static void write_chunk(exr_context_t file, exr_chunk_info_t *chunk, const void *values)
{
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    bool begun = exr_encoding_initialize(file, 0, chunk, &encoder) == EXR_ERR_SUCCESS;
    for (int i = 0; begun && i < encoder.channel_count; i++) {
        encoder.channels[i].user_pixel_stride = encoder.channels[i].bytes_per_element;
        encoder.channels[i].user_line_stride = encoder.channels[i].bytes_per_element * chunk->width;
        encoder.channels[i].encode_from_ptr = values;
    }
    bool done = begun && exr_encoding_choose_default_routines(file, 0, &encoder) == EXR_ERR_SUCCESS &&
                exr_encoding_run(file, 0, &encoder) == EXR_ERR_SUCCESS;
    exr_encoding_destroy(file, &encoder);
    sample_check(done ? &encoder : NULL);
}

static void add_exr(samples *all, const char *name, exr_compression_t compression, exr_pixel_type_t type, bool is_tiled)
{
    enum { SIDE = 8 };
    static kept made;
    static uint32_t values[SIDE * 32];
    made.size = 0;
    fill(values, sizeof values);
    exr_context_t file = NULL;
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.user_data = &made;
    settings.write_fn = exr_write;
    exr_attr_box2i_t window = {{{{0, 0}}}, {{{SIDE - 1, SIDE - 1}}}};
    exr_attr_v2f_t centre = {{{0.0f, 0.0f}}};
    int part;
    bool sound = exr_start_write(&file, name, EXR_WRITE_FILE_DIRECTLY, &settings) == EXR_ERR_SUCCESS &&
                 exr_add_part(file, NULL, is_tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &part) ==
                     EXR_ERR_SUCCESS &&
                 exr_initialize_required_attr(file, 0, &window, &window, 1.0f, &centre, 1.0f,
                                              EXR_LINEORDER_INCREASING_Y, compression) == EXR_ERR_SUCCESS;
    static const char *const channels[] = {"B", "G", "R"};
    for (int i = 0; sound && i < 3; i++) {
        sound = exr_add_channel(file, 0, channels[i], type, EXR_PERCEPTUALLY_LINEAR, 1, 1) == EXR_ERR_SUCCESS;
    }
    if (sound && is_tiled) {
        sound = exr_set_tile_descriptor(file, 0, 4, 4, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN) == EXR_ERR_SUCCESS;
    }
    sound = sound && exr_write_header(file) == EXR_ERR_SUCCESS;
    size_t header = made.size;
    int32_t lines = SIDE;
    if (sound && !is_tiled) {
        sound = exr_get_scanlines_per_chunk(file, 0, &lines) == EXR_ERR_SUCCESS;
    }
    sample_check(sound ? &made : NULL);
    for (int y = 0; y < (is_tiled ? 4 : SIDE); y += is_tiled ? 1 : lines) {
        exr_chunk_info_t chunk;
        exr_result_t result = is_tiled ? exr_write_tile_chunk_info(file, 0, y % 2, y / 2, 0, 0, &chunk)
                                       : exr_write_scanline_chunk_info(file, 0, y, &chunk);
        sample_check(result == EXR_ERR_SUCCESS ? &made : NULL);
        write_chunk(file, &chunk, values);
    }
    sample_check(exr_finish(&file) == EXR_ERR_SUCCESS ? &made : NULL);
    add(all, name, made.data, made.size, header + 64);
}

// ----------------------------------------------------------------------------------------------------------------- DDS

static void put_word(unsigned char *to, uint32_t word)
{
    for (uint32_t i = 0; i < 4; i++) {
        to[i] = (unsigned char)(word >> 8 * i);
    }
}

// `code` null: pixels of 32 bits by masks. `newer`: the format in DXGI's numbers, after the code DX10.
static void add_dds(samples *all, const char *name, const char *code, uint32_t newer, uint32_t block)
{
    unsigned char file[512] = "DDS ";
    size_t header = 128 + (newer != 0 ? 20 : 0), size = block != 0 ? 4 * (size_t)block : WIDTH * HEIGHT * 4;
    put_word(file + 4, 124);
    put_word(file + 12, HEIGHT);
    put_word(file + 16, WIDTH);
    put_word(file + 76, 32);
    put_word(file + 80, code != NULL ? 0x4 : 0x41);
    if (code != NULL) {
        memcpy(file + 84, code, 4);
    } else {
        static const uint32_t masks[] = {32, 0xff0000, 0xff00, 0xff, 0xff000000};
        for (uint32_t i = 0; i < 5; i++) {
            put_word(file + 88 + 4 * i, masks[i]);
        }
    }
    if (newer != 0) {
        put_word(file + 128, newer);
        put_word(file + 132, 3);
        put_word(file + 140, 1);
    }
    fill(file + header, size);
    add(all, name, file, header + size, header);
}

// ------------------------------------------------------------------------------------------------------ KTX, TGA, WebP

// Words and pixels after a signature of twelve bytes.
static void add_ktx(samples *all, const char *name, const char *signature, const uint32_t *words, size_t count,
                    size_t size)
{
    unsigned char file[512];
    memcpy(file, signature, 12);
    for (size_t i = 0; i < count; i++) {
        put_word(file + 12 + 4 * i, words[i]);
    }
    fill(file + 12 + 4 * count, size);
    add(all, name, file, 12 + 4 * count + size, 12 + 4 * count);
}

static void add_ktx_of_both_versions(samples *all)
{
    // type, size of it, format (RGBA, RGBA8), width, height, depth, layers, faces, levels, bytes of pairs; the level's bytes
    static const uint32_t older[] = {0x04030201, 0x1401, 1, 0x1908, 0x8058, 0x1908, WIDTH,
                                     HEIGHT,     0,      0, 1,      1,      0,      WIDTH * HEIGHT * 4};
    // format (RGBA8), size of it, width, height, depth, layers, faces, levels, packing; descriptor, pairs and packing's data: where and
    // how long; the level: where, how long, how long when unpacked
    static const uint32_t newer[] = {
        37, 1, WIDTH, HEIGHT, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 104, 0, WIDTH * HEIGHT * 4, 0, WIDTH * HEIGHT * 4,
        0};
    add_ktx(all, "plain.ktx", "\xabKTX 11\xbb\r\n\x1a\n", older, sizeof older / 4, WIDTH * HEIGHT * 4);
    add_ktx(all, "plain.ktx2", "\xabKTX 20\xbb\r\n\x1a\n", newer, sizeof newer / 4, WIDTH * HEIGHT * 4);
}

static void add_tga(samples *all, const char *name, unsigned char kind, unsigned char bits, const void *data,
                    size_t size)
{
    unsigned char file[256] = {0,    (unsigned char)(kind % 8 == 1),
                               kind, 0,
                               0,    (unsigned char)(kind % 8 == 1 ? 2 : 0),
                               0,    (unsigned char)(kind % 8 == 1 ? 24 : 0),
                               0,    0,
                               0,    0,
                               3,    0,
                               2,    0,
                               bits, 0x20};
    size_t palette = kind % 8 == 1 ? 6 : 0;
    memcpy(file + 18 + palette, data, size);
    add(all, name, file, 18 + palette + size, 18);
}

static void add_webp(samples *all, const char *name, bool is_lossless)
{
    static uint8_t pixels[16 * 16 * 4];
    uint8_t *made = NULL;
    fill(pixels, sizeof pixels);
    size_t size = is_lossless ? WebPEncodeLosslessRGBA(pixels, 16, 16, 64, &made)
                              : WebPEncodeRGB(pixels, 16, 16, 48, 50, &made);
    add(all, name, sample_check(made), size, size);
    WebPFree(made);
}

void sample_add_pictures(samples *all)
{
    add_written(all, "rgb.png", CLAST_PIXEL_UNORM8, 3, SIZE_MAX);
    add_written(all, "deep.png", CLAST_PIXEL_UNORM16, 2, SIZE_MAX);
    add_png(all, "grey1.png", 1, PNG_COLOR_TYPE_GRAY, false);
    add_png(all, "palette.png", 4, PNG_COLOR_TYPE_PALETTE, false);
    add_png(all, "interlaced.png", 8, PNG_COLOR_TYPE_RGB_ALPHA, true);
    add_jpeg(all, "grey.jpg", TJPF_GRAY, TJSAMP_GRAY, 0);
    add_jpeg(all, "colour.jpg", TJPF_RGB, TJSAMP_420, 0);
    add_jpeg(all, "progressive.jpg", TJPF_RGB, TJSAMP_422, TJFLAG_PROGRESSIVE);
    add_jpeg(all, "cmyk.jpg", TJPF_CMYK, TJSAMP_444, 0);
    add_written(all, "runs.hdr", CLAST_PIXEL_FLOAT, 3, 80);
    static const char flat[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n+Y 2 -X 3\n"
                               "\x80\x40\x20\x81\x01\x01\x01\x02\x10\x10\x10\x80\x11\x12\x13\x84\x7f\x01\x02\x7f";
    add(all, "flat.hdr", flat, sizeof flat - 1, 70);
    add_written(all, "grey.pfm", CLAST_PIXEL_FLOAT, 1, 24);
    add_written(all, "colour.pfm", CLAST_PIXEL_FLOAT, 3, 24);
    add_written(all, "zip.exr", CLAST_PIXEL_FLOAT, 4, 400);
    add_exr(all, "none.exr", EXR_COMPRESSION_NONE, EXR_PIXEL_HALF, false);
    add_exr(all, "rle.exr", EXR_COMPRESSION_RLE, EXR_PIXEL_HALF, false);
    add_exr(all, "zips.exr", EXR_COMPRESSION_ZIPS, EXR_PIXEL_UINT, false);
    add_exr(all, "piz.exr", EXR_COMPRESSION_PIZ, EXR_PIXEL_HALF, false);
    add_exr(all, "pxr24.exr", EXR_COMPRESSION_PXR24, EXR_PIXEL_FLOAT, false);
    add_exr(all, "b44.exr", EXR_COMPRESSION_B44, EXR_PIXEL_HALF, false);
    add_exr(all, "tiles.exr", EXR_COMPRESSION_RLE, EXR_PIXEL_FLOAT, true);
    add_dds(all, "bc1.dds", "DXT1", 0, 8);
    add_dds(all, "bc3.dds", "DXT5", 0, 16);
    add_dds(all, "bc6.dds", "DX10", 95, 16);
    add_dds(all, "bc7.dds", "DX10", 98, 16);
    add_dds(all, "masks.dds", NULL, 0, 0);
    add_ktx_of_both_versions(all);
    add_tga(all, "colour.tga", 2, 24, "abcdefghijklmnopqr", 18);
    add_tga(all, "runs.tga", 10, 16, "\x83\x11\x22\x01\x33\x44\x55\x66", 8);
    add_tga(all, "palette.tga", 1, 8, "\0\1\0\1\1\0", 6);
    add_webp(all, "lossy.webp", false);
    add_webp(all, "lossless.webp", true);
}
