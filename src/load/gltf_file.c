// SPDX-License-Identifier: Apache-2.0
// Where a glTF file's bytes are: the chunks of a .glb, URIs, buffers and buffer views.
#include <string.h>

#include "load/account.h"
#include "load/gltf.h"

// ---------------------------------------------------------------------------------------------------- .glb, section 4

enum { GLB_HEADER_SIZE = 12, GLB_CHUNK_HEADER_SIZE = 8, GLB_JSON = 0x4e4f534a, GLB_BINARY = 0x004e4942 };

static uint32_t little_endian(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

// A 32-bit word; false where the file ends before it.
static bool read_word(clast_bytes bytes, uint64_t offset, uint32_t *word)
{
    unsigned char raw[4];
    if (!clast_bytes_read(bytes, offset, raw, sizeof raw)) {
        return false;
    }
    *word = little_endian(raw);
    return true;
}

static bool take_chunk(clast_gltf *gltf, size_t number, uint32_t type, clast_bytes chunk, clast_bytes *text)
{
    if (number == 0) {
        if (type != GLB_JSON) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL,
                                   "the first chunk has type 0x%08x: expected JSON (0x%08x)", type, (unsigned)GLB_JSON);
        }
        *text = chunk;
        return true;
    }
    if (type == GLB_JSON || (type == GLB_BINARY && number != 1)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL,
                               "chunk %zu is %s: expected one JSON chunk first, then at most one BIN chunk", number,
                               type == GLB_JSON ? "JSON" : "BIN");
    }
    if (type == GLB_BINARY) {
        gltf->binary_chunk = chunk;
        gltf->has_binary_chunk = true;
    }
    return true; // other types are to be ignored
}

static bool split_binary(clast_gltf *gltf, clast_bytes file, clast_bytes *text)
{
    uint32_t version, length;
    if (!read_word(file, 4, &version) || !read_word(file, 8, &length)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL, "%llu bytes: expected a header of %d",
                               (unsigned long long)file.size, GLB_HEADER_SIZE);
    }
    if (version != 2) {
        return clast_gltf_fail(gltf, CLAST_ERROR_UNSUPPORTED, NULL, "binary glTF version %u: expected 2", version);
    }
    clast_bytes glb;
    if (length < GLB_HEADER_SIZE || !clast_bytes_slice(file, 0, length, &glb)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL,
                               "the header says %u bytes: expected at least %d and the file's %llu", length,
                               GLB_HEADER_SIZE, (unsigned long long)file.size);
    }
    uint64_t offset = GLB_HEADER_SIZE;
    size_t number = 0;
    for (; offset < length; number++) {
        uint32_t size, type;
        clast_bytes chunk;
        if (!read_word(glb, offset, &size) || !read_word(glb, offset + 4, &type) ||
            !clast_bytes_slice(glb, offset + GLB_CHUNK_HEADER_SIZE, size, &chunk)) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL,
                                   "chunk %zu at byte %llu does not fit into the %u bytes that the header says", number,
                                   (unsigned long long)offset, length);
        }
        if (size % 4 != 0) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL,
                                   "chunk %zu has %u bytes: expected a multiple of 4", number, size);
        }
        if (!take_chunk(gltf, number, type, chunk, text)) {
            return false;
        }
        offset += GLB_CHUNK_HEADER_SIZE + (uint64_t)size;
    }
    return number != 0 || clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL, "no chunk: expected a JSON chunk");
}

bool clast_gltf_split(clast_gltf *gltf, clast_bytes *text)
{
    clast_bytes file = {gltf->file->data, gltf->file->size};
    if (clast_bytes_begin_with(file, "glTF")) {
        return split_binary(gltf, file, text);
    }
    *text = file;
    return true;
}

// ---------------------------------------------------------------------------------------------------------------- URIs

static int base64_digit(unsigned char c)
{
    if (c >= 'A' && c <= 'Z') {
        return c - 'A';
    }
    if (c >= 'a' && c <= 'z') {
        return c - 'a' + 26;
    }
    if (c >= '0' && c <= '9') {
        return c - '0' + 52;
    }
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Decodes by RFC 4648 section 4, padding needed and no other characters. Returns the number of bytes, or -1.
static int64_t decode_base64(const unsigned char *text, size_t length, unsigned char *bytes)
{
    if (length % 4 != 0) {
        return -1;
    }
    size_t padding = 0;
    while (padding < 2 && length > padding && text[length - 1 - padding] == '=') {
        padding++;
    }
    size_t out = 0;
    for (size_t i = 0; i < length; i += 4) {
        uint32_t group = 0;
        size_t digits = i + 4 == length ? 4 - padding : 4;
        for (size_t k = 0; k < 4; k++) {
            int digit = k < digits ? base64_digit(text[i + k]) : 0;
            if (digit < 0) {
                return -1;
            }
            group = group << 6 | (uint32_t)digit;
        }
        for (size_t k = 0; k + 1 < digits; k++) {
            bytes[out++] = (unsigned char)(group >> (16 - 8 * k));
        }
    }
    return (int64_t)out;
}

static bool open_data_uri(clast_gltf *gltf, const clast_gltf_value *place, const char *uri, void **block,
                          clast_bytes *bytes)
{
    static const char marker[] = ";base64";
    const char *comma = strchr(uri, ',');
    size_t head = comma != NULL ? (size_t)(comma - uri) : 0;
    if (head < sizeof marker - 1 || memcmp(comma - (sizeof marker - 1), marker, sizeof marker - 1) != 0) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                               "a data URI that is not of the form data:[type];base64,DATA");
    }
    const char *text = comma + 1;
    size_t length = strlen(text);
    if (!clast_gltf_account(gltf, place, length, 1)) {
        return false;
    }
    *block = clast_allocate(gltf->context, length / 4 + 1, 3);
    if (*block == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    int64_t size = decode_base64((const unsigned char *)text, length, *block);
    if (size < 0) {
        clast_free(gltf->context, *block);
        *block = NULL;
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                               "the data URI's %zu characters are not padded base64", length);
    }
    *bytes = (clast_bytes){*block, (uint64_t)size};
    return true;
}

static int hexadecimal_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

// Decodes %XX in place (RFC 3986 section 2.1); false where it is broken or hides a zero byte.
static bool decode_percent(char *text)
{
    char *out = text;
    for (const char *in = text; *in != '\0'; in++) {
        if (*in != '%') {
            *out++ = *in;
            continue;
        }
        int high = hexadecimal_digit(in[1]), low = high < 0 ? -1 : hexadecimal_digit(in[2]);
        if (low < 0 || (high == 0 && low == 0)) {
            return false;
        }
        *out++ = (char)(high * 16 + low);
        in += 2;
    }
    *out = '\0';
    return true;
}

// True for "http:" and the like: a letter, then letters, digits, + - or . up to a colon.
static bool has_scheme(const char *uri)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
    size_t length = strspn(uri, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.");
    return length > 0 && uri[length] == ':' && strchr(letters, uri[0]) != NULL;
}

// Counts a file as read; one that is named again is no more than it was.
static clast_status note_read(clast_gltf *gltf, const char *name, uint64_t size)
{
    clast_status status = clast_table_reserve(gltf->context, &gltf->files_read);
    uint32_t hash = clast_hash_text(name, strlen(name));
    size_t place = hash;
    if (status == CLAST_OK && clast_table_next(&gltf->files_read, hash, &place) == CLAST_NONE) {
        clast_table_insert(&gltf->files_read, hash, place, 0);
        clast_account_read(gltf->scene, size);
    }
    return status;
}

static bool open_external(clast_gltf *gltf, const clast_gltf_value *place, const char *uri, clast_file_view *file,
                          clast_bytes *bytes)
{
    if (has_scheme(uri) || uri[0] == '/') {
        return clast_gltf_fail(gltf, CLAST_ERROR_UNSUPPORTED, place,
                               "\"%.200s\": expected a path relative to the file, or a data URI", uri);
    }
    char *decoded = clast_copy_text(gltf->context, uri);
    if (decoded == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    if (!decode_percent(decoded) || decoded[0] == '\0') {
        clast_free(gltf->context, decoded);
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, place,
                               "\"%.200s\": expected a path with %% only in escapes such as %%20", uri);
    }
    char *path = clast_path_beside(gltf->context, gltf->path, decoded);
    clast_status status = path != NULL ? clast_file_map(gltf->context, path, file) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status != CLAST_OK) {
        clast_gltf_fail(gltf, status, place, "\"%.200s\": %s", decoded, clast_status_text(status));
    } else {
        status = note_read(gltf, decoded, file->size);
        clast_gltf_check(gltf, status);
        *bytes = (clast_bytes){file->data, file->size};
    }
    clast_free(gltf->context, path);
    clast_free(gltf->context, decoded);
    return status == CLAST_OK;
}

bool clast_gltf_open_uri(clast_gltf *gltf, const clast_gltf_value *place, const char *uri, void **block,
                         clast_file_view *file, clast_bytes *bytes)
{
    return strncmp(uri, "data:", 5) == 0 ? open_data_uri(gltf, place, uri, block, bytes)
                                         : open_external(gltf, place, uri, file, bytes);
}

// ------------------------------------------------------------------------------------------------------------- buffers

bool clast_gltf_open_buffer(clast_gltf *gltf, uint32_t index)
{
    clast_gltf_buffer *buffer = &gltf->buffers[index];
    if (buffer->opened) {
        return true;
    }
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_BUFFERS, index);
    uint64_t length = clast_gltf_integer(gltf, &value, "byteLength", 1, INT64_MAX, CLAST_GLTF_REQUIRED);
    const char *uri = clast_gltf_text(gltf, &value, "uri");
    clast_gltf_value place = clast_gltf_member(&value, "uri");
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    clast_bytes whole = gltf->binary_chunk;
    if (uri != NULL) {
        if (!clast_gltf_open_uri(gltf, &place, uri, &buffer->block, &buffer->file, &whole) ||
            !clast_gltf_account(gltf, &place, buffer->file.size, 1)) {
            return false;
        }
    } else if (index == 0 && gltf->has_binary_chunk) {
        buffer->is_binary_chunk = true;
    } else {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value,
                               "no uri: expected one, or a first buffer that is a .glb's BIN chunk");
    }
    if (!clast_bytes_slice(whole, 0, length, &buffer->bytes)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value,
                               "byteLength %llu: expected at most the %llu bytes that there are",
                               (unsigned long long)length, (unsigned long long)whole.size);
    }
    buffer->opened = true;
    return true;
}

bool clast_gltf_keep_buffer(clast_gltf *gltf, uint32_t index)
{
    if (index == CLAST_GLTF_DECODED) {
        return false;
    }
    clast_gltf_buffer *buffer = &gltf->buffers[index];
    if (buffer->block != NULL || buffer->kept) {
        return buffer->kept;
    }
    clast_file_view *file = buffer->is_binary_chunk ? gltf->file : &buffer->file;
    clast_file_view kept = *file;
    *file = (clast_file_view){0};
    buffer->kept = clast_gltf_check(gltf, clast_scene_keep_file(gltf->scene, kept));
    return buffer->kept;
}

void clast_gltf_close_buffers(clast_gltf *gltf)
{
    size_t count = gltf->buffers != NULL ? clast_gltf_size(&gltf->lists[CLAST_GLTF_BUFFERS]) : 0;
    for (size_t i = 0; i < count; i++) {
        clast_file_unmap(gltf->context, &gltf->buffers[i].file);
        clast_free(gltf->context, gltf->buffers[i].block);
    }
    count = gltf->decoded_views != NULL ? clast_gltf_size(&gltf->lists[CLAST_GLTF_BUFFER_VIEWS]) : 0;
    for (size_t i = 0; i < count; i++) {
        clast_free(gltf->context, gltf->decoded_views[i]);
    }
    clast_table_free(gltf->context, &gltf->files_read);
    clast_free(gltf->context, gltf->buffers);
    clast_free(gltf->context, gltf->decoded_views);
    gltf->buffers = NULL;
    gltf->decoded_views = NULL;
}
