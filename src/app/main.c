// SPDX-License-Identifier: Apache-2.0
// The command: clast VERB [options] INPUT [OUTPUT].
#include <string.h>

#include "app/option.h"
#include "app/print.h"
#include "app/session.h"

// clast help [VERB | --man | --completion]
static clast_exit run_help(int count, char *const *arguments)
{
    if (count > 1) {
        clast_print_error("help takes one verb: \"%s\" is one too many", arguments[1]);
        return CLAST_EXIT_USAGE;
    }
    clast_verb verb;
    if (count == 0) {
        clast_help_overview();
    } else if (strcmp(arguments[0], "--man") == 0) {
        clast_help_manual();
    } else if (strcmp(arguments[0], "--completion") == 0) {
        clast_help_completion();
    } else if (clast_verb_find(arguments[0], &verb)) {
        clast_help_verb(verb);
    } else {
        return CLAST_EXIT_USAGE;
    }
    return CLAST_EXIT_SUCCESS;
}

static clast_exit run(int count, char *const *arguments)
{
    if (count == 0) {
        clast_print_error("a verb is missing; \"clast help\" lists them");
        return CLAST_EXIT_USAGE;
    }
    const char *first = arguments[0];
    if (strcmp(first, "--version") == 0) {
        printf("clast %s\n", clast_version());
        return CLAST_EXIT_SUCCESS;
    }
    if (strcmp(first, "help") == 0 || strcmp(first, "--help") == 0 || strcmp(first, "-h") == 0) {
        return run_help(count - 1, arguments + 1);
    }
    clast_verb verb;
    clast_command command;
    if (!clast_verb_find(first, &verb) || !clast_command_parse(verb, count - 1, arguments + 1, &command)) {
        return CLAST_EXIT_USAGE;
    }
    if (command.help) {
        clast_help_verb(verb);
        return CLAST_EXIT_SUCCESS;
    }
    return clast_verbs[verb].run(&command);
}

int main(int argc, char **argv)
{
    return (int)clast_finish_output(run(argc > 0 ? argc - 1 : 0, argv + (argc > 0)));
}
