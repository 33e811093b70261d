// SPDX-License-Identifier: Apache-2.0
// Pictures that a Vulkan device makes: one path a pixel of 1920x1080, three bounces, with a shadow ray to the sky and one to the sun
// at each, over a waving sheet. Times are the device's own, in milliseconds, as means over the samples of a render.
//
//   primary rays, next rays, shadow rays   traced
//   shade                                  surfaces, lights, and where paths go on
//   finish                                 the sums of the picture
//   sample                                 all of it
//   rays                                   Mrays/s over all of it
//
// Drivers that are programs on the processor count with --triangles only.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clast/clast.h"
#include "vulkan_open.h"
#include "vulkan/frame_state.h"
#include "vulkan/render.h"

enum { WIDTH = 1920, HEIGHT = 1080, BOUNCES = 3, SAMPLES = 32, SAMPLES_QUICK = 8, TILE_TRIANGLES = 242 };

typedef struct picture_work {
    clast_context *context;
    clast_gpu *gpu;
    clast_scene *scene;
    clast_cooked *cooked;
    clast_frame *frame;
    clast_vulkan_frame *device;
    float *pixels;
} picture_work;

// A sheet whose tiles have all the triangles that a tile can have.
static void make_scene(picture_work *w, uint32_t triangles)
{
    uint32_t tiles = 1, geometry, instance, material;
    while (tiles < 1024 && tiles * tiles * TILE_TRIANGLES < triangles) {
        tiles++;
    }
    bench_check(clast_scene_create(w->context, &w->scene), w->context);
    clast_material_desc grey = clast_material_defaults();
    grey.roughness = 0.6f;
    bench_check(clast_scene_add_material(w->scene, &grey, NULL, &material), w->context);
    clast_wave wave = {
        .size = 40.0f, .tiles = tiles, .amplitude = 1.5f, .wavelength = 6.0f, .speed = 0.5f, .material = material};
    bench_check(clast_scene_add_wave(w->scene, &wave, NULL, &geometry), w->context);
    bench_check(clast_scene_add_instance(w->scene, geometry, NULL, NULL, &instance), w->context);
    clast_environment sky = {.type = CLAST_ENVIRONMENT_SKY, .sun_direction = {0.5f, 0.4f, 0.3f}};
    bench_check(clast_scene_set_environment(w->scene, &sky), w->context);
    bench_check(clast_cooked_create(w->context, &w->cooked), w->context);
    bench_check(clast_cooked_update(w->cooked, w->scene), w->context);
    bench_check(clast_frame_create(w->scene, w->cooked, &w->frame), w->context);
    bench_check(clast_vulkan_frame_create(w->gpu, &w->device), w->context);
    w->frame->device = w->device;
    clast_camera_desc desc = {.position = {14, 7, 14}, .target = {0, 0, 0}, .vertical_angle = 0.9f};
    clast_camera camera = clast_camera_record(&desc, WIDTH, HEIGHT);
    w->frame->settings = (clast_frame_settings){.camera = camera,
                                                .camera_number = CLAST_NONE,
                                                .rate_camera = camera,
                                                .rate_camera_number = CLAST_NONE,
                                                .width = WIDTH,
                                                .height = HEIGHT,
                                                .rate = 1000.0,
                                                .segment = 2.0,
                                                .hidden_fraction = 1.0,
                                                .displacement_scale = 1.0};
    bench_check(clast_frame_run(w->frame, &clast_vulkan_backend, CLAST_PASS_ANIMATE, CLAST_PASS_LIGHTS, NULL),
                w->context);
}

static clast_render_statistics render(picture_work *w, uint32_t samples)
{
    clast_render_settings settings = {
        .width = WIDTH, .height = HEIGHT, .spp = samples, .bounces = BOUNCES, .camera = "", .env = ""};
    clast_render_output output = {CLAST_VIEW_COLOUR, w->pixels};
    clast_render_statistics statistics;
    bench_check(clast_render_frame(w->frame, &clast_vulkan_backend, &settings, &output, 1, &statistics), w->context);
    return statistics;
}

static void add_row(bench *b, const picture_work *w, const char *metric, double value, bool less_is_better)
{
    bench_row row = {.triangles = w->frame->triangles,
                     .threads = 1,
                     .metric = metric,
                     .unit = less_is_better ? "ms" : "Mrays/s",
                     .less_is_better = less_is_better,
                     .clast = value};
    snprintf(row.workload, sizeof row.workload, "sheet");
    bench_add(b, row);
}

// A render of one sample comes before: kernels are compiled for it.
static void measure(bench *b, clast_context *context, clast_gpu *gpu, uint32_t triangles)
{
    uint32_t samples = b->options.quick ? SAMPLES_QUICK : SAMPLES;
    picture_work w = {.context = context, .gpu = gpu, .pixels = malloc((size_t)WIDTH * HEIGHT * 12)};
    if (w.pixels == NULL) {
        fprintf(stderr, "out of memory\n");
        exit(1);
    }
    make_scene(&w, triangles);
    render(&w, 1);
    vulkan_wake(context, gpu);
    clast_render_statistics statistics = render(&w, samples);
    clast_gpu_time times[CLAST_GPU_TIMES];
    uint32_t count = clast_vulkan_render_times(w.device->render, times);
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        add_row(b, &w, times[i].pass, times[i].milliseconds / samples, true);
        sum += times[i].milliseconds;
    }
    add_row(b, &w, "sample", sum / samples, true);
    add_row(b, &w, "rays", sum > 0.0 ? (double)statistics.rays / sum * 1e-3 : 0.0, false);
    clast_vulkan_frame_destroy(w.device);
    clast_frame_destroy(w.frame);
    clast_cooked_destroy(w.cooked);
    clast_scene_destroy(w.scene);
    free(w.pixels);
}

int main(int count, char **arguments)
{
    bench b;
    bench_begin(&b, "vulkan_picture", count, arguments);
    clast_context *context;
    clast_gpu *gpu;
    if (!vulkan_open(&b, false, &context, &gpu)) {
        return BENCH_NO_DEVICE;
    }
    uint32_t sizes[] = {1000000, 8000000, 32000000}, size_count = b.options.quick ? 2 : 3;
    if (b.options.triangles != 0) {
        sizes[0] = b.options.triangles;
        size_count = 1;
    }
    for (uint32_t i = 0; i < size_count; i++) {
        measure(&b, context, gpu, sizes[i]);
    }
    vulkan_close(context, gpu);
    return bench_end(&b);
}
