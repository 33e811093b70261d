// SPDX-License-Identifier: Apache-2.0
// Where the vertices of a composite's leaves are. A composite begins with the corners of all its leaves that are whole triangles,
// in the order of the cluster's vertices, then has the points within their edges, in the order of its edges, each along the edge;
// then come, leaf by leaf, the points inside. Parts of split triangles have all of their own there.
#include "base/simd_wide.h"
#include "source/displaced.h"

// Patterns of few vertices have the places of these in one register, in which their triangles' corners are looked up.
#if defined(__AVX512VBMI__)
enum { SMALL = 64 };
#define SMALL_PATTERNS 1
#elif defined(__SSE4_2__) || defined(__AVX2__)
enum { SMALL = 16 };
#define SMALL_PATTERNS 1
#endif

enum {
    PLACES_MORE = 16, // that may be written beyond
    BYTES = sizeof(uint64_t),
};

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

// Which of some bytes are more than `least`, in order.
static uint32_t list_above(const uint8_t *bytes, uint32_t count, uint8_t least, uint16_t *list)
{
    uint32_t listed = 0;
#if defined(__AVX512F__)
    const __m512i ramp = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    for (uint32_t i = 0; i < count; i += 16) {
        __m128i some = _mm_loadu_si128((const __m128i *)(const void *)(bytes + i));
        __mmask16 above = _mm_cmpgt_epu8_mask(some, _mm_set1_epi8((char)least));
        __m512i numbers = _mm512_maskz_compress_epi32(above, _mm512_add_epi32(ramp, _mm512_set1_epi32((int)i)));
        _mm256_storeu_si256((__m256i *)(void *)(list + listed), _mm512_cvtepi32_epi16(numbers));
        listed += (uint32_t)__builtin_popcount(above);
    }
#else
    for (uint32_t i = 0; i < count; i++) {
        list[listed] = (uint16_t)i; // what is not above is written over
        listed += bytes[i] > least;
    }
#endif
    return listed;
}

static void place_vertices(displaced_layout *layout, uint32_t vertex_count)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < vertex_count; i += BYTES) {
        uint64_t there = load_bytes(layout->vertices + i), sums = there * each_byte;
        store_bytes(layout->vertex_at + i, sums - there + count * each_byte);
        count += (uint32_t)(sums >> 56);
    }
    layout->vertex_count = list_above(layout->vertices, vertex_count, 0, layout->vertex_list);
}

static void place_edges(displaced_layout *layout, uint32_t edge_count)
{
    uint32_t count = layout->vertex_count;
    for (uint32_t i = 0; i < edge_count; i += BYTES) {
        uint64_t factors = load_bytes(layout->factors + i), within = factors - not_zero(factors);
        uint64_t sums = within * each_byte;
        store_bytes(layout->edge_at + i, sums - within + count * each_byte);
        count += (uint32_t)(sums >> 56);
    }
    layout->shared_count = count;
    layout->edge_count = list_above(layout->factors, edge_count, 1, layout->edge_list);
}

void CLAST_KERNEL(clast_displaced_lay_out)(const displaced_reader *reader, displaced_layout *layout)
{
    uint32_t vertex_count = reader->cluster->vertex_count, edge_count = reader->cluster->edge_count;
    memset(layout->vertices, 0, vertex_count + DISPLACED_TOGETHER - 1);
    memset(layout->factors, 0, edge_count + DISPLACED_TOGETHER - 1);
    layout->by_owners = false;
    mark_shared(reader, layout);
    place_vertices(layout, vertex_count);
    place_edges(layout, edge_count);
}

// --------------------------------------------------------------------------------------------------------- corners

// A leaf, with the pattern that it takes.
typedef struct placed_leaf {
    displaced_triangle triangle;
    bool split;
    clast_pattern pattern;
    uint32_t rotation;
    uint32_t own_at; // where its own vertices begin in the record
} placed_leaf;

static inline uint32_t own_corner(const placed_leaf *leaf, uint32_t k)
{
    uint32_t turned = k + leaf->rotation;
    return turned < 3 ? turned : turned - 3;
}

// All ones where an edge's places fall along the triangle's edge: a branch would be foreseen half of the times.
static inline uint32_t falls_along(displaced_triangle triangle, uint32_t own)
{
    return (triangle.edges >> (27 + own) & 1) - 1;
}

// The places of the points within an edge, as the triangle has them. As many are written as there ever are: those beyond may be
// anything.
static void place_edge(const displaced_layout *layout, displaced_triangle triangle, uint32_t own, uint32_t within,
                       uint8_t *places)
{
    typedef uint8_t bytes __attribute__((vector_size(PLACES_MORE)));
    const bytes steps = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    uint8_t first = layout->edge_at[displaced_edge_of(triangle, own)];
    uint32_t falls = falls_along(triangle, own);
    bytes all = (uint8_t)(first + (falls & (within - 1))) + ((steps ^ (uint8_t)falls) - (uint8_t)falls);
    memcpy(places, &all, sizeof all);
}

// Where the vertices of a leaf's pattern are in the record.
static void place_leaf(const placed_leaf *leaf, const displaced_layout *layout,
                       uint8_t places[PATTERN_VERTICES + PLACES_MORE])
{
    uint32_t factors = pattern_own_factors(leaf->pattern), count = pattern_vertices(leaf->pattern), shared = 0;
    if (!leaf->split) {
        shared = 3;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t own = own_corner(leaf, k), within = pattern_factor(factors, k) - 1;
            places[k] = layout->vertex_at[displaced_corner(leaf->triangle, own)];
            place_edge(layout, leaf->triangle, own, within, places + shared);
            shared += within;
        }
    }
    for (uint32_t i = shared; i < count; i++) {
        places[i] = (uint8_t)(leaf->own_at + i - shared);
    }
}

static uint8_t *write_corners(const placed_leaf *leaf, const displaced_layout *layout, const uint32_t *triangles,
                              uint8_t *to)
{
    uint8_t places[PATTERN_VERTICES + PLACES_MORE];
    place_leaf(leaf, layout, places);
    for (uint32_t i = 0; i < pattern_triangles(leaf->pattern); i++, to += 3) {
        uint32_t word = triangles[i];
        to[0] = places[word & 255];
        to[1] = places[word >> 8 & 255];
        to[2] = places[word >> 16];
    }
    return to;
}

#if defined(SMALL_PATTERNS)
typedef uint8_t small_places __attribute__((vector_size(SMALL)));

CLAST_LANES small_places ramp_of_places(void)
{
    static const uint8_t ramp[64] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13, 14, 15,
                                     16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31,
                                     32, 33, 34, 35, 36, 37, 38, 39, 40, 41, 42, 43, 44, 45, 46, 47,
                                     48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62, 63};
    small_places places;
    memcpy(&places, ramp, sizeof places);
    return places;
}

// `after` from a place on.
CLAST_LANES small_places go_on(small_places before, uint32_t begin, small_places after)
{
#if defined(__AVX512VBMI__)
    return (small_places)_mm512_mask_mov_epi8((__m512i)before, ~(__mmask64)0 << begin, (__m512i)after);
#else
    return (small_places)_mm_blendv_epi8((__m128i)before, (__m128i)after,
                                         (__m128i)(ramp_of_places() >= (uint8_t)begin));
#endif
}

// place_leaf() of a whole triangle.
CLAST_LANES small_places place_small(const placed_leaf *leaf, const displaced_layout *layout)
{
    const small_places ramp = ramp_of_places(), none = {0};
    uint32_t factors = pattern_own_factors(leaf->pattern), begin = 3;
    small_places places = none;
    for (uint32_t k = 0; k < 3; k++) {
        places = go_on(places, k, none + layout->vertex_at[displaced_corner(leaf->triangle, own_corner(leaf, k))]);
    }
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t own = own_corner(leaf, k), within = pattern_factor(factors, k) - 1;
        uint32_t first = layout->edge_at[displaced_edge_of(leaf->triangle, own)];
        uint32_t falls = falls_along(leaf->triangle, own);
        uint32_t start = first - begin + (falls & (within - 1 + 2 * begin));
        places = go_on(places, begin, ((ramp ^ (uint8_t)falls) - (uint8_t)falls) + (uint8_t)start);
        begin += within;
    }
    return go_on(places, begin, ramp + (uint8_t)(leaf->own_at - begin));
}

static uint8_t *write_small(const placed_leaf *leaf, const displaced_layout *layout, const uint32_t *triangles,
                            uint8_t *to)
{
    small_places places = place_small(leaf, layout);
    uint32_t count = pattern_triangles(leaf->pattern);
#if defined(__AVX512VBMI__)
    const __m512i three_of_four = _mm512_setr_epi32(0x04020100, 0x09080605, 0x0e0d0c0a, 0x14121110, 0x19181615,
                                                    0x1e1d1c1a, 0x24222120, 0x29282625, 0x2e2d2c2a, 0x34323130,
                                                    0x39383635, 0x3e3d3c3a, 0, 0, 0, 0);
    for (uint32_t i = 0; i < count; i += 16) {
        uint32_t left = min_uint(count - i, 16);
        __m512i words = (__m512i)wide_load_first(triangles + i, left);
        __m512i corners = _mm512_permutexvar_epi8(_mm512_permutexvar_epi8(three_of_four, words), (__m512i)places);
        _mm512_mask_storeu_epi8(to + 3 * i, ((__mmask64)1 << 3 * left) - 1, corners);
    }
#else
    const __m128i three_of_four = _mm_setr_epi8(0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14, 15, 15, 15, 15);
    for (uint32_t i = 0; i < count; i += 4) {
        uint32_t left = min_uint(count - i, 4), four[4] = {0};
        if (left == 4) {
            memcpy(four, triangles + i, sizeof four);
        }
        for (uint32_t j = 0; left < 4 && j < left; j++) {
            four[j] = triangles[i + j];
        }
        __m128i words = _mm_loadu_si128((const __m128i *)(const void *)four);
        __m128i corners = _mm_shuffle_epi8((__m128i)places, _mm_shuffle_epi8(words, three_of_four));
        uint8_t twelve[16];
        _mm_storeu_si128((__m128i *)(void *)twelve, corners);
        memcpy(to + 3 * i, twelve, 12); // what comes next is written over it
    }
#endif
    return to + 3 * count;
}
#endif

uint32_t CLAST_KERNEL(clast_displaced_place)(const displaced_reader *reader, const displaced_layout *layout,
                                             uint8_t corners[3 * TEMPLATE_TRIANGLES])
{
    const displaced_unit *unit = reader->unit;
    const displaced_triangle *triangles = unit->triangles + reader->cluster->first_triangle;
    uint32_t own_at = layout->shared_count;
    for (uint32_t i = 0; i < reader->leaf_count; i++) {
        uint32_t word = reader->words[i];
        displaced_pattern use = displaced_pattern_of(unit, displaced_leaf_factors(word));
        placed_leaf leaf = {triangles[displaced_leaf_triangle(word)], displaced_leaf_is_split(word), *use.pattern,
                            use.rotation, own_at};
        const uint32_t *of_pattern = unit->patterns->triangles + leaf.pattern.first_triangle;
        uint32_t vertices = pattern_vertices(leaf.pattern);
        own_at += vertices - (leaf.split ? 0 : pattern_edge_begin(pattern_own_factors(leaf.pattern), 3));
#if defined(SMALL_PATTERNS)
        if (!leaf.split && vertices <= SMALL) {
            corners = write_small(&leaf, layout, of_pattern, corners);
            continue;
        }
#endif
        corners = write_corners(&leaf, layout, of_pattern, corners);
    }
    return own_at - layout->shared_count;
}
