// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: polygons, with texture coordinates, normals, vertex colours, smoothing groups, objects and materials.
// What else the format has (curves, points, lines, groups, subdivision tags) is passed over. A file without normals has
// flat triangles, but for faces in a smoothing group (`s`), whose normals are averaged by area within the group.
#include "load/obj.h"

#include <math.h>

#include "load/text.h"

enum { LINES_BETWEEN_PROGRESS = 1 << 16 };

typedef struct obj_reader {
    clast_obj *obj;
    clast_text text;
    const char *begin;
    uint32_t material, smoothing;
    uint64_t short_faces; // of fewer than three corners
} obj_reader;

static clast_status malformed(const obj_reader *reader, const char *expected)
{
    return clast_fail(reader->obj->context, CLAST_ERROR_MALFORMED, "%s, line %llu: expected %s", reader->obj->path,
                      (unsigned long long)reader->text.line, expected);
}

static clast_status too_many(const obj_reader *reader, const char *what)
{
    return clast_fail(reader->obj->context, CLAST_ERROR_LIMIT, "%s, line %llu: more %s than a file may have (%u)",
                      reader->obj->path, (unsigned long long)reader->text.line, what, CLAST_NONE);
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

// From the first coloured vertex on, all have colours: white where the file gives none.
static clast_status add_colour(obj_reader *reader, const float *colour)
{
    clast_obj *obj = reader->obj;
    if (colour == NULL && obj->colour_count == 0) {
        return CLAST_OK;
    }
    clast_status status = CLAST_RESERVE(obj->context, obj->colours, obj->colour_capacity, obj->position_count);
    if (status != CLAST_OK) {
        return status;
    }
    for (; obj->colour_count < obj->position_count; obj->colour_count++) {
        bool given = colour != NULL && obj->colour_count + 1 == obj->position_count;
        for (int c = 0; c < 3; c++) {
            obj->colours[obj->colour_count][c] = given ? colour[c] : 1.0f;
        }
    }
    return CLAST_OK;
}

// x y z, then nothing, a weight (for curves: ignored), a colour, or a colour and its alpha (ignored).
static clast_status read_position(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    float values[7];
    uint32_t count;
    if (!read_numbers(reader, values, 7, &count) || count < 3 || count == 5) {
        return malformed(reader, "v with 3 finite numbers, then none, 1, 3 or 4");
    }
    if (obj->position_count == CLAST_NONE) {
        return too_many(reader, "vertices");
    }
    clast_status status = CLAST_RESERVE(obj->context, obj->positions, obj->position_capacity, obj->position_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    memcpy(obj->positions[obj->position_count++], values, sizeof *obj->positions);
    return add_colour(reader, count >= 6 ? values + 3 : NULL);
}

static clast_status read_coordinate(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    float values[3] = {0.0f, 0.0f, 0.0f};
    uint32_t count;
    if (!read_numbers(reader, values, 3, &count) || count == 0) {
        return malformed(reader, "vt with 1 to 3 finite numbers");
    }
    if (obj->coordinate_count == CLAST_NONE) {
        return too_many(reader, "texture coordinates");
    }
    clast_status status = CLAST_RESERVE(obj->context, obj->coordinates, obj->coordinate_capacity,
                                        obj->coordinate_count + 1);
    if (status == CLAST_OK) {
        float *to = obj->coordinates[obj->coordinate_count++];
        to[0] = values[0];
        to[1] = 1.0f - values[1]; // OBJ counts from the image's lower edge
    }
    return status;
}

static clast_status read_normal(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    float values[3];
    uint32_t count;
    if (!read_numbers(reader, values, 3, &count) || count != 3) {
        return malformed(reader, "vn with 3 finite numbers");
    }
    if (obj->normal_count == CLAST_NONE) {
        return too_many(reader, "normals");
    }
    clast_status status = CLAST_RESERVE(obj->context, obj->normals, obj->normal_capacity, obj->normal_count + 1);
    if (status == CLAST_OK) {
        double x = (double)values[0], y = (double)values[1], z = (double)values[2];
        double length = sqrt(x * x + y * y + z * z);
        double scale = length > 0.0 ? 1.0 / length : 0.0;
        float *to = obj->normals[obj->normal_count++];
        to[0] = (float)(x * scale);
        to[1] = (float)(y * scale);
        to[2] = (float)(z * scale);
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- faces

// One index of a corner: from 1, or backwards from -1, the newest. Positive ones are checked against the lists when the
// whole file is read, as they may look ahead.
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
    const clast_obj *obj = reader->obj;
    clast_text *text = &reader->text;
    const size_t counts[3] = {obj->position_count, obj->coordinate_count, obj->normal_count};
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

// Whether a corner's indices are as those of all before it; the first says how these are.
static bool is_alike(clast_obj *obj, clast_obj_corner corner)
{
    if (obj->corner_count == 0) {
        obj->has_alike_coordinates = corner.coordinate != CLAST_NONE;
        obj->has_alike_normals = corner.normal != CLAST_NONE;
    }
    return corner.coordinate == (obj->has_alike_coordinates ? corner.position : CLAST_NONE) &&
           corner.normal == (obj->has_alike_normals ? corner.position : CLAST_NONE);
}

// From now on corners are kept whole.
static clast_status unfold_corners(clast_obj *obj)
{
    clast_obj_corner *corners = NULL;
    size_t capacity = 0;
    clast_status status = CLAST_RESERVE(obj->context, corners, capacity, obj->corner_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < obj->corner_count; i++) {
        corners[i] = clast_obj_corner_at(obj, i);
    }
    clast_free(obj->context, obj->alike_corners);
    obj->alike_corners = NULL;
    obj->corners = corners;
    obj->corner_capacity = capacity;
    return CLAST_OK;
}

static clast_status add_corner(clast_obj *obj, clast_obj_corner corner)
{
    if (obj->corners == NULL && is_alike(obj, corner)) {
        clast_status status = CLAST_RESERVE(obj->context, obj->alike_corners, obj->corner_capacity,
                                            obj->corner_count + 1);
        if (status == CLAST_OK) {
            obj->alike_corners[obj->corner_count++] = corner.position;
        }
        return status;
    }
    clast_status status = obj->corners == NULL
                              ? unfold_corners(obj)
                              : CLAST_RESERVE(obj->context, obj->corners, obj->corner_capacity, obj->corner_count + 1);
    if (status == CLAST_OK) {
        obj->corners[obj->corner_count++] = corner;
    }
    return status;
}

static clast_status read_corners(obj_reader *reader)
{
    while (!clast_line_is_over(&reader->text)) {
        clast_obj_corner corner;
        if (!read_corner(reader, &corner)) {
            return malformed(reader, "f with corners such as 1, 1/2, 1//3 or 1/2/3, counted from 1 or back from -1");
        }
        clast_status status = add_corner(reader->obj, corner);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

static clast_status read_face(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    clast_obj_face face = {
        .first_corner = obj->corner_count,
        .line = reader->text.line,
        .material = reader->material,
        .smoothing = reader->smoothing,
    };
    clast_status status = read_corners(reader);
    if (status != CLAST_OK) {
        return status;
    }
    if (obj->corner_count - face.first_corner < 3) {
        reader->short_faces++;
        obj->corner_count = face.first_corner;
        return CLAST_OK;
    }
    if (obj->face_count == CLAST_NONE || obj->corner_count - face.first_corner > CLAST_NONE) {
        return too_many(reader, "faces or corners");
    }
    status = CLAST_RESERVE(obj->context, obj->faces, obj->face_capacity, obj->face_count + 1);
    if (status == CLAST_OK) {
        obj->faces[obj->face_count++] = face;
    }
    return status;
}

// ----------------------------------------------------------------------------------------------------- names and state

static char *copy_word(clast_context *context, clast_word word)
{
    char *copy = clast_allocate(context, word.length + 1, 1);
    if (copy != NULL) {
        memcpy(copy, word.begin, word.length);
        copy[word.length] = '\0';
    }
    return copy;
}

static clast_status begin_object(obj_reader *reader, clast_word name)
{
    clast_obj *obj = reader->obj;
    clast_status status = CLAST_RESERVE(obj->context, obj->objects, obj->object_capacity, obj->object_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    char *copy = NULL;
    if (name.length > 0) {
        copy = copy_word(obj->context, name);
        if (copy == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    // An object without faces makes room for the next.
    if (obj->object_count > 0 && obj->objects[obj->object_count - 1].first_face == obj->face_count) {
        clast_free(obj->context, obj->objects[--obj->object_count].name);
    }
    obj->objects[obj->object_count++] = (clast_obj_object){copy, obj->face_count};
    return CLAST_OK;
}

static clast_status use_material(obj_reader *reader, clast_word name)
{
    clast_obj *obj = reader->obj;
    clast_status status = clast_table_reserve(obj->context, &obj->material_table);
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t hash = clast_hash_text(name.begin, name.length);
    size_t place = hash;
    uint32_t number;
    while ((number = clast_table_next(&obj->material_table, hash, &place)) != CLAST_NONE) {
        if (clast_word_is(name, obj->materials[number].name)) {
            reader->material = number;
            return CLAST_OK;
        }
    }
    status = CLAST_RESERVE(obj->context, obj->materials, obj->material_capacity, obj->material_count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    char *copy = copy_word(obj->context, name);
    if (copy == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    reader->material = (uint32_t)obj->material_count;
    clast_table_insert(&obj->material_table, hash, place, reader->material);
    obj->materials[obj->material_count++] = (clast_obj_material){copy, 0};
    return CLAST_OK;
}

// "off" and 0 end smoothing; any other word is a group's name, a number as a rule.
static clast_status read_smoothing(obj_reader *reader)
{
    clast_word word = clast_next_word(&reader->text);
    int64_t group;
    const char *next;
    if (word.length == 0) {
        return malformed(reader, "s with a group's number or off");
    }
    if (clast_word_is(word, "off")) {
        reader->smoothing = 0;
    } else if (clast_parse_integer(word.begin, word.begin + word.length, &group, &next)) {
        reader->smoothing = (uint32_t)group;
    } else {
        reader->smoothing = clast_hash_text(word.begin, word.length) | 1u;
    }
    return CLAST_OK;
}

// ---------------------------------------------------------------------------------------------------------- libraries

static clast_status load_library(obj_reader *reader, const char *name)
{
    clast_obj *obj = reader->obj;
    char *path = clast_path_beside(obj->context, obj->path, name);
    if (path == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_mtl_load(&obj->library, path);
    clast_free(obj->context, path);
    return status;
}

static bool is_missing(clast_status status)
{
    return status == CLAST_ERROR_FILE_NOT_FOUND || status == CLAST_ERROR_FILE_READ;
}

static void warn_of_library(const obj_reader *reader, const char *name)
{
    clast_log(reader->obj->context, CLAST_LOG_WARNING,
              "%s, line %llu: the material library %s is missing: its materials are plain", reader->obj->path,
              (unsigned long long)reader->text.line, name);
}

// The next name of a list of names parted by blanks, where "\ " is a blank within a name. Writes over `at`.
static char *next_name(char **at)
{
    char *from = *at + strspn(*at, " \t");
    char *name = from;
    char *to = from;
    for (; *from != '\0' && *from != ' ' && *from != '\t'; from++) {
        from += from[0] == '\\' && from[1] == ' ';
        *to++ = *from;
    }
    *at = *from != '\0' ? from + 1 : from;
    *to = '\0';
    return name;
}

// The line is one name, if a file has that name; else a list of names.
static clast_status read_libraries(obj_reader *reader)
{
    clast_obj *obj = reader->obj;
    clast_word rest = clast_rest_of_line(&reader->text);
    if (rest.length == 0) {
        return malformed(reader, "mtllib with a file's name");
    }
    char *names = copy_word(obj->context, rest);
    if (names == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = load_library(reader, names);
    if (is_missing(status) && strpbrk(names, " \t") == NULL) {
        warn_of_library(reader, names);
        status = CLAST_OK;
    }
    char *at = names;
    for (bool several = is_missing(status); several;) {
        char *name = next_name(&at);
        if (name[0] == '\0') {
            status = CLAST_OK;
            break;
        }
        status = load_library(reader, name);
        if (is_missing(status)) {
            warn_of_library(reader, name);
        } else if (status != CLAST_OK) {
            break;
        }
    }
    clast_free(obj->context, names);
    return status;
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

static clast_status read_line(obj_reader *reader)
{
    if (clast_line_is_over(&reader->text)) {
        return CLAST_OK;
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
        return read_libraries(reader);
    }
    return is_keyword(keyword) ? CLAST_OK : malformed(reader, "a keyword such as v or f");
}

static clast_status read_lines(obj_reader *reader)
{
    uint64_t count = 0;
    while (reader->text.at < reader->text.end) {
        clast_status status = read_line(reader);
        if (status == CLAST_OK && ++count % LINES_BETWEEN_PROGRESS == 0) {
            status = clast_progress(reader->obj->context, "load", (uint64_t)(reader->text.at - reader->begin),
                                    (uint64_t)(reader->text.end - reader->begin));
        }
        if (status != CLAST_OK) {
            return status;
        }
        clast_next_line(&reader->text);
    }
    return CLAST_OK;
}

static clast_status check_corners(const clast_obj *obj)
{
    for (size_t f = 0; f < obj->face_count; f++) {
        uint64_t end = f + 1 < obj->face_count ? obj->faces[f + 1].first_corner : obj->corner_count;
        for (uint64_t i = obj->faces[f].first_corner; i < end; i++) {
            clast_obj_corner corner = clast_obj_corner_at(obj, i);
            const char *what = corner.position >= obj->position_count ? "vertices"
                               : corner.coordinate != CLAST_NONE && corner.coordinate >= obj->coordinate_count
                                   ? "texture coordinates"
                               : corner.normal != CLAST_NONE && corner.normal >= obj->normal_count ? "normals"
                                                                                                   : NULL;
            if (what != NULL) {
                return clast_fail(obj->context, CLAST_ERROR_MALFORMED,
                                  "%s, line %llu: a corner's index is beyond the file's %s", obj->path,
                                  (unsigned long long)obj->faces[f].line, what);
            }
        }
    }
    return CLAST_OK;
}

static void resolve_materials(clast_obj *obj)
{
    for (size_t i = 0; i < obj->material_count; i++) {
        uint32_t number = clast_mtl_find(&obj->library, obj->materials[i].name);
        if (number == CLAST_NONE) {
            clast_log(obj->context, CLAST_LOG_WARNING, "%s: no library has the material %s: it is plain", obj->path,
                      obj->materials[i].name);
        }
        obj->materials[i].number = number != CLAST_NONE ? number : 0;
    }
}

static void obj_free(clast_obj *obj)
{
    clast_context *context = obj->context;
    for (size_t i = 0; i < obj->object_count; i++) {
        clast_free(context, obj->objects[i].name);
    }
    for (size_t i = 0; i < obj->material_count; i++) {
        clast_free(context, obj->materials[i].name);
    }
    clast_free(context, obj->positions);
    clast_free(context, obj->colours);
    clast_free(context, obj->coordinates);
    clast_free(context, obj->normals);
    clast_free(context, obj->corners);
    clast_free(context, obj->alike_corners);
    clast_free(context, obj->faces);
    clast_free(context, obj->objects);
    clast_free(context, obj->materials);
    clast_table_free(context, &obj->material_table);
    clast_mtl_free(&obj->library);
}

clast_status clast_load_obj(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_obj obj = {.scene = scene, .context = scene->context, .path = path, .library = {.scene = scene}};
    clast_text text = clast_text_of((clast_bytes){file->data, file->size});
    obj_reader reader = {.obj = &obj, .text = text, .begin = text.at, .material = CLAST_NONE};
    clast_status status = begin_object(&reader, (clast_word){NULL, 0});
    if (status == CLAST_OK) {
        status = read_lines(&reader);
    }
    if (status == CLAST_OK) {
        status = check_corners(&obj);
    }
    if (status == CLAST_OK) {
        if (reader.short_faces > 0) {
            clast_log(obj.context, CLAST_LOG_WARNING, "%s: %llu faces have fewer than three corners and are left out",
                      path, (unsigned long long)reader.short_faces);
        }
        resolve_materials(&obj);
        status = clast_obj_add_meshes(&obj);
    }
    obj_free(&obj);
    return status;
}
