// SPDX-License-Identifier: Apache-2.0
// Buffer views (section 3.6.1.4), decoded where EXT_meshopt_compression or KHR_meshopt_compression packs them. A packed view
// is always decoded, also where the file has its plain bytes as well: those are for readers that cannot.
#include <string.h>

#include "load/gltf.h"
#include "load/meshopt.h"

static bool read_mode(clast_gltf *gltf, const clast_gltf_value *packed, clast_meshopt_stream *stream)
{
#define TEXT(name, text) text,
    static const char *const modes[] = {CLAST_MESHOPT_MODE_LIST(TEXT)};
    static const char *const filters[] = {CLAST_MESHOPT_FILTER_LIST(TEXT)};
#undef TEXT
    enum { MODES = sizeof modes / sizeof *modes, FILTERS = sizeof filters / sizeof *filters };
    const char *mode_text = clast_gltf_text(gltf, packed, "mode"),
               *filter_text = clast_gltf_text(gltf, packed, "filter");
    uint32_t mode = 0, filter = 0;
    while (mode_text != NULL && mode < MODES && strcmp(modes[mode], mode_text) != 0) {
        mode++;
    }
    while (filter_text != NULL && filter < FILTERS && strcmp(filters[filter], filter_text) != 0) {
        filter++;
    }
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (mode_text == NULL || mode == MODES) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, packed,
                               "mode %.40s: expected ATTRIBUTES, TRIANGLES or INDICES",
                               mode_text != NULL ? mode_text : "missing");
    }
    if (filter == FILTERS) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, packed,
                               "filter %.40s: expected NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR",
                               filter_text);
    }
    stream->mode = (clast_meshopt_mode)mode;
    stream->filter = (clast_meshopt_filter)filter;
    return true;
}

// What a view's extension says of its stream; `length` is of the decoded view.
static bool read_stream(clast_gltf *gltf, const clast_gltf_value *packed, uint64_t length, clast_meshopt_stream *stream)
{
    stream->count = clast_gltf_integer(gltf, packed, "count", 1, INT64_MAX, CLAST_GLTF_REQUIRED);
    stream->stride = (uint32_t)clast_gltf_integer(gltf, packed, "byteStride", 1, 256, CLAST_GLTF_REQUIRED);
    if (!clast_gltf_ok(gltf) || !read_mode(gltf, packed, stream)) {
        return false;
    }
    const char *fault = clast_meshopt_check(stream);
    if (fault != NULL) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, packed, "%s", fault);
    }
    return (length / stream->stride == stream->count && length % stream->stride == 0) ||
           clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, packed,
                           "%llu elements of %u bytes: expected the %llu bytes of the buffer view",
                           (unsigned long long)stream->count, stream->stride, (unsigned long long)length);
}

// Bytes of a buffer that an object names by buffer, byteOffset and byteLength.
static bool open_range(clast_gltf *gltf, const clast_gltf_value *object, clast_bytes *bytes, uint32_t *buffer)
{
    *buffer = clast_gltf_index(gltf, object, "buffer", CLAST_GLTF_BUFFERS);
    uint64_t offset = clast_gltf_integer(gltf, object, "byteOffset", 0, INT64_MAX, 0);
    uint64_t length = clast_gltf_integer(gltf, object, "byteLength", 1, INT64_MAX, CLAST_GLTF_REQUIRED);
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (*buffer == CLAST_NONE) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, object, "no buffer: expected its index");
    }
    if (!clast_gltf_open_buffer(gltf, *buffer)) {
        return false;
    }
    return clast_bytes_slice(gltf->buffers[*buffer].bytes, offset, length, bytes) ||
           clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, object,
                           "byteOffset %llu and byteLength %llu: expected to lie in the %llu bytes of buffer %u",
                           (unsigned long long)offset, (unsigned long long)length,
                           (unsigned long long)gltf->buffers[*buffer].bytes.size, *buffer);
}

static bool decode_view(clast_gltf *gltf, uint32_t index, const clast_gltf_value *view, const clast_gltf_value *packed,
                        clast_meshopt_stream *stream, clast_bytes *bytes)
{
    uint64_t length = clast_gltf_integer(gltf, view, "byteLength", 1, INT64_MAX, CLAST_GLTF_REQUIRED);
    uint32_t buffer;
    clast_bytes from;
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (gltf->decoded_views[index] != NULL) {
        *bytes = (clast_bytes){gltf->decoded_views[index], length};
        return true;
    }
    if (!read_stream(gltf, packed, length, stream) || !open_range(gltf, packed, &from, &buffer) ||
        !clast_gltf_account(gltf, packed, length, 1)) {
        return false;
    }
    unsigned char *block = clast_allocate(gltf->context, length, 1);
    if (block == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    const char *fault = clast_meshopt_decode(stream, from, block);
    if (fault != NULL) {
        clast_free(gltf->context, block);
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, packed, "the compressed stream: %s", fault);
    }
    gltf->decoded_views[index] = block;
    *bytes = (clast_bytes){block, length};
    return true;
}

bool clast_gltf_open_view(clast_gltf *gltf, uint32_t index, clast_bytes *bytes, uint32_t *buffer)
{
    clast_gltf_value view = clast_gltf_entry(gltf, CLAST_GLTF_BUFFER_VIEWS, index), extensions;
    clast_gltf_value newer = clast_gltf_extension(gltf, &view, &extensions, "KHR_meshopt_compression");
    clast_gltf_value older = clast_gltf_extension(gltf, &view, &extensions, "EXT_meshopt_compression");
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (newer.json == NULL && older.json == NULL) {
        return open_range(gltf, &view, bytes, buffer);
    }
    clast_meshopt_stream stream = {.version_1 = newer.json != NULL};
    *buffer = CLAST_GLTF_DECODED;
    return decode_view(gltf, index, &view, newer.json != NULL ? &newer : &older, &stream, bytes);
}
