// SPDX-License-Identifier: Apache-2.0
// EXR.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, clast_exr_decode, "\\x76\\x2f\\x31\\x01", 4, data, size);
}
