// SPDX-License-Identifier: Apache-2.0
// Jobs: what the measurements of a workload share.
#include "accel_job.h"

#include <stdio.h>

#include "base/context.h"

size_t accel_job_rays(const accel_job *j)
{
    return (size_t)1 << (j->b->options.quick ? 17 : 18);
}

accel_job accel_job_begin(bench *b, const workload *w, bool grids, uint32_t threads)
{
    accel_job j = {.b = b, .work = w, .grids = grids, .threads = threads};
    bench_check(clast_context_create(&(clast_context_desc){.threads = threads}, &j.context), j.context);
    for (uint32_t i = 0; i < PEER_DEVICES; i++) {
        j.devices[i] = peer_device(threads, i);
    }
    j.moved = bench_allocate(w->m.vertex_count, 12);
    j.rays = bench_allocate(accel_job_rays(&j), sizeof *j.rays);
    j.hits = bench_allocate(accel_job_rays(&j), sizeof *j.hits);
    j.ours = grids ? structure_of_grids(j.context, w) : structure_of_clusters(j.context, w);
    return j;
}

void accel_job_end(accel_job *j)
{
    structure_free(j->context, &j->ours);
    free(j->rays);
    free(j->hits);
    free(j->moved);
    clast_context_destroy(j->context);
    for (uint32_t i = 0; i < PEER_DEVICES; i++) {
        rtcReleaseDevice(j->devices[i]);
    }
}

void accel_add_own_row(const accel_job *j, const char *metric, const char *unit, const char *peer, bench_pair values)
{
    bench_row row = {.triangles = j->work->m.triangle_count,
                     .threads = j->threads,
                     .metric = metric,
                     .unit = unit,
                     .less_is_better = strcmp(unit, "bytes") == 0 || strcmp(unit, "ms") == 0,
                     .clast = values.clast,
                     .peer_value = values.peer};
    snprintf(row.workload, sizeof row.workload, "%.*s%s", BENCH_NAME_SIZE - 8, j->work->name,
             j->grids ? ", grids" : "");
    snprintf(row.peer, sizeof row.peer, "%.*s", BENCH_NAME_SIZE - 1, peer);
    bench_add(j->b, row);
}

void accel_add_row(const accel_job *j, const char *metric, const char *unit, const char *peer_detail, bench_pair values)
{
    char peer[BENCH_NAME_SIZE + 32];
    snprintf(peer, sizeof peer, "Embree %s%s%s", RTC_VERSION_STRING, peer_detail != NULL ? ", " : "",
             peer_detail != NULL ? peer_detail : "");
    accel_add_own_row(j, metric, unit, peer, values);
}

bench_pair accel_alternate(accel_job *j, bench_function clast, bench_function peer)
{
    bench_pair seconds = bench_alternate(j->b, clast, peer, j);
    double triangles = 1e-6 * (double)j->work->m.triangle_count;
    return (bench_pair){triangles / seconds.clast, triangles / seconds.peer};
}

static double time_of_commits(peer *p, int trials)
{
    double best = 1e30;
    for (int i = 0; i < trials; i++) {
        double begun = bench_seconds();
        peer_commit(p);
        best = fmin(best, bench_seconds() - begun);
    }
    return best;
}

peer_kind accel_choose_peer(accel_job *j, const peer_kind *kinds, uint32_t count)
{
    double least = 1e30;
    peer_kind chosen = kinds[0];
    j->theirs = (peer){0};
    for (uint32_t i = 0; i < count * PEER_DEVICES; i++) {
        peer p = peer_make(j->devices[i % PEER_DEVICES], j->work, j->moved, kinds[i / PEER_DEVICES]);
        double seconds = time_of_commits(&p, j->b->options.quick ? 1 : 2);
        peer worse = seconds < least ? j->theirs : p;
        if (seconds < least) {
            least = seconds;
            chosen = kinds[i / PEER_DEVICES];
            j->theirs = p;
        }
        if (worse.scene != NULL) {
            peer_free(&worse);
        }
    }
    return chosen;
}

void accel_make_peers(accel_job *j, peer_kind kind)
{
    j->theirs = peer_make(j->devices[0], j->work, j->moved, kind);
    j->wide = peer_make(j->devices[1], j->work, j->moved, kind);
}

void accel_free_peers(accel_job *j)
{
    peer_free(&j->theirs);
    peer_free(&j->wide);
}
