// SPDX-License-Identifier: Apache-2.0
// How surfaces scatter light: the twin of src/render/scatter.c, whose tables it reads.
#ifndef CLAST_RENDER_SCATTER_GLSL
#define CLAST_RENDER_SCATTER_GLSL

#include "render/texture.glsl"

float scatter_value(uint64_t table, float roughness, float cosine)
{
    clast_scatter_place at = scatter_place(roughness, cosine);
    floats values = floats(table);
    return scatter_blend(at, values.at[at.first], values.at[at.first + 1u], values.at[at.first + SCATTER_SIDE],
                         values.at[at.first + SCATTER_SIDE + 1u]);
}

// A surface of a material of the scene, as the view sees it; `alpha_floor` as brdf_make has it. To be called before any other
// formula of bsdf.h.
clast_bsdf scatter_make(materials_reference all, uint material, clast_bsdf_input from, float alpha_floor, vec3 view)
{
    clast_glass_albedo glass = glass_albedo(1.0f, 1.0f);
    float sheen = 0.0f;
    ggx_tables = load_address(all.of.ggx);
    if (from.transmission > 0.0f) {
        float roughness = scatter_roughness(from, alpha_floor);
        uint number = material_at(all, material).of.glass;
        if (from.thin != 0u || number == CLAST_NONE) {
            glass = thin_glass_albedo(roughness, view[2]);
        } else {
            uint first = GLASS_TABLES * (number + from.colour);
            uint64_t full = uint64_t(first + glass_table(from.inside, 0u)) * uint64_t(4u * SCATTER_CELLS);
            uint64_t bare = uint64_t(first + glass_table(from.inside, 1u)) * uint64_t(4u * SCATTER_CELLS);
            glass = glass_albedo(scatter_value(load_address(all.of.glass) + full, roughness, view[2]),
                                 scatter_value(load_address(all.of.glass) + bare, roughness, view[2]));
        }
    }
    if (largest3(load3(from.sheen)) > 0.0f) {
        sheen = scatter_value(load_address(all.of.sheen), from.sheen_roughness, view[2]);
    }
    return bsdf_make(from, alpha_floor, view, glass, sheen);
}

#endif
