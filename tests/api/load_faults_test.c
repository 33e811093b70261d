// SPDX-License-Identifier: Apache-2.0
// Scenes of files are loaded, cooked, built, drawn and written while every allocation, and every call of the system that may fail,
// fails once: the 1st, 2nd, ... until none does. Each failure is a clean error, leaves nothing behind, and the same context works
// afterwards.
#include "test.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "clast/clast.h"
#include "load/samples.h"

enum { WIDTH = 8, HEIGHT = 6 };

// -------------------------------------------------------------------------------------------------------------- faults

// Which call fails: the one that makes it 0; negative: none. Atomic, as threads allocate too.
static _Atomic int64_t allocations_left = -1, calls_left = -1;
static _Atomic int64_t blocks, failed;

static bool is_due(_Atomic int64_t *left)
{
    int64_t now = *left;
    if (now < 0) {
        return false;
    }
    now = (*left)--;
    failed += now == 0;
    return now == 0;
}

static void *failing_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        blocks -= pointer != NULL;
        free(pointer);
        return NULL;
    }
    void *block = is_due(&allocations_left) ? NULL : realloc(pointer, new_size);
    blocks += pointer == NULL && block != NULL;
    return block;
}

// The linker puts these in place of the system's, in all that is linked from here.
#define FAULTY(result, name, parameters, arguments, fault) \
    result __real_##name parameters; \
    result __wrap_##name parameters; \
    result __wrap_##name parameters \
    { \
        if (is_due(&calls_left)) { \
            return fault; \
        } \
        return __real_##name arguments; \
    }

static int fail_with(int error)
{
    errno = error;
    return -1;
}

FAULTY(int, fstat, (int file, struct stat *information), (file, information), fail_with(EIO))
FAULTY(ssize_t, read, (int file, void *data, size_t size), (file, data, size), fail_with(EIO))
FAULTY(ssize_t, pread, (int file, void *data, size_t size, off_t offset), (file, data, size, offset), fail_with(EIO))
FAULTY(int, posix_memalign, (void **block, size_t alignment, size_t size), (block, alignment, size), ENOMEM)
FAULTY(int, fsync, (int file), (file), fail_with(EIO))
FAULTY(int, rename, (const char *from, const char *to), (from, to), fail_with(ENOSPC))
FAULTY(int, pthread_create, (pthread_t * thread, const pthread_attr_t *attributes, void *(*run)(void *), void *data),
       (thread, attributes, run, data), EAGAIN)
FAULTY(int, pthread_mutex_init, (pthread_mutex_t * lock, const pthread_mutexattr_t *attributes), (lock, attributes),
       ENOMEM)

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    int mode = (flags & O_CREAT) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    return is_due(&calls_left) ? fail_with(EMFILE) : __real_open(path, flags, mode);
}

// ---------------------------------------------------------------------------------------------------------------- life

static char folder[64];
static samples all;

static void write_samples(void)
{
    strcpy(folder, "/tmp/clast_faults_XXXXXX");
    assert_non_null(mkdtemp(folder));
    all = samples_make();
    for (size_t i = 0; i < all.count; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", folder, all.list[i].name);
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(all.list[i].data, 1, all.list[i].size, file), all.list[i].size);
        fclose(file);
    }
}

static void remove_samples(void)
{
    for (size_t i = 0; i < all.count; i++) {
        char path[256];
        snprintf(path, sizeof path, "%s/%s", folder, all.list[i].name);
        remove(path);
    }
    samples_free(&all);
    assert_int_equal(rmdir(folder), 0); // nothing half written is left in it
}

static clast_status draw(clast_context *context, clast_scene *scene)
{
    char path[256];
    float colour[WIDTH * HEIGHT * 3];
    const clast_render_output output = {CLAST_VIEW_COLOUR, colour};
    clast_render_settings settings = {
        .width = WIDTH, .height = HEIGHT, .spp = 1, .bounces = 2, .device = CLAST_DEVICE_CPU, .env = "1,1,1"};
    clast_renderer *renderer = NULL;
    clast_status status = clast_renderer_create(scene, &renderer);
    status = status != CLAST_OK ? status : clast_render(renderer, &settings, &output, 1, NULL);
    clast_image image = {WIDTH, HEIGHT, 3, CLAST_PIXEL_FLOAT, colour};
    snprintf(path, sizeof path, "%s/drawn.pfm", folder);
    status = status != CLAST_OK ? status : clast_image_write(context, path, &image);
    remove(path);
    clast_renderer_destroy(renderer);
    return status;
}

static clast_status live(clast_context *context, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    clast_scene *scene = NULL;
    clast_status status = clast_scene_load(context, path, &scene);
    status = status != CLAST_OK ? status : draw(context, scene);
    clast_scene_destroy(scene);
    return status;
}

static clast_status make_context(uint32_t threads, clast_context **context)
{
    clast_context_desc desc = {.memory = {failing_reallocate, NULL}, .threads = threads};
    return clast_context_create(&desc, context);
}

static const char *const scenes[] = {"scene.json", "scene.gltf", "scene.glb", "packed.gltf", "ascii.ply", "binary.stl"};
enum { SCENES = sizeof scenes / sizeof *scenes };

// --------------------------------------------------------------------------------------------------------------- tests

static void every_allocation_may_fail(void **state)
{
    (void)state;
    uint64_t points = 0;
    for (size_t i = 0; i < SCENES; i++) {
        clast_context *context;
        assert_int_equal(make_context(1, &context), CLAST_OK); // one thread: the order is the same each time
        int64_t before = blocks;
        for (int64_t k = 0; k < 100000; k++) {
            failed = 0;
            allocations_left = k;
            clast_status status = live(context, scenes[i]);
            allocations_left = -1;
            assert_int_equal(blocks, before);
            if (failed == 0) {
                assert_ok(context, status);
                break;
            }
            points++;
            // A few allocations only save work; where one of them fails the call goes on.
            if (status != CLAST_OK && status != CLAST_ERROR_OUT_OF_MEMORY) {
                fail_msg("%s, allocation %lld: %s", scenes[i], (long long)k, clast_context_error(context));
            }
            if (k % 16 == 0) {
                assert_ok(context, live(context, scenes[i]));
            }
        }
        clast_context_destroy(context);
    }
    assert_int_equal(blocks, 0);
    assert_true(points > 500);
    printf("%llu allocations made to fail\n", (unsigned long long)points);
}

static void every_call_of_the_system_may_fail(void **state)
{
    (void)state;
    uint64_t points = 0;
    for (size_t i = 0; i < SCENES; i++) {
        for (int64_t k = 0; k < 10000; k++) {
            failed = 0;
            clast_context *context = NULL;
            calls_left = k;
            clast_status status = make_context(3, &context);
            bool is_made = status == CLAST_OK;
            status = is_made ? live(context, scenes[i]) : status;
            calls_left = -1;
            points += failed != 0;
            bool fits = status == CLAST_OK || status == CLAST_ERROR_OUT_OF_MEMORY || status == CLAST_ERROR_FILE_READ ||
                        status == CLAST_ERROR_FILE_WRITE || status == CLAST_ERROR_THREAD;
            if (!fits || (is_made && status != CLAST_OK && clast_context_error(context)[0] == '\0')) {
                fail_msg("%s, call %lld: %s", scenes[i], (long long)k, clast_status_text(status));
            }
            if (is_made) {
                assert_ok(context, live(context, scenes[i]));
                clast_context_destroy(context);
            }
            assert_int_equal(blocks, 0);
            if (failed == 0) {
                assert_int_equal(status, CLAST_OK);
                break;
            }
        }
    }
    assert_true(points > 50);
    printf("%llu calls made to fail\n", (unsigned long long)points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(every_call_of_the_system_may_fail),
    };
    write_samples();
    int result = cmocka_run_group_tests(tests, NULL, NULL);
    remove_samples();
    return result;
}
