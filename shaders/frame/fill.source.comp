#version 460
// SPDX-License-Identifier: Apache-2.0
// Vertices of some units' records, and the clusters fitted to them while they are in shared memory: a work group for each record.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_FILLS
#include "source_kind.glsl"
#include "frame/spans.glsl"

#ifdef SOURCE_COMPOSITES
#define FIT_OWN_PAIRS
#endif
#include "accel/fit.glsl"

layout(local_size_x = 128) in;

// Where a record's cluster begins. Where records are new, sums over their spaces tell; these are kept for when only vertices
// change.
uint place_of(unit_reference unit, uint number)
{
    uint64_t spaces = load_address(unit.of.spaces);
    uints places = uints(load_address(unit.of.places));
    if (spaces == 0ul) {
        return places.at[number];
    }
    uint place = uints(spaces).at[number] - uints(spaces).at[0];
    if (gl_LocalInvocationIndex == 0u) {
        places.at[number] = place;
    }
    return place;
}

// Where a record's vertices lie; those that are not resident are written there.
uint64_t store_vertices(unit_reference unit, clast_cluster_record record)
{
    uint64_t resident = source_resident(unit, record);
    if (resident != 0ul) {
        return resident;
    }
    uint64_t address = load_address(unit.of.vertices) + 12ul * uint64_t(record.first_vertex);
    for (uint i = gl_LocalInvocationIndex; i < record_vertices(record); i += SOURCE_GROUP) {
        positions3(address).at[i] = store3(cluster_points[i]);
    }
    return address;
}

void main()
{
    span_place place = place_in_spans();
    if (!place.is_there) {
        return;
    }
    unit_reference unit = place.unit;
    clast_cluster_record record = cluster_records(load_address(unit.of.records)).at[place.group];
    uint64_t words = words_of(unit, record);
    source_fill(unit, record, words);
    fit_target target;
    target.head = load_address(unit.of.clusters) + uint64_t(CLUSTER_UNIT) * uint64_t(place_of(unit, place.group));
    target.vertices = store_vertices(unit, record);
    target.pairs = 0ul;
    target.box = load_address(unit.of.boxes) + 24ul * uint64_t(place.group);
    target.cluster = place.group;
    target.counts = triangles_counts(record_triangles(record));
    clast_pair pair;
#ifdef SOURCE_COMPOSITES
    if (record_form(record) == FORM_COMPOSITE) {
        source_corners(unit, record, words);
        pair = fit_own_pair(target, record_triangles(record));
    } else
#endif
    {
        target.pairs = load_address(fit_templates(push.templates).at[record.template_index].pairs);
        pair = fit_template_pair(target);
    }
    fit_cluster(target, pair);
}
