// SPDX-License-Identifier: Apache-2.0
// KTX of both versions, with levels.
#include "fuzz.h"

static clast_status decode_older(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    clast_image_parts parts = {0};
    clast_status status = clast_ktx_decode_parts(context, name, bytes, image, &parts);
    clast_levels_free(context, &parts.levels);
    return status;
}

static clast_status decode_newer(clast_context *context, const char *name, clast_bytes bytes, clast_image *image)
{
    clast_image_parts parts = {0};
    clast_status status = clast_ktx2_decode_parts(context, name, bytes, image, &parts);
    clast_levels_free(context, &parts.levels);
    return status;
}

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    if (size > 5 && data[5] == '2') {
        fuzz_decode(context, decode_newer, "\xabKTX 20\xbb\r\n\x1a\n", 12, data, size);
    } else {
        fuzz_decode(context, decode_older, "\xabKTX 11\xbb\r\n\x1a\n", 12, data, size);
    }
}
