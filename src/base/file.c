// SPDX-License-Identifier: Apache-2.0
#include "base/file.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/size.h"

// ---------------------------------------------------------------------------------------------- the machine's files

// A file's bytes are read into memory of our own: a mapping would end the process where another program cuts the file short, and
// could change between a check and the use of what was checked. Only larger files are mapped, as memory may not hold them.
#define READ_MOST ((uint64_t)1 << 30)
enum { READ_ALIGNMENT = 64 }; // what a block that lies in a file needs (clast_blas_map)

static clast_status read_whole(int file, clast_file_view *view)
{
    void *block;
    size_t size = (size_t)view->size, done = 0;
    if (posix_memalign(&block, READ_ALIGNMENT, size) != 0) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    while (done < size) {
        ssize_t count = read(file, (char *)block + done, size - done);
        if (count == 0 || (count < 0 && errno != EINTR)) { // it has become shorter, or cannot be read
            free(block);
            return CLAST_ERROR_FILE_READ;
        }
        done += count > 0 ? (size_t)count : 0;
    }
    view->data = view->handle = block;
    return CLAST_OK;
}

static clast_status map_whole(int file, clast_file_view *view)
{
    void *data = view->size > SIZE_MAX ? MAP_FAILED : mmap(NULL, (size_t)view->size, PROT_READ, MAP_PRIVATE, file, 0);
    if (data == MAP_FAILED) {
        return CLAST_ERROR_FILE_READ;
    }
    view->data = data;
    return CLAST_OK;
}

static clast_status open_machine_file(const char *path, int *file, uint64_t *size)
{
    *file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); // a named pipe without a writer must not block
    if (*file < 0) {
        return errno == ENOENT || errno == ENOTDIR ? CLAST_ERROR_FILE_NOT_FOUND : CLAST_ERROR_FILE_READ;
    }
    struct stat information;
    if (fstat(*file, &information) != 0 || !S_ISREG(information.st_mode)) {
        close(*file);
        return CLAST_ERROR_FILE_READ;
    }
    *size = (uint64_t)information.st_size;
    return CLAST_OK;
}

static clast_status machine_map(void *user, const char *path, clast_file_view *view)
{
    (void)user;
    *view = (clast_file_view){0};
    int file;
    clast_status status = open_machine_file(path, &file, &view->size);
    if (status == CLAST_OK) {
        view->data = "";
        status = view->size == 0 ? CLAST_OK : view->size > READ_MOST ? map_whole(file, view) : read_whole(file, view);
        close(file);
    }
    if (status != CLAST_OK) {
        *view = (clast_file_view){0};
    }
    return status;
}

static void machine_unmap(void *user, clast_file_view *view)
{
    (void)user;
    if (view->handle != NULL) {
        free(view->handle);
    } else if (view->data != NULL && view->size != 0) {
        munmap((void *)view->data, (size_t)view->size);
    }
    *view = (clast_file_view){0};
}

// An output is written beside its target under a name of its own and renamed when whole. What is no ordinary file (a
// device, a pipe) cannot be replaced: it is written through.
typedef struct machine_output {
    FILE *stream;
    char *path;
    char *temporary; // null where written through
} machine_output;

static void output_free(machine_output *output)
{
    free(output->path);
    free(output->temporary);
    free(output);
}

static char *copy_bytes(const char *text, size_t length, size_t room)
{
    char *copy = malloc(length + room);
    if (copy != NULL) {
        memcpy(copy, text, length);
        copy[length] = '\0';
    }
    return copy;
}

// A new file beside `path`, with the permissions that the user's mask leaves; its name goes to `temporary`.
static int open_beside(const char *path, char **temporary)
{
    enum { SUFFIX = 32, ATTEMPTS = 1000 };
    size_t length = strlen(path);
    *temporary = copy_bytes(path, length, SUFFIX);
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    for (unsigned i = 0; *temporary != NULL && i < ATTEMPTS; i++) {
        unsigned number = ((unsigned)now.tv_nsec + i) * 2654435761u ^ (unsigned)getpid();
        snprintf(*temporary + length, SUFFIX, ".%08x.part", number);
        int descriptor = open(*temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor >= 0 || errno != EEXIST) {
            return descriptor;
        }
    }
    return -1;
}

static clast_status machine_create(void *user, const char *path, void **file)
{
    (void)user;
    machine_output *output = calloc(1, sizeof *output);
    if (output == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    output->path = realpath(path, NULL); // behind links: they stay
    if (output->path == NULL) {
        output->path = copy_bytes(path, strlen(path), 1);
    }
    if (output->path == NULL) {
        output_free(output);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    struct stat information;
    bool special = stat(output->path, &information) == 0 && !S_ISREG(information.st_mode);
    int descriptor = special ? open(output->path, O_WRONLY | O_CLOEXEC) : open_beside(output->path, &output->temporary);
    output->stream = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    if (output->stream == NULL) {
        if (descriptor >= 0) {
            close(descriptor);
            if (output->temporary != NULL) {
                unlink(output->temporary);
            }
        }
        output_free(output);
        return CLAST_ERROR_FILE_WRITE;
    }
    *file = output;
    return CLAST_OK;
}

static clast_status machine_write(void *user, void *file, const void *data, size_t size)
{
    (void)user;
    machine_output *output = file;
    return fwrite(data, 1, size, output->stream) == size ? CLAST_OK : CLAST_ERROR_FILE_WRITE;
}

static void machine_discard(void *user, void *file)
{
    (void)user;
    machine_output *output = file;
    if (output->stream != NULL) {
        fclose(output->stream);
    }
    if (output->temporary != NULL) {
        unlink(output->temporary);
    }
    output_free(output);
}

// Makes a rename durable. Some systems cannot: then it is as durable as they make it.
static void sync_folder_of(char *path)
{
    char *slash = strrchr(path, '/');
    char kept = slash != NULL ? slash[1] : '\0';
    if (slash != NULL) {
        slash[1] = '\0';
    }
    int folder = open(slash != NULL ? path : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        fsync(folder);
        close(folder);
    }
    if (slash != NULL) {
        slash[1] = kept;
    }
}

static clast_status machine_commit(void *user, void *file)
{
    machine_output *output = file;
    bool whole = fflush(output->stream) == 0;
    if (output->temporary != NULL) {
        whole = whole && fsync(fileno(output->stream)) == 0;
    }
    whole = fclose(output->stream) == 0 && whole;
    output->stream = NULL;
    if (whole && output->temporary != NULL) {
        whole = rename(output->temporary, output->path) == 0;
    }
    if (!whole) {
        machine_discard(user, file);
        return CLAST_ERROR_FILE_WRITE;
    }
    if (output->temporary != NULL) {
        sync_folder_of(output->path);
    }
    output_free(output);
    return CLAST_OK;
}

const clast_file_hook clast_machine_files = {
    .map = machine_map,
    .unmap = machine_unmap,
    .create = machine_create,
    .write = machine_write,
    .commit = machine_commit,
    .discard = machine_discard,
};

// ------------------------------------------------------------------------------------------------ by way of the hooks

// Memory that the machine's hook took for a file counts as the context's; that of other hooks is theirs.
static uint64_t memory_of(const clast_file_hook *files, const clast_file_view *view)
{
    return files->map == machine_map && view->handle != NULL ? view->size : 0;
}

clast_status clast_file_map(clast_context *context, const char *path, clast_file_view *view)
{
    const clast_file_hook *files = clast_context_files(context);
    clast_status status = files->map(files->user, path, view);
    if (status == CLAST_OK && !clast_context_claim(context, memory_of(files, view))) {
        files->unmap(files->user, view);
        status = CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status != CLAST_OK) {
        *view = (clast_file_view){0};
        return clast_fail(context, status, "%s: %s", path, clast_status_text(status));
    }
    return CLAST_OK;
}

void clast_file_unmap(clast_context *context, clast_file_view *view)
{
    const clast_file_hook *files = clast_context_files(context);
    clast_context_return(context, memory_of(files, view));
    if (view->data != NULL) {
        files->unmap(files->user, view);
    }
    *view = (clast_file_view){0};
}

clast_status clast_file_open(clast_context *context, const char *path, clast_file_source *source)
{
    *source = (clast_file_source){.context = context, .descriptor = -1};
    if (clast_context_files(context)->map != machine_map) {
        clast_status status = clast_file_map(context, path, &source->view);
        source->size = source->view.size;
        return status;
    }
    clast_status status = open_machine_file(path, &source->descriptor, &source->size);
    if (status != CLAST_OK) {
        *source = (clast_file_source){.context = context, .descriptor = -1};
        return clast_fail(context, status, "%s: %s", path, clast_status_text(status));
    }
    return CLAST_OK;
}

void clast_file_close(clast_file_source *source)
{
    if (source->descriptor >= 0) {
        close(source->descriptor);
    } else {
        clast_file_unmap(source->context, &source->view);
    }
    *source = (clast_file_source){.context = source->context, .descriptor = -1};
}

clast_status clast_file_piece(const clast_file_source *source, uint64_t offset, size_t size, void *room,
                              const unsigned char **bytes)
{
    if (source->descriptor < 0) {
        *bytes = (const unsigned char *)source->view.data + offset;
        return CLAST_OK;
    }
    for (size_t done = 0; done < size;) {
        ssize_t count = pread(source->descriptor, (char *)room + done, size - done, (off_t)(offset + done));
        if (count == 0 || (count < 0 && errno != EINTR)) {
            return CLAST_ERROR_FILE_READ;
        }
        done += count > 0 ? (size_t)count : 0;
    }
    *bytes = room;
    return CLAST_OK;
}

clast_status clast_file_look(const clast_file_source *source, clast_file_window *window, uint64_t offset, size_t size,
                             const unsigned char **bytes)
{
    if (source->descriptor >= 0 && window->capacity < size) {
        clast_file_free_window(source->context, window);
        window->room = clast_allocate(source->context, size, 1);
        if (window->room == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
        window->capacity = size;
    }
    return clast_file_piece(source, offset, size, window->room, bytes);
}

void clast_file_free_window(clast_context *context, clast_file_window *window)
{
    clast_free(context, window->room);
    *window = (clast_file_window){NULL, 0};
}

static clast_status output_failed(clast_file_output *output, clast_status status)
{
    if (output->status == CLAST_OK) {
        output->status = status;
        clast_fail(output->context, status, "%s: %s", output->path, clast_status_text(status));
    }
    return output->status;
}

clast_status clast_file_create(clast_context *context, const char *path, clast_file_output *output)
{
    const clast_file_hook *files = clast_context_files(context);
    *output = (clast_file_output){.context = context, .path = path};
    clast_status status = files->create(files->user, path, &output->handle);
    return status == CLAST_OK ? CLAST_OK : output_failed(output, status);
}

clast_status clast_file_write(clast_file_output *output, const void *data, size_t size)
{
    if (output->status != CLAST_OK) {
        return output->status;
    }
    const clast_file_hook *files = clast_context_files(output->context);
    clast_status status = files->write(files->user, output->handle, data, size);
    return status == CLAST_OK ? CLAST_OK : output_failed(output, status);
}

clast_status clast_file_print(clast_file_output *output, const char *format, ...)
{
    char few[512];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(few, sizeof few, format, arguments);
    va_end(arguments);
    if (length < 0) {
        return output_failed(output, CLAST_ERROR_FILE_WRITE);
    }
    if ((size_t)length < sizeof few) {
        return clast_file_write(output, few, (size_t)length);
    }
    char *many = clast_allocate(output->context, (size_t)length + 1, 1);
    if (many == NULL) {
        return output_failed(output, CLAST_ERROR_OUT_OF_MEMORY);
    }
    va_start(arguments, format);
    vsnprintf(many, (size_t)length + 1, format, arguments);
    va_end(arguments);
    clast_status status = clast_file_write(output, many, (size_t)length);
    clast_free(output->context, many);
    return status;
}

clast_status clast_file_commit(clast_file_output *output)
{
    if (output->status != CLAST_OK) {
        clast_file_discard(output);
        return output->status;
    }
    const clast_file_hook *files = clast_context_files(output->context);
    clast_status status = files->commit(files->user, output->handle);
    output->handle = NULL;
    return status == CLAST_OK ? CLAST_OK : output_failed(output, status);
}

void clast_file_discard(clast_file_output *output)
{
    const clast_file_hook *files = clast_context_files(output->context);
    if (output->handle != NULL) {
        files->discard(files->user, output->handle);
        output->handle = NULL;
    }
}

// ---------------------------------------------------------------------------------------------------------- paths

char *clast_path_beside(clast_context *context, const char *base, const char *relative)
{
    const char *slash = strrchr(base, '/');
    size_t folder = relative[0] == '/' || slash == NULL ? 0 : (size_t)(slash - base) + 1;
    size_t length = strlen(relative);
    char *path = clast_allocate(context, folder + length + 1, 1);
    if (path != NULL) {
        memcpy(path, base, folder);
        memcpy(path + folder, relative, length + 1);
    }
    return path;
}

void clast_path_extension(const char *path, char *extension, size_t size)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash != NULL ? slash + 1 : path;
    const char *dot = strrchr(name, '.');
    size_t length = 0;
    for (const char *c = dot != NULL ? dot + 1 : ""; *c != '\0' && length + 1 < size; c++) {
        extension[length++] = (char)tolower((unsigned char)*c);
    }
    extension[length] = '\0';
}

bool clast_path_is_folder(const char *path)
{
    struct stat information;
    return stat(path, &information) == 0 && S_ISDIR(information.st_mode);
}

clast_status clast_make_folder(clast_context *context, const char *path)
{
    char *partial = clast_copy_text(context, path);
    if (partial == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    for (char *c = partial + 1; status == CLAST_OK && partial[0] != '\0'; c++) {
        if (*c != '/' && *c != '\0') {
            continue;
        }
        char kept = *c;
        *c = '\0';
        if (mkdir(partial, 0777) != 0 && !clast_path_is_folder(partial)) {
            status = clast_fail(context, CLAST_ERROR_FILE_WRITE, "%s: the folder could not be made", partial);
        }
        *c = kept;
        if (kept == '\0') {
            break;
        }
    }
    clast_free(context, partial);
    return status;
}
