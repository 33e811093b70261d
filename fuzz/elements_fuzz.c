// SPDX-License-Identifier: Apache-2.0
// A glTF accessor by itself: the input's first bytes are its numbers and those of its views, put into a document that is there once;
// the rest is the buffer. What opens is read as floats and as integers.
#include "fuzz.h"
#include "load/gltf.h"

enum { VIEWS = 3, VALUES_MOST = 1 << 12 };

static const char document[] =
    "{\"accessors\":[{\"bufferView\":0,\"byteOffset\":0,\"componentType\":0,\"count\":0,\"type\":\"VEC3\",\"normalized\":true},"
    "{\"bufferView\":0,\"byteOffset\":0,\"componentType\":0,\"count\":0,\"type\":\"MAT3\",\"sparse\":{\"count\":0,\"indices\":"
    "{\"bufferView\":1,\"byteOffset\":0,\"componentType\":0},\"values\":{\"bufferView\":2,\"byteOffset\":0}}}],"
    "\"buffers\":[{\"byteLength\":1}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":0,\"byteStride\":4},"
    "{\"buffer\":0,\"byteOffset\":0,\"byteLength\":0},{\"buffer\":0,\"byteOffset\":0,\"byteLength\":0}]}";

static json_t *parsed;

static json_int_t number(fuzz_bytes *bytes)
{
    static const json_int_t edges[] = {65535, 2147483647, 4294967295, 4294967296, 9223372036854775807, -1, 256, 1024};
    uint8_t choice = fuzz_byte(bytes);
    return choice < 0xf8 ? choice : edges[choice - 0xf8];
}

static void set(json_t *object, const char *name, json_int_t value)
{
    FUZZ_CHECK(json_integer_set(json_object_get(object, name), value) == 0);
}

static void set_range(fuzz_bytes *bytes, json_t *object)
{
    set(object, "bufferView", fuzz_byte(bytes) % (VIEWS + 1));
    set(object, "byteOffset", number(bytes));
}

static json_int_t component(fuzz_bytes *bytes)
{
    return 5120 + fuzz_byte(bytes) % 8;
}

static void set_accessor(fuzz_bytes *bytes, json_t *accessor)
{
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4", "MAT5"};
    json_t *sparse = json_object_get(accessor, "sparse");
    set_range(bytes, accessor);
    set(accessor, "componentType", component(bytes));
    set(accessor, "count", number(bytes));
    FUZZ_CHECK(json_string_set(json_object_get(accessor, "type"), types[fuzz_byte(bytes) % 8]) == 0);
    if (sparse != NULL) {
        set(sparse, "count", number(bytes));
        set_range(bytes, json_object_get(sparse, "indices"));
        set(json_object_get(sparse, "indices"), "componentType", component(bytes));
        set_range(bytes, json_object_get(sparse, "values"));
    }
}

static void read_elements(clast_gltf *gltf, uint32_t index)
{
    static float floats[VALUES_MOST];
    static uint32_t integers[VALUES_MOST];
    clast_gltf_accessor accessor;
    if (!clast_gltf_open_accessor(gltf, &gltf->root, index, &accessor) || accessor.count > VALUES_MOST) {
        return;
    }
    uint64_t values = accessor.count * accessor.columns * accessor.rows;
    if (values <= VALUES_MOST) {
        clast_gltf_read_floats(&accessor, 0, accessor.count, floats);
        clast_gltf_read_floats(&accessor, accessor.count / 2, accessor.count - accessor.count / 2, floats);
    }
    if (accessor.columns * accessor.rows == 1 && accessor.component != CLAST_GLTF_FLOAT &&
        accessor.component != CLAST_GLTF_BYTE && accessor.component != CLAST_GLTF_SHORT) {
        clast_gltf_read_integers(&accessor, integers);
    }
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    static clast_scene *scene;
    static void *decoded[VIEWS];
    if (parsed == NULL) {
        parsed = json_loads(document, 0, NULL);
        FUZZ_CHECK(parsed != NULL && clast_scene_create(context, &scene) == CLAST_OK);
        fuzz_keep(context);
    }
    fuzz_bytes bytes = {data, data + size};
    uint32_t index = fuzz_byte(&bytes) % 2;
    set_accessor(&bytes, json_array_get(json_object_get(parsed, "accessors"), index));
    for (size_t i = 0; i < VIEWS; i++) {
        json_t *view = json_array_get(json_object_get(parsed, "bufferViews"), i);
        set(view, "byteOffset", number(&bytes));
        set(view, "byteLength", number(&bytes));
        if (i == 0) {
            set(view, "byteStride", number(&bytes));
        }
    }
    size_t left = (size_t)(bytes.end - bytes.at);
    uint8_t *copy = fuzz_copy(bytes.at, left);
    clast_gltf_buffer buffer = {.opened = true, .bytes = {copy, left}};
    clast_gltf gltf = {.context = context,
                       .scene = scene,
                       .path = "input",
                       .json = parsed,
                       .root = {.json = parsed},
                       .buffers = &buffer,
                       .decoded_views = decoded};
    scene->stored_bytes = scene->made_bytes = 0;
    gltf.lists[CLAST_GLTF_ACCESSORS] = clast_gltf_array(&gltf, &gltf.root, "accessors");
    gltf.lists[CLAST_GLTF_BUFFER_VIEWS] = clast_gltf_array(&gltf, &gltf.root, "bufferViews");
    gltf.lists[CLAST_GLTF_BUFFERS] = clast_gltf_array(&gltf, &gltf.root, "buffers");
    read_elements(&gltf, index);
    fuzz_check_outcome(context, gltf.status);
    free(copy);
}
