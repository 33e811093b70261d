// SPDX-License-Identifier: Apache-2.0
// The displaced scene: the paved yard of an old cloister in low sun. A few thousand triangles; all that is carved, laid and
// grown comes from height maps. Every model but the land is closed, and most have hard edges and seams of their texture
// coordinates.
// Metres, y up.
#ifndef CLAST_GENERATE_CLOISTER_H
#define CLAST_GENERATE_CLOISTER_H

#include "generate/relief.h"
#include "generate/surface.h"

typedef struct clast_cloister {
    clast_context *context;
    clast_outputs *outputs;
    clast_gltf_writer writer;
    clast_builder builder;
    double detail;
    uint seed;
    uint32_t materials[CLAST_RELIEF_KINDS];
} clast_cloister;

// cloister_models.c: each adds its meshes and their instances.
void clast_cloister_build_ground(clast_cloister *cloister);
void clast_cloister_build_globes(clast_cloister *cloister);
void clast_cloister_build_rings(clast_cloister *cloister);
void clast_cloister_build_trees(clast_cloister *cloister);
void clast_cloister_build_walls(clast_cloister *cloister);

// cloister.c
clast_status clast_generate_cloister(clast_context *context, double detail, uint32_t seed, const char *folder);

#endif
