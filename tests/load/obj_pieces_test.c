// SPDX-License-Identifier: Apache-2.0
// OBJ files that are read in pieces: where they are cut and how many threads read them changes nothing, they are never in memory as
// a whole, and one that changes meanwhile is an error.
#include "test.h"

#include <string.h>
#include <unistd.h>

#include "load/obj.h"

static const char text[] =
    "# begins\n"
    "v 0 0 0\nv 1 0 0\r\nv 1 1 \\\n0\nv 0 1 0\rvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 0 2 0\n"
    "f 1/1 2/2 3/3\nusemtl a\nf 1 3 \\\r\n 4\no one\\\ns 1\nf -4//1 -3//-1 -2//2 -1//1\n"
    "g of no use\\\nf 1 2 3\nf 1 2\nusemtl b\n\n\no \no two\nv 0 0 1 1 0 0.5\n\n"
    "f 1/1/1 5/2/2 3/3/1\nf 5 4 3 2 1\ns off\nusemtl a\nf 1/1 2/2 3/3\no three\nusemtl b\n"
    "v 5 5 5\nf 1 6 2 # ends\nf 1/1/2 6/1/2 2/1/2\no none\nusemtl c\n";

static clast_status load_cut(clast_context *context, const char *from, size_t piece, clast_scene **scene)
{
    clast_file_view view = {.data = from, .size = strlen(from)};
    clast_file_source source = {context, view.size, view, -1};
    assert_ok(context, clast_scene_create(context, scene));
    return clast_load_obj_source(*scene, "a.obj", &source, piece);
}

#define ASSERT_ARRAY(got, expected, count) \
    do { \
        assert_int_equal((got) != NULL, (expected) != NULL); \
        if ((expected) != NULL) { \
            assert_memory_equal(got, expected, (count) * sizeof *(expected)); \
        } \
    } while (0)

static void assert_same(const clast_scene *got, const clast_scene *expected)
{
    assert_int_equal(got->geometry_count, expected->geometry_count);
    for (size_t i = 0; i < got->geometry_count; i++) {
        const clast_mesh *a = &got->geometries[i].of.mesh, *b = &expected->geometries[i].of.mesh;
        const char *name = expected->geometries[i].name;
        assert_string_equal(got->geometries[i].name != NULL ? got->geometries[i].name : "", name != NULL ? name : "");
        assert_int_equal(a->vertex_count, b->vertex_count);
        assert_int_equal(a->triangle_count, b->triangle_count);
        assert_int_equal(a->material, b->material);
        ASSERT_ARRAY(a->positions, b->positions, 3 * (size_t)b->vertex_count);
        ASSERT_ARRAY(a->normals, b->normals, 3 * (size_t)b->vertex_count);
        ASSERT_ARRAY(a->coordinates[0], b->coordinates[0], 2 * (size_t)b->vertex_count);
        ASSERT_ARRAY(a->colours, b->colours, 4 * (size_t)b->vertex_count);
        ASSERT_ARRAY(a->indices, b->indices, 3 * (size_t)b->triangle_count);
        ASSERT_ARRAY(a->triangle_materials, b->triangle_materials, (size_t)b->triangle_count);
    }
}

static clast_context *context_of(uint32_t threads)
{
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads}, &context), CLAST_OK);
    return context;
}

static void pieces_of_any_size_on_any_threads_give_the_same_scene(void **state)
{
    (void)state;
    clast_context *alone = context_of(1);
    clast_scene *whole;
    assert_ok(alone, load_cut(alone, text, sizeof text, &whole));
    assert_int_equal(whole->geometry_count, 4);
    assert_string_equal(whole->geometries[1].name, "one");
    assert_string_equal(whole->geometries[2].name, "two");
    assert_int_equal(whole->geometries[2].of.mesh.triangle_count, 5);
    for (uint32_t threads = 1; threads <= 5; threads += 2) {
        clast_context *context = context_of(threads);
        for (size_t piece = 3; piece < sizeof text; piece++) {
            clast_scene *cut;
            assert_ok(context, load_cut(context, text, piece, &cut));
            assert_same(cut, whole);
            clast_scene_destroy(cut);
        }
        clast_context_destroy(context);
    }
    clast_scene_destroy(whole);
    clast_context_destroy(alone);
}

static void the_first_wrong_line_is_told_wherever_it_is_cut(void **state)
{
    (void)state;
    clast_context *context = context_of(3);
    static const struct {
        const char *tail, *error;
    } cases[] = {
        {"v 1 2\nv x\n", "a.obj, line 42: expected v with"},
        {"f 1 2 99\nf 1 2 3/88\n", "a.obj, line 42: a corner's index is beyond the file's vertices"},
        {"f 1 2 99\nf 1 2 3 4 x\n", "a.obj, line 43: expected f with"},
        {"f 1 2 3\\\n 4\nf 1 2 -7\n=", "a.obj, line 44: expected f with"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char wrong[sizeof text + 64];
        snprintf(wrong, sizeof wrong, "%s%s", text, cases[i].tail);
        for (size_t piece = 3; piece < sizeof wrong; piece += 5) {
            clast_scene *scene;
            assert_int_equal(load_cut(context, wrong, piece, &scene), CLAST_ERROR_MALFORMED);
            if (strstr(clast_context_error(context), cases[i].error) == NULL) {
                fail_msg("pieces of %zu: %s, expected %s", piece, clast_context_error(context), cases[i].error);
            }
            clast_scene_destroy(scene);
        }
    }
    clast_context_destroy(context);
}

// What another program does to the file between its survey and its reading.
typedef struct meddler {
    char *bytes;
    const char *from, *to; // of one length
    bool is_done;
} meddler;

static bool meddle(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)stage;
    meddler *m = user;
    char *place = strstr(m->bytes, m->from);
    if (2 * done >= total && !m->is_done) {
        assert_non_null(place);
        memcpy(place, m->to, strlen(m->to));
        m->is_done = true;
    }
    return true;
}

static void a_file_that_changes_while_it_is_read_is_an_error(void **state)
{
    (void)state;
    static const struct {
        const char *from, *to;
    } edits[] = {
        {"f 1 2 3\n", "f 1 2  \n"},     {"f 1 2  \n", "f 1 2 3\n"},
        {"v 2 0 0\n", "# 2 0 0\n"},     {"#v 3 3 3\n", " v 3 3 3\n"},
        {"f 2 3 4 4\n", "f 2 3 4  \n"}, {"f 2 3 4\n", "f 2/3 4\n"},
        {"f 1/1 2/2\n", "f 1/1 2/3\n"}, {"vt 0.5\n", "#t 0.5\n"},
        {"vn 0 0 1\n", "vp 0 0 1\n"},   {"f 3//3 4//4 1//1\n", "f 3//3 4//4 1/11\n"},
        {"#vt 0 0 0\n", " vt 0 0 0\n"}, {"#vn 0 0 0\n", " vn 0 0 0\n"},
    };
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        char bytes[2048] =
            "v 2 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n#v 3 3 3\nvt 0.5\nvt 1\nvt 1\n#vt 0 0 0\n#vn 0 0 0\n"
            "vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n"
            "f 1 2 3\nf 1 2  \nf 2 3 4 4\nf 2 3 4\no x\nf 1/1 2/2\nf 3/3 1/1 2/2\no y\nf 3//3 4//4 1//1\n";
        for (int k = 0; k < 70; k++) { // more pieces than are read at a time
            strcat(bytes, "# a line\n");
        }
        meddler m = {bytes, edits[i].from, edits[i].to, false};
        clast_context *context;
        clast_context_desc desc = {.threads = 1, .progress = {meddle, &m}};
        assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
        uint64_t before = clast_context_memory(context);
        clast_scene *scene;
        clast_status status = load_cut(context, bytes, 3, &scene);
        assert_true(m.is_done);
        clast_scene_destroy(scene);
        bool is_harmless = strcmp(edits[i].from, "f 1/1 2/2\n") == 0; // two corners, before and after
        if (status != (is_harmless ? CLAST_OK : CLAST_ERROR_FILE_READ) && status != CLAST_ERROR_MALFORMED) {
            fail_msg("%s: status %d", edits[i].to, status);
        }
        assert_int_equal(clast_context_memory(context), before);
        clast_context_destroy(context);
    }
}

// The scene keeps 56 bytes a vertex of this grid; the file has about 100.
static void a_large_file_is_never_in_memory_as_a_whole(void **state)
{
    (void)state;
    enum { SIDE = 300 };
    char path[] = "/tmp/clast-obj-XXXXXX.obj";
    int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    FILE *file = fdopen(descriptor, "w");
    for (int i = 0; i < SIDE * SIDE; i++) {
        fprintf(file, "v %d.25 %d.125 0.5\nvt 0.%06d 0.%06d\nvn 0 %d 1\n", i % SIDE, i / SIDE, i, i, i % 3);
    }
    for (int i = 0; i < SIDE * SIDE - SIDE; i++) {
        int a = i + 1, b = a + 1, c = a + SIDE;
        if (a % SIDE != 0) {
            fprintf(file, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", a, a, a, b, b, b, c, c, c);
            fprintf(file, "f %d/%d/%d %d/%d/%d %d/%d/%d\n", b, b, b, c + 1, c + 1, c + 1, c, c, c);
        }
    }
    uint64_t size = (uint64_t)ftell(file);
    fclose(file);
    clast_context *context = context_of(2);
    clast_scene *scene;
    assert_ok(context, clast_scene_load(context, path, &scene));
    uint64_t kept = clast_context_memory(context), peak = clast_context_memory_peak(context);
    remove(path);
    if (size < kept || 10 * peak > 13 * kept) {
        fail_msg("%llu bytes became %llu, at most %llu: expected at most 1.3 times as many", (unsigned long long)size,
                 (unsigned long long)kept, (unsigned long long)peak);
    }
    assert_int_equal(scene->geometries[0].of.mesh.vertex_count, SIDE * SIDE);
    assert_int_equal(scene->geometries[0].of.mesh.triangle_count, 2 * (SIDE - 1) * (SIDE - 1));
    clast_scene_destroy(scene);
    clast_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_of_any_size_on_any_threads_give_the_same_scene),
        cmocka_unit_test(the_first_wrong_line_is_told_wherever_it_is_cut),
        cmocka_unit_test(a_file_that_changes_while_it_is_read_is_an_error),
        cmocka_unit_test(a_large_file_is_never_in_memory_as_a_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
