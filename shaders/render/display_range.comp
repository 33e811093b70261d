// SPDX-License-Identifier: Apache-2.0
// The range of depths, of steps, or of samples. The bits of depths, which are more than zero, compare as they do.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/display.glsl"

shared uint least, most;

void main()
{
    if (gl_LocalInvocationIndex == 0u) {
        least = 0xffffffffu;
        most = 0u;
    }
    barrier();
    uint number = linear_group() * 128u + gl_LocalInvocationIndex;
    uint value = number < push.count ? word_at(number) : 0u;
    bool is_depth = push.view == CLAST_VIEW_DEPTH;
    if (number < push.count && (is_depth ? display_is_there(uintBitsToFloat(value)) : value != 0u && value != CLAST_NONE)) {
        atomicMin(least, value);
        atomicMax(most, value);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u && most != 0u) {
        atomicMin(uints(push.range).at[0], least);
        atomicMax(uints(push.range).at[1], most);
    }
}
