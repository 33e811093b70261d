// SPDX-License-Identifier: Apache-2.0
// Where a glTF file's bytes are: JSON, .glb chunks, URIs, buffers; versions and extensions.
#include "gltf_fixture.h"

// ---------------------------------------------------------------------------------------------------------------- JSON

static void a_triangle_is_read(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, TRIANGLE_WITH(""));
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 3);
    assert_int_equal(mesh->triangle_count, 1);
    assert_floats(mesh->positions, TRIANGLE, 9, 0.0f);
    assert_indices(mesh->indices, (uint32_t[]){0, 1, 2}, 3);
    assert_null(mesh->normals);
    assert_int_equal(mesh->material, 0);
    assert_int_equal(f->scene->instance_count, 1);
    assert_string_equal(f->scene->geometries[0].name, "shape");
    assert_string_equal(f->log, "");
}

static void an_empty_file_of_a_scene_is_valid(void **state)
{
    fixture *f = *state;
    assert_loads(f, "{" ASSET "}");
    assert_int_equal(f->scene->geometry_count, 0);
    assert_loads(f, "{" ASSET ",'scenes':[{}],'scene':0}");
    assert_loads(f, "{" ASSET ",'nodes':[],'meshes':[],'buffers':[]}");
}

static void a_byte_order_mark_is_passed_over(void **state)
{
    fixture *f = *state;
    assert_loads(f, "\xef\xbb\xbf{" ASSET "}");
}

static void broken_json_is_refused_with_its_line(void **state)
{
    fixture *f = *state;
    assert_refused(f, "", CLAST_ERROR_MALFORMED, "JSON, line 1");
    assert_refused(f, "[]", CLAST_ERROR_MALFORMED, "not an object");
    assert_refused(f, "{" ASSET ",\n'nodes':}", CLAST_ERROR_MALFORMED, "JSON, line 2");
    assert_refused(f, "{" ASSET "} x", CLAST_ERROR_MALFORMED, "JSON");
    assert_refused(f, "{" ASSET ",'a':1e999}", CLAST_ERROR_MALFORMED, "JSON");
    assert_refused(f, "{" ASSET ",'a':1,'a':2}", CLAST_ERROR_MALFORMED, "duplicate");
    assert_refused(f, "{" ASSET ",'a':'\xff'}", CLAST_ERROR_MALFORMED, "JSON");
}

static void deep_nesting_is_refused(void **state)
{
    fixture *f = *state;
    char text[20000];
    memset(text, '[', sizeof text);
    memcpy(text, "{'a':", 5);
    text[sizeof text - 1] = '\0';
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "JSON");
}

static void lists_of_a_wrong_type_are_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, "{" ASSET ",'meshes':{}}", CLAST_ERROR_MALFORMED, "meshes: an object: expected an array");
    assert_refused(f, "{" ASSET ",'nodes':[7]}", CLAST_ERROR_MALFORMED, "nodes[0]: a number: expected an object");
    assert_refused(f, "{" ASSET ",'scenes':[null]}", CLAST_ERROR_MALFORMED, "scenes[0]: null: expected an object");
    assert_refused(f, "{'asset':2}", CLAST_ERROR_MALFORMED, "asset: a number: expected an object");
}

// ------------------------------------------------------------------------------------------------- version, extensions

static void versions_are_checked(void **state)
{
    fixture *f = *state;
    assert_loads(f, "{'asset':{'version':'2.7'}}");
    assert_loads(f, "{'asset':{'version':'2.7','minVersion':'2.0'}}");
    assert_refused(f, "{'asset':{'version':'2.7','minVersion':'2.1'}}", CLAST_ERROR_UNSUPPORTED, "version 2.1");
    assert_refused(f, "{'asset':{'version':'1.0'}}", CLAST_ERROR_UNSUPPORTED, "version 1.0");
    assert_refused(f, "{'asset':{'version':'3.0'}}", CLAST_ERROR_UNSUPPORTED, "version 3.0");
    assert_refused(f, "{'asset':{'version':'2'}}", CLAST_ERROR_MALFORMED, "asset.version");
    assert_refused(f, "{'asset':{'version':'2.0x'}}", CLAST_ERROR_MALFORMED, "asset.version");
    assert_refused(f, "{'asset':{'version':2.0}}", CLAST_ERROR_MALFORMED, "asset.version: a number: expected a text");
    assert_refused(f, "{'asset':{}}", CLAST_ERROR_MALFORMED, "asset.version");
    assert_refused(f, "{}", CLAST_ERROR_MALFORMED, "asset.version");
}

static void a_needed_extension_that_is_lacking_is_named(void **state)
{
    fixture *f = *state;
    assert_refused(f, "{" ASSET ",'extensionsRequired':['KHR_mesh_quantization','VENDOR_magic']}",
                   CLAST_ERROR_UNSUPPORTED, "needs the extension VENDOR_magic");
    assert_refused(f, "{" ASSET ",'extensionsRequired':[7]}", CLAST_ERROR_MALFORMED, "extensionsRequired[0]");
    assert_refused(f, "{" ASSET ",'extensionsRequired':'x'}", CLAST_ERROR_MALFORMED, "extensionsRequired");
    assert_loads(f, "{" ASSET
                    ",'extensionsRequired':['KHR_mesh_quantization','KHR_texture_transform','KHR_lights_punctual',"
                    "'KHR_materials_emissive_strength','EXT_mesh_gpu_instancing']}");
}

static void an_optional_extension_is_logged(void **state)
{
    fixture *f = *state;
    assert_loads(f, "{" ASSET ",'extensionsUsed':['KHR_materials_volume_scatter','KHR_lights_punctual']}");
    assert_non_null(strstr(f->log, "KHR_materials_volume_scatter"));
    assert_null(strstr(f->log, "KHR_lights_punctual"));
    assert_loads(f, "{" ASSET ",'extensionsUsed':['EVIL_\\nlines\\u001b']}");
    assert_non_null(strstr(f->log, "EVIL_ lines  "));
}

// ------------------------------------------------------------------------------------------------------------- buffers

static void a_mapped_buffer_is_used_in_place(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(f, TRIANGLE_WITH(""));
    assert_int_equal(f->scene->file_count, 1);
    assert_ptr_equal(mesh_of(f, 0)->positions, f->scene->files[0].data);
}

static void a_data_uri_is_decoded(void **state)
{
    fixture *f = *state;
    // TRIANGLE in base64.
    const char *text =
        "{" ASSET "," NODE ",'buffers':[{'byteLength':36,'uri':'data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA'}]," MESH(
            "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}],"
                                           "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}";
    assert_loads(f, text);
    assert_floats(mesh_of(f, 0)->positions, TRIANGLE, 9, 0.0f);
    assert_int_equal(f->scene->file_count, 0);
}

// A text whose only buffer has this URI; byteLength 1, read through an accessor of one byte.
static const char *with_uri(fixture *f, const char *uri)
{
    static char text[4096];
    (void)f;
    snprintf(
        text, sizeof text,
        "{" ASSET "," NODE ",'buffers':[{'byteLength':1,'uri':'%s'}]," MESH(
            "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':1}],'accessors':[{'bufferView':0,'componentType':5121,'count':1,'type':'SCALAR'}]}",
        uri);
    return text;
}

static void broken_data_uris_are_refused(void **state)
{
    fixture *f = *state;
    const char *broken[] = {"data:;base64,A",
                            "data:;base64,AA",
                            "data:;base64,AAA",
                            "data:;base64,AA A",
                            "data:;base64,A===",
                            "data:;base64,====",
                            "data:;base64,AA==AA==",
                            "data:;base64,AA=A",
                            "data:;base64,AA-_",
                            "data:text/plain,AAAA",
                            "data:;base64",
                            "data:",
                            "data:,"};
    for (size_t i = 0; i < sizeof broken / sizeof *broken; i++) {
        assert_refused(f, with_uri(f, broken[i]), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    }
    // Well-formed ones get as far as their use: an accessor that is no position.
    const char *sound[] = {"data:;base64,AA==", "data:;base64,AAA=", "data:;base64,+/+/",
                           "data:application/gltf-buffer;base64,AAAA"};
    for (size_t i = 0; i < sizeof sound / sizeof *sound; i++) {
        assert_refused(f, with_uri(f, sound[i]), CLAST_ERROR_MALFORMED, "attributes.POSITION: SCALAR of UNSIGNED_BYTE");
    }
    assert_refused(f, with_uri(f, "data:;base64,"), CLAST_ERROR_MALFORMED,
                   "buffers[0]: byteLength 1: expected at most the 0 bytes");
}

static void paths_are_decoded_and_stand_beside_the_file(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "some folder/a%b \xe2\x9d\xa4.bin", "x", 1);
    const char *reaches[] = {"some%20folder/a%25b%20%E2%9d%a4.bin", "some folder/a%25b \xe2\x9d\xa4.bin",
                             "some folder/a%25b \\u2764.bin"};
    for (size_t i = 0; i < sizeof reaches / sizeof *reaches; i++) {
        assert_refused(f, with_uri(f, reaches[i]), CLAST_ERROR_MALFORMED, "attributes.POSITION: SCALAR");
    }
}

static void files_are_looked_for_in_the_folder_of_the_scene(void **state)
{
    fixture *f = *state;
    char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"normalTexture\":{\"index\":0}}],\"textures\":[{\"source\":0}],"
        "\"images\":[{\"uri\":\"../x.png\"}]}";
    memory_files_put(&f->files, "dir/scene.gltf", text, strlen(text));
    memory_files_put(&f->files, "dir/../x.png", "not an image of any type", 24);
    clast_status status = load_file(f, "dir/scene.gltf");
    assert_true(status != CLAST_ERROR_FILE_NOT_FOUND);
}

static void bad_paths_are_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, with_uri(f, "gone.bin"), CLAST_ERROR_FILE_NOT_FOUND, "buffers[0].uri: \"gone.bin\"");
    assert_refused(f, with_uri(f, "a%2.bin"), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "a%zz.bin"), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "a%00.bin"), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "a%"), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    assert_refused(f, with_uri(f, ""), CLAST_ERROR_MALFORMED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "http://host/a.bin"), CLAST_ERROR_UNSUPPORTED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "file:///etc/passwd"), CLAST_ERROR_UNSUPPORTED, "buffers[0].uri");
    assert_refused(f, with_uri(f, "/etc/passwd"), CLAST_ERROR_UNSUPPORTED, "buffers[0].uri");
}

static void ranges_beyond_a_buffer_are_refused(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", TRIANGLE, 35);
    assert_refused(f, TRIANGLE_WITH(""), CLAST_ERROR_MALFORMED,
                   "buffers[0]: byteLength 36: expected at most the 35 bytes");
    put_triangle(f);
#define RANGES(buffer, view, accessor) \
    "{" ASSET "," NODE \
    "," MESH("'attributes':{'POSITION':0}") ",'buffers':[{'uri':'data.bin'" buffer "}],'bufferViews':[{" view \
                                            "}],'accessors':[{'componentType':5126,'type':'VEC3'" accessor "}]}"
    assert_loads(f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':3"));
    assert_refused(f, RANGES("", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':3"), CLAST_ERROR_MALFORMED,
                   "buffers[0].byteLength: missing");
    assert_refused(f, RANGES(",'byteLength':0", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':3"),
                   CLAST_ERROR_MALFORMED, "buffers[0].byteLength: 0");
    assert_refused(f, RANGES(",'byteLength':36", "'byteLength':36", ",'bufferView':0,'count':3"), CLAST_ERROR_MALFORMED,
                   "bufferViews[0]: no buffer");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':1,'byteLength':36", ",'bufferView':0,'count':3"),
                   CLAST_ERROR_MALFORMED, "bufferViews[0].buffer: 1");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':0", ",'bufferView':0,'count':3"), CLAST_ERROR_MALFORMED,
                   "bufferViews[0].byteLength: missing");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':37", ",'bufferView':0,'count':3"),
                   CLAST_ERROR_MALFORMED, "bufferViews[0]: byteOffset 0 and byteLength 37");
    assert_refused(f,
                   RANGES(",'byteLength':36", "'buffer':0,'byteLength':36,'byteOffset':9223372036854775807",
                          ",'bufferView':0,'count':3"),
                   CLAST_ERROR_MALFORMED, "bufferViews[0]: byteOffset");
    assert_refused(
        f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36,'byteOffset':-4", ",'bufferView':0,'count':3"),
        CLAST_ERROR_MALFORMED, "bufferViews[0].byteOffset: -4");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':1,'count':3"),
                   CLAST_ERROR_MALFORMED, "accessors[0].bufferView: 1");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':4"),
                   CLAST_ERROR_MALFORMED, "accessors[0]: 4 elements of 12 bytes");
    assert_refused(f,
                   RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':3,'byteOffset':4"),
                   CLAST_ERROR_MALFORMED, "accessors[0]: 3 elements of 12 bytes");
    assert_refused(f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':1e18"),
                   CLAST_ERROR_MALFORMED, "accessors[0].count");
    assert_refused(
        f, RANGES(",'byteLength':36", "'buffer':0,'byteLength':36", ",'bufferView':0,'count':768614336404564651"),
        CLAST_ERROR_MALFORMED, "accessors[0]: 768614336404564651 elements");
}

// ---------------------------------------------------------------------------------------------------------------- .glb

static size_t put_word(unsigned char *bytes, size_t at, uint32_t word)
{
    for (size_t i = 0; i < 4; i++) {
        bytes[at + i] = (unsigned char)(word >> 8 * i);
    }
    return at + 4;
}

// A .glb of a JSON chunk (' for ") and, where there are bytes, a BIN chunk; padded. Returns its size.
static size_t make_glb(unsigned char *bytes, const char *text, const void *binary, size_t binary_size)
{
    size_t length = strlen(text), padded = (length + 3) / 4 * 4, at = 0;
    memcpy(bytes, "glTF", 4);
    at = put_word(bytes, 4, 2);
    at = put_word(bytes, at, 0);
    at = put_word(bytes, at, (uint32_t)padded);
    at = put_word(bytes, at, 0x4e4f534a);
    for (size_t i = 0; i < padded; i++) {
        bytes[at++] = i >= length ? ' ' : text[i] == '\'' ? '"' : (unsigned char)text[i];
    }
    if (binary != NULL) {
        size_t padded_binary = (binary_size + 3) / 4 * 4;
        at = put_word(bytes, at, (uint32_t)padded_binary);
        at = put_word(bytes, at, 0x004e4942);
        memset(bytes + at, 0, padded_binary);
        memcpy(bytes + at, binary, binary_size);
        at += padded_binary;
    }
    put_word(bytes, 8, (uint32_t)at);
    return at;
}

static const char *GLB_TEXT = "{" ASSET "," NODE ",'buffers':[{'byteLength':36}]," MESH(
    "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}";

static clast_status load_glb(fixture *f, const unsigned char *bytes, size_t size)
{
    memory_files_put(&f->files, "scene.glb", bytes, size);
    return load_file(f, "scene.glb");
}

static void a_binary_file_is_read_in_place(void **state)
{
    fixture *f = *state;
    unsigned char bytes[2048];
    size_t size = make_glb(bytes, GLB_TEXT, TRIANGLE, sizeof TRIANGLE);
    assert_ok(f->context, load_glb(f, bytes, size));
    assert_floats(mesh_of(f, 0)->positions, TRIANGLE, 9, 0.0f);
    assert_int_equal(f->scene->file_count, 1);
    const char *begin = f->scene->files[0].data;
    assert_ptr_equal(mesh_of(f, 0)->positions, begin + size - 36);
    assert_ok(f->context, load_glb(f, bytes, make_glb(bytes, "{" ASSET "}", NULL, 0)));
    assert_ok(f->context, load_glb(f, bytes, make_glb(bytes, "{" ASSET "}", "", 0)));
}

static void every_cut_of_a_binary_file_is_refused(void **state)
{
    fixture *f = *state;
    unsigned char bytes[2048];
    size_t size = make_glb(bytes, GLB_TEXT, TRIANGLE, sizeof TRIANGLE);
    for (size_t cut = 0; cut < size; cut++) {
        assert_int_equal(load_glb(f, bytes, cut), CLAST_ERROR_MALFORMED);
        // Also where the header tells the truth about the cut file; then only the chunks disagree, or the buffer is
        // missing.
        if (cut >= 12) {
            unsigned char honest[2048];
            memcpy(honest, bytes, cut);
            put_word(honest, 8, (uint32_t)cut);
            assert_int_equal(load_glb(f, honest, cut), CLAST_ERROR_MALFORMED);
        }
    }
}

static void broken_chunks_are_refused(void **state)
{
    fixture *f = *state;
    unsigned char bytes[2048];
    size_t size = make_glb(bytes, GLB_TEXT, TRIANGLE, sizeof TRIANGLE), binary = size - 36 - 8;
    put_word(bytes, 4, 1);
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_UNSUPPORTED);
    put_word(bytes, 4, 2);
    put_word(bytes, binary, 37);
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_MALFORMED);
    put_word(bytes, binary, 0xffffffff);
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_MALFORMED);
    put_word(bytes, binary, 36);
    put_word(bytes, binary + 4, 0x4e4f534a); // a second JSON chunk
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_MALFORMED);
    put_word(bytes, binary + 4, 0x12345678); // a type to be ignored, so no buffer
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_MALFORMED);
    assert_non_null(strstr(clast_context_error(f->context), "buffers[0]: no uri"));
    put_word(bytes, 16, 0x004e4942); // BIN first
    assert_int_equal(load_glb(f, bytes, size), CLAST_ERROR_MALFORMED);
}

static void only_the_first_buffer_is_the_binary_chunk(void **state)
{
    fixture *f = *state;
    unsigned char bytes[2048];
    const char *text = "{" ASSET "," NODE ",'buffers':[{'byteLength':36},{'byteLength':36}]," MESH(
        "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':1,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}";
    assert_int_equal(load_glb(f, bytes, make_glb(bytes, text, TRIANGLE, 36)), CLAST_ERROR_MALFORMED);
    assert_non_null(strstr(clast_context_error(f->context), "buffers[1]: no uri"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(a_triangle_is_read),
        GLTF_TEST(an_empty_file_of_a_scene_is_valid),
        GLTF_TEST(a_byte_order_mark_is_passed_over),
        GLTF_TEST(broken_json_is_refused_with_its_line),
        GLTF_TEST(deep_nesting_is_refused),
        GLTF_TEST(lists_of_a_wrong_type_are_refused),
        GLTF_TEST(versions_are_checked),
        GLTF_TEST(a_needed_extension_that_is_lacking_is_named),
        GLTF_TEST(an_optional_extension_is_logged),
        GLTF_TEST(a_mapped_buffer_is_used_in_place),
        GLTF_TEST(a_data_uri_is_decoded),
        GLTF_TEST(broken_data_uris_are_refused),
        GLTF_TEST(paths_are_decoded_and_stand_beside_the_file),
        GLTF_TEST(files_are_looked_for_in_the_folder_of_the_scene),
        GLTF_TEST(bad_paths_are_refused),
        GLTF_TEST(ranges_beyond_a_buffer_are_refused),
        GLTF_TEST(a_binary_file_is_read_in_place),
        GLTF_TEST(every_cut_of_a_binary_file_is_refused),
        GLTF_TEST(broken_chunks_are_refused),
        GLTF_TEST(only_the_first_buffer_is_the_binary_chunk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
