// SPDX-License-Identifier: Apache-2.0
// The sky as a picture: scattered light of every direction, and what is left of the sun's.
#ifndef CLAST_RENDER_SKY_H
#define CLAST_RENDER_SKY_H

#include "base/context.h"
#include "shared/sky.h"

enum { CLAST_SKY_WIDTH = 128, CLAST_SKY_HEIGHT = 256 };

typedef struct clast_sky {
    packed3 *
        radiance; // CLAST_SKY_WIDTH x CLAST_SKY_HEIGHT, laid out as surroundings_place() with `rotation`; without the sun
    float rotation; // the sun stands over the middle
    vec3
        sun_irradiance; // at the ground, of a surface that faces the sun; of the whole disc, also where part of it is below the horizon
} clast_sky;

// `sun` is the unit vector towards the sun's middle.
clast_status clast_sky_create(clast_context *context, vec3 sun, float turbidity, clast_sky *sky);
void clast_sky_destroy(clast_context *context, clast_sky *sky);

#endif
