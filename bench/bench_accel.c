// SPDX-License-Identifier: Apache-2.0
// Cluster acceleration structures beside Embree: in one process, in turns, on the same geometry and the same rays.
//
//   refit_vs_refit       all vertices moved and lying in their clusters, everything else kept; Embree's refit
//   gathered_vs_refit    the same from the mesh's own vertices, the copy included
//   rebuild_vs_rebuild   clusters in another order each frame, nothing kept; Embree's fastest build of triangles
//   rebuild_vs_grids     the same; Embree's grids, their fastest build
//   build_static         from plain triangles, clusters and templates included; Embree's SAH build
//   bytes_per_triangle   all that the structures hold, vertices and indices included
//   primary_single, diffuse_single, anyhit_single   single-ray calls; Embree's, on a fresh SAH tree, in its fast mode
//   diffuse_vs_robust    the same; Embree's watertight mode
//   primary_batch, diffuse_batch                    the best batch call; the best of all of Embree's calls
//   diffuse_after_twist  single rays after parts were twisted by half a turn over 60 frames; a fresh SAH tree, and Embree's refit;
//                        twist_frame beside it: the worst frame's update
//   tlas_update          10,000 moved instances; Embree's fastest build of its scene of instances
//   tlas_partial         10,000 moved instances of 1,000,000
//
// Embree is run as it runs best: where it has several ways (calls, flags, scenes) they are tried first, and the row names the
// fastest; its rays lie ready in the layout of its call; it commits into memory that it has.
#include <stdio.h>

#include "accel_job.h"
#include "base/context.h"

enum { MOST_CLUSTERED = 8000000 }; // larger ones are measured as grids only

static void measure_workload(bench *b, const workload *w, bool grids, uint32_t threads)
{
    accel_job j = accel_job_begin(b, w, grids, threads);
    accel_measure_static(&j);
    accel_measure_updates(&j);
    accel_measure_rays(&j);
    if (!grids) {
        accel_measure_twist(&j);
    }
    accel_job_end(&j);
}

// Where no number of threads is asked for, one and two.
static void measure(bench *b, workload w, bool grids)
{
    for (uint32_t threads = 1; threads <= 2 && w.m.triangle_count > 0; threads++) {
        if (b->options.threads == 0 || threads == 1) {
            measure_workload(b, &w, grids, b->options.threads != 0 ? b->options.threads : threads);
        }
    }
    workload_free(&w);
}

static void measure_surfaces(bench *b, uint32_t triangles)
{
    for (surface kind = 0; kind < SURFACE_COUNT; kind++) {
        if (bench_wants(b, workload_surface_name(kind)) && (!b->options.quick || kind == SURFACE_SPHERE)) {
            measure(b, workload_surface(kind, triangles), true);
            if (!b->options.quick && triangles <= MOST_CLUSTERED) {
                measure(b, workload_surface(kind, triangles), false);
            }
        }
    }
}

// Without models there is a surface instead.
static void measure_pile(bench *b, clast_context *context, uint32_t triangles)
{
    if (bench_wants(b, "pile of scans") && triangles <= MOST_CLUSTERED) {
        workload pile = workload_pile(context, triangles);
        if (pile.m.triangle_count == 0 && b->options.quick) {
            workload_free(&pile);
            pile = workload_surface(SURFACE_CLOTH, triangles);
        }
        measure(b, pile, false);
    }
}

static void measure_models(bench *b, clast_context *context, uint32_t triangles)
{
    static const char *const models[] = {"lucy.ply", "bun_zipper.ply", "nefertiti-lowres.obj"};
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        if (bench_wants(b, models[i])) {
            measure(b, workload_model(context, models[i], triangles), false);
        }
    }
}

static void measure_size(bench *b, clast_context *context, uint32_t triangles)
{
    uint32_t repetitions = b->options.repetitions;
    b->options.repetitions = triangles > 2000000 || b->options.quick ? 3 : 5; // the whole takes a third of an hour
    measure_surfaces(b, triangles);
    measure_pile(b, context, triangles);
    if (!b->options.quick && triangles <= 1000000) {
        measure_models(b, context, triangles);
    }
    b->options.repetitions = repetitions;
}

static void measure_instances(bench *b)
{
    for (uint32_t threads = 1; threads <= 2 && bench_wants(b, "instances"); threads++) {
        if (b->options.threads == 0 || threads == 1) {
            // Embree takes seconds for each frame of a million: a quick run affords them once.
            bool all = !b->options.quick || b->options.threads != 0 || threads == 2;
            accel_measure_instances(b, b->options.threads != 0 ? b->options.threads : threads, all);
        }
    }
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "accel", count, arguments);
    const uint32_t sizes[] = {1000000, 4000000, 16000000};
    clast_context *context;
    bench_check(clast_context_create(NULL, &context), NULL);
    if (b.options.triangles != 0) {
        measure_size(&b, context, b.options.triangles);
    } else {
        for (int i = 0; i < (b.options.quick ? 1 : 3); i++) {
            measure_size(&b, context, sizes[i]);
        }
    }
    measure_instances(&b);
    clast_context_destroy(context);
    return bench_end(&b);
}
