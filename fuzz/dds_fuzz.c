// SPDX-License-Identifier: Apache-2.0
// DDS.
#include "fuzz.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    fuzz_decode(context, clast_dds_decode, "DDS ", 4, data, size);
}
