// SPDX-License-Identifier: Apache-2.0
// STL files (3D Systems, 1989), binary and ascii: triangles without any order, each with three corners of its own. Equal
// corners become one vertex. Normals and colours are passed over: the triangles' own normals are what they say, and there are
// several ways of storing colours that exclude each other.
#include <math.h>
#include <string.h>

#include "clast/geometry.h"
#include "load/load.h"
#include "load/text.h"

enum {
    HEADER_SIZE = 80,
    COUNT_SIZE = 4,
    NORMAL_SIZE = 12,
    TRIANGLE_SIZE = 50, // a normal, three corners, two bytes that mean nothing
    CORNERS_BETWEEN_PROGRESS = 1 << 18,
};

typedef struct stl_reader {
    clast_context *context;
    const char *path;
    clast_bytes bytes;
    float *positions; // three for each corner, then for each vertex
    size_t position_capacity;
    size_t corner_count;
    uint32_t *indices;
} stl_reader;

static clast_status add_corner(stl_reader *reader, const float corner[3])
{
    size_t end = 3 * (reader->corner_count + 1);
    if (end >= CLAST_NONE) {
        return clast_fail(reader->context, CLAST_ERROR_LIMIT, "%s: more than %u corners of triangles", reader->path,
                          CLAST_NONE / 3);
    }
    clast_status status = CLAST_RESERVE(reader->context, reader->positions, reader->position_capacity, end);
    if (status == CLAST_OK) {
        memcpy(reader->positions + 3 * reader->corner_count++, corner, 3 * sizeof *corner);
    }
    if (status == CLAST_OK && reader->corner_count % CORNERS_BETWEEN_PROGRESS == 0) {
        status = clast_progress(reader->context, "load", reader->corner_count / 3 * TRIANGLE_SIZE, reader->bytes.size);
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- binary

// A float stored with its low byte first.
static float load_float(const unsigned char *at)
{
    uint32_t bits = clast_load_word(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool read_count(clast_bytes bytes, uint64_t *count)
{
    unsigned char stored[COUNT_SIZE];
    bool read = clast_bytes_read(bytes, HEADER_SIZE, stored, sizeof stored);
    *count = read ? clast_load_word(stored) : 0;
    return read;
}

// A binary file may begin with "solid" too: its length tells.
static bool is_binary(clast_bytes bytes)
{
    uint64_t count;
    return read_count(bytes, &count) &&
           (bytes.size == HEADER_SIZE + COUNT_SIZE + TRIANGLE_SIZE * count || !clast_bytes_begin_with(bytes, "solid"));
}

static clast_status read_binary(stl_reader *reader)
{
    uint64_t count;
    clast_bytes triangles;
    read_count(reader->bytes, &count);
    if (!clast_bytes_slice(reader->bytes, HEADER_SIZE + COUNT_SIZE, TRIANGLE_SIZE * count, &triangles)) {
        return clast_fail(reader->context, CLAST_ERROR_MALFORMED,
                          "%s: byte %d: %llu triangles: expected %llu bytes of them, the file has %llu", reader->path,
                          HEADER_SIZE, (unsigned long long)count, (unsigned long long)(TRIANGLE_SIZE * count),
                          (unsigned long long)(reader->bytes.size - HEADER_SIZE - COUNT_SIZE));
    }
    clast_status status = CLAST_RESERVE(reader->context, reader->positions, reader->position_capacity, 9 * count);
    for (uint64_t i = 0; status == CLAST_OK && i < 3 * count; i++) {
        const unsigned char *at = triangles.data + i / 3 * TRIANGLE_SIZE + NORMAL_SIZE * (1 + i % 3);
        const float corner[3] = {load_float(at), load_float(at + 4), load_float(at + 8)};
        if (!isfinite(corner[0]) || !isfinite(corner[1]) || !isfinite(corner[2])) {
            return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: triangle %llu: expected finite numbers",
                              reader->path, (unsigned long long)(i / 3));
        }
        status = add_corner(reader, corner);
    }
    return status;
}

// --------------------------------------------------------------------------------------------------------------- ascii

static clast_status malformed(const stl_reader *reader, const clast_text *text, const char *expected)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s: line %llu: expected %s", reader->path,
                      (unsigned long long)text->line, expected);
}

static bool read_corner(clast_text *text, float corner[3])
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        double value;
        if (!clast_next_number(text, &value) || !isfinite((float)value)) {
            return false;
        }
        corner[axis] = (float)value;
    }
    return true;
}

// Lines that matter are those of corners, and those that end a loop of them.
static clast_status read_ascii(stl_reader *reader)
{
    clast_text text = clast_text_of(reader->bytes);
    uint32_t corners = 0;
    clast_status status = CLAST_OK;
    for (; status == CLAST_OK && text.at < text.end; clast_next_line(&text)) {
        clast_word word = clast_next_word(&text);
        if (clast_word_resembles(word, "vertex")) {
            float corner[3];
            if (!read_corner(&text, corner)) {
                return malformed(reader, &text, "three finite numbers after \"vertex\"");
            }
            corners++;
            status = add_corner(reader, corner);
        } else if (clast_word_resembles(word, "endloop") || clast_word_resembles(word, "endfacet")) {
            if (corners != 3 && corners != 0) {
                return malformed(reader, &text, "three corners in a facet");
            }
            corners = 0;
        } else if (word.length != 0 && !clast_word_resembles(word, "solid") && !clast_word_resembles(word, "facet") &&
                   !clast_word_resembles(word, "outer") && !clast_word_resembles(word, "endsolid")) {
            return malformed(reader, &text, "solid, facet, outer loop, vertex, endloop, endfacet or endsolid");
        }
    }
    return status == CLAST_OK && corners != 0 ? malformed(reader, &text, "the end of a facet") : status;
}

// ----------------------------------------------------------------------------------------------------------- the scene

// Makes vertices of corners: each keeps its first one.
static clast_status weld(stl_reader *reader, size_t *vertex_count)
{
    reader->indices = clast_allocate(reader->context, reader->corner_count, sizeof *reader->indices);
    if (reader->indices == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint32_t *indices = reader->indices;
    clast_status status = clast_weld_positions(reader->context, reader->positions, reader->corner_count, indices,
                                               vertex_count);
    if (status != CLAST_OK) {
        return status;
    }
    size_t count = 0;
    for (size_t i = 0; i < reader->corner_count; i++) {
        if (indices[i] == i) { // the first of its kind: what comes later finds its number here
            memmove(reader->positions + 3 * count, reader->positions + 3 * i, 3 * sizeof *reader->positions);
            indices[i] = (uint32_t)count++;
        } else {
            indices[i] = indices[indices[i]];
        }
    }
    float *fewer = clast_reallocate(reader->context, reader->positions, 3 * count, sizeof *fewer);
    if (fewer == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    reader->positions = fewer;
    return CLAST_OK;
}

static clast_status add_mesh(stl_reader *reader, clast_scene *scene)
{
    if (reader->corner_count == 0) {
        clast_log(reader->context, CLAST_LOG_WARNING, "%s: no triangles: nothing of it is drawn", reader->path);
        return CLAST_OK;
    }
    size_t vertex_count;
    clast_status status = weld(reader, &vertex_count);
    if (status != CLAST_OK) {
        return status;
    }
    clast_mesh mesh = {
        .vertex_count = (uint32_t)vertex_count,
        .triangle_count = (uint32_t)(reader->corner_count / 3),
        .positions = reader->positions,
        .indices = reader->indices,
        .material = CLAST_NONE,
    };
    void *blocks[] = {reader->positions, reader->indices};
    reader->positions = NULL;
    reader->indices = NULL;
    uint32_t geometry, instance;
    status = clast_scene_adopt_mesh(scene, &mesh, blocks, sizeof blocks / sizeof blocks[0], NULL, &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(scene, geometry, NULL, NULL, &instance) : status;
}

clast_status clast_load_stl(clast_scene *scene, const char *path, clast_file_view *file)
{
    stl_reader reader = {.context = scene->context, .path = path, .bytes = {file->data, file->size}};
    clast_status status;
    if (is_binary(reader.bytes)) {
        status = read_binary(&reader);
    } else if (clast_bytes_begin_with(reader.bytes, "solid")) {
        status = read_ascii(&reader);
    } else {
        status = clast_fail(reader.context, CLAST_ERROR_MALFORMED,
                            "%s: expected \"solid\", or the %d bytes of a binary header", path,
                            HEADER_SIZE + COUNT_SIZE);
    }
    if (status == CLAST_OK) {
        status = add_mesh(&reader, scene);
    }
    clast_free(reader.context, reader.positions);
    clast_free(reader.context, reader.indices);
    return status;
}
