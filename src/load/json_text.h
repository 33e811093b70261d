// SPDX-License-Identifier: Apache-2.0
// JSON texts of files, as values of jansson.
#ifndef CLAST_LOAD_JSON_TEXT_H
#define CLAST_LOAD_JSON_TEXT_H

#include <jansson.h>

#include "base/context.h"
#include "load/bytes.h"

// Parses a text; names that an object has twice are refused. The values are the library's own memory and outside the context's
// limit: texts whose values might come to more than clast_unpacked_most() are refused beforehand. The caller ends the values by
// json_decref(). `name` is for errors: MALFORMED, LIMIT, OUT_OF_MEMORY.
clast_status clast_json_parse(clast_context *context, const char *name, clast_bytes text, json_t **json);

#endif
