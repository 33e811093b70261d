// SPDX-License-Identifier: Apache-2.0
// Structures over triangles: their memory, builds, updates, and making them smaller.
#include "vulkan/driver_state.h"

enum { BATCH_JOBS = 64 }; // that one command builds

typedef VkAccelerationStructureBuildGeometryInfoKHR build_info;

VkPhysicalDeviceAccelerationStructurePropertiesKHR clast_driver_limits(clast_gpu *gpu)
{
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = &limits};
    gpu->vk.vkGetPhysicalDeviceProperties2(gpu->physical_device, &properties);
    return limits;
}

// ------------------------------------------------------------------------------------------------------------ memory

static VkAccelerationStructureGeometryKHR geometry_of(const clast_driver_triangles *triangles)
{
    uint32_t vertices = triangles->vertex_count;
    return (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR,
        .geometry.triangles = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR,
                               .vertexFormat = VK_FORMAT_R32G32B32_SFLOAT,
                               .vertexData.deviceAddress = triangles->positions,
                               .vertexStride = sizeof(packed3),
                               .maxVertex = vertices != 0 ? vertices - 1 : 0,
                               .indexType = VK_INDEX_TYPE_UINT32,
                               .indexData.deviceAddress = triangles->indices}};
}

static VkAccelerationStructureGeometryKHR geometry_over(uint64_t instances)
{
    return (VkAccelerationStructureGeometryKHR){
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR,
        .geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR,
        .geometry.instances = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR,
                               .data.deviceAddress = instances}};
}

static build_info info_of(const clast_driver_structure *structure, const VkAccelerationStructureGeometryKHR *geometry)
{
    return (build_info){.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR,
                        .type = structure->is_top ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                                  : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                        .flags = structure->flags,
                        .mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR,
                        .dstAccelerationStructure = structure->handle,
                        .geometryCount = 1,
                        .pGeometries = geometry};
}

static clast_status create_handle(clast_gpu *gpu, clast_driver_structure *structure)
{
    clast_status status = clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, structure->bytes, "the driver's structure",
                                             &structure->memory);
    if (status != CLAST_OK) {
        return status;
    }
    VkAccelerationStructureCreateInfoKHR create = {.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR,
                                                   .buffer = structure->memory.handle,
                                                   .offset = structure->memory.offset,
                                                   .size = structure->bytes,
                                                   .type = structure->is_top
                                                               ? VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR
                                                               : VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR};
    VkResult result = gpu->vk.vkCreateAccelerationStructureKHR(gpu->device, &create, NULL, &structure->handle);
    if (result != VK_SUCCESS) {
        structure->handle = VK_NULL_HANDLE;
        return clast_gpu_fail(gpu, result, "making a structure");
    }
    VkAccelerationStructureDeviceAddressInfoKHR where = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR,
        .accelerationStructure = structure->handle};
    structure->address = gpu->vk.vkGetAccelerationStructureDeviceAddressKHR(gpu->device, &where);
    return CLAST_OK;
}

// With the flags, kind and room that `structure` has.
static clast_status make_structure(clast_gpu *gpu, clast_driver_structure *structure)
{
    clast_driver_triangles triangles = {.vertex_count = structure->vertices};
    VkAccelerationStructureGeometryKHR geometry = structure->is_top ? geometry_over(0) : geometry_of(&triangles);
    build_info info = info_of(structure, &geometry);
    VkAccelerationStructureBuildSizesInfoKHR sizes = {
        .sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    gpu->vk.vkGetAccelerationStructureBuildSizesKHR(gpu->device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                                    &structure->triangles, &sizes);
    structure->bytes = sizes.accelerationStructureSize;
    structure->build_scratch = sizes.buildScratchSize;
    structure->update_scratch = sizes.updateScratchSize;
    clast_status status = create_handle(gpu, structure);
    if (status != CLAST_OK) {
        clast_driver_free(gpu, structure);
    }
    return status;
}

static VkBuildAccelerationStructureFlagsKHR flags_of(clast_driver_build build, bool updated, bool compacted)
{
    return (build == CLAST_DRIVER_FAST_BUILD ? VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_BUILD_BIT_KHR
                                             : VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR) |
           (updated ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR : 0) |
           (compacted ? VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR : 0);
}

clast_status clast_driver_reserve(clast_gpu *gpu, const clast_driver_structure_desc *desc,
                                  clast_driver_structure *structure)
{
    VkBuildAccelerationStructureFlagsKHR flags = flags_of(desc->build, desc->updated, desc->compacted);
    if (structure->handle != VK_NULL_HANDLE && !structure->is_top && !structure->is_compacted &&
        structure->flags == flags && structure->triangles >= desc->triangle_count &&
        structure->vertices >= desc->vertex_count) {
        return CLAST_OK;
    }
    clast_driver_free(gpu, structure);
    if (!gpu->features.ray_tracing) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED,
                          "vulkan: the device was not opened for acceleration structures of its driver");
    }
    VkPhysicalDeviceAccelerationStructurePropertiesKHR limits = clast_driver_limits(gpu);
    if (desc->triangle_count > limits.maxPrimitiveCount) {
        return clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: %u triangles; the driver's structures take %llu",
                          desc->triangle_count, (unsigned long long)limits.maxPrimitiveCount);
    }
    *structure = (clast_driver_structure){
        .flags = flags, .triangles = desc->triangle_count, .vertices = desc->vertex_count};
    return make_structure(gpu, structure);
}

void clast_driver_free(clast_gpu *gpu, clast_driver_structure *structure)
{
    if (structure->handle != VK_NULL_HANDLE) {
        clast_gpu_leave(gpu, &(clast_gpu_leaving){.structure = structure->handle, .number = CLAST_NONE});
    }
    clast_gpu_free(gpu, &structure->memory);
    *structure = (clast_driver_structure){0};
}

// ------------------------------------------------------------------------------------------------------------ builds

// A command that builds several structures.
typedef struct build_batch {
    build_info infos[BATCH_JOBS];
    VkAccelerationStructureGeometryKHR geometries[BATCH_JOBS];
    VkAccelerationStructureBuildRangeInfoKHR ranges[BATCH_JOBS];
    const VkAccelerationStructureBuildRangeInfoKHR *range_list[BATCH_JOBS];
    uint32_t count;
    uint64_t used; // of the working memory
} build_batch;

static uint64_t scratch_of(const clast_driver_job *job, uint64_t alignment)
{
    uint64_t bytes = job->update ? job->structure->update_scratch : job->structure->build_scratch;
    return (bytes + alignment - 1) / alignment * alignment;
}

static void flush_batch(clast_gpu_commands *commands, build_batch *batch)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    if (batch->count != 0) {
        gpu->vk.vkCmdBuildAccelerationStructuresKHR(commands->buffer, batch->count, batch->infos, batch->range_list);
    }
    batch->count = 0;
    batch->used = 0;
}

static void add_to_batch(build_batch *batch, const clast_driver_structure *structure,
                         const VkAccelerationStructureGeometryKHR *geometry, uint32_t primitives, bool update,
                         uint64_t scratch)
{
    uint32_t i = batch->count++;
    batch->geometries[i] = *geometry;
    batch->infos[i] = info_of(structure, &batch->geometries[i]);
    batch->infos[i].scratchData.deviceAddress = scratch;
    if (update) {
        batch->infos[i].mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
        batch->infos[i].srcAccelerationStructure = structure->handle;
    }
    batch->ranges[i] = (VkAccelerationStructureBuildRangeInfoKHR){.primitiveCount = primitives};
    batch->range_list[i] = &batch->ranges[i];
}

// Why a job cannot be built; null where it can.
static const char *fault_of(const clast_driver_job *job)
{
    const clast_driver_structure *structure = job->structure;
    if (structure->handle == VK_NULL_HANDLE || structure->is_top) {
        return "there is no structure for triangles";
    }
    if (job->triangles.triangle_count > structure->triangles || job->triangles.vertex_count > structure->vertices) {
        return "the structure has no room for so many triangles";
    }
    if (!job->update) {
        return structure->is_compacted ? "the structure was made as small as can be" : NULL;
    }
    bool can = (structure->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR) != 0;
    return can ? NULL : "the structure was not made for updates";
}

// Checks the jobs, and makes the working memory. Gives whether there is something to be done.
static bool prepare(clast_gpu_commands *commands, const clast_driver_job *jobs, size_t count, uint64_t alignment,
                    clast_driver_scratch *scratch)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    uint64_t most = 0, all = 0;
    for (size_t i = 0; i < count; i++) {
        const char *fault = fault_of(&jobs[i]);
        if (fault != NULL) {
            clast_gpu_note(commands, clast_fail(gpu->context, CLAST_ERROR_INVALID_ARGUMENT, "vulkan: %s", fault));
            return false;
        }
        uint64_t bytes = scratch_of(&jobs[i], alignment);
        most = bytes > most ? bytes : most;
        all += bytes;
    }
    uint64_t wanted = scratch->least > all ? all : scratch->least;
    wanted = (wanted > most ? wanted : most) + alignment;
    clast_gpu_note(commands, clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, wanted, "working memory of the driver's builds",
                                               &scratch->buffer));
    return commands->status == CLAST_OK && count != 0;
}

void clast_driver_build_all(clast_gpu_commands *commands, const clast_driver_job *jobs, size_t count,
                            clast_driver_scratch *scratch)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    uint64_t alignment = gpu->features.ray_tracing
                             ? clast_driver_limits(gpu).minAccelerationStructureScratchOffsetAlignment
                             : 1;
    alignment = alignment != 0 ? alignment : 1;
    if (commands->status != CLAST_OK || !prepare(commands, jobs, count, alignment, scratch)) {
        return;
    }
    build_batch *batch = clast_allocate(gpu->context, 1, sizeof *batch);
    if (batch == NULL) {
        clast_gpu_note(commands, CLAST_ERROR_OUT_OF_MEMORY);
        return;
    }
    batch->count = 0;
    batch->used = 0;
    uint64_t begin = (scratch->buffer.address + alignment - 1) / alignment * alignment;
    uint64_t room = scratch->buffer.address + scratch->buffer.bytes - begin;
    for (size_t i = 0; i < count; i++) {
        uint64_t bytes = scratch_of(&jobs[i], alignment);
        if (batch->count == BATCH_JOBS || bytes > room - batch->used) {
            flush_batch(commands, batch);
            clast_gpu_barrier(commands); // the same memory is used again
        }
        VkAccelerationStructureGeometryKHR geometry = geometry_of(&jobs[i].triangles);
        add_to_batch(batch, jobs[i].structure, &geometry, jobs[i].triangles.triangle_count, jobs[i].update,
                     begin + batch->used);
        batch->used += bytes;
    }
    flush_batch(commands, batch);
    clast_free(gpu->context, batch);
}

// --------------------------------------------------------------------------------------------------------- compaction

static clast_status ask_size(clast_gpu *gpu, const clast_driver_structure *structure, VkQueryPool pool, uint64_t *bytes)
{
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    gpu->vk.vkCmdResetQueryPool(commands->buffer, pool, 0, 1);
    gpu->vk.vkCmdWriteAccelerationStructuresPropertiesKHR(
        commands->buffer, 1, &structure->handle, VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR, pool, 0);
    status = clast_gpu_finish(commands);
    if (status != CLAST_OK) {
        return status;
    }
    VkResult result = gpu->vk.vkGetQueryPoolResults(gpu->device, pool, 0, 1, sizeof *bytes, bytes, sizeof *bytes,
                                                    VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
    return result == VK_SUCCESS ? CLAST_OK : clast_gpu_fail(gpu, result, "asking how small a structure can be");
}

static clast_status move_to(clast_gpu *gpu, clast_driver_structure *structure, clast_driver_structure *smaller)
{
    clast_gpu_commands *commands;
    clast_status status = clast_gpu_begin(gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    VkCopyAccelerationStructureInfoKHR copy = {.sType = VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR,
                                               .src = structure->handle,
                                               .dst = smaller->handle,
                                               .mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR};
    gpu->vk.vkCmdCopyAccelerationStructureKHR(commands->buffer, &copy);
    return clast_gpu_finish(commands);
}

clast_status clast_driver_compact(clast_gpu *gpu, clast_driver_structure *structure)
{
    if (structure->handle == VK_NULL_HANDLE || structure->is_top || structure->is_compacted ||
        (structure->flags & VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR) == 0) {
        return clast_fail(gpu->context, CLAST_ERROR_INVALID_ARGUMENT, "vulkan: the structure cannot be made smaller");
    }
    VkQueryPoolCreateInfo create = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                    .queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                    .queryCount = 1};
    VkQueryPool pool;
    VkResult result = gpu->vk.vkCreateQueryPool(gpu->device, &create, NULL, &pool);
    if (result != VK_SUCCESS) {
        return clast_gpu_fail(gpu, result, "asking how small a structure can be");
    }
    clast_driver_structure smaller = *structure;
    smaller.memory = (clast_gpu_buffer){0};
    smaller.handle = VK_NULL_HANDLE;
    smaller.is_compacted = true;
    clast_status status = ask_size(gpu, structure, pool, &smaller.bytes);
    gpu->vk.vkDestroyQueryPool(gpu->device, pool, NULL);
    if (status == CLAST_OK) {
        status = create_handle(gpu, &smaller);
    }
    if (status == CLAST_OK) {
        status = move_to(gpu, structure, &smaller);
    }
    if (status != CLAST_OK) {
        clast_driver_free(gpu, &smaller);
        return status;
    }
    clast_driver_free(gpu, structure);
    *structure = smaller;
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------- instances

clast_status clast_driver_reserve_top(clast_gpu *gpu, uint32_t count, clast_driver_build build,
                                      clast_driver_structure *structure)
{
    VkBuildAccelerationStructureFlagsKHR flags = flags_of(build, false, false);
    if (structure->handle != VK_NULL_HANDLE && structure->flags == flags && structure->triangles >= count) {
        return CLAST_OK;
    }
    uint64_t most = clast_driver_limits(gpu).maxInstanceCount;
    if (count > most) {
        return clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: %u instances; the driver's structures take %llu",
                          count, (unsigned long long)most);
    }
    uint64_t grown = (uint64_t)structure->triangles + structure->triangles / 2;
    grown = grown > count ? grown : count;
    clast_driver_free(gpu, structure);
    *structure = (clast_driver_structure){
        .flags = flags, .is_top = true, .triangles = (uint32_t)(grown < most ? grown : most)};
    return make_structure(gpu, structure);
}

void clast_driver_build_top(clast_gpu_commands *commands, const clast_driver_structure *structure, uint64_t instances,
                            uint32_t count, clast_driver_scratch *scratch)
{
    clast_gpu *gpu = clast_gpu_of(commands);
    uint64_t alignment = clast_driver_limits(gpu).minAccelerationStructureScratchOffsetAlignment;
    alignment = alignment != 0 ? alignment : 1;
    clast_gpu_note(commands, clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, structure->build_scratch + alignment,
                                               "working memory of the driver's builds", &scratch->buffer));
    if (commands->status != CLAST_OK) {
        return;
    }
    VkAccelerationStructureGeometryKHR geometry = geometry_over(instances);
    build_info info = info_of(structure, &geometry);
    info.scratchData.deviceAddress = (scratch->buffer.address + alignment - 1) / alignment * alignment;
    VkAccelerationStructureBuildRangeInfoKHR range = {.primitiveCount = count};
    const VkAccelerationStructureBuildRangeInfoKHR *ranges = &range;
    gpu->vk.vkCmdBuildAccelerationStructuresKHR(commands->buffer, 1, &info, &ranges);
}
