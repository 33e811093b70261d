// SPDX-License-Identifier: Apache-2.0
// From vertices to where rays can be traced. Evaluating the vertices is no side's part, and is not timed.
#include "accel_job.h"

// -------------------------------------------------------------------------------------------------------------- static

static double build_ours(void *data)
{
    accel_job *j = data;
    structure s = structure_of_clusters(j->context, j->work);
    double seconds = s.build_seconds;
    structure_free(j->context, &s);
    return seconds;
}

static double commit_theirs(void *data)
{
    accel_job *j = data;
    double begun = bench_seconds();
    peer_commit(&j->theirs);
    return bench_seconds() - begun;
}

static void measure_bytes(accel_job *j)
{
    double triangles = (double)j->work->m.triangle_count, ours = structure_bytes(&j->ours);
    peer sah = peer_make(j->devices[0], j->work, j->work->m.positions, PEER_SAH);
    accel_add_row(j, "bytes_per_triangle", "bytes", NULL, (bench_pair){ours / triangles, sah.bytes / triangles});
    peer_free(&sah);
    if (j->grids) {
        peer grids = peer_make(j->devices[0], j->work, j->work->m.positions, PEER_GRIDS);
        accel_add_row(j, "bytes_per_triangle", "bytes", "grids",
                      (bench_pair){ours / triangles, grids.bytes / triangles});
        peer_free(&grids);
    }
}

void accel_measure_static(accel_job *j)
{
    const peer_kind kinds[] = {PEER_SAH, PEER_SAH_DYNAMIC};
    memcpy(j->moved, j->work->m.positions, (size_t)j->work->m.vertex_count * 12);
    measure_bytes(j);
    if (!j->grids) { // into the memory of the build before: a first build takes longer
        peer_kind kind = accel_choose_peer(j, kinds, 2);
        accel_add_row(j, "build_static", "Mtri/s", kind == PEER_SAH ? "static" : "dynamic",
                      accel_alternate(j, build_ours, commit_theirs));
        peer_free(&j->theirs);
    }
}

// --------------------------------------------------------------------------------------------------------------- refit

static void move(accel_job *j)
{
    workload_wave(j->context, j->work, 0.7f * (float)++j->frame, j->moved);
}

static double refit_ours(void *data)
{
    accel_job *j = data;
    move(j);
    structure_gather(j->context, &j->ours, j->moved);
    double begun = bench_seconds();
    structure_refit(j->context, &j->ours);
    return bench_seconds() - begun;
}

static double refit_gathered_ours(void *data)
{
    accel_job *j = data;
    move(j);
    double begun = bench_seconds();
    structure_refit_gathered(j->context, &j->ours, j->moved, j->work->m.vertex_count);
    return bench_seconds() - begun;
}

static double move_theirs(void *data)
{
    move(data);
    return commit_theirs(data);
}

// ------------------------------------------------------------------------------------------------------------- rebuild

// A frame's clusters as a source might emit them: in any order, each followed by the next one's vertices.
typedef struct emission {
    accel_job *job;
    float *vertices;
    clast_clas_input *inputs;
    uint32_t *order;
} emission;

static void emit(emission *e)
{
    accel_job *j = e->job;
    const structure *s = &j->ours;
    randoms r = {++j->frame};
    for (uint32_t i = s->cluster_count; i > 1; i--) { // Fisher and Yates
        uint32_t other = random_below(&r, i), swapped = e->order[i - 1];
        e->order[i - 1] = e->order[other];
        e->order[other] = swapped;
    }
    float *to = e->vertices;
    for (uint32_t i = 0; i < s->cluster_count; i++) {
        uint32_t cluster = e->order[i];
        e->inputs[i] = (clast_clas_input){s->templates[cluster], to};
        for (uint32_t v = s->first_vertex[cluster]; v < s->first_vertex[cluster + 1]; v++, to += 3) {
            memcpy(to, j->moved + 3 * (size_t)s->sources[v], 12);
        }
    }
}

static void build_emitted(const emission *e)
{
    accel_job *j = e->job;
    bench_check(clast_clas_instantiate(j->ours.pool, 0, j->ours.cluster_count, e->inputs), j->context);
    bench_check(clast_blas_build(j->ours.blas, NULL, j->ours.cluster_count, CLAST_BUILD_FAST), j->context);
    structure_build_tlas(j->context, &j->ours);
}

static double rebuild_ours(void *data)
{
    emission *e = data;
    move(e->job);
    emit(e);
    double begun = bench_seconds();
    build_emitted(e);
    return bench_seconds() - begun;
}

static double rebuild_theirs(void *data)
{
    return move_theirs(((emission *)data)->job);
}

static void measure_rebuild(accel_job *j, emission *e, const char *metric, peer_kind kind, peer_kind dynamic)
{
    const peer_kind kinds[] = {kind, dynamic};
    bool is_dynamic = accel_choose_peer(j, kinds, 2) == dynamic;
    double rate = 1e-6 * (double)j->work->m.triangle_count;
    bench_pair seconds = bench_alternate(j->b, rebuild_ours, rebuild_theirs, e);
    emit(e); // as the peer has them: both sides moved in turns
    build_emitted(e);
    if (kind == PEER_FAST) {
        accel_check_hits(j, metric);
    }
    accel_add_row(j, metric, "Mtri/s", is_dynamic ? "dynamic" : "static",
                  (bench_pair){rate / seconds.clast, rate / seconds.peer});
    peer_free(&j->theirs);
}

// The pool is built into: nothing of the job's structure can be used afterwards, until it is instantiated again.
static void measure_rebuilds(accel_job *j)
{
    emission e = {.job = j,
                  .vertices = bench_allocate(j->ours.vertex_count, 12),
                  .inputs = bench_allocate(j->ours.cluster_count, sizeof *e.inputs),
                  .order = bench_allocate(j->ours.cluster_count, sizeof *e.order)};
    for (uint32_t i = 0; i < j->ours.cluster_count; i++) {
        e.order[i] = i;
    }
    bench_check(clast_blas_reserve(j->ours.blas, j->ours.cluster_count), j->context);
    measure_rebuild(j, &e, "rebuild_vs_rebuild", PEER_FAST, PEER_FAST_DYNAMIC);
    if (j->grids) {
        measure_rebuild(j, &e, "rebuild_vs_grids", PEER_GRIDS, PEER_GRIDS_DYNAMIC);
    }
    free(e.vertices);
    free(e.inputs);
    free(e.order);
    structure_gather(j->context, &j->ours, j->work->m.positions);
    structure_instantiate(j->context, &j->ours);
}

static void measure_refit(accel_job *j, const char *metric, bench_function ours)
{
    accel_add_row(j, metric, "Mtri/s", NULL, accel_alternate(j, ours, move_theirs));
    structure_gather(j->context, &j->ours, j->moved); // as the peer has them: both sides moved in turns
    structure_refit(j->context, &j->ours);
    accel_check_hits(j, metric);
}

void accel_measure_updates(accel_job *j)
{
    const peer_kind refit = PEER_REFIT;
    move(j);
    accel_choose_peer(j, &refit, 1);
    measure_refit(j, "refit_vs_refit", refit_ours);
    if (!j->grids) {
        measure_refit(j, "gathered_vs_refit", refit_gathered_ours);
    }
    peer_free(&j->theirs);
    measure_rebuilds(j);
}
