// SPDX-License-Identifier: Apache-2.0
// Puts triangles into blocks as they come.
#include <string.h>

#include "accel/structures.h"

static void order_some(clast_block *block, const uint8_t *indices, uint32_t first, uint32_t count)
{
    for (uint32_t lane = 0; lane < BLOCK_TRIANGLES; lane++) {
        uint32_t from = lane < count ? lane : 0;
        block->triangles[lane] = (uint8_t)(first + from);
        for (uint32_t corner = 0; corner < 3; corner++) {
            block->corners[corner][lane] = indices[3 * from + corner];
        }
    }
}

#if defined(__SSSE3__)
typedef uint8_t bytes16 __attribute__((vector_size(16)));
_Static_assert(sizeof(clast_block) == 32 && offsetof(clast_block, triangles) == 24, "two vectors");

// Eight triangles are 24 bytes: every third is the first corner of one.
static void order_eight(clast_block *block, const uint8_t *indices, uint32_t first)
{
    bytes16 low, high; // bytes 0 to 15 and 8 to 23
    memcpy(&low, indices, sizeof low);
    memcpy(&high, indices + 8, sizeof high);
    bytes16 corners = __builtin_shufflevector(low, high, 0, 3, 6, 9, 12, 15, 26, 29, 1, 4, 7, 10, 13, 24, 27, 30);
    bytes16 last = __builtin_shufflevector(low, high, 2, 5, 8, 11, 14, 25, 28, 31, 0, 0, 0, 0, 0, 0, 0, 0);
    uint64_t numbers = 0x0706050403020100u + 0x0101010101010101u * (uint8_t)first;
    memcpy(block, &corners, sizeof corners);
    memcpy(block->corners[2], &last, sizeof block->corners[2]);
    memcpy(block->triangles, &numbers, sizeof numbers);
}
#else
static void order_eight(clast_block *block, const uint8_t *indices, uint32_t first)
{
    order_some(block, indices, first, BLOCK_TRIANGLES);
}
#endif

void CLAST_KERNEL(clast_order)(clast_block *blocks, const uint8_t *indices, uint32_t count)
{
    uint32_t first = 0;
    for (; first + BLOCK_TRIANGLES <= count; first += BLOCK_TRIANGLES) {
        order_eight(blocks++, indices + 3 * (size_t)first, first);
    }
    if (first < count) {
        order_some(blocks, indices + 3 * (size_t)first, first, count - first);
    }
}
