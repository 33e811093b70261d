// SPDX-License-Identifier: Apache-2.0
// Instances on a device: their records, and the tree that rays are traced through. Maps are inverted here, in double precision, as
// that of the processor's own tree are; what depends on the units is the device's (shaders/frame/place.comp).
#include <string.h>

#include "accel/structures.h"
#include "base/thread.h"
#include "shared/cluster.h"
#include "vulkan/frame_state.h"
#include "vulkan/maps.h"

enum { INSTANCE_GRAIN = 2048 };

typedef struct instance_job {
    const clast_frame *frame;
    clast_device_instance *list;
    clast_device_map *maps;
    size_t known; // instances that the device has
    clast_place_kernel place;
    atomic_bool differs, moves;
} instance_job;

// ------------------------------------------------------------------------------------------------------------ records

static clast_device_instance instance_record(const clast_frame_instance *instance)
{
    return (clast_device_instance){
        .to_world = instance->to_world,
        .to_object = instance->to_object,
        .bounds = instance->bounds,
        .unit = instance->unit,
        .scene_instance = instance->scene_instance,
        .state = (instance->hidden ? INSTANCE_HIDDEN : 0) | (instance->occluded ? INSTANCE_OCCLUDED : 0),
    };
}

static bool same_place(const clast_device_instance *a, const clast_device_instance *b)
{
    return memcmp(&a->to_world, &b->to_world, sizeof a->to_world) == 0 && a->unit == b->unit &&
           a->scene_instance == b->scene_instance;
}

// Maps of some instances, by the processor's own kernel.
static void make_maps(instance_job *job, size_t begin, size_t end)
{
    for (size_t first = begin; first < end; first += CLAST_MAPS_TOGETHER) {
        const clast_frame_instance *instances = &job->frame->instances[first];
        const clast_transform *transforms[CLAST_MAPS_TOGETHER];
        size_t count = end - first < CLAST_MAPS_TOGETHER ? end - first : CLAST_MAPS_TOGETHER;
        for (size_t i = 0; i < count; i++) {
            transforms[i] = &instances[i].to_world;
        }
        clast_make_maps(job->place, transforms, count, job->maps + first);
        for (size_t i = 0; i < count; i++) {
            job->maps[first + i].unit = instances[i].unit;
            job->maps[first + i].id = instances[i].scene_instance;
        }
    }
}

static void look_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    instance_job *job = data;
    bool differs = false, moves = false;
    for (size_t i = begin; i < end; i++) {
        clast_device_instance record = instance_record(&job->frame->instances[i]);
        moves = moves || i >= job->known || !same_place(&job->list[i], &record);
        differs = differs || moves || memcmp(&job->list[i], &record, sizeof record) != 0;
        job->list[i] = record;
    }
    if (moves) {
        make_maps(job, begin, end);
        atomic_store_explicit(&job->moves, true, memory_order_relaxed);
    }
    if (differs) {
        atomic_store_explicit(&job->differs, true, memory_order_relaxed);
    }
}

static clast_status make_list_room(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    size_t count = frame->instance_count;
    clast_status status = CLAST_RESERVE(device->context, device->instance_list, device->instance_capacity, count);
    return status == CLAST_OK ? CLAST_RESERVE(device->context, device->map_list, device->map_capacity, count) : status;
}

static clast_status make_buffer_room(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint64_t count = frame->instance_count;
    uint64_t before[] = {device->instances.address, device->maps.address};
    const struct {
        clast_gpu_buffer *buffer;
        uint64_t bytes;
        const char *name;
    } all[] = {
        {&device->instances, count * sizeof(clast_device_instance), "instances"},
        {&device->maps, count * sizeof(clast_device_map), "maps of instances"},
        {&device->instance_of, frame->frame_instance_of_count * sizeof(uint32_t), "numbers of instances"},
        {&device->placements, count * sizeof(clast_device_placement), "placements"},
        {&device->placement_boxes, count * sizeof(clast_box), "boxes of placements"},
        {&device->placement_tree, clast_gpu_tree_bytes((uint32_t)count), "a tree over placements"},
        {&device->scene, sizeof(clast_device_scene), "a scene"},
        {&device->head, sizeof(clast_device_frame), "a frame"},
    };
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < sizeof all / sizeof *all && status == CLAST_OK; i++) {
        status = clast_gpu_reserve(device->gpu, CLAST_GPU_DEVICE, all[i].bytes, all[i].name, all[i].buffer);
    }
    if (device->instances.address != before[0] || device->maps.address != before[1]) {
        device->instance_count = 0; // what was there is lost
    }
    return status;
}

clast_status clast_vulkan_write_instances(clast_frame *frame, clast_gpu_commands *commands, bool *moves)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    size_t count = frame->instance_count;
    clast_status status = make_list_room(frame);
    status = status == CLAST_OK ? make_buffer_room(frame) : status;
    if (status != CLAST_OK) {
        return status;
    }
    instance_job job = {.frame = frame,
                        .list = device->instance_list,
                        .maps = device->map_list,
                        .known = device->instance_count,
                        .place = clast_accel_kernels_of(clast_context_isa(device->context))->place};
    atomic_init(&job.differs, false);
    atomic_init(&job.moves, count != device->instance_count);
    clast_parallel_for(device->context, count, INSTANCE_GRAIN, look_range, &job);
    *moves = atomic_load(&job.moves);
    if (atomic_load(&job.differs)) {
        clast_gpu_write(commands, &device->instances, 0, device->instance_list, count * sizeof *device->instance_list);
    }
    if (*moves) {
        clast_gpu_write(commands, &device->maps, 0, device->map_list, count * sizeof *device->map_list);
        clast_gpu_write(commands, &device->instance_of, 0, frame->frame_instance_of,
                        frame->frame_instance_of_count * sizeof *frame->frame_instance_of);
    }
    device->instance_count = count;
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------------- tree

// The push constants of shaders/frame/place.comp.
typedef struct place_push {
    uint64_t units, maps, placements, boxes;
    uint32_t count;
} place_push;

static float spread_of(const clast_vulkan_frame *device)
{
    float spread = 1.0f;
    for (size_t i = 0; i < device->instance_count; i++) {
        spread = max1(spread, device->map_list[i].condition);
    }
    return spread;
}

clast_status clast_vulkan_build_scene(clast_frame *frame, clast_gpu_commands *commands)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint32_t count = (uint32_t)frame->instance_count;
    clast_device_scene scene = {
        .nodes = store_address(device->placement_tree.address),
        .placements = store_address(device->placements.address),
        .box = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}},
        .spread = spread_of(device),
        .placement_count = count,
    };
    clast_gpu_write(commands, &device->scene, 0, &scene, sizeof scene);
    if (count == 0) {
        return CLAST_OK;
    }
    place_push push = {.units = device->unit_records.address,
                       .maps = device->maps.address,
                       .placements = device->placements.address,
                       .boxes = device->placement_boxes.address,
                       .count = count};
    clast_gpu_barrier(commands);
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_FRAME_PLACE,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = (count + SOURCE_GROUP - 1) / SOURCE_GROUP});
    clast_gpu_tree tree = {.boxes = device->placement_boxes.address,
                           .nodes = device->placement_tree.address,
                           .bounds = device->scene.address + offsetof(clast_device_scene, box),
                           .count = count};
    return clast_gpu_trees_build(device->trees, commands, &tree, 1, CLAST_GPU_TREE_SORTED);
}
