// SPDX-License-Identifier: Apache-2.0
// BC1 to BC5, and images of blocks.
#include "load/block.h"

#include "load/image.h"
#include "shared/block.h"

static const struct {
    uint32_t size, channels;
    clast_pixel_type type;
} formats[CLAST_BLOCK_COUNT] = {
#define FORMAT(name, size, channels, type) {size, channels, type},
    CLAST_BLOCK_LIST(FORMAT)
#undef FORMAT
};

uint32_t clast_block_size(clast_block_format format)
{
    return formats[format].size;
}

uint32_t clast_block_channels(clast_block_format format)
{
    return formats[format].channels;
}

clast_pixel_type clast_block_type(clast_block_format format)
{
    return formats[format].type;
}

// ------------------------------------------------------------------------------------------------------- BC1, BC2, BC3

// `has_black`: where the first colour is not the larger, the fourth is transparent black.
static void decode_colours(const unsigned char *block, bool has_black, unsigned char pixels[CLAST_BLOCK_PIXELS][4])
{
    uint32_t ends = clast_load_word(block);
    unsigned char palette[4][4];
    for (uint32_t code = 0; code < 4; code++) {
        uint32_t colour = block_colour(ends, code, has_black);
        for (uint32_t c = 0; c < 4; c++) {
            palette[code][c] = (unsigned char)(colour >> 8 * c);
        }
    }
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        memcpy(pixels[i], palette[block[4 + i / 4] >> (i % 4 * 2) & 3], 4);
    }
}

static void decode_sharp_alpha(const unsigned char *block, unsigned char pixels[CLAST_BLOCK_PIXELS][4])
{
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        pixels[i][3] = (unsigned char)((block[i / 2] >> (i % 2 * 4) & 15) * 17);
    }
}

// ------------------------------------------------------------------------------------------------------------ BC4, BC5

static void fill_signed_values(const unsigned char *block, unsigned char values[8])
{
    int32_t a = (int8_t)block[0], b = (int8_t)block[1]; // -128 means what -127 means
    a = a < -127 ? -127 : a;
    b = b < -127 ? -127 : b;
    int32_t steps = a > b ? 7 : 5;
    float palette[8] = {(float)a, (float)b};
    palette[6] = -127.0f;
    palette[7] = 127.0f;
    for (int32_t i = 1; i < steps; i++) {
        palette[1 + i] = (float)((steps - i) * a + i * b) / (float)steps;
    }
    for (uint32_t i = 0; i < 8; i++) {
        values[i] = (unsigned char)((palette[i] + 127.0f) * (255.0f / 254.0f) + 0.5f);
    }
}

// One channel of eight values between two ends, into every `stride`th byte.
static void decode_channel(const unsigned char *block, bool is_signed, unsigned char *pixels, uint32_t stride)
{
    unsigned char values[8];
    for (uint32_t code = 0; code < 8; code++) {
        values[code] = (unsigned char)block_value(block[0], block[1], code);
    }
    if (is_signed) {
        fill_signed_values(block, values);
    }
    uint64_t codes = 0;
    for (uint32_t i = 0; i < 6; i++) {
        codes |= (uint64_t)block[2 + i] << (8 * i);
    }
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        pixels[(size_t)i * stride] = values[codes >> (3 * i) & 7];
    }
}

// ----------------------------------------------------------------------------------------------------------------- all

void clast_block_decode(clast_block_format format, const unsigned char *block, void *pixels)
{
    bool is_signed = format == CLAST_BLOCK_BC4_SIGNED || format == CLAST_BLOCK_BC5_SIGNED ||
                     format == CLAST_BLOCK_BC6_SIGNED;
    switch (format) {
    case CLAST_BLOCK_BC1: decode_colours(block, true, pixels); break;
    case CLAST_BLOCK_BC2:
        decode_colours(block + 8, false, pixels);
        decode_sharp_alpha(block, pixels);
        break;
    case CLAST_BLOCK_BC3:
        decode_colours(block + 8, false, pixels);
        decode_channel(block, false, (unsigned char *)pixels + 3, 4);
        break;
    case CLAST_BLOCK_BC4:
    case CLAST_BLOCK_BC4_SIGNED: decode_channel(block, is_signed, pixels, 1); break;
    case CLAST_BLOCK_BC5:
    case CLAST_BLOCK_BC5_SIGNED:
        decode_channel(block, is_signed, pixels, 2);
        decode_channel(block + 8, is_signed, (unsigned char *)pixels + 1, 2);
        break;
    case CLAST_BLOCK_BC6:
    case CLAST_BLOCK_BC6_SIGNED: clast_block_decode_bc6(block, is_signed, pixels); break;
    case CLAST_BLOCK_BC7: clast_block_decode_bc7(block, pixels); break;
    case CLAST_BLOCK_COUNT: break;
    }
}

void clast_block_decode_image(clast_block_format format, clast_bytes bytes, uint32_t width, uint32_t height,
                              void *pixels)
{
    size_t pixel = clast_block_channels(format) * clast_pixel_size(clast_block_type(format));
    uint32_t across = (width + CLAST_BLOCK_SIDE - 1) / CLAST_BLOCK_SIDE, size = clast_block_size(format);
    for (uint32_t y = 0; y < height; y += CLAST_BLOCK_SIDE) {
        for (uint32_t x = 0; x < width; x += CLAST_BLOCK_SIDE) {
            float decoded[CLAST_BLOCK_BYTES_MOST / sizeof(float)];
            size_t number = (size_t)(y / CLAST_BLOCK_SIDE) * across + x / CLAST_BLOCK_SIDE;
            clast_block_decode(format, bytes.data + number * size, decoded);
            uint32_t columns = width - x < CLAST_BLOCK_SIDE ? width - x : CLAST_BLOCK_SIDE;
            for (uint32_t row = 0; row < CLAST_BLOCK_SIDE && y + row < height; row++) {
                memcpy((unsigned char *)pixels + ((size_t)(y + row) * width + x) * pixel,
                       (const unsigned char *)decoded + (size_t)row * CLAST_BLOCK_SIDE * pixel, columns * pixel);
            }
        }
    }
}
