// SPDX-License-Identifier: Apache-2.0
// What a committed scene takes.
#include "api/renderer.h"
#include "base/thread.h"
#include "render/levels.h"

static uint64_t image_bytes(const clast_image *image)
{
    uint64_t element = image->type == CLAST_PIXEL_UNORM8 ? 1 : image->type == CLAST_PIXEL_UNORM16 ? 2 : 4;
    return (uint64_t)image->width * image->height * image->channels * element;
}

static uint64_t mesh_bytes(const clast_mesh *mesh)
{
    uint64_t floats = 3u * (mesh->positions != NULL) + 3u * (mesh->normals != NULL) + 4u * (mesh->tangents != NULL) +
                      2u * (mesh->coordinates[0] != NULL) + 2u * (mesh->coordinates[1] != NULL) +
                      4u * (mesh->colours != NULL);
    uint64_t uints = 3u + (mesh->triangle_materials != NULL);
    return 4 * (floats * mesh->vertex_count + uints * mesh->triangle_count);
}

static uint64_t scene_bytes(const clast_scene *scene)
{
    uint64_t bytes = scene->material_count * sizeof *scene->materials +
                     scene->instance_count * sizeof *scene->instances;
    for (size_t i = 0; i < scene->image_count; i++) {
        bytes += image_bytes(&scene->images[i].image);
    }
    bytes += clast_level_bytes(scene);
    for (size_t i = 0; i < scene->geometry_count; i++) {
        if (clast_geometry_is_mesh(&scene->geometries[i])) {
            bytes += mesh_bytes(&scene->geometries[i].of.mesh);
        }
    }
    return bytes;
}

// The sum over a unit's clusters of how full each is. That of triangles and that of vertices are comparable, as clusters aim at
// as many of both.
static double unit_fill(const clast_frame_unit *unit)
{
    _Static_assert((int)CLUSTER_TRIANGLES == (int)CLUSTER_VERTICES, "one number tells both");
    return (double)unit->cluster_fill / CLUSTER_TRIANGLES;
}

void clast_collect_statistics(const clast_renderer *renderer, const clast_frame *frame,
                              clast_render_statistics *statistics)
{
    double fill = 0.0;
    size_t records = 0;
    for (uint32_t i = 0; i < CLAST_PASS_COUNT_; i++) {
        statistics->pass_milliseconds[i] = frame->milliseconds[i];
    }
    statistics->cook_milliseconds = renderer->cooked->milliseconds;
    statistics->triangles = frame->triangles;
    statistics->instanced_triangles = frame->instanced_triangles;
    statistics->clusters = frame->clusters;
    statistics->vertices = frame->vertices;
    statistics->instances = (uint32_t)frame->instance_count;
    for (size_t i = 0; i < frame->instance_count; i++) {
        statistics->hidden_instances += frame->instances[i].hidden;
        statistics->occluded_instances += frame->instances[i].occluded;
    }
    statistics->moved_vertices = frame->moved_vertices;
    statistics->lights = (uint32_t)renderer->scene->light_count;
    statistics->rate = (double)frame->fitted_rate;
    statistics->bound = frame->bound;
    statistics->wanted_clusters = frame->wanted.clusters;
    statistics->wanted_triangles = frame->wanted.triangles;
    statistics->wanted_bytes = frame->wanted.bytes;
    statistics->frame_bytes = frame->granted.bytes;
    statistics->minimum_clusters = frame->minimum.clusters;
    statistics->minimum_triangles = frame->minimum.triangles;
    statistics->minimum_bytes = frame->minimum.bytes;
    statistics->scene_bytes = scene_bytes(renderer->scene);
    statistics->cook_bytes = renderer->cooked->bytes;
    statistics->template_bytes = clast_template_set_bytes(renderer->cooked->templates);
    clast_frame_bytes bytes = clast_frame_count_bytes(frame);
    statistics->vertex_bytes = bytes.vertices;
    statistics->clas_bytes = bytes.records + bytes.clas;
    statistics->blas_bytes = bytes.blas;
    statistics->tlas_bytes = bytes.tlas;
    for (size_t i = 0; i < frame->unit_count; i++) {
        const clast_frame_unit *unit = &frame->units[i];
        if (!unit->used) {
            continue;
        }
        statistics->units++;
        statistics->moved_units += unit->change == CLAST_CHANGE_VERTICES;
        fill += unit_fill(unit);
        records += unit->record_count;
    }
    statistics->cluster_fill = records != 0 ? fill / (double)records : 0.0;
    statistics->memory_peak = clast_context_memory_peak(renderer->context);
    statistics->process_memory_peak = clast_process_memory_peak();
}

clast_status clast_renderer_statistics(const clast_renderer *renderer, clast_render_statistics *statistics)
{
    if (renderer == NULL || statistics == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *statistics = (clast_render_statistics){0};
    if (!renderer->is_committed) {
        return clast_fail(renderer->context, CLAST_ERROR_STATE, "statistics: the renderer has not committed its scene");
    }
    clast_collect_statistics(renderer, renderer->frame, statistics);
    statistics->device = "cpu";
    statistics->driver = "";
    return CLAST_OK;
}
