// SPDX-License-Identifier: Apache-2.0
// clast generate: procedural scenes as files.
#include <string.h>

#include "app/print.h"
#include "app/session.h"
#include "clast/generate.h"

static clast_exit list_scenes(void)
{
    const char *name = NULL;
    const char *text = NULL;
    for (uint32_t i = 0; clast_generate_scene(i, &name, &text); i++) {
        int column = printf("%-10s ", name);
        clast_print_wrapped(stdout, text, column, column, 100);
    }
    return CLAST_EXIT_SUCCESS;
}

static bool scene_is_known(const char *wanted)
{
    char all[256] = "";
    const char *name = NULL;
    const char *text = NULL;
    for (uint32_t i = 0; clast_generate_scene(i, &name, &text); i++) {
        if (strcmp(name, wanted) == 0) {
            return true;
        }
        size_t length = strlen(all);
        snprintf(all + length, sizeof all - length, "%s%s", length != 0 ? ", " : "", name);
    }
    clast_print_error("there is no scene \"%s\"; expected one of %s", wanted, all);
    return false;
}

clast_exit clast_run_generate(const clast_command *command)
{
    if (command->list) {
        return list_scenes();
    }
    if (!scene_is_known(command->positionals[0])) {
        return CLAST_EXIT_USAGE;
    }
    clast_session session;
    if (!clast_session_begin(&session, command)) {
        return CLAST_EXIT_FAILURE;
    }
    clast_generate_desc desc = {command->positionals[0], command->detail, command->generate_seed};
    clast_status status = clast_generate(session.context, &desc, command->positionals[1]);
    clast_exit code = CLAST_EXIT_SUCCESS;
    if (status != CLAST_OK) {
        code = clast_session_fail(&session, status);
    } else if (clast_session_prints(&session)) {
        clast_session_clear_line(&session);
        printf("%s: scene.json and the files that it names, in %.2f s\n", command->positionals[1],
               clast_session_seconds(&session));
    }
    clast_session_end(&session);
    return code;
}
