// SPDX-License-Identifier: Apache-2.0
// clast export: a scene file in, the triangles of a frame out.
#include "clast/export.h"

#include <string.h>

#include "app/print.h"
#include "app/report.h"
#include "app/session.h"
#include "base/file.h"

typedef struct clast_export_work {
    clast_session session;
    clast_scene *scene;
    clast_renderer *renderer;
    clast_render_settings settings;
    clast_export_statistics written;
    clast_render_statistics statistics;
} clast_export_work;

static clast_status work_through(clast_export_work *work)
{
    const clast_command *command = work->session.command;
    clast_status status = clast_session_load(&work->session, &work->scene, &work->settings);
    if (status == CLAST_OK) {
        status = clast_renderer_create(work->scene, &work->renderer);
    }
    clast_export_desc desc = {.welded = command->weld};
    if (command->given.instance_) {
        desc.instances = &command->instance;
        desc.instance_count = 1;
    }
    if (status == CLAST_OK) {
        status = clast_export(work->renderer, &work->settings, &desc, command->positionals[1], &work->written);
    }
    return status == CLAST_OK ? clast_renderer_statistics(work->renderer, &work->statistics) : status;
}

static json_t *results_object(const clast_export_work *work)
{
    const clast_command *command = work->session.command;
    const clast_export_statistics *written = &work->written;
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:{s:i, s:i, s:I, s:I, s:I}, s:f, s:f}", "verb", "export", "clast",
                     clast_report_program(&work->session), "input", clast_report_text(command->positionals[0]),
                     "output", clast_report_text(command->positionals[1]), "settings",
                     clast_report_settings(&work->settings), "written", "meshes", (int)written->meshes, "instances",
                     (int)written->instances, "vertices", (json_int_t)written->vertices, "triangles",
                     (json_int_t)written->triangles, "instanced_triangles", (json_int_t)written->instanced_triangles,
                     "rate", work->statistics.rate, "milliseconds", 1000.0 * clast_session_seconds(&work->session));
}

static void print_summary(const clast_export_work *work)
{
    char vertices[32];
    char triangles[32];
    printf("%s: %u meshes, %u instances, %s vertices, %s triangles, %.2f s\n", work->session.command->positionals[1],
           work->written.meshes, work->written.instances, clast_format_count(work->written.vertices, vertices),
           clast_format_count(work->written.triangles, triangles), clast_session_seconds(&work->session));
}

static bool output_is_possible(const clast_command *command)
{
    char extension[8];
    clast_path_extension(command->positionals[1], extension, sizeof extension);
    if (strcmp(extension, "gltf") != 0 && strcmp(extension, "glb") != 0 && strcmp(extension, "ply") != 0) {
        clast_print_error("%s: expected an output that ends in .gltf, .glb or .ply", command->positionals[1]);
        return false;
    }
    return true;
}

static clast_exit finish(clast_export_work *work)
{
    clast_session_clear_line(&work->session);
    if (clast_session_prints(&work->session)) {
        print_summary(work);
    }
    bool good = work->session.command->json == NULL || clast_session_write_json(&work->session, results_object(work));
    return good ? CLAST_EXIT_SUCCESS : CLAST_EXIT_FAILURE;
}

clast_exit clast_run_export(const clast_command *command)
{
    if (!output_is_possible(command)) {
        return CLAST_EXIT_USAGE;
    }
    if (!clast_can_write(command->positionals[1])) {
        clast_print_error("%s: a file cannot be written there", command->positionals[1]);
        return CLAST_EXIT_FAILURE;
    }
    clast_export_work work = {0};
    if (!clast_session_begin(&work.session, command)) {
        return CLAST_EXIT_FAILURE;
    }
    clast_status status = work_through(&work);
    clast_exit code = status == CLAST_OK ? finish(&work) : clast_session_fail(&work.session, status);
    clast_renderer_destroy(work.renderer);
    clast_scene_destroy(work.scene);
    clast_session_end(&work.session);
    return code;
}
