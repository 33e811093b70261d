// SPDX-License-Identifier: Apache-2.0
// JPEG.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, clast_jpeg_decode, "\\xff\\xd8\\xff", 3, data, size);
}
