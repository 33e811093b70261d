// SPDX-License-Identifier: Apache-2.0
// Passes fill, refit, blas and tlas: positions, and the trees over them. A unit that did not change is left alone.
#include <string.h>

#include "base/thread.h"
#include "frame/backend.h"

enum { RECORD_GRAIN = 32 };

// ------------------------------------------------------------------------------------------------------------- fill

static void fill_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_frame_unit *unit = data;
    const clast_source *source = clast_source_of(unit->unit);
    for (size_t i = begin; i < end; i++) {
        const clast_cluster_record *record = &unit->records[i];
        if (source->resident(unit->unit, record) == NULL) {
            source->fill(unit->unit, &unit->pose, record, clast_frame_words(unit, record),
                         unit->vertices + record->first_vertex);
        }
    }
}

clast_status clast_cpu_fill(clast_frame *frame, void *target)
{
    (void)target;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (unit->used && unit->change != CLAST_CHANGE_NOTHING && unit->vertex_count != 0) {
            clast_parallel_for(frame->context, unit->record_count, RECORD_GRAIN, fill_range, unit);
        }
    }
    return CLAST_OK;
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
    const clast_frame_unit *unit = job->unit;
    for (size_t i = begin; i < end; i++) {
        const clast_cluster_record *record = &unit->records[i];
        const packed3 *resident = clast_source_of(unit->unit)->resident(unit->unit, record);
        const packed3 *vertices = resident != NULL ? resident : unit->vertices + record->first_vertex;
        job->inputs[i] = (clast_clas_input){record->template_index, vertices->v};
    }
}

static clast_status instantiate_unit(clast_frame *frame, clast_frame_unit *unit)
{
    clast_status status = CLAST_OK;
    if (unit->clas == NULL) {
        status = clast_clas_pool_create(frame->cooked->templates, &unit->clas);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(frame->context, frame->clas_inputs, frame->clas_input_capacity, unit->record_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_clas_pool_truncate(unit->clas, 0);
    status = clast_clas_pool_reserve(unit->clas, unit->record_count);
    if (status != CLAST_OK) {
        return status;
    }
    input_job job = {unit, frame->clas_inputs};
    clast_parallel_for(frame->context, unit->record_count, RECORD_GRAIN, input_range, &job);
    return clast_clas_instantiate(unit->clas, 0, unit->record_count, frame->clas_inputs);
}

clast_status clast_cpu_refit(clast_frame *frame, void *target)
{
    (void)target;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        clast_status status = CLAST_OK;
        if (!unit->used || unit->record_count == 0) {
            continue;
        }
        if (unit->change == CLAST_CHANGE_TOPOLOGY) {
            status = instantiate_unit(frame, unit);
        } else if (unit->change == CLAST_CHANGE_VERTICES) {
            status = clast_clas_refit(unit->clas, 0, unit->record_count);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- BLAS

// Built anew where vertices moved, too: a tree that was only refitted would have the shape of an earlier moment, and
// what is seen of it (the steps view, the time) would depend on what was rendered before. Over clusters, building is
// cheap.
static clast_status build_unit(clast_frame_unit *unit)
{
    clast_status status = CLAST_OK;
    if (unit->blas == NULL) {
        status = clast_blas_create(unit->clas, &unit->blas);
    }
    return status == CLAST_OK ? clast_blas_build(unit->blas, NULL, unit->record_count, CLAST_BUILD_BEST) : status;
}

clast_status clast_cpu_blas(clast_frame *frame, void *target)
{
    (void)target;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (!unit->used) {
            continue;
        }
        if (unit->change != CLAST_CHANGE_NOTHING && unit->record_count != 0) {
            clast_status status = build_unit(unit);
            if (status != CLAST_OK) {
                return status;
            }
        }
        unit->made = true;
        unit->made_pose = unit->pose;
        unit->made_view = unit->view;
    }
    return CLAST_OK;
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
