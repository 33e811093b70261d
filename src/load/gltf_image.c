// SPDX-License-Identifier: Apache-2.0
// Images, samplers and textures (sections 3.8.2 to 3.8.4). Only images that a material uses are decoded.
#include <stdio.h>
#include <string.h>

#include "base/thread.h"
#include "load/gltf.h"
#include "load/image.h"

// -------------------------------------------------------------------------------------------------------------- images

// An image's bytes and what decoding gave.
typedef struct image_job {
    clast_context *context;
    uint32_t index; // in the file
    char name[CLAST_GLTF_PLACE_SIZE + 256];
    void *block;
    clast_file_view file;
    clast_bytes bytes;
    clast_image image;
    clast_image_parts parts;
    clast_status status;
} image_job;

static bool open_image(clast_gltf *gltf, image_job *job)
{
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_IMAGES, job->index);
    clast_gltf_value place = clast_gltf_member(&value, "uri");
    const char *uri = clast_gltf_text(gltf, &value, "uri");
    uint32_t view = clast_gltf_index(gltf, &value, "bufferView", CLAST_GLTF_BUFFER_VIEWS), buffer;
    if (!clast_gltf_ok(gltf)) {
        return false;
    }
    snprintf(job->name, sizeof job->name, "%.250s: images[%u]", gltf->path, job->index);
    if (uri != NULL && strncmp(uri, "data:", 5) != 0) {
        size_t length = strlen(job->name);
        snprintf(job->name + length, sizeof job->name - length, " (%.200s)", uri);
        clast_gltf_make_line(job->name);
    }
    if ((uri != NULL) == (view != CLAST_NONE)) {
        return clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &value, "expected either a uri or a bufferView");
    }
    return uri != NULL ? clast_gltf_open_uri(gltf, &place, uri, &job->block, &job->file, &job->bytes)
                       : clast_gltf_open_view(gltf, view, &job->bytes, &buffer);
}

static void close_image(clast_gltf *gltf, image_job *job)
{
    clast_file_unmap(gltf->context, &job->file);
    clast_free(gltf->context, job->block);
    clast_free(gltf->context, (void *)job->image.pixels);
    clast_free(gltf->context, job->parts.blocks.data);
    clast_levels_free(gltf->context, &job->parts.levels);
}

static void decode_images(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    image_job *jobs = data;
    for (size_t i = begin; i < end; i++) {
        image_job *job = &jobs[i];
        job->status = clast_decode_image_parts(job->context, job->name, job->bytes.data, job->bytes.size, &job->image,
                                               &job->parts);
    }
}

// Hands a decoded image to the scene. One of a type that clast does not read leaves its textures out: the surfaces are
// still there.
static void take_image(clast_gltf *gltf, image_job *job)
{
    if (job->status == CLAST_ERROR_UNSUPPORTED) {
        clast_log(gltf->context, CLAST_LOG_WARNING, "%s: not a type of image that clast reads: left out", job->name);
        return;
    }
    if (job->status != CLAST_OK) {
        // Others may have failed beside it: once more, for the text of this one.
        clast_gltf_check(gltf,
                         clast_decode_image(gltf->context, job->name, job->bytes.data, job->bytes.size, &job->image));
        return;
    }
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_IMAGES, job->index);
    const char *name = clast_gltf_text(gltf, &value, "name");
    if (name == NULL) {
        name = json_string_value(json_object_get(value.json, "uri"));
        name = name != NULL && strncmp(name, "data:", 5) == 0 ? NULL : name;
    }
    clast_image image = job->image;
    uint64_t size = (uint64_t)image.width * image.height * image.channels * clast_pixel_size(image.type);
    if (!clast_gltf_account(gltf, &value, size + job->parts.levels.bytes, 1)) {
        return;
    }
    job->image.pixels = NULL;
    uint32_t *number = &gltf->images[job->index];
    if (clast_gltf_check(gltf, clast_scene_adopt_image(gltf->scene, &image, name, number))) {
        clast_scene_adopt_blocks(gltf->scene, *number, &job->parts.blocks);
        clast_scene_adopt_levels(gltf->scene, *number, &job->parts.levels);
    }
}

// Decodes some images side by side. More than a few at a time would hold too many files open.
static void read_batch(clast_gltf *gltf, image_job *jobs, size_t count)
{
    size_t opened = 0;
    while (opened < count && open_image(gltf, &jobs[opened])) {
        opened++;
    }
    if (clast_gltf_ok(gltf)) {
        clast_parallel_for(gltf->context, opened, 1, decode_images, jobs);
    }
    for (size_t i = 0; i < count; i++) {
        if (clast_gltf_ok(gltf)) {
            take_image(gltf, &jobs[i]);
        }
        close_image(gltf, &jobs[i]);
    }
}

// Extensions that hold an image where a texture has no source that every reader knows.
static const char *const SOURCE_EXTENSIONS[] = {"EXT_texture_webp", "MSFT_texture_dds"};
enum { SOURCE_EXTENSION_COUNT = sizeof SOURCE_EXTENSIONS / sizeof *SOURCE_EXTENSIONS };

// Marks the image of a texture that a material's slot names; what is broken there is said when the material is read.
static void mark_slot(clast_gltf *gltf, const clast_gltf_value *object, const char *name, bool *used)
{
    uint64_t counts[] = {clast_gltf_size(&gltf->lists[CLAST_GLTF_TEXTURES]),
                         clast_gltf_size(&gltf->lists[CLAST_GLTF_IMAGES])};
    const json_t *slot = json_object_get(object->json, name);
    const json_t *index = json_object_get(slot, "index");
    json_int_t texture = json_is_integer(index) ? json_integer_value(index) : -1;
    if (texture < 0 || (uint64_t)texture >= counts[0]) {
        return;
    }
    const json_t *entry = json_array_get(gltf->lists[CLAST_GLTF_TEXTURES].json, (size_t)texture);
    const json_t *extensions = json_object_get(entry, "extensions"), *source = json_object_get(entry, "source");
    for (int i = 0; source == NULL && i < SOURCE_EXTENSION_COUNT; i++) {
        source = json_object_get(json_object_get(extensions, SOURCE_EXTENSIONS[i]), "source");
    }
    json_int_t image = json_is_integer(source) ? json_integer_value(source) : -1;
    if (image >= 0 && (uint64_t)image < counts[1]) {
        used[image] = true;
    }
}

// The texture slots of a material's extensions.
static const struct {
    const char *extension, *slot;
} EXTENSION_SLOTS[] = {
    {"KHR_materials_anisotropy", "anisotropyTexture"},
    {"KHR_materials_clearcoat", "clearcoatTexture"},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture"},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture"},
    {"KHR_materials_displacement", "displacementGeometryTexture"},
    {"KHR_materials_sheen", "sheenColorTexture"},
    {"KHR_materials_sheen", "sheenRoughnessTexture"},
    {"KHR_materials_specular", "specularTexture"},
    {"KHR_materials_specular", "specularColorTexture"},
    {"KHR_materials_transmission", "transmissionTexture"},
};

static void mark_images(clast_gltf *gltf, bool *used)
{
    for (size_t i = 0; i < clast_gltf_size(&gltf->lists[CLAST_GLTF_MATERIALS]); i++) {
        clast_gltf_value material = clast_gltf_element(&gltf->lists[CLAST_GLTF_MATERIALS], i);
        clast_gltf_value metallic_roughness = clast_gltf_member(&material, "pbrMetallicRoughness");
        mark_slot(gltf, &metallic_roughness, "baseColorTexture", used);
        mark_slot(gltf, &metallic_roughness, "metallicRoughnessTexture", used);
        mark_slot(gltf, &material, "normalTexture", used);
        mark_slot(gltf, &material, "occlusionTexture", used);
        mark_slot(gltf, &material, "emissiveTexture", used);
        clast_gltf_value extensions = clast_gltf_member(&material, "extensions");
        for (size_t k = 0; k < sizeof EXTENSION_SLOTS / sizeof *EXTENSION_SLOTS; k++) {
            clast_gltf_value extension = clast_gltf_member(&extensions, EXTENSION_SLOTS[k].extension);
            mark_slot(gltf, &extension, EXTENSION_SLOTS[k].slot, used);
        }
    }
}

static void read_marked(clast_gltf *gltf, const bool *used, image_job *jobs, size_t batch)
{
    size_t count = clast_gltf_size(&gltf->lists[CLAST_GLTF_IMAGES]), filled = 0;
    for (size_t i = 0; i <= count && clast_gltf_ok(gltf); i++) {
        if (i < count && used[i]) {
            gltf->image_tried[i] = true;
            jobs[filled++] = (image_job){.context = gltf->context, .index = (uint32_t)i};
        }
        if (filled == batch || (i == count && filled != 0)) {
            read_batch(gltf, jobs, filled);
            filled = 0;
            if (clast_gltf_ok(gltf)) {
                clast_gltf_check(gltf, clast_progress(gltf->context, "load images", i < count ? i + 1 : count, count));
            }
        }
    }
}

void clast_gltf_read_images(clast_gltf *gltf)
{
    size_t count = clast_gltf_size(&gltf->lists[CLAST_GLTF_IMAGES]), batch = clast_worker_count(gltf->context);
    bool *used = clast_allocate_zeroed(gltf->context, count, sizeof *used);
    image_job *jobs = clast_allocate(gltf->context, batch, sizeof *jobs);
    if (used == NULL || jobs == NULL) {
        clast_gltf_check(gltf, CLAST_ERROR_OUT_OF_MEMORY);
    } else {
        mark_images(gltf, used);
        read_marked(gltf, used, jobs, batch);
    }
    clast_free(gltf->context, jobs);
    clast_free(gltf->context, used);
}

// ------------------------------------------------------------------------------------------------------------ textures

static clast_wrap read_wrap(clast_gltf *gltf, const clast_gltf_value *sampler, const char *name)
{
    enum { REPEAT = 10497, CLAMP_TO_EDGE = 33071, MIRRORED_REPEAT = 33648 };
    uint64_t wrap = clast_gltf_integer(gltf, sampler, name, 0, UINT32_MAX, REPEAT);
    switch (wrap) {
    case CLAMP_TO_EDGE: return CLAST_WRAP_CLAMP;
    case MIRRORED_REPEAT: return CLAST_WRAP_MIRROR;
    case REPEAT: return CLAST_WRAP_REPEAT;
    }
    clast_gltf_value place = clast_gltf_member(sampler, name);
    clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "%llu: expected 10497, 33071 or 33648",
                    (unsigned long long)wrap);
    return CLAST_WRAP_REPEAT;
}

static clast_filter read_filter(clast_gltf *gltf, const clast_gltf_value *sampler)
{
    enum { NEAREST = 9728, LINEAR = 9729 };
    uint64_t filter = clast_gltf_integer(gltf, sampler, "magFilter", 0, UINT32_MAX, LINEAR);
    if (filter != NEAREST && filter != LINEAR) {
        clast_gltf_value place = clast_gltf_member(sampler, "magFilter");
        clast_gltf_fail(gltf, CLAST_ERROR_MALFORMED, &place, "%llu: expected 9728 or 9729", (unsigned long long)filter);
    }
    return filter == NEAREST ? CLAST_FILTER_NEAREST : CLAST_FILTER_LINEAR;
}

// Says which extension might hold a texture's image.
static void warn_sourceless(clast_gltf *gltf, const clast_gltf_value *texture)
{
    clast_gltf_value extensions = clast_gltf_object(gltf, texture, "extensions");
    const char *name = json_object_iter_key(json_object_iter(extensions.json));
    clast_gltf_warn(gltf, texture, "no source%s%.80s: left out", name != NULL ? " but by the extension " : "",
                    name != NULL ? name : "");
}

// The image of a texture; CLAST_NONE where it has none that is read.
static uint32_t read_source(clast_gltf *gltf, const clast_gltf_value *texture)
{
    uint32_t source = clast_gltf_index(gltf, texture, "source", CLAST_GLTF_IMAGES);
    for (int i = 0; source == CLAST_NONE && clast_gltf_ok(gltf) && i < SOURCE_EXTENSION_COUNT; i++) {
        clast_gltf_value extensions;
        clast_gltf_value holder = clast_gltf_extension(gltf, texture, &extensions, SOURCE_EXTENSIONS[i]);
        source = clast_gltf_index(gltf, &holder, "source", CLAST_GLTF_IMAGES);
    }
    return source;
}

uint32_t clast_gltf_texture(clast_gltf *gltf, uint32_t index)
{
    if (gltf->textures[index] != CLAST_NONE) {
        return gltf->textures[index];
    }
    clast_gltf_value value = clast_gltf_entry(gltf, CLAST_GLTF_TEXTURES, index);
    uint32_t source = read_source(gltf, &value);
    uint32_t sampler_index = clast_gltf_index(gltf, &value, "sampler", CLAST_GLTF_SAMPLERS);
    clast_texture texture = {.wrap_u = CLAST_WRAP_REPEAT, .wrap_v = CLAST_WRAP_REPEAT, .filter = CLAST_FILTER_LINEAR};
    if (clast_gltf_ok(gltf) && sampler_index != CLAST_NONE) {
        clast_gltf_value sampler = clast_gltf_entry(gltf, CLAST_GLTF_SAMPLERS, sampler_index);
        texture.wrap_u = read_wrap(gltf, &sampler, "wrapS");
        texture.wrap_v = read_wrap(gltf, &sampler, "wrapT");
        texture.filter = read_filter(gltf, &sampler);
    }
    if (clast_gltf_ok(gltf) && source == CLAST_NONE) {
        warn_sourceless(gltf, &value);
    }
    if (!clast_gltf_ok(gltf) || source == CLAST_NONE) {
        return CLAST_NONE;
    }
    if (!gltf->image_tried[source]) { // an index written as 2.0, which the marking passes by
        gltf->image_tried[source] = true;
        image_job job = {.context = gltf->context, .index = source};
        read_batch(gltf, &job, 1);
    }
    texture.image = gltf->images[source];
    if (clast_gltf_ok(gltf) && texture.image != CLAST_NONE) {
        clast_gltf_check(gltf, clast_scene_add_texture(gltf->scene, &texture, &gltf->textures[index]));
    }
    return gltf->textures[index];
}
