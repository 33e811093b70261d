// SPDX-License-Identifier: Apache-2.0
// Values of a scene's textures.
#ifndef CLAST_RENDER_TEXTURE_H
#define CLAST_RENDER_TEXTURE_H

#include "scene/scene.h"
#include "shared/ray_cone.h"

// What 8-bit values are, made once for a render.
typedef struct clast_srgb_table {
    float linear[256]; // of sRGB
    float plain[256];  // of what is linear already
} clast_srgb_table;

void clast_srgb_table_fill(clast_srgb_table *table);

typedef enum clast_encoding {
    CLAST_ENCODING_LINEAR = ENCODING_LINEAR,
    CLAST_ENCODING_SRGB = ENCODING_SRGB,
    CLAST_ENCODING_CUTOUT = ENCODING_CUTOUT,
    CLAST_ENCODING_NORMAL = ENCODING_NORMAL,
} clast_encoding;

// How a picture's levels are made that is used for an encoding: without alpha, nothing is cut out.
clast_encoding clast_levels_encoding(const clast_image *image, clast_encoding encoding);

// A texel as red, green, blue, alpha: grey counts for all colours, a missing alpha is one.
vec4 clast_image_texel(const clast_image *image, uint32_t x, uint32_t y, clast_encoding encoding,
                       const clast_srgb_table *table);
// The mean of four texels by their weights.
vec4 clast_image_blend(const clast_image *image, clast_texel_pair x, clast_texel_pair y, clast_encoding encoding,
                       const clast_srgb_table *table);

// Where a point of a surface is in textures, and how much of them a sample sees there.
typedef struct clast_texture_area {
    vec2 coordinates[2];
    clast_footprint footprints[2]; // around them
    uint32_t look;                 // LOOK_: how closely at these
} clast_texture_area;

// A point, as the finest level has it.
static inline clast_texture_area clast_texture_point(const vec2 coordinates[2])
{
    return (clast_texture_area){.coordinates = {coordinates[0], coordinates[1]}};
}

// A material's texture at a place of a surface; `otherwise` where there is none. The texture's own filter counts on the finest
// level; those below are always blended. Of a normal map, the fourth value is what the mean normal's length lacks of one.
vec4 clast_texture_value(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                         clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise);

// Asks for the texels that clast_texture_value will read, and does not wait for them.
void clast_texture_prefetch(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                            clast_encoding encoding);

// The alpha alone, on the finest level: what hits count by it does not depend on how they are seen.
float clast_texture_alpha(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2]);

#endif
