// SPDX-License-Identifier: Apache-2.0
// Displacement maps: which texels of which levels make a height, and where a point of a surface comes to lie. Texels are
// fetched by number by whoever has them, and blended here, so that every machine displaces alike.
//
// A map is a chain of levels, each of half the sides of the one before (rounded down). A level has a border of one texel all
// around, which repeats what lies beyond by the wrap modes: the four texels of a place are neighbours always.
#ifndef CLAST_SHARED_DISPLACEMENT_H
#define CLAST_SHARED_DISPLACEMENT_H

#include "shared/stable.h"
#include "shared/texture_filter.h"

LIMIT(HEIGHT_LEVELS, 16u, "most levels of a displacement map: a side of 65536 ends at 2")
LIMIT(HEIGHT_LEVEL_STEPS, 256u, "steps from a level of a map to the next that a vertex may have")

RECORD(clast_height_map)
{
    uint level_count; // at least 1
    uint wrap_u;      // CLAST_WRAP_
    uint wrap_v;
    uint is_float;  // texels are floats; else integers of 16 bits
    float unit;     // times a texel: its height; 1/65535 of integers
    uint firsts[16]; // by level: the number of its first texel, which is the border's upper left one
    uint widths[16]; // without the border
    uint heights[16];
};
RECORD_SIZE(clast_height_map, 212)

// The texels around a place in a level: of each row the first, and the one after it.
RECORD(clast_height_texels)
{
    uint upper;
    uint lower;
    float across; // weight of the second in each row
    float down;   // weight of the lower row
};
RECORD_SIZE(clast_height_texels, 16)

RECORD(clast_height_levels)
{
    uint finer;
    uint coarser;
    float weight; // of the coarser
};
RECORD_SIZE(clast_height_levels, 12)

// A height with its derivatives by the texture coordinates.
RECORD(clast_height_slope)
{
    float height;
    packed2 slope;
};
RECORD_SIZE(clast_height_slope, 12)

// The level at which a texel is as long as a segment, from the square of the texels that a segment spans (at least 2^-100); a
// whole number of steps. Never falls while the square grows.
FN float height_level(float texels_squared, uint level_count)
{
    float level = clamp1(0.5f * stable_log2(texels_squared), 0.0f, to_float(level_count - 1u));
    return floor1(level * to_float(HEIGHT_LEVEL_STEPS) + 0.5f) * power_of_two(119u); // over the steps, exactly
}

FN clast_height_levels height_levels_of(uint level_count, float level)
{
    float within = clamp1(level, 0.0f, to_float(level_count - 1u));
    float whole = floor1(within);
    clast_height_levels levels;
    levels.finer = to_uint(whole);
    levels.coarser = min_uint(levels.finer + 1u, level_count - 1u);
    levels.weight = within - whole;
    return levels;
}

FN clast_height_levels height_levels(clast_height_map map, float level) { return height_levels_of(map.level_count, level); }

// In a level of these sides that begins at `first`. `wrapped` is in [0, 1] (wrap_coordinate). Texel centres lie at
// (i + 0.5) / size.
FN clast_height_texels height_texels_in(uint first, uint width, uint height, vec2 wrapped)
{
    float x = wrapped[0] * to_float(width) + 0.5f; // the border comes first
    float y = wrapped[1] * to_float(height) + 0.5f;
    float column = floor1(x);
    float row = floor1(y);
    clast_height_texels texels;
    texels.upper = first + to_uint(row) * (width + 2u) + to_uint(column);
    texels.lower = texels.upper + width + 2u;
    texels.across = x - column;
    texels.down = y - row;
    return texels;
}

FN clast_height_texels height_texels(clast_height_map map, vec2 wrapped, uint level)
{
    return height_texels_in(map.firsts[level], map.widths[level], map.heights[level], wrapped);
}

// Exactly `a` at 0, and where both are the same.
FN float height_between(float a, float b, float weight) { return a + (b - a) * weight; }

// Of four texels: the upper row's a and b, the lower row's c and d.
FN float height_bilinear(clast_height_texels texels, float a, float b, float c, float d)
{
    float upper = height_between(a, b, texels.across);
    float lower = height_between(c, d, texels.across);
    return height_between(upper, lower, texels.down);
}

// By the coordinates as they grow; where a wrap mode mirrors them, height_wrap_sign() times it.
FN clast_height_slope height_bilinear_slope(clast_height_map map, uint level, clast_height_texels texels, float a, float b,
                                            float c, float d)
{
    clast_height_slope result;
    result.height = height_bilinear(texels, a, b, c, d);
    float across = height_between(b - a, d - c, texels.down) * to_float(map.widths[level]);
    float down = height_between(c - a, d - b, texels.across) * to_float(map.heights[level]);
    result.slope = store2(vec2(across, down));
    return result;
}

// How the wrapped coordinate moves while the coordinate grows: 1, -1 where it is mirrored, 0 where it is clamped.
FN float height_wrap_sign(float coordinate, uint wrap)
{
    bool outside = coordinate < 0.0f || coordinate > 1.0f;
    float half_turn = coordinate - 2.0f * floor1(coordinate * 0.5f);
    float mirrored = half_turn > 1.0f ? -1.0f : 1.0f;
    float clamped = outside ? 0.0f : 1.0f;
    return wrap == CLAST_WRAP_REPEAT ? 1.0f : wrap == CLAST_WRAP_MIRROR ? mirrored : clamped;
}

// A point of a surface moved along its normal, which need not have unit length. A normal of no length moves nothing.
FN vec3 displaced_point(vec3 position, vec3 normal, float height)
{
    float square = max1(dot3(normal, normal), 1e-24f);
    vec3 direction = normal * stable_rsqrt(square);
    return position + direction * height;
}

#endif
