// SPDX-License-Identifier: Apache-2.0
// A frame as it lies in a device's memory: what kernels are handed beside their own records. Addresses are of the device's
// memory; 0 is nothing.
//
// The processor keeps the frame (frame/frame.h) and writes these records anew for each frame; what they point to stays as long
// as nothing changes it.
#ifndef CLAST_SHARED_DEVICE_H
#define CLAST_SHARED_DEVICE_H

#include "shared/displacement.h"
#include "shared/records.h"

LIMIT(SOURCE_ARRAYS, 32u, "most arrays of cooked data of a unit")
LIMIT(SOURCE_GROUP, 128u, "invocations of a work group that does a duty of a source together")

// The arrays of sources that are made of a triangle mesh begin with the mesh's own; what it does not have is at 0.
LIMIT(MESH_ARRAY_INDICES, 0u, "three vertices of each triangle")
LIMIT(MESH_ARRAY_MATERIAL, 1u, "one number: of all triangles, where there is no array of them; CLAST_NONE is the first")
LIMIT(MESH_ARRAY_MATERIALS, 2u, "of each triangle")
LIMIT(MESH_ARRAY_POSITIONS, 3u, "of each vertex, three floats; in place of these, a pose's")
LIMIT(MESH_ARRAY_NORMALS, 4u, "three floats; likewise")
LIMIT(MESH_ARRAY_TANGENTS, 5u, "four floats; likewise")
LIMIT(MESH_ARRAY_COORDINATES_0, 6u, "two floats")
LIMIT(MESH_ARRAY_COORDINATES_1, 7u, "two floats")
LIMIT(MESH_ARRAY_COLOURS, 8u, "four floats")
LIMIT(MESH_ARRAYS, 9u, "where a kind's own arrays begin")

// A displacement map.
RECORD(clast_device_height)
{
    packed_address texels; // of 16 or 32 bits, by map.is_float: map.firsts[] count them
    clast_height_map map;
};
RECORD_SIZE(clast_device_height, 220)

// A unit in a frame.
RECORD(clast_device_unit)
{
    packed_address arrays[SOURCE_ARRAYS]; // of cooked data: the kind says which is which
    packed_address heights;               // clast_device_height, by the source's numbers of maps
    // The pose.
    packed_address positions; // in place of the mesh's, as are the next two; 0 where nothing moves them
    packed_address normals;
    packed_address tangents;
    packed4 moment;           // the kind's own
    float displacement_scale; // times what the materials say
    // What the frame makes of it.
    packed_address item_counts; // clast_source_count of each item; once added up, the sums before each, from all units on
    packed_address drafts;      // clast_draft_head, and words: where items emit while they are counted; 0: nowhere
    packed_address draft_places; // of each item: where its draft begins among these, CLAST_NONE for none
    packed_address sums;        // clast_unit_sums
    packed_address records;     // clast_cluster_record
    packed_address words;       // of the records
    packed_address vertices;    // packed3; records with resident positions have none here
    packed_address spaces;      // CLUSTER_UNITs of each record's cluster; once added up, those before it, from all units on
    packed_address clusters;    // shared/cluster.h tells how these lie
    packed_address boxes;       // clast_box of each cluster, not quantised
    packed_address places;      // where each begins in `clusters`, in CLUSTER_UNITs
    packed_address tree;
    clast_source_view view;
    uint kind;         // CLAST_SOURCE_
    uint number;       // of the geometry
    uint item_count;
    uint record_count;
    uint filtered;     // 1 where a material of it is not opaque
    clast_box bounds;  // of the pose, in the unit's own space
};
RECORD_SIZE(clast_device_unit, 8 * 32 + 4 * 8 + 20 + 12 * 8 + 144 + 20 + 24)

// Room for drafts, which items take as they come: where they end up follows from sums over counts, not from this.
RECORD(clast_draft_head)
{
    uint taken; // words; may be more than there are
    uint room;  // that there are, after this
};
RECORD_SIZE(clast_draft_head, 8)

// 64-bit sums over a unit, lower halves first: over its items, by the members of clast_source_count, and over its records.
LIMIT(UNIT_SUMS_COUNTS, 5u, "that are over items")
RECORD(clast_unit_sums)
{
    packed_address counts[UNIT_SUMS_COUNTS];
    packed_address cluster_vertices; // of all records, resident ones too
    packed_address cluster_fill;     // of each record the larger of its triangles and its vertices
};
RECORD_SIZE(clast_unit_sums, 56)

LIMIT(INSTANCE_HIDDEN, 1u, "the camera cannot see it; rays still do")
LIMIT(INSTANCE_OCCLUDED, 2u, "and that is since it lies behind others")

// In the order of the frame's instances.
RECORD(clast_device_instance)
{
    clast_transform to_world;
    clast_transform to_object;
    clast_box bounds;    // world space
    uint unit;           // into clast_device_frame.units
    uint scene_instance; // what hits are told by
    uint state;          // INSTANCE_ bits
};
RECORD_SIZE(clast_device_instance, 132)

// The maps of an instance, as columns.
RECORD(clast_device_map)
{
    packed3 to_object[3];
    packed3 to_world[3];
    packed3 origin;
    float condition; // of the map; 0 where it has no inverse
    uint unit;
    uint id;    // what hits report
    uint flags; // PLACEMENT_MIRRORED or 0
};
RECORD_SIZE(clast_device_map, 100)

RECORD(clast_device_frame)
{
    packed_address units;     // clast_device_unit, by geometry number; those that are not used have no records
    packed_address instances; // clast_device_instance
    packed_address instance_of; // by the scene's instance: the frame's; CLAST_NONE where it is not in the frame
    packed_address tree;      // over the instances
    packed_address templates; // shared/cluster.h
    uint unit_count;
    uint instance_count;
    uint scene_instance_count;
    clast_camera camera;
    clast_camera rate_camera;
};
RECORD_SIZE(clast_device_frame, 5 * 8 + 12 + 2 * 76)

// Work of one dispatch over parts of several units: groups `first` up to the next span's are those of a unit. The list ends
// with a span that tells how many groups there are.
RECORD(clast_device_span)
{
    uint first;
    uint unit; // into clast_device_frame.units
};
RECORD_SIZE(clast_device_span, 8)

#endif
