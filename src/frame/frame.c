// SPDX-License-Identifier: Apache-2.0
#include "frame/frame.h"

#include "base/thread.h"
#include "frame/unit.h"

clast_status clast_frame_create(clast_scene *scene, clast_cooked *cooked, clast_frame **result)
{
    clast_context *context = cooked->context;
    clast_frame *frame = clast_allocate_zeroed(context, 1, sizeof *frame);
    if (frame == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    frame->context = context;
    frame->scene = scene;
    frame->cooked = cooked;
    frame->fitted_rate = 1.0f;
    clast_status status = clast_tlas_create(context, &frame->tlas);
    if (status != CLAST_OK) {
        clast_free(context, frame);
        return status;
    }
    *result = frame;
    return CLAST_OK;
}

void clast_unit_free(clast_context *context, clast_frame_unit *unit)
{
    if (unit->blas != NULL) {
        clast_blas_destroy(unit->blas);
    }
    if (unit->clas != NULL) {
        clast_clas_pool_destroy(unit->clas);
    }
    clast_posed_mesh_destroy(context, &unit->posed);
    clast_free(context, unit->records);
    clast_free(context, unit->vertices);
    clast_free(context, unit->words);
    clast_free(context, unit->item_counts);
    clast_free(context, unit->drafts.places);
    clast_free(context, unit->drafts.words);
}

void clast_frame_destroy(clast_frame *frame)
{
    if (frame == NULL) {
        return;
    }
    clast_context *context = frame->context;
    clast_tlas_destroy(frame->tlas);
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_unit_free(context, &frame->units[i]);
    }
    clast_frame_free_coarse(frame);
    clast_frame_motion_destroy(context, &frame->motion);
    clast_free(context, frame->units);
    clast_free(context, frame->instances);
    clast_free(context, frame->frame_instance_of);
    clast_free(context, frame->emitters);
    clast_free(context, frame->clas_inputs);
    clast_free(context, frame->draft_scratch);
    clast_free(context, frame->tlas_instances);
    clast_free(context, frame->tallies);
    clast_free(context, frame);
}

static const char *pass_name(clast_pass pass)
{
    switch (pass) {
#define CASE(name, value, text, help) \
    case name: return text;
        CLAST_PASS_LIST(CASE)
#undef CASE
    case CLAST_PASS_COUNT_: break;
    }
    return "unknown";
}

static clast_status run_pass(clast_frame *frame, const clast_backend *backend, clast_pass pass, void *target)
{
    if (backend->passes[pass] == NULL) {
        return clast_fail(frame->context, CLAST_ERROR_UNSUPPORTED, "backend %s has no pass %s", backend->name,
                          pass_name(pass));
    }
    double start = clast_clock();
    clast_status status = backend->passes[pass](frame, target);
    frame->milliseconds[pass] += (clast_clock() - start) * 1e3;
    return status;
}

// A failed pass may leave the tree pointing to what has moved since. An empty tree needs no memory, so this cannot
// fail.
static void forget(clast_frame *frame)
{
    clast_tlas_build(frame->tlas, NULL, 0, CLAST_BUILD_BEST);
    clast_frame_free_coarse(frame);
    if (frame->backend->forget != NULL) {
        frame->backend->forget(frame);
    }
    frame->instance_count = 0;
    frame->frame_instance_of_count = 0;
    frame->emitter_count = 0;
    for (size_t i = 0; i < frame->unit_count; i++) {
        frame->units[i].made = false;
    }
}

clast_status clast_frame_run(clast_frame *frame, const clast_backend *backend, clast_pass first, clast_pass last,
                             void *target)
{
    frame->backend = backend;
    if (first == CLAST_PASS_ANIMATE) {
        for (uint32_t pass = 0; pass < CLAST_PASS_COUNT_; pass++) {
            frame->milliseconds[pass] = 0.0;
        }
    }
    for (uint32_t pass = first; pass <= (uint32_t)last && pass < CLAST_PASS_COUNT_; pass++) {
        clast_status status = run_pass(frame, backend, (clast_pass)pass, target);
        if (status != CLAST_OK) {
            if (pass <= CLAST_PASS_LIGHTS) {
                forget(frame);
            }
            return status;
        }
    }
    return CLAST_OK;
}

clast_frame_bytes clast_unit_bytes(const clast_frame_unit *unit)
{
    return (clast_frame_bytes){
        .records = unit->record_capacity * sizeof *unit->records + unit->word_capacity * sizeof *unit->words +
                   unit->item_capacity * sizeof *unit->item_counts +
                   (unit->drafts.capacity + unit->drafts.place_capacity) * sizeof *unit->drafts.words,
        .vertices = unit->vertex_capacity * sizeof *unit->vertices,
        .clas = unit->clas != NULL ? clast_clas_pool_bytes(unit->clas) : 0,
        .blas = unit->blas != NULL ? clast_blas_bytes(unit->blas) : 0,
    };
}

clast_frame_bytes clast_frame_count_bytes(const clast_frame *frame)
{
    clast_frame_bytes bytes = frame->device_bytes;
    bytes.tlas += clast_tlas_bytes(frame->tlas);
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_bytes unit = clast_unit_bytes(&frame->units[i]);
        bytes.records += unit.records;
        bytes.vertices += unit.vertices + frame->units[i].posed.capacity * sizeof(float);
        bytes.clas += unit.clas;
        bytes.blas += unit.blas;
    }
    return bytes;
}
