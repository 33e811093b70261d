// SPDX-License-Identifier: Apache-2.0
// Scenes that pictures are measured with.
#ifndef CLAST_BENCH_RENDER_SCENES_H
#define CLAST_BENCH_RENDER_SCENES_H

#include "bench.h"
#include "clast/clast.h"

// Each ends the program where it fails.
clast_scene *render_scene_cornell(clast_context *context);
// Spheres that are instances of one, under a sky.
clast_scene *render_scene_instances(clast_context *context);
// The demonstration scene, from files in a folder of its own that is removed again.
clast_scene *render_scene_demonstration(clast_context *context, double detail);
// A room with some lamps of one triangle each all over, which together are as bright as one would be.
clast_scene *render_scene_lamps(clast_context *context, uint32_t lamps);

#endif
