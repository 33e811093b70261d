// SPDX-License-Identifier: Apache-2.0
// Which device makes a picture: the processor, or one that Vulkan drives. Rays of the caller's, and what is exported, are always
// the processor's.
#include <string.h>

#include "api/renderer.h"
#include "vulkan/render.h"

static void close_device(clast_renderer *renderer)
{
    clast_vulkan_frame_destroy(renderer->vulkan_frame);
    renderer->vulkan_frame = NULL;
    clast_frame_destroy(renderer->device_frame);
    renderer->device_frame = NULL;
    if (renderer->gpu != NULL) {
        clast_gpu_destroy(renderer->gpu);
    }
    renderer->gpu = NULL;
    clast_free(renderer->context, renderer->device_name);
    renderer->device_name = NULL;
    clast_free(renderer->context, renderer->shader_folder);
    renderer->shader_folder = NULL;
    renderer->is_device_chosen = false;
}

void clast_forget_device(clast_renderer *renderer)
{
    close_device(renderer);
}

// Software drivers are for tests, and for those who know that they want one: they count only where their name is given.
static clast_gpu_desc describe_device(const clast_renderer *renderer, const clast_render_settings *settings)
{
    bool is_named = settings->device_name[0] != '\0';
    return (clast_gpu_desc){
        .device = is_named ? settings->device_name : NULL,
        .software = is_named,
        .hardware = true,
        .ray_tracing = settings->accel == CLAST_ACCEL_DRIVER,
#ifndef NDEBUG
        .validate = true,
#endif
        .shader_folder = settings->shaders[0] != '\0' ? settings->shaders : NULL,
        .memory_limit = clast_context_memory_limit(renderer->context),
        .cache_folder = clast_context_cache_folder(renderer->context),
    };
}

static clast_status open_device(clast_renderer *renderer, const clast_render_settings *settings)
{
    clast_gpu_desc desc = describe_device(renderer, settings);
    clast_status status = clast_gpu_create(renderer->context, &desc, &renderer->gpu);
    if (status == CLAST_OK) {
        status = clast_frame_create(renderer->scene, renderer->cooked, &renderer->device_frame);
    }
    if (status == CLAST_OK) {
        status = clast_vulkan_frame_create(renderer->gpu, &renderer->vulkan_frame);
    }
    if (status == CLAST_OK && settings->accel == CLAST_ACCEL_DRIVER) {
        status = clast_vulkan_frame_use_driver(renderer->vulkan_frame);
    }
    if (status == CLAST_OK) {
        renderer->device_frame->device = renderer->vulkan_frame;
    }
    return status;
}

// The best GPU that there is, or else the processor: what is wrong with GPUs is no error then, and the log tells.
static clast_status choose_automatically(clast_renderer *renderer, const clast_render_settings *settings)
{
    clast_status status = open_device(renderer, settings);
    if (status != CLAST_OK && status != CLAST_ERROR_DEVICE) {
        return status;
    }
    if (status == CLAST_ERROR_DEVICE) {
        clast_log(renderer->context, CLAST_LOG_INFORMATION, "device auto: the processor, as %s",
                  clast_context_error(renderer->context));
        close_device(renderer);
        return CLAST_OK;
    }
    const clast_gpu_features *features = clast_gpu_features_of(renderer->gpu);
    if (!features->is_discrete && !features->is_integrated) {
        clast_log(renderer->context, CLAST_LOG_INFORMATION,
                  "device auto: the processor, as %s is neither a discrete nor an integrated GPU", features->name);
        close_device(renderer);
        return CLAST_OK;
    }
    clast_log(renderer->context, CLAST_LOG_INFORMATION, "device auto: %s, driver %s", features->name, features->driver);
    return CLAST_OK;
}

clast_status clast_choose_device(clast_renderer *renderer, const clast_render_settings *settings)
{
    bool is_same = renderer->is_device_chosen && renderer->device == settings->device &&
                   renderer->accel == settings->accel && strcmp(renderer->device_name, settings->device_name) == 0 &&
                   strcmp(renderer->shader_folder, settings->shaders) == 0;
    if (is_same) {
        return renderer->gpu != NULL ? clast_gpu_renew_kernels(renderer->gpu) : CLAST_OK;
    }
    close_device(renderer);
    clast_status status = CLAST_OK;
    switch (settings->device) {
    case CLAST_DEVICE_CPU: break;
    case CLAST_DEVICE_VULKAN: status = open_device(renderer, settings); break;
    default: status = choose_automatically(renderer, settings); break;
    }
    if (status == CLAST_OK && settings->accel == CLAST_ACCEL_DRIVER && renderer->gpu == NULL) {
        status = clast_fail(renderer->context, CLAST_ERROR_UNSUPPORTED,
                            "accel driver: it is the processor that makes the picture, and no Vulkan device");
    }
    if (status == CLAST_OK) {
        renderer->device_name = clast_copy_text(renderer->context, settings->device_name);
        renderer->shader_folder = clast_copy_text(renderer->context, settings->shaders);
        bool copied = renderer->device_name != NULL && renderer->shader_folder != NULL;
        status = copied ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    }
    if (status != CLAST_OK) {
        close_device(renderer);
        return status;
    }
    renderer->device = settings->device;
    renderer->accel = settings->accel;
    renderer->is_device_chosen = true;
    return CLAST_OK;
}

clast_frame *clast_picture_frame(const clast_renderer *renderer)
{
    return renderer->device_frame != NULL ? renderer->device_frame : renderer->frame;
}

const clast_backend *clast_picture_backend(const clast_renderer *renderer)
{
    return renderer->device_frame != NULL ? &clast_vulkan_backend : &clast_cpu_backend;
}

void clast_collect_device(const clast_renderer *renderer, clast_render_statistics *statistics)
{
    if (renderer->gpu == NULL) {
        statistics->device = "cpu";
        statistics->driver = "";
        return;
    }
    const clast_gpu_features *features = clast_gpu_features_of(renderer->gpu);
    statistics->device = features->name;
    statistics->driver = features->driver;
    statistics->device_bytes = clast_gpu_bytes(renderer->gpu);
    statistics->device_bytes_peak = clast_gpu_bytes_peak(renderer->gpu);
}
