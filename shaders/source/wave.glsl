// SPDX-License-Identifier: Apache-2.0
// The waving sheet: the twin of src/source/wave.c.
#ifndef CLAST_SOURCE_WAVE_GLSL
#define CLAST_SOURCE_WAVE_GLSL

#include "shared/wave.h"
#include "source/source.glsl"

#define CLAST_SOURCE_WAVE_RESIDENT resident_wave
#define CLAST_SOURCE_WAVE_LOCATE locate_wave
#define CLAST_SOURCE_WAVE_SEGMENTS segments_wave
#define CLAST_SOURCE_WAVE_EVALUATE evaluate_wave

ARRAY_OF(wave_sheets, clast_wave_sheet, 4)

clast_wave_sheet wave_sheet_of(unit_reference unit)
{
    return wave_sheets(array_of(unit, WAVE_ARRAY_SHEET)).at[0];
}

clast_wave_moment wave_moment_of(unit_reference unit)
{
    vec4 turns = load4(unit.of.moment);
    clast_wave_moment moment;
    moment.first_turns = turns[0];
    moment.second_turns = turns[1];
    return moment;
}

uint64_t resident_wave(unit_reference unit, clast_cluster_record record) { return 0ul; }

clast_surface_point locate_wave(unit_reference unit, clast_cluster_record record, uint64_t words, uint triangle,
                                vec2 barycentrics)
{
    clast_surface_point point;
    point.primitive = record.item;
    point.coordinates = store2(wave_locate(record.detail, triangle, barycentrics));
    point.level = 0.0f;
    return point;
}

// All edges have as many.
float segments_wave(unit_reference unit, clast_source_view view, clast_cluster_record record, uint64_t words,
                    uint triangle, vec2 barycentrics)
{
    return to_float(wave_segments(wave_sheet_of(unit), view));
}

source_surface evaluate_wave(unit_reference unit, clast_surface_point point)
{
    clast_wave_sheet sheet = wave_sheet_of(unit);
    vec2 plane = wave_plane(sheet, point.primitive, load2(point.coordinates));
    clast_wave_height height = wave_height_and_slopes(sheet, wave_moment_of(unit), plane[0], plane[1]);
    float scale = rough_divide(1.0f, sheet.size);
    vec2 coordinates = plane * scale + splat2(0.5f);
    source_surface surface;
    surface.position = vec3(plane[0], height.height, plane[1]);
    surface.geometric_normal = vec3(-height.slope_x, 1.0f, -height.slope_z);
    surface.normal = surface.geometric_normal;
    surface.tangent = vec3(1.0f, height.slope_x, 0.0f);
    surface.bitangent_sign = 1.0f;
    surface.coordinates[0] = coordinates;
    surface.coordinates[1] = coordinates;
    surface.colour = vec4(1.0f, 1.0f, 1.0f, 1.0f);
    surface.gradients[0].u = store3(vec3(scale, 0.0f, 0.0f));
    surface.gradients[0].v = store3(vec3(0.0f, 0.0f, scale));
    surface.gradients[1] = surface.gradients[0];
    surface.curvature = 0.0f;
    surface.material = sheet.material;
    return surface;
}

#ifdef SOURCE_KIND
#define SOURCE_SINGLE_ITEMS
#define source_resident resident_wave

clast_source_count source_count(unit_reference unit, uint item)
{
    return wave_count(wave_segments(wave_sheet_of(unit), unit.of.view));
}

void source_emit(unit_reference unit, uint item, uint first_vertex, uint first_word, uint64_t words, uint64_t records)
{
    uint segments = wave_segments(wave_sheet_of(unit), unit.of.view);
    uint template_index = uints(array_of(unit, WAVE_ARRAY_TEMPLATES)).at[segments];
    cluster_records(records).at[0] =
        wave_record(segments, template_index, unit.of.number, item, first_vertex, first_word);
}
#endif

#ifdef SOURCE_FILLS
void source_fill(unit_reference unit, clast_cluster_record record, uint64_t words)
{
    clast_wave_sheet sheet = wave_sheet_of(unit);
    clast_wave_moment moment = wave_moment_of(unit);
    uint segments = record.detail;
    uint column = record.item % sheet.tiles * segments;
    uint row = record.item / sheet.tiles * segments;
    uint side = segments + 1u;
    for (uint i = cluster_lane(); i < side * side; i += LANES) {
        set_cluster_point(i, wave_vertex(sheet, moment, segments, column + i % side, row + i / side));
    }
    cluster_barrier();
}
#endif

#endif
