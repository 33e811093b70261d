// SPDX-License-Identifier: Apache-2.0
// What the accessors hold. Each accessor is read once, whatever the number of its uses; a kind of fault is told once for each, with
// the first element and how many there are.
#include <math.h>

#include "load/validate.h"

enum { COMPONENTS_MOST = 16, SETS_MOST = 64 };

static const double vector_tolerance = 0.00674,
                    quaternion_tolerance = 0.00769; // slightly more than the error of signed bytes
static const double weight_step = 0.0039216;        // of unsigned bytes, slightly more

// What elements are checked for, beside being finite and within their bounds.
typedef enum role {
    ROLE_UNIT = 1,    // vectors of unit length: the first three components
    ROLE_SIGN = 2,    // the fourth is 1 or -1
    ROLE_CLAMPED = 4, // 0 to 1
    ROLE_TIMES = 8,   // not negative, and growing
    ROLE_QUATERNIONS = 16,
    ROLE_MATRICES = 32, // the last row is 0 0 0 1
    ROLE_INDICES = 64,
    ROLE_SPLINES = 256, // of three elements, the second is a value
} role;

// Who uses an accessor: an object of a list, a part of it, and the name there. The name is null where nobody does.
typedef struct use_place {
    clast_validate_list list;
    size_t item;
    const char *part; // null: the object itself
    size_t number;
    bool is_attribute;
    const char *name;
} use_place;

// What is known of an accessor after reading it.
typedef struct accessor_facts {
    uint32_t roles;
    use_place use; // the first
    bool is_read;  // its elements could be had
    bool has_weights_checked;
    double most;         // the largest component
    uint64_t most_place; // its element
    uint64_t degenerate; // triangles of the list that name a vertex twice
} accessor_facts;

// -------------------------------------------------------------------------------------------------------------- reading

static uint32_t load_unsigned(const unsigned char *at, uint32_t size)
{
    return size == 1 ? at[0] : size == 2 ? (uint32_t)at[0] | (uint32_t)at[1] << 8 : clast_load_word(at);
}

static double load_component(const clast_validate_accessor *accessor, const unsigned char *at)
{
    uint32_t bits = load_unsigned(at, accessor->component_size);
    float value;
    switch (accessor->component) {
    case CLAST_GLTF_BYTE: return (int8_t)bits;
    case CLAST_GLTF_SHORT: return (int16_t)bits;
    case CLAST_GLTF_FLOAT: memcpy(&value, &bits, sizeof value); return (double)value;
    default: return bits;
    }
}

// A cursor over the elements; replaced ones are in growing order.
typedef struct element_reader {
    const clast_validate_accessor *accessor;
    uint64_t next; // replaced element
} element_reader;

static bool can_read(const clast_validate_accessor *accessor)
{
    bool has_sparse = accessor->sparse_count != 0;
    bool has_sparse_bytes = accessor->sparse_indices.data != NULL && accessor->sparse_values.data != NULL;
    bool has_bytes = accessor->bytes.data != NULL || (accessor->view == CLAST_NONE && has_sparse);
    return accessor->components != 0 && has_bytes && (!has_sparse || has_sparse_bytes);
}

static void read_element(element_reader *reader, uint64_t number, double *components)
{
    const clast_validate_accessor *a = reader->accessor;
    const unsigned char *at = a->bytes.data != NULL ? a->bytes.data + number * a->stride : NULL;
    uint32_t size = a->sparse_component_size;
    if (reader->next < a->sparse_count && load_unsigned(a->sparse_indices.data + reader->next * size, size) == number) {
        at = a->sparse_values.data + reader->next * a->element_size;
        reader->next++;
    }
    for (uint32_t column = 0; column < a->columns; column++) {
        for (uint32_t row = 0; row < a->rows; row++) {
            size_t offset = (size_t)column * a->column_size + (size_t)row * a->component_size;
            *components++ = at != NULL ? load_component(a, at + offset) : 0.0;
        }
    }
}

// A normalised component from -1 to 1.
static double normalise(const clast_validate_accessor *accessor, double value)
{
    switch (accessor->is_normalised ? accessor->component : CLAST_GLTF_FLOAT) {
    case CLAST_GLTF_BYTE: return fmax(value / 127.0, -1.0);
    case CLAST_GLTF_UNSIGNED_BYTE: return value / 255.0;
    case CLAST_GLTF_SHORT: return fmax(value / 32767.0, -1.0);
    case CLAST_GLTF_UNSIGNED_SHORT: return value / 65535.0;
    default: return value;
    }
}

static bool check_sparse(clast_validator *v, uint32_t index)
{
    const clast_validate_accessor *accessor = &v->accessors[index];
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_ACCESSORS, index);
    uint32_t size = accessor->sparse_component_size;
    uint64_t least = 0;
    for (uint64_t i = 0; accessor->sparse_indices.data != NULL && i < accessor->sparse_count; i++) {
        uint32_t element = load_unsigned(accessor->sparse_indices.data + i * size, size);
        if (element < least) {
            clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_SPARSE_INDICES_NON_INCREASING, &value, "sparse",
                                        "index %llu is %u: expected at least %llu", (unsigned long long)i, element,
                                        (unsigned long long)least);
            return false;
        }
        if (element >= accessor->count) {
            clast_validate_member_fault(v, CLAST_FAULT_ACCESSOR_SPARSE_INDEX_OOB, &value, "sparse",
                                        "index %llu is %u of %llu elements", (unsigned long long)i, element,
                                        (unsigned long long)accessor->count);
            return false;
        }
        least = (uint64_t)element + 1;
    }
    return true;
}

// ------------------------------------------------------------------------------------------------------------- elements

// The checks of single elements: how many were wrong, and where the first was.
#define CHECK_LIST(X) \
    X(INVALID_FLOAT, ACCESSOR_INVALID_FLOAT, "is infinite or no number") \
    X(NON_UNIT, ACCESSOR_VECTOR3_NON_UNIT, "is not of unit length") \
    X(SIGN, ACCESSOR_INVALID_SIGN, "has a sign that is neither 1 nor -1") \
    X(NON_CLAMPED, ACCESSOR_NON_CLAMPED, "is outside 0 to 1") \
    X(NEGATIVE, ACCESSOR_ANIMATION_INPUT_NEGATIVE, "is negative") \
    X(NON_INCREASING, ACCESSOR_ANIMATION_INPUT_NON_INCREASING, "is not above the one before") \
    X(QUATERNION, ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION, "is no rotation of unit length") \
    X(MATRIX, ACCESSOR_INVALID_IBM, "has a last row that is not 0 0 0 1")

#define CHECK_ENUMERATOR(name, code, text) CHECK_##name,
typedef enum check_kind { CHECK_LIST(CHECK_ENUMERATOR) CHECK_COUNT } check_kind;

static const struct {
    clast_fault_code code;
    const char *text;
} checks[] = {
#define CHECK_ROW(name, code, text) {CLAST_FAULT_##code, text},
    CHECK_LIST(CHECK_ROW)};

// The bounds that an accessor declares, and those found.
typedef struct bound_check {
    bool is_declared[2]; // min, max
    double declared[2][COMPONENTS_MOST], found[2][COMPONENTS_MOST];
    uint64_t beyond[2][COMPONENTS_MOST];
} bound_check;

typedef struct element_check {
    clast_validator *v;
    const clast_validate_accessor *accessor;
    accessor_facts *facts;
    uint64_t first[CHECK_COUNT], counts[CHECK_COUNT];
    bound_check bounds;
    double last_time;
    double triangle[3]; // the last indices
} element_check;

static void note(element_check *c, check_kind kind, uint64_t number, bool is_wrong)
{
    if (is_wrong) {
        c->first[kind] = c->counts[kind] == 0 ? number : c->first[kind];
        c->counts[kind]++;
    }
}

static double length_of(const element_check *c, const double *components, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        double value = normalise(c->accessor, components[i]);
        sum += value * value;
    }
    return sqrt(sum);
}

static void check_roles(element_check *c, uint64_t number, const double *components)
{
    const clast_validate_accessor *a = c->accessor;
    uint32_t roles = c->facts->roles;
    if ((roles & ROLE_UNIT) != 0 && a->components >= 3) {
        note(c, CHECK_NON_UNIT, number, fabs(length_of(c, components, 3) - 1.0) > vector_tolerance);
    }
    if ((roles & ROLE_SIGN) != 0 && a->components == 4) {
        note(c, CHECK_SIGN, number, fabs(normalise(a, components[3])) != 1.0);
    }
    if ((roles & ROLE_TIMES) != 0) {
        note(c, CHECK_NEGATIVE, number, components[0] < 0.0);
        note(c, CHECK_NON_INCREASING, number, number > 0 && components[0] <= c->last_time);
        c->last_time = components[0];
    }
    if ((roles & ROLE_QUATERNIONS) != 0 && a->components == 4 && ((roles & ROLE_SPLINES) == 0 || number % 3 == 1)) {
        note(c, CHECK_QUATERNION, number, fabs(length_of(c, components, 4) - 1.0) > quaternion_tolerance);
    }
    if ((roles & ROLE_MATRICES) != 0 && a->components == 16) {
        note(c, CHECK_MATRIX, number,
             components[3] != 0.0 || components[7] != 0.0 || components[11] != 0.0 || components[15] != 1.0);
    }
    for (uint32_t i = 0; (roles & ROLE_CLAMPED) != 0 && i < a->components; i++) {
        note(c, CHECK_NON_CLAMPED, number,
             components[i] < 0.0 || (a->component == CLAST_GLTF_FLOAT && components[i] > 1.0));
    }
    if ((roles & ROLE_INDICES) != 0) {
        c->triangle[number % 3] = components[0];
        bool is_degenerate = number % 3 == 2 && (c->triangle[0] == c->triangle[1] || c->triangle[1] == c->triangle[2] ||
                                                 c->triangle[2] == c->triangle[0]);
        c->facts->degenerate += is_degenerate;
    }
}

static void check_components(element_check *c, uint64_t number, const double *components)
{
    for (uint32_t i = 0; i < c->accessor->components; i++) {
        double value = components[i];
        note(c, CHECK_INVALID_FLOAT, number, !isfinite(value));
        if (value > c->facts->most) {
            c->facts->most = value;
            c->facts->most_place = number;
        }
        bound_check *b = &c->bounds;
        b->found[0][i] = number == 0 || value < b->found[0][i] ? value : b->found[0][i];
        b->found[1][i] = number == 0 || value > b->found[1][i] ? value : b->found[1][i];
        b->beyond[0][i] += b->is_declared[0] && value < b->declared[0][i];
        b->beyond[1][i] += b->is_declared[1] && value > b->declared[1][i];
    }
}

static void read_bounds(const clast_gltf_value *value, const clast_validate_accessor *accessor, bound_check *bounds)
{
    static const char *const names[] = {"min", "max"};
    for (int side = 0; side < 2; side++) {
        const json_t *array = json_object_get(value->json, names[side]);
        bounds->is_declared[side] = json_array_size(array) == accessor->components;
        for (uint32_t i = 0; bounds->is_declared[side] && i < accessor->components; i++) {
            double number = json_number_value(json_array_get(array, i));
            bounds->declared[side][i] = accessor->component == CLAST_GLTF_FLOAT ? (double)(float)number : number;
        }
    }
}

static void tell_bounds(element_check *c, const clast_gltf_value *value)
{
    static const clast_fault_code mismatch[] = {CLAST_FAULT_ACCESSOR_MIN_MISMATCH, CLAST_FAULT_ACCESSOR_MAX_MISMATCH};
    static const clast_fault_code beyond[] = {CLAST_FAULT_ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND,
                                              CLAST_FAULT_ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND};
    const bound_check *b = &c->bounds;
    for (int side = 0; side < 2; side++) {
        clast_gltf_value array = clast_gltf_member(value, side == 0 ? "min" : "max");
        for (uint32_t i = 0; b->is_declared[side] && i < c->accessor->components; i++) {
            clast_gltf_value place = clast_gltf_element(&array, i);
            if (b->found[side][i] != b->declared[side][i]) {
                clast_validate_fault(c->v, mismatch[side], &place, "%.9g is declared, %.9g found", b->declared[side][i],
                                     b->found[side][i]);
            }
            if (b->beyond[side][i] != 0) {
                clast_validate_fault(c->v, beyond[side], &place, "%llu elements are beyond %.9g",
                                     (unsigned long long)b->beyond[side][i], b->declared[side][i]);
            }
        }
    }
}

// Floats are the accessor's own affair; all else is told where it is used.
static void tell_checks(const element_check *c, const clast_gltf_value *accessor)
{
    const use_place *use = &c->facts->use;
    clast_gltf_value item = clast_validate_entry(c->v, use->list, use->item),
                     part = clast_gltf_member(&item, use->part);
    clast_gltf_value element = clast_gltf_element(&part, use->number);
    const clast_gltf_value *holder = use->part != NULL ? &element : &item;
    clast_gltf_value attributes = clast_gltf_member(holder, "attributes");
    clast_gltf_value place = clast_gltf_member(use->is_attribute ? &attributes : holder, use->name);
    for (int kind = 0; kind < CHECK_COUNT; kind++) {
        if (c->counts[kind] != 0) {
            bool is_own = kind == CHECK_INVALID_FLOAT || use->name == NULL;
            clast_validate_fault(c->v, checks[kind].code, is_own ? accessor : &place,
                                 "element %llu %s; %llu such in all", (unsigned long long)c->first[kind],
                                 checks[kind].text, (unsigned long long)c->counts[kind]);
        }
    }
}

static void check_accessor(clast_validator *v, uint32_t index, accessor_facts *facts)
{
    const clast_validate_accessor *accessor = &v->accessors[index];
    clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_ACCESSORS, index);
    element_check c = {.v = v, .accessor = accessor, .facts = facts};
    facts->most = -INFINITY;
    if (!check_sparse(v, index) || !can_read(accessor)) {
        return;
    }
    read_bounds(&value, accessor, &c.bounds);
    element_reader reader = {accessor, 0};
    for (uint64_t i = 0; i < accessor->count; i++) {
        double components[COMPONENTS_MOST];
        read_element(&reader, i, components);
        check_components(&c, i, components);
        check_roles(&c, i, components);
    }
    facts->is_read = true;
    tell_bounds(&c, &value);
    tell_checks(&c, &value);
}

// --------------------------------------------------------------------------------------------------------------- roles

// Adds roles to the accessor of that name, and notes who uses it.
static void add_role(clast_validator *v, accessor_facts *facts, const clast_gltf_value *object, use_place use,
                     uint32_t roles)
{
    uint32_t index = clast_validate_index(v, object, use.name, CLAST_VALIDATE_ACCESSORS);
    if (index != CLAST_NONE) {
        facts[index].roles |= roles;
        facts[index].use = facts[index].use.name == NULL ? use : facts[index].use;
    }
}

static uint32_t roles_of_attribute(const char *name)
{
    return strcmp(name, "NORMAL") == 0       ? ROLE_UNIT
           : strcmp(name, "TANGENT") == 0    ? ROLE_UNIT | ROLE_SIGN
           : strncmp(name, "COLOR_", 6) == 0 ? ROLE_CLAMPED
                                             : 0;
}

static void add_primitive_roles(clast_validator *v, accessor_facts *facts, size_t mesh, size_t number,
                                const clast_gltf_value *primitive)
{
    clast_gltf_value attributes = clast_gltf_member(primitive, "attributes");
    use_place use = {CLAST_VALIDATE_MESHES, mesh, "primitives", number, true, NULL};
    const char *name;
    json_t *json;
    json_object_foreach(attributes.json, name, json)
    {
        (void)json;
        use.name = name;
        add_role(v, facts, &attributes, use, roles_of_attribute(name));
    }
    use.is_attribute = false;
    use.name = "indices";
    add_role(v, facts, primitive, use, ROLE_INDICES);
}

static void add_animation_roles(clast_validator *v, accessor_facts *facts, size_t number,
                                const clast_gltf_value *animation)
{
    clast_gltf_value samplers = clast_gltf_member(animation, "samplers"),
                     channels = clast_gltf_member(animation, "channels");
    use_place use = {CLAST_VALIDATE_ANIMATIONS, number, "samplers", 0, false, "input"};
    for (size_t i = 0; i < clast_gltf_size(&samplers); i++) {
        clast_gltf_value sampler = clast_gltf_element(&samplers, i);
        use.number = i;
        add_role(v, facts, &sampler, use, ROLE_TIMES);
    }
    use.name = "output";
    for (size_t i = 0; i < clast_gltf_size(&channels); i++) {
        clast_gltf_value channel = clast_gltf_element(&channels, i), target = clast_gltf_member(&channel, "target");
        const char *path = clast_validate_text(&target, "path");
        use.number = (size_t)clast_validate_unsigned_or(&channel, "sampler", SIZE_MAX);
        clast_gltf_value sampler = clast_gltf_element(&samplers, use.number);
        const char *interpolation = clast_validate_text(&sampler, "interpolation");
        bool is_cubic = interpolation != NULL && strcmp(interpolation, "CUBICSPLINE") == 0;
        if (path != NULL && strcmp(path, "rotation") == 0) {
            add_role(v, facts, &sampler, use, ROLE_QUATERNIONS | (is_cubic ? ROLE_SPLINES : 0));
        }
    }
}

static void add_roles(clast_validator *v, accessor_facts *facts)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_MESHES); i++) {
        clast_gltf_value mesh = clast_validate_entry(v, CLAST_VALIDATE_MESHES, i);
        clast_gltf_value primitives = clast_gltf_member(&mesh, "primitives");
        for (size_t k = 0; k < clast_gltf_size(&primitives); k++) {
            clast_gltf_value primitive = clast_gltf_element(&primitives, k);
            add_primitive_roles(v, facts, i, k, &primitive);
        }
    }
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_ANIMATIONS); i++) {
        clast_gltf_value animation = clast_validate_entry(v, CLAST_VALIDATE_ANIMATIONS, i);
        add_animation_roles(v, facts, i, &animation);
    }
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_SKINS); i++) {
        clast_gltf_value skin = clast_validate_entry(v, CLAST_VALIDATE_SKINS, i);
        use_place use = {CLAST_VALIDATE_SKINS, i, NULL, 0, false, "inverseBindMatrices"};
        add_role(v, facts, &skin, use, ROLE_MATRICES);
    }
}

// -------------------------------------------------------------------------------------------------------------- indices

static void check_indices(clast_validator *v, const accessor_facts *facts, const clast_gltf_value *primitive)
{
    enum { TRIANGLES = 4 };
    clast_gltf_value attributes = clast_gltf_member(primitive, "attributes"),
                     place = clast_gltf_member(primitive, "indices");
    uint32_t index = clast_validate_index(v, primitive, "indices", CLAST_VALIDATE_ACCESSORS);
    uint32_t positions = clast_validate_index(v, &attributes, "POSITION", CLAST_VALIDATE_ACCESSORS);
    if (index == CLAST_NONE || positions == CLAST_NONE || !facts[index].is_read ||
        v->accessors[positions].components == 0) {
        return;
    }
    const clast_validate_accessor *accessor = &v->accessors[index];
    double restart = accessor->component_size == 4 ? 4294967295.0 : (double)((1u << 8 * accessor->component_size) - 1);
    uint64_t vertices = v->accessors[positions].count;
    if (facts[index].most == restart) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_INDEX_PRIMITIVE_RESTART, &place,
                             "index %llu is %.0f, which restarts a primitive",
                             (unsigned long long)facts[index].most_place, restart);
    }
    if (facts[index].most >= (double)vertices) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_INDEX_OOB, &place, "index %llu is %.0f of %llu vertices",
                             (unsigned long long)facts[index].most_place, facts[index].most,
                             (unsigned long long)vertices);
    }
    if (facts[index].degenerate != 0 && clast_validate_unsigned_or(primitive, "mode", TRIANGLES) == TRIANGLES) {
        clast_validate_fault(v, CLAST_FAULT_ACCESSOR_INDEX_TRIANGLE_DEGENERATE, &place,
                             "%llu triangles of %llu name a vertex twice", (unsigned long long)facts[index].degenerate,
                             (unsigned long long)accessor->count / 3);
    }
}

// ------------------------------------------------------------------------------------------------------------ influences

// The sets of joints and weights of a primitive, with a reader each.
typedef struct influences {
    uint32_t count;
    uint64_t vertices;
    uint32_t accessors[2][SETS_MOST]; // joints, weights
    element_reader readers[2][SETS_MOST];
} influences;

static bool open_influences(clast_validator *v, accessor_facts *facts, const clast_gltf_value *attributes,
                            influences *all)
{
    static const char *const names[] = {"JOINTS_", "WEIGHTS_"};
    for (all->count = 0; all->count < SETS_MOST; all->count++) {
        for (int kind = 0; kind < 2; kind++) {
            char name[24];
            snprintf(name, sizeof name, "%s%u", names[kind], all->count);
            uint32_t index = clast_validate_index(v, attributes, name, CLAST_VALIDATE_ACCESSORS);
            if (index == CLAST_NONE || !facts[index].is_read || v->accessors[index].components != 4) {
                return all->count != 0;
            }
            all->vertices = all->count == 0 && kind == 0 ? v->accessors[index].count : all->vertices;
            if (v->accessors[index].count != all->vertices) {
                return false;
            }
            all->accessors[kind][all->count] = index;
            all->readers[kind][all->count] = (element_reader){&v->accessors[index], 0};
        }
    }
    return true;
}

typedef struct influence_faults {
    uint64_t negative, duplicate, unused, uneven; // vertices
    uint64_t first[4];
    double sum; // of the first uneven one
} influence_faults;

static void note_vertex(uint64_t *count, uint64_t *first, uint64_t vertex, bool is_wrong)
{
    *first = is_wrong && *count == 0 ? vertex : *first;
    *count += is_wrong;
}

static void check_vertex(influences *all, uint64_t vertex, influence_faults *faults)
{
    double used[4 * SETS_MOST], sum = 0.0;
    size_t count = 0;
    bool is_negative = false, is_duplicate = false, is_unused = false;
    for (uint32_t set = 0; set < all->count; set++) {
        double joints[COMPONENTS_MOST], weights[COMPONENTS_MOST];
        read_element(&all->readers[0][set], vertex, joints);
        read_element(&all->readers[1][set], vertex, weights);
        for (int i = 0; i < 4; i++) {
            double weight = normalise(all->readers[1][set].accessor, weights[i]);
            is_negative = is_negative || weight < 0.0;
            is_unused = is_unused || (weight == 0.0 && joints[i] != 0.0);
            for (size_t k = 0; weight != 0.0 && k < count; k++) {
                is_duplicate = is_duplicate || used[k] == joints[i];
            }
            if (weight != 0.0) {
                used[count++] = joints[i];
                sum += weight;
            }
        }
    }
    // Each pair of weights beyond the first may be off by a step of 8 bits.
    double tolerance = weight_step * (count < 2 ? 0.0 : (double)((count + 1) / 2 - 1)) + 1e-6;
    bool is_uneven = fabs(sum - 1.0) > tolerance;
    faults->sum = is_uneven && faults->uneven == 0 ? sum : faults->sum;
    note_vertex(&faults->negative, &faults->first[0], vertex, is_negative);
    note_vertex(&faults->duplicate, &faults->first[1], vertex, is_duplicate);
    note_vertex(&faults->unused, &faults->first[2], vertex, is_unused);
    note_vertex(&faults->uneven, &faults->first[3], vertex, is_uneven);
}

static void check_influences(clast_validator *v, accessor_facts *facts, const clast_gltf_value *primitive)
{
    clast_gltf_value attributes = clast_gltf_member(primitive, "attributes");
    influences all = {0};
    influence_faults faults = {0};
    if (!open_influences(v, facts, &attributes, &all) || facts[all.accessors[1][0]].has_weights_checked) {
        return;
    }
    facts[all.accessors[1][0]].has_weights_checked = true;
    for (uint64_t i = 0; i < all.vertices; i++) {
        check_vertex(&all, i, &faults);
    }
    const struct {
        clast_fault_code code;
        const char *name, *text;
        uint64_t count;
    } rows[] = {
        {CLAST_FAULT_ACCESSOR_WEIGHTS_NEGATIVE, "WEIGHTS_0", "has a negative weight", faults.negative},
        {CLAST_FAULT_ACCESSOR_JOINTS_INDEX_DUPLICATE, "JOINTS_0", "names a joint twice", faults.duplicate},
        {CLAST_FAULT_ACCESSOR_JOINTS_USED_ZERO_WEIGHT, "JOINTS_0", "names a joint with a weight of zero",
         faults.unused},
        {CLAST_FAULT_ACCESSOR_WEIGHTS_NON_NORMALIZED, "WEIGHTS_0", "has weights that do not add up to 1",
         faults.uneven},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (rows[i].count != 0) {
            clast_validate_member_fault(v, rows[i].code, &attributes, rows[i].name, "vertex %llu %s; %llu such in all",
                                        (unsigned long long)faults.first[i], rows[i].text,
                                        (unsigned long long)rows[i].count);
        }
    }
}

// The least number of joints of all skins that show a mesh; 0 where none does.
static void find_joint_counts(clast_validator *v, size_t *counts)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_NODES); i++) {
        clast_gltf_value node = clast_validate_entry(v, CLAST_VALIDATE_NODES, i);
        uint32_t mesh = clast_validate_index(v, &node, "mesh", CLAST_VALIDATE_MESHES);
        uint32_t skin = clast_validate_index(v, &node, "skin", CLAST_VALIDATE_SKINS);
        if (mesh == CLAST_NONE || skin == CLAST_NONE) {
            continue;
        }
        clast_gltf_value value = clast_validate_entry(v, CLAST_VALIDATE_SKINS, skin);
        size_t count = json_array_size(json_object_get(value.json, "joints"));
        counts[mesh] = count != 0 && (counts[mesh] == 0 || count < counts[mesh]) ? count : counts[mesh];
    }
}

static void check_joints(clast_validator *v, const accessor_facts *facts, const clast_gltf_value *primitive,
                         size_t joints)
{
    clast_gltf_value attributes = clast_gltf_member(primitive, "attributes");
    const char *name;
    json_t *json;
    json_object_foreach(attributes.json, name, json)
    {
        uint32_t index = clast_validate_index(v, &attributes, name, CLAST_VALIDATE_ACCESSORS);
        clast_gltf_value place = {.around = &attributes, .name = name, .json = json};
        if (index != CLAST_NONE && strncmp(name, "JOINTS_", 7) == 0 && facts[index].is_read && joints != 0 &&
            facts[index].most >= (double)joints) {
            clast_validate_fault(v, CLAST_FAULT_ACCESSOR_JOINTS_INDEX_OOB, &place, "vertex %llu has joint %.0f of %zu",
                                 (unsigned long long)facts[index].most_place, facts[index].most, joints);
        }
    }
}

static void check_meshes(clast_validator *v, accessor_facts *facts, const size_t *joint_counts)
{
    for (size_t i = 0; i < clast_validate_size(v, CLAST_VALIDATE_MESHES); i++) {
        clast_gltf_value mesh = clast_validate_entry(v, CLAST_VALIDATE_MESHES, i);
        clast_gltf_value primitives = clast_gltf_member(&mesh, "primitives");
        for (size_t k = 0; k < clast_gltf_size(&primitives) && v->status == CLAST_OK; k++) {
            clast_gltf_value primitive = clast_gltf_element(&primitives, k);
            check_indices(v, facts, &primitive);
            check_joints(v, facts, &primitive, joint_counts[i]);
            check_influences(v, facts, &primitive);
        }
    }
}

void clast_validate_data(clast_validator *v)
{
    size_t count = clast_validate_size(v, CLAST_VALIDATE_ACCESSORS);
    if (v->status != CLAST_OK) {
        return;
    }
    accessor_facts *facts = clast_allocate_zeroed(v->context, count, sizeof *facts);
    size_t *joints = clast_allocate_zeroed(v->context, clast_validate_size(v, CLAST_VALIDATE_MESHES), sizeof *joints);
    if (facts == NULL || joints == NULL) {
        v->status = CLAST_ERROR_OUT_OF_MEMORY;
    } else {
        add_roles(v, facts);
        for (uint32_t i = 0; i < count && v->status == CLAST_OK; i++) {
            check_accessor(v, i, &facts[i]);
        }
        find_joint_counts(v, joints);
        check_meshes(v, facts, joints);
    }
    clast_free(v->context, facts);
    clast_free(v->context, joints);
}
