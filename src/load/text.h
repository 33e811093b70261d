// SPDX-License-Identifier: Apache-2.0
// A cursor over a text of lines, as OBJ and MTL files have them: a backslash before a line's end joins the next line,
// and lines end by LF, CR LF or CR; the last may lack its end.
#ifndef CLAST_LOAD_TEXT_H
#define CLAST_LOAD_TEXT_H

#include "load/bytes.h"
#include "load/number.h"

typedef struct clast_text {
    const char *at;
    const char *end;
    uint64_t line; // of `at`, from 1
} clast_text;

// A piece of the text; not ended by a zero.
typedef struct clast_word {
    const char *begin;
    size_t length;
} clast_word;

static inline clast_text clast_text_of(clast_bytes bytes)
{
    clast_text text = {(const char *)bytes.data, (const char *)bytes.data + bytes.size, 1};
    if (clast_bytes_begin_with(bytes, "\xef\xbb\xbf")) { // a byte order mark
        text.at += 3;
    }
    return text;
}

// The length of the line end at `at`, 0 where there is none.
static inline size_t clast_line_end(const char *at, const char *end)
{
    if (at < end && *at == '\r') {
        return at + 1 < end && at[1] == '\n' ? 2 : 1;
    }
    return at < end && *at == '\n';
}

// Moves over blanks and joined line ends.
static inline void clast_skip_blanks(clast_text *text)
{
    for (;;) {
        if (text->at < text->end && (*text->at == ' ' || *text->at == '\t' || *text->at == '\v' || *text->at == '\f')) {
            text->at++;
            continue;
        }
        size_t joined = text->at < text->end && *text->at == '\\' ? clast_line_end(text->at + 1, text->end) : 0;
        if (joined == 0) {
            return;
        }
        text->at += 1 + joined;
        text->line++;
    }
}

// Whether nothing but a comment is left in the line. Moves over blanks.
static inline bool clast_line_is_over(clast_text *text)
{
    clast_skip_blanks(text);
    return text->at == text->end || *text->at == '\n' || *text->at == '\r' || *text->at == '#';
}

// Moves to the next line, whatever is left of this one.
void clast_next_line(clast_text *text);

// The next word of the line; of length 0 where the line is over.
clast_word clast_next_word(clast_text *text);

// What is left of the line, without blanks around it; joined lines are not joined. Names with spaces are read so.
clast_word clast_rest_of_line(clast_text *text);

// The next number of the line; false where none begins there, or it does not end at a blank.
bool clast_next_number(clast_text *text, double *value);

static inline bool clast_word_is(clast_word word, const char *text)
{
    return word.length == strlen(text) && memcmp(word.begin, text, word.length) == 0;
}

// The same, without regard to case.
bool clast_word_resembles(clast_word word, const char *text);

#endif
