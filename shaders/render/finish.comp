// SPDX-License-Identifier: Apache-2.0
// Adds what a tile's paths found to the pictures' sums: the twin of src/render/path.c's finish_path().
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/paths.glsl"
layout(local_size_x = 128) in;

void add_to_half(clast_path_pixel pixel, vec3 radiance)
{
    uint64_t halves = load_address(render_of().of.halves);
    if (halves != 0ul) {
        floats sums = floats(halves + 12ul * pixel_number(pixel));
        for (uint c = 0u; c < 3u; c++) {
            sums.at[c] += radiance[c];
        }
    }
}

void main()
{
    uint path = linear_group() * PATH_GROUP + gl_LocalInvocationIndex;
    clast_path_pixel pixel = pixel_of_path(path);
    if (path >= push.places || !is_in_picture(pixel)) {
        return;
    }
    vec4 found = load_piece(PATH_RADIANCE, path);
    vec3 radiance = vec3(found[0], found[1], found[2]);
    if (render_of().of.fireflies == CLAST_FIREFLIES_CLAMPED) {
        vec4 direct = float4s(load_address(render_of().of.direct)).at[path];
        radiance = clamp_indirect(radiance, vec3(direct[0], direct[1], direct[2]));
    }
    if (!is_finite3(radiance)) {
        atomicAdd(queue_of().of.rejected, 1u);
    } else {
        add_to_view(CLAST_VIEW_COLOUR, pixel, radiance);
        if (is_of_half(push.sample_number)) {
            add_to_half(pixel, radiance);
        }
    }
}
