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
        structure_refit_gathered(j->context, &j->ours, j->moved, j->work->m.vertex_count);
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
    peer refitted = peer_make(j->devices[0], j->work, j->moved, PEER_REFIT);
    twist(j, &refitted);
    accel_make_peers(j, PEER_SAH);
    accel_camera_rays(j);
    accel_trace_hits(j);
    accel_bounce_rays(j);
    accel_measure_diffuse(j, "diffuse_after_twist", "fresh tree");
    accel_free_peers(j);
    j->theirs = refitted;
    accel_measure_diffuse(j, "diffuse_after_twist", "refitted");
    peer_free(&j->theirs);
}
