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

// What was found of two images.
typedef struct comparison {
    clast_image images[2];
    clast_image_difference difference;
    double flip;   // the mean
    float *errors; // FLIP of each pixel; null where no picture of them is wanted
} comparison;

// Without bounds, only equal images agree. A value that is not finite agrees with none.
static bool images_agree(const clast_command *command, const comparison *found)
{
    const clast_image_difference *difference = &found->difference;
    if (!command->given.max_mse_ && !command->given.max_difference_ && !command->given.max_flip_) {
        return difference->maximum == 0.0;
    }
    bool mse_is_good = !command->given.max_mse_ || difference->mean_squared_error <= command->max_mse;
    bool maximum_is_good = !command->given.max_difference_ || difference->maximum <= command->max_difference;
    bool flip_is_good = !command->given.max_flip_ || found->flip <= command->max_flip;
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

static json_t *results_object(const clast_session *session, const comparison *found, bool agree)
{
    const clast_command *command = session->command;
    const clast_image_difference *difference = &found->difference;
    return json_pack("{s:s, s:o, s:o, s:o, s:b, s:o, s:o, s:o, s:o, s:[I, I], s:I}", "verb", "compare", "clast",
                     clast_report_program(session), "a", clast_report_text(command->positionals[0]), "b",
                     clast_report_text(command->positionals[1]), "agree", agree, "mse",
                     number_or_null(difference->mean_squared_error), "psnr",
                     number_or_null(peak_signal_to_noise(difference->mean_squared_error)), "flip",
                     number_or_null(found->flip), "maximum", number_or_null(difference->maximum), "maximum_at",
                     (json_int_t)difference->maximum_x, (json_int_t)difference->maximum_y, "differing_pixels",
                     (json_int_t)difference->differing_pixels);
}

static void print_results(const comparison *found, bool agree)
{
    const clast_image_difference *difference = &found->difference;
    printf("MSE %.9g, PSNR %.2f dB, FLIP %.6f, maximum %.9g", difference->mean_squared_error,
           peak_signal_to_noise(difference->mean_squared_error), found->flip, difference->maximum);
    if (difference->differing_pixels != 0) {
        printf(" at %u,%u, %" PRIu64 " pixels differ", difference->maximum_x, difference->maximum_y,
               difference->differing_pixels);
    }
    printf(": the images %s\n", agree ? "agree" : "differ");
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

static clast_status read_images(clast_session *session, comparison *found)
{
    clast_context *context = session->context;
    const char *const *paths = session->command->positionals;
    clast_image *images = found->images;
    clast_status status = clast_image_read(context, paths[0], &images[0]);
    if (status == CLAST_OK) {
        status = clast_image_read(context, paths[1], &images[1]);
    }
    if (status == CLAST_OK && (images[0].width != images[1].width || images[0].height != images[1].height)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s has %u x %u pixels, %s has %u x %u: expected equal sizes", paths[0], images[0].width,
                          images[0].height, paths[1], images[1].width, images[1].height);
    }
    return status;
}

static clast_status compare(clast_session *session, comparison *found)
{
    clast_context *context = session->context;
    const clast_command *command = session->command;
    clast_status status = read_images(session, found);
    if (status == CLAST_OK) {
        status = clast_image_compare(context, &found->images[0], &found->images[1], &found->difference);
    }
    size_t pixels = (size_t)found->images[0].width * found->images[0].height;
    if (status == CLAST_OK && command->positionals[2] != NULL) {
        found->errors = clast_allocate(context, pixels, sizeof *found->errors);
        status = found->errors != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status == CLAST_OK) {
        status = clast_image_flip(context, &found->images[0], &found->images[1], command->pixels_per_degree,
                                  found->errors, &found->flip);
    }
    if (status == CLAST_OK && command->positionals[2] != NULL) {
        status = write_errors(session, found);
    }
    return status;
}

clast_exit clast_run_compare(const clast_command *command)
{
    clast_session session;
    if (!clast_session_begin(&session, command)) {
        return CLAST_EXIT_USAGE;
    }
    comparison found = {.flip = 0.0};
    clast_exit code = CLAST_EXIT_SUCCESS;
    clast_status status = compare(&session, &found);
    if (status != CLAST_OK) {
        code = clast_session_fail(&session, status);
        code = code == CLAST_EXIT_FAILURE ? CLAST_EXIT_USAGE : code; // 1 says that the images differ, and they may not
    } else {
        bool agree = images_agree(command, &found);
        code = agree ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
        if (clast_session_prints(&session)) {
            print_results(&found, agree);
        }
        if (command->json != NULL && !clast_session_write_json(&session, results_object(&session, &found, agree))) {
            code = CLAST_EXIT_USAGE;
        }
    }
    clast_free(session.context, found.errors);
    clast_image_free(session.context, &found.images[0]);
    clast_image_free(session.context, &found.images[1]);
    clast_session_end(&session);
    return code;
}
