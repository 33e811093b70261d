// SPDX-License-Identifier: Apache-2.0
// The tables of shared/brdf.h, read from memory: devices may copy constants of this size for each invocation that looks into
// them. To be included before anything that includes brdf.h; scatter_make() says where the tables lie.
#ifndef CLAST_RENDER_TABLES_GLSL
#define CLAST_RENDER_TABLES_GLSL

#include "gpu.glsl"

uint64_t ggx_tables; // GGX_TABLES floats

#define GGX_LOSS_AT(i) floats(ggx_tables).at[i]
#define GGX_RIM_AT(i) floats(ggx_tables).at[GGX_CELLS + (i)]
#define GGX_MEAN_LOSS_AT(i) floats(ggx_tables).at[2u * GGX_CELLS + (i)]
#define GGX_MEAN_RIM_AT(i) floats(ggx_tables).at[2u * GGX_CELLS + GGX_SIDE + (i)]

#endif
