// SPDX-License-Identifier: Apache-2.0
// Pictures of surfaces, which tile: colour, normals, roughness. Colours are near white: meshes bring the hue.
#ifndef CLAST_GENERATE_TEXTURES_H
#define CLAST_GENERATE_TEXTURES_H

#include "generate/outputs.h"
#include "shared/dialect.h"

typedef enum clast_texture_kind {
    CLAST_TEXTURE_SAND,
    CLAST_TEXTURE_ROCK,
    CLAST_TEXTURE_STONE,
    CLAST_TEXTURE_GOLD,
    CLAST_TEXTURE_LAPIS,
    CLAST_TEXTURE_MARBLE,
    CLAST_TEXTURE_KINDS,
} clast_texture_kind;

typedef struct clast_texture_files {
    const char *colour, *normal, *roughness; // names of files; normal may be null
} clast_texture_files;

extern const clast_texture_files clast_texture_names[CLAST_TEXTURE_KINDS];

// Writes the pictures of a kind, `size` pixels square.
void clast_write_textures(clast_outputs *outputs, clast_texture_kind kind, uint32_t size, uint32_t seed);

#endif
