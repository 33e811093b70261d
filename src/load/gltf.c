// SPDX-License-Identifier: Apache-2.0
// The glTF 2.0 reader: what a file is, what it needs, and the order in which its parts are read.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "load/gltf.h"
#include "load/json_text.h"

// FB_ngon_encoding says by the order of triangles which make polygons; they are drawn as they are.
static const char *const EXTENSIONS[] = {
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "FB_ngon_encoding",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_displacement",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_texture_transform",
    "MSFT_texture_dds",
};

static bool has_extension(const char *name)
{
    for (size_t i = 0; i < sizeof EXTENSIONS / sizeof *EXTENSIONS; i++) {
        if (strcmp(EXTENSIONS[i], name) == 0) {
            return true;
        }
    }
    return false;
}

// ---------------------------------------------------------------------------------------------------------------- JSON

static bool parse(clast_gltf *gltf, clast_bytes text)
{
    if (!clast_gltf_check(gltf, clast_json_parse(gltf->context, gltf->path, text, &gltf->json))) {
        return false;
    }
    if (!json_is_object(gltf->json)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL, "the JSON is not an object: expected glTF");
    }
    gltf->root.json = gltf->json;
    return true;
}

// ------------------------------------------------------------------------------------------------- version, extensions

// major.minor, digits only.
static bool parse_version(const char *text, unsigned long *major, unsigned long *minor)
{
    char *end;
    if (text == NULL || text[0] < '0' || text[0] > '9') {
        return false;
    }
    *major = strtoul(text, &end, 10);
    if (end[0] != '.' || end[1] < '0' || end[1] > '9') {
        return false;
    }
    *minor = strtoul(end + 1, &end, 10);
    return *end == '\0';
}

// Section 3.2: any 2.x can be read, unless it says that it needs more than 2.0.
static bool check_version(clast_gltf *gltf)
{
    clast_gltf_value asset = clast_gltf_object(gltf, &gltf->root, "asset");
    const char *version = clast_gltf_text(gltf, &asset, "version");
    const char *least = clast_gltf_text(gltf, &asset, "minVersion");
    unsigned long major, minor;
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    if (!parse_version(version, &major, &minor)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL, "asset.version \"%.20s\": expected 2.0",
                               version != NULL ? version : "");
    }
    if (least != NULL && !parse_version(least, &major, &minor)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, NULL, "asset.minVersion \"%.20s\": expected 2.0", least);
    }
    if (major != 2 || (least != NULL && minor > 0)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_UNSUPPORTED, NULL, "needs glTF version %lu.%lu: expected 2.0", major,
                               minor);
    }
    return true;
}

static bool check_extensions(clast_gltf *gltf)
{
    clast_gltf_value needed = clast_gltf_array(gltf, &gltf->root, "extensionsRequired");
    for (size_t i = 0; i < clast_gltf_size(&needed); i++) {
        clast_gltf_value element = clast_gltf_element(&needed, i);
        const char *name = json_string_value(element.json);
        if (name == NULL) {
            return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &element, "expected the name of an extension");
        }
        if (!has_extension(name)) {
            return clast_gltf_fail(gltf, CLAST_ERROR_UNSUPPORTED, NULL, "needs the extension %.80s", name);
        }
    }
    clast_gltf_value used = clast_gltf_array(gltf, &gltf->root, "extensionsUsed");
    for (size_t i = 0; i < clast_gltf_size(&used); i++) {
        clast_gltf_value element = clast_gltf_element(&used, i);
        const char *name = json_string_value(element.json);
        if (name != NULL && !has_extension(name)) {
            clast_gltf_warn(gltf, &element, "the extension %.80s is not followed", name);
        }
    }
    return clast_gltf_ok(gltf);
}

// ------------------------------------------------------------------------------------------------------------- reading

// Memory for what is known of each entry of the lists; all of it is set to CLAST_NONE or zero.
static bool allocate_tables(clast_gltf *gltf)
{
    clast_context *context = gltf->context;
    size_t images = clast_gltf_size(&gltf->lists[CLAST_GLTF_IMAGES]),
           textures = clast_gltf_size(&gltf->lists[CLAST_GLTF_TEXTURES]);
    size_t meshes = clast_gltf_size(&gltf->lists[CLAST_GLTF_MESHES]),
           materials = clast_gltf_size(&gltf->lists[CLAST_GLTF_MATERIALS]);
    size_t nodes = clast_gltf_size(&gltf->lists[CLAST_GLTF_NODES]),
           skins = clast_gltf_size(&gltf->lists[CLAST_GLTF_SKINS]);
    gltf->buffers = clast_allocate_zeroed(context, clast_gltf_size(&gltf->lists[CLAST_GLTF_BUFFERS]),
                                          sizeof *gltf->buffers);
    gltf->decoded_views = clast_allocate_zeroed(context, clast_gltf_size(&gltf->lists[CLAST_GLTF_BUFFER_VIEWS]),
                                                sizeof *gltf->decoded_views);
    gltf->images = clast_allocate(context, images, sizeof *gltf->images);
    gltf->image_tried = clast_allocate_zeroed(context, images, sizeof *gltf->image_tried);
    gltf->textures = clast_allocate(context, textures, sizeof *gltf->textures);
    gltf->materials = clast_allocate_zeroed(context, materials, sizeof *gltf->materials);
    gltf->mesh_geometries = clast_allocate(context, meshes, sizeof *gltf->mesh_geometries);
    gltf->own_geometries = clast_allocate(context, meshes, sizeof *gltf->own_geometries);
    gltf->weights_move = clast_allocate_zeroed(context, nodes, sizeof *gltf->weights_move);
    gltf->skins = clast_allocate(context, skins, sizeof *gltf->skins);
    if (gltf->buffers == NULL || gltf->decoded_views == NULL || gltf->images == NULL || gltf->image_tried == NULL ||
        gltf->textures == NULL || gltf->materials == NULL || gltf->mesh_geometries == NULL ||
        gltf->own_geometries == NULL || gltf->weights_move == NULL || gltf->skins == NULL) {
        return clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    }
    memset(gltf->images, 0xff, images * sizeof *gltf->images);
    memset(gltf->textures, 0xff, textures * sizeof *gltf->textures);
    memset(gltf->mesh_geometries, 0xff, meshes * sizeof *gltf->mesh_geometries);
    memset(gltf->own_geometries, 0xff, meshes * sizeof *gltf->own_geometries);
    memset(gltf->skins, 0xff, skins * sizeof *gltf->skins);
    for (size_t i = 0; i < materials; i++) {
        gltf->materials[i].number = CLAST_NONE;
    }
    return true;
}

static void read_lists(clast_gltf *gltf)
{
    static const char *const keys[] = {
#define KEY(name, key) key,
        CLAST_GLTF_LISTS(KEY)
#undef KEY
    };
    for (size_t i = 0; i < CLAST_GLTF_LIST_COUNT; i++) {
        gltf->lists[i] = clast_gltf_array(gltf, &gltf->root, keys[i]);
    }
}

static void read_file(clast_gltf *gltf)
{
    clast_bytes text;
    if (!clast_gltf_split(gltf, &text) || !parse(gltf, text) || !check_version(gltf) || !check_extensions(gltf)) {
        return;
    }
    read_lists(gltf);
    clast_gltf_choose(gltf);
    if (clast_gltf_ok(gltf) && allocate_tables(gltf)) {
        clast_gltf_read_images(gltf);
    }
    if (clast_gltf_ok(gltf)) {
        clast_gltf_read_nodes(gltf);
    }
    if (clast_gltf_ok(gltf) && gltf->node_numbers != NULL) {
        clast_gltf_read_animations(gltf);
    }
}

clast_status clast_load_gltf(clast_scene *scene, const char *path, clast_file_view *file)
{
    clast_gltf gltf = {.context = scene->context, .scene = scene, .path = path, .file = file};
    read_file(&gltf);
    clast_gltf_close_buffers(&gltf);
    clast_free(gltf.context, gltf.images);
    clast_free(gltf.context, gltf.image_tried);
    clast_free(gltf.context, gltf.textures);
    clast_free(gltf.context, gltf.materials);
    clast_free(gltf.context, gltf.mesh_geometries);
    clast_free(gltf.context, gltf.own_geometries);
    clast_free(gltf.context, gltf.geometries);
    clast_free(gltf.context, gltf.windows);
    clast_free(gltf.context, gltf.node_numbers);
    clast_free(gltf.context, gltf.weights_move);
    clast_free(gltf.context, gltf.skins);
    json_decref(gltf.json);
    return gltf.status;
}
