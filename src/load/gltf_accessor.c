// SPDX-License-Identifier: Apache-2.0
// Accessors: typed views of buffers (section 3.6.2). One walker serves all uses, so nothing is checked in one way and
// read in another.
#include <string.h>

#include "load/gltf.h"

// An accessor without buffer view is zeros for no bytes of the file: its count is bounded here instead.
enum { ZERO_COUNT_MOST = 1 << 22, STRIDE_LEAST = 4, STRIDE_MOST = 252 };

// ------------------------------------------------------------------------------------------------------------- opening

static uint32_t size_of_component(uint64_t component)
{
    switch (component) {
    case CLAST_GLTF_BYTE:
    case CLAST_GLTF_UNSIGNED_BYTE: return 1;
    case CLAST_GLTF_SHORT:
    case CLAST_GLTF_UNSIGNED_SHORT: return 2;
    case CLAST_GLTF_UNSIGNED_INT:
    case CLAST_GLTF_FLOAT: return 4;
    }
    return 0;
}

static const struct element_type {
    const char *name;
    uint32_t columns, rows;
} ELEMENT_TYPES[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                     {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
enum { ELEMENT_TYPE_COUNT = sizeof ELEMENT_TYPES / sizeof *ELEMENT_TYPES };

static bool read_type(clast_gltf *gltf, clast_gltf_accessor *accessor)
{
    const clast_gltf_value *value = &accessor->value;
    uint64_t component = clast_gltf_integer(gltf, value, "componentType", 0, UINT32_MAX, CLAST_GLTF_REQUIRED);
    const char *type = clast_gltf_text(gltf, value, "type");
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    accessor->component_size = size_of_component(component);
    if (accessor->component_size == 0) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value,
                               "componentType %llu: expected 5120, 5121, 5122, 5123, 5125 or 5126",
                               (unsigned long long)component);
    }
    accessor->component = (clast_gltf_component)component;
    for (size_t i = 0; i < ELEMENT_TYPE_COUNT && type != NULL; i++) {
        if (strcmp(ELEMENT_TYPES[i].name, type) == 0) {
            accessor->columns = ELEMENT_TYPES[i].columns;
            accessor->rows = ELEMENT_TYPES[i].rows;
        }
    }
    if (accessor->columns == 0) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value,
                               "type %.40s: expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4",
                               type != NULL ? type : "missing");
    }
    uint32_t column_size = accessor->rows * accessor->component_size;
    accessor->column_stride = accessor->columns > 1 ? (column_size + 3) / 4 * 4 : column_size;
    accessor->element_size = accessor->column_stride * accessor->columns;
    return true;
}

// Where elements are in a view, with their range checked: the alignment rules of section 3.6.2.4.
static bool place_elements(clast_gltf *gltf, const clast_gltf_value *value, clast_bytes view, uint64_t offset,
                           uint64_t count, uint64_t stride, uint64_t element_size, uint32_t alignment,
                           clast_bytes *bytes)
{
    if (offset % alignment != 0 || stride % alignment != 0) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value,
                               "byteOffset %llu and stride %llu: expected multiples of the component's %u bytes",
                               (unsigned long long)offset, (unsigned long long)stride, alignment);
    }
    if (!clast_elements_fit(offset, count, stride, element_size, view.size)) {
        return clast_gltf_fail(
            gltf, CLAST_ERROR_MALFORMED, value,
            "%llu elements of %llu bytes, every %llu bytes from byte %llu: expected to lie in the buffer view's %llu bytes",
            (unsigned long long)count, (unsigned long long)element_size, (unsigned long long)stride,
            (unsigned long long)offset, (unsigned long long)view.size);
    }
    return clast_bytes_slice(view, offset, view.size - offset, bytes);
}

static bool open_dense(clast_gltf *gltf, clast_gltf_accessor *accessor)
{
    const clast_gltf_value *value = &accessor->value;
    uint32_t index = clast_gltf_index(gltf, value, "bufferView", CLAST_GLTF_BUFFER_VIEWS);
    uint64_t offset = clast_gltf_integer(gltf, value, "byteOffset", 0, INT64_MAX, 0);
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (index == CLAST_NONE) {
        accessor->buffer = CLAST_NONE;
        return accessor->count <= ZERO_COUNT_MOST ||
               clast_gltf_fail(gltf, CLAST_ERROR_LIMIT, value, "count %llu without a bufferView: expected at most %d",
                               (unsigned long long)accessor->count, ZERO_COUNT_MOST);
    }
    clast_gltf_value view = clast_gltf_entry(gltf, CLAST_GLTF_BUFFER_VIEWS, index);
    accessor->stride = clast_gltf_integer(gltf, &view, "byteStride", STRIDE_LEAST, STRIDE_MOST, accessor->element_size);
    clast_bytes bytes;
    if (!clast_gltf_open_view(gltf, index, &bytes, &accessor->buffer)) {
        return false;
    }
    if (accessor->stride < accessor->element_size) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &view,
                               "byteStride %llu: expected at least the %u bytes of an element",
                               (unsigned long long)accessor->stride, accessor->element_size);
    }
    return place_elements(gltf, value, bytes, offset, accessor->count, accessor->stride, accessor->element_size,
                          accessor->component_size, &accessor->bytes);
}

static bool open_sparse_part(clast_gltf *gltf, const clast_gltf_value *part, uint64_t count, uint32_t element_size,
                             uint32_t alignment, clast_bytes *bytes)
{
    uint32_t view = clast_gltf_index(gltf, part, "bufferView", CLAST_GLTF_BUFFER_VIEWS), buffer;
    uint64_t offset = clast_gltf_integer(gltf, part, "byteOffset", 0, INT64_MAX, 0);
    if (clast_gltf_ok(gltf) && view == CLAST_NONE) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, part, "no bufferView: expected one");
    }
    clast_bytes whole;
    return clast_gltf_ok(gltf) && clast_gltf_open_view(gltf, view, &whole, &buffer) &&
           place_elements(gltf, part, whole, offset, count, element_size, element_size, alignment, bytes);
}

static uint32_t read_unsigned(const unsigned char *bytes, uint32_t size)
{
    switch (size) {
    case 1: return bytes[0];
    case 2: return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8;
    default: return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
    }
}

static uint32_t read_sparse_index(const clast_gltf_accessor *accessor, size_t i)
{
    return read_unsigned(accessor->sparse_indices.data + i * accessor->sparse_index_size, accessor->sparse_index_size);
}

// Each index must be above the one before and below the count (section 3.6.2.3).
static bool check_sparse_indices(clast_gltf *gltf, const clast_gltf_value *place, const clast_gltf_accessor *accessor)
{
    uint64_t next = 0;
    for (uint64_t i = 0; i < accessor->sparse_count; i++) {
        uint32_t index = read_unsigned(accessor->sparse_indices.data + i * accessor->sparse_index_size,
                                       accessor->sparse_index_size);
        if (index < next || index >= accessor->count) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                                   "index %llu is %u: expected a growing order below the count of %llu",
                                   (unsigned long long)i, index, (unsigned long long)accessor->count);
        }
        next = (uint64_t)index + 1;
    }
    return true;
}

static bool open_sparse(clast_gltf *gltf, clast_gltf_accessor *accessor)
{
    clast_gltf_value sparse = clast_gltf_object(gltf, &accessor->value, "sparse");
    if (sparse.json == NULL) {
        return clast_gltf_ok(gltf);
    }
    accessor->sparse_count = clast_gltf_integer(gltf, &sparse, "count", 1, accessor->count, CLAST_GLTF_REQUIRED);
    clast_gltf_value indices = clast_gltf_object(gltf, &sparse, "indices");
    clast_gltf_value values = clast_gltf_object(gltf, &sparse, "values");
    uint64_t component = clast_gltf_integer(gltf, &indices, "componentType", 0, UINT32_MAX, CLAST_GLTF_REQUIRED);
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (component != CLAST_GLTF_UNSIGNED_BYTE && component != CLAST_GLTF_UNSIGNED_SHORT &&
        component != CLAST_GLTF_UNSIGNED_INT) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &indices, "componentType %llu: expected 5121, 5123 or 5125",
                               (unsigned long long)component);
    }
    accessor->sparse_index_size = size_of_component(component);
    return open_sparse_part(gltf, &indices, accessor->sparse_count, accessor->sparse_index_size,
                            accessor->sparse_index_size, &accessor->sparse_indices) &&
           open_sparse_part(gltf, &values, accessor->sparse_count, accessor->element_size, accessor->component_size,
                            &accessor->sparse_values) &&
           check_sparse_indices(gltf, &indices, accessor);
}

bool clast_gltf_open_accessor(clast_gltf *gltf, const clast_gltf_value *user, uint32_t index,
                              clast_gltf_accessor *accessor)
{
    *accessor = (clast_gltf_accessor){.value = clast_gltf_entry(gltf, CLAST_GLTF_ACCESSORS, index),
                                      .buffer = CLAST_NONE};
    accessor->count = clast_gltf_integer(gltf, &accessor->value, "count", 1, INT64_MAX, CLAST_GLTF_REQUIRED);
    accessor->normalised = clast_gltf_flag(gltf, &accessor->value, "normalized", false);
    if (!clast_gltf_ok(gltf) || !read_type(gltf, accessor) || !open_dense(gltf, accessor) ||
        !open_sparse(gltf, accessor)) {
        return false;
    }
    if (accessor->count >= CLAST_NONE) {
        return clast_gltf_fail(gltf, CLAST_ERROR_LIMIT, user, "%llu elements: expected fewer than %u",
                               (unsigned long long)accessor->count, CLAST_NONE);
    }
    return true;
}

// -------------------------------------------------------------------------------------------------------------- typing

static const char *component_text(clast_gltf_component component)
{
    switch (component) {
    case CLAST_GLTF_BYTE: return "BYTE";
    case CLAST_GLTF_UNSIGNED_BYTE: return "UNSIGNED_BYTE";
    case CLAST_GLTF_SHORT: return "SHORT";
    case CLAST_GLTF_UNSIGNED_SHORT: return "UNSIGNED_SHORT";
    case CLAST_GLTF_UNSIGNED_INT: return "UNSIGNED_INT";
    case CLAST_GLTF_FLOAT: return "FLOAT";
    }
    return "none";
}

static const char *type_text(uint32_t columns, uint32_t rows)
{
    for (size_t i = 0; i < ELEMENT_TYPE_COUNT; i++) {
        if (ELEMENT_TYPES[i].columns == columns && ELEMENT_TYPES[i].rows == rows) {
            return ELEMENT_TYPES[i].name;
        }
    }
    return "none";
}

bool clast_gltf_accessor_is(clast_gltf *gltf, const clast_gltf_value *user, const clast_gltf_accessor *accessor,
                            uint32_t components, uint32_t columns, uint32_t rows)
{
    if ((components & CLAST_GLTF_BIT(accessor->component)) != 0 && accessor->columns == columns &&
        accessor->rows == rows) {
        return true;
    }
    char expected[96] = "";
    for (int component = CLAST_GLTF_BYTE; component <= CLAST_GLTF_FLOAT; component++) {
        if ((components & CLAST_GLTF_BIT(component)) != 0) {
            size_t length = strlen(expected);
            snprintf(expected + length, sizeof expected - length, "%s%s", length != 0 ? " or " : "",
                     component_text((clast_gltf_component)component));
        }
    }
    return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, user, "%s of %s: expected %s of %s",
                           type_text(accessor->columns, accessor->rows), component_text(accessor->component),
                           type_text(columns, rows), expected);
}

// ------------------------------------------------------------------------------------------------------------- reading

// One component as a float; normalised ones by section 3.6.2.2.
static float read_component(const unsigned char *bytes, clast_gltf_component component, bool normalised)
{
    switch (component) {
    case CLAST_GLTF_BYTE: {
        float value = (float)(int8_t)bytes[0];
        return !normalised ? value : value < -127.0f ? -1.0f : value / 127.0f;
    }
    case CLAST_GLTF_UNSIGNED_BYTE: return normalised ? (float)bytes[0] / 255.0f : (float)bytes[0];
    case CLAST_GLTF_SHORT: {
        float value = (float)(int16_t)read_unsigned(bytes, 2);
        return !normalised ? value : value < -32767.0f ? -1.0f : value / 32767.0f;
    }
    case CLAST_GLTF_UNSIGNED_SHORT:
        return normalised ? (float)read_unsigned(bytes, 2) / 65535.0f : (float)read_unsigned(bytes, 2);
    case CLAST_GLTF_UNSIGNED_INT: return (float)read_unsigned(bytes, 4);
    case CLAST_GLTF_FLOAT: {
        uint32_t bits = read_unsigned(bytes, 4);
        float value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    }
    return 0.0f;
}

static void read_element(const clast_gltf_accessor *accessor, const unsigned char *bytes, float *floats)
{
    for (uint32_t column = 0; column < accessor->columns; column++) {
        const unsigned char *from = bytes + (size_t)column * accessor->column_stride;
        for (uint32_t row = 0; row < accessor->rows; row++) {
            *floats++ = read_component(from + (size_t)row * accessor->component_size, accessor->component,
                                       accessor->normalised);
        }
    }
}

void clast_gltf_read_floats(const clast_gltf_accessor *accessor, uint64_t first, uint64_t count, float *floats)
{
    size_t components = (size_t)accessor->columns * accessor->rows;
    if (accessor->buffer == CLAST_NONE) {
        memset(floats, 0, count * components * sizeof *floats);
    } else {
        for (size_t i = 0; i < count; i++) {
            read_element(accessor, accessor->bytes.data + (first + i) * accessor->stride, floats + i * components);
        }
    }
    for (size_t i = 0; i < accessor->sparse_count; i++) {
        uint64_t index = read_sparse_index(accessor, i);
        if (index >= first && index - first < count) {
            read_element(accessor, accessor->sparse_values.data + i * accessor->element_size,
                         floats + (index - first) * components);
        }
    }
}

float *clast_gltf_read_block(clast_gltf *gltf, const clast_gltf_value *user, uint32_t components, uint32_t columns,
                             uint32_t rows, uint64_t *count)
{
    clast_gltf_accessor accessor;
    uint32_t index = clast_gltf_value_index(gltf, user, CLAST_GLTF_ACCESSORS);
    if (index == CLAST_NONE || !clast_gltf_open_accessor(gltf, user, index, &accessor) ||
        !clast_gltf_accessor_is(gltf, user, &accessor, components, columns, rows)) {
        return NULL;
    }
    if (*count != 0 && *count != accessor.count) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, user, "%llu elements: expected %llu",
                        (unsigned long long)accessor.count, (unsigned long long)*count);
        return NULL;
    }
    *count = accessor.count;
    if (!clast_gltf_account(gltf, user, accessor.count, columns * rows * sizeof(float))) {
        return NULL;
    }
    float *floats = clast_allocate(gltf->context, accessor.count, columns * rows * sizeof *floats);
    if (floats == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
        return NULL;
    }
    clast_gltf_read_floats(&accessor, 0, accessor.count, floats);
    return floats;
}

void clast_gltf_read_integers(const clast_gltf_accessor *accessor, uint32_t *integers)
{
    size_t components = (size_t)accessor->columns * accessor->rows;
    uint32_t size = accessor->component_size;
    if (accessor->buffer == CLAST_NONE) {
        memset(integers, 0, accessor->count * components * sizeof *integers);
    } else {
        for (size_t i = 0; i < accessor->count; i++) {
            for (size_t k = 0; k < components; k++) {
                integers[i * components + k] = read_unsigned(accessor->bytes.data + i * accessor->stride + k * size,
                                                             size);
            }
        }
    }
    for (size_t i = 0; i < accessor->sparse_count; i++) {
        size_t index = read_unsigned(accessor->sparse_indices.data + i * accessor->sparse_index_size,
                                     accessor->sparse_index_size);
        for (size_t k = 0; k < components; k++) {
            integers[index * components + k] = read_unsigned(
                accessor->sparse_values.data + i * accessor->element_size + k * size, size);
        }
    }
}

const void *clast_gltf_borrow(clast_gltf *gltf, const clast_gltf_accessor *accessor)
{
    static const uint32_t one = 1;
    bool is_native = *(const unsigned char *)&one == 1; // the file's order of bytes is this machine's
    if (!is_native || accessor->buffer == CLAST_NONE || accessor->sparse_count != 0 || accessor->component_size != 4 ||
        accessor->stride != accessor->element_size || (uintptr_t)accessor->bytes.data % 4 != 0 ||
        !clast_gltf_keep_buffer(gltf, accessor->buffer)) {
        return NULL;
    }
    return accessor->bytes.data;
}
