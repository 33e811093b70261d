// SPDX-License-Identifier: Apache-2.0
// What there is to draw, as flat arrays. Public functions of clast/scene.h that only edit these arrays are defined in this
// folder; loaders use the functions below beside them.
#ifndef CLAST_SCENE_SCENE_H
#define CLAST_SCENE_SCENE_H

#include "base/context.h"
#include "clast/render.h"
#include "clast/scene.h"
#include "scene/blocks.h"
#include "scene/levels.h"
#include "scene/motion.h"
#include "shared/texture_filter.h"
#include "shared/transform.h"

typedef struct clast_scene_image {
    clast_image image;
    char *name;                           // null where none; so are all names here
    bool owned;                           // image.pixels is a block of clast_allocate
    clast_image_blocks blocks;            // what the pixels were decoded from
    clast_image_levels stored;            // levels that came with its file, of its own type and channels
    clast_image_levels levels[ENCODINGS]; // by how its values are meant: those that were made (render/levels.h)
} clast_scene_image;

typedef struct clast_scene_material {
    clast_material record;
    char *name;
} clast_scene_material;

#define CLAST_COUNT_NONE(...) +0
#define CLAST_COUNT_ONE(...) +1
enum { // how many of the settings are texts
    CLAST_SETTING_TEXTS = CLAST_RENDER_SETTING_LIST(CLAST_COUNT_NONE, CLAST_COUNT_NONE, CLAST_COUNT_NONE,
                                                    CLAST_COUNT_ONE)
};

enum { CLAST_GEOMETRY_BLOCKS = 9 }; // most blocks that a mesh comes with

// A geometry: which source it is for, and that source's description. A mesh's arrays are the scene's own blocks, or lie in
// one of the scene's mapped files.
typedef struct clast_geometry {
    clast_source_kind kind;
    union {
        clast_mesh mesh;
        clast_wave wave;
    } of;
    bool tessellated; // meshes
    clast_tessellation tessellation;
    clast_deformation deformation; // meshes
    char *name;
    uint32_t version; // grows with each change
    void *blocks[CLAST_GEOMETRY_BLOCKS +
                 1]; // what of the arrays is to be freed; one more for positions that replace others
    uint32_t block_count;
} clast_geometry;

typedef struct clast_instance {
    uint32_t geometry;
    clast_transform to_world;
    bool visible;
    bool removed;
    char *name;
} clast_instance;

typedef struct clast_scene_light {
    clast_light record; // at rest
    uint32_t node;      // that it hangs from; CLAST_NONE
    char *name;
} clast_scene_light;

typedef struct clast_scene_camera {
    clast_camera_desc desc; // at rest
    uint32_t node;          // that it hangs from; CLAST_NONE
    char *name;
} clast_scene_camera;

struct clast_scene {
    clast_context *context;
    clast_scene_image *images;
    size_t image_count, image_capacity;
    clast_texture *textures;
    size_t texture_count, texture_capacity;
    clast_scene_material *materials; // number 0 is the plain one, always there
    size_t material_count, material_capacity;
    clast_geometry *geometries;
    size_t geometry_count, geometry_capacity;
    clast_instance *instances;
    size_t instance_count, instance_capacity;
    clast_scene_light *lights;
    size_t light_count, light_capacity;
    clast_scene_camera *cameras;
    size_t camera_count, camera_capacity;
    clast_motion motion;
    clast_environment environment;
    bool has_environment;
    clast_render_settings settings;            // from a scene file; zero where it says nothing
    char *settings_texts[CLAST_SETTING_TEXTS]; // blocks that settings' texts point to
    clast_file_view *files;                    // mapped files that arrays point into
    size_t file_count, file_capacity;
    uint32_t material_version; // each grows with a change of its arrays
    uint32_t instance_version;
    uint32_t light_version;
    uint32_t position_version; // of all meshes: grows when positions are replaced
    bool has_levels;           // of pictures: of all that shading reads at `levels_version` of the materials
    uint32_t levels_version;
    clast_scene_choice choice; // while a file is read: the loader's
    uint64_t stored_bytes,
        made_bytes; // what loaders have read for it, and what they have made of that (load/account.h)
};

static inline bool clast_geometry_is_mesh(const clast_geometry *geometry)
{
    return geometry->kind == CLAST_SOURCE_CLUSTERS || geometry->kind == CLAST_SOURCE_DISPLACED;
}

// A mesh with arrays that the scene takes over: blocks[] are freed with the scene, also where this call fails. Arrays that
// are not among them must lie in a file handed to clast_scene_keep_file. Checks what clast_scene_add_mesh checks.
clast_status clast_scene_adopt_mesh(clast_scene *scene, const clast_mesh *mesh, void *const *blocks,
                                    uint32_t block_count, const char *name, uint32_t *geometry);
// An image whose pixels (a block of clast_allocate) the scene takes over, also where this call fails.
clast_status clast_scene_adopt_image(clast_scene *scene, const clast_image *image, const char *name, uint32_t *number);
// The blocks that an image of the scene was decoded from, which the scene takes over; `blocks` is empty then.
void clast_scene_adopt_blocks(clast_scene *scene, uint32_t image, clast_image_blocks *blocks);
// The levels that an image's file has below the finest: likewise.
void clast_scene_adopt_levels(clast_scene *scene, uint32_t image, clast_image_levels *levels);
// Keeps a mapped file until the scene ends. On failure the file is unmapped.
clast_status clast_scene_keep_file(clast_scene *scene, clast_file_view file);

// Vertex tangents (4 floats for each vertex, a block of clast_allocate) from texture coordinates and normals, for normal maps
// of meshes that bring none. Null where memory ran out.
float *clast_mesh_tangents(clast_context *context, const clast_mesh *mesh);
// Area-weighted vertex normals of an indexed mesh, a block of clast_allocate.
float *clast_mesh_normals(clast_context *context, const clast_mesh *mesh);

// Whether a material of a mesh displaces it.
bool clast_mesh_is_displaced(const clast_scene *scene, const clast_mesh *mesh);
// The least and the greatest height, along the normals, that materials of a mesh displace it by: where texels are 0 to 1. Zero is
// among them.
vec2 clast_mesh_heights(const clast_scene *scene, const clast_mesh *mesh);
// Has the meshes from geometry `first` on tessellated that a material displaces.
clast_status clast_scene_tessellate_displaced(clast_scene *scene, size_t first);
// Makes one mesh, geometry `first`, of all geometries from there on: meshes that nothing shows yet. A tessellated surface is
// whole only within one mesh. Attributes that only some of the parts have are filled in.
clast_status clast_scene_join_meshes(clast_scene *scene, size_t first);

// The camera that settings name ("" is the first of the scene, or a default one), as a record for width x height pixels.
clast_status clast_scene_choose_camera(clast_scene *scene, const char *text, uint32_t width, uint32_t height,
                                       clast_camera *camera);
// The scene's camera that settings name; CLAST_NONE where they name none of its own.
uint32_t clast_scene_find_camera(const clast_scene *scene, const char *text);
clast_camera clast_camera_record(const clast_camera_desc *desc, uint32_t width, uint32_t height);

#endif
