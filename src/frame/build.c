// SPDX-License-Identifier: Apache-2.0
// Passes fill, refit, blas and tlas: positions, and the trees over them. A unit that did not change is left alone.
//
// Vertices that are not resident are fitted as soon as they are written, some clusters at a time, as long as they are in
// the cache: one loop is both passes, and its time is shared out between them by how long each took in it.
#include <stdatomic.h>
#include <string.h>

#include "base/thread.h"
#include "frame/unit.h"

enum {
    RECORD_GRAIN = 32,
    TOGETHER = 8, // clusters that are filled before the first of them is fitted: their vertices fit the first cache
};

// ------------------------------------------------------------------------------------------------------------- fill

typedef struct fill_job {
    clast_frame_unit *unit;
    size_t grain;
    size_t *places; // by chunk: the bytes of its composites' triangles, then where these begin in the pool; or null
    atomic_uint_fast64_t fill_time, fit_time; // nanoseconds, over all threads
    atomic_int status;
} fill_job;

static void note_failure(fill_job *job, clast_status status)
{
    if (status != CLAST_OK) {
        atomic_store(&job->status, (int)status);
    }
}

static size_t own_bytes(const clast_cluster_record *record)
{
    return record_form(*record) == FORM_COMPOSITE ? clast_clas_own_bytes(record_triangles(*record)) : 0;
}

static void measure_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    fill_job *job = data;
    size_t bytes = 0;
    for (size_t i = begin; i < end; i++) {
        bytes += own_bytes(&job->unit->records[i]);
    }
    job->places[begin / job->grain] = bytes;
}

// Where each chunk's composites put their triangles, and how many bytes all of these take.
static clast_status place_composites(clast_frame *frame, fill_job *job, size_t *bytes)
{
    size_t count = job->unit->record_count, chunks = count / job->grain + 1;
    *bytes = 0;
    if (job->unit->sum.blocks == 0) {
        return CLAST_OK;
    }
    job->places = clast_allocate_zeroed(frame->context, chunks, sizeof *job->places);
    if (job->places == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(frame->context, count, job->grain, measure_range, job);
    for (size_t i = 0; i < chunks; i++) {
        size_t here = job->places[i];
        job->places[i] = *bytes;
        *bytes += here;
    }
    return CLAST_OK;
}

// Three of each triangle of a record: places among its vertices.
typedef struct record_corners {
    bool known;
    uint8_t of[3 * TEMPLATE_TRIANGLES];
} record_corners;

static void fill_record(const clast_frame_unit *unit, size_t number, record_corners *corners)
{
    const clast_source *source = clast_source_of(unit->unit);
    const clast_cluster_record *record = &unit->records[number];
    corners->known = false;
    if (source->resident(unit->unit, record) != NULL) {
        return;
    }
    packed3 *vertices = unit->vertices + record->first_vertex;
    if (source->fill_composite != NULL && record_form(*record) == FORM_COMPOSITE &&
        unit->change == CLAST_CHANGE_TOPOLOGY) {
        corners->known = true;
        source->fill_composite(unit->unit, &unit->pose, record, clast_frame_words(unit, record), vertices, corners->of);
        return;
    }
    source->fill(unit->unit, &unit->pose, record, clast_frame_words(unit, record), vertices);
}

static const float *vertices_of(const clast_frame_unit *unit, const clast_cluster_record *record)
{
    const packed3 *resident = clast_source_of(unit->unit)->resident(unit->unit, record);
    return resident != NULL ? resident->v : (unit->vertices + record->first_vertex)->v;
}

static clast_status set_composite(const clast_frame_unit *unit, size_t number, size_t place, record_corners *corners)
{
    const clast_cluster_record *record = &unit->records[number];
    if (!corners->known) {
        clast_source_of(unit->unit)->corners(unit->unit, record, clast_frame_words(unit, record), corners->of);
    }
    clast_clas_desc desc = {.triangle_count = record_triangles(*record),
                            .vertex_count = record_vertices(*record),
                            .indices = corners->of,
                            .vertices = vertices_of(unit, record),
                            .ordered = 1};
    return clast_clas_set_own(unit->clas, number, place, &desc);
}

static clast_status fit_record(const clast_frame_unit *unit, size_t number, size_t place, record_corners *corners)
{
    const clast_cluster_record *record = &unit->records[number];
    if (unit->change == CLAST_CHANGE_VERTICES) {
        return clast_clas_refit(unit->clas, number, 1);
    }
    if (record_form(*record) == FORM_COMPOSITE) {
        return set_composite(unit, number, place, corners);
    }
    clast_clas_input input = {record->template_index, vertices_of(unit, record)};
    return clast_clas_set(unit->clas, number, &input);
}

static void fill_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    fill_job *job = data;
    size_t place = job->places != NULL ? job->places[begin / job->grain] : 0;
    double fill_time = 0.0, fit_time = 0.0, start = clast_clock();
    record_corners corners[TOGETHER];
    for (size_t first = begin; first < end; first += TOGETHER) {
        size_t next = end - first < TOGETHER ? end : first + TOGETHER;
        for (size_t i = first; i < next; i++) {
            fill_record(job->unit, i, &corners[i - first]);
        }
        double filled = clast_clock();
        for (size_t i = first; i < next; i++) {
            note_failure(job, fit_record(job->unit, i, place, &corners[i - first]));
            place += own_bytes(&job->unit->records[i]);
        }
        double fitted = clast_clock();
        fill_time += filled - start;
        fit_time += fitted - filled;
        start = fitted;
    }
    atomic_fetch_add(&job->fill_time, (uint64_t)(fill_time * 1e9));
    atomic_fetch_add(&job->fit_time, (uint64_t)(fit_time * 1e9));
}

// A pool, and a tree over it, that take no more memory than was counted, where memory is bounded.
static clast_status make_pool(clast_frame *frame, clast_frame_unit *unit, size_t own)
{
    clast_clas_room room = {unit->record_count, clast_source_of(unit->unit)->most_triangles, own};
    bool bounded = frame->settings.max_bytes != 0;
    if (bounded && unit->clas != NULL && clast_clas_room_bytes(&room) < clast_clas_pool_bytes(unit->clas)) {
        clast_blas_destroy(unit->blas);
        clast_clas_pool_destroy(unit->clas);
        unit->blas = NULL;
        unit->clas = NULL;
    }
    clast_status status = CLAST_OK;
    if (unit->clas == NULL) {
        status = clast_clas_pool_create(frame->cooked->templates, &unit->clas);
    }
    return status == CLAST_OK ? clast_clas_pool_resize(unit->clas, &room) : status;
}

static double fit_share(const fill_job *job)
{
    double fill = (double)atomic_load(&job->fill_time), fit = (double)atomic_load(&job->fit_time);
    return fill + fit > 0.0 ? fit / (fill + fit) : 0.0;
}

clast_status clast_unit_fill(clast_frame *frame, clast_frame_unit *unit, double *fit_milliseconds)
{
    if (unit->change == CLAST_CHANGE_NOTHING || unit->vertex_count == 0) {
        return CLAST_OK;
    }
    fill_job job = {.unit = unit, .grain = clast_frame_grain(unit->record_count, RECORD_GRAIN)};
    clast_status status = CLAST_OK;
    if (unit->change == CLAST_CHANGE_TOPOLOGY) {
        size_t own = 0;
        status = place_composites(frame, &job, &own);
        status = status == CLAST_OK ? make_pool(frame, unit, own) : status;
    }
    if (status == CLAST_OK) {
        double start = clast_clock();
        clast_parallel_for(frame->context, unit->record_count, job.grain, fill_range, &job);
        *fit_milliseconds += (clast_clock() - start) * 1e3 * fit_share(&job);
        status = (clast_status)atomic_load(&job.status);
    }
    clast_free(frame->context, job.places);
    return status;
}

clast_status clast_cpu_fill(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = CLAST_OK;
    double moved = 0.0;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        status = frame->units[i].used ? clast_unit_fill(frame, &frame->units[i], &moved) : CLAST_OK;
    }
    frame->milliseconds[CLAST_PASS_FILL] -= moved;
    frame->milliseconds[CLAST_PASS_REFIT] += moved;
    return status;
}

// ------------------------------------------------------------------------------------------------------------ refit

typedef struct input_job {
    const clast_frame_unit *unit;
    clast_clas_input *inputs;
} input_job;

static void input_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    input_job *job = data;
    for (size_t i = begin; i < end; i++) {
        const clast_cluster_record *record = &job->unit->records[i];
        job->inputs[i] = (clast_clas_input){record->template_index, vertices_of(job->unit, record)};
    }
}

// Vertices that lie in memory are best fetched ahead, as a batch is.
static clast_status instantiate_unit(clast_frame *frame, clast_frame_unit *unit)
{
    clast_status status = CLAST_RESERVE(frame->context, frame->clas_inputs, frame->clas_input_capacity,
                                        unit->record_count);
    status = status == CLAST_OK ? make_pool(frame, unit, 0) : status;
    if (status != CLAST_OK) {
        return status;
    }
    input_job job = {unit, frame->clas_inputs};
    clast_parallel_for(frame->context, unit->record_count, RECORD_GRAIN, input_range, &job);
    return clast_clas_instantiate(unit->clas, 0, unit->record_count, frame->clas_inputs);
}

clast_status clast_unit_refit(clast_frame *frame, clast_frame_unit *unit)
{
    if (unit->record_count == 0 || unit->vertex_count != 0) {
        return CLAST_OK;
    }
    switch (unit->change) {
    case CLAST_CHANGE_NOTHING: break;
    case CLAST_CHANGE_VERTICES: return clast_clas_refit(unit->clas, 0, unit->record_count);
    case CLAST_CHANGE_TOPOLOGY: return instantiate_unit(frame, unit);
    }
    return CLAST_OK;
}

clast_status clast_cpu_refit(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        status = frame->units[i].used ? clast_unit_refit(frame, &frame->units[i]) : CLAST_OK;
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------- BLAS

// Built anew where vertices moved, too: a tree that was only refitted would have the shape of an earlier moment, and
// what is seen of it (the steps view, the time) would depend on what was rendered before. Over clusters, building is
// cheap. For the same reason the kind alone decides how well it is built: what follows the view is made every frame.
static clast_status build_tree(clast_frame_unit *unit)
{
    clast_status status = CLAST_OK;
    if (unit->blas == NULL) {
        status = clast_blas_create(unit->clas, &unit->blas);
    }
    clast_build build = clast_source_of(unit->unit)->adapts ? CLAST_BUILD_FAST : CLAST_BUILD_BEST;
    return status == CLAST_OK ? clast_blas_build(unit->blas, NULL, unit->record_count, build) : status;
}

void clast_unit_note_made(clast_frame_unit *unit)
{
    unit->made = true;
    unit->made_pose = unit->pose;
    unit->made_view = unit->view;
}

clast_status clast_unit_build(clast_frame_unit *unit)
{
    if (unit->change != CLAST_CHANGE_NOTHING && unit->record_count != 0) {
        clast_status status = build_tree(unit);
        if (status != CLAST_OK) {
            return status;
        }
    }
    clast_unit_note_made(unit);
    return CLAST_OK;
}

clast_status clast_cpu_blas(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = CLAST_OK;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        status = frame->units[i].used ? clast_unit_build(&frame->units[i]) : CLAST_OK;
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------- TLAS

clast_status clast_cpu_tlas(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = CLAST_RESERVE(frame->context, frame->tlas_instances, frame->tlas_instance_capacity,
                                        frame->instance_count);
    if (status != CLAST_OK) {
        return status;
    }
    for (size_t i = 0; i < frame->instance_count; i++) {
        const clast_frame_instance *instance = &frame->instances[i];
        const clast_frame_unit *unit = &frame->units[instance->unit];
        clast_tlas_instance *to = &frame->tlas_instances[i];
        to->blas = unit->record_count != 0 ? unit->blas : NULL;
        to->id = instance->scene_instance;
        to->filtered = unit->filtered ? 1 : 0;
        _Static_assert(sizeof to->transform == sizeof instance->to_world, "both are three rows of four floats");
        memcpy(to->transform, &instance->to_world, sizeof to->transform);
    }
    status = clast_tlas_build(frame->tlas, frame->tlas_instances, frame->instance_count, CLAST_BUILD_BEST);
    if (status == CLAST_OK) {
        clast_cooked_release(frame->cooked);
    }
    return status;
}
