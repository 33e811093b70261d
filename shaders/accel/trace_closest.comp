#version 460
// SPDX-License-Identifier: Apache-2.0
// The nearest hit of each ray of a buffer: a clast_hit each.
#extension GL_GOOGLE_include_directive : require
#define TRACE_ANY false
#include "accel/trace_rays.glsl"

void main()
{
    trace_all();
}
