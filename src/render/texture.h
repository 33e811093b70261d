// SPDX-License-Identifier: Apache-2.0
// Values of a scene's textures.
#ifndef CLAST_RENDER_TEXTURE_H
#define CLAST_RENDER_TEXTURE_H

#include "scene/scene.h"
#include "shared/texture_filter.h"

// What 8-bit values are, made once for a render.
typedef struct clast_srgb_table {
    float linear[256]; // of sRGB
    float plain[256];  // of what is linear already
} clast_srgb_table;

void clast_srgb_table_fill(clast_srgb_table *table);

typedef enum clast_encoding {
    CLAST_ENCODING_LINEAR = ENCODING_LINEAR,
    CLAST_ENCODING_SRGB = ENCODING_SRGB,
} clast_encoding;

// A texel as red, green, blue, alpha: grey counts for all colours, a missing alpha is one.
vec4 clast_image_texel(const clast_image *image, uint32_t x, uint32_t y, clast_encoding encoding,
                       const clast_srgb_table *table);
// The mean of four texels by their weights.
vec4 clast_image_blend(const clast_image *image, clast_texel_pair x, clast_texel_pair y, clast_encoding encoding,
                       const clast_srgb_table *table);

// A material's texture at a surface's coordinates; `otherwise` where there is none.
vec4 clast_texture_value(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2],
                         clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise);

// Asks for the texels that clast_texture_value will read, and does not wait for them.
void clast_texture_prefetch(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2]);

// Its alpha alone.
float clast_texture_alpha(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2]);

#endif
