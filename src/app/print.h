// SPDX-License-Identifier: Apache-2.0
// What the command prints, and the little it needs from the machine.
#ifndef CLAST_APP_PRINT_H
#define CLAST_APP_PRINT_H

#include <stdio.h>

#include "base/context.h"

// One line on standard error: "clast: ...". Control characters of names become spaces.
void clast_print_error(const char *format, ...) CLAST_PRINTF(1, 2);
void clast_print_warning(const char *format, ...) CLAST_PRINTF(1, 2);

// Prints words with lines broken before `width` columns; lines after the first begin with `indent` spaces. The first line
// begins at column `column`. Ends with a line end.
void clast_print_wrapped(FILE *stream, const char *text, int column, int indent, int width);

// "1.5 GiB"
const char *clast_format_bytes(uint64_t bytes, char text[32]);
// "1 234 567"
const char *clast_format_count(uint64_t count, char text[32]);

// machine.c
bool clast_is_terminal(FILE *stream);
// Whether a file can be made at `path`: its folder is there and may be written to. Saves work whose result could not be kept.
bool clast_can_write(const char *path);
// From now on the first interrupt (SIGINT, SIGTERM) is only noted, the second ends the process.
void clast_watch_interrupts(void);
bool clast_interrupted(void);

#endif
