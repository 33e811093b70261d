// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

#define XYZ "property float x\nproperty float y\nproperty float z\n"
#define FACES(count) "element face " #count "\nproperty list uchar int vertex_indices\n"
#define TEXT_HEADER "ply\nformat ascii 1.0\n"
#define TRIANGLE_TEXT TEXT_HEADER "element vertex 3\n" XYZ FACES(1) "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"

// A file's bytes, put together piece by piece.
typedef struct bytes {
    unsigned char data[1024];
    size_t size;
    bool big;
} bytes;

static void add_text(bytes *to, const char *text)
{
    memcpy(to->data + to->size, text, strlen(text));
    to->size += strlen(text);
}

static void add_value(bytes *to, const void *value, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        to->data[to->size++] = ((const unsigned char *)value)[to->big ? size - 1 - i : i];
    }
}

#define ADD(to, type, value) add_value(to, &(type){value}, sizeof(type))

static void a_text_file_is_read(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply", TRIANGLE_TEXT);
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 3);
    ASSERT_INDICES(mesh->indices, 0, 1, 2);
    ASSERT_FLOATS(mesh->positions, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0);
    assert_null(mesh->normals);
    assert_int_equal(f->scene->instance_count, 1);
}

// Every type, properties in odd order, lists of other names, an element that is skipped.
static void write_binary(bytes *file, bool big)
{
    *file = (bytes){.big = big};
    add_text(file, "ply\r\nformat ");
    add_text(file, big ? "binary_big_endian" : "binary_little_endian");
    add_text(
        file,
        " 1.0\r\ncomment property float x\r\nobj_info nothing\r\nelement vertex 3\r\nproperty uchar red\r\nproperty double z\r\n"
        "property int16 y\r\nproperty list uint8 float32 weights\r\nproperty uchar green\r\nproperty float nx\r\nproperty float ny\r\n"
        "property float nz\r\nproperty char x\r\nproperty uchar blue\r\nproperty ushort alpha\r\nproperty float s\r\nproperty float t\r\n"
        "element extra 2\r\nproperty list ushort double numbers\r\nproperty int one\r\nelement face 1\r\nproperty uchar flag\r\n"
        "property list int uint vertex_index\r\nend_header\r\n");
    for (int i = 0; i < 3; i++) {
        ADD(file, uint8_t, 255);
        ADD(file, double, 0.5);
        ADD(file, int16_t, (int16_t)(i == 2 ? 300 : -1));
        ADD(file, uint8_t, (uint8_t)i);
        for (int k = 0; k < i; k++) {
            ADD(file, float, 7.0f);
        }
        ADD(file, uint8_t, 0);
        ADD(file, float, 0.0f);
        ADD(file, float, 0.0f);
        ADD(file, float, -2.0f);
        ADD(file, int8_t, (int8_t)(i == 1 ? -100 : 1));
        ADD(file, uint8_t, 188);
        ADD(file, uint16_t, 65535);
        ADD(file, float, 0.25f);
        ADD(file, float, 0.25f);
    }
    for (int i = 0; i < 2; i++) {
        ADD(file, uint16_t, 2);
        ADD(file, double, 1.0);
        ADD(file, double, 2.0);
        ADD(file, int32_t, 3);
    }
    ADD(file, uint8_t, 9);
    ADD(file, int32_t, 3);
    ADD(file, uint32_t, 2);
    ADD(file, uint32_t, 1);
    ADD(file, uint32_t, 0);
}

static void a_binary_file_of_either_order_is_read(void **state)
{
    fixture *f = *state;
    for (int big = 0; big < 2; big++) {
        bytes file;
        write_binary(&file, big);
        memory_files_put(&f->files, "a.ply", file.data, file.size);
        assert_ok(f->context, load(f, "a.ply"));
        const clast_mesh *mesh = mesh_of(f, 0);
        ASSERT_INDICES(mesh->indices, 2, 1, 0);
        ASSERT_FLOATS(mesh->positions, 0, 1, -1, 0.5f, -100, -1, 0.5f, 1, 300, 0.5f);
        ASSERT_FLOATS(mesh->normals, 0, 0, 0, -1, 0, 0, -1, 0, 0, -1);
        ASSERT_FLOATS(mesh->coordinates[0], 0, 0.25f, 0.75f, 0.25f, 0.75f, 0.25f, 0.75f);
        ASSERT_FLOATS(mesh->colours, 1e-3, 1, 0, 0.5029f, 1);
    }
}

static void colours_of_floats_are_not_scaled(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply",
                 TEXT_HEADER "element vertex 3\n" XYZ
                             "property float red\nproperty float green\nproperty float blue\n" FACES(
                                 1) "end_header\n0 0 0 1 0 0.5\n1 0 0 1 0 0\n0 1 0 1 0 0\n3 0 1 2\n");
    ASSERT_FLOATS(mesh_of(f, 0)->colours, 1e-5, 1, 0, 0.214041f, 1);
}

static void polygons_are_cut(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply",
                 TEXT_HEADER "element vertex 4\n" XYZ FACES(
                     3) "end_header\n0 0 0\n2 -1 0\n0 3 0\n-2 -1 0\n4 0 1 2 3\n2 0 1\n3 0 1 2\n");
    ASSERT_INDICES(mesh_of(f, 0)->indices, 0, 1, 2, 0, 2, 3, 0, 1, 2);
    assert_non_null(strstr(f->log, "1 faces have fewer"));
}

static void strips_are_unrolled_with_their_turns(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply",
                 TEXT_HEADER "element vertex 5\n" XYZ
                             "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
                             "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n9 0 1 2 3 -1 1 2 3 4\n");
    ASSERT_INDICES(mesh_of(f, 0)->indices, 0, 1, 2, 2, 1, 3, 1, 2, 3, 3, 2, 4);
}

static void normals_that_are_nothing_are_computed(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply",
                 TEXT_HEADER "element vertex 3\n" XYZ "property float nx\nproperty float ny\nproperty float nz\n" FACES(
                     1) "end_header\n0 0 0 0 0 0\n1 0 0 0 3 0\n0 1 0 0 0 0\n3 0 1 2\n");
    ASSERT_FLOATS(mesh_of(f, 0)->normals, 1e-6, 0, 0, 1, 0, 1, 0, 0, 0, 1);
}

static void a_cloud_of_points_is_an_empty_scene_with_a_warning(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.ply", TEXT_HEADER "element vertex 2\n" XYZ "end_header\n0 0 0\n1 2 3\n");
    assert_int_equal(f->scene->geometry_count, 0);
    assert_non_null(strstr(f->log, "cloud of 2 points"));
}

static void broken_headers_are_refused(void **state)
{
    fixture *f = *state;
    static const char *const texts[] = {
        "ply\n",
        "ply\nformat ascii 2.0\nend_header\n",
        "ply\nformat binary 1.0\nend_header\n",
        "ply\nend_header\n",
        TEXT_HEADER "element vertex\nend_header\n",
        TEXT_HEADER "element vertex -3\nend_header\n",
        TEXT_HEADER "element vertex 3 4\nend_header\n",
        TEXT_HEADER "property float x\nend_header\n",
        TEXT_HEADER "element vertex 1\nproperty real x\nend_header\n0\n",
        TEXT_HEADER "element vertex 1\nproperty list float int x\nend_header\n0\n",
        TEXT_HEADER "element vertex 1\nproperty float\nend_header\n0\n",
        TEXT_HEADER "vertices 3\nend_header\n",
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        assert_refused(f, "a.ply", texts[i], CLAST_ERROR_MALFORMED, "line ");
    }
}

static void counts_that_the_file_has_no_room_for_are_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, "a.ply", TEXT_HEADER "element vertex 4000000000\n" XYZ "end_header\n0 0 0\n",
                   CLAST_ERROR_MALFORMED, "too short");
    assert_refused(f, "a.ply",
                   TEXT_HEADER "element vertex 3\n" XYZ FACES(1) "end_header\n0 0 0\n0 0 0\n0 0 0\n200 0 1 2\n",
                   CLAST_ERROR_MALFORMED, "line 13");
    assert_true(clast_context_memory_peak(f->context) < 1 << 20);
    bytes file = {.big = false};
    add_text(&file, "ply\nformat binary_little_endian 1.0\nelement vertex 0\n" XYZ
                    "element face 1\nproperty list uint int vertex_indices\nend_header\n");
    ADD(&file, uint32_t, 0xfffffff0u);
    ADD(&file, uint32_t, 0);
    memory_files_put(&f->files, "a.ply", file.data, file.size);
    assert_int_equal(load(f, "a.ply"), CLAST_ERROR_MALFORMED);
    assert_non_null(strstr(clast_context_error(f->context), "face 0"));
}

static void wrong_values_are_refused_with_their_place(void **state)
{
    fixture *f = *state;
#define FILE_WITH(vertex, face) \
    TEXT_HEADER "element vertex 3\n" XYZ FACES(1) "end_header\n0 0 0\n" vertex "\n0 1 0\n" face "\n"
    assert_refused(f, "a.ply", FILE_WITH("1 0 x", "3 0 1 2"), CLAST_ERROR_MALFORMED, "line 11");
    assert_refused(f, "a.ply", FILE_WITH("1 0 nan", "3 0 1 2"), CLAST_ERROR_MALFORMED, "line 11");
    assert_refused(f, "a.ply", FILE_WITH("1 0 1e60", "3 0 1 2"), CLAST_ERROR_MALFORMED, "line 11");
    assert_refused(f, "a.ply", FILE_WITH("1 0 0", "3 0 1 3"), CLAST_ERROR_MALFORMED, "line 13");
    assert_refused(f, "a.ply", FILE_WITH("1 0 0", "3 0 1 -1"), CLAST_ERROR_MALFORMED, "line 13");
    assert_refused(f, "a.ply", FILE_WITH("1 0 0", "3 0 1 0.5"), CLAST_ERROR_MALFORMED, "line 13");
    assert_refused(f, "a.ply", FILE_WITH("1 0 0", "-3 0 1 2"), CLAST_ERROR_MALFORMED, "line 13");
    assert_refused(f, "a.ply", FILE_WITH("1 0 0", "3 0 1"), CLAST_ERROR_MALFORMED, "line 13");
    assert_refused(f, "a.ply",
                   TEXT_HEADER "element vertex 3\nproperty float x\nproperty float y\n" FACES(
                       1) "end_header\n0 0\n1 0\n0 1\n3 0 1 2\n",
                   CLAST_ERROR_MALFORMED, "x, y and z");
    assert_refused(f, "a.ply",
                   TEXT_HEADER FACES(1) "element vertex 3\n" XYZ "end_header\n3 0 1 2\n0 0 0\n0 0 0\n0 0 0\n",
                   CLAST_ERROR_UNSUPPORTED, "faces come before");
}

static void broken_files_do_no_harm(void **state)
{
    fixture *f = *state;
    bytes file;
    for (int big = 0; big < 2; big++) {
        write_binary(&file, big);
        load_broken(f, "a.ply", file.data, file.size, 2000);
    }
    static const char text[] = TEXT_HEADER
        "element vertex 4\n" XYZ "property uchar red\nproperty uchar green\nproperty uchar blue\n" FACES(
            2) "end_header\n0 0 0 1 2 3\n2 -1 0 1 2 3\n0 3 0 1 2 3\n-2 -1 0 1 2 3\n4 0 1 2 3\n3 0 1 2\n";
    load_broken(f, "a.ply", text, strlen(text), 2000);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    bytes file;
    write_binary(&file, false);
    memory_files_put(&f->files, "a.ply", file.data, file.size);
    load_without_memory(f, "a.ply");
    put_text(f, "a.ply",
             TEXT_HEADER "element vertex 4\n" XYZ "property float nx\nproperty float ny\nproperty float nz\n" FACES(
                 1) "end_header\n0 0 0 0 0 0\n1 0 0 0 0 0\n1 1 0 0 0 0\n0 1 0 0 0 0\n4 0 1 2 3\n");
    load_without_memory(f, "a.ply");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(a_text_file_is_read),
        LOADER_TEST(a_binary_file_of_either_order_is_read),
        LOADER_TEST(colours_of_floats_are_not_scaled),
        LOADER_TEST(polygons_are_cut),
        LOADER_TEST(strips_are_unrolled_with_their_turns),
        LOADER_TEST(normals_that_are_nothing_are_computed),
        LOADER_TEST(a_cloud_of_points_is_an_empty_scene_with_a_warning),
        LOADER_TEST(broken_headers_are_refused),
        LOADER_TEST(counts_that_the_file_has_no_room_for_are_refused),
        LOADER_TEST(wrong_values_are_refused_with_their_place),
        LOADER_TEST(broken_files_do_no_harm),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
