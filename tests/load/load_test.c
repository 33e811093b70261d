// SPDX-License-Identifier: Apache-2.0
#include "loader_fixture.h"

#include <unistd.h>

#define OBJ "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
#define PLY \
    "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n"

static void the_contents_tell_the_type_whatever_the_name(void **state)
{
    fixture *f = *state;
    assert_loads(f, "a.obj", PLY);
    assert_non_null(strstr(f->log, "cloud"));
    assert_loads(f, "no extension", " \n{\"models\": [], \"clast\": 1}");
    assert_refused(f, "a.json", "{\"asset\": {\"version\": \"9.0\"}}", CLAST_ERROR_UNSUPPORTED,
                   "9.0"); // the glTF reader's words
    assert_refused(f, "a.obj", "glTF", CLAST_ERROR_MALFORMED, "a.obj");
}

static void a_key_within_texts_or_deeper_does_not_tell_the_type(void **state)
{
    fixture *f = *state;
    assert_refused(f, "a.txt", "{\"a\": \"\\\"clast\\\":\", \"b\": {\"clast\": 1}, \"c\": \"clast\"}",
                   CLAST_ERROR_UNSUPPORTED, "not a file that clast reads");
}

static void the_name_tells_the_rest(void **state)
{
    fixture *f = *state;
    assert_loads(f, "A.OBJ", OBJ);
    assert_int_equal(f->scene->geometry_count, 1);
    assert_refused(f, "a.ply", OBJ, CLAST_ERROR_MALFORMED, "expected ply");
    assert_refused(f, "a.json", "[]", CLAST_ERROR_MALFORMED, "a.json");
    assert_refused(f, "a.foo", OBJ, CLAST_ERROR_UNSUPPORTED,
                   "not a file that clast reads: expected .gltf, .glb, .obj, .ply, .stl or a scene .json");
    assert_refused(f, "obj", OBJ, CLAST_ERROR_UNSUPPORTED, "not a file that clast reads");
}

static void empty_and_missing_files_are_told_apart(void **state)
{
    fixture *f = *state;
    assert_refused(f, "a.obj", "", CLAST_ERROR_MALFORMED, "the file is empty");
    assert_int_equal(load(f, "nowhere.obj"), CLAST_ERROR_FILE_NOT_FOUND);
    assert_non_null(strstr(clast_context_error(f->context), "nowhere.obj"));
}

static void a_folder_is_called_one(void **state)
{
    clast_context *context = *state;
    clast_scene *scene;
    char path[] = "/tmp/clast-folder-XXXXXX";
    assert_non_null(mkdtemp(path));
    assert_int_equal(clast_scene_load(context, path, &scene), CLAST_ERROR_FILE_READ);
    assert_null(scene);
    assert_non_null(strstr(clast_context_error(context), "is a folder"));
    rmdir(path);
}

static void a_scene_may_be_read_into_another(void **state)
{
    fixture *f = *state;
    put_text(f, "a.mtl", "newmtl m\nKd 1 0 0\n");
    assert_loads(f, "a.obj", "mtllib a.mtl\nusemtl m\n" OBJ);
    assert_ok(f->context, clast_load_into(f->scene, "a.obj"));
    assert_int_equal(f->scene->geometry_count, 2);
    assert_int_equal(mesh_of(f, 0)->material, 1);
    assert_int_equal(mesh_of(f, 1)->material, 2);
    assert_int_equal(f->scene->instances[1].geometry, 1);
}

static void wrong_arguments_are_refused(void **state)
{
    fixture *f = *state;
    clast_scene *scene;
    assert_int_equal(clast_scene_load(NULL, "a.obj", &scene), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_scene_load(f->context, NULL, &scene), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_scene_load(f->context, "a.obj", NULL), CLAST_ERROR_INVALID_ARGUMENT);
}

static bool cancel(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)user;
    (void)stage;
    (void)done;
    (void)total;
    return false;
}

static void loading_can_be_cancelled(void **state)
{
    (void)state;
    memory_files files = {.count = 0};
    memory_files_put(&files, "a.obj", OBJ, strlen(OBJ));
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .progress = {cancel, NULL}, .file = memory_files_hook(&files)};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    uint64_t before = clast_context_memory(context);
    clast_scene *scene;
    assert_int_equal(clast_scene_load(context, "a.obj", &scene), CLAST_ERROR_CANCELLED);
    assert_int_equal(clast_context_memory(context), before);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(the_contents_tell_the_type_whatever_the_name),
        LOADER_TEST(a_key_within_texts_or_deeper_does_not_tell_the_type),
        LOADER_TEST(the_name_tells_the_rest),
        LOADER_TEST(empty_and_missing_files_are_told_apart),
        CONTEXT_TEST(a_folder_is_called_one),
        LOADER_TEST(a_scene_may_be_read_into_another),
        LOADER_TEST(wrong_arguments_are_refused),
        cmocka_unit_test(loading_can_be_cancelled),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
