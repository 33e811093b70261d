// SPDX-License-Identifier: Apache-2.0
// Numbers in text: what is read is what the C library reads, and nothing beyond the end is looked at.
#include "fuzz.h"
#include "load/number.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    (void)context;
    char *text = fuzz_copy(data, size);
    const char *next = NULL;
    double value;
    int64_t integer;
    if (clast_parse_number(text, text + size, &value, &next)) {
        FUZZ_CHECK(next > text && next <= text + size);
        char ended[64];
        size_t length = (size_t)(next - text);
        if (length < sizeof ended) {
            memcpy(ended, text, length);
            ended[length] = '\0';
            double expected = strtod(ended, NULL);
            FUZZ_CHECK(value == expected || (value != value && expected != expected));
        }
    }
    if (clast_parse_integer(text, text + size, &integer, &next)) {
        FUZZ_CHECK(next > text && next <= text + size);
    }
    free(text);
}
