// SPDX-License-Identifier: Apache-2.0
// Pictures of any kind, told by their contents.
#include "fuzz.h"

static clast_status decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    return clast_decode_image(context, name, bytes.data, bytes.size, image);
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, decode, "", 0, data, size);
}
