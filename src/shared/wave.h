// SPDX-License-Identifier: Apache-2.0
// The waving sheet: tiles x tiles grids in the plane y = 0 around the origin, each of n x n quads, n the same for all
// tiles of a frame. A vertex is a function of its place in the grid of the whole sheet alone, so that tiles that
// share a border compute the same bits for it; and it is made of + - * only, so that every machine does.
#ifndef CLAST_SHARED_WAVE_H
#define CLAST_SHARED_WAVE_H

#include "shared/records.h"

LIMIT(WAVE_PIXELS, 8u, "pixels that a quad's side covers at rate 1, where it is nearest")
LIMIT(WAVE_ARRAY_SHEET, 0u, "clast_wave_sheet")
LIMIT(WAVE_ARRAY_TEMPLATES, 1u, "templates by n")
LIMIT(WAVE_ARRAYS, 2u, "how many there are")

RECORD(clast_wave_sheet)
{
    uint tiles; // along a side
    uint material;
    float size;
    float amplitude;
    float tile_length;  // size / tiles
    packed2 first_wave; // turns of the first wave per length along x and z
    packed2 second_wave;
    float half_steps[12]; // by n: half a quad's side; [0] is not used
};
RECORD_SIZE(clast_wave_sheet, 84)

// A moment, as turns of each wave in [0, 1): reduced in double precision, so that late times move as smoothly as
// early ones.
RECORD(clast_wave_moment)
{
    float first_turns;
    float second_turns;
};
RECORD_SIZE(clast_wave_moment, 8)

RECORD(clast_wave_height)
{
    float height;
    float slope_x; // of the height
    float slope_z;
};
RECORD_SIZE(clast_wave_height, 12)

// sin(2 pi turns) to 4e-6, by its series on a quarter turn: no machine's own sine is asked.
FN float wave_sine(float turns)
{
    float part = turns - floor1(turns + 0.5f); // [-0.5, 0.5]
    float high = part > 0.25f ? 0.5f - part : part;
    float x = high < -0.25f ? -0.5f - high : high;
    float s = x * x;
    return x * (6.28318531f + s * (-41.3417022f + s * (81.6052493f + s * (-76.7058597f + s * 42.0586940f))));
}

FN float wave_first_phase(clast_wave_sheet sheet, clast_wave_moment moment, float x, float z)
{
    return dot2(load2(sheet.first_wave), vec2(x, z)) - moment.first_turns;
}

FN float wave_second_phase(clast_wave_sheet sheet, clast_wave_moment moment, float x, float z)
{
    return dot2(load2(sheet.second_wave), vec2(x, z)) - moment.second_turns;
}

// The weights add up to one, so that the amplitude bounds the height.
FN float wave_height(clast_wave_sheet sheet, clast_wave_moment moment, float x, float z)
{
    float first = wave_sine(wave_first_phase(sheet, moment, x, z));
    float second = wave_sine(wave_second_phase(sheet, moment, x, z));
    return sheet.amplitude * (0.625f * first + 0.375f * second);
}

// With its slopes, for normals.
FN clast_wave_height wave_height_and_slopes(clast_wave_sheet sheet, clast_wave_moment moment, float x, float z)
{
    float first = 6.28318531f * 0.625f * wave_sine(wave_first_phase(sheet, moment, x, z) + 0.25f);
    float second = 6.28318531f * 0.375f * wave_sine(wave_second_phase(sheet, moment, x, z) + 0.25f);
    vec2 slopes = (load2(sheet.first_wave) * first + load2(sheet.second_wave) * second) * sheet.amplitude;
    clast_wave_height result;
    result.height = wave_height(sheet, moment, x, z);
    result.slope_x = slopes[0];
    result.slope_z = slopes[1];
    return result;
}

// Vertex (column, row) of the whole sheet's grid of (tiles * segments) quads a side. Rows go towards -z, so that the
// grid template's triangles face up.
FN vec3 wave_vertex(clast_wave_sheet sheet, clast_wave_moment moment, uint segments, uint column, uint row)
{
    float side = to_float(sheet.tiles * segments); // at most 1024 * 11: twice that is exact
    float x = (to_float(column * 2u) - side) * sheet.half_steps[segments];
    float z = (side - to_float(row * 2u)) * sheet.half_steps[segments];
    return vec3(x, wave_height(sheet, moment, x, z), z);
}

FN float wave_outside(float coordinate, float half_extent)
{
    return max1(abs1(coordinate) - half_extent, 0.0f);
}

// The n of a frame: the least whose quads are small enough where the sheet's box is nearest to the eye. Decided by
// products of squares, without a quotient or a root.
FN uint wave_segments(clast_wave_sheet sheet, clast_source_view view)
{
    vec3 eye = load3(view.eye);
    float half_size = sheet.size * 0.5f;
    vec3 away = vec3(wave_outside(eye[0], half_size), wave_outside(eye[1], abs1(sheet.amplitude)),
                     wave_outside(eye[2], half_size));
    precise float distance_square = dot3(away, away);
    float share = view.hidden != 0u ? view.hidden_fraction : 1.0f;
    precise float wanted = sheet.tile_length * view.pixels_per_unit * (view.rate * share);
    uint segments = 1u;
    for (; segments < GRID_SEGMENTS; segments++) {
        precise float reach = to_float(segments * WAVE_PIXELS);
        precise bool enough = (reach * reach) * distance_square >= wanted * wanted;
        if (enough) {
            break;
        }
    }
    return segments;
}

// What a tile emits: one grid of n x n quads.
FN clast_source_count wave_count(uint segments)
{
    clast_source_count count;
    count.clusters = 1u;
    count.triangles = 2u * segments * segments;
    count.vertices = (segments + 1u) * (segments + 1u);
    count.words = 0u;
    count.blocks = 0u;
    return count;
}

FN clast_cluster_record wave_record(uint segments, uint template_index, uint unit, uint tile, uint first_vertex,
                                    uint first_word)
{
    clast_source_count count = wave_count(segments);
    clast_cluster_record record;
    record.unit = unit;
    record.template_index = template_index;
    record.first_vertex = first_vertex;
    record.item = tile;
    record.form_and_counts = form_and_counts(FORM_WHOLE, count.triangles, count.vertices);
    record.detail = segments;
    record.first_word = first_word;
    return record;
}

// Where on its tile (0 to 1 each way) a point of a grid's triangle is. Quad q is triangles 2 q: (v00, v10, v11) and 2
// q + 1: (v00, v11, v01).
FN vec2 wave_locate(uint segments, uint triangle, vec2 barycentrics)
{
    uint quad = triangle / 2u;
    vec2 corner = vec2(to_float(quad % segments), to_float(quad / segments));
    float sum = barycentrics[0] + barycentrics[1];
    vec2 inside = triangle % 2u == 0u ? vec2(sum, barycentrics[1]) : vec2(barycentrics[0], sum);
    return (corner + inside) * rough_divide(1.0f, to_float(segments));
}

// The point in the plane of a place on a tile: x and z.
FN vec2 wave_plane(clast_wave_sheet sheet, uint tile, vec2 place)
{
    float x = (to_float(tile % sheet.tiles) + place[0]) * sheet.tile_length - sheet.size * 0.5f;
    float z = sheet.size * 0.5f - (to_float(tile / sheet.tiles) + place[1]) * sheet.tile_length;
    return vec2(x, z);
}

#endif
