// SPDX-License-Identifier: Apache-2.0
// The settings of a render: defaults and ranges, from the one list.
#include "base/context.h"
#include "clast/render.h"
#include "scene/scene.h"

void clast_scene_settings(const clast_scene *scene, clast_render_settings *settings)
{
    if (scene != NULL && settings != NULL) {
        *settings = scene->settings;
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
    CLAST_RENDER_SETTING_LIST(RESOLVE_NUMBER, RESOLVE_NUMBER, RESOLVE_CHOICE, RESOLVE_TEXT)
    return status;
}
