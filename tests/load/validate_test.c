// SPDX-License-Identifier: Apache-2.0
// Validations of files written here: a sound one, and the same with one thing wrong.
#include "loader_fixture.h"

#include "clast/validate.h"

// A triangle with normals, indices, a node that turns, and all of its bytes in a URI.
static const char sound[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0,\"name\":\"turning\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2,\"material\":0}]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0.5},\"alphaMode\":\"OPAQUE\"}],"
    "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}}],"
    "\"samplers\":[{\"input\":3,\"output\":4}]}],"
    "\"accessors\":["
    "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,0]},"
    "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
    "{\"bufferView\":2,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"},"
    "{\"bufferView\":3,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\",\"min\":[0],\"max\":[1]},"
    "{\"bufferView\":4,\"componentType\":5126,\"count\":2,\"type\":\"VEC4\"}],"
    "\"bufferViews\":["
    "{\"buffer\":0,\"byteLength\":36,\"target\":34962},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36,\"target\":34962},"
    "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":6,\"target\":34963},"
    "{\"buffer\":0,\"byteOffset\":80,\"byteLength\":8},{\"buffer\":0,\"byteOffset\":88,\"byteLength\":32}],"
    "\"buffers\":[{\"byteLength\":120,\"uri\":\"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/"
    "AAABAAIAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAA\"}]}";

static clast_validation *validate(fixture *f, const char *name, const void *data, size_t size)
{
    clast_validation *validation;
    memory_files_put(&f->files, name, data, size);
    assert_ok(f->context, clast_validate(f->context, name, &validation));
    return validation;
}

// The sound file with the first `from` made `to`.
static size_t change(const char *from, const char *to, char *changed, size_t most)
{
    const char *at = strstr(sound, from);
    if (at == NULL) {
        fail_msg("no \"%s\" in the file", from);
        return 0;
    }
    int length = snprintf(changed, most, "%.*s%s%s", (int)(at - sound), sound, to, at + strlen(from));
    assert_true(length > 0 && (size_t)length < most);
    return (size_t)length;
}

static void a_sound_file_has_no_fault(void **state)
{
    fixture *f = *state;
    clast_validation *validation = validate(f, "a.gltf", sound, strlen(sound));
    for (size_t i = 0; i < clast_validation_fault_count(validation); i++) {
        const clast_fault *fault = clast_validation_fault(validation, i);
        fail_msg("%s at %s: %s", fault->code, fault->pointer, fault->text);
    }
    clast_validation_destroy(validation);
}

typedef struct broken_case {
    const char *from, *to;
    const char *code, *pointer;
} broken_case;

static const broken_case cases[] = {
    // form
    {"\"version\":\"2.0\"", "\"version\":2.0", "TYPE_MISMATCH", "/asset/version"},
    {"\"version\":\"2.0\"", "\"generator\":\"x\"", "UNDEFINED_PROPERTY", "/asset"},
    {"\"version\":\"2.0\"", "\"version\":\"2\"", "PATTERN_MISMATCH", "/asset/version"},
    {"\"version\":\"2.0\"", "\"version\":\"3.0\"", "UNKNOWN_ASSET_MAJOR_VERSION", "/asset/version"},
    {"\"scene\":0", "\"scene\":1", "UNRESOLVED_REFERENCE", "/scene"},
    {"\"scene\":0", "\"scene\":-1", "INVALID_INDEX", "/scene"},
    {"\"scene\":0", "\"scene\":0.5", "TYPE_MISMATCH", "/scene"},
    {"\"nodes\":[0]", "\"nodes\":[]", "EMPTY_ENTITY", "/scenes/0/nodes"},
    {"\"nodes\":[0]", "\"nodes\":[0,0]", "DUPLICATE_ELEMENTS", "/scenes/0/nodes/1"},
    {"\"nodes\":[0]", "\"nodes\":[true]", "ARRAY_TYPE_MISMATCH", "/scenes/0/nodes"},
    {"\"metallicFactor\":0.5", "\"metallicFactor\":1.5", "VALUE_NOT_IN_RANGE",
     "/materials/0/pbrMetallicRoughness/metallicFactor"},
    {"\"metallicFactor\":0.5", "\"baseColorFactor\":[1,1,1]", "ARRAY_LENGTH_NOT_IN_LIST",
     "/materials/0/pbrMetallicRoughness/baseColorFactor"},
    {"\"OPAQUE\"", "\"GLASS\"", "VALUE_NOT_IN_LIST", "/materials/0/alphaMode"},
    {"\"name\":\"turning\"", "\"name/~\":1", "UNEXPECTED_PROPERTY", "/nodes/0/name~1~0"},
    {"\"name\":\"turning\"", "\"extensions\":{\"KHR_x\":{}}", "UNDECLARED_EXTENSION", "/nodes/0/extensions/KHR_x"},
    {"\"name\":\"turning\"", "\"extras\":1", "NON_OBJECT_EXTRAS", "/nodes/0/extras"},
    {"\"scene\":0", "\"extensionsRequired\":[\"KHR_x\"],\"scene\":0", "UNUSED_EXTENSION_REQUIRED",
     "/extensionsRequired/0"},
    {"\"scene\":0", "\"extensionsUsed\":[\"KHR_x\"],\"scene\":0", "UNSUPPORTED_EXTENSION", "/extensionsUsed/0"},
    {"\"scene\":0", "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"scene\":0", "NON_REQUIRED_EXTENSION",
     "/extensionsUsed/0"},
    {"]}", "]", "INVALID_JSON", ""},
    {"\"scene\":0", "\"cameras\":[{\"type\":\"perspective\"}],\"scene\":0", "ONE_OF_MISMATCH", "/cameras/0"},
    {"\"scene\":0",
     "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":4,\"znear\":2,\"zfar\":1}}],\"scene\":0",
     "CAMERA_ZFAR_LEQUAL_ZNEAR", "/cameras/0/perspective"},
    {"\"scene\":0", "\"images\":[{}],\"scene\":0", "ONE_OF_MISMATCH", "/images/0"},
    {"\"scene\":0", "\"images\":[{\"uri\":\"no.png\"}],\"scene\":0", "IO_ERROR", "/images/0/uri"},
    {"\"scene\":0", "\"images\":[{\"uri\":\"%zz.png\"}],\"scene\":0", "INVALID_URI", "/images/0/uri"},
    {"\"scene\":0", "\"images\":[{\"uri\":\"data:image/png;base64,iVBORw0KGgoAAAAA\"}],\"scene\":0",
     "IMAGE_DATA_INVALID", "/images/0"},
    {"\"scene\":0", "\"images\":[{\"uri\":\"data:image/gif;base64,R0lGODlh\"}],\"scene\":0",
     "IMAGE_UNRECOGNIZED_FORMAT", "/images/0"},
    // nodes
    {"\"name\":\"turning\"", "\"rotation\":[0,0,0,0.9]", "ROTATION_NON_UNIT", "/nodes/0/rotation"},
    {"\"name\":\"turning\"", "\"matrix\":[1,1,0,0,0,1,0,0,0,0,1,0,0,0,0,1]", "NODE_MATRIX_NON_TRS", "/nodes/0/matrix"},
    {"\"name\":\"turning\"", "\"children\":[0]", "NODE_LOOP", "/nodes/0"},
    {"\"name\":\"turning\"", "\"weights\":[1]", "NODE_WEIGHTS_INVALID", "/nodes/0/weights"},
    // accessors
    {"\"count\":3", "\"count\":4", "ACCESSOR_TOO_LONG", "/accessors/0"},
    {"\"count\":3", "\"byteOffset\":2,\"count\":2", "ACCESSOR_OFFSET_ALIGNMENT", "/accessors/0/byteOffset"},
    {"\"min\":[0,0,0]", "\"min\":[0,0]", "ARRAY_LENGTH_NOT_IN_LIST", "/accessors/0/min"},
    {"\"min\":[0,0,0]", "\"min\":[0,0,-1]", "ACCESSOR_MIN_MISMATCH", "/accessors/0/min/2"},
    {"\"max\":[1,1,0]", "\"max\":[0.5,1,0]", "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND", "/accessors/0/max/0"},
    {"\"byteLength\":36", "\"byteLength\":200", "BUFFER_VIEW_TOO_LONG", "/bufferViews/0/byteLength"},
    {"\"byteLength\":120", "\"byteLength\":121", "BUFFER_EMBEDDED_BYTELENGTH_MISMATCH", "/buffers/0"},
    {"\"target\":34963", "\"target\":34962", "BUFFER_VIEW_TARGET_OVERRIDE", "/meshes/0/primitives/0/indices"},
    {"octet-stream", "pdf", "BUFFER_DATA_URI_MIME_TYPE_INVALID", "/buffers/0/uri"},
    // contents
    {"base64,AAAAAAAA", "base64,AADAfwAA", "ACCESSOR_INVALID_FLOAT", "/accessors/0"},
    {"AAABAAIA", "AwABAAIA", "ACCESSOR_INDEX_OOB", "/meshes/0/primitives/0/indices"},
    {"AAABAAIA", "//8BAAIA", "ACCESSOR_INDEX_PRIMITIVE_RESTART", "/meshes/0/primitives/0/indices"},
    {"AAABAAIA", "AQABAAIA", "ACCESSOR_INDEX_TRIANGLE_DEGENERATE", "/meshes/0/primitives/0/indices"},
    {"\"NORMAL\":1", "\"NORMAL\":0", "ACCESSOR_VECTOR3_NON_UNIT", "/meshes/0/primitives/0/attributes/POSITION"},
    {"\"input\":3", "\"input\":2", "ACCESSOR_USAGE_OVERRIDE", "/animations/0/samplers/0/input"},
    {"\"max\":[1]}",
     "\"max\":[1],\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":2,\"componentType\":5121},"
     "\"values\":{\"bufferView\":3,\"byteOffset\":4}}}",
     "ACCESSOR_ANIMATION_INPUT_NON_INCREASING", "/animations/0/samplers/0/input"},
    // animation
    {"\"path\":\"rotation\"", "\"path\":\"scale\"", "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT",
     "/animations/0/channels/0/sampler"},
    {"\"path\":\"rotation\"", "\"path\":\"weights\"", "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS",
     "/animations/0/channels/0/target"},
    {"\"sampler\":0", "\"sampler\":1", "UNRESOLVED_REFERENCE", "/animations/0/channels/0/sampler"},
};

static void each_fault_has_its_code_and_its_place(void **state)
{
    fixture *f = *state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char changed[4096];
        size_t size = change(cases[i].from, cases[i].to, changed, sizeof changed);
        clast_validation *validation = validate(f, "a.gltf", changed, size);
        bool is_there = false;
        for (size_t k = 0; k < clast_validation_fault_count(validation); k++) {
            const clast_fault *fault = clast_validation_fault(validation, k);
            is_there = is_there || (strcmp(fault->code, cases[i].code) == 0 && fault->pointer != NULL &&
                                    strcmp(fault->pointer, cases[i].pointer) == 0);
        }
        if (!is_there) {
            const clast_fault *first = clast_validation_fault(validation, 0);
            fail_msg("%s: no %s at %s, first %s at %s", cases[i].to, cases[i].code, cases[i].pointer,
                     first != NULL ? first->code : "nothing",
                     first != NULL && first->pointer != NULL ? first->pointer : "");
        }
        clast_validation_destroy(validation);
    }
}

static void other_files_have_the_error_of_their_reader(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *name, *text, *code; // null: none
    } files[] = {
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", NULL},
        {"a.obj", "v 0 0 0\nf 1 2 4\n", "FILE_MALFORMED"},
        {"a.ply", "ply\nformat ascii 1.0\nend_header\n", NULL},
        {"a.ply", "ply\nformat klingon 1.0\nend_header\n", "FILE_MALFORMED"},
        {"a.png", "\x89PNG\r\n\x1a\n", "FILE_MALFORMED"},
        {"a.txt", "hello", "FILE_UNSUPPORTED"},
        {"a.pfm", "Pf\n1 1\n-1\n\1\2\3\4", NULL},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        clast_validation *validation = validate(f, files[i].name, files[i].text, strlen(files[i].text));
        const clast_fault *fault = clast_validation_fault(validation, 0);
        uint64_t counts[CLAST_SEVERITY_COUNT];
        clast_validation_count(validation, counts);
        assert_int_equal(counts[CLAST_SEVERITY_ERROR], files[i].code != NULL);
        if (files[i].code != NULL) {
            assert_string_equal(fault->code, files[i].code);
            assert_null(fault->pointer);
            assert_non_null(strstr(fault->text, files[i].name));
        }
        clast_validation_destroy(validation);
    }
    clast_validation *validation;
    assert_int_equal(clast_validate(f->context, "nowhere.gltf", &validation), CLAST_ERROR_FILE_NOT_FOUND);
}

// A file of many faults lists some, and counts all.
static void long_lists_are_cut_and_counted(void **state)
{
    fixture *f = *state;
    enum { NODES = 10500 };
    char *text = malloc(NODES * 3 + 100);
    assert_non_null(text);
    size_t length = (size_t)sprintf(text, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[");
    for (int i = 0; i < NODES; i++) {
        length += (size_t)sprintf(text + length, "%s{}", i > 0 ? "," : "");
    }
    length += (size_t)sprintf(text + length, "]}");
    clast_validation *validation = validate(f, "a.gltf", text, length);
    uint64_t counts[CLAST_SEVERITY_COUNT];
    clast_validation_count(validation, counts);
    assert_int_equal(counts[CLAST_SEVERITY_INFORMATION], 2 * NODES); // empty and unused
    assert_int_equal(clast_validation_fault_count(validation), 10000);
    assert_null(clast_validation_fault(validation, 10000));
    clast_validation_destroy(validation);
    free(text);
}

// Whatever comes: no crash, and nothing left over.
static void any_change_of_a_file_does_no_harm(void **state)
{
    fixture *f = *state;
    char changed[sizeof sound];
    uint32_t random = 1;
    for (int i = 0; i < 6000; i++) {
        memcpy(changed, sound, sizeof sound);
        for (int k = 0; k <= i % 3; k++) {
            random = random * 1664525u + 1013904223u;
            size_t at = (random >> 8) % (sizeof sound - 1);
            random = random * 1664525u + 1013904223u;
            changed[at] = "0123456789{}[]\",:-.eA"[(random >> 16) % 21];
        }
        size_t size = i % 5 == 0 ? (random >> 4) % sizeof sound : sizeof sound - 1;
        clast_validation_destroy(validate(f, "a.gltf", changed, size));
    }
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    char changed[4096];
    size_t size = change("\"metallicFactor\":0.5", "\"metallicFactor\":2", changed, sizeof changed);
    memory_files_put(&f->files, "a.gltf", changed, size);
    for (long blocks = 0;; blocks++) {
        clast_validation *validation;
        f->blocks_left = blocks;
        clast_status status = clast_validate(f->context, "a.gltf", &validation);
        f->blocks_left = -1;
        if (status == CLAST_OK) {
            clast_validation_destroy(validation);
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
        assert_null(validation);
        assert_int_equal(clast_context_memory(f->context), f->memory_before);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(a_sound_file_has_no_fault),
        LOADER_TEST(each_fault_has_its_code_and_its_place),
        LOADER_TEST(other_files_have_the_error_of_their_reader),
        LOADER_TEST(long_lists_are_cut_and_counted),
        LOADER_TEST(any_change_of_a_file_does_no_harm),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
