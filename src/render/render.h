// SPDX-License-Identifier: Apache-2.0
// The passes that end in a picture: visibility of primary rays, and what is seen there.
#ifndef CLAST_RENDER_RENDER_H
#define CLAST_RENDER_RENDER_H

#include "frame/backend.h"
#include "render/texture.h"

struct clast_scatter_tables; // scatter.h: what glass and fuzz give back
struct clast_lights;         // lights.h: tables for sampling environment, punctual lights and emitters
struct clast_scratch;        // path.h: paths of a tile

// A render under way: samples are added until there are enough.
typedef struct clast_render_target {
    clast_render_settings settings; // resolved
    uint32_t width, height;
    uint32_t sample;              // being traced
    uint32_t sample_count;        // done
    uint32_t band_rows;           // rows that are worked on between two reports of progress
    uint32_t shaded_rows;         // of the sample under way
    clast_visibility *visibility; // width * height, of the sample under way
    float *sums
        [CLAST_VIEW_COUNT_]; // of float views that were asked for, channels of CLAST_VIEW_LIST; depth and uv: first sample
    uint32_t *firsts[CLAST_VIEW_COUNT_]; // integer views: from the first sample, whose rays go through pixel centres
    clast_srgb_table srgb;
    struct clast_lights *lights;
    struct clast_scatter_tables *scatter;
    struct clast_scratch *scratch; // by worker
    uint64_t primary_rays;
    atomic_uint_fast64_t rays;
    atomic_uint_fast64_t rejected; // samples that were not finite, and count as black
} clast_render_target;

// The CPU backend, whole.
extern const clast_backend clast_cpu_backend;

// Pass trace: the primary rays of a sample into target->visibility. Pass shade: paths from there, into target->sums and
// target->firsts. `target` is a clast_render_target.
clast_status clast_cpu_trace(clast_frame *frame, void *target);
clast_status clast_cpu_shade(clast_frame *frame, void *target);

// Renders into outputs, running the frame's trace and shade passes for each sample. The frame has been run up to
// CLAST_PASS_LIGHTS. Reports progress as "render". `samples` and `rays` are set also where it is cancelled.
clast_status clast_render_frame(clast_frame *frame, const clast_backend *backend, const clast_render_settings *settings,
                                const clast_render_output *outputs, size_t count, clast_render_statistics *statistics);

// Whether a hit's alpha lets it count: the filters of accel/ for a frame. Blended surfaces count from an alpha of a half on.
bool clast_alpha_accepts(void *frame, const clast_ray *ray, const clast_hit *hit);
// The same, but blended surfaces count with a chance of their alpha: a hash of the ray and the triangle decides.
bool clast_alpha_accepts_by_chance(void *frame, const clast_ray *ray, const clast_hit *hit);

#endif
