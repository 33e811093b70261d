// SPDX-License-Identifier: Apache-2.0
// Pass count: how much the frame needs at the wanted rate, and at the least.
#include <stdatomic.h>

#include "base/thread.h"
#include "frame/unit.h"

enum { ITEM_GRAIN = 256, UNIT_BYTES = 2048 };

typedef struct count_job {
    const clast_frame_unit *unit;
    clast_source_view view;
    uint32_t *clusters; // by item; null where only the sum is wanted
    uint32_t *vertices;
    uint32_t *words;
    atomic_uint_fast64_t sums[5]; // of integers: the order does not matter
} count_job;

static void count_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    count_job *job = data;
    const clast_unit *unit = job->unit->unit;
    const clast_source *source = clast_source_of(unit);
    uint64_t sums[5] = {0};
    for (size_t i = begin; i < end; i++) {
        clast_source_count count = source->count(unit, &job->unit->pose, &job->view, (uint32_t)i);
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

static clast_frame_need run_count(clast_frame *frame, count_job *job)
{
    size_t items = job->unit->unit->item_count;
    clast_parallel_for(frame->context, items, clast_frame_grain(items, ITEM_GRAIN), count_range, job);
    clast_frame_need need = {.clusters = atomic_load(&job->sums[0]),
                             .triangles = atomic_load(&job->sums[1]),
                             .vertices = atomic_load(&job->sums[2]),
                             .words = atomic_load(&job->sums[3]),
                             .blocks = atomic_load(&job->sums[4])};
    need.bytes = bytes_of(job->unit, &need);
    return need;
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

clast_status clast_unit_count(clast_frame *frame, clast_frame_unit *unit, float rate, clast_frame_need *need)
{
    if (clast_unit_change(frame, unit, rate) != CLAST_CHANGE_TOPOLOGY) {
        *need = unit->sum;
        return CLAST_OK;
    }
    if (!unit->counted || unit->counted_rate != rate) {
        size_t items = unit->unit->item_count;
        clast_status status = CLAST_RESERVE(frame->context, unit->item_counts, unit->item_capacity, 3 * items);
        if (status != CLAST_OK) {
            return status;
        }
        count_job job = {.unit = unit,
                         .view = view_at(unit, rate),
                         .clusters = unit->item_counts,
                         .vertices = unit->item_counts + items,
                         .words = unit->item_counts + 2 * items};
        unit->counted_sum = run_count(frame, &job);
        unit->counted_rate = rate;
        unit->counted = true;
    }
    *need = unit->counted_sum;
    return CLAST_OK;
}

clast_frame_need clast_unit_minimum(clast_frame *frame, clast_frame_unit *unit)
{
    if (!unit->minimum_known) {
        count_job job = {.unit = unit, .view = view_at(unit, CLAST_RATE_LEAST)};
        unit->minimum = run_count(frame, &job);
        unit->minimum_known = true;
    }
    return unit->minimum;
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

clast_status clast_frame_count(clast_frame *frame, float rate, clast_frame_need *need)
{
    *need = clast_frame_instance_need(frame);
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        if (frame->units[i].used) {
            clast_frame_need unit = {0};
            status = clast_unit_count(frame, &frame->units[i], rate, &unit);
            clast_frame_add_need(need, &unit);
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
