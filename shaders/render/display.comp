// SPDX-License-Identifier: Apache-2.0
// A view as a picture to look at: the twin of src/render/display.c. An invocation makes four pixels, which are whole words.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/display.glsl"

vec3 vector_at(uint number)
{
    return vec3(real_at(3u * number), real_at(3u * number + 1u), real_at(3u * number + 2u)) * push.scale;
}

clast_display with_range(clast_display how)
{
    uint least = uints(push.range).at[0];
    uint most = uints(push.range).at[1];
    if (push.view == CLAST_VIEW_DEPTH && most != 0u) {
        how.low = rough_log(uintBitsToFloat(least));
        how.high = rough_log(uintBitsToFloat(most));
    } else if (push.view == CLAST_VIEW_STEPS) {
        how.high = to_float(max_uint(most, 1u));
    } else if (push.view == CLAST_VIEW_SAMPLES) {
        how.low = rough_log2(to_float(max_uint(least, 1u)));
        how.high = rough_log2(to_float(max_uint(most, 1u)));
    }
    return how;
}

vec3 pixel_colour(clast_display how, uint number)
{
    switch (push.view) {
    case CLAST_VIEW_COLOUR: return tone_map(vector_at(number), how.gain, how.curve);
    case CLAST_VIEW_ALBEDO: return display_albedo(vector_at(number));
    case CLAST_VIEW_NORMAL: return display_normal(vector_at(number));
    case CLAST_VIEW_DEPTH: return display_depth(how, real_at(number));
    case CLAST_VIEW_UV: return display_uv(vec2(real_at(2u * number), real_at(2u * number + 1u)));
    case CLAST_VIEW_INSTANCE:
    case CLAST_VIEW_CLUSTER:
    case CLAST_VIEW_TRIANGLE:
    case CLAST_VIEW_PRIMITIVE: return display_number(word_at(number));
    case CLAST_VIEW_SEGMENTS: return display_segments(real_at(number));
    case CLAST_VIEW_RATE: return display_balance(real_at(number));
    case CLAST_VIEW_AREA: return display_balance(rough_divide(real_at(number), how.area));
    case CLAST_VIEW_STEPS: return display_steps(how, word_at(number));
    case CLAST_VIEW_SAMPLES: return display_samples(how, word_at(number));
    }
    return splat3(0.0f);
}

void main()
{
    uint first = 4u * (linear_group() * 128u + gl_LocalInvocationIndex);
    if (first >= push.count) {
        return;
    }
    clast_display how = with_range(push.how);
    uint words[6] = uint[6](0u, 0u, 0u, 0u, 0u, 0u);
    float most = push.bits == 16u ? 65535.0f : 255.0f;
    for (uint i = 0u; i < 4u && first + i < push.count; i++) {
        vec3 colour = pixel_colour(how, first + i);
        for (uint c = 0u; c < 3u; c++) {
            uint bit = (3u * i + c) * push.bits;
            words[bit / 32u] |= display_level(colour[c], most) << (bit & 31u);
        }
    }
    uint each = 12u * push.bits / 32u;
    uints pixels = uints(push.pixels + 4ul * uint64_t(each) * uint64_t(first / 4u));
    for (uint i = 0u; i < each; i++) {
        pixels.at[i] = words[i];
    }
}
