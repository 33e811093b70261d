// SPDX-License-Identifier: Apache-2.0
// Passes count, fit and emit: how much the frame needs, at which rate it fits, and the records themselves. Counts
// come first and prefix sums decide places, so that nothing is ever dropped for want of room, and no place depends on
// timing.
#include <stdatomic.h>

#include "base/size.h"
#include "base/thread.h"
#include "frame/backend.h"

enum { ITEM_GRAIN = 256 };

float clast_frame_rate_step(uint32_t step)
{
    // 2^(-k/16)
    static const float steps[RATE_STEPS] = {
        1.0f,         0.957603281f, 0.917004043f, 0.878126080f, 0.840896415f, 0.805245166f, 0.771105413f, 0.738413073f,
        0.707106781f, 0.677127773f, 0.648419777f, 0.620928906f, 0.594603558f, 0.569394317f, 0.545253866f, 0.522136891f,
    };
    if (step >= CLAST_FRAME_LAST_RATE_STEP) {
        return CLAST_RATE_LEAST;
    }
    return steps[step % RATE_STEPS] * power_of_two(127u - step / RATE_STEPS);
}

// ------------------------------------------------------------------------------------------------------------ count

typedef struct wide_count {
    uint64_t clusters, triangles, vertices, words;
} wide_count;

typedef struct count_job {
    const clast_frame_unit *unit;
    clast_source_view view;
    uint32_t *clusters; // by item; null where only the sum is wanted
    uint32_t *vertices;
    uint32_t *words;
    atomic_uint_fast64_t cluster_sum, triangle_sum, vertex_sum, word_sum; // of integers: the order does not matter
} count_job;

static void count_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    count_job *job = data;
    const clast_unit *unit = job->unit->unit;
    const clast_source *source = clast_source_of(unit);
    wide_count sum = {0};
    for (size_t i = begin; i < end; i++) {
        clast_source_count count = source->count(unit, &job->unit->pose, &job->view, (uint32_t)i);
        if (job->clusters != NULL) {
            job->clusters[i] = count.clusters;
            job->vertices[i] = count.vertices;
            job->words[i] = count.words;
        }
        sum.clusters += count.clusters;
        sum.triangles += count.triangles;
        sum.vertices += count.vertices;
        sum.words += count.words;
    }
    atomic_fetch_add(&job->cluster_sum, sum.clusters);
    atomic_fetch_add(&job->triangle_sum, sum.triangles);
    atomic_fetch_add(&job->vertex_sum, sum.vertices);
    atomic_fetch_add(&job->word_sum, sum.words);
}

static clast_status run_count(clast_frame *frame, clast_frame_unit *unit, count_job *job, clast_source_count *result)
{
    clast_parallel_for(frame->context, unit->unit->item_count, ITEM_GRAIN, count_range, job);
    uint64_t clusters = atomic_load(&job->cluster_sum);
    uint64_t triangles = atomic_load(&job->triangle_sum);
    uint64_t vertices = atomic_load(&job->vertex_sum);
    uint64_t words = atomic_load(&job->word_sum);
    if (clusters > UINT32_MAX || triangles > UINT32_MAX || vertices > UINT32_MAX || words > UINT32_MAX) {
        return clast_fail(
            frame->context, CLAST_ERROR_LIMIT,
            "geometry %u needs %llu triangles in %llu clusters of %llu vertices, expected at most %u of each",
            unit->unit->number, (unsigned long long)triangles, (unsigned long long)clusters,
            (unsigned long long)vertices, UINT32_MAX);
    }
    *result = (clast_source_count){(uint32_t)clusters, (uint32_t)triangles, (uint32_t)vertices, (uint32_t)words, 0};
    return CLAST_OK;
}

static clast_source_view view_at(const clast_frame_unit *unit, float rate)
{
    clast_source_view view = unit->view;
    view.rate = rate;
    return view;
}

// What must be made anew for this frame at a rate.
static clast_change change_at(const clast_frame_unit *unit, float rate)
{
    if (!unit->made) {
        return CLAST_CHANGE_TOPOLOGY;
    }
    clast_source_view view = view_at(unit, rate);
    return clast_source_of(unit->unit)->changed(unit->unit, &unit->made_pose, &unit->made_view, &unit->pose, &view);
}

// What the unit needs at a rate. Units whose records stay as they are need not be asked; others keep what each item
// needs.
static clast_status count_unit(clast_frame *frame, clast_frame_unit *unit, float rate, clast_source_count *result)
{
    if (change_at(unit, rate) != CLAST_CHANGE_TOPOLOGY) {
        *result = unit->sum;
        return CLAST_OK;
    }
    if (unit->counted && unit->counted_rate == rate) {
        *result = unit->counted_sum;
        return CLAST_OK;
    }
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
    status = run_count(frame, unit, &job, &unit->counted_sum);
    unit->counted = status == CLAST_OK;
    unit->counted_rate = rate;
    *result = unit->counted_sum;
    return status;
}

static clast_status find_minimum(clast_frame *frame, clast_frame_unit *unit)
{
    if (unit->minimum_known) {
        return CLAST_OK;
    }
    count_job job = {.unit = unit, .view = view_at(unit, CLAST_RATE_LEAST)};
    clast_status status = run_count(frame, unit, &job, &unit->minimum);
    unit->minimum_known = status == CLAST_OK;
    return status;
}

// The triangles of the whole frame at a rate.
static clast_status count_frame(clast_frame *frame, float rate, uint64_t *triangles)
{
    *triangles = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (!frame->units[i].used) {
            continue;
        }
        clast_source_count count = {0};
        clast_status status = count_unit(frame, &frame->units[i], rate, &count);
        if (status != CLAST_OK) {
            return status;
        }
        *triangles += count.triangles;
    }
    return CLAST_OK;
}

clast_status clast_cpu_count(clast_frame *frame, void *target)
{
    (void)target;
    frame->minimum_triangles = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        if (frame->units[i].used) {
            clast_status status = find_minimum(frame, &frame->units[i]);
            if (status != CLAST_OK) {
                return status;
            }
            frame->minimum_triangles += frame->units[i].minimum.triangles;
        }
    }
    return count_frame(frame, (float)frame->settings.rate, &frame->triangles);
}

// -------------------------------------------------------------------------------------------------------------- fit

static float rate_at(const clast_frame *frame, uint32_t step)
{
    return (float)frame->settings.rate * clast_frame_rate_step(step);
}

// The first step of the ladder that fits. Counts never fall while the rate grows, so halving finds it.
static clast_status find_step(clast_frame *frame, uint32_t *step)
{
    uint32_t too_much = 0;
    uint32_t fits = CLAST_FRAME_LAST_RATE_STEP;
    while (fits - too_much > 1) {
        uint32_t middle = too_much + (fits - too_much) / 2;
        uint64_t triangles = 0;
        clast_status status = count_frame(frame, rate_at(frame, middle), &triangles);
        if (status != CLAST_OK) {
            return status;
        }
        if (triangles <= frame->settings.budget) {
            fits = middle;
        } else {
            too_much = middle;
        }
    }
    *step = fits;
    return CLAST_OK;
}

static clast_status settle_unit(clast_frame *frame, clast_frame_unit *unit, float rate)
{
    clast_source_count sum = unit->sum;
    clast_change change = change_at(unit, rate);
    if (change == CLAST_CHANGE_TOPOLOGY) {
        clast_status status = count_unit(frame, unit, rate, &sum);
        if (status != CLAST_OK) {
            return status;
        }
    }
    unit->change = change;
    unit->made = unit->made && change == CLAST_CHANGE_NOTHING; // until the passes that follow have made it
    unit->sum = sum;
    unit->view.rate = rate;
    frame->triangles += sum.triangles;
    return CLAST_OK;
}

clast_status clast_cpu_fit(clast_frame *frame, void *target)
{
    (void)target;
    uint64_t budget = frame->settings.budget;
    uint32_t step = 0;
    if (budget != 0 && budget < frame->minimum_triangles) {
        return clast_fail(frame->context, CLAST_ERROR_BUDGET,
                          "a budget of %llu triangles is below the scene's minimum of %llu", (unsigned long long)budget,
                          (unsigned long long)frame->minimum_triangles);
    }
    if (budget != 0 && frame->triangles > budget) {
        clast_status status = find_step(frame, &step);
        if (status != CLAST_OK) {
            return status;
        }
    }
    frame->fitted_rate = clast_frame_rate_step(step);
    frame->triangles = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_status status = frame->units[i].used ? settle_unit(frame, &frame->units[i], rate_at(frame, step))
                                                   : CLAST_OK;
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- emit

typedef struct emit_job {
    const clast_frame_unit *unit;
    const uint32_t *first_records; // by item
    const uint32_t *first_vertices;
    const uint32_t *first_words;
    atomic_uint_fast64_t vertices;
} emit_job;

static void emit_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    emit_job *job = data;
    const clast_frame_unit *unit = job->unit;
    const clast_source *source = clast_source_of(unit->unit);
    for (size_t i = begin; i < end; i++) {
        source->emit(unit->unit, &unit->pose, &unit->view, (uint32_t)i, job->first_vertices[i], job->first_words[i],
                     unit->words + job->first_words[i], unit->records + job->first_records[i]);
    }
    size_t last = end < unit->unit->item_count ? job->first_records[end] : unit->record_count;
    uint64_t vertices = 0;
    for (size_t i = job->first_records[begin]; i < last; i++) {
        vertices += record_vertices(unit->records[i]);
    }
    atomic_fetch_add(&job->vertices, vertices);
}

static clast_status emit_unit(clast_frame *frame, clast_frame_unit *unit)
{
    clast_context *context = frame->context;
    size_t items = unit->unit->item_count;
    clast_status status = CLAST_RESERVE(context, unit->records, unit->record_capacity, unit->sum.clusters);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, unit->vertices, unit->vertex_capacity, unit->sum.vertices);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(context, unit->words, unit->word_capacity, (size_t)unit->sum.words + 1);
    }
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
    unit->record_count = unit->sum.clusters;
    unit->vertex_count = unit->sum.vertices;
    unit->word_count = unit->sum.words;
    clast_parallel_for(context, items, ITEM_GRAIN, emit_range, &job);
    unit->cluster_vertices = atomic_load(&job.vertices);
    return CLAST_OK;
}

clast_status clast_cpu_emit(clast_frame *frame, void *target)
{
    (void)target;
    frame->clusters = 0;
    frame->vertices = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (!unit->used) {
            continue;
        }
        clast_status status = unit->change == CLAST_CHANGE_TOPOLOGY ? emit_unit(frame, unit) : CLAST_OK;
        if (status != CLAST_OK) {
            return status;
        }
        frame->clusters += unit->record_count;
        frame->vertices += unit->cluster_vertices;
    }
    frame->instanced_triangles = 0;
    for (size_t i = 0; i < frame->instance_count; i++) {
        frame->instanced_triangles += frame->units[frame->instances[i].unit].sum.triangles;
    }
    return CLAST_OK;
}
