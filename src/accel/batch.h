// SPDX-License-Identifier: Apache-2.0
// Batches of rays: what the kernels for many rays at once are called with, and what they promise. Their hits are those
// of single rays, to the bit.
//
//   packet.kernel.c  64 rays that are alike go through the trees as one beam; 16 or 8 of them meet a triangle at once
//   stream.kernel.c  rays that have nothing in common take turns, so that each waits for memory while others compute
//   batch.kernel.c   parts a batch between the two
#ifndef CLAST_ACCEL_BATCH_H
#define CLAST_ACCEL_BATCH_H

#include "accel/structures.h"

enum {
    // Clusters, or instances, from which on a stream pays: of fewer, near caches hold so much that waiting is short, and taking turns
    // costs more.
    STREAM_CLUSTERS = 1 << 14,
    BATCH_LEAST = 8,    // rays: fewer go one by one
    BATCH_WINDOW = 512, // rays that are parted together
    PACKET_RAYS = 64,
    // Work of a packet for each of its rays, beyond which rays alone are faster. All instruction sets count alike.
    PACKET_WORK_MOST = 12, // steps of the tree
    PACKET_WORK_BLOCK = 2,
    PACKET_WORK_INSTANCE = 8,
};

typedef struct clast_batch {
    const clast_tlas *tlas;
    const clast_ray *rays;
    const clast_hit_filter *filter;
    clast_hit *hits;   // for the nearest hits
    uint8_t *occluded; // for any hits, where `hits` is null
} clast_batch;

typedef void (*clast_batch_kernel)(const clast_batch *batch, size_t count);

// At most PACKET_RAYS rays of a batch (false: they were too unlike, and went one by one in the end); any number of rays, for the
// nearest hits; all rays.
#define CLAST_DECLARE_BATCH_KERNELS(set) \
    bool clast_packet_##set(const clast_batch *batch, const uint32_t *numbers, uint32_t count); \
    void clast_stream_##set(const clast_batch *batch, const uint32_t *numbers, uint32_t count); \
    void clast_batch_##set(const clast_batch *batch, size_t count);
CLAST_EACH_ISA(CLAST_DECLARE_BATCH_KERNELS)

#endif
