// SPDX-License-Identifier: Apache-2.0
// Images written and read again, and writing that fails.
#include "test.h"

#include <dirent.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "clast/image.h"

// A folder of its own for each test; the test must leave only `expected` files in it.
typedef struct folder {
    char path[64];
    char file[400];
} folder;

static folder make_folder(void)
{
    folder made = {.path = "/tmp/clast-image-XXXXXX"};
    assert_non_null(mkdtemp(made.path));
    return made;
}

static const char *in(folder *f, const char *name)
{
    snprintf(f->file, sizeof f->file, "%s/%s", f->path, name);
    return f->file;
}

// Removes the folder with its files, and gives how many there were.
static int remove_folder(folder *f)
{
    int count = 0;
    DIR *directory = opendir(f->path);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        if (entry->d_name[0] != '.') {
            count += unlink(in(f, entry->d_name)) == 0;
        }
    }
    closedir(directory);
    rmdir(f->path);
    return count;
}

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

// Pixels of all values; the first columns are alike, so that runs are met.
static void fill(void *pixels, size_t count, clast_pixel_type type)
{
    uint32_t random = 7;
    for (size_t i = 0; i < count; i++) {
        uint32_t value = i % 64 < 40 ? 17 : next_random(&random);
        if (type == CLAST_PIXEL_UNORM8) {
            ((uint8_t *)pixels)[i] = (uint8_t)value;
        } else if (type == CLAST_PIXEL_UNORM16) {
            ((uint16_t *)pixels)[i] = (uint16_t)value;
        } else {
            ((float *)pixels)[i] = ldexpf((float)(value % 4096), (int)(value >> 12) % 40 - 30);
        }
    }
}

static void assert_round_trip(clast_context *context, const char *name, clast_pixel_type type, uint32_t channels,
                              double tolerance)
{
    folder f = make_folder();
    enum { WIDTH = 83, HEIGHT = 21 };
    size_t size = type == CLAST_PIXEL_UNORM8 ? 1 : type == CLAST_PIXEL_UNORM16 ? 2 : 4;
    void *pixels = malloc(WIDTH * HEIGHT * channels * size);
    assert_non_null(pixels);
    fill(pixels, (size_t)WIDTH * HEIGHT * channels, type);
    clast_image image = {WIDTH, HEIGHT, channels, type, pixels}, read;
    assert_ok(context, clast_image_write(context, in(&f, name), &image));
    assert_ok(context, clast_image_read(context, in(&f, name), &read));
    assert_int_equal(read.width, WIDTH);
    assert_int_equal(read.height, HEIGHT);
    assert_int_equal(read.channels, channels);
    assert_int_equal(read.type, type);
    if (tolerance == 0.0) {
        assert_memory_equal(read.pixels, pixels, WIDTH * HEIGHT * channels * size);
    }
    for (size_t i = 0; tolerance > 0.0 && i < WIDTH * HEIGHT; i++) {
        const float *a = (const float *)pixels + 3 * i, *b = (const float *)read.pixels + 3 * i;
        double most = fmax(fmax((double)a[0], (double)a[1]), (double)a[2]);
        for (int c = 0; c < 3; c++) {
            assert_true(fabs((double)a[c] - (double)b[c]) <= tolerance * most);
        }
    }
    clast_image_free(context, &read);
    assert_null(read.pixels);
    free(pixels);
    assert_int_equal(remove_folder(&f), 1);
}

static void png_keeps_every_bit(void **state)
{
    for (uint32_t channels = 1; channels <= 4; channels++) {
        assert_round_trip(*state, "a.png", CLAST_PIXEL_UNORM8, channels, 0.0);
        assert_round_trip(*state, "a.PNG", CLAST_PIXEL_UNORM16, channels, 0.0);
    }
}

static void pfm_keeps_every_bit(void **state)
{
    assert_round_trip(*state, "a.pfm", CLAST_PIXEL_FLOAT, 1, 0.0);
    assert_round_trip(*state, "a.pfm", CLAST_PIXEL_FLOAT, 3, 0.0);
}

static void exr_keeps_every_bit(void **state)
{
    for (uint32_t channels = 1; channels <= 4; channels++) {
        assert_round_trip(*state, "a.exr", CLAST_PIXEL_FLOAT, channels, 0.0);
    }
}

static void hdr_keeps_eight_bits_of_the_largest_channel(void **state)
{
    assert_round_trip(*state, "a.hdr", CLAST_PIXEL_FLOAT, 3, 1.0 / 256.0);
}

static void hdr_of_any_width_is_read_again(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    static float pixels[3 * 300];
    fill(pixels, 3 * 300, CLAST_PIXEL_FLOAT);
    static const uint32_t widths[] = {1, 7, 8, 127, 128, 129, 300};
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; i++) {
        clast_image image = {widths[i], 1, 3, CLAST_PIXEL_FLOAT, pixels}, read;
        assert_ok(context, clast_image_write(context, in(&f, "a.hdr"), &image));
        assert_ok(context, clast_image_read(context, in(&f, "a.hdr"), &read));
        assert_int_equal(read.width, widths[i]);
        clast_image_free(context, &read);
    }
    assert_int_equal(remove_folder(&f), 1);
}

static void hdr_has_a_place_for_odd_values(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    const float pixels[12] = {NAN, -1.0f, 1.0f, INFINITY, 0.0f, 0.0f, 1e-30f, 0.0f, 1e-45f, 0.9999f, 0.5f, 0.25f};
    clast_image image = {4, 1, 3, CLAST_PIXEL_FLOAT, pixels}, read;
    assert_ok(context, clast_image_write(context, in(&f, "a.hdr"), &image));
    assert_ok(context, clast_image_read(context, in(&f, "a.hdr"), &read));
    const float *got = read.pixels;
    assert_true(got[0] == 0.0f && got[1] == 0.0f && got[2] == 1.0f);
    assert_true(got[3] > 1e38f && isfinite(got[3]));
    assert_true(fabs((double)got[6] / 1e-30 - 1.0) < 0.01);
    assert_true(got[9] == 1.0f && got[10] == 0.5f && got[11] == 0.25f);
    clast_image_free(context, &read);
    remove_folder(&f);
}

static void what_a_format_cannot_hold_is_refused(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    const float floats[16] = {0};
    const uint8_t bytes[16] = {0};
    const clast_image grey8 = {2, 2, 1, CLAST_PIXEL_UNORM8, bytes}, float2 = {2, 2, 2, CLAST_PIXEL_FLOAT, floats};
    assert_int_equal(clast_image_write(context, in(&f, "a.png"), &float2), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(clast_image_write(context, in(&f, "a.exr"), &grey8), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(clast_image_write(context, in(&f, "a.pfm"), &float2), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(clast_image_write(context, in(&f, "a.hdr"), &float2), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(clast_image_write(context, in(&f, "a.tiff"), &grey8), CLAST_ERROR_UNSUPPORTED);
    assert_non_null(strstr(clast_context_error(context), ".png, .jpg, .exr, .pfm or .hdr"));
    assert_int_equal(clast_image_write(context, in(&f, "a.png"), NULL), CLAST_ERROR_INVALID_ARGUMENT);
    clast_image none = grey8;
    none.pixels = NULL;
    assert_int_equal(clast_image_write(context, in(&f, "a.png"), &none), CLAST_ERROR_INVALID_ARGUMENT);
    clast_image wide = grey8;
    wide.width = 70000;
    assert_int_equal(clast_image_write(context, in(&f, "a.png"), &wide), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(remove_folder(&f), 0);
}

// ------------------------------------------------------------------------------------------------------------- layers

static bool file_has(const char *path, const void *bytes, size_t size)
{
    static char data[1 << 16];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t length = fread(data, 1, sizeof data, file);
    fclose(file);
    return memmem(data, length, bytes, size) != NULL;
}

static void layers_are_channels_of_their_names(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    enum { WIDTH = 40, HEIGHT = 37 };
    static float colour[WIDTH * HEIGHT * 3], normal[WIDTH * HEIGHT * 3], depth[WIDTH * HEIGHT];
    static uint32_t numbers[WIDTH * HEIGHT];
    fill(colour, WIDTH * HEIGHT * 3, CLAST_PIXEL_FLOAT);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        numbers[i] = i;
        depth[i] = (float)i;
    }
    const clast_image_layer layers[] = {
        {.name = "", .channels = "RGB", .pixels = colour},
        {.name = "Albedo", .channels = "RGB", .pixels = normal},
        {.name = "N", .channels = "XYZ", .pixels = normal},
        {.name = "", .channels = "Z", .pixels = depth},
        {.name = "instance", .channels = "Y", .is_integer = true, .pixels = numbers},
    };
    assert_ok(context, clast_image_write_layers(context, in(&f, "a.exr"), WIDTH, HEIGHT, layers, 5));
    static const char *const names[] = {"Albedo.R", "Albedo.G", "Albedo.B", "N.X", "N.Y", "N.Z", "instance.Y"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        assert_true(file_has(f.file, names[i], strlen(names[i]) + 1));
    }
    // a channel's entry: its name, then its type: 0 for uint, 2 for float
    assert_true(file_has(f.file, "instance.Y\0\0\0\0\0", 15));
    assert_true(file_has(f.file, "\0Z\0\2\0\0\0", 7));
    clast_image read;
    assert_ok(context, clast_image_read(context, f.file, &read));
    assert_int_equal(read.channels, 3);
    assert_memory_equal(read.pixels, colour, sizeof colour);
    clast_image_free(context, &read);
    assert_ok(context, clast_image_write_layers(context, in(&f, "a.exr"), WIDTH, HEIGHT, layers + 4, 1));
    assert_ok(context, clast_image_read(context, f.file, &read));
    assert_int_equal(read.channels, 1);
    assert_true(((const float *)read.pixels)[1234] == 1234.0f);
    clast_image_free(context, &read);
    assert_int_equal(remove_folder(&f), 1);
}

// A part of a picture lies where it belongs in the whole; around it there is nothing.
static void a_window_lies_in_its_picture(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    enum { WIDTH = 9, HEIGHT = 21 };
    static float depth[WIDTH * HEIGHT];
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        depth[i] = (float)(i + 1);
    }
    const clast_image_layer layer = {.name = "", .channels = "Y", .pixels = depth};
    clast_image_window window = {5, 30, WIDTH, HEIGHT, 20, 60};
    assert_ok(context, clast_image_write_window(context, in(&f, "a.exr"), &window, &layer, 1));
    assert_true(file_has(f.file, "dataWindow\0box2i\0\x10\0\0\0\x05\0\0\0\x1e\0\0\0\x0d\0\0\0\x32\0\0\0", 37));
    assert_true(file_has(f.file, "displayWindow\0box2i\0\x10\0\0\0\0\0\0\0\0\0\0\0\x13\0\0\0\x3b\0\0\0", 40));
    clast_image read;
    assert_ok(context, clast_image_read(context, f.file, &read));
    assert_true(read.width == 20 && read.height == 60 && read.channels == 1);
    const float *values = read.pixels;
    for (uint32_t i = 0; i < 20 * 60; i++) {
        uint32_t x = i % 20 - 5, y = i / 20 - 30;
        assert_true(values[i] == (x < WIDTH && y < HEIGHT ? depth[y * WIDTH + x] : 0.0f));
    }
    clast_image_free(context, &read);
    assert_int_equal(remove_folder(&f), 1);
    const clast_image_window wrong[] = {{12, 30, WIDTH, HEIGHT, 20, 60},
                                        {5, 40, WIDTH, HEIGHT, 20, 60},
                                        {5, 30, 0, HEIGHT, 20, 60},
                                        {5, 30, 9, 21, 0, 0}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_int_equal(clast_image_write_window(context, "a.exr", &wrong[i], &layer, 1),
                         CLAST_ERROR_INVALID_ARGUMENT);
    }
}

static void note_layer(void *user, const char *layer)
{
    strcat(user, layer);
    strcat(user, ";");
}

static void layers_are_listed_and_read_by_name(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    enum { WIDTH = 19, HEIGHT = 21, PIXELS = WIDTH * HEIGHT };
    static float colour[PIXELS * 3], normal[PIXELS * 3], place[PIXELS * 2];
    static uint32_t numbers[PIXELS];
    fill(colour, PIXELS * 3, CLAST_PIXEL_FLOAT);
    fill(normal, PIXELS * 3, CLAST_PIXEL_FLOAT);
    fill(place, PIXELS * 2, CLAST_PIXEL_FLOAT);
    for (uint32_t i = 0; i < PIXELS; i++) {
        numbers[i] = i;
    }
    const clast_image_layer layers[] = {{.name = "", .channels = "RGB", .pixels = colour},
                                        {.name = "a.N", .channels = "XYZ", .pixels = normal},
                                        {.name = "", .channels = "Z", .is_integer = true, .pixels = numbers},
                                        {.name = "uv", .channels = "VU", .pixels = place}};
    assert_ok(context, clast_image_write_layers(context, in(&f, "a.exr"), WIDTH, HEIGHT, layers, 4));
    char names[64] = "";
    assert_ok(context, clast_image_list_layers(context, f.file, note_layer, names));
    assert_string_equal(names, ";Z;a.N;uv;");
    clast_image read;
    assert_ok(context, clast_image_read_layer(context, f.file, "a.N", &read));
    assert_int_equal(read.channels, 3);
    assert_memory_equal(read.pixels, normal, sizeof normal);
    clast_image_free(context, &read);
    assert_ok(context, clast_image_read_layer(context, f.file, "Z", &read));
    assert_int_equal(read.channels, 1);
    assert_true(((const float *)read.pixels)[300] == 300.0f);
    clast_image_free(context, &read);
    assert_ok(context, clast_image_read_layer(context, f.file, "uv", &read)); // U before V, as they are written "VU"
    for (int i = 0; i < PIXELS; i++) {
        assert_memory_equal((const float *)read.pixels + 2 * i, &place[2 * i + 1], sizeof(float));
        assert_memory_equal((const float *)read.pixels + 2 * i + 1, &place[2 * i], sizeof(float));
    }
    clast_image_free(context, &read);
    assert_ok(context, clast_image_read_layer(context, f.file, "", &read));
    assert_memory_equal(read.pixels, colour, sizeof colour);
    clast_image_free(context, &read);
    assert_int_equal(clast_image_read_layer(context, f.file, "N", &read), CLAST_ERROR_UNSUPPORTED);
    assert_null(read.pixels);
    assert_int_equal(remove_folder(&f), 1);
}

static void halves_keep_eleven_bits(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    enum { PIXELS = 64 };
    float values[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        values[i] = ldexpf(1.0f + (float)i / 77.0f, i % 20 - 10);
    }
    const clast_image_layer layer = {.name = "", .channels = "Y", .pixels = values, .is_half = true};
    assert_ok(context, clast_image_write_layers(context, in(&f, "a.exr"), 8, 8, &layer, 1));
    assert_true(file_has(f.file, "\0Y\0\1\0\0\0", 7)); // type 1: half
    clast_image read;
    assert_ok(context, clast_image_read(context, f.file, &read));
    for (int i = 0; i < PIXELS; i++) {
        float found = ((const float *)read.pixels)[i];
        assert_true(fabsf(found - values[i]) <= values[i] / 2048.0f);
    }
    clast_image_free(context, &read);
    assert_int_equal(remove_folder(&f), 1);
}

// Smooth pictures come back nearly as they were.
static void jpeg_looks_the_same(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    enum { SIDE = 48 };
    static uint8_t pixels[SIDE * SIDE * 3];
    for (uint32_t channels = 1; channels <= 3; channels += 2) {
        for (uint32_t i = 0; i < SIDE * SIDE * channels; i++) {
            pixels[i] = (uint8_t)(i / channels % SIDE * 3 + i / (channels * SIDE) + 20 * (i % channels));
        }
        clast_image image = {SIDE, SIDE, channels, CLAST_PIXEL_UNORM8, pixels}, read;
        assert_ok(context, clast_image_write(context, in(&f, channels == 1 ? "a.jpeg" : "a.jpg"), &image));
        assert_ok(context, clast_image_read(context, f.file, &read));
        assert_int_equal(read.channels, channels);
        for (uint32_t i = 0; i < SIDE * SIDE * channels; i++) {
            assert_in_range(((const uint8_t *)read.pixels)[i] - pixels[i] + 8, 0, 16);
        }
        clast_image_free(context, &read);
    }
    assert_int_equal(remove_folder(&f), 2);
}

static void wrong_layers_are_refused(void **state)
{
    clast_context *context = *state;
    folder f = make_folder();
    const float pixels[16] = {0};
    const clast_image_layer good = {.name = "", .channels = "R", .pixels = pixels},
                            nameless = {.name = NULL, .channels = "R", .pixels = pixels},
                            empty = {.name = "a", .channels = "", .pixels = pixels},
                            blank = {.name = "a", .channels = "R", .pixels = NULL};
    const clast_image_layer twice[2] = {good, good};
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 2, 2, &nameless, 1),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 2, 2, &empty, 1), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 2, 2, &blank, 1), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 2, 2, twice, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 2, 2, &good, 0), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.exr"), 0, 2, &good, 1), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_write_layers(context, in(&f, "a.png"), 2, 2, &good, 1), CLAST_ERROR_UNSUPPORTED);
    assert_int_equal(remove_folder(&f), 0);
}

// ---------------------------------------------------------------------------------------------------- writes that fail

// A disk that is full after some bytes, and memory that runs out after some blocks.
typedef struct trouble {
    size_t bytes_left;
    long blocks_left;
    int open, committed;
} trouble;

static clast_status trouble_map(void *user, const char *path, clast_file_view *view)
{
    (void)user;
    (void)path;
    (void)view;
    return CLAST_ERROR_FILE_NOT_FOUND;
}

static void trouble_unmap(void *user, clast_file_view *view)
{
    (void)user;
    (void)view;
}

static clast_status trouble_create(void *user, const char *path, void **file)
{
    (void)path;
    ((trouble *)user)->open++;
    *file = user;
    return CLAST_OK;
}

static clast_status trouble_write(void *user, void *file, const void *data, size_t size)
{
    (void)file;
    (void)data;
    trouble *t = user;
    if (size > t->bytes_left) {
        return CLAST_ERROR_FILE_WRITE;
    }
    t->bytes_left -= size;
    return CLAST_OK;
}

static clast_status trouble_commit(void *user, void *file)
{
    (void)file;
    ((trouble *)user)->open--;
    ((trouble *)user)->committed++;
    return CLAST_OK;
}

static void trouble_discard(void *user, void *file)
{
    (void)file;
    ((trouble *)user)->open--;
}

static void *trouble_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)old_size;
    trouble *t = user;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    if (t->blocks_left == 0) {
        return NULL;
    }
    t->blocks_left -= t->blocks_left > 0;
    return realloc(pointer, new_size);
}

static clast_context *make_troubled(trouble *t)
{
    clast_context *context;
    *t = (trouble){.bytes_left = SIZE_MAX, .blocks_left = -1};
    clast_context_desc desc = {
        .threads = 1,
        .memory = {trouble_reallocate, t},
        .file = {trouble_map, trouble_unmap, trouble_create, trouble_write, trouble_commit, trouble_discard, t},
    };
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    return context;
}

static const float troubled_pixels[20 * 3 * 20];

static clast_status write_as(clast_context *context, const char *path)
{
    bool is_png = strstr(path, "png") != NULL;
    clast_image image = {20, 20, 3, is_png ? CLAST_PIXEL_UNORM8 : CLAST_PIXEL_FLOAT, troubled_pixels};
    return clast_image_write(context, path, &image);
}

static void a_full_disk_leaves_no_file(void **state)
{
    (void)state;
    static const char *const names[] = {"a.png", "a.pfm", "a.exr", "a.hdr"};
    for (size_t i = 0; i < 4; i++) {
        for (size_t bytes = 0;; bytes += 13) {
            trouble t;
            clast_context *context = make_troubled(&t);
            uint64_t before = clast_context_memory(context);
            t.bytes_left = bytes;
            clast_status status = write_as(context, names[i]);
            assert_int_equal(t.open, 0);
            assert_int_equal(clast_context_memory(context), before);
            assert_int_equal(t.committed, status == CLAST_OK);
            bool failed = status != CLAST_OK;
            if (failed) {
                assert_int_equal(status, CLAST_ERROR_FILE_WRITE);
                assert_non_null(strstr(clast_context_error(context), names[i]));
            }
            clast_context_destroy(context);
            if (!failed) {
                break;
            }
        }
    }
}

static void memory_that_runs_out_leaves_no_file(void **state)
{
    (void)state;
    static const char *const names[] = {"a.png", "a.pfm", "a.exr", "a.hdr"};
    for (size_t i = 0; i < 4; i++) {
        clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
        for (long blocks = 0; status != CLAST_OK; blocks++) {
            trouble t;
            clast_context *context = make_troubled(&t);
            uint64_t before = clast_context_memory(context);
            t.blocks_left = blocks;
            status = write_as(context, names[i]);
            assert_true(status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY);
            assert_int_equal(t.open, 0);
            assert_int_equal(t.committed, status == CLAST_OK);
            assert_int_equal(clast_context_memory(context), before);
            clast_context_destroy(context);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(png_keeps_every_bit),
        CONTEXT_TEST(pfm_keeps_every_bit),
        CONTEXT_TEST(exr_keeps_every_bit),
        CONTEXT_TEST(hdr_keeps_eight_bits_of_the_largest_channel),
        CONTEXT_TEST(hdr_of_any_width_is_read_again),
        CONTEXT_TEST(hdr_has_a_place_for_odd_values),
        CONTEXT_TEST(what_a_format_cannot_hold_is_refused),
        CONTEXT_TEST(layers_are_channels_of_their_names),
        CONTEXT_TEST(a_window_lies_in_its_picture),
        CONTEXT_TEST(layers_are_listed_and_read_by_name),
        CONTEXT_TEST(halves_keep_eleven_bits),
        CONTEXT_TEST(jpeg_looks_the_same),
        CONTEXT_TEST(wrong_layers_are_refused),
        cmocka_unit_test(a_full_disk_leaves_no_file),
        cmocka_unit_test(memory_that_runs_out_leaves_no_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
