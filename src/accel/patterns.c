// SPDX-License-Identifier: Apache-2.0
#include "accel/patterns.h"

#include "accel/structures.h"

// What the templates are made of. A table's triangles are in order for blocks.
typedef struct pattern_descs {
    clast_template_desc descs[PATTERN_COUNT];
    uint8_t (*indices)[3]; // of the table's triangles
} pattern_descs;

static void unpack_triangles(const clast_pattern_table *table, uint8_t (*indices)[3])
{
    for (uint32_t i = 0; i < table->triangle_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            indices[i][k] = (uint8_t)(table->triangles[i] >> (8 * k));
        }
    }
}

static clast_status add(clast_template_set *set, const clast_pattern_table *table, pattern_descs *made, uint32_t *first)
{
    unpack_triangles(table, made->indices);
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        const clast_pattern *pattern = &table->patterns[i];
        made->descs[i] = (clast_template_desc){
            .triangle_count = pattern_triangles(*pattern),
            .vertex_count = pattern_vertices(*pattern),
            .indices = made->indices[pattern->first_triangle],
        };
    }
    return clast_template_set_add(set, made->descs, PATTERN_COUNT, first);
}

clast_status clast_template_set_add_patterns(clast_template_set *set, const clast_pattern_table *table, uint32_t *first)
{
    if (set->has_patterns && set->pattern_hash == table->hash) {
        *first = set->first_pattern;
        return CLAST_OK;
    }
    pattern_descs *made = clast_allocate(set->context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->indices = clast_allocate(set->context, table->triangle_count, sizeof *made->indices);
    clast_status status = made->indices != NULL ? add(set, table, made, first) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        set->has_patterns = true;
        set->pattern_hash = table->hash;
        set->first_pattern = *first;
    }
    clast_free(set->context, made->indices);
    clast_free(set->context, made);
    return status;
}
