// SPDX-License-Identifier: Apache-2.0
// A render: samples until there are enough, then means.
#include <string.h>

#include "base/thread.h"
#include "render/checkpoint.h"
#include "render/levels.h"
#include "render/path.h"
#include "render/scatter.h"
#include "render/shutter.h"

typedef struct view_layout {
    uint32_t channels;
    bool is_float;
} view_layout;

#define VIEW_LAYOUT(name, value, text, channels, is_float, help) [name] = {channels, is_float},
static const view_layout layouts[CLAST_VIEW_COUNT_] = {CLAST_VIEW_LIST(VIEW_LAYOUT)};

static size_t pixel_count(const clast_render_target *target)
{
    return (size_t)target->area.width * target->area.height;
}

// Sums are kept in the caller's own memory.
static void begin_outputs(clast_render_target *target, const clast_render_output *outputs, size_t count)
{
    size_t pixels = pixel_count(target);
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

// Noise is that of colour, whichever views are wanted.
static clast_status begin_noise(clast_context *context, clast_render_target *target)
{
    target->halves = clast_allocate_zeroed(context, pixel_count(target), 3 * sizeof(float));
    if (target->halves != NULL && target->sums[CLAST_VIEW_COLOUR] == NULL) {
        target->own_colour = clast_allocate_zeroed(context, pixel_count(target), 3 * sizeof(float));
        target->sums[CLAST_VIEW_COLOUR] = target->own_colour;
    }
    return target->halves != NULL && target->sums[CLAST_VIEW_COLOUR] != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// What the CPU's passes work in.
static clast_status begin_cpu(clast_context *context, clast_render_target *target)
{
    target->visibility = clast_allocate(context, pixel_count(target), sizeof *target->visibility);
    target->scratch = clast_allocate(context, clast_worker_count(context), sizeof *target->scratch);
    return target->visibility != NULL && target->scratch != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// How many samples there may be, up to the next power of two.
static uint32_t power_for(uint32_t samples)
{
    uint32_t power = 0;
    while (power < 20 && 1u << power < samples) {
        power++;
    }
    return power;
}

static clast_status begin(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    clast_context *context = frame->context;
    clast_srgb_table_fill(&target->srgb);
    bool by_noise = target->settings.noise_target > 0.0;
    clast_status status = clast_squares_begin(context, &target->area, by_noise, &target->squares);
    if (status == CLAST_OK && by_noise) {
        status = begin_noise(context, target);
    }
    if (status == CLAST_OK && backend == &clast_cpu_backend) {
        status = begin_cpu(context, target);
    }
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

// ------------------------------------------------------------------------------------------------------------- samples

clast_status clast_render_report(const clast_frame *frame, const clast_render_target *target, double part)
{
    enum { WHOLE = 1 << 30 };
    const clast_squares *squares = &target->squares;
    double done = ((double)target->sample + part) / (double)target->settings.spp;
    if (squares->noise != NULL) {
        done = squares->expected != 0 ? (double)squares->work / (double)squares->expected : 0.0;
    }
    if (target->settings.time_limit > 0.0) {
        double passed = (clast_clock() - target->begun) / target->settings.time_limit;
        done = passed > done ? passed : done;
    }
    return clast_progress(frame->context, "render", (uint64_t)((done < 1.0 ? done : 1.0) * WHOLE), WHOLE);
}

// The next sample will take as long as the last one.
static bool time_is_up(const clast_render_target *target)
{
    double limit = target->settings.time_limit, passed = clast_clock() - target->begun;
    return limit > 0.0 && target->sample != target->first_sample && passed + target->sample_seconds > limit;
}

// Between rounds, and never before each pixel has the least samples: squares whose noise is below the target end.
static clast_status settle(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    const clast_render_settings *settings = &target->settings;
    if (target->halves == NULL || target->sample % ROUND_SAMPLES != 0 || target->sample < settings->min_spp) {
        return CLAST_OK;
    }
    clast_status status = backend->measure(frame, target);
    if (status == CLAST_OK) {
        clast_squares_settle(&target->squares, settings->noise_target, settings->spp);
    }
    return status;
}

static clast_status add_sample(clast_frame *frame, const clast_backend *backend, clast_render_target *target)
{
    double start = clast_clock();
    clast_status status = clast_shutter_move(frame, backend, target);
    if (status != CLAST_OK) {
        return status;
    }
    status = clast_frame_run(frame, backend, CLAST_PASS_TRACE, CLAST_PASS_SHADE, target);
    if (status != CLAST_OK) {
        return status;
    }
    clast_squares_end_sample(&target->squares);
    target->sample++;
    status = settle(frame, backend, target);
    target->sample_seconds = clast_clock() - start;
    if (target->first_sample_seconds == 0.0) {
        target->first_sample_seconds = clast_clock() - target->begun;
    }
    return status;
}

// Brings the sums to the target, and writes the checkpoint, where there is to be one.
static clast_status save(clast_frame *frame, const clast_backend *backend, clast_checkpoint_keeper *keeper,
                         clast_render_target *target)
{
    clast_status status = backend->fetch != NULL ? backend->fetch(frame, target) : CLAST_OK;
    if (status != CLAST_OK || keeper->files.save == NULL) {
        return status;
    }
    if (clast_checkpoint_save(frame, keeper, target) != CLAST_OK) {
        clast_log(frame->context, CLAST_LOG_WARNING, "the checkpoint could not be written: %s",
                  clast_context_error(frame->context));
    }
    return CLAST_OK;
}

static clast_status add_samples(clast_frame *frame, const clast_backend *backend, clast_checkpoint_keeper *keeper,
                                clast_render_target *target)
{
    clast_status status = CLAST_OK;
    while (target->sample < target->settings.spp && target->squares.active_count != 0 && !time_is_up(target)) {
        status = add_sample(frame, backend, target);
        if (status == CLAST_OK && keeper->files.save != NULL &&
            clast_clock() - keeper->saved >= keeper->files.interval) {
            status = save(frame, backend, keeper, target);
        }
        if (status != CLAST_OK) {
            return status;
        }
    }
    return clast_progress(frame->context, "render", 1, 1);
}

// -------------------------------------------------------------------------------------------------------------- the end

// What each pixel has had of samples differs: where noise decides, and within a sample that was cancelled.
static void average(const clast_render_target *target, clast_view view)
{
    uint32_t channels = layouts[view].channels;
    for (uint32_t y = 0; y < target->area.height; y++) {
        float *row = target->sums[view] + (size_t)y * target->area.width * channels;
        for (uint32_t x = 0; x < target->area.width; x++) {
            uint32_t samples = target->squares.samples[clast_square_of_pixel(&target->squares, x, y)];
            float scale = samples > 0 ? 1.0f / (float)samples : 0.0f;
            for (uint32_t c = 0; c < channels; c++) {
                row[x * channels + c] *= scale;
            }
        }
    }
}

static void show_samples(const clast_render_target *target)
{
    uint32_t *view = target->firsts[CLAST_VIEW_SAMPLES];
    for (uint32_t y = 0; view != NULL && y < target->area.height; y++) {
        for (uint32_t x = 0; x < target->area.width; x++) {
            view[(size_t)y * target->area.width + x] =
                target->squares.samples[clast_square_of_pixel(&target->squares, x, y)];
        }
    }
}

static uint64_t pixels_above_target(const clast_render_target *target)
{
    const clast_squares *squares = &target->squares;
    uint64_t count = 0;
    for (uint32_t i = 0; squares->noise != NULL && i < squares->active_count; i++) {
        count += clast_square_pixels(squares, squares->active[i]);
    }
    return count;
}

static void finish(clast_frame *frame, clast_render_target *target, clast_render_statistics *statistics)
{
    const clast_view means[] = {CLAST_VIEW_COLOUR, CLAST_VIEW_ALBEDO, CLAST_VIEW_NORMAL};
    for (size_t i = 0; i < sizeof means / sizeof means[0]; i++) {
        if (target->sums[means[i]] != NULL) {
            average(target, means[i]);
        }
    }
    show_samples(target);
    uint64_t rejected = atomic_load(&target->rejected);
    if (rejected != 0) {
        clast_log(frame->context, CLAST_LOG_WARNING, "%llu samples were not finite and count as black",
                  (unsigned long long)rejected);
    }
    statistics->samples = target->sample;
    statistics->mean_samples = (double)target->squares.work / (double)pixel_count(target);
    statistics->pixels_above_target = pixels_above_target(target);
    statistics->first_sample_milliseconds = 1e3 * target->first_sample_seconds;
    statistics->primary_rays = target->squares.work - target->first_work;
    statistics->rays = statistics->primary_rays + atomic_load(&target->rays);
}

static void free_target(clast_context *context, clast_render_target *target)
{
    clast_squares_free(context, &target->squares);
    clast_lights_destroy(context, target->lights);
    clast_scatter_destroy(context, target->scatter);
    clast_free(context, target->visibility);
    clast_free(context, target->scratch);
    clast_free(context, target->halves);
    clast_free(context, target->own_colour);
    clast_free(context, target);
}

static clast_status render(clast_frame *frame, const clast_backend *backend, clast_checkpoint_keeper *keeper,
                           clast_render_target *target, clast_render_statistics *statistics)
{
    clast_status status = begin(frame, backend, target);
    if (status == CLAST_OK) {
        status = clast_checkpoint_begin(frame, keeper, target);
    }
    if (status != CLAST_OK) {
        return status;
    }
    target->begun = clast_clock();
    status = add_samples(frame, backend, keeper, target);
    if (status == CLAST_OK || status == CLAST_ERROR_CANCELLED) {
        clast_status saved = save(frame, backend, keeper, target);
        saved = saved == CLAST_OK && keeper->failed ? CLAST_ERROR_FILE_WRITE : saved;
        status = saved != CLAST_OK ? saved : status;
    }
    finish(frame, target, statistics);
    clast_status closed = clast_shutter_close(frame, backend, target);
    return status == CLAST_OK ? closed : status;
}

clast_status clast_render_run(clast_frame *frame, const clast_backend *backend, const clast_render_request *request,
                              clast_render_statistics *statistics)
{
    clast_context *context = frame->context;
    const clast_render_settings *settings = request->settings;
    clast_checkpoint_keeper keeper = {.files = request->checkpoint, .device = request->device};
    clast_render_target *target = clast_allocate_zeroed(context, 1, sizeof *target);
    if (target == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    target->settings = *settings;
    target->width = settings->width;
    target->height = settings->height;
    target->power = power_for(settings->spp);
    clast_status status = clast_find_area(context, settings, &target->area);
    if (status == CLAST_OK) {
        begin_outputs(target, request->outputs, request->output_count);
        status = render(frame, backend, &keeper, target, statistics);
    }
    free_target(context, target);
    return status;
}

clast_status clast_render_frame(clast_frame *frame, const clast_backend *backend, const clast_render_settings *settings,
                                const clast_render_output *outputs, size_t count, clast_render_statistics *statistics)
{
    clast_render_request request = {.settings = settings, .outputs = outputs, .output_count = count, .device = ""};
    return clast_render_run(frame, backend, &request, statistics);
}
