// SPDX-License-Identifier: Apache-2.0
// Material libraries, by way of an OBJ file that names one.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    static const char shape[] = "mtllib input.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl red\nf 1/1 2/1 3/1\n";
    fuzz_put_file("input.mtl", data, size);
    fuzz_load(context, clast_load_obj, "input.obj", (const uint8_t *)shape, sizeof shape - 1);
}
