// SPDX-License-Identifier: Apache-2.0
#include "app/session.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "app/print.h"
#include "base/file.h"
#include "base/thread.h"
#include "scene/scene.h"

static void log_line(void *user, clast_log_level level, const char *text)
{
    clast_session *session = user;
    if (level == CLAST_LOG_WARNING && !session->command->quiet) {
        clast_session_clear_line(session);
        clast_print_warning("%s", text);
    }
}

static void show_progress(clast_session *session, const char *stage, uint64_t done, uint64_t total)
{
    double now = clast_clock(), part = total != 0 ? (double)done / (double)total : 0.0;
    if (session->frame_count != 0) {
        part = ((double)session->frame + part) / (double)session->frame_count;
    }
    if (strncmp(session->stage, stage, sizeof session->stage - 1) != 0) {
        snprintf(session->stage, sizeof session->stage, "%s", stage);
        session->stage_begun = now;
        session->stage_part = part;
    } else if (now - session->shown < 0.1) { // a terminal need not be faster than the eye
        return;
    }
    session->shown = now;
    double made = part - session->stage_part; // a render that goes on with a checkpoint has come some way before
    double passed = now - session->stage_begun;
    fprintf(stderr, "\r\033[K%s %3.0f %%", session->stage, 100.0 * part);
    if (session->frame_count != 0) {
        fprintf(stderr, ", frame %u of %u", session->frame + 1, session->frame_count);
    }
    if (made > 1e-6 && passed > 1.0) {
        uint64_t left = (uint64_t)(passed * (1.0 - part) / made + 0.5);
        fprintf(stderr, ", %" PRIu64 ":%02u left", left / 60, (unsigned)(left % 60));
    }
    fflush(stderr);
    session->line_is_shown = true;
}

static bool note_progress(void *user, const char *stage, uint64_t done, uint64_t total)
{
    clast_session *session = user;
    if (session->shows_progress) {
        show_progress(session, stage, done, total);
    }
    return !clast_interrupted();
}

bool clast_session_begin(clast_session *session, const clast_command *command)
{
    *session = (clast_session){.command = command, .begun = clast_clock()};
    session->shows_progress = !command->quiet && clast_is_terminal(stderr);
    clast_context_desc desc = {
        .log = {log_line, session},
        .progress = {note_progress, session},
        .threads = command->threads,
        .memory_limit = command->memory,
        .isa = (clast_isa)command->isa,
        .cache_folder = command->cache_dir,
    };
    clast_status status = clast_context_create(&desc, &session->context);
    if (status == CLAST_ERROR_DEVICE) {
        clast_print_error("--isa: this machine lacks the instruction set");
    } else if (status != CLAST_OK) {
        clast_print_error("%s", clast_status_text(status));
    }
    clast_watch_interrupts();
    return status == CLAST_OK;
}

clast_status clast_session_change(const clast_session *session, clast_scene *scene)
{
    const clast_command *command = session->command;
    clast_scene_counts counts;
    clast_scene_count(scene, &counts);
    clast_tessellation curved = {.curved = true};
    clast_status status = CLAST_OK;
    for (uint32_t i = 0; command->curved && i < counts.geometries && status == CLAST_OK; i++) {
        if (clast_geometry_is_mesh(&scene->geometries[i])) {
            status = clast_scene_set_tessellation(scene, i, &curved);
        }
    }
    return status == CLAST_OK && command->copies > 1 ? clast_scene_repeat(scene, command->copies) : status;
}

clast_status clast_session_settle(const clast_session *session, const clast_scene *scene, double time,
                                  clast_render_settings *settings)
{
    const clast_command *command = session->command;
    clast_render_settings scenes;
    clast_scene_settings_at(scene, time, &scenes);
    *settings = command->render;
#define MERGE(name, ...) \
    if (!command->given.name) { \
        settings->name = scenes.name; \
    }
    CLAST_RENDER_SETTING_LIST(MERGE, MERGE, MERGE, MERGE)
    settings->time = time;
    return clast_render_settings_resolve(session->context, settings);
}

clast_status clast_session_load(clast_session *session, clast_scene **scene, clast_render_settings *settings)
{
    const clast_command *command = session->command;
    clast_scene_choice choice = {command->chosen_scene, command->variant};
    clast_status status = clast_scene_load_chosen(session->context, command->positionals[0], &choice, scene);
    if (status == CLAST_OK) {
        status = clast_session_change(session, *scene);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_render_settings scenes;
    clast_scene_settings(*scene, &scenes);
    return clast_session_settle(session, *scene, command->given.time ? command->render.time : scenes.time, settings);
}

void clast_session_end(clast_session *session)
{
    clast_session_clear_line(session);
    clast_context_destroy(session->context);
    session->context = NULL;
}

void clast_session_clear_line(clast_session *session)
{
    if (session->line_is_shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
        session->line_is_shown = false;
    }
}

double clast_session_seconds(const clast_session *session)
{
    return clast_clock() - session->begun;
}

clast_exit clast_session_fail(clast_session *session, clast_status status)
{
    clast_session_clear_line(session);
    const char *text = clast_context_error(session->context);
    clast_print_error("%s", text[0] != '\0' ? text : clast_status_text(status));
    return status == CLAST_ERROR_CANCELLED ? CLAST_EXIT_CANCELLED : CLAST_EXIT_FAILURE;
}

static bool write_text(clast_session *session, const char *path, const char *text)
{
    clast_file_output output;
    clast_status status = clast_file_create(session->context, path, &output);
    if (status == CLAST_OK) {
        clast_file_write(&output, text, strlen(text));
        clast_file_write(&output, "\n", 1);
        status = clast_file_commit(&output);
    }
    if (status != CLAST_OK) {
        clast_session_fail(session, status);
    }
    return status == CLAST_OK;
}

bool clast_session_write_json(clast_session *session, json_t *object)
{
    const char *path = session->command->json;
    char *text = object != NULL ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(object);
    if (text == NULL) {
        clast_session_clear_line(session);
        clast_print_error("the statistics could not be written as JSON: memory ran out");
        return false;
    }
    bool good = true;
    if (strcmp(path, "-") == 0) {
        puts(text);
    } else {
        good = write_text(session, path, text);
    }
    free(text);
    return good;
}

bool clast_session_prints(const clast_session *session)
{
    const clast_command *command = session->command;
    return !command->quiet && !(command->json != NULL && strcmp(command->json, "-") == 0);
}

clast_exit clast_finish_output(clast_exit code)
{
    bool whole = ferror(stdout) == 0;
    whole = fflush(stdout) == 0 && whole;
    if (!whole) {
        clast_print_error("standard output did not take everything");
        return code == CLAST_EXIT_SUCCESS ? CLAST_EXIT_FAILURE : code;
    }
    return code;
}
