// SPDX-License-Identifier: Apache-2.0
// DDS files (Microsoft, DDS File Layout; the header of Direct3D 9 and that of Direct3D 10): a plane
// texture with its levels.
#include <string.h>

#include "load/texel.h"

enum {
    MAGIC_SIZE = 4,
    HEADER_SIZE = 124,
    NEWER_HEADER_SIZE = 20,
    FORMAT_SIZE = 32,
    // flags of the pixel format
    HAS_ALPHA = 0x1,
    ONLY_ALPHA = 0x2,
    HAS_CODE = 0x4,
    HAS_COLOURS = 0x40,
    HAS_LUMINANCE = 0x20000,
    HAS_DIFFERENCES = 0x80000, // signed
    // flags of what it is
    IS_CUBE = 0x200,
    IS_VOLUME = 0x200000,
    NEWER_IS_CUBE = 0x4,
    DIMENSION_2 = 3,
};

// The parts of the older header that matter.
typedef struct dds_header {
    uint32_t height, width;
    uint32_t levels;                      // with the largest; 0 is one
    uint32_t flags, code, bits, masks[4]; // of the pixel format
    uint32_t caps;
} dds_header;

static void read_header(const unsigned char *at, dds_header *header)
{
    const unsigned char *format = at + 72;
    *header = (dds_header){.height = clast_load_word(at + 8),
                           .width = clast_load_word(at + 12),
                           .levels = clast_load_word(at + 24),
                           .caps = clast_load_word(at + 108)};
    header->flags = clast_load_word(format + 4);
    header->code = clast_load_word(format + 8);
    header->bits = clast_load_word(format + 12);
    for (uint32_t i = 0; i < 4; i++) {
        header->masks[i] = clast_load_word(format + 16 + 4 * i);
    }
}

// Codes of four letters, and numbers that Direct3D 9 used for codes, as formats of DXGI.
static bool format_of_code(uint32_t code, clast_texel_format *format)
{
    static const struct {
        char letters[5];
        uint8_t dxgi;
        bool is_premultiplied;
    } lettered[] = {
        {"DXT1", 71, false}, {"DXT2", 74, true},  {"DXT3", 74, false}, {"DXT4", 77, true},
        {"DXT5", 77, false}, {"ATI1", 80, false}, {"BC4U", 80, false}, {"BC4S", 81, false},
        {"ATI2", 83, false}, {"BC5U", 83, false}, {"BC5S", 84, false},
    };
    static const uint8_t numbered[][2] = {{36, 11},  {110, 13}, {111, 54}, {112, 34},
                                          {113, 10}, {114, 41}, {115, 16}, {116, 2}};
    for (size_t i = 0; i < sizeof lettered / sizeof *lettered; i++) {
        if (clast_load_word((const unsigned char *)lettered[i].letters) == code) {
            bool found = clast_texel_of_dxgi(lettered[i].dxgi, format);
            format->is_premultiplied = lettered[i].is_premultiplied;
            return found;
        }
    }
    for (size_t i = 0; i < sizeof numbered / sizeof *numbered; i++) {
        if (numbered[i][0] == code) {
            return clast_texel_of_dxgi(numbered[i][1], format);
        }
    }
    return false;
}

// A channel's mask, of bits in one run.
static bool read_mask(uint32_t mask, uint32_t bits, clast_texel_format *format, uint32_t channel)
{
    if (mask == 0) {
        return true;
    }
    uint32_t offset = (uint32_t)__builtin_ctz(mask), length = (uint32_t)__builtin_popcount(mask);
    format->channels[channel].offset = (uint8_t)offset;
    format->channels[channel].bits = (uint8_t)length;
    bool has_values = length > 1 || format->kind != CLAST_TEXEL_SNORM; // a sign alone is none
    return has_values && length <= 16 && offset + length <= bits &&
           (uint64_t)mask >> offset == ((uint64_t)1 << length) - 1;
}

static bool format_of_masks(const dds_header *header, clast_texel_format *format)
{
    *format = (clast_texel_format){.kind = header->flags & HAS_DIFFERENCES ? CLAST_TEXEL_SNORM : CLAST_TEXEL_UNORM,
                                   .size = header->bits / 8};
    bool has_colours = (header->flags & (HAS_COLOURS | HAS_LUMINANCE | HAS_DIFFERENCES)) != 0;
    bool has_alpha = (header->flags & (HAS_ALPHA | ONLY_ALPHA)) != 0 ||
                     ((header->flags & HAS_DIFFERENCES) != 0 && header->masks[3] != 0);
    if (header->bits == 0 || header->bits > 32 || header->bits % 8 != 0 || !(has_colours || has_alpha)) {
        return false;
    }
    uint32_t colours = header->flags & HAS_LUMINANCE ? 1 : 3;
    for (uint32_t i = 0; has_colours && i < colours; i++) {
        if (!read_mask(header->masks[i], header->bits, format, i)) {
            return false;
        }
    }
    return (!has_alpha || read_mask(header->masks[3], header->bits, format, CLAST_TEXEL_ALPHA)) &&
           (format->channels[CLAST_TEXEL_RED].bits != 0 || format->channels[CLAST_TEXEL_ALPHA].bits != 0);
}

static void write_code(uint32_t code, char text[5])
{
    for (uint32_t i = 0; i < 4; i++) {
        char c = (char)(code >> (8 * i));
        text[i] = c >= ' ' && c <= '~' ? c : '?';
    }
    text[4] = '\0';
}

static clast_status find_format(clast_context *context, const char *name, const dds_header *header,
                                const unsigned char *newer, clast_texel_format *format)
{
    char code[5];
    write_code(header->code, code);
    if (newer != NULL) {
        if (clast_load_word(newer + 4) != DIMENSION_2 || (clast_load_word(newer + 8) & NEWER_IS_CUBE) != 0 ||
            clast_load_word(newer + 12) > 1) {
            return clast_fail(context, CLAST_ERROR_UNSUPPORTED,
                              "%s: an array, a cube or a volume: expected one plane image", name);
        }
        return clast_texel_of_dxgi(clast_load_word(newer), format)
                   ? CLAST_OK
                   : clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: pixels of the DXGI format %u are not read", name,
                                clast_load_word(newer));
    }
    if ((header->caps & (IS_CUBE | IS_VOLUME)) != 0) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: a cube or a volume: expected one plane image", name);
    }
    if ((header->flags & HAS_CODE) != 0) {
        return format_of_code(header->code, format)
                   ? CLAST_OK
                   : clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: pixels of the code \"%s\" (%u) are not read",
                                name, code, header->code);
    }
    return format_of_masks(header, format)
               ? CLAST_OK
               : clast_fail(context, CLAST_ERROR_UNSUPPORTED,
                            "%s: pixels of %u bits with the masks %x, %x, %x and %x are not read", name, header->bits,
                            header->masks[0], header->masks[1], header->masks[2], header->masks[3]);
}

// Whether a device reads in blocks what clast makes of them: not where values are signed, as these are given as (v + 1) / 2.
static bool means_the_same(const clast_texel_format *format)
{
    bool is_shifted = format->block == CLAST_BLOCK_BC4_SIGNED || format->block == CLAST_BLOCK_BC5_SIGNED;
    return format->kind == CLAST_TEXEL_BLOCK && !format->is_premultiplied && !is_shifted;
}

// `pixels` was decoded: there are enough.
static clast_status copy_blocks(clast_context *context, const clast_texel_format *format, const dds_header *header,
                                clast_bytes pixels, clast_image_blocks *blocks)
{
    uint64_t size = 0;
    clast_texel_image_size(format, header->width, header->height, &size);
    *blocks = (clast_image_blocks){format->block, clast_allocate(context, (size_t)size, 1), (size_t)size};
    if (blocks->data == NULL) {
        *blocks = (clast_image_blocks){0};
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memcpy(blocks->data, pixels.data, (size_t)size);
    return CLAST_OK;
}

// The levels follow the picture, each the one before it. `pixels` was decoded: the first is there.
static void read_levels(clast_context *context, const char *name, const clast_texel_format *format,
                        const dds_header *header, clast_bytes pixels, uint64_t stored, const clast_image *image,
                        clast_image_levels *levels)
{
    uint32_t most = clast_level_count(image->width, image->height);
    uint32_t count = header->levels == 0 ? 0 : header->levels - 1 < most ? header->levels - 1 : most;
    uint64_t offset = 0;
    bool goes_on = true;
    for (uint32_t level = 1; level <= count && goes_on; level++) {
        uint64_t size = 0;
        uint32_t width = clast_level_side(image->width, level), height = clast_level_side(image->height, level);
        clast_texel_image_size(format, clast_level_side(image->width, level - 1),
                               clast_level_side(image->height, level - 1), &size);
        offset += size;
        clast_bytes rest;
        clast_image decoded = {0};
        goes_on = offset < pixels.size && clast_bytes_slice(pixels, offset, pixels.size - offset, &rest) &&
                  clast_texel_decode(context, name, format, rest, stored, width, height, &decoded) == CLAST_OK &&
                  clast_image_take_level(context, image, level, count, &decoded, levels);
    }
}

clast_status clast_dds_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                    clast_image_parts *parts)
{
    clast_bytes pixels;
    dds_header header;
    if (bytes.size < MAGIC_SIZE + HEADER_SIZE || clast_load_word(bytes.data + MAGIC_SIZE) != HEADER_SIZE ||
        clast_load_word(bytes.data + MAGIC_SIZE + 72) != FORMAT_SIZE) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: expected a DDS header of %d bytes", name, HEADER_SIZE);
    }
    read_header(bytes.data + MAGIC_SIZE, &header);
    const unsigned char *newer = NULL;
    uint64_t begin = MAGIC_SIZE + HEADER_SIZE;
    if ((header.flags & HAS_CODE) != 0 && header.code == clast_load_word((const unsigned char *)"DX10")) {
        newer = bytes.data + begin;
        begin += NEWER_HEADER_SIZE;
    }
    if (bytes.size < begin || !clast_bytes_slice(bytes, begin, bytes.size - begin, &pixels)) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: expected a DDS header of Direct3D 10", name);
    }
    clast_texel_format format;
    clast_status status = find_format(context, name, &header, newer, &format);
    if (status == CLAST_OK) {
        status = clast_texel_decode(context, name, &format, pixels, bytes.size, header.width, header.height, image);
    }
    if (status == CLAST_OK && parts != NULL && means_the_same(&format)) {
        status = copy_blocks(context, &format, &header, pixels, &parts->blocks);
        if (status != CLAST_OK) {
            clast_image_free(context, image);
        }
    }
    if (status == CLAST_OK && parts != NULL) {
        read_levels(context, name, &format, &header, pixels, bytes.size, image, &parts->levels);
    }
    return status;
}

clast_status clast_dds_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    return clast_dds_decode_parts(context, name, bytes, image, NULL);
}
