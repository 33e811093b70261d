// SPDX-License-Identifier: Apache-2.0
// Leaves of displaced meshes, and how they are packed into records, by a work group: the twin of src/source/displaced_emit.c.
// There, leaves go one after the other into a record until one does not fit. Here, all that fit go at once, then all that go
// on their own at once: the group takes a step for each such run, not for each leaf.
#ifndef CLAST_SOURCE_DISPLACED_LEAVES_GLSL
#define CLAST_SOURCE_DISPLACED_LEAVES_GLSL

#include "source/displaced_split.glsl"

// Of a vertex or an edge of the cluster, the first leaf that has it in the latest record that has it: the lower, the later
// the record, and the earlier the leaf in it.
shared uint displaced_taken[CLUSTER_VERTICES + DISPLACED_EDGES];
const uint DISPLACED_SERIALS = 0x1ffffffu; // records that there can be: each but the last two has 43 triangles at least
const uint DISPLACED_SERIAL_SHIFT = 7u;

// Of the leaves that are packed: triangles, vertices, number of the pattern, and whether it is a part of a split triangle.
shared uint displaced_leaves[DISPLACED_LIST];
shared uint displaced_leaf_sums[DISPLACED_LIST];   // triangles up to and with each, and those that are split above 16 bits
shared uint displaced_vertex_sums[DISPLACED_LIST]; // vertices

// The open record, where it is written: words of its leaves, and of those that are split.
shared uint displaced_open[DISPLACED_RECORD_TRIANGLES * (1u + DISPLACED_SPLIT_WORDS)];

// Counting and emitting are one walk. A count may write too, into the room of a draft (displaced_draft.glsl): words from its
// beginning, records from its end, as long as both fit.
struct displaced_walk
{
    bool writes;
    bool drafts;
    uint room; // words of a draft
    uint64_t words, records;
    uint item, first_vertex, first_word, unit_number, first_pattern;
    clast_source_count count; // of what is closed
    // the open record
    uint leaf_count, triangle_count, vertex_count, split_count, serial;
    uint lone; // displaced_leaves[] of its first
};

uint displaced_leaf_triangles(uint leaf) { return leaf & 255u; }
uint displaced_leaf_vertices(uint leaf) { return leaf >> 8u & 255u; }
uint displaced_leaf_pattern(uint leaf) { return leaf >> 16u & 511u; }

// A leaf as one invocation has it.
struct displaced_own_leaf
{
    uint word; // displaced_leaf_word(), without its first triangle
    uint corners[3], edges[3], within[3]; // of the cluster; points within the edges
    uint weights[3], levels[3];
    uint triangles, vertices, pattern;
    bool split;
};

displaced_own_leaf displaced_leaf_of(unit_reference unit, clast_displaced_cluster cluster, displaced_part part)
{
    displaced_own_leaf leaf;
    clast_displaced_triangle triangle = displaced_triangle_of(unit, cluster, part.triangle);
    uint factors[3];
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        factors[k] = min_uint(part.factors[k], PATTERN_SEGMENTS);
        leaf.corners[k] = displaced_corner(triangle, k);
        leaf.edges[k] = CLUSTER_VERTICES + displaced_edge_of(triangle, k);
        leaf.within[k] = factors[k] - 1u;
        leaf.weights[k] = part.corners[k];
        leaf.levels[k] = part.levels[k];
    }
    uint packed = pattern_factors(factors[0], factors[1], factors[2]);
    leaf.pattern = pattern_use(packed).number;
    clast_pattern pattern = displaced_pattern_at(unit, leaf.pattern);
    leaf.triangles = pattern_triangles(pattern);
    leaf.vertices = pattern_vertices(pattern);
    leaf.split = part.depth != 0u;
    leaf.word = displaced_leaf_word(part.triangle, packed, leaf.split, 0u);
    return leaf;
}

// ------------------------------------------------------------------------------------------------------------- writing

const uint DISPLACED_RECORD_WORDS = 7u; // of clast_cluster_record

void displaced_write_record(displaced_walk walk, uint number, uint form, uint template_index, uint triangles,
                            uint vertices, uint leaves, uint first_vertex, uint first_word)
{
    clast_cluster_record record;
    record.unit = walk.unit_number;
    record.template_index = template_index;
    record.first_vertex = walk.first_vertex + first_vertex;
    record.item = walk.item;
    record.form_and_counts = form_and_counts(form, triangles, vertices);
    record.detail = leaves;
    record.first_word = walk.first_word + first_word;
    uint64_t address = walk.drafts ? walk.words + 4ul * uint64_t(walk.room - DISPLACED_RECORD_WORDS * (number + 1u))
                                   : walk.records + 28ul * uint64_t(number);
    cluster_records(address).at[0] = record;
}

// Whether the walk writes so many more records and words; a draft that has no room for them is given up.
bool displaced_may_write(inout displaced_walk walk, uint records, uint words)
{
    bool fits = walk.count.words + words + DISPLACED_RECORD_WORDS * (walk.count.clusters + records) <= walk.room;
    walk.writes = walk.writes && (!walk.drafts || fits);
    return walk.writes;
}

void displaced_write_split(uint64_t to, displaced_own_leaf leaf)
{
    uints words = uints(to);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        words.at[k] = leaf.weights[k];
    }
    words.at[3] = leaf.levels[0] | leaf.levels[1] << 16u;
    words.at[4] = leaf.levels[2];
}

// Writes what is open: one leaf as a pattern, several as a composite.
void displaced_close(inout displaced_walk walk)
{
    if (walk.leaf_count == 0u) {
        return;
    }
    bool alone = walk.leaf_count == 1u;
    uint vertices = alone ? displaced_leaf_vertices(walk.lone) : walk.vertex_count;
    uint split_words = walk.split_count * DISPLACED_SPLIT_WORDS;
    if (displaced_may_write(walk, 1u, 1u + walk.leaf_count + split_words)) {
        barrier(); // what is open has been written
        uint lane = group_lane();
        uints words = uints(walk.words + 4ul * uint64_t(walk.count.words));
        if (lane == 0u) {
            displaced_write_record(walk, walk.count.clusters, alone ? FORM_WHOLE : FORM_COMPOSITE,
                                   alone ? walk.first_pattern + displaced_leaf_pattern(walk.lone) : CLAST_NONE,
                                   walk.triangle_count, vertices, walk.leaf_count, walk.count.vertices, walk.count.words);
            words.at[0] = walk.count.words; // the item's first word is so far back
        }
        for (uint i = lane; i < walk.leaf_count; i += GROUP_SIZE) {
            words.at[1u + i] = displaced_open[i];
        }
        for (uint i = lane; i < split_words; i += GROUP_SIZE) {
            words.at[1u + walk.leaf_count + i] = displaced_open[DISPLACED_RECORD_TRIANGLES + i];
        }
        barrier(); // and can be written over
    }
    walk.count.clusters++;
    walk.count.triangles += walk.triangle_count;
    walk.count.vertices += vertices;
    walk.count.words += 1u + walk.leaf_count + split_words;
    walk.count.blocks += alone ? 0u : (walk.triangle_count + BLOCK_TRIANGLES - 1u) / BLOCK_TRIANGLES;
    walk.leaf_count = 0u;
    walk.triangle_count = 0u;
    walk.vertex_count = 0u;
    walk.split_count = 0u;
    walk.serial++;
}

// Sums over the leaves before one.
uint displaced_sum_before(uint leaf) { return leaf == 0u ? 0u : displaced_leaf_sums[leaf - 1u]; }
uint displaced_vertices_before(uint leaf) { return leaf == 0u ? 0u : displaced_vertex_sums[leaf - 1u]; }

// Writes the leaves from `first` up to `end`, each as a record of its own.
void displaced_write_alone(inout displaced_walk walk, displaced_own_leaf leaf, uint first, uint end)
{
    uint sum = displaced_sum_before(first);
    uint vertices = displaced_vertices_before(first);
    uint lane = group_lane();
    uint all = displaced_leaf_sums[end - 1u] - sum;
    uint all_words = 2u * (end - first) + DISPLACED_SPLIT_WORDS * (all >> 16u);
    if (displaced_may_write(walk, end - first, all_words) && lane >= first && lane < end) {
        uint before = displaced_sum_before(lane) - sum;
        uint first_word = walk.count.words + 2u * (lane - first) + DISPLACED_SPLIT_WORDS * (before >> 16u);
        uint first_vertex = walk.count.vertices + displaced_vertices_before(lane) - vertices;
        displaced_write_record(walk, walk.count.clusters + lane - first, FORM_WHOLE, walk.first_pattern + leaf.pattern,
                               leaf.triangles, leaf.vertices, 1u, first_vertex, first_word);
        uints words = uints(walk.words + 4ul * uint64_t(first_word));
        words.at[0] = first_word;
        words.at[1] = leaf.word;
        if (leaf.split) {
            displaced_write_split(uint64_t(words) + 8ul, leaf);
        }
    }
    walk.count.clusters += end - first;
    walk.count.triangles += all & 65535u;
    walk.count.vertices += displaced_vertex_sums[end - 1u] - vertices;
    walk.count.words += all_words;
}

// ------------------------------------------------------------------------------------------------------------- packing

// How many of a leaf's vertices the record does not have yet. It has marked all it has by `key`.
uint displaced_fresh_vertices(displaced_own_leaf leaf, uint key)
{
    uint fresh = leaf.vertices;
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        bool corner_again = false; // a triangle without area may have one twice
        bool edge_again = false;
        [[unroll]] for (uint j = 0u; j < k; j++) {
            corner_again = corner_again || leaf.corners[j] == leaf.corners[k];
            edge_again = edge_again || leaf.edges[j] == leaf.edges[k];
        }
        fresh -= corner_again || displaced_taken[leaf.corners[k]] < key ? 1u : 0u;
        fresh -= edge_again || displaced_taken[leaf.edges[k]] < key ? leaf.within[k] : 0u;
    }
    return fresh;
}

void displaced_mark(displaced_own_leaf leaf, uint key)
{
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        atomicMin(displaced_taken[leaf.corners[k]], key);
        atomicMin(displaced_taken[leaf.edges[k]], key);
    }
}

void displaced_unmark(displaced_own_leaf leaf, uint key)
{
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
        atomicCompSwap(displaced_taken[leaf.corners[k]], key, 0xffffffffu);
        atomicCompSwap(displaced_taken[leaf.edges[k]], key, 0xffffffffu);
    }
}

// Adds the leaves from `first` up to `end`, which have no more triangles than fit, to the open record, as long as their
// vertices fit: corners and points within edges that the record has already cost nothing. Gives where it stopped.
uint displaced_add_leaves(inout displaced_walk walk, displaced_own_leaf leaf, uint first, uint end)
{
    uint lane = group_lane();
    uint place = walk.leaf_count + lane - first;
    uint key = (DISPLACED_SERIALS - walk.serial) << DISPLACED_SERIAL_SHIFT | place;
    bool mine = lane >= first && lane < end;
    if (mine && !leaf.split) {
        displaced_mark(leaf, key);
    }
    barrier();
    uint fresh = 0u;
    if (mine) {
        fresh = leaf.split ? leaf.vertices : displaced_fresh_vertices(leaf, key);
    }
    group_sum sum = sum_over_group(fresh);
    uint stop = end;
    if (walk.vertex_count + sum.all + PATTERN_VERTICES > TEMPLATE_VERTICES) {
        bool over = mine && walk.vertex_count + sum.before + leaf.vertices > TEMPLATE_VERTICES;
        stop = min_uint(displaced_lowest(over), end);
        mine = mine && lane < stop;
        if (lane >= stop && lane < end && !leaf.split) {
            displaced_unmark(leaf, key);
        }
        sum.all = sum_over_group(mine ? fresh : 0u).all;
    }
    uint before = displaced_sum_before(first);
    if (walk.writes && mine) {
        uint own = displaced_sum_before(lane) - before;
        uint first_triangle = walk.triangle_count + (own & 65535u);
        displaced_open[place] = leaf.word | first_triangle << DISPLACED_LEAF_FIRST_BIT;
        if (leaf.split) {
            uint to = DISPLACED_RECORD_TRIANGLES + (walk.split_count + (own >> 16u)) * DISPLACED_SPLIT_WORDS;
            [[unroll]] for (uint k = 0u; k < 3u; k++) {
                displaced_open[to + k] = leaf.weights[k];
            }
            displaced_open[to + 3u] = leaf.levels[0] | leaf.levels[1] << 16u;
            displaced_open[to + 4u] = leaf.levels[2];
        }
    }
    if (stop > first) {
        uint all = displaced_leaf_sums[stop - 1u] - before;
        walk.lone = walk.leaf_count == 0u ? displaced_leaves[first] : walk.lone;
        walk.leaf_count += stop - first;
        walk.triangle_count += all & 65535u;
        walk.split_count += all >> 16u;
        walk.vertex_count += sum.all;
    }
    return stop;
}

// The first leaf from `first` on with which the open record would have too many triangles.
uint displaced_first_too_many(displaced_walk walk, uint first, uint count)
{
    uint room = DISPLACED_RECORD_TRIANGLES - walk.triangle_count + (displaced_sum_before(first) & 65535u);
    uint low = first;
    uint high = count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        bool fits = (displaced_leaf_sums[middle] & 65535u) <= room;
        low = fits ? middle + 1u : low;
        high = fits ? high : middle;
    }
    return low;
}

// Packs `count` leaves of a list. What does not fit into the open record goes on its own where it is the larger of the two;
// else the record does, and the leaf begins another.
void displaced_pack(unit_reference unit, clast_displaced_cluster cluster, inout displaced_walk walk, uint list, uint first,
                    uint count)
{
    uint lane = group_lane();
    displaced_own_leaf leaf;
    leaf.triangles = 0u;
    leaf.vertices = 0u;
    leaf.pattern = 0u;
    leaf.split = false;
    if (lane < count) {
        leaf = displaced_leaf_of(unit, cluster, displaced_part_at(unit, cluster, list, first + lane));
    }
    uint counted = leaf.triangles | (leaf.split ? 1u << 16u : 0u);
    uint sum = sum_over_group(counted).before + counted;
    uint vertex_sum = sum_over_group(leaf.vertices).before + leaf.vertices;
    displaced_leaves[lane] = leaf.triangles | leaf.vertices << 8u | leaf.pattern << 16u;
    displaced_leaf_sums[lane] = sum;
    displaced_vertex_sums[lane] = vertex_sum;
    barrier();
    uint next = 0u;
    while (next < count) {
        uint end = displaced_first_too_many(walk, next, count);
        if (end > next) {
            next = displaced_add_leaves(walk, leaf, next, end);
        }
        if (next == count) {
            break;
        }
        if (displaced_leaf_triangles(displaced_leaves[next]) < walk.triangle_count) {
            displaced_close(walk);
            continue;
        }
        bool fits = walk.triangle_count + leaf.triangles <= DISPLACED_RECORD_TRIANGLES &&
                    walk.vertex_count + leaf.vertices <= TEMPLATE_VERTICES;
        bool alone = !fits && leaf.triangles >= walk.triangle_count;
        end = min_uint(displaced_lowest(lane >= next && !alone), count);
        displaced_write_alone(walk, leaf, next, end);
        next = end;
    }
    barrier();
}

// --------------------------------------------------------------------------------------------------------------- walks

const uint DISPLACED_LISTS = DISPLACED_SPLITS_DEEPEST + 2u;

// By list: how long it is, how far it has come, and where in the list before it was made from. A list that was written over is
// made again from there, as are those before it.
shared uint displaced_lengths[DISPLACED_LISTS];
shared uint displaced_nexts[DISPLACED_LISTS];
shared uint displaced_firsts[DISPLACED_LISTS];

// Packs what is left of a list where none of it splits; false else.
bool displaced_pack_rest(unit_reference unit, clast_displaced_cluster cluster, inout displaced_walk walk, uint list)
{
    uint next = displaced_nexts[list];
    uint end = displaced_lengths[list];
    uint own = next + group_lane();
    bool splits = own < end && !displaced_is_leaf(displaced_part_at(unit, cluster, list, own));
    if (displaced_lowest(splits) != GROUP_SIZE) {
        return false;
    }
    displaced_pack(unit, cluster, walk, list, next, end - next);
    if (group_lane() == 0u) {
        displaced_nexts[list] = end;
    }
    barrier();
    return true;
}

// All triangles of a cluster, whose rates are known.
void displaced_walk_triangles(unit_reference unit, clast_displaced_cluster cluster, inout displaced_walk walk)
{
    uint lane = group_lane();
    for (uint i = lane; i < CLUSTER_VERTICES + DISPLACED_EDGES; i += GROUP_SIZE) {
        displaced_taken[i] = 0xffffffffu;
    }
    if (lane == 0u) {
        displaced_lengths[0] = cluster.triangle_count;
        displaced_nexts[0] = 0u;
    }
    barrier();
    uint list = 0u;
    uvec2 held = uvec2(0u, 0u); // the lists that were made last, by where they lie
    uint made = 0u;             // below `list`, where that has been written over: the list up to which they are there again
    while (walk.count.triangles <= DISPLACED_ITEM_TRIANGLES) {
        if (made == list) {
            if (displaced_nexts[list] == displaced_lengths[list]) {
                if (list == 0u) {
                    break;
                }
                list--;
                bool is_held = list == 0u || ((list & 1u) == 0u ? held[0] : held[1]) == list;
                bool whole = is_held || displaced_nexts[list] == displaced_lengths[list];
                made = whole ? list : 0u;
                continue;
            }
            if (displaced_pack_rest(unit, cluster, walk, list)) {
                continue;
            }
        }
        uint first = made == list ? displaced_nexts[made] : displaced_firsts[made + 1u];
        displaced_expansion next = displaced_expand(unit, cluster, made, first, displaced_lengths[made]);
        bool descends = made == list;
        if (descends && lane == 0u) {
            displaced_nexts[list] = first + next.parts;
            displaced_firsts[list + 1u] = first;
            displaced_lengths[list + 1u] = next.children;
            displaced_nexts[list + 1u] = 0u;
        }
        barrier();
        made++;
        list = descends ? made : list;
        held = (made & 1u) == 0u ? uvec2(made, held[1]) : uvec2(held[0], made);
    }
    displaced_close(walk);
}

void displaced_write_levels(inout displaced_walk walk, uint vertex_count, bool moved)
{
    uint words = displaced_words_of_levels(vertex_count, moved);
    bool writes = displaced_may_write(walk, 0u, words);
    for (uint i = group_lane(); writes && i < words; i += GROUP_SIZE) {
        uint second = 2u * i + 1u < vertex_count ? displaced_levels[2u * i + 1u] : 0u;
        uints(walk.words).at[i] = displaced_levels[2u * i] | second << 16u;
    }
    walk.count.words += words;
}

void displaced_write_cooked(inout displaced_walk walk, clast_displaced_cluster cluster)
{
    if (displaced_may_write(walk, 1u, 1u) && group_lane() == 0u) {
        displaced_write_record(walk, 0u, FORM_WHOLE, cluster.template_index, cluster.triangle_count, cluster.vertex_count,
                               0u, 0u, walk.count.words);
        uints(walk.words).at[walk.count.words] = walk.count.words;
    }
    walk.count.clusters = 1u;
    walk.count.triangles = cluster.triangle_count;
    walk.count.vertices = cluster.vertex_count;
    walk.count.words++;
}

// Begins a walk over an item, that only counts.
displaced_walk displaced_begin_walk(unit_reference unit, uint item)
{
    displaced_walk walk;
    walk.writes = false;
    walk.drafts = false;
    walk.room = 0u;
    walk.words = 0ul;
    walk.records = 0ul;
    walk.item = item;
    walk.first_vertex = 0u;
    walk.first_word = 0u;
    walk.unit_number = unit.of.number;
    walk.first_pattern = displaced_headers(array_of(unit, DISPLACED_ARRAY_HEADER)).at[0].first_pattern;
    walk.count.clusters = 0u;
    walk.count.triangles = 0u;
    walk.count.vertices = 0u;
    walk.count.words = 0u;
    walk.count.blocks = 0u;
    walk.leaf_count = 0u;
    walk.triangle_count = 0u;
    walk.vertex_count = 0u;
    walk.split_count = 0u;
    walk.serial = 1u;
    walk.lone = 0u;
    return walk;
}

// Counts what the item of the walk emits, whose rates are known, and writes it where the walk writes.
void displaced_walk_item(unit_reference unit, clast_displaced_cluster cluster, inout displaced_walk walk)
{
    displaced_write_levels(walk, cluster.vertex_count, displaced_is_moved(unit));
    bool cut = false;
    for (uint i = group_lane(); i < cluster.edge_count; i += GROUP_SIZE) {
        cut = cut || displaced_factors[i] > 1u;
    }
    if (displaced_lowest(cut) == GROUP_SIZE) {
        displaced_write_cooked(walk, cluster);
        return;
    }
    displaced_walk_triangles(unit, cluster, walk);
    if (walk.count.triangles > DISPLACED_ITEM_TRIANGLES) {
        walk.count.clusters = 0xffffffffu;
        walk.count.triangles = 0xffffffffu;
        walk.count.vertices = 0xffffffffu;
        walk.count.words = 0xffffffffu;
        walk.count.blocks = 0xffffffffu;
    }
}

#endif
