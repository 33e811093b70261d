// SPDX-License-Identifier: Apache-2.0
// The shapes of the trees of meshes that bend: each is built once, by the processor, over the clusters of the mesh at rest, and fitted
// on the device to where these are. So a tree depends on the mesh and on the moment, and not on what was made before.
#include "accel/structures.h"
#include "base/size.h"
#include "base/thread.h"
#include "frame/unit.h"
#include "vulkan/frame_state.h"

enum { REST_GRAIN = 64 };

// What a unit emits at rest.
typedef struct rest_unit {
    const clast_frame_unit *unit;
    const clast_source *source;
    clast_pose pose;
    clast_cluster_record *records;
    uint32_t *words;
    clast_box *boxes;
    uint64_t record_count, word_count;
} rest_unit;

bool clast_vulkan_keeps_shape(const clast_frame_unit *unit)
{
    return !clast_source_of(unit->unit)->adapts && unit->pose.positions != NULL;
}

static void free_rest(clast_context *context, rest_unit *rest)
{
    clast_free(context, rest->records);
    clast_free(context, rest->words);
    clast_free(context, rest->boxes);
}

static void count_rest(rest_unit *rest)
{
    const clast_unit *unit = rest->unit->unit;
    for (uint32_t item = 0; item < unit->item_count; item++) {
        clast_source_count count = rest->source->count(unit, &rest->pose, &rest->unit->view, item);
        rest->record_count += count.clusters;
        rest->word_count += count.words;
    }
}

static void emit_rest(rest_unit *rest)
{
    const clast_unit *unit = rest->unit->unit;
    uint64_t record = 0, vertex = 0, word = 0;
    for (uint32_t item = 0; item < unit->item_count; item++) {
        clast_source_count count = rest->source->count(unit, &rest->pose, &rest->unit->view, item);
        rest->source->emit(unit, &rest->pose, &rest->unit->view, item, (uint32_t)vertex, (uint32_t)word,
                           rest->words + word, rest->records + record);
        record += count.clusters;
        vertex += count.vertices;
        word += count.words;
    }
}

static void bound_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const rest_unit *rest = data;
    const clast_unit *unit = rest->unit->unit;
    packed3 filled[TEMPLATE_VERTICES];
    for (size_t i = begin; i < end; i++) {
        const clast_cluster_record *record = &rest->records[i];
        const packed3 *positions = rest->source->resident(unit, record);
        if (positions == NULL) {
            rest->source->fill(unit, &rest->pose, record, rest->words + record->first_word, filled);
            positions = filled;
        }
        clast_box box = clast_box_empty();
        for (uint32_t k = 0; k < record_vertices(*record); k++) {
            vec3 p = load3(positions[k]);
            if (is_sound3(p)) {
                box.lower = store3(min3(load3(box.lower), p));
                box.upper = store3(max3(load3(box.upper), p));
            }
        }
        rest->boxes[i] = box;
    }
}

static clast_status build_rest(clast_context *context, const rest_unit *rest, clast_tree *tree)
{
    size_t count = (size_t)rest->record_count;
    clast_arena scratch = {clast_allocate(context, clast_tree_scratch(count), 1), 0};
    if (scratch.memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_tree_build(context, tree, rest->boxes, NULL, count, CLAST_BUILD_BEST, &scratch);
    clast_free(context, scratch.memory);
    return status;
}

// Brings the shape of a tree to the device. A tree that is too deep has none.
static clast_status upload_shape(clast_frame *frame, clast_vulkan_unit *own, const clast_tree *tree)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint64_t bytes = clast_gpu_tree_shape_bytes(tree);
    void *shape = clast_allocate(device->context, bytes, 1);
    if (shape == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = clast_gpu_tree_shape(device->context, tree, shape);
    if (status == CLAST_OK) {
        status = clast_vulkan_renew(frame, bytes, "the shape of a tree", &own->shape);
        if (status == CLAST_OK) {
            clast_gpu_write(device->commands, &own->shape, 0, shape, bytes);
            clast_gpu_barrier(device->commands);
        }
    } else if (status == CLAST_ERROR_UNSUPPORTED) {
        clast_gpu_free(device->gpu, &own->shape);
        status = CLAST_OK;
    }
    clast_free(device->context, shape);
    return status;
}

static clast_status make_shape(clast_frame *frame, const clast_frame_unit *unit, clast_vulkan_unit *own)
{
    clast_context *context = frame->context;
    rest_unit rest = {.unit = unit, .source = clast_source_of(unit->unit), .pose = {.displacement_scale = 1.0f}};
    rest.pose.version = unit->unit->version;
    count_rest(&rest);
    if (rest.record_count != own->record_count) {
        return clast_fail(context, CLAST_ERROR_STATE,
                          "vulkan: geometry %u has other clusters at rest than when it bends", unit->unit->number);
    }
    rest.records = clast_allocate(context, (size_t)rest.record_count + 1, sizeof *rest.records);
    rest.words = clast_allocate(context, (size_t)rest.word_count + 1, sizeof *rest.words);
    rest.boxes = clast_allocate(context, (size_t)rest.record_count + 1, sizeof *rest.boxes);
    clast_tree tree = {0};
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (rest.records != NULL && rest.words != NULL && rest.boxes != NULL) {
        emit_rest(&rest);
        clast_parallel_for(context, (size_t)rest.record_count, REST_GRAIN, bound_range, &rest);
        status = build_rest(context, &rest, &tree);
    }
    if (status == CLAST_OK) {
        status = upload_shape(frame, own, &tree);
    }
    clast_tree_free(context, &tree);
    free_rest(context, &rest);
    return status;
}

clast_status clast_vulkan_shape_unit(clast_frame *frame, const clast_frame_unit *unit)
{
    clast_vulkan_unit *own = &clast_vulkan_of(frame)->units[unit->unit->number];
    if (own->shape_is_made && own->shape_serial == unit->unit->serial && own->shape_version == unit->unit->version) {
        return CLAST_OK;
    }
    clast_status status = make_shape(frame, unit, own);
    own->shape_is_made = status == CLAST_OK;
    own->shape_serial = unit->unit->serial;
    own->shape_version = unit->unit->version;
    return status;
}
