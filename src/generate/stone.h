// SPDX-License-Identifier: Apache-2.0
// Cut stones: rounded boxes with worn edges, straight or bent around the y axis.
#ifndef CLAST_GENERATE_STONE_H
#define CLAST_GENERATE_STONE_H

#include "generate/ornament.h"
#include "generate/surface.h"

// Local axes: x along (tangential where bent), y up, z outwards.
typedef struct clast_stone {
    vec3 half; // half sizes
    float bevel;
    vec3 centre;          // straight: place; bent: only y is looked at
    float turn;           // about y, turns; bent: where its middle stands, from +x towards +z
    float radius;         // bent around the axis at this radius; 0: straight
    float tilt_x, tilt_z; // slopes of the top along z and x
    vec3 colour;
    float wear;              // metres
    clast_ornament ornament; // on the outer face
    float repeats, depth;    // along the stone
    float dust;              // sand that lies on top, 0 to 1, as colour
    uint32_t hidden_faces;
    uint seed;
} clast_stone;

void clast_build_stone(clast_builder *builder, const clast_stone *stone, double triangles);

#endif
