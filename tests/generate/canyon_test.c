// SPDX-License-Identifier: Apache-2.0
// The demonstration scene as files: the same for any number of threads, sound glTF, all or nothing.
#include "folder.h"

#include <jansson.h>
#include <math.h>
#include <png.h>

#include "base/file.h"
#include "clast/generate.h"

static clast_status generate(clast_context *context, double detail, uint32_t seed, const folder *to)
{
    return clast_generate(context, &(clast_generate_desc){"canyon", detail, seed}, to->path);
}

// ----------------------------------------------------------------------------------------------------- determinism

static void add_to_hash(const char *path, const char *name, void *data)
{
    uint64_t *sum = data,
             hash = 14695981039346656037u; // FNV-1a of the name and the bytes; sums do not depend on the order
    size_t size;
    unsigned char *bytes = read_whole(path, &size);
    for (const char *c = name; *c != '\0'; c++) {
        hash = (hash ^ (unsigned char)*c) * 1099511628211u;
    }
    for (size_t i = 0; i < size; i++) {
        hash = (hash ^ bytes[i]) * 1099511628211u;
    }
    free(bytes);
    *sum += hash;
}

static uint64_t hash_of_scene(uint32_t threads, uint32_t seed)
{
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads}, &context), CLAST_OK);
    folder to = folder_make();
    assert_ok(context, generate(context, 0.02, seed, &to));
    uint64_t sum = 0;
    assert_true(folder_each(&to, add_to_hash, &sum) > 20);
    folder_remove(&to);
    clast_context_destroy(context);
    return sum;
}

static void threads_do_not_change_a_byte(void **state)
{
    (void)state;
    uint64_t one = hash_of_scene(1, 7);
    assert_true(hash_of_scene(1, 7) == one);
    assert_true(hash_of_scene(2, 7) == one);
    assert_true(hash_of_scene(5, 7) == one);
}

static void seeds_give_different_scenes(void **state)
{
    (void)state;
    assert_true(hash_of_scene(2, 1) != hash_of_scene(2, 2));
}

// ------------------------------------------------------------------------------------------------------------- glTF

typedef struct model {
    json_t *root;
    unsigned char *buffers[8];
    size_t sizes[8];
    size_t buffer_count;
} model;

static json_t *load_json(const folder *from, const char *name)
{
    char path[512];
    folder_file(from, name, path);
    json_error_t error;
    json_t *root = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
    if (root == NULL) {
        fail_msg("%s: %s", name, error.text);
    }
    return root;
}

static model model_load(const folder *from)
{
    model loaded = {.root = load_json(from, "canyon.gltf")};
    json_t *buffers = json_object_get(loaded.root, "buffers");
    loaded.buffer_count = json_array_size(buffers);
    assert_true(loaded.buffer_count <= 8);
    for (size_t i = 0; i < loaded.buffer_count; i++) {
        char path[512];
        json_t *buffer = json_array_get(buffers, i);
        folder_file(from, json_string_value(json_object_get(buffer, "uri")), path);
        loaded.buffers[i] = read_whole(path, &loaded.sizes[i]);
        assert_int_equal(loaded.sizes[i], json_integer_value(json_object_get(buffer, "byteLength")));
    }
    return loaded;
}

static void model_free(model *loaded)
{
    for (size_t i = 0; i < loaded->buffer_count; i++) {
        free(loaded->buffers[i]);
    }
    json_decref(loaded->root);
}

static json_int_t integer(json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

static json_t *element(const model *m, const char *array, json_int_t index)
{
    json_t *found = json_array_get(json_object_get(m->root, array), (size_t)index);
    assert_non_null(found);
    return found;
}

// The elements of an accessor, checked to lie inside their buffer.
static const void *accessor_data(const model *m, json_int_t number, json_int_t component, size_t element_bytes,
                                 size_t *count)
{
    json_t *accessor = element(m, "accessors", number);
    json_t *view = element(m, "bufferViews", integer(accessor, "bufferView"));
    size_t offset = (size_t)(integer(accessor, "byteOffset") + integer(view, "byteOffset"));
    *count = (size_t)integer(accessor, "count");
    assert_int_equal(integer(accessor, "componentType"), component);
    assert_true(*count > 0 && offset % 4 == 0);
    assert_true(offset + *count * element_bytes <= (size_t)(integer(view, "byteOffset") + integer(view, "byteLength")));
    assert_true((size_t)integer(view, "byteLength") <= m->sizes[integer(view, "buffer")]);
    return m->buffers[integer(view, "buffer")] + offset;
}

static json_int_t attribute(json_t *primitive, const char *name)
{
    json_t *found = json_object_get(json_object_get(primitive, "attributes"), name);
    assert_non_null(found);
    return json_integer_value(found);
}

static void each_primitive(const model *m, void (*check)(const model *m, json_t *primitive, void *data), void *data)
{
    size_t i, j;
    json_t *mesh, *primitive;
    json_array_foreach(json_object_get(m->root, "meshes"), i, mesh)
    {
        json_array_foreach(json_object_get(mesh, "primitives"), j, primitive)
        {
            check(m, primitive, data);
        }
    }
}

static void add_triangles(const model *m, json_t *primitive, void *data)
{
    *(uint64_t *)data += (uint64_t)integer(element(m, "accessors", integer(primitive, "indices")), "count") / 3;
}

static void check_indices(const model *m, json_t *primitive, void *data)
{
    (void)data;
    size_t count, vertices;
    const uint32_t *indices = accessor_data(m, integer(primitive, "indices"), 5125, 4, &count);
    const float *positions = accessor_data(m, attribute(primitive, "POSITION"), 5126, 12, &vertices);
    assert_int_equal(count % 3, 0);
    for (size_t i = 0; i < count; i += 3) {
        for (size_t k = 0; k < 3; k++) {
            assert_true(indices[i + k] < vertices);
            const float *a = positions + 3 * indices[i + k], *b = positions + 3 * indices[i + (k + 1) % 3];
            assert_false(a[0] == b[0] && a[1] == b[1] && a[2] == b[2]);
        }
    }
}

static void check_positions(const model *m, json_t *primitive, void *data)
{
    (void)data;
    size_t count;
    const float *positions = accessor_data(m, attribute(primitive, "POSITION"), 5126, 12, &count);
    json_t *accessor = element(m, "accessors", attribute(primitive, "POSITION"));
    for (size_t axis = 0; axis < 3; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            assert_true(isfinite(positions[3 * i + axis]));
            low = fminf(low, positions[3 * i + axis]);
            high = fmaxf(high, positions[3 * i + axis]);
        }
        // Exactly, after the way through decimal digits.
        assert_true((float)json_number_value(json_array_get(json_object_get(accessor, "min"), axis)) == low);
        assert_true((float)json_number_value(json_array_get(json_object_get(accessor, "max"), axis)) == high);
    }
}

static double dot(const float *a, const float *b)
{
    return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

static void check_frames(const model *m, json_t *primitive, void *data)
{
    (void)data;
    size_t count, same;
    const float *normals = accessor_data(m, attribute(primitive, "NORMAL"), 5126, 12, &count);
    const float *tangents = accessor_data(m, attribute(primitive, "TANGENT"), 5126, 16, &same);
    assert_int_equal(count, same);
    const float *coordinates = accessor_data(m, attribute(primitive, "TEXCOORD_0"), 5126, 8, &same);
    assert_int_equal(count, same);
    accessor_data(m, attribute(primitive, "COLOR_0"), 5123, 8, &same);
    assert_int_equal(count, same);
    for (size_t i = 0; i < count; i++) {
        assert_true(fabs(dot(normals + 3 * i, normals + 3 * i) - 1.0) < 1e-5);
        assert_true(fabs(dot(tangents + 4 * i, tangents + 4 * i) - 1.0) < 1e-5);
        assert_true(fabs(dot(normals + 3 * i, tangents + 4 * i)) < 1e-3);
        assert_true(fabsf(tangents[4 * i + 3]) == 1.0f);
        assert_true(isfinite(coordinates[2 * i]) && isfinite(coordinates[2 * i + 1]));
    }
}

// Normals agree with the side that triangles face, but for a few at sharp creases.
static void check_sides(const model *m, json_t *primitive, void *data)
{
    (void)data;
    size_t count, vertices, against = 0;
    const uint32_t *indices = accessor_data(m, integer(primitive, "indices"), 5125, 4, &count);
    const float *positions = accessor_data(m, attribute(primitive, "POSITION"), 5126, 12, &vertices);
    const float *normals = accessor_data(m, attribute(primitive, "NORMAL"), 5126, 12, &vertices);
    for (size_t i = 0; i < count; i += 3) {
        const float *a = positions + 3 * indices[i], *b = positions + 3 * indices[i + 1],
                    *c = positions + 3 * indices[i + 2];
        float u[3], v[3];
        for (int k = 0; k < 3; k++) {
            u[k] = b[k] - a[k];
            v[k] = c[k] - a[k];
        }
        float cross[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        double sum = 0.0;
        for (size_t k = 0; k < 3; k++) {
            sum += dot(cross, normals + 3 * indices[i + k]);
        }
        against += sum < 0.0;
    }
    if (against * 20 > count / 3) {
        fail_msg("%zu of %zu triangles face away from their normals", against, count / 3);
    }
}

static void check_nodes(const model *m)
{
    size_t i, cameras = 0;
    json_t *node;
    json_array_foreach(json_object_get(m->root, "nodes"), i, node)
    {
        json_t *mesh = json_object_get(node, "mesh"), *rotation = json_object_get(node, "rotation");
        cameras += json_object_get(node, "camera") != NULL;
        assert_true(mesh == NULL ||
                    (size_t)json_integer_value(mesh) < json_array_size(json_object_get(m->root, "meshes")));
        if (rotation != NULL) {
            double square = 0.0;
            for (size_t k = 0; k < 4; k++) {
                double x = json_number_value(json_array_get(rotation, k));
                square += x * x;
            }
            assert_true(fabs(square - 1.0) < 1e-5);
        }
    }
    assert_int_equal(cameras, 3);
    assert_true(i > 300);
}

static void the_gltf_is_sound(void **state)
{
    clast_context *context = *state;
    folder to = folder_make();
    assert_ok(context, generate(context, 0.05, 3, &to));
    model m = model_load(&to);
    each_primitive(&m, check_indices, NULL);
    each_primitive(&m, check_positions, NULL);
    each_primitive(&m, check_frames, NULL);
    each_primitive(&m, check_sides, NULL);
    check_nodes(&m);
    model_free(&m);
    folder_remove(&to);
}

static void detail_scales_the_number_of_triangles(void **state)
{
    clast_context *context = *state;
    static const double details[] = {0.02, 0.1, 0.4};
    for (size_t i = 0; i < 3; i++) {
        folder to = folder_make();
        assert_ok(context, generate(context, details[i], 0, &to));
        model m = model_load(&to);
        uint64_t triangles = 0;
        each_primitive(&m, add_triangles, &triangles);
        double ratio = (double)triangles / (details[i] * 1e6);
        if (ratio < 0.85 || ratio > 1.15) {
            fail_msg("detail %g gives %llu triangles", details[i], (unsigned long long)triangles);
        }
        model_free(&m);
        folder_remove(&to);
    }
}

// --------------------------------------------------------------------------------------------- pictures, scene file

static void check_picture(const char *path, const char *name, void *data)
{
    uint32_t *count = data;
    if (strstr(name, ".png") == NULL) {
        return;
    }
    png_image image = {.version = PNG_IMAGE_VERSION};
    assert_true(png_image_begin_read_from_file(&image, path) != 0);
    assert_true(image.width >= 64 && (image.width & (image.width - 1)) == 0 && image.height >= 64);
    bool deep = strstr(name, "height") != NULL;
    assert_int_equal((image.format & PNG_FORMAT_FLAG_LINEAR) != 0, deep); // 16-bit
    image.format = deep ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_RGB;
    void *pixels = malloc(PNG_IMAGE_SIZE(image));
    assert_true(png_image_finish_read(&image, NULL, pixels, 0, NULL) != 0);
    if (strstr(name, "normal") != NULL) {
        const unsigned char *p = pixels;
        for (size_t i = 0; i < (size_t)image.width * image.height; i++) {
            float n[3] = {(float)p[3 * i] / 127.5f - 1.0f, (float)p[3 * i + 1] / 127.5f - 1.0f,
                          (float)p[3 * i + 2] / 127.5f - 1.0f};
            assert_true(fabs(sqrt(dot(n, n)) - 1.0) < 0.02);
        }
    }
    free(pixels);
    ++*count;
}

static void pictures_can_be_read(void **state)
{
    clast_context *context = *state;
    folder to = folder_make();
    assert_ok(context, generate(context, 0.02, 0, &to));
    uint32_t count = 0;
    folder_each(&to, check_picture, &count);
    assert_true(count >= 16);
    folder_remove(&to);
}

static void every_file_that_is_named_is_there(void **state)
{
    clast_context *context = *state;
    folder to = folder_make();
    assert_ok(context, generate(context, 0.02, 0, &to));
    json_t *scene = load_json(&to, "scene.json"), *gltf = load_json(&to, "canyon.gltf");
    assert_int_equal(integer(scene, "clast"), 1);
    json_t *model_entry = json_array_get(json_object_get(scene, "models"), 0);
    assert_string_equal(json_string_value(json_object_get(model_entry, "path")), "canyon.gltf");
    size_t i;
    json_t *image;
    json_array_foreach(json_object_get(gltf, "images"), i, image)
    {
        char path[512];
        folder_file(&to, json_string_value(json_object_get(image, "uri")), path);
        assert_int_equal(access(path, R_OK), 0);
    }
    json_decref(scene);
    json_decref(gltf);
    folder_remove(&to);
}

// ---------------------------------------------------------------------------------------------------- all or nothing

static bool stop_at(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)stage;
    assert_true(total > 0 && done <= total + total / 4);
    int *left = user;
    return --*left > 0;
}

static void a_cancelled_scene_leaves_nothing(void **state)
{
    (void)state;
    static const int calls[] = {1, 3, 40, 400};
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++) {
        int left = calls[i];
        clast_context *context;
        clast_context_desc desc = {.threads = 2, .progress = {stop_at, &left}};
        assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
        uint64_t before = clast_context_memory(context);
        folder to = folder_make();
        assert_int_equal(generate(context, 0.02, 0, &to), CLAST_ERROR_CANCELLED);
        assert_int_equal(folder_each(&to, NULL, NULL), 0);
        assert_int_equal(clast_context_memory(context), before);
        folder_remove(&to);
        clast_context_destroy(context);
    }
}

// The machine's files, of which writing fails after so many bytes.
typedef struct failing_files {
    int64_t bytes_left;
    int open;
} failing_files;

static clast_status failing_create(void *user, const char *path, void **file)
{
    clast_status status = clast_machine_files.create(NULL, path, file);
    ((failing_files *)user)->open += status == CLAST_OK;
    return status;
}

static clast_status failing_write(void *user, void *file, const void *data, size_t size)
{
    failing_files *files = user;
    files->bytes_left -= (int64_t)size;
    return files->bytes_left < 0 ? CLAST_ERROR_FILE_WRITE : clast_machine_files.write(NULL, file, data, size);
}

static clast_status failing_commit(void *user, void *file)
{
    ((failing_files *)user)->open--;
    return clast_machine_files.commit(NULL, file);
}

static void failing_discard(void *user, void *file)
{
    ((failing_files *)user)->open--;
    clast_machine_files.discard(NULL, file);
}

static void a_full_disk_gives_one_error_and_leaves_nothing(void **state)
{
    (void)state;
    static const int64_t bytes[] = {0, 1000, 150000, 900000};
    for (size_t i = 0; i < sizeof bytes / sizeof bytes[0]; i++) {
        failing_files files = {.bytes_left = bytes[i]};
        clast_context *context;
        clast_context_desc desc = {.threads = 2, .file = clast_machine_files};
        desc.file.create = failing_create;
        desc.file.write = failing_write;
        desc.file.commit = failing_commit;
        desc.file.discard = failing_discard;
        desc.file.user = &files;
        assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
        uint64_t before = clast_context_memory(context);
        folder to = folder_make();
        assert_int_equal(generate(context, 0.02, 0, &to), CLAST_ERROR_FILE_WRITE);
        assert_true(strstr(clast_context_error(context), to.path) != NULL);
        assert_int_equal(folder_each(&to, NULL, NULL), 0);
        assert_int_equal(files.open, 0);
        assert_int_equal(clast_context_memory(context), before);
        folder_remove(&to);
        clast_context_destroy(context);
    }
}

static void a_folder_that_cannot_be_made_is_an_error(void **state)
{
    clast_context *context = *state;
    clast_generate_desc desc = {"canyon", 0.02, 0};
    assert_int_equal(clast_generate(context, &desc, "/dev/null/scene"), CLAST_ERROR_FILE_WRITE);
    assert_true(strstr(clast_context_error(context), "/dev/null") != NULL);
}

static void too_little_memory_is_an_error(void **state)
{
    (void)state;
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 2, .memory_limit = 300000}, &context),
                     CLAST_OK);
    uint64_t before = clast_context_memory(context);
    folder to = folder_make();
    assert_int_equal(generate(context, 0.05, 0, &to), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(folder_each(&to, NULL, NULL), 0);
    assert_int_equal(clast_context_memory(context), before);
    folder_remove(&to);
    clast_context_destroy(context);
}

static void what_is_asked_for_is_checked(void **state)
{
    clast_context *context = *state;
    folder to = folder_make();
    assert_int_equal(generate(context, 0.001, 0, &to), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(generate(context, 26.0, 0, &to), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(generate(context, (double)NAN, 0, &to), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_generate(context, &(clast_generate_desc){"atlantis", 1.0, 0}, to.path),
                     CLAST_ERROR_INVALID_ARGUMENT);
    assert_true(strstr(clast_context_error(context), "atlantis") != NULL);
    assert_int_equal(folder_each(&to, NULL, NULL), 0);
    folder_remove(&to);
}

static void scenes_are_listed(void **state)
{
    (void)state;
    const char *name, *text;
    assert_true(clast_generate_scene(0, &name, &text));
    assert_string_equal(name, "canyon");
    assert_true(strlen(text) > 10);
    assert_false(clast_generate_scene(100, &name, &text));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_do_not_change_a_byte),
        cmocka_unit_test(seeds_give_different_scenes),
        CONTEXT_TEST(the_gltf_is_sound),
        CONTEXT_TEST(detail_scales_the_number_of_triangles),
        CONTEXT_TEST(pictures_can_be_read),
        CONTEXT_TEST(every_file_that_is_named_is_there),
        cmocka_unit_test(a_cancelled_scene_leaves_nothing),
        cmocka_unit_test(a_full_disk_gives_one_error_and_leaves_nothing),
        CONTEXT_TEST(a_folder_that_cannot_be_made_is_an_error),
        cmocka_unit_test(too_little_memory_is_an_error),
        CONTEXT_TEST(what_is_asked_for_is_checked),
        cmocka_unit_test(scenes_are_listed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
