// SPDX-License-Identifier: Apache-2.0
// Carved ornament as height fields: bands that repeat along a line. Heights are 0 to 1.
#ifndef CLAST_GENERATE_ORNAMENT_H
#define CLAST_GENERATE_ORNAMENT_H

#include "generate/noise.h"

typedef enum clast_ornament {
    CLAST_ORNAMENT_PLAIN,     // 0 everywhere
    CLAST_ORNAMENT_BEADS,     // a row of pearls
    CLAST_ORNAMENT_ROPE,      // a twisted cable
    CLAST_ORNAMENT_GUILLOCHE, // two strands that cross over and under, around open eyes
    CLAST_ORNAMENT_MEANDER,   // the running key
    CLAST_ORNAMENT_SCALES,    // overlapping like fish scales, five rows
    CLAST_ORNAMENT_COFFERS,   // sunk panels with a rosette each
    CLAST_ORNAMENT_TONGUES,   // a row of upright leaves
    CLAST_ORNAMENT_LEAVES,    // two rows of leaves, the second behind the gaps of the first
    CLAST_ORNAMENT_FLUTES,    // channels between narrow ridges
    CLAST_ORNAMENT_LATTICE,   // crossing bars with studs
    CLAST_ORNAMENT_TICKS,     // a scale's graduation
    CLAST_ORNAMENT_GLYPHS,    // an inscription in a script that nobody reads
    CLAST_ORNAMENT_WAVES,     // running spirals
} clast_ornament;

// `along` counts repeats; `across` is -1 to 1 over the band's width; `aspect` is its width over a repeat's length.
float clast_ornament_height(clast_ornament ornament, float along, float across, float aspect);

// A flower of `petals` around a boss, in the unit disc.
float clast_rosette_height(float x, float y, float petals);

#endif
