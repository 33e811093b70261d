// SPDX-License-Identifier: Apache-2.0
// The eye looks through the backs of single-sided surfaces: the twin of src/render/passes.c's look_through_backs().
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/trace.glsl"

uint trace_count() { return push.places; }
uint64_t trace_ticket() { return 0ul; }
void begin_ray(uint path) {}
void store_ray() {}

void main()
{
    uint path = trace_number();
    clast_path_pixel pixel = pixel_of_path(path);
    if (path >= push.places || !is_in_picture(pixel)) {
        return;
    }
    clast_visibility seen = load_hit(path);
    vec4 direction = load_piece(PATH_DIRECTION, path);
    vec3 along = vec3(direction[0], direction[1], direction[2]);
    if (!is_hidden_back(frame_of_render(), materials_of_render(), seen, along)) {
        return;
    }
    clast_ray ray = primary_ray_of(pixel);
    for (uint backs = 0u; backs < BACKS_MOST; backs++) {
        uint steps = seen.steps;
        ray.t_min = beyond_hit(seen.distance);
        seen = visibility_of_hit(trace_closest(scene_of_render(), ray));
        seen.steps += steps;
        if (!is_hidden_back(frame_of_render(), materials_of_render(), seen, along)) {
            break;
        }
    }
    store_hit(path, seen);
}
