// SPDX-License-Identifier: Apache-2.0
// How many keys of each chunk have which first digit; the other tables begin with zeros.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "gpu.glsl"
#include "accel/sort.glsl"

shared uint counts[DIGITS];

void main()
{
    uint chunk = linear_group();
    if (chunk >= push.chunks) {
        return;
    }
    uint lane = gl_LocalInvocationIndex;
    counts[lane] = 0u;
    barrier();
    uint first = chunk << push.chunk_bits;
    uint end = min(push.count - first, 1u << push.chunk_bits);
    for (uint i = lane; i < end; i += GROUP_SIZE) {
        atomicAdd(counts[digit_of(load_key(push.from_keys, first + i), 0u)], 1u);
    }
    barrier();
    table_of(0u).at[chunk * DIGITS + lane] = counts[lane];
    for (uint digit = 1u; digit < push.digits; digit++) {
        table_of(digit).at[chunk * DIGITS + lane] = 0u;
    }
}
