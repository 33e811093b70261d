#version 460
// SPDX-License-Identifier: Apache-2.0
// The memory that the clusters of some units' records take, and how much is in all of a unit's.
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
    uint fill = 0u;
    if (number < place.unit.of.record_count) {
        clast_cluster_record record = cluster_records(load_address(place.unit.of.records)).at[number];
        vertices = record_vertices(record);
        fill = max_uint(vertices, record_triangles(record));
        uints(load_address(place.unit.of.spaces)).at[number] =
            cluster_space(triangles_counts(record_triangles(record)), record_form(record) == FORM_COMPOSITE);
    }
    uint all_vertices = sum_over_group(vertices).all;
    uint all_fill = sum_over_group(fill).all;
    if (gl_LocalInvocationIndex == 0u) {
        uint64s sums = uint64s(load_address(place.unit.of.sums));
        atomicAdd(sums.at[UNIT_SUMS_COUNTS], uint64_t(all_vertices));
        atomicAdd(sums.at[UNIT_SUMS_COUNTS + 1u], uint64_t(all_fill));
    }
}
