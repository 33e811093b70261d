// SPDX-License-Identifier: Apache-2.0
// STL, both kinds.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_load(context, clast_load_stl, "input.stl", data, size);
}
