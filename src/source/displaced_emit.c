// SPDX-License-Identifier: Apache-2.0
// Leaves of displaced meshes, and how they are packed into records. Counting and emitting are one walk: where there is no room
// to write, it counts.
#include "source/displaced.h"

// A record that still takes leaves.
typedef struct open_record {
    uint32_t leaf_count, triangle_count, vertex_count, split_count;
    // Of the cluster, which it has already: those marked with its serial number.
    uint8_t vertices[CLUSTER_VERTICES], edges[DISPLACED_EDGES], serial;
    uint32_t leaves[DISPLACED_RECORD_TRIANGLES];
    uint32_t splits[DISPLACED_RECORD_TRIANGLES * DISPLACED_SPLIT_WORDS];
} open_record;

typedef struct walk {
    const displaced_unit *unit;
    const clast_pose *pose;
    const displaced_cluster *cluster;
    clast_rate_view view;
    displaced_rates rates;
    open_record open;
    clast_source_count count;
    clast_source_draft to; // without room where it only counts
    uint32_t item, first_vertex, first_word;
} walk;

// ---------------------------------------------------------------------------------------------------------- records

static void write_record(walk *w, uint32_t form, uint32_t template_index, const open_record *from)
{
    uint32_t words = 1 + from->leaf_count + from->split_count * DISPLACED_SPLIT_WORDS;
    if (w->count.clusters < w->to.record_room && (uint64_t)w->count.words + words <= w->to.word_room) {
        uint32_t *to = w->to.words + w->count.words;
        w->to.records[w->count.clusters] = (clast_cluster_record){
            .unit = w->unit->base.number,
            .template_index = template_index,
            .first_vertex = w->first_vertex + w->count.vertices,
            .item = w->item,
            .form_and_counts = form_and_counts(form, from->triangle_count, from->vertex_count),
            .detail = from->leaf_count,
            .first_word = w->first_word + w->count.words,
        };
        to[0] = w->count.words; // the item's first word is so far back
        memcpy(to + 1, from->leaves, from->leaf_count * sizeof *to);
        memcpy(to + 1 + from->leaf_count, from->splits, from->split_count * DISPLACED_SPLIT_WORDS * sizeof *to);
    }
    w->count.clusters++;
    w->count.triangles += from->triangle_count;
    w->count.vertices += from->vertex_count;
    w->count.words += words;
    w->count.blocks += form == FORM_COMPOSITE ? (from->triangle_count + BLOCK_TRIANGLES - 1) / BLOCK_TRIANGLES : 0;
}

// A leaf before it is in a record.
typedef struct loose_leaf {
    uint32_t triangle, factors;
    const displaced_leaf_corner *corners; // null for a whole triangle
    displaced_pattern use;
} loose_leaf;

static void put_leaf(open_record *record, const loose_leaf *leaf)
{
    record->leaves[record->leaf_count++] = displaced_leaf_word(leaf->triangle, leaf->factors, leaf->corners != NULL,
                                                               record->triangle_count);
    if (leaf->corners != NULL) {
        uint32_t *to = record->splits + record->split_count++ * DISPLACED_SPLIT_WORDS;
        for (uint32_t k = 0; k < 3; k++) {
            to[k] = weights_word(leaf->corners[k].at);
        }
        to[3] = leaf->corners[0].level | leaf->corners[1].level << 16;
        to[4] = leaf->corners[2].level;
    }
}

static void write_alone(walk *w, const loose_leaf *leaf)
{
    open_record alone;
    alone.leaf_count = alone.triangle_count = alone.split_count = 0;
    put_leaf(&alone, leaf);
    alone.triangle_count = pattern_triangles(*leaf->use.pattern);
    alone.vertex_count = pattern_vertices(*leaf->use.pattern);
    write_record(w, FORM_WHOLE, w->unit->first_pattern + leaf->use.number, &alone);
}

static void empty_record(open_record *record)
{
    record->leaf_count = record->triangle_count = record->vertex_count = record->split_count = 0;
}

static void begin_records(open_record *record)
{
    empty_record(record);
    memset(record->vertices, 0, sizeof record->vertices);
    memset(record->edges, 0, sizeof record->edges);
    record->serial = 1;
}

static void next_record(open_record *record)
{
    record->serial++;
    if (record->serial == 0) {
        begin_records(record); // serial numbers have come round
    }
    empty_record(record);
}

// Writes what is open: one leaf as a pattern, several as a composite.
static void close_record(walk *w)
{
    open_record *open = &w->open;
    if (open->leaf_count == 0) {
        return;
    }
    if (open->leaf_count == 1) {
        uint32_t factors = displaced_leaf_factors(open->leaves[0]);
        displaced_pattern use = displaced_pattern_of(w->unit, factors);
        open->vertex_count = pattern_vertices(*use.pattern);
        write_record(w, FORM_WHOLE, w->unit->first_pattern + use.number, open);
    } else {
        write_record(w, FORM_COMPOSITE, CLAST_NONE, open);
    }
    next_record(open);
}

// All ones where the record has what the mark is of; it has it from now on.
static uint32_t take(uint8_t *mark, uint8_t serial)
{
    uint32_t had = *mark == serial ? ~0u : 0u;
    *mark = serial;
    return had;
}

// Adds a leaf where it fits: corners and points within edges that the record has already cost nothing.
static bool add_leaf(open_record *open, const loose_leaf *leaf, displaced_triangle triangle)
{
    uint32_t triangles = pattern_triangles(*leaf->use.pattern), vertices = pattern_vertices(*leaf->use.pattern);
    if (open->triangle_count + triangles > DISPLACED_RECORD_TRIANGLES ||
        open->vertex_count + vertices > TEMPLATE_VERTICES) {
        return false;
    }
    for (uint32_t k = 0; k < 3 && leaf->corners == NULL; k++) {
        uint32_t within = pattern_factor(leaf->factors, k) - 1;
        vertices -= take(&open->vertices[displaced_corner(triangle, k)], open->serial) & 1;
        vertices -= take(&open->edges[displaced_edge_of(triangle, k)], open->serial) & within;
    }
    put_leaf(open, leaf);
    open->triangle_count += triangles;
    open->vertex_count += vertices;
    return true;
}

// Leaves come in the order of the cluster, and small ones gather in a record until one does not fit. The larger of the two then
// goes on its own: the record while the leaf begins another, or the leaf.
static void pack_leaf(walk *w, uint32_t number, displaced_triangle triangle, const uint32_t factors[3],
                      const displaced_leaf_corner *corners)
{
    loose_leaf leaf = {number, pattern_factors(factors[0], factors[1], factors[2]), corners, {NULL, 0, 0}};
    leaf.use = displaced_pattern_of(w->unit, leaf.factors);
    if (add_leaf(&w->open, &leaf, triangle)) {
        return;
    }
    if (pattern_triangles(*leaf.use.pattern) >= w->open.triangle_count) {
        write_alone(w, &leaf);
        return;
    }
    close_record(w);
    add_leaf(&w->open, &leaf, triangle);
}

// ------------------------------------------------------------------------------------------------------------ walks

typedef struct part_job {
    walk *w;
    uint32_t number;
    displaced_triangle triangle;
} part_job;

static bool pack_part(void *user, const displaced_part *part)
{
    part_job *job = user;
    pack_leaf(job->w, job->number, job->triangle, part->factors, part->corners);
    return job->w->count.triangles <= DISPLACED_ITEM_TRIANGLES;
}

static void split_triangle(walk *w, uint32_t number, displaced_triangle triangle, const uint32_t factors[3])
{
    displaced_part whole;
    for (uint32_t k = 0; k < 3; k++) {
        whole.factors[k] = factors[k];
        whole.corners[k] = (displaced_leaf_corner){weights_of_corner(k),
                                                   w->rates.levels[displaced_corner(triangle, k)]};
    }
    part_job job = {w, number, triangle};
    clast_displaced_split(w->unit, w->pose, &w->view, w->cluster, number, &whole, pack_part, &job);
}

static void pack_triangle(walk *w, uint32_t number)
{
    displaced_triangle triangle = w->unit->triangles[w->cluster->first_triangle + number];
    const uint32_t *all = w->rates.factors;
    const uint32_t factors[3] = {all[displaced_edge_of(triangle, 0)], all[displaced_edge_of(triangle, 1)],
                                 all[displaced_edge_of(triangle, 2)]};
    if (max_uint(max_uint(factors[0], factors[1]), factors[2]) <= PATTERN_SEGMENTS) {
        pack_leaf(w, number, triangle, factors, NULL);
    } else {
        split_triangle(w, number, triangle, factors);
    }
}

static void write_levels(walk *w)
{
    uint32_t words = displaced_level_words(w->unit, w->cluster);
    for (uint32_t i = 0; words <= w->to.word_room && i < words; i++) {
        uint32_t second = 2 * i + 1 < w->cluster->vertex_count ? w->rates.levels[2 * i + 1] : 0u;
        w->to.words[i] = w->rates.levels[2 * i] | second << 16;
    }
    w->count.words += words;
}

static bool is_as_cooked(const walk *w)
{
    uint32_t most = 1;
    for (uint32_t i = 0; i < w->cluster->edge_count; i++) {
        most = max_uint(most, w->rates.factors[i]);
    }
    return most == 1;
}

static void walk_item(walk *w)
{
    clast_displaced_rates(w->unit, w->pose, &w->view, w->cluster, &w->rates);
    write_levels(w);
    begin_records(&w->open);
    if (is_as_cooked(w)) {
        w->open.triangle_count = w->cluster->triangle_count;
        w->open.vertex_count = w->cluster->vertex_count;
        write_record(w, FORM_WHOLE, w->cluster->template_index, &w->open);
        return;
    }
    for (uint32_t i = 0; i < w->cluster->triangle_count && w->count.triangles <= DISPLACED_ITEM_TRIANGLES; i++) {
        pack_triangle(w, i);
    }
    close_record(w);
    if (w->count.triangles > DISPLACED_ITEM_TRIANGLES) {
        w->count = (clast_source_count){UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
    }
}

static void begin_walk(walk *w, const displaced_unit *unit, const clast_pose *pose, const clast_source_view *view,
                       uint32_t item)
{
    w->unit = unit;
    w->pose = pose;
    w->cluster = &unit->clusters[item];
    w->view = clast_displaced_rate_view(unit, pose, view);
    w->count = (clast_source_count){0};
    w->item = item;
    w->first_vertex = w->first_word = 0;
}

clast_source_count clast_displaced_draft(const clast_unit *base, const clast_pose *pose, const clast_source_view *view,
                                         uint32_t item, const clast_source_draft *draft)
{
    walk w;
    begin_walk(&w, clast_displaced_of(base), pose, view, item);
    w.to = *draft;
    walk_item(&w);
    return w.count;
}

clast_source_count clast_displaced_count(const clast_unit *base, const clast_pose *pose, const clast_source_view *view,
                                         uint32_t item)
{
    return clast_displaced_draft(base, pose, view, item, &(clast_source_draft){0});
}

void clast_displaced_emit(const clast_unit *base, const clast_pose *pose, const clast_source_view *view, uint32_t item,
                          uint32_t first_vertex, uint32_t first_word, uint32_t *words, clast_cluster_record *records)
{
    walk w;
    begin_walk(&w, clast_displaced_of(base), pose, view, item);
    w.to = (clast_source_draft){records, words, UINT32_MAX, UINT32_MAX};
    w.first_vertex = first_vertex;
    w.first_word = first_word;
    walk_item(&w);
}
