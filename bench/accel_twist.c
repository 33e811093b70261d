// SPDX-License-Identifier: Apache-2.0
// Parts twisted by half a turn over 60 frames. clast keeps what it has and refits it each frame; Embree refits a tree of its
// own, for comparison, and builds a fresh one on the last shape.
#include "accel_job.h"

enum { TWIST_FRAMES = 60 };

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void twist(accel_job *j, peer *refitted)
{
    double seconds[TWIST_FRAMES], worst = 0.0;
    for (uint32_t frame = 1; frame <= TWIST_FRAMES; frame++) {
        workload_twist(j->context, j->work, (float)frame / TWIST_FRAMES, j->moved);
        double begun = bench_seconds();
        structure_gather(j->context, &j->ours, j->moved);
        structure_refit(j->context, &j->ours);
        seconds[frame - 1] = bench_seconds() - begun;
        worst = fmax(worst, seconds[frame - 1]);
        peer_commit(refitted);
    }
    qsort(seconds, TWIST_FRAMES, sizeof seconds[0], compare_doubles);
    accel_add_row(j, "twist_frame", "ms", "worst frame beside twice the median frame",
                  (bench_pair){1e3 * worst, 2e3 * seconds[TWIST_FRAMES / 2]});
}

void accel_measure_twist(accel_job *j)
{
    workload_twist(j->context, j->work, 0.0f, j->moved);
    peer refitted = peer_make(j->device, j->work, j->moved, PEER_REFIT);
    twist(j, &refitted);
    j->theirs = peer_make(j->device, j->work, j->moved, PEER_SAH);
    accel_camera_rays(j);
    accel_trace_hits(j);
    accel_bounce_rays(j);
    accel_measure_diffuse(j, "diffuse_after_twist", "fresh tree");
    peer_free(&j->theirs);
    j->theirs = refitted;
    accel_measure_diffuse(j, "diffuse_after_twist", "refitted");
    peer_free(&j->theirs);
}
