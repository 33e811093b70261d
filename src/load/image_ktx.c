// SPDX-License-Identifier: Apache-2.0
// KTX files of both versions (Khronos Group, KTX File Format 1.0; KTX 2.0): a plane texture with its levels, packed by zstd or
// not.
#include <zstd.h>

#include "load/texel.h"

enum {
    SIGNATURE_SIZE = 12,
    OLDER_HEADER_SIZE = 64,
    NEWER_HEADER_SIZE = 80,
    LEVEL_SIZE = 24,
    ROW_ALIGNMENT = 4, // of the older version
};

typedef struct ktx_reader {
    clast_context *context;
    const char *name;
    clast_bytes bytes;
    uint32_t width, height;
    clast_texel_format format;
    bool from_right, from_bottom; // where the first pixel is
} ktx_reader;

static clast_status malformed(const ktx_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: KTX: %s", reader->name, text);
}

static clast_status unsupported(const ktx_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: KTX: %s", reader->name, text);
}

static uint32_t swap_word(uint32_t word)
{
    return word >> 24 | (word >> 8 & 0xff00) | (word << 8 & 0xff0000) | word << 24;
}

// Looks through keys and values (a length, a key that ends with a zero, a value, padding to four bytes) for the one that says
// where the first pixel is: "S=l,T=u" in the older version, "lu" in the newer.
static void read_orientation(ktx_reader *reader, clast_bytes pairs, bool is_swapped)
{
    static const char key[] = "KTXorientation";
    uint64_t offset = 0;
    clast_bytes pair;
    while (offset + 4 <= pairs.size) {
        uint32_t length = clast_load_word(pairs.data + offset);
        length = is_swapped ? swap_word(length) : length;
        if (!clast_bytes_slice(pairs, offset + 4, length, &pair)) {
            return;
        }
        if (length > sizeof key && memcmp(pair.data, key, sizeof key) == 0) {
            reader->from_right = memchr(pair.data + sizeof key, 'l', length - sizeof key) != NULL;
            reader->from_bottom = memchr(pair.data + sizeof key, 'u', length - sizeof key) != NULL;
        }
        offset += 4 + ((uint64_t)length + 3) / 4 * 4;
    }
}

static void swap_pixels(unsigned char *a, unsigned char *b, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        unsigned char kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

static void orient(const ktx_reader *reader, const clast_image *image)
{
    size_t pixel = image->channels * clast_pixel_size(image->type), row = pixel * image->width;
    unsigned char *pixels = (unsigned char *)image->pixels;
    for (uint32_t y = 0; reader->from_bottom && y < image->height / 2; y++) {
        swap_pixels(pixels + y * row, pixels + (image->height - 1 - y) * row, row);
    }
    for (uint32_t y = 0; reader->from_right && y < image->height; y++) {
        for (uint32_t x = 0; x < image->width / 2; x++) {
            swap_pixels(pixels + y * row + x * pixel, pixels + y * row + (image->width - 1 - x) * pixel, pixel);
        }
    }
}

static clast_status check_shape(const ktx_reader *reader, uint32_t depth, uint32_t layers, uint32_t faces)
{
    return depth > 1 || layers > 1 || faces > 1
               ? unsupported(reader, "an array, a cube or a volume: expected one plane image")
               : CLAST_OK;
}

static clast_status decode_texels(ktx_reader *reader, clast_bytes texels, clast_image *image)
{
    clast_status status = clast_texel_decode(reader->context, reader->name, &reader->format, texels, reader->bytes.size,
                                             reader->width, reader->height, image);
    if (status == CLAST_OK) {
        orient(reader, image);
    }
    return status;
}

// --------------------------------------------------------------------------------------------------- the older version

typedef struct older_header {
    bool is_swapped; // written by a machine that stores the high byte first
    uint32_t type, type_size, layout, internal_format, width, height, depth, layers, faces, levels, pairs_size;
} older_header;

static bool read_older_header(clast_bytes bytes, older_header *header)
{
    if (bytes.size < OLDER_HEADER_SIZE) {
        return false;
    }
    uint32_t words[13];
    for (uint32_t i = 0; i < 13; i++) {
        words[i] = clast_load_word(bytes.data + SIGNATURE_SIZE + 4 * i);
    }
    header->is_swapped = words[0] == 0x01020304;
    for (uint32_t i = 0; header->is_swapped && i < 13; i++) {
        words[i] = swap_word(words[i]);
    }
    uint32_t kept = header->is_swapped;
    *header = (older_header){kept,     words[1], words[2], words[3],  words[4],  words[6],
                             words[7], words[8], words[9], words[10], words[11], words[12]};
    return words[0] == 0x04030201;
}

// The order of channels that OpenGL's formats of pixels stand for, X(OpenGL, channels).
#define LAYOUT_LIST(X) \
    X(0x1903, 1, "r") \
    X(0x1906, 1, "a") \
    X(0x1909, 1, "r") \
    X(0x190a, 2, "ra") \
    X(0x8227, 2, "rg") \
    X(0x1907, 3, "rgb") \
    X(0x80e0, 3, "bgr") \
    X(0x1908, 4, "rgba") \
    X(0x80e1, 4, "bgra")

// What OpenGL's types of a channel stand for, X(OpenGL, kind, bits).
#define TYPE_LIST(X) \
    X(0x1400, SNORM, 8) \
    X(0x1401, UNORM, 8) \
    X(0x1402, SNORM, 16) \
    X(0x1403, UNORM, 16) \
    X(0x1406, FLOAT, 32) \
    X(0x140b, FLOAT, 16)

// The format of uncompressed pixels: where the type is of whole channels, they lie one after the other in the layout's order.
static bool format_of_layout(const older_header *header, clast_texel_format *format)
{
    static const struct {
        uint32_t number, count;
        char channels[5];
    } layouts[] = {
#define LAYOUT(number, count, channels) {number, count, channels},
        LAYOUT_LIST(LAYOUT)
#undef LAYOUT
    };
    static const struct {
        uint32_t number;
        clast_texel_kind kind;
        uint8_t bits;
    } types[] = {
#define TYPE(number, kind, bits) {number, CLAST_TEXEL_##kind, bits},
        TYPE_LIST(TYPE)
#undef TYPE
    };
    static const char order[] = "rgba";
    for (size_t t = 0; t < sizeof types / sizeof *types; t++) {
        for (size_t l = 0; types[t].number == header->type && l < sizeof layouts / sizeof *layouts; l++) {
            if (layouts[l].number != header->layout) {
                continue;
            }
            uint32_t count = layouts[l].count;
            *format = (clast_texel_format){.kind = types[t].kind, .size = count * types[t].bits / 8};
            for (uint32_t c = 0; c < count; c++) {
                uint32_t channel = (uint32_t)(strchr(order, layouts[l].channels[c]) - order);
                format->channels[channel].offset = (uint8_t)(c * types[t].bits);
                format->channels[channel].bits = types[t].bits;
            }
            return true;
        }
    }
    return clast_texel_of_opengl(header->internal_format, format); // packed: one word for a pixel
}

// Rows without their padding, words with the low byte first. `texels` has room for them.
static void copy_rows(const ktx_reader *reader, const older_header *header, clast_bytes level, unsigned char *texels)
{
    size_t row = (size_t)reader->width * reader->format.size,
           stride = (row + ROW_ALIGNMENT - 1) / ROW_ALIGNMENT * ROW_ALIGNMENT;
    for (size_t y = 0; y < reader->height; y++) {
        memcpy(texels + y * row, level.data + y * stride, row);
    }
    uint32_t unit = header->type_size;
    for (size_t i = 0; header->is_swapped && i + unit <= row * reader->height; i += unit) {
        for (uint32_t k = 0; k < unit / 2; k++) {
            swap_pixels(texels + i + k, texels + i + unit - 1 - k, 1);
        }
    }
}

static clast_status decode_rows(ktx_reader *reader, const older_header *header, clast_bytes level, clast_image *image)
{
    uint64_t row = (uint64_t)reader->width * reader->format.size;
    uint64_t stride = (row + ROW_ALIGNMENT - 1) / ROW_ALIGNMENT * ROW_ALIGNMENT;
    if (stride == row && !header->is_swapped) {
        return decode_texels(reader, level, image);
    }
    if (header->type_size != 1 && header->type_size != 2 && header->type_size != 4) {
        return malformed(reader, "expected a type of 1, 2 or 4 bytes");
    }
    if (reader->height > level.size / stride) {
        return malformed(reader, "the file is too short for the size of its picture");
    }
    unsigned char *texels = clast_allocate(reader->context, (size_t)row, reader->height);
    if (texels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    copy_rows(reader, header, level, texels);
    clast_status status = decode_texels(reader, (clast_bytes){texels, row * reader->height}, image);
    clast_free(reader->context, texels);
    return status;
}

static clast_status decode_older_level(ktx_reader *reader, const older_header *header, clast_bytes level,
                                       clast_image *image)
{
    return header->type == 0 ? decode_texels(reader, level, image) : decode_rows(reader, header, level, image);
}

// How many levels below the largest a file says it has; those that cannot be are not counted.
static uint32_t levels_below(const clast_image *image, uint32_t levels)
{
    uint32_t most = clast_level_count(image->width, image->height);
    return levels == 0 ? 0 : levels - 1 < most ? levels - 1 : most;
}

static void choose_level(ktx_reader *reader, const clast_image *finest, uint32_t level)
{
    reader->width = clast_level_side(finest->width, level);
    reader->height = clast_level_side(finest->height, level);
}

// Each level has its size before it, and is padded to four bytes. `offset` is where the largest's size is.
static void read_older_levels(ktx_reader *reader, const older_header *header, uint64_t offset, const clast_image *image,
                              clast_image_levels *levels)
{
    uint32_t count = levels_below(image, header->levels);
    bool goes_on = true;
    for (uint32_t level = 1; level <= count && goes_on; level++) {
        uint32_t before = clast_load_word(reader->bytes.data + offset);
        before = header->is_swapped ? swap_word(before) : before;
        offset += 4 + ((uint64_t)before + 3) / 4 * 4;
        clast_bytes rest;
        clast_image decoded = {0};
        choose_level(reader, image, level);
        goes_on = offset < reader->bytes.size && reader->bytes.size - offset > 4 &&
                  clast_bytes_slice(reader->bytes, offset + 4, reader->bytes.size - offset - 4, &rest) &&
                  decode_older_level(reader, header, rest, &decoded) == CLAST_OK &&
                  clast_image_take_level(reader->context, image, level, count, &decoded, levels);
    }
}

clast_status clast_ktx_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                    clast_image_parts *parts)
{
    ktx_reader reader = {.context = context, .name = name, .bytes = bytes};
    older_header header;
    clast_bytes pairs, level;
    if (!read_older_header(bytes, &header)) {
        return malformed(&reader, "expected a header of 64 bytes in one of both orders of bytes");
    }
    reader.width = header.width;
    reader.height = header.height != 0 ? header.height : 1;
    clast_status status = check_shape(&reader, header.depth, header.layers, header.faces);
    if (status != CLAST_OK) {
        return status;
    }
    if (reader.width == 0) {
        return malformed(&reader, "an image without width");
    }
    bool is_packed = header.type == 0;
    if (is_packed ? !clast_texel_of_opengl(header.internal_format, &reader.format)
                  : !format_of_layout(&header, &reader.format)) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED,
                          "%s: KTX: pixels of the OpenGL format 0x%04x (0x%04x of type 0x%04x) are not read", name,
                          header.internal_format, header.layout, header.type);
    }
    if (!clast_bytes_slice(bytes, OLDER_HEADER_SIZE, header.pairs_size, &pairs) ||
        bytes.size - OLDER_HEADER_SIZE - header.pairs_size < 4) {
        return malformed(&reader, "the file ends before its pixels");
    }
    read_orientation(&reader, pairs, header.is_swapped);
    uint64_t begin = OLDER_HEADER_SIZE + (uint64_t)header.pairs_size +
                     4; // after the level's size, which follows from the rest
    level = (clast_bytes){bytes.data + begin, bytes.size - begin};
    status = decode_older_level(&reader, &header, level, image);
    if (status == CLAST_OK && parts != NULL) {
        read_older_levels(&reader, &header, begin - 4, image, &parts->levels);
    }
    return status;
}

clast_status clast_ktx_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    return clast_ktx_decode_parts(context, name, bytes, image, NULL);
}

// --------------------------------------------------------------------------------------------------- the newer version

enum { SCHEME_NONE, SCHEME_BASIS, SCHEME_ZSTD, SCHEME_ZLIB, MODEL_ETC1S = 163, MODEL_UASTC = 166 };

static uint64_t load_long(const unsigned char *at)
{
    return clast_load_word(at) | (uint64_t)clast_load_word(at + 4) << 32;
}

// What the data format descriptor says of the colour model, and of alpha: Khronos Data Format Specification 1.3, section 3.
static void read_descriptor(const ktx_reader *reader, uint32_t *model, bool *is_premultiplied)
{
    uint32_t offset = clast_load_word(reader->bytes.data + 48), length = clast_load_word(reader->bytes.data + 52);
    clast_bytes block;
    bool is_there = length >= 16 && clast_bytes_slice(reader->bytes, offset, length, &block);
    *model = is_there ? block.data[12] : 0;
    *is_premultiplied = is_there && (block.data[15] & 1) != 0;
}

static clast_status find_newer_format(ktx_reader *reader, uint32_t scheme)
{
    uint32_t number = clast_load_word(reader->bytes.data + SIGNATURE_SIZE), model;
    bool is_premultiplied;
    read_descriptor(reader, &model, &is_premultiplied);
    if (scheme == SCHEME_BASIS || model == MODEL_ETC1S || model == MODEL_UASTC) {
        return unsupported(reader, "Basis Universal (BasisLZ, ETC1S or UASTC) is not read: expected BC1 to BC7, or "
                                   "uncompressed pixels");
    }
    if (scheme == SCHEME_ZLIB) {
        return unsupported(reader, "packing by zlib is not read: expected zstd or none");
    }
    if (scheme > SCHEME_ZLIB) {
        return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: KTX: packing by scheme %u is not read",
                          reader->name, scheme);
    }
    if (!clast_texel_of_vulkan(number, &reader->format)) {
        return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED,
                          "%s: KTX: pixels of the Vulkan format %u are not read", reader->name, number);
    }
    reader->format.is_premultiplied = is_premultiplied;
    return CLAST_OK;
}

static clast_status decode_packed(ktx_reader *reader, clast_bytes level, uint64_t size, clast_image *image)
{
    uint64_t expected;
    if (!clast_texel_image_size(&reader->format, reader->width, reader->height, &expected) || size != expected) {
        return malformed(reader, "a packed level has another size than its pixels");
    }
    clast_status status = clast_image_check_size(reader->context, reader->name, reader->bytes.size, size);
    if (status != CLAST_OK) {
        return status;
    }
    if (ZSTD_getFrameContentSize(level.data, (size_t)level.size) == ZSTD_CONTENTSIZE_ERROR) {
        return malformed(reader, "a packed level is not of zstd");
    }
    unsigned char *texels = clast_allocate(reader->context, (size_t)size, 1);
    if (texels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    size_t got = ZSTD_decompress(texels, (size_t)size, level.data, (size_t)level.size);
    if (ZSTD_isError(got) || got != size) {
        status = clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: KTX: zstd: %s", reader->name,
                            ZSTD_isError(got) ? ZSTD_getErrorName(got) : "the level ends early");
    }
    if (status == CLAST_OK) {
        status = decode_texels(reader, (clast_bytes){texels, size}, image);
    }
    clast_free(reader->context, texels);
    return status;
}

// A level of the index, which the file is long enough for.
static clast_status decode_newer_level(ktx_reader *reader, uint32_t scheme, uint32_t level, clast_image *image)
{
    const unsigned char *at = reader->bytes.data + NEWER_HEADER_SIZE + (size_t)LEVEL_SIZE * level;
    clast_bytes texels;
    if (!clast_bytes_slice(reader->bytes, load_long(at), load_long(at + 8), &texels)) {
        return malformed(reader, "the file ends before its pixels");
    }
    return scheme == SCHEME_ZSTD ? decode_packed(reader, texels, load_long(at + 16), image)
                                 : decode_texels(reader, texels, image);
}

static void read_newer_levels(ktx_reader *reader, uint32_t scheme, const clast_image *image, clast_image_levels *levels)
{
    uint32_t count = levels_below(image, clast_load_word(reader->bytes.data + 40));
    bool goes_on = true;
    for (uint32_t level = 1; level <= count && goes_on; level++) {
        clast_image decoded = {0};
        choose_level(reader, image, level);
        goes_on = reader->bytes.size >= NEWER_HEADER_SIZE + (uint64_t)LEVEL_SIZE * (level + 1) &&
                  decode_newer_level(reader, scheme, level, &decoded) == CLAST_OK &&
                  clast_image_take_level(reader->context, image, level, count, &decoded, levels);
    }
}

clast_status clast_ktx2_decode_parts(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                     clast_image_parts *parts)
{
    ktx_reader reader = {.context = context, .name = name, .bytes = bytes};
    if (bytes.size < NEWER_HEADER_SIZE + LEVEL_SIZE) {
        return malformed(&reader, "the file ends inside its header");
    }
    const unsigned char *at = bytes.data;
    reader.width = clast_load_word(at + 20);
    reader.height = clast_load_word(at + 24) != 0 ? clast_load_word(at + 24) : 1;
    uint32_t scheme = clast_load_word(at + 44);
    clast_status status = find_newer_format(&reader, scheme);
    if (status == CLAST_OK) {
        status = check_shape(&reader, clast_load_word(at + 28), clast_load_word(at + 32), clast_load_word(at + 36));
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_bytes pairs;
    if (reader.width == 0 || !clast_bytes_slice(bytes, clast_load_word(at + 56), clast_load_word(at + 60), &pairs)) {
        return malformed(&reader, reader.width == 0 ? "an image without width" : "the file ends before its pixels");
    }
    read_orientation(&reader, pairs, false);
    status = decode_newer_level(&reader, scheme, 0, image);
    if (status == CLAST_OK && parts != NULL) {
        read_newer_levels(&reader, scheme, image, &parts->levels);
    }
    return status;
}

clast_status clast_ktx2_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    return clast_ktx2_decode_parts(context, name, bytes, image, NULL);
}
