// SPDX-License-Identifier: Apache-2.0
// Reading EXR by OpenEXRCore: the first flat part that holds a picture, by scanlines or tiles. The picture is the display window;
// what the data window leaves out of it is 0.
#include <math.h>
#include <openexr.h>

#include "load/image.h"

enum {
    CHANNELS_MOST = 4,           // of a picture
    LISTED_CHANNELS_MOST = 1024, // of all parts, where layers are listed: each is compared with all others
};

typedef struct exr_reader {
    clast_context *context;
    const char *name;
    clast_bytes bytes;
    exr_context_t file;
    int part;
    char error[200]; // what the library said first
    exr_attr_box2i_t data, display;
    const char *layer;                   // that is wanted; null for the picture
    const char *channels[CHANNELS_MOST]; // the file's channel for each of the image's
    uint32_t channel_count;
    clast_image image;
} exr_reader;

static void keep_error(exr_const_context_t file, exr_result_t code, const char *text)
{
    void *user = NULL;
    (void)code;
    if (file == NULL || exr_get_user_data(file, &user) != EXR_ERR_SUCCESS || user == NULL) {
        return;
    }
    exr_reader *reader = user;
    if (reader->error[0] == '\0') {
        clast_copy_line(reader->error, sizeof reader->error, text);
    }
}

static int64_t read_bytes(exr_const_context_t file, void *user, void *buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t error)
{
    (void)file;
    (void)error;
    exr_reader *reader = user;
    uint64_t left = offset < reader->bytes.size ? reader->bytes.size - offset : 0;
    uint64_t length = size < left ? size : left;
    if (length > 0) {
        memcpy(buffer, reader->bytes.data + offset, length);
    }
    return (int64_t)length;
}

static int64_t query_size(exr_const_context_t file, void *user)
{
    (void)file;
    return (int64_t)((exr_reader *)user)->bytes.size;
}

static clast_status failed(const exr_reader *reader, exr_result_t result)
{
    clast_status status = result == EXR_ERR_OUT_OF_MEMORY             ? CLAST_ERROR_OUT_OF_MEMORY
                          : result == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? CLAST_ERROR_UNSUPPORTED
                                                                      : CLAST_ERROR_MALFORMED;
    const char *text = reader->error[0] != '\0' ? reader->error : exr_get_default_error_message(result);
    if (status == CLAST_ERROR_UNSUPPORTED) {
        int major, minor, patch;
        exr_get_library_version(&major, &minor, &patch, NULL);
        return clast_fail(reader->context, status,
                          "%s: EXR: OpenEXR %d.%d.%d, which is installed, cannot read this: %s", reader->name, major,
                          minor, patch, text);
    }
    return clast_fail(reader->context, status, "%s: EXR: %s", reader->name, text);
}

static clast_status unsupported(const exr_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: EXR: %s", reader->name, text);
}

static clast_status malformed(const exr_reader *reader, const char *text)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: EXR: %s", reader->name, text);
}

// A channel of a layer, whose name is `length` letters of `layer` with their last dot; of no layer where that is 0.
static const exr_attr_chlist_entry_t *find_channel(const exr_attr_chlist_t *list, const char *layer, size_t length,
                                                   const char *name)
{
    for (int i = 0; i < list->num_channels; i++) {
        const char *text = list->entries[i].name.str;
        if (strncmp(text, layer, length) == 0 && strcmp(text + length, name) == 0) {
            return &list->entries[i];
        }
    }
    return NULL;
}

typedef struct exr_choice {
    const exr_attr_chlist_entry_t *channels[CHANNELS_MOST];
    uint32_t count;
} exr_choice;

// The colours of a layer, and their alpha.
static bool choose_colours(const exr_attr_chlist_t *list, const char *layer, size_t length, exr_choice *choice)
{
    static const char *const names[] = {"R", "G", "B", "A"};
    for (uint32_t i = 0; i < 4; i++) {
        choice->channels[i] = find_channel(list, layer, length, names[i]);
    }
    choice->count = choice->channels[3] != NULL ? 4 : 3;
    return choice->channels[0] != NULL && choice->channels[1] != NULL && choice->channels[2] != NULL;
}

static bool choose_grey(const exr_attr_chlist_t *list, exr_choice *choice)
{
    const exr_attr_chlist_entry_t *grey = find_channel(list, "", 0, "Y"), *red = find_channel(list, "", 0, "R"),
                                  *alpha = find_channel(list, "", 0, "A");
    choice->channels[0] = grey != NULL ? grey : red != NULL ? red : list->num_channels == 1 ? &list->entries[0] : NULL;
    choice->channels[1] = alpha;
    choice->count = alpha != NULL && alpha != choice->channels[0] ? 2 : 1;
    return choice->channels[0] != NULL;
}

// The first layer that has colours.
static bool choose_layer(const exr_attr_chlist_t *list, exr_choice *choice)
{
    for (int i = 0; i < list->num_channels; i++) {
        const char *text = list->entries[i].name.str, *dot = strrchr(text, '.');
        if (dot != NULL && choose_colours(list, text, (size_t)(dot + 1 - text), choice)) {
            return true;
        }
    }
    return false;
}

// Which channels make the picture: R, G and B; else Y; else R; else the only one there is; else R, G and B of a layer. A goes
// with each.
static clast_status choose_picture(const exr_reader *reader, const exr_attr_chlist_t *list, exr_choice *choice)
{
    if (choose_colours(list, "", 0, choice)) {
        return CLAST_OK;
    }
    if (find_channel(list, "", 0, "RY") || find_channel(list, "", 0, "BY")) {
        return unsupported(reader, "luminance and chroma channels (RY, BY) are not read");
    }
    if (!choose_grey(list, choice) && !choose_layer(list, choice)) {
        return unsupported(reader, "expected channels R, G and B, or Y");
    }
    return CLAST_OK;
}

// Of a channel's name, how much is its layer's: up to the last dot; all of it where there is none.
static size_t layer_length(const char *channel)
{
    const char *dot = strrchr(channel, '.');
    return dot != NULL ? (size_t)(dot - channel) : strlen(channel);
}

// Where a channel stands among those of its layer: in the order of the field's names, which is not that of the alphabet.
static int rank_of(const char *channel)
{
    static const char order[] = "RGBAXYZUV";
    const char *dot = strrchr(channel, '.');
    const char *letter = dot != NULL ? dot + 1 : channel, *found = letter[0] != '\0' ? strchr(order, letter[0]) : NULL;
    return found != NULL && letter[1] == '\0' ? (int)(found - order) : (int)sizeof order;
}

// The channels of a layer by name.
static clast_status choose_named(const exr_reader *reader, const exr_attr_chlist_t *list, exr_choice *choice)
{
    size_t length = strlen(reader->layer);
    choice->count = 0;
    for (int i = 0; i < list->num_channels; i++) {
        const char *text = list->entries[i].name.str;
        if (layer_length(text) != length || strncmp(text, reader->layer, length) != 0) {
            continue;
        }
        if (choice->count == CHANNELS_MOST) {
            return unsupported(reader, "the layer has more than four channels");
        }
        uint32_t place = choice->count++;
        for (; place > 0 && rank_of(choice->channels[place - 1]->name.str) > rank_of(text); place--) {
            choice->channels[place] = choice->channels[place - 1];
        }
        choice->channels[place] = &list->entries[i];
    }
    return choice->count != 0 ? CLAST_OK : unsupported(reader, "the file has no such layer");
}

static clast_status choose_channels(exr_reader *reader)
{
    const exr_attr_chlist_t *list;
    exr_result_t result = exr_get_channels(reader->file, reader->part, &list);
    if (result != EXR_ERR_SUCCESS) {
        return failed(reader, result);
    }
    exr_choice choice;
    clast_status status = reader->layer != NULL ? choose_named(reader, list, &choice)
                                                : choose_picture(reader, list, &choice);
    if (status != CLAST_OK) {
        return status;
    }
    for (uint32_t i = 0; i < choice.count; i++) {
        if (choice.channels[i]->x_sampling != 1 || choice.channels[i]->y_sampling != 1) {
            return unsupported(reader, "subsampled channels are not read");
        }
        reader->channels[i] = choice.channels[i]->name.str;
    }
    reader->channel_count = choice.count;
    return CLAST_OK;
}

// Takes the first flat part whose channels make a picture; where none does, the error is that of the last.
static clast_status choose_part(exr_reader *reader, int parts)
{
    clast_status status = parts > 0 ? CLAST_ERROR_UNSUPPORTED : malformed(reader, "the file has no part");
    for (int part = 0; part < parts && status == CLAST_ERROR_UNSUPPORTED; part++) {
        exr_storage_t storage;
        exr_result_t result = exr_get_storage(reader->file, part, &storage);
        if (result != EXR_ERR_SUCCESS) {
            return failed(reader, result);
        }
        bool is_flat = storage == EXR_STORAGE_SCANLINE || storage == EXR_STORAGE_TILED;
        reader->part = part;
        status = is_flat ? choose_channels(reader) : unsupported(reader, "deep pixels are not read");
    }
    return status;
}

static bool window_size(const exr_attr_box2i_t *window, uint64_t *width, uint64_t *height)
{
    if (window->max.x < window->min.x || window->max.y < window->min.y) {
        return false;
    }
    *width = (uint64_t)((int64_t)window->max.x - window->min.x + 1);
    *height = (uint64_t)((int64_t)window->max.y - window->min.y + 1);
    return true;
}

static clast_status open_file(exr_reader *reader, int *parts)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = keep_error;
    settings.user_data = reader;
    settings.read_fn = read_bytes;
    settings.size_fn = query_size;
    settings.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t result = exr_start_read(&reader->file, reader->name, &settings);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_get_count(reader->file, parts);
    }
    return result == EXR_ERR_SUCCESS ? CLAST_OK : failed(reader, result);
}

static clast_status read_header(exr_reader *reader)
{
    int parts = 0;
    clast_status status = open_file(reader, &parts);
    if (status == CLAST_OK) {
        status = choose_part(reader, parts);
    }
    if (status != CLAST_OK) {
        return status;
    }
    exr_result_t result = exr_get_data_window(reader->file, reader->part, &reader->data);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_get_display_window(reader->file, reader->part, &reader->display);
    }
    return result == EXR_ERR_SUCCESS ? CLAST_OK : failed(reader, result);
}

// The chunk table and the largest chunk must be possible for a file of this size before the library allocates them.
static clast_status check_sizes(exr_reader *reader)
{
    uint64_t width, height, unpacked;
    int32_t chunks;
    if (!window_size(&reader->data, &width, &height)) {
        return malformed(reader, "the data window is empty");
    }
    if (width > CLAST_IMAGE_SIDE || height > CLAST_IMAGE_SIDE) {
        return clast_fail(reader->context, CLAST_ERROR_LIMIT,
                          "%s: an image of %llu x %llu pixels: at most %d a side are read", reader->name,
                          (unsigned long long)width, (unsigned long long)height, CLAST_IMAGE_SIDE);
    }
    if (exr_get_chunk_count(reader->file, reader->part, &chunks) != EXR_ERR_SUCCESS || chunks <= 0 ||
        (uint64_t)chunks > reader->bytes.size / 8) {
        return malformed(reader, "the file is too short for its chunk table");
    }
    if (exr_get_chunk_unpacked_size(reader->file, reader->part, &unpacked) != EXR_ERR_SUCCESS) {
        return malformed(reader, "the chunks have no size");
    }
    return clast_image_check_size(reader->context, reader->name, reader->bytes.size, unpacked);
}

// 16-bit IEEE 754.
static float float_of_half(uint32_t half)
{
    uint32_t exponent = half >> 10 & 31, fraction = half & 1023;
    float size = exponent == 0    ? ldexpf((float)fraction, -24)
                 : exponent < 31  ? ldexpf((float)(fraction | 1024), (int)exponent - 25)
                 : fraction == 0u ? HUGE_VALF
                                  : NAN;
    return half & 0x8000 ? -size : size;
}

// A stored value, little-endian.
static float value_of(const uint8_t *bytes, uint16_t type)
{
    uint32_t word = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8;
    if (type == EXR_PIXEL_HALF) {
        return float_of_half(word);
    }
    word |= (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
    float value;
    memcpy(&value, &word, sizeof value);
    return type == EXR_PIXEL_UINT ? (float)word : value;
}

// Where a chunk's line comes to lie in the image.
typedef struct exr_line {
    int64_t left, y; // of the chunk's first pixel, relative to the display window
} exr_line;

static void store_channel(exr_reader *reader, exr_line line, uint32_t to, const exr_coding_channel_info_t *channel,
                          const uint8_t *bytes)
{
    if (line.y < 0 || line.y >= reader->image.height) {
        return;
    }
    float *row = (float *)reader->image.pixels + (size_t)line.y * reader->image.width * reader->channel_count + to;
    for (int64_t x = 0; x < channel->width; x++) {
        if (line.left + x >= 0 && line.left + x < reader->image.width) {
            row[(size_t)(line.left + x) * reader->channel_count] = value_of(
                bytes + (size_t)x * (size_t)channel->bytes_per_element, channel->data_type);
        }
    }
}

// Which of the image's channels a channel of the file is; CLAST_NONE for none.
static uint32_t place_of(const exr_reader *reader, const char *name)
{
    for (uint32_t c = 0; c < reader->channel_count; c++) {
        if (strcmp(reader->channels[c], name) == 0) {
            return c;
        }
    }
    return CLAST_NONE;
}

// Takes a decompressed chunk apart: line by line, in each the channels one after the other. (The library's own functions for
// this write through null where a file's channels are not what they expect.)
static bool store_chunk(exr_reader *reader, const exr_decode_pipeline_t *decoder, clast_bytes bytes, int64_t left,
                        int64_t top)
{
    uint64_t offset = 0;
    for (int64_t y = 0; y < decoder->chunk.height; y++) {
        exr_line line = {left - reader->display.min.x, top + y - reader->display.min.y};
        for (int i = 0; i < decoder->channel_count; i++) {
            const exr_coding_channel_info_t *channel = &decoder->channels[i];
            if (channel->y_samples > 1 && (top + y) % channel->y_samples != 0) {
                continue;
            }
            int size = channel->data_type == EXR_PIXEL_HALF ? 2 : 4;
            clast_bytes values;
            if (channel->width < 0 || channel->bytes_per_element != size ||
                !clast_bytes_slice(bytes, offset, (uint64_t)channel->width * (uint64_t)size, &values)) {
                return false;
            }
            offset += values.size;
            uint32_t place = place_of(reader, channel->channel_name);
            if (place != CLAST_NONE) {
                store_channel(reader, line, place, channel, values.data);
            }
        }
    }
    return true;
}

// Reads and decompresses a chunk.
static exr_result_t decode_chunk(exr_reader *reader, exr_decode_pipeline_t *decoder, const exr_chunk_info_t *chunk)
{
    exr_result_t result = decoder->channels == NULL
                              ? exr_decoding_initialize(reader->file, reader->part, chunk, decoder)
                              : exr_decoding_update(reader->file, reader->part, chunk, decoder);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_decoding_choose_default_routines(reader->file, reader->part, decoder);
    }
    decoder->unpack_and_convert_fn = NULL;
    if (chunk->packed_size == chunk->unpacked_size) { // what packing made no smaller is stored as it is
        decoder->decompress_fn = NULL;
    }
    return result == EXR_ERR_SUCCESS ? exr_decoding_run(reader->file, reader->part, decoder) : result;
}

static clast_status read_chunk(exr_reader *reader, exr_decode_pipeline_t *decoder, const exr_chunk_info_t *chunk,
                               int64_t left, int64_t top)
{
    // The library allocates what a chunk says that it unpacks to, and does not always hold that against the part's own size.
    uint64_t largest = 0;
    exr_get_chunk_unpacked_size(reader->file, reader->part, &largest);
    if (chunk->width <= 0 || chunk->height <= 0 || chunk->unpacked_size > largest ||
        chunk->packed_size > reader->bytes.size) {
        return malformed(reader, "a chunk has an impossible size");
    }
    exr_result_t result = decode_chunk(reader, decoder, chunk);
    if (result == EXR_ERR_OUT_OF_MEMORY && decoder->unpacked_buffer != NULL) {
        return malformed(reader, "a chunk does not unpack"); // with room for it, the library means its data
    }
    if (result != EXR_ERR_SUCCESS) {
        return failed(reader, result);
    }
    bool is_packed = decoder->decompress_fn != NULL;
    clast_bytes bytes = {is_packed ? decoder->unpacked_buffer : decoder->packed_buffer, chunk->unpacked_size};
    if (!is_packed && chunk->packed_size < chunk->unpacked_size) {
        bytes.size = chunk->packed_size;
    }
    if (bytes.data == NULL || !store_chunk(reader, decoder, bytes, left, top)) {
        return malformed(reader, "a chunk ends early");
    }
    return CLAST_OK;
}

static clast_status read_scanlines(exr_reader *reader, exr_decode_pipeline_t *decoder)
{
    int32_t lines = 0;
    exr_result_t result = exr_get_scanlines_per_chunk(reader->file, reader->part, &lines);
    if (result != EXR_ERR_SUCCESS || lines <= 0) {
        return malformed(reader, "the chunks hold no scanlines");
    }
    for (int64_t y = reader->data.min.y; y <= reader->data.max.y; y += lines) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(reader->file, reader->part, (int)y, &chunk);
        clast_status status = result == EXR_ERR_SUCCESS ? read_chunk(reader, decoder, &chunk, reader->data.min.x, y)
                                                        : failed(reader, result);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

static clast_status read_tiles(exr_reader *reader, exr_decode_pipeline_t *decoder)
{
    int32_t width, height;
    exr_result_t result = exr_get_tile_sizes(reader->file, reader->part, 0, 0, &width, &height);
    if (result != EXR_ERR_SUCCESS || width <= 0 || height <= 0) {
        return malformed(reader, "the tiles have no size");
    }
    int64_t across = ((int64_t)reader->data.max.x - reader->data.min.x) / width + 1;
    int64_t down = ((int64_t)reader->data.max.y - reader->data.min.y) / height + 1;
    for (int64_t i = 0; i < across * down; i++) {
        int64_t x = i % across;
        int64_t y = i / across;
        exr_chunk_info_t chunk;
        result = exr_read_tile_chunk_info(reader->file, reader->part, (int)x, (int)y, 0, 0, &chunk);
        clast_status status = result == EXR_ERR_SUCCESS
                                  ? read_chunk(reader, decoder, &chunk, reader->data.min.x + x * width,
                                               reader->data.min.y + y * height)
                                  : failed(reader, result);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

static clast_status read_pixels(exr_reader *reader)
{
    uint64_t width = 0, height = 0;
    exr_storage_t storage = EXR_STORAGE_SCANLINE;
    clast_status status = check_sizes(reader);
    if (status == CLAST_OK && !window_size(&reader->display, &width, &height)) {
        status = malformed(reader, "the display window is empty");
    }
    if (status == CLAST_OK) {
        status = clast_image_allocate(reader->context, reader->name, reader->bytes.size, width, height,
                                      reader->channel_count, CLAST_PIXEL_FLOAT, &reader->image);
    }
    if (status != CLAST_OK) {
        return status;
    }
    memset((void *)reader->image.pixels, 0, (size_t)(width * height * reader->channel_count * 4));
    exr_get_storage(reader->file, reader->part, &storage);
    exr_decode_pipeline_t decoder = EXR_DECODE_PIPELINE_INITIALIZER;
    status = storage == EXR_STORAGE_TILED ? read_tiles(reader, &decoder) : read_scanlines(reader, &decoder);
    exr_decoding_destroy(reader->file, &decoder);
    return status;
}

static clast_status decode(exr_reader *reader, clast_image *image)
{
    clast_status status = read_header(reader);
    if (status == CLAST_OK) {
        status = read_pixels(reader);
    }
    if (reader->file != NULL) {
        exr_finish(&reader->file);
    }
    if (status != CLAST_OK) {
        clast_image_free(reader->context, &reader->image);
        return status;
    }
    *image = reader->image;
    return CLAST_OK;
}

clast_status clast_exr_decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    exr_reader reader = {.context = context, .name = name, .bytes = bytes};
    return decode(&reader, image);
}

clast_status clast_exr_decode_layer(clast_context *context, const char *name, clast_bytes bytes, const char *layer,
                                    clast_image *image)
{
    exr_reader reader = {.context = context, .name = name, .bytes = bytes, .layer = layer[0] != '\0' ? layer : NULL};
    return decode(&reader, image);
}

// ------------------------------------------------------------------------------------------------------------- layers

// Whether a channel is of the layer without a name.
static bool is_of_picture(const char *channel)
{
    return channel[0] != '\0' && strchr("RGBAY", channel[0]) != NULL && channel[1] == '\0';
}

// Whether a layer was told already: by a channel before `end` in this part, or by one of a part before.
static bool is_told(const exr_reader *reader, int part, int end, const char *channel)
{
    size_t length = layer_length(channel);
    for (int p = 0; p <= part; p++) {
        const exr_attr_chlist_t *list;
        if (exr_get_channels(reader->file, p, &list) != EXR_ERR_SUCCESS) {
            continue;
        }
        for (int i = 0; i < (p < part ? list->num_channels : end); i++) {
            const char *text = list->entries[i].name.str;
            bool same = is_of_picture(channel) ? is_of_picture(text)
                                               : !is_of_picture(text) && layer_length(text) == length &&
                                                     strncmp(text, channel, length) == 0;
            if (same) {
                return true;
            }
        }
    }
    return false;
}

static clast_status tell_layer(const exr_reader *reader, const char *channel, clast_layer_function function, void *user)
{
    size_t length = is_of_picture(channel) ? 0 : layer_length(channel);
    char *layer = clast_allocate(reader->context, length + 1, 1);
    if (layer == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memcpy(layer, channel, length);
    layer[length] = '\0';
    function(user, layer);
    clast_free(reader->context, layer);
    return CLAST_OK;
}

static clast_status tell_part(const exr_reader *reader, int part, clast_layer_function function, void *user)
{
    const exr_attr_chlist_t *list;
    exr_result_t result = exr_get_channels(reader->file, part, &list);
    clast_status status = result == EXR_ERR_SUCCESS ? CLAST_OK : failed(reader, result);
    for (int i = 0; status == CLAST_OK && i < list->num_channels; i++) {
        const char *channel = list->entries[i].name.str;
        if (!is_told(reader, part, i, channel)) {
            status = tell_layer(reader, channel, function, user);
        }
    }
    return status;
}

clast_status clast_exr_list_layers(clast_context *context, const char *name, clast_bytes bytes,
                                   clast_layer_function function, void *user)
{
    exr_reader reader = {.context = context, .name = name, .bytes = bytes};
    int parts = 0, channels = 0;
    clast_status status = open_file(&reader, &parts);
    for (int part = 0; status == CLAST_OK && part < parts; part++) {
        const exr_attr_chlist_t *list;
        channels += exr_get_channels(reader.file, part, &list) == EXR_ERR_SUCCESS ? list->num_channels : 0;
        if (channels > LISTED_CHANNELS_MOST || part > LISTED_CHANNELS_MOST) {
            status = clast_fail(context, CLAST_ERROR_LIMIT, "%s: EXR: more than %d channels", name,
                                LISTED_CHANNELS_MOST);
        }
    }
    for (int part = 0; status == CLAST_OK && part < parts; part++) {
        exr_storage_t storage;
        bool is_flat = exr_get_storage(reader.file, part, &storage) == EXR_ERR_SUCCESS &&
                       (storage == EXR_STORAGE_SCANLINE || storage == EXR_STORAGE_TILED);
        status = is_flat ? tell_part(&reader, part, function, user) : CLAST_OK;
    }
    if (reader.file != NULL) {
        exr_finish(&reader.file);
    }
    return status;
}
