// SPDX-License-Identifier: Apache-2.0
// Pass emit: the records themselves. Prefix sums of the counts decide places, so that no place depends on timing.
#include "base/thread.h"
#include "frame/unit.h"

enum { ITEM_GRAIN = 256 };

typedef struct emit_job {
    const clast_frame_unit *unit;
    const uint32_t *first_records; // by item
    const uint32_t *first_vertices;
    const uint32_t *first_words;
    atomic_uint_fast64_t vertices, fill;
} emit_job;

// Where the records of an item begin, and at the end of all.
static size_t record_place(const emit_job *job, size_t item)
{
    return item < job->unit->unit->item_count ? job->first_records[item] : job->unit->record_count;
}

static size_t word_place(const emit_job *job, size_t item)
{
    return item < job->unit->unit->item_count ? job->first_words[item] : job->unit->word_count;
}

static void emit_item(const emit_job *job, size_t item)
{
    const clast_frame_unit *unit = job->unit;
    size_t record = record_place(job, item), word = word_place(job, item);
    bool taken = clast_draft_take(unit, (uint32_t)item, job->first_vertices[item], (uint32_t)word,
                                  (uint32_t)(word_place(job, item + 1) - word), unit->records + record,
                                  (uint32_t)(record_place(job, item + 1) - record));
    if (!taken) {
        clast_source_of(unit->unit)
            ->emit(unit->unit, &unit->pose, &unit->view, (uint32_t)item, job->first_vertices[item], (uint32_t)word,
                   unit->words + word, unit->records + record);
    }
}

static void emit_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    emit_job *job = data;
    const clast_frame_unit *unit = job->unit;
    for (size_t i = begin; i < end; i++) {
        emit_item(job, i);
    }
    uint64_t vertices = 0, fill = 0;
    for (size_t i = record_place(job, begin); i < record_place(job, end); i++) {
        uint32_t here = record_vertices(unit->records[i]);
        vertices += here;
        fill += max_uint(here, record_triangles(unit->records[i]));
    }
    atomic_fetch_add(&job->vertices, vertices);
    atomic_fetch_add(&job->fill, fill);
}

// Room for an array that is written anew: what it held is lost. From the second time on a little more is taken than is
// needed, unless memory is bounded: then it is as much as was counted.
static clast_status renew(clast_frame *frame, void **array, size_t *capacity, size_t wanted, size_t size)
{
    bool bounded = frame->settings.max_bytes != 0;
    if (wanted <= *capacity && (!bounded || wanted == *capacity)) {
        return CLAST_OK;
    }
    size_t grown = *capacity != 0 && !bounded ? wanted + wanted / 32 : wanted;
    clast_free(frame->context, *array);
    *capacity = 0;
    *array = clast_allocate(frame->context, grown, size);
    if (*array == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    *capacity = grown;
    return CLAST_OK;
}

#define RENEW(array, capacity, wanted) renew(frame, (void **)&(array), &(capacity), wanted, sizeof *(array))

static clast_status make_room(clast_frame *frame, clast_frame_unit *unit)
{
    unit->record_count = unit->vertex_count = unit->word_count = 0;
    clast_status status = RENEW(unit->records, unit->record_capacity, (size_t)unit->sum.clusters);
    if (status == CLAST_OK) {
        status = RENEW(unit->vertices, unit->vertex_capacity, (size_t)unit->sum.vertices);
    }
    if (status == CLAST_OK) {
        status = RENEW(unit->words, unit->word_capacity, (size_t)unit->sum.words + 1);
    }
    return status;
}

clast_status clast_unit_emit(clast_frame *frame, clast_frame_unit *unit)
{
    clast_context *context = frame->context;
    size_t items = unit->unit->item_count;
    if (unit->change != CLAST_CHANGE_TOPOLOGY) {
        return CLAST_OK;
    }
    clast_status status = make_room(frame, unit);
    if (status != CLAST_OK) {
        return status;
    }
    emit_job job = {.unit = unit,
                    .first_records = unit->item_counts,
                    .first_vertices = unit->item_counts + items,
                    .first_words = unit->item_counts + 2 * items};
    uint32_t total = 0; // known to fit: the sums do
    clast_exclusive_scan(context, unit->item_counts, items, &total);
    clast_exclusive_scan(context, unit->item_counts + items, items, &total);
    clast_exclusive_scan(context, unit->item_counts + 2 * items, items, &total);
    unit->counted = false; // they are places now
    unit->record_count = (size_t)unit->sum.clusters;
    unit->vertex_count = (size_t)unit->sum.vertices;
    unit->word_count = (size_t)unit->sum.words;
    clast_parallel_for(context, items, clast_frame_grain(items, ITEM_GRAIN), emit_range, &job);
    unit->cluster_vertices = atomic_load(&job.vertices);
    unit->cluster_fill = atomic_load(&job.fill);
    unit->drafts.known = false;
    return CLAST_OK;
}

void clast_frame_sum_up(clast_frame *frame)
{
    frame->clusters = 0;
    frame->vertices = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (frame->units[i].used) {
            frame->clusters += frame->units[i].record_count;
            frame->vertices += frame->units[i].cluster_vertices;
        }
    }
    frame->instanced_triangles = 0;
    for (size_t i = 0; i < frame->instance_count; i++) {
        frame->instanced_triangles += frame->units[frame->instances[i].unit].sum.triangles;
    }
}

clast_status clast_cpu_emit(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        status = frame->units[i].used ? clast_unit_emit(frame, &frame->units[i]) : CLAST_OK;
    }
    if (status == CLAST_OK) {
        clast_frame_sum_up(frame);
    }
    return status;
}
