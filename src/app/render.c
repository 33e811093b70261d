// SPDX-License-Identifier: Apache-2.0
// clast render: a scene file in, a picture out.
#include <inttypes.h>

#include "app/output.h"
#include "app/print.h"
#include "app/session.h"
#include "app/report.h"
#include "base/thread.h"

// A render under way.
typedef struct clast_render_work {
    clast_session session;
    clast_output picture;
    clast_scene *scene;
    clast_renderer *renderer;
    clast_render_settings settings;
    clast_render_statistics statistics;
    double load_milliseconds;
    double write_milliseconds;
    bool was_cancelled;
} clast_render_work;

static clast_status load(clast_render_work *work)
{
    double begun = clast_clock();
    clast_status status = clast_session_load(&work->session, &work->scene, &work->settings);
    work->load_milliseconds = 1000.0 * (clast_clock() - begun);
    return status;
}

// A render that was stopped counts as done where each pixel has a sample at least.
static clast_status render(clast_render_work *work)
{
    clast_context *context = work->session.context;
    work->session.samples = work->settings.spp;
    clast_status status = clast_output_allocate(context, &work->picture, work->settings.width, work->settings.height);
    if (status == CLAST_OK) {
        status = clast_renderer_create(work->scene, &work->renderer);
    }
    if (status == CLAST_OK) {
        status = clast_render(work->renderer, &work->settings, work->picture.outputs, work->picture.output_count,
                              &work->statistics);
    }
    if (status == CLAST_ERROR_CANCELLED && work->statistics.samples > 0) {
        work->was_cancelled = true;
        status = CLAST_OK;
    }
    return status;
}

static json_t *milliseconds_object(const clast_render_work *work)
{
    const clast_session *session = &work->session;
    return json_pack("{s:f, s:f, s:o, s:f, s:f, s:f, s:f}", "load", work->load_milliseconds, "cook",
                     work->statistics.cook_milliseconds, "passes", clast_report_passes(&work->statistics), "render",
                     work->statistics.total_milliseconds, "write", work->write_milliseconds, "first_picture",
                     1000.0 * session->first_picture, "total", 1000.0 * clast_session_seconds(session));
}

static json_t *results_object(const clast_render_work *work)
{
    char hash[20];
    snprintf(hash, sizeof hash, "%016" PRIx64, work->picture.hash);
    json_t *object = json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:b, s:i, s:o, s:I, s:I, s:f, s:s}", "verb", "render", "clast",
        clast_report_program(&work->session), "input", clast_report_text(work->session.command->positionals[0]),
        "output", clast_report_text(work->picture.path), "settings", clast_report_settings(&work->settings),
        "cancelled", work->was_cancelled, "samples", (int)work->statistics.samples, "milliseconds",
        milliseconds_object(work), "rays", (json_int_t)work->statistics.rays, "primary_rays",
        (json_int_t)work->statistics.primary_rays, "mrays_per_second", clast_mega_rays_per_second(&work->statistics),
        "image_hash", hash);
    if (object != NULL && clast_report_add_counts(object, &work->statistics) != 0) {
        json_decref(object);
        return NULL;
    }
    return object;
}

static void print_summary(const clast_render_work *work)
{
    char triangles[32];
    char memory[32];
    printf("%s: %u x %u pixels, %u samples a pixel, %s triangles, %.2f s, %.2f million rays a second, %s at most\n",
           work->picture.path, work->picture.width, work->picture.height, work->statistics.samples,
           clast_format_count(work->statistics.instanced_triangles, triangles), clast_session_seconds(&work->session),
           clast_mega_rays_per_second(&work->statistics),
           clast_format_bytes(work->statistics.process_memory_peak, memory));
}

static clast_exit finish(clast_render_work *work)
{
    clast_session *session = &work->session;
    double begun = clast_clock();
    clast_status status = clast_output_write(session->context, &work->picture, &work->settings);
    work->write_milliseconds = 1000.0 * (clast_clock() - begun);
    if (status != CLAST_OK) {
        return clast_session_fail(session, status);
    }
    clast_session_clear_line(session);
    if (clast_session_prints(session)) {
        print_summary(work);
    }
    if (session->command->json != NULL && !clast_session_write_json(session, results_object(work))) {
        return CLAST_EXIT_FAILURE;
    }
    if (work->was_cancelled) {
        clast_print_error("stopped by an interrupt: %s has %u of %u samples a pixel", work->picture.path,
                          work->statistics.samples, work->settings.spp);
        return CLAST_EXIT_CANCELLED;
    }
    return CLAST_EXIT_SUCCESS;
}

static clast_exit work_through(clast_render_work *work)
{
    clast_exit planned = clast_output_plan(&work->session, &work->picture);
    if (planned != CLAST_EXIT_SUCCESS) {
        return planned;
    }
    clast_status status = load(work);
    if (status == CLAST_OK) {
        status = render(work);
    }
    return status == CLAST_OK ? finish(work) : clast_session_fail(&work->session, status);
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
    clast_session_end(&work.session);
    return code;
}
