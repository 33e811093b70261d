// SPDX-License-Identifier: Apache-2.0
// Pictures that the processor makes: how fast, what the time goes into, and what many lights cost.
//
//   samples          paths of pixels from the camera on, of up to four bounces, a second
//   traversal        of the time of these, what rays take, in percent
//   textures         likewise, what reading textures takes
//   shading          likewise, all else: surfaces, lights, where paths go on
//   light_time       the time of a picture, beside that of the same room with one lamp
//   light_variance   its noise at as many samples, likewise
//   tree_build       lights that the tree over them takes in a second
//
// What functions of the library take is found by standing in for them: the linker puts the functions below that are called
// __wrap_ in their place. Shares are of one thread.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/light_tree.h"
#include "render/texture.h"
#include "render_scenes.h"
#include "shared/random.h"

enum { WIDTH = 320, HEIGHT = 180, BOUNCES = 4, SAMPLES = 16, SAMPLES_QUICK = 4, TEXTURES_TIMED = 16 };

// -------------------------------------------------------------------------------------------------------------- phases

static bool counts_phases; // one thread works then
static double traversal_seconds, texture_seconds, clock_seconds;
static uint32_t texture_calls;

void __real_clast_trace_closest(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                const clast_hit_filter *filter, clast_hit *hits);
void __real_clast_trace_any(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter,
                            uint8_t *occluded);
vec4 __real_clast_texture_value(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                                clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise);
void __wrap_clast_trace_closest(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                const clast_hit_filter *filter, clast_hit *hits);
void __wrap_clast_trace_any(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter,
                            uint8_t *occluded);
vec4 __wrap_clast_texture_value(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                                clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise);

void __wrap_clast_trace_closest(const clast_tlas *tlas, const clast_ray *rays, size_t count,
                                const clast_hit_filter *filter, clast_hit *hits)
{
    double start = counts_phases ? bench_seconds() : 0.0;
    __real_clast_trace_closest(tlas, rays, count, filter, hits);
    if (counts_phases) {
        traversal_seconds += bench_seconds() - start;
    }
}

void __wrap_clast_trace_any(const clast_tlas *tlas, const clast_ray *rays, size_t count, const clast_hit_filter *filter,
                            uint8_t *occluded)
{
    double start = counts_phases ? bench_seconds() : 0.0;
    __real_clast_trace_any(tlas, rays, count, filter, occluded);
    if (counts_phases) {
        traversal_seconds += bench_seconds() - start;
    }
}

// So many calls are short that one of a few stands for all, and what the clock itself takes is taken off.
vec4 __wrap_clast_texture_value(const clast_scene *scene, clast_texture_use use, const clast_texture_area *area,
                                clast_encoding encoding, const clast_srgb_table *table, vec4 otherwise)
{
    if (!counts_phases || ++texture_calls % TEXTURES_TIMED != 0) {
        return __real_clast_texture_value(scene, use, area, encoding, table, otherwise);
    }
    double start = bench_seconds();
    vec4 value = __real_clast_texture_value(scene, use, area, encoding, table, otherwise);
    texture_seconds += TEXTURES_TIMED * (bench_seconds() - start - clock_seconds);
    return value;
}

static void measure_clock(void)
{
    enum { TIMES = 100000 };
    double start = bench_seconds();
    for (int i = 0; i < TIMES; i++) {
        (void)bench_seconds();
    }
    clock_seconds = (bench_seconds() - start) / TIMES;
}

// -------------------------------------------------------------------------------------------------------------- renders

typedef struct work {
    bench *b;
    clast_context *context;
    clast_scene *scene;
    clast_renderer *renderer;
    float *pixels;
    uint32_t samples, threads;
    uint64_t triangles; // of the frame
} work;

static void open_work(work *w, clast_scene *scene)
{
    w->scene = scene;
    w->pixels = malloc(sizeof(float) * 3 * WIDTH * HEIGHT);
    w->samples = w->b->options.quick ? SAMPLES_QUICK : SAMPLES;
    bench_check(clast_renderer_create(scene, &w->renderer), w->context);
}

static void close_work(work *w)
{
    clast_renderer_destroy(w->renderer);
    clast_scene_destroy(w->scene);
    free(w->pixels);
}

// Seconds. What does not change is kept from the render before.
static double render(work *w, uint32_t seed)
{
    clast_render_settings settings = {.width = WIDTH,
                                      .height = HEIGHT,
                                      .spp = w->samples,
                                      .bounces = BOUNCES,
                                      .seed = seed,
                                      .device = CLAST_DEVICE_CPU,
                                      .camera = "",
                                      .env = ""};
    clast_render_output output = {CLAST_VIEW_COLOUR, w->pixels};
    clast_render_statistics statistics;
    double start = bench_seconds();
    bench_check(clast_render(w->renderer, &settings, &output, 1, &statistics), w->context);
    w->triangles = statistics.triangles;
    return bench_seconds() - start;
}

static double median_render(work *w)
{
    double seconds[BENCH_REPETITIONS_MOST];
    render(w, 1); // cooks
    for (uint32_t i = 0; i < w->b->options.repetitions; i++) {
        seconds[i] = render(w, 1);
    }
    return bench_median(seconds, w->b->options.repetitions);
}

static bench_row row_of(const work *w, const char *workload, const char *metric, const char *unit, double value)
{
    bench_row row = {.triangles = w->triangles, .threads = w->threads, .metric = metric, .unit = unit, .clast = value};
    snprintf(row.workload, sizeof row.workload, "%s", workload);
    return row;
}

// ------------------------------------------------------------------------------------------------------------- workloads

static void measure_shares(work *w, const char *workload)
{
    traversal_seconds = texture_seconds = 0.0;
    counts_phases = true;
    double all = render(w, 2);
    counts_phases = false;
    double shading = all - traversal_seconds - texture_seconds;
    bench_add(w->b, row_of(w, workload, "traversal", "%", 100.0 * traversal_seconds / all));
    bench_add(w->b, row_of(w, workload, "textures", "%", 100.0 * texture_seconds / all));
    bench_add(w->b, row_of(w, workload, "shading", "%", 100.0 * shading / all));
}

static void measure_scene(work *w, const char *workload)
{
    double seconds = median_render(w), samples = (double)w->samples * WIDTH * HEIGHT;
    bench_add(w->b, row_of(w, workload, "samples", "Msamples/s", 1e-6 * samples / seconds));
    if (w->threads == 1) {
        measure_shares(w, workload);
    }
}

// Half of the mean square of what two renders differ by; the brightest sparks count as white.
static double measure_variance(work *w)
{
    size_t count = 3 * (size_t)WIDTH * HEIGHT;
    float *first = malloc(count * sizeof *first);
    render(w, 3);
    memcpy(first, w->pixels, count * sizeof *first);
    render(w, 4);
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        double difference = (double)fminf(first[i], 1.0f) - (double)fminf(w->pixels[i], 1.0f);
        sum += 0.5 * difference * difference;
    }
    free(first);
    return sum / (double)count;
}

static void measure_lamps(bench *b, clast_context *context, uint32_t threads)
{
    static const uint32_t counts[] = {1, 100, 10000};
    double seconds[3], variances[3];
    for (int i = 0; i < 3; i++) {
        work w = {.b = b, .context = context, .threads = threads};
        char workload[BENCH_NAME_SIZE];
        snprintf(workload, sizeof workload, "lamps, %u", counts[i]);
        open_work(&w, render_scene_lamps(context, counts[i]));
        seconds[i] = median_render(&w);
        variances[i] = measure_variance(&w);
        bench_row row = row_of(&w, workload, "light_time", "ms", 1e3 * seconds[i]);
        snprintf(row.peer, sizeof row.peer, "one lamp");
        row.less_is_better = true;
        row.peer_value = 1e3 * seconds[0];
        bench_add(b, row);
        row.metric = "light_variance";
        row.unit = "1e-3";
        row.clast = 1e3 * variances[i];
        row.peer_value = 1e3 * variances[0];
        bench_add(b, row);
        close_work(&w);
    }
}

// A tree over triangles all over a cube.
static void measure_build(bench *b, clast_context *context, uint32_t threads)
{
    uint32_t count = b->options.quick ? 100000 : 1000000;
    clast_emitter *emitters = calloc(count, sizeof *emitters);
    float *radiances = malloc(count * sizeof *radiances);
    for (uint32_t i = 0; i < count; i++) {
        vec3 place = vec3(unit_float(hash2(i, 1)), unit_float(hash2(i, 2)), unit_float(hash2(i, 3)));
        vec3 right = vec3(0.002f, 0.001f * unit_float(hash2(i, 4)), 0.0f), up = vec3(0.0f, 0.001f, 0.002f);
        emitters[i] = (clast_emitter){.corners = {store3(place), store3(place + right), store3(place + up)},
                                      .area = 0.5f * length3(cross3(right, up))};
        radiances[i] = 1.0f + unit_float(hash2(i, 5));
    }
    clast_light_sources sources = {
        .emitters = emitters, .emitter_radiances = radiances, .emitter_count = count, .extent = 1.0f};
    double seconds[BENCH_REPETITIONS_MOST];
    for (uint32_t i = 0; i < b->options.repetitions; i++) {
        clast_light_tree tree;
        double start = bench_seconds();
        bench_check(clast_light_tree_create(context, &sources, &tree), context);
        seconds[i] = bench_seconds() - start;
        clast_light_tree_destroy(context, &tree);
    }
    work w = {.triangles = count, .threads = threads};
    bench_add(b, row_of(&w, "lights in a cube", "tree_build", "Mlights/s",
                        1e-6 * count / bench_median(seconds, b->options.repetitions)));
    free(emitters);
    free(radiances);
}

static void measure(bench *b, uint32_t threads)
{
    clast_context *context;
    bench_check(clast_context_create(&(clast_context_desc){.threads = threads}, &context), NULL);
    const char *const names[] = {"demonstration", "Cornell box", "instances"};
    for (int i = 0; i < 3; i++) {
        if (bench_wants(b, names[i])) {
            work w = {.b = b, .context = context, .threads = threads};
            open_work(&w, i == 0   ? render_scene_demonstration(context, b->options.quick ? 0.05 : 1.0)
                          : i == 1 ? render_scene_cornell(context)
                                   : render_scene_instances(context));
            measure_scene(&w, names[i]);
            close_work(&w);
        }
    }
    if (bench_wants(b, "lamps")) {
        measure_lamps(b, context, threads);
    }
    if (bench_wants(b, "lights in a cube")) {
        measure_build(b, context, threads);
    }
    clast_context_destroy(context);
}

int main(int argc, char **argv)
{
    bench b;
    bench_begin(&b, "render", argc, argv);
    measure_clock();
    for (uint32_t threads = 1; threads <= 2 && b.options.threads == 0; threads++) {
        measure(&b, threads);
    }
    if (b.options.threads != 0) {
        measure(&b, b.options.threads);
    }
    return bench_end(&b);
}
