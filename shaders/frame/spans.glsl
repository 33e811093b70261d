// SPDX-License-Identifier: Apache-2.0
// Work of one dispatch over parts of several units: which part a work group has. The push constants of the kernels of this
// folder begin as span_push does.
#ifndef CLAST_FRAME_SPANS_GLSL
#define CLAST_FRAME_SPANS_GLSL

#include "source/source.glsl"

layout(push_constant, scalar) uniform span_push
{
    uint64_t units; // clast_device_unit
    uint64_t spans; // clast_device_span
    uint64_t templates; // clast_device_template
    uint span_count; // without the one that ends the list
    uint keep;       // of count: whether what items need is written
} push;

struct span_place
{
    bool is_there;
    unit_reference unit;
    uint number; // of the unit
    uint group;  // counted from the unit's first
};

// Of a work group, or of what else the spans count.
span_place place_in_spans(uint group)
{
    device_spans spans = device_spans(push.spans);
    span_place place;
    place.is_there = group < spans.at[push.span_count].first;
    // the last span that begins at `group` or before: [low, high)
    uint low = 0u;
    uint high = push.span_count;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (spans.at[middle].first <= group) {
            low = middle;
        } else {
            high = middle;
        }
    }
    clast_device_span span = spans.at[low];
    place.number = span.unit;
    place.unit = unit_at(push.units, span.unit);
    place.group = group - span.first;
    return place;
}

span_place place_in_spans() { return place_in_spans(linear_group()); }

#endif
