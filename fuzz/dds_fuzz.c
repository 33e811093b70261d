// SPDX-License-Identifier: Apache-2.0
// DDS, with its blocks and levels.
#include "fuzz.h"

static clast_status decode(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    clast_image_parts parts = {0};
    clast_status status = clast_dds_decode_parts(context, name, bytes, image, &parts);
    clast_free(context, parts.blocks.data);
    clast_levels_free(context, &parts.levels);
    return status;
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, decode, "DDS ", 4, data, size);
}
