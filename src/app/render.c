// SPDX-License-Identifier: Apache-2.0
// clast render: a scene file in, a picture out.
#include <inttypes.h>

#include "app/output.h"
#include "app/print.h"
#include "app/session.h"
#include "app/report.h"
#include "base/thread.h"

// A render under way: of one picture, or of one frame after the other.
typedef struct clast_render_work {
    clast_session session;
    clast_output picture;
    clast_scene *scene;
    clast_renderer *renderer;
    clast_render_settings settings;
    clast_render_statistics statistics;
    double load_milliseconds;
    double write_milliseconds;
    double first_picture; // milliseconds until each pixel of the first picture had a sample
    bool was_cancelled;
    bool checkpoint_failed; // of which a warning told
    char *output;           // as the command line has it, where frames have names of their own
    json_t *frames;         // what --json tells of each
} clast_render_work;

static clast_status load(clast_render_work *work)
{
    double begun = clast_clock();
    clast_status status = clast_session_load(&work->session, &work->scene, &work->settings);
    work->load_milliseconds = 1000.0 * (clast_clock() - begun);
    return status;
}

static clast_status prepare(clast_render_work *work)
{
    clast_context *context = work->session.context;
    clast_render_area area;
    clast_status status = clast_render_settings_area(context, &work->settings, &area);
    if (status == CLAST_OK) {
        status = clast_output_allocate(context, &work->picture, &work->settings, &area);
    }
    return status == CLAST_OK ? clast_renderer_create(work->scene, &work->renderer) : status;
}

// Renders the picture and writes it. A render that was stopped counts as done where each pixel has a sample at least.
static clast_status make_picture(clast_render_work *work)
{
    double before = 1000.0 * clast_session_seconds(&work->session);
    const clast_command *command = work->session.command;
    clast_checkpoint checkpoint = {command->resume, command->checkpoint, command->checkpoint_interval};
    clast_status status = clast_render_with_checkpoint(work->renderer, &work->settings, &checkpoint,
                                                       work->picture.outputs, work->picture.output_count,
                                                       &work->statistics);
    if (work->first_picture == 0.0) {
        work->first_picture = before + work->statistics.first_sample_milliseconds;
    }
    if (status == CLAST_ERROR_CANCELLED && work->statistics.samples > 0) {
        work->was_cancelled = true;
        status = CLAST_OK;
    }
    if (status == CLAST_ERROR_FILE_WRITE && work->statistics.samples > 0) { // the checkpoint: the picture is not lost
        work->was_cancelled = clast_interrupted();
        work->checkpoint_failed = true;
        status = CLAST_OK;
    }
    double begun = clast_clock();
    if (status == CLAST_OK) {
        status = clast_output_write(work->session.context, &work->picture, &work->settings);
    }
    work->write_milliseconds = 1000.0 * (clast_clock() - begun);
    return status;
}

static json_t *milliseconds_object(const clast_render_work *work)
{
    const clast_session *session = &work->session;
    return json_pack("{s:f, s:f, s:o, s:f, s:f, s:f, s:f}", "load", work->load_milliseconds, "cook",
                     work->statistics.cook_milliseconds, "passes", clast_report_passes(&work->statistics), "render",
                     work->statistics.total_milliseconds, "write", work->write_milliseconds, "first_picture",
                     work->first_picture, "total", 1000.0 * clast_session_seconds(session));
}

// Adds what is known of the picture itself.
static json_t *add_picture(const clast_render_work *work, json_t *object)
{
    char hash[20];
    snprintf(hash, sizeof hash, "%016" PRIx64, work->picture.hash);
    json_t *picture = json_pack("{s:o, s:b, s:i, s:f, s:I, s:o, s:I, s:I, s:f, s:s}", "output",
                                clast_report_text(work->picture.path), "cancelled", work->was_cancelled, "samples",
                                (int)work->statistics.samples, "mean_samples", work->statistics.mean_samples,
                                "pixels_above_target", (json_int_t)work->statistics.pixels_above_target, "milliseconds",
                                milliseconds_object(work), "rays", (json_int_t)work->statistics.rays, "primary_rays",
                                (json_int_t)work->statistics.primary_rays, "mrays_per_second",
                                clast_mega_rays_per_second(&work->statistics), "image_hash", hash);
    if (object == NULL || picture == NULL || json_object_update(object, picture) != 0 ||
        clast_report_add_counts(object, &work->statistics) != 0) {
        json_decref(object);
        object = NULL;
    }
    json_decref(picture);
    return object;
}

static json_t *results_object(const clast_render_work *work)
{
    return json_pack("{s:s, s:o, s:o, s:o}", "verb", "render", "clast", clast_report_program(&work->session), "input",
                     clast_report_text(work->session.command->positionals[0]), "settings",
                     clast_report_settings(&work->settings));
}

static void print_summary(const clast_render_work *work)
{
    char triangles[32];
    char memory[32];
    printf("%s: %u x %u pixels, %u samples a pixel, %s triangles, %.2f s, %.2f million rays a second, %s at most",
           work->picture.path, work->picture.width, work->picture.height, work->statistics.samples,
           clast_format_count(work->statistics.instanced_triangles, triangles), clast_session_seconds(&work->session),
           clast_mega_rays_per_second(&work->statistics),
           clast_format_bytes(work->statistics.process_memory_peak, memory));
    if (work->statistics.driver[0] != '\0') {
        printf(", and %s on %s", clast_format_bytes(work->statistics.device_bytes_peak, memory),
               work->statistics.device);
    }
    putchar('\n');
}

static clast_exit end_code(const clast_render_work *work)
{
    if (work->checkpoint_failed) {
        clast_print_error("%s: the checkpoint could not be written; %s is written", work->session.command->checkpoint,
                          work->picture.path);
        return CLAST_EXIT_FAILURE;
    }
    if (!work->was_cancelled) {
        return CLAST_EXIT_SUCCESS;
    }
    clast_print_error("stopped by an interrupt: %s has %u of %u samples a pixel", work->picture.path,
                      work->statistics.samples, work->settings.spp);
    return CLAST_EXIT_CANCELLED;
}

static void tell(clast_render_work *work)
{
    clast_session_clear_line(&work->session);
    if (clast_session_prints(&work->session)) {
        print_summary(work);
    }
}

static clast_exit render_one(clast_render_work *work)
{
    clast_session *session = &work->session;
    clast_status status = make_picture(work);
    if (status != CLAST_OK) {
        return clast_session_fail(session, status);
    }
    tell(work);
    if (session->command->json != NULL && !clast_session_write_json(session, add_picture(work, results_object(work)))) {
        return CLAST_EXIT_FAILURE;
    }
    return end_code(work);
}

// --------------------------------------------------------------------------------------------------------- animations

static clast_status render_frame(clast_render_work *work, uint32_t frame)
{
    clast_session *session = &work->session;
    const clast_command *command = session->command;
    double time = (double)frame / command->fps;
    clast_free(session->context, work->picture.path);
    work->picture.path = clast_output_frame_path(session->context, work->output, frame);
    if (work->picture.path == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_session_settle(session, work->scene, time, &work->settings);
    if (status == CLAST_OK) {
        status = make_picture(work);
    }
    if (status != CLAST_OK) {
        return status;
    }
    tell(work);
    json_t *told = add_picture(work, json_pack("{s:I, s:f}", "frame", (json_int_t)frame, "time", time));
    if (command->json != NULL && json_array_append_new(work->frames, told) != 0) {
        return clast_fail(session->context, CLAST_ERROR_OUT_OF_MEMORY, "memory ran out");
    }
    if (command->json == NULL) {
        json_decref(told);
    }
    return CLAST_OK;
}

// Frames that are done stay, and are told of, where a later one fails.
static clast_exit render_frames(clast_render_work *work)
{
    clast_session *session = &work->session;
    const clast_range frames = session->command->frames;
    clast_status status = CLAST_OK;
    work->output = work->picture.path;
    work->picture.path = NULL;
    work->frames = json_array();
    session->frame_count = frames.last - frames.first + 1;
    for (uint32_t i = 0; i < session->frame_count && status == CLAST_OK && !work->was_cancelled; i++) {
        session->frame = i;
        status = render_frame(work, frames.first + i);
    }
    json_t *object = results_object(work);
    if (json_object_set(object, "frames", work->frames) != 0) {
        json_decref(object);
        object = NULL;
    }
    bool is_told = true;
    if (session->command->json != NULL) {
        is_told = clast_session_write_json(session, object);
    } else {
        json_decref(object);
    }
    if (status != CLAST_OK) {
        return clast_session_fail(session, status);
    }
    return is_told ? end_code(work) : CLAST_EXIT_FAILURE;
}

// Options that only make sense together, or not at all.
static bool check_options(const clast_command *command)
{
    if (command->given.frames_ && command->given.time) {
        clast_print_error("--frames says which moments are shown, and so does --time: expected one of them");
        return false;
    }
    if (command->given.fps_ && !command->given.frames_) {
        clast_print_error("--fps needs --frames");
        return false;
    }
    if (command->given.frames_ && (command->given.checkpoint_ || command->given.resume_)) {
        clast_print_error(
            "a checkpoint is of one picture: expected no --frames with it; frames that are written stay, and a render "
            "of the others goes on with --frames");
        return false;
    }
    if (command->given.checkpoint_interval_ && !command->given.checkpoint_) {
        clast_print_error("--checkpoint-interval needs --checkpoint");
        return false;
    }
    return true;
}

static clast_exit work_through(clast_render_work *work)
{
    clast_exit planned = check_options(work->session.command) ? clast_output_plan(&work->session, &work->picture)
                                                              : CLAST_EXIT_USAGE;
    if (planned != CLAST_EXIT_SUCCESS) {
        return planned;
    }
    clast_status status = load(work);
    if (status == CLAST_OK) {
        status = prepare(work);
    }
    if (status != CLAST_OK) {
        return clast_session_fail(&work->session, status);
    }
    return work->session.command->given.frames_ ? render_frames(work) : render_one(work);
}

clast_exit clast_run_render(const clast_command *command)
{
    clast_render_work work = {0};
    if (!clast_session_begin(&work.session, command)) {
        return CLAST_EXIT_FAILURE;
    }
    clast_exit code = work_through(&work);
    clast_renderer_destroy(work.renderer);
    clast_scene_destroy(work.scene);
    clast_output_free(work.session.context, &work.picture);
    clast_free(work.session.context, work.output);
    json_decref(work.frames);
    clast_session_end(&work.session);
    return code;
}
