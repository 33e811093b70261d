// SPDX-License-Identifier: Apache-2.0
// Values of a scene's textures.
#ifndef CLAST_RENDER_TEXTURE_H
#define CLAST_RENDER_TEXTURE_H

#include "scene/scene.h"
#include "shared/texture_filter.h"

// What 8-bit sRGB values are, made once for a render.
typedef struct clast_srgb_table {
    float linear[256];
} clast_srgb_table;

void clast_srgb_table_fill(clast_srgb_table *table);

// A texel as red, green, blue, alpha: grey counts for all colours, a missing alpha is one. `table` null: values are linear;
// else those of integer images are sRGB (alpha never is).
vec4 clast_image_texel(const clast_image *image, uint32_t x, uint32_t y, const clast_srgb_table *table);

// A material's texture at a surface's coordinates; `otherwise` where there is none.
vec4 clast_texture_value(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2], const clast_srgb_table *table,
                         vec4 otherwise);

// Its alpha alone.
float clast_texture_alpha(const clast_scene *scene, clast_texture_use use, const vec2 coordinates[2]);

#endif
