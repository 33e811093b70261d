// SPDX-License-Identifier: Apache-2.0
// WebP by libwebp, lossy and lossless; pictures that move are refused.
#include <webp/decode.h>

#include "load/image.h"

static clast_status failed(clast_context *context, const char *name, VP8StatusCode code)
{
    static const char *const texts[] = {
        [VP8_STATUS_INVALID_PARAM] = "the header has values out of range",
        [VP8_STATUS_BITSTREAM_ERROR] = "the data is damaged",
        [VP8_STATUS_UNSUPPORTED_FEATURE] = "a feature of the format that libwebp does not read",
        [VP8_STATUS_SUSPENDED] = "the file ends early",
        [VP8_STATUS_NOT_ENOUGH_DATA] = "the file ends early",
    };
    if (code == VP8_STATUS_OUT_OF_MEMORY) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "%s: WebP: memory ran out", name);
    }
    bool is_known = (size_t)code < sizeof texts / sizeof *texts && texts[code] != NULL;
    return clast_fail(context, code == VP8_STATUS_UNSUPPORTED_FEATURE ? CLAST_ERROR_UNSUPPORTED : CLAST_ERROR_MALFORMED,
                      "%s: WebP: %s", name, is_known ? texts[code] : "the picture could not be decoded");
}

clast_status clast_webp_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    WebPDecoderConfig config;
    if (bytes.size > SIZE_MAX || !WebPInitDecoderConfig(&config)) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: WebP: libwebp is of another version", name);
    }
    VP8StatusCode code = WebPGetFeatures(bytes.data, (size_t)bytes.size, &config.input);
    if (code != VP8_STATUS_OK) {
        return failed(context, name, code);
    }
    if (config.input.has_animation) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: WebP: a moving picture: expected one image", name);
    }
    uint32_t channels = config.input.has_alpha ? 4 : 3;
    clast_status status = clast_image_allocate(context, name, bytes.size, (uint64_t)config.input.width,
                                               (uint64_t)config.input.height, channels, CLAST_PIXEL_UNORM8, image);
    if (status != CLAST_OK) {
        return status;
    }
    size_t stride = (size_t)image->width * channels;
    config.output.colorspace = channels == 4 ? MODE_RGBA : MODE_RGB;
    config.output.is_external_memory = 1;
    config.output.u.RGBA.rgba = (uint8_t *)image->pixels;
    config.output.u.RGBA.stride = (int)stride;
    config.output.u.RGBA.size = stride * image->height;
    code = WebPDecode(bytes.data, (size_t)bytes.size, &config);
    WebPFreeDecBuffer(&config.output);
    if (code != VP8_STATUS_OK) {
        clast_image_free(context, image);
        return failed(context, name, code);
    }
    return CLAST_OK;
}
