// SPDX-License-Identifier: Apache-2.0
// Kernels: made at their first use, kept in a table, and on disk as the driver compiled them.
#include "vulkan/device.h"

#include <stdio.h>
#include <string.h>

// ---------------------------------------------------------------------------------------------------------- layouts

static VkResult make_set(clast_gpu *gpu)
{
    VkDescriptorSetLayoutBinding binding = {.binding = 0,
                                            .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                            .descriptorCount = gpu->features.textures,
                                            .stageFlags = VK_SHADER_STAGE_ALL};
    VkDescriptorBindingFlags flag = VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT |
                                    VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT;
    VkDescriptorSetLayoutBindingFlagsCreateInfo flags = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO,
        .bindingCount = 1,
        .pBindingFlags = &flag};
    VkDescriptorSetLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                              .pNext = &flags,
                                              .flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT,
                                              .bindingCount = 1,
                                              .pBindings = &binding};
    VkResult result = gpu->vk.vkCreateDescriptorSetLayout(gpu->device, &layout, NULL, &gpu->set_layout);
    if (result != VK_SUCCESS) {
        return result;
    }
    VkDescriptorPoolSize size = {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, gpu->features.textures};
    VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                       .flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT,
                                       .maxSets = 1,
                                       .poolSizeCount = 1,
                                       .pPoolSizes = &size};
    result = gpu->vk.vkCreateDescriptorPool(gpu->device, &pool, NULL, &gpu->descriptor_pool);
    if (result != VK_SUCCESS) {
        return result;
    }
    VkDescriptorSetAllocateInfo allocate = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                            .descriptorPool = gpu->descriptor_pool,
                                            .descriptorSetCount = 1,
                                            .pSetLayouts = &gpu->set_layout};
    return gpu->vk.vkAllocateDescriptorSets(gpu->device, &allocate, &gpu->set);
}

clast_status clast_gpu_make_layouts(clast_gpu *gpu)
{
    VkResult result = make_set(gpu);
    if (result == VK_SUCCESS) {
        VkPushConstantRange push = {VK_SHADER_STAGE_COMPUTE_BIT, 0, CLAST_GPU_PUSH_BYTES};
        VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .setLayoutCount = 1,
                                             .pSetLayouts = &gpu->set_layout,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &push};
        result = gpu->vk.vkCreatePipelineLayout(gpu->device, &layout, NULL, &gpu->pipeline_layout);
    }
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "making the layout of kernels");
}

// ----------------------------------------------------------------------------------------------------- cache on disk

// One file for each device and driver: the driver checks what is in it.
static bool cache_path(const clast_gpu *gpu, char path[4096])
{
    if (gpu->desc.cache_folder == NULL || gpu->is_foreign) {
        return false;
    }
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    gpu->vk.vkGetPhysicalDeviceProperties2(gpu->physical_device, &properties);
    char id[2 * VK_UUID_SIZE + 1];
    for (uint32_t i = 0; i < VK_UUID_SIZE; i++) {
        snprintf(id + 2 * i, 3, "%02x", properties.properties.pipelineCacheUUID[i]);
    }
    int length = snprintf(path, 4096, "%s/kernels-%s.vulkan", gpu->desc.cache_folder, id);
    return length > 0 && length < 4096;
}

clast_status clast_gpu_open_cache(clast_gpu *gpu)
{
    char path[4096];
    clast_file_view view = {0};
    const clast_file_hook *files = clast_context_files(gpu->context);
    bool found = cache_path(gpu, path) && files->map(files->user, path, &view) == CLAST_OK;
    VkPipelineCacheCreateInfo create = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                        .initialDataSize = found ? (size_t)view.size : 0,
                                        .pInitialData = found ? view.data : NULL};
    VkResult result = gpu->vk.vkCreatePipelineCache(gpu->device, &create, NULL, &gpu->pipeline_cache);
    if (result != VK_SUCCESS && found) { // what lies there is of no use
        create.initialDataSize = 0;
        result = gpu->vk.vkCreatePipelineCache(gpu->device, &create, NULL, &gpu->pipeline_cache);
    }
    if (found) {
        files->unmap(files->user, &view);
    }
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "making the cache of kernels");
}

static bool write_cache(clast_gpu *gpu, const char *path, const void *data, size_t size)
{
    const clast_file_hook *files = clast_context_files(gpu->context);
    void *file;
    if (files->create(files->user, path, &file) != CLAST_OK) {
        return false;
    }
    if (files->write(files->user, file, data, size) != CLAST_OK) {
        files->discard(files->user, file);
        return false;
    }
    return files->commit(files->user, file) == CLAST_OK;
}

void clast_gpu_keep_cache(clast_gpu *gpu)
{
    char path[4096];
    size_t size = 0;
    if (gpu->pipeline_cache == VK_NULL_HANDLE || gpu->kernel_count == 0 || gpu->is_lost || !cache_path(gpu, path) ||
        gpu->vk.vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &size, NULL) != VK_SUCCESS || size == 0) {
        return;
    }
    void *data = clast_allocate(gpu->context, size, 1);
    bool kept = data != NULL &&
                gpu->vk.vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &size, data) == VK_SUCCESS &&
                write_cache(gpu, path, data, size);
    if (!kept) {
        clast_log(gpu->context, CLAST_LOG_WARNING, "vulkan: compiled kernels could not be kept in %s", path);
    }
    clast_free(gpu->context, data);
}

void clast_gpu_free_kernels(clast_gpu *gpu)
{
    for (size_t i = 0; i < gpu->kernel_capacity; i++) {
        gpu->vk.vkDestroyPipeline(gpu->device, gpu->kernels[i].pipeline, NULL);
    }
    clast_free(gpu->context, gpu->kernels);
    gpu->vk.vkDestroyPipelineCache(gpu->device, gpu->pipeline_cache, NULL);
    gpu->vk.vkDestroyPipelineLayout(gpu->device, gpu->pipeline_layout, NULL);
    gpu->vk.vkDestroyDescriptorPool(gpu->device, gpu->descriptor_pool, NULL);
    gpu->vk.vkDestroyDescriptorSetLayout(gpu->device, gpu->set_layout, NULL);
}

// -------------------------------------------------------------------------------------------------------------- code

enum { SPIRV_MAGIC = 0x07230203 };

// A shader's code: the library's, or that of a file in the folder of shaders. The latter is to be unmapped.
static clast_status find_code(clast_gpu *gpu, clast_shader shader, clast_shader_code *code, clast_file_view *view)
{
    char path[4096];
    const clast_file_hook *files = clast_context_files(gpu->context);
    *code = clast_shader_codes[shader];
    if (gpu->shader_folder == NULL) {
        return CLAST_OK;
    }
    int length = snprintf(path, sizeof path, "%s/%s.spv.exact", gpu->shader_folder, code->symbol);
    if (length < 0 || length >= (int)sizeof path || files->map(files->user, path, view) != CLAST_OK) {
        return CLAST_OK; // not all kernels need be there
    }
    uint32_t first = 0;
    memcpy(&first, view->data, view->size >= sizeof first ? sizeof first : 0);
    if (view->size % sizeof first != 0 || first != SPIRV_MAGIC) {
        files->unmap(files->user, view);
        *view = (clast_file_view){0};
        return clast_fail(gpu->context, CLAST_ERROR_MALFORMED, "%s: expected SPIR-V", path);
    }
    code->words = (const void *)view->data; // views are aligned
    code->bytes = (size_t)view->size;
    return CLAST_OK;
}

static void unmap(clast_gpu *gpu, clast_file_view *view)
{
    const clast_file_hook *files = clast_context_files(gpu->context);
    if (view->data != NULL) {
        files->unmap(files->user, view);
    }
}

// FNV-1a, of the words of files only: the library's never change.
static uint64_t hash_of_code(const clast_shader_code *code, const clast_file_view *view)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; view->data != NULL && i < code->bytes / sizeof *code->words; i++) {
        hash = (hash ^ code->words[i]) * 0x100000001b3u;
    }
    return hash;
}

clast_status clast_gpu_open_shader(clast_gpu *gpu, clast_shader shader, VkShaderModule *module, uint64_t *hash)
{
    clast_shader_code code;
    clast_file_view view = {0};
    clast_status status = find_code(gpu, shader, &code, &view);
    if (status != CLAST_OK) {
        return status;
    }
    VkShaderModuleCreateInfo create = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code.bytes, .pCode = code.words};
    VkResult result = gpu->vk.vkCreateShaderModule(gpu->device, &create, NULL, module);
    *hash = hash_of_code(&code, &view);
    unmap(gpu, &view);
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "taking over the code of a kernel");
}

// Whether the code that a kernel was made of is what it would be made of now.
static clast_status compare_code(clast_gpu *gpu, const clast_gpu_kernel *kernel, bool *same)
{
    clast_shader_code code;
    clast_file_view view = {0};
    clast_status status = find_code(gpu, kernel->shader, &code, &view);
    *same = status == CLAST_OK && hash_of_code(&code, &view) == kernel->code_hash;
    unmap(gpu, &view);
    return status;
}

// ----------------------------------------------------------------------------------------------------------- kernels

static size_t hash_of(const clast_gpu_call *call, uint32_t subgroup)
{
    uint64_t hash = (uint64_t)call->shader * 31 + subgroup;
    for (uint32_t i = 0; i < call->constant_count; i++) {
        hash = (hash ^ call->constants[i]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return (size_t)hash;
}

static bool is_kernel_of(const clast_gpu_kernel *kernel, const clast_gpu_call *call, uint32_t subgroup)
{
    return kernel->shader == call->shader && kernel->subgroup == subgroup &&
           kernel->constant_count == call->constant_count &&
           memcmp(kernel->constants, call->constants, call->constant_count * sizeof *call->constants) == 0;
}

// The place of a kernel, or the free one where it would be.
static clast_gpu_kernel *find(const clast_gpu *gpu, const clast_gpu_call *call, uint32_t subgroup)
{
    size_t mask = gpu->kernel_capacity - 1;
    for (size_t i = hash_of(call, subgroup) & mask;; i = (i + 1) & mask) {
        clast_gpu_kernel *kernel = &gpu->kernels[i];
        if (kernel->pipeline == VK_NULL_HANDLE || is_kernel_of(kernel, call, subgroup)) {
            return kernel;
        }
    }
}

// A table of another capacity, for the kernels of the present one.
static clast_status move_kernels(clast_gpu *gpu, size_t capacity)
{
    size_t old_capacity = gpu->kernel_capacity;
    clast_gpu_kernel *old = gpu->kernels, *kernels = clast_allocate_zeroed(gpu->context, capacity, sizeof *kernels);
    if (kernels == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    gpu->kernels = kernels;
    gpu->kernel_capacity = capacity;
    gpu->kernel_count = 0;
    for (size_t i = 0; i < old_capacity; i++) {
        if (old[i].pipeline != VK_NULL_HANDLE) {
            clast_gpu_call call = {.shader = old[i].shader, .constant_count = old[i].constant_count};
            memcpy(call.constants, old[i].constants, sizeof call.constants);
            *find(gpu, &call, old[i].subgroup) = old[i];
            gpu->kernel_count++;
        }
    }
    clast_free(gpu->context, old);
    return CLAST_OK;
}

static clast_status grow(clast_gpu *gpu)
{
    if (2 * (gpu->kernel_count + 1) <= gpu->kernel_capacity) {
        return CLAST_OK;
    }
    return move_kernels(gpu, gpu->kernel_capacity != 0 ? 2 * gpu->kernel_capacity : 64);
}

clast_status clast_gpu_renew_kernels(clast_gpu *gpu)
{
    bool is_idle = false;
    for (size_t i = 0; i < gpu->kernel_capacity && gpu->shader_folder != NULL; i++) {
        bool same = true;
        clast_gpu_kernel *kernel = &gpu->kernels[i];
        clast_status status = kernel->pipeline != VK_NULL_HANDLE ? compare_code(gpu, kernel, &same) : CLAST_OK;
        if (status != CLAST_OK) {
            return status;
        }
        if (same) {
            continue;
        }
        VkResult result = is_idle ? VK_SUCCESS : gpu->vk.vkDeviceWaitIdle(gpu->device);
        if (result != VK_SUCCESS) {
            return clast_gpu_fail(gpu, result, "waiting for the device");
        }
        is_idle = true;
        gpu->vk.vkDestroyPipeline(gpu->device, kernel->pipeline, NULL);
        *kernel = (clast_gpu_kernel){0};
    }
    return is_idle ? move_kernels(gpu, gpu->kernel_capacity) : CLAST_OK; // searches would end at gaps
}

static VkResult make_pipeline(clast_gpu *gpu, const clast_gpu_call *call, uint32_t subgroup, VkShaderModule module,
                              VkPipeline *pipeline)
{
    const clast_shader_code *code = &clast_shader_codes[call->shader];
    VkSpecializationMapEntry entries[CLAST_GPU_CONSTANTS];
    for (uint32_t i = 0; i < call->constant_count; i++) {
        entries[i] = (VkSpecializationMapEntry){i, i * (uint32_t)sizeof(uint32_t), sizeof(uint32_t)};
    }
    VkSpecializationInfo constants = {call->constant_count, entries, call->constant_count * sizeof(uint32_t),
                                      call->constants};
    VkPipelineShaderStageRequiredSubgroupSizeCreateInfo width = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO,
        .requiredSubgroupSize = subgroup};
    VkComputePipelineCreateInfo create = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .flags = call->subgroup != 0 ? VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT : 0,
                  .pNext = subgroup != 0 ? &width : NULL,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main",
                  .pSpecializationInfo = call->constant_count != 0 ? &constants : NULL},
        .layout = gpu->pipeline_layout};
    VkResult result = gpu->vk.vkCreateComputePipelines(gpu->device, gpu->pipeline_cache, 1, &create, NULL, pipeline);
    if (result == VK_SUCCESS && gpu->vk.vkSetDebugUtilsObjectNameEXT != NULL) {
        VkDebugUtilsObjectNameInfoEXT name = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                              .objectType = VK_OBJECT_TYPE_PIPELINE,
                                              .objectHandle = (uint64_t)(uintptr_t)*pipeline,
                                              .pObjectName = code->file};
        gpu->vk.vkSetDebugUtilsObjectNameEXT(gpu->device, &name);
    }
    return result;
}

clast_status clast_gpu_kernel_of(clast_gpu *gpu, const clast_gpu_call *call, VkPipeline *pipeline)
{
    uint32_t subgroup = call->subgroup != 0 ? call->subgroup : gpu->desc.subgroup;
    const clast_gpu_features *features = &gpu->features;
    if (subgroup != 0 && !features->subgroup_control && subgroup == features->subgroup_most) {
        subgroup = 0;
    }
    if (subgroup != 0 &&
        (!features->subgroup_control || subgroup < features->subgroup_least || subgroup > features->subgroup_most)) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED,
                          "vulkan: subgroups of %u were asked for; the device has %u to %u", subgroup,
                          features->subgroup_least, features->subgroup_most);
    }
    clast_status status = grow(gpu);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_kernel *kernel = find(gpu, call, subgroup);
    if (kernel->pipeline == VK_NULL_HANDLE) {
        VkShaderModule module;
        uint64_t hash;
        status = clast_gpu_open_shader(gpu, call->shader, &module, &hash);
        if (status != CLAST_OK) {
            return status;
        }
        VkResult result = make_pipeline(gpu, call, subgroup, module, pipeline);
        gpu->vk.vkDestroyShaderModule(gpu->device, module, NULL);
        if (result != VK_SUCCESS) {
            char what[256];
            snprintf(what, sizeof what, "compiling kernel %s", clast_shader_codes[call->shader].file);
            return clast_gpu_fail(gpu, result, what);
        }
        *kernel = (clast_gpu_kernel){.pipeline = *pipeline,
                                     .shader = call->shader,
                                     .code_hash = hash,
                                     .subgroup = subgroup,
                                     .constant_count = call->constant_count};
        memcpy(kernel->constants, call->constants, sizeof kernel->constants);
        gpu->kernel_count++;
    }
    *pipeline = kernel->pipeline;
    return CLAST_OK;
}
