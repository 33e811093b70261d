// SPDX-License-Identifier: Apache-2.0
// Textures compressed in blocks of 4 x 4 pixels: BC1 to BC7 (Khronos Data Format Specification 1.3, sections 18 to 20; what
// Direct3D 11 calls them). A block decodes to sixteen pixels, rows from the top; whatever it holds means something.
#ifndef CLAST_LOAD_BLOCK_H
#define CLAST_LOAD_BLOCK_H

#include "clast/image.h"
#include "load/bytes.h"
#include "scene/blocks.h"

enum { CLAST_BLOCK_SIDE = 4, CLAST_BLOCK_PIXELS = 16, CLAST_BLOCK_BYTES_MOST = CLAST_BLOCK_PIXELS * 4 * 4 };

uint32_t clast_block_size(clast_block_format format);
uint32_t clast_block_channels(clast_block_format format);
clast_pixel_type clast_block_type(clast_block_format format);

// Decodes a block of clast_block_size bytes to sixteen pixels; `pixels` is aligned for its type.
void clast_block_decode(clast_block_format format, const unsigned char *block, void *pixels);
// Decodes an image of whole blocks, of which `bytes` holds enough, into pixels of `width` x `height`.
void clast_block_decode_image(clast_block_format format, clast_bytes bytes, uint32_t width, uint32_t height,
                              void *pixels);

// block_bptc.c
void clast_block_decode_bc6(const unsigned char *block, bool is_signed, float pixels[CLAST_BLOCK_PIXELS][3]);
void clast_block_decode_bc7(const unsigned char *block, unsigned char pixels[CLAST_BLOCK_PIXELS][4]);

#endif
