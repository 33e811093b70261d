// SPDX-License-Identifier: Apache-2.0
// Recording, submitting and waiting.
#include "vulkan/device.h"

#include <string.h>

enum { GROUPS_ACROSS = 65535 }; // the least that all devices allow along a dimension

// ------------------------------------------------------------------------------------------------------------- life

static VkResult make_own(clast_gpu *gpu, clast_gpu_commands *commands)
{
    VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                    .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                    .queueFamilyIndex = gpu->queue_family};
    VkResult result = gpu->vk.vkCreateCommandPool(gpu->device, &pool, NULL, &commands->pool);
    if (result != VK_SUCCESS) {
        return result;
    }
    VkCommandBufferAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                            .commandPool = commands->pool,
                                            .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                            .commandBufferCount = 1};
    result = gpu->vk.vkAllocateCommandBuffers(gpu->device, &allocate, &commands->buffer);
    if (result != VK_SUCCESS || gpu->features.timestamp_period == 0.0f) {
        return result;
    }
    VkQueryPoolCreateInfo queries = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = GPU_QUERIES};
    return gpu->vk.vkCreateQueryPool(gpu->device, &queries, NULL, &commands->queries);
}

clast_status clast_gpu_make_commands(clast_gpu *gpu)
{
    VkSemaphoreTypeCreateInfo type = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO,
                                      .semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE};
    VkSemaphoreCreateInfo semaphore = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, .pNext = &type};
    VkResult result = gpu->vk.vkCreateSemaphore(gpu->device, &semaphore, NULL, &gpu->timeline);
    for (int i = 0; i < GPU_COMMANDS && result == VK_SUCCESS; i++) {
        gpu->commands[i].gpu = gpu;
        result = make_own(gpu, &gpu->commands[i]);
    }
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "making command buffers");
}

void clast_gpu_free_commands(clast_gpu *gpu)
{
    for (int i = 0; i < GPU_COMMANDS; i++) {
        clast_gpu_commands *commands = &gpu->commands[i];
        commands->is_recording = false;
        commands->gpu = gpu;
        clast_gpu_free_staging(commands);
        clast_free(gpu->context, commands->deliveries);
        gpu->vk.vkDestroyQueryPool(gpu->device, commands->queries, NULL);
        gpu->vk.vkDestroyCommandPool(gpu->device, commands->pool, NULL);
    }
    gpu->vk.vkDestroySemaphore(gpu->device, gpu->timeline, NULL);
}

// -------------------------------------------------------------------------------------------------------- recording

static clast_status open_buffer(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    VkResult result = gpu->vk.vkResetCommandPool(gpu->device, commands->pool, 0);
    if (result == VK_SUCCESS) {
        VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
        result = gpu->vk.vkBeginCommandBuffer(commands->buffer, &begin);
    }
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "beginning a command buffer");
}

static void bind_textures(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    gpu->vk.vkCmdBindDescriptorSets(commands->buffer, VK_PIPELINE_BIND_POINT_COMPUTE, gpu->pipeline_layout, 0, 1,
                                    &gpu->set, 0, NULL);
}

clast_status clast_gpu_begin(clast_gpu *gpu, clast_gpu_commands **result)
{
    clast_gpu_commands *commands = &gpu->commands[gpu->next_commands];
    if (commands->is_recording) {
        return clast_fail(gpu->context, CLAST_ERROR_STATE, "vulkan: two recordings are under way already");
    }
    clast_status status = clast_gpu_wait(gpu, commands->ticket);
    if (status == CLAST_OK) {
        status = open_buffer(commands);
    }
    if (status != CLAST_OK) {
        return status;
    }
    gpu->next_commands = (gpu->next_commands + 1) % GPU_COMMANDS;
    commands->is_recording = true;
    commands->status = CLAST_OK;
    commands->pass_count = 0;
    commands->is_labelled = false;
    if (commands->queries != VK_NULL_HANDLE) {
        gpu->vk.vkCmdResetQueryPool(commands->buffer, commands->queries, 0, GPU_QUERIES);
    }
    bind_textures(commands);
    clast_gpu_barrier(commands); // the submission before wrote what this one reads
    *result = commands;
    return CLAST_OK;
}

clast_status clast_gpu_begin_foreign(clast_gpu *gpu, VkCommandBuffer buffer, clast_gpu_commands **result)
{
    clast_gpu_commands *commands = clast_allocate_zeroed(gpu->context, 1, sizeof *commands);
    if (commands == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    commands->gpu = gpu;
    commands->buffer = buffer;
    commands->is_recording = true;
    bind_textures(commands);
    *result = commands;
    return CLAST_OK;
}

static void end_label(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    if (commands->is_labelled && gpu->vk.vkCmdEndDebugUtilsLabelEXT != NULL) {
        gpu->vk.vkCmdEndDebugUtilsLabelEXT(commands->buffer);
    }
    commands->is_labelled = false;
}

clast_status clast_gpu_release(clast_gpu_commands *commands)
{
    clast_status status = commands->status;
    clast_context *context = commands->gpu->context;
    end_label(commands);
    clast_gpu_free_staging(commands);
    clast_free(context, commands->deliveries);
    clast_free(context, commands);
    return status;
}

void clast_gpu_note(clast_gpu_commands *commands, clast_status status)
{
    commands->status = commands->status == CLAST_OK ? status : commands->status;
}

VkCommandBuffer clast_gpu_command_buffer(const clast_gpu_commands *commands)
{
    return commands->buffer;
}

clast_gpu *clast_gpu_of(const clast_gpu_commands *commands)
{
    return commands->gpu;
}

// A time at the end of what was recorded; `pass` begins there.
static void stamp(clast_gpu_commands *commands, const char *pass)
{
    clast_gpu *gpu = commands->gpu;
    if (commands->queries != VK_NULL_HANDLE && commands->pass_count < GPU_QUERIES) {
        gpu->vk.vkCmdWriteTimestamp2(commands->buffer, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, commands->queries,
                                     commands->pass_count);
        commands->passes[commands->pass_count++] = pass;
    }
}

void clast_gpu_pass(clast_gpu_commands *commands, const char *name)
{
    clast_gpu *gpu = commands->gpu;
    end_label(commands);
    if (commands->pass_count < GPU_QUERIES - 1) { // the last is for the end
        stamp(commands, name);
    }
    if (gpu->vk.vkCmdBeginDebugUtilsLabelEXT != NULL) {
        VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
        gpu->vk.vkCmdBeginDebugUtilsLabelEXT(commands->buffer, &label);
        commands->is_labelled = true;
    }
}

void clast_gpu_barrier(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    VkAccessFlags2 writes = VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT;
    VkAccessFlags2 reads = VK_ACCESS_2_SHADER_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT;
    if (gpu->features.ray_tracing) {
        stages |= VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR |
                  VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
        writes |= VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
        reads |= VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR;
    }
    VkMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
        .srcStageMask = stages,
        .srcAccessMask = writes,
        .dstStageMask = stages | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
        .dstAccessMask = reads | writes | VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT,
    };
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &barrier};
    gpu->vk.vkCmdPipelineBarrier2(commands->buffer, &info);
}

void clast_gpu_run(clast_gpu_commands *commands, const clast_gpu_call *call)
{
    clast_gpu *gpu = commands->gpu;
    if (commands->status != CLAST_OK || (call->indirect == NULL && call->groups == 0)) {
        return;
    }
    if (call->groups > (uint64_t)GROUPS_ACROSS * GROUPS_ACROSS) {
        clast_gpu_note(commands, clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: kernel %s has %llu work groups",
                                            clast_shader_codes[call->shader].file, (unsigned long long)call->groups));
        return;
    }
    VkPipeline pipeline;
    clast_status status = clast_gpu_kernel_of(gpu, call, &pipeline);
    if (status != CLAST_OK) {
        clast_gpu_note(commands, status);
        return;
    }
    gpu->vk.vkCmdBindPipeline(commands->buffer, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    if (call->push_bytes != 0) {
        gpu->vk.vkCmdPushConstants(commands->buffer, gpu->pipeline_layout, VK_SHADER_STAGE_COMPUTE_BIT, 0,
                                   call->push_bytes, call->push);
    }
    if (call->indirect != NULL) {
        gpu->vk.vkCmdDispatchIndirect(commands->buffer, call->indirect->handle,
                                      call->indirect->offset + call->indirect_offset);
        return;
    }
    uint32_t down = (uint32_t)((call->groups + GROUPS_ACROSS - 1) / GROUPS_ACROSS);
    uint32_t across = (uint32_t)((call->groups + down - 1) / down);
    gpu->vk.vkCmdDispatch(commands->buffer, across, down, 1);
}

// -------------------------------------------------------------------------------------------- submitting and waiting

static clast_status submit_buffer(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    VkMemoryBarrier2 to_host = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                .srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                .dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT,
                                .dstAccessMask = VK_ACCESS_2_HOST_READ_BIT};
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &to_host};
    gpu->vk.vkCmdPipelineBarrier2(commands->buffer, &info);
    VkResult result = gpu->vk.vkEndCommandBuffer(commands->buffer);
    if (result != VK_SUCCESS) {
        return clast_gpu_fail(gpu, result, "ending a command buffer");
    }
    VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                        .commandBuffer = commands->buffer};
    VkSemaphoreSubmitInfo signal = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO,
                                    .semaphore = gpu->timeline,
                                    .value = gpu->ticket + 1,
                                    .stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT};
    VkSubmitInfo2 submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                            .commandBufferInfoCount = 1,
                            .pCommandBufferInfos = &buffer,
                            .signalSemaphoreInfoCount = 1,
                            .pSignalSemaphoreInfos = &signal};
    result = gpu->vk.vkQueueSubmit2(gpu->queue, 1, &submit, VK_NULL_HANDLE);
    if (result != VK_SUCCESS) {
        return clast_gpu_fail(gpu, result, "submitting commands");
    }
    commands->ticket = ++gpu->ticket;
    return CLAST_OK;
}

clast_status clast_gpu_submit(clast_gpu_commands *commands, uint64_t *ticket)
{
    clast_gpu *gpu = commands->gpu;
    end_label(commands);
    if (commands->pass_count != 0) {
        stamp(commands, NULL);
    }
    clast_status status = commands->status;
    if (status == CLAST_OK) {
        status = submit_buffer(commands);
    } else {
        gpu->vk.vkEndCommandBuffer(commands->buffer);
    }
    if (status != CLAST_OK) {
        commands->delivery_count = 0;
        commands->pass_count = 0;
    }
    commands->is_recording = false;
    *ticket = commands->ticket;
    return status;
}

clast_status clast_gpu_update_reached(clast_gpu *gpu)
{
    // what the semaphore stands at is known to be reached only by waiting for it: a wait for the last ticket
    VkSemaphoreWaitInfo wait = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                .semaphoreCount = 1,
                                .pSemaphores = &gpu->timeline,
                                .pValues = &gpu->ticket};
    VkResult result = gpu->vk.vkWaitSemaphores(gpu->device, &wait, UINT64_MAX);
    if (result != VK_SUCCESS) {
        return clast_gpu_fail(gpu, result, "waiting for the device");
    }
    gpu->reached = gpu->ticket;
    return CLAST_OK;
}

void clast_gpu_deliver(clast_gpu_commands *commands)
{
    for (size_t i = 0; i < commands->delivery_count; i++) {
        const clast_gpu_delivery *delivery = &commands->deliveries[i];
        memcpy(delivery->to, delivery->from, delivery->bytes);
    }
    commands->delivery_count = 0;
    for (int direction = 0; direction < 2; direction++) {
        for (size_t i = 0; i < commands->staging_count[direction]; i++) {
            commands->staging[direction][i].used = 0;
        }
        commands->staged[direction] = 0;
    }
}

static void add_time(clast_gpu *gpu, const char *pass, double milliseconds)
{
    uint32_t i = 0;
    while (i < gpu->time_count && strcmp(gpu->times[i].pass, pass) != 0) {
        i++;
    }
    if (i == gpu->time_count) {
        if (gpu->time_count == CLAST_GPU_TIMES) {
            return;
        }
        gpu->times[gpu->time_count++] = (clast_gpu_time){pass, 0.0};
    }
    gpu->times[i].milliseconds += milliseconds;
}

// `*first`: times of an earlier wait are still there.
static void read_times(clast_gpu_commands *commands, bool *first)
{
    clast_gpu *gpu = commands->gpu;
    uint64_t values[GPU_QUERIES];
    if (commands->pass_count < 2 ||
        gpu->vk.vkGetQueryPoolResults(gpu->device, commands->queries, 0, commands->pass_count, sizeof values, values,
                                      sizeof *values, VK_QUERY_RESULT_64_BIT) != VK_SUCCESS) {
        return;
    }
    gpu->time_count = *first ? 0 : gpu->time_count;
    *first = false;
    for (uint32_t i = 0; i + 1 < commands->pass_count; i++) {
        double steps = (double)(values[i + 1] - values[i]);
        add_time(gpu, commands->passes[i], steps * (double)gpu->features.timestamp_period * 1e-6);
    }
    commands->pass_count = 0;
}

clast_status clast_gpu_wait(clast_gpu *gpu, uint64_t ticket)
{
    if (gpu->is_lost) {
        return clast_gpu_fail(gpu, VK_ERROR_DEVICE_LOST, "waiting for the device");
    }
    if (ticket > gpu->reached) {
        VkSemaphoreWaitInfo wait = {.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO,
                                    .semaphoreCount = 1,
                                    .pSemaphores = &gpu->timeline,
                                    .pValues = &ticket};
        VkResult result = gpu->vk.vkWaitSemaphores(gpu->device, &wait, UINT64_MAX);
        if (result != VK_SUCCESS) {
            return clast_gpu_fail(gpu, result, "waiting for the device");
        }
        gpu->reached = ticket;
    }
    bool first = true;
    for (int i = 0; i < GPU_COMMANDS; i++) {
        clast_gpu_commands *commands = &gpu->commands[i];
        if (!commands->is_recording && commands->ticket <= gpu->reached) {
            clast_gpu_deliver(commands);
            read_times(commands, &first);
        }
    }
    clast_gpu_let_go(gpu);
    return CLAST_OK;
}

clast_status clast_gpu_finish(clast_gpu_commands *commands)
{
    uint64_t ticket;
    clast_gpu *gpu = commands->gpu;
    clast_status status = clast_gpu_submit(commands, &ticket);
    return status == CLAST_OK ? clast_gpu_wait(gpu, ticket) : status;
}

void clast_gpu_flush(clast_gpu_commands *commands)
{
    clast_gpu *gpu = commands->gpu;
    if (commands->status != CLAST_OK || commands->pool == VK_NULL_HANDLE) {
        return;
    }
    bool labelled = commands->is_labelled;
    end_label(commands);
    clast_status status = submit_buffer(commands);
    if (status == CLAST_OK) {
        status = clast_gpu_update_reached(gpu);
    }
    if (status == CLAST_OK) {
        clast_gpu_deliver(commands);
        status = open_buffer(commands);
    }
    if (status == CLAST_OK) {
        bind_textures(commands);
        clast_gpu_barrier(commands);
        if (labelled && commands->pass_count != 0) { // the pass goes on
            VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
                                          .pLabelName = commands->passes[commands->pass_count - 1]};
            gpu->vk.vkCmdBeginDebugUtilsLabelEXT(commands->buffer, &label);
            commands->is_labelled = true;
        }
    }
    clast_gpu_note(commands, status);
}

uint32_t clast_gpu_passes(const clast_gpu *gpu, clast_gpu_time times[CLAST_GPU_TIMES])
{
    memcpy(times, gpu->times, gpu->time_count * sizeof *times);
    return gpu->time_count;
}
