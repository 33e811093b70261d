// SPDX-License-Identifier: Apache-2.0
// Real OBJ and PLY models, and broken ones.
#include "test.h"

#include <dirent.h>
#include <string.h>

#include "clast/scene.h"

static char path_text[900];

static clast_status load(clast_context *context, const char *path, clast_scene_counts *counts)
{
    clast_scene *scene;
    *counts = (clast_scene_counts){0};
    clast_status status = clast_scene_load(context, path, &scene);
    if (status == CLAST_OK) {
        clast_scene_count(scene, counts);
        clast_scene_destroy(scene);
    } else {
        assert_null(scene);
        assert_null(strchr(clast_context_error(context), '\n'));
        assert_true(strlen(clast_context_error(context)) > 0);
    }
    return status;
}

static void dense_models_have_all_their_triangles(void **state)
{
    static const struct {
        const char *name;
        uint64_t triangles;
    } models[] = {
        {"bun_zipper.ply", 69451},          {"lucy.ply", 99970},  {"koala.obj", 99994},
        {"nefertiti-lowres.obj", 70000},    {"pizza.obj", 49954}, {"skull.obj", 100002},
        {"sword-quad-dominant.obj", 44582},
    };
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        clast_scene_counts counts;
        snprintf(path_text, sizeof path_text, "%s/dense/%s", test_assets(), models[i].name);
        assert_ok(*state, load(*state, path_text, &counts));
        assert_int_equal(counts.triangles, models[i].triangles);
        assert_int_equal(counts.geometries, 1);
    }
}

static void a_polygon_of_n_corners_is_n_less_two_triangles(void **state)
{
    clast_scene_counts counts;
    snprintf(path_text, sizeof path_text, "%s/osd-shapes/catmark_cube.obj", test_assets());
    assert_ok(*state, load(*state, path_text, &counts));
    assert_int_equal(counts.triangles, 12);
    snprintf(path_text, sizeof path_text, "%s/osd-shapes/loop_icosahedron.obj", test_assets());
    assert_ok(*state, load(*state, path_text, &counts));
    assert_int_equal(counts.triangles, 20);
}

// Loads every file of a folder with one of the extensions; gives how many were read and how many refused.
static void load_all(clast_context *context, const char *folder, const char *extension, int *read, int *refused)
{
    char directory_path[400];
    snprintf(directory_path, sizeof directory_path, "%s/%s", test_assets(), folder);
    DIR *directory = opendir(directory_path);
    assert_non_null(directory);
    *read = *refused = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        const char *dot = strrchr(entry->d_name, '.');
        if (dot == NULL || strcmp(dot, extension) != 0) {
            continue;
        }
        clast_scene_counts counts;
        snprintf(path_text, sizeof path_text, "%s/%s", directory_path, entry->d_name);
        clast_status status = load(context, path_text, &counts);
        *read += status == CLAST_OK;
        *refused += status != CLAST_OK;
    }
    closedir(directory);
}

static void all_subdivision_shapes_load(void **state)
{
    int read, refused;
    load_all(*state, "osd-shapes", ".obj", &read, &refused);
    assert_true(read > 60 && refused == 0);
    load_all(*state, "osd-shapes/hbr-baseline", ".obj", &read, &refused);
    assert_true(read > 60 && refused == 0);
}

static void broken_models_are_refused_or_read(void **state)
{
    int read, refused;
    load_all(*state, "malformed/obj", ".obj", &read, &refused);
    assert_true(refused > 60 && read > 5);
    load_all(*state, "malformed/obj/tinyobj", ".obj", &read, &refused);
    assert_true(refused > 2 && read > 15);
    load_all(*state, "malformed/ply-stl-off", ".ply", &read, &refused);
    assert_true(refused == 2 && read == 4);
    load_all(*state, "malformed/ply-stl-off", ".stl", &read, &refused);
    assert_true(refused == 0 && read == 3);
}

static void broken_libraries_are_refused_or_read(void **state)
{
    char folder[400];
    snprintf(folder, sizeof folder, "%s/malformed/mtl", test_assets());
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        if (strstr(entry->d_name, ".mtl") == NULL) {
            continue;
        }
        char model[] = "/tmp/clast-model-XXXXXX";
        int file = mkstemp(model);
        assert_true(file >= 0);
        FILE *stream = fdopen(file, "w");
        assert_non_null(stream);
        fprintf(stream, "mtllib %s/%s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", folder, entry->d_name);
        fclose(stream);
        snprintf(path_text, sizeof path_text, "%s.obj", model);
        assert_int_equal(rename(model, path_text), 0);
        clast_scene_counts counts;
        load(*state, path_text, &counts);
        remove(path_text);
        count++;
    }
    closedir(directory);
    assert_true(count > 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(dense_models_have_all_their_triangles),
        CONTEXT_TEST(a_polygon_of_n_corners_is_n_less_two_triangles),
        CONTEXT_TEST(all_subdivision_shapes_load),
        CONTEXT_TEST(broken_models_are_refused_or_read),
        CONTEXT_TEST(broken_libraries_are_refused_or_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
