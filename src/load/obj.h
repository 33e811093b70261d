// SPDX-License-Identifier: Apache-2.0
// What an OBJ file says, before it becomes meshes.
#ifndef CLAST_LOAD_OBJ_H
#define CLAST_LOAD_OBJ_H

#include "load/load.h"
#include "load/mtl.h"
#include "load/table.h"

// A face's corner: indices into the file's lists from 0, CLAST_NONE where the file gives none.
typedef struct clast_obj_corner {
    uint32_t position, coordinate, normal;
} clast_obj_corner;

// A face's corners end where those of the next begin.
typedef struct clast_obj_face {
    uint64_t first_corner;
    uint64_t line;      // of the file, for errors
    uint32_t material;  // into the names of `usemtl`, CLAST_NONE before the first
    uint32_t smoothing; // group, 0 for none
} clast_obj_face;

typedef struct clast_obj_object {
    char *name; // null before the first `o`
    size_t first_face;
} clast_obj_object;

typedef struct clast_obj_material {
    char *name;
    uint32_t number; // of the scene; known when the whole file is read
} clast_obj_material;

typedef struct clast_obj {
    clast_scene *scene;
    clast_context *context;
    const char *path;
    float (*positions)[3];
    size_t position_count, position_capacity;
    float (*colours)[3]; // as many as positions, or none at all; as the file has them
    size_t colour_count, colour_capacity;
    float (*coordinates)[2];
    size_t coordinate_count, coordinate_capacity;
    float (*normals)[3]; // unit length, or zero
    size_t normal_count, normal_capacity;
    // Most files give a corner's indices alike: while all do, only those of positions are kept, a third of the memory.
    uint32_t *alike_corners;
    bool has_alike_coordinates, has_alike_normals; // else those corners have none
    clast_obj_corner *corners;                     // null while all are alike
    size_t corner_count, corner_capacity;
    clast_obj_face *faces;
    size_t face_count, face_capacity;
    clast_obj_object *objects;
    size_t object_count, object_capacity;
    clast_obj_material *materials;
    size_t material_count, material_capacity;
    clast_table material_table;
    clast_mtl library;
} clast_obj;

static inline clast_obj_corner clast_obj_corner_at(const clast_obj *obj, uint64_t number)
{
    if (obj->corners != NULL) {
        return obj->corners[number];
    }
    uint32_t index = obj->alike_corners[number];
    return (clast_obj_corner){index, obj->has_alike_coordinates ? index : CLAST_NONE,
                              obj->has_alike_normals ? index : CLAST_NONE};
}

// Adds a mesh and an instance for each object that has faces. Frees the corners and faces when the last object has used them.
clast_status clast_obj_add_meshes(clast_obj *obj);

#endif
