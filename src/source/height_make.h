// SPDX-License-Identifier: Apache-2.0
// How displacement maps are made, for height.c.
#ifndef CLAST_SOURCE_HEIGHT_MAKE_H
#define CLAST_SOURCE_HEIGHT_MAKE_H

#include "source/height.h"

// The number of a texel of a level, whose border begins at (-1, -1).
static inline size_t clast_height_place(const clast_height_map *map, uint32_t level, int64_t x, int64_t y)
{
    return map->firsts[level] + (size_t)((y + 1) * (map->widths[level] + 2) + x + 1);
}

static inline float clast_height_texel(const clast_height *height, size_t place)
{
    return height->map.is_float ? ((const float *)height->texels)[place]
                                : (float)((const uint16_t *)height->texels)[place];
}

// The sizes of all levels, for an image of that size and type. LIMIT where there are too many texels.
clast_status clast_height_lay_out(clast_context *context, const clast_image *image, const clast_texture *texture,
                                  clast_height *height);
// Texels of all levels, from an image's first channel, to where height->texels points. Gives how many of the image's are not
// finite.
uint64_t clast_height_fill_levels(clast_context *context, const clast_image *image, clast_height *height);

// How many ranges there are, with their places in `height`; and the ranges themselves, of the texels.
size_t clast_height_lay_out_ranges(clast_height *height);
void clast_height_fill_ranges(clast_context *context, const clast_height *height, clast_height_range *ranges);

#endif
