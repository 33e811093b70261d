// SPDX-License-Identifier: Apache-2.0
// EXR files that the writer does not make: tiles, half and whole numbers, windows that differ, layers.
#include "test.h"

#include <openexr.h>
#include <string.h>
#include <unistd.h>

#include "clast/image.h"

typedef struct exr_file {
    char path[64];
    exr_context_t file;
} exr_file;

static exr_file begin(exr_storage_t storage, exr_attr_box2i_t display, exr_attr_box2i_t data,
                      exr_compression_t compression)
{
    exr_file made = {.path = "/tmp/clast-exr-XXXXXX"};
    int descriptor = mkstemp(made.path);
    assert_true(descriptor >= 0);
    close(descriptor);
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    int part;
    exr_attr_v2f_t centre = {{{0.0f, 0.0f}}};
    assert_int_equal(exr_start_write(&made.file, made.path, EXR_WRITE_FILE_DIRECTLY, &settings), 0);
    assert_int_equal(exr_add_part(made.file, NULL, storage, &part), 0);
    assert_int_equal(exr_initialize_required_attr(made.file, 0, &display, &data, 1.0f, &centre, 1.0f,
                                                  EXR_LINEORDER_INCREASING_Y, compression),
                     0);
    return made;
}

static void add_channel(exr_file *file, const char *name, exr_pixel_type_t type)
{
    assert_int_equal(exr_add_channel(file->file, 0, name, type, EXR_PERCEPTUALLY_LINEAR, 1, 1), 0);
}

// Writes a chunk whose channels are all the same words, one after the other.
static void write_part_chunk(exr_file *file, int part, exr_chunk_info_t *chunk, const void *words, int32_t size)
{
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(file->file, part, chunk, &encoder), 0);
    for (int i = 0; i < encoder.channel_count; i++) {
        encoder.channels[i].user_pixel_stride = size;
        encoder.channels[i].user_line_stride = size * chunk->width;
        encoder.channels[i].encode_from_ptr = words;
    }
    assert_int_equal(exr_encoding_choose_default_routines(file->file, part, &encoder), 0);
    assert_int_equal(exr_encoding_run(file->file, part, &encoder), 0);
    exr_encoding_destroy(file->file, &encoder);
}

static void write_chunk(exr_file *file, exr_chunk_info_t *chunk, const void *words, int32_t size)
{
    write_part_chunk(file, 0, chunk, words, size);
}

static clast_status finish(clast_context *context, exr_file *file, clast_image *image)
{
    assert_int_equal(exr_finish(&file->file), 0);
    clast_status status = clast_image_read(context, file->path, image);
    unlink(file->path);
    return status;
}

static exr_attr_box2i_t window(int left, int top, int right, int bottom)
{
    return (exr_attr_box2i_t){{{{left, top}}}, {{{right, bottom}}}};
}

static void tiles_are_read(void **state)
{
    clast_context *context = *state;
    enum { WIDTH = 20, HEIGHT = 13, SIDE = 8 };
    exr_file file = begin(EXR_STORAGE_TILED, window(0, 0, WIDTH - 1, HEIGHT - 1), window(0, 0, WIDTH - 1, HEIGHT - 1),
                          EXR_COMPRESSION_ZIP);
    assert_int_equal(exr_set_tile_descriptor(file.file, 0, SIDE, SIDE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN), 0);
    add_channel(&file, "Y", EXR_PIXEL_FLOAT);
    assert_int_equal(exr_write_header(file.file), 0);
    for (int ty = 0; ty < 2; ty++) {
        for (int tx = 0; tx < 3; tx++) {
            exr_chunk_info_t chunk;
            assert_int_equal(exr_write_tile_chunk_info(file.file, 0, tx, ty, 0, 0, &chunk), 0);
            float pixels[SIDE * SIDE];
            for (int y = 0; y < chunk.height; y++) {
                for (int x = 0; x < chunk.width; x++) {
                    pixels[y * chunk.width + x] = (float)((ty * SIDE + y) * 100 + tx * SIDE + x);
                }
            }
            write_chunk(&file, &chunk, pixels, 4);
        }
    }
    clast_image image;
    assert_ok(context, finish(context, &file, &image));
    assert_int_equal(image.width, WIDTH);
    assert_int_equal(image.height, HEIGHT);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_true(((const float *)image.pixels)[i] == (float)(i / WIDTH * 100 + i % WIDTH));
    }
    clast_image_free(context, &image);
}

// One row of 4 pixels in one chunk.
static exr_file begin_row(exr_compression_t compression)
{
    return begin(EXR_STORAGE_SCANLINE, window(0, 0, 3, 0), window(0, 0, 3, 0), compression);
}

static clast_status write_row(clast_context *context, exr_file *file, const void *words, int32_t size,
                              clast_image *image)
{
    exr_chunk_info_t chunk;
    assert_int_equal(exr_write_header(file->file), 0);
    assert_int_equal(exr_write_scanline_chunk_info(file->file, 0, 0, &chunk), 0);
    write_chunk(file, &chunk, words, size);
    return finish(context, file, image);
}

static void half_and_whole_numbers_become_floats(void **state)
{
    clast_context *context = *state;
    clast_image image;
    exr_file file = begin_row(EXR_COMPRESSION_NONE);
    add_channel(&file, "Y", EXR_PIXEL_HALF);
    const uint16_t halves[4] = {0x3c00, 0xc000, 0x0001, 0x7bff};
    assert_ok(context, write_row(context, &file, halves, 2, &image));
    const float expected[4] = {1.0f, -2.0f, 5.9604645e-8f, 65504.0f};
    assert_memory_equal(image.pixels, expected, sizeof expected);
    clast_image_free(context, &image);
    file = begin_row(EXR_COMPRESSION_NONE);
    add_channel(&file, "instance", EXR_PIXEL_UINT);
    const uint32_t words[4] = {0, 7, 16777216, 0xffffffffu};
    assert_ok(context, write_row(context, &file, words, 4, &image));
    const float numbers[4] = {0.0f, 7.0f, 16777216.0f, 4294967296.0f};
    assert_memory_equal(image.pixels, numbers, sizeof numbers);
    clast_image_free(context, &image);
}

static void layers_beside_the_picture_are_left_out(void **state)
{
    clast_context *context = *state;
    static const char *const names[] = {"A", "Albedo.B", "Albedo.G", "Albedo.R", "B", "G", "R", "Z"};
    exr_file file = begin_row(EXR_COMPRESSION_NONE);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        add_channel(&file, names[i], EXR_PIXEL_FLOAT);
    }
    const float row[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    clast_image image;
    assert_ok(context, write_row(context, &file, row, 4, &image));
    assert_int_equal(image.channels, 4);
    assert_true(((const float *)image.pixels)[0] == 1.0f && ((const float *)image.pixels)[15] == 4.0f);
    clast_image_free(context, &image);
}

static void channels_that_make_no_picture_are_refused(void **state)
{
    static const char *const pairs[][2] = {{"N.X", "N.Y"}, {"BY", "Y"}};
    for (int i = 0; i < 2; i++) {
        exr_file file = begin_row(EXR_COMPRESSION_NONE);
        add_channel(&file, pairs[i][0], EXR_PIXEL_FLOAT);
        add_channel(&file, pairs[i][1], EXR_PIXEL_FLOAT);
        const float row[4] = {0.0f};
        clast_image image;
        assert_int_equal(write_row(*state, &file, row, 4, &image), CLAST_ERROR_UNSUPPORTED);
    }
}

static void the_first_layer_with_colours_stands_for_a_picture(void **state)
{
    clast_context *context = *state;
    static const char *const names[] = {"Depth.Z", "View.Combined.A", "View.Combined.B", "View.Combined.G",
                                        "View.Combined.R"};
    exr_file file = begin_row(EXR_COMPRESSION_NONE);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        add_channel(&file, names[i], EXR_PIXEL_FLOAT);
    }
    const float row[4] = {1.0f, 2.0f, 3.0f, 4.0f};
    clast_image image;
    assert_ok(context, write_row(context, &file, row, 4, &image));
    assert_int_equal(image.channels, 4);
    assert_true(((const float *)image.pixels)[4] == 2.0f);
    clast_image_free(context, &image);
}

// Two parts: the first has channels that make no picture.
static void the_first_part_with_a_picture_is_read(void **state)
{
    clast_context *context = *state;
    exr_file file = {.path = "/tmp/clast-exr-XXXXXX"};
    int descriptor = mkstemp(file.path);
    assert_true(descriptor >= 0);
    close(descriptor);
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_attr_box2i_t box = window(0, 0, 3, 0);
    exr_attr_v2f_t centre = {{{0.0f, 0.0f}}};
    static const char *const channels[][2] = {{"N.X", "N.Y"}, {"Y", "Z"}};
    assert_int_equal(exr_start_write(&file.file, file.path, EXR_WRITE_FILE_DIRECTLY, &settings), 0);
    for (int part = 0; part < 2; part++) {
        int number;
        assert_int_equal(exr_add_part(file.file, part == 0 ? "vectors" : "picture", EXR_STORAGE_SCANLINE, &number), 0);
        assert_int_equal(exr_initialize_required_attr(file.file, part, &box, &box, 1.0f, &centre, 1.0f,
                                                      EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIPS),
                         0);
        for (int i = 0; i < 2; i++) {
            assert_int_equal(
                exr_add_channel(file.file, part, channels[part][i], EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1), 0);
        }
    }
    assert_int_equal(exr_write_header(file.file), 0);
    const float rows[2][4] = {{9.0f, 9.0f, 9.0f, 9.0f}, {1.0f, 2.0f, 3.0f, 4.0f}};
    for (int part = 0; part < 2; part++) {
        exr_chunk_info_t chunk;
        assert_int_equal(exr_write_scanline_chunk_info(file.file, part, 0, &chunk), 0);
        write_part_chunk(&file, part, &chunk, rows[part], 4);
    }
    clast_image image;
    assert_ok(context, finish(context, &file, &image));
    assert_int_equal(image.channels, 1);
    assert_memory_equal(image.pixels, rows[1], sizeof rows[1]);
    clast_image_free(context, &image);
}

static void what_lies_outside_the_data_window_is_zero(void **state)
{
    clast_context *context = *state;
    exr_file file = begin(EXR_STORAGE_SCANLINE, window(0, 0, 2, 1), window(-1, 1, 1, 1), EXR_COMPRESSION_NONE);
    add_channel(&file, "Y", EXR_PIXEL_FLOAT);
    assert_int_equal(exr_write_header(file.file), 0);
    exr_chunk_info_t chunk;
    assert_int_equal(exr_write_scanline_chunk_info(file.file, 0, 1, &chunk), 0);
    write_chunk(&file, &chunk, (const float[]){5.0f, 6.0f, 7.0f}, 4);
    clast_image image;
    assert_ok(context, finish(context, &file, &image));
    const float expected[6] = {0.0f, 0.0f, 0.0f, 6.0f, 7.0f, 0.0f};
    assert_int_equal(image.width, 3);
    assert_memory_equal(image.pixels, expected, sizeof expected);
    clast_image_free(context, &image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(tiles_are_read),
        CONTEXT_TEST(half_and_whole_numbers_become_floats),
        CONTEXT_TEST(layers_beside_the_picture_are_left_out),
        CONTEXT_TEST(channels_that_make_no_picture_are_refused),
        CONTEXT_TEST(the_first_layer_with_colours_stands_for_a_picture),
        CONTEXT_TEST(the_first_part_with_a_picture_is_read),
        CONTEXT_TEST(what_lies_outside_the_data_window_is_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
