// SPDX-License-Identifier: Apache-2.0
// KTX of both versions.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    if (size > 5 && data[5] == '2') {
        fuzz_decode(context, clast_ktx2_decode, "\xabKTX 20\xbb\r\n\x1a\n", 12, data, size);
    } else {
        fuzz_decode(context, clast_ktx_decode, "\xabKTX 11\xbb\r\n\x1a\n", 12, data, size);
    }
}
