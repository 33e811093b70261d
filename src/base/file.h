// SPDX-License-Identifier: Apache-2.0
// Files by way of the context's hooks, and the machine's own files as the default hook.
#ifndef CLAST_BASE_FILE_H
#define CLAST_BASE_FILE_H

#include "base/context.h"

// A file's bytes. The error names the path. The machine's own files are read into memory, which counts as the context's, so that
// they stay as they are; only those of more than 1 GiB are mapped.
clast_status clast_file_map(clast_context *context, const char *path, clast_file_view *view);
void clast_file_unmap(clast_context *context, clast_file_view *view);

// A file that is read piece by piece, so that memory holds no more of it than is being looked at. A hook of the user's gives its
// whole view instead.
typedef struct clast_file_source {
    clast_context *context;
    uint64_t size;
    clast_file_view view; // data is null where pieces are read
    int descriptor;       // -1 where they are not
} clast_file_source;

// The error names the path.
clast_status clast_file_open(clast_context *context, const char *path, clast_file_source *source);
void clast_file_close(clast_file_source *source);
// Bytes [offset, offset + size) of the file, inside its size: in `room`, or where they lie in memory. From any thread; records no
// text. FILE_READ where the file has become shorter.
clast_status clast_file_piece(const clast_file_source *source, uint64_t offset, size_t size, void *room,
                              const unsigned char **bytes);

// Room for pieces, which grows as they need it; zero is empty.
typedef struct clast_file_window {
    unsigned char *room;
    size_t capacity;
} clast_file_window;

// The same, with the window's room.
clast_status clast_file_look(const clast_file_source *source, clast_file_window *window, uint64_t offset, size_t size,
                             const unsigned char **bytes);
void clast_file_free_window(clast_context *context, clast_file_window *window);

// An output file: nothing appears under `path` before clast_file_commit, so a failure or a kill leaves no half file.
typedef struct clast_file_output {
    clast_context *context;
    void *handle;
    const char *path;    // the caller's, valid until commit or discard
    clast_status status; // the first failure; later writes do nothing
} clast_file_output;

clast_status clast_file_create(clast_context *context, const char *path, clast_file_output *output);
clast_status clast_file_write(clast_file_output *output, const void *data, size_t size);
clast_status clast_file_print(clast_file_output *output, const char *format, ...) CLAST_PRINTF(2, 3);
// Ends the output: makes it visible and durable, or, after a failed write, gives it up and returns that failure.
clast_status clast_file_commit(clast_file_output *output);
void clast_file_discard(clast_file_output *output);

// `directory of base`/`relative`, in a new block; `relative` alone where it is absolute or base has no directory.
char *clast_path_beside(clast_context *context, const char *base, const char *relative);
// What follows the last dot of the last component, in lower case, into `extension` (size bytes); empty where none.
void clast_path_extension(const char *path, char *extension, size_t size);
// Whether the machine has a folder of that name.
bool clast_path_is_folder(const char *path);
// The machine's own files.
extern const clast_file_hook clast_machine_files;
// Makes a folder, and those above it, where they are missing.
clast_status clast_make_folder(clast_context *context, const char *path);

#endif
