// SPDX-License-Identifier: Apache-2.0
// Paths of light, followed from the camera, a tile of pixels at a time: all paths of a tile take a step together, so that
// their rays reach accel/ in batches.
#ifndef CLAST_RENDER_PATH_H
#define CLAST_RENDER_PATH_H

#include "render/lights.h"
#include "render/render.h"
#include "render/surface.h"
#include "shared/path.h"

enum {
    CLAST_TILE_WIDTH = 32,
    CLAST_TILE_HEIGHT = 16,
    CLAST_TILE_PIXELS = CLAST_TILE_WIDTH * CLAST_TILE_HEIGHT,
    CLAST_TILE_SHADOWS = 2 * CLAST_TILE_PIXELS
}; // one for the sun, one for another light

// One light path.
typedef struct clast_path {
    vec3 throughput;
    vec3 radiance;             // found so far
    vec3 direct;               // of it, what the first surface sends out or scatters at once
    vec3 direction;            // of the ray under way, unit length
    clast_light_shares shares; // of the point where it began
    vec3 absorption;           // of the volume that the ray is in
    float density;             // with which it was chosen, by solid angle
    float alpha_floor;         // least width of the lobes to come
    clast_ray_cone cone;       // around that ray, where it began
    uint32_t pixel;
    uint32_t seed;
} clast_path;

// A worker's memory for a tile.
typedef struct clast_scratch {
    clast_path paths[CLAST_TILE_PIXELS];
    clast_visibility seen[CLAST_TILE_PIXELS]; // by each path's ray
    clast_ray rays[CLAST_TILE_PIXELS];
    clast_hit hits[CLAST_TILE_PIXELS];
    clast_ray shadow_rays[CLAST_TILE_SHADOWS];
    vec3 shadow_radiance[CLAST_TILE_SHADOWS]; // that arrives where nothing is in between
    uint32_t shadow_paths[CLAST_TILE_SHADOWS];
    uint8_t occluded[CLAST_TILE_SHADOWS];
} clast_scratch;

// Pixels of the picture: [x, x + width) x [y, y + height), of a tile's size at most.
typedef struct clast_tile {
    uint32_t x, y, width, height;
} clast_tile;

typedef struct clast_pixel_place {
    uint32_t x, y;
} clast_pixel_place;

// The pixel that is a tile's i-th: squares of 64 pixels one after the other, as rays that follow each other and are alike are
// traced together. Tiles at the picture's edges go row by row.
static inline clast_pixel_place clast_tile_pixel(clast_tile tile, uint32_t i)
{
    enum { SIDE = 8, SQUARE = SIDE * SIDE };
    if (tile.width % SIDE != 0 || tile.height % SIDE != 0) {
        return (clast_pixel_place){tile.x + i % tile.width, tile.y + i / tile.width};
    }
    uint32_t square = i / SQUARE, across = tile.width / SIDE;
    return (clast_pixel_place){tile.x + square % across * SIDE + i % SIDE,
                               tile.y + square / across * SIDE + i % SQUARE / SIDE};
}

// The ray of a pixel's sample under way.
clast_camera_ray clast_primary_ray(const clast_frame *frame, const clast_render_target *target, uint32_t x, uint32_t y);
clast_ray clast_ray_of(clast_camera_ray ray);

// Follows the paths of a tile and adds what they find to the target's sums.
void clast_shade_tile(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch, clast_tile tile);

#endif
