// SPDX-License-Identifier: Apache-2.0
// Parts twisted by half a turn over 60 frames. clast's mesh watches how good its clusters and its tree are, and mends them piece by
// piece; Embree builds a fresh tree on the last shape and, for comparison, refits one that it built on the first.
#include "accel_job.h"

enum { TWIST_FRAMES = 60, TWIST_PASSES = 3 };

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static clast_deforming_mesh *make_mesh(const accel_job *j, bool unwatched)
{
    const mesh *m = &j->work->m;
    clast_deforming_mesh *made;
    clast_deforming_mesh_desc desc = {.positions = m->positions,
                                      .position_count = m->vertex_count,
                                      .indices = m->indices,
                                      .triangle_count = m->triangle_count,
                                      .unwatched = unwatched};
    bench_check(clast_deforming_mesh_create(j->context, &desc, &made), j->context);
    return made;
}

// Seconds of an update, if they are fewer than `least`: what a frame takes does not depend on the pass.
static double time_update(const accel_job *j, clast_deforming_mesh *m, double least)
{
    double begun = bench_seconds();
    bench_check(clast_deforming_mesh_update(m, j->moved, NULL), j->context);
    return fmin(least, bench_seconds() - begun);
}

// Gives the mesh as it is in the end.
static clast_deforming_mesh *twist(accel_job *j)
{
    double watched[TWIST_FRAMES], usual[TWIST_FRAMES], longest = 0.0;
    clast_deforming_mesh *twisted = NULL;
    for (uint32_t pass = 0; pass < TWIST_PASSES; pass++) {
        clast_deforming_mesh_destroy(twisted);
        clast_deforming_mesh *plain = make_mesh(j, true);
        twisted = make_mesh(j, false);
        for (uint32_t i = 0; i < TWIST_FRAMES; i++) {
            workload_twist(j->context, j->work, (float)(i + 1) / TWIST_FRAMES, j->moved);
            watched[i] = time_update(j, twisted, pass > 0 ? watched[i] : 1e30);
            usual[i] = time_update(j, plain, pass > 0 ? usual[i] : 1e30);
        }
        clast_deforming_mesh_destroy(plain);
    }
    for (uint32_t i = 0; i < TWIST_FRAMES; i++) {
        longest = fmax(longest, watched[i]);
    }
    qsort(usual, TWIST_FRAMES, sizeof usual[0], compare_doubles);
    accel_add_own_row(j, "twist_frame", "ms", "twice the median update of an unwatched mesh",
                      (bench_pair){1e3 * longest, 2e3 * usual[TWIST_FRAMES / 2]});
    return twisted;
}

static void measure_rays(accel_job *j)
{
    workload_twist(j->context, j->work, 0.0f, j->moved);
    peer refitted = peer_make(j->devices[0], j->work, j->moved, PEER_REFIT);
    workload_twist(j->context, j->work, 1.0f, j->moved);
    peer_commit(&refitted);
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

void accel_measure_twist(accel_job *j)
{
    clast_deforming_mesh *twisted = twist(j);
    clast_tlas_instance instance = instance_of(clast_deforming_mesh_blas(twisted), 0);
    clast_tlas *kept = j->ours.tlas;
    bench_check(clast_tlas_create(j->context, &j->ours.tlas), j->context);
    bench_check(clast_tlas_build(j->ours.tlas, &instance, 1, CLAST_BUILD_BEST), j->context);
    measure_rays(j);
    clast_tlas_destroy(j->ours.tlas);
    j->ours.tlas = kept;
    clast_deforming_mesh_destroy(twisted);
}
