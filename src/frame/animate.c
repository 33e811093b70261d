// SPDX-License-Identifier: Apache-2.0
// Pass animate: what stands where at this moment.
#include <math.h>
#include <stdatomic.h>
#include <string.h>

#include "base/thread.h"
#include "frame/backend.h"

enum { INSTANCE_GRAIN = 2048 };

static clast_status make_room(clast_frame *frame)
{
    const clast_scene *scene = frame->scene;
    clast_status status = CLAST_RESERVE(frame->context, frame->units, frame->unit_capacity, frame->cooked->unit_count);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(frame->context, frame->instances, frame->instance_capacity, scene->instance_count);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(frame->context, frame->frame_instance_of, frame->frame_instance_capacity,
                               scene->instance_count);
    }
    while (status == CLAST_OK && frame->unit_count < frame->cooked->unit_count) {
        frame->units[frame->unit_count++] = (clast_frame_unit){0};
    }
    return status;
}

static void begin_units(clast_frame *frame)
{
    for (size_t i = 0; i < frame->unit_count; i++) {
        clast_frame_unit *unit = &frame->units[i];
        unit->unit = frame->cooked->units[i];
        unit->used = false;
        unit->counted = false;
        if (unit->unit == NULL) {
            continue;
        }
        if (unit->made_serial != unit->unit->serial) {
            unit->made = false;
            unit->minimum_known = false;
            unit->made_serial = unit->unit->serial;
        }
    }
}

static clast_status pose_units(clast_frame *frame)
{
    clast_status status = CLAST_OK;
    frame->moved_vertices = 0;
    for (size_t i = 0; i < frame->unit_count && status == CLAST_OK; i++) {
        clast_frame_unit *unit = &frame->units[i];
        if (!unit->used) {
            continue;
        }
        unit->pose = (clast_pose){.time = frame->settings.time,
                                  .version = unit->unit->version,
                                  .displacement_scale = (float)frame->settings.displacement_scale};
        status = clast_frame_pose_unit(frame, unit);
        unit->bounds = clast_source_of(unit->unit)->bounds(unit->unit, &unit->pose);
    }
    return status;
}

// In double precision: an object may be scaled by less than the cube root of the least float. False where there is no
// inverse.
static bool invert(const clast_transform *t, clast_transform *inverse)
{
    double m[3][4];
    for (uint32_t row = 0; row < 3; row++) {
        for (uint32_t column = 0; column < 4; column++) {
            m[row][column] = (double)t->rows[row].v[column];
        }
    }
    double c[3][3]; // cofactors
    for (uint32_t row = 0; row < 3; row++) {
        for (uint32_t column = 0; column < 3; column++) {
            uint32_t r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
            c[row][column] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        }
    }
    double determinant = m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
    if (determinant == 0.0 || !isfinite(determinant)) {
        return false;
    }
    bool sound = true;
    for (uint32_t row = 0; row < 3; row++) {
        double moved = 0.0;
        for (uint32_t column = 0; column < 3; column++) {
            double value = c[column][row] / determinant;
            inverse->rows[row].v[column] = (float)value;
            moved += value * m[column][3];
            sound = sound && isfinite(inverse->rows[row].v[column]);
        }
        inverse->rows[row].v[3] = (float)-moved;
        sound = sound && isfinite(inverse->rows[row].v[3]);
    }
    return sound;
}

typedef struct place_job {
    clast_frame *frame;
    size_t *counts;          // by chunk: instances that are there, at the beginning of the chunk's part of the frame's
    _Atomic size_t uncooked; // the first instance whose geometry is not cooked
} place_job;

static void note_uncooked(place_job *job, size_t instance)
{
    size_t first = atomic_load(&job->uncooked);
    while (instance < first && !atomic_compare_exchange_weak(&job->uncooked, &first, instance)) {
    }
}

// By any thread.
static void note_used(clast_frame_unit *unit)
{
    if (!__atomic_load_n(&unit->used, __ATOMIC_RELAXED)) {
        __atomic_store_n(&unit->used, true, __ATOMIC_RELAXED);
    }
}

// Instances that are removed, invisible or squashed to nothing drop out.
static void place_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    place_job *job = data;
    clast_frame *frame = job->frame;
    size_t next = clast_motion_first_attachment(&frame->scene->motion, begin), count = 0;
    for (size_t i = begin; i < end; i++) {
        const clast_instance *from = &frame->scene->instances[i];
        frame->frame_instance_of[i] = CLAST_NONE;
        if (from->removed || !from->visible) {
            continue;
        }
        if (from->geometry >= frame->unit_count || frame->units[from->geometry].unit == NULL) {
            note_uncooked(job, i);
            continue;
        }
        clast_frame_instance *instance = &frame->instances[begin + count];
        *instance = (clast_frame_instance){.scene_instance = (uint32_t)i,
                                           .unit = from->geometry,
                                           .to_world = clast_frame_place_instance(frame, i, &next)};
        if (invert(&instance->to_world, &instance->to_object)) {
            note_used(&frame->units[from->geometry]);
            count++;
        }
    }
    job->counts[begin / INSTANCE_GRAIN] = count;
}

// Tells the scene's instances of a chunk where they are in the frame.
static void number_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const place_job *job = data;
    clast_frame *frame = job->frame;
    for (size_t chunk = begin; chunk < end; chunk++) {
        for (size_t i = job->counts[chunk]; i < job->counts[chunk + 1]; i++) {
            frame->frame_instance_of[frame->instances[i].scene_instance] = (uint32_t)i;
        }
    }
}

// Brings the chunks' instances together. Their counts become where they begin.
static void gather_instances(place_job *job, size_t chunks)
{
    clast_frame *frame = job->frame;
    frame->instance_count = 0;
    for (size_t chunk = 0; chunk < chunks; chunk++) {
        const clast_frame_instance *from = frame->instances + chunk * INSTANCE_GRAIN;
        clast_frame_instance *to = frame->instances + frame->instance_count;
        size_t count = job->counts[chunk];
        if (from != to) {
            memmove(to, from, count * sizeof *to);
        }
        job->counts[chunk] = frame->instance_count;
        frame->instance_count += count;
    }
    job->counts[chunks] = frame->instance_count;
    clast_parallel_for(frame->context, chunks, 1, number_range, job);
}

static clast_status place_instances(clast_frame *frame)
{
    const clast_scene *scene = frame->scene;
    size_t chunks = (scene->instance_count + INSTANCE_GRAIN - 1) / INSTANCE_GRAIN;
    place_job job = {.frame = frame, .counts = clast_allocate_zeroed(frame->context, chunks + 1, sizeof *job.counts)};
    if (job.counts == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    atomic_init(&job.uncooked, scene->instance_count);
    frame->frame_instance_of_count = scene->instance_count;
    clast_parallel_for(frame->context, scene->instance_count, INSTANCE_GRAIN, place_range, &job);
    gather_instances(&job, chunks);
    clast_free(frame->context, job.counts);
    size_t uncooked = atomic_load(&job.uncooked);
    return uncooked == scene->instance_count
               ? CLAST_OK
               : clast_fail(frame->context, CLAST_ERROR_STATE, "instance %zu shows geometry %u, which is not cooked",
                            uncooked, scene->instances[uncooked].geometry);
}

clast_status clast_cpu_animate(clast_frame *frame, void *target)
{
    (void)target;
    clast_status status = make_room(frame);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_frame_pose_scene(frame);
    if (status != CLAST_OK) {
        return status;
    }
    begin_units(frame);
    status = place_instances(frame);
    return status == CLAST_OK ? pose_units(frame) : status;
}
