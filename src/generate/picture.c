// SPDX-License-Identifier: Apache-2.0
#include "generate/picture.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>

#include "base/thread.h"

static void write_piece(png_structp png, png_bytep data, png_size_t size)
{
    if (clast_file_write(png_get_io_ptr(png), data, size) != CLAST_OK) {
        png_error(png, "write"); // jumps back; the file has the failure
    }
}

static void flush_nothing(png_structp png)
{
    (void)png;
}
static void stop(png_structp png, png_const_charp text)
{
    (void)text;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp text)
{
    (void)png, (void)text;
}

// Rows of `stride` bytes, tightly packed, big-endian where 16-bit.
static void write_png(clast_outputs *outputs, const char *name, uint32_t width, uint32_t height, int depth, int colour,
                      const uint8_t *rows, size_t stride)
{
    clast_file_output *file = clast_outputs_open(outputs, name);
    if (file == NULL) {
        return;
    }
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, stop, ignore);
    png_infop information = png != NULL ? png_create_info_struct(png) : NULL;
    if (information == NULL) {
        png_destroy_write_struct(&png, NULL);
        clast_outputs_note(outputs, clast_fail(outputs->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: out of memory", name));
        return;
    }
    if (setjmp(png_jmpbuf(png)) == 0) {
        png_set_write_fn(png, file, write_piece, flush_nothing);
        png_set_IHDR(png, information, width, height, depth, colour, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                     PNG_FILTER_TYPE_DEFAULT);
        // Noise hardly shrinks further however long one tries.
        png_set_compression_level(png, 4);
        png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP | PNG_FILTER_PAETH);
        png_write_info(png, information);
        for (uint32_t y = 0; y < height; y++) {
            png_write_row(png, rows + y * stride);
        }
        png_write_end(png, information);
    } else if (file->status == CLAST_OK) {
        clast_outputs_note(outputs,
                           clast_fail(outputs->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: the PNG encoder failed", name));
    }
    clast_outputs_note(outputs, file->status);
    png_destroy_write_struct(&png, &information);
}

// x^(5/12), from square roots and Newton's cube root: no library's rounding decides a pixel.
static double power_five_twelfths(double x)
{
    double s = sqrt(x), cube = 0.3 + 0.7 * s;
    for (int i = 0; i < 24; i++) {
        cube -= (cube * cube * cube - s) / (3.0 * cube * cube);
    }
    return sqrt(s) * cube;
}

// IEC 61966-2-1.
void clast_make_gamma(uint8_t table[CLAST_GAMMA_STEPS])
{
    for (uint32_t i = 0; i < CLAST_GAMMA_STEPS; i++) {
        double x = (double)i / (CLAST_GAMMA_STEPS - 1);
        double y = x <= 0.0031308 ? 12.92 * x : 1.055 * power_five_twelfths(x) - 0.055;
        table[i] = (uint8_t)(y * 255.0 + 0.5);
    }
}

void clast_picture_write(clast_outputs *outputs, const char *name, uint32_t width, uint32_t height,
                         const uint8_t *pixels)
{
    write_png(outputs, name, width, height, 8, PNG_COLOR_TYPE_RGB, pixels, (size_t)width * 3);
}

typedef struct evaluation {
    float (*texel)(const void *data, uint32_t x, uint32_t y);
    const void *data;
    uint32_t width;
    float *heights;
} evaluation;

static void evaluate_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const evaluation *e = data;
    for (size_t y = begin; y < end; y++) {
        for (uint32_t x = 0; x < e->width; x++) {
            e->heights[y * e->width + x] = e->texel(e->data, x, (uint32_t)y);
        }
    }
}

void clast_picture_write_heights(clast_outputs *outputs, const char *name, uint32_t width, uint32_t height,
                                 float (*texel)(const void *data, uint32_t x, uint32_t y), const void *data, float *low,
                                 float *high)
{
    size_t count = (size_t)width * height;
    float *heights = clast_allocate(outputs->context, count, sizeof *heights);
    uint8_t *rows = clast_allocate(outputs->context, count, 2);
    if (heights == NULL || rows == NULL) {
        clast_outputs_note(outputs, CLAST_ERROR_OUT_OF_MEMORY);
    } else {
        evaluation e = {texel, data, width, heights};
        clast_parallel_for(outputs->context, height, 4, evaluate_rows, &e);
        *low = *high = heights[0];
        for (size_t i = 0; i < count; i++) {
            *low = min1(*low, heights[i]);
            *high = max1(*high, heights[i]);
        }
        float scale = *high > *low ? 65535.0f / (*high - *low) : 0.0f;
        for (size_t i = 0; i < count; i++) {
            uint32_t value = (uint32_t)clamp1((heights[i] - *low) * scale + 0.5f, 0.0f, 65535.0f);
            rows[2 * i] = (uint8_t)(value >> 8);
            rows[2 * i + 1] = (uint8_t)value;
        }
        write_png(outputs, name, width, height, 16, PNG_COLOR_TYPE_GRAY, rows, (size_t)width * 2);
    }
    clast_free(outputs->context, heights);
    clast_free(outputs->context, rows);
}
