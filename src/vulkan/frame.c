// SPDX-License-Identifier: Apache-2.0
// A frame on a device: its life, and what of it the processor uploads.
#include "vulkan/frame.h"

#include <string.h>

#include "vulkan/frame_driver.h"
#include "vulkan/frame_state.h"
#include "vulkan/render.h"

clast_status clast_vulkan_frame_create(clast_gpu *gpu, clast_vulkan_frame **result)
{
    clast_context *context = clast_gpu_context(gpu);
    clast_vulkan_frame *device = clast_allocate_zeroed(context, 1, sizeof *device);
    if (device == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    device->gpu = gpu;
    device->context = context;
    clast_status status = clast_mirror_create(gpu, &device->mirror);
    if (status == CLAST_OK) {
        status = clast_gpu_trees_create(gpu, &device->trees);
    }
    if (status != CLAST_OK) {
        clast_mirror_destroy(device->mirror);
        clast_free(context, device);
        return status;
    }
    *result = device;
    return CLAST_OK;
}

clast_status clast_vulkan_frame_use_driver(clast_vulkan_frame *device)
{
    return device->driver != NULL ? CLAST_OK : clast_frame_driver_create(device->gpu, &device->driver);
}

// What a unit has and the frame itself, as lists of buffers: for what is done to all of them.
enum { UNIT_BUFFERS = 8, FRAME_BUFFERS = 16 };

static void list_unit_buffers(clast_vulkan_unit *unit, clast_gpu_buffer *list[UNIT_BUFFERS])
{
    clast_gpu_buffer *all[UNIT_BUFFERS] = {&unit->records, &unit->words,  &unit->vertices, &unit->clusters,
                                           &unit->boxes,   &unit->places, &unit->tree,     &unit->shape};
    memcpy(list, all, sizeof all);
}

static void list_frame_buffers(clast_vulkan_frame *device, clast_gpu_buffer *list[FRAME_BUFFERS])
{
    clast_gpu_buffer *all[FRAME_BUFFERS] = {
        &device->unit_records,    &device->instances,      &device->instance_of, &device->head,
        &device->spans,           &device->item_counts,    &device->sums,        &device->spaces,
        &device->scratch,         &device->scene,          &device->maps,        &device->placements,
        &device->placement_boxes, &device->placement_tree, &device->drafts,      &device->depths};
    memcpy(list, all, sizeof all);
}

static void free_unit(clast_vulkan_frame *device, clast_vulkan_unit *unit)
{
    clast_gpu_buffer *list[UNIT_BUFFERS];
    list_unit_buffers(unit, list);
    for (int i = 0; i < UNIT_BUFFERS; i++) {
        clast_gpu_free(device->gpu, list[i]);
    }
    *unit = (clast_vulkan_unit){0};
}

// Ends what is being recorded: as it was not submitted, nothing of it happens.
static void abandon(clast_vulkan_frame *device)
{
    if (device->commands != NULL) {
        uint64_t ticket = 0;
        clast_gpu_note(device->commands, CLAST_ERROR_STATE);
        clast_gpu_submit(device->commands, &ticket);
        device->commands = NULL;
    }
}

void clast_vulkan_frame_destroy(clast_vulkan_frame *device)
{
    if (device == NULL) {
        return;
    }
    clast_context *context = device->context;
    abandon(device);
    clast_vulkan_free_coarse(device);
    clast_vulkan_render_destroy(device->render);
    clast_frame_driver_destroy(device->driver);
    for (size_t i = 0; i < device->unit_count; i++) {
        free_unit(device, &device->units[i]);
    }
    clast_gpu_buffer *list[FRAME_BUFFERS];
    list_frame_buffers(device, list);
    for (int i = 0; i < FRAME_BUFFERS; i++) {
        clast_gpu_free(device->gpu, list[i]);
    }
    clast_topologies_free(device->gpu, &device->topologies);
    clast_gpu_trees_destroy(device->trees);
    clast_mirror_destroy(device->mirror);
    clast_free(context, device->units);
    clast_free(context, device->records);
    clast_free(context, device->span_list);
    clast_free(context, device->unit_sums);
    clast_free(context, device->instance_list);
    clast_free(context, device->map_list);
    clast_free(context, device);
}

// What the failed passes recorded has not happened, though it is noted as done: everything is uploaded anew.
void clast_vulkan_forget(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_vulkan_begin(device);
    clast_vulkan_free_coarse(device);
    device->instance_count = 0;
    for (size_t i = 0; i < device->unit_count; i++) {
        device->units[i].shape_is_made = false;
    }
    clast_mirror_forget(device->mirror);
    clast_topologies_free(device->gpu, &device->topologies);
}

clast_gpu *clast_vulkan_frame_gpu(const clast_vulkan_frame *device)
{
    return device->gpu;
}

uint64_t clast_vulkan_frame_address(const clast_vulkan_frame *device)
{
    return device->is_whole ? device->head.address : 0;
}

uint64_t clast_vulkan_frame_scene(const clast_vulkan_frame *device)
{
    return device->is_whole && device->driver == NULL ? device->scene.address : 0;
}

clast_frame_bytes clast_vulkan_count_bytes(const clast_vulkan_frame *device)
{
    clast_frame_bytes bytes = {
        .records = device->item_counts.bytes + device->unit_records.bytes + device->spans.bytes + device->sums.bytes +
                   device->spaces.bytes + device->scratch.bytes + device->head.bytes + device->drafts.bytes +
                   device->depths.bytes,
        .blas = clast_gpu_trees_bytes(device->trees) +
                (device->driver != NULL ? clast_frame_driver_bytes(device->driver) : 0),
        .tlas = device->instances.bytes + device->instance_of.bytes + device->maps.bytes + device->scene.bytes +
                device->placements.bytes + device->placement_boxes.bytes + device->placement_tree.bytes,
    };
    for (size_t i = 0; i < device->unit_count; i++) {
        const clast_vulkan_unit *unit = &device->units[i];
        bytes.records += unit->records.bytes + unit->words.bytes;
        bytes.vertices += unit->vertices.bytes;
        bytes.clas += unit->clusters.bytes + unit->places.bytes;
        bytes.blas += unit->tree.bytes + unit->boxes.bytes + unit->shape.bytes;
    }
    if (device->coarse_device != NULL) {
        clast_frame_bytes coarse = clast_vulkan_count_bytes(device->coarse_device);
        bytes.records += coarse.records + device->coarse_rays.bytes;
        bytes.vertices += coarse.vertices;
        bytes.clas += coarse.clas;
        bytes.blas += coarse.blas;
        bytes.tlas += coarse.tlas;
    }
    return bytes;
}

uint64_t clast_vulkan_frame_bytes(const clast_vulkan_frame *device)
{
    clast_frame_bytes bytes = clast_vulkan_count_bytes(device);
    return clast_mirror_bytes(device->mirror) + bytes.records + bytes.vertices + bytes.clas + bytes.blas + bytes.tlas;
}

// ------------------------------------------------------------------------------------------------------------ upload

clast_status clast_vulkan_renew(clast_frame *frame, uint64_t bytes, const char *name, clast_gpu_buffer *buffer)
{
    clast_gpu *gpu = clast_vulkan_of(frame)->gpu;
    if (frame->settings.max_bytes != 0 && buffer->bytes != (bytes + 15) / 16 * 16) {
        clast_gpu_free(gpu, buffer);
        return bytes != 0 ? clast_gpu_allocate(gpu, CLAST_GPU_DEVICE, bytes, name, buffer) : CLAST_OK;
    }
    return clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, bytes, name, buffer);
}

static clast_status make_room(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_context *context = device->context;
    clast_status status = CLAST_RESERVE(context, device->units, device->unit_capacity, frame->unit_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, device->records, device->record_capacity, frame->unit_count);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, device->unit_sums, device->sum_capacity, frame->unit_count);
    }
    while (status == CLAST_OK && device->unit_count < frame->unit_count) {
        device->records[device->unit_count] = (clast_device_unit){0};
        device->units[device->unit_count++] = (clast_vulkan_unit){0};
    }
    return status;
}

// Where what was made of a unit lies.
static void describe_unit(const clast_vulkan_frame *device, size_t number, const clast_frame_unit *unit)
{
    const clast_vulkan_unit *own = &device->units[number];
    clast_device_unit *record = &device->records[number];
    record->view = unit->view;
    record->view.depths = store_address(load_address(unit->view.depths) != 0 ? device->depths.address : 0);
    record->bounds = unit->bounds;
    record->filtered = unit->filtered ? 1 : 0;
    record->sums = store_address(device->sums.address + number * sizeof(clast_unit_sums));
    record->drafts = store_address(own->drafts);
    record->record_count = own->record_count;
    record->records = store_address(own->records.address);
    record->words = store_address(own->words.address);
    record->vertices = store_address(own->vertices.address);
    record->clusters = store_address(own->clusters.address);
    record->boxes = store_address(own->boxes.address);
    record->places = store_address(own->places.address);
    record->tree = store_address(own->tree.address);
}

static clast_status mirror_units(clast_frame *frame, clast_gpu_commands *commands)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_status status = clast_mirror_begin(device->mirror, frame->unit_count);
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (unit->used) {
            status = clast_mirror_unit(device->mirror, commands, i, unit, &device->records[i]);
        } else { // what it is made of leaves the device: where it comes back, it is made anew
            device->records[i] = (clast_device_unit){0};
            unit->made = false;
        }
        if (!unit->made) {
            device->units[i].record_count = 0;
        }
    }
    clast_mirror_end(device->mirror);
    return status;
}

// What a frame's units have on the device, from the frame that mirrors them.
static void borrow_units(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        device->records[i] = unit->used ? device->parent->records[i] : (clast_device_unit){0};
        device->records[i].item_counts = device->records[i].spaces = store_address(0);
        unit->made = unit->made && unit->used;
        if (!unit->made) {
            device->units[i].record_count = 0;
        }
    }
    device->is_prepared = true;
}

clast_status clast_vulkan_prepare(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    if (device->is_prepared) {
        return CLAST_OK;
    }
    clast_gpu_commands *commands = NULL;
    uint64_t ticket = 0;
    clast_status status = make_room(frame);
    if (status == CLAST_OK && device->parent != NULL) {
        borrow_units(frame);
        return CLAST_OK;
    }
    if (status == CLAST_OK) {
        status = clast_gpu_begin(device->gpu, &commands);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_pass(commands, "upload");
    status = mirror_units(frame, commands);
    if (status == CLAST_OK) {
        status = clast_topologies_update(&device->topologies, commands, frame->cooked->templates);
    }
    clast_gpu_note(commands, status);
    status = clast_gpu_submit(commands, &ticket);
    device->is_prepared = status == CLAST_OK;
    return status;
}

clast_status clast_vulkan_describe_units(clast_frame *frame)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_gpu *gpu = device->gpu;
    clast_status status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, device->unit_count * sizeof *device->records,
                                            "units", &device->unit_records);
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, device->span_count * sizeof *device->span_list, "spans",
                                   &device->spans);
    }
    if (status == CLAST_OK) {
        status = clast_gpu_reserve(gpu, CLAST_GPU_DEVICE, device->unit_count * sizeof *device->unit_sums,
                                   "sums of units", &device->sums);
    }
    for (size_t i = 0; i < device->unit_count && status == CLAST_OK; i++) {
        if (frame->units[i].used) {
            describe_unit(device, i, &frame->units[i]);
        }
    }
    return status;
}

void clast_vulkan_write_units(clast_vulkan_frame *device, clast_gpu_commands *commands)
{
    clast_gpu_write(commands, &device->unit_records, 0, device->records, device->unit_count * sizeof *device->records);
    clast_gpu_write(commands, &device->spans, 0, device->span_list, device->span_count * sizeof *device->span_list);
    clast_gpu_fill(commands, &device->sums, 0, device->unit_count * sizeof *device->unit_sums, 0);
    clast_gpu_barrier(commands);
}

// -------------------------------------------------------------------------------------------------------------- back

static clast_status read_back(clast_frame *frame, const clast_gpu_buffer *buffer, uint64_t first, uint64_t count,
                              size_t size, void *to)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    if (count == 0) {
        return CLAST_OK;
    }
    if (!device->is_whole || first > buffer->bytes / size || count > buffer->bytes / size - first) {
        return clast_fail(frame->context, CLAST_ERROR_STATE, "vulkan: the frame has nothing there");
    }
    clast_gpu_commands *commands = NULL;
    clast_status status = clast_gpu_begin(device->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_read(commands, buffer, first * size, to, count * size);
    return clast_gpu_finish(commands);
}

clast_status clast_vulkan_frame_read_records(clast_frame *frame, size_t unit, size_t first, size_t count,
                                             clast_cluster_record *records)
{
    return read_back(frame, &clast_vulkan_of(frame)->units[unit].records, first, count, sizeof *records, records);
}

clast_status clast_vulkan_frame_read_words(clast_frame *frame, size_t unit, size_t first, size_t count, uint32_t *words)
{
    return read_back(frame, &clast_vulkan_of(frame)->units[unit].words, first, count, sizeof *words, words);
}

clast_status clast_vulkan_frame_read_vertices(clast_frame *frame, size_t unit, size_t first, size_t count,
                                              packed3 *vertices)
{
    return read_back(frame, &clast_vulkan_of(frame)->units[unit].vertices, first, count, sizeof *vertices, vertices);
}

// ------------------------------------------------------------------------------------------------------------ passes

void clast_vulkan_begin(clast_vulkan_frame *device)
{
    abandon(device);
    device->is_prepared = false;
    device->is_whole = false;
    device->kept_units = 0;
}

clast_status clast_vulkan_animate(clast_frame *frame, void *target)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_vulkan_begin(device);
    return clast_cpu_animate(frame, target);
}

clast_status clast_vulkan_count(clast_frame *frame, void *target)
{
    clast_status status = clast_vulkan_prepare(frame);
    return status == CLAST_OK ? clast_cpu_count(frame, target) : status;
}
