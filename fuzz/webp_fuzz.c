// SPDX-License-Identifier: Apache-2.0
// WebP.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    if (size >= 12) {
        uint8_t *copy = fuzz_copy(data, size);
        memcpy(copy + 8, "WEBP", 4);
        fuzz_decode(context, clast_webp_decode, "RIFF", 4, copy, size);
        free(copy);
    }
}
