// SPDX-License-Identifier: Apache-2.0
// A render: samples until there are enough, then means.
#include <string.h>

#include "base/thread.h"
#include "render/levels.h"
#include "render/path.h"
#include "render/scatter.h"

enum { BAND_PIXELS = 1 << 16 };

typedef struct view_layout {
    uint32_t channels;
    bool is_float;
} view_layout;

#define VIEW_LAYOUT(name, value, text, channels, is_float, help) [name] = {channels, is_float},
static const view_layout layouts[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(VIEW_LAYOUT)};

// Sums are kept in the caller's own memory.
static void begin_outputs(clast_render_target *target, const clast_render_output *outputs, size_t count)
{
    size_t pixels = (size_t)target->width * target->height;
    for (size_t i = 0; i < count; i++) {
        clast_view view = outputs[i].view;
        size_t bytes = pixels * layouts[view].channels * sizeof(float);
        if (layouts[view].is_float) {
            target->sums[view] = outputs[i].pixels;
            memset(outputs[i].pixels, 0, bytes);
        } else {
            target->firsts[view] = outputs[i].pixels;
            memset(outputs[i].pixels, 0xff, bytes); // CLAST_NONE
        }
    }
    for (size_t i = 0; target->sums[CLAST_VIEW_DEPTH] != NULL && i < pixels; i++) {
        target->sums[CLAST_VIEW_DEPTH][i] = INFINITY;
    }
}

// What the CPU's passes work in.
static clast_status begin_cpu(clast_context *context, clast_render_target *target)
{
    uint32_t rows = BAND_PIXELS / target->width;
    rows = rows < 1 ? 1 : rows;
    target->band_rows = (rows + CLAST_TILE_HEIGHT - 1) / CLAST_TILE_HEIGHT * CLAST_TILE_HEIGHT;
    target->visibility = clast_allocate(context, (size_t)target->width * target->height, sizeof *target->visibility);
    target->scratch = clast_allocate(context, clast_worker_count(context), sizeof *target->scratch);
    return target->visibility != NULL && target->scratch != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

static clast_status begin(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    clast_context *context = frame->context;
    clast_srgb_table_fill(&target->srgb);
    clast_status status = backend == &clast_cpu_backend ? begin_cpu(context, target) : CLAST_OK;
    if (status != CLAST_OK) {
        return status;
    }
    double start = clast_clock();
    status = clast_make_levels(frame->scene);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_lights_create(frame, &target->srgb, &target->lights);
    if (status == CLAST_OK) {
        status = clast_scatter_create(frame->scene, &target->scatter);
    }
    frame->milliseconds[CLAST_PASS_LIGHTS] += (clast_clock() - start) * 1e3;
    return status;
}

// Rows of a sample that was cancelled half way have one sample more than the others.
static void average(const clast_render_target *target, clast_view view)
{
    size_t row_size = (size_t)target->width * layouts[view].channels;
    for (uint32_t row = 0; row < target->height; row++) {
        uint32_t count = target->sample_count + (row < target->shaded_rows);
        float scale = count > 0 ? 1.0f / (float)count : 0.0f;
        float *values = target->sums[view] + row * row_size;
        for (size_t i = 0; i < row_size; i++) {
            values[i] *= scale;
        }
    }
}

static clast_status add_samples(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    for (; target->sample < target->settings.spp; target->sample++) {
        clast_status status = clast_frame_run(frame, backend, CLAST_PASS_TRACE, CLAST_PASS_SHADE, target);
        if (status != CLAST_OK) {
            return status;
        }
        target->sample_count++;
        target->shaded_rows = 0;
    }
    return clast_progress(frame->context, "render", 1, 1);
}

static void finish(clast_frame *frame, clast_render_target *target, clast_render_statistics *statistics)
{
    const clast_view means[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_ALBEDO, CLAST_VIEW_NORMAL};
    for (size_t i = 0; i < sizeof means / sizeof means[0]; i++) {
        if (target->sums[means[i]] != NULL) {
            average(target, means[i]);
        }
    }
    uint64_t rejected = atomic_load(&target->rejected);
    if (rejected != 0) {
        clast_log(frame->context, CLAST_LOG_WARNING, "%llu samples were not finite and count as black",
                  (unsigned long long)rejected);
    }
    statistics->samples = target->sample_count;
    statistics->primary_rays = target->primary_rays;
    statistics->rays = atomic_load(&target->rays);
}

clast_status clast_render_frame(clast_frame *frame, const clast_backend *backend, const clast_render_settings *settings,
                                const clast_render_output *outputs, size_t count, clast_render_statistics *statistics)
{
    clast_context *context = frame->context;
    clast_render_target *target = clast_allocate_zeroed(context, 1, sizeof *target);
    if (target == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    target->settings = *settings;
    target->width = settings->width;
    target->height = settings->height;
    begin_outputs(target, outputs, count);
    clast_status status = begin(frame, backend, target);
    if (status == CLAST_OK) {
        status = add_samples(frame, backend, target);
        finish(frame, target, statistics);
    }
    clast_lights_destroy(context, target->lights);
    clast_scatter_destroy(context, target->scatter);
    clast_free(context, target->visibility);
    clast_free(context, target->scratch);
    clast_free(context, target);
    return status;
}
