// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: polygons, with texture coordinates, normals, vertex colours, smoothing groups, objects and materials.
// What else the format has (curves, points, lines, groups, subdivision tags) is passed over. A file without normals has
// flat triangles, but for faces in a smoothing group (`s`), whose normals are averaged by area within the group.
#include "load/obj.h"

#include "load/text.h"

static clast_status fail_at(const clast_obj *obj, const clast_obj_error *error, uint64_t lines_before)
{
    unsigned long long line = lines_before + error->line;
    switch (error->status) {
    case CLAST_ERROR_MALFORMED:
        return clast_fail(obj->context, error->status, "%s, line %llu: expected %s", obj->path, line, error->what);
    case CLAST_ERROR_LIMIT:
        return clast_fail(obj->context, error->status, "%s, line %llu: more %s than a file may have (%u)", obj->path,
                          line, error->what, CLAST_NONE);
    case CLAST_ERROR_FILE_READ:
        return clast_fail(obj->context, error->status, "%s: %s", obj->path,
                          error->what != NULL ? error->what : clast_status_text(error->status));
    default: return error->status; // of memory: the text is there
    }
}

// ---------------------------------------------------------------------------------------------------------- libraries

static clast_status load_library(clast_obj *obj, const char *name)
{
    char *path = clast_path_beside(obj->context, obj->path, name);
    if (path == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_mtl_load(&obj->library, path);
    clast_free(obj->context, path);
    return status;
}

static bool is_missing(clast_status status)
{
    return status == CLAST_ERROR_FILE_NOT_FOUND || status == CLAST_ERROR_FILE_READ;
}

static void warn_of_library(const clast_obj *obj, const char *name, uint64_t line)
{
    clast_log(obj->context, CLAST_LOG_WARNING,
              "%s, line %llu: the material library %s is missing: its materials are plain", obj->path,
              (unsigned long long)line, name);
}

// The next name of a list of names parted by blanks, where "\ " is a blank within a name. Writes over `at`.
static char *next_name(char **at)
{
    char *from = *at + strspn(*at, " \t");
    char *name = from;
    char *to = from;
    for (; *from != '\0' && *from != ' ' && *from != '\t'; from++) {
        from += from[0] == '\\' && from[1] == ' ';
        *to++ = *from;
    }
    *at = *from != '\0' ? from + 1 : from;
    *to = '\0';
    return name;
}

// The line is one name, if a file has that name; else a list of names.
static clast_status load_libraries(clast_obj *obj, char *names, uint64_t line)
{
    clast_status status = load_library(obj, names);
    if (is_missing(status) && strpbrk(names, " \t") == NULL) {
        warn_of_library(obj, names, line);
        return CLAST_OK;
    }
    while (is_missing(status)) {
        char *name = next_name(&names);
        if (name[0] == '\0') {
            return CLAST_OK;
        }
        status = load_library(obj, name);
        if (is_missing(status)) {
            warn_of_library(obj, name, line);
        }
    }
    return status;
}

// ------------------------------------------------------------------------------------------- what holds across pieces

// What lines mean for those after them.
typedef struct obj_state {
    uint64_t lines; // before the piece
    uint32_t material, smoothing;
    char *name; // of an object that no face has come after
    uint64_t short_faces;
} obj_state;

static void free_names(clast_context *context, clast_obj_name **names, size_t *count)
{
    for (size_t i = 0; i < *count; i++) {
        clast_free(context, (*names)[i].text);
    }
    clast_free(context, *names);
    *names = NULL;
    *count = 0;
}

// Gives the piece's materials the file's numbers, and its runs what they take from those before.
static clast_status settle_runs(clast_obj *obj, clast_obj_piece *piece, obj_state *state)
{
    for (size_t i = 0; i < piece->material_count; i++) {
        clast_obj_name *material = &piece->materials[i];
        clast_word name = {material->text, strlen(material->text)};
        clast_status status = clast_obj_number_name(obj->context, &obj->material_table, &obj->materials,
                                                    &obj->material_count, &obj->material_capacity, name,
                                                    &material->number);
        if (status != CLAST_OK) {
            return status;
        }
    }
    for (size_t i = 0; i < piece->run_count; i++) {
        clast_obj_run *run = &piece->runs[i];
        state->material = run->has_material ? piece->materials[run->material].number : state->material;
        state->smoothing = run->has_smoothing ? run->smoothing : state->smoothing;
        run->material = state->material;
        run->smoothing = state->smoothing;
    }
    free_names(obj->context, &piece->materials, &piece->material_count);
    clast_table_free(obj->context, &piece->material_table);
    return CLAST_OK;
}

static void move_name(clast_obj *obj, char **to, char **from)
{
    clast_free(obj->context, *to);
    *to = *from;
    *from = NULL;
}

// An object's name stands before its first face, in the piece of that face or in one before.
static void settle_objects(clast_obj *obj, clast_obj_piece *piece, obj_state *state)
{
    for (size_t i = piece->first_span; i < piece->first_span + piece->span_count; i++) {
        clast_obj_span *span = &obj->spans[i];
        clast_obj_object *object = &obj->objects[span->object];
        if (object->first_span == i) {
            move_name(obj, &object->name, span->begins_object ? &span->name : &state->name);
        }
    }
    if (piece->ends_with_object) {
        move_name(obj, &state->name, &piece->last_name);
    }
}

static clast_status settle_piece(clast_obj *obj, clast_obj_piece *piece, obj_state *state)
{
    clast_status status = CLAST_OK;
    for (size_t i = 0; status == CLAST_OK && i < piece->library_count; i++) {
        const clast_obj_name *library = &piece->libraries[i];
        status = load_libraries(obj, library->text, state->lines + library->line);
    }
    free_names(obj->context, &piece->libraries, &piece->library_count);
    if (status == CLAST_OK && piece->error.status != CLAST_OK) {
        status = fail_at(obj, &piece->error, state->lines);
    }
    if (status == CLAST_OK) {
        status = settle_runs(obj, piece, state);
    }
    if (status == CLAST_OK) {
        settle_objects(obj, piece, state);
        state->short_faces += piece->short_faces;
        obj->has_zero_normal = obj->has_zero_normal || piece->has_zero_normal;
        state->lines += piece->line_count;
    }
    return status;
}

static clast_status check_corners(const clast_obj *obj)
{
    uint64_t lines = 0;
    for (size_t i = 0; i < obj->piece_count; i++) {
        const clast_obj_piece *piece = &obj->pieces[i];
        if (piece->wild.what != NULL) {
            return clast_fail(obj->context, CLAST_ERROR_MALFORMED,
                              "%s, line %llu: a corner's index is beyond the file's %s", obj->path,
                              (unsigned long long)(lines + piece->wild.line), piece->wild.what);
        }
        lines += piece->line_count;
    }
    return CLAST_OK;
}

// From the first coloured vertex on, all have colours.
static clast_status join_colours(clast_obj *obj)
{
    for (size_t i = 0; i < obj->piece_count; i++) {
        clast_obj_piece *piece = &obj->pieces[i];
        if (piece->colours != NULL && obj->colours == NULL) {
            obj->colours = clast_allocate(obj->context, obj->position_count, sizeof *obj->colours);
            if (obj->colours == NULL) {
                return CLAST_ERROR_OUT_OF_MEMORY;
            }
            for (size_t k = 0; k < piece->first_position; k++) {
                obj->colours[k][0] = obj->colours[k][1] = obj->colours[k][2] = 1.0f;
            }
        }
        for (size_t k = 0; obj->colours != NULL && k < piece->position_count; k++) {
            for (int c = 0; c < 3; c++) {
                obj->colours[piece->first_position + k][c] = piece->colours != NULL ? piece->colours[k][c] : 1.0f;
            }
        }
        clast_free(obj->context, piece->colours);
        piece->colours = NULL;
    }
    return CLAST_OK;
}

static clast_status settle(clast_obj *obj)
{
    obj_state state = {.material = CLAST_NONE};
    clast_status status = CLAST_OK;
    for (size_t i = 0; status == CLAST_OK && i < obj->piece_count; i++) {
        status = settle_piece(obj, &obj->pieces[i], &state);
    }
    clast_free(obj->context, state.name);
    status = status == CLAST_OK ? check_corners(obj) : status;
    status = status == CLAST_OK ? join_colours(obj) : status;
    if (status == CLAST_OK && state.short_faces > 0) {
        clast_log(obj->context, CLAST_LOG_WARNING, "%s: %llu faces have fewer than three corners and are left out",
                  obj->path, (unsigned long long)state.short_faces);
    }
    return status;
}

static void resolve_materials(clast_obj *obj)
{
    for (size_t i = 0; i < obj->material_count; i++) {
        uint32_t number = clast_mtl_find(&obj->library, obj->materials[i].text);
        if (number == CLAST_NONE) {
            clast_log(obj->context, CLAST_LOG_WARNING, "%s: no library has the material %s: it is plain", obj->path,
                      obj->materials[i].text);
        }
        obj->materials[i].number = number != CLAST_NONE ? number : 0;
    }
}

// ------------------------------------------------------------------------------------------------------------- loading

static void free_windows(clast_obj *obj)
{
    for (uint32_t i = 0; obj->windows != NULL && i < clast_worker_count(obj->context); i++) {
        clast_file_free_window(obj->context, &obj->windows[i].window);
    }
    clast_free(obj->context, obj->windows);
    obj->windows = NULL;
}

static void free_piece(clast_context *context, clast_obj_piece *piece)
{
    free_names(context, &piece->materials, &piece->material_count);
    free_names(context, &piece->libraries, &piece->library_count);
    clast_table_free(context, &piece->material_table);
    clast_free(context, piece->spans);
    clast_free(context, piece->lengths);
    clast_free(context, piece->colours);
    clast_free(context, piece->runs);
    clast_free(context, piece->last_name);
}

static void obj_free(clast_obj *obj)
{
    clast_context *context = obj->context;
    free_windows(obj);
    for (size_t i = 0; i < obj->piece_count; i++) {
        free_piece(context, &obj->pieces[i]);
    }
    for (size_t i = 0; i < obj->span_count; i++) {
        clast_free(context, obj->spans[i].name);
    }
    for (size_t i = 0; i < obj->object_count; i++) {
        clast_free(context, obj->objects[i].name);
        clast_obj_free_corners(obj, &obj->objects[i]);
    }
    clast_free(context, obj->pieces);
    clast_free(context, obj->spans);
    clast_free(context, obj->objects);
    clast_free(context, obj->positions);
    clast_free(context, obj->colours);
    clast_free(context, obj->coordinates);
    clast_free(context, obj->normals);
    free_names(context, &obj->materials, &obj->material_count);
    clast_table_free(context, &obj->material_table);
    clast_mtl_free(&obj->library);
}

clast_status clast_load_obj_source(clast_scene *scene, const char *path, const clast_file_source *file,
                                   size_t piece_size)
{
    clast_obj obj = {
        .scene = scene, .context = scene->context, .path = path, .file = file, .library = {.scene = scene}};
    uint32_t workers = clast_worker_count(obj.context);
    obj.windows = clast_allocate_zeroed(obj.context, workers, sizeof *obj.windows);
    clast_status status = obj.windows != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    for (uint32_t i = 0; status == CLAST_OK && i < workers; i++) {
        obj.windows[i].piece = SIZE_MAX;
    }
    status = status == CLAST_OK ? clast_obj_survey(&obj, piece_size) : status;
    status = status == CLAST_OK ? clast_obj_read(&obj) : status;
    free_windows(&obj);
    status = status == CLAST_OK ? settle(&obj) : status;
    if (status == CLAST_OK) {
        resolve_materials(&obj);
        status = clast_obj_add_meshes(&obj);
    }
    obj_free(&obj);
    return status;
}

clast_status clast_load_obj(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_file_source source = {scene->context, file->size, *file, -1};
    return clast_load_obj_source(scene, path, &source, CLAST_OBJ_PIECE);
}
