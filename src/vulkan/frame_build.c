// SPDX-License-Identifier: Apache-2.0
// Passes blas and tlas on a device: trees, instances, and the record that tells kernels of the frame. The end of the latter is
// where the processor waits for the device.
#include <string.h>

#include "frame/unit.h"
#include "vulkan/frame_driver.h"
#include "vulkan/frame_state.h"

// ------------------------------------------------------------------------------------------------------------- trees

// Trees to be built, from the first on, and such to be fitted, from the last on.
typedef struct tree_list {
    clast_gpu_tree *trees;
    size_t room;
    uint32_t built, fitted;
} tree_list;

// The box around a unit lies behind those of its clusters.
static clast_gpu_tree tree_of(const clast_vulkan_unit *unit)
{
    return (clast_gpu_tree){.boxes = unit->boxes.address,
                            .items = unit->places.address,
                            .nodes = unit->tree.address,
                            .bounds = unit->boxes.address + unit->record_count * sizeof(clast_box),
                            .count = unit->record_count};
}

static clast_status add_tree(clast_frame *frame, const clast_frame_unit *unit, tree_list *list)
{
    clast_vulkan_unit *own = &clast_vulkan_of(frame)->units[unit->unit->number];
    clast_status status = CLAST_OK;
    bool keeps = clast_vulkan_keeps_shape(unit);
    if (keeps) {
        status = clast_vulkan_shape_unit(frame, unit);
    }
    clast_gpu_tree tree = tree_of(own);
    if (keeps && own->shape.bytes != 0) {
        tree.kept = own->shape.address;
        list->trees[list->room - ++list->fitted] = tree;
    } else {
        list->trees[list->built++] = tree;
    }
    return status;
}

clast_status clast_vulkan_blas(clast_frame *frame, void *target)
{
    (void)target;
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    if (device->driver != NULL) {
        return clast_frame_driver_build_units(frame, device->commands);
    }
    tree_list list = {.room = frame->unit_count + 1};
    list.trees = clast_allocate(device->context, list.room, sizeof *list.trees);
    if (list.trees == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        const clast_frame_unit *unit = &frame->units[i];
        if (unit->used && unit->change != CLAST_CHANGE_NOTHING && device->units[i].record_count != 0) {
            status = add_tree(frame, unit, &list);
        }
    }
    if (status == CLAST_OK && list.built + list.fitted != 0) {
        clast_gpu_pass(device->commands, "blas");
        status = clast_gpu_trees_build(device->trees, device->commands, list.trees, list.built, CLAST_GPU_TREE_SORTED);
        if (status == CLAST_OK) {
            status = clast_gpu_trees_refit(device->trees, device->commands, list.trees + list.room - list.fitted,
                                           list.fitted);
        }
        clast_gpu_barrier(device->commands);
    }
    clast_free(device->context, list.trees);
    return status;
}

// ---------------------------------------------------------------------------------------------------------------- end

static void write_head(clast_frame *frame, clast_gpu_commands *commands)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_device_frame head = {
        .units = store_address(device->unit_records.address),
        .instances = store_address(device->instances.address),
        .instance_of = store_address(device->instance_of.address),
        .tree = store_address(device->driver != NULL ? clast_frame_driver_scene(device->driver)
                                                     : device->scene.address),
        .templates = store_address(clast_vulkan_topologies(device)->templates.address),
        .unit_count = (uint32_t)frame->unit_count,
        .instance_count = (uint32_t)frame->instance_count,
        .scene_instance_count = (uint32_t)frame->frame_instance_of_count,
        .camera = frame->settings.camera,
        .rate_camera = frame->settings.rate_camera,
    };
    clast_gpu_write(commands, &device->head, 0, &head, sizeof head);
}

// The time that passes took on the device, in place of that for which the processor waited for all of them.
static void share_out_time(clast_frame *frame)
{
    static const struct {
        const char *name;
        clast_pass pass;
    } passes[] = {{"emit", CLAST_PASS_EMIT}, {"fill", CLAST_PASS_FILL}, {"blas", CLAST_PASS_BLAS}};
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t count = clast_gpu_passes(clast_vulkan_of(frame)->gpu, times);
    for (uint32_t i = 0; i < count; i++) {
        for (size_t k = 0; k < sizeof passes / sizeof *passes; k++) {
            if (strcmp(times[i].pass, passes[k].name) == 0) {
                frame->milliseconds[passes[k].pass] += times[i].milliseconds;
                frame->milliseconds[CLAST_PASS_TLAS] -= times[i].milliseconds;
            }
        }
    }
}

static clast_status finish(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_gpu_commands *commands = device->commands;
    clast_gpu_read(commands, &device->sums, 0, device->unit_sums, device->unit_count * sizeof *device->unit_sums);
    device->commands = NULL;
    clast_status status = clast_gpu_finish(commands);
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (unit->used && unit->change == CLAST_CHANGE_TOPOLOGY) {
            unit->cluster_vertices = load_address(device->unit_sums[i].cluster_vertices);
            unit->cluster_fill = load_address(device->unit_sums[i].cluster_fill);
        }
        if (unit->used) {
            clast_unit_note_made(unit);
        }
    }
    share_out_time(frame);
    clast_frame_sum_up(frame);
    clast_cooked_release(frame->cooked);
    frame->device_bytes = clast_vulkan_count_bytes(device);
    device->is_whole = true;
    return CLAST_OK;
}

// Whether placements tell of units what is so no longer.
static bool units_changed(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    bool changed = false;
    for (size_t i = 0; i < frame->unit_count; i++) {
        const clast_frame_unit *unit = &frame->units[i];
        if (unit->used) {
            changed = changed || unit->change != CLAST_CHANGE_NOTHING || unit->filtered != device->units[i].filtered;
            device->units[i].filtered = unit->filtered;
        }
    }
    return changed;
}

clast_status clast_vulkan_tlas(clast_frame *frame, void *target)
{
    (void)target;
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    bool moves = false, changed = units_changed(frame);
    clast_gpu_pass(device->commands, "tlas");
    clast_status status = clast_vulkan_write_instances(frame, device->commands, &moves);
    if (status == CLAST_OK && (moves || changed || frame->instance_count == 0)) {
        status = device->driver != NULL ? clast_frame_driver_build_scene(frame, device->commands)
                                        : clast_vulkan_build_scene(frame, device->commands);
    }
    if (status != CLAST_OK) {
        return status;
    }
    write_head(frame, device->commands);
    return finish(frame);
}
