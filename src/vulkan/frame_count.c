// SPDX-License-Identifier: Apache-2.0
// Counting on a device, and how a dispatch is laid out over several units.
#include <string.h>

#include "vulkan/frame_state.h"

// ------------------------------------------------------------------------------------------------------------- spans

uint64_t clast_item_groups(const clast_frame_unit *unit)
{
    uint64_t items = unit->unit->item_count;
    return clast_source_of(unit->unit)->single_items ? (items + SOURCE_GROUP - 1) / SOURCE_GROUP : items;
}

uint64_t clast_record_groups(const clast_frame_unit *unit)
{
    return unit->record_count;
}

uint64_t clast_record_batches(const clast_frame_unit *unit)
{
    return (unit->record_count + SOURCE_GROUP - 1) / SOURCE_GROUP;
}

clast_status clast_vulkan_add_spans(clast_vulkan_frame *device, clast_frame_unit *const *units, size_t count,
                                    uint32_t kind, clast_groups_function groups, clast_span_range *range)
{
    *range = (clast_span_range){.first = device->span_count};
    clast_status status = CLAST_RESERVE(device->context, device->span_list, device->span_capacity,
                                        device->span_count + count + 1);
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        uint64_t here = groups(units[i]);
        if ((kind == CLAST_NONE || (uint32_t)units[i]->unit->kind == kind) && here != 0) {
            device->span_list[device->span_count++] = (clast_device_span){(uint32_t)range->groups,
                                                                          units[i]->unit->number};
            range->groups += here;
            range->count++;
        }
    }
    device->span_list[device->span_count++] = (clast_device_span){(uint32_t)range->groups, 0};
    if (range->groups > INT32_MAX) {
        return clast_fail(device->context, CLAST_ERROR_LIMIT,
                          "vulkan: a frame of %llu clusters or items; expected less than 2^31",
                          (unsigned long long)range->groups);
    }
    return CLAST_OK;
}

void clast_vulkan_run_spans(clast_vulkan_frame *device, clast_gpu_commands *commands, clast_shader shader,
                            const clast_span_range *range, bool keep)
{
    clast_vulkan_call_spans(device, commands, range, keep, (clast_gpu_call){.shader = shader, .groups = range->groups});
}

void clast_vulkan_call_spans(clast_vulkan_frame *device, clast_gpu_commands *commands, const clast_span_range *range,
                             bool keep, clast_gpu_call call)
{
    if (range->groups == 0) {
        return;
    }
    clast_span_push push = {.units = device->unit_records.address,
                            .spans = device->spans.address + range->first * sizeof(clast_device_span),
                            .templates = clast_vulkan_topologies(device)->templates.address,
                            .span_count = (uint32_t)range->count,
                            .keep = keep ? 1 : 0};
    call.push = &push;
    call.push_bytes = sizeof push;
    clast_gpu_run(commands, &call);
}

// ------------------------------------------------------------------------------------------------------------- count

static clast_status list_units(const clast_vulkan_frame *device, const clast_unit_tally *tallies, size_t count,
                               clast_frame_unit ***list)
{
    *list = clast_allocate(device->context, count, sizeof **list);
    if (*list == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (size_t i = 0; i < count; i++) {
        (*list)[i] = tallies[i].unit;
    }
    return CLAST_OK;
}

// Where what the items of each unit need is kept: one after the other.
static clast_status place_items(clast_frame *frame, clast_frame_unit *const *list, size_t count)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint64_t items = 0;
    for (size_t i = 0; i < count; i++) {
        device->units[list[i]->unit->number].first_item = items;
        items += list[i]->unit->item_count;
    }
    device->kept_items = items;
    clast_status status = clast_vulkan_renew(frame, (items + 1) * sizeof(clast_source_count), "what items need",
                                             &device->item_counts);
    for (size_t i = 0; i < count && status == CLAST_OK; i++) {
        size_t number = list[i]->unit->number;
        device->records[number].item_counts = store_address(
            device->item_counts.address + device->units[number].first_item * sizeof(clast_source_count));
    }
    return status;
}

// Room for drafts of kinds that make them, by unit; none where memory is bounded. Without room there are none: then
// emitting takes longer.
static void place_drafts(clast_frame *frame, clast_gpu_commands *commands, clast_frame_unit *const *list, size_t count)
{
    // of an item, and of all; the least is for few items that are split many times
    enum { DRAFT_WORDS = 1536, DRAFT_WORDS_LEAST = 1 << 21, DRAFT_WORDS_MOST = 1 << 25 };
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    uint64_t items = 0;
    for (size_t i = 0; i < count; i++) {
        items += clast_source_of(list[i]->unit)->draft != NULL ? list[i]->unit->item_count : 0;
        device->units[list[i]->unit->number].drafts = 0;
    }
    uint64_t room = items < DRAFT_WORDS_MOST / DRAFT_WORDS ? items * DRAFT_WORDS : DRAFT_WORDS_MOST;
    room = room > DRAFT_WORDS_LEAST ? room : DRAFT_WORDS_LEAST;
    uint64_t head_at = (items * sizeof(uint32_t) + 15) / 16 * 16, place = 0;
    uint64_t bytes = head_at + sizeof(clast_draft_head) + room * sizeof(uint32_t);
    bool bounded = frame->settings.max_bytes != 0 || clast_context_memory_limit(device->context) != 0;
    bool none = items == 0 || bounded ||
                clast_gpu_reserve(device->gpu, CLAST_GPU_DEVICE, bytes, "drafts", &device->drafts) != CLAST_OK;
    if (none) {
        clast_gpu_free(device->gpu, &device->drafts);
        return;
    }
    clast_draft_head head = {0, (uint32_t)room};
    clast_gpu_write(commands, &device->drafts, head_at, &head, sizeof head);
    for (size_t i = 0; i < count; i++) {
        if (clast_source_of(list[i]->unit)->draft != NULL) {
            size_t number = list[i]->unit->number;
            device->units[number].drafts = device->drafts.address + head_at;
            device->records[number].draft_places = store_address(device->drafts.address + place * sizeof(uint32_t));
            place += list[i]->unit->item_count;
        }
    }
}

static clast_status record_count(clast_frame *frame, clast_gpu_commands *commands, clast_frame_unit *const *list,
                                 size_t count, float rate, bool keep)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_span_range ranges[CLAST_KINDS_MOST];
    clast_status status = keep ? place_items(frame, list, count) : CLAST_OK;
    if (keep && status == CLAST_OK) {
        place_drafts(frame, commands, list, count);
    }
    device->span_count = 0;
    for (uint32_t kind = 0; kind < clast_source_kind_count && status == CLAST_OK; kind++) {
        status = clast_vulkan_add_spans(device, list, count, kind, clast_item_groups, &ranges[kind]);
    }
    status = status == CLAST_OK ? clast_vulkan_describe_units(frame) : status;
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        clast_device_unit *record = &device->records[list[i]->unit->number];
        record->view.rate = rate;
        record->drafts = store_address(keep ? device->units[list[i]->unit->number].drafts : 0);
    }
    clast_vulkan_write_units(device, commands);
    for (uint32_t kind = 0; kind < clast_source_kind_count; kind++) {
        clast_vulkan_run_spans(device, commands, CLAST_SHADER_OF_KIND(FRAME_COUNT, kind), &ranges[kind], keep);
    }
    clast_gpu_read(commands, &device->sums, 0, device->unit_sums, device->unit_count * sizeof *device->unit_sums);
    return CLAST_OK;
}

static clast_status run_count(clast_frame *frame, clast_frame_unit *const *list, size_t count, float rate, bool keep)
{
    clast_gpu_commands *commands = NULL;
    clast_status status = clast_gpu_begin(clast_vulkan_of(frame)->gpu, &commands);
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_pass(commands, "count");
    clast_gpu_note(commands, record_count(frame, commands, list, count, rate, keep));
    return clast_gpu_finish(commands);
}

clast_status clast_vulkan_count_units(clast_frame *frame, clast_unit_tally *tallies, size_t count, float rate,
                                      bool keep)
{
    clast_vulkan_frame *device = clast_vulkan_of(frame);
    clast_frame_unit **list = NULL;
    clast_status status = clast_vulkan_prepare(frame);
    status = status == CLAST_OK ? list_units(device, tallies, count, &list) : status;
    status = status == CLAST_OK ? run_count(frame, list, count, rate, keep) : status;
    clast_free(device->context, list);
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < count; i++) {
        const clast_unit_sums *sums = &device->unit_sums[tallies[i].unit->unit->number];
        tallies[i].need = (clast_frame_need){.clusters = load_address(sums->counts[0]),
                                             .triangles = load_address(sums->counts[1]),
                                             .vertices = load_address(sums->counts[2]),
                                             .words = load_address(sums->counts[3]),
                                             .blocks = load_address(sums->counts[4])};
    }
    if (keep) {
        device->kept_units = count;
        device->kept_rate = rate;
    }
    return CLAST_OK;
}
