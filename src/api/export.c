// SPDX-License-Identifier: Apache-2.0
// Export: which instances, their units as meshes, and the writer that the file's name asks for.
#include "clast/export.h"

#include <string.h>

#include "api/renderer.h"
#include "frame/extract.h"
#include "load/mesh_write.h"

typedef enum export_format { EXPORT_GLTF, EXPORT_GLB, EXPORT_PLY } export_format;

typedef struct export_work {
    clast_renderer *renderer;
    const clast_export_desc *desc;
    uint32_t *mesh_of; // by the frame's units; CLAST_NONE where none is wanted
    clast_extraction *extractions;
    const clast_mesh **meshes;
    const char **names;
    size_t mesh_count;
    clast_write_instance *instances;
    size_t instance_count;
} export_work;

static bool find_format(const char *path, export_format *format)
{
    static const char *const extensions[] = {"gltf", "glb", "ply"};
    char extension[8];
    clast_path_extension(path, extension, sizeof extension);
    for (size_t i = 0; i < sizeof extensions / sizeof *extensions; i++) {
        if (strcmp(extension, extensions[i]) == 0) {
            *format = (export_format)i;
            return true;
        }
    }
    return false;
}

static void add_instance(export_work *work, const clast_frame_instance *instance)
{
    const clast_scene *scene = work->renderer->scene;
    uint32_t *mesh = &work->mesh_of[instance->unit];
    if (work->renderer->frame->units[instance->unit].record_count == 0) {
        return; // nothing to see
    }
    if (*mesh == CLAST_NONE) {
        *mesh = (uint32_t)work->mesh_count;
        work->names[work->mesh_count++] = scene->geometries[instance->unit].name;
    }
    work->instances[work->instance_count++] = (clast_write_instance){
        .mesh = *mesh, .to_world = instance->to_world, .name = scene->instances[instance->scene_instance].name};
}

static clast_status choose_instances(export_work *work)
{
    const clast_frame *frame = work->renderer->frame;
    clast_context *context = work->renderer->context;
    const clast_export_desc *desc = work->desc;
    size_t wanted = desc->instances != NULL ? desc->instance_count : frame->instance_count;
    work->mesh_of = clast_allocate(context, frame->unit_count, sizeof *work->mesh_of);
    work->names = clast_allocate(context, frame->unit_count, sizeof *work->names);
    work->instances = clast_allocate(context, wanted, sizeof *work->instances);
    if (work->mesh_of == NULL || work->names == NULL || work->instances == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(work->mesh_of, 0xff, frame->unit_count * sizeof *work->mesh_of);
    for (size_t i = 0; i < wanted; i++) {
        uint32_t number = (uint32_t)i;
        if (desc->instances != NULL) {
            uint32_t scene_instance = desc->instances[i];
            number = scene_instance < frame->frame_instance_of_count ? frame->frame_instance_of[scene_instance]
                                                                     : CLAST_NONE;
            if (number == CLAST_NONE) {
                return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "export: the scene has no visible instance %u",
                                  scene_instance);
            }
        }
        add_instance(work, &frame->instances[number]);
    }
    return CLAST_OK;
}

static uint64_t unit_triangles(const clast_frame_unit *unit)
{
    uint64_t triangles = 0;
    for (size_t i = 0; i < unit->record_count; i++) {
        triangles += record_triangles(unit->records[i]);
    }
    return triangles;
}

static clast_status extract(export_work *work)
{
    const clast_frame *frame = work->renderer->frame;
    clast_context *context = work->renderer->context;
    work->extractions = clast_allocate_zeroed(context, work->mesh_count, sizeof *work->extractions);
    work->meshes = clast_allocate(context, work->mesh_count, sizeof *work->meshes);
    if (work->extractions == NULL || work->meshes == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint64_t total = 0, done = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        total += work->mesh_of[i] != CLAST_NONE ? unit_triangles(&frame->units[i]) : 0;
    }
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        uint32_t mesh = work->mesh_of[i];
        if (mesh != CLAST_NONE) {
            status = clast_frame_extract(frame, &frame->units[i], work->desc->welded, done, total,
                                         &work->extractions[mesh]);
            work->meshes[mesh] = &work->extractions[mesh].mesh;
            done += unit_triangles(&frame->units[i]);
        }
    }
    return status;
}

static clast_status write(export_work *work, export_format format, const char *path)
{
    clast_write_model model = {.scene = work->renderer->scene,
                               .meshes = work->meshes,
                               .names = work->names,
                               .mesh_count = work->mesh_count,
                               .instances = work->instances,
                               .instance_count = work->instance_count};
    return format == EXPORT_PLY ? clast_ply_write(work->renderer->context, path, &model)
                                : clast_gltf_write(work->renderer->context, path, format == EXPORT_GLB, &model);
}

static void count(const export_work *work, clast_export_statistics *statistics)
{
    statistics->meshes = (uint32_t)work->mesh_count;
    statistics->instances = (uint32_t)work->instance_count;
    for (size_t i = 0; i < work->mesh_count; i++) {
        statistics->vertices += work->meshes[i]->vertex_count;
        statistics->triangles += work->meshes[i]->triangle_count;
    }
    for (size_t i = 0; i < work->instance_count; i++) {
        statistics->instanced_triangles += work->meshes[work->instances[i].mesh]->triangle_count;
    }
}

clast_status clast_export(clast_renderer *renderer, const clast_render_settings *settings,
                          const clast_export_desc *desc, const char *path, clast_export_statistics *statistics)
{
    if (renderer == NULL || path == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    static const clast_export_desc all = {0};
    export_format format;
    clast_export_statistics unwanted;
    statistics = statistics != NULL ? statistics : &unwanted;
    *statistics = (clast_export_statistics){0};
    if (!find_format(path, &format)) {
        return clast_fail(renderer->context, CLAST_ERROR_UNSUPPORTED,
                          "%s: expected a name that ends in .gltf, .glb or .ply", path);
    }
    clast_status status = clast_renderer_commit(renderer, settings);
    if (status != CLAST_OK) {
        return status;
    }
    export_work work = {.renderer = renderer, .desc = desc != NULL ? desc : &all};
    status = choose_instances(&work);
    if (status == CLAST_OK) {
        status = extract(&work);
    }
    if (status == CLAST_OK) {
        status = write(&work, format, path);
    }
    if (status == CLAST_OK) {
        count(&work, statistics);
    }
    for (size_t i = 0; work.extractions != NULL && i < work.mesh_count; i++) {
        clast_extraction_free(renderer->context, &work.extractions[i]);
    }
    void *blocks[] = {work.mesh_of, work.extractions, work.meshes, work.names, work.instances};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) {
        clast_free(renderer->context, blocks[i]);
    }
    return status;
}
