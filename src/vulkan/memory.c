// SPDX-License-Identifier: Apache-2.0
// Buffers are ranges of large blocks of memory: drivers allow few allocations, and each is slow.
#include "vulkan/device.h"

#include <string.h>

static const uint64_t block_bytes_usual = (uint64_t)64 << 20;
static const uint64_t buffer_alignment = 256;

static uint64_t round_up(uint64_t bytes, uint64_t step)
{
    return (bytes + step - 1) / step * step;
}

// ------------------------------------------------------------------------------------------------------------ blocks

static uint32_t type_for(const clast_gpu *gpu, clast_gpu_memory use, uint32_t types)
{
    const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkMemoryPropertyFlags must = use == CLAST_GPU_DEVICE ? 0 : host;
    const VkMemoryPropertyFlags good = use == CLAST_GPU_DEVICE     ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                                       : use == CLAST_GPU_READBACK ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                                                   : 0;
    // memory that both see is often scarce, or slow for one: what is not asked for counts against a type
    const VkMemoryPropertyFlags bad = use == CLAST_GPU_DEVICE   ? VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT
                                      : use == CLAST_GPU_UPLOAD ? VK_MEMORY_PROPERTY_HOST_CACHED_BIT
                                                                : VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    uint32_t best = CLAST_NONE;
    int best_points = -1;
    for (uint32_t i = 0; i < gpu->memory.memoryTypeCount; i++) {
        VkMemoryPropertyFlags flags = gpu->memory.memoryTypes[i].propertyFlags;
        int points = ((flags & good) == good ? 2 : 0) + ((flags & bad) == 0 ? 1 : 0);
        if ((types >> i & 1) != 0 && (flags & must) == must && points > best_points) {
            best = i;
            best_points = points;
        }
    }
    return best;
}

static void free_block(clast_gpu *gpu, clast_gpu_block *block)
{
    gpu->vk.vkDestroyBuffer(gpu->device, block->buffer, NULL);
    gpu->vk.vkFreeMemory(gpu->device, block->memory, NULL);
    gpu->block_bytes -= block->memory != VK_NULL_HANDLE ? block->bytes : 0;
    clast_free(gpu->context, block->ranges);
    clast_free(gpu->context, block);
}

static bool is_all_free(const clast_gpu_block *block)
{
    return block->range_count == 1 && block->ranges[0].bytes == block->bytes;
}

static void free_empty_blocks(clast_gpu *gpu, bool all)
{
    for (clast_gpu_block **at = &gpu->blocks; *at != NULL;) {
        clast_gpu_block *block = *at;
        if (is_all_free(block) && (all || block->bytes > block_bytes_usual)) {
            *at = block->next;
            free_block(gpu, block);
        } else {
            at = &block->next;
        }
    }
}

void clast_gpu_free_blocks(clast_gpu *gpu)
{
    while (gpu->blocks != NULL) {
        clast_gpu_block *block = gpu->blocks;
        gpu->blocks = block->next;
        free_block(gpu, block);
    }
}

static VkResult make_buffer(clast_gpu *gpu, clast_gpu_block *block, uint32_t *types)
{
    VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                               VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                               VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    if (gpu->features.ray_tracing) {
        usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR | VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR;
    }
    VkBufferCreateInfo create = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = block->bytes, .usage = usage};
    VkResult result = gpu->vk.vkCreateBuffer(gpu->device, &create, NULL, &block->buffer);
    if (result == VK_SUCCESS) {
        VkMemoryRequirements needs;
        gpu->vk.vkGetBufferMemoryRequirements(gpu->device, block->buffer, &needs);
        *types = needs.memoryTypeBits;
        block->bytes = needs.size < block->bytes ? needs.size : block->bytes;
    }
    return result;
}

static VkResult allocate_block(clast_gpu *gpu, clast_gpu_block *block)
{
    VkMemoryAllocateFlagsInfo flags = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO,
                                       .flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT};
    uint64_t bytes = block->bytes;
    if (!block->is_for_pictures) {
        VkMemoryRequirements needs;
        gpu->vk.vkGetBufferMemoryRequirements(gpu->device, block->buffer, &needs);
        bytes = needs.size;
    }
    VkMemoryAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                     .pNext = block->is_for_pictures ? NULL : &flags,
                                     .allocationSize = bytes,
                                     .memoryTypeIndex = block->type};
    VkResult result = gpu->vk.vkAllocateMemory(gpu->device, &allocate, NULL, &block->memory);
    if (result != VK_SUCCESS) {
        block->memory = VK_NULL_HANDLE;
        return result;
    }
    gpu->block_bytes += block->bytes;
    if (block->is_for_pictures) {
        return VK_SUCCESS;
    }
    result = gpu->vk.vkBindBufferMemory(gpu->device, block->buffer, block->memory, 0);
    if (result == VK_SUCCESS && block->use != CLAST_GPU_DEVICE) {
        void *mapped = NULL;
        result = gpu->vk.vkMapMemory(gpu->device, block->memory, 0, VK_WHOLE_SIZE, 0, &mapped);
        block->mapped = mapped;
    }
    if (result == VK_SUCCESS) {
        VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO,
                                          .buffer = block->buffer};
        block->address = gpu->vk.vkGetBufferDeviceAddress(gpu->device, &info);
    }
    return result;
}

// A block of at least so many bytes, all free, put first in the list.
static VkResult add_block(clast_gpu *gpu, clast_gpu_memory use, bool pictures, uint32_t types, uint64_t bytes)
{
    clast_gpu_block *block = clast_allocate_zeroed(gpu->context, 1, sizeof *block);
    if (block == NULL || CLAST_RESERVE(gpu->context, block->ranges, block->range_capacity, 8) != CLAST_OK) {
        clast_free(gpu->context, block);
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    }
    block->use = use;
    block->is_for_pictures = pictures;
    block->bytes = bytes;
    VkResult result = pictures ? VK_SUCCESS : make_buffer(gpu, block, &types);
    if (result == VK_SUCCESS) {
        block->type = type_for(gpu, use, types);
        result = block->type != CLAST_NONE ? allocate_block(gpu, block) : VK_ERROR_OUT_OF_DEVICE_MEMORY;
    }
    if (result != VK_SUCCESS) {
        free_block(gpu, block);
        return result;
    }
    block->ranges[0] = (clast_gpu_range){0, block->bytes};
    block->range_count = 1;
    block->next = gpu->blocks;
    gpu->blocks = block;
    return VK_SUCCESS;
}

// ------------------------------------------------------------------------------------------------------------ ranges

static void remove_range(clast_gpu_block *block, size_t i)
{
    memmove(&block->ranges[i], &block->ranges[i + 1], (block->range_count - i - 1) * sizeof *block->ranges);
    block->range_count--;
}

// Takes from the first range that is large enough. Room for one more range is made before, so that giving back never
// needs memory.
static bool take_range(clast_gpu *gpu, clast_gpu_block *block, uint64_t bytes, uint64_t alignment, uint64_t *offset)
{
    for (size_t i = 0; i < block->range_count; i++) {
        clast_gpu_range range = block->ranges[i];
        uint64_t start = round_up(range.offset, alignment), skipped = start - range.offset;
        if (range.bytes < skipped || range.bytes - skipped < bytes) {
            continue;
        }
        if (CLAST_RESERVE(gpu->context, block->ranges, block->range_capacity, 2 * block->range_count + 8) != CLAST_OK) {
            return false;
        }
        uint64_t left = range.bytes - skipped - bytes;
        if (skipped != 0 && left != 0) {
            memmove(&block->ranges[i + 1], &block->ranges[i], (block->range_count - i) * sizeof *block->ranges);
            block->range_count++;
            block->ranges[i] = (clast_gpu_range){range.offset, skipped};
            block->ranges[i + 1] = (clast_gpu_range){start + bytes, left};
        } else if (skipped != 0) {
            block->ranges[i].bytes = skipped;
        } else if (left != 0) {
            block->ranges[i] = (clast_gpu_range){start + bytes, left};
        } else {
            remove_range(block, i);
        }
        *offset = start;
        return true;
    }
    return false;
}

static void give_range(clast_gpu *gpu, clast_gpu_block *block, uint64_t offset, uint64_t bytes)
{
    size_t i = 0;
    while (i < block->range_count && block->ranges[i].offset < offset) {
        i++;
    }
    bool joins_before = i > 0 && block->ranges[i - 1].offset + block->ranges[i - 1].bytes == offset;
    bool joins_after = i < block->range_count && offset + bytes == block->ranges[i].offset;
    if (joins_before) {
        block->ranges[i - 1].bytes += bytes;
        if (joins_after) {
            block->ranges[i - 1].bytes += block->ranges[i].bytes;
            remove_range(block, i);
        }
    } else if (joins_after) {
        block->ranges[i].offset = offset;
        block->ranges[i].bytes += bytes;
    } else if (CLAST_RESERVE(gpu->context, block->ranges, block->range_capacity, block->range_count + 1) == CLAST_OK) {
        memmove(&block->ranges[i + 1], &block->ranges[i], (block->range_count - i) * sizeof *block->ranges);
        block->ranges[i] = (clast_gpu_range){offset, bytes};
        block->range_count++;
    } // else the range stays taken until the block goes
}

static bool take_from_blocks(clast_gpu *gpu, clast_gpu_memory use, bool pictures, uint32_t types, uint64_t bytes,
                             uint64_t alignment, clast_gpu_block **block, uint64_t *offset)
{
    for (clast_gpu_block *b = gpu->blocks; b != NULL; b = b->next) {
        bool fits = b->use == use && b->is_for_pictures == pictures && (types >> b->type & 1) != 0;
        if (fits && take_range(gpu, b, bytes, alignment, offset)) {
            *block = b;
            return true;
        }
    }
    return false;
}

static VkResult take_new(clast_gpu *gpu, clast_gpu_memory use, bool pictures, uint32_t types, uint64_t bytes)
{
    if (gpu->desc.memory_limit != 0 && use == CLAST_GPU_DEVICE &&
        (bytes > gpu->desc.memory_limit || gpu->block_bytes > gpu->desc.memory_limit - bytes)) {
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    }
    bool large = bytes > block_bytes_usual / 4;
    bool tight = gpu->desc.memory_limit != 0 && gpu->desc.memory_limit - gpu->block_bytes < 4 * block_bytes_usual;
    VkResult result = add_block(gpu, use, pictures, types, large || tight ? bytes : block_bytes_usual);
    return result == VK_SUCCESS || large || tight ? result : add_block(gpu, use, pictures, types, bytes);
}

clast_status clast_gpu_take(clast_gpu *gpu, clast_gpu_memory use, bool pictures, uint32_t types, uint64_t bytes,
                            uint64_t alignment, const char *name, clast_gpu_block **block, uint64_t *offset)
{
    if (gpu->is_lost) {
        return clast_gpu_fail(gpu, VK_ERROR_DEVICE_LOST, name);
    }
    if (bytes > gpu->largest_allocation) {
        return clast_fail(gpu->context, CLAST_ERROR_OUT_OF_MEMORY,
                          "vulkan: %s needs %llu bytes in one piece; the device allows %llu", name,
                          (unsigned long long)bytes, (unsigned long long)gpu->largest_allocation);
    }
    if (take_from_blocks(gpu, use, pictures, types, bytes, alignment, block, offset)) {
        return CLAST_OK;
    }
    VkResult result = take_new(gpu, use, pictures, types, bytes);
    if (result != VK_SUCCESS && gpu->leaving_count != 0) { // what left may make room
        gpu->vk.vkDeviceWaitIdle(gpu->device);
        clast_gpu_update_reached(gpu);
        clast_gpu_let_go(gpu);
        if (take_from_blocks(gpu, use, pictures, types, bytes, alignment, block, offset)) {
            return CLAST_OK;
        }
    }
    if (result != VK_SUCCESS) {
        free_empty_blocks(gpu, true);
        result = take_new(gpu, use, pictures, types, bytes);
    }
    if (result != VK_SUCCESS) {
        return clast_fail(gpu->context, result == VK_ERROR_DEVICE_LOST ? CLAST_ERROR_DEVICE : CLAST_ERROR_OUT_OF_MEMORY,
                          "vulkan: %s: no room for %llu bytes beside the %llu that are held", name,
                          (unsigned long long)bytes, (unsigned long long)gpu->block_bytes);
    }
    if (!take_range(gpu, gpu->blocks, bytes, alignment, offset)) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *block = gpu->blocks;
    return CLAST_OK;
}

// ----------------------------------------------------------------------------------------------------------- buffers

clast_status clast_gpu_allocate(clast_gpu *gpu, clast_gpu_memory memory, uint64_t bytes, const char *name,
                                clast_gpu_buffer *buffer)
{
    *buffer = (clast_gpu_buffer){0};
    if (bytes > UINT64_MAX / 2) {
        return clast_fail(gpu->context, CLAST_ERROR_OUT_OF_MEMORY, "vulkan: %s needs more than there can be", name);
    }
    bytes = bytes == 0 ? 16 : round_up(bytes, 16);
    if (gpu->desc.size_hook.size != NULL && memory == CLAST_GPU_DEVICE) {
        bytes = round_up(gpu->desc.size_hook.size(gpu->desc.size_hook.user, name, bytes), 16);
    }
    clast_gpu_block *block;
    uint64_t offset;
    uint64_t taken = round_up(bytes, buffer_alignment);
    clast_status status = clast_gpu_take(gpu, memory, false, UINT32_MAX, taken, buffer_alignment, name, &block,
                                         &offset);
    if (status != CLAST_OK) {
        return status;
    }
    *buffer = (clast_gpu_buffer){
        .bytes = bytes,
        .address = block->address + offset,
        .mapped = block->mapped != NULL ? block->mapped + offset : NULL,
        .handle = block->buffer,
        .offset = offset,
        .block = block,
    };
    gpu->buffer_bytes += bytes;
    gpu->buffer_bytes_peak = gpu->buffer_bytes > gpu->buffer_bytes_peak ? gpu->buffer_bytes : gpu->buffer_bytes_peak;
    return CLAST_OK;
}

void clast_gpu_free(clast_gpu *gpu, clast_gpu_buffer *buffer)
{
    if (buffer->block != NULL) {
        gpu->buffer_bytes -= buffer->bytes;
        clast_gpu_leave(gpu, &(clast_gpu_leaving){.block = buffer->block,
                                                  .offset = buffer->offset,
                                                  .bytes = round_up(buffer->bytes, buffer_alignment),
                                                  .number = CLAST_NONE});
    }
    *buffer = (clast_gpu_buffer){0};
}

clast_status clast_gpu_reserve(clast_gpu *gpu, clast_gpu_memory memory, uint64_t bytes, const char *name,
                               clast_gpu_buffer *buffer)
{
    if (buffer->block != NULL && buffer->bytes >= bytes) {
        return CLAST_OK;
    }
    uint64_t grown = buffer->bytes + buffer->bytes / 2;
    clast_gpu_free(gpu, buffer);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    bool may_grow = gpu->desc.memory_limit == 0 && gpu->desc.size_hook.size == NULL;
    if (grown > bytes && grown <= gpu->largest_allocation && may_grow) {
        status = clast_gpu_allocate(gpu, memory, grown, name, buffer);
    }
    return status == CLAST_OK ? status : clast_gpu_allocate(gpu, memory, bytes, name, buffer);
}

uint64_t clast_gpu_bytes(const clast_gpu *gpu)
{
    return gpu->buffer_bytes;
}

uint64_t clast_gpu_bytes_peak(const clast_gpu *gpu)
{
    return gpu->buffer_bytes_peak;
}

// ----------------------------------------------------------------------------------------------------------- leaving

static void let_one_go(clast_gpu *gpu, const clast_gpu_leaving *leaving)
{
    if (leaving->structure != VK_NULL_HANDLE) {
        gpu->vk.vkDestroyAccelerationStructureKHR(gpu->device, leaving->structure, NULL);
        return;
    }
    if (leaving->number != CLAST_NONE) {
        clast_gpu_free_picture(gpu, leaving);
    }
    give_range(gpu, leaving->block, leaving->offset, leaving->bytes);
}

void clast_gpu_let_go(clast_gpu *gpu)
{
    size_t kept = 0;
    for (size_t i = 0; i < gpu->leaving_count; i++) {
        if (gpu->leaving[i].ticket <= gpu->reached) {
            let_one_go(gpu, &gpu->leaving[i]);
        } else {
            gpu->leaving[kept++] = gpu->leaving[i];
        }
    }
    gpu->leaving_count = kept;
    free_empty_blocks(gpu, false);
}

void clast_gpu_collect(clast_gpu *gpu)
{
    for (size_t i = 0; i < gpu->leaving_count; i++) {
        gpu->leaving[i].ticket = 0;
    }
    clast_gpu_let_go(gpu);
}

void clast_gpu_leave(clast_gpu *gpu, const clast_gpu_leaving *leaving)
{
    bool recording = false;
    for (int i = 0; i < GPU_COMMANDS; i++) {
        recording = recording || gpu->commands[i].is_recording;
    }
    clast_gpu_leaving last = *leaving;
    last.ticket = gpu->ticket + (recording ? 1 : 0); // what is being recorded may name it
    if (gpu->is_foreign) {
        last.ticket = UINT64_MAX; // so may commands of the caller, who tells when these have run
    }
    if (last.ticket <= gpu->reached) {
        let_one_go(gpu, &last);
        return;
    }
    if (CLAST_RESERVE(gpu->context, gpu->leaving, gpu->leaving_capacity, gpu->leaving_count + 1) != CLAST_OK) {
        gpu->vk.vkDeviceWaitIdle(gpu->device); // without a place to note it, wait
        if (!recording) {
            let_one_go(gpu, &last);
        }
        return; // else its range stays taken until the device is closed
    }
    gpu->leaving[gpu->leaving_count++] = last;
}
