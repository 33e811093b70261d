// SPDX-License-Identifier: Apache-2.0
// Passes trace and shade on the CPU: bands of the picture one after the other, so that progress can be told and asked; the
// tiles of a band in parallel.
#include "base/thread.h"
#include "render/path.h"
#include "render/views.h"

#define CPU_PASS(pass, function) [pass] = function,
const clast_backend clast_cpu_backend = {
    .name = "cpu",
    .passes = {CLAST_FRAME_CPU_PASSES(CPU_PASS) CPU_PASS(CLAST_PASS_TRACE, clast_cpu_trace)
                   CPU_PASS(CLAST_PASS_SHADE, clast_cpu_shade)},
};

typedef struct band_job {
    const clast_frame *frame;
    clast_render_target *target;
    uint32_t first_row, rows;
    void (*work)(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch, clast_tile tile);
} band_job;

static void band_tiles(void *data, size_t begin, size_t end, uint32_t worker)
{
    const band_job *job = data;
    clast_render_target *target = job->target;
    uint32_t across = (target->width + CLAST_TILE_WIDTH - 1) / CLAST_TILE_WIDTH;
    for (size_t i = begin; i < end; i++) {
        uint32_t x = (uint32_t)(i % across) * CLAST_TILE_WIDTH, y = (uint32_t)(i / across) * CLAST_TILE_HEIGHT;
        clast_tile tile = {x, job->first_row + y, min_uint(CLAST_TILE_WIDTH, target->width - x),
                           min_uint(CLAST_TILE_HEIGHT, job->rows - y)};
        job->work(job->frame, target, &target->scratch[worker], tile);
    }
}

static uint64_t band_count(const clast_render_target *target)
{
    return (target->height + target->band_rows - 1) / target->band_rows;
}

// The two passes of a sample are each half of it.
static clast_status report(const clast_frame *frame, const clast_render_target *target, uint32_t row, bool shading)
{
    uint64_t bands = band_count(target);
    uint64_t done = target->sample * 2 * bands + row / target->band_rows + (shading ? bands : 0);
    return clast_progress(frame->context, "render", done, 2 * bands * target->settings.spp);
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

static void trace_tile(const clast_frame *frame, clast_render_target *target, clast_scratch *scratch, clast_tile tile)
{
    uint32_t count = tile.width * tile.height;
    clast_camera_ray rays[CLAST_TILE_PIXELS];
    for (uint32_t i = 0; i < count; i++) {
        clast_pixel_place at = clast_tile_pixel(tile, i);
        rays[i] = clast_primary_ray(frame, target, at.x, at.y);
        scratch->rays[i] = clast_ray_of(rays[i]);
    }
    clast_hit_filter filter = {clast_alpha_accepts_by_chance, (void *)frame};
    clast_trace_closest(frame->tlas, scratch->rays, count, &filter, scratch->hits);
    for (uint32_t i = 0; i < count; i++) {
        look_through_backs(frame, &filter, scratch->rays[i], &scratch->hits[i]);
        clast_pixel_place at = clast_tile_pixel(tile, i);
        size_t pixel = (size_t)at.y * target->width + at.x;
        clast_visibility seen = clast_visibility_of_hit(&scratch->hits[i]);
        target->visibility[pixel] = seen;
        if (target->sample == 0 && target->sums[CLAST_VIEW_DEPTH] != NULL) {
            bool hit = seen.instance != CLAST_NONE;
            target->sums[CLAST_VIEW_DEPTH][pixel] = hit ? camera_depth(frame->settings.camera, rays[i], seen.distance)
                                                        : INFINITY;
        }
    }
}

static void keep_first(uint32_t *view, size_t first, const clast_visibility *seen, size_t count, size_t member)
{
    for (size_t i = 0; view != NULL && i < count; i++) {
        memcpy(&view[first + i], (const char *)&seen[i] + member, sizeof *view);
    }
}

static void keep_first_rows(clast_render_target *target, uint32_t row, uint32_t rows)
{
    size_t first = (size_t)row * target->width, count = (size_t)rows * target->width;
    const clast_visibility *seen = target->visibility + first;
    keep_first(target->firsts[CLAST_VIEW_INSTANCE], first, seen, count, offsetof(clast_visibility, instance));
    keep_first(target->firsts[CLAST_VIEW_CLUSTER], first, seen, count, offsetof(clast_visibility, cluster));
    keep_first(target->firsts[CLAST_VIEW_TRIANGLE], first, seen, count, offsetof(clast_visibility, triangle));
    keep_first(target->firsts[CLAST_VIEW_STEPS], first, seen, count, offsetof(clast_visibility, steps));
}

static void run_band(band_job *job)
{
    uint32_t across = (job->target->width + CLAST_TILE_WIDTH - 1) / CLAST_TILE_WIDTH;
    uint32_t down = (job->rows + CLAST_TILE_HEIGHT - 1) / CLAST_TILE_HEIGHT;
    clast_parallel_for(job->frame->context, (size_t)across * down, 1, band_tiles, job);
}

clast_status clast_cpu_trace(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    for (uint32_t row = 0; row < target->height; row += target->band_rows) {
        clast_status status = report(frame, target, row, false);
        if (status != CLAST_OK) {
            return status;
        }
        band_job job = {frame, target, row, min_uint(target->band_rows, target->height - row), trace_tile};
        run_band(&job);
        if (target->sample == 0) {
            keep_first_rows(target, row, job.rows);
            clast_keep_cut_views(frame, target, row, job.rows);
        }
    }
    target->primary_rays += (uint64_t)target->width * target->height;
    atomic_fetch_add(&target->rays, (uint64_t)target->width * target->height);
    return CLAST_OK;
}

clast_status clast_cpu_shade(clast_frame *frame, void *data)
{
    clast_render_target *target = data;
    target->shaded_rows = 0;
    for (uint32_t row = 0; row < target->height; row += target->band_rows) {
        clast_status status = report(frame, target, row, true);
        if (status != CLAST_OK) {
            return status;
        }
        band_job job = {frame, target, row, min_uint(target->band_rows, target->height - row), clast_shade_tile};
        run_band(&job);
        target->shaded_rows = row + job.rows;
    }
    return CLAST_OK;
}
