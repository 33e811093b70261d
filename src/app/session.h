// SPDX-License-Identifier: Apache-2.0
// What all verbs share: a context made from the options, progress on a terminal, statistics as JSON.
#ifndef CLAST_APP_SESSION_H
#define CLAST_APP_SESSION_H

#include <jansson.h>

#include "app/option.h"
#include "clast/context.h"

typedef struct clast_session {
    const clast_command *command;
    clast_context *context;
    double begun; // clast_clock() at the start
    bool shows_progress;
    bool line_is_shown; // a progress line stands on the terminal
    char stage[32];
    double stage_begun, stage_part; // when the stage began, and what was done of it then: 0 to 1
    double shown;                   // when the line was last written
    uint32_t frame,
        frame_count; // of an animation, for the progress: the first is 0; no frames where there is one picture
} clast_session;

// Begins the work of a verb; prints the error and gives false where the context cannot be made.
bool clast_session_begin(clast_session *session, const clast_command *command);
void clast_session_end(clast_session *session);
// Changes a scene as the options say: curves its meshes, repeats it.
clast_status clast_session_change(const clast_session *session, clast_scene *scene);
// Reads the scene that the command line names, changed as its options say, and the settings: what the command line does not
// say, the scene file does. The settings are resolved.
clast_status clast_session_load(clast_session *session, clast_scene **scene, clast_render_settings *settings);
// The settings at another time: what a scene file changes with time is as it is then.
clast_status clast_session_settle(const clast_session *session, const clast_scene *scene, double time,
                                  clast_render_settings *settings);
// Takes the progress line off the terminal.
void clast_session_clear_line(clast_session *session);
double clast_session_seconds(const clast_session *session);

// Prints the context's error, and gives the exit code for the status.
clast_exit clast_session_fail(clast_session *session, clast_status status);

// Writes and releases the object where --json asks for it; gives false after an error line. An object that is null (memory
// ran out) is an error too.
bool clast_session_write_json(clast_session *session, json_t *object);
// Whether results for a person go to standard output.
bool clast_session_prints(const clast_session *session);
// Ends what was printed: an error where standard output did not take it all.
clast_exit clast_finish_output(clast_exit code);

#endif
