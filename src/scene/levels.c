// SPDX-License-Identifier: Apache-2.0
#include "scene/levels.h"

#include "base/size.h"

enum { LEVEL_ALIGNMENT = 16 };

static size_t element_bytes(clast_pixel_type type)
{
    return type == CLAST_PIXEL_UNORM8 ? 1 : type == CLAST_PIXEL_UNORM16 ? 2 : 4;
}

clast_image clast_level_image(const clast_image *finest, const clast_image_levels *levels, uint32_t level)
{
    return (clast_image){clast_level_side(finest->width, level), clast_level_side(finest->height, level),
                         levels->channels, levels->type, (const char *)levels->pixels + levels->offsets[level - 1]};
}

// False where the sizes pass what memory can hold.
static bool lay_out(const clast_image *finest, clast_image_levels *levels)
{
    for (uint32_t level = 1; level <= levels->count; level++) {
        size_t texels, bytes;
        levels->offsets[level - 1] = levels->bytes;
        if (!clast_multiply_size(clast_level_side(finest->width, level), clast_level_side(finest->height, level),
                                 &texels) ||
            !clast_multiply_size(texels, levels->channels * element_bytes(levels->type), &bytes) ||
            !clast_add_size(bytes, LEVEL_ALIGNMENT - 1, &bytes) ||
            !clast_add_size(levels->bytes, bytes / LEVEL_ALIGNMENT * LEVEL_ALIGNMENT, &levels->bytes)) {
            return false;
        }
    }
    return true;
}

clast_status clast_levels_create(clast_context *context, const clast_image *finest, uint32_t channels,
                                 clast_pixel_type type, uint32_t count, clast_image_levels *levels)
{
    uint32_t most = clast_level_count(finest->width, finest->height);
    clast_image_levels made = {.count = count < most ? count : most, .channels = channels, .type = type};
    *levels = (clast_image_levels){0};
    if (!lay_out(finest, &made)) {
        return clast_fail(context, CLAST_ERROR_LIMIT, "the levels of an image of %u x %u do not fit the memory",
                          finest->width, finest->height);
    }
    if (made.count != 0) {
        made.pixels = clast_allocate(context, made.bytes, 1);
        if (made.pixels == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
    }
    *levels = made;
    return CLAST_OK;
}

void clast_levels_free(clast_context *context, clast_image_levels *levels)
{
    clast_free(context, levels->pixels);
    *levels = (clast_image_levels){0};
}
