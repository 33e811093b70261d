#version 460
// SPDX-License-Identifier: Apache-2.0
// Vertices of some units' records, and the clusters fitted to them while they are in shared memory: a subgroup for each record.
#extension GL_GOOGLE_include_directive : require
#define SOURCE_FILLS
#define LANES_CONSTANT 0
#define GROUP_CONSTANT 1
#include "source_kind.glsl"
#include "frame/spans.glsl"

#ifdef SOURCE_COMPOSITES
#define FIT_OWN_PAIRS
#endif
#include "accel/fit.glsl"

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
    if (cluster_lane() == 0u) {
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
    store_cluster_points(address, record_vertices(record));
    return address;
}

void main()
{
    span_place place = place_in_spans(cluster_of_group());
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
    target.box = load_address(unit.of.boxes) + 24ul * uint64_t(place.group);
    target.cluster = place.group;
    target.counts = triangles_counts(record_triangles(record));
    target.own_triangles = 0u;
#ifdef SOURCE_COMPOSITES
    if (record_form(record) == FORM_COMPOSITE) {
        source_corners(unit, record, words);
        target.own_triangles = record_triangles(record);
        target.pairs = target.head + cluster_pairs_offset(target.counts);
    } else
#endif
    {
        target.pairs = load_address(fit_templates(push.templates).at[record.template_index].pairs);
    }
    fit_cluster(target);
}
