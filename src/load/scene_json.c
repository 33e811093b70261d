// SPDX-License-Identifier: Apache-2.0
#include "load/scene_json.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "load/image.h"

enum { PLACE_TEXT = 400, MESSAGE_TEXT = 600 };

static size_t print_place(const clast_json_place *place, char *text, size_t size)
{
    if (place == NULL || place->parent == NULL) {
        text[0] = '\0';
        return 0;
    }
    size_t length = print_place(place->parent, text, size);
    char key[80];
    if (place->key != NULL) {
        clast_copy_line(key, sizeof key, place->key);
        snprintf(text + length, size - length, "%s%s", length > 0 ? "." : "", key);
    } else {
        snprintf(text + length, size - length, "[%zu]", place->index);
    }
    return length + strlen(text + length);
}

void clast_json_fail(clast_json *json, const clast_json_place *place, clast_status status, const char *format, ...)
{
    char where[PLACE_TEXT];
    char what[MESSAGE_TEXT];
    if (json->status != CLAST_OK) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    print_place(place, where, sizeof where);
    json->status = clast_fail(json->context, status, "%s: %s%s%s", json->path, where, where[0] != '\0' ? ": " : "",
                              what);
}

void clast_json_check(clast_json *json, const clast_json_place *place, clast_status status)
{
    if (status == CLAST_OK || json->status != CLAST_OK) {
        return;
    }
    if (status == CLAST_ERROR_INVALID_ARGUMENT) {
        char what[MESSAGE_TEXT];
        snprintf(what, sizeof what, "%s", clast_context_error(json->context));
        clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "%s", what);
    }
    json->status = json->status == CLAST_OK ? status : json->status;
}

clast_json_place clast_json_member(const clast_json_place *object, const char *key)
{
    return (clast_json_place){object, key, 0, json_object_get(object->value, key)};
}

clast_json_place clast_json_element(const clast_json_place *array, size_t index)
{
    return (clast_json_place){array, NULL, index, json_array_get(array->value, index)};
}

static void expected(clast_json *json, const clast_json_place *place, const char *what)
{
    clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "expected %s", what);
}

static bool is_listed(const char *keys, const char *key)
{
    size_t length = strlen(key);
    for (const char *at = keys; *at != '\0';) {
        size_t word = strcspn(at, " ");
        if (word == length && memcmp(at, key, length) == 0) {
            return true;
        }
        at += word + (at[word] == ' ');
    }
    return false;
}

bool clast_json_object(clast_json *json, const clast_json_place *place, const char *keys)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    if (!json_is_object(place->value)) {
        expected(json, place, "an object");
        return false;
    }
    const char *key;
    json_t *value;
    json_object_foreach(place->value, key, value)
    {
        if (!is_listed(keys, key)) {
            clast_json_place unknown = {place, key, 0, value};
            clast_json_fail(json, &unknown, CLAST_ERROR_MALFORMED, "unknown key; expected one of: %s", keys);
            return false;
        }
    }
    return true;
}

size_t clast_json_array(clast_json *json, const clast_json_place *place)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return 0;
    }
    if (!json_is_array(place->value)) {
        expected(json, place, "an array");
        return 0;
    }
    return json_array_size(place->value);
}

bool clast_json_require(clast_json *json, const clast_json_place *place)
{
    if (place->value == NULL) {
        expected(json, place, "a value: it is missing");
    }
    return json->status == CLAST_OK;
}

bool clast_json_real(clast_json *json, const clast_json_place *place, double minimum, double maximum, double *value)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    double number = json_number_value(place->value);
    if (!json_is_number(place->value)) {
        expected(json, place, "a number");
    } else if (!(number >= minimum && number <= maximum)) {
        clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "%g: expected %g to %g", number, minimum, maximum);
    } else {
        *value = number;
    }
    return json->status == CLAST_OK;
}

bool clast_json_float(clast_json *json, const clast_json_place *place, double minimum, double maximum, float *value)
{
    double number = 0.0;
    if (!clast_json_real(json, place, minimum, maximum, &number)) {
        return false;
    }
    if (!isfinite((float)number)) {
        expected(json, place, "a number that is finite in single precision");
        return false;
    }
    *value = (float)number;
    return true;
}

bool clast_json_uint(clast_json *json, const clast_json_place *place, uint32_t minimum, uint32_t maximum,
                     uint32_t *value)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    json_int_t number = json_integer_value(place->value);
    if (!json_is_integer(place->value)) {
        expected(json, place, "a whole number");
    } else if (number < (json_int_t)minimum || number > (json_int_t)maximum) {
        clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "%" JSON_INTEGER_FORMAT ": expected %u to %u", number,
                        minimum, maximum);
    } else {
        *value = (uint32_t)number;
    }
    return json->status == CLAST_OK;
}

bool clast_json_bool(clast_json *json, const clast_json_place *place, bool *value)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    if (!json_is_boolean(place->value)) {
        expected(json, place, "true or false");
        return false;
    }
    *value = json_is_true(place->value);
    return true;
}

bool clast_json_vector(clast_json *json, const clast_json_place *place, float *values, size_t count)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    if (!json_is_array(place->value) || json_array_size(place->value) != count) {
        clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "expected an array of %zu numbers", count);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        clast_json_place element = clast_json_element(place, i);
        clast_json_float(json, &element, -HUGE_VAL, HUGE_VAL, &values[i]);
    }
    return json->status == CLAST_OK;
}

bool clast_json_text(clast_json *json, const clast_json_place *place, const char **text)
{
    if (json->status != CLAST_OK || place->value == NULL) {
        return false;
    }
    if (!json_is_string(place->value)) {
        expected(json, place, "a text");
        return false;
    }
    *text = json_string_value(place->value);
    return true;
}

bool clast_json_choose(clast_json *json, const clast_json_place *place, const clast_json_choice *choices, size_t count,
                       uint32_t *value)
{
    const char *text = NULL;
    if (!clast_json_text(json, place, &text)) {
        return false;
    }
    char list[200] = "";
    for (size_t i = 0; i < count; i++) {
        if (strcmp(choices[i].text, text) == 0) {
            *value = choices[i].value;
            return true;
        }
        size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%s", i > 0 ? ", " : "", choices[i].text);
    }
    clast_json_fail(json, place, CLAST_ERROR_MALFORMED, "expected one of: %s", list);
    return false;
}
