// SPDX-License-Identifier: Apache-2.0
// How texture files (DDS, KTX) store pixels: one list of formats, by the numbers that the interfaces of the time gave them, and
// their conversion to images.
#ifndef CLAST_LOAD_TEXEL_H
#define CLAST_LOAD_TEXEL_H

#include "load/block.h"
#include "load/image.h"

// What a channel's bits mean.
typedef enum clast_texel_kind {
    CLAST_TEXEL_UNORM,
    CLAST_TEXEL_SNORM, // given as (v + 1) / 2
    CLAST_TEXEL_FLOAT, // of 32, 16, 11 or 10 bits
    CLAST_TEXEL_SHARED_EXPONENT,
    CLAST_TEXEL_BLOCK,
} clast_texel_kind;

enum { CLAST_TEXEL_RED, CLAST_TEXEL_GREEN, CLAST_TEXEL_BLUE, CLAST_TEXEL_ALPHA, CLAST_TEXEL_CHANNELS };

typedef struct clast_texel_format {
    clast_texel_kind kind;
    clast_block_format block; // of blocks
    uint32_t size;            // bytes of a pixel, of others
    struct {
        uint8_t offset, bits; // from the lowest bit; none where bits is zero
    } channels[CLAST_TEXEL_CHANNELS];
    bool is_grey;          // red stands for all colours
    bool is_premultiplied; // colours have been multiplied by alpha
} clast_texel_format;

// A format by its number in DXGI, Vulkan, or OpenGL (sized internal formats); false where it is none that is read.
bool clast_texel_of_dxgi(uint32_t number, clast_texel_format *format);
bool clast_texel_of_vulkan(uint32_t number, clast_texel_format *format);
bool clast_texel_of_opengl(uint32_t number, clast_texel_format *format);

// Bytes of an image of that size; false where that does not fit 64 bits.
bool clast_texel_image_size(const clast_texel_format *format, uint32_t width, uint32_t height, uint64_t *size);
// Makes an image of the pixels at the beginning of `bytes`, of which it checks that there are enough. `stored` is the size of
// the file that they are from, `name` is for errors.
clast_status clast_texel_decode(clast_context *context, const char *name, const clast_texel_format *format,
                                clast_bytes bytes, uint64_t stored, uint32_t width, uint32_t height,
                                clast_image *image);

#endif
