// SPDX-License-Identifier: Apache-2.0
// A ray that hit nothing.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "driver/hits.glsl"

layout(location = 0) rayPayloadInEXT driver_found found;

void main()
{
    found.t = gl_RayTmaxEXT;
    found.instance = CLAST_NONE;
}
