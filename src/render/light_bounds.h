// SPDX-License-Identifier: Apache-2.0
// What is known of lights while a tree is built over them: where they are, which way and how strongly they shine.
#ifndef CLAST_RENDER_LIGHT_BOUNDS_H
#define CLAST_RENDER_LIGHT_BOUNDS_H

#include "render/light_tree.h"

#define CLAST_LIGHT_POWER_LEAST 1e-20f // of the power of all lights

// In the tree's scale.
typedef struct clast_light_box {
    packed3 lower, upper;
} clast_light_box;

// A light that shines.
typedef struct clast_light_item {
    clast_light_box box;
    packed3 axis; // unit length; zero where it shines to all sides
    float power;  // irradiance at a distance of one, straight ahead; above zero and finite
    uint32_t number;
    bool two_sided;
} clast_light_item;

// Of some lights: they shine within `emission` of a direction that is within `spread` of the axis; angles in radians.
typedef struct clast_light_cover {
    clast_light_box box;
    double axis[3], spread, emission;
    double power;
    float reach; // 0: endless
    bool two_sided;
} clast_light_cover;

clast_light_box clast_light_no_box(void);
// A power of two that brings the scene to a size of about one.
float clast_light_scale(const clast_light_sources *sources);
// Fills `items` with the lights that shine, in order of their numbers; gives how many there are.
uint32_t clast_light_items(clast_context *context, const clast_light_sources *sources, float scale,
                           clast_light_item *items);

clast_light_cover clast_light_cover_of(const clast_light_sources *sources, const clast_light_item *item, float scale);
void clast_light_cover_add(clast_light_cover *cover, const clast_light_cover *other);
// As a node, which may cover more but not less. `total` is the power of all lights.
clast_light_node clast_light_cover_pack(const clast_light_cover *cover, double total);

#endif
