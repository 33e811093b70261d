// SPDX-License-Identifier: Apache-2.0
// The demonstration scene: an old sanctuary on the floor of a desert canyon, at the end of a day. What its parts share.
// Metres, y up; the monument stands at the origin and faces +z.
#ifndef CLAST_GENERATE_CANYON_H
#define CLAST_GENERATE_CANYON_H

#include "generate/noise.h"
#include "generate/surface.h"

// A table mountain: a closed curve around a centre, swept up a profile of cliffs and benches.
typedef struct clast_mesa {
    vec2 centre;    // x, z
    float radius;   // along its long axis
    float flatness; // short axis over long axis
    float turn;     // of the long axis, turns
    float height;
    float from, to; // turns: the side that is seen
    float haze;     // 0 to 1: how much air lies between, as colour
    float share;    // of the triangles of all mesas
    uint seed;
} clast_mesa;

enum { CLAST_MESA_COUNT = 9 };

typedef enum clast_canyon_material {
    CLAST_CANYON_SAND,
    CLAST_CANYON_ROCK,
    CLAST_CANYON_STONE,
    CLAST_CANYON_GOLD,
    CLAST_CANYON_LAPIS,
    CLAST_CANYON_MARBLE,
    CLAST_CANYON_STRAW,
    CLAST_CANYON_MATERIALS,
} clast_canyon_material;

typedef struct clast_canyon {
    clast_context *context;
    clast_outputs *outputs;
    clast_gltf_writer writer;
    clast_builder builder;
    double detail;
    uint seed;
    uint32_t materials[CLAST_CANYON_MATERIALS];
    clast_mesa mesas[CLAST_MESA_COUNT];
} clast_canyon;

// What the parts are made of, linear; textures vary it.
#define CLAST_SAND_COLOUR vec3(0.66f, 0.42f, 0.245f)
#define CLAST_STONE_COLOUR vec3(0.64f, 0.515f, 0.375f)
#define CLAST_HAZE_COLOUR vec3(0.50f, 0.43f, 0.44f)

static const float CLAST_PLAZA_RADIUS = 17.0f;

// mesa.c
void clast_canyon_place_mesas(clast_canyon *canyon);
void clast_canyon_build_mesas(clast_canyon *canyon, double triangles);
// How far (x, z) is outside the foot of a mesa; below 0 inside.
float clast_mesa_distance(const clast_mesa *mesa, float x, float z);
// Height of the debris at a mesa's foot, at (x, z), `distance` outside it; below the ground where there is none.
float clast_mesa_apron(const clast_mesa *mesa, float x, float z, float distance);
// The colour of the rock at a place: strata by height.
vec3 clast_rock_colour(vec3 place, uint seed);

// terrain.c
// Height of the ground at (x, z): the sand's, or that of the debris on it.
float clast_canyon_ground(const clast_canyon *canyon, float x, float z);
void clast_canyon_build_terrain(clast_canyon *canyon, double triangles);
// A square of the ground around the origin, `size` metres wide, as 16-bit heights; gives the range that they span.
void clast_canyon_write_heights(clast_canyon *canyon, const char *name, uint32_t pixels, float size, float *low,
                                float *high);

// boulders.c
void clast_canyon_build_boulders(clast_canyon *canyon, double triangles);
void clast_canyon_build_grass(clast_canyon *canyon, double triangles);

// masonry.c
void clast_canyon_build_masonry(clast_canyon *canyon, double triangles);
// columns.c
void clast_canyon_build_columns(clast_canyon *canyon, double triangles);
// monument.c
void clast_canyon_build_monument(clast_canyon *canyon, double triangles);
void clast_canyon_write_ornament(clast_canyon *canyon, const char *name, uint32_t width, uint32_t height, float *low,
                                 float *high);

// canyon.c
clast_status clast_generate_canyon(clast_context *context, double detail, uint32_t seed, const char *folder);

#endif
