// SPDX-License-Identifier: Apache-2.0
// What one workload's measurements share, on one number of threads, and what each of them is.
#ifndef CLAST_BENCH_ACCEL_JOB_H
#define CLAST_BENCH_ACCEL_JOB_H

#include "accel_structures.h"

typedef struct accel_job {
    bench *b;
    const workload *work;
    bool grids; // the workload as grids, not as clusters of any triangles
    uint32_t threads;
    clast_context *context;
    RTCDevice devices[PEER_DEVICES];
    structure ours;  // made of the shape at rest
    float *moved;    // the mesh's vertices at another moment
    uint32_t frame;  // counts moments
    peer theirs;     // of the measurement under way
    peer wide;       // the same on the other device, where both are tried on rays
    clast_ray *rays; // accel_job_rays of them
    clast_hit *hits;
    size_t ray_count;
} accel_job;

accel_job accel_job_begin(bench *b, const workload *w, bool grids, uint32_t threads);
void accel_job_end(accel_job *j);
// The number of rays that a camera makes: fewer in a quick run.
size_t accel_job_rays(const accel_job *j);
// Adds a row; `peer_detail` (may be null) goes behind the peer's name.
void accel_add_row(const accel_job *j, const char *metric, const char *unit, const char *peer_detail,
                   bench_pair values);
// The same beside something that is not Embree's.
void accel_add_own_row(const accel_job *j, const char *metric, const char *unit, const char *peer, bench_pair values);
// Of functions that give seconds: millions of triangles a second.
bench_pair accel_alternate(accel_job *j, bench_function clast, bench_function peer);
// Makes, over j->moved, of the kinds and devices the peer that commits fastest. Gives the kind.
peer_kind accel_choose_peer(accel_job *j, const peer_kind *kinds, uint32_t count);
// Makes j->theirs and j->wide, over j->moved, for rays; frees both.
void accel_make_peers(accel_job *j, peer_kind kind);
void accel_free_peers(accel_job *j);
// Ends the program where both sides do not hit the same number of times, but for a few: j->rays, j->ours, j->theirs.
void accel_check_hits(accel_job *j, const char *metric);

// accel_updates.c: build_static, bytes_per_triangle, refit_vs_refit, gathered_vs_refit, rebuild_vs_rebuild, rebuild_vs_grids
void accel_measure_static(accel_job *j);
void accel_measure_updates(accel_job *j);
// accel_rays.c: primary_single, primary_batch, diffuse_single, diffuse_vs_robust, diffuse_batch, anyhit_single
void accel_measure_rays(accel_job *j);
void accel_camera_rays(accel_job *j);
// Makes of j->rays, which have met j->hits, one bounce from each hit.
void accel_bounce_rays(accel_job *j);
// Traces single rays into j->hits.
void accel_trace_hits(accel_job *j);
// Single rays of j->rays through both, as a row.
void accel_measure_diffuse(accel_job *j, const char *metric, const char *peer_detail);
// accel_twist.c: diffuse_after_twist
void accel_measure_twist(accel_job *j);
// accel_instances.c: tlas_update and, with `all`, tlas_partial
void accel_measure_instances(bench *b, uint32_t threads, bool all);

#endif
