// SPDX-License-Identifier: Apache-2.0
// BC6H and BC7. The tables are those of the Khronos Data Format Specification 1.3, section 20. Everything is integer
// arithmetic that is specified to the bit.
#include "load/block.h"

// ------------------------------------------------------------------------------------------------------- what both have

// Which of two subsets a pixel is in: bit i of a partition's number. BC6H has the first half of them.
static const uint16_t partitions_2[64] = {
    0xcccc, 0x8888, 0xeeee, 0xecc8, 0xc880, 0xfeec, 0xfec8, 0xec80, 0xc800, 0xffec, 0xfe80, 0xe800, 0xffe8,
    0xff00, 0xfff0, 0xf000, 0xf710, 0x008e, 0x7100, 0x08ce, 0x008c, 0x7310, 0x3100, 0x8cce, 0x088c, 0x3110,
    0x6666, 0x366c, 0x17e8, 0x0ff0, 0x718e, 0x399c, 0xaaaa, 0xf0f0, 0x5a5a, 0x33cc, 0x3c3c, 0x55aa, 0x9696,
    0xa55a, 0x73ce, 0x13c8, 0x324c, 0x3bdc, 0x6996, 0xc33c, 0x9966, 0x0660, 0x0272, 0x04e4, 0x4e40, 0x2720,
    0xc936, 0x936c, 0x39c6, 0x639c, 0x9336, 0x9cc6, 0x817e, 0xe718, 0xccf0, 0x0fcc, 0x7744, 0xee22,
};

// Which of three: two bits for each pixel.
static const uint32_t partitions_3[64] = {
    0xaa685050, 0x6a5a5040, 0x5a5a4200, 0x5450a0a8, 0xa5a50000, 0xa0a05050, 0x5555a0a0, 0x5a5a5050,
    0xaa550000, 0xaa555500, 0xaaaa5500, 0x90909090, 0x94949494, 0xa4a4a4a4, 0xa9a59450, 0x2a0a4250,
    0xa5945040, 0x0a425054, 0xa5a5a500, 0x55a0a0a0, 0xa8a85454, 0x6a6a4040, 0xa4a45000, 0x1a1a0500,
    0x0050a4a4, 0xaaa59090, 0x14696914, 0x69691400, 0xa08585a0, 0xaa821414, 0x50a4a450, 0x6a5a0200,
    0xa9a58000, 0x5090a0a8, 0xa8a09050, 0x24242424, 0x00aa5500, 0x24924924, 0x24499224, 0x50a50a50,
    0x500aa550, 0xaaaa4444, 0x66660000, 0xa5a0a5a0, 0x50a050a0, 0x69286928, 0x44aaaa44, 0x66666600,
    0xaa444444, 0x54a854a8, 0x95809580, 0x96969600, 0xa85454a8, 0x80959580, 0xaa141414, 0x96960000,
    0xaaaa1414, 0xa05050a0, 0xa0a5a5a0, 0x96000000, 0x40804080, 0xa9a8a9a8, 0xaaaaaa44, 0x2a4a5254,
};

// The pixel of the second subset whose index lacks its highest bit, which is zero; of the first it is pixel 0.
static const uint8_t anchors_2[64] = {
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2,  8, 2,  2, 8,
    8,  15, 2,  8,  2,  2,  8,  8,  2,  2,  15, 15, 6,  8,  2,  8,  15, 15, 2, 8,  2, 2,
    2,  15, 15, 6,  6,  2,  6,  8,  15, 15, 2,  2,  15, 15, 15, 15, 15, 2,  2, 15,
};
// The same for the second and the third of three.
static const uint8_t anchors_3[2][64] = {
    {3,  3,  15, 15, 8, 3,  15, 15, 8,  8,  6, 6,  6, 5,  3, 3,  3,  3,  8,  15, 3,  3,
     6,  10, 5,  8,  8, 6,  8,  5,  15, 15, 8, 15, 3, 5,  6, 10, 8,  15, 15, 3,  15, 5,
     15, 15, 15, 15, 3, 15, 5,  5,  5,  8,  5, 10, 5, 10, 8, 13, 15, 12, 3,  3},
    {15, 8, 8, 3,  15, 15, 3,  8,  15, 15, 15, 15, 15, 15, 15, 8,  15, 8,  15, 3,  15, 8,
     15, 8, 3, 15, 6,  10, 15, 15, 10, 8,  15, 3,  15, 10, 10, 8,  9,  10, 6,  15, 8,  15,
     3,  6, 6, 8,  15, 3,  15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3,  15, 15, 8},
};

// How much of the second end an index means, of 64.
static const uint8_t weights_2[4] = {0, 21, 43, 64};
static const uint8_t weights_3[8] = {0, 9, 18, 27, 37, 46, 55, 64};
static const uint8_t weights_4[16] = {0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};
static const uint8_t *const weights[5] = {NULL, NULL, weights_2, weights_3, weights_4};

static int32_t blend(int32_t a, int32_t b, int32_t weight)
{
    return (a * (64 - weight) + b * weight + 32) >> 6;
}

// A block's 128 bits, the lowest of its first byte first.
typedef struct bit_reader {
    const unsigned char *block;
    uint32_t place;
} bit_reader;

static uint32_t read_bits(bit_reader *bits, uint32_t count)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < count; i++, bits->place++) {
        value |= (uint32_t)(bits->block[bits->place / 8] >> bits->place % 8 & 1) << i;
    }
    return value;
}

static uint32_t subset_of(uint32_t subsets, uint32_t partition, uint32_t pixel)
{
    return subsets == 2   ? partitions_2[partition] >> pixel & 1u
           : subsets == 3 ? partitions_3[partition] >> (2 * pixel) & 3u
                          : 0;
}

static bool is_anchor(uint32_t subsets, uint32_t partition, uint32_t pixel)
{
    return pixel == 0 || (subsets == 2 && pixel == anchors_2[partition]) ||
           (subsets == 3 && (pixel == anchors_3[0][partition] || pixel == anchors_3[1][partition]));
}

static void read_indices(bit_reader *bits, uint32_t length, uint32_t subsets, uint32_t partition,
                         uint8_t indices[CLAST_BLOCK_PIXELS])
{
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        indices[i] = (uint8_t)read_bits(bits, length - is_anchor(subsets, partition, i));
    }
}

// ----------------------------------------------------------------------------------------------------------------- BC7

static const struct bc7_mode {
    uint8_t subsets, partition_bits, rotation_bits, selection_bits, colour_bits, alpha_bits;
    uint8_t own_low_bits, shared_low_bits; // a lowest bit of each end, or of each subset
    uint8_t index_bits, second_index_bits;
} bc7_modes[8] = {
    {3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0}, {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 1, 0, 2, 0}, {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
};

// Widens a value of `bits` bits to eight by its upper ones.
static uint32_t widen(uint32_t value, uint32_t bits)
{
    value <<= 8 - bits;
    return value | value >> bits;
}

static void read_ends(bit_reader *bits, const struct bc7_mode *mode, uint32_t ends[6][4])
{
    uint32_t count = 2u * mode->subsets;
    for (uint32_t c = 0; c < 4; c++) {
        for (uint32_t i = 0; i < count; i++) {
            ends[i][c] = read_bits(bits, c < 3 ? mode->colour_bits : mode->alpha_bits);
        }
    }
    uint32_t low_bit = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (mode->own_low_bits || (mode->shared_low_bits && i % 2 == 0)) {
            low_bit = read_bits(bits, 1);
        }
        for (uint32_t c = 0; c < 4; c++) {
            uint32_t length = c < 3 ? mode->colour_bits : mode->alpha_bits;
            if (mode->own_low_bits || mode->shared_low_bits) {
                ends[i][c] = ends[i][c] << 1 | low_bit;
                length += length != 0;
            }
            ends[i][c] = length != 0 ? widen(ends[i][c], length) : 255;
        }
    }
}

void clast_block_decode_bc7(const unsigned char *block, unsigned char pixels[CLAST_BLOCK_PIXELS][4])
{
    if (block[0] == 0) { // no mode: reserved, and to be decoded as zeros
        memset(pixels, 0, sizeof pixels[0] * CLAST_BLOCK_PIXELS);
        return;
    }
    uint32_t number = (uint32_t)__builtin_ctz(block[0]);
    const struct bc7_mode *mode = &bc7_modes[number];
    bit_reader bits = {block, number + 1};
    uint32_t partition = read_bits(&bits, mode->partition_bits), rotation = read_bits(&bits, mode->rotation_bits);
    bool second_is_colour = read_bits(&bits, mode->selection_bits) != 0;
    uint32_t ends[6][4];
    read_ends(&bits, mode, ends);
    uint8_t first[CLAST_BLOCK_PIXELS], second[CLAST_BLOCK_PIXELS];
    read_indices(&bits, mode->index_bits, mode->subsets, partition, first);
    if (mode->second_index_bits != 0) {
        read_indices(&bits, mode->second_index_bits, mode->subsets, partition, second);
    }
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        int32_t weight = weights[mode->index_bits][first[i]], colour_weight = weight, alpha_weight = weight;
        if (mode->second_index_bits != 0) {
            int32_t other = weights[mode->second_index_bits][second[i]];
            colour_weight = second_is_colour ? other : weight;
            alpha_weight = second_is_colour ? weight : other;
        }
        uint32_t subset = subset_of(mode->subsets, partition, i);
        for (uint32_t c = 0; c < 4; c++) {
            pixels[i][c] = (unsigned char)blend((int32_t)ends[2 * subset][c], (int32_t)ends[2 * subset + 1][c],
                                                c < 3 ? colour_weight : alpha_weight);
        }
        if (rotation != 0) { // alpha has changed places with a colour
            unsigned char other = pixels[i][3];
            pixels[i][3] = pixels[i][rotation - 1];
            pixels[i][rotation - 1] = other;
        }
    }
}

// ---------------------------------------------------------------------------------------------------------------- BC6H

// A piece of an end's channel: `count` bits from `low` up; where count is negative, they come with the highest first.
typedef struct bc6_piece {
    uint8_t channel, end;
    uint8_t low;
    int8_t count;
} bc6_piece;

#define R(end, low, count) \
    { \
        0, end, low, count \
    }
#define G(end, low, count) \
    { \
        1, end, low, count \
    }
#define B(end, low, count) \
    { \
        2, end, low, count \
    }
enum { PIECES_MOST = 24 };

static const struct bc6_mode {
    uint8_t code;          // what a block begins with: two bits, or five
    uint8_t regions;       // one or two
    uint8_t end_bits;      // of the first end
    uint8_t delta_bits[3]; // of the others, channel by channel
    bool has_deltas;       // the others are relative to the first
    bc6_piece pieces[PIECES_MOST];
} bc6_modes[14] = {
    {0x00,
     2,
     10,
     {5, 5, 5},
     true,
     {G(2, 4, 1), B(2, 4, 1), B(3, 4, 1), R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 5), G(3, 4, 1), G(2, 0, 4),
      G(1, 0, 5), B(3, 0, 1), G(3, 0, 4), B(1, 0, 5), B(3, 1, 1), B(2, 0, 4), R(2, 0, 5), B(3, 2, 1), R(3, 0, 5),
      B(3, 3, 1)}},
    {0x01, 2, 7, {6, 6, 6}, true, {G(2, 5, 1), G(3, 4, 1), G(3, 5, 1), R(0, 0, 7), B(3, 0, 1), B(3, 1, 1),
                                   B(2, 4, 1), G(0, 0, 7), B(2, 5, 1), B(3, 2, 1), G(2, 4, 1), B(0, 0, 7),
                                   B(3, 3, 1), B(3, 5, 1), B(3, 4, 1), R(1, 0, 6), G(2, 0, 4), G(1, 0, 6),
                                   G(3, 0, 4), B(1, 0, 6), B(2, 0, 4), R(2, 0, 6), R(3, 0, 6)}},
    {0x02,
     2,
     11,
     {5, 4, 4},
     true,
     {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 5), R(0, 10, 1), G(2, 0, 4), G(1, 0, 4), G(0, 10, 1), B(3, 0, 1),
      G(3, 0, 4), B(1, 0, 4), B(0, 10, 1), B(3, 1, 1), B(2, 0, 4), R(2, 0, 5), B(3, 2, 1), R(3, 0, 5), B(3, 3, 1)}},
    {0x06, 2, 11, {4, 5, 4}, true, {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 4),  R(0, 10, 1),
                                    G(3, 4, 1),  G(2, 0, 4),  G(1, 0, 5),  G(0, 10, 1), G(3, 0, 4),
                                    B(1, 0, 4),  B(0, 10, 1), B(3, 1, 1),  B(2, 0, 4),  R(2, 0, 4),
                                    B(3, 0, 1),  B(3, 2, 1),  R(3, 0, 4),  G(2, 4, 1),  B(3, 3, 1)}},
    {0x0a, 2, 11, {4, 4, 5}, true, {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 4),  R(0, 10, 1),
                                    B(2, 4, 1),  G(2, 0, 4),  G(1, 0, 4),  G(0, 10, 1), B(3, 0, 1),
                                    G(3, 0, 4),  B(1, 0, 5),  B(0, 10, 1), B(2, 0, 4),  R(2, 0, 4),
                                    B(3, 1, 1),  B(3, 2, 1),  R(3, 0, 4),  B(3, 4, 1),  B(3, 3, 1)}},
    {0x0e,
     2,
     9,
     {5, 5, 5},
     true,
     {R(0, 0, 9), B(2, 4, 1), G(0, 0, 9), G(2, 4, 1), B(0, 0, 9), B(3, 4, 1), R(1, 0, 5), G(3, 4, 1), G(2, 0, 4),
      G(1, 0, 5), B(3, 0, 1), G(3, 0, 4), B(1, 0, 5), B(3, 1, 1), B(2, 0, 4), R(2, 0, 5), B(3, 2, 1), R(3, 0, 5),
      B(3, 3, 1)}},
    {0x12,
     2,
     8,
     {6, 5, 5},
     true,
     {R(0, 0, 8), G(3, 4, 1), B(2, 4, 1), G(0, 0, 8), B(3, 2, 1), G(2, 4, 1), B(0, 0, 8), B(3, 3, 1), B(3, 4, 1),
      R(1, 0, 6), G(2, 0, 4), G(1, 0, 5), B(3, 0, 1), G(3, 0, 4), B(1, 0, 5), B(3, 1, 1), B(2, 0, 4), R(2, 0, 6),
      R(3, 0, 6)}},
    {0x16, 2, 8, {5, 6, 5}, true, {R(0, 0, 8), B(3, 0, 1), B(2, 4, 1), G(0, 0, 8), G(2, 5, 1), G(2, 4, 1), B(0, 0, 8),
                                   G(3, 5, 1), B(3, 4, 1), R(1, 0, 5), G(3, 4, 1), G(2, 0, 4), G(1, 0, 6), G(3, 0, 4),
                                   B(1, 0, 5), B(3, 1, 1), B(2, 0, 4), R(2, 0, 5), B(3, 2, 1), R(3, 0, 5), B(3, 3, 1)}},
    {0x1a, 2, 8, {5, 5, 6}, true, {R(0, 0, 8), B(3, 1, 1), B(2, 4, 1), G(0, 0, 8), B(2, 5, 1), G(2, 4, 1), B(0, 0, 8),
                                   B(3, 5, 1), B(3, 4, 1), R(1, 0, 5), G(3, 4, 1), G(2, 0, 4), G(1, 0, 5), B(3, 0, 1),
                                   G(3, 0, 4), B(1, 0, 6), B(2, 0, 4), R(2, 0, 5), B(3, 2, 1), R(3, 0, 5), B(3, 3, 1)}},
    {0x1e, 2, 6, {6, 6, 6}, false, {R(0, 0, 6), G(3, 4, 1), B(3, 0, 1), B(3, 1, 1), B(2, 4, 1), G(0, 0, 6),
                                    G(2, 5, 1), B(2, 5, 1), B(3, 2, 1), G(2, 4, 1), B(0, 0, 6), G(3, 5, 1),
                                    B(3, 3, 1), B(3, 5, 1), B(3, 4, 1), R(1, 0, 6), G(2, 0, 4), G(1, 0, 6),
                                    G(3, 0, 4), B(1, 0, 6), B(2, 0, 4), R(2, 0, 6), R(3, 0, 6)}},
    {0x03, 1, 10, {10, 10, 10}, false, {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 10), G(1, 0, 10), B(1, 0, 10)}},
    {0x07,
     1,
     11,
     {9, 9, 9},
     true,
     {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 9), R(0, 10, 1), G(1, 0, 9), G(0, 10, 1), B(1, 0, 9),
      B(0, 10, 1)}},
    {0x0b,
     1,
     12,
     {8, 8, 8},
     true,
     {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 8), R(0, 10, -2), G(1, 0, 8), G(0, 10, -2), B(1, 0, 8),
      B(0, 10, -2)}},
    {0x0f,
     1,
     16,
     {4, 4, 4},
     true,
     {R(0, 0, 10), G(0, 0, 10), B(0, 0, 10), R(1, 0, 4), R(0, 10, -6), G(1, 0, 4), G(0, 10, -6), B(1, 0, 4),
      B(0, 10, -6)}},
};
#undef R
#undef G
#undef B

static const struct bc6_mode *find_mode(bit_reader *bits)
{
    uint32_t code = read_bits(bits, 2);
    code |= code > 1 ? read_bits(bits, 3) << 2 : 0;
    for (uint32_t i = 0; i < 14; i++) {
        if (bc6_modes[i].code == code) {
            return &bc6_modes[i];
        }
    }
    return NULL;
}

static void read_pieces(bit_reader *bits, const struct bc6_mode *mode, int32_t ends[3][4])
{
    memset(ends, 0, 3 * sizeof ends[0]);
    for (const bc6_piece *piece = mode->pieces; piece < mode->pieces + PIECES_MOST && piece->count != 0; piece++) {
        int32_t *end = &ends[piece->channel][piece->end];
        if (piece->count > 0) {
            *end |= (int32_t)(read_bits(bits, (uint32_t)piece->count) << piece->low);
        }
        for (int32_t i = -piece->count - 1; i >= 0; i--) {
            *end |= (int32_t)(read_bits(bits, 1) << (piece->low + i));
        }
    }
}

// The value of the lowest `bits` bits as a signed number.
static int32_t extend_sign(int32_t value, uint32_t bits)
{
    int32_t sign = 1 << (bits - 1);
    value &= (sign << 1) - 1;
    return (value ^ sign) - sign;
}

static void add_deltas(const struct bc6_mode *mode, bool is_signed, int32_t ends[3][4])
{
    for (uint32_t c = 0; c < 3; c++) {
        if (is_signed) {
            ends[c][0] = extend_sign(ends[c][0], mode->end_bits);
        }
        for (uint32_t i = 1; i < 2u * mode->regions; i++) {
            if (mode->has_deltas || is_signed) {
                ends[c][i] = extend_sign(ends[c][i], mode->delta_bits[c]);
            }
            if (mode->has_deltas) {
                int32_t sum = ends[c][0] + ends[c][i];
                ends[c][i] = is_signed ? extend_sign(sum, mode->end_bits) : sum & ((1 << mode->end_bits) - 1);
            }
        }
    }
}

// Widens an end to 16 bits, or to 15 and a sign.
static int32_t widen_end(int32_t value, uint32_t bits, bool is_signed)
{
    if (!is_signed) {
        return bits >= 15                 ? value
               : value == 0               ? 0
               : value == (1 << bits) - 1 ? 0xffff
                                          : (int32_t)((((uint32_t)value << 16) + 0x8000u) >> bits);
    }
    if (bits >= 16) {
        return value;
    }
    int32_t size = value < 0 ? -value : value;
    int32_t wide = size == 0 ? 0 : size >= (1 << (bits - 1)) - 1 ? 0x7fff : ((size << 15) + 0x4000) >> (bits - 1);
    return value < 0 ? -wide : wide;
}

// The bits of a half-precision number, as a float.
static float half_of(int32_t value, bool is_signed)
{
    int32_t size = value < 0 ? -value : value;
    uint32_t half = (uint32_t)(is_signed ? size * 31 >> 5 : size * 31 >> 6), bits;
    if (half < 0x400) {
        float small = (float)half * 0x1p-24f;
        return value < 0 ? -small : small;
    }
    bits = (half << 13) + (112u << 23) + (value < 0 ? 0x80000000u : 0); // never infinite: 31/32 and 31/64 see to that
    float result;
    memcpy(&result, &bits, sizeof result);
    return result;
}

void clast_block_decode_bc6(const unsigned char *block, bool is_signed, float pixels[CLAST_BLOCK_PIXELS][3])
{
    bit_reader bits = {block, 0};
    const struct bc6_mode *mode = find_mode(&bits);
    if (mode == NULL) { // reserved, and to be decoded as zeros
        memset(pixels, 0, sizeof pixels[0] * CLAST_BLOCK_PIXELS);
        return;
    }
    int32_t ends[3][4];
    read_pieces(&bits, mode, ends);
    add_deltas(mode, is_signed, ends);
    uint32_t partition = mode->regions == 2 ? read_bits(&bits, 5) : 0, index_bits = mode->regions == 2 ? 3 : 4;
    uint8_t indices[CLAST_BLOCK_PIXELS];
    read_indices(&bits, index_bits, mode->regions, partition, indices);
    for (uint32_t i = 0; i < CLAST_BLOCK_PIXELS; i++) {
        uint32_t subset = subset_of(mode->regions, partition, i);
        for (uint32_t c = 0; c < 3; c++) {
            int32_t a = widen_end(ends[c][2 * subset], mode->end_bits, is_signed);
            int32_t b = widen_end(ends[c][2 * subset + 1], mode->end_bits, is_signed);
            pixels[i][c] = half_of(blend(a, b, weights[index_bits][indices[i]]), is_signed);
        }
    }
}
