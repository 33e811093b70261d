// SPDX-License-Identifier: Apache-2.0
// Scene files, beside models and pictures.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_load(context, clast_load_scene_file, "input.json", data, size);
}
