// SPDX-License-Identifier: Apache-2.0
// Views as pictures to look at.
#include <math.h>

#include "base/thread.h"
#include "render/display.h"

typedef struct display_job {
    clast_view view;
    const void *values;
    clast_display how;
    uint8_t *bytes; // one of the two
    uint16_t *words;
} display_job;

static vec3 vector_at(const void *values, size_t i)
{
    const float *v = (const float *)values + 3 * i;
    return vec3(v[0], v[1], v[2]);
}

static vec3 pixel_colour(const display_job *job, size_t i)
{
    const float *reals = job->values;
    const uint32_t *numbers = job->values;
    switch (job->view) {
    case CLAST_VIEW_COLOUR: return tone_map(vector_at(reals, i), job->how.gain, job->how.curve);
    case CLAST_VIEW_ALBEDO: return display_albedo(vector_at(reals, i));
    case CLAST_VIEW_NORMAL: return display_normal(vector_at(reals, i));
    case CLAST_VIEW_DEPTH: return display_depth(job->how, reals[i]);
    case CLAST_VIEW_UV: return display_uv(vec2(reals[2 * i], reals[2 * i + 1]));
    case CLAST_VIEW_INSTANCE:
    case CLAST_VIEW_CLUSTER:
    case CLAST_VIEW_TRIANGLE:
    case CLAST_VIEW_PRIMITIVE: return display_number(numbers[i]);
    case CLAST_VIEW_SEGMENTS: return display_segments(reals[i]);
    case CLAST_VIEW_RATE: return display_balance(reals[i]);
    case CLAST_VIEW_AREA: return display_balance(reals[i] / job->how.area);
    case CLAST_VIEW_STEPS: return display_steps(job->how, numbers[i]);
    case CLAST_VIEW_SAMPLES: return display_samples(job->how, numbers[i]);
    case CLAST_VIEW_COUNT_: break;
    }
    return splat3(0.0f);
}

static void display_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const display_job *job = data;
    for (size_t i = begin; i < end; i++) {
        vec3 colour = pixel_colour(job, i);
        for (size_t c = 0; c < 3; c++) {
            if (job->bytes != NULL) {
                job->bytes[3 * i + c] = (uint8_t)display_level(colour[c], 255.0f);
            } else {
                job->words[3 * i + c] = (uint16_t)display_level(colour[c], 65535.0f);
            }
        }
    }
}

static void find_range(display_job *job, size_t count)
{
    if (job->view == CLAST_VIEW_DEPTH) {
        const float *depths = job->values;
        float near = INFINITY, far = 0.0f;
        for (size_t i = 0; i < count; i++) {
            bool there = display_is_there(depths[i]);
            near = there ? min1(near, depths[i]) : near;
            far = there ? max1(far, depths[i]) : far;
        }
        job->how.low = far > 0.0f ? logf(near) : 0.0f;
        job->how.high = far > 0.0f ? logf(far) : 0.0f;
    } else if (job->view == CLAST_VIEW_STEPS) {
        const uint32_t *steps = job->values;
        uint32_t most = 1;
        for (size_t i = 0; i < count; i++) {
            most = steps[i] != CLAST_NONE ? max_uint(most, steps[i]) : most;
        }
        job->how.high = (float)most;
    } else if (job->view == CLAST_VIEW_SAMPLES) {
        const uint32_t *samples = job->values;
        uint32_t least = UINT32_MAX, most = 1;
        for (size_t i = 0; i < count; i++) {
            bool there = samples[i] != 0 && samples[i] != CLAST_NONE;
            least = there ? min_uint(least, samples[i]) : least;
            most = there ? max_uint(most, samples[i]) : most;
        }
        job->how.low = log2f((float)max_uint(least, 1));
        job->how.high = log2f((float)most);
    }
}

clast_display clast_display_of(const clast_render_settings *settings)
{
    // Equilateral triangles with sides of the wanted length, where that is one of pixels.
    bool of_pixels = settings->metric == CLAST_METRIC_PIXELS || settings->metric == CLAST_METRIC_SPHERE;
    bool is_known = of_pixels && settings->segment > 0.0;
    return (clast_display){
        .curve = settings->tonemap,
        .gain = exp2f((float)settings->exposure),
        .area = is_known ? 0.4330127f * (float)(settings->segment * settings->segment) : 1.0f,
    };
}

static clast_status to_display(clast_context *context, const display_job *wanted, uint32_t width, uint32_t height,
                               const clast_render_settings *settings)
{
    if (context == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    display_job job = *wanted;
    if ((uint32_t)job.view >= CLAST_VIEW_COUNT_ || job.values == NULL || (job.bytes == NULL && job.words == NULL) ||
        width == 0 || height == 0) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "view to display: there is no such view, or no pixels");
    }
    job.how = clast_display_of(settings != NULL ? settings : &(clast_render_settings){0});
    size_t count = (size_t)width * height;
    find_range(&job, count);
    clast_parallel_for(context, count, 4096, display_range, &job);
    return CLAST_OK;
}

clast_status clast_view_to_display(clast_context *context, clast_view view, const void *values, uint32_t width,
                                   uint32_t height, const clast_render_settings *settings, uint8_t *pixels)
{
    return to_display(context, &(display_job){.view = view, .values = values, .bytes = pixels}, width, height,
                      settings);
}

clast_status clast_view_to_display_16(clast_context *context, clast_view view, const void *values, uint32_t width,
                                      uint32_t height, const clast_render_settings *settings, uint16_t *pixels)
{
    return to_display(context, &(display_job){.view = view, .values = values, .words = pixels}, width, height,
                      settings);
}
