// SPDX-License-Identifier: Apache-2.0
// Buffers, views, accessors and images: whether each lies in what it refers to (sections 3.6 and 3.8.3).
#include "load/validate.h"

// -------------------------------------------------------------------------------------------------------------- buffers

// The bytes of a URI; false, with a fault, where they cannot be had.
static bool open_uri(clast_validator *v, const clast_gltf_value *place, const char *uri, void **block,
                     clast_file_view *file, clast_bytes *bytes)
{
    clast_gltf reader = {.context = v->context, .scene = v->scene, .path = v->path};
    bool is_open = clast_gltf_open_uri(&reader, place, uri, block, file, bytes);
    clast_gltf_close_buffers(&reader);
    if (is_open) {
        return true;
    }
    if (reader.status == CLAST_ERROR_OUT_OF_MEMORY) {
        v->status = reader.status;
    } else if (reader.status == CLAST_ERROR_MALFORMED) {
        clast_validate_fault(v, CLAST_FAULT_INVALID_URI, place, "not a URI that can be decoded");
    } else if (reader.status != CLAST_ERROR_UNSUPPORTED) { // what is not relative has been told
        clast_validate_fault(v, CLAST_FAULT_IO_ERROR, place, "\"%.200s\": %s", uri, clast_status_text(reader.status));
    }
    return false;
}

static void check_data_uri(clast_validator *v, const clast_gltf_value *place, const char *uri)
{
    static const char *const types[] = {"application/octet-stream", "application/gltf-buffer"};
    size_t length = strcspn(uri + 5, ";,");
    bool is_known = length == 0;
    for (int i = 0; i < 2; i++) {
        is_known = is_known || (strlen(types[i]) == length && strncmp(uri + 5, types[i], length) == 0);
    }
    if (!is_known) {
        clast_validate_fault(v, CLAST_FAULT_BUFFER_DATA_URI_MIME_TYPE_INVALID, place, "\"%.*s\": expected %s or %s",
                             (int)(length < 80 ? length : 80), uri + 5, types[0], types[1]);
    }
    if (v->is_container) {
        clast_validate_fault(v, CLAST_FAULT_DATA_URI_GLB, place, "a data URI in a .glb file");
    }
}

static void take_chunk(clast_validator *v, const clast_gltf_value *value, clast_validate_buffer *buffer)
{
    buffer->bytes = v->binary;
    if (buffer->bytes.size > buffer->length + 3) { // a chunk is padded to four bytes
        clast_validate_fault(v, CLAST_FAULT_BUFFER_GLB_CHUNK_TOO_BIG, value, "the BIN chunk has %llu bytes for %llu",
                             (unsigned long long)buffer->bytes.size, (unsigned long long)buffer->length);
    }
}

static void open_buffer(clast_validator *v, uint32_t index)
{
    clast_validate_buffer *buffer = &v->buffers[index];
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_BUFFERS, index);
    clast_gltf_value place = clast_gltf_member(&value, "uri");
    const char *uri = json_string_value(place.json);
    buffer->length = clast_validate_unsigned_or(&value, "byteLength", 0);
    bool is_data = uri != NULL && strncmp(uri, "data:", 5) == 0;
    if (uri != NULL) {
        if (is_data) {
            check_data_uri(v, &place, uri);
        }
        if (!open_uri(v, &place, uri, &buffer->block, &buffer->file, &buffer->bytes)) {
            return;
        }
    } else if (v->is_container && index == 0 && v->has_binary) {
        take_chunk(v, &value, buffer);
    } else {
        if (v->is_container && index == 0) {
            clast_validate_fault(v, CLAST_FAULT_BUFFER_MISSING_GLB_DATA, &value, "no uri, and no BIN chunk");
        }
        return; // an extension may have the bytes
    }
    if (is_data ? buffer->bytes.size != buffer->length : buffer->bytes.size < buffer->length) {
        clast_validate_fault(v,
                             is_data ? CLAST_FAULT_BUFFER_EMBEDDED_BYTELENGTH_MISMATCH
                                     : CLAST_FAULT_BUFFER_EXTERNAL_BYTELENGTH_MISMATCH,
                             &value, "%llu bytes for a byteLength of %llu", (unsigned long long)buffer->bytes.size,
                             (unsigned long long)buffer->length);
    }
    if (!clast_bytes_slice(buffer->bytes, 0, buffer->length, &buffer->bytes)) {
        buffer->bytes = (clast_bytes){NULL, 0};
    }
}

// ---------------------------------------------------------------------------------------------------------------- views

static void open_view(clast_validator *v, uint32_t index)
{
    enum { VERTICES = 34962, INDICES = 34963 };
    clast_validate_view *view = &v->views[index];
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_BUFFER_VIEWS, index);
    uint64_t target = clast_validate_unsigned_or(&value, "target", 0);
    *view = (clast_validate_view){
        .buffer = clast_validate_index(v, &value, "buffer", CLAST_VALIDATE_BUFFERS),
        .offset = clast_validate_unsigned_or(&value, "byteOffset", 0),
        .length = clast_validate_unsigned_or(&value, "byteLength", 0),
        .stride = clast_validate_unsigned_or(&value, "byteStride", 0),
        .usage = target == VERTICES  ? CLAST_USAGE_VERTICES
                 : target == INDICES ? CLAST_USAGE_INDICES
                                     : CLAST_USAGE_NONE,
        .first_user = CLAST_NONE,
    };
    if (view->buffer == CLAST_NONE || view->length == 0) {
        return;
    }
    const clast_validate_buffer *buffer = &v->buffers[view->buffer];
    if (buffer->length != 0 && !clast_range_fits(view->offset, view->length, buffer->length)) {
        clast_validate_member_fault(
            v, CLAST_FAULT_BUFFER_VIEW_TOO_LONG, &value, view->offset >= buffer->length ? "byteOffset" : "byteLength",
            "%llu bytes from %llu do not fit into the %llu of buffer %u", (unsigned long long)view->length,
            (unsigned long long)view->offset, (unsigned long long)buffer->length, view->buffer);
    }
    if (buffer->bytes.data != NULL) {
        clast_bytes_slice(buffer->bytes, view->offset, view->length, &view->bytes);
    }
}

// ------------------------------------------------------------------------------------------------------------ accessors

uint32_t clast_validate_component_size(uint64_t component)
{
    switch (component) {
    case CLAST_GLTF_BYTE:
    case CLAST_GLTF_UNSIGNED_BYTE: return 1;
    case CLAST_GLTF_SHORT:
    case CLAST_GLTF_UNSIGNED_SHORT: return 2;
    case CLAST_GLTF_UNSIGNED_INT:
    case CLAST_GLTF_FLOAT: return 4;
    default: return 0;
    }
}

bool clast_validate_type(const char *type, uint32_t *columns, uint32_t *rows)
{
    static const struct {
        const char *name;
        uint32_t columns, rows;
    } types[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                 {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(types[i].name, type) == 0) {
            *columns = types[i].columns;
            *rows = types[i].rows;
            return true;
        }
    }
    return false;
}

// A piece of a view that holds elements; false, with faults, where it does not lie in there. Bytes are null where they are not at
// hand.
static bool place_elements(clast_validator *v, const clast_gltf_value *value, uint32_t view_index, uint64_t offset,
                           uint64_t count, uint64_t stride, uint64_t element_size, uint32_t alignment,
                           clast_bytes *bytes)
{
    const clast_validate_view *view = &v->views[view_index];
    bool has_offset = json_object_get(value->json, "byteOffset") != NULL;
    clast_gltf_value place = has_offset ? clast_gltf_member(value, "byteOffset") : *value;
    *bytes = (clast_bytes){NULL, 0};
    if ((view->offset % alignment + offset % alignment) % alignment != 0) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_TOTAL_OFFSET_ALIGNMENT, value,
                             "byte %llu of byte %llu of the buffer: expected a multiple of %u",
                             (unsigned long long)offset, (unsigned long long)view->offset, alignment);
    }
    if (!clast_elements_fit(offset, count, stride, element_size, view->length)) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_TOO_LONG, &place,
                             "%llu elements of %llu bytes from byte %llu do not fit into the %llu of view %u",
                             (unsigned long long)count, (unsigned long long)element_size, (unsigned long long)offset,
                             (unsigned long long)view->length, view_index);
        return false;
    }
    if (view->bytes.data != NULL) {
        clast_bytes_slice(view->bytes, offset, view->bytes.size - offset, bytes);
    }
    return true;
}

static void open_sparse_part(clast_validator *v, const clast_gltf_value *part, uint64_t count, uint64_t element_size,
                             uint32_t alignment, clast_bytes *bytes)
{
    uint32_t view = clast_validate_index(v, part, "bufferView", CLAST_VALIDATE_BUFFER_VIEWS);
    if (view == CLAST_NONE) {
        return;
    }
    if (v->views[view].stride != 0) {
        clast_validate_member_fault(v, CLAST_FAULT_BUFFER_VIEW_INVALID_BYTE_STRIDE, part, "bufferView",
                                    "only views of vertices can have a byteStride");
    }
    place_elements(v, part, view, clast_validate_unsigned_or(part, "byteOffset", 0), count, element_size, element_size,
                   alignment, bytes);
}

static void open_sparse(clast_validator *v, const clast_gltf_value *value, clast_validate_accessor *accessor)
{
    clast_gltf_value sparse = clast_gltf_member(value, "sparse");
    clast_gltf_value indices = clast_gltf_member(&sparse, "indices"), values = clast_gltf_member(&sparse, "values");
    if (!json_is_object(sparse.json)) {
        return;
    }
    uint64_t count = clast_validate_unsigned_or(&sparse, "count", 0);
    if (count > accessor->count) {
        clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE, &sparse, "count",
                                    "%llu elements of %llu are replaced", (unsigned long long)count,
                                    (unsigned long long)accessor->count);
    }
    uint32_t size = clast_validate_component_size(clast_validate_unsigned_or(&indices, "componentType", 0));
    if (count == 0 || size == 0) {
        return;
    }
    open_sparse_part(v, &indices, count, size, size, &accessor->sparse_indices);
    open_sparse_part(v, &values, count, accessor->element_size, accessor->component_size, &accessor->sparse_values);
    accessor->sparse_component_size = size;
    accessor->sparse_count = count;
}

static void open_accessor(clast_validator *v, uint32_t index)
{
    clast_validate_accessor *accessor = &v->accessors[index];
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_ACCESSORS, index);
    const char *type = clast_validate_text(&value, "type");
    uint64_t component = clast_validate_unsigned_or(&value, "componentType", 0);
    *accessor = (clast_validate_accessor){
        .count = clast_validate_unsigned_or(&value, "count", 0),
        .offset = clast_validate_unsigned_or(&value, "byteOffset", 0),
        .view = clast_validate_index(v, &value, "bufferView", CLAST_VALIDATE_BUFFER_VIEWS),
        .component_size = clast_validate_component_size(component),
        .is_normalised = json_is_true(json_object_get(value.json, "normalized")),
    };
    if (type == NULL || accessor->component_size == 0 || accessor->count == 0 ||
        !clast_validate_type(type, &accessor->columns, &accessor->rows)) {
        return;
    }
    accessor->component = (uint32_t)component;
    accessor->components = accessor->rows * accessor->columns;
    uint32_t column = accessor->rows * accessor->component_size;
    accessor->column_size = accessor->columns > 1 ? (column + 3) / 4 * 4 : column;
    accessor->element_size = accessor->column_size * accessor->columns;
    if (accessor->view != CLAST_NONE) {
        uint64_t stride = v->views[accessor->view].stride;
        accessor->stride = stride != 0 ? stride : accessor->element_size;
        if (accessor->stride < accessor->element_size) {
            clast_validate_fault(v, CLAST_FAULT_ACCESSOR_SMALL_BYTESTRIDE, &value,
                                 "the view's byteStride of %llu is below an element's %u bytes",
                                 (unsigned long long)stride, accessor->element_size);
        } else {
            uint64_t last = (uint64_t)accessor->column_size * (accessor->columns - 1) + column; // without its padding
            place_elements(v, &value, accessor->view, accessor->offset, accessor->count, accessor->stride, last,
                           accessor->component_size, &accessor->bytes);
        }
    }
    open_sparse(v, &value, accessor);
}

static const char *usage_text(clast_usage usage)
{
    static const char *const texts[] = {"nothing",   "vertices", "indices",  "inverse bind matrices",
                                        "animation", "an image", "instances"};
    return texts[usage];
}

bool clast_validate_use(clast_validator *v, const clast_gltf_value *place, uint32_t index, clast_usage usage)
{
    clast_validate_accessor *accessor = &v->accessors[index];
    if (accessor->usage != CLAST_USAGE_NONE && accessor->usage != usage) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_USAGE_OVERRIDE, place,
                             "accessor %u is used for %s too, and for %s", index, usage_text(accessor->usage),
                             usage_text(usage));
        return false;
    }
    accessor->usage = usage;
    if (accessor->view == CLAST_NONE) {
        return true;
    }
    clast_validate_view *view = &v->views[accessor->view];
    if (view->usage != CLAST_USAGE_NONE && view->usage != usage) {
        clast_validate_fault(v, CLAST_FAULT_BUFFER_VIEW_TARGET_OVERRIDE, place, "view %u is for %s, and used for %s",
                             accessor->view, usage_text(view->usage), usage_text(usage));
        return false;
    }
    if (view->usage == CLAST_USAGE_NONE && (usage == CLAST_USAGE_VERTICES || usage == CLAST_USAGE_INDICES)) {
        clast_validate_fault(v, CLAST_FAULT_BUFFER_VIEW_TARGET_MISSING, place, "view %u has no target", accessor->view);
    }
    view->usage = usage;
    return true;
}

// --------------------------------------------------------------------------------------------------------------- images

// Types of images by what their files begin with, and the extension that allows them; null where none needs to.
static const struct {
    const char *type, *signature, *extension;
    size_t at, length;
} image_types[] = {
    {"image/png", "\x89PNG\r\n\x1a\n", NULL, 0, 8},
    {"image/jpeg", "\xff\xd8\xff", NULL, 0, 3},
    {"image/webp", "WEBP", "EXT_texture_webp", 8, 4},
    {"image/ktx2", "\xabKTX 20\xbb\r\n\x1a\n", "KHR_texture_basisu", 0, 12},
    {"image/vnd-ms.dds", "DDS ", "MSFT_texture_dds", 0, 4},
};

static void decode_image(clast_validator *v, const clast_gltf_value *value, clast_bytes bytes)
{
    clast_image image = {0};
    clast_status status = clast_decode_image(v->context, v->path, bytes.data, bytes.size, &image);
    if (status == CLAST_OK) {
        if ((image.width & (image.width - 1)) != 0 || (image.height & (image.height - 1)) != 0) {
            clast_validate_fault(v, CLAST_FAULT_IMAGE_NPOT_DIMENSIONS, value, "%u x %u pixels are no powers of two",
                                 image.width, image.height);
        }
    } else if (status == CLAST_ERROR_MALFORMED || status == CLAST_ERROR_LIMIT) {
        const char *text = clast_context_error(v->context);
        size_t name = strlen(v->path); // the text begins with the file's name
        clast_validate_fault(v, status == CLAST_ERROR_LIMIT ? CLAST_FAULT_FILE_LIMIT : CLAST_FAULT_IMAGE_DATA_INVALID,
                             value, "%s",
                             strncmp(text, v->path, name) == 0 && strlen(text) > name + 2 ? text + name + 2 : text);
    } else if (status != CLAST_ERROR_UNSUPPORTED) {
        v->status = status;
    }
    clast_image_free(v->context, &image);
}

static void check_image(clast_validator *v, const clast_gltf_value *value, clast_bytes bytes)
{
    const char *declared = clast_validate_text(value, "mimeType");
    for (size_t i = 0; i < sizeof image_types / sizeof *image_types; i++) {
        clast_bytes head;
        if (!clast_bytes_slice(bytes, image_types[i].at, image_types[i].length, &head) ||
            memcmp(head.data, image_types[i].signature, image_types[i].length) != 0) {
            continue;
        }
        if (declared != NULL && strcmp(declared, image_types[i].type) != 0) {
            clast_validate_fault(v, CLAST_FAULT_IMAGE_MIME_TYPE_INVALID, value, "the data is %s, declared as %.40s",
                                 image_types[i].type, declared);
        }
        if (image_types[i].extension != NULL && !clast_validate_declares(v, image_types[i].extension)) {
            clast_validate_fault(v, CLAST_FAULT_IMAGE_NON_ENABLED_MIME_TYPE, value, "%s needs %s", image_types[i].type,
                                 image_types[i].extension);
        }
        decode_image(v, value, bytes);
        return;
    }
    clast_validate_fault(v, CLAST_FAULT_IMAGE_UNRECOGNIZED_FORMAT, value, "an image of no known type");
}

static void open_image(clast_validator *v, uint32_t index)
{
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_IMAGES, index);
    clast_gltf_value place = clast_gltf_member(&value, "uri"), view_place = clast_gltf_member(&value, "bufferView");
    const char *uri = json_string_value(place.json);
    uint32_t view = clast_validate_index(v, &value, "bufferView", CLAST_VALIDATE_BUFFER_VIEWS);
    if (uri != NULL) {
        void *block = NULL;
        clast_file_view file = {0};
        clast_bytes bytes;
        if (strncmp(uri, "data:", 5) == 0 && v->is_container) {
            clast_validate_fault(v, CLAST_FAULT_DATA_URI_GLB, &place, "a data URI in a .glb file");
        }
        if (open_uri(v, &place, uri, &block, &file, &bytes)) {
            check_image(v, &value, bytes);
        }
        clast_file_unmap(v->context, &file);
        clast_free(v->context, block);
    } else if (view != CLAST_NONE) {
        clast_validate_view *used = &v->views[view];
        if (used->stride != 0) {
            clast_validate_fault(v, CLAST_FAULT_IMAGE_BUFFER_VIEW_WITH_BYTESTRIDE, &view_place,
                                 "view %u has a byteStride", view);
        }
        if (used->usage != CLAST_USAGE_NONE && used->usage != CLAST_USAGE_IMAGE) {
            clast_validate_fault(v, CLAST_FAULT_BUFFER_VIEW_TARGET_OVERRIDE, &view_place,
                                 "view %u is for %s, and used for %s", view, usage_text(used->usage),
                                 usage_text(CLAST_USAGE_IMAGE));
        }
        used->usage = CLAST_USAGE_IMAGE;
        if (used->bytes.data != NULL) {
            check_image(v, &value, used->bytes);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------------ all

void clast_validate_storage(clast_validator *v)
{
    size_t buffers = clast_validate_size(v, CLAST_VALIDATE_BUFFERS),
           views = clast_validate_size(v, CLAST_VALIDATE_BUFFER_VIEWS),
           accessors = clast_validate_size(v, CLAST_VALIDATE_ACCESSORS),
           images = clast_validate_size(v, CLAST_VALIDATE_IMAGES);
    if (v->status != CLAST_OK) {
        return;
    }
    v->buffers = clast_allocate_zeroed(v->context, buffers, sizeof *v->buffers);
    v->views = clast_allocate_zeroed(v->context, views, sizeof *v->views);
    v->accessors = clast_allocate_zeroed(v->context, accessors, sizeof *v->accessors);
    if (v->buffers == NULL || v->views == NULL || v->accessors == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (uint32_t i = 0; i < buffers && v->status == CLAST_OK; i++) {
        open_buffer(v, i);
    }
    for (uint32_t i = 0; i < views && v->status == CLAST_OK; i++) {
        open_view(v, i);
    }
    for (uint32_t i = 0; i < accessors && v->status == CLAST_OK; i++) {
        open_accessor(v, i);
    }
    for (uint32_t i = 0; i < images && v->status == CLAST_OK; i++) {
        open_image(v, i);
    }
}

void clast_validate_close_storage(clast_validator *v)
{
    for (size_t i = 0; v->buffers != NULL && i < clast_validate_size(v, CLAST_VALIDATE_BUFFERS); i++) {
        clast_file_unmap(v->context, &v->buffers[i].file);
        clast_free(v->context, v->buffers[i].block);
    }
    clast_free(v->context, v->buffers);
    clast_free(v->context, v->views);
    clast_free(v->context, v->accessors);
    clast_free(v->context, v->parents);
}
