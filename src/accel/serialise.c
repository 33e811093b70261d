// SPDX-License-Identifier: Apache-2.0
// Writes a BLAS as one block (stored.h). Only the clusters that the tree has are written, in the order of their slots; they are
// numbered anew, from zero. Same tree, same bytes: nothing depends on where things lie in memory, and what no one reads is zero.
#include <string.h>

#define XXH_INLINE_ALL // so that the library needs no other at run time
#include <xxhash.h>

#include "accel/stored.h"
#include "base/thread.h"

uint64_t clast_stored_checksum(const stored_header *header)
{
    size_t skipped = offsetof(stored_header, checksum) + sizeof header->checksum;
    return XXH3_64bits((const uint8_t *)header + skipped, (size_t)header->bytes - skipped);
}

typedef struct writer {
    const clast_blas *blas;
    uint32_t *slots;      // of the clusters, ascending
    uint32_t *ranks;      // of the pool's slots among these; CLAST_NONE for others
    uint64_t *topologies; // where each cluster's begins among all; those that are shared are written once
    uint32_t count;
    stored_header header;
} writer;

static const clast_clas *cluster_of(const writer *w, uint32_t rank)
{
    return clast_pool_slot(w->blas->pool, w->slots[rank]);
}

// Finds the clusters.
static void rank_slots(writer *w)
{
    const clast_tree *tree = &w->blas->tree;
    size_t pool_count = w->blas->pool->count;
    for (size_t i = 0; i < pool_count; i++) {
        w->ranks[i] = CLAST_NONE;
    }
    for (uint32_t i = 0; i < tree->node_count; i++) {
        for (uint32_t k = 0; k < tree->nodes[i].child_count; k++) {
            uint32_t child = tree->nodes[i].children[k];
            if ((child & CLAST_CHILD_ITEM) != 0) {
                w->ranks[child & ~CLAST_CHILD_ITEM] = 0;
            }
        }
    }
    for (size_t i = 0; i < pool_count; i++) {
        if (w->ranks[i] != CLAST_NONE) {
            w->ranks[i] = w->count;
            w->slots[w->count++] = (uint32_t)i;
        }
    }
}

// Places topologies in the order in which they are first used. Sorting by address brings together who shares one, the first
// of them first, as the sort is stable; the addresses themselves decide nothing.
static clast_status place_topologies(writer *w)
{
    clast_context *context = w->blas->context;
    uint64_t *addresses = clast_allocate(context, w->count, sizeof *addresses);
    uint32_t *order = clast_allocate(context, w->count, sizeof *order);
    clast_status status = addresses != NULL && order != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        for (uint32_t i = 0; i < w->count; i++) {
            addresses[i] = (uintptr_t)clast_clas_topology(cluster_of(w, i));
            order[i] = i;
        }
        status = clast_sort_pairs(context, addresses, order, w->count);
    }
    for (uint32_t i = 0; status == CLAST_OK && i < w->count; i++) {
        bool shared = i > 0 && addresses[i] == addresses[i - 1];
        w->topologies[order[i]] = shared ? w->topologies[order[i - 1]] : order[i]; // for now: who has it first
    }
    for (uint32_t i = 0; status == CLAST_OK && i < w->count; i++) {
        const clast_clas *clas = cluster_of(w, i);
        if (clas->topology == 0) {
            continue;
        }
        const clast_template *topology = clast_clas_topology(clas);
        if (w->topologies[i] == i) {
            w->topologies[i] = w->header.topology_bytes;
            w->header.topology_bytes += stored_template_bytes(topology);
        } else {
            w->topologies[i] = w->topologies[w->topologies[i]];
        }
        w->header.vertex_bytes += stored_vertex_bytes(topology);
    }
    clast_free(context, addresses);
    clast_free(context, order);
    return status;
}

// Nodes go out as they are numbered in a search by levels, whatever their order was: a child then always follows.
static void write_nodes(const writer *w, clast_node *nodes)
{
    const clast_tree *tree = &w->blas->tree;
    uint32_t found = tree->node_count != 0 ? 1 : 0;
    if (found != 0) {
        nodes[0] = tree->nodes[0];
    }
    for (uint32_t i = 0; i < found; i++) {
        clast_node *node = &nodes[i];
        for (uint32_t k = 0; k < TREE_WIDTH; k++) {
            uint32_t *child = &node->children[k];
            if (k >= node->child_count) {
                *child = 0;
                for (int axis = 0; axis < 3; axis++) {
                    node->boxes[axis][0][k] = node->boxes[axis][1][k] = 0;
                }
            } else if ((*child & CLAST_CHILD_ITEM) != 0) {
                *child = CLAST_CHILD_ITEM | w->ranks[*child & ~CLAST_CHILD_ITEM];
            } else {
                nodes[found] = tree->nodes[*child];
                *child = found++;
            }
        }
    }
}

// The boxes of a cluster's blocks.
static void write_boxes(clast_clas *to, const clast_clas *from)
{
    for (uint32_t i = 0; i < from->block_count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            for (int side = 0; side < 2; side++) {
                to->groups[i / CLUSTER_WIDTH][axis][side][i % CLUSTER_WIDTH] =
                    from->groups[i / CLUSTER_WIDTH][axis][side][i % CLUSTER_WIDTH];
            }
        }
    }
}

static void write_clusters(const writer *w, uint8_t *memory)
{
    stored_layout layout = stored_layout_of(&w->header);
    uint8_t *vertices = memory + layout.vertices;
    for (uint32_t i = 0; i < w->count; i++) {
        const clast_clas *from = cluster_of(w, i);
        if (from->topology == 0) {
            continue; // nothing there: all zero
        }
        const clast_template *topology = clast_clas_topology(from);
        clast_clas *to = (clast_clas *)(void *)(memory + layout.slots + i * w->header.stride);
        uint8_t *stored_topology = memory + layout.topologies + w->topologies[i];
        *to = (clast_clas){.block_count = from->block_count,
                           .topology = clast_distance(to, stored_topology),
                           .vertices = clast_distance(to, vertices)};
        if (from->block_count != 0) {
            memcpy(to->lower, from->lower, sizeof to->lower);
            memcpy(to->exponents, from->exponents, sizeof to->exponents);
            write_boxes(to, from);
        }
        memcpy(stored_topology, topology, stored_template_bytes(topology));
        memcpy(vertices, clast_clas_vertices(from), stored_vertex_bytes(topology));
        vertices += stored_vertex_bytes(topology);
    }
}

static void write_block(writer *w, uint8_t *memory)
{
    memset(memory, 0, (size_t)w->header.bytes);
    write_nodes(w, (clast_node *)(void *)(memory + stored_layout_of(&w->header).nodes));
    write_clusters(w, memory);
    memcpy(memory, &w->header, sizeof w->header);
    stored_header *header = (stored_header *)(void *)memory;
    header->checksum = clast_stored_checksum(header);
}

static void describe(writer *w)
{
    stored_header *header = &w->header;
    memcpy(header->magic, STORED_MAGIC, sizeof STORED_MAGIC);
    header->version = STORED_VERSION;
    header->order = STORED_ORDER;
    header->node_count = w->blas->tree.node_count;
    header->slot_count = w->count;
    header->stride = w->blas->pool->stride;
    clast_box box = clast_tree_bounds(&w->blas->tree);
    header->box = box;
    header->bytes = stored_layout_of(header).end;
}

static clast_status write_all(writer *w, uint8_t *memory, size_t size, uint64_t *needed)
{
    rank_slots(w);
    clast_status status = place_topologies(w);
    if (status != CLAST_OK) {
        return status;
    }
    describe(w);
    *needed = w->header.bytes;
    if (memory == NULL) {
        return CLAST_OK;
    }
    if (size < w->header.bytes) {
        return clast_fail(w->blas->context, CLAST_ERROR_INVALID_ARGUMENT, "%zu bytes for a BLAS that needs %llu", size,
                          (unsigned long long)w->header.bytes);
    }
    write_block(w, memory);
    return CLAST_OK;
}

clast_status clast_blas_serialise(const clast_blas *blas, void *memory, size_t size, uint64_t *needed)
{
    if (blas == NULL || needed == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if ((uintptr_t)memory % STORED_ALIGNMENT != 0) {
        return clast_fail(blas->context, CLAST_ERROR_INVALID_ARGUMENT, "the memory given is not aligned to %d bytes",
                          STORED_ALIGNMENT);
    }
    clast_context *context = blas->context;
    size_t count = blas->pool->count;
    writer w = {.blas = blas,
                .slots = clast_allocate(context, count, sizeof *w.slots),
                .ranks = clast_allocate(context, count, sizeof *w.ranks),
                .topologies = clast_allocate(context, count, sizeof *w.topologies)};
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (w.slots != NULL && w.ranks != NULL && w.topologies != NULL) {
        status = write_all(&w, memory, size, needed);
    }
    clast_free(context, w.slots);
    clast_free(context, w.ranks);
    clast_free(context, w.topologies);
    return status;
}
