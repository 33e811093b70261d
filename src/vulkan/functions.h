// SPDX-License-Identifier: Apache-2.0
// Vulkan's types, and its functions as members of structs: the loader is opened at run time, so that nothing links it.
#ifndef CLAST_VULKAN_FUNCTIONS_H
#define CLAST_VULKAN_FUNCTIONS_H

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

// Before there is an instance.
#define CLAST_VULKAN_LOADER_FUNCTIONS(X) \
    X(vkCreateInstance) \
    X(vkEnumerateInstanceExtensionProperties) \
    X(vkEnumerateInstanceLayerProperties) \
    X(vkEnumerateInstanceVersion)

#define CLAST_VULKAN_INSTANCE_FUNCTIONS(X) \
    X(vkCreateDevice) \
    X(vkDestroyInstance) \
    X(vkEnumerateDeviceExtensionProperties) \
    X(vkEnumeratePhysicalDevices) \
    X(vkGetDeviceProcAddr) \
    X(vkGetPhysicalDeviceFeatures2) \
    X(vkGetPhysicalDeviceFormatProperties) \
    X(vkGetPhysicalDeviceMemoryProperties2) \
    X(vkGetPhysicalDeviceProperties2) \
    X(vkGetPhysicalDeviceQueueFamilyProperties)

#define CLAST_VULKAN_DEVICE_FUNCTIONS(X) \
    X(vkAllocateCommandBuffers) \
    X(vkAllocateDescriptorSets) \
    X(vkAllocateMemory) \
    X(vkBeginCommandBuffer) \
    X(vkBindBufferMemory) \
    X(vkBindImageMemory) \
    X(vkCmdBindDescriptorSets) \
    X(vkCmdBindPipeline) \
    X(vkCmdCopyBuffer) \
    X(vkCmdCopyBufferToImage) \
    X(vkCmdDispatch) \
    X(vkCmdDispatchIndirect) \
    X(vkCmdFillBuffer) \
    X(vkCmdPipelineBarrier2) \
    X(vkCmdPushConstants) \
    X(vkCmdResetQueryPool) \
    X(vkCmdUpdateBuffer) \
    X(vkCmdWriteTimestamp2) \
    X(vkCreateBuffer) \
    X(vkCreateCommandPool) \
    X(vkCreateComputePipelines) \
    X(vkCreateDescriptorPool) \
    X(vkCreateDescriptorSetLayout) \
    X(vkCreateImage) \
    X(vkCreateImageView) \
    X(vkCreatePipelineCache) \
    X(vkCreatePipelineLayout) \
    X(vkCreateQueryPool) \
    X(vkCreateSemaphore) \
    X(vkCreateShaderModule) \
    X(vkDestroyBuffer) \
    X(vkDestroyCommandPool) \
    X(vkDestroyDescriptorPool) \
    X(vkDestroyDescriptorSetLayout) \
    X(vkDestroyDevice) \
    X(vkDestroyImage) \
    X(vkDestroyImageView) \
    X(vkDestroyPipeline) \
    X(vkDestroyPipelineCache) \
    X(vkDestroyPipelineLayout) \
    X(vkDestroyQueryPool) \
    X(vkDestroySemaphore) \
    X(vkDestroyShaderModule) \
    X(vkDeviceWaitIdle) \
    X(vkEndCommandBuffer) \
    X(vkFreeMemory) \
    X(vkGetBufferDeviceAddress) \
    X(vkGetBufferMemoryRequirements) \
    X(vkGetDeviceQueue) \
    X(vkGetImageMemoryRequirements) \
    X(vkGetPipelineCacheData) \
    X(vkGetQueryPoolResults) \
    X(vkMapMemory) \
    X(vkQueueSubmit2) \
    X(vkResetCommandPool) \
    X(vkUpdateDescriptorSets) \
    X(vkWaitSemaphores)

// Of extensions: null where these are not in use.
#define CLAST_VULKAN_DEBUG_FUNCTIONS(X) \
    X(vkCmdBeginDebugUtilsLabelEXT) \
    X(vkCmdEndDebugUtilsLabelEXT) \
    X(vkCreateDebugUtilsMessengerEXT) \
    X(vkDestroyDebugUtilsMessengerEXT) \
    X(vkSetDebugUtilsObjectNameEXT)

#define CLAST_VULKAN_RAY_TRACING_FUNCTIONS(X) \
    X(vkCmdBuildAccelerationStructuresKHR) \
    X(vkCmdCopyAccelerationStructureKHR) \
    X(vkCmdTraceRaysKHR) \
    X(vkCmdWriteAccelerationStructuresPropertiesKHR) \
    X(vkCreateAccelerationStructureKHR) \
    X(vkCreateRayTracingPipelinesKHR) \
    X(vkDestroyAccelerationStructureKHR) \
    X(vkGetAccelerationStructureBuildSizesKHR) \
    X(vkGetAccelerationStructureDeviceAddressKHR) \
    X(vkGetRayTracingShaderGroupHandlesKHR)

#define CLAST_VULKAN_MEMBER(name) PFN_##name name;
typedef struct clast_vulkan_functions {
    PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr;
    CLAST_VULKAN_LOADER_FUNCTIONS(CLAST_VULKAN_MEMBER)
    CLAST_VULKAN_INSTANCE_FUNCTIONS(CLAST_VULKAN_MEMBER)
    CLAST_VULKAN_DEVICE_FUNCTIONS(CLAST_VULKAN_MEMBER)
    CLAST_VULKAN_DEBUG_FUNCTIONS(CLAST_VULKAN_MEMBER)
    CLAST_VULKAN_RAY_TRACING_FUNCTIONS(CLAST_VULKAN_MEMBER)
} clast_vulkan_functions;

#endif
