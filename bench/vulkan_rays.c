// SPDX-License-Identifier: Apache-2.0
#include "vulkan_rays.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// The push constants of shaders/bench/rays.comp.
typedef struct rays_push {
    uint64_t to, from, seen, count;
    float eye[3], right[3], up[3], forward[3];
    uint32_t width, height;
} rays_push;
_Static_assert(sizeof(rays_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

static void normalise(float v[3])
{
    float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) {
        v[k] /= length;
    }
}

static void cross(const float a[3], const float b[3], float result[3])
{
    for (int k = 0; k < 3; k++) {
        result[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
    }
}

static void aim(const vulkan_rays *rays, rays_push *push)
{
    const vulkan_work *work = rays->work;
    for (int k = 0; k < 3; k++) {
        push->eye[k] = work->eye[k];
        push->forward[k] = work->target[k] - work->eye[k];
    }
    normalise(push->forward);
    cross(push->forward, (const float[3]){0, 1, 0}, push->right);
    normalise(push->right);
    cross(push->right, push->forward, push->up);
    for (int k = 0; k < 3; k++) {
        push->right[k] *= work->field * (float)rays->width / (float)rays->height;
        push->up[k] *= work->field;
    }
}

static uint32_t make_rays(vulkan_rays *rays, bool diffuse)
{
    vulkan_device *device = rays->work->device;
    clast_gpu_commands *commands = vulkan_begin(device);
    rays_push push = {.to = diffuse ? rays->diffuse.address : rays->primary.address,
                      .from = rays->primary.address,
                      .seen = rays->hits.address,
                      .count = rays->counts.address,
                      .width = rays->width,
                      .height = rays->height};
    aim(rays, &push);
    clast_gpu_fill(commands, &rays->counts, 0, 16, 0);
    clast_gpu_barrier(commands);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_RAYS,
                                              .constants = {diffuse},
                                              .constant_count = 1,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = ((uint64_t)rays->width * rays->height + 63) / 64});
    uint32_t count = 0;
    clast_gpu_read(commands, &rays->counts, 0, &count, sizeof count);
    vulkan_finish(device, commands);
    return count;
}

void vulkan_rays_make(vulkan_work *work, uint32_t width, uint32_t height, vulkan_rays *rays)
{
    *rays = (vulkan_rays){.work = work, .width = width, .height = height};
    uint64_t count = (uint64_t)width * height;
    vulkan_allocate(work->device, count * sizeof(clast_ray), "rays of a picture", &rays->primary);
    vulkan_allocate(work->device, count * sizeof(clast_ray), "diffuse rays", &rays->diffuse);
    vulkan_allocate(work->device, count * sizeof(clast_hit), "hits", &rays->hits);
    vulkan_allocate(work->device, count * sizeof(clast_hit), "hits by the driver", &rays->peer_hits);
    vulkan_allocate(work->device, 16, "counts", &rays->counts);
    rays->primary_count = make_rays(rays, false);
    clast_gpu_commands *commands = vulkan_begin(work->device);
    vulkan_trace(rays, commands, false);
    vulkan_finish(work->device, commands);
    rays->diffuse_count = make_rays(rays, true);
}

void vulkan_rays_free(vulkan_rays *rays)
{
    clast_gpu *gpu = rays->work->device->gpu;
    clast_gpu_free(gpu, &rays->primary);
    clast_gpu_free(gpu, &rays->diffuse);
    clast_gpu_free(gpu, &rays->hits);
    clast_gpu_free(gpu, &rays->peer_hits);
    clast_gpu_free(gpu, &rays->counts);
}

// Another way to go about it, to find the best: CLAST_BENCH_TUNING is group,refill,steps,pairs,bytes,groups (vulkan/rays.h),
// with -1 for never.
static clast_gpu_rays_tuning tuning_of_environment(void)
{
    clast_gpu_rays_tuning tuning = {0};
    uint32_t *const numbers[] = {&tuning.group, &tuning.refill, &tuning.steps,
                                 &tuning.pairs, &tuning.bytes,  &tuning.groups};
    const char *text = getenv("CLAST_BENCH_TUNING");
    for (size_t i = 0; text != NULL && i < sizeof numbers / sizeof *numbers; i++) {
        *numbers[i] = (uint32_t)strtol(text, NULL, 10);
        text = strchr(text, ',');
        text = text != NULL ? text + 1 : NULL;
    }
    return tuning;
}

void vulkan_trace(const vulkan_rays *rays, clast_gpu_commands *commands, bool diffuse)
{
    clast_gpu_trace_closest(commands,
                            &(clast_gpu_rays){.scene = rays->work->scene.address,
                                              .rays = diffuse ? rays->diffuse.address : rays->primary.address,
                                              .to = rays->hits.address,
                                              .scratch = &rays->work->scratch,
                                              .count = rays->width * rays->height,
                                              .kind = diffuse ? CLAST_GPU_RAYS_INCOHERENT : CLAST_GPU_RAYS_COHERENT,
                                              .tuning = tuning_of_environment()});
    clast_gpu_barrier(commands);
}

void vulkan_trace_peer(const vulkan_rays *rays, clast_gpu_commands *commands, bool diffuse)
{
    clast_driver_trace(commands, rays->work->device->driver, &rays->work->peer.scene,
                       &(clast_driver_rays){.rays = diffuse ? rays->diffuse.address : rays->primary.address,
                                            .results = rays->peer_hits.address,
                                            .count = rays->width * rays->height});
    clast_gpu_barrier(commands);
}

vulkan_agreement vulkan_compare(const vulkan_rays *rays, bool diffuse)
{
    vulkan_device *device = rays->work->device;
    vulkan_agreement agreement;
    struct {
        uint64_t first, second, counts;
        uint32_t count;
    } push = {rays->hits.address, rays->peer_hits.address, rays->counts.address, rays->width * rays->height};
    clast_gpu_commands *commands = vulkan_begin(device);
    clast_gpu_fill(commands, &rays->counts, 0, 16, 0);
    vulkan_trace(rays, commands, diffuse);
    vulkan_trace_peer(rays, commands, diffuse);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_BENCH_COMPARE,
                                              .push = &push,
                                              .push_bytes = 28,
                                              .groups = (push.count + 255) / 256});
    clast_gpu_read(commands, &rays->counts, 0, &agreement, sizeof agreement);
    vulkan_finish(device, commands);
    return agreement;
}
