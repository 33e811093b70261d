// SPDX-License-Identifier: Apache-2.0
// A program that is killed while it writes a file, at any step, leaves the old file or the new one, whole; and so does a disk
// that is full.
#include "test.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/file.h"

enum { PIECES = 6, PIECE = 5000 };

// ---------------------------------------------------------------------------------------------- steps of the machine's files

static long steps_left = -1; // until the program is killed; negative: it is not

static void step(void)
{
    if (steps_left == 0) {
        raise(SIGKILL);
    }
    steps_left -= steps_left > 0;
}

// The linker puts these in place of the system's.
int __real_open(const char *path, int flags, ...);
int __real_fsync(int file);
int __real_rename(const char *from, const char *to);
int __wrap_open(const char *path, int flags, ...);
int __wrap_fsync(int file);
int __wrap_rename(const char *from, const char *to);

int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    int mode = (flags & O_CREAT) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    step();
    int file = __real_open(path, flags, mode);
    step();
    return file;
}

int __wrap_fsync(int file)
{
    step();
    int result = __real_fsync(file);
    step();
    return result;
}

int __wrap_rename(const char *from, const char *to)
{
    step();
    int result = __real_rename(from, to);
    step();
    return result;
}

// --------------------------------------------------------------------------------------------------------------- files

static clast_status write_file(clast_context *context, const char *path, char letter)
{
    static char piece[PIECE];
    clast_file_output output;
    memset(piece, letter, sizeof piece);
    clast_status status = clast_file_create(context, path, &output);
    if (status != CLAST_OK) {
        return status;
    }
    for (int i = 0; i < PIECES; i++) {
        step();
        clast_file_write(&output, piece, sizeof piece);
    }
    step();
    return clast_file_commit(&output);
}

// The letter that the file is made of, whole; 0 where it is anything else.
static char letter_of(const char *path)
{
    static char text[PIECES * PIECE + 1];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(text, 1, sizeof text, file);
    fclose(file);
    for (size_t i = 1; i < size; i++) {
        if (text[i] != text[0]) {
            return 0;
        }
    }
    return size == PIECES * PIECE ? text[0] : 0;
}

// Removes all files of a folder but one; gives how many these were.
static int remove_others(const char *folder, const char *kept)
{
    DIR *directory = opendir(folder);
    int count = 0;
    for (struct dirent *entry; (entry = readdir(directory)) != NULL;) {
        char path[512];
        snprintf(path, sizeof path, "%s/%.255s", folder, entry->d_name);
        if (entry->d_name[0] != '.' && strcmp(path, kept) != 0) {
            remove(path);
            count++;
        }
    }
    closedir(directory);
    return count;
}

static void make_folder(char folder[64], char path[128])
{
    strcpy(folder, "/tmp/clast-kill-XXXXXX");
    assert_non_null(mkdtemp(folder));
    snprintf(path, 128, "%s/picture.png", folder);
}

static void a_kill_at_any_step_leaves_a_whole_file(void **state)
{
    clast_context *context = *state;
    char folder[64], path[128];
    make_folder(folder, path);
    bool has_ended = false;
    long kills = 0;
    for (; !has_ended; kills++) {
        assert_ok(context, write_file(context, path, 'a'));
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            steps_left = kills;
            _exit(write_file(context, path, 'b') == CLAST_OK ? 0 : 1);
        }
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        char letter = letter_of(path);
        has_ended = WIFEXITED(status);
        if (has_ended) {
            assert_int_equal(WEXITSTATUS(status), 0);
            assert_int_equal(letter, 'b');
        } else {
            assert_int_equal(WTERMSIG(status), SIGKILL);
            assert_true(letter == 'a' || letter == 'b');
        }
        remove_others(folder, path);
    }
    assert_true(kills > 12);
    remove(path);
    assert_int_equal(rmdir(folder), 0);
}

static void a_full_disk_leaves_the_file_before_and_nothing_else(void **state)
{
    clast_context *context = *state;
    char folder[64], path[128];
    make_folder(folder, path);
    assert_ok(context, write_file(context, path, 'a'));
    struct rlimit before, small;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (rlim_t size = 0; size < PIECES * PIECE; size += PIECE / 2) {
        small = (struct rlimit){size, before.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        clast_status status = write_file(context, path, 'b');
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        assert_int_equal(status, CLAST_ERROR_FILE_WRITE);
        assert_non_null(strstr(clast_context_error(context), path));
        assert_int_equal(letter_of(path), 'a');
        assert_int_equal(remove_others(folder, path), 0);
    }
    signal(SIGXFSZ, handler);
    assert_ok(context, write_file(context, path, 'b'));
    assert_int_equal(letter_of(path), 'b');
    remove(path);
    assert_int_equal(rmdir(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_kill_at_any_step_leaves_a_whole_file),
        CONTEXT_TEST(a_full_disk_leaves_the_file_before_and_nothing_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
