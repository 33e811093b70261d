// SPDX-License-Identifier: Apache-2.0
// clast compare: how two images differ, and whether that is within bounds.
#include <inttypes.h>
#include <math.h>

#include "app/print.h"
#include "app/session.h"
#include "app/report.h"
#include "clast/image.h"

// Without bounds, only equal images agree. A value that is not finite agrees with none.
static bool images_agree(const clast_command *command, const clast_image_difference *difference)
{
    if (!command->given.max_mse_ && !command->given.max_difference_) {
        return difference->maximum == 0.0;
    }
    bool mse_is_good = !command->given.max_mse_ || difference->mean_squared_error <= command->max_mse;
    bool maximum_is_good = !command->given.max_difference_ || difference->maximum <= command->max_difference;
    return mse_is_good && maximum_is_good;
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

static json_t *results_object(const clast_session *session, const clast_image_difference *difference, bool agree)
{
    const clast_command *command = session->command;
    return json_pack("{s:s, s:o, s:o, s:o, s:b, s:o, s:o, s:o, s:[I, I], s:I}", "verb", "compare", "clast",
                     clast_report_program(session), "a", clast_report_text(command->positionals[0]), "b",
                     clast_report_text(command->positionals[1]), "agree", agree, "mse",
                     number_or_null(difference->mean_squared_error), "psnr",
                     number_or_null(peak_signal_to_noise(difference->mean_squared_error)), "maximum",
                     number_or_null(difference->maximum), "maximum_at", (json_int_t)difference->maximum_x,
                     (json_int_t)difference->maximum_y, "differing_pixels", (json_int_t)difference->differing_pixels);
}

static void print_results(const clast_image_difference *difference, bool agree)
{
    printf("MSE %.9g, PSNR %.2f dB, maximum %.9g", difference->mean_squared_error,
           peak_signal_to_noise(difference->mean_squared_error), difference->maximum);
    if (difference->differing_pixels != 0) {
        printf(" at %u,%u, %" PRIu64 " pixels differ", difference->maximum_x, difference->maximum_y,
               difference->differing_pixels);
    }
    printf(": the images %s\n", agree ? "agree" : "differ");
}

static clast_status read_and_compare(clast_session *session, clast_image images[2], clast_image_difference *difference)
{
    clast_context *context = session->context;
    const clast_command *command = session->command;
    clast_status status = clast_image_read(context, command->positionals[0], &images[0]);
    if (status == CLAST_OK) {
        status = clast_image_read(context, command->positionals[1], &images[1]);
    }
    if (status == CLAST_OK && (images[0].width != images[1].width || images[0].height != images[1].height)) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "%s has %u x %u pixels, %s has %u x %u: expected equal sizes", command->positionals[0],
                          images[0].width, images[0].height, command->positionals[1], images[1].width,
                          images[1].height);
    }
    return status == CLAST_OK ? clast_image_compare(context, &images[0], &images[1], difference) : status;
}

clast_exit clast_run_compare(const clast_command *command)
{
    clast_session session;
    if (!clast_session_begin(&session, command)) {
        return CLAST_EXIT_USAGE;
    }
    clast_image images[2] = {{0}, {0}};
    clast_image_difference difference = {0};
    clast_exit code = CLAST_EXIT_SUCCESS;
    clast_status status = read_and_compare(&session, images, &difference);
    if (status != CLAST_OK) {
        code = clast_session_fail(&session, status);
        code = code == CLAST_EXIT_FAILURE ? CLAST_EXIT_USAGE : code; // 1 says that the images differ, and they may not
    } else {
        bool agree = images_agree(command, &difference);
        code = agree ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
        if (clast_session_prints(&session)) {
            print_results(&difference, agree);
        }
        if (command->json != NULL &&
            !clast_session_write_json(&session, results_object(&session, &difference, agree))) {
            code = CLAST_EXIT_USAGE;
        }
    }
    clast_image_free(session.context, &images[0]);
    clast_image_free(session.context, &images[1]);
    clast_session_end(&session);
    return code;
}
