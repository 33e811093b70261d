// SPDX-License-Identifier: Apache-2.0
// The loops over rays of both sides.
#include <stdatomic.h>
#include <stdio.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "accel_rays.h"
#include "base/thread.h"

enum { RAY_GRAIN = 4096, RAY_WORDS_MOST = 24, CALL_TRIALS = 2 };

static const struct {
    uint32_t width;
    size_t hit_bytes, any_bytes; // of a packet
    const char *name;
} calls[PEER_CALL_COUNT] = {
    [PEER_CALL_1] = {1, sizeof(struct RTCRayHit), sizeof(struct RTCRay), "1"},
    [PEER_CALL_4] = {4, sizeof(struct RTCRayHit4), sizeof(struct RTCRay4), "4"},
    [PEER_CALL_8] = {8, sizeof(struct RTCRayHit8), sizeof(struct RTCRay8), "8"},
    [PEER_CALL_16] = {16, sizeof(struct RTCRayHit16), sizeof(struct RTCRay16), "16"},
    [PEER_CALL_1M] = {1, sizeof(struct RTCRayHit), sizeof(struct RTCRay), "1M"},
    [PEER_CALL_8M] = {8, sizeof(struct RTCRayHit8), sizeof(struct RTCRay8), "NM of 8"},
};

void peer_way_name(peer_way way, bool any, char name[BENCH_NAME_SIZE])
{
    snprintf(name, BENCH_NAME_SIZE, "%s%s, %s, %u bits", any ? "rtcOccluded" : "rtcIntersect", calls[way.call].name,
             way.coherent ? "coherent" : "incoherent", 256u << way.wide);
}

// ------------------------------------------------------------------------------------------------------------- clast's

typedef struct trace_job {
    ray_run *run;
    atomic_uint_fast64_t found;
} trace_job;

static void ours_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    trace_job *job = data;
    const ray_run *run = job->run;
    uint64_t found = 0;
    uint8_t occluded[RAY_GRAIN];
    for (size_t i = begin; i < end; i += run->batch) {
        size_t count = end - i < run->batch ? end - i : run->batch;
        if (run->any) {
            clast_trace_any(run->ours, run->rays + i, count, NULL, occluded);
        } else {
            clast_trace_closest(run->ours, run->rays + i, count, NULL, run->hits + i);
        }
        for (size_t k = 0; k < count; k++) {
            found += run->any ? occluded[k] : run->hits[i + k].instance != CLAST_NONE;
        }
    }
    atomic_fetch_add(&job->found, found);
}

double ray_run_ours(void *data)
{
    ray_run *run = data;
    trace_job job = {.run = run};
    double begun = bench_seconds();
    clast_parallel_for(run->context, run->count, RAY_GRAIN, ours_range, &job);
    double seconds = bench_seconds() - begun;
    run->found[0] += job.found;
    return seconds;
}

// ------------------------------------------------------------------------------------------------------------- Embree's

static size_t packet_size(const ray_run *run)
{
    return run->any ? calls[run->way.call].any_bytes : calls[run->way.call].hit_bytes;
}

// The order of a packet's arrays is that of the members of RTCRay and RTCHit, which have one word each.
enum { WORD_FAR = 8, WORD_MASK = 9, WORD_GEOMETRY = 18, WORD_INSTANCE = 19 };

static void prepare_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    ray_run *run = data;
    uint32_t width = calls[run->way.call].width;
    size_t bytes = packet_size(run);
    for (size_t i = begin; i < end; i++) {
        const clast_ray *ray = &run->rays[i < run->count ? i : run->count - 1];
        uint32_t *words = run->packets + i / width * (bytes / 4) + i % width;
        const float values[9] = {ray->origin[0],    ray->origin[1],    ray->origin[2], ray->t_min, ray->direction[0],
                                 ray->direction[1], ray->direction[2], 0.0f,           ray->t_max};
        for (uint32_t k = 0; k < 9; k++) {
            memcpy(words + k * width, &values[k], 4);
        }
        words[WORD_MASK * width] = ~0u;
        words[(WORD_MASK + 1) * width] = 0;
        words[(WORD_MASK + 2) * width] = 0;
        if (!run->any) {
            words[WORD_GEOMETRY * width] = RTC_INVALID_GEOMETRY_ID;
            words[WORD_INSTANCE * width] = RTC_INVALID_GEOMETRY_ID;
        }
    }
}

static size_t padded_count(const ray_run *run)
{
    uint32_t width = calls[run->way.call].width;
    return (run->count + width - 1) / width * width;
}

static void prepare(ray_run *run)
{
    size_t bytes = padded_count(run) / calls[run->way.call].width * packet_size(run);
    if (bytes > run->packet_bytes) {
        free(run->packets);
        run->packets = bench_allocate(bytes / 64 + 1, 64);
        run->packet_bytes = bytes;
    }
    clast_parallel_for(run->context, padded_count(run), RAY_GRAIN, prepare_range, run);
}

#if RTC_VERSION_MAJOR >= 4
#define PEER_INTERSECT(width, packet) rtcIntersect##width(valid, run->theirs[run->way.wide], packet, &intersect)
#define PEER_OCCLUDED(width, packet) rtcOccluded##width(valid, run->theirs[run->way.wide], packet, &occluded)
#else
#define PEER_INTERSECT(width, packet) rtcIntersect##width(valid, run->theirs[run->way.wide], &context, packet)
#define PEER_OCCLUDED(width, packet) rtcOccluded##width(valid, run->theirs[run->way.wide], &context, packet)
#endif

static void call_range(const ray_run *run, uint8_t *packet, size_t count)
{
    static const _Alignas(64) int valid[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    size_t bytes = packet_size(run);
#if RTC_VERSION_MAJOR >= 4
    struct RTCIntersectArguments intersect;
    struct RTCOccludedArguments occluded;
    rtcInitIntersectArguments(&intersect);
    rtcInitOccludedArguments(&occluded);
    intersect.flags = occluded.flags = run->way.coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = run->way.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    if (run->way.call == PEER_CALL_1M) {
        run->any ? rtcOccluded1M(run->theirs[run->way.wide], &context, (void *)packet, (unsigned)count, bytes)
                 : rtcIntersect1M(run->theirs[run->way.wide], &context, (void *)packet, (unsigned)count, bytes);
        return;
    }
    if (run->way.call == PEER_CALL_8M) {
        run->any ? rtcOccludedNM(run->theirs[run->way.wide], &context, (void *)packet, 8, (unsigned)count, bytes)
                 : rtcIntersectNM(run->theirs[run->way.wide], &context, (void *)packet, 8, (unsigned)count, bytes);
        return;
    }
#endif
    for (size_t i = 0; i < count; i++, packet += bytes) {
        void *p = packet;
        switch (run->way.call) {
#if RTC_VERSION_MAJOR >= 4
        case PEER_CALL_1:
            run->any ? rtcOccluded1(run->theirs[run->way.wide], p, &occluded)
                     : rtcIntersect1(run->theirs[run->way.wide], p, &intersect);
            break;
#else
        case PEER_CALL_1:
            run->any ? rtcOccluded1(run->theirs[run->way.wide], &context, p)
                     : rtcIntersect1(run->theirs[run->way.wide], &context, p);
            break;
#endif
        case PEER_CALL_4: run->any ? PEER_OCCLUDED(4, p) : PEER_INTERSECT(4, p); break;
        case PEER_CALL_8: run->any ? PEER_OCCLUDED(8, p) : PEER_INTERSECT(8, p); break;
        default: run->any ? PEER_OCCLUDED(16, p) : PEER_INTERSECT(16, p); break;
        }
    }
}

// Embree's advice: denormals are flushed while rays are traced.
static uint32_t flush_denormals(void)
{
#if defined(__x86_64__)
    uint32_t before = _mm_getcsr();
    _mm_setcsr(before | 0x8040u);
    return before;
#else
    return 0;
#endif
}

static void restore_denormals(uint32_t before)
{
#if defined(__x86_64__)
    _mm_setcsr(before);
#else
    (void)before;
#endif
}

static void theirs_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    trace_job *job = data;
    const ray_run *run = job->run;
    uint32_t width = calls[run->way.call].width;
    size_t words = packet_size(run) / 4, last = end < run->count ? end : run->count;
    uint32_t *packets = run->packets + begin / width * words;
    uint32_t before = flush_denormals();
    call_range(run, (uint8_t *)packets, (end - begin) / width);
    restore_denormals(before);
    uint64_t found = 0;
    for (size_t i = 0; i < last - begin; i++) {
        const uint32_t *ray = packets + i / width * words + i % width;
        found += run->any ? ray[WORD_FAR * width] >> 31 // a negative distance
                          : ray[WORD_GEOMETRY * width] != RTC_INVALID_GEOMETRY_ID;
    }
    atomic_fetch_add(&job->found, found);
}

double ray_run_theirs(void *data)
{
    ray_run *run = data;
    trace_job job = {.run = run};
    prepare(run);
    double begun = bench_seconds();
    clast_parallel_for(run->context, padded_count(run), RAY_GRAIN, theirs_range, &job);
    double seconds = bench_seconds() - begun;
    run->found[1] += job.found;
    return seconds;
}

// -------------------------------------------------------------------------------------------------------------- choice

// On a quarter of the rays, from their middle.
static double best_of_trials(ray_run *run, bench_function function)
{
    ray_run part = *run;
    if (run->count / 4 > RAY_GRAIN) {
        part.count = run->count / 4;
        part.rays += run->count / 8 * 3;
    }
    double best = 1e30;
    for (int i = 0; i < CALL_TRIALS; i++) {
        best = fmin(best, function(&part));
    }
    run->packets = part.packets;
    run->packet_bytes = part.packet_bytes;
    return best;
}

void ray_run_choose_way(ray_run *run, bool single)
{
    peer_way best = {0};
    double least = 1e30;
    for (peer_call call = PEER_CALL_1; call < PEER_CALL_COUNT && !(single && call != PEER_CALL_1); call++) {
#if RTC_VERSION_MAJOR >= 4
        if (call == PEER_CALL_1M || call == PEER_CALL_8M) {
            continue; // gone in Embree 4
        }
#endif
        for (uint32_t i = 0; i < 4; i++) {
            run->way = (peer_way){call, i % 2 != 0, i / 2};
            if (run->theirs[run->way.wide] == NULL) {
                continue;
            }
            double seconds = best_of_trials(run, ray_run_theirs);
            if (seconds < least) {
                least = seconds;
                best = run->way;
            }
        }
    }
    run->way = best;
}

void ray_run_choose_batch(ray_run *run)
{
    static const size_t batches[] = {16, 64, 256, 1024, RAY_GRAIN};
    size_t best = batches[0];
    double least = 1e30;
    for (size_t i = 0; i < sizeof batches / sizeof batches[0]; i++) {
        run->batch = batches[i];
        double seconds = best_of_trials(run, ray_run_ours);
        if (seconds < least) {
            least = seconds;
            best = run->batch;
        }
    }
    run->batch = best;
}

void ray_run_free(ray_run *run)
{
    free(run->packets);
}
