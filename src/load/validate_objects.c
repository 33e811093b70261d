// SPDX-License-Identifier: Apache-2.0
// What single objects mean, beyond what the tables can say. Faults of form have been told already: values of other types are
// passed over here.
#include <math.h>
#include <stdlib.h>

#include "load/validate.h"

static const double rotation_tolerance = 0.00769; // slightly more than the error of signed bytes
static const double matrix_tolerance = 0.0005;

static bool has(const clast_gltf_value *object, const char *name)
{
    return json_object_get(object->json, name) != NULL;
}

// Reads an array of so many numbers.
static bool read_numbers(const clast_gltf_value *object, const char *name, size_t count, double *numbers)
{
    const json_t *array = json_object_get(object->json, name);
    for (size_t i = 0; i < count; i++) {
        const json_t *element = json_array_get(array, i);
        if (!json_is_number(element)) {
            return false;
        }
        numbers[i] = json_number_value(element);
    }
    return json_array_size(array) == count;
}

// ------------------------------------------------------------------------------------------------------ asset, extensions

// major.minor, digits only.
static bool read_version(clast_validator *v, const clast_gltf_value *asset, const char *name, unsigned long version[2])
{
    const char *text = clast_validate_text(asset, name);
    if (text == NULL) {
        return false;
    }
    size_t major = strspn(text, "0123456789"), minor = text[major] == '.' ? strspn(text + major + 1, "0123456789") : 0;
    if (major == 0 || minor == 0 || text[major + 1 + minor] != '\0') {
        clast_validate_member_fault(v, CLAST_FAULT_PATTERN_MISMATCH, asset, name, "\"%.40s\": expected such as 2.0",
                                    text);
        return false;
    }
    version[0] = strtoul(text, NULL, 10);
    version[1] = strtoul(text + major + 1, NULL, 10);
    return true;
}

void clast_validate_asset(clast_validator *v, const clast_gltf_value *value)
{
    unsigned long version[2], least[2];
    if (!read_version(v, value, "version", version)) {
        return;
    }
    if (version[0] != 2) {
        clast_validate_member_fault(v, CLAST_FAULT_UNKNOWN_ASSET_MAJOR_VERSION, value, "version",
                                    "version %lu: expected 2", version[0]);
    } else if (version[1] > 0) {
        clast_validate_member_fault(v, CLAST_FAULT_UNKNOWN_ASSET_MINOR_VERSION, value, "version",
                                    "version 2.%lu: 2.0 is known", version[1]);
    }
    if (read_version(v, value, "minVersion", least) &&
        (least[0] > version[0] || (least[0] == version[0] && least[1] > version[1]))) {
        clast_validate_member_fault(v, CLAST_FAULT_ASSET_MIN_VERSION_GREATER_THAN_VERSION, value, "minVersion",
                                    "%lu.%lu is above the version", least[0], least[1]);
    }
}

bool clast_validate_knows_extension(const char *name)
{
    for (size_t i = 0; i < clast_rule_extension_count; i++) {
        if (strcmp(clast_rule_extensions[i].name, name) == 0) {
            return true;
        }
    }
    return false;
}

static bool list_has(const json_t *list, const char *name)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *text = json_string_value(json_array_get(list, i));
        if (text != NULL && strcmp(text, name) == 0) {
            return true;
        }
    }
    return false;
}

void clast_validate_extension_lists(clast_validator *v, const clast_gltf_value *value)
{
    clast_gltf_value used = clast_gltf_member(value, "extensionsUsed"),
                     needed = clast_gltf_member(value, "extensionsRequired");
    for (size_t i = 0; i < clast_gltf_size(&used); i++) {
        clast_gltf_value element = clast_gltf_element(&used, i);
        const char *name = json_string_value(element.json);
        if (name == NULL) {
            continue;
        }
        size_t prefix = strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789");
        if (prefix == 0 || name[prefix] != '_' || name[prefix + 1] == '\0') {
            clast_validate_fault(v, CLAST_FAULT_INVALID_EXTENSION_NAME_FORMAT, &element,
                                 "\"%.80s\": expected PREFIX_name", name);
        }
        if (!clast_validate_knows_extension(name)) {
            clast_validate_fault(v, CLAST_FAULT_UNSUPPORTED_EXTENSION, &element, "the extension %.80s is not checked",
                                 name);
        }
        if (strcmp(name, "KHR_mesh_quantization") == 0 && !list_has(needed.json, name)) {
            clast_validate_fault(v, CLAST_FAULT_NON_REQUIRED_EXTENSION, &element,
                                 "the extension %.80s cannot be optional", name);
        }
    }
    for (size_t i = 0; i < clast_gltf_size(&needed); i++) {
        clast_gltf_value element = clast_gltf_element(&needed, i);
        const char *name = json_string_value(element.json);
        if (name != NULL && !list_has(used.json, name)) {
            clast_validate_fault(v, CLAST_FAULT_UNUSED_EXTENSION_REQUIRED, &element,
                                 "%.80s is required, and not among extensionsUsed", name);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------ accessors

static void check_bound(clast_validator *v, const clast_gltf_value *accessor, const char *name, size_t components)
{
    static const struct {
        double least, most;
    } ranges[] = {{-128, 127}, {0, 255}, {-32768, 32767}, {0, 65535}, {0, 0}, {0, 4294967295.0}};
    clast_gltf_value bound = clast_gltf_member(accessor, name);
    uint64_t component = clast_validate_unsigned_or(accessor, "componentType", 0);
    if (!json_is_array(bound.json)) {
        return;
    }
    if (clast_gltf_size(&bound) != components) {
        clast_validate_fault(v, CLAST_FAULT_ARRAY_LENGTH_NOT_IN_LIST, &bound, "%zu elements: expected %zu",
                             clast_gltf_size(&bound), components);
    }
    for (size_t i = 0; component >= 5120 && component <= 5125 && i < clast_gltf_size(&bound); i++) {
        clast_gltf_value element = clast_gltf_element(&bound, i);
        double number = json_number_value(element.json);
        if (json_is_number(element.json) && (number < ranges[component - 5120].least ||
                                             number > ranges[component - 5120].most || number != floor(number))) {
            clast_validate_fault(v, CLAST_FAULT_INVALID_GL_VALUE, &element, "%.9g does not fit the component's type",
                                 number);
        }
    }
}

void clast_validate_accessor_object(clast_validator *v, const clast_gltf_value *value)
{
    uint32_t rows, columns;
    const char *type = clast_validate_text(value, "type");
    uint64_t component = clast_validate_unsigned_or(value, "componentType", 0);
    uint64_t offset = clast_validate_unsigned_or(value, "byteOffset", 0);
    uint32_t size = clast_validate_component_size(component);
    if (json_is_true(json_object_get(value->json, "normalized")) && (component == 5125 || component == 5126)) {
        clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_NORMALIZED_INVALID, value, "normalized",
                                    "only integers of 8 and 16 bits can be normalised");
    }
    if (type == NULL || size == 0 || !clast_validate_type(type, &columns, &rows)) {
        return;
    }
    check_bound(v, value, "min", (size_t)rows * columns);
    check_bound(v, value, "max", (size_t)rows * columns);
    if (columns > 1 && offset % 4 != 0) {
        clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_MATRIX_ALIGNMENT, value, "byteOffset",
                                    "%llu: expected a multiple of 4, as matrices have it", (unsigned long long)offset);
    } else if (columns == 1 && offset % size != 0) {
        clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_OFFSET_ALIGNMENT, value, "byteOffset",
                                    "%llu: expected a multiple of the component's %u bytes", (unsigned long long)offset,
                                    size);
    }
}

void clast_validate_view_object(clast_validator *v, const clast_gltf_value *value)
{
    enum { INDICES = 34963 };
    uint64_t stride = clast_validate_unsigned_or(value, "byteStride", 0);
    uint64_t length = clast_validate_unsigned_or(value, "byteLength", UINT64_MAX);
    if (stride % 4 != 0) {
        clast_validate_member_fault(v, CLAST_FAULT_VALUE_MULTIPLE_OF, value, "byteStride",
                                    "%llu: expected a multiple of 4", (unsigned long long)stride);
    }
    if (stride > length) {
        clast_validate_member_fault(v, CLAST_FAULT_BUFFER_VIEW_TOO_BIG_BYTE_STRIDE, value, "byteStride",
                                    "%llu is above the byteLength of %llu", (unsigned long long)stride,
                                    (unsigned long long)length);
    }
    if (stride != 0 && clast_validate_unsigned_or(value, "target", 0) == INDICES) {
        clast_validate_member_fault(v, CLAST_FAULT_BUFFER_VIEW_INVALID_BYTE_STRIDE, value, "byteStride",
                                    "only views of vertices can have one");
    }
}

// -------------------------------------------------------------------------------------------------- cameras and lights

void clast_validate_orthographic(clast_validator *v, const clast_gltf_value *value)
{
    static const char *const names[] = {"xmag", "ymag"};
    for (int i = 0; i < 2; i++) {
        double number = clast_validate_number_or(value, names[i], 1.0);
        if (number == 0.0) {
            clast_validate_member_fault(v, CLAST_FAULT_CAMERA_XMAG_YMAG_ZERO, value, names[i],
                                        "expected another than zero");
        } else if (number < 0.0) {
            clast_validate_member_fault(v, CLAST_FAULT_CAMERA_XMAG_YMAG_NEGATIVE, value, names[i],
                                        "%.9g: expected a positive number", number);
        }
    }
    double near_plane = clast_validate_number_or(value, "znear", -INFINITY);
    if (clast_validate_number_or(value, "zfar", INFINITY) <= near_plane) {
        clast_validate_fault(v, CLAST_FAULT_CAMERA_ZFAR_LEQUAL_ZNEAR, value, "zfar is not above znear");
    }
}

void clast_validate_perspective(clast_validator *v, const clast_gltf_value *value)
{
    static const double half_turn = 3.14159265358979;
    double near_plane = clast_validate_number_or(value, "znear", -INFINITY);
    if (clast_validate_number_or(value, "zfar", INFINITY) <= near_plane) {
        clast_validate_fault(v, CLAST_FAULT_CAMERA_ZFAR_LEQUAL_ZNEAR, value, "zfar is not above znear");
    }
    if (clast_validate_number_or(value, "yfov", 1.0) >= half_turn) {
        clast_validate_member_fault(v, CLAST_FAULT_CAMERA_YFOV_GEQUAL_PI, value, "yfov",
                                    "expected less than half a turn");
    }
}

void clast_validate_camera(clast_validator *v, const clast_gltf_value *value)
{
    if (has(value, "orthographic") == has(value, "perspective")) {
        clast_validate_fault(v, CLAST_FAULT_ONE_OF_MISMATCH, value, "expected either orthographic or perspective");
        return;
    }
    const char *type = clast_validate_text(value, "type");
    if (type != NULL && (strcmp(type, "orthographic") == 0 || strcmp(type, "perspective") == 0) && !has(value, type)) {
        clast_validate_fault(v, CLAST_FAULT_UNDEFINED_PROPERTY, value, "no %s, as the type says", type);
    }
}

void clast_validate_light(clast_validator *v, const clast_gltf_value *value)
{
    const char *type = clast_validate_text(value, "type");
    clast_gltf_value spot = clast_gltf_member(value, "spot");
    if (type == NULL) {
        return;
    }
    if (strcmp(type, "spot") != 0 && spot.json != NULL) {
        clast_validate_fault(v, CLAST_FAULT_EXTRA_PROPERTY, &spot, "of no effect for a light of another type");
    } else if (strcmp(type, "spot") == 0 && spot.json == NULL) {
        clast_validate_fault(v, CLAST_FAULT_UNDEFINED_PROPERTY, value, "no spot, as the type says");
    }
    double inner = clast_validate_number_or(&spot, "innerConeAngle", 0.0);
    double outer = clast_validate_number_or(&spot, "outerConeAngle", 0.785398163397448);
    if (json_is_object(spot.json) && outer <= inner) {
        clast_validate_fault(v, CLAST_FAULT_KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES, &spot,
                             "the outer angle of %.9g is not above the inner one of %.9g", outer, inner);
    }
}

// -------------------------------------------------------------------------------------------------- images, materials

void clast_validate_image_object(clast_validator *v, const clast_gltf_value *value)
{
    if (has(value, "uri") == has(value, "bufferView")) {
        clast_validate_fault(v, CLAST_FAULT_ONE_OF_MISMATCH, value, "expected either uri or bufferView");
    } else if (has(value, "bufferView") && !has(value, "mimeType")) {
        clast_validate_member_fault(v, CLAST_FAULT_UNSATISFIED_DEPENDENCY, value, "bufferView", "needs mimeType");
    }
}

void clast_validate_material(clast_validator *v, const clast_gltf_value *value)
{
    const char *mode = clast_validate_text(value, "alphaMode");
    if (has(value, "alphaCutoff") && (mode == NULL || strcmp(mode, "MASK") != 0)) {
        clast_validate_member_fault(v, CLAST_FAULT_MATERIAL_ALPHA_CUTOFF_INVALID_MODE, value, "alphaCutoff",
                                    "of no effect without the alphaMode MASK");
    }
}

// The material around an extension of it, and the extensions beside.
static const clast_gltf_value *material_around(const clast_gltf_value *extension)
{
    return extension->around->around;
}

void clast_validate_ior(clast_validator *v, const clast_gltf_value *value)
{
    double ior = clast_validate_number_or(value, "ior", 1.5);
    if (ior != 0.0 && !(ior >= 1.0)) {
        clast_validate_member_fault(v, CLAST_FAULT_VALUE_NOT_IN_RANGE, value, "ior", "%.9g: expected 0, or 1 and more",
                                    ior);
    }
}

void clast_validate_volume(clast_validator *v, const clast_gltf_value *value)
{
    const clast_gltf_value *material = material_around(value);
    if (!has(value->around, "KHR_materials_transmission") &&
        !has(value->around, "KHR_materials_diffuse_transmission")) {
        clast_validate_fault(v, CLAST_FAULT_KHR_MATERIALS_VOLUME_NO_TRANSMISSION, value,
                             "no extension lets light into the volume");
    }
    if (json_is_true(json_object_get(material->json, "doubleSided")) &&
        clast_validate_number_or(value, "thicknessFactor", 0.0) > 0.0) {
        clast_validate_fault(v, CLAST_FAULT_KHR_MATERIALS_VOLUME_DOUBLE_SIDED, value,
                             "a volume with a double-sided surface");
    }
}

void clast_validate_dispersion(clast_validator *v, const clast_gltf_value *value)
{
    if (!has(value->around, "KHR_materials_volume")) {
        clast_validate_fault(v, CLAST_FAULT_KHR_MATERIALS_DISPERSION_NO_VOLUME, value, "dispersion without a volume");
    }
}

void clast_validate_anisotropy(clast_validator *v, const clast_gltf_value *value)
{
    clast_gltf_value normals = clast_gltf_member(material_around(value), "normalTexture");
    clast_gltf_value texture = clast_gltf_member(value, "anisotropyTexture");
    if (json_is_object(normals.json) && json_is_object(texture.json) &&
        clast_validate_unsigned_or(&normals, "texCoord", 0) != clast_validate_unsigned_or(&texture, "texCoord", 0)) {
        clast_validate_fault(v, CLAST_FAULT_KHR_MATERIALS_ANISOTROPY_ANISOTROPY_TEXTURE_TEXCOORD, &texture,
                             "expected the coordinates of the normal texture");
    }
}

// ---------------------------------------------------------------------------------------------------------------- nodes

// Whether a matrix is a translation, a rotation and scales along its axes: these are at right angles.
static bool is_decomposable(const double m[16])
{
    if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
        return false;
    }
    double lengths[3];
    for (int i = 0; i < 3; i++) {
        const double *a = m + 4 * i;
        lengths[i] = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        if (!(lengths[i] > 0.0)) {
            return false;
        }
    }
    for (int i = 0; i < 3; i++) {
        const double *a = m + 4 * i, *b = m + 4 * ((i + 1) % 3);
        double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        if (!(fabs(dot) <= matrix_tolerance * lengths[i] * lengths[(i + 1) % 3])) {
            return false;
        }
    }
    return true;
}

static void check_matrix(clast_validator *v, const clast_gltf_value *node)
{
    double m[16];
    if (!has(node, "matrix")) {
        return;
    }
    if (has(node, "translation") || has(node, "rotation") || has(node, "scale")) {
        clast_validate_member_fault(v, CLAST_FAULT_NODE_MATRIX_TRS, node, "matrix",
                                    "beside translation, rotation or scale");
    }
    if (!read_numbers(node, "matrix", 16, m)) {
        return;
    }
    bool is_default = true;
    for (int i = 0; i < 16; i++) {
        is_default = is_default && m[i] == (i % 5 == 0 ? 1.0 : 0.0);
    }
    if (is_default) {
        clast_validate_member_fault(v, CLAST_FAULT_NODE_MATRIX_DEFAULT, node, "matrix", "should be left out");
    } else if (!is_decomposable(m)) {
        clast_validate_member_fault(v, CLAST_FAULT_NODE_MATRIX_NON_TRS, node, "matrix",
                                    "no translation, rotation and scale make this");
    }
}

void clast_validate_node_object(clast_validator *v, const clast_gltf_value *value)
{
    double q[4];
    check_matrix(v, value);
    if (read_numbers(value, "rotation", 4, q) &&
        fabs(sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) - 1.0) > rotation_tolerance) {
        clast_validate_member_fault(v, CLAST_FAULT_ROTATION_NON_UNIT, value, "rotation", "not of unit length");
    }
    if (json_object_size(value->json) == (has(value, "name") ? 1u : 0u) + (has(value, "extras") ? 1u : 0u)) {
        clast_validate_fault(v, CLAST_FAULT_NODE_EMPTY, value, "a node without content");
    }
}

// ---------------------------------------------------------------------------------------------------------- extensions

void clast_validate_channel_target(clast_validator *v, const clast_gltf_value *value)
{
    const char *path = clast_validate_text(value, "path");
    if (path != NULL && strcmp(path, "pointer") == 0 && !clast_validate_declares(v, "KHR_animation_pointer")) {
        clast_validate_member_fault(v, CLAST_FAULT_VALUE_NOT_IN_LIST, value, "path",
                                    "expected translation, rotation, scale or weights without KHR_animation_pointer");
    }
}

void clast_validate_pointer_target(clast_validator *v, const clast_gltf_value *value)
{
    const clast_gltf_value *target = value->around->around;
    const char *path = clast_validate_text(target, "path"), *pointer = clast_validate_text(value, "pointer");
    if (has(target, "node")) {
        clast_validate_fault(v, CLAST_FAULT_KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE, value,
                             "expected no node beside the pointer");
    }
    if (path != NULL && strcmp(path, "pointer") != 0) {
        clast_validate_fault(v, CLAST_FAULT_KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH, value,
                             "path \"%.40s\": expected pointer", path);
    }
    bool is_pointer = pointer != NULL && (pointer[0] == '/' || pointer[0] == '\0');
    for (const char *c = pointer; is_pointer && *c != '\0'; c++) {
        is_pointer = *c != '~' || c[1] == '0' || c[1] == '1';
    }
    if (pointer != NULL && !is_pointer) {
        clast_validate_member_fault(v, CLAST_FAULT_PATTERN_MISMATCH, value, "pointer",
                                    "\"%.100s\": expected a JSON pointer", pointer);
    }
}

void clast_validate_variant_mappings(clast_validator *v, const clast_gltf_value *value)
{
    clast_gltf_value mappings = clast_gltf_member(value, "mappings");
    bool *seen = clast_allocate_zeroed(v->context, clast_validate_size(v, CLAST_VALIDATE_VARIANTS), sizeof *seen);
    if (seen == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
        return;
    }
    for (size_t i = 0; i < clast_gltf_size(&mappings); i++) {
        clast_gltf_value mapping = clast_gltf_element(&mappings, i), variants = clast_gltf_member(&mapping, "variants");
        for (size_t k = 0; k < clast_gltf_size(&variants); k++) {
            uint32_t variant = clast_validate_element_index(v, &variants, k, CLAST_VALIDATE_VARIANTS);
            clast_gltf_value element = clast_gltf_element(&variants, k);
            if (variant != CLAST_NONE && seen[variant]) {
                clast_validate_fault(v, CLAST_FAULT_KHR_MATERIALS_VARIANTS_NON_UNIQUE_VARIANT, &element,
                                     "the variant has a material already");
            } else if (variant != CLAST_NONE) {
                seen[variant] = true;
            }
        }
    }
    clast_free(v->context, seen);
}
