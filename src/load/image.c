// SPDX-License-Identifier: Apache-2.0
// Which image format a file has, and what all of them share.
#include "load/image.h"

#include "load/load.h"

clast_status clast_image_check_size(clast_context *context, const char *name, uint64_t stored, uint64_t size)
{
    uint64_t most = clast_unpacked_most(stored);
    return size <= most
               ? CLAST_OK
               : clast_fail(context, CLAST_ERROR_LIMIT,
                            "%s: a picture that takes %llu bytes: at most %llu are read from a file of %llu", name,
                            (unsigned long long)size, (unsigned long long)most, (unsigned long long)stored);
}

clast_status clast_image_allocate(clast_context *context, const char *name, uint64_t stored, uint64_t width,
                                  uint64_t height, uint32_t channels, clast_pixel_type type, clast_image *image)
{
    *image = (clast_image){0};
    if (width == 0 || height == 0) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: an image of %llu x %llu pixels: expected at least 1 x 1",
                          name, (unsigned long long)width, (unsigned long long)height);
    }
    if (width > CLAST_IMAGE_SIDE || height > CLAST_IMAGE_SIDE) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "%s: an image of %llu x %llu pixels: at most %d a side are read",
                          name, (unsigned long long)width, (unsigned long long)height, CLAST_IMAGE_SIDE);
    }
    uint64_t size = width * height * channels * clast_pixel_size(type); // below 2^37: no overflow
    clast_status status = clast_image_check_size(context, name, stored, size);
    if (status != CLAST_OK) {
        return status;
    }
    void *pixels = clast_allocate(context, (size_t)size, 1);
    if (pixels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *image = (clast_image){(uint32_t)width, (uint32_t)height, channels, type, pixels};
    return CLAST_OK;
}

void clast_copy_line(char *to, size_t size, const char *text)
{
    size_t length = 0;
    for (; text[length] != '\0' && text[length] != '\n' && length + 1 < size; length++) {
        to[length] = text[length] >= ' ' && text[length] <= '~' ? text[length] : '?';
    }
    to[length] = '\0';
}

void clast_image_free(clast_context *context, clast_image *image)
{
    if (context != NULL && image != NULL) {
        clast_free(context, (void *)image->pixels);
        *image = (clast_image){0};
    }
}

// Formats by what their files begin with.
static const struct {
    unsigned char size;
    char signature[13];
    clast_status (*decode)(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);
} readers[] = {
    {8, "\x89PNG\r\n\x1a\n", clast_png_decode},
    {3, "\xff\xd8\xff", clast_jpeg_decode},
    {2, "#?", clast_hdr_decode},
    {4, "\x76\x2f\x31\x01", clast_exr_decode},
    {4, "DDS ", clast_dds_decode},
    {12, "\xabKTX 11\xbb\r\n\x1a\n", clast_ktx_decode},
    {12, "\xabKTX 20\xbb\r\n\x1a\n", clast_ktx2_decode},
    {2, "PF", clast_pfm_decode},
    {2, "Pf", clast_pfm_decode},
};

static bool is_webp(clast_bytes bytes)
{
    return bytes.size >= 12 && memcmp(bytes.data, "RIFF", 4) == 0 && memcmp(bytes.data + 8, "WEBP", 4) == 0;
}

typedef clast_status decoder(clast_context *context, const char *name, clast_bytes bytes, clast_image *image);

// Null where the bytes are no image of a known type.
static decoder *decoder_of(clast_bytes bytes)
{
    for (size_t i = 0; i < sizeof readers / sizeof *readers; i++) {
        if (bytes.size >= readers[i].size && memcmp(bytes.data, readers[i].signature, readers[i].size) == 0) {
            return readers[i].decode;
        }
    }
    return is_webp(bytes) ? clast_webp_decode : clast_is_tga(bytes) ? clast_tga_decode : NULL;
}

bool clast_is_image(clast_bytes bytes)
{
    return decoder_of(bytes) != NULL;
}

bool clast_image_take_level(clast_context *context, const clast_image *finest, uint32_t level, uint32_t count,
                            clast_image *decoded, clast_image_levels *levels)
{
    bool is_level = decoded->width == clast_level_side(finest->width, level) && decoded->channels == finest->channels &&
                    decoded->height == clast_level_side(finest->height, level) && decoded->type == finest->type;
    if (is_level && level == 1) {
        is_level = clast_levels_create(context, finest, finest->channels, finest->type, count, levels) == CLAST_OK;
    }
    if (is_level) {
        clast_image place = clast_level_image(finest, levels, level);
        memcpy((void *)place.pixels, decoded->pixels,
               (size_t)place.width * place.height * place.channels * clast_pixel_size(place.type));
    }
    levels->count = is_level ? level : level - 1; // as far as they have come
    clast_image_free(context, decoded);
    return is_level;
}

clast_status clast_decode_image(clast_context *context, const char *name, const void *data, uint64_t size,
                                clast_image *image)
{
    return clast_decode_image_parts(context, name, data, size, image, NULL);
}

typedef clast_status parts_decoder(clast_context *context, const char *name, clast_bytes bytes, clast_image *image,
                                   clast_image_parts *parts);

// Null where a format has pixels alone.
static parts_decoder *parts_decoder_of(decoder *decode)
{
    return decode == clast_dds_decode    ? clast_dds_decode_parts
           : decode == clast_ktx_decode  ? clast_ktx_decode_parts
           : decode == clast_ktx2_decode ? clast_ktx2_decode_parts
                                         : NULL;
}

clast_status clast_decode_image_parts(clast_context *context, const char *name, const void *data, uint64_t size,
                                      clast_image *image, clast_image_parts *parts)
{
    clast_bytes bytes = {data, size};
    *image = (clast_image){0};
    if (parts != NULL) {
        *parts = (clast_image_parts){0};
    }
    decoder *decode = decoder_of(bytes);
    if (parts_decoder_of(decode) != NULL) {
        return parts_decoder_of(decode)(context, name, bytes, image, parts);
    }
    if (decode != NULL) {
        return decode(context, name, bytes, image);
    }
    if (size == 0) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: the file is empty: expected an image", name);
    }
    return clast_fail(
        context, CLAST_ERROR_UNSUPPORTED,
        "%s: not an image that clast reads: expected PNG, JPEG, WebP, Radiance HDR, EXR, PFM, TGA, DDS or KTX", name);
}

clast_status clast_image_read(clast_context *context, const char *path, clast_image *image)
{
    if (context == NULL || path == NULL || image == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *image = (clast_image){0};
    clast_file_view file;
    clast_status status = clast_file_map(context, path, &file);
    if (status == CLAST_OK) {
        status = clast_decode_image(context, path, file.data, file.size, image);
        clast_file_unmap(context, &file);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------- layers

// Maps a file that must be EXR.
static clast_status map_layers(clast_context *context, const char *path, clast_file_view *file)
{
    clast_status status = clast_file_map(context, path, file);
    if (status == CLAST_OK && decoder_of((clast_bytes){file->data, file->size}) != clast_exr_decode) {
        clast_file_unmap(context, file);
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: only EXR files have layers", path);
    }
    return status;
}

clast_status clast_image_read_layer(clast_context *context, const char *path, const char *layer, clast_image *image)
{
    if (context == NULL || path == NULL || layer == NULL || image == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *image = (clast_image){0};
    clast_file_view file;
    clast_status status = map_layers(context, path, &file);
    if (status == CLAST_OK) {
        status = clast_exr_decode_layer(context, path, (clast_bytes){file.data, file.size}, layer, image);
        clast_file_unmap(context, &file);
    }
    return status;
}

clast_status clast_image_list_layers(clast_context *context, const char *path, clast_layer_function function,
                                     void *user)
{
    if (context == NULL || path == NULL || function == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_file_view file;
    clast_status status = map_layers(context, path, &file);
    if (status == CLAST_OK) {
        status = clast_exr_list_layers(context, path, (clast_bytes){file.data, file.size}, function, user);
        clast_file_unmap(context, &file);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------ writing

static bool image_is_valid(const clast_image *image)
{
    return image != NULL && image->pixels != NULL && image->width > 0 && image->width <= CLAST_IMAGE_SIDE &&
           image->height > 0 && image->height <= CLAST_IMAGE_SIDE && image->channels >= 1 && image->channels <= 4 &&
           image->type >= CLAST_PIXEL_UNORM8 && image->type <= CLAST_PIXEL_FLOAT;
}

static void exr_encode_image(clast_file_output *output, const clast_image *image)
{
    static const char *const names[] = {"Y", "YA", "RGB", "RGBA"};
    clast_image_layer layer = {.name = "", .channels = names[image->channels - 1], .pixels = image->pixels};
    clast_image_window window = {0, 0, image->width, image->height, image->width, image->height};
    clast_exr_encode(output, &window, &layer, 1);
}

// What the extension of a file to write stands for. The masks have a bit for each pixel type and channel count.
typedef struct writer {
    const char *extension;
    unsigned types;
    unsigned channels;
    const char *expected;
    void (*encode)(clast_file_output *output, const clast_image *image);
} writer;

#define TYPE(type) (1u << (type))
static const writer writers[] = {
    {"png", TYPE(CLAST_PIXEL_UNORM8) | TYPE(CLAST_PIXEL_UNORM16), 0x1e, "8 or 16-bit pixels", clast_png_encode},
    {"pfm", TYPE(CLAST_PIXEL_FLOAT), 0x0a, "float pixels of 1 or 3 channels", clast_pfm_encode},
    {"exr", TYPE(CLAST_PIXEL_FLOAT), 0x1e, "float pixels", exr_encode_image},
    {"hdr", TYPE(CLAST_PIXEL_FLOAT), 0x08, "float pixels of 3 channels", clast_hdr_encode},
    {"jpg", TYPE(CLAST_PIXEL_UNORM8), 0x0a, "8-bit pixels of 1 or 3 channels", clast_jpeg_encode},
    {"jpeg", TYPE(CLAST_PIXEL_UNORM8), 0x0a, "8-bit pixels of 1 or 3 channels", clast_jpeg_encode},
};

static const writer *writer_of(const char *path)
{
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    for (size_t i = 0; i < sizeof writers / sizeof writers[0]; i++) {
        if (strcmp(writers[i].extension, extension) == 0) {
            return &writers[i];
        }
    }
    return NULL;
}

clast_status clast_image_write(clast_context *context, const char *path, const clast_image *image)
{
    if (context == NULL || path == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (!image_is_valid(image)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s: the image has no pixels, or a size, channel count or type out of range", path);
    }
    const writer *found = writer_of(path);
    if (found == NULL) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED,
                          "%s: not an image type that clast writes: expected .png, .jpg, .exr, .pfm or .hdr", path);
    }
    if (!(found->types & TYPE(image->type)) || !(found->channels & 1u << image->channels)) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: .%s takes %s, not %u channels of another type", path,
                          found->extension, found->expected, image->channels);
    }
    clast_file_output output;
    clast_status status = clast_file_create(context, path, &output);
    if (status == CLAST_OK) {
        found->encode(&output, image);
        status = clast_file_commit(&output);
    }
    return status;
}

static bool share_a_channel(const clast_image_layer *a, const clast_image_layer *b)
{
    return strcmp(a->name, b->name) == 0 && strpbrk(a->channels, b->channels) != NULL;
}

static bool has_a_channel_twice(const clast_image_layer *layer)
{
    for (const char *c = layer->channels; *c != '\0'; c++) {
        if (strchr(c + 1, *c) != NULL) {
            return true;
        }
    }
    return false;
}

// Channels must have different names: the EXR library does not come back from two of one name.
static bool layers_are_valid(const clast_image_layer *layers, size_t count)
{
    if (layers == NULL || count == 0 || count > 256) {
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        size_t channels = layers[i].channels != NULL ? strlen(layers[i].channels) : 0;
        if (layers[i].pixels == NULL || channels == 0 || channels > 16 || layers[i].name == NULL ||
            strlen(layers[i].name) > 200 || has_a_channel_twice(&layers[i])) {
            return false;
        }
        for (size_t k = 0; k < i; k++) {
            if (share_a_channel(&layers[i], &layers[k])) {
                return false;
            }
        }
    }
    return true;
}

static bool side_is_valid(uint32_t first, uint32_t count, uint32_t whole)
{
    return whole <= CLAST_IMAGE_SIDE && count != 0 && count <= whole && first <= whole - count;
}

clast_status clast_image_write_window(clast_context *context, const char *path, const clast_image_window *window,
                                      const clast_image_layer *layers, size_t count)
{
    if (context == NULL || path == NULL || window == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (!side_is_valid(window->x, window->width, window->picture_width) ||
        !side_is_valid(window->y, window->height, window->picture_height) || !layers_are_valid(layers, count)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s: a size, layer or channel name of the image is out of range", path);
    }
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    if (strcmp(extension, "exr") != 0) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "%s: layers are written as .exr only", path);
    }
    clast_file_output output;
    clast_status status = clast_file_create(context, path, &output);
    if (status == CLAST_OK) {
        clast_exr_encode(&output, window, layers, count);
        status = clast_file_commit(&output);
    }
    return status;
}

clast_status clast_image_write_layers(clast_context *context, const char *path, uint32_t width, uint32_t height,
                                      const clast_image_layer *layers, size_t count)
{
    clast_image_window window = {0, 0, width, height, width, height};
    return clast_image_write_window(context, path, &window, layers, count);
}
