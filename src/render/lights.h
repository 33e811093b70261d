// SPDX-License-Identifier: Apache-2.0
// All lights of a frame, ready to be sampled: surroundings, sun, punctual lights, emissive triangles.
#ifndef CLAST_RENDER_LIGHTS_H
#define CLAST_RENDER_LIGHTS_H

#include "frame/frame.h"
#include "render/light_tree.h"
#include "render/sky.h"
#include "render/texture.h"

// A table to choose from by weight: a running sum from 0 to 1, `count` + 1 values.
typedef struct clast_choice_table {
    float *sums;
    uint32_t count;
    float total; // of the weights
} clast_choice_table;

// The surroundings' picture in cells, chosen by brightness and size: a row, then a cell of it.
typedef struct clast_surroundings {
    uint32_t width, height;
    float *row_sums;  // height + 1
    float *cell_sums; // height * (width + 1)
    float rotation;
    float upper, lower; // mean luminance of each half
} clast_surroundings;

typedef struct clast_lights {
    const clast_frame *frame;
    const clast_srgb_table *table;
    clast_environment environment;
    bool has_surroundings;
    vec3 factor;              // of the surroundings' radiance
    const clast_image *image; // null where there is none
    clast_sky sky;
    clast_surroundings surroundings;
    bool has_sun;
    clast_basis sun;  // z towards its middle
    float sun_height; // 1 - cosine of its angular radius
    vec3 sun_irradiance;
    float sun_density; // of directions, by solid angle
    clast_choice_table directional;
    uint32_t *directional_numbers; // of the scene's lights
    clast_light_tree tree;         // of the others, and of emissive triangles
    uint32_t emitter_count;
    uint32_t *first_emitter; // by frame instance, one more at the end; null where nothing shines
    float extent;            // of the scene
} clast_lights;

clast_status clast_lights_create(const clast_frame *frame, const clast_srgb_table *table, clast_lights **lights);
void clast_lights_destroy(clast_context *context, clast_lights *lights);

// What comes from far away along a direction (unit length).
vec3 clast_distant_radiance(const clast_lights *lights, vec3 direction);

// The shares at a point; both normals face the viewer.
clast_light_shares clast_lights_share(const clast_lights *lights, clast_lit_point point, vec3 geometric_normal,
                                      vec3 normal);
// A point of the sun; of density 0 where its share is none.
clast_light_sample clast_lights_sample_sun(const clast_lights *lights, const clast_light_shares *shares, vec2 u);
// Chooses one of the other lights by `choice` in [0, 1) and a point of it by `u`.
clast_light_sample clast_lights_sample(const clast_lights *lights, const clast_light_shares *shares,
                                       clast_lit_point point, float choice, vec2 u);
// The density with which these find a direction that hits nothing, or an emissive triangle.
float clast_distant_density(const clast_lights *lights, const clast_light_shares *shares, vec3 direction);
float clast_emitter_density(const clast_lights *lights, const clast_light_shares *shares, clast_lit_point point,
                            uint32_t frame_instance, uint32_t primitive, float distance, float cosine);

// A light of the tree, by its number there, and the chance with which it is chosen.
typedef struct clast_chosen_light {
    uint32_t number;
    float density;
} clast_chosen_light;
clast_chosen_light clast_light_tree_choose(const clast_lights *lights, clast_lit_point point, float u);
// The same bits as what chose it had.
float clast_light_tree_density(const clast_lights *lights, clast_lit_point point, uint32_t number);

// surroundings.c: from weights in sums[1 .. count]; sums[0] is ignored. All weights zero: an even choice, total 0.
float clast_sums_make(float *sums, uint32_t count);
// The entry that `u` in [0, 1) falls into; `*rest` is where in it, 0 to 1.
uint32_t clast_sums_find(const float *sums, uint32_t count, float u, float *rest);

// The cells of a picture.
clast_status clast_surroundings_create(clast_context *context, clast_lights *lights);
void clast_surroundings_destroy(clast_context *context, clast_surroundings *surroundings);
vec3 clast_surroundings_sample(const clast_surroundings *surroundings, vec2 u, float *density);
float clast_surroundings_density(const clast_surroundings *surroundings, vec3 direction);
vec3 clast_surroundings_radiance(const clast_lights *lights, vec3 direction);

#endif
