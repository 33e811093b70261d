// SPDX-License-Identifier: Apache-2.0
// Writing EXR by OpenEXRCore: one part, scanlines, ZIP, channels of 32 bits or of 16-bit floats. The library goes back to fill in its chunk
// table, so the file is made in memory and then handed to the output.
#include <openexr.h>
#include <stdio.h>

#include "load/image.h"

enum { CHANNEL_NAME_SIZE = 256 };

typedef struct exr_channel {
    char name[CHANNEL_NAME_SIZE];
    const uint8_t *pixels; // the channel's value of the first pixel
    int32_t stride;        // bytes from pixel to pixel
    uint16_t type;         // of the pixels
    uint16_t stored_type;  // in the file
} exr_channel;

typedef struct exr_writer {
    clast_file_output *output;
    exr_context_t file;
    char error[200];
    unsigned char *bytes;
    size_t size, capacity;
    bool memory_ran_out;
    exr_channel *channels;
    size_t channel_count;
} exr_writer;

static void keep_error(exr_const_context_t file, exr_result_t code, const char *text)
{
    void *user = NULL;
    (void)code;
    if (file == NULL || exr_get_user_data(file, &user) != EXR_ERR_SUCCESS || user == NULL) {
        return;
    }
    exr_writer *writer = user;
    if (writer->error[0] == '\0') {
        clast_copy_line(writer->error, sizeof writer->error, text);
    }
}

static int64_t write_bytes(exr_const_context_t file, void *user, const void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t error)
{
    (void)file;
    (void)error;
    exr_writer *writer = user;
    size_t end;
    if (offset > SIZE_MAX || size > SIZE_MAX || !clast_add_size((size_t)offset, (size_t)size, &end) ||
        CLAST_RESERVE(writer->output->context, writer->bytes, writer->capacity, end) != CLAST_OK) {
        writer->memory_ran_out = true;
        return -1;
    }
    if (offset > writer->size) {
        memset(writer->bytes + writer->size, 0, (size_t)offset - writer->size);
    }
    memcpy(writer->bytes + offset, buffer, (size_t)size);
    writer->size = end > writer->size ? end : writer->size;
    return (int64_t)size;
}

static bool list_channels(exr_writer *writer, const clast_image_layer *layers, size_t count)
{
    size_t total = 0;
    for (size_t i = 0; i < count; i++) {
        total += strlen(layers[i].channels);
    }
    writer->channels = clast_allocate(writer->output->context, total, sizeof *writer->channels);
    if (writer->channels == NULL) {
        writer->memory_ran_out = true;
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        const clast_image_layer *layer = &layers[i];
        size_t channels = strlen(layer->channels);
        for (size_t c = 0; c < channels; c++) {
            exr_channel *channel = &writer->channels[writer->channel_count++];
            snprintf(channel->name, sizeof channel->name, "%s%s%c", layer->name, layer->name[0] != '\0' ? "." : "",
                     layer->channels[c]);
            channel->pixels = (const uint8_t *)layer->pixels + 4 * c;
            channel->stride = (int32_t)(4 * channels);
            channel->type = layer->is_integer ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
            channel->stored_type = layer->is_half && !layer->is_integer ? EXR_PIXEL_HALF : channel->type;
        }
    }
    return true;
}

static exr_attr_box2i_t box_of(uint32_t x, uint32_t y, uint32_t width, uint32_t height)
{
    return (exr_attr_box2i_t){.min = {.x = (int32_t)x, .y = (int32_t)y},
                              .max = {.x = (int32_t)(x + width - 1), .y = (int32_t)(y + height - 1)}};
}

static exr_result_t write_windows(exr_context_t file, int part, const clast_image_window *window)
{
    exr_attr_box2i_t data = box_of(window->x, window->y, window->width, window->height);
    exr_attr_box2i_t display = box_of(0, 0, window->picture_width, window->picture_height);
    exr_result_t result = exr_set_data_window(file, part, &data);
    return result == EXR_ERR_SUCCESS ? exr_set_display_window(file, part, &display) : result;
}

static exr_result_t write_header(exr_writer *writer, const clast_image_window *window)
{
    exr_context_initializer_t settings = EXR_DEFAULT_CONTEXT_INITIALIZER;
    settings.error_handler_fn = keep_error;
    settings.user_data = writer;
    settings.write_fn = write_bytes;
    int part = 0;
    exr_result_t result = exr_start_write(&writer->file, writer->output->path, EXR_WRITE_FILE_DIRECTLY, &settings);
    if (result == EXR_ERR_SUCCESS) {
        result = exr_add_part(writer->file, NULL, EXR_STORAGE_SCANLINE, &part);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = exr_initialize_required_attr_simple(writer->file, part, (int32_t)window->width,
                                                     (int32_t)window->height, EXR_COMPRESSION_ZIP);
    }
    if (result == EXR_ERR_SUCCESS) {
        result = write_windows(writer->file, part, window);
    }
    for (size_t i = 0; result == EXR_ERR_SUCCESS && i < writer->channel_count; i++) {
        if (strlen(writer->channels[i].name) > 31) {
            result = exr_set_longname_support(writer->file, 1);
        }
    }
    for (size_t i = 0; result == EXR_ERR_SUCCESS && i < writer->channel_count; i++) {
        result = exr_add_channel(writer->file, part, writer->channels[i].name,
                                 (exr_pixel_type_t)writer->channels[i].stored_type, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    }
    return result == EXR_ERR_SUCCESS ? exr_write_header(writer->file) : result;
}

static const exr_channel *find_channel(const exr_writer *writer, const char *name)
{
    for (size_t i = 0; i < writer->channel_count; i++) {
        if (strcmp(writer->channels[i].name, name) == 0) {
            return &writer->channels[i];
        }
    }
    return NULL;
}

// `y` counts from the window's first row.
static exr_result_t write_chunk(exr_writer *writer, exr_encode_pipeline_t *encoder, const clast_image_window *window,
                                uint32_t y)
{
    exr_chunk_info_t chunk;
    exr_result_t result = exr_write_scanline_chunk_info(writer->file, 0, (int)(window->y + y), &chunk);
    if (result == EXR_ERR_SUCCESS) {
        result = encoder->channels == NULL ? exr_encoding_initialize(writer->file, 0, &chunk, encoder)
                                           : exr_encoding_update(writer->file, 0, &chunk, encoder);
    }
    if (result != EXR_ERR_SUCCESS) {
        return result;
    }
    for (int i = 0; i < encoder->channel_count; i++) {
        exr_coding_channel_info_t *to = &encoder->channels[i];
        const exr_channel *from = find_channel(writer, to->channel_name);
        if (from == NULL) {
            return EXR_ERR_UNKNOWN;
        }
        to->user_data_type = from->type;
        to->user_bytes_per_element = 4;
        to->user_pixel_stride = from->stride;
        to->user_line_stride = from->stride * (int32_t)window->width;
        to->encode_from_ptr = from->pixels + (size_t)y * window->width * (size_t)from->stride;
    }
    result = exr_encoding_choose_default_routines(writer->file, 0, encoder);
    return result == EXR_ERR_SUCCESS ? exr_encoding_run(writer->file, 0, encoder) : result;
}

static exr_result_t write_chunks(exr_writer *writer, const clast_image_window *window)
{
    int32_t lines = 1;
    exr_result_t result = exr_get_scanlines_per_chunk(writer->file, 0, &lines);
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    for (uint32_t y = 0; result == EXR_ERR_SUCCESS && y < window->height; y += (uint32_t)lines) {
        result = write_chunk(writer, &encoder, window, y);
    }
    exr_encoding_destroy(writer->file, &encoder);
    return result;
}

void clast_exr_encode(clast_file_output *output, const clast_image_window *window, const clast_image_layer *layers,
                      size_t count)
{
    exr_writer writer = {.output = output};
    exr_result_t result = list_channels(&writer, layers, count) ? write_header(&writer, window) : EXR_ERR_OUT_OF_MEMORY;
    if (result == EXR_ERR_SUCCESS) {
        result = write_chunks(&writer, window);
    }
    if (writer.file != NULL) {
        exr_result_t finished = exr_finish(&writer.file); // writes the chunk table
        result = result == EXR_ERR_SUCCESS ? finished : result;
    }
    if (result == EXR_ERR_SUCCESS && !writer.memory_ran_out) {
        clast_file_write(output, writer.bytes, writer.size);
    } else {
        output->status = writer.memory_ran_out || result == EXR_ERR_OUT_OF_MEMORY ? CLAST_ERROR_OUT_OF_MEMORY
                                                                                  : CLAST_ERROR_INVALID_ARGUMENT;
        clast_fail(output->context, output->status, "%s: EXR: %s", output->path,
                   writer.error[0] != '\0' ? writer.error : exr_get_default_error_message(result));
    }
    clast_free(output->context, writer.bytes);
    clast_free(output->context, writer.channels);
}
