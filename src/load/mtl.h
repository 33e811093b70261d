// SPDX-License-Identifier: Apache-2.0
// Materials of MTL files, as metallic-roughness.
#ifndef CLAST_LOAD_MTL_H
#define CLAST_LOAD_MTL_H

#include "load/load.h"
#include "load/table.h"
#include "load/text.h"

typedef struct clast_mtl_entry {
    char *name;
    uint32_t number; // of the scene
} clast_mtl_entry;

// The materials of all libraries of an OBJ file. Zero, but for the scene, is empty.
typedef struct clast_mtl {
    clast_scene *scene;
    clast_mtl_entry *entries;
    size_t entry_count, entry_capacity;
    clast_table entry_table;
    clast_mtl_entry *textures; // by what they were made from; CLAST_NONE for those that could not be read
    size_t texture_count, texture_capacity;
    clast_table texture_table;
} clast_mtl;

// Reads a library. Textures that cannot be read are left out, with a warning.
clast_status clast_mtl_load(clast_mtl *library, const char *path);
void clast_mtl_free(clast_mtl *library);

// The number of a material; CLAST_NONE where no library has it.
uint32_t clast_mtl_find(const clast_mtl *library, const char *name);

// ----------------------------------------------------------------------------------------------- for mtl_texture.c

// A line such as `map_Kd -s 2 2 wood.png`.
typedef struct clast_mtl_map {
    char *path; // null: none; beside the library
    float offset[2], scale[2];
    float multiplier; // -bm
    float base, gain; // -mm
    bool has_range;   // base and gain are given
    bool clamp;
} clast_mtl_map;

typedef enum clast_mtl_texture_use {
    CLAST_MTL_COLOUR,          // the first map; the second, if any, becomes its alpha
    CLAST_MTL_ROUGHNESS_METAL, // the first map becomes green, the second blue; white where there is none
    CLAST_MTL_NORMALS,         // the first map
    CLAST_MTL_BUMPS,           // the first map, if it holds normals
    CLAST_MTL_HEIGHTS,         // the first map
    CLAST_MTL_BUMP_HEIGHTS,    // the first map, if it holds heights
} clast_mtl_texture_use;

// Makes the texture, or finds one made before, and fills the slot. The slot's texture is CLAST_NONE where a file could
// not be read (with a warning): what is returned is about memory and the like.
clast_status clast_mtl_texture(clast_mtl *library, clast_mtl_texture_use use, const clast_mtl_map *first,
                               const clast_mtl_map *second, clast_texture_slot *slot);

#endif
