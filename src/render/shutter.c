// SPDX-License-Identifier: Apache-2.0
#include "render/shutter.h"

#include "render/lights.h"

static uint32_t moments_of(const clast_render_settings *settings)
{
    return settings->shutter_steps < settings->spp ? settings->shutter_steps : settings->spp;
}

uint32_t clast_shutter_moment(const clast_render_settings *settings, uint32_t sample)
{
    bool opens = settings->shutter > 0.0;
    return opens ? (uint32_t)((uint64_t)sample * moments_of(settings) / settings->spp) : 0;
}

double clast_shutter_time(const clast_render_settings *settings, uint32_t moment)
{
    return settings->time + settings->shutter * ((double)moment + 0.5) / (double)moments_of(settings);
}

static clast_status run_to(clast_frame *frame, const clast_backend *backend, double time)
{
    frame->settings.time = time;
    return clast_frame_run(frame, backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL);
}

clast_status clast_shutter_move(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    const clast_render_settings *settings = &target->settings;
    uint32_t moment = clast_shutter_moment(settings, target->sample);
    if (settings->shutter <= 0.0 || (target->is_moved && moment == target->moment)) {
        return CLAST_OK;
    }
    clast_status status = run_to(frame, backend, clast_shutter_time(settings, moment));
    if (status == CLAST_OK) {
        clast_lights_destroy(frame->context, target->lights);
        target->lights = NULL;
        status = clast_lights_create(frame, &target->srgb, &target->lights);
    }
    target->moment = moment;
    target->is_moved = status == CLAST_OK;
    return status;
}

clast_status clast_shutter_close(clast_frame *frame, const clast_backend *backend, const clast_render_target *target)
{
    bool opened = target->settings.shutter > 0.0 && frame->settings.time != target->settings.time;
    return opened ? run_to(frame, backend, target->settings.time) : CLAST_OK;
}
