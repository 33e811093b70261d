// SPDX-License-Identifier: Apache-2.0
// Numbers in text: fast, correctly rounded, and the same in every locale.
#ifndef CLAST_LOAD_NUMBER_H
#define CLAST_LOAD_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

// Reads a decimal number ([sign] digits [. digits] [e [sign] digits]) that begins at `at` and ends before `end`, and
// says where it ends. False where none begins there ("inf" and "nan" are none). Too large a number is infinite.
bool clast_parse_number(const char *at, const char *end, double *value, const char **next);

// Reads an integer with an optional sign; false where none begins there or it does not fit.
bool clast_parse_integer(const char *at, const char *end, int64_t *value, const char **next);

#endif
