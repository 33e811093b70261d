// SPDX-License-Identifier: Apache-2.0
#include "load/json_text.h"

#include "load/image.h"

// What values take at most, with the library's overhead; an object's, with what a loader keeps of it. A text takes its own length
// besides.
enum { OBJECT_BYTES = 352, ARRAY_BYTES = 144, MEMBER_BYTES = 88, VALUE_BYTES = 48 };

// The memory that the values of a text may take: what its signs outside of texts stand for, whether it is sound or not.
static uint64_t bytes_of_values(clast_bytes text)
{
    uint64_t bytes = text.size;
    bool in_text = false;
    for (uint64_t i = 0; i < text.size; i++) {
        unsigned char c = text.data[i];
        if (in_text) {
            i += c == '\\';
            in_text = c != '"';
            continue;
        }
        switch (c) {
        case '"': in_text = true; break;
        case '{': bytes += OBJECT_BYTES + VALUE_BYTES; break;
        case '[': bytes += ARRAY_BYTES + VALUE_BYTES; break;
        case ':': bytes += MEMBER_BYTES; break;
        case ',': bytes += VALUE_BYTES; break;
        }
    }
    return bytes;
}

clast_status clast_json_parse(clast_context *context, const char *name, clast_bytes text, json_t **json)
{
    *json = NULL;
    if (clast_bytes_begin_with(text, "\xef\xbb\xbf")) { // a byte order mark: forbidden to write, free to pass over
        clast_bytes_slice(text, 3, text.size - 3, &text);
    }
    uint64_t bytes = bytes_of_values(text), most = clast_unpacked_most(text.size);
    if (bytes > most) {
        return clast_fail(context, CLAST_ERROR_LIMIT,
                          "%s: JSON whose values may take %llu bytes: at most %llu are allowed for its %llu", name,
                          (unsigned long long)bytes, (unsigned long long)most, (unsigned long long)text.size);
    }
    json_error_t error;
    *json = json_loadb((const char *)text.data, (size_t)text.size, JSON_REJECT_DUPLICATES, &error);
    if (*json != NULL) {
        return CLAST_OK;
    }
    if (json_error_code(&error) == json_error_out_of_memory) {
        return clast_fail(context, CLAST_ERROR_OUT_OF_MEMORY, "%s: no memory for the JSON", name);
    }
    char quoting[JSON_ERROR_TEXT_LENGTH];
    clast_copy_line(quoting, sizeof quoting, error.text);
    return clast_fail(context, CLAST_ERROR_MALFORMED, "%s: JSON, line %d, column %d: %s", name, error.line,
                      error.column, quoting);
}
