// SPDX-License-Identifier: Apache-2.0
// The next rays of paths that go on.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACE_RAY() next_ray(trace_path)
#include "accel/ray.glsl"

uint trace_path;
clast_ray next_ray(uint path);

#include "render/trace.glsl"

clast_ray next_ray(uint path)
{
    vec4 origin = load_piece(PATH_ORIGIN, path);
    vec4 direction = load_piece(PATH_DIRECTION, path);
    return make_ray(vec3(origin[0], origin[1], origin[2]), 0.0f, vec3(direction[0], direction[1], direction[2]),
                    uintBitsToFloat(0x7f800000u));
}

uint trace_count() { return queue_of().of.lengths[LIST_NEXT]; }
uint64_t trace_ticket() { return ticket_of(LIST_NEXT); }

void begin_ray(uint number)
{
    trace_path = paths_in(LIST_NEXT, push.bounce + 1u).at[number];
    begin_trace(scene_of_render(), next_ray(trace_path), false);
}

void store_ray()
{
    store_hit(trace_path, visibility_of_hit(traced_hit()));
}

void main()
{
    trace_all();
}
