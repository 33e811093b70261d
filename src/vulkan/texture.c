// SPDX-License-Identifier: Apache-2.0
// Pictures with levels, which kernels reach by number.
#include "vulkan/device.h"

#include <string.h>

bool clast_gpu_can_read(const clast_gpu *gpu, VkFormat format)
{
    bool is_compressed = format >= VK_FORMAT_BC1_RGB_UNORM_BLOCK && format <= VK_FORMAT_BC7_SRGB_BLOCK;
    if (is_compressed && !gpu->has_compression) {
        return false; // the device may know it, and was not made for it
    }
    VkFormatProperties properties;
    gpu->vk.vkGetPhysicalDeviceFormatProperties(gpu->physical_device, format, &properties);
    const VkFormatFeatureFlags needed = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_TRANSFER_DST_BIT;
    return (properties.optimalTilingFeatures & needed) == needed;
}

static clast_status take_number(clast_gpu *gpu, const char *name, uint32_t *number)
{
    if (gpu->free_number_count != 0) {
        *number = gpu->free_numbers[--gpu->free_number_count];
        return CLAST_OK;
    }
    if (gpu->picture_count == gpu->features.textures) {
        return clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: %s is one texture more than the %u that fit", name,
                          gpu->features.textures);
    }
    // room in the list of free numbers is made now, so that freeing needs no memory
    clast_status status = CLAST_RESERVE(gpu->context, gpu->pictures, gpu->picture_capacity, gpu->picture_count + 1);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(gpu->context, gpu->free_numbers, gpu->free_number_capacity, gpu->picture_count + 1);
    }
    if (status == CLAST_OK) {
        *number = (uint32_t)gpu->picture_count++;
    }
    return status;
}

static VkResult make_image(clast_gpu *gpu, const clast_gpu_texture_desc *desc, clast_gpu_picture *picture)
{
    VkImageCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                .imageType = VK_IMAGE_TYPE_2D,
                                .format = desc->format,
                                .extent = {desc->width, desc->height, 1},
                                .mipLevels = desc->levels,
                                .arrayLayers = 1,
                                .samples = VK_SAMPLE_COUNT_1_BIT,
                                .tiling = VK_IMAGE_TILING_OPTIMAL,
                                .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    return gpu->vk.vkCreateImage(gpu->device, &create, NULL, &picture->image);
}

static VkResult make_view(clast_gpu *gpu, const clast_gpu_texture_desc *desc, clast_gpu_picture *picture)
{
    VkResult result = gpu->vk.vkBindImageMemory(gpu->device, picture->image, picture->block->memory, picture->offset);
    if (result != VK_SUCCESS) {
        return result;
    }
    VkImageViewCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                    .image = picture->image,
                                    .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                    .format = desc->format,
                                    .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, desc->levels, 0, 1}};
    return gpu->vk.vkCreateImageView(gpu->device, &create, NULL, &picture->view);
}

static void describe(clast_gpu *gpu, uint32_t number)
{
    VkDescriptorImageInfo image = {.imageView = gpu->pictures[number].view,
                                   .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
    VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                  .dstSet = gpu->set,
                                  .dstArrayElement = number,
                                  .descriptorCount = 1,
                                  .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                  .pImageInfo = &image};
    gpu->vk.vkUpdateDescriptorSets(gpu->device, 1, &write, 0, NULL);
}

static clast_status fill_picture(clast_gpu *gpu, const clast_gpu_texture_desc *desc, clast_gpu_picture *picture)
{
    VkResult result = make_image(gpu, desc, picture);
    if (result != VK_SUCCESS) {
        picture->image = VK_NULL_HANDLE;
        return clast_gpu_fail(gpu, result, desc->name);
    }
    VkMemoryRequirements needs;
    gpu->vk.vkGetImageMemoryRequirements(gpu->device, picture->image, &needs);
    clast_status status = clast_gpu_take(gpu, CLAST_GPU_DEVICE, true, needs.memoryTypeBits, needs.size, needs.alignment,
                                         desc->name, &picture->block, &picture->offset);
    if (status != CLAST_OK) {
        return status;
    }
    picture->bytes = needs.size;
    result = make_view(gpu, desc, picture);
    if (result != VK_SUCCESS) {
        picture->view = VK_NULL_HANDLE;
        return clast_gpu_fail(gpu, result, desc->name);
    }
    return CLAST_OK;
}

static void leave(clast_gpu *gpu, uint32_t number)
{
    clast_gpu_picture *picture = &gpu->pictures[number];
    if (picture->block != NULL) {
        clast_gpu_leave(gpu, &(clast_gpu_leaving){.block = picture->block,
                                                  .offset = picture->offset,
                                                  .bytes = picture->bytes,
                                                  .image = picture->image,
                                                  .view = picture->view,
                                                  .number = number});
    } else {
        gpu->vk.vkDestroyImage(gpu->device, picture->image, NULL);
        gpu->free_numbers[gpu->free_number_count++] = number;
    }
    *picture = (clast_gpu_picture){0};
}

void clast_gpu_free_picture(clast_gpu *gpu, const clast_gpu_leaving *leaving)
{
    gpu->vk.vkDestroyImageView(gpu->device, leaving->view, NULL);
    gpu->vk.vkDestroyImage(gpu->device, leaving->image, NULL);
    gpu->free_numbers[gpu->free_number_count++] = leaving->number;
}

clast_status clast_gpu_texture_create(clast_gpu *gpu, const clast_gpu_texture_desc *desc, clast_gpu_texture *texture)
{
    texture->number = CLAST_NONE;
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    gpu->vk.vkGetPhysicalDeviceProperties2(gpu->physical_device, &properties);
    uint32_t most = properties.properties.limits.maxImageDimension2D;
    if (desc->width > most || desc->height > most) {
        return clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: %s has %u x %u texels; the device allows %u a side",
                          desc->name, desc->width, desc->height, most);
    }
    if (!clast_gpu_can_read(gpu, desc->format)) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED, "vulkan: %s: the device cannot read format %d",
                          desc->name, (int)desc->format);
    }
    uint32_t number = CLAST_NONE;
    clast_status status = take_number(gpu, desc->name, &number);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_picture *picture = &gpu->pictures[number];
    *picture = (clast_gpu_picture){.width = desc->width, .height = desc->height, .levels = desc->levels};
    status = fill_picture(gpu, desc, picture);
    if (status != CLAST_OK) {
        leave(gpu, number);
        return status;
    }
    describe(gpu, number);
    texture->number = number;
    return CLAST_OK;
}

void clast_gpu_texture_destroy(clast_gpu *gpu, clast_gpu_texture *texture)
{
    if (texture->number != CLAST_NONE) {
        leave(gpu, texture->number);
    }
    texture->number = CLAST_NONE;
}

static void change_layout(clast_gpu_commands *commands, VkImage image, uint32_t level, bool begins)
{
    const VkPipelineStageFlags2 copies = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    const VkPipelineStageFlags2 kernels = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    VkImageMemoryBarrier2 barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
        .srcStageMask = begins ? kernels | copies : copies,
        .srcAccessMask = begins ? 0 : VK_ACCESS_2_TRANSFER_WRITE_BIT,
        .dstStageMask = begins ? copies : kernels | copies,
        .dstAccessMask = begins ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_READ_BIT,
        .oldLayout = begins ? VK_IMAGE_LAYOUT_UNDEFINED : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
        .newLayout = begins ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, level, 1, 0, 1}};
    VkDependencyInfo info = {
        .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    commands->gpu->vk.vkCmdPipelineBarrier2(commands->buffer, &info);
}

void clast_gpu_texture_write(clast_gpu_commands *commands, clast_gpu_texture texture, uint32_t level, const void *data,
                             uint64_t bytes)
{
    clast_gpu *gpu = commands->gpu;
    clast_gpu_buffer piece;
    if (commands->status != CLAST_OK || !clast_gpu_stage(commands, 0, bytes, &piece)) {
        return;
    }
    const clast_gpu_picture *picture = &gpu->pictures[texture.number];
    uint32_t width = picture->width >> level, height = picture->height >> level;
    memcpy(piece.mapped, data, bytes);
    change_layout(commands, picture->image, level, true);
    VkBufferImageCopy region = {.bufferOffset = piece.offset,
                                .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, level, 0, 1},
                                .imageExtent = {width != 0 ? width : 1, height != 0 ? height : 1, 1}};
    gpu->vk.vkCmdCopyBufferToImage(commands->buffer, piece.handle, picture->image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                   1, &region);
    change_layout(commands, picture->image, level, false);
}

void clast_gpu_free_textures(clast_gpu *gpu)
{
    for (size_t i = 0; i < gpu->picture_count; i++) {
        clast_gpu_picture *picture = &gpu->pictures[i];
        if (picture->image != VK_NULL_HANDLE) {
            gpu->vk.vkDestroyImageView(gpu->device, picture->view, NULL);
            gpu->vk.vkDestroyImage(gpu->device, picture->image, NULL);
        }
    }
    for (size_t i = 0; i < gpu->leaving_count; i++) {
        if (gpu->leaving[i].number != CLAST_NONE) {
            gpu->vk.vkDestroyImageView(gpu->device, gpu->leaving[i].view, NULL);
            gpu->vk.vkDestroyImage(gpu->device, gpu->leaving[i].image, NULL);
        }
        if (gpu->leaving[i].structure != VK_NULL_HANDLE) {
            gpu->vk.vkDestroyAccelerationStructureKHR(gpu->device, gpu->leaving[i].structure, NULL);
        }
    }
    gpu->leaving_count = 0;
    clast_free(gpu->context, gpu->pictures);
    clast_free(gpu->context, gpu->free_numbers);
    gpu->pictures = NULL;
    gpu->free_numbers = NULL;
    gpu->picture_count = gpu->free_number_count = 0;
}
