// SPDX-License-Identifier: Apache-2.0
// PNG.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, clast_png_decode, "\\x89PNG\\r\\n\\x1a\\n", 8, data, size);
}
