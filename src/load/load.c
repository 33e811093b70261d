// SPDX-License-Identifier: Apache-2.0
// Which format a file has: by its contents, then by its name.
#include "load/load.h"

#include "load/account.h"
#include "load/obj.h"
#include "load/ply.h"

// ------------------------------------------------------------------------------------------------------ kinds of JSON

// Moves over the string that begins at `at`, and gives what follows it.
static const char *skip_string(const char *at, const char *end)
{
    for (at++; at < end && *at != '"'; at++) {
        at += *at == '\\' && at + 1 < end;
    }
    return at < end ? at + 1 : end;
}

// Whether the outermost object of a JSON text has a member of that name. The text need not be sound: its loader says
// so.
static bool has_member(clast_bytes bytes, const char *name)
{
    const char *at = (const char *)bytes.data;
    const char *end = at + bytes.size;
    size_t length = strlen(name);
    int64_t depth = 0;
    while (at < end) {
        if (*at != '"') {
            depth += *at == '{' || *at == '[';
            depth -= *at == '}' || *at == ']';
            at++;
            continue;
        }
        const char *begin = at + 1;
        at = skip_string(at, end);
        bool is_name = depth == 1 && (size_t)(at - begin) == length + 1 && memcmp(begin, name, length) == 0;
        while (is_name && at < end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) {
            at++;
        }
        if (is_name && at < end && *at == ':') {
            return true;
        }
    }
    return false;
}

static bool is_json(clast_bytes bytes)
{
    uint64_t i = clast_bytes_begin_with(bytes, "\xef\xbb\xbf") ? 3 : 0;
    while (i < bytes.size &&
           (bytes.data[i] == ' ' || bytes.data[i] == '\t' || bytes.data[i] == '\n' || bytes.data[i] == '\r')) {
        i++;
    }
    return i < bytes.size && bytes.data[i] == '{';
}

// --------------------------------------------------------------------------------------------------------- the kinds

typedef clast_status loader(clast_scene *scene, const char *path, clast_file_view *file);

static loader *loader_of_contents(clast_bytes bytes)
{
    if (clast_bytes_begin_with(bytes, "glTF")) {
        return clast_load_gltf;
    }
    if (clast_bytes_begin_with(bytes, "ply\n") || clast_bytes_begin_with(bytes, "ply\r")) {
        return clast_load_ply;
    }
    if (is_json(bytes)) {
        return has_member(bytes, "clast") ? clast_load_scene_file : has_member(bytes, "asset") ? clast_load_gltf : NULL;
    }
    return NULL;
}

static loader *loader_of_name(const char *path)
{
    static const struct {
        const char *extension;
        loader *load;
    } kinds[] = {
        {"gltf", clast_load_gltf}, {"glb", clast_load_gltf}, {"obj", clast_load_obj},
        {"ply", clast_load_ply},   {"stl", clast_load_stl},  {"json", clast_load_scene_file},
    };
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(kinds[i].extension, extension) == 0) {
            return kinds[i].load;
        }
    }
    return NULL;
}

bool clast_is_gltf(const char *path, clast_bytes bytes)
{
    loader *load = loader_of_name(path);
    return load == clast_load_gltf || (load == NULL && loader_of_contents(bytes) == clast_load_gltf);
}

static clast_status load_file(clast_scene *scene, const char *path, clast_file_view *file, bool within_scene_file)
{
    if (file->size == 0) {
        return clast_fail(scene->context, CLAST_ERROR_MALFORMED, "%s: the file is empty", path);
    }
    loader *load = loader_of_contents((clast_bytes){file->data, file->size});
    load = load != NULL ? load : loader_of_name(path);
    if (load == NULL) {
        return clast_fail(scene->context, CLAST_ERROR_UNSUPPORTED,
                          "%s: not a file that clast reads: expected .gltf, .glb, .obj, .ply, .stl or a scene .json",
                          path);
    }
    if (load == clast_load_scene_file && within_scene_file) {
        return clast_fail(scene->context, CLAST_ERROR_UNSUPPORTED,
                          "%s: a scene file cannot be a model of another scene file", path);
    }
    size_t first = scene->geometry_count;
    clast_status status = load(scene, path, file);
    // A scene file has decided for its models.
    bool decides = status == CLAST_OK && load != clast_load_scene_file;
    return decides ? clast_scene_tessellate_displaced(scene, first) : status;
}

// Whether the bytes that a file begins with leave its kind to its name.
static bool is_told_by_name(clast_bytes beginning)
{
    uint64_t i = clast_bytes_begin_with(beginning, "\xef\xbb\xbf") ? 3 : 0;
    while (i < beginning.size && (beginning.data[i] == ' ' || beginning.data[i] == '\t' || beginning.data[i] == '\n' ||
                                  beginning.data[i] == '\r')) {
        i++;
    }
    return i < beginning.size && !is_json(beginning) && loader_of_contents(beginning) == NULL;
}

// Loads a large file piece by piece, if it is of a kind that can be; else *is_loaded stays false.
static clast_status load_in_pieces(clast_scene *scene, const char *path, bool *is_loaded)
{
    unsigned char room[4096];
    const unsigned char *bytes = room;
    *is_loaded = false;
    loader *named = loader_of_name(path);
    if (named != clast_load_obj && named != clast_load_ply) {
        return CLAST_OK;
    }
    clast_file_source file;
    clast_status status = clast_file_open(scene->context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    size_t size = file.size < sizeof room ? (size_t)file.size : sizeof room;
    status = clast_file_piece(&file, 0, size, room, &bytes);
    if (status != CLAST_OK) {
        clast_fail(scene->context, status, "%s: %s", path, clast_status_text(status));
    } else {
        clast_bytes beginning = {bytes, size};
        bool is_ply = loader_of_contents(beginning) == clast_load_ply;
        *is_loaded = is_ply || (named == clast_load_obj && is_told_by_name(beginning));
        if (*is_loaded) {
            size_t first = scene->geometry_count;
            clast_account_read(scene, file.size);
            status = is_ply ? clast_load_ply_source(scene, path, &file)
                            : clast_load_obj_source(scene, path, &file, CLAST_OBJ_PIECE);
            status = status == CLAST_OK ? clast_scene_tessellate_displaced(scene, first) : status;
        }
    }
    clast_file_close(&file);
    return status;
}

static clast_status load_path(clast_scene *scene, const char *path, bool within_scene_file)
{
    bool is_loaded;
    clast_file_view file;
    clast_status status = load_in_pieces(scene, path, &is_loaded);
    if (is_loaded) {
        return status;
    }
    status = status == CLAST_OK ? clast_file_map(scene->context, path, &file) : status;
    if (status == CLAST_OK) {
        clast_account_read(scene, file.size);
        status = load_file(scene, path, &file, within_scene_file);
        clast_file_unmap(scene->context, &file);
    } else if (status == CLAST_ERROR_FILE_READ && clast_path_is_folder(path)) {
        clast_fail(scene->context, status,
                   "%s: is a folder: expected a .gltf, .glb, .obj, .ply, .stl or a scene .json file", path);
    }
    return status;
}

clast_status clast_load_into(clast_scene *scene, const char *path)
{
    return load_path(scene, path, false);
}

clast_status clast_load_model(clast_scene *scene, const char *path)
{
    return load_path(scene, path, true);
}

clast_status clast_scene_load(clast_context *context, const char *path, clast_scene **scene)
{
    return clast_scene_load_chosen(context, path, NULL, scene);
}

clast_status clast_scene_load_chosen(clast_context *context, const char *path, const clast_scene_choice *choice,
                                     clast_scene **scene)
{
    if (context == NULL || path == NULL || scene == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *scene = NULL;
    clast_scene *loaded;
    clast_status status = clast_scene_create(context, &loaded);
    if (status != CLAST_OK) {
        return status;
    }
    loaded->choice = choice != NULL ? *choice : (clast_scene_choice){NULL, NULL};
    status = clast_load_into(loaded, path);
    loaded->choice = (clast_scene_choice){NULL, NULL};
    if (status != CLAST_OK) {
        clast_scene_destroy(loaded);
        return status;
    }
    *scene = loaded;
    return CLAST_OK;
}
