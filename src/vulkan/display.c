// SPDX-License-Identifier: Apache-2.0
#include "vulkan/display.h"

enum {
    GROUP = 128, // invocations of a work group: as in shaders/render/display.glsl
    EACH = 4,    // pixels of an invocation, in whole words
};
#define PIXELS_MOST (UINT64_C(1) << 30)

// The push constants of shaders/render/display.glsl.
typedef struct display_push {
    uint64_t values, pixels, range;
    clast_display how;
    float scale;
    uint32_t view, count, bits;
} display_push;
_Static_assert(sizeof(display_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

uint64_t clast_gpu_display_bytes(uint32_t width, uint32_t height, uint32_t bits)
{
    uint64_t pieces = ((uint64_t)width * height + EACH - 1) / EACH;
    return pieces * EACH * 3 * (bits / 8);
}

static void run(clast_gpu_commands *commands, clast_shader shader, const display_push *push, uint64_t invocations)
{
    clast_gpu_run(commands, &(clast_gpu_call){.shader = shader,
                                              .push = push,
                                              .push_bytes = sizeof *push,
                                              .groups = (invocations + GROUP - 1) / GROUP});
}

void clast_gpu_display(clast_gpu_commands *commands, const clast_gpu_display_desc *desc, const clast_gpu_buffer *range)
{
    uint64_t count = (uint64_t)desc->width * desc->height;
    if (count > PIXELS_MOST) {
        clast_gpu_note(commands, clast_fail(clast_gpu_context(clast_gpu_of(commands)), CLAST_ERROR_LIMIT,
                                            "a picture of %u x %u pixels: a device makes at most 2^30", desc->width,
                                            desc->height));
        return;
    }
    display_push push = {.values = desc->values,
                         .pixels = desc->pixels,
                         .range = range->address,
                         .how = desc->how,
                         .scale = desc->scale,
                         .view = (uint32_t)desc->view,
                         .count = (uint32_t)count,
                         .bits = desc->bits};
    if (desc->view == CLAST_VIEW_DEPTH || desc->view == CLAST_VIEW_STEPS || desc->view == CLAST_VIEW_SAMPLES) {
        clast_gpu_fill(commands, range, 0, 4, UINT32_MAX);
        clast_gpu_fill(commands, range, 4, 4, 0);
        clast_gpu_barrier(commands);
        run(commands, CLAST_SHADER_RENDER_DISPLAY_RANGE, &push, count);
        clast_gpu_barrier(commands);
    }
    run(commands, CLAST_SHADER_RENDER_DISPLAY, &push, (count + EACH - 1) / EACH);
}
