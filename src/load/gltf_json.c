// SPDX-License-Identifier: Apache-2.0
// Typed, checked reads of JSON values, and errors that name their place.
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "load/account.h"
#include "load/gltf.h"

enum { PLACE_DEPTH_MOST = 16 };

static const double EXACT_INTEGER_MOST = 9007199254740992.0; // 2^53

// -------------------------------------------------------------------------------------------------------------- errors

void clast_gltf_write_place(const clast_gltf_value *value, char *text)
{
    const clast_gltf_value *chain[PLACE_DEPTH_MOST];
    size_t depth = 0;
    for (; value != NULL && value->around != NULL && depth < PLACE_DEPTH_MOST; value = value->around) {
        chain[depth++] = value;
    }
    size_t length = 0;
    text[0] = '\0';
    while (depth > 0 && length < CLAST_GLTF_PLACE_SIZE) {
        const clast_gltf_value *step = chain[--depth];
        char *rest = text + length;
        size_t room = CLAST_GLTF_PLACE_SIZE - length;
        int written = step->name != NULL ? snprintf(rest, room, "%s%s", length != 0 ? "." : "", step->name)
                                         : snprintf(rest, room, "[%zu]", step->index);
        length += written > 0 ? (size_t)written : 0;
    }
}

bool clast_gltf_fail(clast_gltf *gltf, clast_status status, const clast_gltf_value *place, const char *format, ...)
{
    if (gltf->status != CLAST_OK) {
        return false;
    }
    gltf->status = status;
    char where[CLAST_GLTF_PLACE_SIZE] = "", what[512];
    if (place != NULL) {
        clast_gltf_write_place(place, where);
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    clast_fail(gltf->context, status, "%s: %s%s%s", gltf->path, where, where[0] != '\0' ? ": " : "", what);
    return false;
}

bool clast_gltf_check(clast_gltf *gltf, clast_status status)
{
    if (gltf->status == CLAST_OK) {
        gltf->status = status;
    }
    return status == CLAST_OK;
}

bool clast_gltf_account(clast_gltf *gltf, const clast_gltf_value *place, uint64_t count, uint64_t size)
{
    char where[CLAST_GLTF_PLACE_SIZE], name[2 * CLAST_GLTF_PLACE_SIZE];
    clast_gltf_write_place(place, where);
    snprintf(name, sizeof name, "%.250s: %s", gltf->path, where);
    return clast_gltf_ok(gltf) && clast_gltf_check(gltf, clast_account_make(gltf->scene, name, count, size));
}

void clast_gltf_make_line(char *text)
{
    for (; *text != '\0'; text++) {
        if ((unsigned char)*text < 32 || *text == 127) {
            *text = ' ';
        }
    }
}

void clast_gltf_warn(const clast_gltf *gltf, const clast_gltf_value *place, const char *format, ...)
{
    char where[CLAST_GLTF_PLACE_SIZE], what[512];
    clast_gltf_write_place(place, where);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    clast_gltf_make_line(what);
    clast_log(gltf->context, CLAST_LOG_WARNING, "%s: %s%s%s", gltf->path, where, where[0] != '\0' ? ": " : "", what);
}

static const char *type_text(const json_t *json)
{
    switch (json_typeof(json)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "a text";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "a boolean";
    case JSON_NULL: return "null";
    }
    return "nothing";
}

static bool fail_type(clast_gltf *gltf, const clast_gltf_value *value, const char *expected)
{
    return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%s: expected %s",
                           value->json != NULL ? type_text(value->json) : "missing", expected);
}

// ---------------------------------------------------------------------------------------------------- objects, arrays

clast_gltf_value clast_gltf_member(const clast_gltf_value *object, const char *name)
{
    // json_object_get gives null for what is no object.
    return (clast_gltf_value){.around = object, .name = name, .json = json_object_get(object->json, name)};
}

clast_gltf_value clast_gltf_object(clast_gltf *gltf, const clast_gltf_value *object, const char *name)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    if (value.json != NULL && !json_is_object(value.json)) {
        fail_type(gltf, &value, "an object");
        value.json = NULL;
    }
    return value;
}

clast_gltf_value clast_gltf_array(clast_gltf *gltf, const clast_gltf_value *object, const char *name)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    if (value.json != NULL && !json_is_array(value.json)) {
        fail_type(gltf, &value, "an array");
        value.json = NULL;
    }
    return value;
}

clast_gltf_value clast_gltf_element(const clast_gltf_value *array, size_t index)
{
    return (clast_gltf_value){.around = array, .index = index, .json = json_array_get(array->json, index)};
}

clast_gltf_value clast_gltf_element_object(clast_gltf *gltf, const clast_gltf_value *array, size_t index)
{
    clast_gltf_value value = clast_gltf_element(array, index);
    if (!json_is_object(value.json)) {
        fail_type(gltf, &value, "an object");
        value.json = NULL;
    }
    return value;
}

size_t clast_gltf_size(const clast_gltf_value *array)
{
    return json_array_size(array->json);
}

clast_gltf_value clast_gltf_entry(clast_gltf *gltf, clast_gltf_list list, uint32_t index)
{
    return clast_gltf_element_object(gltf, &gltf->lists[list], index);
}

clast_gltf_value clast_gltf_extension(clast_gltf *gltf, const clast_gltf_value *object, clast_gltf_value *extensions,
                                      const char *name)
{
    *extensions = clast_gltf_object(gltf, object, "extensions");
    return clast_gltf_object(gltf, extensions, name);
}

// ------------------------------------------------------------------------------------------------------------- values

// A JSON number as an integer; 2.0 is one (section 2.7). False where it is none or negative.
static bool to_integer(const json_t *json, uint64_t *integer)
{
    if (json_is_integer(json)) {
        json_int_t value = json_integer_value(json);
        *integer = value >= 0 ? (uint64_t)value : 0;
        return value >= 0;
    }
    double value = json_is_real(json) ? json_real_value(json) : -1.0;
    if (!(value >= 0.0 && value <= EXACT_INTEGER_MOST) || value != floor(value)) {
        return false;
    }
    *integer = (uint64_t)value;
    return true;
}

uint64_t clast_gltf_integer(clast_gltf *gltf, const clast_gltf_value *object, const char *name, uint64_t least,
                            uint64_t most, uint64_t absent)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    uint64_t fallback = absent == CLAST_GLTF_REQUIRED ? least : absent, integer;
    if (value.json == NULL) {
        if (absent == CLAST_GLTF_REQUIRED) {
            fail_type(gltf, &value, "an integer");
        }
        return fallback;
    }
    if (!json_is_number(value.json)) {
        fail_type(gltf, &value, "an integer");
        return fallback;
    }
    if (!to_integer(value.json, &integer) || integer < least || integer > most) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "%.17g: expected an integer from %llu to %llu",
                        json_number_value(value.json), (unsigned long long)least, (unsigned long long)most);
        return fallback;
    }
    return integer;
}

static float read_number(clast_gltf *gltf, const clast_gltf_value *value, float least, float most, float fallback)
{
    if (!json_is_number(value->json)) {
        fail_type(gltf, value, "a number");
        return fallback;
    }
    double number = json_number_value(value->json);
    // Compared as doubles, so that the conversion below cannot overflow.
    if (number >= (double)least && number <= (double)most) {
        return (float)number;
    }
    if (most == FLT_MAX && least == -FLT_MAX) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%.9g: expected a finite 32-bit float", number);
    } else if (most == FLT_MAX) {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%.9g: expected a finite number of at least %.9g", number,
                        (double)least);
    } else {
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%.9g: expected a number from %.9g to %.9g", number,
                        (double)least, (double)most);
    }
    return fallback;
}

float clast_gltf_number(clast_gltf *gltf, const clast_gltf_value *object, const char *name, float least, float most,
                        float absent)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    return value.json == NULL ? absent : read_number(gltf, &value, least, most, absent);
}

bool clast_gltf_flag(clast_gltf *gltf, const clast_gltf_value *object, const char *name, bool absent)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    if (value.json == NULL) {
        return absent;
    }
    if (!json_is_boolean(value.json)) {
        fail_type(gltf, &value, "true or false");
        return absent;
    }
    return json_is_true(value.json);
}

const char *clast_gltf_text(clast_gltf *gltf, const clast_gltf_value *object, const char *name)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    if (value.json != NULL && !json_is_string(value.json)) {
        fail_type(gltf, &value, "a text");
    }
    return json_string_value(value.json);
}

bool clast_gltf_numbers(clast_gltf *gltf, const clast_gltf_value *object, const char *name, size_t count, float least,
                        float most, float *values)
{
    clast_gltf_value array = clast_gltf_array(gltf, object, name);
    if (array.json == NULL) {
        return false;
    }
    if (clast_gltf_size(&array) != count) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &array, "%zu elements: expected %zu",
                               clast_gltf_size(&array), count);
    }
    for (size_t i = 0; i < count; i++) {
        clast_gltf_value value = clast_gltf_element(&array, i);
        values[i] = read_number(gltf, &value, least, most, values[i]);
    }
    return clast_gltf_ok(gltf);
}

uint32_t clast_gltf_value_index(clast_gltf *gltf, const clast_gltf_value *value, clast_gltf_list list)
{
    static const char *const keys[] = {
#define KEY(name, key) key,
        CLAST_GLTF_LISTS(KEY)
#undef KEY
    };
    uint64_t index, count = clast_gltf_size(&gltf->lists[list]);
    if (!json_is_number(value->json)) {
        fail_type(gltf, value, "an index");
        return CLAST_NONE;
    }
    if (!to_integer(value->json, &index) || index >= count || index >= CLAST_NONE) {
        double number = json_number_value(value->json);
        if (count == 0) {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%.17g: the file has no %s", number, keys[list]);
        } else {
            clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, value, "%.17g: expected the index of one of the %llu %s",
                            number, (unsigned long long)count, keys[list]);
        }
        return CLAST_NONE;
    }
    return (uint32_t)index;
}

uint32_t clast_gltf_index(clast_gltf *gltf, const clast_gltf_value *object, const char *name, clast_gltf_list list)
{
    clast_gltf_value value = clast_gltf_member(object, name);
    return value.json == NULL ? CLAST_NONE : clast_gltf_value_index(gltf, &value, list);
}
