// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file.
#ifndef CLAST_LOAD_PLY_H
#define CLAST_LOAD_PLY_H

#include "base/context.h"
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

// Whether `left` bytes can hold an element's items. Items without properties take no room; their count means nothing.
bool clast_ply_count_is_possible(const clast_ply_header *header, const clast_ply_element *element, uint64_t left);

#endif
