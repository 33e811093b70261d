// SPDX-License-Identifier: Apache-2.0
// Radiance pictures (.hdr, .pic): RGBE pixels; flat, old and new run-length scanlines. Ward, Real Pixels, Graphics Gems
// II, 1991; the file format is that of Radiance's reference manual.
#include <math.h>

#include "load/image.h"
#include "load/number.h"

enum { RUN_WIDTH_LEAST = 8, RUN_WIDTH_MOST = 32767 }; // new run-length scanlines exist for these widths only

typedef struct hdr_reader {
    clast_context *context;
    const char *name;
    clast_bytes bytes;
    uint64_t position;
    double exposure;
    bool flip_x, flip_y;
} hdr_reader;

static clast_status malformed(const hdr_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: HDR, byte %llu: %s", reader->name,
                      (unsigned long long)reader->position, text);
}

// The next line without its end, as a piece of the file.
static bool next_line(hdr_reader *reader, clast_bytes *line)
{
    const unsigned char *begin = reader->bytes.data + reader->position;
    uint64_t left = reader->bytes.size - reader->position;
    const unsigned char *end = left > 0 ? memchr(begin, '\n', left) : NULL;
    if (end == NULL) {
        return false;
    }
    *line = (clast_bytes){begin, (uint64_t)(end - begin)};
    reader->position += line->size + 1;
    if (line->size > 0 && end[-1] == '\r') {
        line->size--;
    }
    return true;
}

static clast_status read_variable(hdr_reader *reader, clast_bytes line)
{
    const char *text = (const char *)line.data;
    const char *end = text + line.size;
    if (clast_bytes_begin_with(line, "FORMAT=") && !clast_bytes_begin_with(line, "FORMAT=32-bit_rle_rgbe")) {
        return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: HDR: the pixels are not RGBE", reader->name);
    }
    if (clast_bytes_begin_with(line, "EXPOSURE=")) {
        const char *at = text + strlen("EXPOSURE=");
        double value;
        while (at < end && *at == ' ') {
            at++;
        }
        if (!clast_parse_number(at, end, &value, &at) || !(value > 0) || !isfinite(value)) {
            return malformed(reader, "the exposure is not a positive number");
        }
        reader->exposure *= value;
    }
    return CLAST_OK;
}

// An axis of the resolution line, as "-Y 512".
static bool read_axis(const char **at, const char *end, char axis, bool *minus, int64_t *size)
{
    while (*at < end && **at == ' ') {
        (*at)++;
    }
    if (end - *at < 3 || ((*at)[0] != '-' && (*at)[0] != '+') || (*at)[1] != axis || (*at)[2] != ' ') {
        return false;
    }
    *minus = (*at)[0] == '-';
    const char *number = *at + 3;
    while (number < end && *number == ' ') {
        number++;
    }
    return clast_parse_integer(number, end, size, at) && *size >= 0;
}

static clast_status read_header(hdr_reader *reader, uint64_t *width, uint64_t *height)
{
    clast_bytes line;
    do {
        if (!next_line(reader, &line)) {
            return malformed(reader, "the header does not end with an empty line");
        }
        clast_status status = read_variable(reader, line);
        if (status != CLAST_OK) {
            return status;
        }
    } while (line.size > 0);
    if (!isfinite(reader->exposure) || reader->exposure <= 0) {
        return malformed(reader, "the exposures multiply to no number");
    }
    int64_t x, y;
    bool minus_x, minus_y;
    if (!next_line(reader, &line)) {
        return malformed(reader, "the file ends before its resolution");
    }
    const char *at = (const char *)line.data;
    const char *end = at + line.size;
    if (line.size > 1 && line.data[1] == 'X') {
        return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: HDR: the picture is stored by columns",
                          reader->name);
    }
    if (!read_axis(&at, end, 'Y', &minus_y, &y) || !read_axis(&at, end, 'X', &minus_x, &x)) {
        return malformed(reader, "expected a resolution such as -Y 512 +X 1024");
    }
    reader->flip_y = !minus_y;
    reader->flip_x = minus_x;
    *width = (uint64_t)x;
    *height = (uint64_t)y;
    return CLAST_OK;
}

static bool next_bytes(hdr_reader *reader, void *data, size_t length)
{
    if (!clast_bytes_read(reader->bytes, reader->position, data, length)) {
        return false;
    }
    reader->position += length;
    return true;
}

// Flat pixels, with the old runs: (1, 1, 1, n) repeats the pixel before it; runs that follow each other count 256-fold.
static clast_status read_old_scanline(hdr_reader *reader, unsigned char *pixels, uint32_t width)
{
    int shift = 0;
    for (uint32_t x = 0; x < width;) {
        unsigned char *pixel = pixels + 4 * (size_t)x;
        if (!next_bytes(reader, pixel, 4)) {
            return malformed(reader, "the file ends inside a scanline");
        }
        if (pixel[0] != 1 || pixel[1] != 1 || pixel[2] != 1) {
            shift = 0;
            x++;
            continue;
        }
        uint64_t count = shift > 16 ? UINT32_MAX : (uint64_t)pixel[3] << shift;
        if (x == 0 || count > width - x) {
            return malformed(reader, "a run leaves its scanline");
        }
        for (; count > 0; count--, x++) {
            memcpy(pixels + 4 * (size_t)x, pixels + 4 * ((size_t)x - 1), 4);
        }
        shift += 8;
    }
    return CLAST_OK;
}

static clast_status read_component(hdr_reader *reader, unsigned char *values, uint32_t width)
{
    for (uint32_t x = 0; x < width;) {
        unsigned char code[2];
        if (!next_bytes(reader, code, 1)) {
            return malformed(reader, "the file ends inside a scanline");
        }
        uint32_t count = code[0] > 128 ? code[0] - 128u : code[0];
        if (count == 0 || count > width - x) {
            return malformed(reader, "a run leaves its scanline");
        }
        if (code[0] > 128) {
            if (!next_bytes(reader, code + 1, 1)) {
                return malformed(reader, "the file ends inside a scanline");
            }
            memset(values + x, code[1], count);
        } else if (!next_bytes(reader, values + x, count)) {
            return malformed(reader, "the file ends inside a scanline");
        }
        x += count;
    }
    return CLAST_OK;
}

// `scratch` holds 4 bytes for each pixel: pixels of RGBE.
static clast_status read_scanline(hdr_reader *reader, unsigned char *scratch, unsigned char *planes, uint32_t width)
{
    unsigned char head[4];
    bool runs = width >= RUN_WIDTH_LEAST && width <= RUN_WIDTH_MOST &&
                clast_bytes_read(reader->bytes, reader->position, head, 4) && head[0] == 2 && head[1] == 2 &&
                head[2] < 128;
    if (!runs) {
        return read_old_scanline(reader, scratch, width);
    }
    if (((uint32_t)head[2] << 8 | head[3]) != width) {
        return malformed(reader, "a scanline has another width than the picture");
    }
    reader->position += 4;
    for (uint32_t c = 0; c < 4; c++) {
        clast_status status = read_component(reader, planes + c * (size_t)width, width);
        if (status != CLAST_OK) {
            return status;
        }
    }
    for (uint32_t x = 0; x < width; x++) {
        for (uint32_t c = 0; c < 4; c++) {
            scratch[4 * (size_t)x + c] = planes[c * (size_t)width + x];
        }
    }
    return CLAST_OK;
}

static void store_scanline(const hdr_reader *reader, const unsigned char *rgbe, float *row, uint32_t width)
{
    for (uint32_t x = 0; x < width; x++) {
        const unsigned char *from = rgbe + 4 * (size_t)x;
        float *to = row + 3 * (size_t)(reader->flip_x ? width - 1 - x : x);
        double scale = from[3] == 0 ? 0.0 : ldexp(1.0, (int)from[3] - 136) / reader->exposure;
        for (int c = 0; c < 3; c++) {
            to[c] = (float)(from[c] * scale);
        }
    }
}

static clast_status read_pixels(hdr_reader *reader, unsigned char *scratch, clast_image *image)
{
    for (uint32_t y = 0; y < image->height; y++) {
        clast_status status = read_scanline(reader, scratch, scratch + 4 * (size_t)image->width, image->width);
        if (status != CLAST_OK) {
            return status;
        }
        uint32_t row = reader->flip_y ? image->height - 1 - y : y;
        store_scanline(reader, scratch, (float *)image->pixels + 3 * (size_t)row * image->width, image->width);
    }
    return CLAST_OK;
}

clast_status clast_hdr_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    hdr_reader reader = {.context = context, .name = name, .bytes = bytes, .exposure = 1.0};
    uint64_t width = 0, height = 0;
    clast_status status = read_header(&reader, &width, &height);
    if (status != CLAST_OK) {
        return status;
    }
    // A scanline costs at least a byte, so a taller picture than that is known to end early.
    if (height > bytes.size) {
        return malformed(&reader, "the file is too short for the size of its picture");
    }
    status = clast_image_allocate(context, name, bytes.size, width, height, 3, CLAST_PIXEL_FLOAT, image);
    if (status != CLAST_OK) {
        return status;
    }
    unsigned char *scratch = clast_allocate(context, (size_t)width, 8);
    status = scratch != NULL ? read_pixels(&reader, scratch, image) : CLAST_ERROR_OUT_OF_MEMORY;
    clast_free(context, scratch);
    if (status != CLAST_OK) {
        clast_image_free(context, image);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------ writing

// Negative values and NaN have no place in RGBE and become 0; infinity becomes the largest.
static void to_rgbe(const float colour[3], unsigned char rgbe[4])
{
    double values[3];
    double most = 0.0;
    for (int c = 0; c < 3; c++) {
        values[c] = colour[c] > 0.0f ? (double)colour[c] : 0.0;
        values[c] = values[c] < 1.6e38 ? values[c] : 1.6e38;
        most = values[c] > most ? values[c] : most;
    }
    int exponent;
    frexp(most, &exponent);
    if (most > 0.0 && most * ldexp(1.0, 8 - exponent) >= 255.5) {
        exponent++; // rounding would pass 255
    }
    if (most == 0.0 || exponent < -127) {
        memset(rgbe, 0, 4);
        return;
    }
    for (int c = 0; c < 3; c++) {
        rgbe[c] = (unsigned char)(values[c] * ldexp(1.0, 8 - exponent) + 0.5);
    }
    rgbe[3] = (unsigned char)(exponent + 128);
}

static size_t run_length(const unsigned char *values, size_t left)
{
    size_t length = 1;
    while (length < left && length < 127 && values[length] == values[0]) {
        length++;
    }
    return length;
}

// Packs a plane into runs of 4 and more and stretches of the rest; at most 129 bytes for each 128. Returns the size.
static size_t pack_component(const unsigned char *values, size_t width, unsigned char *packed)
{
    size_t size = 0;
    for (size_t x = 0; x < width;) {
        size_t run = run_length(values + x, width - x);
        if (run >= 4) {
            packed[size++] = (unsigned char)(128 + run);
            packed[size++] = values[x];
            x += run;
            continue;
        }
        size_t end = x + run;
        while (end < width && end - x < 124 && (run = run_length(values + end, width - end)) < 4) {
            end += run;
        }
        packed[size++] = (unsigned char)(end - x);
        memcpy(packed + size, values + x, end - x);
        size += end - x;
        x = end;
    }
    return size;
}

static void write_scanline(clast_file_output *output, const float *row, uint32_t width, unsigned char *scratch)
{
    unsigned char *packed = scratch + 4 * (size_t)width;
    bool runs = width >= RUN_WIDTH_LEAST && width <= RUN_WIDTH_MOST;
    for (size_t x = 0; x < width; x++) {
        unsigned char rgbe[4];
        to_rgbe(row + 3 * x, rgbe);
        for (size_t c = 0; c < 4; c++) {
            scratch[runs ? c * width + x : 4 * x + c] = rgbe[c];
        }
    }
    if (!runs) {
        clast_file_write(output, scratch, 4 * (size_t)width);
        return;
    }
    unsigned char head[4] = {2, 2, (unsigned char)(width >> 8), (unsigned char)width};
    clast_file_write(output, head, 4);
    for (size_t c = 0; c < 4; c++) {
        clast_file_write(output, packed, pack_component(scratch + c * width, width, packed));
    }
}

void clast_hdr_encode(clast_file_output *output, const clast_image *image)
{
    unsigned char *scratch = clast_allocate(output->context, image->width, 6);
    if (scratch == NULL) {
        output->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    clast_file_print(output, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %u +X %u\n", image->height, image->width);
    for (size_t y = 0; y < image->height; y++) {
        write_scanline(output, (const float *)image->pixels + 3 * y * image->width, image->width, scratch);
    }
    clast_free(output->context, scratch);
}
