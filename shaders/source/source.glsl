// SPDX-License-Identifier: Apache-2.0
// What kernels know of sources: the twin of src/source/source.h. A kind is a file of this folder that gives its duties;
// source/sources.glsl has all of them, and kernels that are compiled once for each kind (NAME.source.comp) include
// "source_kind.glsl", which is the kind's file.
//
// Duties of a single invocation have the kind's name in theirs; the kind's file names them by macros, for the switches of
// source/sources.glsl:
//
//   CLAST_SOURCE_KIND_RESIDENT  uint64_t resident_kind(unit_reference unit, clast_cluster_record record)
//       Where the positions of a record lie already; 0 where they are filled.
//   CLAST_SOURCE_KIND_LOCATE    clast_surface_point locate_kind(unit_reference unit, clast_cluster_record record,
//                                                               uint64_t words, uint triangle, vec2 barycentrics)
//   CLAST_SOURCE_KIND_SEGMENTS  float segments_kind(unit_reference unit, clast_source_view view, clast_cluster_record record,
//                                                   uint64_t words, uint triangle, vec2 barycentrics)
//       0 where the kind does not adapt.
//   CLAST_SOURCE_KIND_EVALUATE  source_surface evaluate_kind(unit_reference unit, clast_surface_point point)
//
// Duties of a work group stand within #ifdef SOURCE_KIND. All SOURCE_GROUP invocations of the group call them together, with
// equal arguments; they may use shared memory and barriers. There, source_resident is a macro too, for resident_kind. Or, where
// the file says SOURCE_SINGLE_ITEMS, source_count and source_emit are called by single invocations, each for an item of its own,
// and use neither.
//
//   clast_source_count source_count(unit_reference unit, uint item)
//       The same bits as the C function. All invocations get the result.
//   void source_emit(unit_reference unit, uint item, uint first_vertex, uint first_word, uint64_t words, uint64_t records)
//       `words` and `records` are where the first of the item's are written.
//
// And of a subgroup that has a cluster (accel/lanes.glsl). All of its invocations call them together:
//
//   void source_fill(unit_reference unit, clast_cluster_record record, uint64_t words)
//       Sets the cluster's points, and ends with cluster_barrier().
//   void source_corners(unit_reference unit, clast_cluster_record record, uint64_t words)
//       Of composites: sets the cluster's corners, and ends with cluster_barrier(). With SOURCE_COMPOSITES only.
//
// And of a single invocation, for kinds that have a posed array (clast_source.posed_array), which say so by
// SOURCE_HAS_POSED_ARRAY, within #ifdef SOURCE_POSES:
//
//   void source_pose(unit_reference unit, uint number, uint64_t to)
//       Writes an element of the array that stands in its place while the pose lasts.
//
// A kernel says which of them it calls before it includes the kind's file, so that no others take shared memory:
// SOURCE_COUNTS for source_count and source_emit, SOURCE_FILLS for source_fill and source_corners. The latter follows the
// former for the same record.
//
// `words` is where the first word of the record lies (unit.words + 4 * record.first_word), except in source_emit.
// The view is unit.of.view, the pose is in unit.of too.
#ifndef CLAST_SOURCE_GLSL
#define CLAST_SOURCE_GLSL

#include "gpu.glsl"
#include "shared/device.h"
#include "shared/texture_filter.h"

// A unit, where it lies: unit.of.kind. Records of its size are not handed about.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer unit_reference { clast_device_unit of; };
ARRAY_OF(item_counts, clast_source_count, 4)
ARRAY_OF(device_heights, clast_device_height, 4)
ARRAY_OF(device_spans, clast_device_span, 4)
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer frame_reference { clast_device_frame of; };

// The unit of a number, in the array of a frame's.
unit_reference unit_at(uint64_t units, uint number)
{
    return unit_reference(units) + number;
}

uint64_t array_of(unit_reference unit, uint number) { return load_address(unit.of.arrays[number]); }

// Where the words of a record begin.
uint64_t words_of(unit_reference unit, clast_cluster_record record)
{
    return load_address(unit.of.words) + 4ul * uint64_t(record.first_word);
}

// What a hit is made of, in the unit's own space: clast_source_surface.
struct source_surface
{
    vec3 position;
    vec3 geometric_normal; // not normalised, counter-clockwise side
    vec3 normal;           // interpolated, not normalised; the geometric one where the geometry is flat
    vec3 tangent;          // not normalised; zero where there is none
    float bitangent_sign;
    vec2 coordinates[2];
    vec4 colour;
    clast_texture_gradient gradients[2]; // of these; zero where they do not tell
    float curvature;                     // mesh_curvature(); 0 where it is not known
    uint material;
};

#ifdef SOURCE_FILLS
#include "accel/lanes.glsl"

// Three vertices of each triangle of a composite, 8 bits each.
shared uint cluster_corner_words[CLUSTERS_TOGETHER * TEMPLATE_TRIANGLES];
uint cluster_corners(uint triangle) { return cluster_corner_words[cluster_slot() * TEMPLATE_TRIANGLES + triangle]; }
void set_cluster_corners(uint triangle, uint corners)
{
    cluster_corner_words[cluster_slot() * TEMPLATE_TRIANGLES + triangle] = corners;
}
#endif

#endif
