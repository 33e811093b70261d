// SPDX-License-Identifier: Apache-2.0
// The same rays on a Vulkan device.
#include <stdio.h>

#include "accel/watertight.h"
#include "vulkan/device_scene.h"
#include "vulkan/rays.h"

struct device_tracer {
    clast_gpu *gpu;
    clast_context *context;
    clast_gpu_trees *trees;
    clast_gpu_buffer rays, results, scratch;
};

struct device_tlas {
    device_scene scene;
};

device_tracer *device_tracer_create(clast_context *context)
{
    device_tracer *d = calloc(1, sizeof *d);
    clast_gpu_desc desc = {.software = true, .hardware = true};
    d->context = context;
    clast_status status = clast_gpu_create(context, &desc, &d->gpu);
    if (status != CLAST_OK) {
        printf("skipped: %s\n", clast_context_error(context));
        free(d);
        return NULL;
    }
    if (clast_gpu_trees_create(d->gpu, &d->trees) != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(context));
        clast_gpu_destroy(d->gpu);
        free(d);
        return NULL;
    }
    printf("device: %s\n", clast_gpu_features_of(d->gpu)->name);
    return d;
}

void device_tracer_destroy(device_tracer *d)
{
    if (d != NULL) {
        clast_gpu_free(d->gpu, &d->rays);
        clast_gpu_free(d->gpu, &d->results);
        clast_gpu_free(d->gpu, &d->scratch);
        clast_gpu_trees_destroy(d->trees);
        clast_gpu_destroy(d->gpu);
        free(d);
    }
}

device_tlas *device_tlas_create(device_tracer *d, const clast_tlas *tlas, const device_tlas *first)
{
    device_tlas *made = calloc(1, sizeof *made);
    if (device_scene_make_with(d->gpu, tlas, first != NULL ? &first->scene : NULL, d->trees, &made->scene) !=
        CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(d->context));
        device_tlas_destroy(d, made);
        return NULL;
    }
    return made;
}

void device_tlas_destroy(device_tracer *d, device_tlas *tlas)
{
    if (tlas != NULL) {
        tlas->scene.gpu = d->gpu;
        device_scene_free(&tlas->scene);
        free(tlas);
    }
}

static uint64_t result_bytes(const device_batch *b)
{
    return b->count * (b->any ? sizeof(uint32_t) : sizeof(clast_hit));
}

static void record_batches(device_tracer *d, clast_gpu_commands *commands, const device_batch *batches, size_t count)
{
    uint64_t rays = 0, results = 0;
    for (size_t i = 0; i < count; i++) {
        clast_gpu_write(commands, &d->rays, rays, batches[i].rays, batches[i].count * sizeof(clast_ray));
        rays += batches[i].count * sizeof(clast_ray);
    }
    clast_gpu_barrier(commands);
    rays = 0;
    for (size_t i = 0; i < count; i++) {
        const device_batch *b = &batches[i];
        clast_gpu_rays call = {.scene = b->tlas->scene.scene.address,
                               .rays = d->rays.address + rays,
                               .to = d->results.address + results,
                               .scratch = &d->scratch,
                               .count = b->count,
                               .kind = b->incoherent ? CLAST_GPU_RAYS_INCOHERENT : CLAST_GPU_RAYS_COHERENT};
        if (b->any) {
            clast_gpu_trace_any(commands, &call);
        } else {
            clast_gpu_trace_closest(commands, &call);
        }
        rays += b->count * sizeof(clast_ray);
        results += result_bytes(b);
    }
    results = 0;
    for (size_t i = 0; i < count; i++) {
        void *to = batches[i].any ? (void *)batches[i].occluded : (void *)batches[i].hits;
        clast_gpu_read(commands, &d->results, results, to, result_bytes(&batches[i]));
        results += result_bytes(&batches[i]);
    }
}

bool device_trace(device_tracer *d, const device_batch *batches, size_t count)
{
    uint64_t rays = 0, results = 0;
    for (size_t i = 0; i < count; i++) {
        rays += batches[i].count * sizeof(clast_ray);
        results += result_bytes(&batches[i]);
    }
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_reserve(d->gpu, CLAST_GPU_DEVICE, rays + 16, "rays", &d->rays);
    status = status == CLAST_OK ? clast_gpu_reserve(d->gpu, CLAST_GPU_DEVICE, results + 16, "results", &d->results)
                                : status;
    status = status == CLAST_OK
                 ? clast_gpu_reserve(d->gpu, CLAST_GPU_DEVICE, CLAST_GPU_RAYS_SCRATCH, "scratch", &d->scratch)
                 : status;
    status = status == CLAST_OK ? clast_gpu_begin(d->gpu, &commands) : status;
    if (status == CLAST_OK) {
        record_batches(d, commands, batches, count);
        status = clast_gpu_finish(commands);
    }
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", clast_context_error(d->context));
    }
    return status == CLAST_OK;
}
