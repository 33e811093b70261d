// SPDX-License-Identifier: Apache-2.0
// Counting and emitting items of displaced meshes. What an item emits is written while it is counted already, where a frame has
// room for such drafts: then emitting it is copying it.
#ifndef CLAST_SOURCE_DISPLACED_DRAFT_GLSL
#define CLAST_SOURCE_DISPLACED_DRAFT_GLSL

#include "source/displaced_leaves.glsl"

ARRAY_OF(draft_heads, clast_draft_head, 8)

const uint DISPLACED_DRAFT_MOST = 1u << 18u; // words of a draft
const uint DISPLACED_DRAFT_HEAD = 3u;        // records and words that it has, and its room

shared uint displaced_draft_place;

// About how many words a triangle's leaves and their records take, on the safe side.
uint displaced_draft_words(clast_displaced_triangle triangle)
{
    uint a = min_uint(displaced_factors[displaced_edge_of(triangle, 0u)], 4096u);
    uint b = min_uint(displaced_factors[displaced_edge_of(triangle, 1u)], 4096u);
    uint c = min_uint(displaced_factors[displaced_edge_of(triangle, 2u)], 4096u);
    bool small = a <= PATTERN_SEGMENTS && b <= PATTERN_SEGMENTS && c <= PATTERN_SEGMENTS;
    uint whole = DISPLACED_RECORD_WORDS + 2u;
    uint leaves = (a * b + b * c + c * a) / 72u + 8u;
    return small ? whole : min_uint(leaves * (whole + DISPLACED_SPLIT_WORDS), DISPLACED_DRAFT_MOST);
}

// Where words of a draft lie.
uint64_t displaced_draft_address(unit_reference unit, uint place)
{
    return load_address(unit.of.drafts) + 8ul + 4ul * uint64_t(place);
}

// Takes room for a draft; the walk stays as it is where there is none. Gives where it begins, or CLAST_NONE.
uint displaced_begin_draft(unit_reference unit, clast_displaced_cluster cluster, inout displaced_walk walk)
{
    uint64_t drafts = load_address(unit.of.drafts);
    if (drafts == 0ul) {
        return CLAST_NONE;
    }
    uint lane = group_lane();
    uint own = lane < cluster.triangle_count ? displaced_draft_words(displaced_triangle_of(unit, cluster, lane)) : 0u;
    uint words = min_uint(sum_over_group(own).all + CLUSTER_VERTICES / 2u + 2u, DISPLACED_DRAFT_MOST);
    uint all = words + DISPLACED_DRAFT_HEAD;
    if (lane == 0u) {
        draft_heads head = draft_heads(drafts);
        uint room = head.at[0].room;
        // sums of the few that look at the same time stay far below 2^32
        uint place = head.at[0].taken < room ? atomicAdd(head.at[0].taken, all) : room;
        displaced_draft_place = place < room && all <= room - place ? place : CLAST_NONE;
    }
    barrier();
    uint place = displaced_draft_place;
    if (place != CLAST_NONE) {
        walk.writes = true;
        walk.drafts = true;
        walk.room = words;
        walk.words = displaced_draft_address(unit, place + DISPLACED_DRAFT_HEAD);
    }
    return place;
}

void displaced_end_draft(unit_reference unit, displaced_walk walk, uint place)
{
    if (load_address(unit.of.drafts) == 0ul || group_lane() != 0u) {
        return;
    }
    uints(load_address(unit.of.draft_places)).at[walk.item] = walk.writes ? place : CLAST_NONE;
    if (walk.writes) {
        uints head = uints(displaced_draft_address(unit, place));
        head.at[0] = walk.count.clusters;
        head.at[1] = walk.count.words;
        head.at[2] = walk.room;
    }
}

// Moves a draft to its place.
void displaced_copy_draft(unit_reference unit, uint draft, uint first_vertex, uint first_word, uint64_t words, uint64_t records)
{
    uints from = uints(displaced_draft_address(unit, draft));
    uint record_words = DISPLACED_RECORD_WORDS * from.at[0];
    uint word_count = from.at[1];
    uint end = DISPLACED_DRAFT_HEAD + from.at[2];
    for (uint i = group_lane(); i < word_count; i += GROUP_SIZE) {
        uints(words).at[i] = from.at[DISPLACED_DRAFT_HEAD + i];
    }
    for (uint i = group_lane(); i < record_words; i += GROUP_SIZE) {
        uint member = i % DISPLACED_RECORD_WORDS;
        uint add = member == 2u ? first_vertex : member == 6u ? first_word : 0u; // where these are in a record
        uints(records).at[i] = from.at[end - (i - member) - DISPLACED_RECORD_WORDS + member] + add;
    }
}

// -------------------------------------------------------------------------------------------------------------- duties

clast_source_count source_count(unit_reference unit, uint item)
{
    displaced_walk walk = displaced_begin_walk(unit, item);
    clast_displaced_cluster cluster = displaced_cluster_of(unit, item);
    displaced_find_rates(unit, cluster);
    uint draft = displaced_begin_draft(unit, cluster, walk);
    displaced_walk_item(unit, cluster, walk);
    displaced_end_draft(unit, walk, draft);
    return walk.count;
}

void source_emit(unit_reference unit, uint item, uint first_vertex, uint first_word, uint64_t words, uint64_t records)
{
    if (load_address(unit.of.drafts) != 0ul) {
        uint draft = uints(load_address(unit.of.draft_places)).at[item];
        if (draft != CLAST_NONE) {
            displaced_copy_draft(unit, draft, first_vertex, first_word, words, records);
            return;
        }
    }
    displaced_walk walk = displaced_begin_walk(unit, item);
    walk.writes = true;
    walk.words = words;
    walk.records = records;
    walk.first_vertex = first_vertex;
    walk.first_word = first_word;
    clast_displaced_cluster cluster = displaced_cluster_of(unit, item);
    displaced_find_rates(unit, cluster);
    displaced_walk_item(unit, cluster, walk);
}

#endif
