// SPDX-License-Identifier: Apache-2.0
// What the files of the PLY reader share: the header, and what is being read.
#ifndef CLAST_LOAD_PLY_H
#define CLAST_LOAD_PLY_H

#include "base/file.h"
#include "load/load.h"
#include "load/polygon.h"
#include "load/text.h"

// X(name, other name, bytes)
#define CLAST_PLY_TYPE_LIST(X) \
    X(CHAR, "char", "int8", 1) \
    X(UCHAR, "uchar", "uint8", 1) \
    X(SHORT, "short", "int16", 2) \
    X(USHORT, "ushort", "uint16", 2) \
    X(INT, "int", "int32", 4) \
    X(UINT, "uint", "uint32", 4) \
    X(FLOAT, "float", "float32", 4) \
    X(DOUBLE, "double", "float64", 8)

#define CLAST_PLY_ENUMERATOR(name, text, other, size) CLAST_PLY_##name,
typedef enum clast_ply_type { CLAST_PLY_TYPE_LIST(CLAST_PLY_ENUMERATOR) CLAST_PLY_TYPE_COUNT } clast_ply_type;

typedef enum clast_ply_encoding { CLAST_PLY_ASCII, CLAST_PLY_LITTLE_ENDIAN, CLAST_PLY_BIG_ENDIAN } clast_ply_encoding;

typedef struct clast_ply_property {
    clast_word name;
    bool is_list;
    clast_ply_type count_type; // of a list
    clast_ply_type type;
} clast_ply_property;

typedef struct clast_ply_element {
    clast_word name;
    uint64_t count;
    size_t first_property, property_count;
} clast_ply_element;

typedef struct clast_ply_header {
    clast_ply_encoding encoding;
    clast_ply_element *elements;
    size_t element_count, element_capacity;
    clast_ply_property *properties;
    size_t property_count, property_capacity;
    uint64_t size;  // bytes of the header
    uint64_t lines; // of the header
} clast_ply_header;

// Reads the header. Names point into `bytes`. Counts are not checked yet: clast_ply_count_is_possible does that.
clast_status clast_ply_read_header(clast_context *context, const char *path, clast_bytes bytes,
                                   clast_ply_header *header);
void clast_ply_free_header(clast_context *context, clast_ply_header *header);

size_t clast_ply_type_size(clast_ply_type type);
// A binary value, of which there are enough bytes.
double clast_ply_value(const unsigned char *bytes, clast_ply_type type, bool big_endian);

// Whether `left` bytes can hold an element's items. Items without properties take no room; their count means nothing.
bool clast_ply_count_is_possible(const clast_ply_header *header, const clast_ply_element *element, uint64_t left);

// What a property of a vertex is for: a place in the list of its values.
typedef enum clast_ply_role {
    CLAST_PLY_X,
    CLAST_PLY_Y,
    CLAST_PLY_Z,
    CLAST_PLY_NX,
    CLAST_PLY_NY,
    CLAST_PLY_NZ,
    CLAST_PLY_U,
    CLAST_PLY_V,
    CLAST_PLY_RED,
    CLAST_PLY_GREEN,
    CLAST_PLY_BLUE,
    CLAST_PLY_ALPHA,
    CLAST_PLY_ROLE_COUNT,
    CLAST_PLY_NO_ROLE = CLAST_PLY_ROLE_COUNT,
} clast_ply_role;

typedef struct clast_ply_reader {
    clast_context *context;
    const char *path;
    clast_ply_header header;
    const clast_file_source *file;
    clast_file_view whole; // where it had to be had
    clast_bytes bytes;     // all of the file; data is null while only pieces of it are read
    uint64_t position;     // binary: of the next value
    clast_text text;       // text: the same
    const clast_ply_element *element;
    uint64_t item;
    bool has_vertices;
    uint32_t vertex_count;
    float (*positions)[3];
    float (*normals)[3];
    float (*coordinates)[2];
    float (*colours)[4];
    uint32_t *indices;
    size_t index_count, index_capacity;
    uint32_t *face; // the list at hand
    size_t face_capacity;
    clast_polygon polygon;
    uint64_t short_faces; // of fewer than three corners
} clast_ply_reader;

// The status, with its text where reading a piece has failed.
clast_status clast_ply_fail(const clast_ply_reader *reader, clast_status status);
// Loads from a source; for load.c.
clast_status clast_load_ply_source(clast_scene *scene, const char *path, const clast_file_source *file);

// What a whole number or a fraction of a colour is divided by.
double clast_ply_colour_scale(clast_ply_type type);
// Stores a vertex; false where a value is not finite.
bool clast_ply_store_vertex(const clast_ply_reader *reader, uint64_t vertex, const double values[CLAST_PLY_ROLE_COUNT]);

// ply_binary.c: on all threads what binary files allow. Each leaves the rest, from reader->item at reader->position on, to the
// caller, who reads value by value and so finds what is wrong: all where the element is not of that kind, nothing where all is
// read. Errors: OUT_OF_MEMORY, FILE_READ, CANCELLED, LIMIT.
clast_status clast_ply_read_many_vertices(clast_ply_reader *reader, const clast_ply_role *roles);
clast_status clast_ply_read_many_faces(clast_ply_reader *reader);

#endif
