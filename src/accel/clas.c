// SPDX-License-Identifier: Apache-2.0
// Pools of clusters.
#include <string.h>

#include "accel/structures.h"
#include "base/prefetch.h"
#include "base/size.h"
#include "base/thread.h"

enum { FIT_GRAIN = 64, EMPTY_GRAIN = 1024, SLOT_ALIGNMENT = 64, HEAD_AHEAD = 8, FETCH_AHEAD = 2 };

static size_t stride_for(uint32_t blocks)
{
    size_t groups = (blocks + CLUSTER_WIDTH - 1) / CLUSTER_WIDTH;
    size_t bytes = sizeof(clast_clas) + groups * sizeof(((clast_clas *)0)->groups[0]);
    return (bytes + SLOT_ALIGNMENT - 1) / SLOT_ALIGNMENT * SLOT_ALIGNMENT;
}

clast_status clast_clas_pool_create(clast_template_set *set, clast_clas_pool **pool)
{
    if (set == NULL || pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *pool = clast_allocate_zeroed(set->context, 1, sizeof **pool);
    if (*pool == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    **pool = (clast_clas_pool){.set = set, .context = set->context, .stride = stride_for(1)};
    return CLAST_OK;
}

void clast_clas_pool_destroy(clast_clas_pool *pool)
{
    if (pool != NULL) {
        clast_reserve_free(pool->context, &pool->reserve);
        clast_free(pool->context, pool);
    }
}

// -------------------------------------------------------------------------------------------------------------- memory

// What a slot takes. A topology's is zero in a pool whose clusters are all of templates, or set one by one: theirs take
// own_bytes together.
typedef struct slot_sizes {
    size_t stride, topology_stride, own_bytes;
} slot_sizes;

static size_t topology_bytes(uint32_t blocks)
{
    return sizeof(clast_template) + blocks * sizeof(clast_block);
}

static slot_sizes sizes_for(uint32_t blocks, uint32_t own_blocks)
{
    return (slot_sizes){stride_for(blocks > own_blocks ? blocks : own_blocks),
                        own_blocks != 0 ? topology_bytes(own_blocks) : 0, 0};
}

static void take_slots(clast_clas_pool *pool, size_t capacity, slot_sizes sizes, clast_arena *arena)
{
    pool->slots = clast_arena_take(arena, capacity, sizes.stride);
    pool->boxes = clast_arena_take(arena, capacity, sizeof *pool->boxes);
    pool->topologies = clast_arena_take(arena, capacity, sizes.topology_stride);
    pool->own = clast_arena_take(arena, sizes.own_bytes, 1);
    pool->stride = sizes.stride;
    pool->topology_stride = sizes.topology_stride;
    pool->own_bytes = sizes.own_bytes;
    pool->capacity = capacity;
}

static uint64_t bytes_for(size_t capacity, slot_sizes sizes)
{
    clast_clas_pool counted;
    clast_arena arena = {NULL, 0};
    take_slots(&counted, capacity, sizes, &arena);
    return arena.used;
}

static clast_template *own_topology(const clast_clas_pool *pool, size_t slot)
{
    return (clast_template *)(void *)(pool->topologies + slot * pool->topology_stride);
}

// Copies a slot into a pool that has the same one, or larger ones.
static void move_slot(clast_clas_pool *to_pool, const clast_clas_pool *from_pool, size_t slot)
{
    const clast_clas *from = clast_pool_slot(from_pool, slot);
    clast_clas *to = clast_pool_slot(to_pool, slot);
    memcpy(to, from, from_pool->stride);
    to_pool->boxes[slot] = from_pool->boxes[slot];
    to->vertices += from->vertices != 0 ? clast_distance(to, from) : 0;
    if (from->topology == 0) {
        return;
    }
    const clast_template *topology = clast_clas_topology(from);
    uintptr_t place = (uintptr_t)topology - (uintptr_t)from_pool->own;
    if (from_pool->topology_stride != 0 && topology == own_topology(from_pool, slot)) {
        memcpy(own_topology(to_pool, slot), topology, from_pool->topology_stride);
        to->topology = clast_distance(to, own_topology(to_pool, slot));
    } else if (place < from_pool->own_bytes) {
        memcpy(to_pool->own + place, topology, topology_bytes(topology->block_count));
        to->topology = clast_distance(to, to_pool->own + place);
    } else {
        to->topology += clast_distance(to, from);
    }
}

// Room for `capacity` slots of templates of `blocks` blocks, and of clusters of their own of `own_blocks`; keeps what is
// there.
static clast_status make_room(clast_clas_pool *pool, size_t capacity, uint32_t blocks, uint32_t own_blocks)
{
    slot_sizes sizes = sizes_for(blocks, own_blocks);
    sizes.stride = sizes.stride > pool->stride ? sizes.stride : pool->stride;
    sizes.topology_stride = sizes.topology_stride > pool->topology_stride ? sizes.topology_stride
                                                                          : pool->topology_stride;
    sizes.own_bytes = pool->own_bytes;
    if (capacity <= pool->capacity && sizes.stride == pool->stride && sizes.topology_stride == pool->topology_stride) {
        return CLAST_OK;
    }
    capacity = capacity > pool->capacity ? capacity : pool->capacity;
    if (pool->reserve.borrowed) {
        return clast_fail(pool->context, CLAST_ERROR_OUT_OF_MEMORY, "%llu bytes are needed; the memory given has %zu",
                          (unsigned long long)bytes_for(capacity, sizes), pool->reserve.bytes);
    }
    clast_clas_pool grown = *pool;
    grown.reserve = (clast_reserve){0};
    clast_status status = clast_reserve_own(pool->context, &grown.reserve, bytes_for(capacity, sizes));
    if (status != CLAST_OK) {
        return status;
    }
    clast_arena arena = {grown.reserve.memory, 0};
    take_slots(&grown, capacity, sizes, &arena);
    for (size_t i = 0; i < pool->count; i++) {
        move_slot(&grown, pool, i);
    }
    clast_reserve_free(pool->context, &pool->reserve);
    *pool = grown;
    return CLAST_OK;
}

uint64_t clast_clas_pool_memory(const clast_template_set *set, size_t count, uint32_t own_triangles)
{
    if (set == NULL || count > CLAST_CHILD_ITEM || own_triangles > TEMPLATE_TRIANGLES) {
        return UINT64_MAX;
    }
    uint32_t blocks = set->most_blocks != 0 ? set->most_blocks : 1;
    return bytes_for(count, sizes_for(blocks, clast_blocks_of(own_triangles)));
}

static clast_status check_own_triangles(const clast_clas_pool *pool, uint32_t own_triangles)
{
    if (own_triangles > TEMPLATE_TRIANGLES) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "clusters of %u triangles; %u are possible",
                          own_triangles, TEMPLATE_TRIANGLES);
    }
    return CLAST_OK;
}

clast_status clast_clas_pool_reserve_own(clast_clas_pool *pool, size_t count, uint32_t own_triangles)
{
    if (pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count > CLAST_CHILD_ITEM) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "a pool of %zu clusters; 2^31 are possible",
                          count);
    }
    clast_status status = check_own_triangles(pool, own_triangles);
    return status != CLAST_OK ? status : make_room(pool, count, pool->set->most_blocks, clast_blocks_of(own_triangles));
}

clast_status clast_clas_pool_reserve(clast_clas_pool *pool, size_t count)
{
    return clast_clas_pool_reserve_own(pool, count, 0);
}

clast_status clast_clas_pool_use_memory(clast_clas_pool *pool, void *memory, size_t bytes, uint32_t own_triangles)
{
    if (pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check_own_triangles(pool, own_triangles);
    status = status == CLAST_OK ? clast_reserve_borrow(pool->context, &pool->reserve, memory, bytes) : status;
    if (status != CLAST_OK) {
        return status;
    }
    uint32_t blocks = pool->set->most_blocks != 0 ? pool->set->most_blocks : 1;
    slot_sizes sizes = sizes_for(blocks, clast_blocks_of(own_triangles));
    // Each of the three arrays may end with a gap.
    size_t gaps = 3 * (ARENA_ALIGNMENT - 1), slot = sizes.stride + sizeof *pool->boxes + sizes.topology_stride;
    size_t capacity = memory != NULL && bytes > gaps ? (bytes - gaps) / slot : 0;
    while (capacity < CLAST_CHILD_ITEM && memory != NULL && bytes_for(capacity + 1, sizes) <= bytes) {
        capacity++;
    }
    clast_arena arena = {memory, 0};
    take_slots(pool, capacity < CLAST_CHILD_ITEM ? capacity : CLAST_CHILD_ITEM, sizes, &arena);
    pool->count = 0;
    return CLAST_OK;
}

static clast_status check_room(clast_context *context, const clast_clas_room *room)
{
    if (room->count > CLAST_CHILD_ITEM || room->most_triangles < 1 || room->most_triangles > TEMPLATE_TRIANGLES ||
        room->own_bytes > SIZE_MAX / 4) {
        return clast_fail(
            context, CLAST_ERROR_INVALID_ARGUMENT,
            "room for %zu clusters of up to %u triangles, and %zu bytes; 2^31 clusters of 1 to %u triangles "
            "are possible",
            room->count, room->most_triangles, room->own_bytes, TEMPLATE_TRIANGLES);
    }
    return CLAST_OK;
}

static slot_sizes sizes_of_room(const clast_clas_room *room)
{
    return (slot_sizes){stride_for(clast_blocks_of(room->most_triangles)), 0, room->own_bytes};
}

size_t clast_clas_own_bytes(uint32_t triangle_count)
{
    return topology_bytes(clast_blocks_of(triangle_count));
}

uint64_t clast_clas_room_bytes(const clast_clas_room *room)
{
    if (room == NULL || room->count > CLAST_CHILD_ITEM || room->most_triangles < 1 ||
        room->most_triangles > TEMPLATE_TRIANGLES || room->own_bytes > SIZE_MAX / 4) {
        return UINT64_MAX;
    }
    return bytes_for(room->count, sizes_of_room(room));
}

static void empty_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_clas_pool *pool = data;
    for (size_t i = begin; i < end; i++) {
        memset(clast_pool_slot(pool, i), 0, sizeof(clast_clas));
        pool->boxes[i] = clast_box_empty();
    }
}

clast_status clast_clas_pool_resize(clast_clas_pool *pool, const clast_clas_room *room)
{
    if (pool == NULL || room == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check_room(pool->context, room);
    if (status != CLAST_OK) {
        return status;
    }
    slot_sizes sizes = sizes_of_room(room);
    uint64_t bytes = bytes_for(room->count, sizes);
    bool grows = pool->reserve.memory != NULL && !pool->reserve.borrowed && bytes > pool->reserve.bytes;
    status = clast_reserve_fit(pool->context, &pool->reserve, grows ? bytes + bytes / 32 : bytes);
    if (status != CLAST_OK) {
        return status;
    }
    clast_arena arena = {pool->reserve.memory, 0};
    take_slots(pool, room->count, sizes, &arena);
    pool->count = room->count;
    clast_parallel_for(pool->context, pool->count, EMPTY_GRAIN, empty_range, pool);
    return CLAST_OK;
}

// ---------------------------------------------------------------------------------------------------------------- fit

// At most one of `inputs` and `clusters` is there; without both, only boxes are fitted.
typedef struct fit_job {
    clast_clas_pool *pool;
    const clast_clas_input *inputs;
    const clast_clas_desc *clusters;
    size_t first;
    clast_fit_kernel fit;
} fit_job;

// What a cluster is as a template.
static clast_template_desc desc_of(const clast_clas_desc *cluster)
{
    return (clast_template_desc){cluster->triangle_count, cluster->vertex_count, cluster->indices, cluster->vertices};
}

// Of a cluster that was checked.
static void build_topology(const clast_clas_pool *pool, const clast_clas_desc *cluster, clast_template *made)
{
    clast_template_desc desc = desc_of(cluster);
    if (!cluster->ordered) {
        clast_template_build(made, &desc);
        return;
    }
    *made = (clast_template){.triangle_count = (uint16_t)desc.triangle_count,
                             .vertex_count = (uint16_t)desc.vertex_count,
                             .block_count = (uint16_t)clast_blocks_of(desc.triangle_count),
                             .all_used = 1};
    clast_accel_kernels_of(clast_context_isa(pool->context))->order(made->blocks, desc.indices, desc.triangle_count);
}

static void fill_slot(const fit_job *job, size_t i, clast_clas *clas)
{
    const clast_clas_pool *pool = job->pool;
    if (job->inputs != NULL) {
        clas->topology = clast_distance(clas, pool->set->templates[job->inputs[i].template_number]);
        clas->vertices = clast_distance(clas, job->inputs[i].vertices);
    } else if (job->clusters != NULL) {
        clast_template *topology = own_topology(pool, job->first + i);
        build_topology(pool, &job->clusters[i], topology);
        clas->topology = clast_distance(clas, topology);
        clas->vertices = clast_distance(clas, job->clusters[i].vertices);
    }
}

// Clusters are small and may lie anywhere: what is read of one is fetched while those before it are fitted, its template's
// head first, which tells how much the rest is.
CLAST_FETCHES void prefetch_cluster(const fit_job *job, size_t i, bool head)
{
    const clast_template *topology;
    const float *vertices;
    if (job->inputs != NULL) {
        topology = job->pool->set->templates[job->inputs[i].template_number];
        vertices = job->inputs[i].vertices;
    } else {
        const clast_clas *clas = clast_pool_slot(job->pool, job->first + i);
        topology = clast_clas_topology(clas);
        vertices = clast_clas_vertices(clas);
        if (clas->topology == 0) {
            return;
        }
    }
    if (head) {
        __builtin_prefetch(topology);
        __builtin_prefetch(vertices);
    } else {
        clast_prefetch(topology->blocks, topology->block_count * sizeof *topology->blocks);
        clast_prefetch(vertices, topology->vertex_count * 3 * sizeof *vertices);
    }
}

static void fit_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    fit_job *job = data;
    for (size_t i = begin; i < end; i++) {
        if (i + HEAD_AHEAD < end && job->clusters == NULL) {
            prefetch_cluster(job, i + HEAD_AHEAD, true);
        }
        if (i + FETCH_AHEAD < end && job->clusters == NULL) {
            prefetch_cluster(job, i + FETCH_AHEAD, false);
        }
        clast_clas *clas = clast_pool_slot(job->pool, job->first + i);
        fill_slot(job, i, clas);
        if (clas->topology != 0) {
            job->fit(clas, &job->pool->boxes[job->first + i]);
        }
    }
}

static clast_status check_inputs(const clast_clas_pool *pool, const clast_clas_input *inputs, size_t count,
                                 uint32_t *most_blocks)
{
    // Templates may lie anywhere: they are looked at only where slots might have to grow.
    bool roomy = sizes_for(pool->set->most_blocks, 0).stride <= pool->stride;
    *most_blocks = roomy ? 1 : *most_blocks;
    for (size_t i = 0; i < count; i++) {
        uint32_t number = inputs[i].template_number;
        if (number >= pool->set->count) {
            return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu: template %u; the set has %zu",
                              i, number, pool->set->count);
        }
        if (inputs[i].vertices == NULL) {
            return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu has no vertices", i);
        }
        uint32_t blocks = roomy ? 1 : pool->set->templates[number]->block_count;
        *most_blocks = blocks > *most_blocks ? blocks : *most_blocks;
    }
    return CLAST_OK;
}

static clast_status check_clusters(const clast_clas_pool *pool, const clast_clas_desc *clusters, size_t count,
                                   uint32_t *most_blocks)
{
    for (size_t i = 0; i < count; i++) {
        clast_template_desc desc = desc_of(&clusters[i]);
        clast_status status = clast_template_check(pool->context, &desc, "cluster", i);
        if (status != CLAST_OK) {
            return status;
        }
        if (clusters[i].vertices == NULL) {
            return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu has no vertices", i);
        }
        uint32_t blocks = clast_blocks_of(desc.triangle_count);
        *most_blocks = blocks > *most_blocks ? blocks : *most_blocks;
    }
    return CLAST_OK;
}

static clast_status fill_slots(clast_clas_pool *pool, size_t first, size_t count, const clast_clas_input *inputs,
                               const clast_clas_desc *clusters)
{
    size_t end;
    if (!clast_add_size(first, count, &end) || end > CLAST_CHILD_ITEM) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "clusters %zu and on, %zu of them; a pool has 2^31 slots", first, count);
    }
    uint32_t most_blocks = 0;
    clast_status status = inputs != NULL ? check_inputs(pool, inputs, count, &most_blocks)
                                         : check_clusters(pool, clusters, count, &most_blocks);
    if (status == CLAST_OK) {
        bool doubles = end > pool->capacity && end <= 2 * pool->capacity && !pool->reserve.borrowed;
        status = make_room(pool, doubles ? 2 * pool->capacity : end, inputs != NULL ? most_blocks : 1,
                           inputs != NULL ? 0 : most_blocks);
    }
    if (status != CLAST_OK) {
        return status;
    }
    for (; pool->count < first; pool->count++) {
        memset(clast_pool_slot(pool, pool->count), 0, sizeof(clast_clas)); // skipped over: nothing there
        pool->boxes[pool->count] = clast_box_empty();
    }
    pool->count = end > pool->count ? end : pool->count;
    fit_job job = {pool, inputs, clusters, first, clast_accel_kernels_of(clast_context_isa(pool->context))->fit};
    clast_parallel_for(pool->context, count, FIT_GRAIN, fit_range, &job);
    return CLAST_OK;
}

clast_status clast_clas_instantiate(clast_clas_pool *pool, size_t first, size_t count, const clast_clas_input *inputs)
{
    if (pool == NULL || (inputs == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    return count != 0 ? fill_slots(pool, first, count, inputs, NULL) : CLAST_OK;
}

clast_status clast_clas_build(clast_clas_pool *pool, size_t first, size_t count, const clast_clas_desc *clusters)
{
    if (pool == NULL || (clusters == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    return count != 0 ? fill_slots(pool, first, count, NULL, clusters) : CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------- single slots

static clast_status check_slot(const clast_clas_pool *pool, size_t slot, uint32_t blocks, const float *vertices)
{
    if (slot >= pool->count || vertices == NULL || stride_for(blocks) > pool->stride) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "cluster %zu of %zu has no vertices, or %u blocks of triangles and room for less", slot,
                          pool->count, blocks);
    }
    return CLAST_OK;
}

static void set_slot(clast_clas_pool *pool, size_t slot, const clast_template *topology, const float *vertices)
{
    clast_clas *clas = clast_pool_slot(pool, slot);
    clas->topology = clast_distance(clas, topology);
    clas->vertices = clast_distance(clas, vertices);
    clast_accel_kernels_of(clast_context_isa(pool->context))->fit(clas, &pool->boxes[slot]);
}

clast_status clast_clas_set(clast_clas_pool *pool, size_t slot, const clast_clas_input *input)
{
    if (pool == NULL || input == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (input->template_number >= pool->set->count) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT, "cluster %zu: template %u; the set has %zu",
                          slot, input->template_number, pool->set->count);
    }
    const clast_template *topology = pool->set->templates[input->template_number];
    clast_status status = check_slot(pool, slot, topology->block_count, input->vertices);
    if (status == CLAST_OK) {
        set_slot(pool, slot, topology, input->vertices);
    }
    return status;
}

clast_status clast_clas_set_own(clast_clas_pool *pool, size_t slot, size_t place, const clast_clas_desc *cluster)
{
    if (pool == NULL || cluster == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_template_desc desc = desc_of(cluster);
    clast_status status = clast_template_check(pool->context, &desc, "cluster", slot);
    if (status == CLAST_OK) {
        status = check_slot(pool, slot, clast_blocks_of(desc.triangle_count), cluster->vertices);
    }
    if (status != CLAST_OK) {
        return status;
    }
    if (place % 8 != 0 || !clast_range_fits(place, clast_clas_own_bytes(desc.triangle_count), pool->own_bytes)) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "cluster %zu: triangles of its own at byte %zu; there is room for %zu", slot, place,
                          pool->own_bytes);
    }
    clast_template *topology = (clast_template *)(void *)(pool->own + place);
    build_topology(pool, cluster, topology);
    set_slot(pool, slot, topology, cluster->vertices);
    return CLAST_OK;
}

bool clast_clas_corners(const clast_clas_pool *pool, size_t slot, uint32_t triangle, float corners[3][3])
{
    memset(corners, 0, 9 * sizeof(float));
    const clast_clas *clas = pool != NULL && slot < pool->count ? clast_pool_slot(pool, slot) : NULL;
    uint32_t vertices[3];
    if (clas == NULL || clas->topology == 0 || !clast_template_corners(clast_clas_topology(clas), triangle, vertices)) {
        return false;
    }
    for (int k = 0; k < 3; k++) {
        memcpy(corners[k], clast_clas_vertices(clas) + 3 * (size_t)vertices[k], sizeof corners[k]);
    }
    return true;
}

void clast_clas_pool_truncate(clast_clas_pool *pool, size_t count)
{
    if (pool != NULL && count < pool->count) {
        pool->count = count;
    }
}

clast_status clast_clas_refit(clast_clas_pool *pool, size_t first, size_t count)
{
    if (pool == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (!clast_range_fits(first, count, pool->count)) {
        return clast_fail(pool->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "clusters %zu and on, %zu of them; the pool has %zu", first, count, pool->count);
    }
    fit_job job = {pool, NULL, NULL, first, clast_accel_kernels_of(clast_context_isa(pool->context))->fit};
    clast_parallel_for(pool->context, count, FIT_GRAIN, fit_range, &job);
    return CLAST_OK;
}

size_t clast_clas_pool_count(const clast_clas_pool *pool)
{
    return pool != NULL ? pool->count : 0;
}

uint64_t clast_clas_pool_bytes(const clast_clas_pool *pool)
{
    return pool != NULL ? sizeof *pool + pool->reserve.bytes : 0;
}
