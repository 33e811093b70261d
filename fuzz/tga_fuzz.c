// SPDX-License-Identifier: Apache-2.0
// TGA. It has no signature: whether bytes may be one is asked first, as for any picture.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    if (clast_is_tga((clast_bytes){data, size})) {
        fuzz_decode(context, clast_tga_decode, "", 0, data, size);
    }
}
