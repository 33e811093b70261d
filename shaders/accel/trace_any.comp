#version 460
// SPDX-License-Identifier: Apache-2.0
// Whether each ray of a buffer hits anything: a number each, 1 or 0.
#extension GL_GOOGLE_include_directive : require
#define TRACE_ANY true
#include "accel/trace_rays.glsl"

void main()
{
    trace_all();
}
