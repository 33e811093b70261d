// SPDX-License-Identifier: Apache-2.0
// What the pass occlude needs of a device: the scene at the least rate, and rays through it. It is a frame of its own, which has the
// same units and instances, and takes what is mirrored from the frame that it belongs to.
#include "shared/occlusion.h"
#include "vulkan/frame_state.h"
#include "vulkan/rays.h"

void clast_vulkan_free_coarse(clast_vulkan_frame *device)
{
    clast_vulkan_frame_destroy(device->coarse_device);
    clast_frame_destroy(device->coarse);
    clast_gpu_free(device->gpu, &device->coarse_rays);
    device->coarse_device = NULL;
    device->coarse = NULL;
}

static clast_status create(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    if (device->coarse != NULL) {
        return CLAST_OK;
    }
    clast_status status = clast_frame_create(frame->scene, frame->cooked, &device->coarse);
    if (status == CLAST_OK) {
        status = clast_vulkan_frame_create(device->gpu, &device->coarse_device);
    }
    if (status != CLAST_OK) {
        clast_vulkan_free_coarse(device);
        return status;
    }
    device->coarse_device->parent = device;
    device->coarse->device = device->coarse_device;
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------------- scene

static clast_status copy_units(const clast_frame *frame, clast_frame *coarse)
{
    clast_status status = CLAST_RESERVE(coarse->context, coarse->units, coarse->unit_capacity, frame->unit_count);
    while (status == CLAST_OK && coarse->unit_count < frame->unit_count) {
        coarse->units[coarse->unit_count++] = (clast_frame_unit){0};
    }
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        const clast_frame_unit *from = &frame->units[i];
        clast_frame_unit *to = &coarse->units[i];
        to->used = from->used && !from->filtered; // nothing is hidden by what can be seen through
        to->unit = from->unit;
        to->pose = from->pose;
        to->view = from->view;
        to->bounds = from->bounds;
        to->counted = false;
        if (to->unit != NULL && to->made_serial != to->unit->serial) {
            to->made_serial = to->unit->serial;
            to->made = to->minimum_known = false;
        }
    }
    return status;
}

// Hits name the frame's instances.
static clast_status copy_instances(const clast_frame *frame, clast_frame *coarse)
{
    size_t count = frame->instance_count;
    clast_status status = CLAST_RESERVE(coarse->context, coarse->instances, coarse->instance_capacity, count);
    for (size_t i = 0; i < count && status == CLAST_OK; i++) {
        coarse->instances[i] = frame->instances[i];
        coarse->instances[i].scene_instance = (uint32_t)i;
    }
    coarse->instance_count = status == CLAST_OK ? count : 0;
    return status;
}

static clast_status make_scene(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = clast_vulkan_prepare(frame);
    status = status == CLAST_OK ? create(frame) : status;
    status = status == CLAST_OK ? copy_units(frame, device->coarse) : status;
    status = status == CLAST_OK ? copy_instances(frame, device->coarse) : status;
    if (status != CLAST_OK) {
        return status;
    }
    clast_frame *coarse = device->coarse;
    coarse->settings = frame->settings;
    coarse->settings.rate = CLAST_RATE_LEAST;
    coarse->settings.max_triangles = coarse->settings.max_clusters = 0;
    clast_vulkan_begin(device->coarse_device);
    return clast_frame_run(coarse, frame->backend, CLAST_PASS_COUNT, CLAST_PASS_TLAS, NULL);
}

// --------------------------------------------------------------------------------------------------------------- rays

clast_status clast_vulkan_trace_coarse(clast_frame *frame, const clast_ray *rays, size_t count, clast_hit *hits)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint64_t ray_bytes = count * sizeof *rays, hit_bytes = count * sizeof *hits;
    uint64_t hits_at = (ray_bytes + 255) / 256 * 256;
    clast_gpu_buffer scratch = {0};
    clast_gpu_commands *commands = NULL;
    clast_status status = make_scene(frame);
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(device->gpu, CLAST_GPU_DEVICE, hits_at + hit_bytes, "coarse rays",
                                   &device->coarse_rays);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_allocate(device->gpu, CLAST_GPU_DEVICE, CLAST_GPU_RAYS_SCRATCH, "scratch of rays", &scratch);
    }
    status = status == CLAST_OK ? clast_gpu_begin(device->gpu, &commands) : status;
    if (status == CLAST_OK) {
        clast_gpu_pass(commands, "occlude");
        clast_gpu_write(commands, &device->coarse_rays, 0, rays, ray_bytes);
        clast_gpu_barrier(commands);
        clast_gpu_trace_closest(commands, &(clast_gpu_rays){.scene = clast_vulkan_frame_scene(device->coarse_device),
                                                            .rays = device->coarse_rays.address,
                                                            .to = device->coarse_rays.address + hits_at,
                                                            .scratch = &scratch,
                                                            .count = (uint32_t)count,
                                                            .kind = CLAST_GPU_RAYS_COHERENT});
        clast_gpu_read(commands, &device->coarse_rays, hits_at, hits, hit_bytes);
        status = clast_gpu_finish(commands);
    }
    clast_gpu_free(device->gpu, &scratch);
    return status;
}

// -------------------------------------------------------------------------------------------------------------- depths

// Brings what edges compare themselves with to the device, where that has other depths.
static clast_status write_depths(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    const clast_depth_pyramid *pyramid = &frame->pyramid;
    uint64_t bytes = (uint64_t)pyramid->row_count * OCCLUSION_DEPTHS * sizeof *pyramid->rows;
    if (device->depths_count == pyramid->row_count && device->depths_key == pyramid->row_key) {
        return CLAST_OK;
    }
    device->depths_count = 0;
    clast_gpu_commands *commands = NULL;
    uint64_t ticket = 0;
    clast_status status = clast_vulkan_renew(frame, bytes, "depths", &device->depths);
    if (status != CLAST_OK || bytes == 0) {
        return status;
    }
    status = clast_gpu_begin(device->gpu, &commands);
    if (status == CLAST_OK) {
        clast_gpu_pass(commands, "occlude");
        clast_gpu_write(commands, &device->depths, 0, pyramid->rows, bytes);
        clast_gpu_barrier(commands);
        status = clast_gpu_submit(commands, &ticket);
    }
    if (status == CLAST_OK) {
        device->depths_count = pyramid->row_count;
        device->depths_key = pyramid->row_key;
    }
    return status;
}

clast_status clast_vulkan_occlude(clast_frame *frame, void *target)
{
    clast_status status = clast_cpu_occlude(frame, target);
    if (frame->pyramid.level_count == 0) { // it was not wanted
        clast_vulkan_free_coarse(clast_vulkan_of(frame));
    }
    return status == CLAST_OK ? write_depths(frame) : status;
}
