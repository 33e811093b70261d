// SPDX-License-Identifier: Apache-2.0
// All kinds of sources at once, for kernels that meet any of them: the duties of a single invocation.
#ifndef CLAST_SOURCES_GLSL
#define CLAST_SOURCES_GLSL

#include "source/clusters.glsl"
#include "source/displaced.glsl"
#include "source/wave.glsl"

#define RESIDENT_CASE(name, value, text) case value: return name##_RESIDENT(unit, record);
#define LOCATE_CASE(name, value, text) case value: return name##_LOCATE(unit, record, words, triangle, barycentrics);
#define SEGMENTS_CASE(name, value, text) \
    case value: return name##_SEGMENTS(unit, view, record, words, triangle, barycentrics);
#define EVALUATE_CASE(name, value, text) case value: return name##_EVALUATE(unit, point);

uint64_t source_resident(unit_reference unit, clast_cluster_record record)
{
    switch (unit.of.kind) {
        CLAST_SOURCE_LIST(RESIDENT_CASE)
    }
    return 0ul;
}

clast_surface_point source_locate(unit_reference unit, clast_cluster_record record, uint64_t words, uint triangle,
                                  vec2 barycentrics)
{
    switch (unit.of.kind) {
        CLAST_SOURCE_LIST(LOCATE_CASE)
    }
    clast_surface_point nowhere;
    nowhere.primitive = 0u;
    nowhere.coordinates = store2(barycentrics);
    nowhere.level = 0.0f;
    return nowhere;
}

float source_segments(unit_reference unit, clast_source_view view, clast_cluster_record record, uint64_t words,
                      uint triangle, vec2 barycentrics)
{
    switch (unit.of.kind) {
        CLAST_SOURCE_LIST(SEGMENTS_CASE)
    }
    return 0.0f;
}

source_surface source_evaluate(unit_reference unit, clast_surface_point point)
{
    switch (unit.of.kind) {
        CLAST_SOURCE_LIST(EVALUATE_CASE)
    }
    source_surface nothing;
    nothing.position = nothing.geometric_normal = nothing.normal = nothing.tangent = splat3(0.0f);
    nothing.coordinates[0] = nothing.coordinates[1] = splat2(0.0f);
    nothing.colour = vec4(1.0f, 1.0f, 1.0f, 1.0f);
    nothing.bitangent_sign = 1.0f;
    nothing.gradients[0] = nothing.gradients[1] = no_texture_gradient();
    nothing.curvature = 0.0f;
    nothing.material = 0u;
    return nothing;
}

#endif
