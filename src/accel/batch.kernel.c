// SPDX-License-Identifier: Apache-2.0
// Parts a batch: runs of rays that are alike become packets; the others take turns in a stream where the trees are large, and go
// one by one where they are not. The parting costs little and need not be right, as it changes no hits.
#include <math.h>

#include "accel/batch.h"

enum {
    PACKET_LEAST = 16,     // rays: fewer are not worth a packet
    SAMPLES = 8,           // of a run, that are looked at
    STREAM_INSTANCES = 16, // that are looked at
};

#define ALIKE_DIRECTION 0.15f  // between two rays of a run, where the largest component is one
#define ALIKE_ORIGIN 0.015625f // of the scene's size

// Whether two rays may go together.
static bool are_alike(const clast_ray *a, const clast_ray *b, float size)
{
    float x = fabsf(a->direction[0]), y = fabsf(a->direction[1]), z = fabsf(a->direction[2]);
    int axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    float scale_a = 1.0f / a->direction[axis], scale_b = 1.0f / b->direction[axis];
    bool alike = scale_a * scale_b > 0.0f;
    for (int k = 0; k < 3; k++) {
        alike &= fabsf(a->direction[k] * scale_a - b->direction[k] * scale_b) <= ALIKE_DIRECTION;
        alike &= fabsf(a->origin[k] - b->origin[k]) <= size;
    }
    return alike;
}

static bool is_run_alike(const clast_ray *rays, uint32_t count, float size)
{
    for (uint32_t i = 1; i < SAMPLES; i++) {
        if (!are_alike(&rays[0], &rays[(count - 1) * i / (SAMPLES - 1)], size)) {
            return false;
        }
    }
    return true;
}

static float size_of(const clast_tlas *tlas)
{
    float lower[3], upper[3];
    clast_tlas_bounds(tlas, lower, upper);
    return fmaxf(upper[0] - lower[0], fmaxf(upper[1] - lower[1], upper[2] - lower[2]));
}

// Whether unlike rays take turns, so that each fetches while others work.
static bool takes_turns(const clast_batch *batch)
{
    const clast_tlas *tlas = batch->tlas;
    bool is_large = tlas->placement_count >= STREAM_CLUSTERS;
    for (size_t i = 0; i < tlas->placement_count && i < STREAM_INSTANCES; i++) {
        const clast_blas *blas = tlas->placements[i].blas;
        is_large |= blas != NULL && blas->pool->count >= STREAM_CLUSTERS;
    }
    return is_large && batch->hits != NULL; // a search for any hit ends early
}

// Rays first to first + count of the batch.
static void trace_window(const clast_batch *batch, size_t first, uint32_t count, float alike, bool turns)
{
    const clast_batch part = {
        .tlas = batch->tlas,
        .rays = batch->rays + first,
        .filter = batch->filter,
        .hits = batch->hits != NULL ? batch->hits + first : NULL,
        .occluded = batch->occluded != NULL ? batch->occluded + first : NULL,
    };
    uint32_t numbers[BATCH_WINDOW], others = 0, run;
    bool packets = true;
    for (uint32_t i = 0; i < count; i += run) {
        run = count - i < PACKET_RAYS ? count - i : PACKET_RAYS;
        uint32_t *those = numbers + others;
        for (uint32_t k = 0; k < run; k++) {
            those[k] = i + k;
        }
        if (packets && run >= PACKET_LEAST && is_run_alike(part.rays + i, run, alike)) {
            packets = CLAST_KERNEL(clast_packet)(&part, those, run);
        } else {
            others += run;
        }
    }
    if (turns) {
        CLAST_KERNEL(clast_stream)(&part, numbers, others);
        return;
    }
    for (uint32_t i = 0; i < others; i++) {
        const clast_ray *ray = &part.rays[numbers[i]];
        if (part.hits != NULL) {
            CLAST_KERNEL(clast_closest)(part.tlas, ray, 1, part.filter, &part.hits[numbers[i]]);
        } else {
            CLAST_KERNEL(clast_any)(part.tlas, ray, 1, part.filter, &part.occluded[numbers[i]]);
        }
    }
}

void CLAST_KERNEL(clast_batch)(const clast_batch *batch, size_t count)
{
    float alike = size_of(batch->tlas) * ALIKE_ORIGIN;
    bool turns = takes_turns(batch);
    for (size_t first = 0; first < count; first += BATCH_WINDOW) {
        size_t left = count - first;
        trace_window(batch, first, left < BATCH_WINDOW ? (uint32_t)left : BATCH_WINDOW, alike, turns);
    }
}
