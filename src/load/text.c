// SPDX-License-Identifier: Apache-2.0
#include "load/text.h"

#include <strings.h>

static bool ends_word(const char *at, const char *end)
{
    return at == end || *at == ' ' || *at == '\t' || *at == '\v' || *at == '\f' || clast_line_end(at, end) != 0 ||
           (*at == '\\' && clast_line_end(at + 1, end) != 0);
}

void clast_next_line(clast_text *text)
{
    while (text->at < text->end) {
        size_t joined = *text->at == '\\' ? clast_line_end(text->at + 1, text->end) : 0;
        size_t ended = clast_line_end(text->at, text->end);
        text->at += joined != 0 ? 1 + joined : ended != 0 ? ended : 1;
        text->line += joined != 0 || ended != 0;
        if (ended != 0) {
            return;
        }
    }
}

clast_word clast_next_word(clast_text *text)
{
    clast_skip_blanks(text);
    clast_word word = {text->at, 0};
    while (!ends_word(text->at, text->end)) {
        text->at++;
    }
    word.length = (size_t)(text->at - word.begin);
    return word;
}

clast_word clast_rest_of_line(clast_text *text)
{
    clast_skip_blanks(text);
    clast_word rest = {text->at, 0};
    while (text->at < text->end && clast_line_end(text->at, text->end) == 0) {
        text->at++;
    }
    rest.length = (size_t)(text->at - rest.begin);
    while (rest.length > 0 && ends_word(rest.begin + rest.length - 1, text->end)) {
        rest.length--;
    }
    return rest;
}

bool clast_next_number(clast_text *text, double *value)
{
    clast_skip_blanks(text);
    const char *next;
    if (!clast_parse_number(text->at, text->end, value, &next) || !ends_word(next, text->end)) {
        return false;
    }
    text->at = next;
    return true;
}

bool clast_word_resembles(clast_word word, const char *text)
{
    return word.length == strlen(text) && strncasecmp(word.begin, text, word.length) == 0;
}
