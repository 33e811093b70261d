// SPDX-License-Identifier: Apache-2.0
// Reads the lines of an OBJ file's pieces to the places that the survey gave them. Nothing relies on the file being as it was then:
// what has no place is an error.
#include <math.h>

#include "load/obj.h"
#include "load/text.h"

typedef struct obj_reader {
    clast_obj *obj;
    clast_obj_piece *piece;
    clast_text text;
    size_t positions, coordinates, normals; // read of the piece
    uint32_t faces, length_count;
    size_t span;       // that takes the next face, of all
    size_t span_faces; // read of it
    size_t corners;    // likewise
    char *name;        // of an object that no face has come after
} obj_reader;

static bool ends_with(obj_reader *reader, clast_status status, const char *what)
{
    reader->piece->error = (clast_obj_error){status, what, reader->text.line};
    return false;
}

static bool malformed(obj_reader *reader, const char *expected)
{
    return ends_with(reader, CLAST_ERROR_MALFORMED, expected);
}

static bool too_many(obj_reader *reader, const char *what)
{
    return ends_with(reader, CLAST_ERROR_LIMIT, what);
}

// Where the survey has seen another file.
static bool changed(obj_reader *reader)
{
    return ends_with(reader, CLAST_ERROR_FILE_READ, "the file has changed while it was read");
}

static bool memory_ran_out(obj_reader *reader)
{
    return ends_with(reader, CLAST_ERROR_OUT_OF_MEMORY, NULL);
}

// The numbers of the line, as floats; false where one is none, is not finite as a float, or there are more than `most`.
static bool read_numbers(obj_reader *reader, float *values, uint32_t most, uint32_t *count)
{
    *count = 0;
    while (!clast_line_is_over(&reader->text)) {
        double value;
        if (*count == most || !clast_next_number(&reader->text, &value) || !isfinite((float)value)) {
            return false;
        }
        values[(*count)++] = (float)value;
    }
    return true;
}

// ----------------------------------------------------------------------------------------------------------- vertices

// White where the file gives none.
static bool store_colour(obj_reader *reader, const float *colour)
{
    clast_obj_piece *piece = reader->piece;
    if (piece->colours == NULL) {
        piece->colours = clast_allocate(reader->obj->context, piece->position_count, sizeof *piece->colours);
        if (piece->colours == NULL) {
            return memory_ran_out(reader);
        }
        for (size_t i = 0; i < piece->position_count; i++) {
            piece->colours[i][0] = piece->colours[i][1] = piece->colours[i][2] = 1.0f;
        }
    }
    memcpy(piece->colours[reader->positions], colour, sizeof *piece->colours);
    return true;
}

// x y z, then nothing, a weight (for curves: ignored), a colour, or a colour and its alpha (ignored).
static bool read_position(obj_reader *reader)
{
    float values[7];
    uint32_t count;
    if (!read_numbers(reader, values, 7, &count) || count < 3 || count == 5) {
        return malformed(reader, "v with 3 finite numbers, then none, 1, 3 or 4");
    }
    size_t number = reader->piece->first_position + reader->positions;
    if (number >= CLAST_NONE) {
        return too_many(reader, "vertices");
    }
    if (reader->positions == reader->piece->position_count) {
        return changed(reader);
    }
    if (count >= 6 && !store_colour(reader, values + 3)) {
        return false;
    }
    memcpy(reader->obj->positions[number], values, sizeof *reader->obj->positions);
    reader->positions++;
    return true;
}

static bool read_coordinate(obj_reader *reader)
{
    float values[3] = {0.0f, 0.0f, 0.0f};
    uint32_t count;
    if (!read_numbers(reader, values, 3, &count) || count == 0) {
        return malformed(reader, "vt with 1 to 3 finite numbers");
    }
    size_t number = reader->piece->first_coordinate + reader->coordinates;
    if (number >= CLAST_NONE) {
        return too_many(reader, "texture coordinates");
    }
    if (reader->coordinates == reader->piece->coordinate_count) {
        return changed(reader);
    }
    float *to = reader->obj->coordinates[number];
    to[0] = values[0];
    to[1] = 1.0f - values[1]; // OBJ counts from the image's lower edge
    reader->coordinates++;
    return true;
}

static bool read_normal(obj_reader *reader)
{
    float values[3];
    uint32_t count;
    if (!read_numbers(reader, values, 3, &count) || count != 3) {
        return malformed(reader, "vn with 3 finite numbers");
    }
    size_t number = reader->piece->first_normal + reader->normals;
    if (number >= CLAST_NONE) {
        return too_many(reader, "normals");
    }
    if (reader->normals == reader->piece->normal_count) {
        return changed(reader);
    }
    double x = (double)values[0], y = (double)values[1], z = (double)values[2];
    double length = sqrt(x * x + y * y + z * z);
    double scale = length > 0.0 ? 1.0 / length : 0.0;
    float *to = reader->obj->normals[number];
    to[0] = (float)(x * scale);
    to[1] = (float)(y * scale);
    to[2] = (float)(z * scale);
    reader->normals++;
    bool is_zero = to[0] == 0.0f && to[1] == 0.0f && to[2] == 0.0f;
    reader->piece->has_zero_normal = reader->piece->has_zero_normal || is_zero;
    return true;
}

// -------------------------------------------------------------------------------------------------------------- faces

// One index of a corner: from 1, or backwards from -1, the newest. Positive ones may look ahead.
static bool read_index(obj_reader *reader, size_t count, uint32_t *index)
{
    int64_t value;
    if (!clast_parse_integer(reader->text.at, reader->text.end, &value, &reader->text.at)) {
        return false;
    }
    if (value < 0 ? (uint64_t)-value > count : value == 0 || value > CLAST_NONE) {
        return false;
    }
    *index = value < 0 ? (uint32_t)(count - (uint64_t)-value) : (uint32_t)(value - 1);
    return *index != CLAST_NONE;
}

static bool at_end_of_index(const obj_reader *reader)
{
    const char *at = reader->text.at;
    return at == reader->text.end || *at == ' ' || *at == '\t' || *at == '\n' || *at == '\r' || *at == '/' ||
           *at == '\\';
}

// p, p/t, p//n or p/t/n; an index may be left out after each slash.
static bool read_corner(obj_reader *reader, clast_obj_corner *corner)
{
    const clast_obj_piece *piece = reader->piece;
    clast_text *text = &reader->text;
    const size_t counts[3] = {piece->first_position + reader->positions, piece->first_coordinate + reader->coordinates,
                              piece->first_normal + reader->normals};
    uint32_t indices[3] = {CLAST_NONE, CLAST_NONE, CLAST_NONE};
    for (int i = 0; i < 3; i++) {
        if ((i == 0 || !at_end_of_index(reader)) && !read_index(reader, counts[i], &indices[i])) {
            return false;
        }
        if (!at_end_of_index(reader)) {
            return false;
        }
        if (text->at == text->end || *text->at != '/') {
            break;
        }
        if (i == 2) {
            return false;
        }
        text->at++;
    }
    *corner = (clast_obj_corner){indices[0], indices[1], indices[2]};
    return true;
}

// The span that takes the next face; null where there is none.
static clast_obj_span *span_of_face(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    size_t end = reader->piece->first_span + reader->piece->span_count;
    if (reader->span < end && reader->span_faces == obj->spans[reader->span].face_count) {
        reader->span++;
        reader->span_faces = reader->corners = 0;
    }
    return reader->span < end ? &obj->spans[reader->span] : NULL;
}

// Stores the next corner of a span; false where it has no place, or is not of the form that the survey saw.
static bool store_corner(obj_reader *reader, const clast_obj_span *span, size_t number, clast_obj_corner corner)
{
    const clast_obj_object *object = &reader->obj->objects[span->object];
    if (number >= span->corner_count) {
        return false;
    }
    size_t place = span->first_corner + number;
    object->positions[place] = corner.position;
    bool unlike = (object->form & CLAST_OBJ_UNLIKE) != 0;
    uint32_t coordinate = !unlike && (object->form & CLAST_OBJ_COORDINATES) != 0 ? corner.position : CLAST_NONE;
    uint32_t normal = !unlike && (object->form & CLAST_OBJ_NORMALS) != 0 ? corner.position : CLAST_NONE;
    if (object->coordinates != NULL) {
        coordinate = object->coordinates[place] = corner.coordinate;
    }
    if (object->normals != NULL) {
        normal = object->normals[place] = corner.normal;
    }
    return coordinate == corner.coordinate && normal == corner.normal;
}

static void check_corner(obj_reader *reader, clast_obj_corner corner, uint64_t line)
{
    const clast_obj *obj = reader->obj;
    const char *what = corner.position >= obj->position_count ? "vertices"
                       : corner.coordinate != CLAST_NONE && corner.coordinate >= obj->coordinate_count
                           ? "texture coordinates"
                       : corner.normal != CLAST_NONE && corner.normal >= obj->normal_count ? "normals"
                                                                                           : NULL;
    if (what != NULL && reader->piece->wild.what == NULL) {
        reader->piece->wild = (clast_obj_error){CLAST_ERROR_MALFORMED, what, line};
    }
}

// The lengths of a piece's faces are kept where those of a span differ.
static bool store_length(obj_reader *reader, const clast_obj_span *span, uint32_t length)
{
    clast_obj_piece *piece = reader->piece;
    if (span->face_corners != 0) {
        return span->face_corners == length || changed(reader);
    }
    if (piece->lengths == NULL) {
        piece->lengths = clast_allocate(reader->obj->context, piece->face_count, sizeof *piece->lengths);
    }
    if (piece->lengths == NULL) {
        return memory_ran_out(reader);
    }
    piece->lengths[reader->faces] = length;
    return true;
}

// The first two corners wait: a face of fewer than three has no place.
static bool read_face(obj_reader *reader)
{
    clast_obj_corner corner, waiting[2];
    clast_obj_span *span = span_of_face(reader);
    uint64_t line = reader->text.line;
    size_t count = 0;
    while (!clast_line_is_over(&reader->text)) {
        if (!read_corner(reader, &corner)) {
            return malformed(reader, "f with corners such as 1, 1/2, 1//3 or 1/2/3, counted from 1 or back from -1");
        }
        if (count < 2) {
            waiting[count++] = corner;
            continue;
        }
        if (span == NULL) {
            return reader->piece->first_face + reader->faces >= CLAST_NONE ? too_many(reader, "faces or corners")
                                                                           : changed(reader);
        }
        for (size_t i = count == 2 ? 0 : 2; i < 2; i++) {
            if (!store_corner(reader, span, reader->corners + i, waiting[i])) {
                return changed(reader);
            }
            check_corner(reader, waiting[i], line);
        }
        if (!store_corner(reader, span, reader->corners + count++, corner)) {
            return changed(reader);
        }
        check_corner(reader, corner, line);
    }
    if (count < 3) {
        reader->piece->short_faces++;
        return true;
    }
    if (reader->piece->first_face + reader->faces >= CLAST_NONE || count > CLAST_NONE) {
        return too_many(reader, "faces or corners");
    }
    if (!store_length(reader, span, (uint32_t)count)) {
        return false;
    }
    if (reader->span_faces == 0) {
        span->name = reader->name;
        reader->name = NULL;
    }
    reader->corners += count;
    reader->span_faces++;
    reader->faces++;
    return true;
}

// ----------------------------------------------------------------------------------------------------- names and state

char *clast_obj_copy_word(clast_context *context, clast_word word)
{
    char *copy = clast_allocate(context, word.length + 1, 1);
    if (copy != NULL) {
        memcpy(copy, word.begin, word.length);
        copy[word.length] = '\0';
    }
    return copy;
}

clast_status clast_obj_number_name(clast_context *context, clast_table *table, clast_obj_name **names, size_t *count,
                                   size_t *capacity, clast_word name, uint32_t *number)
{
    clast_status status = clast_table_reserve(context, table);
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t hash = clast_hash_text(name.begin, name.length);
    size_t place = hash;
    while ((*number = clast_table_next(table, hash, &place)) != CLAST_NONE) {
        if (clast_word_is(name, (*names)[*number].text)) {
            return CLAST_OK;
        }
    }
    status = CLAST_RESERVE(context, *names, *capacity, *count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    char *copy = clast_obj_copy_word(context, name);
    if (copy == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *number = (uint32_t)*count;
    clast_table_insert(table, hash, place, *number);
    (*names)[(*count)++] = (clast_obj_name){.text = copy};
    return CLAST_OK;
}

static bool begin_object(obj_reader *reader, clast_word name)
{
    clast_free(reader->obj->context, reader->name);
    reader->name = name.length > 0 ? clast_obj_copy_word(reader->obj->context, name) : NULL;
    return name.length == 0 || reader->name != NULL || memory_ran_out(reader);
}

// What holds from the next face on: each face has one run at most. Null where memory ran out.
static clast_obj_run *next_run(obj_reader *reader)
{
    clast_obj_piece *piece = reader->piece;
    if (piece->run_count == 0 || piece->runs[piece->run_count - 1].first_face != reader->faces) {
        if (CLAST_RESERVE(reader->obj->context, piece->runs, piece->run_capacity, piece->run_count + 1) != CLAST_OK) {
            memory_ran_out(reader);
            return NULL;
        }
        piece->runs[piece->run_count++] = (clast_obj_run){.first_face = reader->faces};
    }
    return &piece->runs[piece->run_count - 1];
}

static bool use_material(obj_reader *reader, clast_word name)
{
    clast_obj_piece *piece = reader->piece;
    clast_obj_run *run = next_run(reader);
    if (run == NULL) {
        return false;
    }
    run->has_material = true;
    return clast_obj_number_name(reader->obj->context, &piece->material_table, &piece->materials,
                                 &piece->material_count, &piece->material_capacity, name, &run->material) == CLAST_OK ||
           memory_ran_out(reader);
}

// "off" and 0 end smoothing; any other word is a group's name, a number as a rule.
static bool read_smoothing(obj_reader *reader)
{
    clast_word word = clast_next_word(&reader->text);
    int64_t group;
    const char *next;
    if (word.length == 0) {
        return malformed(reader, "s with a group's number or off");
    }
    clast_obj_run *run = next_run(reader);
    if (run == NULL) {
        return false;
    }
    run->has_smoothing = true;
    if (clast_word_is(word, "off")) {
        run->smoothing = 0;
    } else if (clast_parse_integer(word.begin, word.begin + word.length, &group, &next)) {
        run->smoothing = (uint32_t)group;
    } else {
        run->smoothing = clast_hash_text(word.begin, word.length) | 1u;
    }
    return true;
}

// Libraries are read later, in the order of the file.
static bool note_libraries(obj_reader *reader)
{
    clast_obj_piece *piece = reader->piece;
    clast_context *context = reader->obj->context;
    clast_word rest = clast_rest_of_line(&reader->text);
    if (rest.length == 0) {
        return malformed(reader, "mtllib with a file's name");
    }
    if (CLAST_RESERVE(context, piece->libraries, piece->library_capacity, piece->library_count + 1) != CLAST_OK) {
        return memory_ran_out(reader);
    }
    char *names = clast_obj_copy_word(context, rest);
    if (names == NULL) {
        return memory_ran_out(reader);
    }
    piece->libraries[piece->library_count++] = (clast_obj_name){.text = names, .line = reader->text.line};
    return true;
}

// -------------------------------------------------------------------------------------------------------------- lines

static bool is_keyword(clast_word word)
{
    for (size_t i = 0; i < word.length; i++) {
        char c = word.begin[i];
        bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
        bool later = (c >= '0' && c <= '9') || c == '-' || c == '.' || c == ':';
        if (!letter && (i == 0 || !later)) {
            return false;
        }
    }
    return true;
}

static bool read_line(obj_reader *reader)
{
    if (clast_line_is_over(&reader->text)) {
        return true;
    }
    clast_word keyword = clast_next_word(&reader->text);
    if (clast_word_is(keyword, "v")) {
        return read_position(reader);
    }
    if (clast_word_is(keyword, "f") || clast_word_is(keyword, "fo")) { // fo: the old name of f
        return read_face(reader);
    }
    if (clast_word_is(keyword, "vt")) {
        return read_coordinate(reader);
    }
    if (clast_word_is(keyword, "vn")) {
        return read_normal(reader);
    }
    if (clast_word_is(keyword, "s")) {
        return read_smoothing(reader);
    }
    if (clast_word_is(keyword, "o")) {
        return begin_object(reader, clast_rest_of_line(&reader->text));
    }
    if (clast_word_is(keyword, "usemtl")) {
        return use_material(reader, clast_rest_of_line(&reader->text));
    }
    if (clast_word_is(keyword, "mtllib")) {
        return note_libraries(reader);
    }
    return is_keyword(keyword) || malformed(reader, "a keyword such as v or f");
}

static bool is_whole(const obj_reader *reader)
{
    const clast_obj_piece *piece = reader->piece;
    return reader->positions == piece->position_count && reader->coordinates == piece->coordinate_count &&
           reader->normals == piece->normal_count && reader->faces == piece->face_count;
}

static void read_piece(clast_obj *obj, size_t number, uint32_t worker)
{
    clast_obj_piece *piece = &obj->pieces[number];
    obj_reader reader = {.obj = obj, .piece = piece, .span = piece->first_span};
    clast_status status = clast_obj_look_at(obj, number, worker, &reader.text);
    if (status != CLAST_OK) {
        piece->error = (clast_obj_error){status, NULL, 1};
        return;
    }
    bool is_read = next_run(&reader) != NULL; // what holds at the beginning is known later
    while (is_read && reader.text.at < reader.text.end) {
        is_read = read_line(&reader);
        if (is_read) {
            clast_next_line(&reader.text);
        }
    }
    if (is_read && !is_whole(&reader)) {
        changed(&reader);
    }
    piece->line_count = reader.text.line - 1;
    piece->last_name = reader.name;
}

static void read_pieces(void *data, size_t begin, size_t end, uint32_t worker)
{
    clast_obj_walk *walk = data;
    for (size_t i = begin; i < end; i++) {
        read_piece(walk->obj, walk->first + i, worker);
    }
}

clast_status clast_obj_read(clast_obj *obj)
{
    return clast_obj_walk_pieces(obj, read_pieces, 1);
}
