// SPDX-License-Identifier: Apache-2.0
// A frame's lights as they lie in a device's memory: clast_lights of render/lights.h.
#ifndef CLAST_SHARED_DEVICE_LIGHTS_H
#define CLAST_SHARED_DEVICE_LIGHTS_H

#include "shared/device_materials.h"
#include "shared/light_choice.h"

LIMIT(LIGHTS_SURROUNDINGS, 1u, "there is light from far away that is worth sampling")
LIMIT(LIGHTS_SUN, 2u, "there is a sun")
LIMIT(SKY_WIDTH, 128u, "of the picture of a sky")
LIMIT(SKY_HEIGHT, 256u, "of the picture of a sky")

RECORD(clast_device_lights)
{
    packed_address row_sums;         // cells_height + 1 floats: the surroundings' cells
    packed_address cell_sums;        // of each row, cells_width + 1
    packed_address sky;              // packed3, SKY_WIDTH x SKY_HEIGHT; 0 where there is none
    packed_address punctual;         // clast_light
    packed_address directional;      // numbers of the directional ones
    packed_address directional_sums; // one more than there are
    packed_address emitters;         // clast_emitter
    packed_address first_emitter;    // by instance of the frame, one more at the end
    packed_address tree_nodes;       // clast_light_node
    packed_address tree_entries;     // clast_light_entry
    packed_address tree_trails;      // by number of a light in the tree: the turns to its leaf
    packed_address tree_places;      // likewise its entry
    clast_device_image image;        // of the surroundings
    uint flags;                      // LIGHTS_ bits
    packed3 factor;                  // of the surroundings' radiance
    uint cells_width;
    uint cells_height;
    float rotation;
    float upper;                     // mean luminance of each half
    float lower;
    clast_basis sun;                 // z towards its middle
    float sun_height;                // 1 - cosine of its angular radius
    packed3 sun_irradiance;
    float sun_density;               // of directions, by solid angle
    uint directional_count;
    float directional_total;
    uint emitter_count;
    uint tree_count;                 // of entries
    float tree_scale;
    float tree_strength;
};
RECORD_SIZE(clast_device_lights, 12 * 8 + 12 + 4 + 12 + 20 + 36 + 20 + 24)

#endif
