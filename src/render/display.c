// SPDX-License-Identifier: Apache-2.0
// Views as pictures to look at.
#include <math.h>

#include "base/thread.h"
#include "render/render.h"
#include "shared/random.h"
#include "shared/tone_map.h"

typedef struct display_job {
    clast_view view;
    const void *values;
    uint32_t curve;
    float gain;
    float area;      // of the triangles that are wanted, in pixels
    float low, high; // depth: logarithms of the nearest and farthest; steps: 0 and the most
    uint8_t *bytes;  // one of the two
    uint16_t *words;
} display_job;

static vec3 vector_at(const void *values, size_t i)
{
    const float *v = (const float *)values + 3 * i;
    return vec3(v[0], v[1], v[2]);
}

static vec3 clamp_unit3(vec3 v)
{
    return vec3(clamp1(v[0], 0.0f, 1.0f), clamp1(v[1], 0.0f, 1.0f), clamp1(v[2], 0.0f, 1.0f));
}

static vec3 encode3(vec3 v)
{
    v = clamp_unit3(v);
    return vec3(linear_to_srgb(v[0]), linear_to_srgb(v[1]), linear_to_srgb(v[2]));
}

// Neighbouring numbers differ in hue by the golden ratio, and in brightness.
static vec3 number_colour(uint32_t number)
{
    if (number == CLAST_NONE) {
        return splat3(0.0f);
    }
    uint32_t bits = hash1(number);
    float hue = (float)number * 0.618033989f;
    return hsv_to_rgb(vec3(hue - floorf(hue), 0.45f + 0.4f * unit_float(bits), 0.6f + 0.4f * unit_float(hash1(bits))));
}

static vec3 depth_colour(const display_job *job, float depth)
{
    if (!(depth > 0.0f) || !is_finite1(depth)) {
        return splat3(0.0f);
    }
    float range = job->high - job->low;
    float place = range > 0.0f ? (logf(depth) - job->low) / range : 0.0f;
    return splat3(1.0f - 0.9f * clamp1(place, 0.0f, 1.0f)); // near is bright, nothing is black
}

// Up the rainbow with each doubling; even counts are darker, so that neighbouring counts are told apart.
static vec3 segments_colour(float segments)
{
    if (!(segments > 0.0f) || !is_finite1(segments)) {
        return splat3(0.0f);
    }
    float half = 0.5f * floorf(segments + 0.5f);
    return heat_colour(log2f(max1(segments, 1.0f)) / 8.0f) * (half == floorf(half) ? 0.78f : 1.0f);
}

// Grey where all is as it should be, blue below (-1), red above (1).
static vec3 balance_colour(float x)
{
    float t = clamp1(x, -1.0f, 1.0f);
    vec3 end = t < 0.0f ? vec3(0.10f, 0.30f, 0.80f) : vec3(0.85f, 0.13f, 0.08f);
    return mix3(splat3(0.84f), end, abs1(t));
}

static vec3 pixel_colour(const display_job *job, size_t i)
{
    const float *reals = job->values;
    const uint32_t *numbers = job->values;
    switch (job->view) {
    case CLAST_VIEW_COLOUR: return tone_map(vector_at(reals, i), job->gain, job->curve);
    case CLAST_VIEW_ALBEDO: return encode3(vector_at(reals, i));
    case CLAST_VIEW_NORMAL: {
        vec3 normal = vector_at(reals, i);
        bool none = normal[0] == 0.0f && normal[1] == 0.0f && normal[2] == 0.0f;
        return none ? normal : clamp_unit3(normal * 0.5f + splat3(0.5f));
    }
    case CLAST_VIEW_DEPTH: return depth_colour(job, reals[i]);
    case CLAST_VIEW_UV:
        return vec3(reals[2 * i] - floorf(reals[2 * i]), reals[2 * i + 1] - floorf(reals[2 * i + 1]), 0.0f);
    case CLAST_VIEW_INSTANCE:
    case CLAST_VIEW_CLUSTER:
    case CLAST_VIEW_TRIANGLE:
    case CLAST_VIEW_PRIMITIVE: return number_colour(numbers[i]);
    case CLAST_VIEW_SEGMENTS: return segments_colour(reals[i]);
    case CLAST_VIEW_RATE: return reals[i] > 0.0f ? balance_colour(log2f(reals[i]) / 3.0f) : splat3(0.0f);
    case CLAST_VIEW_AREA: return reals[i] > 0.0f ? balance_colour(log2f(reals[i] / job->area) / 3.0f) : splat3(0.0f);
    case CLAST_VIEW_STEPS: return numbers[i] == CLAST_NONE ? splat3(0.0f) : heat_colour((float)numbers[i] / job->high);
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
            float value = clamp1(colour[c], 0.0f, 1.0f);
            if (job->bytes != NULL) {
                job->bytes[3 * i + c] = (uint8_t)(value * 255.0f + 0.5f);
            } else {
                job->words[3 * i + c] = (uint16_t)(value * 65535.0f + 0.5f);
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
            bool there = depths[i] > 0.0f && is_finite1(depths[i]);
            near = there ? min1(near, depths[i]) : near;
            far = there ? max1(far, depths[i]) : far;
        }
        job->low = far > 0.0f ? logf(near) : 0.0f;
        job->high = far > 0.0f ? logf(far) : 0.0f;
    } else if (job->view == CLAST_VIEW_STEPS) {
        const uint32_t *steps = job->values;
        uint32_t most = 1;
        for (size_t i = 0; i < count; i++) {
            most = steps[i] != CLAST_NONE ? max_uint(most, steps[i]) : most;
        }
        job->high = (float)most;
    }
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
    clast_render_settings resolved = settings != NULL ? *settings : (clast_render_settings){0};
    job.curve = resolved.tonemap;
    job.gain = exp2f((float)resolved.exposure);
    // Equilateral triangles with sides of the wanted length, where that is one of pixels.
    bool of_pixels = resolved.metric == CLAST_METRIC_PIXELS || resolved.metric == CLAST_METRIC_SPHERE;
    job.area = of_pixels && resolved.segment > 0.0 ? 0.4330127f * (float)(resolved.segment * resolved.segment) : 1.0f;
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
