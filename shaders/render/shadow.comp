// SPDX-License-Identifier: Apache-2.0
// Shadow rays: what arrives where nothing is in between is added to the path. A path has one ray of a list at most.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TRACE_RAY() shadow_ray(trace_path)
#include "accel/ray.glsl"

uint trace_path;
clast_ray shadow_ray(uint path);

#include "render/trace.glsl"

clast_ray shadow_ray(uint path)
{
    vec4 origin = float4s(shadow_piece(push.list, 0u, path)).at[0];
    vec4 direction = float4s(shadow_piece(push.list, 1u, path)).at[0];
    return make_ray(vec3(origin[0], origin[1], origin[2]), 0.0f, vec3(direction[0], direction[1], direction[2]),
                    origin[3]);
}

uint trace_count() { return queue_of().of.lengths[push.list]; }
uint64_t trace_ticket() { return ticket_of(push.list); }

void begin_ray(uint number)
{
    trace_path = paths_in(push.list, push.bounce).at[number];
    begin_trace(scene_of_render(), shadow_ray(trace_path), true);
}

void store_ray()
{
    if (trace_found()) {
        return;
    }
    vec4 arrives = float4s(shadow_piece(push.list, 2u, trace_path)).at[0];
    vec4 found = load_piece(PATH_RADIANCE, trace_path);
    vec3 radiance = vec3(found[0], found[1], found[2]) + vec3(arrives[0], arrives[1], arrives[2]);
    store_piece(PATH_RADIANCE, trace_path, radiance, found[3]);
    if (render_of().of.fireflies == CLAST_FIREFLIES_CLAMPED && push.bounce == 0u) { // what shadow rays from the first surface bring
        float4s(load_address(render_of().of.direct)).at[trace_path] = vec4(radiance, 0.0f);
    }
}

void main()
{
    trace_all();
}
