// SPDX-License-Identifier: Apache-2.0
// Block decoders: the first byte chooses one. Whatever a block holds means something, and the same each time.
#include "fuzz.h"
#include "load/block.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    (void)context;
    clast_block_format format = size != 0 ? (clast_block_format)(data[0] % CLAST_BLOCK_COUNT) : CLAST_BLOCK_BC1;
    size_t block_size = clast_block_size(format);
    for (size_t at = 1; at + block_size <= size; at += block_size) {
        float pixels[CLAST_BLOCK_BYTES_MOST / 4] = {0};
        uint8_t *block = fuzz_copy(data + at, block_size);
        clast_block_decode(format, block, pixels);
        free(block);
        for (size_t i = 0; clast_block_type(format) == CLAST_PIXEL_FLOAT && i < 3 * CLAST_BLOCK_PIXELS; i++) {
            FUZZ_CHECK(pixels[i] - pixels[i] == 0.0f); // finite
        }
    }
}
