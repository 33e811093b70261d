// SPDX-License-Identifier: Apache-2.0
// Drafts: what items emitted while they were counted, so that the pass emit need only move it to its place. Sources for which
// counting is most of the work make them. A draft that finds no room is emitted once more; in a frame whose memory is bounded
// there are none.
#include <string.h>

#include "base/thread.h"
#include "frame/unit.h"

enum {
    RECORD_WORDS = sizeof(clast_cluster_record) / sizeof(uint32_t),
    SCRATCH_RECORDS = 4096, // of an item: those that need more are split so finely that none of this matters
    SCRATCH_WORDS = 32768,
    WORDS_EACH = 256, // of an item, before anything is known
};

static void forget_drafts(clast_context *context, clast_frame_drafts *drafts)
{
    clast_free(context, drafts->places);
    clast_free(context, drafts->words);
    *drafts = (clast_frame_drafts){0};
}

clast_status clast_drafts_begin(clast_frame *frame, clast_frame_unit *unit)
{
    clast_frame_drafts *drafts = &unit->drafts;
    size_t items = unit->unit->item_count, workers = clast_worker_count(frame->context);
    drafts->known = false;
    if (clast_source_of(unit->unit)->draft == NULL || frame->settings.max_bytes != 0) {
        forget_drafts(frame->context, drafts);
        return CLAST_OK;
    }
    size_t wanted = drafts->wanted + drafts->wanted / 8;
    wanted = wanted > WORDS_EACH * items ? wanted : WORDS_EACH * items;
    wanted = wanted < CLAST_NONE ? wanted : CLAST_NONE;
    clast_status status = CLAST_RESERVE(frame->context, drafts->places, drafts->place_capacity, items);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(frame->context, drafts->words, drafts->capacity, wanted);
    }
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(frame->context, frame->draft_scratch, frame->draft_scratch_capacity,
                               workers * (RECORD_WORDS * SCRATCH_RECORDS + SCRATCH_WORDS));
    }
    drafts->known = status == CLAST_OK;
    return status;
}

clast_source_count clast_draft_item(const clast_frame *frame, const clast_frame_unit *unit,
                                    const clast_source_view *view, uint32_t item, uint32_t worker,
                                    atomic_uint_fast64_t *taken)
{
    const clast_frame_drafts *drafts = &unit->drafts;
    uint32_t *scratch = frame->draft_scratch + worker * (size_t)(RECORD_WORDS * SCRATCH_RECORDS + SCRATCH_WORDS);
    clast_source_draft draft = {
        .records = (clast_cluster_record *)(void *)scratch,
        .words = scratch + RECORD_WORDS * SCRATCH_RECORDS,
        .record_room = SCRATCH_RECORDS,
        .word_room = SCRATCH_WORDS,
    };
    clast_source_count count = clast_source_of(unit->unit)->draft(unit->unit, &unit->pose, view, item, &draft);
    drafts->places[item] = CLAST_NONE;
    if (count.clusters <= SCRATCH_RECORDS && count.words <= SCRATCH_WORDS) {
        size_t record_words = RECORD_WORDS * (size_t)count.clusters;
        uint64_t place = atomic_fetch_add(taken, record_words + count.words); // any order will do
        if (place + record_words + count.words <= drafts->capacity) {
            drafts->places[item] = (uint32_t)place;
            memcpy(drafts->words + place, draft.records, record_words * sizeof *scratch);
            memcpy(drafts->words + place + record_words, draft.words, count.words * sizeof *scratch);
        }
    }
    return count;
}

bool clast_draft_take(const clast_frame_unit *unit, uint32_t item, uint32_t first_vertex, uint32_t first_word,
                      uint32_t word_count, clast_cluster_record *records, uint32_t record_count)
{
    const clast_frame_drafts *drafts = &unit->drafts;
    if (!drafts->known || drafts->places[item] == CLAST_NONE) {
        return false;
    }
    const uint32_t *from = drafts->words + drafts->places[item];
    memcpy(records, from, record_count * sizeof *records);
    for (uint32_t i = 0; i < record_count; i++) {
        records[i].first_vertex += first_vertex;
        records[i].first_word += first_word;
    }
    memcpy(unit->words + first_word, from + RECORD_WORDS * (size_t)record_count, word_count * sizeof *from);
    return true;
}
