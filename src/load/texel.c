// SPDX-License-Identifier: Apache-2.0
#include "load/texel.h"

#include <math.h>

// ------------------------------------------------------------------------------------------------------------- formats

// X(DXGI, Vulkan, OpenGL, kind, bytes, channels as {offset, bits} of red, green, blue, alpha); 0 where there is no number. A
// format of colours in sRGB is the same here: what a picture is used for says how its values are meant.
#define TEXEL_LIST(X) \
    X(61, 9, 0x8229, UNORM, 1, {0, 8}) \
    X(63, 10, 0x8f94, SNORM, 1, {0, 8}) \
    X(49, 16, 0x822b, UNORM, 2, {0, 8}, {8, 8}) \
    X(51, 17, 0x8f95, SNORM, 2, {0, 8}, {8, 8}) \
    X(0, 23, 0x8051, UNORM, 3, {0, 8}, {8, 8}, {16, 8}) \
    X(0, 29, 0x8c41, UNORM, 3, {0, 8}, {8, 8}, {16, 8}) \
    X(0, 30, 0, UNORM, 3, {16, 8}, {8, 8}, {0, 8}) \
    X(0, 36, 0, UNORM, 3, {16, 8}, {8, 8}, {0, 8}) \
    X(28, 37, 0x8058, UNORM, 4, {0, 8}, {8, 8}, {16, 8}, {24, 8}) \
    X(29, 43, 0x8c43, UNORM, 4, {0, 8}, {8, 8}, {16, 8}, {24, 8}) \
    X(31, 38, 0x8f97, SNORM, 4, {0, 8}, {8, 8}, {16, 8}, {24, 8}) \
    X(87, 44, 0, UNORM, 4, {16, 8}, {8, 8}, {0, 8}, {24, 8}) \
    X(91, 50, 0, UNORM, 4, {16, 8}, {8, 8}, {0, 8}, {24, 8}) \
    X(88, 0, 0, UNORM, 4, {16, 8}, {8, 8}, {0, 8}) \
    X(93, 0, 0, UNORM, 4, {16, 8}, {8, 8}, {0, 8}) \
    X(24, 64, 0x8059, UNORM, 4, {0, 10}, {10, 10}, {20, 10}, {30, 2}) \
    X(85, 4, 0x8d62, UNORM, 2, {11, 5}, {5, 6}, {0, 5}) \
    X(86, 8, 0, UNORM, 2, {10, 5}, {5, 5}, {0, 5}, {15, 1}) \
    X(115, 1000340000, 0, UNORM, 2, {8, 4}, {4, 4}, {0, 4}, {12, 4}) \
    X(191, 0, 0, UNORM, 2, {12, 4}, {8, 4}, {4, 4}, {0, 4}) \
    X(56, 70, 0x822a, UNORM, 2, {0, 16}) \
    X(58, 71, 0x8f98, SNORM, 2, {0, 16}) \
    X(54, 76, 0x822d, FLOAT, 2, {0, 16}) \
    X(35, 77, 0x822c, UNORM, 4, {0, 16}, {16, 16}) \
    X(37, 78, 0x8f99, SNORM, 4, {0, 16}, {16, 16}) \
    X(34, 83, 0x822f, FLOAT, 4, {0, 16}, {16, 16}) \
    X(0, 84, 0x8054, UNORM, 6, {0, 16}, {16, 16}, {32, 16}) \
    X(0, 90, 0x881b, FLOAT, 6, {0, 16}, {16, 16}, {32, 16}) \
    X(11, 91, 0x805b, UNORM, 8, {0, 16}, {16, 16}, {32, 16}, {48, 16}) \
    X(13, 92, 0x8f9b, SNORM, 8, {0, 16}, {16, 16}, {32, 16}, {48, 16}) \
    X(10, 97, 0x881a, FLOAT, 8, {0, 16}, {16, 16}, {32, 16}, {48, 16}) \
    X(41, 100, 0x822e, FLOAT, 4, {0, 32}) \
    X(16, 103, 0x8230, FLOAT, 8, {0, 32}, {32, 32}) \
    X(6, 106, 0x8815, FLOAT, 12, {0, 32}, {32, 32}, {64, 32}) \
    X(2, 109, 0x8814, FLOAT, 16, {0, 32}, {32, 32}, {64, 32}, {96, 32}) \
    X(26, 122, 0x8c3a, FLOAT, 4, {0, 11}, {11, 11}, {22, 10}) \
    X(67, 123, 0x8c3d, SHARED_EXPONENT, 4, {0, 9}, {9, 9}, {18, 9}) \
    X(65, 0, 0, UNORM, 1, {0, 0}, {0, 0}, {0, 0}, {0, 8})

#define BLOCK_LIST(X) \
    X(71, 131, 0x83f0, BC1) \
    X(72, 132, 0x8c4c, BC1) \
    X(0, 133, 0x83f1, BC1) \
    X(0, 134, 0x8c4d, BC1) \
    X(74, 135, 0x83f2, BC2) \
    X(75, 136, 0x8c4e, BC2) \
    X(77, 137, 0x83f3, BC3) \
    X(78, 138, 0x8c4f, BC3) \
    X(80, 139, 0x8dbb, BC4) \
    X(81, 140, 0x8dbc, BC4_SIGNED) \
    X(83, 141, 0x8dbd, BC5) \
    X(84, 142, 0x8dbe, BC5_SIGNED) \
    X(95, 143, 0x8e8f, BC6) \
    X(96, 144, 0x8e8e, BC6_SIGNED) \
    X(98, 145, 0x8e8c, BC7) \
    X(99, 146, 0x8e8d, BC7)

static const struct numbered_format {
    uint32_t numbers[3]; // of DXGI, Vulkan, OpenGL
    clast_texel_format format;
} formats[] = {
#define TEXEL(dxgi, vulkan, opengl, kind, bytes, ...) \
    {{dxgi, vulkan, opengl}, {CLAST_TEXEL_##kind, 0, bytes, {__VA_ARGS__}, false, false}},
    TEXEL_LIST(TEXEL)
#define BLOCK(dxgi, vulkan, opengl, block) \
    {{dxgi, vulkan, opengl}, {CLAST_TEXEL_BLOCK, CLAST_BLOCK_##block, 0, {{0, 0}}, false, false}},
        BLOCK_LIST(BLOCK)
#undef TEXEL
#undef BLOCK
};

static bool find_format(uint32_t interface, uint32_t number, clast_texel_format *format)
{
    for (size_t i = 0; number != 0 && i < sizeof formats / sizeof *formats; i++) {
        if (formats[i].numbers[interface] == number) {
            *format = formats[i].format;
            return true;
        }
    }
    return false;
}

bool clast_texel_of_dxgi(uint32_t number, clast_texel_format *format)
{
    return find_format(0, number, format);
}

bool clast_texel_of_vulkan(uint32_t number, clast_texel_format *format)
{
    return find_format(1, number, format);
}

bool clast_texel_of_opengl(uint32_t number, clast_texel_format *format)
{
    return find_format(2, number, format);
}

bool clast_texel_image_size(const clast_texel_format *format, uint32_t width, uint32_t height, uint64_t *size)
{
    uint64_t across = width, down = height, unit = format->size;
    if (format->kind == CLAST_TEXEL_BLOCK) {
        across = (across + CLAST_BLOCK_SIDE - 1) / CLAST_BLOCK_SIDE;
        down = (down + CLAST_BLOCK_SIDE - 1) / CLAST_BLOCK_SIDE;
        unit = clast_block_size(format->block);
    }
    *size = across * down; // of 32 bits each
    return !__builtin_mul_overflow(*size, unit, size);
}

// ------------------------------------------------------------------------------------------------------------- channels

// Up to 32 bits of a pixel, from the lowest of its first byte on.
static uint32_t read_channel(const unsigned char *pixel, uint32_t offset, uint32_t bits)
{
    uint64_t value = 0;
    uint32_t first = offset / 8, last = (offset + bits - 1) / 8;
    for (uint32_t i = first; i <= last; i++) {
        value |= (uint64_t)pixel[i] << (8 * (i - first));
    }
    return (uint32_t)(value >> offset % 8 & (((uint64_t)1 << bits) - 1));
}

// A float of five bits of exponent; of 10 or 11 bits it has no sign.
static float small_float(uint32_t value, uint32_t bits)
{
    uint32_t mantissa_bits = bits == 16 ? 10 : bits - 5;
    uint32_t mantissa = value & ((1u << mantissa_bits) - 1), exponent = value >> mantissa_bits & 31u;
    bool is_negative = bits == 16 && value >> 15 != 0;
    float result = exponent == 31 ? (mantissa != 0 ? NAN : INFINITY)
                   : exponent == 0
                       ? ldexpf((float)mantissa, -14 - (int)mantissa_bits)
                       : ldexpf((float)(mantissa | 1u << mantissa_bits), (int)exponent - 15 - (int)mantissa_bits);
    return is_negative ? -result : result;
}

static float float_channel(const clast_texel_format *format, const unsigned char *pixel, uint32_t channel)
{
    uint32_t bits = format->channels[channel].bits;
    uint32_t value = read_channel(pixel, format->channels[channel].offset, bits);
    if (format->kind == CLAST_TEXEL_SHARED_EXPONENT) {
        return ldexpf((float)value, (int)read_channel(pixel, 27, 5) - 15 - 9);
    }
    if (bits != 32) {
        return small_float(value, bits);
    }
    float result;
    memcpy(&result, &value, sizeof result);
    return result;
}

// A normalised channel from 0 to `most`, rounded to the nearest.
static uint32_t integer_channel(const clast_texel_format *format, const unsigned char *pixel, uint32_t channel,
                                uint32_t most)
{
    uint32_t bits = format->channels[channel].bits;
    uint32_t value = read_channel(pixel, format->channels[channel].offset, bits), highest = (1u << bits) - 1;
    if (format->kind == CLAST_TEXEL_SNORM) { // the least of all means what the next means
        highest = 2 * (highest / 2);
        value = (value ^ 1u << (bits - 1)); // from 0 up, in order
        value -= value != 0;
    }
    return (uint32_t)(((uint64_t)value * most + highest / 2) / highest);
}

// --------------------------------------------------------------------------------------------------------------- images

// The channels of the image that a format becomes. Grey is one; two colours are red and green with no blue.
static uint32_t image_channels(const clast_texel_format *format)
{
    if (format->kind == CLAST_TEXEL_BLOCK) {
        uint32_t channels = clast_block_channels(format->block);
        return channels == 2 ? 3 : channels;
    }
    bool has_alpha = format->channels[CLAST_TEXEL_ALPHA].bits != 0;
    bool is_grey = format->channels[CLAST_TEXEL_GREEN].bits == 0;
    return is_grey ? 1u + has_alpha : 3u + has_alpha;
}

static clast_pixel_type image_type(const clast_texel_format *format)
{
    if (format->kind == CLAST_TEXEL_BLOCK) {
        return clast_block_type(format->block);
    }
    if (format->kind == CLAST_TEXEL_FLOAT || format->kind == CLAST_TEXEL_SHARED_EXPONENT) {
        return CLAST_PIXEL_FLOAT;
    }
    uint32_t most = 0;
    for (uint32_t i = 0; i < CLAST_TEXEL_CHANNELS; i++) {
        most = format->channels[i].bits > most ? format->channels[i].bits : most;
    }
    return most > 8 ? CLAST_PIXEL_UNORM16 : CLAST_PIXEL_UNORM8;
}

static void store_channel(const clast_texel_format *format, const unsigned char *pixel, uint32_t channel,
                          const clast_image *image, size_t place)
{
    bool is_there = format->channels[channel].bits != 0;
    if (image->type == CLAST_PIXEL_FLOAT) {
        ((float *)image->pixels)[place] = is_there ? float_channel(format, pixel, channel) : 0.0f;
        return;
    }
    uint32_t most = image->type == CLAST_PIXEL_UNORM16 ? 65535 : 255;
    uint32_t nothing = format->kind == CLAST_TEXEL_SNORM ? (most + 1) / 2 : 0;
    uint32_t value = is_there ? integer_channel(format, pixel, channel, most) : nothing;
    if (image->type == CLAST_PIXEL_UNORM16) {
        ((uint16_t *)image->pixels)[place] = (uint16_t)value;
    } else {
        ((uint8_t *)image->pixels)[place] = (uint8_t)value;
    }
}

static void decode_plain(const clast_texel_format *format, const unsigned char *data, const clast_image *image)
{
    size_t count = (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++) {
        for (uint32_t c = 0; c < image->channels; c++) {
            uint32_t channel = image->channels == 2 && c == 1 ? CLAST_TEXEL_ALPHA : c;
            store_channel(format, data + i * format->size, channel, image, i * image->channels + c);
        }
    }
}

// Two channels become three from the last pixel on; the third means nothing: zero, which signed values have in the middle.
static void add_blue(const clast_image *image, bool is_signed)
{
    uint8_t *pixels = (uint8_t *)image->pixels;
    for (size_t i = (size_t)image->width * image->height; i-- > 0;) {
        uint8_t red = pixels[2 * i], green = pixels[2 * i + 1];
        pixels[3 * i] = red;
        pixels[3 * i + 1] = green;
        pixels[3 * i + 2] = is_signed ? 128 : 0;
    }
}

static uint32_t divide(uint32_t colour, uint32_t alpha, uint32_t most)
{
    uint64_t value = ((uint64_t)colour * most + alpha / 2) / alpha;
    return value < most ? (uint32_t)value : most;
}

static void divide_by_alpha(const clast_image *image)
{
    uint32_t n = image->channels, colours = n - 1;
    for (size_t i = 0; n % 2 == 0 && i < (size_t)image->width * image->height; i++) {
        for (uint32_t c = 0; c < colours; c++) {
            size_t at = i * n + c, alpha = i * n + colours;
            if (image->type == CLAST_PIXEL_UNORM8) {
                uint8_t *pixels = (uint8_t *)image->pixels;
                pixels[at] = (uint8_t)(pixels[alpha] != 0 ? divide(pixels[at], pixels[alpha], 255) : pixels[at]);
            } else if (image->type == CLAST_PIXEL_UNORM16) {
                uint16_t *pixels = (uint16_t *)image->pixels;
                pixels[at] = (uint16_t)(pixels[alpha] != 0 ? divide(pixels[at], pixels[alpha], 65535) : pixels[at]);
            } else {
                float *pixels = (float *)image->pixels;
                pixels[at] = pixels[alpha] > 0.0f ? pixels[at] / pixels[alpha] : pixels[at];
            }
        }
    }
}

clast_status clast_texel_decode(clast_context *context, const char *name, const clast_texel_format *format,
                                clast_bytes bytes, uint64_t stored, uint32_t width, uint32_t height, clast_image *image)
{
    uint64_t size;
    *image = (clast_image){0};
    if (!clast_texel_image_size(format, width, height, &size) || size > bytes.size) {
        return clast_fail(context, CLAST_ERROR_MALFORMED,
                          "%s: %u x %u pixels: expected more than the %llu bytes that there are", name, width, height,
                          (unsigned long long)bytes.size);
    }
    clast_status status = clast_image_allocate(context, name, stored, width, height, image_channels(format),
                                               image_type(format), image);
    if (status != CLAST_OK) {
        return status;
    }
    if (format->kind == CLAST_TEXEL_BLOCK) {
        clast_block_decode_image(format->block, bytes, width, height, (void *)image->pixels);
        if (clast_block_channels(format->block) == 2) {
            add_blue(image, format->block == CLAST_BLOCK_BC5_SIGNED);
        }
    } else {
        decode_plain(format, bytes.data, image);
    }
    if (format->is_premultiplied) {
        divide_by_alpha(image);
    }
    return CLAST_OK;
}
