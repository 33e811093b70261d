// SPDX-License-Identifier: Apache-2.0
// glTF as text, beside a buffer and a picture.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_load(context, clast_load_gltf, "input.gltf", data, size);
}
