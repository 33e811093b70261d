// SPDX-License-Identifier: Apache-2.0
// Portable float maps.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    if (size >= 2 && (data[1] == 'F' || data[1] == 'f')) {
        fuzz_decode(context, clast_pfm_decode, "P", 1, data, size);
    }
}
