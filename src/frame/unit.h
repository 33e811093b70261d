// SPDX-License-Identifier: Apache-2.0
// What the CPU's passes do with a single unit.
#ifndef CLAST_FRAME_UNIT_H
#define CLAST_FRAME_UNIT_H

#include <stdatomic.h>

#include "frame/backend.h"

// How many elements a task takes: few where there are few of them, as each may be much work, and at most `most`.
static inline size_t clast_frame_grain(size_t count, size_t most)
{
    size_t grain = count / 128;
    return grain < 1 ? 1 : grain < most ? grain : most;
}

// What must be made anew for this frame at a rate (count.c).
clast_change clast_unit_change(const clast_frame *frame, const clast_frame_unit *unit, float rate);
// What the unit needs at a rate. Units whose records stay as they are need not be asked; others keep what each item needs.
clast_status clast_unit_count(clast_frame *frame, clast_frame_unit *unit, float rate, clast_frame_need *need);
// Finds what each used unit needs at the least.
clast_status clast_frame_find_minima(clast_frame *frame);
// What all used units need at a rate, and the instances.
clast_status clast_frame_count(clast_frame *frame, float rate, clast_frame_need *need);
clast_frame_need clast_frame_instance_need(const clast_frame *frame);
void clast_frame_add_need(clast_frame_need *sum, const clast_frame_need *need);
// Finds the minimum of the frame, and refuses budgets below it (fit.c).
clast_status clast_frame_check_minimum(clast_frame *frame);
// Before a unit is counted: whether its items are drafted, and room for that (draft.c).
clast_status clast_drafts_begin(clast_frame *frame, clast_frame_unit *unit);
// Counts an item and keeps what it emits, where there is room; `taken` counts the words of all.
clast_source_count clast_draft_item(const clast_frame *frame, const clast_frame_unit *unit,
                                    const clast_source_view *view, uint32_t item, uint32_t worker,
                                    atomic_uint_fast64_t *taken);
// Emits what was kept; false where nothing was.
bool clast_draft_take(const clast_frame_unit *unit, uint32_t item, uint32_t first_vertex, uint32_t first_word,
                      uint32_t word_count, clast_cluster_record *records, uint32_t record_count);
// Decides that the unit has this rate in this frame. Units of the frame have been counted at it.
clast_status clast_unit_settle(clast_frame *frame, clast_frame_unit *unit, float rate);
// Writes the records of a unit whose topology changes (emit.c).
clast_status clast_unit_emit(clast_frame *frame, clast_frame_unit *unit);
// Writes the vertices of a unit that are not resident, and fits its clusters to them (build.c). To `fit_milliseconds` is
// added how long the latter took.
clast_status clast_unit_fill(clast_frame *frame, clast_frame_unit *unit, double *fit_milliseconds);
// Makes the clusters of a unit whose vertices are all resident, or fits them anew.
clast_status clast_unit_refit(clast_frame *frame, clast_frame_unit *unit);
// Builds the tree. What the passes before made is known from now on.
clast_status clast_unit_build(clast_frame_unit *unit);
// The same, of a unit whose tree is somewhere else.
void clast_unit_note_made(clast_frame_unit *unit);
// Adds up what the frame's units and instances have come to (emit.c).
void clast_frame_sum_up(clast_frame *frame);
// Frees all that was made of a unit.
void clast_unit_free(clast_context *context, clast_frame_unit *unit);

// Finds from where each unit is adapted, of which instances the camera sees (classify.c).
clast_status clast_frame_view_units(clast_frame *frame);
// Frees what the pass occlude made.
void clast_frame_free_coarse(clast_frame *frame);

#endif
