// SPDX-License-Identifier: Apache-2.0
// Which texels of a picture make a texture's value, and with what weights. Texels are fetched by number and blended
// here, so that every machine filters alike.
#ifndef CLAST_SHARED_TEXTURE_FILTER_H
#define CLAST_SHARED_TEXTURE_FILTER_H

#include "shared/enums.h"
#include "shared/records.h"

// What a texture's values mean: how its colours are stored, where it is an integer image (alpha is always linear), and what the
// mean of several of them is.
LIMIT(ENCODING_LINEAR, 0u, "as they are")
LIMIT(ENCODING_SRGB, 1u, "for a display")
LIMIT(ENCODING_CUTOUT, 2u, "for a display, and colours count as much as they cover: by their alpha")
LIMIT(ENCODING_NORMAL, 3u, "directions")
LIMIT(ENCODINGS, 4u, "how many there are")

FN bool encoding_is_srgb(uint encoding) { return encoding == ENCODING_SRGB || encoding == ENCODING_CUTOUT; }

// How texture coordinates grow along a surface: by so much for each length towards these directions.
RECORD(clast_texture_gradient)
{
    packed3 u;
    packed3 v;
};
RECORD_SIZE(clast_texture_gradient, 24)

FN clast_texture_gradient no_texture_gradient(void)
{
    clast_texture_gradient gradient;
    gradient.u = store3(splat3(0.0f));
    gradient.v = store3(splat3(0.0f));
    return gradient;
}

// A texel along one axis, its neighbour, and the neighbour's weight.
RECORD(clast_texel_pair)
{
    uint first;
    uint second;
    float weight; // of the second; 0 where only the first counts
};
RECORD_SIZE(clast_texel_pair, 12)

// A coordinate brought to [0, 1]. What is not finite becomes 0.
FN float wrap_coordinate(float coordinate, uint wrap)
{
    float whole = floor1(coordinate);
    float part = coordinate - whole;
    float half_turn = coordinate - 2.0f * floor1(coordinate * 0.5f); // [0, 2)
    float mirrored = half_turn > 1.0f ? 2.0f - half_turn : half_turn;
    float wrapped = wrap == CLAST_WRAP_REPEAT ? part : wrap == CLAST_WRAP_MIRROR ? mirrored : coordinate;
    return clamp1(wrapped, 0.0f, 1.0f);
}

FN uint nearest_texel(float coordinate, uint wrap, uint size)
{
    float place = wrap_coordinate(coordinate, wrap) * to_float(size);
    return min_uint(to_uint(place), size - 1u);
}

// Texel centres lie at (i + 0.5) / size.
FN clast_texel_pair linear_texels(float coordinate, uint wrap, uint size)
{
    float place = wrap_coordinate(coordinate, wrap) * to_float(size) + 0.5f; // one more than the texel's own
    float whole = floor1(place);
    uint above = to_uint(whole); // 0 to size
    clast_texel_pair texels;
    bool repeats = wrap == CLAST_WRAP_REPEAT;
    texels.first = above == 0u ? (repeats ? size - 1u : 0u) : above - 1u;
    texels.second = above >= size ? (repeats ? 0u : size - 1u) : above;
    texels.weight = place - whole;
    return texels;
}

// Counter-clockwise as seen: coordinates grow downwards.
FN vec2 turn_coordinates(vec2 coordinates, float cosine, float sine)
{
    return vec2(cosine * coordinates[0] + sine * coordinates[1], cosine * coordinates[1] - sine * coordinates[0]);
}

// KHR_texture_transform: scaled, then turned, then moved.
FN vec2 transform_coordinates(clast_texture_use use, vec2 coordinates)
{
    vec2 scaled = coordinates * load2(use.scale);
    vec2 turned = scaled;
    if (use.rotation != 0.0f) {
        turned = turn_coordinates(scaled, rough_cos(use.rotation), rough_sin(use.rotation));
    }
    return turned + load2(use.offset);
}

// What integers of 8 and of 16 bits stand for: k / 255 and k / 65535, rounded as a division would. The first product is exact.
FN float unorm8(uint k) { return to_float(k) * 0.0039215087890625f + to_float(k) * 5.9838392e-8f; }
FN float unorm16(uint k) { return to_float(k) * 0.0000152587890625f + to_float(k) * 2.32834196e-10f; }

// Of equal values, that value to the bit.
FN vec4 blend_texels(vec4 a, vec4 b, float t) { return a + (b - a) * t; }

// IEC 61966-2-1. Both ways exact to rounding; 0 and 1 stay what they are.
FN float srgb_to_linear(float c)
{
    return c <= 0.04045f ? rough_divide(c, 12.92f) : rough_pow(rough_divide(c + 0.055f, 1.055f), 2.4f);
}

FN float linear_to_srgb(float c)
{
    return c <= 0.0031308f ? c * 12.92f : 1.055f * rough_pow(c, 0.416666667f) - 0.055f;
}

#endif
