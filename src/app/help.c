// SPDX-License-Identifier: Apache-2.0
// Every text about the command, from its tables: help, manual page, shell completion.
#include <string.h>

#include "app/option.h"
#include "app/print.h"

enum { WIDTH = 100, INDENT = 30, RANGE_SIZE = 512 };

// "--width PIXELS", "--json[=FILE]", "--quiet"
static void option_usage(const clast_option *option, char text[RANGE_SIZE])
{
    const char *format = option->type == CLAST_OPTION_FLAG       ? "--%s%s"
                         : option->type == CLAST_OPTION_OPTIONAL ? "--%s[=%s]"
                                                                 : "--%s %s";
    snprintf(text, RANGE_SIZE, format, clast_option_spell(option).text,
             option->type == CLAST_OPTION_FLAG ? "" : option->placeholder);
}

static void choices_text(const clast_option *option, char text[RANGE_SIZE])
{
    size_t length = 0;
    const char *initial = "";
    for (const clast_choice *choice = option->choices; choice->text != NULL; choice++) {
        length += (size_t)snprintf(text + length, RANGE_SIZE - length, "%s%s", length != 0 ? ", " : "", choice->text);
        if (choice->value == (uint32_t)option->default_number) {
            initial = choice->text;
        }
    }
    snprintf(text + length, RANGE_SIZE - length, "; default %s", initial);
}

// What values an option takes, and what it is without; empty where there is nothing to say.
static void option_range(const clast_option *option, char text[RANGE_SIZE])
{
    text[0] = '\0';
    switch (option->type) {
    case CLAST_OPTION_UINT:
        snprintf(text, RANGE_SIZE, "%.0f to %.0f; default %.0f", option->minimum, option->maximum,
                 option->default_number);
        break;
    case CLAST_OPTION_REAL:
        snprintf(text, RANGE_SIZE, "%g to %g; default %g", option->minimum, option->maximum, option->default_number);
        break;
    case CLAST_OPTION_CHOICE: choices_text(option, text); break;
    case CLAST_OPTION_SIZE: snprintf(text, RANGE_SIZE, "default 0"); break;
    case CLAST_OPTION_TEXT:
        if (option->default_text[0] != '\0') {
            snprintf(text, RANGE_SIZE, "default %s", option->default_text);
        }
        break;
    case CLAST_OPTION_FLAG:
    case CLAST_OPTION_OPTIONAL:
    case CLAST_OPTION_RANGE: break;
    }
}

static void print_option(const clast_option *option)
{
    char usage[RANGE_SIZE];
    char range[RANGE_SIZE];
    char text[2 * RANGE_SIZE];
    option_usage(option, usage);
    option_range(option, range);
    snprintf(text, sizeof text, range[0] != '\0' ? "%s (%s)" : "%s%s", option->help, range);
    int column = printf("  %s", usage);
    if (column + 2 > INDENT) {
        printf("\n");
        column = 0;
    }
    printf("%*s", INDENT - column, "");
    clast_print_wrapped(stdout, text, INDENT, INDENT, WIDTH);
}

static void print_views(void)
{
    printf("\nviews:\n");
#define PRINT_VIEW(name, value, text, channels, is_float, help) \
    printf("  %-10s", text); \
    clast_print_wrapped(stdout, help, 12, 12, WIDTH);
    CLAST_VIEW_LIST(PRINT_VIEW)
}

static void print_exits(void)
{
    printf("\nexit codes:\n");
#define PRINT_EXIT(name, value, text) \
    printf("  %d  ", value); \
    clast_print_wrapped(stdout, text, 5, 5, WIDTH);
    CLAST_EXIT_LIST(PRINT_EXIT)
}

void clast_help_overview(void)
{
    printf(
        "clast %s: draws geometry too dense for ordinary renderers\n\nusage: clast VERB [options] INPUT [OUTPUT]\n\nverbs:\n",
        clast_version());
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        printf("  %-10s %s\n", clast_verbs[i].name, clast_verbs[i].summary);
    }
    printf(
        "\n\"clast help VERB\" and \"clast VERB --help\" tell all about a verb. \"clast --version\" prints the version.\n"
        "\"clast help --man\" prints the manual page, \"clast help --completion\" what makes bash complete command lines.\n");
    print_exits();
}

void clast_help_verb(clast_verb verb)
{
    const clast_verb_info *info = &clast_verbs[verb];
    printf("clast %s: %s\n\nusage: clast %s [options] %s\n", info->name, info->summary, info->name, info->positionals);
    for (const char *const *detail = info->details; *detail != NULL; detail++) {
        printf("\n");
        clast_print_wrapped(stdout, *detail, 0, 0, WIDTH);
    }
    printf("\noptions:\n");
    for (size_t i = 0; i < clast_option_count; i++) {
        if (clast_option_is_for(&clast_options[i], verb)) {
            print_option(&clast_options[i]);
        }
    }
    if (verb == CLAST_VERB_RENDER) {
        print_views();
    }
    print_exits();
}

// Text for troff: backslashes and hyphens are escaped, and a line must not begin with a dot or a quote.
static void print_troff(const char *text)
{
    if (text[0] == '.' || text[0] == '\'') {
        printf("\\&");
    }
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '\\') {
            printf("\\e");
        } else if (*c == '-') {
            printf("\\-");
        } else {
            putchar(*c);
        }
    }
    putchar('\n');
}

static void print_troff_option(const clast_option *option)
{
    char usage[RANGE_SIZE];
    char range[RANGE_SIZE];
    char text[2 * RANGE_SIZE];
    option_usage(option, usage);
    option_range(option, range);
    snprintf(text, sizeof text, range[0] != '\0' ? "%s (%s)." : "%s%s.", option->help, range);
    printf(".TP\n.B ");
    print_troff(usage);
    print_troff(text);
}

void clast_help_manual(void)
{
    printf(
        ".TH CLAST 1 \"\" \"clast %s\" \"User Commands\"\n.SH NAME\nclast \\- draws geometry too dense for ordinary renderers\n",
        clast_version());
    printf(".SH SYNOPSIS\n");
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        printf("%s.B clast %s\n[options] %s\n", i != 0 ? ".br\n" : "", clast_verbs[i].name, clast_verbs[i].positionals);
    }
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        const clast_verb_info *info = &clast_verbs[i];
        printf(".SH \"CLAST %s\"\n.B clast %s\n", info->name, info->name);
        print_troff(info->summary);
        for (const char *const *detail = info->details; *detail != NULL; detail++) {
            printf(".PP\n");
            print_troff(*detail);
        }
        for (size_t j = 0; j < clast_option_count; j++) {
            if (clast_option_is_for(&clast_options[j], (clast_verb)i)) {
                print_troff_option(&clast_options[j]);
            }
        }
    }
    printf(".SH EXIT STATUS\n");
#define PRINT_TROFF_EXIT(name, value, text) \
    printf(".TP\n.B %d\n", value); \
    print_troff(text);
    CLAST_EXIT_LIST(PRINT_TROFF_EXIT)
}

static void print_completion_words(clast_verb verb)
{
    for (size_t i = 0; i < clast_option_count; i++) {
        if (clast_option_is_for(&clast_options[i], verb)) {
            printf(" --%s%s", clast_option_spell(&clast_options[i]).text,
                   clast_options[i].type == CLAST_OPTION_OPTIONAL ? "=" : "");
        }
    }
}

void clast_help_completion(void)
{
    printf("# bash completion for clast; printed by \"clast help --completion\"\n_clast()\n{\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=\n"
           "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n        words=\"help --version");
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        printf(" %s", clast_verbs[i].name);
    }
    printf(
        "\"\n        COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n        return\n    fi\n    case $before in\n");
    for (size_t i = 0; i < clast_option_count; i++) {
        const clast_option *option = &clast_options[i];
        if (option->type == CLAST_OPTION_CHOICE) {
            printf("    --%s) words=\"", clast_option_spell(option).text);
            for (const clast_choice *choice = option->choices; choice->text != NULL; choice++) {
                printf("%s%s", choice != option->choices ? " " : "", choice->text);
            }
            printf("\" ;;\n");
        }
    }
    printf("    esac\n    if [ -z \"$words\" ] && [[ $word == -* ]]; then\n        case ${COMP_WORDS[1]} in\n");
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        printf("        %s) words=\"", clast_verbs[i].name);
        print_completion_words((clast_verb)i);
        printf("\" ;;\n");
    }
    printf(
        "        esac\n    fi\n    if [ -n \"$words\" ]; then\n        COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
        "    else\n        COMPREPLY=($(compgen -f -- \"$word\"))\n    fi\n}\ncomplete -o filenames -F _clast clast\n");
}
