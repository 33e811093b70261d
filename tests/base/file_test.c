// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <dirent.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"

// A folder of its own for each test.
typedef struct place {
    clast_context *context;
    char folder[64];
    char path[128];
} place;

static int place_make(void **state)
{
    if (test_context_setup(state) != 0) {
        return -1;
    }
    place *p = calloc(1, sizeof *p);
    p->context = *state;
    strcpy(p->folder, "/tmp/clast-file-test-XXXXXX");
    if (mkdtemp(p->folder) == NULL) {
        return -1;
    }
    snprintf(p->path, sizeof p->path, "%s/file", p->folder);
    *state = p;
    return 0;
}

// How many files the folder holds; the last one's name goes to `name`.
static int files_in(const char *folder, char name[256])
{
    DIR *directory = opendir(folder);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        if (entry->d_name[0] != '.') {
            snprintf(name, 256, "%s", entry->d_name);
            count++;
        }
    }
    closedir(directory);
    return count;
}

static int place_remove(void **state)
{
    place *p = *state;
    char name[256], path[512];
    while (files_in(p->folder, name) != 0) {
        snprintf(path, sizeof path, "%s/%s", p->folder, name);
        if (remove(path) != 0) {
            break;
        }
    }
    rmdir(p->folder);
    *state = p->context;
    free(p);
    return test_context_teardown(state);
}

#define PLACE_TEST(function) cmocka_unit_test_setup_teardown(function, place_make, place_remove)

static void write_text(place *p, const char *text)
{
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, p->path, &output));
    assert_ok(p->context, clast_file_write(&output, text, strlen(text)));
    assert_ok(p->context, clast_file_commit(&output));
}

static void assert_text(place *p, const char *path, const char *text)
{
    clast_file_view view;
    assert_ok(p->context, clast_file_map(p->context, path, &view));
    assert_int_equal(view.size, strlen(text));
    assert_memory_equal(view.data, text, strlen(text));
    clast_file_unmap(p->context, &view);
    assert_null(view.data);
}

static void what_is_written_is_mapped(void **state)
{
    place *p = *state;
    char name[256];
    write_text(p, "some words");
    assert_text(p, p->path, "some words");
    assert_int_equal(files_in(p->folder, name), 1);
}

static void nothing_appears_before_commit(void **state)
{
    place *p = *state;
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, p->path, &output));
    assert_ok(p->context, clast_file_print(&output, "%d words", 12));
    assert_int_equal(access(p->path, F_OK), -1);
    assert_ok(p->context, clast_file_commit(&output));
    assert_text(p, p->path, "12 words");
}

static void the_old_file_stays_until_commit(void **state)
{
    place *p = *state;
    write_text(p, "old");
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, p->path, &output));
    assert_ok(p->context, clast_file_write(&output, "new", 3));
    assert_text(p, p->path, "old");
    assert_ok(p->context, clast_file_commit(&output));
    assert_text(p, p->path, "new");
}

static void what_is_discarded_leaves_nothing(void **state)
{
    place *p = *state;
    char name[256];
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, p->path, &output));
    assert_ok(p->context, clast_file_write(&output, "words", 5));
    clast_file_discard(&output);
    assert_int_equal(files_in(p->folder, name), 0);
}

static void a_print_may_be_long(void **state)
{
    place *p = *state;
    char text[5000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, p->path, &output));
    assert_ok(p->context, clast_file_print(&output, "%s", text));
    assert_ok(p->context, clast_file_commit(&output));
    assert_text(p, p->path, text);
}

static void a_new_file_has_the_users_permissions(void **state)
{
    place *p = *state;
    mode_t before = umask(027);
    write_text(p, "words");
    umask(before);
    struct stat information;
    assert_int_equal(stat(p->path, &information), 0);
    assert_int_equal(information.st_mode & 0777, 0640);
}

static void a_folder_that_is_missing_is_an_error(void **state)
{
    place *p = *state;
    snprintf(p->path, sizeof p->path, "%s/missing/file", p->folder);
    clast_file_output output;
    assert_int_equal(clast_file_create(p->context, p->path, &output), CLAST_ERROR_FILE_WRITE);
    assert_non_null(strstr(clast_context_error(p->context), p->path));
    assert_int_equal(clast_file_write(&output, "x", 1), CLAST_ERROR_FILE_WRITE);
    assert_int_equal(clast_file_commit(&output), CLAST_ERROR_FILE_WRITE);
}

static void a_folder_is_no_output(void **state)
{
    place *p = *state;
    clast_file_output output;
    assert_int_equal(clast_file_create(p->context, p->folder, &output), CLAST_ERROR_FILE_WRITE);
}

static void a_full_device_is_an_error(void **state)
{
    place *p = *state;
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, "/dev/full", &output));
    clast_file_write(&output, "words", 5);
    assert_int_equal(clast_file_commit(&output), CLAST_ERROR_FILE_WRITE);
    struct stat information;
    assert_int_equal(stat("/dev/full", &information), 0);
    assert_true(S_ISCHR(information.st_mode)); // not replaced by a file
}

static void a_link_to_a_file_stays_a_link(void **state)
{
    place *p = *state;
    write_text(p, "old");
    char link[256];
    snprintf(link, sizeof link, "%s/link", p->folder);
    assert_int_equal(symlink(p->path, link), 0);
    clast_file_output output;
    assert_ok(p->context, clast_file_create(p->context, link, &output));
    assert_ok(p->context, clast_file_write(&output, "new", 3));
    assert_ok(p->context, clast_file_commit(&output));
    struct stat information;
    assert_int_equal(lstat(link, &information), 0);
    assert_true(S_ISLNK(information.st_mode));
    assert_text(p, p->path, "new");
}

static void what_cannot_be_mapped_is_told_apart(void **state)
{
    place *p = *state;
    clast_file_view view;
    assert_int_equal(clast_file_map(p->context, p->path, &view), CLAST_ERROR_FILE_NOT_FOUND);
    assert_non_null(strstr(clast_context_error(p->context), p->path));
    assert_int_equal(clast_file_map(p->context, p->folder, &view), CLAST_ERROR_FILE_READ);
    assert_int_equal(clast_file_map(p->context, "/dev/null", &view), CLAST_ERROR_FILE_READ);
    assert_null(view.data);
}

static void a_pipe_without_a_writer_is_refused_at_once(void **state)
{
    place *p = *state;
    clast_file_view view;
    assert_int_equal(mkfifo(p->path, 0600), 0);
    assert_int_equal(clast_file_map(p->context, p->path, &view), CLAST_ERROR_FILE_READ);
}

static void an_empty_file_maps_to_no_bytes(void **state)
{
    place *p = *state;
    write_text(p, "");
    assert_text(p, p->path, "");
}

// What is in use stays as it was, whatever becomes of the file: a mapping would end the process.
static void a_file_that_is_cut_or_changed_while_in_use_stays_as_it_was(void **state)
{
    place *p = *state;
    enum { SIZE = 3 * 4096 + 5 };
    static char text[SIZE + 1];
    memset(text, 'x', SIZE);
    write_text(p, text);
    clast_file_view view;
    uint64_t before = clast_context_memory(p->context);
    assert_ok(p->context, clast_file_map(p->context, p->path, &view));
    assert_int_equal(clast_context_memory(p->context), before + SIZE); // it counts
    FILE *file = fopen(p->path, "r+b");
    assert_non_null(file);
    assert_int_equal(fputc('y', file), 'y');
    fclose(file);
    assert_memory_equal(view.data, text, SIZE);
    assert_int_equal(truncate(p->path, 0), 0);
    assert_memory_equal(view.data, text, SIZE);
    clast_file_unmap(p->context, &view);
    assert_int_equal(clast_context_memory(p->context), before);
}

static void a_file_may_be_too_large_for_the_memory_limit(void **state)
{
    place *p = *state;
    write_text(p, "some words");
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .memory_limit = 4096};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    assert_int_equal(truncate(p->path, 8192), 0);
    clast_file_view view;
    assert_int_equal(clast_file_map(context, p->path, &view), CLAST_ERROR_OUT_OF_MEMORY);
    assert_non_null(strstr(clast_context_error(context), p->path));
    clast_context_destroy(context);
}

// ------------------------------------------------------------------------------------------------------ hooked files

typedef struct full_disk {
    int writes_left;
    int open;
} full_disk;

static clast_status disk_map(void *user, const char *path, clast_file_view *view)
{
    (void)user;
    (void)path;
    (void)view;
    return CLAST_ERROR_FILE_NOT_FOUND;
}

static void disk_unmap(void *user, clast_file_view *view)
{
    (void)user;
    (void)view;
}

static clast_status disk_create(void *user, const char *path, void **file)
{
    (void)path;
    full_disk *disk = user;
    disk->open++;
    *file = disk;
    return CLAST_OK;
}

static clast_status disk_write(void *user, void *file, const void *data, size_t size)
{
    (void)file;
    (void)data;
    (void)size;
    full_disk *disk = user;
    return disk->writes_left-- > 0 ? CLAST_OK : CLAST_ERROR_FILE_WRITE;
}

static clast_status disk_commit(void *user, void *file)
{
    (void)file;
    ((full_disk *)user)->open--;
    return CLAST_OK;
}

static void disk_discard(void *user, void *file)
{
    (void)file;
    ((full_disk *)user)->open--;
}

static void a_write_that_fails_gives_the_output_up(void **state)
{
    (void)state;
    full_disk disk = {.writes_left = 2};
    clast_context *context;
    clast_context_desc desc = {
        .threads = 1, .file = {disk_map, disk_unmap, disk_create, disk_write, disk_commit, disk_discard, &disk}};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    clast_file_output output;
    assert_ok(context, clast_file_create(context, "picture.png", &output));
    assert_ok(context, clast_file_write(&output, "1", 1));
    assert_ok(context, clast_file_write(&output, "2", 1));
    assert_int_equal(clast_file_write(&output, "3", 1), CLAST_ERROR_FILE_WRITE);
    disk.writes_left = 10;
    assert_int_equal(clast_file_write(&output, "4", 1), CLAST_ERROR_FILE_WRITE); // the hole stays one
    assert_int_equal(clast_file_commit(&output), CLAST_ERROR_FILE_WRITE);
    assert_int_equal(disk.open, 0);
    assert_int_equal(disk.writes_left, 10);
    assert_non_null(strstr(clast_context_error(context), "picture.png"));
    clast_context_destroy(context);
}

static void some_of_the_hooks_are_too_few(void **state)
{
    (void)state;
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .file = {.map = disk_map, .unmap = disk_unmap}};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_ERROR_INVALID_ARGUMENT);
}

// -------------------------------------------------------------------------------------------------------------- paths

static void assert_beside(clast_context *context, const char *base, const char *relative, const char *expected)
{
    char *path = clast_path_beside(context, base, relative);
    assert_string_equal(path, expected);
    clast_free(context, path);
}

static void a_path_is_taken_from_beside_another(void **state)
{
    assert_beside(*state, "scenes/a.gltf", "a.bin", "scenes/a.bin");
    assert_beside(*state, "a.gltf", "a.bin", "a.bin");
    assert_beside(*state, "/a.gltf", "a.bin", "/a.bin");
    assert_beside(*state, "scenes/a.gltf", "/tmp/a.bin", "/tmp/a.bin");
}

static void assert_extension(const char *path, const char *expected)
{
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    assert_string_equal(extension, expected);
}

static void an_extension_is_what_follows_the_last_dot(void **state)
{
    (void)state;
    assert_extension("a.PNG", "png");
    assert_extension("a.b/c", "");
    assert_extension("a.tar.gz", "gz");
    assert_extension("", "");
    assert_extension("a.", "");
}

static void folders_are_made_with_those_above(void **state)
{
    place *p = *state;
    char deep[200], middle[200];
    snprintf(middle, sizeof middle, "%s/a", p->folder);
    snprintf(deep, sizeof deep, "%s/a/b", p->folder);
    assert_ok(p->context, clast_make_folder(p->context, deep));
    assert_true(clast_path_is_folder(deep));
    assert_ok(p->context, clast_make_folder(p->context, deep));
    rmdir(deep);
    rmdir(middle);
    write_text(p, "a file");
    assert_false(clast_path_is_folder(p->path));
    assert_int_equal(clast_make_folder(p->context, p->path), CLAST_ERROR_FILE_WRITE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        PLACE_TEST(what_is_written_is_mapped),
        PLACE_TEST(nothing_appears_before_commit),
        PLACE_TEST(the_old_file_stays_until_commit),
        PLACE_TEST(what_is_discarded_leaves_nothing),
        PLACE_TEST(a_print_may_be_long),
        PLACE_TEST(a_new_file_has_the_users_permissions),
        PLACE_TEST(a_folder_that_is_missing_is_an_error),
        PLACE_TEST(a_folder_is_no_output),
        PLACE_TEST(a_full_device_is_an_error),
        PLACE_TEST(a_link_to_a_file_stays_a_link),
        PLACE_TEST(what_cannot_be_mapped_is_told_apart),
        PLACE_TEST(a_pipe_without_a_writer_is_refused_at_once),
        PLACE_TEST(an_empty_file_maps_to_no_bytes),
        PLACE_TEST(a_file_that_is_cut_or_changed_while_in_use_stays_as_it_was),
        PLACE_TEST(a_file_may_be_too_large_for_the_memory_limit),
        cmocka_unit_test(a_write_that_fails_gives_the_output_up),
        cmocka_unit_test(some_of_the_hooks_are_too_few),
        CONTEXT_TEST(a_path_is_taken_from_beside_another),
        cmocka_unit_test(an_extension_is_what_follows_the_last_dot),
        PLACE_TEST(folders_are_made_with_those_above),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
