// SPDX-License-Identifier: Apache-2.0
// Walks the JSON by the tables of validate_tables.c. The depth is that of the tables: what they do not know is not entered.
#include <math.h>

#include "load/validate.h"

static void walk_object(clast_validator *v, const clast_gltf_value *value, const clast_rule_object *object);

static bool is_integer(const json_t *json)
{
    return json_is_integer(json) || (json_is_real(json) && json_real_value(json) == floor(json_real_value(json)));
}

// --------------------------------------------------------------------------------------------------------- single values

// Whether a value is one of the choices, parted by blanks.
static bool is_choice(const char *choices, const char *text)
{
    size_t length = strlen(text);
    for (const char *at = choices; *at != '\0';) {
        size_t word = strcspn(at, " ");
        if (word == length && memcmp(at, text, length) == 0) {
            return true;
        }
        at += word;
        at += *at == ' ';
    }
    return false;
}

static void check_number(clast_validator *v, const clast_gltf_value *value, const clast_rule *rule)
{
    double number = json_number_value(value->json);
    if (rule->choices != NULL) {
        char text[32];
        snprintf(text, sizeof text, "%.0f", number);
        if (!is_choice(rule->choices, text)) {
            clast_validate_fault(v, CLAST_FAULT_VALUE_NOT_IN_LIST, value, "%.9g: expected one of %s", number,
                                 rule->choices);
        }
        return;
    }
    bool has_range = rule->least != 0.0 || rule->most != 0.0;
    bool is_low = number < rule->least || (rule->excludes_least && number == rule->least);
    if (!isfinite(number) || (has_range && (is_low || number > rule->most))) {
        clast_validate_fault(v, CLAST_FAULT_VALUE_NOT_IN_RANGE, value, "%.9g is out of range", number);
    }
}

// Section 3.10 takes what RFC 3986 does, and letters of any language; blanks are common and harm nobody. What steers terminals is
// none, and % stands before two hexadecimals.
static bool is_uri(const char *uri)
{
    for (const char *c = uri; *c != '\0'; c++) {
        if ((unsigned char)*c < ' ') {
            return false;
        }
        if (*c == '%' && strspn(c + 1, "0123456789abcdefABCDEF") < 2) {
            return false;
        }
    }
    return true;
}

static void check_uri(clast_validator *v, const clast_gltf_value *value)
{
    const char *uri = json_string_value(value->json);
    size_t scheme = strspn(uri, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.");
    if (strncmp(uri, "data:", 5) == 0) {
        return;
    }
    if (!is_uri(uri)) {
        clast_validate_fault(v, CLAST_FAULT_INVALID_URI, value, "\"%.200s\" has characters that a URI has not", uri);
    } else if (uri[0] == '/' || (scheme > 0 && uri[scheme] == ':')) {
        clast_validate_fault(v, CLAST_FAULT_NON_RELATIVE_URI, value, "\"%.200s\" is not relative", uri);
    }
}

static const char *type_text(clast_rule_type type)
{
    static const char *const texts[] = {
        [CLAST_RULE_BOOLEAN] = "a boolean", [CLAST_RULE_INTEGER] = "an integer", [CLAST_RULE_NUMBER] = "a number",
        [CLAST_RULE_TEXT] = "a text",       [CLAST_RULE_URI] = "a text",         [CLAST_RULE_INDEX] = "an integer",
        [CLAST_RULE_OBJECT] = "an object",  [CLAST_RULE_MAP] = "an object",      [CLAST_RULE_NUMBERS] = "an array",
        [CLAST_RULE_INTEGERS] = "an array", [CLAST_RULE_INDICES] = "an array",   [CLAST_RULE_TEXTS] = "an array",
        [CLAST_RULE_OBJECTS] = "an array",  [CLAST_RULE_MAPS] = "an array",
    };
    return texts[type] != NULL ? texts[type] : "something else";
}

static bool has_type(const json_t *json, clast_rule_type type)
{
    switch (type) {
    case CLAST_RULE_ANY: return true;
    case CLAST_RULE_BOOLEAN: return json_is_boolean(json);
    case CLAST_RULE_INTEGER:
    case CLAST_RULE_INDEX: return is_integer(json);
    case CLAST_RULE_NUMBER: return json_is_number(json);
    case CLAST_RULE_TEXT:
    case CLAST_RULE_URI: return json_is_string(json);
    case CLAST_RULE_OBJECT:
    case CLAST_RULE_MAP: return json_is_object(json);
    case CLAST_RULE_NUMBERS:
    case CLAST_RULE_INTEGERS:
    case CLAST_RULE_INDICES:
    case CLAST_RULE_TEXTS:
    case CLAST_RULE_OBJECTS:
    case CLAST_RULE_MAPS: return json_is_array(json);
    }
    return false;
}

static void check_index(clast_validator *v, const clast_gltf_value *value, clast_validate_list list)
{
    double number = json_number_value(value->json);
    if (number < 0.0) {
        clast_validate_fault(v, CLAST_FAULT_INVALID_INDEX, value, "%.9g: expected an index, which is not negative",
                             number);
    } else if (number >= (double)clast_validate_size(v, list)) {
        clast_validate_fault(v, CLAST_FAULT_UNRESOLVED_REFERENCE, value, "%.9g: there are %zu entries", number,
                             clast_validate_size(v, list));
    } else {
        v->used[list][(size_t)number] = true;
    }
}

// A value of the right type.
static void check_value(clast_validator *v, const clast_gltf_value *value, const clast_rule *rule, clast_rule_type type)
{
    switch (type) {
    case CLAST_RULE_INTEGER:
    case CLAST_RULE_NUMBER: check_number(v, value, rule); break;
    case CLAST_RULE_TEXT:
        if (rule->choices != NULL && !is_choice(rule->choices, json_string_value(value->json))) {
            clast_validate_fault(v, CLAST_FAULT_VALUE_NOT_IN_LIST, value, "\"%.100s\": expected one of %s",
                                 json_string_value(value->json), rule->choices);
        }
        break;
    case CLAST_RULE_URI: check_uri(v, value); break;
    case CLAST_RULE_INDEX: check_index(v, value, rule->list); break;
    case CLAST_RULE_OBJECT: walk_object(v, value, rule->object); break;
    default: break;
    }
}

// --------------------------------------------------------------------------------------------------------------- arrays

static clast_rule_type element_type(clast_rule_type type)
{
    switch (type) {
    case CLAST_RULE_NUMBERS: return CLAST_RULE_NUMBER;
    case CLAST_RULE_INTEGERS: return CLAST_RULE_INTEGER;
    case CLAST_RULE_INDICES: return CLAST_RULE_INDEX;
    case CLAST_RULE_TEXTS: return CLAST_RULE_TEXT;
    case CLAST_RULE_OBJECTS: return CLAST_RULE_OBJECT;
    default: return CLAST_RULE_MAP;
    }
}

static void check_length(clast_validator *v, const clast_gltf_value *array, const clast_rule *rule)
{
    size_t length = json_array_size(array->json);
    bool is_allowed = rule->lengths[0] == 0;
    for (size_t i = 0; i < sizeof rule->lengths && rule->lengths[i] != 0; i++) {
        is_allowed = is_allowed || rule->lengths[i] == length;
    }
    if (length == 0 && !rule->may_be_empty) {
        clast_validate_fault(v, CLAST_FAULT_EMPTY_ENTITY, array, "empty: expected at least one element");
    } else if (!is_allowed) {
        clast_validate_fault(v, CLAST_FAULT_ARRAY_LENGTH_NOT_IN_LIST, array,
                             "%zu elements: not a length that it may have", length);
    }
}

static void walk_map(clast_validator *v, const clast_gltf_value *map, clast_validate_list list);

// Each element once. Lists of indices can be long: what was seen of them is noted; those of texts are short, as are the texts.
static void check_distinct(clast_validator *v, const clast_gltf_value *array, const clast_rule *rule)
{
    size_t count = json_array_size(array->json);
    size_t most = rule->type == CLAST_RULE_INDICES ? clast_validate_size(v, rule->list) : 0;
    bool *seen = clast_allocate_zeroed(v->context, most, sizeof *seen);
    if (seen == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < count; i++) {
        clast_gltf_value element = clast_gltf_element(array, i);
        bool is_double = false;
        if (rule->type == CLAST_RULE_INDICES) {
            uint32_t index = clast_validate_element_index(v, array, i, rule->list);
            is_double = index != CLAST_NONE && seen[index];
            if (index != CLAST_NONE) {
                seen[index] = true;
            }
        }
        for (size_t k = 0; rule->type == CLAST_RULE_TEXTS && k < i && k < 1000; k++) {
            is_double = is_double || json_equal(element.json, json_array_get(array->json, k));
        }
        if (is_double) {
            clast_validate_fault(v, CLAST_FAULT_DUPLICATE_ELEMENTS, &element, "occurs twice");
        }
    }
    clast_free(v->context, seen);
}

static void walk_array(clast_validator *v, const clast_gltf_value *array, const clast_rule *rule)
{
    clast_rule_type type = element_type(rule->type);
    check_length(v, array, rule);
    for (size_t i = 0; i < json_array_size(array->json) && v->status == CLAST_OK; i++) {
        clast_gltf_value element = clast_gltf_element(array, i);
        if (type == CLAST_RULE_INDEX && json_is_number(element.json) && !is_integer(element.json)) {
            clast_validate_fault(v, CLAST_FAULT_INVALID_INDEX, &element, "expected an index");
        } else if (!has_type(element.json, type)) {
            clast_validate_fault(v, CLAST_FAULT_ARRAY_TYPE_MISMATCH, array, "element %zu is not %s", i,
                                 type_text(type));
        } else if (type == CLAST_RULE_MAP) {
            walk_map(v, &element, rule->list);
        } else {
            check_value(v, &element, rule, type);
        }
    }
    if (rule->is_distinct) {
        check_distinct(v, array, rule);
    }
}

// -------------------------------------------------------------------------------------------------------------- objects

static void walk_map(clast_validator *v, const clast_gltf_value *map, clast_validate_list list)
{
    const char *name;
    json_t *json;
    if (json_object_size(map->json) == 0) {
        clast_validate_fault(v, CLAST_FAULT_EMPTY_ENTITY, map, "empty: expected at least one member");
    }
    json_object_foreach(map->json, name, json)
    {
        clast_gltf_value member = {.around = map, .name = name, .json = json};
        if (has_type(json, CLAST_RULE_INDEX)) {
            check_index(v, &member, list);
        } else {
            clast_validate_fault(v, CLAST_FAULT_TYPE_MISMATCH, &member, "expected an integer");
        }
    }
}

static void walk_rule(clast_validator *v, const clast_gltf_value *object, const clast_rule *rule)
{
    clast_gltf_value value = clast_gltf_member(object, rule->name);
    if (value.json == NULL) {
        if (rule->is_required) {
            clast_validate_fault(v, CLAST_FAULT_UNDEFINED_PROPERTY, object, "no %s: expected %s", rule->name,
                                 type_text(rule->type));
        }
        return;
    }
    if (rule->needs != NULL && json_object_get(object->json, rule->needs) == NULL) {
        clast_validate_fault(v, CLAST_FAULT_UNSATISFIED_DEPENDENCY, &value, "needs %s", rule->needs);
    }
    if (!has_type(value.json, rule->type)) {
        clast_validate_fault(v, CLAST_FAULT_TYPE_MISMATCH, &value, "expected %s", type_text(rule->type));
    } else if (rule->type == CLAST_RULE_MAP) {
        walk_map(v, &value, rule->list);
    } else if (json_is_array(value.json) && rule->type != CLAST_RULE_ANY) {
        walk_array(v, &value, rule);
    } else {
        check_value(v, &value, rule, rule->type);
    }
}

static bool knows_name(const clast_rule_object *object, const char *name)
{
    for (const clast_rule *rule = object->rules; rule->name != NULL; rule++) {
        if (strcmp(rule->name, name) == 0) {
            return true;
        }
    }
    return !object->is_plain && (strcmp(name, "extensions") == 0 || strcmp(name, "extras") == 0);
}

static void walk_extension(clast_validator *v, const clast_gltf_value *value, const clast_rule_object *around)
{
    bool is_known = false;
    if (!clast_validate_declares(v, value->name)) {
        clast_validate_fault(v, CLAST_FAULT_UNDECLARED_EXTENSION, value, "extensionsUsed does not name it");
        return;
    }
    for (size_t i = 0; i < clast_rule_extension_count; i++) {
        const clast_rule_extension *extension = &clast_rule_extensions[i];
        if (strcmp(extension->name, value->name) != 0) {
            continue;
        }
        is_known = true;
        if (extension->around == around) {
            walk_object(v, value, extension->object);
            return;
        }
    }
    if (is_known) {
        clast_validate_fault(v, CLAST_FAULT_UNEXPECTED_EXTENSION_OBJECT, value, "the extension is not defined here");
    }
}

static void walk_extensions(clast_validator *v, const clast_gltf_value *object, const clast_rule_object *rules)
{
    clast_gltf_value extensions = clast_gltf_member(object, "extensions"), extras = clast_gltf_member(object, "extras");
    if (extras.json != NULL && !json_is_object(extras.json)) {
        clast_validate_fault(v, CLAST_FAULT_NON_OBJECT_EXTRAS, &extras, "extras that are no object");
    }
    if (extensions.json == NULL) {
        return;
    }
    if (!json_is_object(extensions.json)) {
        clast_validate_fault(v, CLAST_FAULT_TYPE_MISMATCH, &extensions, "expected an object");
        return;
    }
    const char *name;
    json_t *json;
    json_object_foreach(extensions.json, name, json)
    {
        clast_gltf_value extension = {.around = &extensions, .name = name, .json = json};
        if (json_is_object(json)) {
            walk_extension(v, &extension, rules);
        } else {
            clast_validate_fault(v, CLAST_FAULT_TYPE_MISMATCH, &extension, "expected an object");
        }
    }
}

static void walk_object(clast_validator *v, const clast_gltf_value *value, const clast_rule_object *object)
{
    const char *name;
    json_t *json;
    json_object_foreach(value->json, name, json)
    {
        if (!knows_name(object, name)) {
            clast_gltf_value member = {.around = value, .name = name, .json = json};
            clast_validate_fault(v, CLAST_FAULT_UNEXPECTED_PROPERTY, &member, "no such property is defined");
        }
    }
    for (const clast_rule *rule = object->rules; rule->name != NULL && v->status == CLAST_OK; rule++) {
        walk_rule(v, value, rule);
    }
    if (!object->is_plain) {
        walk_extensions(v, value, object);
    }
    if (object->check != NULL && v->status == CLAST_OK) {
        object->check(v, value);
    }
}

void clast_validate_walk(clast_validator *v)
{
    walk_object(v, &v->root, &clast_rules_of_root);
}
