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
#include <string.h>

#include "clast/clast.h"
#include "frame/backend.h"
#include "tess_ground.h"
#include "vulkan/frame.h"

#define BACKEND_PASS(pass, function) [pass] = function,
static const clast_backend backend = {.name = "vulkan",
                                      .passes = {CLAST_FRAME_VULKAN_PASSES(BACKEND_PASS)},
                                      .count = clast_vulkan_count_units,
                                      .forget = clast_vulkan_forget};

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

static void check(clast_status status, const clast_context *context)
{
    if (status != CLAST_OK) {
        fprintf(stderr, "%s\n", context != NULL ? clast_context_error(context) : clast_status_text(status));
        exit(1);
    }
}

// --------------------------------------------------------------------------------------------------------------- scene

static void make_scene(tess_work *w, const tess_ground *g)
{
    uint32_t image, texture, material, geometry, instance;
    check(clast_scene_create(w->context, &w->scene), w->context);
    clast_image map = {TESS_MAP_SIDE, TESS_MAP_SIDE, 1, CLAST_PIXEL_UNORM16, g->map};
    check(clast_scene_add_image(w->scene, &map, NULL, &image), w->context);
    clast_texture use = {.image = image};
    check(clast_scene_add_texture(w->scene, &use, &texture), w->context);
    clast_material_desc ground = clast_material_defaults();
    ground.displacement_texture.texture = texture;
    ground.displacement_scale = g->height_scale * 65535.0f;
    check(clast_scene_add_material(w->scene, &ground, NULL, &material), w->context);
    clast_mesh base = {.vertex_count = g->base.vertex_count,
                       .triangle_count = g->base.triangle_count,
                       .positions = g->base.positions,
                       .coordinates = {g->coordinates},
                       .indices = g->base.indices,
                       .material = material};
    check(clast_scene_add_mesh(w->scene, &base, NULL, &geometry), w->context);
    check(clast_scene_set_tessellation(w->scene, geometry, &(clast_tessellation){0}), w->context);
    check(clast_scene_add_instance(w->scene, geometry, NULL, NULL, &instance), w->context);
    check(clast_cooked_create(w->context, &w->cooked), w->context);
    check(clast_cooked_update(w->cooked, w->scene), w->context);
    check(clast_frame_create(w->scene, w->cooked, &w->frame), w->context);
    check(clast_vulkan_frame_create(w->gpu, &w->device), w->context);
    w->frame->device = w->device;
    clast_camera_desc desc = {.position = {4, -4, 6}, .target = {4, 4, 0}, .up = {0, 0, 1}, .vertical_angle = 0.9f};
    clast_camera camera = clast_camera_record(&desc, 1920, 1080);
    w->frame->settings = (clast_frame_settings){.camera = camera,
                                                .camera_number = CLAST_NONE,
                                                .rate_camera = camera,
                                                .rate_camera_number = CLAST_NONE,
                                                .width = 1920,
                                                .height = 1080,
                                                .metric = CLAST_METRIC_LENGTH,
                                                .rate = 1.0,
                                                .segment = w->segment,
                                                .hidden_fraction = 1.0,
                                                .displacement_scale = 1.0};
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
        w->frame->settings.segment = w->segment * (1.0 + 0.004 * (double)(i % 3));
        check(clast_frame_run(w->frame, &backend, CLAST_PASS_ANIMATE, CLAST_PASS_FIT, NULL), w->context);
        if (i >= 2) {
            take_times(w, i - 2);
        }
        check(clast_frame_run(w->frame, &backend, CLAST_PASS_EMIT, CLAST_PASS_TLAS, NULL), w->context);
        if (i >= 2) {
            take_times(w, i - 2);
        }
    }
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values, uint32_t count)
{
    double sorted[FRAMES];
    memcpy(sorted, values, count * sizeof *values);
    qsort(sorted, count, sizeof *sorted, by_size);
    return sorted[count / 2];
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
        const double *values = sum ? all : w.passes[pass].milliseconds;
        bench_row row = {.triangles = w.frame->triangles,
                         .threads = 1,
                         .metric = sum ? "all" : w.passes[pass].name,
                         .unit = "ms",
                         .less_is_better = true,
                         .clast = median(values, frames)};
        snprintf(row.workload, sizeof row.workload, "%s", kind->name);
        bench_add(b, row);
        for (uint32_t i = 0; i < frames && !sum; i++) {
            all[i] += values[i];
        }
    }
    free_scene(&w);
    tess_ground_free(&ground);
}

static void log_line(void *user, clast_log_level level, const char *text)
{
    (void)user;
    if (level == CLAST_LOG_WARNING) {
        fprintf(stderr, "%s\n", text);
    }
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "vulkan_tess", count, arguments);
    clast_context *context = NULL;
    check(clast_context_create(&(clast_context_desc){.threads = b.options.threads, .log = {log_line, NULL}}, &context),
          NULL);
    clast_gpu *gpu = NULL;
    clast_gpu_desc wanted = {.software = b.options.triangles != 0, .hardware = true};
    if (clast_gpu_create(context, &wanted, &gpu) != CLAST_OK) {
        fprintf(stderr, "skipped: %s\n", clast_context_error(context));
        clast_context_destroy(context);
        bench_end(&b);
        return 77;
    }
    const clast_gpu_features *features = clast_gpu_features_of(gpu);
    snprintf(b.machine, sizeof b.machine, "%s, %s", features->name, features->driver);
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
    clast_gpu_destroy(gpu);
    clast_context_destroy(context);
    return bench_end(&b);
}
