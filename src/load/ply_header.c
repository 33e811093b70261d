// SPDX-License-Identifier: Apache-2.0
#include "load/ply.h"

enum { ELEMENTS_MOST = 256, PROPERTIES_MOST = 4096 };

typedef struct header_reader {
    clast_context *context;
    const char *path;
    clast_text text;
    clast_ply_header *header;
    bool has_format;
} header_reader;

static clast_status malformed(const header_reader *reader, const char *expected)
{
    return clast_fail(reader->context, CLAST_ERROR_MALFORMED, "%s, line %llu: expected %s", reader->path,
                      (unsigned long long)reader->text.line, expected);
}

size_t clast_ply_type_size(clast_ply_type type)
{
    switch (type) {
#define CASE(name, text, other, size) \
    case CLAST_PLY_##name: return size;
        CLAST_PLY_TYPE_LIST(CASE)
#undef CASE
    default: return 0;
    }
}

static bool type_of(clast_word word, clast_ply_type *type)
{
#define TRY(name, text, other, size) \
    if (clast_word_is(word, text) || clast_word_is(word, other)) { \
        *type = CLAST_PLY_##name; \
        return true; \
    }
    CLAST_PLY_TYPE_LIST(TRY)
#undef TRY
    return false;
}

static clast_status read_format(header_reader *reader)
{
    static const char *const encodings[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    clast_word encoding = clast_next_word(&reader->text);
    clast_word version = clast_next_word(&reader->text);
    for (int i = 0; i < 3; i++) {
        if (clast_word_is(encoding, encodings[i]) && clast_word_is(version, "1.0")) {
            reader->header->encoding = (clast_ply_encoding)i;
            reader->has_format = true;
            return CLAST_OK;
        }
    }
    return malformed(reader, "format ascii, binary_little_endian or binary_big_endian 1.0");
}

static clast_status read_element(header_reader *reader)
{
    clast_ply_header *header = reader->header;
    clast_word name = clast_next_word(&reader->text);
    int64_t count;
    clast_skip_blanks(&reader->text);
    if (name.length == 0 || !clast_parse_integer(reader->text.at, reader->text.end, &count, &reader->text.at) ||
        count < 0 || !clast_line_is_over(&reader->text)) {
        return malformed(reader, "element with a name and a count");
    }
    if (header->element_count == ELEMENTS_MOST) {
        return malformed(reader, "at most 256 elements");
    }
    clast_status status = CLAST_RESERVE(reader->context, header->elements, header->element_capacity,
                                        header->element_count + 1);
    if (status == CLAST_OK) {
        header->elements[header->element_count++] = (clast_ply_element){name, (uint64_t)count, header->property_count,
                                                                        0};
    }
    return status;
}

static clast_status read_property(header_reader *reader)
{
    clast_ply_header *header = reader->header;
    clast_ply_property property = {.count_type = CLAST_PLY_UCHAR};
    clast_word word = clast_next_word(&reader->text);
    if (clast_word_is(word, "list")) {
        property.is_list = true;
        bool known = type_of(clast_next_word(&reader->text), &property.count_type);
        if (!known || property.count_type == CLAST_PLY_FLOAT || property.count_type == CLAST_PLY_DOUBLE) {
            return malformed(reader, "an integer type for the list's length");
        }
        word = clast_next_word(&reader->text);
    }
    if (!type_of(word, &property.type)) {
        return malformed(reader, "a type: char, uchar, short, ushort, int, uint, float or double");
    }
    property.name = clast_next_word(&reader->text);
    if (property.name.length == 0 || header->element_count == 0) {
        return malformed(reader, "a property's name, after an element");
    }
    if (header->property_count == PROPERTIES_MOST) {
        return malformed(reader, "at most 4096 properties");
    }
    clast_status status = CLAST_RESERVE(reader->context, header->properties, header->property_capacity,
                                        header->property_count + 1);
    if (status == CLAST_OK) {
        header->properties[header->property_count++] = property;
        header->elements[header->element_count - 1].property_count++;
    }
    return status;
}

// True at the header's end.
static clast_status read_line(header_reader *reader, bool *ended)
{
    clast_word keyword = clast_next_word(&reader->text);
    *ended = clast_word_is(keyword, "end_header");
    if (*ended || keyword.length == 0 || clast_word_is(keyword, "comment") || clast_word_is(keyword, "obj_info")) {
        return CLAST_OK;
    }
    if (clast_word_is(keyword, "format")) {
        return read_format(reader);
    }
    if (clast_word_is(keyword, "element")) {
        return read_element(reader);
    }
    if (clast_word_is(keyword, "property")) {
        return read_property(reader);
    }
    return malformed(reader, "format, element, property, comment, obj_info or end_header");
}

clast_status clast_ply_read_header(clast_context *context, const char *path, clast_bytes bytes,
                                   clast_ply_header *header)
{
    *header = (clast_ply_header){0};
    header_reader reader = {.context = context, .path = path, .header = header};
    reader.text = (clast_text){(const char *)bytes.data, (const char *)bytes.data + bytes.size, 1};
    if (!clast_word_is(clast_next_word(&reader.text), "ply")) {
        return malformed(&reader, "ply");
    }
    bool ended = false;
    while (!ended) {
        clast_next_line(&reader.text);
        if (reader.text.at == reader.text.end) {
            return malformed(&reader, "end_header");
        }
        clast_status status = read_line(&reader, &ended);
        if (status != CLAST_OK) {
            return status;
        }
    }
    if (!reader.has_format) {
        return malformed(&reader, "a format before end_header");
    }
    // Not clast_next_line: what follows is binary, and only the line's own end belongs to the header.
    while (reader.text.at < reader.text.end && (*reader.text.at == ' ' || *reader.text.at == '\t')) {
        reader.text.at++;
    }
    reader.text.at += clast_line_end(reader.text.at, reader.text.end);
    header->size = (uint64_t)(reader.text.at - (const char *)bytes.data);
    header->lines = reader.text.line;
    return CLAST_OK;
}

void clast_ply_free_header(clast_context *context, clast_ply_header *header)
{
    clast_free(context, header->elements);
    clast_free(context, header->properties);
    *header = (clast_ply_header){0};
}

bool clast_ply_count_is_possible(const clast_ply_header *header, const clast_ply_element *element, uint64_t left)
{
    uint64_t least = 0; // bytes of an item
    for (size_t i = 0; i < element->property_count; i++) {
        const clast_ply_property *property = &header->properties[element->first_property + i];
        size_t size = clast_ply_type_size(property->is_list ? property->count_type : property->type);
        least += header->encoding == CLAST_PLY_ASCII ? 2 : size; // a digit and what parts it from the next
    }
    return least == 0 || element->count <= (left + 1) / least;
}
