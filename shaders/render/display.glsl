// SPDX-License-Identifier: Apache-2.0
// What the kernels that make pictures of views share: display_range.comp finds the range of depths and steps, display.comp makes
// display values of all pixels.
#ifndef CLAST_RENDER_DISPLAY_GLSL
#define CLAST_RENDER_DISPLAY_GLSL

#include "gpu.glsl"
#include "shared/display.h"

layout(local_size_x = 128) in;

#define DISPLAY_VIEW(name, value, text, channels, is_float, help) const uint name = value;
CLAST_VIEW_LIST(DISPLAY_VIEW)

// vulkan/display.c hands these over.
layout(push_constant, scalar) uniform clast_display_push
{
    uint64_t values; // of the view, row by row
    uint64_t pixels; // three channels of 8 or 16 bits each
    uint64_t range;  // of depths the least and the largest, of steps 0 and the largest: as whole numbers that compare alike
    clast_display how; // but for the range
    float scale;       // of the values of colour, albedo and normals
    uint view;
    uint count; // of pixels
    uint bits;
}
push;

float real_at(uint number) { return floats(push.values).at[number]; }
uint word_at(uint number) { return uints(push.values).at[number]; }

#endif
