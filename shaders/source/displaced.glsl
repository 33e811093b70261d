// SPDX-License-Identifier: Apache-2.0
// Displaced meshes: the twin of src/source/displaced.c and what belongs to it.
#ifndef CLAST_SOURCE_DISPLACED_GLSL
#define CLAST_SOURCE_DISPLACED_GLSL

#include "source/displaced_surface.glsl"

#define CLAST_SOURCE_DISPLACED_RESIDENT resident_displaced
#define CLAST_SOURCE_DISPLACED_LOCATE locate_displaced
#define CLAST_SOURCE_DISPLACED_SEGMENTS segments_displaced
#define CLAST_SOURCE_DISPLACED_EVALUATE evaluate_displaced

uint64_t resident_displaced(unit_reference unit, clast_cluster_record record) { return 0ul; }

#ifdef SOURCE_KIND
#define SOURCE_COMPOSITES
#define source_resident resident_displaced
#endif

#ifdef SOURCE_POSES
#include "source/displaced_pose.glsl"
#endif

#ifdef SOURCE_FILLS
#include "source/displaced_fill.glsl"
#endif

#ifdef SOURCE_COUNTS
#include "source/displaced_draft.glsl"
#endif

#endif
