// SPDX-License-Identifier: Apache-2.0
// Primary rays: what each pixel of a tile sees. The twin of src/render/passes.c's trace_tile(), but for backs (backs.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/trace.glsl"

uint trace_count() { return push.places; }
uint64_t trace_ticket() { return 0ul; }

uint trace_path;

void begin_ray(uint path)
{
    trace_path = path;
    trace.more = false;
    clast_path_pixel pixel = pixel_of_path(path);
    if (is_in_picture(pixel)) {
        clast_ray ray = primary_ray_of(pixel);
        store_piece(PATH_DIRECTION, path, load3(ray.direction), 0.0f);
        begin_trace(scene_of_render(), ray, false);
    }
}

void store_ray()
{
    if (is_in_picture(pixel_of_path(trace_path))) {
        store_hit(trace_path, visibility_of_hit(traced_hit()));
    }
}

void main()
{
    trace_one();
}
