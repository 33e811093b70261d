// SPDX-License-Identifier: Apache-2.0
// What the files of the glTF writer share. What fails is noted in the writer and looked at once, at the end.
#ifndef CLAST_LOAD_GLTF_WRITE_H
#define CLAST_LOAD_GLTF_WRITE_H

#include <jansson.h>

#include "load/mesh_write.h"

// A part of the buffer.
typedef struct clast_gltf_piece {
    const void *data;
    uint64_t size;
    void *owned; // freed with the writer; may be null
} clast_gltf_piece;

typedef struct clast_gltf_writer {
    clast_context *context;
    const char *path;
    bool is_binary;
    const clast_write_model *model;
    char stem[204], buffer_name[212];
    json_t *extensions, *views, *accessors, *meshes, *nodes, *roots, *materials, *textures, *images, *samplers;
    clast_gltf_piece *pieces;
    size_t piece_count, piece_capacity;
    uint64_t length;                                              // of the buffer
    uint32_t *material_numbers, *texture_numbers, *image_numbers; // in the file, by the scene's; CLAST_NONE: not yet
    bool *image_is_colour;                                        // by the scene's
    uint32_t *starts;                                             // scratch: one for each material, and two
    bool failed;                                                  // memory ran out
    clast_status status;                                          // other failures
} clast_gltf_writer;

// gltf_write.c
void clast_gltf_write_set(clast_gltf_writer *writer, json_t *object, const char *key, json_t *value);
uint32_t clast_gltf_write_append(clast_gltf_writer *writer, json_t *array, json_t *value);
json_t *clast_gltf_write_numbers(const float *values, uint32_t count);
void clast_gltf_write_name(clast_gltf_writer *writer, json_t *object, const char *name);
// A new piece and its view, whose number it gives. `owned` is freed with the writer. `target` 0 is none.
uint32_t clast_gltf_write_piece(clast_gltf_writer *writer, const void *data, uint64_t size, void *owned, int target);

// gltf_write_material.c
// A material's number in the file; it is added when first asked for, with its textures and images.
uint32_t clast_gltf_write_material(clast_gltf_writer *writer, uint32_t material);
// Writes the images beside the file.
clast_status clast_gltf_write_images(clast_gltf_writer *writer);

#endif
