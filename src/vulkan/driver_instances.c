// SPDX-License-Identifier: Apache-2.0
// What the driver's structures are made of: triangles of clusters, and instances.
#include "vulkan/driver_state.h"

#include "shared/transform.h"

#include <string.h>

// --------------------------------------------------------------------------------------------------------- triangles

// The push constants of shaders/driver/indices.comp.
typedef struct triangles_push {
    uint64_t clusters, places, firsts, positions, indices, triangles_of;
    uint32_t count, space, triangles;
} triangles_push;
_Static_assert(sizeof(triangles_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

void clast_driver_make_triangles(clast_gpu_commands *commands, const clast_driver_clusters *clusters, uint64_t indices,
                                 uint64_t triangles)
{
    if (clusters->count > DRIVER_CLUSTERS_MOST) {
        clast_gpu_note(commands, clast_fail(clast_gpu_context(clast_gpu_of(commands)), CLAST_ERROR_LIMIT,
                                            "vulkan: %u clusters; the driver's structures take %u of a unit",
                                            clusters->count, DRIVER_CLUSTERS_MOST));
        return;
    }
    triangles_push push = {.clusters = clusters->clusters,
                           .places = clusters->places,
                           .firsts = clusters->firsts,
                           .positions = clusters->positions,
                           .indices = indices,
                           .triangles_of = triangles,
                           .count = clusters->count,
                           .space = clusters->space,
                           .triangles = clusters->triangles};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_DRIVER_INDICES,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = clusters->count});
}

// --------------------------------------------------------------------------------------------------------- instances

// What a map must be, for an instance to be seen: drivers invert it.
static bool is_usable(const clast_transform *map)
{
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++) {
            if (!is_finite1(map->rows[row].v[column])) {
                return false;
            }
        }
    }
    clast_transform inverse = transform_inverse(*map);
    bool is_zero = true;
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++) {
            float x = inverse.rows[row].v[column];
            if (!is_finite1(x)) {
                return false;
            }
            is_zero = is_zero && x == 0.0f;
        }
    }
    return !is_zero;
}

static VkAccelerationStructureInstanceKHR instance_of(const clast_driver_instance *instance, uint32_t number)
{
    VkAccelerationStructureInstanceKHR made = {.instanceCustomIndex = number & 0xffffffu,
                                               .mask = 0xff,
                                               .flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR |
                                                        (instance->filtered
                                                             ? VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR
                                                             : VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR)};
    if (instance->structure != NULL && is_usable(&instance->to_world)) {
        made.accelerationStructureReference = instance->structure->address;
        memcpy(made.transform.matrix, instance->to_world.rows, sizeof made.transform.matrix);
    } else { // without a structure, it is not looked at
        for (int k = 0; k < 3; k++) {
            made.transform.matrix[k][k] = 1.0f;
        }
    }
    return made;
}

static clast_driver_shape shape_of(const clast_driver_instance *instance)
{
    return (clast_driver_shape){.to_world = instance->to_world,
                                .positions = store_address(instance->positions),
                                .indices = store_address(instance->indices),
                                .triangles = store_address(instance->triangles),
                                .id = instance->id,
                                .flags = transform_determinant(instance->to_world) < 0.0f ? DRIVER_MIRRORED : 0};
}

static clast_status reserve_scene(clast_gpu *gpu, size_t count, clast_driver_build build, clast_driver_scene *scene)
{
    if (!gpu->features.ray_tracing) {
        return clast_fail(gpu->context, CLAST_ERROR_UNSUPPORTED,
                          "vulkan: the device was not opened for acceleration structures of its driver");
    }
    if (count > DRIVER_INSTANCES_MOST) {
        return clast_fail(gpu->context, CLAST_ERROR_LIMIT, "vulkan: %zu instances; the driver's structures take %u",
                          count, DRIVER_INSTANCES_MOST);
    }
    clast_status status = clast_driver_reserve_top(gpu, (uint32_t)count, build, &scene->structure);
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, count * sizeof(VkAccelerationStructureInstanceKHR),
                                   "the driver's instances", &scene->instances);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, count * sizeof(clast_driver_shape),
                                   "shapes of the driver's instances", &scene->shapes);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, sizeof(clast_driver_top), "the driver's scene", &scene->top);
    }
    return status;
}

// Writes both lists, made in a piece of memory that is theirs for the time being.
static clast_status write_lists(clast_gpu_commands *commands, const clast_driver_instance *instances, size_t count,
                                const clast_driver_scene *scene)
{
    clast_context *context = clast_gpu_context(clast_gpu_of(commands));
    VkAccelerationStructureInstanceKHR *list = clast_allocate(context, count, sizeof *list);
    clast_driver_shape *shapes = clast_allocate(context, count, sizeof *shapes);
    clast_status status = list != NULL && shapes != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    for (size_t i = 0; i < count && status == CLAST_OK; i++) {
        list[i] = instance_of(&instances[i], (uint32_t)i);
        shapes[i] = shape_of(&instances[i]);
    }
    if (status == CLAST_OK) {
        clast_gpu_write(commands, &scene->instances, 0, list, count * sizeof *list);
        clast_gpu_write(commands, &scene->shapes, 0, shapes, count * sizeof *shapes);
    }
    clast_free(context, list);
    clast_free(context, shapes);
    return status;
}

void clast_driver_scene_build(clast_gpu_commands *commands, const clast_driver_instance *instances, size_t count,
                              clast_driver_build build, clast_driver_scene *scene)
{
    if (commands->status != CLAST_OK) {
        return;
    }
    clast_status status = reserve_scene(clast_gpu_of(commands), count, build, scene);
    if (status == CLAST_OK && count != 0) {
        status = write_lists(commands, instances, count, scene);
    }
    clast_gpu_note(commands, status);
    if (status != CLAST_OK) {
        return;
    }
    scene->count = (uint32_t)count;
    clast_driver_top top = {store_address(scene->structure.address), store_address(scene->shapes.address)};
    clast_gpu_write(commands, &scene->top, 0, &top, sizeof top);
    clast_gpu_barrier(commands);
    clast_driver_build_top(commands, &scene->structure, scene->instances.address, scene->count, &scene->scratch);
}

void clast_driver_scene_free(clast_gpu *gpu, clast_driver_scene *scene)
{
    clast_driver_free(gpu, &scene->structure);
    clast_gpu_free(gpu, &scene->instances);
    clast_gpu_free(gpu, &scene->shapes);
    clast_gpu_free(gpu, &scene->top);
    clast_gpu_free(gpu, &scene->scratch.buffer);
    *scene = (clast_driver_scene){0};
}

uint64_t clast_driver_scene_bytes(const clast_driver_scene *scene)
{
    return scene->structure.memory.bytes + scene->instances.bytes + scene->shapes.bytes + scene->scratch.buffer.bytes;
}
