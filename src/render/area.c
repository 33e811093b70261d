// SPDX-License-Identifier: Apache-2.0
// The part of a picture that is rendered.
#include "render/squares.h"

// Digits only, up to what 32 bits hold; gives where they end, or null.
static const char *read_number(const char *text, uint32_t *number)
{
    uint64_t value = 0;
    const char *at = text;
    for (; *at >= '0' && *at <= '9' && value <= UINT32_MAX; at++) {
        value = 10 * value + (uint64_t)(*at - '0');
    }
    *number = (uint32_t)value;
    return at != text && value <= UINT32_MAX ? at : NULL;
}

static bool read_area(const char *text, clast_render_area *area)
{
    uint32_t *const parts[] = {&area->x, &area->y, &area->width, &area->height};
    for (int i = 0; i < 4; i++) {
        text = read_number(text, parts[i]);
        if (text == NULL || *text != (i < 3 ? ',' : '\0')) {
            return false;
        }
        text++;
    }
    return true;
}

clast_status clast_find_area(clast_context *context, const clast_render_settings *settings, clast_render_area *area)
{
    *area = (clast_render_area){0, 0, settings->width, settings->height};
    if (settings->crop == NULL || settings->crop[0] == '\0') {
        return CLAST_OK;
    }
    clast_render_area wanted;
    bool is_inside = read_area(settings->crop, &wanted) && wanted.width != 0 && wanted.height != 0 &&
                     wanted.x < area->width && wanted.width <= area->width - wanted.x && wanted.y < area->height &&
                     wanted.height <= area->height - wanted.y;
    if (!is_inside) {
        return clast_fail(
            context, CLAST_ERROR_INVALID_ARGUMENT,
            "setting crop: expected X,Y,WIDTH,HEIGHT in pixels, within the picture of %u x %u, got \"%s\"", area->width,
            area->height, settings->crop);
    }
    *area = wanted;
    return CLAST_OK;
}
