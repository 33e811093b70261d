// SPDX-License-Identifier: Apache-2.0
// The passes that end in a picture: visibility of primary rays, and what is seen there.
#ifndef CLAST_RENDER_RENDER_H
#define CLAST_RENDER_RENDER_H

#include "frame/backend.h"
#include "render/squares.h"
#include "render/texture.h"

struct clast_scatter_tables; // scatter.h: what glass and fuzz give back
struct clast_lights;         // lights.h: tables for sampling environment, punctual lights and emitters
struct clast_scratch;        // path.h: paths of a tile

// A render under way: samples are added until there are enough.
typedef struct clast_render_target {
    clast_render_settings settings; // resolved
    uint32_t width, height;         // of the whole picture
    clast_render_area area;         // what is rendered of it: pixels of sums and views are its
    clast_squares squares;
    uint32_t power;               // of two: how many samples of a pixel points are laid out for
    uint32_t sample;              // being traced; before it, all are done
    uint32_t first_sample;        // of this run: more than zero where it goes on with a checkpoint
    uint64_t first_work;          // likewise of squares.work
    bool is_resumed;              // sums are those of a checkpoint
    uint32_t moment;              // of the shutter's that the frame is at (shutter.h)
    bool is_moved;                // to that moment; before, the frame is as it was committed
    bool is_begun;                // on a device, where sums are its until they are fetched
    double begun;                 // clast_clock() before the first
    double sample_seconds;        // that the last one took
    double first_sample_seconds;  // until each pixel had one; 0 where not yet
    clast_visibility *visibility; // of each pixel, of the sample under way
    float *sums
        [CLAST_VIEW_COUNT_]; // of float views that were asked for, channels of CLAST_VIEW_LIST; depth and uv: first sample
    uint32_t *firsts[CLAST_VIEW_COUNT_]; // integer views: from the first sample, whose rays go through pixel centres
    float *halves;     // of the sums of colour, what samples of pixels' halves brought; null where no noise is too much
    float *own_colour; // sums of colour that noise is measured of, where nobody wants them; else null
    clast_srgb_table srgb;
    struct clast_lights *lights;
    struct clast_scatter_tables *scatter;
    struct clast_scratch *scratch; // by worker
    atomic_uint_fast64_t rays;     // beside the primary ones
    atomic_uint_fast64_t rejected; // samples that were not finite, and count as black
} clast_render_target;

// The CPU backend, whole.
extern const clast_backend clast_cpu_backend;

// Pass trace: the primary rays of a sample into target->visibility. Pass shade: paths from there, into target->sums and
// target->firsts. `target` is a clast_render_target.
clast_status clast_cpu_trace(clast_frame *frame, void *target);
clast_status clast_cpu_shade(clast_frame *frame, void *target);
// Measures the noise of the active squares.
clast_status clast_cpu_measure(clast_frame *frame, void *target);

// Tells how far a render has come, where a part of the sample under way is done: by the limit that ends it first.
clast_status clast_render_report(const clast_frame *frame, const clast_render_target *target, double part);

// What a render is asked for.
typedef struct clast_render_request {
    const clast_render_settings *settings; // resolved
    const clast_render_output *outputs;
    size_t output_count;
    clast_checkpoint checkpoint;
    const char *device; // that makes the picture: checkpoints are of one device
} clast_render_request;

// Renders into outputs, running the frame's trace and shade passes for each sample. The frame has been run up to
// CLAST_PASS_LIGHTS. Reports progress as "render". `samples` and `rays` are set also where it is cancelled.
clast_status clast_render_run(clast_frame *frame, const clast_backend *backend, const clast_render_request *request,
                              clast_render_statistics *statistics);
// The same without checkpoints.
clast_status clast_render_frame(clast_frame *frame, const clast_backend *backend, const clast_render_settings *settings,
                                const clast_render_output *outputs, size_t count, clast_render_statistics *statistics);

// Whether a hit's alpha lets it count: the filters of accel/ for a frame. Blended surfaces count from an alpha of a half on.
bool clast_alpha_accepts(void *frame, const clast_ray *ray, const clast_hit *hit);
// The same, but blended surfaces count with a chance of their alpha: a hash of the ray and the triangle decides.
bool clast_alpha_accepts_by_chance(void *frame, const clast_ray *ray, const clast_hit *hit);

#endif
