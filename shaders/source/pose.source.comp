#version 460
// SPDX-License-Identifier: Apache-2.0
// What a kind of source makes of a pose before anything else: its posed array, element by element. Kinds without one do
// nothing.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_POSES
#include "source_kind.glsl"

layout(local_size_x = 128) in;

layout(push_constant, scalar) uniform pose_push
{
    uint64_t unit; // of which the arrays and the pose are there
    uint64_t to;
    uint count;
} push;

void main()
{
    uint number = linear_group() * 128u + gl_LocalInvocationIndex;
    if (number >= push.count) {
        return;
    }
#ifdef SOURCE_HAS_POSED_ARRAY
    source_pose(unit_reference(push.unit), number, push.to);
#endif
}
