// SPDX-License-Identifier: Apache-2.0
// Meshes: attributes, indices, morph targets (section 3.7.2), and whether they have what their materials need.
#include <stdlib.h>

#include "load/validate.h"

// -------------------------------------------------------------------------------------------------------- attribute names

typedef enum semantic {
    POSITION,
    NORMAL,
    TANGENT,
    COORDINATES,
    COLOUR,
    JOINTS,
    WEIGHTS,
    OWN, // begins with an underscore
    SEMANTIC_COUNT,
} semantic;

// What a set of attributes has: for numbered ones, how many, and the least number above all.
typedef struct attribute_set {
    uint32_t counts[SEMANTIC_COUNT], ends[SEMANTIC_COUNT];
} attribute_set;

static const char *const numbered_names[SEMANTIC_COUNT] = {
    [COORDINATES] = "TEXCOORD_", [COLOUR] = "COLOR_", [JOINTS] = "JOINTS_", [WEIGHTS] = "WEIGHTS_"};

// What an attribute's name stands for; false where it is no such name. Numbers have no leading zeros.
static bool parse_name(const char *name, bool is_target, semantic *meaning, uint32_t *number)
{
    static const char *const plain[] = {"POSITION", "NORMAL", "TANGENT"};
    *number = 0;
    if (name[0] == '_') {
        *meaning = OWN;
        return true;
    }
    for (int i = POSITION; i <= TANGENT; i++) {
        if (strcmp(plain[i], name) == 0) {
            *meaning = (semantic)i;
            return true;
        }
    }
    for (int i = COORDINATES; i <= (is_target ? COLOUR : WEIGHTS); i++) {
        size_t length = strlen(numbered_names[i]), digits = 0;
        if (strncmp(name, numbered_names[i], length) != 0) {
            continue;
        }
        digits = strspn(name + length, "0123456789");
        if (digits == 0 || digits > 6 || name[length + digits] != '\0' || (name[length] == '0' && digits > 1)) {
            return false;
        }
        *meaning = (semantic)i;
        *number = (uint32_t)strtoul(name + length, NULL, 10);
        return true;
    }
    return false;
}

// Counts the attributes, and tells of names that are none.
static attribute_set read_names(clast_validator *v, const clast_gltf_value *map, bool is_target)
{
    attribute_set set = {{0}, {0}};
    const char *name;
    json_t *json;
    json_object_foreach(map->json, name, json)
    {
        semantic meaning;
        uint32_t number;
        clast_gltf_value place = {.around = map, .name = name, .json = json};
        if (!parse_name(name, is_target, &meaning, &number)) {
            clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_INVALID_ATTRIBUTE, &place,
                                 "no such attribute is defined");
            continue;
        }
        set.counts[meaning]++;
        set.ends[meaning] = number + 1 > set.ends[meaning] ? number + 1 : set.ends[meaning];
    }
    for (int i = COORDINATES; i <= WEIGHTS; i++) {
        if (set.ends[i] != set.counts[i]) {
            clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_INDEXED_SEMANTIC_CONTINUITY, map,
                                 "%u attributes %s0 and up, the last of number %u: expected no gap", set.counts[i],
                                 numbered_names[i], set.ends[i] - 1);
        }
    }
    return set;
}

static void check_names(clast_validator *v, const clast_gltf_value *attributes, const attribute_set *set)
{
    if (set->counts[POSITION] == 0) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_NO_POSITION, attributes, "no POSITION");
    }
    if (set->counts[TANGENT] != 0 && set->counts[NORMAL] == 0) {
        clast_validate_member_fault(v, CLAST_FAULT_MESH_PRIMITIVE_TANGENT_WITHOUT_NORMAL, attributes, "TANGENT",
                                    "TANGENT without NORMAL");
    }
    if (set->counts[JOINTS] != set->counts[WEIGHTS]) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH, attributes,
                             "%u sets of joints, %u of weights", set->counts[JOINTS], set->counts[WEIGHTS]);
    }
}

// -------------------------------------------------------------------------------------------------------------- formats

// A bit for each type of component, plain or normalised.
#define PLAIN(type) (1u << (CLAST_GLTF_##type - CLAST_GLTF_BYTE))
#define NORMALISED(type) (PLAIN(type) << 8)
#define BOTH(type) (PLAIN(type) | NORMALISED(type))
#define FRACTIONS (PLAIN(FLOAT) | NORMALISED(UNSIGNED_BYTE) | NORMALISED(UNSIGNED_SHORT))
#define SIGNED_FRACTIONS (NORMALISED(BYTE) | NORMALISED(SHORT))
#define SMALL (BOTH(BYTE) | BOTH(UNSIGNED_BYTE) | BOTH(SHORT) | BOTH(UNSIGNED_SHORT))

// What a name takes: a bit for each number of components, types, and those that KHR_mesh_quantization adds.
typedef struct format_rule {
    uint32_t components, types, quantised;
} format_rule;

static const format_rule base_formats[SEMANTIC_COUNT] = {
    [POSITION] = {1u << 3, PLAIN(FLOAT), SMALL},
    [NORMAL] = {1u << 3, PLAIN(FLOAT), SIGNED_FRACTIONS},
    [TANGENT] = {1u << 4, PLAIN(FLOAT), SIGNED_FRACTIONS},
    [COORDINATES] = {1u << 2, FRACTIONS, SMALL},
    [COLOUR] = {1u << 3 | 1u << 4, FRACTIONS, 0},
    [JOINTS] = {1u << 4, PLAIN(UNSIGNED_BYTE) | PLAIN(UNSIGNED_SHORT), 0},
    [WEIGHTS] = {1u << 4, FRACTIONS, 0},
};
static const format_rule target_formats[SEMANTIC_COUNT] = {
    [POSITION] = {1u << 3, PLAIN(FLOAT), BOTH(BYTE) | BOTH(SHORT)},
    [NORMAL] = {1u << 3, PLAIN(FLOAT), SIGNED_FRACTIONS},
    [TANGENT] = {1u << 3, PLAIN(FLOAT), SIGNED_FRACTIONS},
    [COORDINATES] = {1u << 2, FRACTIONS | SIGNED_FRACTIONS, BOTH(BYTE) | BOTH(SHORT)},
    [COLOUR] = {1u << 3 | 1u << 4, FRACTIONS | SIGNED_FRACTIONS, 0},
};

static void check_format(clast_validator *v, const clast_gltf_value *place, const clast_validate_accessor *accessor,
                         semantic meaning, bool is_target)
{
    const format_rule *rule = is_target ? &target_formats[meaning] : &base_formats[meaning];
    uint32_t types = rule->types | (v->is_quantised ? rule->quantised : 0);
    uint32_t type = 1u << (accessor->component - CLAST_GLTF_BYTE) << (accessor->is_normalised ? 8 : 0);
    if (meaning == OWN) {
        if (accessor->component == CLAST_GLTF_UNSIGNED_INT) {
            clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_UNSIGNED_INT, place,
                                 "attributes cannot be of 32-bit integers");
        }
    } else if (accessor->columns != 1 || (rule->components >> accessor->rows & 1) == 0 || (types & type) == 0) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT, place,
                             "%u components of type %u%s: not what this attribute takes", accessor->components,
                             accessor->component, accessor->is_normalised ? ", normalised" : "");
    }
}

static void check_alignment(clast_validator *v, const clast_gltf_value *place, const clast_validate_accessor *accessor,
                            uint32_t index)
{
    if (accessor->view == CLAST_NONE) {
        return;
    }
    clast_validate_view *view = &v->views[accessor->view];
    if (accessor->offset % 4 != 0 || view->offset % 4 != 0 || accessor->stride % 4 != 0) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_ACCESSOR_UNALIGNED, place,
                             "vertices every %llu bytes from byte %llu of byte %llu: expected multiples of 4",
                             (unsigned long long)accessor->stride, (unsigned long long)accessor->offset,
                             (unsigned long long)view->offset);
    }
    if (view->stride == 0 && view->first_user != CLAST_NONE && view->first_user != index) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_ACCESSOR_WITHOUT_BYTESTRIDE, place,
                             "view %u has no byteStride, and accessor %u uses it too", accessor->view,
                             view->first_user);
    }
    view->first_user = view->first_user == CLAST_NONE ? index : view->first_user;
}

// --------------------------------------------------------------------------------------------------------- primitives

typedef struct primitive_check {
    clast_validator *v;
    clast_gltf_value value, attributes, targets;
    attribute_set set;
    uint64_t vertices; // of the first sound attribute; 0 where there is none
} primitive_check;

static void check_bounds(clast_validator *v, const clast_gltf_value *place, uint32_t index)
{
    clast_gltf_value accessor = clast_validate_entry(v, CLAST_VALIDATE_ACCESSORS, index);
    if (json_object_get(accessor.json, "min") == NULL || json_object_get(accessor.json, "max") == NULL) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_POSITION_ACCESSOR_WITHOUT_BOUNDS, place,
                             "positions need min and max");
    }
}

static void check_attribute(primitive_check *c, const clast_gltf_value *place, const clast_gltf_value *base)
{
    clast_validator *v = c->v;
    const clast_gltf_value *map = place->around;
    uint32_t index = clast_validate_index(v, map, place->name, CLAST_VALIDATE_ACCESSORS), number;
    semantic meaning;
    if (index == CLAST_NONE || v->accessors[index].components == 0) {
        return;
    }
    const clast_validate_accessor *accessor = &v->accessors[index];
    bool is_known = parse_name(place->name, base != NULL, &meaning, &number);
    clast_validate_use(v, place, index, CLAST_USAGE_VERTICES);
    if (is_known && meaning == POSITION) {
        check_bounds(v, place, index);
    }
    if (is_known) {
        check_format(v, place, accessor, meaning, base != NULL);
    }
    check_alignment(v, place, accessor, index);
    if (base != NULL) {
        uint32_t first = clast_validate_index(v, base, place->name, CLAST_VALIDATE_ACCESSORS);
        if (first != CLAST_NONE && v->accessors[first].count != accessor->count) {
            clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT, place,
                                 "%llu vertices, %llu without the target", (unsigned long long)accessor->count,
                                 (unsigned long long)v->accessors[first].count);
        }
    } else if (c->vertices == 0) {
        c->vertices = accessor->count;
    } else if (c->vertices != accessor->count) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT, place,
                             "%llu vertices, %llu of others", (unsigned long long)accessor->count,
                             (unsigned long long)c->vertices);
    }
}

static void check_attributes(primitive_check *c, const clast_gltf_value *map, const clast_gltf_value *base)
{
    const char *name;
    json_t *json;
    json_object_foreach(map->json, name, json)
    {
        clast_gltf_value place = {.around = map, .name = name, .json = json};
        if (base != NULL && json_object_get(base->json, name) == NULL) {
            clast_validate_fault(c->v, CLAST_FAULT_MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR, &place,
                                 "the primitive has no such attribute");
        } else {
            check_attribute(c, &place, base);
        }
    }
}

static void check_mode(primitive_check *c, uint64_t count)
{
    enum { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, STRIP, FAN };
    uint64_t mode = clast_validate_unsigned_or(&c->value, "mode", TRIANGLES);
    bool is_odd = (mode == LINES && (count % 2 != 0 || count < 2)) ||
                  ((mode == LINE_LOOP || mode == LINE_STRIP) && count < 2) ||
                  (mode == TRIANGLES && (count % 3 != 0 || count < 3)) || ((mode == STRIP || mode == FAN) && count < 3);
    if (count != 0 && is_odd) {
        clast_validate_fault(c->v, CLAST_FAULT_MESH_PRIMITIVE_INCOMPATIBLE_MODE, &c->value,
                             "%llu vertices or indices do not fit the mode %llu", (unsigned long long)count,
                             (unsigned long long)mode);
    }
}

static void check_indices(primitive_check *c)
{
    clast_validator *v = c->v;
    clast_gltf_value place = clast_gltf_member(&c->value, "indices");
    uint32_t index = clast_validate_index(v, &c->value, "indices", CLAST_VALIDATE_ACCESSORS);
    if (place.json == NULL) {
        check_mode(c, c->vertices);
        return;
    }
    if (index == CLAST_NONE || v->accessors[index].components == 0) {
        return;
    }
    const clast_validate_accessor *accessor = &v->accessors[index];
    bool is_integer = accessor->component == CLAST_GLTF_UNSIGNED_BYTE ||
                      accessor->component == CLAST_GLTF_UNSIGNED_SHORT ||
                      accessor->component == CLAST_GLTF_UNSIGNED_INT;
    clast_validate_use(v, &place, index, CLAST_USAGE_INDICES);
    if (accessor->view != CLAST_NONE && v->views[accessor->view].stride != 0) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_INDICES_ACCESSOR_WITH_BYTESTRIDE, &place,
                             "view %u has a byteStride", accessor->view);
    }
    if (accessor->components != 1 || !is_integer || accessor->is_normalised) {
        clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT, &place,
                             "%u components of type %u: expected single unsigned integers", accessor->components,
                             accessor->component);
    }
    check_mode(c, accessor->count);
}

// ----------------------------------------------------------------------------------------------------------- materials

static void check_coordinates(primitive_check *c, const clast_gltf_value *place, const clast_gltf_value *texture)
{
    clast_gltf_value extensions;
    clast_gltf_value transform = clast_validate_extension(texture, &extensions, "KHR_texture_transform");
    uint64_t set = clast_validate_unsigned_or(texture, "texCoord", 0);
    set = clast_validate_unsigned_or(&transform, "texCoord", set);
    if (set >= c->set.ends[COORDINATES]) {
        clast_validate_fault(c->v, CLAST_FAULT_MESH_PRIMITIVE_TOO_FEW_TEXCOORDS, place,
                             "the material's %.60s needs TEXCOORD_%llu", texture->name, (unsigned long long)set);
    }
}

static void check_textures(primitive_check *c, const clast_gltf_value *place, const clast_gltf_value *object)
{
    const char *name;
    json_t *json;
    json_object_foreach(object->json, name, json)
    {
        clast_gltf_value member = {.around = object, .name = name, .json = json};
        size_t length = strlen(name), ending = strlen("Texture");
        bool is_texture = length > ending && strcmp(name + length - ending, "Texture") == 0;
        if (is_texture && clast_validate_index(c->v, &member, "index", CLAST_VALIDATE_TEXTURES) != CLAST_NONE) {
            check_coordinates(c, place, &member);
        }
    }
}

static void check_material(primitive_check *c)
{
    clast_gltf_value place = clast_gltf_member(&c->value, "material");
    uint32_t index = clast_validate_index(c->v, &c->value, "material", CLAST_VALIDATE_MATERIALS);
    bool has_normal_map = false, has_anisotropy = false;
    if (index != CLAST_NONE) {
        clast_gltf_value material = clast_validate_entry(c->v, CLAST_VALIDATE_MATERIALS, index);
        clast_gltf_value surface = clast_gltf_member(&material, "pbrMetallicRoughness");
        clast_gltf_value extensions = clast_gltf_member(&material, "extensions");
        check_textures(c, &place, &surface);
        check_textures(c, &place, &material);
        const char *name;
        json_t *json;
        json_object_foreach(extensions.json, name, json)
        {
            clast_gltf_value extension = {.around = &extensions, .name = name, .json = json};
            if (clast_validate_knows_extension(name)) {
                check_textures(c, &place, &extension);
            }
        }
        clast_gltf_value anisotropy = clast_gltf_member(&extensions, "KHR_materials_anisotropy");
        has_normal_map = json_is_object(json_object_get(material.json, "normalTexture"));
        has_anisotropy = json_is_object(json_object_get(anisotropy.json, "anisotropyTexture"));
    }
    bool has_tangents = c->set.counts[TANGENT] != 0 && c->set.counts[NORMAL] != 0;
    if (has_normal_map && !has_tangents) {
        clast_validate_fault(
            c->v, CLAST_FAULT_MESH_PRIMITIVE_GENERATED_TANGENT_SPACE, &place,
            "the material has a normal texture, the primitive no tangents: programs make different ones");
    } else if (has_anisotropy && !has_tangents) {
        clast_validate_fault(c->v, CLAST_FAULT_MESH_PRIMITIVE_NO_TANGENT_SPACE, &place,
                             "the material needs tangents, which are not there and cannot be made");
    }
    if (!has_normal_map && !has_anisotropy && c->set.counts[TANGENT] != 0) {
        clast_validate_member_fault(c->v, CLAST_FAULT_UNUSED_MESH_TANGENT, &c->attributes, "TANGENT",
                                    "the material has no use for tangents");
    }
}

// -------------------------------------------------------------------------------------------------------------- meshes

static void check_primitive(clast_validator *v, const clast_gltf_value *primitives, size_t number)
{
    primitive_check c = {.v = v, .value = clast_gltf_element(primitives, number)};
    c.attributes = clast_gltf_member(&c.value, "attributes");
    c.targets = clast_gltf_member(&c.value, "targets");
    if (!json_is_object(c.attributes.json)) {
        return;
    }
    c.set = read_names(v, &c.attributes, false);
    if (json_object_size(c.attributes.json) > 0) {
        check_names(v, &c.attributes, &c.set);
    }
    check_attributes(&c, &c.attributes, NULL);
    for (size_t i = 0; i < clast_gltf_size(&c.targets); i++) {
        clast_gltf_value target = clast_gltf_element(&c.targets, i);
        read_names(v, &target, true);
        check_attributes(&c, &target, &c.attributes);
    }
    check_indices(&c);
    check_material(&c);
}

size_t clast_validate_target_count(const clast_gltf_value *mesh)
{
    clast_gltf_value primitives = clast_gltf_member(mesh, "primitives");
    clast_gltf_value first = clast_gltf_element(&primitives, 0);
    return json_array_size(json_object_get(first.json, "targets"));
}

bool clast_validate_has_joints(const clast_gltf_value *mesh)
{
    clast_gltf_value primitives = clast_gltf_member(mesh, "primitives");
    for (size_t i = 0; i < clast_gltf_size(&primitives); i++) {
        clast_gltf_value primitive = clast_gltf_element(&primitives, i);
        if (json_object_get(json_object_get(primitive.json, "attributes"), "JOINTS_0") != NULL) {
            return true;
        }
    }
    return false;
}

static void check_targets(clast_validator *v, const clast_gltf_value *mesh, const clast_gltf_value *primitives)
{
    size_t count = clast_validate_target_count(mesh);
    for (size_t i = 1; i < clast_gltf_size(primitives); i++) {
        clast_gltf_value primitive = clast_gltf_element(primitives, i),
                         targets = clast_gltf_member(&primitive, "targets");
        if (json_is_object(primitive.json) && clast_gltf_size(&targets) != count) {
            clast_validate_fault(v, CLAST_FAULT_MESH_PRIMITIVES_UNEQUAL_TARGETS_COUNT,
                                 targets.json != NULL ? &targets : &primitive,
                                 "%zu morph targets, %zu of the first primitive", clast_gltf_size(&targets), count);
        }
    }
    clast_gltf_value weights = clast_gltf_member(mesh, "weights");
    if (json_is_array(weights.json) && clast_gltf_size(&weights) != count) {
        clast_validate_fault(v, CLAST_FAULT_MESH_INVALID_WEIGHTS_COUNT, &weights, "%zu weights for %zu morph targets",
                             clast_gltf_size(&weights), count);
    }
}

void clast_validate_meshes(clast_validator *v)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_MESHES) && v->status == CLAST_OK; i++) {
        clast_gltf_value mesh = clast_validate_entry(v, CLAST_VALIDATE_MESHES, i);
        clast_gltf_value primitives = clast_gltf_member(&mesh, "primitives");
        check_targets(v, &mesh, &primitives);
        for (size_t k = 0; k < clast_gltf_size(&primitives) && v->status == CLAST_OK; k++) {
            check_primitive(v, &primitives, k);
        }
    }
}
