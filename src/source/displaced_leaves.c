// SPDX-License-Identifier: Apache-2.0
// Reading the leaves of a record, and where in it their vertices are. A composite begins with the corners of all its leaves that
// are whole triangles, in the order of the cluster's vertices, then has the points within their edges, in the order of its edges,
// each along the edge; then come, leaf by leaf, the points inside. Parts of split triangles have all of their own there.
#include "source/displaced.h"

enum {
    PLACES_MORE = 16, // that may be written beyond
    BYTES = sizeof(uint64_t),
};

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

static void read_split(displaced_reader *reader)
{
    displaced_leaf *leaf = &reader->leaf;
    for (uint32_t k = 0; k < 3; k++) {
        leaf->corners[k].at = weights_of(reader->splits[k]);
    }
    leaf->corners[0].level = reader->splits[3] & 65535;
    leaf->corners[1].level = reader->splits[3] >> 16;
    leaf->corners[2].level = reader->splits[4];
    reader->splits += DISPLACED_SPLIT_WORDS;
}

bool clast_displaced_next(displaced_reader *reader)
{
    if (reader->next == reader->leaf_count) {
        return false;
    }
    uint32_t word = reader->words[reader->next++];
    displaced_leaf *leaf = &reader->leaf;
    leaf->triangle = word & 255;
    leaf->factors = word >> DISPLACED_LEAF_TRIANGLE_BITS & 4095;
    leaf->split = (word >> DISPLACED_LEAF_SPLIT_BIT & 1) != 0;
    reader->first_triangle = word >> DISPLACED_LEAF_FIRST_BIT & 255;
    reader->use = displaced_pattern_of(reader->unit, leaf->factors);
    if (leaf->split) {
        read_split(reader);
    }
    return true;
}

// ---------------------------------------------------------------------------------------------------------- layouts

// Which vertices and edges the leaves share: those of whole triangles.
static void mark_shared(const displaced_reader *reader, displaced_layout *layout)
{
    const displaced_triangle *triangles = reader->unit->triangles + reader->cluster->first_triangle;
    for (uint32_t i = 0; i < reader->leaf_count; i++) {
        uint32_t word = reader->words[i];
        if (displaced_leaf_is_split(word)) {
            continue;
        }
        displaced_triangle triangle = triangles[displaced_leaf_triangle(word)];
        uint32_t factors = displaced_leaf_factors(word);
#pragma GCC unroll 3
        for (uint32_t k = 0; k < 3; k++) {
            layout->vertices[displaced_corner(triangle, k)] = 1;
            layout->factors[displaced_edge_of(triangle, k)] = (uint8_t)pattern_factor(factors, k);
        }
        layout->by_owners |= !displaced_is_plain(triangle);
    }
}

// Eight bytes in one register: a product with these adds up to each byte those before it, as no sum is more than a byte holds.
static const uint64_t each_byte = 0x0101010101010101u;

// The first byte is the lowest, on any machine.
static inline uint64_t in_order(uint64_t bytes)
{
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
    return __builtin_bswap64(bytes);
#else
    return bytes;
#endif
}

static inline uint64_t load_bytes(const uint8_t *from)
{
    uint64_t bytes;
    memcpy(&bytes, from, sizeof bytes);
    return in_order(bytes);
}

static inline void store_bytes(uint8_t *to, uint64_t bytes)
{
    bytes = in_order(bytes);
    memcpy(to, &bytes, sizeof bytes);
}

// 1 for each byte that is not zero, of bytes below 128.
static inline uint64_t not_zero(uint64_t bytes)
{
    return (bytes + 127 * each_byte) >> 7 & each_byte;
}

static void place_vertices(displaced_layout *layout, uint32_t vertex_count)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < vertex_count; i += BYTES) {
        uint64_t there = load_bytes(layout->vertices + i), sums = there * each_byte;
        uint64_t before = sums - there + count * each_byte;
        store_bytes(layout->vertex_at + i, before);
        for (uint32_t k = 0; k < BYTES && there != 0; k++) {
            layout->vertex_list[before >> 8 * k & 255] = (uint8_t)(i + k); // what is not there is written over
        }
        count += sums >> 56;
    }
    layout->vertex_count = count;
}

static void place_edges(displaced_layout *layout, uint32_t edge_count)
{
    uint32_t count = layout->vertex_count, listed = 0;
    for (uint32_t i = 0; i < edge_count; i += BYTES) {
        uint64_t factors = load_bytes(layout->factors + i), within = factors - not_zero(factors);
        uint64_t sums = within * each_byte;
        store_bytes(layout->edge_at + i, sums - within + count * each_byte);
        count += sums >> 56;
        uint64_t some = not_zero(within), some_sums = some * each_byte, before = some_sums - some;
        for (uint32_t k = 0; k < BYTES && some != 0; k++) {
            layout->edge_list[listed + (before >> 8 * k & 255)] = (uint16_t)(i + k);
        }
        listed += some_sums >> 56;
    }
    layout->edge_count = listed;
    layout->shared_count = count;
}

_Static_assert((int)BYTES == (int)DISPLACED_TOGETHER, "arrays have room for what is placed at once");

void clast_displaced_lay_out(const displaced_reader *reader, displaced_layout *layout)
{
    uint32_t vertex_count = reader->cluster->vertex_count, edge_count = reader->cluster->edge_count;
    memset(layout->vertices, 0, vertex_count + BYTES - 1);
    memset(layout->factors, 0, edge_count + BYTES - 1);
    layout->by_owners = false;
    mark_shared(reader, layout);
    place_vertices(layout, vertex_count);
    place_edges(layout, edge_count);
}

// --------------------------------------------------------------------------------------------------------- corners

// The places of the points within an edge, as the triangle has them. As many are written as there ever are: those beyond may be
// anything.
static void place_edge(const displaced_layout *layout, displaced_triangle triangle, uint32_t own, uint32_t within,
                       uint8_t *places)
{
    typedef uint8_t bytes __attribute__((vector_size(PLACES_MORE)));
    const bytes steps = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    uint8_t first = layout->edge_at[displaced_edge_of(triangle, own)];
    uint8_t falls = displaced_goes_along(triangle, own) ? 0 : 0xff;
    bytes all = (uint8_t)(first + (falls & (within - 1))) + ((steps ^ falls) - falls);
    memcpy(places, &all, sizeof all);
}

// Where the vertices of a leaf's pattern are in the record; `own_at` is where its own begin. Gives where those of the next do.
static uint32_t place_leaf(const displaced_reader *reader, const displaced_layout *layout, uint32_t own_at,
                           uint8_t places[PATTERN_VERTICES + PLACES_MORE])
{
    uint32_t factors = pattern_own_factors(*reader->use.pattern), count = pattern_vertices(*reader->use.pattern);
    uint32_t shared = 0;
    if (!reader->leaf.split) {
        displaced_triangle triangle = reader->unit->triangles[reader->cluster->first_triangle + reader->leaf.triangle];
        shared = 3;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t own = (k + reader->use.rotation) % 3, within = pattern_factor(factors, k) - 1;
            places[k] = layout->vertex_at[displaced_corner(triangle, own)];
            place_edge(layout, triangle, own, within, places + shared);
            shared += within;
        }
    }
    for (uint32_t i = shared; i < count; i++) {
        places[i] = (uint8_t)own_at++;
    }
    return own_at;
}

void clast_displaced_place(const displaced_reader *from, const displaced_layout *layout,
                           uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    displaced_reader reader = *from;
    uint32_t own_at = layout->shared_count;
    uint8_t *to = corners;
    while (clast_displaced_next(&reader)) {
        uint8_t places[PATTERN_VERTICES + PLACES_MORE];
        own_at = place_leaf(&reader, layout, own_at, places);
        const uint32_t *triangles = reader.unit->patterns->triangles + reader.use.pattern->first_triangle;
        uint32_t count = pattern_triangles(*reader.use.pattern);
        for (uint32_t i = 0; i < count; i++, to += 3) {
            uint32_t word = triangles[i];
            to[0] = places[word & 255];
            to[1] = places[word >> 8 & 255];
            to[2] = places[word >> 16];
        }
    }
}

void clast_displaced_corners(const clast_unit *base, const clast_cluster_record *record, const uint32_t *words,
                             uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    displaced_reader reader = clast_displaced_read(clast_displaced_of(base), record, words);
    displaced_layout layout;
    clast_displaced_lay_out(&reader, &layout);
    clast_displaced_place(&reader, &layout, corners);
}
