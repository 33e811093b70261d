// SPDX-License-Identifier: Apache-2.0
// The list of faults, and what is validated how.
#include "load/validate.h"

#include <math.h>
#include <stdio.h>

#include "load/account.h"
#include "load/image.h"

enum { LISTED_MOST = 10000, POINTER_SIZE = 512, DEPTH_MOST = 32, EXTENSIONS_MOST = 256 };

struct clast_validation {
    clast_context *context;
    clast_fault *faults;
    size_t count, capacity;
    uint64_t counts[CLAST_SEVERITY_COUNT];
};

static const struct {
    const char *code;
    clast_severity severity;
} codes[] = {
#define CODE(code, severity, meaning) {#code, CLAST_SEVERITY_##severity},
    CLAST_FAULT_LIST(CODE)
#undef CODE
};

// -------------------------------------------------------------------------------------------------------------- faults

// Adds a character to a pointer that has room for it and the end.
static size_t put(char *text, size_t length, char c)
{
    if (length + 1 < POINTER_SIZE) {
        text[length++] = c;
    }
    return length;
}

// A name as a part of a JSON pointer: RFC 6901 section 3.
static size_t put_name(char *text, size_t length, const char *name)
{
    for (; *name != '\0'; name++) {
        if (*name == '~' || *name == '/') {
            length = put(text, length, '~');
            length = put(text, length, *name == '~' ? '0' : '1');
        } else {
            length = put(text, length, *name);
        }
    }
    return length;
}

static void write_pointer(const clast_gltf_value *value, char text[POINTER_SIZE])
{
    const clast_gltf_value *chain[DEPTH_MOST];
    size_t depth = 0, length = 0;
    for (; value != NULL && value->around != NULL && depth < DEPTH_MOST; value = value->around) {
        chain[depth++] = value;
    }
    while (depth > 0) {
        const clast_gltf_value *step = chain[--depth];
        char number[24];
        snprintf(number, sizeof number, "%zu", step->index);
        length = put(text, length, '/');
        length = put_name(text, length, step->name != NULL ? step->name : number);
    }
    text[length] = '\0';
}

// Takes texts as blocks, and keeps them in the list where they fit.
static void add_fault(clast_validator *v, clast_fault_code code, char *pointer, uint64_t offset, const char *text)
{
    clast_validation *validation = v->validation;
    validation->counts[codes[code].severity]++;
    char *copy = NULL;
    bool is_listed = validation->count < LISTED_MOST;
    if (is_listed) {
        v->status = CLAST_RESERVE(v->context, validation->faults, validation->capacity, validation->count + 1);
        copy = v->status == CLAST_OK ? clast_copy_text(v->context, text) : NULL;
    }
    if (copy == NULL) {
        v->status = is_listed ? CLAST_ERROR_OUT_OF_MEMORY : v->status;
        clast_free(v->context, pointer);
        return;
    }
    for (char *c = copy; *c != '\0'; c++) {
        *c = (unsigned char)*c < 32 || *c == 127 ? ' ' : *c;
    }
    validation->faults[validation->count++] = (clast_fault){codes[code].severity, codes[code].code, pointer, offset,
                                                            copy};
}

static void add_fault_at(clast_validator *v, clast_fault_code code, const clast_gltf_value *place, const char *format,
                         va_list arguments)
{
    char pointer[POINTER_SIZE], text[512];
    if (v->status != CLAST_OK) {
        return;
    }
    write_pointer(place, pointer);
    vsnprintf(text, sizeof text, format, arguments);
    char *copy = clast_copy_text(v->context, pointer);
    if (copy == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    add_fault(v, code, copy, 0, text);
}

void clast_validate_fault(clast_validator *v, clast_fault_code code, const clast_gltf_value *place, const char *format,
                          ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_fault_at(v, code, place, format, arguments);
    va_end(arguments);
}

void clast_validate_member_fault(clast_validator *v, clast_fault_code code, const clast_gltf_value *object,
                                 const char *name, const char *format, ...)
{
    clast_gltf_value place = clast_gltf_member(object, name);
    va_list arguments;
    va_start(arguments, format);
    add_fault_at(v, code, &place, format, arguments);
    va_end(arguments);
}

void clast_validate_byte_fault(clast_validator *v, clast_fault_code code, uint64_t offset, const char *format, ...)
{
    char text[512];
    if (v->status != CLAST_OK) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    add_fault(v, code, NULL, offset, text);
}

// -------------------------------------------------------------------------------------------------------------- values

static bool to_unsigned(const json_t *json, uint64_t *value)
{
    static const double exact_most = 9007199254740992.0; // 2^53
    if (json_is_integer(json) && json_integer_value(json) >= 0) {
        *value = (uint64_t)json_integer_value(json);
        return true;
    }
    double number = json_is_real(json) ? json_real_value(json) : -1.0;
    if (!(number >= 0.0 && number <= exact_most) || number != floor(number)) {
        return false;
    }
    *value = (uint64_t)number;
    return true;
}

bool clast_validate_unsigned(const clast_gltf_value *object, const char *name, uint64_t *value)
{
    return to_unsigned(json_object_get(object->json, name), value);
}

uint64_t clast_validate_unsigned_or(const clast_gltf_value *object, const char *name, uint64_t otherwise)
{
    uint64_t value;
    return clast_validate_unsigned(object, name, &value) ? value : otherwise;
}

double clast_validate_number_or(const clast_gltf_value *object, const char *name, double otherwise)
{
    const json_t *json = json_object_get(object->json, name);
    return json_is_number(json) ? json_number_value(json) : otherwise;
}

const char *clast_validate_text(const clast_gltf_value *object, const char *name)
{
    return json_string_value(json_object_get(object->json, name));
}

static uint32_t resolve(const clast_validator *v, const json_t *json, clast_validate_list list)
{
    uint64_t index;
    bool is_there = to_unsigned(json, &index) && index < clast_validate_size(v, list) && index < CLAST_NONE;
    return is_there ? (uint32_t)index : CLAST_NONE;
}

uint32_t clast_validate_index(const clast_validator *v, const clast_gltf_value *object, const char *name,
                              clast_validate_list list)
{
    return resolve(v, json_object_get(object->json, name), list);
}

uint32_t clast_validate_element_index(const clast_validator *v, const clast_gltf_value *array, size_t number,
                                      clast_validate_list list)
{
    return resolve(v, json_array_get(array->json, number), list);
}

bool clast_validate_declares(const clast_validator *v, const char *extension)
{
    const json_t *used = json_object_get(v->json, "extensionsUsed");
    for (size_t i = 0; i < json_array_size(used) && i < EXTENSIONS_MOST; i++) {
        const char *name = json_string_value(json_array_get(used, i));
        if (name != NULL && strcmp(name, extension) == 0) {
            return true;
        }
    }
    return false;
}

clast_gltf_value clast_validate_extension(const clast_gltf_value *object, clast_gltf_value *extensions,
                                          const char *name)
{
    *extensions = clast_gltf_member(object, "extensions");
    return clast_gltf_member(extensions, name);
}

// ---------------------------------------------------------------------------------------------------------------- glTF

static bool parse(clast_validator *v, clast_bytes text)
{
    static const uint64_t size_most = (uint64_t)1 << 31; // as the reader's
    json_error_t error;
    if (text.size > size_most) {
        clast_validate_byte_fault(v, CLAST_FAULT_FILE_LIMIT, 0, "%llu bytes of JSON: at most %llu are read",
                                  (unsigned long long)text.size, (unsigned long long)size_most);
        return false;
    }
    v->json = json_loadb((const char *)text.data, (size_t)text.size, JSON_REJECT_DUPLICATES, &error);
    v->root.json = v->json;
    if (v->json == NULL && json_error_code(&error) == json_error_out_of_memory) {
        v->status = clast_fail(v->context, CLAST_ERROR_OUT_OF_MEMORY, "%s: no memory for the JSON", v->path);
    } else if (v->json == NULL) {
        clast_validate_fault(v, CLAST_FAULT_INVALID_JSON, &v->root, "line %d, column %d: %s", error.line, error.column,
                             error.text);
    } else if (!json_is_object(v->json)) {
        clast_validate_fault(v, CLAST_FAULT_TYPE_MISMATCH, &v->root, "the JSON is not an object");
    }
    return v->json != NULL && json_is_object(v->json);
}

// The lists are members of the root; those of lights and variants, of an extension of the root.
static bool find_lists(clast_validator *v)
{
    static const char *const keys[] = {
#define KEY(name, key) key,
        CLAST_VALIDATE_LISTS(KEY)
#undef KEY
    };
    v->extensions = clast_gltf_member(&v->root, "extensions");
    v->holders[0] = clast_gltf_member(&v->extensions, "KHR_lights_punctual");
    v->holders[1] = clast_gltf_member(&v->extensions, "KHR_materials_variants");
    for (size_t i = 0; i < CLAST_VALIDATE_LIST_COUNT; i++) {
        const clast_gltf_value *holder = i == CLAST_VALIDATE_LIGHTS     ? &v->holders[0]
                                         : i == CLAST_VALIDATE_VARIANTS ? &v->holders[1]
                                                                        : &v->root;
        v->lists[i] = clast_gltf_member(holder, keys[i]);
        v->used[i] = clast_allocate_zeroed(v->context, json_array_size(v->lists[i].json), sizeof *v->used[i]);
        if (v->used[i] == NULL) {
            v->status = CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    return v->status == CLAST_OK;
}

static void validate_gltf(clast_validator *v, clast_bytes file)
{
    char extension[8];
    clast_path_extension(v->path, extension, sizeof extension);
    v->is_container = clast_bytes_begin_with(file, "glTF") || strcmp(extension, "glb") == 0;
    clast_bytes text = file;
    v->status = clast_scene_create(v->context, &v->scene);
    if (v->status == CLAST_OK) {
        clast_account_read(v->scene, file.size);
    }
    if (v->status == CLAST_OK && (!v->is_container || clast_validate_container(v, file, &text)) && parse(v, text) &&
        find_lists(v)) {
        v->is_quantised = clast_validate_declares(v, "KHR_mesh_quantization");
        clast_validate_walk(v);
        clast_validate_storage(v);
        clast_validate_meshes(v);
        clast_validate_links(v);
        clast_validate_data(v);
    }
    clast_validate_close_storage(v);
    clast_scene_destroy(v->scene);
    for (size_t i = 0; i < CLAST_VALIDATE_LIST_COUNT; i++) {
        clast_free(v->context, v->used[i]);
    }
    json_decref(v->json);
}

// --------------------------------------------------------------------------------------------------------- other files

static bool is_fault_of_file(clast_status status, clast_fault_code *code)
{
    *code = status == CLAST_ERROR_MALFORMED     ? CLAST_FAULT_FILE_MALFORMED
            : status == CLAST_ERROR_UNSUPPORTED ? CLAST_FAULT_FILE_UNSUPPORTED
            : status == CLAST_ERROR_LIMIT       ? CLAST_FAULT_FILE_LIMIT
                                                : CLAST_FAULT_IO_ERROR;
    return status == CLAST_ERROR_MALFORMED || status == CLAST_ERROR_UNSUPPORTED || status == CLAST_ERROR_LIMIT ||
           status == CLAST_ERROR_FILE_NOT_FOUND || status == CLAST_ERROR_FILE_READ;
}

// Reads an image or a scene; the reader's error is the fault.
static void validate_by_reading(clast_validator *v, clast_bytes file)
{
    clast_image image = {0};
    clast_status status = clast_decode_image(v->context, v->path, file.data, file.size, &image);
    clast_image_free(v->context, &image);
    if (status == CLAST_ERROR_UNSUPPORTED && !clast_is_image(file)) {
        clast_scene *scene = NULL;
        status = clast_scene_load(v->context, v->path, &scene);
        clast_scene_destroy(scene);
    }
    clast_fault_code code;
    if (is_fault_of_file(status, &code)) {
        clast_validate_byte_fault(v, code, 0, "%s", clast_context_error(v->context));
    } else if (status != CLAST_OK) {
        v->status = status;
    }
}

clast_status clast_validate(clast_context *context, const char *path, clast_validation **validation)
{
    if (context == NULL || path == NULL || validation == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *validation = NULL;
    clast_file_view file;
    clast_status status = clast_file_map(context, path, &file);
    if (status != CLAST_OK) {
        return status;
    }
    clast_validation *made = clast_allocate_zeroed(context, 1, sizeof *made);
    if (made == NULL) {
        clast_file_unmap(context, &file);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->context = context;
    clast_validator v = {.context = context, .validation = made, .path = path};
    clast_bytes bytes = {file.data, file.size};
    if (clast_is_gltf(path, bytes)) {
        validate_gltf(&v, bytes);
    } else {
        validate_by_reading(&v, bytes);
    }
    clast_file_unmap(context, &file);
    if (v.status != CLAST_OK) {
        clast_validation_destroy(made);
        return v.status;
    }
    *validation = made;
    return CLAST_OK;
}

void clast_validation_destroy(clast_validation *validation)
{
    if (validation == NULL) {
        return;
    }
    for (size_t i = 0; i < validation->count; i++) {
        clast_free(validation->context, (void *)validation->faults[i].pointer);
        clast_free(validation->context, (void *)validation->faults[i].text);
    }
    clast_free(validation->context, validation->faults);
    clast_free(validation->context, validation);
}

void clast_validation_count(const clast_validation *validation, uint64_t counts[CLAST_SEVERITY_COUNT])
{
    for (size_t i = 0; i < CLAST_SEVERITY_COUNT; i++) {
        counts[i] = validation != NULL ? validation->counts[i] : 0;
    }
}

size_t clast_validation_fault_count(const clast_validation *validation)
{
    return validation != NULL ? validation->count : 0;
}

const clast_fault *clast_validation_fault(const clast_validation *validation, size_t number)
{
    return validation != NULL && number < validation->count ? &validation->faults[number] : NULL;
}
