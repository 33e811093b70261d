// SPDX-License-Identifier: Apache-2.0
// The parser of command lines. Nothing is guessed: a number that is not wholly one, or is out of range, is refused.
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "app/option.h"
#include "app/print.h"

enum { NAME_MOST = 64 };

// The edits (insert, remove, replace a letter) that lead from one word to another; Wagner and Fischer, The String-to-String
// Correction Problem, JACM 21(1), 1974. Words longer than NAME_MOST are far from everything.
static size_t edit_distance(const char *a, const char *b)
{
    size_t row[NAME_MOST + 1];
    size_t length = strlen(b);
    if (length > NAME_MOST || strlen(a) > NAME_MOST) {
        return SIZE_MAX;
    }
    for (size_t j = 0; j <= length; j++) {
        row[j] = j;
    }
    for (size_t i = 0; a[i] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < length; j++) {
            size_t replaced = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            size_t fewer = row[j] < row[j + 1] ? row[j] : row[j + 1];
            row[j + 1] = replaced < fewer + 1 ? replaced : fewer + 1;
        }
    }
    return row[length];
}

// Keeps the nearer of two words; a word is near where at most a third of it, and one letter more, is wrong.
static void keep_nearer(const char *wanted, const char *word, const char **nearest, size_t *distance)
{
    size_t edits = edit_distance(wanted, word);
    if (edits < *distance && edits <= strlen(word) / 3 + 1) {
        *nearest = word;
        *distance = edits;
    }
}

bool clast_verb_find(const char *name, clast_verb *verb)
{
    const char *nearest = NULL;
    size_t distance = SIZE_MAX;
    for (uint32_t i = 0; i < CLAST_VERB_COUNT_; i++) {
        if (strcmp(clast_verbs[i].name, name) == 0) {
            *verb = (clast_verb)i;
            return true;
        }
        keep_nearer(name, clast_verbs[i].name, &nearest, &distance);
    }
    if (nearest != NULL) {
        clast_print_error("there is no verb \"%s\"; did you mean \"%s\"?", name, nearest);
    } else {
        clast_print_error("there is no verb \"%s\"; \"clast help\" lists them", name);
    }
    return false;
}

static const clast_option *option_find(clast_verb verb, const char *name, size_t length)
{
    for (size_t i = 0; i < clast_option_count; i++) {
        const clast_option *option = &clast_options[i];
        if (clast_option_is_for(option, verb) && strlen(option->name) == length &&
            strncmp(clast_option_spell(option).text, name, length) == 0) {
            return option;
        }
    }
    return NULL;
}

static bool unknown_option(clast_verb verb, const char *argument)
{
    char name[NAME_MOST + 1];
    size_t length = strcspn(argument, "=");
    if (length > NAME_MOST) {
        length = NAME_MOST;
    }
    memcpy(name, argument, length);
    name[length] = '\0';
    const char *word = name + strspn(name, "-");
    clast_option_word nearest = {""};
    size_t distance = SIZE_MAX;
    for (size_t i = 0; i < clast_option_count; i++) {
        clast_option_word known = clast_option_spell(&clast_options[i]);
        const char *nearer = NULL;
        if (clast_option_is_for(&clast_options[i], verb)) {
            keep_nearer(word, known.text, &nearer, &distance);
        }
        nearest = nearer != NULL ? known : nearest;
    }
    const char *verb_name = clast_verbs[verb].name;
    if (nearest.text[0] != '\0') {
        clast_print_error("%s has no option %s; did you mean --%s?", verb_name, name, nearest.text);
    } else {
        clast_print_error("%s has no option %s; \"clast help %s\" lists them", verb_name, name, verb_name);
    }
    return false;
}

// Whole numbers are digits only: no sign, no space, no other base.
static bool parse_whole(const char *text, uint64_t *number, const char **end)
{
    if (text[0] < '0' || text[0] > '9') {
        return false;
    }
    char *stop = NULL;
    errno = 0;
    unsigned long long value = strtoull(text, &stop, 10);
    *end = stop;
    *number = value;
    return errno == 0;
}

static bool parse_uint(const clast_option *option, const char *text, void *place)
{
    uint64_t number = 0;
    const char *end = text;
    double minimum = option->minimum;
    double maximum = option->maximum;
    if (!parse_whole(text, &number, &end) || *end != '\0' || (double)number < minimum || (double)number > maximum) {
        clast_print_error("--%s: expected a whole number from %.0f to %.0f, got \"%s\"",
                          clast_option_spell(option).text, minimum, maximum, text);
        return false;
    }
    *(uint32_t *)place = (uint32_t)number;
    return true;
}

static bool parse_real(const clast_option *option, const char *text, void *place)
{
    char *end = NULL;
    bool plain = text[0] != '\0' &&
                 text[strspn(text, "+-.0123456789eE")] == '\0'; // no nan, inf, hexadecimals or spaces
    double number = strtod(text, &end);
    if (!plain || *end != '\0' || !isfinite(number) || number < option->minimum || number > option->maximum) {
        clast_print_error("--%s: expected a number from %g to %g, got \"%s\"", clast_option_spell(option).text,
                          option->minimum, option->maximum, text);
        return false;
    }
    *(double *)place = number == 0.0 && option->default_number != 0.0 ? CLAST_ZERO : number;
    return true;
}

static bool parse_choice(const clast_option *option, const char *text, void *place)
{
    char all[256] = "";
    for (const clast_choice *choice = option->choices; choice->text != NULL; choice++) {
        if (strcmp(choice->text, text) == 0) {
            *(uint32_t *)place = choice->value;
            return true;
        }
        size_t length = strlen(all);
        snprintf(all + length, sizeof all - length, "%s%s", length != 0 ? ", " : "", choice->text);
    }
    clast_print_error("--%s: expected one of %s, got \"%s\"", clast_option_spell(option).text, all, text);
    return false;
}

// Bytes, with K, M, G or T for powers of 1024.
static bool parse_size(const clast_option *option, const char *text, void *place)
{
    static const char units[] = "KMGT";
    uint64_t number = 0;
    const char *end = text;
    bool good = parse_whole(text, &number, &end);
    if (good && *end != '\0') {
        const char *unit = strchr(units, *end);
        unsigned shift = unit != NULL ? 10 * (unsigned)(unit - units + 1) : 0;
        good = unit != NULL && end[1] == '\0' && number <= UINT64_MAX >> shift;
        number <<= shift;
    }
    if (!good) {
        clast_print_error("--%s: expected a number of bytes, as 4G or 512M, got \"%s\"",
                          clast_option_spell(option).text, text);
        return false;
    }
    *(uint64_t *)place = number;
    return true;
}

static bool parse_range(const clast_option *option, const char *text, void *place)
{
    uint64_t first = 0, last = 0;
    const char *end = text;
    bool good = parse_whole(text, &first, &end);
    last = first;
    if (good && *end == ':') {
        good = parse_whole(end + 1, &last, &end);
    }
    if (!good || *end != '\0' || first > last || last >= UINT32_MAX) {
        clast_print_error("--%s: expected two whole numbers, the first not above the second, as 1:24, got \"%s\"",
                          clast_option_spell(option).text, text);
        return false;
    }
    *(clast_range *)place = (clast_range){(uint32_t)first, (uint32_t)last};
    return true;
}

static bool parse_value(const clast_option *option, const char *text, clast_command *command)
{
    void *place = (char *)command + option->offset;
    *((bool *)((char *)command + option->given_offset)) = true;
    switch (option->type) {
    case CLAST_OPTION_UINT: return parse_uint(option, text, place);
    case CLAST_OPTION_REAL: return parse_real(option, text, place);
    case CLAST_OPTION_CHOICE: return parse_choice(option, text, place);
    case CLAST_OPTION_SIZE: return parse_size(option, text, place);
    case CLAST_OPTION_FLAG: *(bool *)place = true; return true;
    case CLAST_OPTION_RANGE: return parse_range(option, text, place);
    case CLAST_OPTION_TEXT:
    case CLAST_OPTION_OPTIONAL: *(const char **)place = text; return true;
    }
    return false;
}

// Takes the option at arguments[*index], and its value, which may be the argument after it.
static bool parse_option(clast_verb verb, int count, char *const *arguments, int *index, clast_command *command)
{
    const char *argument = arguments[*index];
    if (strcmp(argument, "-h") == 0) {
        argument = "--help";
    }
    size_t length = strcspn(argument, "=");
    bool is_long = strncmp(argument, "--", 2) == 0;
    const clast_option *option = is_long ? option_find(verb, argument + 2, length - 2) : NULL;
    if (option == NULL) {
        return unknown_option(verb, argument);
    }
    const char *value = argument[length] == '=' ? argument + length + 1 : NULL;
    if (option->type == CLAST_OPTION_FLAG) {
        if (value != NULL) {
            clast_print_error("--%s takes no value", clast_option_spell(option).text);
            return false;
        }
        return parse_value(option, "", command);
    }
    if (option->type == CLAST_OPTION_OPTIONAL) {
        if (value != NULL && value[0] == '\0') {
            clast_print_error("--%s: expected %s after the equals sign", clast_option_spell(option).text,
                              option->placeholder);
            return false;
        }
        return parse_value(option, value != NULL ? value : "-", command);
    }
    if (value == NULL) {
        if (*index + 1 >= count) {
            clast_print_error("--%s: expected %s after it", clast_option_spell(option).text, option->placeholder);
            return false;
        }
        value = arguments[++*index];
    }
    return parse_value(option, value, command);
}

static void set_defaults(clast_verb verb, clast_command *command)
{
    *command = (clast_command){.verb = verb};
#define DEFAULT_NUMBER(verbs, field, name, initial, ...) command->field = initial;
#define DEFAULT_CHOICE(verbs, field, name, list, initial, ...) command->field = initial;
#define DEFAULT_ZERO(verbs, field, ...)
    CLAST_COMMAND_OPTION_LIST(DEFAULT_NUMBER, DEFAULT_NUMBER, DEFAULT_CHOICE, DEFAULT_ZERO, DEFAULT_ZERO, DEFAULT_ZERO,
                              DEFAULT_ZERO, DEFAULT_ZERO)
}

bool clast_command_parse(clast_verb verb, int count, char *const *arguments, clast_command *command)
{
    set_defaults(verb, command);
    const clast_verb_info *info = &clast_verbs[verb];
    uint32_t positionals = 0;
    bool options_ended = false;
    for (int i = 0; i < count; i++) {
        const char *argument = arguments[i];
        if (!options_ended && strcmp(argument, "--") == 0) {
            options_ended = true;
        } else if (!options_ended && argument[0] == '-' && argument[1] != '\0') {
            if (!parse_option(verb, count, arguments, &i, command)) {
                return false;
            }
        } else if (positionals == info->positionals_most) {
            clast_print_error("%s takes %s: \"%s\" is one too many%s", info->name, info->positionals, argument,
                              command->json != NULL ? " (a file for statistics is given as --json=FILE)" : "");
            return false;
        } else {
            command->positionals[positionals++] = argument;
        }
    }
    if (command->help || command->list) {
        return true;
    }
    if (positionals < info->positionals_least) {
        clast_print_error("%s needs %s; \"clast help %s\" tells more", info->name, info->positionals, info->name);
        return false;
    }
    for (uint32_t i = 0; i < positionals; i++) {
        if (command->positionals[i][0] == '\0') {
            clast_print_error("%s: an empty name stands for no file", info->name);
            return false;
        }
    }
    return true;
}
