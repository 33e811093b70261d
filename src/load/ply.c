// SPDX-License-Identifier: Apache-2.0
// Stanford PLY: vertices (x y z; nx ny nz; red green blue alpha; s t, u v or texture_u texture_v), polygons and
// triangle strips, in text and both binary orders; all else is passed over. (G. Turk, The PLY Polygon File Format,
// 1994.)
#include "load/ply.h"

#include <math.h>

#include "load/load.h"
#include "load/polygon.h"
#include "shared/texture_filter.h"

enum { ITEMS_BETWEEN_PROGRESS = 1 << 16 };

static const struct {
    const char *name;
    clast_ply_role role;
} role_names[] = {
    {"x", CLAST_PLY_X},
    {"y", CLAST_PLY_Y},
    {"z", CLAST_PLY_Z},
    {"nx", CLAST_PLY_NX},
    {"ny", CLAST_PLY_NY},
    {"nz", CLAST_PLY_NZ},
    {"s", CLAST_PLY_U},
    {"t", CLAST_PLY_V},
    {"u", CLAST_PLY_U},
    {"v", CLAST_PLY_V},
    {"texture_u", CLAST_PLY_U},
    {"texture_v", CLAST_PLY_V},
    {"red", CLAST_PLY_RED},
    {"green", CLAST_PLY_GREEN},
    {"blue", CLAST_PLY_BLUE},
    {"alpha", CLAST_PLY_ALPHA},
    {"r", CLAST_PLY_RED},
    {"g", CLAST_PLY_GREEN},
    {"b", CLAST_PLY_BLUE},
    {"a", CLAST_PLY_ALPHA},
    {"diffuse_red", CLAST_PLY_RED},
    {"diffuse_green", CLAST_PLY_GREEN},
    {"diffuse_blue", CLAST_PLY_BLUE},
};

static clast_status malformed(const clast_ply_reader *reader, const char *expected)
{
    if (reader->header.encoding == CLAST_PLY_ASCII) {
        return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s, line %llu: expected %s", reader->path,
                          (unsigned long long)reader->text.line, expected);
    }
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s, %.*s %llu (byte %llu): expected %s", reader->path,
                      (int)(reader->element->name.length < 64 ? reader->element->name.length : 64),
                      reader->element->name.begin, (unsigned long long)reader->item,
                      (unsigned long long)reader->position, expected);
}

// ------------------------------------------------------------------------------------------------------------- values

clast_status clast_ply_fail(const clast_ply_reader *reader, clast_status status)
{
    return status == CLAST_ERROR_FILE_READ
               ? clast_fail(reader->context, status, "%s: %s", reader->path, clast_status_text(status))
               : status;
}

// Has all of the file in memory, for what is not read piece by piece.
static clast_status need_bytes(clast_ply_reader *reader)
{
    if (reader->bytes.data != NULL) {
        return CLAST_OK;
    }
    clast_status status = clast_file_map(reader->context, reader->path, &reader->whole);
    if (status == CLAST_OK && reader->whole.size != reader->bytes.size) {
        status = clast_fail(reader->context, CLAST_ERROR_FILE_READ, "%s: the file has changed while it was read",
                            reader->path);
    }
    reader->bytes.data = status == CLAST_OK ? reader->whole.data : NULL;
    return status;
}

double clast_ply_value(const unsigned char *bytes, clast_ply_type type, bool big_endian)
{
    uint64_t word = 0;
    size_t size = clast_ply_type_size(type);
    for (size_t i = 0; i < size; i++) {
        word |= (uint64_t)bytes[big_endian ? size - 1 - i : i] << 8 * i;
    }
    uint32_t half = (uint32_t)word;
    float single;
    double number;
    memcpy(&single, &half, sizeof single);
    memcpy(&number, &word, sizeof number);
    switch (type) {
    case CLAST_PLY_CHAR: return (double)(int8_t)(uint8_t)word;
    case CLAST_PLY_SHORT: return (double)(int16_t)(uint16_t)word;
    case CLAST_PLY_INT: return (double)(int32_t)half;
    case CLAST_PLY_FLOAT: return (double)single;
    case CLAST_PLY_DOUBLE: return number;
    default: return (double)half;
    }
}

// The next value; false where the file ends or none is there.
static bool next_value(clast_ply_reader *reader, clast_ply_type type, double *value)
{
    if (reader->header.encoding != CLAST_PLY_ASCII) {
        unsigned char bytes[8];
        if (!clast_bytes_read(reader->bytes, reader->position, bytes, clast_ply_type_size(type))) {
            return false;
        }
        reader->position += clast_ply_type_size(type);
        *value = clast_ply_value(bytes, type, reader->header.encoding == CLAST_PLY_BIG_ENDIAN);
        return true;
    }
    clast_text *text = &reader->text;
    while (text->at < text->end &&
           (*text->at == ' ' || *text->at == '\t' || clast_line_end(text->at, text->end) != 0)) {
        size_t ended = clast_line_end(text->at, text->end);
        text->at += ended != 0 ? ended : 1;
        text->line += ended != 0;
    }
    return clast_next_number(text, value);
}

// The length of a list, bounded by what the file can hold.
static clast_status next_length(clast_ply_reader *reader, const clast_ply_property *property, uint32_t *length)
{
    double value;
    if (!next_value(reader, property->count_type, &value)) {
        return malformed(reader, "a list's length");
    }
    bool is_text = reader->header.encoding == CLAST_PLY_ASCII;
    uint64_t left = is_text ? (uint64_t)(reader->text.end - reader->text.at) : reader->bytes.size - reader->position;
    uint64_t most = is_text ? left / 2 : left / clast_ply_type_size(property->type);
    if (!(value >= 0.0) || value != floor(value) || value > (double)most || value >= (double)CLAST_NONE) {
        return malformed(reader, "a list's length that the file has room for");
    }
    *length = (uint32_t)value;
    return CLAST_OK;
}

static clast_status skip_property(clast_ply_reader *reader, const clast_ply_property *property)
{
    uint32_t length = 1;
    clast_status status = property->is_list ? next_length(reader, property, &length) : CLAST_OK;
    if (status == CLAST_OK && reader->header.encoding != CLAST_PLY_ASCII) {
        uint64_t size = (uint64_t)length * clast_ply_type_size(property->type);
        if (!clast_range_fits(reader->position, size, reader->bytes.size)) {
            return malformed(reader, "more data");
        }
        reader->position += size;
        return CLAST_OK;
    }
    double value;
    for (uint32_t i = 0; status == CLAST_OK && i < length; i++) {
        status = next_value(reader, property->type, &value) ? CLAST_OK : malformed(reader, "a number");
    }
    return status;
}

static const clast_ply_property *properties_of(const clast_ply_reader *reader)
{
    return reader->header.properties + reader->element->first_property;
}

static clast_status note_progress(clast_ply_reader *reader)
{
    if (reader->item % ITEMS_BETWEEN_PROGRESS != 0) {
        return CLAST_OK;
    }
    bool is_text = reader->header.encoding == CLAST_PLY_ASCII;
    uint64_t done = is_text ? (uint64_t)(reader->text.at - (const char *)reader->bytes.data) : reader->position;
    return clast_progress(reader->context, "load", done, reader->bytes.size);
}

// ----------------------------------------------------------------------------------------------------------- vertices

double clast_ply_colour_scale(clast_ply_type type)
{
    switch (type) {
    case CLAST_PLY_FLOAT:
    case CLAST_PLY_DOUBLE: return 1.0;
    case CLAST_PLY_CHAR:
    case CLAST_PLY_UCHAR: return 255.0;
    case CLAST_PLY_SHORT:
    case CLAST_PLY_USHORT: return 65535.0;
    default: return 4294967295.0;
    }
}

static clast_ply_role role_of(const clast_ply_property *property)
{
    for (size_t i = 0; !property->is_list && i < sizeof role_names / sizeof role_names[0]; i++) {
        if (clast_word_is(property->name, role_names[i].name)) {
            return role_names[i].role;
        }
    }
    return CLAST_PLY_NO_ROLE;
}

// The vertex's arrays, as its properties ask for them.
static clast_status allocate_vertices(clast_ply_reader *reader, const bool present[CLAST_PLY_ROLE_COUNT])
{
    clast_context *context = reader->context;
    size_t count = reader->vertex_count;
    if (!present[CLAST_PLY_X] || !present[CLAST_PLY_Y] || !present[CLAST_PLY_Z]) {
        return malformed(reader, "vertices with x, y and z");
    }
    bool whole = (reader->positions = clast_allocate(context, count, sizeof *reader->positions)) != NULL;
    if (present[CLAST_PLY_NX] && present[CLAST_PLY_NY] && present[CLAST_PLY_NZ]) {
        whole = whole && (reader->normals = clast_allocate(context, count, sizeof *reader->normals)) != NULL;
    }
    if (present[CLAST_PLY_U] && present[CLAST_PLY_V]) {
        whole = whole && (reader->coordinates = clast_allocate(context, count, sizeof *reader->coordinates)) != NULL;
    }
    if (present[CLAST_PLY_RED] && present[CLAST_PLY_GREEN] && present[CLAST_PLY_BLUE]) {
        whole = whole && (reader->colours = clast_allocate(context, count, sizeof *reader->colours)) != NULL;
    }
    return whole ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

bool clast_ply_store_vertex(const clast_ply_reader *reader, uint64_t i, const double values[CLAST_PLY_ROLE_COUNT])
{
    bool finite = true;
    for (int c = 0; c < 3; c++) {
        reader->positions[i][c] = (float)values[CLAST_PLY_X + c];
        finite = finite && isfinite(reader->positions[i][c]);
    }
    if (reader->normals != NULL) {
        double x = values[CLAST_PLY_NX], y = values[CLAST_PLY_NY], z = values[CLAST_PLY_NZ];
        double length = sqrt(x * x + y * y + z * z);
        bool sound = length > 0.0 && isfinite(length); // what is not gets a computed one later
        for (int c = 0; c < 3; c++) {
            reader->normals[i][c] = sound ? (float)(values[CLAST_PLY_NX + c] / length) : 0.0f;
        }
    }
    if (reader->coordinates != NULL) {
        reader->coordinates[i][0] = (float)values[CLAST_PLY_U];
        reader->coordinates[i][1] = (float)(1.0 - values[CLAST_PLY_V]); // PLY counts from the image's lower edge
        finite = finite && isfinite(reader->coordinates[i][0]) && isfinite(reader->coordinates[i][1]);
    }
    if (reader->colours != NULL) {
        for (int c = 0; c < 3; c++) { // vertex colours are those of a display
            reader->colours[i][c] = srgb_to_linear((float)values[CLAST_PLY_RED + c]);
            finite = finite && isfinite(reader->colours[i][c]);
        }
        reader->colours[i][3] = (float)values[CLAST_PLY_ALPHA];
        finite = finite && isfinite(reader->colours[i][3]);
    }
    return finite;
}

static clast_status read_vertex(clast_ply_reader *reader, const clast_ply_role *roles)
{
    const clast_ply_property *properties = properties_of(reader);
    double values[CLAST_PLY_ROLE_COUNT + 1] = {[CLAST_PLY_ALPHA] = 1.0};
    for (size_t i = 0; i < reader->element->property_count; i++) {
        if (roles[i] == CLAST_PLY_NO_ROLE) {
            clast_status status = skip_property(reader, &properties[i]);
            if (status != CLAST_OK) {
                return status;
            }
            continue;
        }
        if (!next_value(reader, properties[i].type, &values[roles[i]])) {
            return malformed(reader, "a number");
        }
        if (roles[i] >= CLAST_PLY_RED) {
            values[roles[i]] /= clast_ply_colour_scale(properties[i].type);
        }
    }
    return clast_ply_store_vertex(reader, reader->item, values) ? CLAST_OK : malformed(reader, "finite numbers");
}

static clast_status read_vertices(clast_ply_reader *reader)
{
    const clast_ply_element *element = reader->element;
    if (reader->has_vertices) {
        return malformed(reader, "one element of vertices");
    }
    if (element->count >= CLAST_NONE) {
        return clast_fail(reader->context, CLAST_ERROR_LIMIT, "%s: %llu vertices: at most %u are read", reader->path,
                          (unsigned long long)element->count, CLAST_NONE - 1);
    }
    reader->has_vertices = true;
    reader->vertex_count = (uint32_t)element->count;
    clast_ply_role *roles = clast_allocate(reader->context, element->property_count, sizeof *roles);
    if (roles == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    bool present[CLAST_PLY_ROLE_COUNT + 1] = {false};
    for (size_t i = 0; i < element->property_count; i++) {
        roles[i] = role_of(&properties_of(reader)[i]);
        present[roles[i]] = true;
    }
    clast_status status = allocate_vertices(reader, present);
    if (status == CLAST_OK) {
        status = clast_ply_read_many_vertices(reader, roles);
    }
    if (status == CLAST_OK && reader->item < element->count) {
        status = need_bytes(reader);
    }
    for (; status == CLAST_OK && reader->item < element->count; reader->item++) {
        status = read_vertex(reader, roles);
        if (status == CLAST_OK) {
            status = note_progress(reader);
        }
    }
    clast_free(reader->context, roles);
    return status;
}

// -------------------------------------------------------------------------------------------------------------- faces

// Reads a list of vertices into reader->face. `restart`: -1 is allowed and becomes CLAST_NONE.
static clast_status read_indices(clast_ply_reader *reader, const clast_ply_property *property, bool restart,
                                 uint32_t *length)
{
    clast_status status = next_length(reader, property, length);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(reader->context, reader->face, reader->face_capacity, *length);
    }
    for (uint32_t i = 0; status == CLAST_OK && i < *length; i++) {
        double value;
        if (!next_value(reader, property->type, &value)) {
            return malformed(reader, "a vertex's number");
        }
        bool ends_strip = restart && value == -1.0;
        if (!ends_strip && !(value >= 0.0 && value < (double)reader->vertex_count && value == floor(value))) {
            return malformed(reader, "a vertex's number below the number of vertices");
        }
        reader->face[i] = ends_strip ? CLAST_NONE : (uint32_t)value;
    }
    return status;
}

static clast_status add_triangle(clast_ply_reader *reader, uint32_t a, uint32_t b, uint32_t c)
{
    if (reader->index_count / 3 >= UINT32_MAX / 3) {
        return clast_fail(reader->context, CLAST_ERROR_LIMIT, "%s: more triangles than a mesh may have (%u)",
                          reader->path, UINT32_MAX / 3);
    }
    clast_status status = CLAST_RESERVE(reader->context, reader->indices, reader->index_capacity,
                                        reader->index_count + 3);
    if (status == CLAST_OK) {
        reader->indices[reader->index_count++] = a;
        reader->indices[reader->index_count++] = b;
        reader->indices[reader->index_count++] = c;
    }
    return status;
}

static clast_status add_polygon(clast_ply_reader *reader, uint32_t count)
{
    const uint32_t *face = reader->face;
    if (count < 3) {
        reader->short_faces++;
        return CLAST_OK;
    }
    if (count == 3) {
        return add_triangle(reader, face[0], face[1], face[2]);
    }
    clast_status status = clast_polygon_reserve(reader->context, &reader->polygon, count);
    if (status != CLAST_OK) {
        return status;
    }
    for (uint32_t i = 0; i < count; i++) {
        memcpy(reader->polygon.points[i], reader->positions[face[i]], sizeof *reader->positions);
    }
    clast_polygon_cut(&reader->polygon, count);
    const uint32_t *corners = reader->polygon.corners;
    for (uint32_t i = 0; status == CLAST_OK && i < count - 2; i++) {
        status = add_triangle(reader, face[corners[3 * i]], face[corners[3 * i + 1]], face[corners[3 * i + 2]]);
    }
    return status;
}

// Every vertex of a strip makes a triangle with the two before it, alternately turned.
static clast_status add_strips(clast_ply_reader *reader, uint32_t count)
{
    uint32_t run = 0;
    clast_status status = CLAST_OK;
    for (uint32_t i = 0; status == CLAST_OK && i < count; i++) {
        const uint32_t *at = reader->face + i;
        run = *at != CLAST_NONE ? run + 1 : 0;
        if (run < 3 || at[0] == at[-1] || at[0] == at[-2] || at[-1] == at[-2]) {
            continue; // stitches between strips are no triangles
        }
        status = run % 2 == 1 ? add_triangle(reader, at[-2], at[-1], at[0])
                              : add_triangle(reader, at[-1], at[-2], at[0]);
    }
    return status;
}

static clast_status read_faces(clast_ply_reader *reader, bool strips)
{
    const clast_ply_element *element = reader->element;
    if (!reader->has_vertices && element->count > 0) {
        return clast_fail(reader->context, CLAST_ERROR_UNSUPPORTED, "%s: the faces come before the vertices",
                          reader->path);
    }
    const clast_ply_property *properties = properties_of(reader);
    clast_status status = strips ? CLAST_OK : clast_ply_read_many_faces(reader);
    if (status == CLAST_OK && reader->item < element->count) {
        status = need_bytes(reader);
    }
    for (; status == CLAST_OK && reader->item < element->count; reader->item++) {
        for (size_t i = 0; status == CLAST_OK && i < element->property_count; i++) {
            clast_word name = properties[i].name;
            uint32_t length;
            if (!properties[i].is_list ||
                !(clast_word_is(name, "vertex_indices") || clast_word_is(name, "vertex_index"))) {
                status = skip_property(reader, &properties[i]);
                continue;
            }
            status = read_indices(reader, &properties[i], strips, &length);
            if (status == CLAST_OK) {
                status = strips ? add_strips(reader, length) : add_polygon(reader, length);
            }
        }
        if (status == CLAST_OK) {
            status = note_progress(reader);
        }
    }
    return status;
}

// ----------------------------------------------------------------------------------------------------------- the file

// Bytes of an item of a binary element; 0 where a list makes them different, or there are none.
static uint64_t size_of_item(const clast_ply_reader *reader)
{
    uint64_t size = 0;
    for (size_t i = 0; i < reader->element->property_count; i++) {
        const clast_ply_property *property = &properties_of(reader)[i];
        if (property->is_list) {
            return 0;
        }
        size += clast_ply_type_size(property->type);
    }
    return size;
}

static clast_status skip_element(clast_ply_reader *reader)
{
    const clast_ply_element *element = reader->element;
    uint64_t size = reader->header.encoding != CLAST_PLY_ASCII ? size_of_item(reader) : 0;
    if (size != 0 && element->count <= (reader->bytes.size - reader->position) / size) {
        reader->position += element->count * size;
        return CLAST_OK;
    }
    clast_status status = need_bytes(reader);
    for (reader->item = 0; status == CLAST_OK && element->property_count > 0 && reader->item < element->count;
         reader->item++) {
        for (size_t i = 0; status == CLAST_OK && i < element->property_count; i++) {
            status = skip_property(reader, &properties_of(reader)[i]);
        }
    }
    return status;
}

static clast_status read_elements(clast_ply_reader *reader)
{
    for (size_t i = 0; i < reader->header.element_count; i++) {
        reader->element = &reader->header.elements[i];
        clast_word name = reader->element->name;
        bool is_text = reader->header.encoding == CLAST_PLY_ASCII;
        uint64_t left = is_text ? (uint64_t)(reader->text.end - reader->text.at)
                                : reader->bytes.size - reader->position;
        reader->item = 0;
        if (!clast_ply_count_is_possible(&reader->header, reader->element, left)) {
            return malformed(reader, "more data: the file is too short for the counts of its header");
        }
        clast_status status = clast_word_is(name, "vertex")      ? read_vertices(reader)
                              : clast_word_is(name, "face")      ? read_faces(reader, false)
                              : clast_word_is(name, "tristrips") ? read_faces(reader, true)
                                                                 : skip_element(reader);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

// Normals that the file gives as nothing become area-weighted ones of the faces.
static clast_status mend_normals(clast_ply_reader *reader, const clast_mesh *mesh)
{
    float *computed = NULL;
    for (uint32_t i = 0; reader->normals != NULL && i < reader->vertex_count; i++) {
        float *n = reader->normals[i];
        if (n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f) {
            continue;
        }
        if (computed == NULL) {
            computed = clast_mesh_normals(reader->context, mesh);
            if (computed == NULL) {
                return CLAST_ERROR_OUT_OF_MEMORY;
            }
        }
        memcpy(n, computed + 3 * (size_t)i, sizeof *reader->normals);
    }
    clast_free(reader->context, computed);
    return CLAST_OK;
}

static clast_status add_mesh(clast_ply_reader *reader, clast_scene *scene)
{
    if (reader->short_faces > 0) {
        clast_log(reader->context, CLAST_LOG_WARNING, "%s: %llu faces have fewer than three corners and are left out",
                  reader->path, (unsigned long long)reader->short_faces);
    }
    if (reader->index_count == 0) {
        clast_log(reader->context, CLAST_LOG_WARNING, "%s: a cloud of %u points without faces: nothing of it is drawn",
                  reader->path, reader->vertex_count);
        return CLAST_OK;
    }
    clast_mesh mesh = {
        .vertex_count = reader->vertex_count,
        .triangle_count = (uint32_t)(reader->index_count / 3),
        .positions = (const float *)reader->positions,
        .normals = (const float *)reader->normals,
        .coordinates = {(const float *)reader->coordinates, NULL},
        .colours = (const float *)reader->colours,
        .indices = reader->indices,
        .material = CLAST_NONE,
    };
    clast_status status = mend_normals(reader, &mesh);
    if (status != CLAST_OK) {
        return status;
    }
    void *blocks[] = {reader->positions, reader->normals, reader->coordinates, reader->colours, reader->indices};
    reader->positions = NULL;
    reader->normals = NULL;
    reader->coordinates = NULL;
    reader->colours = NULL;
    reader->indices = NULL;
    uint32_t geometry, instance;
    status = clast_scene_adopt_mesh(scene, &mesh, blocks, sizeof blocks / sizeof blocks[0], NULL, &geometry);
    return status == CLAST_OK ? clast_scene_add_instance(scene, geometry, NULL, NULL, &instance) : status;
}

// Reads the header from the file's beginning; from all of it where that is not enough, or the values are text.
static clast_status read_header(clast_ply_reader *reader, clast_file_window *window)
{
    enum { BEGINNING = 1 << 16 };
    size_t size = reader->file->size < BEGINNING ? (size_t)reader->file->size : BEGINNING;
    const unsigned char *bytes;
    clast_status status = clast_file_look(reader->file, window, 0, size, &bytes);
    if (status != CLAST_OK) {
        return clast_ply_fail(reader, status);
    }
    clast_bytes beginning = {bytes, size};
    if (reader->bytes.data == NULL) {
        status = clast_ply_read_header(reader->context, reader->path, beginning, &reader->header);
        if (status == CLAST_OK && reader->header.encoding != CLAST_PLY_ASCII) {
            return CLAST_OK;
        }
        clast_ply_free_header(reader->context, &reader->header);
        status = need_bytes(reader);
    }
    return status == CLAST_OK ? clast_ply_read_header(reader->context, reader->path, reader->bytes, &reader->header)
                              : status;
}

clast_status clast_load_ply_source(clast_scene *scene, const char *path, const clast_file_source *file)
{
    clast_context *context = scene->context;
    clast_file_window beginning = {NULL, 0}; // the names of the header lie in it
    clast_ply_reader reader = {.context = context, .path = path, .file = file, .bytes = {file->view.data, file->size}};
    clast_status status = read_header(&reader, &beginning);
    if (status == CLAST_OK) {
        reader.position = reader.header.size;
        if (reader.header.encoding == CLAST_PLY_ASCII) {
            const char *begin = (const char *)reader.bytes.data;
            reader.text = (clast_text){begin + reader.header.size, begin + file->size, reader.header.lines + 1};
        }
        status = read_elements(&reader);
    }
    if (status == CLAST_OK) {
        status = add_mesh(&reader, scene);
    }
    clast_ply_free_header(context, &reader.header);
    clast_file_free_window(context, &beginning);
    clast_file_unmap(context, &reader.whole);
    clast_free(context, reader.positions);
    clast_free(context, reader.normals);
    clast_free(context, reader.coordinates);
    clast_free(context, reader.colours);
    clast_free(context, reader.indices);
    clast_free(context, reader.face);
    clast_polygon_free(context, &reader.polygon);
    return status;
}

clast_status clast_load_ply(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_file_source source = {scene->context, file->size, *file, -1};
    return clast_load_ply_source(scene, path, &source);
}
