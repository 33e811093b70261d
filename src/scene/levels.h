// SPDX-License-Identifier: Apache-2.0
// Levels of a picture: what it is at half as many texels a side, at a quarter, and so on down to one texel, so that what is far
// away is read from few texels.
#ifndef CLAST_SCENE_LEVELS_H
#define CLAST_SCENE_LEVELS_H

#include "base/context.h"
#include "clast/scene.h"
#include "scene/blocks.h"

enum { CLAST_LEVELS_MOST = 16 }; // below the finest, of 65536 texels a side

typedef struct clast_image_levels {
    uint32_t count; // below the finest, which is not among them; 0: there are none
    uint32_t channels;
    clast_pixel_type type;
    void *pixels; // a block of clast_allocate: one level after the other, rows from the top, tightly packed
    size_t bytes;
    size_t offsets[CLAST_LEVELS_MOST]; // of each level, in bytes; that of level k, whose number begins at 1, is [k - 1]
} clast_image_levels;

// Texels of a side at a level: half of those before it, rounded down, and one at least.
static inline uint32_t clast_level_side(uint32_t side, uint32_t level)
{
    return side >> level != 0 ? side >> level : 1;
}

// How many levels lie below the finest until there is one texel.
static inline uint32_t clast_level_count(uint32_t width, uint32_t height)
{
    uint32_t longest = width > height ? width : height, count = 0;
    while (longest >> (count + 1) != 0) {
        count++;
    }
    return count;
}

// What a file has of a picture beside its pixels. All data are blocks of clast_allocate.
typedef struct clast_image_parts {
    clast_image_blocks blocks; // that the pixels were decoded from, where devices read them alike
    clast_image_levels levels;
} clast_image_parts;

// Allocates `count` levels below a picture (fewer where it has fewer), of its type and channels or of others; the pixels are
// undefined yet. Where memory runs out, `levels` is empty.
clast_status clast_levels_create(clast_context *context, const clast_image *finest, uint32_t channels,
                                 clast_pixel_type type, uint32_t count, clast_image_levels *levels);
// A level, which begins at 1, as a picture.
clast_image clast_level_image(const clast_image *finest, const clast_image_levels *levels, uint32_t level);
void clast_levels_free(clast_context *context, clast_image_levels *levels);

#endif
