// SPDX-License-Identifier: Apache-2.0
// What an OBJ file says, before it becomes meshes. The file is cut at ends of lines into pieces, which are surveyed and then read on
// all threads: the survey says how much there is, so that each piece has its place in arrays of the right size. Only what lines mean
// for those after them (objects, materials, smoothing groups, libraries) goes through the pieces in order.
#ifndef CLAST_LOAD_OBJ_H
#define CLAST_LOAD_OBJ_H

#include "base/thread.h"
#include "load/load.h"
#include "load/mtl.h"
#include "load/table.h"

// A face's corner: indices into the file's lists from 0, CLAST_NONE where the file gives none.
typedef struct clast_obj_corner {
    uint32_t position, coordinate, normal;
} clast_obj_corner;

// How corners give their indices. Where all of an object are alike, and give one number for each index, only positions are kept.
enum {
    CLAST_OBJ_KNOWN = 1, // there are corners
    CLAST_OBJ_COORDINATES = 2,
    CLAST_OBJ_NORMALS = 4,
    CLAST_OBJ_UNLIKE = 8, // else one number, and the same indices for all corners
};

// Faces of one object in one piece.
typedef struct clast_obj_span {
    char *name;         // of the object that begins with it, or null
    bool begins_object; // an `o` stands before it, in its piece
    uint8_t form;
    uint32_t piece, object;
    uint32_t face_corners;               // where all faces have as many; else 0, and their lengths are the piece's
    uint32_t first_face, face_count;     // in the piece
    size_t first_corner, first_triangle; // in the object
    size_t corner_count, triangle_count;
} clast_obj_span;

// What holds for a piece's faces from `first_face` on.
typedef struct clast_obj_run {
    uint32_t first_face;
    uint32_t material;                // into the names of `usemtl`, CLAST_NONE before the first
    uint32_t smoothing;               // group, 0 for none
    bool has_material, has_smoothing; // else those of the run before
} clast_obj_run;

typedef struct clast_obj_name {
    char *text;
    uint32_t number; // of materials: of the piece's names, the file's
    uint64_t line;   // of libraries
} clast_obj_name;

typedef struct clast_obj_error {
    clast_status status;
    const char *what; // that was expected, or is too many
    uint64_t line;    // of the piece
} clast_obj_error;

typedef struct clast_obj_piece {
    uint64_t begin, end; // bytes of the file
    // By the survey:
    size_t first_position, position_count;
    size_t first_coordinate, coordinate_count;
    size_t first_normal, normal_count;
    size_t first_face, face_count; // of at least three corners
    clast_obj_span *spans;         // until all are in one array
    size_t first_span, span_count, span_capacity;
    bool ends_with_object; // an `o` stands behind the last face
    // By reading it:
    uint64_t line_count;
    uint32_t *lengths;   // corners of each face; null where each span's are as many
    float (*colours)[3]; // from the first coloured vertex on
    clast_obj_run *runs;
    size_t run_count, run_capacity;
    clast_obj_name *materials, *libraries;
    size_t material_count, material_capacity, library_count, library_capacity;
    clast_table material_table;
    char *last_name; // of the object behind the last face
    uint64_t short_faces;
    bool has_zero_normal;
    clast_obj_error error; // what ended the reading
    clast_obj_error wild;  // the first index beyond the file's lists
} clast_obj_piece;

typedef struct clast_obj_object {
    char *name;
    size_t first_span, span_count;
    uint64_t face_count, corner_count, triangle_count;
    uint8_t form;
    uint32_t *positions, *coordinates, *normals; // of corners; the latter where they are unlike
} clast_obj_object;

// Where a thread reads pieces to.
typedef struct clast_obj_window {
    clast_file_window window;
    size_t piece; // that is in it, or SIZE_MAX
} clast_obj_window;

typedef struct clast_obj {
    clast_scene *scene;
    clast_context *context;
    const char *path;
    const clast_file_source *file;
    clast_obj_window *windows; // for each worker
    clast_obj_piece *pieces;
    size_t piece_count, piece_capacity;
    clast_obj_span *spans; // in the order of the file
    size_t span_count, span_capacity;
    clast_obj_object *objects; // that have faces
    size_t object_count, object_capacity;
    float (*positions)[3];
    float (*colours)[3]; // as many, or null; as the file has them
    float (*coordinates)[2];
    float (*normals)[3]; // unit length, or zero
    size_t position_count, coordinate_count, normal_count;
    bool has_zero_normal;
    clast_obj_name *materials;
    size_t material_count, material_capacity;
    clast_table material_table;
    clast_mtl library;
} clast_obj;

// The corner of an object, whose positions are still those of the file.
static inline clast_obj_corner clast_obj_corner_at(const clast_obj_object *object, size_t number)
{
    uint32_t position = object->positions[number];
    bool alike = (object->form & CLAST_OBJ_UNLIKE) == 0;
    return (clast_obj_corner){
        position,
        object->coordinates != NULL                            ? object->coordinates[number]
        : alike && (object->form & CLAST_OBJ_COORDINATES) != 0 ? position
                                                               : CLAST_NONE,
        object->normals != NULL                            ? object->normals[number]
        : alike && (object->form & CLAST_OBJ_NORMALS) != 0 ? position
                                                           : CLAST_NONE,
    };
}

// What two forms are together.
static inline uint8_t clast_obj_join_forms(uint8_t a, uint8_t b)
{
    return a == 0 || b == 0 || a == b ? a | b : a | b | CLAST_OBJ_UNLIKE;
}

// A copy of a word, or null where memory ran out.
char *clast_obj_copy_word(clast_context *context, clast_word word);
// The number of a name in a list without doubles: the one that is there, or a new one.
clast_status clast_obj_number_name(clast_context *context, clast_table *table, clast_obj_name **names, size_t *count,
                                   size_t *capacity, clast_word name, uint32_t *number);

// Brings a piece's bytes into memory, for a worker.
clast_status clast_obj_look_at(const clast_obj *obj, size_t piece, uint32_t worker, clast_text *text);
// Calls the function for all pieces, some at a time, with progress between; it gets a clast_obj_walk.
typedef struct clast_obj_walk {
    clast_obj *obj;
    size_t first; // piece: of those under way
} clast_obj_walk;
clast_status clast_obj_walk_pieces(clast_obj *obj, clast_range_function function, int step);

// Finds the pieces, of about so many bytes, and what is in them. Makes the file's arrays and objects, empty.
clast_status clast_obj_survey(clast_obj *obj, size_t piece_size);
// Fills them.
clast_status clast_obj_read(clast_obj *obj);

// A walk over a span's faces.
typedef struct clast_obj_cursor {
    const clast_obj_piece *piece;
    const clast_obj_span *span;
    const clast_obj_run *run;
    uint32_t face;   // of the piece
    uint32_t length; // its corners
    size_t corner;   // its first, in the object
} clast_obj_cursor;

static inline clast_obj_cursor clast_obj_first_face(const clast_obj *obj, const clast_obj_span *span)
{
    clast_obj_cursor cursor = {&obj->pieces[span->piece], span, NULL, span->first_face, span->face_corners,
                               span->first_corner};
    size_t below = 0, above = cursor.piece->run_count; // the last run that begins at the face or before
    while (above - below > 1) {
        size_t middle = below + (above - below) / 2;
        *(cursor.piece->runs[middle].first_face <= cursor.face ? &below : &above) = middle;
    }
    cursor.run = cursor.piece->runs + below;
    if (cursor.length == 0) {
        cursor.length = cursor.piece->lengths[cursor.face];
    }
    return cursor;
}

static inline bool clast_obj_has_face(const clast_obj_cursor *cursor)
{
    return cursor->face - cursor->span->first_face < cursor->span->face_count;
}

static inline void clast_obj_next_face(clast_obj_cursor *cursor)
{
    const clast_obj_run *end = cursor->piece->runs + cursor->piece->run_count;
    cursor->corner += cursor->length;
    cursor->face++;
    while (cursor->run + 1 < end && cursor->run[1].first_face <= cursor->face) {
        cursor->run++;
    }
    if (cursor->span->face_corners == 0 && clast_obj_has_face(cursor)) {
        cursor->length = cursor->piece->lengths[cursor->face];
    }
}

// The scene's material of a run.
static inline uint32_t clast_obj_material(const clast_obj *obj, const clast_obj_run *run)
{
    return run->material != CLAST_NONE ? obj->materials[run->material].number : 0;
}

// Whether the file gives the corner a normal of some length.
static inline bool clast_obj_has_normal(const clast_obj *obj, clast_obj_corner corner)
{
    if (corner.normal == CLAST_NONE || !obj->has_zero_normal) {
        return corner.normal != CLAST_NONE;
    }
    const float *n = obj->normals[corner.normal];
    return n[0] != 0.0f || n[1] != 0.0f || n[2] != 0.0f;
}

// A mesh under way: blocks become the scene's.
typedef struct clast_obj_arrays {
    float (*positions)[3];
    float (*normals)[3];
    float (*coordinates)[2];
    float (*colours)[4];
    uint32_t *indices;
    uint32_t *materials; // of triangles; null where all have that of the first
    size_t vertex_count;
} clast_obj_arrays;

// Adds a mesh and an instance for each object that has faces, and frees what it is made from.
clast_status clast_obj_add_meshes(clast_obj *obj);
// Makes the mesh of an object some of whose normals must be made: one face after the other. obj_smooth.c
clast_status clast_obj_smooth_mesh(clast_obj *obj, clast_obj_object *object, bool has_coordinates,
                                   clast_obj_arrays *arrays);
void clast_obj_free_corners(const clast_obj *obj, clast_obj_object *object);
clast_status clast_obj_out_of_range(const clast_obj *obj);
void clast_obj_fill_colour(const clast_obj *obj, uint32_t position, float colour[4]);

// Loads from a source; clast_load_obj with pieces of another size. For load.c and tests.
clast_status clast_load_obj_source(clast_scene *scene, const char *path, const clast_file_source *file,
                                   size_t piece_size);

enum { CLAST_OBJ_PIECE = 256 << 10 };

#endif
