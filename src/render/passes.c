// SPDX-License-Identifier: Apache-2.0
// Passes trace and shade on the CPU: bands of squares one after the other, so that progress can be told and asked; the tiles of
// a band in parallel.
#include "base/thread.h"
#include "render/path.h"
#include "render/views.h"

#define CPU_PASS(pass, function) [pass] = function,
const clast_backend clast_cpu_backend = {
    .name = "cpu",
    .passes = {CLAST_FRAME_CPU_PASSES(CPU_PASS) CPU_PASS(CLAST_PASS_TRACE, clast_cpu_trace)
                   CPU_PASS(CLAST_PASS_SHADE, clast_cpu_shade)},
    .measure = clast_cpu_measure,
};

// Squares that are worked on between two reports of progress.
enum { BAND_SQUARES = 1024 };

typedef void (*tile_function)(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch);

typedef struct band_job {
    const clast_frame *frame;
    clast_render_target *target;
    uint32_t first, count; // of the active squares
    tile_function work;
} band_job;

static void list_pixels(const clast_render_target *target, uint32_t first, uint32_t count, clast_scratch *scratch)
{
    const clast_squares *squares = &target->squares;
    scratch->pixel_count = 0;
    for (uint32_t i = 0; i < count * SQUARE_PIXELS; i++) {
        clast_path_pixel at = clast_pixel_of_square(squares, squares->active[first + i / SQUARE_PIXELS],
                                                    i % SQUARE_PIXELS);
        if (at.x < target->area.width && at.y < target->area.height) {
            scratch->pixels[scratch->pixel_count++] = at;
        }
    }
}

static void band_tiles(void *data, size_t begin, size_t end, uint32_t worker)
{
    const band_job *job = data;
    clast_scratch *scratch = &job->target->scratch[worker];
    for (size_t i = begin; i < end; i++) {
        uint32_t first = (uint32_t)i * CLAST_TILE_SQUARES;
        list_pixels(job->target, job->first + first, min_uint(CLAST_TILE_SQUARES, job->count - first), scratch);
        job->work(job->frame, job->target, scratch);
    }
}

// The next squares that lack the sample under way.
static band_job next_band(const clast_frame *frame, clast_render_target *target, uint32_t first, tile_function work)
{
    return (band_job){frame, target, first, min_uint(BAND_SQUARES, target->squares.active_count - first), work};
}

static void run_band(band_job *job)
{
    size_t tiles = (job->count + CLAST_TILE_SQUARES - 1) / CLAST_TILE_SQUARES;
    clast_parallel_for(job->frame->context, tiles, 1, band_tiles, job);
}

// The two passes of a sample are each half of it.
static clast_status report(const clast_frame *frame, const clast_render_target *target, uint32_t square, bool shading)
{
    double part = (double)square / (double)target->squares.active_count;
    return clast_render_report(frame, target, 0.5 * part + (shading ? 0.5 : 0.0));
}

static bool is_hidden_back(const clast_frame *frame, const clast_ray *ray, const clast_hit *hit)
{
    const float *n = hit->normal, *d = ray->direction;
    if (hit->instance == CLAST_NONE || !sees_back(vec3(n[0], n[1], n[2]), vec3(d[0], d[1], d[2]))) {
        return false;
    }
    return clast_surface_of_hit(frame, hit).material->double_sided == 0;
}

// The eye looks through the backs of single-sided surfaces (glTF 2.0, material.doubleSided). Light does not: to it they are
// as solid as any, so that a wall casts its shadow from both sides.
static void look_through_backs(const clast_frame *frame, const clast_hit_filter *filter, clast_ray ray, clast_hit *hit)
{
    for (uint32_t backs = 0; backs < BACKS_MOST && is_hidden_back(frame, &ray, hit); backs++) {
        uint32_t steps = hit->steps;
        ray.t_min = beyond_hit(hit->t);
        clast_trace_closest(frame->tlas, &ray, 1, filter, hit);
        hit->steps += steps;
    }
}

static void trace_tile(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch)
{
    clast_camera_ray rays[CLAST_TILE_PIXELS];
    for (uint32_t i = 0; i < scratch->pixel_count; i++) {
        rays[i] = clast_primary_ray(frame, target, scratch->pixels[i]);
        scratch->rays[i] = clast_ray_of(rays[i]);
    }
    clast_hit_filter filter = {clast_alpha_accepts_by_chance, (void *)frame};
    clast_trace_closest(frame->tlas, scratch->rays, scratch->pixel_count, &filter, scratch->hits);
    for (uint32_t i = 0; i < scratch->pixel_count; i++) {
        look_through_backs(frame, &filter, scratch->rays[i], &scratch->hits[i]);
        size_t pixel = (size_t)scratch->pixels[i].y * target->area.width + scratch->pixels[i].x;
        clast_visibility seen = clast_visibility_of_hit(&scratch->hits[i]);
        target->visibility[pixel] = seen;
        if (target->sample != 0) {
            continue;
        }
        clast_keep_views(frame, target, pixel);
        if (target->sums[CLAST_VIEW_DEPTH] != NULL && seen.instance != CLAST_NONE) {
            target->sums[CLAST_VIEW_DEPTH][pixel] = camera_depth(frame->settings.camera, rays[i], seen.distance);
        }
    }
}

clast_status clast_cpu_trace(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    band_job band = next_band(frame, target, target->squares.done, trace_tile);
    while (band.count != 0) {
        clast_status status = report(frame, target, band.first, false);
        if (status != CLAST_OK) {
            return status;
        }
        run_band(&band);
        band = next_band(frame, target, band.first + band.count, trace_tile);
    }
    return CLAST_OK;
}

clast_status clast_cpu_shade(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    band_job band = next_band(frame, target, target->squares.done, clast_shade_tile);
    while (band.count != 0) {
        clast_status status = report(frame, target, band.first, true);
        if (status != CLAST_OK) {
            return status;
        }
        run_band(&band);
        clast_squares_advance(&target->squares, band.count);
        band = next_band(frame, target, target->squares.done, clast_shade_tile);
    }
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------------- noise

static void measure_square(clast_render_target *target, uint32_t square, float gain)
{
    const clast_squares *squares = &target->squares;
    const float *sums = target->sums[CLAST_VIEW_COLOUR];
    float samples = (float)squares->samples[square], sum = 0.0f;
    for (uint32_t i = 0; i < SQUARE_PIXELS; i++) {
        clast_path_pixel at = clast_pixel_of_square(squares, square, i);
        if (at.x < target->area.width && at.y < target->area.height) {
            size_t place = 3 * ((size_t)at.y * target->area.width + at.x);
            const float *all = sums + place, *half = target->halves + place;
            sum += pixel_noise(vec3(all[0], all[1], all[2]), vec3(half[0], half[1], half[2]), samples, gain);
        }
    }
    squares->noise[square] = sum / (float)clast_square_pixels(squares, square);
}

static void measure_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_render_target *target = data;
    float gain = exp2f((float)target->settings.exposure);
    for (size_t i = begin; i < end; i++) {
        measure_square(target, target->squares.active[i], gain);
    }
}

clast_status clast_cpu_measure(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    clast_parallel_for(frame->context, target->squares.active_count, 16, measure_range, target);
    return CLAST_OK;
}
