// SPDX-License-Identifier: Apache-2.0
// The settings of a render: defaults and ranges, from the one list.
#include <string.h>

#include "base/context.h"
#include "render/squares.h"
#include "scene/scene.h"

// Between keys the value goes straight; before the first and after the last it stays.
static double value_at(const clast_setting_keys *setting, double time)
{
    const double(*keys)[2] = (const double(*)[2])setting->keys;
    size_t last = setting->key_count - 1, i = 0;
    while (i < last && keys[i + 1][0] <= time) {
        i++;
    }
    if (i == last || time <= keys[i][0]) {
        return keys[i][1];
    }
    double part = (time - keys[i][0]) / (keys[i + 1][0] - keys[i][0]);
    return keys[i][1] + part * (keys[i + 1][1] - keys[i][1]);
}

void clast_scene_settings_at(const clast_scene *scene, double time, clast_render_settings *settings)
{
    if (scene == NULL || settings == NULL) {
        return;
    }
    *settings = scene->settings;
    settings->time = time;
    for (size_t i = 0; i < scene->motion.setting_count; i++) {
        const clast_setting_keys *setting = &scene->motion.settings[i];
        double value = value_at(setting, time);
        value = value == 0.0 && setting->has_default ? CLAST_ZERO : value;
        memcpy((char *)settings + setting->offset, &value, sizeof value);
    }
}

void clast_scene_settings(const clast_scene *scene, clast_render_settings *settings)
{
    if (scene != NULL && settings != NULL) {
        clast_scene_settings_at(scene, scene->settings.time, settings);
    }
}

// A check is written so that a NaN fails it.
static clast_status check_range(clast_context *context, const char *name, double value, double minimum, double maximum)
{
    if (value >= minimum && value <= maximum) {
        return CLAST_OK;
    }
    return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "setting %s: expected %g to %g, got %g", name, minimum,
                      maximum, value);
}

static clast_status fail_choice(clast_context *context, const char *name, uint32_t value)
{
    return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "setting %s: %u is none of its values", name, value);
}

#define IS_VALUE(name, value, ...) || chosen == (value)
#define RESOLVE_NUMBER(name, initial, minimum, maximum, ...) \
    if (settings->name == 0) { \
        settings->name = initial; \
    } \
    if (status == CLAST_OK) { \
        status = check_range(context, #name, (double)settings->name, minimum, maximum); \
    }
#define RESOLVE_CHOICE(name, list, initial, ...) \
    if (settings->name == 0) { \
        settings->name = initial; \
    } \
    if (status == CLAST_OK) { \
        uint32_t chosen = settings->name; \
        if (!(false list(IS_VALUE))) { \
            status = fail_choice(context, #name, chosen); \
        } \
    }
#define RESOLVE_TEXT(name, initial, ...) \
    if (settings->name == NULL) { \
        settings->name = initial; \
    }

clast_status clast_render_settings_resolve(clast_context *context, clast_render_settings *settings)
{
    if (context == NULL || settings == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = CLAST_OK;
    if (settings->spp == 0 && (settings->time_limit > 0.0 || settings->noise_target > 0.0)) {
        settings->spp = CLAST_SPP_WITHOUT_COUNT;
    }
    CLAST_RENDER_SETTING_LIST(RESOLVE_NUMBER, RESOLVE_NUMBER, RESOLVE_CHOICE, RESOLVE_TEXT)
    if (status == CLAST_OK && settings->shutter > 0.0 && (settings->time_limit > 0.0 || settings->noise_target > 0.0)) {
        status = clast_fail(
            context, CLAST_ERROR_INVALID_ARGUMENT,
            "shutter: samples are divided among its moments: give their number, not time_limit or noise_target");
    }
    clast_render_area area;
    return status == CLAST_OK ? clast_find_area(context, settings, &area) : status;
}

clast_status clast_render_settings_area(clast_context *context, const clast_render_settings *settings,
                                        clast_render_area *area)
{
    if (context == NULL || settings == NULL || area == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_render_settings resolved = *settings;
    clast_status status = clast_render_settings_resolve(context, &resolved);
    return status == CLAST_OK ? clast_find_area(context, &resolved, area) : status;
}
