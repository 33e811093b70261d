// SPDX-License-Identifier: Apache-2.0
// Turned stone and metal: a profile swept about the y axis, with carved bands.
#ifndef CLAST_GENERATE_LATHE_H
#define CLAST_GENERATE_LATHE_H

#include "generate/ornament.h"
#include "generate/surface.h"

enum { CLAST_LATHE_POINTS_MOST = 48 };

// A corner of a profile, and what is carved on the stretch from here to the next.
typedef struct clast_lathe_point {
    float radius, height;
    clast_ornament ornament;
    float repeats; // around
    float depth;   // metres, outwards
    float weight;  // rows for its length; 0 is 1
} clast_lathe_point;

typedef struct clast_lathe {
    const clast_lathe_point *points;
    uint32_t point_count;
    vec3 colour;
    float wear; // metres, of weathering; 0 for metal
    float tile; // metres of a texture's repeat
    uint seed;
    // A broken top: heights above (fracture - 1) move by up to `fracture_depth`. 0 is whole.
    float fracture, fracture_depth;
    // Found by clast_build_lathe.
    uint32_t first_row[CLAST_LATHE_POINTS_MOST];
    uint32_t rows;
    float start[CLAST_LATHE_POINTS_MOST]; // lengths along the profile
} clast_lathe;

// Adds it to the primitive under way, with about that many triangles.
void clast_build_lathe(clast_builder *builder, clast_lathe *lathe, double triangles);

// The colour of carved stone: dark in hollows, pale on edges, dirty near the ground.
vec3 clast_carved_colour(vec3 base, vec3 place, float relief, uint seed);
// How far weathering has worn a place down, 0 or more, about 1 at most.
float clast_wear(vec3 place, uint seed);

#endif
