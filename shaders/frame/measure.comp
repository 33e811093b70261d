#version 460
// SPDX-License-Identifier: Apache-2.0
// The memory that the clusters of some units' records take, and how many vertices all of a unit's have.
#extension GL_GOOGLE_include_directive : require
#include "frame/spans.glsl"
#include "shared/cluster.h"

#define GROUP_SIZE 128
#include "accel/group.glsl"

layout(local_size_x = GROUP_SIZE) in;

void main()
{
    span_place place = place_in_spans();
    if (!place.is_there) {
        return;
    }
    uint number = place.group * GROUP_SIZE + gl_LocalInvocationIndex;
    uint vertices = 0u;
    if (number < place.unit.of.record_count) {
        clast_cluster_record record = cluster_records(load_address(place.unit.of.records)).at[number];
        vertices = record_vertices(record);
        uints(load_address(place.unit.of.spaces)).at[number] =
            cluster_space(triangles_counts(record_triangles(record)), record_form(record) == FORM_COMPOSITE);
    }
    uint all = sum_over_group(vertices).all;
    if (gl_LocalInvocationIndex == 0u) {
        atomicAdd(uint64s(load_address(place.unit.of.sums)).at[UNIT_SUMS_COUNTS], uint64_t(all));
    }
}
