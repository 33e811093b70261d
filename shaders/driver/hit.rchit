// SPDX-License-Identifier: Apache-2.0
// The nearest hit of a ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "driver/hits.glsl"

layout(location = 0) rayPayloadInEXT driver_found found;
hitAttributeEXT vec2 barycentrics;

void main()
{
    found.t = gl_HitTEXT;
    found.barycentrics = barycentrics;
    found.instance = gl_InstanceCustomIndexEXT;
    found.primitive = gl_PrimitiveID;
}
