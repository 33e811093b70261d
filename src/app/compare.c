// SPDX-License-Identifier: Apache-2.0
// clast compare: how two images differ, and whether that is within bounds.
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "app/print.h"
#include "app/session.h"
#include "app/report.h"
#include "base/file.h"
#include "clast/image.h"
#include "shared/tone_map.h"

// What was found of two images, or of a layer of theirs.
typedef struct comparison {
    char *layer;     // null for the picture
    bool is_missing; // in one of the files
    bool agrees;
    clast_image images[2];
    clast_image_difference difference;
    double flip;   // the mean; not a number for a layer
    float *errors; // FLIP of each pixel; null where no picture of them is wanted
} comparison;

// All layers.
typedef struct comparisons {
    clast_session *session;
    comparison *found;
    size_t count, capacity;
    clast_status status;
} comparisons;

// Without bounds, only equal images agree. A value that is not finite agrees with none.
static bool images_agree(const clast_command *command, const comparison *found)
{
    const clast_image_difference *difference = &found->difference;
    if (found->is_missing) {
        return false;
    }
    if (!command->given.max_mse_ && !command->given.max_difference_ && !command->given.max_flip_) {
        return difference->maximum == 0.0;
    }
    bool mse_is_good = !command->given.max_mse_ || difference->mean_squared_error <= command->max_mse;
    bool maximum_is_good = !command->given.max_difference_ || difference->maximum <= command->max_difference;
    bool flip_is_good = !command->given.max_flip_ || found->layer != NULL || found->flip <= command->max_flip;
    return mse_is_good && maximum_is_good && flip_is_good;
}

// Decibels for a peak of 1; infinite for equal images.
static double peak_signal_to_noise(double mean_squared_error)
{
    return mean_squared_error > 0.0 ? -10.0 * log10(mean_squared_error) : (double)INFINITY;
}

// JSON has no infinity: null stands for it.
static json_t *number_or_null(double number)
{
    return isfinite(number) ? json_real(number) : json_null();
}

static json_t *difference_object(const comparison *found)
{
    const clast_image_difference *difference = &found->difference;
    return json_pack("{s:b, s:o, s:o, s:o, s:o, s:[I, I], s:I}", "agree", found->agrees, "mse",
                     number_or_null(difference->mean_squared_error), "psnr",
                     number_or_null(peak_signal_to_noise(difference->mean_squared_error)), "flip",
                     number_or_null(found->flip), "maximum", number_or_null(difference->maximum), "maximum_at",
                     (json_int_t)difference->maximum_x, (json_int_t)difference->maximum_y, "differing_pixels",
                     (json_int_t)difference->differing_pixels);
}

static json_t *layers_array(const comparisons *all)
{
    json_t *array = json_array();
    for (size_t i = 0; i < all->count; i++) {
        const comparison *found = &all->found[i];
        json_t *object = found->is_missing ? json_pack("{s:b, s:b}", "agree", 0, "missing", 1)
                                           : difference_object(found);
        json_object_set_new(object, "layer", clast_report_text(found->layer != NULL ? found->layer : ""));
        json_array_append_new(array, object);
    }
    return array;
}

// One comparison's numbers stand at the top; those of several layers in a list of their own.
static json_t *results_object(const clast_session *session, const comparisons *all, bool agree)
{
    const clast_command *command = session->command;
    json_t *object = json_pack("{s:s, s:o, s:o, s:o}", "verb", "compare", "clast", clast_report_program(session), "a",
                               clast_report_text(command->positionals[0]), "b",
                               clast_report_text(command->positionals[1]));
    json_t *numbers = all->count == 1 && !all->found[0].is_missing
                          ? difference_object(&all->found[0])
                          : json_pack("{s:b, s:o}", "agree", agree, "layers", layers_array(all));
    json_object_update(object, numbers);
    json_decref(numbers);
    return object;
}

static void print_comparison(const comparison *found)
{
    const clast_image_difference *difference = &found->difference;
    if (found->layer != NULL) {
        printf("%s: ", found->layer);
    }
    if (found->is_missing) {
        printf("only one of the files has this layer\n");
        return;
    }
    printf("MSE %.9g, PSNR %.2f dB, ", difference->mean_squared_error,
           peak_signal_to_noise(difference->mean_squared_error));
    if (!isnan(found->flip)) {
        printf("FLIP %.6f, ", found->flip);
    }
    printf("maximum %.9g", difference->maximum);
    if (difference->differing_pixels != 0) {
        printf(" at %u,%u, %" PRIu64 " pixels differ", difference->maximum_x, difference->maximum_y,
               difference->differing_pixels);
    }
    printf(": the %s %s\n", found->layer != NULL ? "layers" : "images", found->agrees ? "agree" : "differ");
}

// ------------------------------------------------------------------------------------------------- the picture of errors

static bool holds_floats(const char *path)
{
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    return strcmp(extension, "pfm") == 0 || strcmp(extension, "exr") == 0;
}

// Errors themselves where the format can hold them, else in false colours: from black by violet and orange to pale yellow.
static clast_status write_errors(clast_session *session, const comparison *found)
{
    const char *path = session->command->positionals[2];
    clast_image image = {found->images[0].width, found->images[0].height, 1, CLAST_PIXEL_FLOAT, found->errors};
    if (holds_floats(path)) {
        return clast_image_write(session->context, path, &image);
    }
    size_t pixels = (size_t)image.width * image.height;
    uint8_t *colours = clast_allocate(session->context, pixels, 3);
    if (colours == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < pixels; i++) {
        vec3 colour = ember_colour(found->errors[i]);
        for (int c = 0; c < 3; c++) {
            colours[3 * i + (size_t)c] = (uint8_t)(colour[c] * 255.0f + 0.5f);
        }
    }
    image.channels = 3;
    image.type = CLAST_PIXEL_UNORM8;
    image.pixels = colours;
    clast_status status = clast_image_write(session->context, path, &image);
    clast_free(session->context, colours);
    return status;
}

// ----------------------------------------------------------------------------------------------------------- the verb

static clast_status read_image(clast_session *session, const comparison *found, int which, clast_image *image)
{
    const char *path = session->command->positionals[which];
    return found->layer != NULL ? clast_image_read_layer(session->context, path, found->layer, image)
                                : clast_image_read(session->context, path, image);
}

static clast_status read_images(clast_session *session, comparison *found)
{
    const char *const *paths = session->command->positionals;
    clast_image *images = found->images;
    clast_status status = read_image(session, found, 0, &images[0]);
    if (status == CLAST_OK) {
        status = read_image(session, found, 1, &images[1]);
    }
    if (status == CLAST_OK && (images[0].width != images[1].width || images[0].height != images[1].height)) {
        return clast_fail(session->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s has %u x %u pixels, %s has %u x %u: expected equal sizes", paths[0], images[0].width,
                          images[0].height, paths[1], images[1].width, images[1].height);
    }
    return status;
}

static clast_status measure_flip(clast_session *session, comparison *found)
{
    clast_context *context = session->context;
    const clast_command *command = session->command;
    if (command->positionals[2] != NULL) {
        size_t pixels = (size_t)found->images[0].width * found->images[0].height;
        found->errors = clast_allocate(context, pixels, sizeof *found->errors);
        if (found->errors == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    clast_status status = clast_image_flip(context, &found->images[0], &found->images[1], command->pixels_per_degree,
                                           found->errors, &found->flip);
    return status == CLAST_OK && found->errors != NULL ? write_errors(session, found) : status;
}

static clast_status compare(clast_session *session, comparison *found)
{
    clast_status status = read_images(session, found);
    if (status == CLAST_OK) {
        status = clast_image_compare(session->context, &found->images[0], &found->images[1], &found->difference);
    }
    if (status == CLAST_OK && found->layer == NULL) {
        status = measure_flip(session, found);
    }
    found->agrees = status == CLAST_OK && images_agree(session->command, found);
    for (int i = 0; i < 2; i++) { // of many layers, one is held at a time
        clast_image_free(session->context, &found->images[i]);
    }
    return status;
}

// Adds a layer; the empty name is the picture.
static comparison *add_layer(comparisons *all, const char *layer)
{
    clast_context *context = all->session->context;
    char *copy = layer[0] != '\0' ? clast_copy_text(context, layer) : NULL;
    clast_status status = copy == NULL && layer[0] != '\0' ? CLAST_ERROR_OUT_OF_MEMORY : CLAST_OK;
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, all->found, all->capacity, all->count + 1);
    }
    if (status != CLAST_OK) {
        clast_free(context, copy);
        all->status = status;
        return NULL;
    }
    comparison *found = &all->found[all->count++];
    *found = (comparison){.layer = copy, .flip = (double)NAN};
    return found;
}

static comparison *find_layer(const comparisons *all, const char *layer)
{
    for (size_t i = 0; i < all->count; i++) {
        if (strcmp(all->found[i].layer != NULL ? all->found[i].layer : "", layer) == 0) {
            return &all->found[i];
        }
    }
    return NULL;
}

// Layers count as missing until the second file is seen to have them.
static void take_first(void *user, const char *layer)
{
    comparison *found = add_layer(user, layer);
    if (found != NULL) {
        found->is_missing = true;
    }
}

static void take_second(void *user, const char *layer)
{
    comparison *found = find_layer(user, layer);
    if (found != NULL) {
        found->is_missing = false;
    } else {
        take_first(user, layer);
    }
}

static clast_status list_layers(comparisons *all)
{
    const clast_command *command = all->session->command;
    if (command->layer == NULL || strcmp(command->layer, "all") != 0) {
        add_layer(all, command->layer != NULL ? command->layer : "");
        return all->status;
    }
    clast_context *context = all->session->context;
    clast_status status = clast_image_list_layers(context, command->positionals[0], take_first, all);
    if (status == CLAST_OK) {
        status = clast_image_list_layers(context, command->positionals[1], take_second, all);
    }
    return status == CLAST_OK ? all->status : status;
}

static clast_status compare_all(comparisons *all, bool *agree)
{
    clast_status status = list_layers(all);
    *agree = true;
    for (size_t i = 0; i < all->count && status == CLAST_OK; i++) {
        if (!all->found[i].is_missing) {
            status = compare(all->session, &all->found[i]);
        }
        *agree = *agree && all->found[i].agrees;
    }
    return status;
}

static void free_comparisons(comparisons *all)
{
    clast_context *context = all->session->context;
    for (size_t i = 0; i < all->count; i++) {
        clast_free(context, all->found[i].errors);
        clast_free(context, all->found[i].layer);
    }
    clast_free(context, all->found);
}

clast_exit clast_run_compare(const clast_command *command)
{
    clast_session session;
    if (!clast_session_begin(&session, command)) {
        return CLAST_EXIT_USAGE;
    }
    comparisons all = {.session = &session};
    bool agree = false;
    clast_exit code = CLAST_EXIT_SUCCESS;
    clast_status status = compare_all(&all, &agree);
    if (status != CLAST_OK) {
        code = clast_session_fail(&session, status);
        code = code == CLAST_EXIT_FAILURE ? CLAST_EXIT_USAGE : code; // 1 says that the images differ, and they may not
    } else {
        code = agree ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
        for (size_t i = 0; i < all.count && clast_session_prints(&session); i++) {
            print_comparison(&all.found[i]);
        }
        if (command->json != NULL && !clast_session_write_json(&session, results_object(&session, &all, agree))) {
            code = CLAST_EXIT_USAGE;
        }
    }
    free_comparisons(&all);
    clast_session_end(&session);
    return code;
}
