// SPDX-License-Identifier: Apache-2.0
// What the launches of rays of a buffer share.
#ifndef CLAST_DRIVER_RAYS_GLSL
#define CLAST_DRIVER_RAYS_GLSL

#include "driver/driver.glsl"
#include "driver/trace.glsl"

uint ray_number;

uint trace_count() { return push.counts != 0ul ? min(uints(push.counts).at[0], push.count) : push.count; }

#endif
