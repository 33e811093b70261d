// SPDX-License-Identifier: Apache-2.0
// The container of .glb files: section 4.
#include "load/validate.h"

enum { HEADER_SIZE = 12, CHUNK_HEADER_SIZE = 8, TYPE_JSON = 0x4e4f534a, TYPE_BINARY = 0x004e4942 };

typedef struct container {
    clast_validator *v;
    clast_bytes file;
    uint64_t length; // declared
    uint64_t offset;
    bool has_json;
    clast_bytes text;
} container;

static void fault(container *c, clast_fault_code code, uint64_t offset, const char *text)
{
    clast_validate_byte_fault(c->v, code, offset, "%s", text);
}

static bool check_header(container *c)
{
    if (c->file.size < HEADER_SIZE) {
        fault(c, CLAST_FAULT_GLB_UNEXPECTED_END_OF_HEADER, c->file.size, "the file ends inside its header of 12 bytes");
        return false;
    }
    uint32_t version = clast_load_word(c->file.data + 4);
    if (!clast_bytes_begin_with(c->file, "glTF")) {
        fault(c, CLAST_FAULT_GLB_INVALID_MAGIC, 0, "the file does not begin with glTF");
        return false;
    }
    if (version != 2) {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_INVALID_VERSION, 4, "version %u of the container: expected 2",
                                  version);
        return false;
    }
    c->length = clast_load_word(c->file.data + 8);
    if (c->length < HEADER_SIZE + CHUNK_HEADER_SIZE) {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_LENGTH_TOO_SMALL, 8,
                                  "the declared %llu bytes have no room for a chunk", (unsigned long long)c->length);
    }
    return true;
}

static void take_json(container *c, uint64_t place, clast_bytes chunk)
{
    if (chunk.size == 0) {
        fault(c, CLAST_FAULT_GLB_EMPTY_CHUNK, place, "the JSON chunk is empty");
    }
    if (c->has_json) {
        fault(c, CLAST_FAULT_GLB_DUPLICATE_CHUNK, place, "a second JSON chunk");
        return;
    }
    c->has_json = true;
    c->text = chunk;
}

static void take_binary(container *c, uint64_t place, size_t number, clast_bytes chunk)
{
    if (chunk.size == 0) {
        fault(c, CLAST_FAULT_GLB_EMPTY_BIN_CHUNK, place, "an empty BIN chunk, which should be left out");
    }
    if (c->v->has_binary) {
        fault(c, CLAST_FAULT_GLB_DUPLICATE_CHUNK, place, "a second BIN chunk");
        return;
    }
    if (number > 1) {
        fault(c, CLAST_FAULT_GLB_UNEXPECTED_BIN_CHUNK, place, "the BIN chunk is not the second");
    }
    c->v->has_binary = true;
    c->v->binary = chunk;
}

// Takes the chunk at the offset; false where what follows cannot be found.
static bool take_chunk(container *c, size_t number)
{
    uint64_t place = c->offset;
    if (c->file.size - place < CHUNK_HEADER_SIZE) {
        fault(c, CLAST_FAULT_GLB_UNEXPECTED_END_OF_CHUNK_HEADER, c->file.size,
              "the file ends inside the header of a chunk");
        return false;
    }
    uint32_t size = clast_load_word(c->file.data + place), type = clast_load_word(c->file.data + place + 4);
    c->offset += CHUNK_HEADER_SIZE;
    if (size % 4 != 0) {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_CHUNK_LENGTH_UNALIGNED, place,
                                  "a chunk of %u bytes: expected a multiple of 4", size);
    }
    if (c->offset + size > c->length) {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_CHUNK_TOO_BIG, place,
                                  "a chunk of %u bytes does not fit into the declared %llu", size,
                                  (unsigned long long)c->length);
    }
    if (number == 0 && type != TYPE_JSON) {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_UNEXPECTED_FIRST_CHUNK, place,
                                  "the first chunk has type 0x%08x: expected JSON", type);
    }
    clast_bytes chunk;
    if (!clast_bytes_slice(c->file, c->offset, size, &chunk)) {
        fault(c, CLAST_FAULT_GLB_UNEXPECTED_END_OF_CHUNK_DATA, c->file.size, "the file ends inside a chunk");
        return false;
    }
    if (type == TYPE_JSON) {
        take_json(c, place, chunk);
    } else if (type == TYPE_BINARY) {
        take_binary(c, place, number, chunk);
    } else {
        clast_validate_byte_fault(c->v, CLAST_FAULT_GLB_UNKNOWN_CHUNK_TYPE, place, "a chunk of the unknown type 0x%08x",
                                  type);
    }
    c->offset += size;
    return true;
}

bool clast_validate_container(clast_validator *v, clast_bytes file, clast_bytes *text)
{
    container c = {.v = v, .file = file, .offset = HEADER_SIZE};
    bool is_whole = check_header(&c);
    // Chunks are looked at as far as the file goes, where too little is declared too.
    uint64_t end = c.length < file.size && c.length >= HEADER_SIZE + CHUNK_HEADER_SIZE ? c.length : file.size;
    for (size_t number = 0; is_whole && c.offset < end; number++) {
        is_whole = take_chunk(&c, number);
    }
    if (is_whole && c.length > file.size) {
        clast_validate_byte_fault(v, CLAST_FAULT_GLB_LENGTH_MISMATCH, file.size,
                                  "the declared %llu bytes are not the file's %llu", (unsigned long long)c.length,
                                  (unsigned long long)file.size);
    } else if (is_whole && c.offset < file.size) {
        fault(&c, CLAST_FAULT_GLB_EXTRA_DATA, c.offset, "data after the declared length");
    } else if (is_whole && c.length != c.offset) {
        clast_validate_byte_fault(v, CLAST_FAULT_GLB_LENGTH_MISMATCH, c.offset,
                                  "the declared %llu bytes are not those of the chunks, %llu",
                                  (unsigned long long)c.length, (unsigned long long)c.offset);
    }
    *text = c.text;
    return c.has_json && c.text.size > 0;
}
