// SPDX-License-Identifier: Apache-2.0
// Pass animate: what stands where at this moment.
#include <math.h>

#include "base/thread.h"
#include "frame/backend.h"

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

// Instances that are removed, invisible or squashed to nothing drop out.
static clast_status place_instances(clast_frame *frame)
{
    const clast_scene *scene = frame->scene;
    size_t next = 0;
    frame->instance_count = 0;
    frame->frame_instance_of_count = scene->instance_count;
    for (size_t i = 0; i < scene->instance_count; i++) {
        const clast_instance *from = &scene->instances[i];
        frame->frame_instance_of[i] = CLAST_NONE;
        if (from->removed || !from->visible) {
            continue;
        }
        if (from->geometry >= frame->unit_count || frame->units[from->geometry].unit == NULL) {
            return clast_fail(frame->context, CLAST_ERROR_STATE, "instance %zu shows geometry %u, which is not cooked",
                              i, from->geometry);
        }
        clast_frame_instance instance = {.scene_instance = (uint32_t)i,
                                         .unit = from->geometry,
                                         .to_world = clast_frame_place_instance(frame, i, &next)};
        if (!invert(&instance.to_world, &instance.to_object)) {
            continue;
        }
        frame->frame_instance_of[i] = (uint32_t)frame->instance_count;
        frame->instances[frame->instance_count++] = instance;
        frame->units[from->geometry].used = true;
    }
    return CLAST_OK;
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
