// SPDX-License-Identifier: Apache-2.0
// The cache on disk: what is kept is found, what is damaged is not believed, and a mesh cooked with it is that cooked without.
#include "shapes.h"

#include <dirent.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cook/cook.h"

enum { BYTES = 1000 };
static const clast_cook_key key = {0x0123456789abcdef, 0xfedcba9876543210};

// A context with a cache in a new folder within a new folder, and the lines of its log.
typedef struct place {
    char outer[64], folder[80], file[160];
    uint32_t lines;
    char line[512];
    clast_context *context;
    clast_file_cache files;
    clast_cook_cache cache;
} place;

static void note_line(void *user, clast_log_level level, const char *text)
{
    place *p = user;
    assert_int_equal(level, CLAST_LOG_WARNING);
    p->lines++;
    snprintf(p->line, sizeof p->line, "%s", text);
}

static void open_context(place *p)
{
    clast_context_desc desc = {.threads = 2, .log = {note_line, p}, .cache_folder = p->folder};
    assert_int_equal(clast_context_create(&desc, &p->context), CLAST_OK);
    p->files = (clast_file_cache){p->context, p->folder};
    p->cache = clast_file_cache_hooks(&p->files);
}

static place *open_place(void)
{
    place *p = calloc(1, sizeof *p);
    snprintf(p->outer, sizeof p->outer, "/tmp/clast_cache_XXXXXX");
    assert_non_null(mkdtemp(p->outer));
    snprintf(p->folder, sizeof p->folder, "%s/inner", p->outer);
    snprintf(p->file, sizeof p->file, "%s/fedcba98765432100123456789abcdef.cache", p->folder);
    open_context(p);
    return p;
}

// Gives how many files the folder has, and the path of one.
static uint32_t list_files(const place *p, char path[512])
{
    uint32_t count = 0;
    DIR *folder = opendir(p->folder);
    for (struct dirent *entry; folder != NULL && (entry = readdir(folder)) != NULL;) {
        if (entry->d_name[0] != '.') {
            count++;
            snprintf(path, 512, "%s/%s", p->folder, entry->d_name);
        }
    }
    if (folder != NULL) {
        closedir(folder);
    }
    return count;
}

static void close_place(place *p)
{
    char path[512];
    while (list_files(p, path) != 0) {
        assert_int_equal(unlink(path), 0);
    }
    rmdir(p->folder);
    rmdir(p->outer);
    clast_context_destroy(p->context);
    free(p);
}

static void fill(uint8_t data[BYTES])
{
    for (uint32_t i = 0; i < BYTES; i++) {
        data[i] = (uint8_t)(i * 7 + i / 256);
    }
}

static bool finds(const place *p, clast_cook_key wanted, size_t size)
{
    uint8_t data[BYTES], found[BYTES + 8] = {0};
    fill(data);
    return p->cache.find(p->cache.user, wanted, found, size) && memcmp(data, found, BYTES) == 0;
}

static void keep(const place *p)
{
    uint8_t data[BYTES];
    fill(data);
    p->cache.keep(p->cache.user, key, data, BYTES);
}

// --------------------------------------------------------------------------------------------------------------- files

static void what_was_kept_is_found(void **state)
{
    (void)state;
    place *p = open_place();
    assert_false(finds(p, key, BYTES));
    keep(p);
    assert_true(finds(p, key, BYTES));
    assert_false(finds(p, (clast_cook_key){key.low, key.high + 1}, BYTES));
    assert_int_equal(p->lines, 0);
    assert_false(finds(p, key, BYTES + 1)); // of another size: not what was meant
    assert_int_equal(p->lines, 1);
    close_place(p);
}

static void change_byte(const char *path, long offset, long length)
{
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    if (length >= 0) {
        assert_int_equal(ftruncate(fileno(file), length), 0);
    } else {
        fseek(file, offset, SEEK_SET);
        int byte = fgetc(file);
        fseek(file, offset, SEEK_SET);
        fputc(byte ^ 0x10, file);
    }
    fclose(file);
}

static void a_byte_that_changed_is_noticed(void **state)
{
    (void)state;
    place *p = open_place();
    keep(p);
    struct stat information;
    assert_int_equal(stat(p->file, &information), 0);
    for (long at = 0; at < information.st_size; at += at < 64 ? 1 : 37) {
        uint32_t lines = p->lines;
        change_byte(p->file, at, -1);
        assert_false(finds(p, key, BYTES));
        assert_int_equal(p->lines, lines + 1);
        assert_non_null(strstr(p->line, "not a whole cache file"));
        keep(p);
        assert_true(finds(p, key, BYTES));
    }
    close_place(p);
}

static void a_file_cut_short_is_noticed(void **state)
{
    (void)state;
    place *p = open_place();
    static const long lengths[] = {0, 7, 47, 48, 1000};
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        keep(p);
        change_byte(p->file, 0, lengths[i]);
        assert_false(finds(p, key, BYTES));
    }
    close_place(p);
}

static void a_folder_that_cannot_be_is_told_once_each_time(void **state)
{
    (void)state;
    place *p = open_place();
    FILE *file = fopen(p->folder, "w"); // a file where the folder should be
    assert_non_null(file);
    fclose(file);
    keep(p);
    assert_int_equal(p->lines, 1);
    assert_non_null(strstr(p->line, "nothing is kept"));
    assert_false(finds(p, key, BYTES));
    unlink(p->folder);
    close_place(p);
}

// -------------------------------------------------------------------------------------------------------------- meshes

// A displaced sphere.
static clast_scene *make_scene(clast_context *context)
{
    enum { SIDE = 64 };
    uint16_t texels[SIDE * SIDE];
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
        texels[i] = (uint16_t)(i * 40503u);
    }
    clast_scene *scene;
    uint32_t number;
    assert_ok(context, clast_scene_create(context, &scene));
    assert_ok(context,
              clast_scene_add_image(scene, &(clast_image){SIDE, SIDE, 1, CLAST_PIXEL_UNORM16, texels}, NULL, &number));
    assert_ok(context, clast_scene_add_texture(scene, &(clast_texture){.image = number}, &number));
    clast_material_desc material = clast_material_defaults();
    material.displacement_texture.texture = number;
    material.displacement_scale = 0.5f;
    assert_ok(context, clast_scene_add_material(scene, &material, NULL, &number));
    shape sphere = shape_sphere(24, 16);
    float *coordinates = malloc(2 * sizeof *coordinates * sphere.mesh.vertex_count);
    for (uint32_t i = 0; i < 2 * sphere.mesh.vertex_count; i++) {
        coordinates[i] = (float)(i * 37 % 101) / 101.0f;
    }
    sphere.mesh.coordinates[0] = coordinates;
    sphere.mesh.material = number;
    assert_ok(context, clast_scene_add_mesh(scene, &sphere.mesh, NULL, &number));
    assert_ok(context, clast_scene_set_tessellation(scene, number, &(clast_tessellation){0}));
    shape_free(&sphere);
    free(coordinates);
    return scene;
}

static clast_box cook_box(clast_context *context)
{
    clast_scene *scene = make_scene(context);
    clast_cooked *cooked;
    assert_ok(context, clast_cooked_create(context, &cooked));
    assert_ok(context, clast_cooked_update(cooked, scene));
    const clast_pose pose = {.displacement_scale = 1.0f};
    clast_box box = clast_source_of(cooked->units[0])->bounds(cooked->units[0], &pose);
    clast_cooked_destroy(cooked);
    clast_scene_destroy(scene);
    return box;
}

static void a_mesh_is_bounded_alike_with_a_cache_and_without(void **state)
{
    clast_box without = cook_box(*state);
    place *p = open_place();
    char path[512];
    clast_box first = cook_box(p->context);
    assert_int_equal(list_files(p, path), 1);
    clast_box second = cook_box(p->context);
    assert_int_equal(list_files(p, path), 1);
    assert_memory_equal(&first, &without, sizeof first);
    assert_memory_equal(&second, &without, sizeof second);
    assert_int_equal(p->lines, 0);
    close_place(p);
}

// The ranges of a file, changed and kept under the same key by a cache that means it.
static void forge(place *p, float scale)
{
    enum { HEADER = 48 };
    char path[512];
    assert_int_equal(list_files(p, path), 1);
    unsigned long long high, low;
    assert_int_equal(sscanf(strrchr(path, '/') + 1, "%16llx%16llx", &high, &low), 2);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    size_t count = ((size_t)ftell(file) - HEADER) / sizeof(clast_height_range);
    fseek(file, HEADER, SEEK_SET);
    clast_height_range *ranges = malloc(count * sizeof *ranges);
    assert_int_equal(fread(ranges, sizeof *ranges, count, file), count);
    fclose(file);
    for (size_t i = 0; i < count; i++) {
        ranges[i].upper = ranges[i].lower + (ranges[i].upper - ranges[i].lower) * scale;
    }
    p->cache.keep(p->cache.user, (clast_cook_key){low, high}, ranges, count * sizeof *ranges);
    free(ranges);
}

static void what_the_cache_holds_is_used_where_it_could_be_true(void **state)
{
    (void)state;
    place *p = open_place();
    clast_box true_box = cook_box(p->context);
    forge(p, 0.5f);
    clast_box small = cook_box(p->context);
    assert_true(small.upper.v[0] < true_box.upper.v[0] - 0.01f); // so the file was read
    forge(p, NAN);
    clast_box again = cook_box(p->context);
    assert_memory_equal(&again, &true_box, sizeof again); // and is not where it lies
    forge(p, 100.0f);
    again = cook_box(p->context);
    assert_memory_equal(&again, &true_box, sizeof again);
    close_place(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_kept_is_found),
        cmocka_unit_test(a_byte_that_changed_is_noticed),
        cmocka_unit_test(a_file_cut_short_is_noticed),
        cmocka_unit_test(a_folder_that_cannot_be_is_told_once_each_time),
        CONTEXT_TEST(a_mesh_is_bounded_alike_with_a_cache_and_without),
        cmocka_unit_test(what_the_cache_holds_is_used_where_it_could_be_true),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
