// SPDX-License-Identifier: Apache-2.0
// JPEG by libturbojpeg, read and written.
#include <limits.h>
#include <turbojpeg.h>

#include "load/image.h"

// Adobe's programs store CMYK inverted, and say so by an APP14 segment. Segments: FF, marker, big-endian length.
static bool has_adobe_marker(clast_bytes bytes)
{
    uint64_t offset = 2;
    unsigned char head[9];
    while (clast_bytes_read(bytes, offset, head, sizeof head) && head[0] == 0xff && head[1] != 0xda) {
        if (head[1] == 0xee && memcmp(head + 4, "Adobe", 5) == 0) {
            return true;
        }
        offset += 2 + ((uint64_t)head[2] << 8 | head[3]);
    }
    return false;
}

static void cmyk_to_rgb(const unsigned char *cmyk, size_t count, bool inverted, unsigned char *rgb)
{
    for (size_t i = 0; i < count; i++) {
        unsigned black = inverted ? cmyk[4 * i + 3] : 255u - cmyk[4 * i + 3];
        for (int c = 0; c < 3; c++) {
            unsigned ink = inverted ? cmyk[4 * i + c] : 255u - cmyk[4 * i + c];
            rgb[3 * i + c] = (unsigned char)((ink * black + 127) / 255);
        }
    }
}

static bool ends_whole(clast_bytes bytes)
{
    uint64_t end = bytes.size;
    while (end > 0 && bytes.data[end - 1] == 0) { // padding
        end--;
    }
    return end >= 2 && bytes.data[end - 2] == 0xff && bytes.data[end - 1] == 0xd9;
}

// Stray bytes between segments harm nothing; any other warning means that part of the picture is guessed. The library keeps
// the first warning only, so a file with stray bytes must also be seen to be whole.
static bool is_harmless(tjhandle handle, clast_bytes bytes)
{
    return tjGetErrorCode(handle) == TJERR_WARNING && strstr(tjGetErrorStr2(handle), "extraneous bytes") != NULL &&
           ends_whole(bytes);
}

static clast_status decompress(clast_context *context, const char *name, tjhandle handle, clast_bytes bytes,
                               clast_image *image, void *pixels, int format)
{
    if (tjDecompress2(handle, bytes.data, (unsigned long)bytes.size, pixels, (int)image->width, 0, (int)image->height,
                      format, TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) == 0) {
        return CLAST_OK;
    }
    if (is_harmless(handle, bytes)) {
        clast_log(context, CLAST_LOG_WARNING, "%s: JPEG: %s", name, tjGetErrorStr2(handle));
        return CLAST_OK;
    }
    return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: JPEG: %s", name, tjGetErrorStr2(handle));
}

static clast_status decode_cmyk(clast_context *context, const char *name, tjhandle handle, clast_bytes bytes,
                                clast_image *image)
{
    clast_image cmyk;
    clast_status status = clast_image_allocate(context, name, bytes.size, image->width, image->height, 4,
                                               CLAST_PIXEL_UNORM8, &cmyk);
    if (status == CLAST_OK) {
        status = decompress(context, name, handle, bytes, image, (void *)cmyk.pixels, TJPF_CMYK);
    }
    if (status == CLAST_OK) {
        cmyk_to_rgb(cmyk.pixels, (size_t)image->width * image->height, has_adobe_marker(bytes), (void *)image->pixels);
    }
    clast_image_free(context, &cmyk);
    return status;
}

static clast_status decode(clast_context *context, const char *name, tjhandle handle, clast_bytes bytes,
                           clast_image *image)
{
    int width = 0, height = 0, sampling = 0, space = 0;
    if (tjDecompressHeader3(handle, bytes.data, (unsigned long)bytes.size, &width, &height, &sampling, &space) != 0 &&
        !is_harmless(handle, bytes)) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: JPEG: %s", name, tjGetErrorStr2(handle));
    }
    uint32_t channels = space == TJCS_GRAY ? 1 : 3;
    clast_status status = clast_image_allocate(context, name, bytes.size, (uint64_t)width, (uint64_t)height, channels,
                                               CLAST_PIXEL_UNORM8, image);
    if (status != CLAST_OK) {
        return status;
    }
    if (space == TJCS_CMYK || space == TJCS_YCCK) {
        return decode_cmyk(context, name, handle, bytes, image);
    }
    return decompress(context, name, handle, bytes, image, (void *)image->pixels, channels == 1 ? TJPF_GRAY : TJPF_RGB);
}

clast_status clast_jpeg_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    tjhandle handle = bytes.size <= ULONG_MAX ? tjInitDecompress() : NULL;
    if (handle == NULL) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "%s: JPEG: memory ran out", name);
    }
    clast_status status = decode(context, name, handle, bytes, image);
    tjDestroy(handle);
    if (status != CLAST_OK) {
        clast_image_free(context, image);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------ writing

enum { QUALITY = 95 }; // without subsampled colours: what a picture to look at can do without, and no more

void clast_jpeg_encode(clast_file_output *output, const clast_image *image)
{
    tjhandle handle = tjInitCompress();
    if (handle == NULL) {
        output->status = clast_fail(output->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: JPEG: %s", output->path,
                                    tjGetErrorStr2(NULL));
        return;
    }
    bool is_grey = image->channels == 1;
    unsigned char *bytes = NULL;
    unsigned long size = 0;
    if (tjCompress2(handle, image->pixels, (int)image->width, 0, (int)image->height, is_grey ? TJPF_GRAY : TJPF_RGB,
                    &bytes, &size, is_grey ? TJSAMP_GRAY : TJSAMP_444, QUALITY, TJFLAG_ACCURATEDCT) == 0) {
        clast_file_write(output, bytes, size);
    } else {
        output->status = clast_fail(output->context, CLAST_ERROR_UNSUPPORTED, "%s: JPEG: %s", output->path,
                                    tjGetErrorStr2(handle));
    }
    tjFree(bytes);
    tjDestroy(handle);
}
