// SPDX-License-Identifier: Apache-2.0
// Files of many vertices and faces, which are read in chunks: all encodings give one mesh, and a fault has its place wherever it
// is.
#include <unistd.h>

#include "loader_fixture.h"

enum { VERTICES = 40000, FACES = 20001 }; // of triangles, quads, pentagons, and some that are none

typedef enum encoding { TEXT, LITTLE, BIG } encoding;

typedef struct file {
    unsigned char *data;
    size_t size;
    encoding encoding;
} file;

static void add(file *f, const void *value, size_t size, double number)
{
    if (f->encoding == TEXT) {
        f->size += (size_t)sprintf((char *)f->data + f->size, "%.9g ", number);
        return;
    }
    for (size_t i = 0; i < size; i++) {
        f->data[f->size++] = ((const unsigned char *)value)[f->encoding == BIG ? size - 1 - i : i];
    }
}

#define ADD(f, type, value) add(f, &(type){(type)(value)}, sizeof(type), (double)(type)(value))

// One face has a vertex that is not there, where `wrong` is below their number; one vertex has no position, where `odd` is.
static file make(encoding encoding, uint32_t wrong, uint32_t odd)
{
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    file f = {malloc(64 * (VERTICES + FACES) + 30000), 0, encoding};
    assert_non_null(f.data);
    f.size = (size_t)sprintf(
        (char *)f.data,
        "ply\nformat %s 1.0\nelement vertex %d\nproperty short id\nproperty float x\nproperty float y\n"
        "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "element other 1000\nproperty short a\nproperty double b\n"
        "element face %d\nproperty uchar flag\nproperty list uchar int vertex_indices\nproperty float w\n"
        "end_header\n",
        names[encoding], VERTICES, FACES);
    for (uint32_t i = 0; i < VERTICES; i++) {
        ADD(&f, int16_t, i % 1000);
        ADD(&f, float, i == odd ? INFINITY : (float)(i % 200));
        ADD(&f, float, i / 200);
        ADD(&f, double, (i % 7) * 0.25);
        ADD(&f, uint8_t, i);
        ADD(&f, uint8_t, i >> 8);
        ADD(&f, uint8_t, 7);
    }
    for (uint32_t i = 0; i < 1000; i++) { // what is skipped
        ADD(&f, int16_t, i);
        ADD(&f, double, i);
    }
    for (uint32_t i = 0; i < FACES; i++) {
        uint32_t corner = i % 39000, count = i % 5 == 4 ? 2 : 3 + i % 3;
        const uint32_t corners[5] = {corner, corner + 1, corner + 201, corner + 200, corner + 100};
        ADD(&f, uint8_t, 1);
        ADD(&f, uint8_t, count);
        for (uint32_t k = 0; k < count; k++) {
            ADD(&f, int32_t, i == wrong && k == 1 ? VERTICES : corners[k]);
        }
        ADD(&f, float, 0.5f);
    }
    return f;
}

static clast_status load_file(fixture *f, const file *made)
{
    memory_files_put(&f->files, "a.ply", made->data, made->size);
    return load(f, "a.ply");
}

static void all_encodings_give_one_mesh(void **state)
{
    fixture *f = *state;
    uint32_t *indices = NULL, triangles = 0;
    float *positions = NULL;
    for (int encoding = TEXT; encoding <= BIG; encoding++) {
        file made = make((enum encoding)encoding, FACES, VERTICES);
        assert_ok(f->context, load_file(f, &made));
        const clast_mesh *mesh = mesh_of(f, 0);
        assert_int_equal(mesh->vertex_count, VERTICES);
        assert_non_null(strstr(f->log, "4000 faces have fewer than three corners"));
        if (encoding == TEXT) {
            triangles = mesh->triangle_count;
            indices = malloc(12 * (size_t)triangles);
            positions = malloc(12 * VERTICES);
            assert_true(indices != NULL && positions != NULL);
            memcpy(indices, mesh->indices, 12 * (size_t)triangles);
            memcpy(positions, mesh->positions, 12 * VERTICES);
        }
        assert_int_equal(mesh->triangle_count, triangles);
        assert_memory_equal(mesh->indices, indices, 12 * (size_t)triangles);
        assert_memory_equal(mesh->positions, positions, 12 * VERTICES);
        free(made.data);
    }
    free(indices);
    free(positions);
}

static void faults_have_their_place_in_any_chunk(void **state)
{
    fixture *f = *state;
    static const uint32_t places[] = {0, 8191, 8192, 16385, 20000};
    char words[64];
    for (size_t i = 0; i < 5; i++) {
        file made = make(LITTLE, places[i], VERTICES);
        assert_int_equal(load_file(f, &made), CLAST_ERROR_MALFORMED);
        snprintf(words, sizeof words, "face %u (byte", places[i]);
        if (strstr(clast_context_error(f->context), words) == NULL) {
            fail_msg("no \"%s\" in \"%s\"", words, clast_context_error(f->context));
        }
        free(made.data);
        made = make(BIG, FACES, places[i] * 2 - (places[i] == 20000));
        assert_int_equal(load_file(f, &made), CLAST_ERROR_MALFORMED);
        snprintf(words, sizeof words, "vertex %u (byte", places[i] * 2 - (places[i] == 20000));
        if (strstr(clast_context_error(f->context), words) == NULL) {
            fail_msg("no \"%s\" in \"%s\"", words, clast_context_error(f->context));
        }
        free(made.data);
    }
}

static void a_file_that_ends_in_any_chunk_is_refused(void **state)
{
    fixture *f = *state;
    file made = make(LITTLE, FACES, VERTICES);
    for (size_t cut = 1; cut < made.size / 4; cut = cut * 3 + 1) {
        file shorter = {made.data, made.size - cut, LITTLE};
        assert_int_equal(load_file(f, &shorter), CLAST_ERROR_MALFORMED);
    }
    free(made.data);
}

// Loads a file from the disk, which is read piece by piece.
static clast_status load_from_disk(clast_context *context, const file *made, clast_scene **scene)
{
    char path[] = "/tmp/clast-ply-XXXXXX.ply";
    int descriptor = mkstemps(path, 4);
    assert_true(descriptor >= 0);
    FILE *stream = fdopen(descriptor, "wb");
    assert_int_equal(fwrite(made->data, 1, made->size, stream), made->size);
    fclose(stream);
    clast_status status = clast_scene_load(context, path, scene);
    remove(path);
    return status;
}

static void a_file_on_the_disk_is_the_same_and_not_in_memory_as_a_whole(void **state)
{
    fixture *f = *state;
    for (int encoding = TEXT; encoding <= BIG; encoding++) {
        clast_context *context;
        clast_scene *scene;
        file made = make(encoding, FACES, VERTICES);
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 3}, &context), CLAST_OK);
        assert_ok(context, load_from_disk(context, &made, &scene));
        assert_ok(f->context, load_file(f, &made));
        const clast_mesh *mesh = &scene->geometries[0].of.mesh, *expected = mesh_of(f, 0);
        assert_int_equal(mesh->vertex_count, expected->vertex_count);
        assert_int_equal(mesh->triangle_count, expected->triangle_count);
        assert_memory_equal(mesh->positions, expected->positions, 12 * (size_t)mesh->vertex_count);
        assert_memory_equal(mesh->colours, expected->colours, 16 * (size_t)mesh->vertex_count);
        assert_memory_equal(mesh->indices, expected->indices, 12 * (size_t)mesh->triangle_count);
        uint64_t kept = clast_context_memory(context), peak = clast_context_memory_peak(context);
        if (encoding != TEXT && 2 * (peak - kept) > made.size) {
            fail_msg("%zu bytes became %llu, at most %llu", made.size, (unsigned long long)kept,
                     (unsigned long long)peak);
        }
        clast_scene_destroy(scene);
        clast_context_destroy(context);
        free(made.data);
    }
}

static void faults_of_a_file_on_the_disk_have_their_place(void **state)
{
    fixture *f = *state;
    static const uint32_t places[][2] = {{FACES, 0}, {FACES, 33333}, {7, VERTICES}, {FACES - 1, VERTICES}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        clast_context *context;
        clast_scene *scene;
        file made = make(i % 2 == 0 ? LITTLE : BIG, places[i][0], places[i][1]);
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 3}, &context), CLAST_OK);
        assert_int_equal(load_from_disk(context, &made, &scene), CLAST_ERROR_MALFORMED);
        assert_int_equal(load_file(f, &made), CLAST_ERROR_MALFORMED);
        const char *text = strchr(clast_context_error(context), ','), *expected = clast_context_error(f->context);
        assert_non_null(text);
        assert_non_null(strchr(expected, ','));
        assert_string_equal(text, strchr(expected, ','));
        clast_context_destroy(context);
        free(made.data);
    }
}

static void memory_that_runs_out_is_an_error(void **state)
{
    fixture *f = *state;
    file made = make(LITTLE, FACES, VERTICES);
    memory_files_put(&f->files, "a.ply", made.data, made.size);
    load_without_memory(f, "a.ply");
    free(made.data);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        LOADER_TEST(all_encodings_give_one_mesh),
        LOADER_TEST(faults_have_their_place_in_any_chunk),
        LOADER_TEST(a_file_that_ends_in_any_chunk_is_refused),
        LOADER_TEST(a_file_on_the_disk_is_the_same_and_not_in_memory_as_a_whole),
        LOADER_TEST(faults_of_a_file_on_the_disk_have_their_place),
        LOADER_TEST(memory_that_runs_out_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
