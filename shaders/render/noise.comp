// SPDX-License-Identifier: Apache-2.0
// The noise of squares that go on: the twin of src/render/passes.c's measure_square(). A work group takes a square.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/paths.glsl"
layout(local_size_x = 64) in; // SQUARE_PIXELS

shared float noise[SQUARE_PIXELS];
shared uint pixels[SQUARE_PIXELS];

vec3 sum_at(floats sums) { return vec3(sums.at[0], sums.at[1], sums.at[2]); }

float noise_of(clast_path_pixel pixel)
{
    floats all_sums = view_pixel(CLAST_VIEW_COLOUR, 3u, pixel);
    floats half_sums = floats(load_address(render_of().of.halves) + 12ul * pixel_number(pixel));
    return pixel_noise(sum_at(all_sums), sum_at(half_sums), to_float(push.sample_number), render_of().of.gain);
}

void main()
{
    uint group = linear_group();
    if (group >= push.places) { // squares, here
        return;
    }
    uint lane = gl_LocalInvocationIndex;
    clast_path_pixel pixel = pixel_of_path(group * SQUARE_PIXELS + lane);
    bool is_there = is_in_picture(pixel);
    noise[lane] = 0.0f;
    pixels[lane] = is_there ? 1u : 0u;
    if (is_there) {
        noise[lane] = noise_of(pixel);
    }
    barrier();
    for (uint stride = SQUARE_PIXELS / 2u; stride > 0u; stride /= 2u) {
        if (lane < stride) {
            noise[lane] += noise[lane + stride];
            pixels[lane] += pixels[lane + stride];
        }
        barrier();
    }
    if (lane == 0u) {
        uint square = uints(load_address(render_of().of.squares)).at[push.first_square + group];
        floats(load_address(render_of().of.noise)).at[square] = rough_divide(noise[0], to_float(pixels[0]));
    }
}
