// SPDX-License-Identifier: Apache-2.0
// Displacement maps as sources use them: the red channel of a texture's image, with its levels. shared/displacement.h has
// the formulas; what fills many points at once restates them (source/displace.kernel.c).
#ifndef CLAST_SOURCE_HEIGHT_H
#define CLAST_SOURCE_HEIGHT_H

#include "base/context.h"
#include "scene/scene.h"
#include "shared/displacement.h"

// The least and the greatest of some texels.
typedef struct clast_height_range {
    float lower, upper;
} clast_height_range;

// A map, which units share: made once for each image and way of wrapping. It can be read from all threads. A texture's filter
// is not looked at: heights are always interpolated.
typedef struct clast_height {
    clast_height_map map;
    const void *texels;   // uint16_t or float, by map.is_float: map.firsts[] count them
    uint32_t texel_count; // of all levels with their borders
    // For bounds: the ranges of squares of texels, of 2^(1 + i) texels a side in array i, up to one square for the whole map.
    // They cover the image without a border.
    const clast_height_range *ranges;
    uint32_t range_firsts[HEIGHT_LEVELS + 1];
    uint32_t range_level_count;
    uint64_t bytes; // of all arrays
    uint64_t hash;  // of the texels and the wrap modes: the same map, the same number
} clast_height;

// The maps of a scene, counted by their users. One call at a time.
typedef struct clast_height_store clast_height_store;

clast_status clast_height_store_create(clast_context *context, clast_height_store **store);
// All maps have been released.
void clast_height_store_destroy(clast_height_store *store);
// The map of a texture, to be released. Texels that are not finite become 0, with a line in the log. Errors: INVALID_ARGUMENT (no
// such texture, or one without pixels), LIMIT, OUT_OF_MEMORY.
clast_status clast_height_acquire(clast_height_store *store, const clast_scene *scene, uint32_t texture,
                                  const clast_height **height);
void clast_height_release(clast_height_store *store, const clast_height *height);

// The height, linear within levels and between them. Coordinates are those of the texture, transformed already
// (transform_coordinates); `level` is in [0, map.level_count - 1]. Integer images give 0 to 1.
float clast_height_value(const clast_height *height, vec2 coordinates, float level);
// With the derivatives by the coordinates.
clast_height_slope clast_height_value_and_slope(const clast_height *height, vec2 coordinates, float level);

// Holds all values within a triangle of coordinates, at all levels up to `level_most`.
clast_height_range clast_height_bounds(const clast_height *height, const vec2 corners[3], float level_most);

#endif
