// SPDX-License-Identifier: Apache-2.0
// Adaptive tessellation beside Embree: a displaced ground is cut anew each frame, with other segments than before.
//
//   frame_mtris_per_core  the whole frame (counts, records, vertices, boxes, trees); beside it the goal
//   frame_vs_rebuild      the same; Embree's fastest build of the same triangles, their vertices made by the same code
//   frame_vs_refit        the same; Embree's refit, which cannot follow where segments change
//   frame_vs_subdiv       the same; Embree's subdivision surface with as many triangles, displaced by a vectorised callback
//   trace_vs_sah          diffuse rays, one by one; Embree's SAH tree over the same triangles
//   bytes_per_triangle    records, vertices, clusters and trees; Embree's vertices, indices and tree
//   pass_*                nanoseconds a triangle of each pass, of the frame that took the least time
//
// Workloads: edges of 8 to 11 segments, 9 on average (long), and of 2 (short).
#include "tess.h"

#include <math.h>
#include <stdio.h>

#include "base/thread.h"
#include "frame/backend.h"

#define BACKEND_PASS(pass, function) [pass] = function,
static const clast_backend backend = {.name = "cpu", .passes = {CLAST_FRAME_CPU_PASSES(BACKEND_PASS)}};

// A workload: how long a segment is, in spacings of the ground.
typedef struct tess_kind {
    const char *name;
    float segment;
    float triangles; // of a base triangle, about: for the ground's size
    double goal;     // millions of triangles a second and core
    bool subdivision;
} tess_kind;

static const tess_kind kinds[] = {
    {"long", 1.0f / 9.3f, 88.0f, 150.0, true},
    {"short", 1.0f / 1.95f, 4.1f, 60.0, false},
};

typedef struct tess_job {
    bench *b;
    const tess_kind *kind;
    tess_ground ground;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;
    double segment;
    uint32_t frames;
    double least;                     // seconds of the frame that took the least
    double passes[CLAST_PASS_COUNT_]; // its milliseconds
    // The frame's triangles as Embree takes them.
    accel_job accel;
    workload work;
    clast_cluster_record *records;
    uint32_t *words;
    size_t record_count;
    tess_subdivision subdivision;
} tess_job;

// --------------------------------------------------------------------------------------------------------------- scene

static void make_scene(tess_job *j)
{
    clast_context *context = j->accel.context;
    j->scene = tess_ground_scene(&j->ground, context);
    bench_check(clast_cooked_create(context, &j->cooked), context);
    bench_check(clast_cooked_update(j->cooked, j->scene), context);
    bench_check(clast_frame_create(j->scene, j->cooked, &j->frame), context);
    j->frame->settings = tess_ground_settings(j->segment);
}

static void run_frame(tess_job *j)
{
    bench_check(clast_frame_run(j->frame, &backend, CLAST_PASS_ANIMATE, CLAST_PASS_TLAS, NULL), j->accel.context);
}

// Segments differ a little from frame to frame, so that none can be kept.
static double ours(void *data)
{
    tess_job *j = data;
    j->frame->settings.segment = j->segment * (1.0 + 0.004 * (double)(++j->frames % 3));
    double begun = bench_seconds();
    run_frame(j);
    double seconds = bench_seconds() - begun;
    if (j->least == 0.0 || seconds < j->least) {
        j->least = seconds;
        memcpy(j->passes, j->frame->milliseconds, sizeof j->passes);
    }
    return seconds;
}

// ---------------------------------------------------------------------------------------------------------------- peers

static const clast_frame_unit *unit_of(const tess_job *j)
{
    return &j->frame->units[0];
}

// The frame's triangles, over the vertices as they lie in the frame; and what is needed to make these again.
static void take_triangles(tess_job *j)
{
    const clast_frame_unit *unit = unit_of(j);
    const clast_source *source = clast_source_of(unit->unit);
    workload *w = &j->work;
    snprintf(w->name, sizeof w->name, "%s", j->kind->name);
    w->m = (mesh){bench_allocate(unit->vertex_count + 1, 12), bench_allocate((size_t)unit->sum.triangles + 1, 12),
                  (uint32_t)unit->vertex_count, (uint32_t)unit->sum.triangles};
    memcpy(w->m.positions, unit->vertices, unit->vertex_count * 12);
    uint32_t *corner = w->m.indices;
    for (size_t i = 0; i < unit->record_count; i++) {
        const clast_cluster_record *record = &unit->records[i];
        uint8_t corners[3 * TEMPLATE_TRIANGLES];
        bool composite = record_form(*record) == FORM_COMPOSITE;
        if (composite) {
            source->corners(unit->unit, record, clast_frame_words(unit, record), corners);
        }
        for (uint32_t t = 0; t < record_triangles(*record); t++) {
            uint32_t of[3] = {corners[3 * t], corners[3 * t + 1], corners[3 * t + 2]};
            if (!composite) {
                clast_template_triangle(j->cooked->templates, record->template_index, t, of);
            }
            for (int k = 0; k < 3; k++) {
                *corner++ = record->first_vertex + of[k];
            }
        }
    }
    j->record_count = unit->record_count;
    j->records = bench_allocate(unit->record_count, sizeof *j->records);
    memcpy(j->records, unit->records, unit->record_count * sizeof *j->records);
    j->words = bench_allocate(unit->word_count, sizeof *j->words);
    memcpy(j->words, unit->words, unit->word_count * sizeof *j->words);
    w->size = 8.0f;
    const float eye[3] = {4, -3, 4}, target[3] = {4, 4, 0};
    memcpy(w->eye, eye, sizeof eye);
    memcpy(w->target, target, sizeof target);
}

static void fill_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    tess_job *j = data;
    const clast_frame_unit *unit = unit_of(j);
    for (size_t i = begin; i < end; i++) {
        const clast_cluster_record *record = &j->records[i];
        clast_source_of(unit->unit)
            ->fill(unit->unit, &unit->pose, record, j->words + record->first_word,
                   (packed3 *)(void *)(j->accel.moved + 3 * (size_t)record->first_vertex));
    }
}

static double theirs(void *data)
{
    tess_job *j = data;
    double begun = bench_seconds();
    clast_parallel_for(j->accel.context, j->record_count, 32, fill_range, j);
    peer_commit(&j->accel.theirs);
    return bench_seconds() - begun;
}

static double theirs_subdivided(void *data)
{
    tess_job *j = data;
    tess_subdivision_levels(&j->subdivision, (float)(j->segment * (1.0 + 0.004 * (double)(j->frames % 3))));
    double begun = bench_seconds();
    tess_subdivision_commit(&j->subdivision);
    return bench_seconds() - begun;
}

// ------------------------------------------------------------------------------------------------------------ measuring

static bench_pair in_mtris(const tess_job *j, bench_pair seconds)
{
    double triangles = 1e-6 * (double)j->work.m.triangle_count;
    return (bench_pair){triangles / seconds.clast, triangles / seconds.peer};
}

static void measure_triangles(tess_job *j, const char *metric, const peer_kind *peers, uint32_t count)
{
    accel_choose_peer(&j->accel, peers, count);
    bench_pair seconds = bench_alternate(j->b, ours, theirs, j);
    accel_add_row(&j->accel, metric, "Mtri/s", NULL, in_mtris(j, seconds));
    peer_free(&j->accel.theirs);
}

static void measure_subdivision(tess_job *j)
{
    double least = 1e30;
    int best = 0;
    for (int i = 0; i < 2 * PEER_DEVICES; i++) {
        j->subdivision = tess_subdivision_make(j->accel.devices[i / 2], &j->ground, (float)j->segment, i % 2 != 0);
        double seconds = theirs_subdivided(j);
        best = seconds < least ? i : best;
        least = fmin(least, seconds);
        tess_subdivision_free(&j->subdivision);
    }
    j->subdivision = tess_subdivision_make(j->accel.devices[best / 2], &j->ground, (float)j->segment, best % 2 != 0);
    bench_pair seconds = bench_alternate(j->b, ours, theirs_subdivided, j);
    accel_add_row(&j->accel, "frame_vs_subdiv", "Mtri/s", "subdivision", in_mtris(j, seconds));
    tess_subdivision_free(&j->subdivision);
}

static double nothing(void *data)
{
    (void)data;
    return 1.0;
}

static void measure_frame(tess_job *j)
{
    bench_pair seconds = bench_alternate(j->b, ours, nothing, j);
    double mtris = in_mtris(j, seconds).clast / j->accel.threads;
    accel_add_own_row(&j->accel, "frame_mtris_per_core", "Mtri/s", "the goal", (bench_pair){mtris, j->kind->goal});
    static const char *const names[] = {
#define PASS_NAME(name, value, text, ...) [value] = "pass_" text,
        CLAST_PASS_LIST(PASS_NAME)
#undef PASS_NAME
    };
    double triangles = 1e-6 * (double)j->work.m.triangle_count;
    for (int i = 0; i <= CLAST_PASS_TLAS; i++) {
        bench_row row = {.triangles = j->work.m.triangle_count,
                         .threads = j->accel.threads,
                         .metric = names[i],
                         .unit = "ns/tri",
                         .less_is_better = true,
                         .clast = j->passes[i] / triangles};
        snprintf(row.workload, sizeof row.workload, "%s", j->kind->name);
        bench_add(j->b, row);
    }
}

// Rays, and bytes, of the frame whose triangles were taken.
static void measure_structures(tess_job *j)
{
    j->frame->settings.segment = j->segment;
    run_frame(j);
    memcpy(j->accel.moved, j->work.m.positions, (size_t)j->work.m.vertex_count * 12);
    accel_make_peers(&j->accel, PEER_SAH);
    clast_frame_bytes bytes = clast_frame_count_bytes(j->frame);
    double sum = (double)(bytes.records + bytes.vertices + bytes.clas + bytes.blas + bytes.tlas);
    double triangles = (double)j->work.m.triangle_count;
    accel_add_row(&j->accel, "bytes_per_triangle", "bytes", NULL,
                  (bench_pair){sum / triangles, j->accel.theirs.bytes / triangles});
    j->accel.ours.tlas = j->frame->tlas;
    accel_camera_rays(&j->accel);
    accel_trace_hits(&j->accel);
    accel_bounce_rays(&j->accel);
    accel_measure_diffuse(&j->accel, "trace_vs_sah", NULL);
    accel_free_peers(&j->accel);
}

static void begin_job(tess_job *j, uint32_t threads)
{
    accel_job *a = &j->accel;
    *a = (accel_job){.b = j->b, .work = &j->work, .threads = threads};
    bench_check(clast_context_create(&(clast_context_desc){.threads = threads}, &a->context), NULL);
    for (uint32_t i = 0; i < PEER_DEVICES; i++) {
        a->devices[i] = peer_device(threads, i);
    }
    make_scene(j);
    run_frame(j);
    take_triangles(j);
    a->moved = bench_allocate((size_t)j->work.m.vertex_count + 1, 12);
    memcpy(a->moved, j->work.m.positions, (size_t)j->work.m.vertex_count * 12);
    a->rays = bench_allocate(accel_job_rays(a), sizeof *a->rays);
    a->hits = bench_allocate(accel_job_rays(a), sizeof *a->hits);
}

static void end_job(tess_job *j)
{
    accel_job *a = &j->accel;
    free(a->moved);
    free(a->rays);
    free(a->hits);
    free(j->records);
    free(j->words);
    workload_free(&j->work);
    clast_frame_destroy(j->frame);
    clast_cooked_destroy(j->cooked);
    clast_scene_destroy(j->scene);
    clast_context_destroy(a->context);
    for (uint32_t i = 0; i < PEER_DEVICES; i++) {
        rtcReleaseDevice(a->devices[i]);
    }
    tess_ground_free(&j->ground);
}

static void measure(bench *b, const tess_kind *kind, uint32_t triangles, uint32_t threads)
{
    static const peer_kind rebuilds[] = {PEER_FAST, PEER_FAST_DYNAMIC}, refits[] = {PEER_REFIT};
    tess_job j = {.b = b, .kind = kind, .ground = tess_ground_make((uint32_t)((float)triangles / kind->triangles))};
    j.segment = (double)(j.ground.spacing * kind->segment);
    begin_job(&j, threads);
    if (bench_measures(b, "frame_mtris_per_core")) {
        measure_frame(&j);
    }
    if (bench_measures(b, "frame_vs_rebuild")) {
        measure_triangles(&j, "frame_vs_rebuild", rebuilds, 2);
    }
    if (bench_measures(b, "frame_vs_refit")) {
        measure_triangles(&j, "frame_vs_refit", refits, 1);
    }
    if (kind->subdivision && bench_measures(b, "frame_vs_subdiv")) {
        measure_subdivision(&j);
    }
    if (bench_measures(b, "bytes_per_triangle") || bench_measures(b, "trace_vs_sah")) {
        measure_structures(&j);
    }
    end_job(&j);
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "tess", count, arguments);
    uint32_t sizes[] = {1000000, 4000000, 16000000}, size_count = b.options.quick ? 1 : 3;
    if (b.options.triangles != 0) {
        sizes[0] = b.options.triangles;
        size_count = 1;
    }
    for (uint32_t i = 0; i < size_count; i++) {
        for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
            for (uint32_t threads = 1; threads <= 2 && bench_wants(&b, kinds[kind].name); threads++) {
                if (b.options.threads == 0 || threads == 1) {
                    measure(&b, &kinds[kind], sizes[i], b.options.threads != 0 ? b.options.threads : threads);
                }
            }
        }
    }
    return bench_end(&b);
}
