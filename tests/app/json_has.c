// SPDX-License-Identifier: Apache-2.0
// json_has FILE PATH...: fails unless FILE is one JSON object that has a value at each path, as milliseconds.passes.trace.
// Prints the scalar values, one a line.
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>

static const json_t *value_at(const json_t *value, const char *path)
{
    char key[64];
    while (value != NULL && *path != '\0') {
        size_t length = strcspn(path, ".");
        if (length >= sizeof key) {
            return NULL;
        }
        memcpy(key, path, length);
        key[length] = '\0';
        value = json_object_get(value, key);
        path += length + (path[length] == '.');
    }
    return value;
}

static void print_value(const json_t *value)
{
    if (json_is_integer(value)) {
        printf("%" JSON_INTEGER_FORMAT "\n", json_integer_value(value));
    } else if (json_is_real(value)) {
        printf("%.9g\n", json_real_value(value));
    } else if (json_is_string(value)) {
        printf("%s\n", json_string_value(value));
    } else if (json_is_boolean(value)) {
        printf("%s\n", json_is_true(value) ? "true" : "false");
    }
}

int main(int count, char **arguments)
{
    if (count < 2) {
        return 2;
    }
    json_error_t error;
    json_t *object = json_load_file(arguments[1], JSON_REJECT_DUPLICATES, &error);
    if (!json_is_object(object)) {
        fprintf(stderr, "%s: not one JSON object: %s\n", arguments[1], object == NULL ? error.text : "something else");
        json_decref(object);
        return 1;
    }
    int result = 0;
    for (int i = 2; i < count; i++) {
        const json_t *value = value_at(object, arguments[i]);
        if (value == NULL) {
            fprintf(stderr, "%s: has no %s\n", arguments[1], arguments[i]);
            result = 1;
        } else {
            print_value(value);
        }
    }
    json_decref(object);
    return result;
}
