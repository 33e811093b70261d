// SPDX-License-Identifier: Apache-2.0
// What the files of the glTF reader share. Section numbers cite the glTF 2.0 specification (Khronos Group, 2021).
//
// A function that fails records one error in the reader, says where in the JSON it was, and later steps do nothing: the
// functions return a harmless value then, and the callers look at gltf->status where they loop, allocate or finish.
#ifndef CLAST_LOAD_GLTF_H
#define CLAST_LOAD_GLTF_H

#include <jansson.h>

#include "load/load.h"
#include "load/table.h"

// The root's lists that are read: X(name, key).
#define CLAST_GLTF_LISTS(X) \
    X(CLAST_GLTF_ACCESSORS, "accessors") \
    X(CLAST_GLTF_ANIMATIONS, "animations") \
    X(CLAST_GLTF_BUFFERS, "buffers") \
    X(CLAST_GLTF_BUFFER_VIEWS, "bufferViews") \
    X(CLAST_GLTF_CAMERAS, "cameras") \
    X(CLAST_GLTF_IMAGES, "images") \
    X(CLAST_GLTF_MATERIALS, "materials") \
    X(CLAST_GLTF_MESHES, "meshes") \
    X(CLAST_GLTF_NODES, "nodes") \
    X(CLAST_GLTF_SAMPLERS, "samplers") \
    X(CLAST_GLTF_SCENES, "scenes") \
    X(CLAST_GLTF_SKINS, "skins") \
    X(CLAST_GLTF_TEXTURES, "textures")

#define CLAST_GLTF_ENUMERATOR(name, key) name,
typedef enum clast_gltf_list { CLAST_GLTF_LISTS(CLAST_GLTF_ENUMERATOR) CLAST_GLTF_LIST_COUNT } clast_gltf_list;

// A JSON value and where it stands. The place is a chain to the root, written out only for an error; so the value
// around it must stay where it is.
typedef struct clast_gltf_value {
    const struct clast_gltf_value *around; // null for the root
    const char *name;                      // of a member; null for an element
    size_t index;                          // of an element
    json_t *json;                          // null where it is absent
} clast_gltf_value;

// The vertices that a primitive uses of its accessors' elements.
typedef struct clast_gltf_window {
    uint32_t first, count;
    uint32_t all; // elements of each accessor
} clast_gltf_window;

typedef struct clast_gltf_buffer {
    bool opened;
    bool is_binary_chunk;
    bool kept;            // by the scene: its mapping lives as long as that
    clast_bytes bytes;    // byteLength of them
    clast_file_view file; // an external file, while the reader owns it
    void *block;          // a decoded data URI
} clast_gltf_buffer;

// Which of a file's texture coordinate sets a material's slots 0 and 1 mean, and what its vertices need.
typedef struct clast_gltf_material {
    uint32_t number;  // in the scene; CLAST_NONE before it is read
    uint32_t sets[2]; // CLAST_NONE where none
    bool needs_tangents;
    uint32_t normal_set; // 0 or 1: the slot whose coordinates they follow
} clast_gltf_material;

typedef struct clast_gltf {
    clast_context *context;
    clast_scene *scene;
    const char *path;
    clast_file_view *file; // the caller's, until the scene keeps it
    clast_status status;   // the first failure
    json_t *json;
    clast_gltf_value root;
    clast_gltf_value lists[CLAST_GLTF_LIST_COUNT];
    bool has_binary_chunk;
    clast_bytes binary_chunk;
    clast_table files_read;     // hashes of the names of other files: each counts as read once
    clast_gltf_buffer *buffers; // one for each of the file's
    void **decoded_views;       // one for each of the file's views; null where it is not compressed, or not needed yet
    uint32_t *images;           // scene images; CLAST_NONE: not read yet, or not readable
    bool *image_tried;
    uint32_t *textures; // scene textures, likewise
    clast_gltf_material *materials;
    uint32_t *mesh_geometries;  // for each mesh, where its geometries begin in `geometries`; CLAST_NONE: not read yet
    uint32_t *own_geometries;   // likewise, those of the first node that has its own
    uint32_t *geometries;       // of each primitive of the meshes read; CLAST_NONE where it draws nothing
    clast_gltf_window *windows; // of each of them
    size_t geometry_count, geometry_capacity, window_capacity;
    uint32_t *node_numbers;                // of each node in the scene; null where nothing in the file moves
    bool *weights_move;                    // of each node: an animation moves its weights
    uint32_t *skins;                       // scene skins; CLAST_NONE: not read yet
    uint32_t chosen_scene, chosen_variant; // CLAST_NONE: the first; none
} clast_gltf;

// ------------------------------------------------------------------------------------------------------ gltf_json.c

enum { CLAST_GLTF_PLACE_SIZE = 256 };
#define CLAST_GLTF_REQUIRED UINT64_MAX // as `absent`: the member must be there

// Records the first error; always false. `place` may be null.
bool clast_gltf_fail(clast_gltf *gltf, clast_status status, const clast_gltf_value *place, const char *format, ...)
    CLAST_PRINTF(4, 5);
// Takes over the status of a call that has recorded its error itself; true where it is CLAST_OK.
bool clast_gltf_check(clast_gltf *gltf, clast_status status);
static inline bool clast_gltf_ok(const clast_gltf *gltf)
{
    return gltf->status == CLAST_OK;
}
// Counts what is about to be made of the file (load/account.h); `place` is for the error.
bool clast_gltf_account(clast_gltf *gltf, const clast_gltf_value *place, uint64_t count, uint64_t size);
// A log line with the file and the place.
void clast_gltf_warn(const clast_gltf *gltf, const clast_gltf_value *place, const char *format, ...) CLAST_PRINTF(3, 4);
// Puts blanks in place of line ends and other control characters: what a file holds must not break a log's lines.
void clast_gltf_make_line(char *text);
// materials[3].name, into CLAST_GLTF_PLACE_SIZE bytes.
void clast_gltf_write_place(const clast_gltf_value *value, char *text);

// A member of any type, an object or an array; absent where it is not there. An array's elements follow by number.
clast_gltf_value clast_gltf_member(const clast_gltf_value *object, const char *name);
clast_gltf_value clast_gltf_object(clast_gltf *gltf, const clast_gltf_value *object, const char *name);
clast_gltf_value clast_gltf_array(clast_gltf *gltf, const clast_gltf_value *object, const char *name);
clast_gltf_value clast_gltf_element(const clast_gltf_value *array, size_t index);
clast_gltf_value clast_gltf_element_object(clast_gltf *gltf, const clast_gltf_value *array, size_t index);
size_t clast_gltf_size(const clast_gltf_value *array);
// An entry of a root's list: an object. The index has been checked.
clast_gltf_value clast_gltf_entry(clast_gltf *gltf, clast_gltf_list list, uint32_t index);
// extensions.NAME of an object. `extensions` is the caller's, for the place.
clast_gltf_value clast_gltf_extension(clast_gltf *gltf, const clast_gltf_value *object, clast_gltf_value *extensions,
                                      const char *name);

// Values of members, checked; `absent` where they are not there, and after a failure.
uint64_t clast_gltf_integer(clast_gltf *gltf, const clast_gltf_value *object, const char *name, uint64_t least,
                            uint64_t most, uint64_t absent);
float clast_gltf_number(clast_gltf *gltf, const clast_gltf_value *object, const char *name, float least, float most,
                        float absent);
bool clast_gltf_flag(clast_gltf *gltf, const clast_gltf_value *object, const char *name, bool absent);
const char *clast_gltf_text(clast_gltf *gltf, const clast_gltf_value *object, const char *name); // null where absent
// `count` numbers into `values`, which keeps what it holds where the member is absent; true where it is there.
bool clast_gltf_numbers(clast_gltf *gltf, const clast_gltf_value *object, const char *name, size_t count, float least,
                        float most, float *values);
// A member, or a value itself, that numbers an entry of a list; CLAST_NONE where absent.
uint32_t clast_gltf_index(clast_gltf *gltf, const clast_gltf_value *object, const char *name, clast_gltf_list list);
uint32_t clast_gltf_value_index(clast_gltf *gltf, const clast_gltf_value *value, clast_gltf_list list);

// ------------------------------------------------------------------------------------------------------ gltf_file.c

// Splits the file into JSON text and, for .glb, its binary chunk.
bool clast_gltf_split(clast_gltf *gltf, clast_bytes *text);
// The bytes of a URI: a decoded data URI in `*block` (to be freed), or a mapped file in `*file`.
bool clast_gltf_open_uri(clast_gltf *gltf, const clast_gltf_value *place, const char *uri, void **block,
                         clast_file_view *file, clast_bytes *bytes);
// Opens a buffer, where it is not open yet. The index has been checked.
bool clast_gltf_open_buffer(clast_gltf *gltf, uint32_t index);
// Hands a buffer's mapping to the scene, so that arrays may point into it; false where it is no mapping, or on failure.
bool clast_gltf_keep_buffer(clast_gltf *gltf, uint32_t buffer);
void clast_gltf_close_buffers(clast_gltf *gltf);

// ------------------------------------------------------------------------------------------------------ gltf_view.c

#define CLAST_GLTF_DECODED (CLAST_NONE - 1u) // in place of a buffer's number: the reader decoded the bytes itself

// The bytes of a buffer view, and which buffer they are of. Buffers are opened, and compressed views decoded, when first
// asked for.
bool clast_gltf_open_view(clast_gltf *gltf, uint32_t view, clast_bytes *bytes, uint32_t *buffer);

// -------------------------------------------------------------------------------------------------- gltf_accessor.c

typedef enum clast_gltf_component {
    CLAST_GLTF_BYTE = 5120,
    CLAST_GLTF_UNSIGNED_BYTE = 5121,
    CLAST_GLTF_SHORT = 5122,
    CLAST_GLTF_UNSIGNED_SHORT = 5123,
    CLAST_GLTF_UNSIGNED_INT = 5125,
    CLAST_GLTF_FLOAT = 5126,
} clast_gltf_component;

// Components allowed, as a set of bits.
#define CLAST_GLTF_BIT(component) (1u << ((component)-5120))

typedef struct clast_gltf_accessor {
    clast_gltf_value value;
    clast_gltf_component component;
    uint32_t component_size; // bytes
    uint32_t columns, rows;  // SCALAR 1 1, VECn 1 n, MATn n n
    uint32_t column_stride;  // bytes; a matrix's columns begin at multiples of four (section 3.6.2.4)
    uint32_t element_size;   // bytes
    bool normalised;
    uint64_t count;
    uint32_t buffer;   // CLAST_NONE: all zero
    clast_bytes bytes; // from the first element to the end of the view
    uint64_t stride;
    uint64_t sparse_count;
    clast_bytes sparse_indices, sparse_values;
    uint32_t sparse_index_size;
} clast_gltf_accessor;

// Opens an accessor, with all of its ranges checked. `user` is the place that names it.
bool clast_gltf_open_accessor(clast_gltf *gltf, const clast_gltf_value *user, uint32_t index,
                              clast_gltf_accessor *accessor);
// True where it has one of these component types and `rows` x `columns`; fails otherwise.
bool clast_gltf_accessor_is(clast_gltf *gltf, const clast_gltf_value *user, const clast_gltf_accessor *accessor,
                            uint32_t components, uint32_t columns, uint32_t rows);
// Elements [first, first + count) as floats: count * columns * rows of them. Normalised ones by section 3.6.2.2.
void clast_gltf_read_floats(const clast_gltf_accessor *accessor, uint64_t first, uint64_t count, float *floats);
// All elements of the accessor that a value names, in a new block; null on failure. `*count` is what is expected, or
// 0 for any; it is set.
float *clast_gltf_read_block(clast_gltf *gltf, const clast_gltf_value *user, uint32_t components, uint32_t columns,
                             uint32_t rows, uint64_t *count);
// All elements of an unsigned type as integers.
void clast_gltf_read_integers(const clast_gltf_accessor *accessor, uint32_t *integers);
// The elements where they lie, kept by the scene: for tightly packed 4-byte components in a mapped buffer. Null
// otherwise.
const void *clast_gltf_borrow(clast_gltf *gltf, const clast_gltf_accessor *accessor);

// ------------------------------------------------------------------------------------- gltf_material.c, gltf_image.c

// A texture's number in the scene, read when first asked for; CLAST_NONE where it cannot be shown (a log line says
// why).
uint32_t clast_gltf_texture(clast_gltf *gltf, uint32_t index);
// A texture slot of an object, which keeps what it holds where the object has none of that name.
void clast_gltf_read_slot(clast_gltf *gltf, const clast_gltf_value *holder, const char *name, clast_texture_slot *slot);
// What a material's extensions say (gltf_layers.c).
void clast_gltf_read_layers(clast_gltf *gltf, const clast_gltf_value *material, clast_material_desc *desc);
// Decodes all images that the materials use, on all threads.
void clast_gltf_read_images(clast_gltf *gltf);
// A material, read when first asked for. Null on failure.
const clast_gltf_material *clast_gltf_use_material(clast_gltf *gltf, uint32_t index);

// -------------------------------------------------------------------------------------------- gltf_mesh.c, gltf_pose.c

// What a node makes of the mesh that it shows.
typedef struct clast_gltf_use {
    bool is_own;      // not as other nodes show it
    bool has_weights; // of morph targets that count
    uint32_t skin;    // of the file; CLAST_NONE
    uint32_t node;    // of the scene
} clast_gltf_use;

// Reads a mesh's primitives; gives where its geometries begin in gltf->geometries, one for each primitive, and moves them as
// the use says. Where that is not the node's own, they are read once and shared.
bool clast_gltf_use_mesh(clast_gltf *gltf, uint32_t mesh, const clast_gltf_use *use, uint32_t *first, uint32_t *count);
// An attribute of a primitive's vertices as floats, in place where it can be, else in a new block that is the caller's; null
// where there is none, or on failure.
const float *clast_gltf_read_vertices(clast_gltf *gltf, const clast_gltf_value *place, clast_gltf_window window,
                                      uint32_t components, uint32_t rows, void **block);

// The weights of morph targets that a mesh or a node has, in a new block; null where it has none, or on failure.
float *clast_gltf_read_weights(clast_gltf *gltf, const clast_gltf_value *object, size_t *count);
// How many morph targets a mesh's first primitive has.
size_t clast_gltf_count_targets(clast_gltf *gltf, uint32_t mesh);
// Has a geometry moved as the use says. What it needs for that is taken over from `known`, where that geometry of the same
// primitive has it; CLAST_NONE for none.
bool clast_gltf_deform(clast_gltf *gltf, const clast_gltf_value *primitive, clast_gltf_window window,
                       const clast_gltf_use *use, uint32_t known, uint32_t geometry);

// -------------------------------------------------------------------------------------- gltf_skin.c, gltf_animation.c

// A skin's number in the scene, read when first asked for; CLAST_NONE on failure. All nodes are in the scene.
uint32_t clast_gltf_use_skin(clast_gltf *gltf, uint32_t skin);
// Whether anything in the file moves, so that its nodes are to be kept; and whose weights animations move.
bool clast_gltf_find_motion(clast_gltf *gltf, bool *moves);
void clast_gltf_read_animations(clast_gltf *gltf);

// ------------------------------------------------------------------------------------------ gltf_node.c, gltf_camera.c

// Adds the default scene's nodes: instances, cameras, lights.
void clast_gltf_read_nodes(clast_gltf *gltf);
// Adds the camera or the light of a node, where it has one. The node's number in the scene is CLAST_NONE where nodes are not
// kept.
void clast_gltf_add_camera(clast_gltf *gltf, const clast_gltf_value *node, uint32_t number_in_scene,
                           const clast_matrix *to_world);
void clast_gltf_add_light(clast_gltf *gltf, const clast_gltf_value *node, uint32_t number_in_scene,
                          const clast_matrix *to_world);

// ---------------------------------------------------------------------------------------------------- gltf_choice.c

// Finds the scene and the variant of the materials that are wanted.
void clast_gltf_choose(clast_gltf *gltf);
// The material of a primitive, by the variant; CLAST_NONE where it has none.
uint32_t clast_gltf_primitive_material(clast_gltf *gltf, const clast_gltf_value *primitive);

#endif
