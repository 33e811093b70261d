// SPDX-License-Identifier: Apache-2.0
// Portable float map: "PF" or "Pf", width, height and scale as text, one space character, then rows of floats from the
// bottom. A negative scale means little-endian; its size is ignored, as all programs do.
#include <math.h>

#include "load/image.h"
#include "load/number.h"

static uint32_t swapped(uint32_t word)
{
    return word >> 24 | (word >> 8 & 0xff00) | (word << 8 & 0xff0000) | word << 24;
}

static const char *skip_space(const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\n' || *at == '\r' || *at == '\t')) {
        at++;
    }
    return at;
}

clast_status clast_pfm_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    const char *at = (const char *)bytes.data + 2;
    const char *end = (const char *)bytes.data + bytes.size;
    double values[3]; // width, height, scale
    for (int i = 0; i < 3; i++) {
        const char *begin = skip_space(at, end);
        if (begin == at || !clast_parse_number(begin, end, &values[i], &at)) {
            return clast_fail(context, CLAST_ERROR_MALFORMED,
                              "%s: PFM: expected width, height and scale after the first line", name);
        }
    }
    double most = 4294967295.0;
    if (!(values[0] >= 0 && values[0] <= most && values[1] >= 0 && values[1] <= most) || values[2] == 0 ||
        !isfinite(values[2])) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: PFM: the width, height or scale is not one", name);
    }
    uint32_t channels = bytes.data[1] == 'F' ? 3 : 1;
    clast_status status = clast_image_allocate(context, name, bytes.size, (uint64_t)values[0], (uint64_t)values[1],
                                               channels, CLAST_PIXEL_FLOAT, image);
    if (status != CLAST_OK) {
        return status;
    }
    uint64_t offset = (uint64_t)(at - (const char *)bytes.data) + 1;
    size_t row = (size_t)image->width * channels;
    bool swap = (values[2] < 0) != clast_is_little_endian();
    uint32_t *pixels = (uint32_t *)image->pixels;
    for (uint32_t y = 0; y < image->height; y++) {
        uint32_t *to = pixels + (image->height - 1 - y) * row;
        if (!clast_bytes_read(bytes, offset, to, row * 4)) {
            clast_image_free(context, image);
            return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: PFM: the file ends in row %u from the bottom", name,
                              y);
        }
        for (size_t i = 0; swap && i < row; i++) {
            to[i] = swapped(to[i]);
        }
        offset += row * 4;
    }
    return CLAST_OK;
}

void clast_pfm_encode(clast_file_output *output, const clast_image *image)
{
    size_t row = (size_t)image->width * image->channels;
    const float *pixels = image->pixels;
    clast_file_print(output, "P%c\n%u %u\n%s\n", image->channels == 3 ? 'F' : 'f', image->width, image->height,
                     clast_is_little_endian() ? "-1.0" : "1.0");
    for (uint32_t y = image->height; y-- > 0;) {
        clast_file_write(output, pixels + y * row, row * sizeof *pixels);
    }
}
