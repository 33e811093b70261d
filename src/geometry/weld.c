// SPDX-License-Identifier: Apache-2.0
// Exact welding of positions. Vertices are spread over buckets by a hash of their position, each bucket in the order of the
// vertices; then every bucket is welded by one thread with a small hash table. Nothing depends on which thread or when. The
// other half of the hash goes along, so that positions are read again only where they are probably equal.
#include <string.h>

#include "base/thread.h"
#include "clast/geometry.h"

enum { VERTEX_CHUNK = 65536, BUCKET_BITS = 10, BUCKETS = 1 << BUCKET_BITS, PROBES_A_VERTEX = 32 };

#define FREE UINT64_MAX // no vertex has the number 2^32 - 1

typedef struct welder {
    clast_context *context;
    const float *positions;
    size_t count;
    uint32_t *remap;
    uint32_t *places; // [chunk][bucket]: how many, then where they go
    uint64_t *order;  // vertices by bucket, below the hash's lower half
    uint32_t first[BUCKETS + 1];
    uint64_t **tables; // one for each worker
    uint32_t *unique;  // one for each bucket
} welder;

typedef struct position_bits {
    uint32_t v[3];
} position_bits;

// The bits that decide, with one zero for both signs; false where a coordinate is not a number.
static inline bool bits_of(const welder *w, uint32_t vertex, position_bits *bits)
{
    memcpy(bits, w->positions + 3 * (size_t)vertex, sizeof *bits);
    bool number = true;
    for (int axis = 0; axis < 3; axis++) {
        uint32_t magnitude = bits->v[axis] & 0x7fffffffu;
        number = number && magnitude <= 0x7f800000u;
        bits->v[axis] = magnitude == 0 ? 0 : bits->v[axis];
    }
    return number;
}

static inline uint64_t hash_of(const position_bits *bits)
{
    uint64_t hash = (uint64_t)bits->v[0] << 32 | bits->v[1];
    hash = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9u;
    hash ^= bits->v[2];
    hash = (hash ^ hash >> 31) * 0x94d049bb133111ebu;
    return hash ^ hash >> 30;
}

static inline uint32_t bucket_of(uint64_t hash)
{
    return (uint32_t)(hash >> (64 - BUCKET_BITS));
}

static void count_chunk(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    welder *w = data;
    uint32_t *places = w->places + begin / VERTEX_CHUNK * BUCKETS;
    memset(places, 0, BUCKETS * sizeof *places);
    for (size_t i = begin; i < end; i++) {
        position_bits bits;
        if (bits_of(w, (uint32_t)i, &bits)) {
            places[bucket_of(hash_of(&bits))]++;
        } else {
            w->remap[i] = (uint32_t)i; // equal to nothing: in no bucket
        }
    }
}

static void spread_chunk(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    welder *w = data;
    uint32_t *places = w->places + begin / VERTEX_CHUNK * BUCKETS;
    for (size_t i = begin; i < end; i++) {
        position_bits bits;
        if (bits_of(w, (uint32_t)i, &bits)) {
            uint64_t hash = hash_of(&bits);
            w->order[places[bucket_of(hash)]++] = hash << 32 | i;
        }
    }
}

static void place_buckets(welder *w)
{
    size_t chunks = (w->count + VERTEX_CHUNK - 1) / VERTEX_CHUNK;
    uint32_t sum = 0;
    for (size_t bucket = 0; bucket < BUCKETS; bucket++) {
        w->first[bucket] = sum;
        for (size_t chunk = 0; chunk < chunks; chunk++) {
            uint32_t here = w->places[chunk * BUCKETS + bucket];
            w->places[chunk * BUCKETS + bucket] = sum;
            sum += here;
        }
    }
    w->first[BUCKETS] = sum;
}

// ------------------------------------------------------------------------------------- a bucket that defeats its table

static int compare(const welder *w, uint64_t a, uint64_t b)
{
    position_bits x, y;
    bits_of(w, (uint32_t)a, &x);
    bits_of(w, (uint32_t)b, &y);
    int order = memcmp(&x, &y, sizeof x); // any order of the bits will do
    return order != 0 ? order : (uint32_t)a < (uint32_t)b ? -1 : 1;
}

static void sift(const welder *w, uint64_t *heap, size_t parent, size_t count)
{
    for (size_t child = 2 * parent + 1; child < count; child = 2 * parent + 1) {
        child += child + 1 < count && compare(w, heap[child], heap[child + 1]) < 0;
        if (compare(w, heap[parent], heap[child]) > 0) {
            return;
        }
        uint64_t kept = heap[parent];
        heap[parent] = heap[child];
        heap[child] = kept;
        parent = child;
    }
}

static bool are_equal(const welder *w, uint64_t a, uint64_t b)
{
    position_bits x, y;
    bits_of(w, (uint32_t)a, &x);
    bits_of(w, (uint32_t)b, &y);
    return memcmp(&x, &y, sizeof x) == 0;
}

// Positions made to collide would take the table quadratic time: heap sort takes n log n on any.
static uint32_t weld_by_sorting(const welder *w, uint64_t *order, size_t count)
{
    for (size_t i = count / 2; i-- > 0;) {
        sift(w, order, i, count);
    }
    for (size_t i = count; i-- > 1;) {
        uint64_t kept = order[0];
        order[0] = order[i];
        order[i] = kept;
        sift(w, order, 0, i);
    }
    uint32_t unique = 0;
    for (size_t i = 0; i < count; i++) {
        bool same = i != 0 && are_equal(w, order[i - 1], order[i]);
        w->remap[(uint32_t)order[i]] = same ? w->remap[(uint32_t)order[i - 1]] : (uint32_t)order[i];
        unique += !same;
    }
    return unique;
}

// ------------------------------------------------------------------------------------------------------ a usual bucket

static size_t table_size_for(uint32_t count)
{
    size_t size = 16;
    while (size < 2 * (uint64_t)count) {
        size *= 2;
    }
    return size;
}

static uint32_t weld_bucket(const welder *w, uint64_t *table, uint64_t *order, uint32_t count)
{
    size_t size = table_size_for(count);
    uint32_t unique = 0;
    memset(table, 0xff, size * sizeof *table);
    uint64_t probes_left = (uint64_t)count * PROBES_A_VERTEX + 1024;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t entry = order[i];
        size_t slot = (entry >> 32) & (size - 1);
        while (table[slot] != FREE && (table[slot] >> 32 != entry >> 32 || !are_equal(w, table[slot], entry))) {
            slot = (slot + 1) & (size - 1);
            if (probes_left-- == 0) {
                return weld_by_sorting(w, order, count);
            }
        }
        if (table[slot] == FREE) { // in the order of the vertices: the first is the lowest
            table[slot] = entry;
            unique++;
        }
        w->remap[(uint32_t)entry] = (uint32_t)table[slot];
    }
    return unique;
}

static void weld_buckets(void *data, size_t begin, size_t end, uint32_t worker)
{
    welder *w = data;
    for (size_t bucket = begin; bucket < end; bucket++) {
        w->unique[bucket] = weld_bucket(w, w->tables[worker], w->order + w->first[bucket],
                                        w->first[bucket + 1] - w->first[bucket]);
    }
}

// A table for each worker, as large as the largest bucket wants.
static bool make_tables(welder *w)
{
    uint32_t most = 0;
    for (size_t bucket = 0; bucket < BUCKETS; bucket++) {
        uint32_t count = w->first[bucket + 1] - w->first[bucket];
        most = count > most ? count : most;
    }
    size_t size = table_size_for(most);
    for (uint32_t i = 0; i < clast_worker_count(w->context); i++) {
        w->tables[i] = clast_allocate(w->context, size, sizeof *w->tables[i]);
        if (w->tables[i] == NULL) {
            return false;
        }
    }
    return true;
}

static clast_status weld(welder *w, size_t *unique_count)
{
    clast_parallel_for(w->context, w->count, VERTEX_CHUNK, count_chunk, w);
    place_buckets(w);
    clast_parallel_for(w->context, w->count, VERTEX_CHUNK, spread_chunk, w);
    if (!make_tables(w)) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(w->context, BUCKETS, 16, weld_buckets, w);
    *unique_count = w->count - w->first[BUCKETS]; // those that are equal to nothing
    for (size_t bucket = 0; bucket < BUCKETS; bucket++) {
        *unique_count += w->unique[bucket];
    }
    return CLAST_OK;
}

clast_status clast_weld_positions(clast_context *context, const float *positions, size_t vertex_count, uint32_t *remap,
                                  size_t *unique_count)
{
    if (context == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (unique_count == NULL || (vertex_count != 0 && (positions == NULL || remap == NULL)) ||
        vertex_count > UINT32_MAX - 1) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "weld: expected arrays of at most 4294967294 vertices");
    }
    uint32_t workers = clast_worker_count(context);
    size_t chunks = (vertex_count + VERTEX_CHUNK - 1) / VERTEX_CHUNK;
    welder w = {
        .context = context,
        .positions = positions,
        .count = vertex_count,
        .remap = remap,
        .places = clast_allocate(context, chunks, BUCKETS * sizeof *w.places),
        .order = clast_allocate(context, vertex_count, sizeof *w.order),
        .tables = clast_allocate_zeroed(context, workers, sizeof *w.tables),
        .unique = clast_allocate(context, BUCKETS, sizeof *w.unique),
    };
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (w.places != NULL && w.order != NULL && w.tables != NULL && w.unique != NULL) {
        status = weld(&w, unique_count);
    }
    for (uint32_t i = 0; w.tables != NULL && i < workers; i++) {
        clast_free(context, w.tables[i]);
    }
    clast_free(context, w.places);
    clast_free(context, w.order);
    clast_free(context, w.tables);
    clast_free(context, w.unique);
    return status;
}
