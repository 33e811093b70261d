// SPDX-License-Identifier: Apache-2.0
// Reading the leaves of a record: where in it their vertices are. A composite has a corner, and the points within an edge, once
// for all of its leaves that are whole triangles; parts of split triangles have all of their own.
#include "source/displaced.h"

displaced_reader clast_displaced_read(const displaced_unit *unit, const clast_cluster_record *record,
                                      const uint32_t *words)
{
    displaced_reader reader;
    reader.unit = unit;
    reader.cluster = &unit->clusters[record->item];
    reader.words = words + 1;
    reader.splits = words + 1 + record->detail;
    reader.levels = unit->displaced ? words - words[0] : NULL;
    reader.leaf_count = record->detail;
    reader.next = 0;
    reader.whole = record_form(*record) == FORM_WHOLE;
    reader.vertex_count = 0;
    memset(reader.known_vertices, 0, sizeof reader.known_vertices);
    memset(reader.known_edges, 0, sizeof reader.known_edges);
    memset(reader.turned_edges, 0, sizeof reader.turned_edges);
    return reader;
}

float clast_displaced_cluster_level(const displaced_reader *reader, uint32_t vertex)
{
    uint32_t steps = reader->levels != NULL ? reader->levels[vertex / 2] >> 16 * (vertex % 2) & 65535 : 0;
    return (float)steps * (1.0f / (float)HEIGHT_LEVEL_STEPS);
}

float clast_displaced_level_of(const displaced_reader *reader, uint32_t corner)
{
    if (reader->leaf.split) {
        return (float)reader->leaf.corners[corner].level * (1.0f / (float)HEIGHT_LEVEL_STEPS);
    }
    displaced_triangle triangle = reader->unit->triangles[reader->cluster->first_triangle + reader->leaf.triangle];
    return clast_displaced_cluster_level(reader, displaced_corner(triangle, corner));
}

static void read_leaf(displaced_reader *reader)
{
    uint32_t word = reader->words[reader->next++];
    displaced_leaf *leaf = &reader->leaf;
    leaf->triangle = word & 255;
    leaf->factors = word >> DISPLACED_LEAF_TRIANGLE_BITS & 4095;
    leaf->split = (word >> DISPLACED_LEAF_SPLIT_BIT & 1) != 0;
    reader->first_triangle = word >> DISPLACED_LEAF_FIRST_BIT & 255;
    reader->use = displaced_pattern_of(reader->unit, leaf->factors);
    if (leaf->split) {
        for (uint32_t k = 0; k < 3; k++) {
            leaf->corners[k].at = weights_of(reader->splits[k]);
        }
        leaf->corners[0].level = reader->splits[3] & 65535;
        leaf->corners[1].level = reader->splits[3] >> 16;
        leaf->corners[2].level = reader->splits[4];
        reader->splits += DISPLACED_SPLIT_WORDS;
    }
}

// All of its vertices are its own, in the pattern's order.
static void place_alone(displaced_reader *reader)
{
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    for (uint32_t k = 0; k < 3; k++) {
        reader->corner_at[k] = (uint8_t)(reader->vertex_count + k);
        reader->edge_at[k] = (uint8_t)(reader->vertex_count + pattern_edge_begin(factors, k));
        reader->edge_falls[k] = false;
        reader->corner_is_new[k] = reader->edge_is_new[k] = true;
    }
    reader->inside_at = (uint8_t)(reader->vertex_count + pattern_edge_begin(factors, 3));
    reader->vertex_count += pattern_vertices(*reader->use.pattern);
}

static bool take_bit(uint64_t *bits, uint32_t bit)
{
    bool had = (bits[bit / 64] >> bit % 64 & 1) != 0;
    bits[bit / 64] |= 1ull << bit % 64;
    return had;
}

static void place_corner(displaced_reader *reader, displaced_triangle triangle, uint32_t k)
{
    uint32_t vertex = displaced_corner(triangle, (k + reader->use.rotation) % 3);
    reader->corner_is_new[k] = !take_bit(reader->known_vertices, vertex);
    if (reader->corner_is_new[k]) {
        reader->first_of_vertex[vertex] = (uint8_t)reader->vertex_count++;
    }
    reader->corner_at[k] = reader->first_of_vertex[vertex];
}

static void place_edge(displaced_reader *reader, displaced_triangle triangle, uint32_t k, uint32_t within)
{
    uint32_t own = (k + reader->use.rotation) % 3;
    uint32_t edge = displaced_edge_of(triangle, own);
    bool turned = !displaced_goes_along(triangle, own);
    reader->edge_is_new[k] = !take_bit(reader->known_edges, edge);
    if (reader->edge_is_new[k]) {
        reader->first_of_edge[edge] = (uint8_t)reader->vertex_count;
        reader->vertex_count += within;
        reader->turned_edges[edge / 64] |= (uint64_t)turned << edge % 64;
    }
    bool falls = turned != ((reader->turned_edges[edge / 64] >> edge % 64 & 1) != 0);
    reader->edge_falls[k] = falls;
    reader->edge_at[k] = (uint8_t)(reader->first_of_edge[edge] + (falls && within != 0 ? within - 1 : 0));
}

// Corners come first, then the points within the edges, then those inside.
static void place_shared(displaced_reader *reader)
{
    displaced_triangle triangle = reader->unit->triangles[reader->cluster->first_triangle + reader->leaf.triangle];
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    for (uint32_t k = 0; k < 3; k++) {
        place_corner(reader, triangle, k);
    }
    for (uint32_t k = 0; k < 3; k++) {
        place_edge(reader, triangle, k, pattern_factor(factors, k) - 1);
    }
    reader->inside_at = (uint8_t)reader->vertex_count;
    reader->vertex_count += pattern_vertices(*reader->use.pattern) - pattern_edge_begin(factors, 3);
}

bool clast_displaced_next(displaced_reader *reader)
{
    if (reader->next == reader->leaf_count) {
        return false;
    }
    read_leaf(reader);
    if (reader->whole || reader->leaf.split) {
        place_alone(reader);
    } else {
        place_shared(reader);
    }
    return true;
}

uint32_t clast_displaced_place(const displaced_reader *reader, uint32_t vertex)
{
    if (vertex < 3) {
        return reader->corner_at[vertex];
    }
    uint32_t factors = pattern_own_factors(*reader->use.pattern);
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t begin = pattern_edge_begin(factors, k);
        if (vertex < pattern_edge_begin(factors, k + 1)) {
            uint32_t step = vertex - begin;
            return reader->edge_falls[k] ? reader->edge_at[k] - step : reader->edge_at[k] + step;
        }
    }
    return reader->inside_at + (vertex - pattern_edge_begin(factors, 3));
}

void clast_displaced_corners(const clast_unit *base, const clast_cluster_record *record, const uint32_t *words,
                             uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    const displaced_unit *unit = clast_displaced_of(base);
    displaced_reader reader = clast_displaced_read(unit, record, words);
    uint8_t *to = corners;
    while (clast_displaced_next(&reader)) {
        uint8_t places[PATTERN_VERTICES];
        for (uint32_t i = 0; i < pattern_vertices(*reader.use.pattern); i++) {
            places[i] = (uint8_t)clast_displaced_place(&reader, i);
        }
        const uint32_t *triangles = unit->patterns->triangles + reader.use.pattern->first_triangle;
        for (uint32_t i = 0; i < pattern_triangles(*reader.use.pattern); i++) {
            for (uint32_t k = 0; k < 3; k++) {
                *to++ = places[triangles[i] >> 8 * k & 255];
            }
        }
    }
}
