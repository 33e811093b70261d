// SPDX-License-Identifier: Apache-2.0
// Pictures compressed in blocks of 4 x 4 pixels: BC1 to BC7 (Khronos Data Format Specification 1.3, sections 18 to 20; what
// Direct3D 11 calls them).
#ifndef CLAST_SCENE_BLOCKS_H
#define CLAST_SCENE_BLOCKS_H

#include <stddef.h>
#include <stdint.h>

// X(name, bytes of a block, channels, pixel type). Signed normalised values v are given as (v + 1) / 2.
#define CLAST_BLOCK_LIST(X) \
    X(CLAST_BLOCK_BC1, 8, 4, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC2, 16, 4, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC3, 16, 4, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC4, 8, 1, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC4_SIGNED, 8, 1, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC5, 16, 2, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC5_SIGNED, 16, 2, CLAST_PIXEL_UNORM8) \
    X(CLAST_BLOCK_BC6, 16, 3, CLAST_PIXEL_FLOAT) \
    X(CLAST_BLOCK_BC6_SIGNED, 16, 3, CLAST_PIXEL_FLOAT) \
    X(CLAST_BLOCK_BC7, 16, 4, CLAST_PIXEL_UNORM8)

#define CLAST_BLOCK_ENUMERATOR(name, size, channels, type) name,
typedef enum clast_block_format { CLAST_BLOCK_LIST(CLAST_BLOCK_ENUMERATOR) CLAST_BLOCK_COUNT } clast_block_format;

// The blocks that a picture was decoded from, row by row from the top: for devices that read them as they are.
typedef struct clast_image_blocks {
    clast_block_format format;
    void *data; // a block of clast_allocate; null where there are none
    size_t bytes;
} clast_image_blocks;

#endif
