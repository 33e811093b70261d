// SPDX-License-Identifier: Apache-2.0
// A renderer's life: commit a scene, trace rays, render.
#include "api/renderer.h"

#include <stdio.h>

#include "base/thread.h"

clast_status clast_renderer_create(clast_scene *scene, clast_renderer **renderer)
{
    if (scene == NULL || renderer == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *renderer = NULL;
    clast_renderer *made = clast_allocate_zeroed(scene->context, 1, sizeof *made);
    if (made == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    made->context = scene->context;
    made->scene = scene;
    clast_status status = clast_cooked_create(made->context, &made->cooked);
    if (status == CLAST_OK) {
        status = clast_frame_create(scene, made->cooked, &made->frame);
    }
    if (status != CLAST_OK) {
        clast_renderer_destroy(made);
        return status;
    }
    *renderer = made;
    return CLAST_OK;
}

void clast_renderer_destroy(clast_renderer *renderer)
{
    if (renderer == NULL) {
        return;
    }
    clast_forget_device(renderer);
    if (renderer->frame != NULL) {
        clast_frame_destroy(renderer->frame);
    }
    if (renderer->cooked != NULL) {
        clast_cooked_destroy(renderer->cooked);
    }
    clast_free_patterns(renderer);
    clast_free(renderer->context, renderer->environment_path);
    clast_free(renderer->context, renderer);
}

static void set_frame(const clast_renderer *renderer, const clast_render_settings *settings, clast_frame *frame)
{
    frame->settings = (clast_frame_settings){
        .width = settings->width,
        .height = settings->height,
        .camera_number = clast_scene_find_camera(renderer->scene, settings->camera),
        .rate_camera_number = clast_scene_find_camera(
            renderer->scene, settings->tess_camera[0] != '\0' ? settings->tess_camera : settings->camera),
        .time = settings->time,
        .rate = settings->rate,
        .metric = settings->metric,
        .segment = settings->segment,
        .hidden_fraction = settings->hidden_fraction,
        .displacement_scale = settings->displacement_scale,
        .max_triangles = settings->max_triangles,
        .max_clusters = settings->max_clusters,
        .max_bytes = (uint64_t)settings->max_memory << 20,
        .seed = settings->seed,
        .aperture = settings->aperture,
        .focus = settings->focus,
    };
}

static clast_status choose_cameras(const clast_renderer *renderer, const clast_render_settings *settings,
                                   clast_frame *frame)
{
    clast_status status = clast_scene_choose_animation(renderer->scene, settings->animation,
                                                       &frame->settings.animation);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_scene_choose_camera(renderer->scene, settings->camera, settings->width, settings->height,
                                       &frame->settings.camera);
    frame->settings.rate_camera = frame->settings.camera;
    if (status == CLAST_OK && settings->tess_camera[0] != '\0') {
        status = clast_scene_choose_camera(renderer->scene, settings->tess_camera, settings->width, settings->height,
                                           &frame->settings.rate_camera);
    }
    return status;
}

// Cooks, and runs the passes up to `last` of a frame on a backend. `settings` are resolved.
static clast_status commit(clast_renderer *renderer, const clast_render_settings *settings, clast_frame *frame,
                           const clast_backend *backend, clast_pass last)
{
    renderer->is_committed = false;
    clast_status status = clast_use_patterns(renderer, settings);
    if (status == CLAST_OK) {
        status = clast_cooked_update(renderer->cooked, renderer->scene);
    }
    if (status != CLAST_OK) {
        return status;
    }
    set_frame(renderer, settings, frame);
    status = choose_cameras(renderer, settings, frame);
    if (status == CLAST_OK) {
        status = clast_frame_run(frame, backend, CLAST_PASS_ANIMATE, last, NULL);
    }
    renderer->is_committed = status == CLAST_OK && frame == renderer->frame;
    renderer->position_version = renderer->scene->position_version;
    return status;
}

clast_status clast_renderer_commit(clast_renderer *renderer, const clast_render_settings *settings)
{
    if (renderer == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_render_settings resolved = settings != NULL ? *settings : (clast_render_settings){0};
    clast_status status = clast_render_settings_resolve(renderer->context, &resolved);
    return status == CLAST_OK ? commit(renderer, &resolved, renderer->frame, &clast_cpu_backend, CLAST_PASS_TLAS)
                              : status;
}

// ------------------------------------------------------------------------------------------------------------- rays

// Positions that were replaced are gone: until the next commit there is nothing to trace or look at.
static clast_status check_committed(const clast_renderer *renderer, const char *call)
{
    if (!renderer->is_committed) {
        return clast_fail(renderer->context, CLAST_ERROR_STATE, "%s: the renderer has not committed its scene%s", call,
                          renderer->device_frame != NULL ? " since it made a picture on another device" : "");
    }
    if (renderer->position_version != renderer->scene->position_version) {
        return clast_fail(renderer->context, CLAST_ERROR_STATE, "%s: positions were replaced: commit the scene first",
                          call);
    }
    return CLAST_OK;
}

static clast_status check_rays(const clast_renderer *renderer, const clast_ray *rays, size_t count, const void *results)
{
    if (renderer == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count != 0 && (rays == NULL || results == NULL)) {
        return clast_fail(renderer->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "trace: the rays or the place for results are null");
    }
    return check_committed(renderer, "trace");
}

clast_status clast_renderer_trace_closest(const clast_renderer *renderer, const clast_ray *rays, size_t count,
                                          clast_hit *hits)
{
    clast_status status = check_rays(renderer, rays, count, hits);
    if (status == CLAST_OK) {
        clast_hit_filter filter = {clast_alpha_accepts, renderer->frame};
        clast_trace_closest(renderer->frame->tlas, rays, count, &filter, hits);
    }
    return status;
}

clast_status clast_renderer_trace_any(const clast_renderer *renderer, const clast_ray *rays, size_t count,
                                      uint8_t *occluded)
{
    clast_status status = check_rays(renderer, rays, count, occluded);
    if (status == CLAST_OK) {
        clast_hit_filter filter = {clast_alpha_accepts, renderer->frame};
        clast_trace_any(renderer->frame->tlas, rays, count, &filter, occluded);
    }
    return status;
}

static void store(float to[3], vec3 v)
{
    to[0] = v[0];
    to[1] = v[1];
    to[2] = v[2];
}

// A normal of object space in world space: by the inverse's transpose. Under a mirroring instance the outer side stays the outer.
static vec3 normal_to_world(const clast_frame_instance *instance, vec3 normal)
{
    return normalize3(transform_transposed(instance->to_object, normal));
}

clast_status clast_renderer_locate(const clast_renderer *renderer, const clast_hit *hit, clast_surface *surface)
{
    if (renderer == NULL || hit == NULL || surface == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check_committed(renderer, "locate");
    if (status != CLAST_OK) {
        return status;
    }
    const clast_frame *frame = renderer->frame;
    bool is_known = hit->instance < renderer->scene->instance_count &&
                    frame->frame_instance_of[hit->instance] != CLAST_NONE;
    const clast_frame_instance *instance = is_known ? &frame->instances[frame->frame_instance_of[hit->instance]] : NULL;
    const clast_frame_unit *unit = is_known ? &frame->units[instance->unit] : NULL;
    if (!is_known || hit->cluster >= unit->record_count ||
        hit->triangle >= record_triangles(unit->records[hit->cluster])) {
        return clast_fail(renderer->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "locate: the hit is none of the scene as last committed");
    }
    const clast_source *source = clast_source_of(unit->unit);
    const clast_cluster_record *record = &unit->records[hit->cluster];
    clast_surface_point point = source->locate(unit->unit, &unit->pose, record, clast_frame_words(unit, record),
                                               hit->triangle, vec2(hit->u, hit->v));
    clast_source_surface found = source->evaluate(unit->unit, &unit->pose, point);
    *surface = (clast_surface){.geometry = instance->unit, .primitive = point.primitive, .material = found.material};
    store(surface->position, transform_point(instance->to_world, found.position));
    store(surface->geometric_normal, normal_to_world(instance, found.geometric_normal));
    store(surface->shading_normal, normal_to_world(instance, found.normal));
    for (int set = 0; set < 2; set++) {
        surface->coordinates[set][0] = found.coordinates[set][0];
        surface->coordinates[set][1] = found.coordinates[set][1];
    }
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------- pictures

static clast_status check_outputs(clast_context *context, const clast_render_output *outputs, size_t count)
{
    if (outputs == NULL || count == 0) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "render: no output is asked for");
    }
    uint32_t seen = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t view = (uint32_t)outputs[i].view;
        if (view >= CLAST_VIEW_COUNT_ || outputs[i].pixels == NULL || (seen >> view & 1) != 0) {
            return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                              "render: output %zu has no such view, no pixels, or the view of one before it", i);
        }
        seen |= 1u << view;
    }
    return CLAST_OK;
}

// The device that makes pictures, and the version of its driver.
static const char *name_device(const clast_renderer *renderer, char text[512])
{
    const clast_gpu_features *features = renderer->gpu != NULL ? clast_gpu_features_of(renderer->gpu) : NULL;
    snprintf(text, 512, "%.255s%s%.250s", features != NULL ? features->name : "cpu", features != NULL ? ", " : "",
             features != NULL ? features->driver : "");
    return text;
}

static clast_status render(clast_renderer *renderer, const clast_render_settings *settings,
                           const clast_checkpoint *checkpoint, const clast_render_output *outputs, size_t count,
                           clast_render_statistics *statistics)
{
    double begun = clast_clock();
    clast_render_settings resolved = settings != NULL ? *settings : (clast_render_settings){0};
    clast_status status = clast_render_settings_resolve(renderer->context, &resolved);
    if (status == CLAST_OK) {
        status = check_outputs(renderer->context, outputs, count);
    }
    if (status == CLAST_OK) {
        status = clast_choose_device(renderer, &resolved);
    }
    clast_frame *frame = clast_picture_frame(renderer);
    const clast_backend *backend = clast_picture_backend(renderer);
    if (status == CLAST_OK) {
        status = commit(renderer, &resolved, frame, backend, CLAST_PASS_LIGHTS);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_kept_environment kept;
    status = clast_environment_begin(renderer, &resolved, &kept);
    if (status == CLAST_OK) {
        double before = clast_clock() - begun;
        char device[512];
        clast_render_request request = {&resolved, outputs, count,
                                        checkpoint != NULL ? *checkpoint : (clast_checkpoint){0},
                                        name_device(renderer, device)};
        status = clast_render_run(frame, backend, &request, statistics);
        statistics->first_sample_milliseconds += 1000.0 * before;
        clast_environment_end(renderer, &kept);
        // A render that failed may have left the frame between two moments of the shutter.
        renderer->is_committed = renderer->is_committed && (status == CLAST_OK || resolved.shutter <= 0.0);
    }
    clast_collect_statistics(renderer, frame, statistics);
    clast_collect_device(renderer, statistics);
    statistics->total_milliseconds = 1000.0 * (clast_clock() - begun);
    return status;
}

clast_status clast_render(clast_renderer *renderer, const clast_render_settings *settings,
                          const clast_render_output *outputs, size_t count, clast_render_statistics *statistics)
{
    return clast_render_with_checkpoint(renderer, settings, NULL, outputs, count, statistics);
}

clast_status clast_render_with_checkpoint(clast_renderer *renderer, const clast_render_settings *settings,
                                          const clast_checkpoint *checkpoint, const clast_render_output *outputs,
                                          size_t count, clast_render_statistics *statistics)
{
    if (renderer == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_render_statistics unwanted;
    statistics = statistics != NULL ? statistics : &unwanted;
    *statistics = (clast_render_statistics){0};
    clast_status status = render(renderer, settings, checkpoint, outputs, count, statistics);
    if (status == CLAST_ERROR_DEVICE) { // a device that was lost stays lost: the next picture opens it anew
        clast_forget_device(renderer);
        statistics->device = statistics->driver = "";
    }
    return status;
}
