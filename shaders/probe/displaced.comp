#version 460
// SPDX-License-Identifier: Apache-2.0
// Fills records of a displaced unit, and tells the corners of composites: for tests/vulkan/displaced_test.c.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_KIND 2
#define SOURCE_FILLS
#include "source/displaced.glsl"

layout(local_size_x = 128) in;

layout(push_constant, scalar) uniform probe_push
{
    uint64_t unit;
    uint64_t corners; // TEMPLATE_TRIANGLES of each record
    uint count;
} push;

void main()
{
    uint number = linear_group();
    if (number >= push.count) {
        return;
    }
    unit_reference unit = unit_reference(push.unit);
    clast_cluster_record record = cluster_records(load_address(unit.of.records)).at[number];
    uint64_t words = words_of(unit, record);
    source_fill(unit, record, words);
    positions3 vertices = positions3(load_address(unit.of.vertices) + 12ul * uint64_t(record.first_vertex));
    for (uint i = gl_LocalInvocationIndex; i < record_vertices(record); i += SOURCE_GROUP) {
        vertices.at[i] = store3(cluster_points[i]);
    }
    if (record_form(record) != FORM_COMPOSITE) {
        return;
    }
    source_corners(unit, record, words);
    for (uint i = gl_LocalInvocationIndex; i < record_triangles(record); i += SOURCE_GROUP) {
        uints(push.corners).at[TEMPLATE_TRIANGLES * number + i] = cluster_corners[i];
    }
}
