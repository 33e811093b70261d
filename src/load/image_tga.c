// SPDX-License-Identifier: Apache-2.0
// TGA pictures (Truevision TGA File Format Specification 2.0, 1991): palettes, colours and greys, plain or in runs, from any
// corner. The format has no signature: a header that makes sense stands for one.
#include "load/texel.h"

enum {
    HEADER_SIZE = 18,
    FOOTER_SIZE = 26,
    KIND_PALETTE = 1,
    KIND_COLOURS = 2,
    KIND_GREY = 3,
    KIND_RUNS = 8, // added to the others
    FROM_RIGHT = 0x10,
    FROM_TOP = 0x20,
    ALPHA_BITS = 0x0f,
    ALPHA_MEANT = 3, // attribute types of the extension area
    ALPHA_PREMULTIPLIED = 4,
};

typedef struct tga_header {
    uint32_t id_size, has_palette, kind;
    uint32_t palette_first, palette_count, palette_bits;
    uint32_t width, height, bits, descriptor;
} tga_header;

typedef struct tga_reader {
    clast_context *context;
    const char *name;
    clast_bytes bytes;
    tga_header header;
    uint64_t position;   // in `bytes`
    clast_bytes palette; // its entries
    clast_texel_format format;
} tga_reader;

static uint32_t load_short(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8;
}

static bool read_header(clast_bytes bytes, tga_header *header)
{
    unsigned char at[HEADER_SIZE];
    if (!clast_bytes_read(bytes, 0, at, HEADER_SIZE)) {
        return false;
    }
    *header = (tga_header){
        .id_size = at[0],
        .has_palette = at[1],
        .kind = at[2],
        .palette_first = load_short(at + 3),
        .palette_count = load_short(at + 5),
        .palette_bits = at[7],
        .width = load_short(at + 12),
        .height = load_short(at + 14),
        .bits = at[16],
        .descriptor = at[17],
    };
    return true;
}

static bool is_colour_size(uint32_t bits)
{
    return bits == 15 || bits == 16 || bits == 24 || bits == 32;
}

bool clast_is_tga(clast_bytes bytes)
{
    tga_header header;
    if (!read_header(bytes, &header) || header.has_palette > 1 || header.width == 0 || header.height == 0 ||
        (header.descriptor & 0xc0) != 0) {
        return false;
    }
    if (header.has_palette != 0 && !is_colour_size(header.palette_bits)) {
        return false;
    }
    switch (header.kind & ~(uint32_t)KIND_RUNS) {
    case KIND_PALETTE: return header.has_palette != 0 && (header.bits == 8 || header.bits == 16);
    case KIND_COLOURS: return is_colour_size(header.bits);
    case KIND_GREY: return header.bits == 8 || header.bits == 16;
    }
    return false;
}

static clast_status malformed(const tga_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: TGA: %s", reader->name, text);
}

// ------------------------------------------------------------------------------------------------------------- format

// The attribute type that a file of the newer version declares; ALPHA_MEANT where there is none to declare it.
static uint32_t attribute_type(clast_bytes bytes)
{
    enum { EXTENSION_SIZE = 495, ATTRIBUTE_TYPE = 494 };
    clast_bytes footer, extension;
    if (bytes.size < FOOTER_SIZE || !clast_bytes_slice(bytes, bytes.size - FOOTER_SIZE, FOOTER_SIZE, &footer) ||
        memcmp(footer.data + 8, "TRUEVISION-XFILE.", 18) != 0) {
        return ALPHA_MEANT;
    }
    uint32_t offset = clast_load_word(footer.data);
    bool is_there = offset != 0 && clast_bytes_slice(bytes, offset, EXTENSION_SIZE, &extension);
    return is_there ? extension.data[ATTRIBUTE_TYPE] : ALPHA_MEANT;
}

// How a pixel, or an entry of the palette, is stored.
static void find_format(tga_reader *reader)
{
    const tga_header *header = &reader->header;
    bool is_palette = (header->kind & ~(uint32_t)KIND_RUNS) == KIND_PALETTE;
    bool is_grey = (header->kind & ~(uint32_t)KIND_RUNS) == KIND_GREY;
    uint32_t bits = is_palette ? header->palette_bits : header->bits, type = attribute_type(reader->bytes);
    // A palette's descriptor tells of the indices, which have no alpha; its entries of 32 bits do.
    bool has_alpha = (type == ALPHA_MEANT || type == ALPHA_PREMULTIPLIED) &&
                     (is_palette ? bits == 32 : (header->descriptor & ALPHA_BITS) != 0);
    clast_texel_format format = {.kind = CLAST_TEXEL_UNORM, .size = (bits + 7) / 8};
    if (is_grey) {
        format.channels[CLAST_TEXEL_RED].bits = 8;
        format.channels[CLAST_TEXEL_ALPHA].bits = has_alpha && bits == 16 ? 8 : 0;
        format.channels[CLAST_TEXEL_ALPHA].offset = 8;
    } else {
        uint8_t size = bits <= 16 ? 5 : 8;
        for (uint32_t c = 0; c < 3; c++) {
            format.channels[c].offset = (uint8_t)((2 - c) * size); // blue comes first
            format.channels[c].bits = size;
        }
        format.channels[CLAST_TEXEL_ALPHA].offset = (uint8_t)(3 * size);
        format.channels[CLAST_TEXEL_ALPHA].bits = !has_alpha || bits == 24 || bits == 15 ? 0 : bits == 16 ? 1 : 8;
    }
    format.is_premultiplied = type == ALPHA_PREMULTIPLIED && format.channels[CLAST_TEXEL_ALPHA].bits == 8 && !is_grey;
    reader->format = format;
}

static clast_status find_palette(tga_reader *reader)
{
    const tga_header *header = &reader->header;
    reader->position = HEADER_SIZE + (uint64_t)header->id_size;
    if (header->has_palette == 0) {
        return CLAST_OK;
    }
    uint64_t size = (uint64_t)header->palette_count * ((header->palette_bits + 7) / 8);
    if (!clast_bytes_slice(reader->bytes, reader->position, size, &reader->palette)) {
        return malformed(reader, "the file ends inside its palette");
    }
    reader->position += size;
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- pixels

// Reads what is stored for a pixel, and gives what it stands for: itself or an entry of the palette.
static clast_status read_pixel(tga_reader *reader, unsigned char pixel[4])
{
    const tga_header *header = &reader->header;
    uint32_t size = (header->bits + 7) / 8;
    if (!clast_bytes_read(reader->bytes, reader->position, pixel, size)) {
        return malformed(reader, "the file ends inside its picture");
    }
    reader->position += size;
    if ((header->kind & ~(uint32_t)KIND_RUNS) != KIND_PALETTE) {
        return CLAST_OK;
    }
    uint32_t index = size == 1 ? pixel[0] : load_short(pixel);
    if (index < header->palette_first || index - header->palette_first >= header->palette_count) {
        return malformed(reader, "a pixel lies outside the palette");
    }
    memcpy(pixel, reader->palette.data + (index - header->palette_first) * (size_t)reader->format.size,
           reader->format.size);
    return CLAST_OK;
}

// Where the pixel of that number in the file lies in the picture.
static size_t place_of(const tga_header *header, size_t number)
{
    size_t x = number % header->width, y = number / header->width;
    x = header->descriptor & FROM_RIGHT ? header->width - 1 - x : x;
    y = header->descriptor & FROM_TOP ? y : header->height - 1 - y;
    return y * header->width + x;
}

// Gives all pixels of the file in the order of the picture, still as they are stored.
static clast_status read_pixels(tga_reader *reader, unsigned char *texels)
{
    const tga_header *header = &reader->header;
    size_t count = (size_t)header->width * header->height, size = reader->format.size;
    bool has_runs = (header->kind & KIND_RUNS) != 0;
    for (size_t i = 0; i < count;) {
        size_t length = count - i;
        bool is_run = false;
        if (has_runs) {
            unsigned char head;
            if (!clast_bytes_read(reader->bytes, reader->position++, &head, 1)) {
                return malformed(reader, "the file ends inside its picture");
            }
            is_run = (head & 0x80) != 0;
            length = (head & 0x7fu) + 1;
        }
        if (length > count - i) {
            return malformed(reader, "a run leaves the picture");
        }
        unsigned char pixel[4] = {0};
        for (size_t k = 0; k < length; k++, i++) {
            clast_status status = k > 0 && is_run ? CLAST_OK : read_pixel(reader, pixel);
            if (status != CLAST_OK) {
                return status;
            }
            memcpy(texels + place_of(header, i) * size, pixel, size);
        }
    }
    return CLAST_OK;
}

clast_status clast_tga_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    tga_reader reader = {.context = context, .name = name, .bytes = bytes};
    if (!read_header(bytes, &reader.header)) {
        return malformed(&reader, "the file ends inside its header");
    }
    find_format(&reader);
    clast_status status = find_palette(&reader);
    if (status != CLAST_OK) {
        return status;
    }
    const tga_header *header = &reader.header;
    // Each run has a byte more than a pixel, and stands for 128 at most.
    uint64_t count = (uint64_t)header->width * header->height, stored = (header->bits + 7) / 8;
    uint64_t least = header->kind & KIND_RUNS ? (count + 127) / 128 * (1 + stored) : count * stored;
    if (reader.position > bytes.size || least > bytes.size - reader.position) {
        return malformed(&reader, "the file is too short for the size of its picture");
    }
    status = clast_image_check_size(context, name, bytes.size, count * 2 * reader.format.size);
    if (status != CLAST_OK) {
        return status;
    }
    unsigned char *texels = clast_allocate(context, (size_t)count, reader.format.size);
    status = texels != NULL ? read_pixels(&reader, texels) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        status = clast_texel_decode(context, name, &reader.format, (clast_bytes){texels, count * reader.format.size},
                                    bytes.size, header->width, header->height, image);
    }
    clast_free(context, texels);
    return status;
}
