// SPDX-License-Identifier: Apache-2.0
// What the files of the validator share. It walks the JSON of a glTF file by tables (validate_tables.c), then looks at what the
// objects mean together, then at what the buffers hold. Unlike the reader it goes on after a fault. Section numbers cite the
// glTF 2.0 specification (Khronos Group, 2021).
#ifndef CLAST_LOAD_VALIDATE_H
#define CLAST_LOAD_VALIDATE_H

#include "clast/validate.h"
#include "load/gltf.h"
#include "load/validate_codes.h"

// The root's lists: X(name, key).
#define CLAST_VALIDATE_LISTS(X) \
    X(ACCESSORS, "accessors") \
    X(ANIMATIONS, "animations") \
    X(BUFFERS, "buffers") \
    X(BUFFER_VIEWS, "bufferViews") \
    X(CAMERAS, "cameras") \
    X(IMAGES, "images") \
    X(MATERIALS, "materials") \
    X(MESHES, "meshes") \
    X(NODES, "nodes") \
    X(SAMPLERS, "samplers") \
    X(SCENES, "scenes") \
    X(SKINS, "skins") \
    X(TEXTURES, "textures") \
    X(LIGHTS, "lights")     /* of KHR_lights_punctual */ \
    X(VARIANTS, "variants") /* of KHR_materials_variants */

#define CLAST_VALIDATE_ENUMERATOR(name, key) CLAST_VALIDATE_##name,
typedef enum clast_validate_list {
    CLAST_VALIDATE_LISTS(CLAST_VALIDATE_ENUMERATOR) CLAST_VALIDATE_LIST_COUNT
} clast_validate_list;

// What the bytes of a view or an accessor are used for.
typedef enum clast_usage {
    CLAST_USAGE_NONE,
    CLAST_USAGE_VERTICES,
    CLAST_USAGE_INDICES,
    CLAST_USAGE_MATRICES, // of a skin
    CLAST_USAGE_ANIMATION,
    CLAST_USAGE_IMAGE,
    CLAST_USAGE_INSTANCES, // of EXT_mesh_gpu_instancing
} clast_usage;

typedef struct clast_validate_buffer {
    uint64_t length;   // declared
    clast_bytes bytes; // null where they are not at hand, or are fewer than declared
    clast_file_view file;
    void *block;
} clast_validate_buffer;

typedef struct clast_validate_view {
    uint32_t buffer;                 // CLAST_NONE where it is none
    uint64_t offset, length, stride; // stride 0: none given
    clast_bytes bytes;               // null where they are not at hand
    clast_usage usage;
    uint32_t first_user; // the accessor of vertices that used it first
} clast_validate_view;

// An accessor whose properties make sense; else `components` is 0.
typedef struct clast_validate_accessor {
    uint64_t count, offset;
    uint32_t view;      // CLAST_NONE where there is none
    uint32_t component; // as glTF numbers them
    uint32_t component_size, components, rows, columns;
    uint32_t column_size, element_size; // columns of matrices are padded to 4 bytes
    uint64_t stride;
    bool is_normalised;
    clast_bytes bytes; // null where they are not at hand
    uint64_t sparse_count;
    uint32_t sparse_component_size;
    clast_bytes sparse_indices, sparse_values; // null where there are none
    clast_usage usage;
} clast_validate_accessor;

typedef struct clast_validator {
    clast_context *context;
    clast_validation *validation;
    clast_status status; // what ends the validation: memory
    const char *path;
    clast_scene *scene; // an empty one, as readers of resources need it
    clast_bytes binary; // the BIN chunk
    bool is_container, has_binary, is_quantised;
    json_t *json;
    clast_gltf_value root, extensions, holders[2]; // holders: of the lists of lights and variants
    clast_gltf_value lists[CLAST_VALIDATE_LIST_COUNT];
    bool *used[CLAST_VALIDATE_LIST_COUNT];
    clast_validate_buffer *buffers;
    clast_validate_view *views;
    clast_validate_accessor *accessors;
    uint32_t *parents; // of nodes; CLAST_NONE for roots
} clast_validator;

// Adds a fault at a place of the JSON.
void clast_validate_fault(clast_validator *v, clast_fault_code code, const clast_gltf_value *place, const char *format,
                          ...) CLAST_PRINTF(4, 5);
// The same at a member of an object.
void clast_validate_member_fault(clast_validator *v, clast_fault_code code, const clast_gltf_value *object,
                                 const char *name, const char *format, ...) CLAST_PRINTF(5, 6);
// Adds a fault at a byte of the file.
void clast_validate_byte_fault(clast_validator *v, clast_fault_code code, uint64_t offset, const char *format, ...)
    CLAST_PRINTF(4, 5);

// Values that the tables have checked already: they add no faults.
bool clast_validate_unsigned(const clast_gltf_value *object, const char *name, uint64_t *value);
uint64_t clast_validate_unsigned_or(const clast_gltf_value *object, const char *name, uint64_t otherwise);
double clast_validate_number_or(const clast_gltf_value *object, const char *name, double otherwise);
const char *clast_validate_text(const clast_gltf_value *object, const char *name);
// The index of an entry of a list; CLAST_NONE where it is absent or resolves to nothing.
uint32_t clast_validate_index(const clast_validator *v, const clast_gltf_value *object, const char *name,
                              clast_validate_list list);
uint32_t clast_validate_element_index(const clast_validator *v, const clast_gltf_value *array, size_t number,
                                      clast_validate_list list);
static inline size_t clast_validate_size(const clast_validator *v, clast_validate_list list)
{
    return clast_gltf_size(&v->lists[list]);
}
static inline clast_gltf_value clast_validate_entry(const clast_validator *v, clast_validate_list list, size_t index)
{
    return clast_gltf_element(&v->lists[list], index);
}
// Whether extensionsUsed names it.
bool clast_validate_declares(const clast_validator *v, const char *extension);
// Whether the tables have an extension of that name.
bool clast_validate_knows_extension(const char *name);
// An extension's object; its json is null where there is none. `extensions` is storage for what stands around it.
clast_gltf_value clast_validate_extension(const clast_gltf_value *object, clast_gltf_value *extensions,
                                          const char *name);

// validate_container.c: takes a .glb file apart; false where there is no JSON to look at.
bool clast_validate_container(clast_validator *v, clast_bytes file, clast_bytes *text);

// validate_walk.c: all of the JSON, by the tables.
void clast_validate_walk(clast_validator *v);

// validate_tables.c
typedef enum clast_rule_type {
    CLAST_RULE_ANY, // not looked at
    CLAST_RULE_BOOLEAN,
    CLAST_RULE_INTEGER,
    CLAST_RULE_NUMBER,
    CLAST_RULE_TEXT,
    CLAST_RULE_URI,
    CLAST_RULE_INDEX,
    CLAST_RULE_OBJECT,
    CLAST_RULE_MAP,     // an object of any names whose values are indices of `list`
    CLAST_RULE_NUMBERS, // arrays of these
    CLAST_RULE_INTEGERS,
    CLAST_RULE_INDICES,
    CLAST_RULE_TEXTS,
    CLAST_RULE_OBJECTS,
    CLAST_RULE_MAPS,
} clast_rule_type;

struct clast_rule_object;

// What may stand under a name.
typedef struct clast_rule {
    const char *name;
    clast_rule_type type;
    bool is_required;
    bool excludes_least; // the least value itself is out of range
    bool is_distinct;    // no element twice
    bool may_be_empty;   // an array
    uint8_t lengths[7];  // that an array may have; none: any from 1
    double least, most;  // of numbers; both 0: any
    const char *choices; // values that are defined, parted by blanks; null: any
    const char *needs;   // a property that must be there too
    clast_validate_list list;
    const struct clast_rule_object *object;
} clast_rule;

typedef struct clast_rule_object {
    const clast_rule *rules;                                          // ends with a null name
    bool is_plain;                                                    // takes neither extensions nor extras
    void (*check)(clast_validator *v, const clast_gltf_value *value); // what the rules cannot say; may be null
} clast_rule_object;

extern const clast_rule_object clast_rules_of_root;

// An extension: where its objects stand, and what they are.
typedef struct clast_rule_extension {
    const char *name;
    const clast_rule_object *around, *object;
} clast_rule_extension;
extern const clast_rule_extension clast_rule_extensions[];
extern const size_t clast_rule_extension_count;

// validate_objects.c: what single objects mean; called by the walk.
void clast_validate_extension_lists(clast_validator *v, const clast_gltf_value *value);
void clast_validate_asset(clast_validator *v, const clast_gltf_value *value);
void clast_validate_accessor_object(clast_validator *v, const clast_gltf_value *value);
void clast_validate_view_object(clast_validator *v, const clast_gltf_value *value);
void clast_validate_camera(clast_validator *v, const clast_gltf_value *value);
void clast_validate_orthographic(clast_validator *v, const clast_gltf_value *value);
void clast_validate_perspective(clast_validator *v, const clast_gltf_value *value);
void clast_validate_image_object(clast_validator *v, const clast_gltf_value *value);
void clast_validate_material(clast_validator *v, const clast_gltf_value *value);
void clast_validate_node_object(clast_validator *v, const clast_gltf_value *value);
void clast_validate_channel_target(clast_validator *v, const clast_gltf_value *value);
void clast_validate_pointer_target(clast_validator *v, const clast_gltf_value *value);
void clast_validate_light(clast_validator *v, const clast_gltf_value *value);
void clast_validate_ior(clast_validator *v, const clast_gltf_value *value);
void clast_validate_volume(clast_validator *v, const clast_gltf_value *value);
void clast_validate_dispersion(clast_validator *v, const clast_gltf_value *value);
void clast_validate_anisotropy(clast_validator *v, const clast_gltf_value *value);
void clast_validate_variant_mappings(clast_validator *v, const clast_gltf_value *value);

// Bytes of a component; 0 where there is no such type. Columns and rows of an accessor's type; false where there is none.
uint32_t clast_validate_component_size(uint64_t component);
bool clast_validate_type(const char *type, uint32_t *columns, uint32_t *rows);

// validate_storage.c: buffers, views and accessors, whose tables it fills; images.
void clast_validate_storage(clast_validator *v);
void clast_validate_close_storage(clast_validator *v);
// Notes what an accessor, and its view, are used for; false, with a fault at the place, where that excludes an earlier use.
bool clast_validate_use(clast_validator *v, const clast_gltf_value *place, uint32_t accessor, clast_usage usage);

// validate_links.c: nodes, scenes, skins and animations; what nothing uses. validate_meshes.c: meshes and their materials.
void clast_validate_links(clast_validator *v);
void clast_validate_meshes(clast_validator *v);
// How many morph targets a mesh has; whether it has joints.
size_t clast_validate_target_count(const clast_gltf_value *mesh);
bool clast_validate_has_joints(const clast_gltf_value *mesh);

// validate_animation.c
void clast_validate_animations(clast_validator *v);

// validate_data.c: what the accessors hold.
void clast_validate_data(clast_validator *v);

#endif
