// SPDX-License-Identifier: Apache-2.0
// How much light glass and fuzz give back, integrated once for a render: what bsdf_make asks for.
#ifndef CLAST_RENDER_SCATTER_H
#define CLAST_RENDER_SCATTER_H

#include "scene/scene.h"
#include "shared/scatter.h"

typedef struct clast_glass_table {
    float ior;
    float albedos[GLASS_TABLES][SCATTER_CELLS]; // by glass_table()
} clast_glass_table;

typedef struct clast_scatter_tables {
    float sheen[SCATTER_CELLS]; // zero where no material is fuzzy
    clast_glass_table *glass;
    size_t glass_count, glass_capacity;
    uint32_t *glass_of; // by material, the first of its tables; CLAST_NONE where it is no border of a volume
} clast_scatter_tables;

// For the materials that a scene has now.
clast_status clast_scatter_create(const clast_scene *scene, clast_scatter_tables **tables);
void clast_scatter_destroy(clast_context *context, clast_scatter_tables *tables);

// A surface of a material of the scene, as the view sees it; `alpha_floor` as brdf_make has it.
clast_bsdf clast_scatter_make(const clast_scatter_tables *tables, uint32_t material, const clast_bsdf_input *from,
                              float alpha_floor, vec3 view);

#endif
