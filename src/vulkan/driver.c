// SPDX-License-Identifier: Apache-2.0
// Ray tracing pipelines, and rays through them. A pipeline's table of shaders has a record for each launch, one for
// misses, and one for hits of any instance; what is hit follows from the instance's number.
#include "vulkan/driver_state.h"

#include <stdio.h>
#include <string.h>

enum {
    STAGES_MOST = CLAST_DRIVER_LAUNCHES_MOST + 3,
    GROUPS_MOST = CLAST_DRIVER_LAUNCHES_MOST + 2,
    HANDLE_MOST = 64, // bytes of a group's handle; all drivers have 32
};

static const VkShaderStageFlags ray_stages = VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR |
                                             VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR;

// The push constants of shaders/driver/driver.glsl.
typedef struct driver_push {
    uint64_t scene, rays, results, counts, user;
    uint32_t count;
} driver_push;
_Static_assert(sizeof(driver_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

struct clast_driver {
    clast_gpu *gpu;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    clast_gpu_buffer table;
    uint32_t launch_count; // records of these come first, then that of misses, then that of hits
    VkStridedDeviceAddressRegionKHR records[GROUPS_MOST];
    uint32_t across, most; // launches along the first dimension, and at once
};

// ---------------------------------------------------------------------------------------------------------- pipeline

static clast_status make_layout(clast_driver *driver)
{
    clast_gpu *gpu = driver->gpu;
    VkPushConstantRange push = {ray_stages, 0, CLAST_GPU_PUSH_BYTES};
    VkPipelineLayoutCreateInfo create = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                         .setLayoutCount = 1,
                                         .pSetLayouts = &gpu->set_layout,
                                         .pushConstantRangeCount = 1,
                                         .pPushConstantRanges = &push};
    VkResult result = gpu->vk.vkCreatePipelineLayout(gpu->device, &create, NULL, &driver->layout);
    return result == VK_SUCCESS ? CLAST_OK
                                : clast_gpu_fail(gpu, result, "making the layout of the ray tracing pipeline");
}

static clast_status make_stage(clast_gpu *gpu, clast_shader shader, VkShaderStageFlagBits stage,
                               VkPipelineShaderStageCreateInfo *made)
{
    uint64_t hash;
    *made = (VkPipelineShaderStageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = stage, .pName = "main"};
    return clast_gpu_open_shader(gpu, shader, &made->module, &hash);
}

// Groups are numbered as stages are, but that the last two stages can be those of one group.
static VkRayTracingShaderGroupCreateInfoKHR group_of(uint32_t number, uint32_t group_count, bool filtered)
{
    bool hits = number + 1 == group_count;
    return (VkRayTracingShaderGroupCreateInfoKHR){.sType = VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR,
                                                  .type = hits
                                                              ? VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR
                                                              : VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR,
                                                  .generalShader = hits ? VK_SHADER_UNUSED_KHR : number,
                                                  .closestHitShader = hits ? number : VK_SHADER_UNUSED_KHR,
                                                  .anyHitShader = hits && filtered ? number + 1 : VK_SHADER_UNUSED_KHR,
                                                  .intersectionShader = VK_SHADER_UNUSED_KHR};
}

static VkResult link_pipeline(clast_driver *driver, const VkPipelineShaderStageCreateInfo *stages, uint32_t stage_count)
{
    VkRayTracingShaderGroupCreateInfoKHR groups[GROUPS_MOST];
    uint32_t group_count = driver->launch_count + 2;
    for (uint32_t i = 0; i < group_count; i++) {
        groups[i] = group_of(i, group_count, stage_count > group_count);
    }
    VkRayTracingPipelineCreateInfoKHR create = {.sType = VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR,
                                                .stageCount = stage_count,
                                                .pStages = stages,
                                                .groupCount = group_count,
                                                .pGroups = groups,
                                                .maxPipelineRayRecursionDepth = 1,
                                                .layout = driver->layout};
    clast_gpu *gpu = driver->gpu;
    return gpu->vk.vkCreateRayTracingPipelinesKHR(gpu->device, VK_NULL_HANDLE, gpu->pipeline_cache, 1, &create, NULL,
                                                  &driver->pipeline);
}

static clast_status make_pipeline(clast_driver *driver, const clast_driver_desc *desc)
{
    clast_gpu *gpu = driver->gpu;
    VkPipelineShaderStageCreateInfo stages[STAGES_MOST] = {{0}};
    uint32_t count = 0;
    clast_status status = CLAST_OK;
    for (uint32_t i = 0; i < desc->launch_count && status == CLAST_OK; i++) {
        status = make_stage(gpu, desc->launches[i], VK_SHADER_STAGE_RAYGEN_BIT_KHR, &stages[count++]);
    }
    if (status == CLAST_OK) {
        status = make_stage(gpu, CLAST_SHADER_DRIVER_MISS, VK_SHADER_STAGE_MISS_BIT_KHR, &stages[count++]);
    }
    if (status == CLAST_OK) {
        status = make_stage(gpu, CLAST_SHADER_DRIVER_HIT, VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR, &stages[count++]);
    }
    if (status == CLAST_OK && desc->filter != CLAST_SHADER_COUNT_) {
        status = make_stage(gpu, desc->filter, VK_SHADER_STAGE_ANY_HIT_BIT_KHR, &stages[count++]);
    }
    if (status == CLAST_OK) {
        VkResult result = link_pipeline(driver, stages, count);
        status = result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "compiling the ray tracing pipeline");
    }
    for (uint32_t i = 0; i < count; i++) {
        gpu->vk.vkDestroyShaderModule(gpu->device, stages[i].module, NULL);
    }
    return status;
}

static uint64_t round_up(uint64_t bytes, uint64_t step)
{
    return (bytes + step - 1) / step * step;
}

static clast_status write_table(clast_driver *driver, const uint8_t *bytes, uint64_t count)
{
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(driver->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_write(commands, &driver->table, 0, bytes, count);
    return clast_gpu_finish(commands);
}

// Launches lie along one dimension as long as that is possible: those of the same number in a second one may become neighbours
// on the device, but their rays are none.
static void take_limits(clast_driver *driver, const VkPhysicalDeviceLimits *limits, uint32_t most)
{
    uint64_t across = (uint64_t)limits->maxComputeWorkGroupCount[0] * limits->maxComputeWorkGroupSize[0];
    driver->most = most;
    driver->across = across < most ? (uint32_t)across : most;
}

// Each record begins where a table of its own may.
static clast_status make_table(clast_driver *driver)
{
    clast_gpu *gpu = driver->gpu;
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR limits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = &limits};
    gpu->vk.vkGetPhysicalDeviceProperties2(gpu->physical_device, &properties);
    take_limits(driver, &properties.properties.limits, limits.maxRayDispatchInvocationCount);
    uint32_t size = limits.shaderGroupHandleSize;
    if (size > HANDLE_MOST) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED, "vulkan: handles of shaders have %u bytes", size);
    }
    uint8_t handles[GROUPS_MOST * HANDLE_MOST];
    uint32_t count = driver->launch_count + 2;
    VkResult result = gpu->vk.vkGetRayTracingShaderGroupHandlesKHR(gpu->device, driver->pipeline, 0, count,
                                                                   (size_t)count * size, handles);
    if (result != VK_SUCCESS) {
        return clast_gpu_fail(gpu, result, "asking for the handles of shaders");
    }
    uint64_t alignment = limits.shaderGroupBaseAlignment != 0 ? limits.shaderGroupBaseAlignment : 1;
    uint64_t stride = round_up(size, limits.shaderGroupHandleAlignment != 0 ? limits.shaderGroupHandleAlignment : 1);
    uint64_t step = round_up(stride, alignment), bytes = count * step + alignment;
    clast_status status = clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, bytes, "the table of shaders", &driver->table);
    if (status != CLAST_OK) {
        return status;
    }
    uint8_t *table = clast_allocate_zeroed(gpu->context, bytes, 1);
    if (table == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    uint64_t skipped = round_up(driver->table.address, alignment) - driver->table.address;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t offset = skipped + i * step;
        memcpy(table + offset, handles + (size_t)i * size, size);
        driver->records[i] = (VkStridedDeviceAddressRegionKHR){driver->table.address + offset, stride, stride};
    }
    status = write_table(driver, table, bytes);
    clast_free(gpu->context, table);
    return status;
}

static const clast_driver_desc rays_of_buffers = {
    .launches = {CLAST_SHADER_DRIVER_CLOSEST, CLAST_SHADER_DRIVER_ANY},
    .launch_count = 2,
};

clast_status clast_driver_create(clast_gpu *gpu, const clast_driver_desc *desc, clast_driver **result)
{
    *result = NULL;
    if (!gpu->features.ray_tracing) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED,
                          "vulkan: %s has no ray tracing pipeline that could be used", gpu->features.name);
    }
    clast_driver *driver = clast_allocate_zeroed(gpu->context, 1, sizeof *driver);
    if (driver == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_driver_desc whole = desc->launch_count != 0 ? *desc : rays_of_buffers;
    whole.filter = desc->filter;
    driver->gpu = gpu;
    driver->launch_count = whole.launch_count;
    clast_status status = make_layout(driver);
    if (status == CLAST_OK) {
        status = make_pipeline(driver, &whole);
    }
    if (status == CLAST_OK) {
        status = make_table(driver);
    }
    if (status != CLAST_OK) {
        clast_driver_destroy(driver);
        return status;
    }
    *result = driver;
    return CLAST_OK;
}

void clast_driver_destroy(clast_driver *driver)
{
    if (driver == NULL) {
        return;
    }
    clast_gpu *gpu = driver->gpu;
    gpu->vk.vkDeviceWaitIdle(gpu->device);
    gpu->vk.vkDestroyPipeline(gpu->device, driver->pipeline, NULL);
    gpu->vk.vkDestroyPipelineLayout(gpu->device, driver->layout, NULL);
    clast_gpu_free(gpu, &driver->table);
    clast_free(gpu->context, driver);
}

// -------------------------------------------------------------------------------------------------------------- rays

void clast_driver_launch(clast_gpu_commands *commands, const clast_driver *driver, uint32_t launch, const void *push,
                         uint32_t push_bytes, uint32_t count)
{
    clast_gpu *gpu = driver->gpu;
    if (commands->status != CLAST_OK || count == 0) {
        return;
    }
    uint32_t across = count < driver->across ? count : driver->across;
    uint32_t down = (count + across - 1) / across;
    if ((uint64_t)across * down > driver->most) {
        clast_gpu_note(commands, clast_fail(gpu->context, CLAST_ERROR_LIMIT,
                                            "vulkan: %u rays; the driver traces %u at a time", count, driver->most));
        return;
    }
    VkStridedDeviceAddressRegionKHR none = {0};
    const VkStridedDeviceAddressRegionKHR *records = driver->records;
    gpu->vk.vkCmdBindPipeline(commands->buffer, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, driver->pipeline);
    gpu->vk.vkCmdBindDescriptorSets(commands->buffer, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR, driver->layout, 0, 1,
                                    &gpu->set, 0, NULL);
    gpu->vk.vkCmdPushConstants(commands->buffer, driver->layout, ray_stages, 0, push_bytes, push);
    gpu->vk.vkCmdTraceRaysKHR(commands->buffer, &records[launch], &records[driver->launch_count],
                              &records[driver->launch_count + 1], &none, across, down, 1);
}

void clast_driver_trace(clast_gpu_commands *commands, const clast_driver *driver, const clast_driver_scene *scene,
                        const clast_driver_rays *rays)
{
    if (scene->structure.address == 0) {
        clast_gpu_note(commands,
                       clast_fail(driver->gpu->context, CLAST_ERROR_STATE, "vulkan: no instances were built"));
        return;
    }
    driver_push push = {.scene = scene->top.address,
                        .rays = rays->rays,
                        .results = rays->results,
                        .counts = rays->counts,
                        .user = rays->user,
                        .count = rays->count};
    clast_driver_launch(commands, driver, rays->any ? 1 : 0, &push, sizeof push, rays->count);
}
