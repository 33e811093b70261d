// SPDX-License-Identifier: Apache-2.0
// The table of patterns: what shared/pattern.h numbers, as flat arrays. docs/patterns.md tells what a pattern must be, how
// the library's own were found, and the form of a table of one's own.
#ifndef CLAST_GEOMETRY_PATTERN_H
#define CLAST_GEOMETRY_PATTERN_H

#include "base/context.h"
#include "geometry/pattern_shape.h"

typedef struct clast_pattern_table {
    const clast_pattern *patterns; // PATTERN_COUNT, by number
    const uint32_t *vertices;      // weights_word()
    const uint32_t *triangles;     // three vertices of the pattern, 8 bits each
    uint32_t vertex_count, triangle_count;
    uint64_t hash; // of all arrays: other contents, another hash
} clast_pattern_table;

// The library's own.
extern const clast_pattern_table clast_patterns;

static inline const clast_pattern *clast_pattern_of(const clast_pattern_table *table, uint32_t factors)
{
    return &table->patterns[pattern_use(factors).number];
}

// Makes a table of PATTERN_COUNT shapes, by their numbers: the ordered ones are given, with triangles in any order; their
// mirror images are made. Each is
// checked: errors (CLAST_ERROR_MALFORMED) say `name`, the pattern and what is wrong with it. The table is the caller's to free; the
// library's own is not.
clast_status clast_pattern_table_create(clast_context *context, const char *name, clast_pattern_shape *shapes,
                                        clast_pattern_table **table);
void clast_pattern_table_free(clast_context *context, clast_pattern_table *table);

#endif
