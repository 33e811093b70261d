// SPDX-License-Identifier: Apache-2.0
// Strict reading of JSON: what is of another type than expected, out of range or unknown is an error that says where,
// as "scene.json: cameras[0].position[1]: expected a number".
#ifndef CLAST_LOAD_SCENE_JSON_H
#define CLAST_LOAD_SCENE_JSON_H

#include <jansson.h>

#include "base/context.h"

// After the first failure all reads do nothing, so that callers check once.
typedef struct clast_json {
    clast_context *context;
    const char *path; // of the file
    clast_status status;
} clast_json;

// A value and the way to it.
typedef struct clast_json_place {
    const struct clast_json_place *parent; // null: the whole text
    const char *key;                       // null: an element of an array
    size_t index;
    json_t *value; // null: absent
} clast_json_place;

// Records the first failure, with the place.
void clast_json_fail(clast_json *json, const clast_json_place *place, clast_status status, const char *format, ...)
    CLAST_PRINTF(4, 5);

// Turns the failure of a call that was made for `place` into one that names it.
void clast_json_check(clast_json *json, const clast_json_place *place, clast_status status);

// A member of an object; its value is null where the object lacks it.
clast_json_place clast_json_member(const clast_json_place *object, const char *key);
clast_json_place clast_json_element(const clast_json_place *array, size_t index);

// Refuses what is no object, and members other than `keys`: names parted by single blanks.
bool clast_json_object(clast_json *json, const clast_json_place *place, const char *keys);
// The number of elements; 0 where absent. Refuses what is no array.
size_t clast_json_array(clast_json *json, const clast_json_place *place);
// Fails where the value is absent.
bool clast_json_require(clast_json *json, const clast_json_place *place);

// Each leaves `*value` alone where the value is absent or wrong, and then gives false. Ranges include their ends.
bool clast_json_real(clast_json *json, const clast_json_place *place, double minimum, double maximum, double *value);
bool clast_json_float(clast_json *json, const clast_json_place *place, double minimum, double maximum, float *value);
bool clast_json_uint(clast_json *json, const clast_json_place *place, uint32_t minimum, uint32_t maximum,
                     uint32_t *value);
bool clast_json_bool(clast_json *json, const clast_json_place *place, bool *value);
// An array of exactly `count` numbers that are finite as floats.
bool clast_json_vector(clast_json *json, const clast_json_place *place, float *values, size_t count);
// A text, of the JSON's own memory.
bool clast_json_text(clast_json *json, const clast_json_place *place, const char **text);

// A value of an X-macro list of clast/lists.h, by its text.
typedef struct clast_json_choice {
    const char *text;
    uint32_t value;
} clast_json_choice;
#define CLAST_JSON_CHOICE(name, value, text, ...) {text, value},
bool clast_json_choose(clast_json *json, const clast_json_place *place, const clast_json_choice *choices, size_t count,
                       uint32_t *value);

#endif
