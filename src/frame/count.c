// SPDX-License-Identifier: Apache-2.0
// Pass count: how much the frame needs at the wanted rate, and at the least.
#include "base/thread.h"
#include "frame/unit.h"

enum { ITEM_GRAIN = 256, UNIT_BYTES = 2048 };

typedef struct count_job {
    const clast_frame *frame;
    const clast_frame_unit *unit;
    clast_source_view view;
    uint32_t *clusters; // by item; null where only the sum is wanted
    uint32_t *vertices;
    uint32_t *words;
    bool drafts;
    atomic_uint_fast64_t drafted; // words
    atomic_uint_fast64_t sums[5]; // of integers: the order does not matter
} count_job;

static clast_source_count count_item(count_job *job, uint32_t item, uint32_t worker)
{
    if (job->drafts) {
        return clast_draft_item(job->frame, job->unit, &job->view, item, worker, &job->drafted);
    }
    const clast_unit *unit = job->unit->unit;
    return clast_source_of(unit)->count(unit, &job->unit->pose, &job->view, item);
}

static void count_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    count_job *job = data;
    uint64_t sums[5] = {0};
    for (size_t i = begin; i < end; i++) {
        clast_source_count count = count_item(job, (uint32_t)i, worker);
        if (job->clusters != NULL) {
            job->clusters[i] = count.clusters;
            job->vertices[i] = count.vertices;
            job->words[i] = count.words;
        }
        sums[0] += count.clusters;
        sums[1] += count.triangles;
        sums[2] += count.vertices;
        sums[3] += count.words;
        sums[4] += count.blocks;
    }
    for (int i = 0; i < 5; i++) {
        atomic_fetch_add(&job->sums[i], sums[i]);
    }
}

static uint64_t add_bytes(uint64_t a, uint64_t b)
{
    return a <= UINT64_MAX - b ? a + b : UINT64_MAX;
}

// At most, while the unit is made. Objects without what they hold take less than UNIT_BYTES.
static uint64_t bytes_of(const clast_frame_unit *unit, const clast_frame_need *need)
{
    size_t clusters = need->clusters < SIZE_MAX / 1024 ? (size_t)need->clusters : SIZE_MAX / 1024;
    uint64_t head = clast_clas_own_bytes(0), block = clast_clas_own_bytes(BLOCK_TRIANGLES) - head;
    clast_clas_room room = {clusters, clast_source_of(unit->unit)->most_triangles,
                            need->blocks != 0 ? (size_t)(need->blocks * block + clusters * head) : 0};
    uint64_t bytes = UNIT_BYTES + need->clusters * sizeof *unit->records + need->vertices * sizeof *unit->vertices +
                     (need->words + 1) * sizeof *unit->words +
                     3 * (uint64_t)unit->unit->item_count * sizeof *unit->item_counts;
    return add_bytes(bytes, add_bytes(clast_clas_room_bytes(&room), clast_blas_memory(clusters)));
}

static void run_count(clast_frame *frame, count_job *job, clast_frame_need *need)
{
    job->frame = frame;
    size_t items = job->unit->unit->item_count;
    clast_parallel_for(frame->context, items, clast_frame_grain(items, ITEM_GRAIN), count_range, job);
    *need = (clast_frame_need){.clusters = atomic_load(&job->sums[0]),
                               .triangles = atomic_load(&job->sums[1]),
                               .vertices = atomic_load(&job->sums[2]),
                               .words = atomic_load(&job->sums[3]),
                               .blocks = atomic_load(&job->sums[4])};
}

static clast_source_view view_at(const clast_frame_unit *unit, float rate)
{
    clast_source_view view = unit->view;
    view.rate = rate;
    return view;
}

static uint64_t held_bytes(const clast_frame_unit *unit)
{
    clast_frame_bytes bytes = clast_unit_bytes(unit);
    return bytes.records + bytes.vertices + bytes.clas + bytes.blas;
}

clast_change clast_unit_change(const clast_frame *frame, const clast_frame_unit *unit, float rate)
{
    // what is kept may have more room than it needs, from when memory was not bounded
    bool roomy = frame->settings.max_bytes != 0 && held_bytes(unit) > unit->sum.bytes;
    if (!unit->made || roomy) {
        return CLAST_CHANGE_TOPOLOGY;
    }
    clast_source_view view = view_at(unit, rate);
    return clast_source_of(unit->unit)->changed(unit->unit, &unit->made_pose, &unit->made_view, &unit->pose, &view);
}

// The CPU's clast_count_function, of one unit.
static clast_status count_unit(clast_frame *frame, clast_unit_tally *tally, float rate, bool keep)
{
    clast_frame_unit *unit = tally->unit;
    size_t items = unit->unit->item_count;
    count_job job = {.unit = unit, .view = view_at(unit, rate)};
    if (keep) {
        clast_status status = CLAST_RESERVE(frame->context, unit->item_counts, unit->item_capacity, 3 * items);
        status = status == CLAST_OK ? clast_drafts_begin(frame, unit) : status;
        if (status != CLAST_OK) {
            return status;
        }
        job.drafts = unit->drafts.known;
        job.clusters = unit->item_counts;
        job.vertices = unit->item_counts + items;
        job.words = unit->item_counts + 2 * items;
    }
    run_count(frame, &job, &tally->need);
    if (job.drafts) {
        unit->drafts.wanted = (size_t)atomic_load(&job.drafted);
    }
    return CLAST_OK;
}

static clast_status count_units(clast_frame *frame, clast_unit_tally *tallies, size_t count, float rate, bool keep)
{
    if (count == 0) {
        return CLAST_OK;
    }
    clast_status status = CLAST_OK;
    if (frame->backend != NULL && frame->backend->count != NULL) {
        status = frame->backend->count(frame, tallies, count, rate, keep);
    } else {
        for (size_t i = 0; i < count && status == CLAST_OK; i++) {
            status = count_unit(frame, &tallies[i], rate, keep);
        }
    }
    for (size_t i = 0; i < count; i++) {
        tallies[i].need.bytes = bytes_of(tallies[i].unit, &tallies[i].need);
    }
    return status;
}

static void note_count(clast_unit_tally *tally, float rate)
{
    tally->unit->counted_sum = tally->need;
    tally->unit->counted_rate = rate;
    tally->unit->counted = true;
}

clast_status clast_unit_count(clast_frame *frame, clast_frame_unit *unit, float rate, clast_frame_need *need)
{
    if (clast_unit_change(frame, unit, rate) != CLAST_CHANGE_TOPOLOGY) {
        *need = unit->sum;
        return CLAST_OK;
    }
    if (!unit->counted || unit->counted_rate != rate) {
        clast_unit_tally tally = {.unit = unit};
        clast_status status = count_unit(frame, &tally, rate, true);
        if (status != CLAST_OK) {
            return status;
        }
        tally.need.bytes = bytes_of(unit, &tally.need);
        note_count(&tally, rate);
    }
    *need = unit->counted_sum;
    return CLAST_OK;
}

clast_status clast_frame_find_minima(clast_frame *frame)
{
    size_t count = 0;
    clast_status status = CLAST_RESERVE(frame->context, frame->tallies, frame->tally_capacity, frame->unit_count);
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        if (frame->units[i].used && !frame->units[i].minimum_known) {
            frame->tallies[count++] = (clast_unit_tally){.unit = &frame->units[i]};
        }
    }
    status = status == CLAST_OK ? count_units(frame, frame->tallies, count, CLAST_RATE_LEAST, false) : status;
    for (size_t i = 0; i < count && status == CLAST_OK; i++) {
        frame->tallies[i].unit->minimum = frame->tallies[i].need;
        frame->tallies[i].unit->minimum_known = true;
    }
    return status;
}

void clast_frame_add_need(clast_frame_need *sum, const clast_frame_need *need)
{
    sum->clusters += need->clusters;
    sum->triangles += need->triangles;
    sum->vertices += need->vertices;
    sum->words += need->words;
    sum->blocks += need->blocks;
    sum->bytes = add_bytes(sum->bytes, need->bytes);
}

clast_frame_need clast_frame_instance_need(const clast_frame *frame)
{
    uint64_t bytes = add_bytes(clast_tlas_memory(frame->instance_count),
                               frame->instance_count * sizeof *frame->tlas_instances);
    return (clast_frame_need){.bytes = add_bytes(bytes, frame->occlude_bytes)};
}

// Lists the units that change their topology at a rate. What others were counted for is of no use. Gives whether all have
// been counted at this rate already.
static bool list_changing(clast_frame *frame, float rate, size_t *count)
{
    bool known = true;
    *count = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        bool changes = unit->used && clast_unit_change(frame, unit, rate) == CLAST_CHANGE_TOPOLOGY;
        unit->counted = unit->counted && changes && unit->counted_rate == rate;
        if (changes) {
            frame->tallies[(*count)++] = (clast_unit_tally){.unit = unit};
            known = known && unit->counted;
        }
    }
    return known;
}

clast_status clast_frame_count(clast_frame *frame, float rate, clast_frame_need *need)
{
    clast_status status = CLAST_RESERVE(frame->context, frame->tallies, frame->tally_capacity, frame->unit_count);
    if (status != CLAST_OK) {
        return status;
    }
    size_t count = 0;
    if (!list_changing(frame, rate, &count)) {
        status = count_units(frame, frame->tallies, count, rate, true);
        for (size_t i = 0; i < count && status == CLAST_OK; i++) {
            note_count(&frame->tallies[i], rate);
        }
    }
    *need = clast_frame_instance_need(frame);
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (unit->used) {
            clast_frame_add_need(need, unit->counted ? &unit->counted_sum : &unit->sum);
        }
    }
    return status;
}

clast_status clast_cpu_count(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = clast_frame_check_minimum(frame);
    return status != CLAST_OK ? status : clast_frame_count(frame, (float)frame->settings.rate, &frame->wanted);
}
