#version 460
// SPDX-License-Identifier: Apache-2.0
// What the items of some units need: of each, where it is kept, and of all of a unit.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_COUNTS
#include "source_kind.glsl"
#include "frame/spans.glsl"

#define GROUP_SIZE 128
#include "accel/group.glsl"

layout(local_size_x = GROUP_SIZE) in;

void add_to_unit(unit_reference unit, uint member, uint64_t value)
{
    if (value != 0ul) {
        atomicAdd(uint64s(load_address(unit.of.sums)).at[member], value);
    }
}

void keep_count(unit_reference unit, uint item, clast_source_count count)
{
    if (push.keep != 0u) {
        item_counts(load_address(unit.of.item_counts)).at[item] = count;
    }
}

void main()
{
    span_place place = place_in_spans();
    if (!place.is_there) {
        return;
    }
#ifdef SOURCE_SINGLE_ITEMS
    uint item = place.group * GROUP_SIZE + gl_LocalInvocationIndex;
    clast_source_count count = clast_source_count(0u, 0u, 0u, 0u, 0u);
    if (item < place.unit.of.item_count) {
        count = source_count(place.unit, item);
        keep_count(place.unit, item, count);
    }
    uint64_t clusters = sum_over_group64(uint64_t(count.clusters));
    uint64_t triangles = sum_over_group64(uint64_t(count.triangles));
    uint64_t vertices = sum_over_group64(uint64_t(count.vertices));
    uint64_t words = sum_over_group64(uint64_t(count.words));
    uint64_t blocks = sum_over_group64(uint64_t(count.blocks));
#else
    clast_source_count count = source_count(place.unit, place.group);
    if (gl_LocalInvocationIndex == 0u) {
        keep_count(place.unit, place.group, count);
    }
    uint64_t clusters = uint64_t(count.clusters);
    uint64_t triangles = uint64_t(count.triangles);
    uint64_t vertices = uint64_t(count.vertices);
    uint64_t words = uint64_t(count.words);
    uint64_t blocks = uint64_t(count.blocks);
#endif
    if (gl_LocalInvocationIndex == 0u) {
        add_to_unit(place.unit, 0u, clusters);
        add_to_unit(place.unit, 1u, triangles);
        add_to_unit(place.unit, 2u, vertices);
        add_to_unit(place.unit, 3u, words);
        add_to_unit(place.unit, 4u, blocks);
    }
}
