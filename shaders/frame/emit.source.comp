#version 460
// SPDX-License-Identifier: Apache-2.0
// The records of some units' items, and their words. Where they go follows from sums over what was counted.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_COUNTS
#include "source_kind.glsl"
#include "frame/spans.glsl"

layout(local_size_x = 128) in;

void emit_item(unit_reference unit, uint item)
{
    item_counts sums = item_counts(load_address(unit.of.item_counts));
    clast_source_count first = sums.at[0];
    clast_source_count here = sums.at[item];
    uint record = here.clusters - first.clusters;
    uint vertex = here.vertices - first.vertices;
    uint word = here.words - first.words;
    source_emit(unit, item, vertex, word, load_address(unit.of.words) + 4ul * uint64_t(word),
                load_address(unit.of.records) + 28ul * uint64_t(record));
}

void main()
{
    span_place place = place_in_spans();
    if (!place.is_there) {
        return;
    }
#ifdef SOURCE_SINGLE_ITEMS
    uint item = place.group * 128u + gl_LocalInvocationIndex;
    if (item < place.unit.of.item_count) {
        emit_item(place.unit, item);
    }
#else
    emit_item(place.unit, place.group);
#endif
}
