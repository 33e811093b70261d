// SPDX-License-Identifier: Apache-2.0
#include "geometry/pattern.h"

#include <string.h>

// A table and its arrays, in one block.
typedef struct table_block {
    clast_pattern_table table;
    clast_pattern patterns[PATTERN_COUNT];
    uint32_t words[]; // vertices, then triangles
} table_block;

static clast_status check(clast_context *context, const char *name, const clast_pattern_shape *shapes)
{
    uint32_t first = 0, second = 0;
    const char *fault = NULL;
    for (uint32_t i = 0; i < PATTERN_ORDERED && fault == NULL; i++) {
        first = second = i;
        fault = clast_pattern_shape_fault(&shapes[i]);
    }
    fault = fault != NULL ? fault : clast_pattern_shapes_fault(shapes, &first, &second);
    if (fault == NULL) {
        return CLAST_OK;
    }
    uint32_t one = shapes[first].factors, other = shapes[second].factors;
    if (first == second) {
        return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: pattern %u %u %u: %s", name, pattern_factor(one, 0),
                          pattern_factor(one, 1), pattern_factor(one, 2), fault);
    }
    return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: pattern %u %u %u: %s, %u %u %u", name,
                      pattern_factor(one, 0), pattern_factor(one, 1), pattern_factor(one, 2), fault,
                      pattern_factor(other, 0), pattern_factor(other, 1), pattern_factor(other, 2));
}

static void copy_shapes(table_block *block, const clast_pattern_shape *shapes, uint32_t *vertices, uint32_t *triangles)
{
    clast_pattern_table table = {.patterns = block->patterns, .vertices = vertices, .triangles = triangles};
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        const clast_pattern_shape *shape = &shapes[i];
        block->patterns[i] = (clast_pattern){
            .first_vertex = table.vertex_count,
            .first_triangle = table.triangle_count,
            .counts = pattern_counts(shape->factors, shape->triangle_count, shape->vertex_count),
        };
        memcpy(vertices + table.vertex_count, shape->vertices, shape->vertex_count * sizeof *vertices);
        memcpy(triangles + table.triangle_count, shape->triangles, shape->triangle_count * sizeof *triangles);
        table.vertex_count += shape->vertex_count;
        table.triangle_count += shape->triangle_count;
        table.hash = clast_pattern_shape_hash(table.hash, shape);
    }
    block->table = table;
}

clast_status clast_pattern_table_create(clast_context *context, const char *name, clast_pattern_shape *shapes,
                                        clast_pattern_table **table)
{
    clast_status status = check(context, name, shapes);
    if (status != CLAST_OK) {
        return status;
    }
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        clast_pattern_shape_order(&shapes[i]);
    }
    clast_pattern_shapes_mirror(shapes);
    size_t vertices = 0, triangles = 0; // at most PATTERN_COUNT * 128 each
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        vertices += shapes[i].vertex_count;
        triangles += shapes[i].triangle_count;
    }
    table_block *block = clast_allocate(context, 1, sizeof *block + (vertices + triangles) * sizeof *block->words);
    if (block == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    copy_shapes(block, shapes, block->words, block->words + vertices);
    *table = &block->table;
    return CLAST_OK;
}

void clast_pattern_table_free(clast_context *context, clast_pattern_table *table)
{
    clast_free(context, table); // the first member of its block
}
