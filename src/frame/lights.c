// SPDX-License-Identifier: Apache-2.0
// Pass lights: the emissive triangles of the frame in world space, in order of instance, then primitive.
#include "base/thread.h"
#include "frame/backend.h"

enum { PRIMITIVE_GRAIN = 4096 };

static bool is_emissive(const clast_scene *scene, uint32_t material)
{
    if (material >= scene->material_count) {
        return false;
    }
    const float *emissive = scene->materials[material].record.emissive.v;
    return emissive[0] > 0.0f || emissive[1] > 0.0f || emissive[2] > 0.0f;
}

static bool may_emit(const clast_scene *scene, const clast_unit *unit)
{
    for (uint32_t i = 0; i < unit->material_count; i++) {
        if (is_emissive(scene, unit->materials[i])) {
            return true;
        }
    }
    return false;
}

typedef struct emitter_job {
    const clast_frame *frame;
    const clast_frame_unit *unit;
    const clast_frame_instance *instance;
    uint32_t instance_number;
    uint32_t *places;        // by chunk: how many, then where they go
    clast_emitter *emitters; // null while counting
} emitter_job;

// False where a primitive does not shine: by its material, or for want of area.
static bool make_emitter(const emitter_job *job, uint32_t primitive, clast_emitter *emitter)
{
    const clast_unit *unit = job->unit->unit;
    const clast_source *source = clast_source_of(unit);
    uint32_t material = source->primitive_material(unit, primitive);
    if (!is_emissive(job->frame->scene, material)) {
        return false;
    }
    vec3 corners[3];
    source->primitive_corners(unit, &job->unit->pose, primitive, corners);
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = transform_point(job->instance->to_world, corners[k]);
        emitter->corners[k] = store3(corners[k]);
    }
    emitter->area = 0.5f * length3(cross3(corners[1] - corners[0], corners[2] - corners[0]));
    emitter->instance = job->instance_number;
    emitter->primitive = primitive;
    emitter->material = material;
    return emitter->area > 0.0f && is_finite1(emitter->area);
}

static void emitter_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    emitter_job *job = data;
    uint32_t *place = &job->places[begin / PRIMITIVE_GRAIN];
    uint32_t count = 0;
    for (size_t i = begin; i < end; i++) {
        clast_emitter emitter;
        if (make_emitter(job, (uint32_t)i, &emitter)) {
            if (job->emitters != NULL) {
                job->emitters[*place + count] = emitter;
            }
            count++;
        }
    }
    if (job->emitters == NULL) {
        *place = count;
    }
}

static clast_status add_emitters(clast_frame *frame, emitter_job *job)
{
    uint32_t primitives = clast_source_of(job->unit->unit)->primitive_count(job->unit->unit);
    size_t chunks = ((size_t)primitives + PRIMITIVE_GRAIN - 1) / PRIMITIVE_GRAIN;
    job->places = clast_allocate_zeroed(frame->context, chunks, sizeof *job->places);
    if (job->places == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(frame->context, primitives, PRIMITIVE_GRAIN, emitter_range, job);
    uint32_t total = 0; // fits, as there are not more than primitives
    clast_exclusive_scan(frame->context, job->places, chunks, &total);
    clast_status status = CLAST_RESERVE(frame->context, frame->emitters, frame->emitter_capacity,
                                        frame->emitter_count + total);
    if (status == CLAST_OK && total != 0) {
        job->emitters = frame->emitters + frame->emitter_count;
        clast_parallel_for(frame->context, primitives, PRIMITIVE_GRAIN, emitter_range, job);
        frame->emitter_count += total;
    }
    clast_free(frame->context, job->places);
    return status;
}

// Which units may emit: most often none does, and no instance need be looked at.
static bool find_emitting(clast_frame *frame)
{
    bool any = false;
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        unit->may_emit = unit->used && may_emit(frame->scene, unit->unit);
        any = any || unit->may_emit;
    }
    return any;
}

clast_status clast_cpu_lights(clast_frame *frame, void *target)
{
    (void)target;
    frame->emitter_count = 0;
    if (!find_emitting(frame)) {
        return CLAST_OK;
    }
    for (size_t i = 0; i < frame->instance_count; i++) {
        const clast_frame_instance *instance = &frame->instances[i];
        const clast_frame_unit *unit = &frame->units[instance->unit];
        if (!unit->may_emit) {
            continue;
        }
        emitter_job job = {.frame = frame, .unit = unit, .instance = instance, .instance_number = (uint32_t)i};
        clast_status status = add_emitters(frame, &job);
        if (status != CLAST_OK) {
            return status;
        }
    }
    return CLAST_OK;
}
