// SPDX-License-Identifier: Apache-2.0
// Broken files that others have collected (CLAST_ASSETS/malformed): each comes to what malformed.txt says, soon, within the memory
// that its size allows (by the context's count, and by what the system says of a process that reads nothing else), and leaves
// nothing over. With --list, the program prints the table as it would be now.
#include "test.h"

#include <dirent.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/thread.h"
#include "clast/image.h"
#include "load/bytes.h"

enum { SECONDS_MOST = 2 };

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
enum { HAS_SANITIZER = true }; // whose own memory is not what is asked about
#else
enum { HAS_SANITIZER = false };
#endif

// What the files that a load opens have in sum.
static uint64_t opened_bytes;

static clast_status counting_map(void *user, const char *path, clast_file_view *view)
{
    clast_status status = clast_machine_files.map(user, path, view);
    opened_bytes += view->size;
    return status;
}

static const char *const status_names[] = {
#define NAME(name, value, text) [value] = #name,
    CLAST_STATUS_LIST(NAME)
#undef NAME
};

static bool is_model(const char *path)
{
    static const char *const extensions[] = {"gltf", "glb", "obj", "ply", "stl", "off", "bary"};
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++) {
        if (strcmp(extensions[i], extension) == 0) {
            return true;
        }
    }
    return false;
}

// A material library is read by way of a model that names it, from beside the test.
static clast_status read_library(clast_context *context, const char *path)
{
    char text[4096], name[] = "/tmp/clast-malformed-XXXXXX.obj";
    int descriptor = mkstemps(name, 4);
    assert_true(descriptor >= 0);
    snprintf(text, sizeof text, "mtllib %s\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", path);
    FILE *file = fdopen(descriptor, "w");
    fputs(text, file);
    fclose(file);
    clast_scene *scene = NULL;
    clast_status status = clast_scene_load(context, name, &scene);
    clast_scene_destroy(scene);
    remove(name);
    return status;
}

static clast_status read_path(clast_context *context, const char *path)
{
    const char *dot = strrchr(path, '.');
    if (dot != NULL && strcmp(dot, ".mtl") == 0) {
        return read_library(context, path);
    }
    if (is_model(path)) {
        clast_scene *scene = NULL;
        clast_status status = clast_scene_load(context, path, &scene);
        clast_scene_destroy(scene);
        return status;
    }
    clast_image image;
    clast_status status = clast_image_read(context, path, &image);
    clast_image_free(context, &image);
    return status;
}

// What reading a file came to.
typedef struct outcome {
    clast_status status;
    bool has_text; // of one line
    double seconds;
    uint64_t files;   // bytes
    uint64_t peak;    // of the context
    uint64_t process; // by how much the most resident memory of the process has grown
    uint64_t left;    // in the context
} outcome;

// Reads a file in a context of its own.
static outcome read_alone(const char *path)
{
    clast_context *context;
    clast_context_desc desc = {.threads = 1, .file = clast_machine_files};
    desc.file.map = counting_map;
    uint64_t process_before = clast_process_memory_peak();
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    uint64_t before = clast_context_memory(context);
    opened_bytes = 0;
    clock_t begin = clock();
    outcome o = {.status = read_path(context, path)};
    o.seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    const char *text = clast_context_error(context);
    o.has_text = text[0] != '\0' && strchr(text, '\n') == NULL;
    o.files = opened_bytes;
    o.peak = clast_context_memory_peak(context) - before;
    o.left = clast_context_memory(context) - before;
    clast_context_destroy(context);
    o.process = clast_process_memory_peak() - process_before;
    return o;
}

// The same in a process of its own, whose memory no file before has made larger. Sanitizers look for leaks where programs end,
// so that theirs is one process.
static outcome read_in_process(const char *path)
{
    int ends[2], ended;
    outcome o = {0};
    if (HAS_SANITIZER) {
        return read_alone(path);
    }
    assert_int_equal(pipe(ends), 0);
    fflush(NULL);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        o = read_alone(path);
        _exit(write(ends[1], &o, sizeof o) != (ssize_t)sizeof o);
    }
    close(ends[1]);
    ssize_t count = read(ends[0], &o, sizeof o);
    close(ends[0]);
    assert_int_equal(waitpid(child, &ended, 0), child);
    if (count != (ssize_t)sizeof o || !WIFEXITED(ended) || WEXITSTATUS(ended) != 0) {
        fail_msg("%s: the process that reads it ends early (%d)", path, ended);
    }
    return o;
}

// Reads a file, and checks all but the status.
static clast_status read_checked(const char *path)
{
    outcome o = read_in_process(path);
    uint64_t most = clast_unpacked_most(o.files);
    if (o.status != CLAST_OK && !o.has_text) {
        fail_msg("%s: no line of text", path);
    }
    if (o.seconds > SECONDS_MOST || o.peak > most || (!HAS_SANITIZER && o.process > most)) {
        fail_msg("%s: %g s, %llu bytes of the context, %llu of the process: expected at most %d s and %llu bytes", path,
                 o.seconds, (unsigned long long)o.peak, (unsigned long long)o.process, SECONDS_MOST,
                 (unsigned long long)most);
    }
    assert_int_equal(o.left, 0);
    return o.status;
}

// --------------------------------------------------------------------------------------------------------------- table

static void list_folder(const char *root, const char *below)
{
    char path[2048];
    snprintf(path, sizeof path, "%s/%s", root, below);
    struct dirent **entries;
    int count = scandir(path, &entries, NULL, alphasort);
    for (int i = 0; i < count; i++) {
        char inner[2048];
        snprintf(inner, sizeof inner, "%.1000s%s%.255s", below, below[0] != '\0' ? "/" : "", entries[i]->d_name);
        snprintf(path, sizeof path, "%.500s/%.1200s", root, inner);
        struct stat information;
        bool is_left_out = entries[i]->d_name[0] == '.' || strstr(inner, ".report.json") != NULL ||
                           strstr(inner, ".txt") != NULL || stat(path, &information) != 0;
        if (!is_left_out && S_ISDIR(information.st_mode)) {
            list_folder(root, inner);
        } else if (!is_left_out) {
            printf("%s %s\n", status_names[read_checked(path)] + strlen("CLAST_"), inner);
            fflush(stdout);
        }
        free(entries[i]);
    }
    free(entries);
}

static void malformed_folder(char folder[1024])
{
    snprintf(folder, 1024, "%s/malformed", test_assets());
}

static void each_file_comes_to_what_the_table_says(void **state)
{
    (void)state;
    char folder[1024], line[1024], path[2100];
    malformed_folder(folder);
    FILE *table = fopen(CLAST_TESTS_MALFORMED_TABLE, "r");
    assert_non_null(table);
    uint32_t count = 0, wrong = 0;
    while (fgets(line, sizeof line, table) != NULL) {
        line[strcspn(line, "\n")] = '\0';
        char *name = strchr(line, ' ');
        if (line[0] == '#' || name == NULL) {
            continue;
        }
        *name++ = '\0';
        snprintf(path, sizeof path, "%s/%s", folder, name);
        clast_status status = read_checked(path);
        if (strcmp(status_names[status] + strlen("CLAST_"), line) != 0) {
            print_error("%s: %s, expected %s\n", name, status_names[status], line);
            wrong++;
        }
        count++;
    }
    fclose(table);
    assert_int_equal(wrong, 0);
    assert_true(count > 300);
}

int main(int argument_count, char **arguments)
{
    if (argument_count == 2 && strcmp(arguments[1], "--list") == 0) {
        char folder[1024];
        malformed_folder(folder);
        list_folder(folder, "");
        return 0;
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_file_comes_to_what_the_table_says)};
    test_assets();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
