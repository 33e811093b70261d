#version 460
// SPDX-License-Identifier: Apache-2.0
// Fills records of a displaced unit, and tells the corners of composites: for tests/vulkan/displaced_test.c.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_KIND 2
#define SOURCE_FILLS
#define LANES_CONSTANT 0
#define GROUP_CONSTANT 1
#include "source/displaced.glsl"

layout(push_constant, scalar) uniform probe_push
{
    uint64_t unit;
    uint64_t corners; // TEMPLATE_TRIANGLES of each record
    uint count;
} push;

void main()
{
    uint number = cluster_of_group();
    if (number >= push.count) {
        return;
    }
    unit_reference unit = unit_reference(push.unit);
    clast_cluster_record record = cluster_records(load_address(unit.of.records)).at[number];
    uint64_t words = words_of(unit, record);
    source_fill(unit, record, words);
    store_cluster_points(load_address(unit.of.vertices) + 12ul * uint64_t(record.first_vertex), record_vertices(record));
    if (record_form(record) != FORM_COMPOSITE) {
        return;
    }
    source_corners(unit, record, words);
    for (uint i = cluster_lane(); i < record_triangles(record); i += LANES) {
        uints(push.corners).at[TEMPLATE_TRIANGLES * number + i] = cluster_corners(i);
    }
}
