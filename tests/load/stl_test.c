// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

#define FACET(a, b, c) "facet normal 0 0 1\nouter loop\nvertex " a "\nvertex " b "\nvertex " c "\nendloop\nendfacet\n"
#define SQUARE FACET("0 0 0", "1 0 0", "1 1 0") FACET("1 1 0", "0 1 0", "0 0 0")

typedef struct binary {
    unsigned char bytes[84 + 50 * 4];
    size_t size;
} binary;

static void put_float(binary *file, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 4; i++) {
        file->bytes[file->size++] = (unsigned char)(bits >> (8 * i));
    }
}

// Two triangles that share an edge; `header` begins the file.
static binary square(const char *header)
{
    static const float corners[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
    binary file = {.size = 84};
    memcpy(file.bytes, header, strlen(header));
    file.bytes[80] = 2;
    for (int i = 0; i < 6; i++) {
        for (int k = 0; i % 3 == 0 && k < 3; k++) {
            put_float(&file, NAN); // a normal is never looked at
        }
        for (int k = 0; k < 3; k++) {
            put_float(&file, corners[i][k]);
        }
        file.size += i % 3 == 2 ? 2 : 0;
    }
    return file;
}

static void assert_square(const fixture *f)
{
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    ASSERT_INDICES(mesh->indices, 0, 1, 2, 2, 3, 0);
    ASSERT_FLOATS(mesh->positions, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
    assert_null(mesh->normals);
    assert_int_equal(f->scene->instance_count, 1);
}

static void an_ascii_file_is_read(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.stl", "solid a square\n" SQUARE "endsolid a square\n");
    assert_square(f);
}

static void blanks_and_capitals_do_not_matter(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.stl",
                 "solid\r\n\tFACET NORMAL 0 0 1\r\n OUTER LOOP\r\n  VERTEX 0 0 0\r\n  Vertex 1e0 0 0\r\n\r\n"
                 "  vertex +1. 1 0\r\n ENDLOOP\r\nENDFACET\r\nENDSOLID");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
}

static void several_solids_are_one_mesh(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.stl", "solid a\n" SQUARE "endsolid\nsolid b\n" FACET("0 0 1", "1 0 1", "0 1 1") "endsolid\n");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 3);
    assert_int_equal(mesh_of(f, 0)->vertex_count, 7);
}

static void a_binary_file_is_read_whatever_its_header_says(void **state)
{
    fixture *f = *state;
    const char *headers[] = {"made by hand", "solid in name only", ""};
    for (int i = 0; i < 3; i++) {
        binary file = square(headers[i]);
        memory_files_put(&f->files, "b.stl", file.bytes, file.size);
        assert_ok(f->context, load(f, "b.stl"));
        assert_square(f);
    }
}

static void bytes_after_the_triangles_are_passed_over(void **state)
{
    fixture *f = *state;
    binary file = square("made by hand");
    file.size += 7;
    memory_files_put(&f->files, "b.stl", file.bytes, file.size);
    assert_ok(f->context, load(f, "b.stl"));
    assert_square(f);
}

static void a_file_cut_at_any_length_is_refused(void **state)
{
    fixture *f = *state;
    binary file = square("made by hand");
    for (size_t size = 1; size < file.size; size++) {
        memory_files_put(&f->files, "b.stl", file.bytes, size);
        assert_int_equal(load(f, "b.stl"), CLAST_ERROR_MALFORMED);
    }
}

static void numbers_that_are_not_finite_are_refused(void **state)
{
    fixture *f = *state;
    binary file = square("made by hand");
    file.bytes[84 + 12 + 3] = 0x7f; // of the first corner's x
    file.bytes[84 + 12 + 2] = 0x80;
    memory_files_put(&f->files, "b.stl", file.bytes, file.size);
    assert_int_equal(load(f, "b.stl"), CLAST_ERROR_MALFORMED);
    assert_refused(f, "a.stl", "solid\n" FACET("0 0 0", "nan 0 0", "0 1 0"), CLAST_ERROR_MALFORMED,
                   "line 5: expected three");
    assert_refused(f, "a.stl", "solid\n" FACET("0 0 0", "1e39 0 0", "0 1 0"), CLAST_ERROR_MALFORMED, "line 5");
}

static void what_is_no_facet_is_refused(void **state)
{
    fixture *f = *state;
    assert_refused(f, "a.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", CLAST_ERROR_MALFORMED,
                   "line 6: expected three corners");
    assert_refused(f, "a.stl", "solid\nfacet\nouter loop\nvertex 0 0 0\n", CLAST_ERROR_MALFORMED, "the end of a facet");
    assert_refused(f, "a.stl", "solid\ncorner 0 0 0\n", CLAST_ERROR_MALFORMED, "line 2: expected solid, facet");
    assert_refused(f, "a.stl", "nothing of the kind", CLAST_ERROR_MALFORMED, "expected \"solid\"");
}

static void nothing_to_draw_is_said(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.stl", "solid\nendsolid\n");
    assert_int_equal(f->scene->geometry_count, 0);
    assert_non_null(strstr(f->log, "no triangles"));
}

static void memory_that_runs_out_anywhere_leaves_nothing(void **state)
{
    fixture *f = *state;
    put_text(f, "a.stl", "solid\n" SQUARE "endsolid\n");
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    for (long blocks = 0; status == CLAST_ERROR_OUT_OF_MEMORY; blocks++) {
        f->blocks_left = blocks;
        status = load(f, "a.stl");
    }
    f->blocks_left = -1;
    assert_ok(f->context, status);
    assert_square(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(an_ascii_file_is_read),
        LOADER_TEST(blanks_and_capitals_do_not_matter),
        LOADER_TEST(several_solids_are_one_mesh),
        LOADER_TEST(a_binary_file_is_read_whatever_its_header_says),
        LOADER_TEST(bytes_after_the_triangles_are_passed_over),
        LOADER_TEST(a_file_cut_at_any_length_is_refused),
        LOADER_TEST(numbers_that_are_not_finite_are_refused),
        LOADER_TEST(what_is_no_facet_is_refused),
        LOADER_TEST(nothing_to_draw_is_said),
        LOADER_TEST(memory_that_runs_out_anywhere_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
