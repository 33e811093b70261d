// SPDX-License-Identifier: Apache-2.0
// Rings of rounded rectangular section in the plane z = 0 around the origin, with carved bands on each face.
#ifndef CLAST_GENERATE_HOOP_H
#define CLAST_GENERATE_HOOP_H

#include "generate/ornament.h"
#include "generate/surface.h"

// A carved band on a face: from - to in metres from the face's middle; positive is outwards on front and back, forwards
// on the rim.
typedef struct clast_hoop_band {
    float from, to;
    clast_ornament ornament;
    float repeats; // in a whole turn
    float depth;   // metres; negative sinks
    float offset;  // metres that the band lies above the face
} clast_hoop_band;

enum { CLAST_HOOP_BANDS_MOST = 8 };

typedef struct clast_hoop_face {
    clast_hoop_band bands[CLAST_HOOP_BANDS_MOST];
    uint32_t count;
} clast_hoop_face;

typedef struct clast_hoop {
    float radius;                  // of the section's middle
    float half_radial, half_axial; // half sizes of the section
    float corner;                  // radius of its edges
    clast_hoop_face front, outer, back, inner;
    float rope_repeats, rope_depth; // on the edges
    float back_weight;              // density of the faces that are seldom seen; 0 is 1
    float from, to;                 // turns; both 0: whole
    float end_drop;                 // metres by which the ends of a part sink
    vec3 colour;
    float wear, tile;
    uint seed;
    // Broken out of the stone: balls around these places.
    uint32_t bite_count;
    vec4 bites[4]; // place, radius
} clast_hoop;

void clast_build_hoop(clast_builder *builder, const clast_hoop *hoop, double triangles);
// The relief at u (turns) and v (around the section, 0 to 1), in metres.
float clast_hoop_relief(const clast_hoop *hoop, float u, float v);

#endif
