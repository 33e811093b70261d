// SPDX-License-Identifier: Apache-2.0
// Accessors and buffer views of glTF: the input's first bytes choose their numbers, the rest is the buffer.
#include "fuzz.h"

// Mostly small, now and then near what sizes can hold.
static long long number(fuzz_bytes *bytes)
{
    static const long long edges[] = {0,
                                      1,
                                      2,
                                      3,
                                      4,
                                      252,
                                      255,
                                      256,
                                      65535,
                                      65536,
                                      2147483647,
                                      4294967295,
                                      4294967296,
                                      9007199254740991,
                                      9223372036854775807,
                                      -1};
    uint8_t choice = fuzz_byte(bytes);
    return choice < 0xf0 ? choice : edges[choice - 0xf0];
}

static int component(fuzz_bytes *bytes)
{
    static const int components[] = {5120, 5121, 5122, 5123, 5125, 5126, 5124, 0};
    return components[fuzz_byte(bytes) % 8];
}

static const char *type(fuzz_bytes *bytes)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", "VEC3"};
    return types[fuzz_byte(bytes) % 8];
}

static size_t write_accessor(fuzz_bytes *bytes, bool is_sparse, char *text, size_t room)
{
    int length = snprintf(
        text, room, "{\"bufferView\":%u,\"byteOffset\":%lld,\"componentType\":%d,\"count\":%lld,\"type\":\"%s\"%s",
        fuzz_byte(bytes) % 3u, number(bytes), component(bytes), number(bytes), type(bytes),
        fuzz_byte(bytes) % 2 ? ",\"normalized\":true" : "");
    if (is_sparse) {
        length += snprintf(
            text + length, room - (size_t)length,
            ",\"sparse\":{\"count\":%lld,\"indices\":{\"bufferView\":%u,\"byteOffset\":%lld,\"componentType\":%d},"
            "\"values\":{\"bufferView\":%u,\"byteOffset\":%lld}}",
            number(bytes), fuzz_byte(bytes) % 3u, number(bytes), component(bytes), fuzz_byte(bytes) % 3u,
            number(bytes));
    }
    length += snprintf(text + length, room - (size_t)length, "}");
    return (size_t)length;
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_bytes bytes = {data, data + size};
    static char text[8192];
    uint8_t flags = fuzz_byte(&bytes);
    size_t length = (size_t)snprintf(
        text, sizeof text,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0%s}],\"meshes\":[{\"weights\":[0.5],\"primitives\":[{\"mode\":%d,"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"COLOR_0\":3}%s%s}]}],\"buffers\":[{\"uri\":\"input.bin\","
        "\"byteLength\":%lld}],\"bufferViews\":[",
        flags & 1 ? ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":0,\"SCALE\":4}}}"
                  : "",
        4 + (flags >> 1) % 3, flags & 8 ? ",\"indices\":4" : "", flags & 16 ? ",\"targets\":[{\"POSITION\":1}]" : "",
        number(&bytes));
    for (int i = 0; i < 3; i++) {
        uint8_t stride = fuzz_byte(&bytes);
        length += (size_t)snprintf(text + length, sizeof text - length,
                                   "%s{\"buffer\":0,\"byteOffset\":%lld,\"byteLength\":%lld", i != 0 ? "," : "",
                                   number(&bytes), number(&bytes));
        length += stride != 0 ? (size_t)snprintf(text + length, sizeof text - length, ",\"byteStride\":%u}", stride)
                              : (size_t)snprintf(text + length, sizeof text - length, "}");
    }
    length += (size_t)snprintf(text + length, sizeof text - length, "],\"accessors\":[");
    for (int i = 0; i < 5; i++) {
        length += (size_t)snprintf(text + length, sizeof text - length, "%s", i != 0 ? "," : "");
        length += write_accessor(&bytes, (flags & 32) != 0 && i < 2, text + length, sizeof text - length);
    }
    length += (size_t)snprintf(text + length, sizeof text - length, "]}");
    fuzz_put_file("input.bin", bytes.at, (size_t)(bytes.end - bytes.at));
    fuzz_load(context, clast_load_gltf, "input.gltf", (const uint8_t *)text, length);
}
