// SPDX-License-Identifier: Apache-2.0
// A user's table of patterns: lines of text, as docs/patterns.md has them.
#include "load/pattern_file.h"

#include <stdlib.h>

#include "base/file.h"
#include "load/text.h"

typedef struct pattern_reader {
    clast_context *context;
    const char *path;
    clast_text text;
    clast_pattern_shape *shapes; // by number; of those that were not read yet, factors are zero
    clast_pattern_shape *shape;  // the one that lines belong to
    uint32_t count;
} pattern_reader;

static clast_status malformed(const pattern_reader *reader, const char *expected)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s, line %llu: expected %s", reader->path,
                      (unsigned long long)reader->text.line, expected);
}

// Three whole numbers, and nothing after them.
static bool read_numbers(pattern_reader *reader, uint32_t most, uint32_t numbers[3])
{
    for (int i = 0; i < 3; i++) {
        double value;
        if (!clast_next_number(&reader->text, &value) || !(value >= 0.0 && value <= most)) {
            return false;
        }
        numbers[i] = (uint32_t)value;
        if (numbers[i] != value) {
            return false;
        }
    }
    return clast_line_is_over(&reader->text);
}

static clast_status read_pattern(pattern_reader *reader)
{
    uint32_t count[3];
    if (!read_numbers(reader, PATTERN_SEGMENTS, count) || count[2] < 1 || count[1] < count[2] || count[0] < count[1]) {
        return malformed(reader, "three counts from 11 to 1, none larger than the one before");
    }
    uint32_t factors = pattern_factors(count[0], count[1], count[2]);
    reader->shape = &reader->shapes[pattern_number(factors)];
    if (reader->shape->factors != 0) {
        return malformed(reader, "each pattern once");
    }
    clast_pattern_shape_begin(reader->shape, factors);
    reader->count++;
    return CLAST_OK;
}

static clast_status read_point(pattern_reader *reader)
{
    uint32_t weights[3];
    clast_pattern_shape *shape = reader->shape;
    if (shape->triangle_count != 0) {
        return malformed(reader, "a pattern's points before its triangles");
    }
    if (shape->vertex_count == PATTERN_VERTICES) {
        return malformed(reader, "at most 128 vertices");
    }
    if (!read_numbers(reader, WEIGHT_ONE, weights) || weights[0] + weights[1] + weights[2] != WEIGHT_ONE) {
        return malformed(reader, "three weights that add up to 32768");
    }
    shape->vertices[shape->vertex_count++] = weights_word((clast_weights){{weights[0], weights[1], weights[2]}});
    return CLAST_OK;
}

static clast_status read_triangle(pattern_reader *reader)
{
    uint32_t corners[3];
    clast_pattern_shape *shape = reader->shape;
    if (shape->triangle_count == PATTERN_TRIANGLES) {
        return malformed(reader, "at most 128 triangles");
    }
    if (!read_numbers(reader, shape->vertex_count - 1, corners)) {
        return malformed(reader, "three of the pattern's vertices, by their numbers");
    }
    shape->triangles[shape->triangle_count++] = corners[0] | corners[1] << 8 | corners[2] << 16;
    return CLAST_OK;
}

static clast_status read_line(pattern_reader *reader)
{
    if (clast_line_is_over(&reader->text)) {
        return CLAST_OK;
    }
    clast_word keyword = clast_next_word(&reader->text);
    if (clast_word_is(keyword, "pattern")) {
        return read_pattern(reader);
    }
    if (reader->shape != NULL && clast_word_is(keyword, "point")) {
        return read_point(reader);
    }
    if (reader->shape != NULL && clast_word_is(keyword, "triangle")) {
        return read_triangle(reader);
    }
    return malformed(reader, reader->shape != NULL ? "pattern, point or triangle" : "pattern");
}

static clast_status read_all(pattern_reader *reader)
{
    while (reader->text.at < reader->text.end) {
        clast_status status = read_line(reader);
        if (status != CLAST_OK) {
            return status;
        }
        clast_next_line(&reader->text);
    }
    if (reader->count != PATTERN_ORDERED) {
        return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: %u patterns, expected %u", reader->path,
                          reader->count, PATTERN_ORDERED);
    }
    return CLAST_OK;
}

clast_status clast_load_patterns(clast_context *context, const char *path, clast_pattern_table **table)
{
    clast_file_view file;
    clast_status status = clast_file_map(context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    pattern_reader reader = {.context = context, .path = path};
    reader.text = clast_text_of((clast_bytes){file.data, file.size});
    reader.shapes = clast_allocate_zeroed(context, PATTERN_COUNT, sizeof *reader.shapes);
    status = reader.shapes != NULL ? read_all(&reader) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        status = clast_pattern_table_create(context, path, reader.shapes, table);
    }
    clast_free(context, reader.shapes);
    clast_file_unmap(context, &file);
    return status;
}
