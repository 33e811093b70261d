// SPDX-License-Identifier: Apache-2.0
// Radiance HDR.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, clast_hdr_decode, "#?", 2, data, size);
}
