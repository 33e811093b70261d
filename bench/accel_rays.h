// SPDX-License-Identifier: Apache-2.0
// Rays through both sides.
#ifndef CLAST_BENCH_ACCEL_RAYS_H
#define CLAST_BENCH_ACCEL_RAYS_H

#include "accel_structures.h"

// How Embree is called: one ray at a time, packets, or streams.
typedef enum peer_call {
    PEER_CALL_1,
    PEER_CALL_4,
    PEER_CALL_8,
    PEER_CALL_16,
    PEER_CALL_1M,
    PEER_CALL_8M, // rtcIntersectNM, of packets of 8
    PEER_CALL_COUNT,
} peer_call;

typedef struct peer_way {
    peer_call call;
    bool coherent; // the flag
    uint32_t wide; // which of the peer's devices
} peer_way;

// A peer's name for a way, as "rtcIntersect8, coherent".
void peer_way_name(peer_way way, bool any, char name[BENCH_NAME_SIZE]);

typedef struct ray_run {
    clast_context *context;
    const clast_tlas *ours;
    RTCScene theirs[PEER_DEVICES]; // null: not there
    const clast_ray *rays;
    size_t count;
    bool any;
    size_t batch; // rays a call of clast's; 1: one by one
    peer_way way;
    clast_hit *hits; // clast's, where `any` is false
    uint64_t found[2];
    uint32_t *packets; // Embree's rays, in the layout of the call; see ray_run_prepare
    size_t packet_bytes;
} ray_run;

// Seconds, of a ray_run. What is found is added to found[0] and found[1]. Embree's rays are made ready before the clock
// starts, in the layout that its call wants.
double ray_run_ours(void *run);
double ray_run_theirs(void *run);
// Finds the fastest of Embree's ways on these rays: all, or single ones only. And of clast's batches.
void ray_run_choose_way(ray_run *run, bool single);
void ray_run_choose_batch(ray_run *run);
void ray_run_free(ray_run *run);

#endif
