// SPDX-License-Identifier: Apache-2.0
// Writers of models: meshes of arrays, and where they stand.
#ifndef CLAST_LOAD_MESH_WRITE_H
#define CLAST_LOAD_MESH_WRITE_H

#include "base/file.h"
#include "scene/scene.h"

typedef struct clast_write_instance {
    uint32_t mesh;
    clast_transform to_world;
    const char *name; // may be null
} clast_write_instance;

// What is written. Every mesh has normals; materials are the scene's.
typedef struct clast_write_model {
    const clast_scene *scene;
    const clast_mesh *const *meshes;
    const char *const *names; // of the meshes; each may be null
    size_t mesh_count;
    const clast_write_instance *instances;
    size_t instance_count;
} clast_write_model;

// Each reports progress as "write", and leaves nothing under any name where it fails.
// Errors: FILE_WRITE, LIMIT, OUT_OF_MEMORY, CANCELLED.

// glTF 2.0: PATH with its buffer PATH.bin and images PATH.N.png (without the extension), or, where `is_binary`, one .glb. Instances
// stay instances. Displacement is not written: the meshes have it already.
clast_status clast_gltf_write(clast_context *context, const char *path, bool is_binary, const clast_write_model *model);

// Binary PLY: one mesh of all instances, in the world: positions, normals, texture coordinates (s, t) where the meshes have them.
clast_status clast_ply_write(clast_context *context, const char *path, const clast_write_model *model);

#endif
