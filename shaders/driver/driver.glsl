// SPDX-License-Identifier: Apache-2.0
// Rays of buffers by the driver's ray tracing pipeline.
#ifndef CLAST_DRIVER_GLSL
#define CLAST_DRIVER_GLSL

#include "driver/hits.glsl"

// vulkan/driver.c hands these over.
layout(push_constant, scalar) uniform clast_driver_push {
    uint64_t scene; // clast_driver_top
    uint64_t rays;
    uint64_t results; // of closest hits: clast_hit; of any hits: 1 or 0, 32 bits each
    uint64_t counts;  // 0, or where the number of rays lies
    uint64_t user;    // the filter's own
    uint count;       // most rays
}
push;

#endif
