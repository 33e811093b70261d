// SPDX-License-Identifier: Apache-2.0
// A BLAS as one block of bytes, which rays can use wherever it lies: a header, then nodes, clusters, topologies and vertices,
// each aligned to 64 bytes and as long as the header's counts say, so that there is no offset to be wrong. The records are those
// in memory: a change to any of them is a change of the version.
#ifndef CLAST_ACCEL_STORED_H
#define CLAST_ACCEL_STORED_H

#include "accel/structures.h"

#define STORED_MAGIC "clastblas"
enum { STORED_VERSION = 1, STORED_MAGIC_SIZE = 10, STORED_ALIGNMENT = 64 };
#define STORED_ORDER 0x01020304u // reads as another number on a machine with another order of bytes

typedef struct stored_header {
    char magic[STORED_MAGIC_SIZE];
    uint16_t version;
    uint32_t order;
    uint64_t checksum; // XXH3, 64 bits, of all that follows it
    uint64_t bytes;    // of the whole block
    uint32_t node_count;
    uint32_t slot_count;
    uint64_t stride; // from one cluster to the next
    uint64_t topology_bytes;
    uint64_t vertex_bytes;
    clast_box box; // around all
    uint8_t zeros[40];
} stored_header;
_Static_assert(sizeof(stored_header) == 128, "no byte of the header is without a meaning");

// Where the parts begin, and the end.
typedef struct stored_layout {
    uint64_t nodes, slots, topologies, vertices, end;
} stored_layout;

static inline uint64_t stored_align(uint64_t bytes)
{
    return (bytes + STORED_ALIGNMENT - 1) / STORED_ALIGNMENT * STORED_ALIGNMENT;
}

// Counts are below 2^32, a stride below 2^16, and bytes below 2^62.
static inline stored_layout stored_layout_of(const stored_header *header)
{
    stored_layout layout = {.nodes = stored_align(sizeof *header)};
    layout.slots = stored_align(layout.nodes + (uint64_t)header->node_count * sizeof(clast_node));
    layout.topologies = stored_align(layout.slots + header->slot_count * header->stride);
    layout.vertices = stored_align(layout.topologies + header->topology_bytes);
    layout.end = stored_align(layout.vertices + header->vertex_bytes);
    return layout;
}

static inline size_t stored_template_bytes(const clast_template *topology)
{
    return sizeof *topology + topology->block_count * sizeof topology->blocks[0];
}

static inline size_t stored_vertex_bytes(const clast_template *topology)
{
    return topology->vertex_count * (3 * sizeof(float));
}

uint64_t clast_stored_checksum(const stored_header *header);

#endif
