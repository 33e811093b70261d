// SPDX-License-Identifier: Apache-2.0
// Adaptive tessellation on a Vulkan device: a displaced ground is cut anew each frame, with other segments than before. Times are
// the device's own, in milliseconds, by the passes' names there.
//
//   count       rates, splits and packing of all items
//   emit        records and words: from drafts where there are some
//   fill        vertices, and clusters fitted to them
//   blas, tlas  trees
//   all         their sum: what lies between them on the processor is not in it
//
// Workloads: edges of 8 to 11 segments (long), of 2 (short), and of 30, which are split (split).
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clast/clast.h"
#include "tess_ground.h"
#include "vulkan/render.h"
#include "vulkan_open.h"

enum { FRAMES = 15, FRAMES_QUICK = 7, PASSES_MOST = 16 };

typedef struct tess_kind {
    const char *name;
    float segment;   // in spacings of the ground
    float triangles; // of a base triangle, about: for the ground's size
} tess_kind;

static const tess_kind kinds[] = {
    {"long", 1.0f / 9.3f, 88.0f}, {"short", 1.0f / 1.95f, 4.1f}, {"split", 1.0f / 30.0f, 900.0f}};

// A pass's times, by frame.
typedef struct pass_times {
    const char *name;
    double milliseconds[FRAMES];
} pass_times;

typedef struct tess_work {
    clast_context *context;
    clast_gpu *gpu;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;
    clast_vulkan_frame *device;
    double segment;
    pass_times passes[PASSES_MOST];
    uint32_t pass_count;
} tess_work;

// --------------------------------------------------------------------------------------------------------------- scene

static void make_scene(tess_work *w, const tess_ground *g)
{
    w->scene = tess_ground_scene(g, w->context);
    bench_check(clast_cooked_create(w->context, &w->cooked), w->context);
    bench_check(clast_cooked_update(w->cooked, w->scene), w->context);
    bench_check(clast_frame_create(w->scene, w->cooked, &w->frame), w->context);
    bench_check(clast_vulkan_frame_create(w->gpu, &w->device), w->context);
    w->frame->device = w->device;
    w->frame->settings = tess_ground_settings(w->segment);
}

static void free_scene(tess_work *w)
{
    clast_vulkan_frame_destroy(w->device);
    clast_frame_destroy(w->frame);
    clast_cooked_destroy(w->cooked);
    clast_scene_destroy(w->scene);
}

// --------------------------------------------------------------------------------------------------------------- times

static void take_times(tess_work *w, uint32_t frame)
{
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t count = clast_gpu_passes(w->gpu, times);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t pass = 0;
        while (pass < w->pass_count && strcmp(w->passes[pass].name, times[i].pass) != 0) {
            pass++;
        }
        if (pass == PASSES_MOST) {
            continue;
        }
        if (pass == w->pass_count) {
            w->passes[w->pass_count++] = (pass_times){.name = times[i].pass};
        }
        w->passes[pass].milliseconds[frame] += times[i].milliseconds;
    }
}

// Segments differ a little from frame to frame, so that none can be kept. What frames begin with, kernels and memory, is over
// after two of them.
static void run_frames(tess_work *w, uint32_t frames)
{
    for (uint32_t i = 0; i < frames + 2; i++) {
        vulkan_wake(w->context, w->gpu);
        w->frame->settings.segment = w->segment * (1.0 + 0.004 * (double)(i % 3));
        bench_check(clast_frame_run(w->frame, &clast_vulkan_backend, CLAST_PASS_ANIMATE, CLAST_PASS_FIT, NULL),
                    w->context);
        if (i >= 2) {
            take_times(w, i - 2);
        }
        bench_check(clast_frame_run(w->frame, &clast_vulkan_backend, CLAST_PASS_EMIT, CLAST_PASS_TLAS, NULL),
                    w->context);
        if (i >= 2) {
            take_times(w, i - 2);
        }
    }
}

static void measure(bench *b, clast_context *context, clast_gpu *gpu, const tess_kind *kind, uint32_t triangles)
{
    uint32_t frames = b->options.quick ? FRAMES_QUICK : FRAMES;
    tess_ground ground = tess_ground_make((uint32_t)((float)triangles / kind->triangles) + 1);
    tess_work w = {.context = context, .gpu = gpu, .segment = (double)(ground.spacing * kind->segment)};
    make_scene(&w, &ground);
    run_frames(&w, frames);
    double all[FRAMES] = {0};
    for (uint32_t pass = 0; pass <= w.pass_count; pass++) {
        bool sum = pass == w.pass_count;
        double *values = sum ? all : w.passes[pass].milliseconds;
        for (uint32_t i = 0; i < frames && !sum; i++) {
            all[i] += values[i];
        }
        bench_row row = {.triangles = w.frame->triangles,
                         .threads = 1,
                         .metric = sum ? "all" : w.passes[pass].name,
                         .unit = "ms",
                         .less_is_better = true,
                         .clast = bench_median(values, frames)};
        snprintf(row.workload, sizeof row.workload, "%s", kind->name);
        bench_add(b, row);
    }
    free_scene(&w);
    tess_ground_free(&ground);
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "vulkan_tess", count, arguments);
    clast_context *context;
    clast_gpu *gpu;
    if (!vulkan_open(&b, false, &context, &gpu)) {
        return BENCH_NO_DEVICE;
    }
    uint32_t sizes[] = {1000000, 8000000}, size_count = 2;
    if (b.options.triangles != 0) {
        sizes[0] = b.options.triangles;
        size_count = 1;
    }
    for (uint32_t i = 0; i < size_count; i++) {
        for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++) {
            if (bench_wants(&b, kinds[kind].name)) {
                measure(&b, context, gpu, &kinds[kind], sizes[i]);
            }
        }
    }
    vulkan_close(context, gpu);
    return bench_end(&b);
}
