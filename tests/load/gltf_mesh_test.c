// SPDX-License-Identifier: Apache-2.0
// Accessors of every kind, and primitives of every mode.
#include "gltf_fixture.h"

#include <math.h>

// A text of one mesh whose primitive, buffer views and accessors are given, with data.bin of `bytes` bytes.
#define SHAPE(bytes, primitive, views, accessors) \
    "{" ASSET "," NODE "," BUFFER(bytes) "," MESH(primitive) ",'bufferViews':[" views "],'accessors':[" accessors "]}"
#define WHOLE_VIEW(bytes) "{'buffer':0,'byteLength':" #bytes "}"
#define ACCESSOR(view, component, count, type) \
    "{'bufferView':" #view ",'componentType':" #component ",'count':" #count ",'type':'" type "'}"
#define NORMALISED(view, component, count, type) \
    "{'bufferView':" #view ",'componentType':" #component ",'count':" #count ",'type':'" type "','normalized':true}"

// ----------------------------------------------------------------------------------------------------------- accessors

static void bytes_and_shorts_become_positions(void **state)
{
    fixture *f = *state;
    const int8_t bytes[12] = {-128, 0, 127, 99, 1, 2, 3, 99, -1, -2, -3, 99}; // stride 4: one byte of padding
    memory_files_put(&f->files, "data.bin", bytes, sizeof bytes);
    const char *views = "{'buffer':0,'byteLength':12,'byteStride':4}";
    char text[1024];
    snprintf(text, sizeof text,
             "{" ASSET "," NODE "," BUFFER(12) "," MESH(
                 "'attributes':{'POSITION':0}") ",'bufferViews':[%s],'accessors':[" ACCESSOR(0, 5120, 3, "VEC3") "]}",
             views);
    assert_loads(f, text);
    assert_floats(mesh_of(f, 0)->positions, (float[]){-128, 0, 127, 1, 2, 3, -1, -2, -3}, 9, 0.0f);
    const uint16_t shorts[9] = {0, 65535, 32768, 1, 2, 3, 4, 5, 6};
    memory_files_put(&f->files, "data.bin", shorts, sizeof shorts);
    assert_loads(f, SHAPE(18, "'attributes':{'POSITION':0}", WHOLE_VIEW(18), ACCESSOR(0, 5123, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, (float[]){0, 65535, 32768, 1, 2, 3, 4, 5, 6}, 9, 0.0f);
    assert_loads(f, SHAPE(18, "'attributes':{'POSITION':0}", WHOLE_VIEW(18), ACCESSOR(0, 5122, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, (float[]){0, -1, -32768, 1, 2, 3, 4, 5, 6}, 9, 0.0f);
}

static void normalised_integers_span_one(void **state)
{
    fixture *f = *state;
    const int8_t bytes[9] = {-128, -127, 127, 0, 64, -64, 1, -1, 0};
    memory_files_put(&f->files, "data.bin", bytes, sizeof bytes);
    assert_loads(f, SHAPE(9, "'attributes':{'POSITION':0}", WHOLE_VIEW(9), NORMALISED(0, 5120, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions,
                  (float[]){-1, -1, 1, 0, 64.0f / 127.0f, -64.0f / 127.0f, 1.0f / 127.0f, -1.0f / 127.0f, 0}, 9, 0.0f);
    assert_loads(f, SHAPE(9, "'attributes':{'POSITION':0}", WHOLE_VIEW(9), NORMALISED(0, 5121, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, (float[]){128.0f / 255.0f, 129.0f / 255.0f, 127.0f / 255.0f, 0}, 4, 0.0f);
    const int16_t shorts[9] = {-32768, -32767, 32767, 0, 1, -1, 2, 3, 4};
    memory_files_put(&f->files, "data.bin", shorts, sizeof shorts);
    assert_loads(f, SHAPE(18, "'attributes':{'POSITION':0}", WHOLE_VIEW(18), NORMALISED(0, 5122, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, (float[]){-1, -1, 1, 0, 1.0f / 32767.0f, -1.0f / 32767.0f}, 6, 0.0f);
    assert_loads(f, SHAPE(18, "'attributes':{'POSITION':0}", WHOLE_VIEW(18), NORMALISED(0, 5123, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, (float[]){32768.0f / 65535.0f, 32769.0f / 65535.0f, 32767.0f / 65535.0f, 0},
                  4, 0.0f);
}

static void interleaved_attributes_are_taken_apart(void **state)
{
    fixture *f = *state;
    float vertices[3][8];
    for (int i = 0; i < 3; i++) {
        float vertex[8] = {TRIANGLE[3 * i], TRIANGLE[3 * i + 1], TRIANGLE[3 * i + 2], 0, 0, 1, 0.25f * (float)i, 0.5f};
        memcpy(vertices[i], vertex, sizeof vertex);
    }
    memory_files_put(&f->files, "data.bin", vertices, sizeof vertices);
    assert_loads(
        f, SHAPE(96, "'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2}",
                 "{'buffer':0,'byteLength':96,'byteStride':32}",
                 ACCESSOR(0, 5126, 3,
                          "VEC3") ",{'bufferView':0,'byteOffset':12,'componentType':5126,'count':3,'type':'VEC3'},"
                                  "{'bufferView':0,'byteOffset':24,'componentType':5126,'count':3,'type':'VEC2'}"));
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_floats(mesh->positions, TRIANGLE, 9, 0.0f);
    assert_floats(mesh->normals, (float[]){0, 0, 1, 0, 0, 1, 0, 0, 1}, 9, 0.0f);
    assert_floats(mesh->coordinates[0], (float[]){0, 0.5f, 0.25f, 0.5f, 0.5f, 0.5f}, 6, 0.0f);
    assert_null(mesh->coordinates[1]);
    assert_int_equal(f->scene->file_count, 0); // nothing was used in place
}

static void a_misaligned_mapping_is_copied(void **state)
{
    fixture *f = *state;
    const char *json = "{" ASSET "," NODE ",'buffers':[{'uri':'data.bin','byteLength':36}]," MESH(
        "'attributes':{'POSITION':0}") ",'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}";
    put_triangle(f);
    assert_loads(f, json);
    assert_int_equal(f->scene->file_count, 1);
    // The accessor is aligned in its view, and the view is not in its buffer.
    char shifted[38] = {0};
    memcpy(shifted + 2, TRIANGLE, 36);
    memory_files_put(&f->files, "data.bin", shifted, sizeof shifted);
    assert_loads(f, SHAPE(38, "'attributes':{'POSITION':0}", "{'buffer':0,'byteOffset':2,'byteLength':36}",
                          ACCESSOR(0, 5126, 3, "VEC3")));
    assert_floats(mesh_of(f, 0)->positions, TRIANGLE, 9, 0.0f);
    assert_int_equal(f->scene->file_count, 0);
}

static void sparse_values_replace_elements(void **state)
{
    fixture *f = *state;
    struct {
        float base[9];
        uint16_t indices[2];
        float values[6];
    } data = {.indices = {0, 2}, .values = {7, 8, 9, 4, 5, 6}};
    memcpy(data.base, TRIANGLE, sizeof TRIANGLE);
    memory_files_put(&f->files, "data.bin", &data, sizeof data);
#define SPARSE(base, count, component, index_offset) \
    SHAPE(64, "'attributes':{'POSITION':0}", WHOLE_VIEW(64), \
          "{" base "'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':" #count \
          ",'indices':{'bufferView':0,'byteOffset':" #index_offset ",'componentType':" #component \
          "},'values':{'bufferView':0,'byteOffset':40}}}")
    assert_loads(f, SPARSE("'bufferView':0,", 2, 5123, 36));
    assert_floats(mesh_of(f, 0)->positions, (float[]){7, 8, 9, 1, 0, 0, 4, 5, 6}, 9, 0.0f);
    assert_loads(f, SPARSE("", 2, 5123, 36));
    assert_floats(mesh_of(f, 0)->positions, (float[]){7, 8, 9, 0, 0, 0, 4, 5, 6}, 9, 0.0f);
    assert_refused(f, SPARSE("", 0, 5123, 36), CLAST_ERROR_MALFORMED, "sparse.count: 0");
    assert_refused(f, SPARSE("", 4, 5123, 36), CLAST_ERROR_MALFORMED, "sparse.count: 4");
    assert_refused(f, SPARSE("", 3, 5123, 36), CLAST_ERROR_MALFORMED, "accessors[0].sparse"); // values end before
    assert_refused(f, SPARSE("", 2, 5122, 36), CLAST_ERROR_MALFORMED, "sparse.indices: componentType 5122");
    assert_refused(f, SPARSE("", 2, 5123, 35), CLAST_ERROR_MALFORMED, "sparse.indices: byteOffset 35");
    assert_refused(f, SPARSE("", 2, 5123, 62), CLAST_ERROR_MALFORMED, "sparse.indices: 2 elements");
    assert_refused(f, SPARSE("", 2, 5121, 36), CLAST_ERROR_MALFORMED, "growing order"); // 0, 0
    assert_refused(f, SPARSE("", 2, 5125, 36), CLAST_ERROR_MALFORMED, "growing order"); // beyond the count
}

static void an_accessor_without_view_is_zero_and_bounded(void **state)
{
    fixture *f = *state;
#define ZEROS(count) \
    "{" ASSET "," NODE "," MESH("'attributes':{'POSITION':0}") ",'accessors':[{'componentType':5126,'count':" #count \
                                                               ",'type':'VEC3'}]}"
    assert_loads(f, ZEROS(6));
    assert_floats(mesh_of(f, 0)->positions, (float[18]){0}, 18, 0.0f);
    assert_refused(f, ZEROS(4294967295), CLAST_ERROR_LIMIT, "accessors[0]: count 4294967295 without a bufferView");
}

static void accessor_rules_are_checked(void **state)
{
    fixture *f = *state;
    put_triangle(f);
#define RULE(view, accessor) \
    SHAPE(36, "'attributes':{'POSITION':0}", "{'buffer':0,'byteLength':36" view "}", "{'bufferView':0" accessor "}")
    assert_loads(f, RULE("", ",'componentType':5126.0,'count':3.0,'type':'VEC3'"));
    assert_refused(f, RULE("", ",'componentType':5124,'count':3,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "componentType 5124");
    assert_refused(f, RULE("", ",'count':3,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "accessors[0].componentType: missing");
    assert_refused(f, RULE("", ",'componentType':5126,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "accessors[0].count: missing");
    assert_refused(f, RULE("", ",'componentType':5126,'count':0,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "accessors[0].count: 0");
    assert_refused(f, RULE("", ",'componentType':5126,'count':2.5,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "accessors[0].count: 2.5");
    assert_refused(f, RULE("", ",'componentType':5126,'count':'3','type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "accessors[0].count: a text");
    assert_refused(f, RULE("", ",'componentType':5126,'count':3,'type':'VEC5'"), CLAST_ERROR_MALFORMED, "type VEC5");
    assert_refused(f, RULE("", ",'componentType':5126,'count':3"), CLAST_ERROR_MALFORMED, "type missing");
    assert_refused(f, RULE("", ",'componentType':5126,'count':2,'type':'VEC3','byteOffset':2"), CLAST_ERROR_MALFORMED,
                   "byteOffset 2");
    assert_refused(f, RULE(",'byteStride':8", ",'componentType':5126,'count':2,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "byteStride 8");
    assert_refused(f, RULE(",'byteStride':14", ",'componentType':5126,'count':2,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "stride 14");
    assert_refused(f, RULE(",'byteStride':3", ",'componentType':5121,'count':3,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "byteStride: 3");
    assert_refused(f, RULE(",'byteStride':256", ",'componentType':5126,'count':1,'type':'VEC3'"), CLAST_ERROR_MALFORMED,
                   "byteStride: 256");
    assert_refused(f, RULE("", ",'componentType':5126,'count':3,'type':'VEC3','normalized':1"), CLAST_ERROR_MALFORMED,
                   "normalized: a number");
    // The last element needs no whole stride.
    assert_loads(f, RULE(",'byteStride':24", ",'componentType':5126,'count':2,'type':'VEC3'"));
}

// ---------------------------------------------------------------------------------------------------------- attributes

typedef struct full_vertices {
    float positions[9];
    float normals[9];
    float tangents[12];
    float coordinates[6];
    uint8_t bytes[8];    // texture coordinates, padded to 8
    uint16_t shorts[12]; // colours RGBA
} full_vertices;

static const full_vertices FULL = {
    .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0},
    .normals = {0, 0, 1, 0, 0, 1, 0, 1, 0},
    .tangents = {1, 0, 0, 1, 1, 0, 0, -1, 1, 0, 0, 1},
    .coordinates = {0, 0, 1, 0, 0, 1},
    .bytes = {0, 255, 51, 102, 204, 0, 0, 0},
    .shorts = {0, 65535, 13107, 65535, 26214, 0, 0, 0, 65535, 65535, 65535, 65535},
};

#define FULL_ACCESSOR(offset, component, type, more) \
    "{'bufferView':0,'byteOffset':" #offset ",'componentType':" #component ",'count':3,'type':'" type "'" more "}"

static void all_attributes_are_read(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &FULL, sizeof FULL);
    assert_int_equal(sizeof FULL, 176);
    assert_loads(
        f,
        SHAPE(
            176,
            "'attributes':{'POSITION':0,'NORMAL':1,'TANGENT':2,'TEXCOORD_0':3,'TEXCOORD_1':4,'COLOR_0':5,'JOINTS_0':9,'_MINE':7}",
            WHOLE_VIEW(176),
            FULL_ACCESSOR(0, 5126, "VEC3", "") "," FULL_ACCESSOR(36, 5126, "VEC3", "") "," FULL_ACCESSOR(
                72, 5126, "VEC4",
                "") "," FULL_ACCESSOR(120, 5126, "VEC2",
                                      "") "," FULL_ACCESSOR(144, 5121, "VEC2",
                                                            ",'normalized':true") "," FULL_ACCESSOR(152, 5123, "VEC4",
                                                                                                    ",'normalized':true")));
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_floats(mesh->positions, FULL.positions, 9, 0.0f);
    assert_floats(mesh->normals, FULL.normals, 9, 0.0f);
    assert_floats(mesh->tangents, FULL.tangents, 12, 0.0f);
    assert_floats(mesh->coordinates[0], FULL.coordinates, 6, 0.0f);
    assert_floats(mesh->coordinates[1], (float[]){0, 1, 0.2f, 0.4f, 0.8f, 0}, 6, 1e-7f);
    assert_floats(mesh->colours, (float[]){0, 1, 0.2f, 1, 0.4f, 0, 0, 0, 1, 1, 1, 1}, 12, 1e-7f);
    assert_int_equal(f->scene->file_count, 1); // kept once, for all arrays
}

static void colours_without_alpha_are_opaque(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &FULL, sizeof FULL);
    assert_loads(f, SHAPE(176, "'attributes':{'POSITION':0,'COLOR_0':1}", WHOLE_VIEW(176),
                          FULL_ACCESSOR(0, 5126, "VEC3", "") "," FULL_ACCESSOR(36, 5126, "VEC3", "")));
    assert_floats(mesh_of(f, 0)->colours, (float[]){0, 0, 1, 1, 0, 0, 1, 1, 0, 1, 0, 1}, 12, 0.0f);
    assert_loads(
        f, SHAPE(176, "'attributes':{'POSITION':0,'COLOR_0':1}", WHOLE_VIEW(176),
                 FULL_ACCESSOR(0, 5126, "VEC3",
                               "") ",{'bufferView':0,'byteOffset':144,'componentType':5121,'count':3,'type':'VEC3'}"));
    assert_floats(mesh_of(f, 0)->colours, (float[]){0, 1, 0.2f, 1, 0.4f, 0.8f, 0, 1}, 8, 1e-7f);
    assert_loads(f, SHAPE(176, "'attributes':{'POSITION':0,'COLOR_0':1}", WHOLE_VIEW(176),
                          FULL_ACCESSOR(0, 5126, "VEC3", "") "," FULL_ACCESSOR(72, 5126, "VEC4", "")));
    assert_floats(mesh_of(f, 0)->colours, FULL.tangents, 12, 0.0f);
}

static void attributes_of_wrong_types_are_refused(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &FULL, sizeof FULL);
#define SECOND(name, accessor) \
    SHAPE(176, "'attributes':{'POSITION':0,'" name "':1}", WHOLE_VIEW(176), \
          FULL_ACCESSOR(0, 5126, "VEC3", "") "," accessor)
    assert_refused(f, SECOND("NORMAL", FULL_ACCESSOR(0, 5126, "VEC2", "")), CLAST_ERROR_MALFORMED,
                   "meshes[0].primitives[0].attributes.NORMAL: VEC2 of FLOAT: expected VEC3 of BYTE or SHORT or FLOAT");
    assert_refused(f, SECOND("NORMAL", FULL_ACCESSOR(0, 5123, "VEC3", "")), CLAST_ERROR_MALFORMED,
                   "attributes.NORMAL: VEC3 of UNSIGNED_SHORT");
    assert_refused(f,
                   SHAPE(176, "'attributes':{'POSITION':0,'NORMAL':0,'TANGENT':0}", WHOLE_VIEW(176),
                         FULL_ACCESSOR(0, 5126, "VEC3", "")),
                   CLAST_ERROR_MALFORMED, "attributes.TANGENT: VEC3");
    assert_refused(f, SECOND("TEXCOORD_1", FULL_ACCESSOR(0, 5126, "VEC3", "")), CLAST_ERROR_MALFORMED,
                   "attributes.TEXCOORD_1: VEC3");
    assert_refused(f, SECOND("COLOR_0", FULL_ACCESSOR(0, 5120, "VEC3", "")), CLAST_ERROR_MALFORMED,
                   "attributes.COLOR_0: VEC3 of BYTE");
    assert_refused(f, SECOND("COLOR_0", FULL_ACCESSOR(0, 5126, "VEC2", "")), CLAST_ERROR_MALFORMED,
                   "attributes.COLOR_0: VEC2");
    assert_refused(f, SECOND("COLOR_0", FULL_ACCESSOR(0, 5125, "VEC4", "")), CLAST_ERROR_MALFORMED,
                   "attributes.COLOR_0: VEC4 of UNSIGNED_INT");
    assert_refused(f, SECOND("NORMAL", "{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'}"),
                   CLAST_ERROR_MALFORMED, "attributes.NORMAL: 4 elements: expected one for each of the 3 vertices");
    assert_refused(f, SHAPE(176, "'attributes':{'POSITION':1}", WHOLE_VIEW(176), FULL_ACCESSOR(0, 5126, "VEC3", "")),
                   CLAST_ERROR_MALFORMED, "attributes.POSITION: 1: expected the index of one of the 1 accessors");
    assert_refused(f, SHAPE(176, "'attributes':{'POSITION':true}", WHOLE_VIEW(176), FULL_ACCESSOR(0, 5126, "VEC3", "")),
                   CLAST_ERROR_MALFORMED, "attributes.POSITION: a boolean");
    assert_refused(f, SHAPE(176, "'attributes':[]", WHOLE_VIEW(176), FULL_ACCESSOR(0, 5126, "VEC3", "")),
                   CLAST_ERROR_MALFORMED, "attributes: an array");
    assert_refused(f, SHAPE(176, "'mode':4", WHOLE_VIEW(176), FULL_ACCESSOR(0, 5126, "VEC3", "")),
                   CLAST_ERROR_MALFORMED, "no attributes");
}

static void tangents_without_normals_are_ignored(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &FULL, sizeof FULL);
    assert_loads(f, SECOND("TANGENT", FULL_ACCESSOR(72, 5126, "VEC4", "")));
    assert_null(mesh_of(f, 0)->tangents);
}

static void values_that_are_not_finite_are_refused(void **state)
{
    fixture *f = *state;
    full_vertices data = FULL;
    memory_files_put(&f->files, "data.bin", &data, sizeof data);
    const char *text = SHAPE(176, "'attributes':{'POSITION':0,'NORMAL':1,'TEXCOORD_0':2}", WHOLE_VIEW(176),
                             FULL_ACCESSOR(0, 5126, "VEC3", "") "," FULL_ACCESSOR(
                                 36, 5126, "VEC3", "") "," FULL_ACCESSOR(120, 5126, "VEC2", ""));
    data.positions[7] = NAN;
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "attributes.POSITION: vertex 2 is not finite");
    data = FULL;
    data.normals[3] = INFINITY;
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "attributes.NORMAL: vertex 1 is not finite");
    data = FULL;
    data.coordinates[0] = -INFINITY;
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "attributes.TEXCOORD_0: vertex 0 is not finite");
}

static void normals_are_made_unit_length(void **state)
{
    fixture *f = *state;
    full_vertices data = FULL;
    float odd[9] = {0, 0, 5, 0, 1e-30f, 0, 0, 0, 0}; // the last gets the triangle's
    memcpy(data.normals, odd, sizeof odd);
    memory_files_put(&f->files, "data.bin", &data, sizeof data);
    assert_loads(f, SECOND("NORMAL", FULL_ACCESSOR(36, 5126, "VEC3", "")));
    assert_floats(mesh_of(f, 0)->normals, (float[]){0, 0, 1, 0, 1, 0, 0, 0, 1}, 9, 1e-6f);
    const int8_t bytes[3][4] = {{0, 0, 127, 0}, {0, 90, 90, 0}, {-127, 0, 0, 0}};
    memcpy(data.normals, bytes, sizeof bytes);
    assert_loads(
        f, SHAPE(176, "'attributes':{'POSITION':0,'NORMAL':1}",
                 WHOLE_VIEW(176) ",{'buffer':0,'byteOffset':36,'byteLength':12,'byteStride':4}",
                 FULL_ACCESSOR(0, 5126, "VEC3",
                               "") ",{'bufferView':1,'componentType':5120,'normalized':true,'count':3,'type':'VEC3'}"));
    assert_floats(mesh_of(f, 0)->normals, (float[]){0, 0, 1, 0, sqrtf(0.5f), sqrtf(0.5f), -1, 0, 0}, 9, 1e-6f);
}

// ------------------------------------------------------------------------------------------------------ indices, modes

typedef struct indexed {
    float positions[15];
    uint8_t bytes[8];
    uint16_t shorts[6];
    uint32_t words[6];
} indexed;

static const indexed INDEXED = {
    .positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0},
    .bytes = {4, 3, 2, 1, 0, 1, 0, 0},
    .shorts = {0, 1, 2, 2, 1, 3},
    .words = {2, 1, 3, 4, 0, 1},
};

#define LIST(mode, offset, component, count) \
    SHAPE(104, "'attributes':{'POSITION':0},'indices':1,'mode':" #mode, WHOLE_VIEW(104), \
          ACCESSOR(0, 5126, 5, "VEC3") ",{'bufferView':0,'byteOffset':" #offset ",'componentType':" #component \
                                       ",'count':" #count ",'type':'SCALAR'}")
#define NO_LIST(mode) \
    SHAPE(104, "'attributes':{'POSITION':0},'mode':" #mode, WHOLE_VIEW(104), ACCESSOR(0, 5126, 5, "VEC3"))

static void indices_of_each_width_are_read(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &INDEXED, sizeof INDEXED);
    assert_int_equal(sizeof INDEXED, 104);
    assert_loads(f, LIST(4, 60, 5121, 6));
    assert_int_equal(mesh_of(f, 0)->triangle_count, 2);
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){4, 3, 2, 1, 0, 1}, 6);
    assert_loads(f, LIST(4, 68, 5123, 6));
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){0, 1, 2, 2, 1, 3}, 6);
    assert_loads(f, LIST(4, 80, 5125, 6));
    assert_indices(mesh_of(f, 0)->indices, INDEXED.words, 6);
    const char *begin = f->scene->files[0].data;
    assert_ptr_equal(mesh_of(f, 0)->indices, begin + 80); // in place
}

static void strips_and_fans_face_one_way(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &INDEXED, sizeof INDEXED);
    assert_loads(f, NO_LIST(5));
    assert_int_equal(mesh_of(f, 0)->triangle_count, 3);
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){0, 1, 2, 1, 3, 2, 2, 3, 4}, 9);
    assert_loads(f, NO_LIST(6));
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){0, 1, 2, 0, 2, 3, 0, 3, 4}, 9);
    assert_loads(f, LIST(5, 60, 5121, 5));
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){4, 3, 2, 3, 1, 2, 2, 1, 0}, 9);
    assert_loads(f, LIST(6, 60, 5121, 5));
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){4, 3, 2, 4, 2, 1, 4, 1, 0}, 9);
}

static void points_and_lines_are_left_out(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &INDEXED, sizeof INDEXED);
    const char *texts[] = {NO_LIST(0), NO_LIST(1), NO_LIST(2), NO_LIST(3)};
    for (size_t i = 0; i < 4; i++) {
        assert_loads(f, texts[i]);
        assert_int_equal(f->scene->geometry_count + f->scene->instance_count, 0);
        assert_non_null(strstr(f->log, "meshes[0].primitives[0]: points and lines are left out"));
    }
    assert_refused(f, NO_LIST(7), CLAST_ERROR_MALFORMED, "primitives[0].mode: 7");
}

static void incomplete_triangles_are_left_out_with_a_word(void **state)
{
    fixture *f = *state;
    memory_files_put(&f->files, "data.bin", &INDEXED, sizeof INDEXED);
    assert_loads(f, NO_LIST(4));
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
    assert_non_null(strstr(f->log, "the last 2 are left out"));
    assert_loads(f, LIST(5, 60, 5121, 2));
    assert_int_equal(f->scene->geometry_count, 0);
}

static void indices_out_of_range_are_refused(void **state)
{
    fixture *f = *state;
    indexed data = INDEXED;
    memory_files_put(&f->files, "data.bin", &data, sizeof data);
    data.bytes[3] = 5;
    assert_refused(f, LIST(4, 60, 5121, 6), CLAST_ERROR_MALFORMED, "primitives[0].indices: vertex 5 of 5 (index 3)");
    data.bytes[3] = 255;
    assert_refused(f, LIST(4, 60, 5121, 6), CLAST_ERROR_MALFORMED, "index 3 is 255, which restarts a primitive");
    data.shorts[5] = 65535;
    assert_refused(f, LIST(4, 68, 5123, 6), CLAST_ERROR_MALFORMED, "index 5 is 65535, which restarts a primitive");
    data.words[0] = 70000;
    assert_refused(f, LIST(5, 80, 5125, 6), CLAST_ERROR_MALFORMED, "vertex 70000 of 5 (index 0)");
    data.words[0] = 0xffffffff;
    assert_refused(f, LIST(6, 80, 5125, 6), CLAST_ERROR_MALFORMED, "index 0 is 4294967295, which restarts a primitive");
    assert_refused(f, LIST(4, 60, 5120, 6), CLAST_ERROR_MALFORMED,
                   "indices: SCALAR of BYTE: expected SCALAR of UNSIGNED_BYTE");
    assert_refused(f, LIST(4, 60, 5126, 6), CLAST_ERROR_MALFORMED, "indices: SCALAR of FLOAT");
    assert_refused(f, LIST(4, 60, 5121, 45), CLAST_ERROR_MALFORMED, "accessors[1]: 45 elements");
}

static void the_restart_value_is_refused_where_there_is_such_a_vertex(void **state)
{
    fixture *f = *state;
    static float positions[300][3];
    static unsigned char data[sizeof positions + 4];
    memcpy(data, positions, sizeof positions);
    memcpy(data + sizeof positions, (unsigned char[]){0, 254, 1, 0}, 4);
    memory_files_put(&f->files, "data.bin", data, sizeof data);
    const char *text = SHAPE(
        3604, "'attributes':{'POSITION':0},'indices':1", WHOLE_VIEW(3604),
        ACCESSOR(0, 5126, 300,
                 "VEC3") ",{'bufferView':0,'byteOffset':3600,'componentType':5121,'count':3,'type':'SCALAR'}");
    assert_loads(f, text);
    data[sizeof positions + 1] = 255;
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "index 1 is 255, which restarts a primitive");
}

static void each_primitive_is_a_geometry_shared_by_the_nodes(void **state)
{
    fixture *f = *state;
    put_triangle(f);
    assert_loads(
        f,
        "{" ASSET "," BUFFER(
            36) ",'scenes':[{'nodes':[0,1,2]}],'nodes':[{'mesh':1},{'mesh':0,'name':'second'},{'mesh':1}],"
                "'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]},"
                "{'primitives':[{'attributes':{'POSITION':0}},{'attributes':{'POSITION':0},'mode':0},{'attributes':{'POSITION':0}}]}],"
                "'bufferViews':[{'buffer':0,'byteLength':36}],'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}]}");
    assert_int_equal(f->scene->geometry_count, 3);
    assert_int_equal(f->scene->instance_count, 5);
    uint32_t expected[5] = {0, 1, 2, 0, 1};
    for (size_t i = 0; i < 5; i++) {
        assert_int_equal(f->scene->instances[i].geometry, expected[i]);
    }
    assert_string_equal(f->scene->instances[2].name, "second");
    assert_int_equal(f->scene->file_count, 1);
}

static void a_primitive_keeps_its_part_of_a_long_accessor(void **state)
{
    fixture *f = *state;
    static struct {
        float positions[100][3];
        uint16_t lists[2][3];
    } data = {.lists = {{50, 51, 53}, {0, 1, 2}}};
    for (int i = 0; i < 100; i++) {
        data.positions[i][0] = (float)i;
        data.positions[i][1] = (float)(i * i % 7);
    }
    memory_files_put(&f->files, "data.bin", &data, sizeof data);
    const char *text =
        "{" ASSET "," NODE "," BUFFER(1212) ",'bufferViews':[" WHOLE_VIEW(1212) "],'accessors':[" ACCESSOR(
            0, 5126, 100,
            "VEC3") ",{'bufferView':0,'byteOffset':1200,'componentType':5123,'count':3,'type':'SCALAR'},"
                    "{'bufferView':0,'byteOffset':1206,'componentType':5123,'count':3,'type':'SCALAR'},"
                    "{'componentType':5126,'count':100,'type':'VEC2','sparse':{'count':1,'indices':{'bufferView':0,"
                    "'byteOffset':1204,'componentType':5123},'values':{'bufferView':0,'byteOffset':600}}}],"
                    "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':3},'indices':1},"
                    "{'attributes':{'POSITION':0},'indices':2}]}]}";
    assert_loads(f, text);
    assert_int_equal(mesh_of(f, 0)->vertex_count, 4);
    assert_indices(mesh_of(f, 0)->indices, (uint32_t[]){0, 1, 3}, 3);
    assert_floats(mesh_of(f, 0)->positions, data.positions[50], 12, 0.0f);
    assert_floats(mesh_of(f, 0)->coordinates[0], (float[]){0, 0, 0, 0, 0, 0, 50, (float)(50 * 50 % 7)}, 8, 0.0f);
    assert_int_equal(mesh_of(f, 1)->vertex_count, 3);
    assert_floats(mesh_of(f, 1)->positions, data.positions[0], 9, 0.0f);
    const char *begin = f->scene->files[0].data;
    assert_ptr_equal(mesh_of(f, 0)->positions, begin + 50 * 12); // still in place
    data.positions[52][1] = NAN;
    assert_refused(f, text, CLAST_ERROR_MALFORMED, "attributes.POSITION: vertex 52 is not finite");
}

static void meshes_without_primitives_are_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, "{" ASSET "," NODE ",'meshes':[{}]}", CLAST_ERROR_MALFORMED, "meshes[0]: no primitives");
    assert_refused(f, "{" ASSET "," NODE ",'meshes':[{'primitives':[]}]}", CLAST_ERROR_MALFORMED,
                   "meshes[0]: no primitives");
    assert_refused(f, "{" ASSET "," NODE ",'meshes':[{'primitives':[3]}]}", CLAST_ERROR_MALFORMED,
                   "meshes[0].primitives[0]: a number");
    assert_loads(f, "{" ASSET "," NODE "," MESH("'attributes':{}") "}");
    assert_non_null(strstr(f->log, "without positions"));
}

static void a_compressed_primitive_without_bytes_names_its_extension(void **state)
{
    fixture *f = *state;
    assert_refused(
        f,
        "{" ASSET "," NODE "," MESH(
            "'attributes':{'POSITION':0},'extensions':{'KHR_draco_mesh_compression':{}}") ",'accessors':[{'componentType':5126,'count':3,'type':'VEC3'}]}",
        CLAST_ERROR_UNSUPPORTED, "meshes[0].primitives[0]: needs the extension KHR_draco_mesh_compression");
}

#define PACKED(parameters) \
    "{" ASSET "," NODE "," MESH( \
        "'attributes':{'POSITION':0}") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','min':[0,0,0],'max':[1,1,0]}]," \
                                       "'buffers':[{'byteLength':36}," \
                                       "{'byteLength':48,'uri':'data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA'}]," \
                                       "'bufferViews':[{'buffer':0,'byteLength':36,'extensions':{'KHR_meshopt_compression':{'buffer':1," parameters \
                                       "}}}]}"

static void what_a_compressed_view_says_of_itself_is_checked(void **state)
{
    fixture *f = *state;
    assert_refused(f, PACKED("'byteLength':48,'byteStride':12,'count':3,'mode':'SOMETHING'"), CLAST_ERROR_MALFORMED,
                   "bufferViews[0].extensions.KHR_meshopt_compression: mode SOMETHING");
    assert_refused(f, PACKED("'byteLength':48,'byteStride':12,'count':3,'mode':'ATTRIBUTES','filter':'BLUR'"),
                   CLAST_ERROR_MALFORMED, "filter BLUR");
    assert_refused(f, PACKED("'byteLength':48,'byteStride':12,'count':2,'mode':'ATTRIBUTES'"), CLAST_ERROR_MALFORMED,
                   "2 elements of 12 bytes: expected the 36 bytes of the buffer view");
    assert_refused(f, PACKED("'byteLength':49,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"), CLAST_ERROR_MALFORMED,
                   "expected to lie in the 48 bytes of buffer 1");
    assert_refused(f, PACKED("'byteLength':48,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"), CLAST_ERROR_MALFORMED,
                   "the compressed stream: its first byte is not a0 or a1");
}

static void a_stream_that_stands_for_far_more_bytes_is_refused(void **state)
{
    fixture *f = *state;
    assert_refused(
        f,
        "{" ASSET "," NODE "," MESH(
            "'attributes':{'POSITION':0}") ",'accessors':[{'bufferView':0,"
                                           "'componentType':5126,'count':100000000,'type':'VEC3'}],'buffers':[{'byteLength':1200000000},"
                                           "{'byteLength':3,'uri':'data:application/octet-stream;base64,oQAA'}],'bufferViews':[{'buffer':0,"
                                           "'byteLength':1200000000,'extensions':{'KHR_meshopt_compression':{'buffer':1,'byteLength':3,"
                                           "'byteStride':12,'count':100000000,'mode':'ATTRIBUTES'}}}]}",
        CLAST_ERROR_LIMIT, "1200000000 elements of 1 bytes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        GLTF_TEST(bytes_and_shorts_become_positions),
        GLTF_TEST(normalised_integers_span_one),
        GLTF_TEST(interleaved_attributes_are_taken_apart),
        GLTF_TEST(a_misaligned_mapping_is_copied),
        GLTF_TEST(sparse_values_replace_elements),
        GLTF_TEST(an_accessor_without_view_is_zero_and_bounded),
        GLTF_TEST(accessor_rules_are_checked),
        GLTF_TEST(all_attributes_are_read),
        GLTF_TEST(colours_without_alpha_are_opaque),
        GLTF_TEST(attributes_of_wrong_types_are_refused),
        GLTF_TEST(tangents_without_normals_are_ignored),
        GLTF_TEST(values_that_are_not_finite_are_refused),
        GLTF_TEST(normals_are_made_unit_length),
        GLTF_TEST(indices_of_each_width_are_read),
        GLTF_TEST(strips_and_fans_face_one_way),
        GLTF_TEST(points_and_lines_are_left_out),
        GLTF_TEST(incomplete_triangles_are_left_out_with_a_word),
        GLTF_TEST(indices_out_of_range_are_refused),
        GLTF_TEST(the_restart_value_is_refused_where_there_is_such_a_vertex),
        GLTF_TEST(each_primitive_is_a_geometry_shared_by_the_nodes),
        GLTF_TEST(a_primitive_keeps_its_part_of_a_long_accessor),
        GLTF_TEST(meshes_without_primitives_are_refused),
        GLTF_TEST(a_compressed_primitive_without_bytes_names_its_extension),
        GLTF_TEST(what_a_compressed_view_says_of_itself_is_checked),
        GLTF_TEST(a_stream_that_stands_for_far_more_bytes_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
