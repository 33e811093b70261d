// SPDX-License-Identifier: Apache-2.0
// Tables of how much light glass and fuzz give back: how they are read. render/scatter.c makes them. Of glass there are four:
// seen from outside and from inside; each of what it reflects by Fresnel's equations and passes, and of what it passes where
// facets reflect nothing but what they must.
#ifndef CLAST_SHARED_SCATTER_H
#define CLAST_SHARED_SCATTER_H

#include "shared/bsdf.h"

LIMIT(SCATTER_SIDE, 16u, "rows by roughness, columns by the square root of the cosine: as GGX_LOSS")
LIMIT(SCATTER_CELLS, 256u, "floats of a table")

LIMIT(GLASS_TABLES, 4u, "of an index of refraction")
FN uint glass_table(uint inside, uint bare) { return 2u * inside + bare; }

// A value of a table, the next of its row, those of the next row, and where between them.
RECORD(clast_scatter_place)
{
    uint first;  // and first + 1, first + SCATTER_SIDE, first + SCATTER_SIDE + 1
    float across;
    float down;
};
RECORD_SIZE(clast_scatter_place, 12)

FN clast_scatter_place scatter_place(float roughness, float cosine)
{
    float row = clamp1(roughness, 0.0f, 1.0f) * 15.0f;
    float column = rough_sqrt(clamp1(cosine, 0.0f, 1.0f)) * 15.0f;
    uint r = min_uint(to_uint(row), SCATTER_SIDE - 2u);
    uint c = min_uint(to_uint(column), SCATTER_SIDE - 2u);
    clast_scatter_place place;
    place.first = r * SCATTER_SIDE + c;
    place.across = column - to_float(c);
    place.down = row - to_float(r);
    return place;
}

FN float scatter_blend(clast_scatter_place place, float first, float second, float below, float second_below)
{
    return mix1(mix1(first, second, place.across), mix1(below, second_below, place.across), place.down);
}

// The roughness of glass, which a path may widen.
FN float scatter_roughness(clast_bsdf_input from, float alpha_floor)
{
    return lobe_roughness(lobe_alpha(from.base, alpha_floor));
}

// What glass that is the border of no volume gives back.
FN clast_glass_albedo thin_glass_albedo(float roughness, float cosine)
{
    float back = 1.0f - ggx_albedo(roughness, cosine)[0];
    return glass_albedo(back, back);
}

#endif
