// SPDX-License-Identifier: Apache-2.0
// JSON by itself: what its values may take is counted before it is parsed, and a fault is told in one line.
#include "fuzz.h"
#include "load/json_text.h"

void fuzz_one(clast_context *context, const uint8_t *data, size_t size)
{
    uint8_t *text = fuzz_copy(data, size);
    json_t *json = NULL;
    clast_status status = clast_json_parse(context, "input", (clast_bytes){text, size}, &json);
    free(text);
    fuzz_check_outcome(context, status);
    FUZZ_CHECK((status == CLAST_OK) == (json != NULL));
    json_decref(json);
}
