// SPDX-License-Identifier: Apache-2.0
// A scene with a frame over it, run by the CPU's passes.
#ifndef CLAST_TESTS_FRAME_STAGE_H
#define CLAST_TESTS_FRAME_STAGE_H

#include "shapes.h"

#include "frame/backend.h"

#define STAGE_PASS(pass, function) [pass] = function,
static const clast_backend stage_backend = {.name = "cpu", .passes = {CLAST_FRAME_CPU_PASSES(STAGE_PASS)}};

typedef struct stage {
    clast_context *context;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;
} stage;

// The eye at (0, 0, 10), looking along -z.
static inline clast_camera stage_camera(void)
{
    clast_camera_desc desc = {.position = {0.0f, 0.0f, 10.0f}, .target = {0.0f, 0.0f, 0.0f}, .vertical_angle = 0.8f};
    return clast_camera_record(&desc, 640, 360);
}

static inline clast_frame *stage_add_frame(stage *s)
{
    clast_frame *frame = NULL;
    assert_ok(s->context, clast_frame_create(s->scene, s->cooked, &frame));
    frame->settings = (clast_frame_settings){.camera = stage_camera(),
                                             .rate_camera = stage_camera(),
                                             .width = 640,
                                             .height = 360,
                                             .rate = 1.0,
                                             .segment = 2.0,
                                             .hidden_fraction = 0.25,
                                             .displacement_scale = 1.0};
    return frame;
}

static inline stage stage_open(clast_context *context)
{
    stage s = {.context = context};
    assert_ok(context, clast_scene_create(context, &s.scene));
    assert_ok(context, clast_cooked_create(context, &s.cooked));
    s.frame = stage_add_frame(&s);
    return s;
}

static inline void stage_close(stage *s)
{
    clast_frame_destroy(s->frame);
    clast_cooked_destroy(s->cooked);
    clast_scene_destroy(s->scene);
}

static inline clast_status stage_try(stage *s)
{
    clast_status status = clast_cooked_update(s->cooked, s->scene);
    return status == CLAST_OK ? clast_frame_run(s->frame, &stage_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL)
                              : status;
}

static inline void stage_run(stage *s)
{
    assert_ok(s->context, stage_try(s));
}

static inline clast_hit stage_trace(const clast_frame *frame, float x, float y, float z, float dx, float dy, float dz)
{
    clast_ray ray = {{x, y, z}, 0.0f, {dx, dy, dz}, INFINITY};
    clast_hit hit;
    clast_trace_closest(frame->tlas, &ray, 1, NULL, &hit);
    return hit;
}

#endif
