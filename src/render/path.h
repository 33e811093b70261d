// SPDX-License-Identifier: Apache-2.0
// Paths of light, followed from the camera, a tile of some squares of pixels at a time: all paths of a tile take a step
// together, so that their rays reach accel/ in batches.
#ifndef CLAST_RENDER_PATH_H
#define CLAST_RENDER_PATH_H

#include "render/lights.h"
#include "render/render.h"
#include "render/surface.h"
#include "shared/path.h"

enum {
    CLAST_TILE_SQUARES = 8,
    CLAST_TILE_PIXELS = CLAST_TILE_SQUARES * SQUARE_PIXELS,
    CLAST_TILE_SHADOWS = 2 * CLAST_TILE_PIXELS
}; // one for the sun, one for another light

// One light path.
typedef struct clast_path {
    vec3 throughput;
    vec3 radiance;             // found so far
    vec3 direct;               // of it, what the first surface sends out or scatters at once
    vec3 direction;            // of the ray under way, unit length
    clast_light_shares shares; // of the point where it began
    clast_lit_point lit;       // that point
    vec3 absorption;           // of the volume that the ray is in
    float density;             // with which it was chosen, by solid angle
    float alpha_floor;         // least width of the lobes to come
    clast_ray_cone cone;       // around that ray, where it began
    uint32_t pixel;
    clast_pixel_samples samples;
} clast_path;

// A worker's memory for a tile.
typedef struct clast_scratch {
    clast_path_pixel pixels[CLAST_TILE_PIXELS]; // of the tile
    uint32_t pixel_count;
    clast_path paths[CLAST_TILE_PIXELS];
    clast_visibility seen[CLAST_TILE_PIXELS]; // by each path's ray
    clast_ray rays[CLAST_TILE_PIXELS];
    clast_hit hits[CLAST_TILE_PIXELS];
    clast_ray shadow_rays[CLAST_TILE_SHADOWS];
    vec3 shadow_radiance[CLAST_TILE_SHADOWS]; // that arrives where nothing is in between
    uint32_t shadow_paths[CLAST_TILE_SHADOWS];
    uint8_t occluded[CLAST_TILE_SHADOWS];
} clast_scratch;

// The ray of a pixel's sample under way.
clast_camera_ray clast_primary_ray(const clast_frame *frame, const clast_render_target *target, clast_path_pixel at);
clast_ray clast_ray_of(clast_camera_ray ray);

// Follows the paths of the scratch's tile and adds what they find to the target's sums.
void clast_shade_tile(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch);

#endif
