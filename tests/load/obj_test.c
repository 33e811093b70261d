// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void a_face_becomes_triangles_of_shared_vertices(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "f 1 2 3 4\n");
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 4);
    assert_int_equal(mesh->triangle_count, 2);
    assert_null(mesh->normals);
    assert_null(mesh->coordinates[0]);
    assert_null(mesh->colours);
    assert_null(mesh->triangle_materials);
    ASSERT_INDICES(mesh->indices, 0, 1, 2, 0, 2, 3);
    ASSERT_FLOATS(mesh->positions, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
    assert_int_equal(f->scene->instance_count, 1);
}

static void every_form_of_a_corner_is_read(void **state)
{
    fixture *f = *state;
    static const struct {
        const char *face;
        bool coordinates, normals;
    } cases[] = {
        {"f 1 2 3", false, false},           {"fo 1 2 3", false, false},
        {"f -3 -2 -1", false, false},        {"f 1/ 2/ 3/", false, false},
        {"f 1// 2//\t3//", false, false},    {"f 1/1 2/2 3/3", true, false},
        {"f 1/1/ 2/2/ 3/3/", true, false},   {"f 1//1 2//1 3//1", false, true},
        {"f 1/1/1 2/2/1 3/3/1", true, true}, {"f -3/-3/-1 -2/-2/-1 -1/-1/-1", true, true},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[200];
        snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\n%s\n", cases[i].face);
        assert_loads(f, "a.obj", text);
        const clast_mesh *mesh = mesh_of(f, 0);
        ASSERT_INDICES(mesh->indices, 0, 1, 2);
        assert_int_equal(mesh->coordinates[0] != NULL, cases[i].coordinates);
        assert_int_equal(mesh->normals != NULL, cases[i].normals);
    }
}

static void corners_that_differ_in_any_index_are_different_vertices(void **state)
{
    fixture *f = *state;
    assert_loads(
        f, "a.obj",
        SQUARE
        "vt 0 0\nvt 1 0\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/1/1 4/1/1\nf 1/2/1 2/1/1 3/1/1\nf 1/1/2 2/1/1 3/1/1\n");
    assert_int_equal(mesh_of(f, 0)->vertex_count, 6);
    ASSERT_INDICES(mesh_of(f, 0)->indices, 0, 1, 2, 0, 2, 3, 4, 1, 2, 5, 1, 2);
}

static void texture_coordinates_count_from_the_upper_edge(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "vt 0.25 0.125\nvt 0.5\nvt 1 1 0\nf 1/1 2/2 3/3\n");
    ASSERT_FLOATS(mesh_of(f, 0)->coordinates[0], 0, 0.25f, 0.875f, 0.5f, 1, 1, 0);
}

static void normals_are_made_unit_length(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "vn 0 3 4\nf 1//1 2//1 3//1\n");
    ASSERT_FLOATS(mesh_of(f, 0)->normals, 1e-6, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f, 0, 0.6f, 0.8f);
}

static void faces_without_normals_are_flat_beside_those_with(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "v 0 1 1\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\nf 1 3 4\nf 1 4 5\n");
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 9);
    ASSERT_FLOATS(mesh->normals + 9, 1e-6, 0, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 0, 0);
}

static void a_smoothing_group_averages_normals_by_area(void **state)
{
    fixture *f = *state;
    // Two faces meet at a right angle along the y axis; the first has twice the area of the second.
    const char *text = "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\ns 1\nf 1 2 3\nf 1 3 4\n";
    assert_loads(f, "a.obj", text);
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 4);
    float a = 2 / sqrtf(5), b = 1 / sqrtf(5);
    ASSERT_FLOATS(mesh->normals, 1e-6, b, 0, a, 0, 0, 1, b, 0, a, 1, 0, 0);
}

static void smoothing_ends_at_the_group(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\ns 1\nf 1 2 3\ns 2\nf 1 3 4\n");
    assert_int_equal(mesh_of(f, 0)->vertex_count, 6);
    assert_loads(f, "a.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\ns 1\nf 1 2 3\ns off\nf 1 3 4\n");
    assert_int_equal(mesh_of(f, 0)->vertex_count, 6);
    assert_loads(f, "a.obj", "v 0 0 0\nv 2 0 0\nv 0 1 0\nv 0 0 1\ns 1\ns 0\nf 1 2 3\nf 1 3 4\n");
    assert_null(mesh_of(f, 0)->normals);
}

static void smoothing_goes_across_texture_seams(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 1\ns 1\nf 1/1 2/1 3/1\nf 1/2 3/2 4/2\n");
    const clast_mesh *mesh = mesh_of(f, 0);
    assert_int_equal(mesh->vertex_count, 6);
    assert_memory_equal(mesh->normals, mesh->normals + 9, 12);
}

static void vertex_colours_are_those_of_a_display(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "v 0 0 0\nv 1 0 0 1 0 0.5\nv 0 1 0 0 0 0 1\nf 1 2 3\n");
    ASSERT_FLOATS(mesh_of(f, 0)->colours, 1e-5, 1, 1, 1, 1, 1, 0, 0.214041f, 1, 0, 0, 0, 1);
}

static void a_weight_behind_the_position_is_ignored(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "v 0 0 0 1\nv 2 0 0 0.5\nv 0 1 0 1\nf 1 2 3\n");
    ASSERT_FLOATS(mesh_of(f, 0)->positions + 3, 0, 2, 0, 0);
    assert_null(mesh_of(f, 0)->colours);
}

static void objects_become_meshes_of_their_own(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "o empty\no first one\nf 1 2 3\ng part\nf 1 3 4\no second\nf 2 3 4\n");
    assert_int_equal(f->scene->geometry_count, 2);
    assert_string_equal(f->scene->geometries[0].name, "first one");
    assert_string_equal(f->scene->geometries[1].name, "second");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 2);
    assert_int_equal(mesh_of(f, 1)->vertex_count, 3);
    ASSERT_FLOATS(mesh_of(f, 1)->positions, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0);
}

static void lines_may_be_joined_and_end_in_any_way(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "\xef\xbb\xbf# mark\r\nv 0 0 0\r\nv 1 \\\r\n 0 0\rv 0 1 0 # end\n\n  \t\nf 1 2\\\n 3");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
}

static void what_is_not_drawn_is_passed_over(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj",
                 SQUARE "t crease 2/1/0 1 2 3.0\np 1\nl 1 2\ncstype bezier\ncurv 0 1 1 2\nvp 0 1\nmg 1 2\nf 1 2 3\n");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
}

static void faces_may_name_vertices_that_follow(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", "f 1 2 3\n" SQUARE);
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
}

static void faces_of_two_corners_are_left_out_with_a_warning(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE "f 1 2\nf 1 2 3\n");
    assert_int_equal(mesh_of(f, 0)->triangle_count, 1);
    assert_non_null(strstr(f->log, "fewer than three"));
}

static void a_file_without_faces_is_an_empty_scene_with_a_warning(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", SQUARE);
    assert_int_equal(f->scene->geometry_count, 0);
    assert_non_null(strstr(f->log, "no faces"));
}

static void wrong_lines_are_refused_with_their_number(void **state)
{
    fixture *f = *state;
    static const char *const lines[] = {
        "v 0 0",
        "v 0 0 x",
        "v 0 0 nan",
        "v 1e60 0 0",
        "v 0 0 0 0 0",
        "v 1 2 3,4",
        "vt",
        "vt 0 inf",
        "vn 0 0",
        "vn 0 0 0 0",
        "f 1 2 0",
        "f 1 2 x",
        "f 1 2 -9",
        "f 1 2 3/-1",
        "f 1/2/3/4 2 3",
        "f 1 2 99999999999999999999",
        "f 1 2 3a",
        "\x01\x02",
        "=",
        "1 2 3",
        "s",
        "mtllib",
        "f 1 2 9",
        "f 1/1 2/1 3/1",
        "f 1//1 2//1 3//1",
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; i++) {
        char text[200];
        snprintf(text, sizeof text, SQUARE "# five\n%s\nf 1 2 3\n", lines[i]);
        assert_refused(f, "a.obj", text, CLAST_ERROR_MALFORMED, "a.obj, line 6: ");
    }
}

static void broken_files_do_no_harm(void **state)
{
    fixture *f = *state;
    static const char text[] = "mtllib a.mtl\no x\n" SQUARE
                               "vt 0 1\nvn 0 0 1\ns 1\nusemtl m\nf 1/1/1 2/1/1 3/1/1 4/1\\\n/1\nusemtl n\nf -4 -3 -2\n"
                               "o y\nv 1 2 3 1 0 0.5\nf 1 2 3 4 5\n";
    put_text(f, "a.mtl", "newmtl m\nKd 1 0 0\nnewmtl n\n");
    load_broken(f, "a.obj", text, strlen(text), 4000);
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    put_text(f, "a.mtl", "newmtl m\nKd 1 0 0\nnewmtl n\nmap_Kd nowhere.png\n");
    put_text(f, "a.obj",
             "mtllib a.mtl\no x\n" SQUARE
             "v 1 2 3 1 0 0.5\nvt 0 1\nvn 0 0 1\ns 1\nusemtl m\nf 1/1/1 2 3 4 5\nusemtl n\nf 1 2 3\no y\nf 1 2 3\n");
    load_without_memory(f, "a.obj");
}

// While all corners are alike, vertices are numbered by their positions; the first other one changes nothing for those before it.
static void corners_may_be_alike_until_one_is_not(void **state)
{
    fixture *f = *state;
#define ALIKE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 3/3 1/1 2/2\nf 1/1 3/3 4/4\n"
    assert_loads(f, "a.obj", ALIKE);
    ASSERT_INDICES(mesh_of(f, 0)->indices, 0, 1, 2, 1, 0, 3);
    assert_int_equal(mesh_of(f, 0)->vertex_count, 4);
    ASSERT_FLOATS(mesh_of(f, 0)->positions, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0);
    assert_loads(f, "a.obj", ALIKE "f 1/1 3/3 4/1\nf 2/2 3 1/1\n");
    ASSERT_INDICES(mesh_of(f, 0)->indices, 0, 1, 2, 1, 0, 3, 1, 0, 4, 2, 5, 1);
    assert_int_equal(mesh_of(f, 0)->vertex_count, 6);
    ASSERT_FLOATS(mesh_of(f, 0)->coordinates[0], 0, 1, 0, 0, 1, 1, 1, 0, 0, 0, 1, 0, 0);
    assert_loads(
        f, "a.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nvn 0 1 0\nvn 0 0 0\nf 1//1 2//2 3//3\n"); // a normal that is none
    ASSERT_FLOATS(mesh_of(f, 0)->normals, 0, 0, 0, 1, 0, 1, 0, 0, 0, 1);
    assert_loads(f, "a.obj", ALIKE "o second\nf 4/4 2/2 3/3\no third\nf 2/1 3/3 1/1\no empty\n");
    assert_int_equal(f->scene->geometry_count, 3);
    ASSERT_INDICES(mesh_of(f, 1)->indices, 0, 1, 2);
    ASSERT_FLOATS(mesh_of(f, 2)->coordinates[0], 0, 0, 1, 1, 0, 0, 1);
#undef ALIKE
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(a_face_becomes_triangles_of_shared_vertices),
        LOADER_TEST(every_form_of_a_corner_is_read),
        LOADER_TEST(corners_that_differ_in_any_index_are_different_vertices),
        LOADER_TEST(texture_coordinates_count_from_the_upper_edge),
        LOADER_TEST(normals_are_made_unit_length),
        LOADER_TEST(faces_without_normals_are_flat_beside_those_with),
        LOADER_TEST(a_smoothing_group_averages_normals_by_area),
        LOADER_TEST(smoothing_ends_at_the_group),
        LOADER_TEST(smoothing_goes_across_texture_seams),
        LOADER_TEST(vertex_colours_are_those_of_a_display),
        LOADER_TEST(a_weight_behind_the_position_is_ignored),
        LOADER_TEST(objects_become_meshes_of_their_own),
        LOADER_TEST(lines_may_be_joined_and_end_in_any_way),
        LOADER_TEST(what_is_not_drawn_is_passed_over),
        LOADER_TEST(faces_may_name_vertices_that_follow),
        LOADER_TEST(faces_of_two_corners_are_left_out_with_a_warning),
        LOADER_TEST(a_file_without_faces_is_an_empty_scene_with_a_warning),
        LOADER_TEST(wrong_lines_are_refused_with_their_number),
        LOADER_TEST(broken_files_do_no_harm),
        LOADER_TEST(corners_may_be_alike_until_one_is_not),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
