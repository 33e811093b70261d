#version 460
// SPDX-License-Identifier: Apache-2.0
// Makes hits of the places of triangles that trace_closest.comp left, where invocations took rays by ticket.
#extension GL_GOOGLE_include_directive : require
#define TRACE_ANY false
#include "accel/trace_rays.glsl"

void main()
{
    uint number = linear_group() * TRACE_GROUP + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
    trace_ray_number = number;
    trace_stack[COLD_SCENE] = store_address(push.scene);
    hits to = hits(push.to);
    trace_place place;
    place.placement = to.at[number].instance;
    place.cluster = to.at[number].cluster;
    place.triangle = to.at[number].triangle;
    float t = to.at[number].t;
    uint steps = to.at[number].steps;
    to.at[number] = hit_at(place, t, steps);
}
