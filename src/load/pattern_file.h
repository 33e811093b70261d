// SPDX-License-Identifier: Apache-2.0
#ifndef CLAST_LOAD_PATTERN_FILE_H
#define CLAST_LOAD_PATTERN_FILE_H

#include "geometry/pattern.h"

// Reads a table of patterns (docs/patterns.md). Errors name the file and the line, or the pattern and what is wrong with it.
// The table is the caller's, by clast_pattern_table_free.
clast_status clast_load_patterns(clast_context *context, const char *path, clast_pattern_table **table);

#endif
