// SPDX-License-Identifier: Apache-2.0
// Texels of pictures that are compressed in blocks of 4 x 4: BC1 to BC5 (Khronos Data Format Specification 1.3, sections 18 and
// 19). What lies between the ends of a block's range is rounded here, as devices do not agree on it.
#ifndef CLAST_SHARED_BLOCK_H
#define CLAST_SHARED_BLOCK_H

#include "shared/dialect.h"

LIMIT(BLOCK_NONE, 0u, "not compressed")
LIMIT(BLOCK_BC1, 1u, "8 bytes: colours, which may be transparent black")
LIMIT(BLOCK_BC2, 2u, "16 bytes: alpha of 4 bits, then colours")
LIMIT(BLOCK_BC3, 3u, "16 bytes: a channel of alpha, then colours")
LIMIT(BLOCK_BC4, 4u, "8 bytes: a channel")
LIMIT(BLOCK_BC5, 5u, "16 bytes: two channels")

// One of four between two, by its code.
FN uint block_between(uint a, uint b, uint code, bool three)
{
    uint near = three ? (a + b) / 2u : (2u * a + b + 1u) / 3u;
    uint far = three ? 0u : (a + 2u * b + 1u) / 3u;
    return code == 0u ? a : code == 1u ? b : code == 2u ? near : far;
}

// The colour of a code, as red, green, blue, alpha, 8 bits each. `ends` are two colours of five, six and five bits, which their
// upper bits widen. `has_black`: where the first is not the larger, the fourth code is transparent black.
FN uint block_colour(uint ends, uint code, bool has_black)
{
    uint a = ends & 65535u;
    uint b = ends >> 16u;
    bool three = has_black && a <= b;
    uint red = block_between((a >> 11u) << 3u | a >> 13u, (b >> 11u) << 3u | b >> 13u, code, three);
    uint green = block_between((a >> 5u & 63u) << 2u | (a >> 9u & 3u), (b >> 5u & 63u) << 2u | (b >> 9u & 3u), code, three);
    uint blue = block_between((a & 31u) << 3u | (a >> 2u & 7u), (b & 31u) << 3u | (b >> 2u & 7u), code, three);
    uint alpha = three && code == 3u ? 0u : 255u;
    return red | green << 8u | blue << 16u | alpha << 24u;
}

// The value of a code, of eight between two ends.
FN uint block_value(uint a, uint b, uint code)
{
    uint steps = a > b ? 7u : 5u;
    uint k = code - 1u;
    uint between = (2u * ((steps - k) * a + k * b) + steps) / (2u * steps);
    uint beyond = code == 6u ? 0u : 255u;
    return code == 0u ? a : code == 1u ? b : code <= steps ? between : beyond;
}

// Texel i of a block is i % 4 across and i / 4 down. The words of a block, lower bytes first.
FN uint block_colours_texel(uint ends, uint codes, uint texel, bool has_black)
{
    return block_colour(ends, codes >> (2u * texel) & 3u, has_black);
}

FN uint block_channel_texel(uint first, uint second, uint texel)
{
    uint low = first >> 16u | second << 16u;
    uint high = second >> 16u;
    uint bit = 3u * texel;
    uint code = bit < 30u ? low >> bit : bit < 32u ? low >> 30u | high << 2u : high >> (bit - 32u);
    return block_value(first & 255u, first >> 8u & 255u, code & 7u);
}

// Red, green, blue, alpha, 8 bits each; of BC4 red, of BC5 red and green.
FN uint block_texel(uint kind, uint w0, uint w1, uint w2, uint w3, uint texel)
{
    uint value = 0u;
    if (kind == BLOCK_BC1) {
        value = block_colours_texel(w0, w1, texel, true);
    } else if (kind == BLOCK_BC4) {
        value = block_channel_texel(w0, w1, texel);
    } else if (kind == BLOCK_BC5) {
        value = block_channel_texel(w0, w1, texel) | block_channel_texel(w2, w3, texel) << 8u;
    } else {
        uint sharp = ((texel < 8u ? w0 : w1) >> (4u * (texel & 7u)) & 15u) * 17u;
        uint alpha = kind == BLOCK_BC2 ? sharp : block_channel_texel(w0, w1, texel);
        value = (block_colours_texel(w2, w3, texel, false) & 0xffffffu) | alpha << 24u;
    }
    return value;
}

#endif
