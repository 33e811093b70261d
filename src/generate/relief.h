// SPDX-License-Identifier: Apache-2.0
// Reliefs: height maps of carved, laid and grown surfaces, for displacement, and the colours that go with them.
#ifndef CLAST_GENERATE_RELIEF_H
#define CLAST_GENERATE_RELIEF_H

#include "generate/outputs.h"
#include "shared/dialect.h"

typedef enum clast_relief_kind {
    CLAST_RELIEF_COBBLES, // round stones in sand; tiles
    CLAST_RELIEF_PANEL,   // a square panel: a frame with a running key, a flower within; one height along its border
    CLAST_RELIEF_GLOBE,   // carved bands around a sphere: latitude and longitude
    CLAST_RELIEF_ROPE,    // strands around a ring: along it, around it
    CLAST_RELIEF_BARK,    // tiles
    CLAST_RELIEF_RINGS,   // a sawn log's end
    CLAST_RELIEF_ASHLAR,  // roughly hewn stone; tiles
    CLAST_RELIEF_HILLS,   // ground that is flat in the middle
    CLAST_RELIEF_KINDS,
} clast_relief_kind;

typedef struct clast_relief_files {
    const char *height, *colour; // names of files
    uint32_t aspect;             // width over height
    float depth;                 // metres between height 0 and 1
    float level;                 // the height, 0 to 1, at which the undisplaced surface lies
} clast_relief_files;

extern const clast_relief_files clast_relief_names[CLAST_RELIEF_KINDS];

// Factor and offset of a material: metres = texel * factor + offset.
typedef struct clast_relief_range {
    float factor, offset;
} clast_relief_range;

// Writes 16-bit heights and 8-bit colours, `size` pixels high, and says what the heights mean. Colours are linear in the
// recipes, sRGB in the file.
clast_relief_range clast_write_relief(clast_outputs *outputs, clast_relief_kind kind, uint32_t size, uint32_t seed);

#endif
