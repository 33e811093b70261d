// SPDX-License-Identifier: Apache-2.0
// Passes emit and fill on a device: records, then vertices and the clusters that are fitted to them. Room is made for all of it
// before anything is recorded, from what was counted: so nothing has to come back in between.
#include <string.h>

#include "frame/unit.h"
#include "shared/cluster.h"
#include "vulkan/fit.h"
#include "vulkan/frame_state.h"
#include "vulkan/sums.h"

// The units of a frame that change, and what is to be done with them.
typedef struct make_list {
    clast_frame_unit **changed; // vertices at least
    clast_frame_unit **emitted; // records too
    size_t changed_count, emitted_count;
    uint64_t record_count; // of the emitted ones
    clast_span_range items[CLAST_KINDS_MOST], fills[CLAST_KINDS_MOST], batches;
} make_list;

static void free_list(clast_vulkan_frame *device, make_list *list)
{
    clast_free(device->context, list->changed);
    clast_free(device->context, list->emitted);
}

static clast_status list_units(clast_frame *frame, make_list *list)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    list->changed = clast_allocate(device->context, frame->unit_count + 1, sizeof *list->changed);
    list->emitted = clast_allocate(device->context, frame->unit_count + 1, sizeof *list->emitted);
    if (list->changed == NULL || list->emitted == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (unit->used && unit->change != CLAST_CHANGE_NOTHING) {
            list->changed[list->changed_count++] = unit;
        }
        if (unit->used && unit->change == CLAST_CHANGE_TOPOLOGY) {
            list->emitted[list->emitted_count++] = unit;
        }
    }
    return CLAST_OK;
}

// What items need must be that of these units at their rate. It is, unless the units that change have been counted at
// different rates: then they are counted once more.
static clast_status check_kept(clast_frame *frame, const make_list *list)
{
    const clast_vulkan_frame *device = clast_vulkan_of(frame);
    if (list->emitted_count == 0) {
        return CLAST_OK;
    }
    float rate = list->emitted[0]->view.rate;
    if (device->kept_units == list->emitted_count && device->kept_rate == rate) {
        return CLAST_OK;
    }
    clast_unit_tally *tallies = clast_allocate_zeroed(frame->context, list->emitted_count, sizeof *tallies);
    if (tallies == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < list->emitted_count; i++) {
        tallies[i].unit = list->emitted[i];
    }
    clast_status status = clast_vulkan_count_units(frame, tallies, list->emitted_count, rate, true);
    clast_free(frame->context, tallies);
    return status;
}

// -------------------------------------------------------------------------------------------------------------- room

// At least what the clusters of a unit take (cluster_space): nodes are counted as if each had a part of one to itself.
static uint64_t cluster_bytes(const clast_frame_need *need)
{
    const uint64_t fixed = CLUSTER_HEAD_BYTES + 2 * CLUSTER_NODE_BYTES + CLUSTER_UNIT;
    uint64_t nodes = need->triangles * CLUSTER_NODE_BYTES / (2 * TREE_CHILDREN);
    uint64_t pairs = need->blocks != 0 ? (need->triangles + need->clusters) * PAIR_BYTES / 2 : 0;
    return need->clusters * fixed + nodes + pairs;
}

static clast_status make_unit_room(clast_frame *frame, clast_frame_unit *unit)
{
    clast_vulkan_unit *own = &clast_vulkan_of(frame)->units[unit->unit->number];
    const clast_frame_need *sum = &unit->sum;
    const struct {
        clast_gpu_buffer *buffer;
        uint64_t bytes;
        const char *name;
    } all[] = {
        {&own->records, sum->clusters * sizeof(clast_cluster_record), "records"},
        {&own->words, sum->words * sizeof(uint32_t), "words of records"},
        {&own->vertices, sum->vertices * sizeof(packed3), "vertices"},
        {&own->clusters, cluster_bytes(sum), "clusters"},
        {&own->boxes, (sum->clusters + 1) * sizeof(clast_box), "boxes of clusters"},
        {&own->places, sum->clusters * sizeof(uint32_t), "places of clusters"},
        {&own->tree, clast_gpu_tree_bytes((uint32_t)sum->clusters), "a tree over clusters"},
    };
    clast_status status = CLAST_OK;
    if (cluster_bytes(sum) / CLUSTER_UNIT >= INT32_MAX) { // trees number places
        status = clast_fail(frame->context, CLAST_ERROR_LIMIT, "vulkan: geometry %u needs %llu bytes of clusters",
                            unit->unit->number, (unsigned long long)cluster_bytes(sum));
    }
    for (size_t i = 0; i < sizeof all / sizeof *all && status == CLAST_OK; i++) {
        status = clast_vulkan_renew(frame, all[i].bytes, all[i].name, all[i].buffer);
    }
    unit->record_count = (size_t)sum->clusters;
    unit->vertex_count = (size_t)sum->vertices;
    unit->word_count = (size_t)sum->words;
    unit->counted = false; // what was kept is added up now
    own->record_count = status == CLAST_OK ? (uint32_t)sum->clusters : 0;
    return status;
}

static clast_status make_room(clast_frame *frame, make_list *list)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < list->emitted_count && status == CLAST_OK; i++) {
        status = make_unit_room(frame, list->emitted[i]);
        device->units[list->emitted[i]->unit->number].first_record = list->record_count;
        list->record_count += list->emitted[i]->record_count;
    }
    if (status == CLAST_OK && list->emitted_count != 0) {
        status = clast_vulkan_renew(frame, (list->record_count + 1) * sizeof(uint32_t), "spaces of clusters",
                                    &device->spaces);
    }
    if (status == CLAST_OK && list->emitted_count != 0) {
        status = clast_gpu_reserve(device->gpu, CLAST_GPU_DEVICE, clast_gpu_sums_scratch(5), "scratch of sums",
                                   &device->scratch);
    }
    return status;
}

static clast_status lay_out(clast_frame *frame, make_list *list)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = CLAST_OK;
    device->span_count = 0;
    for (uint32_t kind = 0; kind < clast_source_kind_count && status == CLAST_OK; kind++) {
        status = clast_vulkan_add_spans(device, list->emitted, list->emitted_count, kind, clast_item_groups,
                                        &list->items[kind]);
        if (status == CLAST_OK) {
            status = clast_vulkan_add_spans(device, list->changed, list->changed_count, kind, clast_record_groups,
                                            &list->fills[kind]);
        }
    }
    if (status == CLAST_OK) {
        status = clast_vulkan_add_spans(device, list->emitted, list->emitted_count, CLAST_NONE, clast_record_batches,
                                        &list->batches);
    }
    status = status == CLAST_OK ? clast_vulkan_describe_units(frame) : status;
    for (size_t i = 0; i < device->unit_count; i++) {
        device->records[i].spaces = store_address(0);
    }
    for (size_t i = 0; i < list->emitted_count; i++) {
        size_t number = list->emitted[i]->unit->number;
        device->records[number].spaces = store_address(device->spaces.address +
                                                       device->units[number].first_record * sizeof(uint32_t));
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- emit

static void record_emit(clast_vulkan_frame *device, const make_list *list)
{
    clast_gpu_commands *commands = device->commands;
    enum { COLUMNS = sizeof(clast_source_count) / sizeof(uint32_t) };
    if (list->record_count == 0) {
        return;
    }
    clast_gpu_pass(commands, "emit");
    clast_gpu_columns counts = {device->item_counts.address, 1, COLUMNS};
    clast_gpu_sums(commands, &(clast_gpu_sums_desc){.from = counts,
                                                    .to = counts,
                                                    .scratch = device->scratch.address,
                                                    .count = device->kept_items,
                                                    .columns = COLUMNS});
    clast_gpu_barrier(commands);
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        clast_vulkan_run_spans(device, commands, CLAST_SHADER_OF_KIND(FRAME_EMIT, kind), &list->items[kind], false);
    }
    clast_gpu_barrier(commands);
    clast_vulkan_run_spans(device, commands, CLAST_SHADER_FRAME_MEASURE, &list->batches, false);
    clast_gpu_barrier(commands);
    clast_gpu_columns spaces = {device->spaces.address, 0, 1};
    clast_gpu_sums(commands, &(clast_gpu_sums_desc){.from = spaces,
                                                    .to = spaces,
                                                    .scratch = device->scratch.address,
                                                    .count = list->record_count,
                                                    .columns = 1});
    clast_gpu_barrier(commands);
}

static void record_fill(clast_vulkan_frame *device, const make_list *list)
{
    if (list->changed_count == 0) {
        return;
    }
    clast_gpu_pass(device->commands, "fill");
    clast_gpu_lanes lanes = clast_gpu_lanes_of(device->gpu);
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        clast_vulkan_call_spans(device, device->commands, &list->fills[kind], false,
                                (clast_gpu_call){.shader = CLAST_SHADER_OF_KIND(FRAME_FILL, kind),
                                                 .constants = {lanes.lanes, lanes.group},
                                                 .constant_count = 2,
                                                 .groups = clast_gpu_lane_groups(lanes, list->fills[kind].groups),
                                                 .subgroup = lanes.lanes});
    }
    clast_gpu_barrier(device->commands);
}

static clast_status make_units(clast_frame *frame, make_list *list)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = list_units(frame, list);
    status = status == CLAST_OK ? check_kept(frame, list) : status;
    status = status == CLAST_OK ? make_room(frame, list) : status;
    status = status == CLAST_OK ? lay_out(frame, list) : status;
    status = status == CLAST_OK ? clast_gpu_begin(device->gpu, &device->commands) : status;
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_pass(device->commands, "upload");
    clast_vulkan_write_units(device, device->commands);
    record_emit(device, list);
    record_fill(device, list);
    device->kept_units = 0;
    return CLAST_OK;
}

// Fill is recorded along with it: the two share how the work is laid out.
clast_status clast_vulkan_emit(clast_frame *frame, void *target)
{
    (void)target;
    make_list list = {0};
    clast_status status = make_units(frame, &list);
    free_list(clast_vulkan_of(frame), &list);
    return status;
}

clast_status clast_vulkan_fill(clast_frame *frame, void *target)
{
    (void)frame;
    (void)target;
    return CLAST_OK;
}

// Clusters are fitted as they are filled.
clast_status clast_vulkan_refit(clast_frame *frame, void *target)
{
    (void)frame;
    (void)target;
    return CLAST_OK;
}
