// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ, beside a material library.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_load(context, clast_load_obj, "input.obj", data, size);
}
