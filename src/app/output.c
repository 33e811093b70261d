// SPDX-License-Identifier: Apache-2.0
#include "app/output.h"

#include <string.h>
#include <xxhash.h>

#include "app/print.h"
#include "base/file.h"
#include "base/size.h"

// A view as the list has it, and the layer that it becomes in an EXR file: the names that compositors know.
typedef struct view_info {
    const char *name;
    uint32_t channels;
    bool is_float;
    const char *layer;
    const char *channel_names;
} view_info;

static const char *const layer_names[CLAST_VIEW_COUNT_][2] = {
    [CLAST_VIEW_COLOUR] = {"", "RGB"},
    [CLAST_VIEW_ALBEDO] = {"albedo", "RGB"},
    [CLAST_VIEW_NORMAL] = {"N", "XYZ"},
    [CLAST_VIEW_DEPTH] = {"", "Z"},
    [CLAST_VIEW_UV] = {"uv", "UV"},
    [CLAST_VIEW_INSTANCE] = {"instance", "X"},
    [CLAST_VIEW_CLUSTER] = {"cluster", "X"},
    [CLAST_VIEW_TRIANGLE] = {"triangle", "X"},
    [CLAST_VIEW_STEPS] = {"steps", "X"},
    [CLAST_VIEW_PRIMITIVE] = {"primitive", "X"},
    [CLAST_VIEW_SEGMENTS] = {"segments", "X"},
    [CLAST_VIEW_RATE] = {"rate", "X"},
    [CLAST_VIEW_AREA] = {"area", "X"},
    [CLAST_VIEW_SAMPLES] = {"samples", "X"},
};

static view_info view_about(clast_view view)
{
    static const view_info views[] = {
#define VIEW_ROW(name, value, text, channels, is_float, help) {text, channels, is_float, NULL, NULL},
        CLAST_VIEW_LIST(VIEW_ROW)};
    view_info info = views[view];
    info.layer = layer_names[view][0];
    info.channel_names = layer_names[view][1];
    return info;
}

static bool find_format(const char *path, clast_output_format *format)
{
    static const struct {
        const char *extension;
        clast_output_format format;
    } formats[] = {{"png", CLAST_OUTPUT_PNG}, {"exr", CLAST_OUTPUT_EXR},  {"pfm", CLAST_OUTPUT_PFM},
                   {"hdr", CLAST_OUTPUT_HDR}, {"jpg", CLAST_OUTPUT_JPEG}, {"jpeg", CLAST_OUTPUT_JPEG}};
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++) {
        if (strcmp(extension, formats[i].extension) == 0) {
            *format = formats[i].format;
            return true;
        }
    }
    return false;
}

// The bits of a channel that are asked for, or the format's usual ones; 0 where it has no such channels.
static uint32_t bits_of(clast_output_format format, uint32_t wanted)
{
    uint32_t least = format == CLAST_OUTPUT_EXR ? 16 : format == CLAST_OUTPUT_PNG ? 8 : 0;
    if (least == 0) {
        return wanted == CLAST_BITS_AUTOMATIC ? 8 : 0;
    }
    uint32_t usual = format == CLAST_OUTPUT_EXR ? 32 : 8, bits = wanted == CLAST_BITS_AUTOMATIC ? usual : wanted;
    return bits == least || bits == 2 * least ? bits : 0;
}

// The input's name without folder and extension, with .png.
static char *default_path(clast_context *context, const char *input)
{
    const char *slash = strrchr(input, '/');
    const char *name = slash != NULL ? slash + 1 : input;
    const char *dot = strrchr(name, '.');
    size_t length = dot != NULL && dot != name ? (size_t)(dot - name) : strlen(name);
    char *path = clast_allocate(context, length + sizeof ".png", 1);
    if (path != NULL) {
        memcpy(path, name, length);
        memcpy(path + length, ".png", sizeof ".png");
    }
    return path;
}

clast_exit clast_output_plan(clast_session *session, clast_output *picture)
{
    const clast_command *command = session->command;
    clast_context *context = session->context;
    *picture = (clast_output){0};
    picture->path = command->positionals[1] != NULL ? clast_copy_text(context, command->positionals[1])
                                                    : default_path(context, command->positionals[0]);
    if (picture->path == NULL) {
        return clast_session_fail(session, CLAST_ERROR_OUT_OF_MEMORY);
    }
    if (!find_format(picture->path, &picture->format)) {
        clast_print_error("%s: expected an output that ends in .png, .jpg, .exr, .pfm or .hdr", picture->path);
        return CLAST_EXIT_USAGE;
    }
    picture->bits = bits_of(picture->format, command->bits);
    if (picture->bits == 0) {
        clast_print_error("--bits: .png has 8 or 16, .exr 16 or 32, others no choice");
        return CLAST_EXIT_USAGE;
    }
    clast_view view = (clast_view)command->view;
    bool is_linear = picture->format == CLAST_OUTPUT_PFM || picture->format == CLAST_OUTPUT_HDR;
    if (is_linear && !view_about(view).is_float) {
        clast_print_error("--view %s: whole numbers can be written as .png or .exr only", view_about(view).name);
        return CLAST_EXIT_USAGE;
    }
    if (!clast_can_write(picture->path)) {
        clast_print_error("%s: a file cannot be written there", picture->path);
        return CLAST_EXIT_FAILURE;
    }
    if (command->checkpoint != NULL && !clast_can_write(command->checkpoint)) {
        clast_print_error("%s: a file cannot be written there", command->checkpoint);
        return CLAST_EXIT_FAILURE;
    }
    if (command->json != NULL && strcmp(command->json, "-") != 0 && !clast_can_write(command->json)) {
        clast_print_error("%s: a file cannot be written there", command->json);
        return CLAST_EXIT_FAILURE;
    }
    if (picture->format == CLAST_OUTPUT_EXR && !command->given.view_) {
        for (uint32_t i = 0; i < CLAST_VIEW_COUNT_; i++) {
            picture->outputs[picture->output_count++].view = (clast_view)i;
        }
    } else {
        picture->outputs[picture->output_count++].view = view;
    }
    return CLAST_EXIT_SUCCESS;
}

// Where a path has %d or %0Nd, N of one digit: gives its length and how many digits are wanted. Null where there is none.
static const char *find_pattern(const char *path, size_t *length, int *digits)
{
    for (const char *at = strchr(path, '%'); at != NULL; at = strchr(at + 1, '%')) {
        if (at[1] == 'd') {
            *length = 2;
            *digits = 1;
            return at;
        }
        if (at[1] == '0' && at[2] >= '1' && at[2] <= '9' && at[3] == 'd') {
            *length = 4;
            *digits = at[2] - '0';
            return at;
        }
    }
    return NULL;
}

char *clast_output_frame_path(clast_context *context, const char *path, uint32_t frame)
{
    size_t length = 0, size = strlen(path) + 16;
    int digits = 4;
    const char *at = find_pattern(path, &length, &digits);
    const char *point = "";
    if (at == NULL) {
        at = strrchr(path, '.'); // there is one: the extension says what is written
        point = ".";
    }
    char *result = clast_allocate(context, size, 1);
    if (result != NULL) {
        snprintf(result, size, "%.*s%s%0*u%s", (int)(at - path), path, point, digits, frame, at + length);
    }
    return result;
}

clast_status clast_output_allocate(clast_context *context, clast_output *picture, const clast_render_settings *settings,
                                   const clast_render_area *area)
{
    picture->width = settings->width;
    picture->height = settings->height;
    picture->area = *area;
    size_t pixels = 0;
    if (!clast_multiply_size(area->width, area->height, &pixels)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "a picture of %u x %u pixels is too large for this machine",
                          area->width, area->height);
    }
    for (size_t i = 0; i < picture->output_count; i++) {
        uint32_t channels = view_about(picture->outputs[i].view).channels;
        picture->outputs[i].pixels = clast_allocate_zeroed(context, pixels, channels * sizeof(float));
        if (picture->outputs[i].pixels == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    return CLAST_OK;
}

static clast_status write_display(clast_context *context, clast_output *picture, const clast_render_settings *settings)
{
    size_t pixels = (size_t)picture->area.width * picture->area.height, size = 3 * (size_t)picture->bits / 8;
    void *values = clast_allocate(context, pixels, size);
    if (values == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    const clast_render_output *output = &picture->outputs[0];
    clast_image image = {picture->area.width, picture->area.height, 3, CLAST_PIXEL_UNORM8, values};
    clast_status status;
    if (picture->bits == 16) {
        image.type = CLAST_PIXEL_UNORM16;
        status = clast_view_to_display_16(context, output->view, output->pixels, picture->area.width,
                                          picture->area.height, settings, values);
    } else {
        status = clast_view_to_display(context, output->view, output->pixels, picture->area.width, picture->area.height,
                                       settings, values);
    }
    if (status == CLAST_OK) {
        status = clast_image_write(context, picture->path, &image);
        picture->hash = XXH3_64bits(values, pixels * size);
    }
    clast_free(context, values);
    return status;
}

// Distances and positions in a texture need all bits; colours and unit vectors can do with half of them.
static bool can_be_half(clast_view view)
{
    return view == CLAST_VIEW_COLOUR || view == CLAST_VIEW_ALBEDO || view == CLAST_VIEW_NORMAL;
}

static clast_status write_layers(clast_context *context, clast_output *picture)
{
    clast_image_layer layers[CLAST_VIEW_COUNT_];
    size_t pixels = (size_t)picture->area.width * picture->area.height;
    picture->hash = 0;
    for (size_t i = 0; i < picture->output_count; i++) {
        view_info info = view_about(picture->outputs[i].view);
        layers[i] = (clast_image_layer){.name = info.layer,
                                        .channels = info.channel_names,
                                        .is_integer = !info.is_float,
                                        .is_half = picture->bits == 16 && can_be_half(picture->outputs[i].view),
                                        .pixels = picture->outputs[i].pixels};
        picture->hash = XXH3_64bits_withSeed(picture->outputs[i].pixels, pixels * info.channels * sizeof(float),
                                             picture->hash);
    }
    clast_image_window window = {picture->area.x,      picture->area.y, picture->area.width,
                                 picture->area.height, picture->width,  picture->height};
    return clast_image_write_window(context, picture->path, &window, layers, picture->output_count);
}

// Linear formats have one or three channels: two (texture coordinates) get a third of zeros, and HDR repeats a single one.
static clast_status write_linear(clast_context *context, clast_output *picture)
{
    view_info info = view_about(picture->outputs[0].view);
    const float *values = picture->outputs[0].pixels;
    size_t pixels = (size_t)picture->area.width * picture->area.height;
    uint32_t channels = info.channels == 1 && picture->format == CLAST_OUTPUT_PFM ? 1 : 3;
    float *padded = NULL;
    picture->hash = XXH3_64bits(values, pixels * info.channels * sizeof(float));
    if (channels != info.channels) {
        padded = clast_allocate(context, pixels, 3 * sizeof(float));
        if (padded == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
        for (size_t i = 0; i < pixels; i++) {
            const float *from = values + i * info.channels;
            padded[3 * i] = from[0];
            padded[3 * i + 1] = info.channels == 2 ? from[1] : from[0];
            padded[3 * i + 2] = info.channels == 2 ? 0.0f : from[0];
        }
        values = padded;
    }
    clast_image image = {picture->area.width, picture->area.height, channels, CLAST_PIXEL_FLOAT, values};
    clast_status status = clast_image_write(context, picture->path, &image);
    clast_free(context, padded);
    return status;
}

clast_status clast_output_write(clast_context *context, clast_output *picture, const clast_render_settings *settings)
{
    switch (picture->format) {
    case CLAST_OUTPUT_PNG:
    case CLAST_OUTPUT_JPEG: return write_display(context, picture, settings);
    case CLAST_OUTPUT_EXR: return write_layers(context, picture);
    case CLAST_OUTPUT_PFM:
    case CLAST_OUTPUT_HDR: return write_linear(context, picture);
    }
    return CLAST_ERROR_INVALID_ARGUMENT;
}

void clast_output_free(clast_context *context, clast_output *picture)
{
    for (size_t i = 0; i < picture->output_count; i++) {
        clast_free(context, picture->outputs[i].pixels);
    }
    clast_free(context, picture->path);
    *picture = (clast_output){0};
}
