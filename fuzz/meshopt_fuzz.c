// SPDX-License-Identifier: Apache-2.0
// The streams of EXT_meshopt_compression: mode, filter, count and stride come first.
#include "fuzz.h"
#include "load/meshopt.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    (void)context;
    fuzz_bytes bytes = {data, data + size};
    clast_meshopt_stream stream = {.mode = (clast_meshopt_mode)(fuzz_byte(&bytes) % 3),
                                   .filter = (clast_meshopt_filter)(fuzz_byte(&bytes) % 5)};
    stream.version_1 = fuzz_byte(&bytes) % 2 != 0;
    stream.stride = fuzz_byte(&bytes) + 1u;
    stream.count = fuzz_byte(&bytes) | (uint64_t)(fuzz_byte(&bytes) % 4) << 8;
    if (clast_meshopt_check(&stream) != NULL || stream.count == 0) {
        return;
    }
    size_t left = (size_t)(bytes.end - bytes.at);
    uint8_t *copy = fuzz_copy(bytes.at, left);
    uint8_t *decoded = malloc(stream.count * stream.stride);
    FUZZ_CHECK(decoded != NULL);
    clast_meshopt_decode(&stream, (clast_bytes){copy, left}, decoded);
    free(decoded);
    free(copy);
}
