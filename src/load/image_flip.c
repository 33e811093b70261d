// SPDX-License-Identifier: Apache-2.0
// What an eye sees of the difference between two images that take turns in one place: Andersson et al., FLIP: A Difference
// Evaluator for Alternating Images, 2020; of images without a fixed white, Visualizing Errors in Rendered High Dynamic Range
// Images, 2021: the largest over exposures.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/size.h"
#include "base/thread.h"
#include "load/image.h"
#include "shared/sampling.h"
#include "shared/texture_filter.h"

enum { ROW_GRAIN = 8, RADIUS_MOST = 4096, PLANES = 12 };

static const float usual_pixels_per_degree = 67.0206433f; // a screen 3840 pixels and 0.7 m wide, seen from 0.7 m

// ------------------------------------------------------------------------------------------------------------- colours

// Linear Rec. 709 to CIE XYZ, and back; D65 is (1, 1, 1)'s.
static const float to_xyz[3][3] = {
    {0.4123908f, 0.3575843f, 0.1804808f}, {0.2126390f, 0.7151687f, 0.0721923f}, {0.0193308f, 0.1191948f, 0.9505322f}};
static const float from_xyz[3][3] = {{3.2409699f, -1.5373832f, -0.4986108f},
                                     {-0.9692436f, 1.8759675f, 0.0415551f},
                                     {0.0556301f, -0.2039770f, 1.0569715f}};
static const vec3 white = {0.9504559f, 1.0f, 1.0890578f};

static vec3 transform(const float rows[3][3], vec3 v)
{
    vec3 result = splat3(0.0f);
    for (int i = 0; i < 3; i++) {
        result[i] = rows[i][0] * v[0] + rows[i][1] * v[1] + rows[i][2] * v[2];
    }
    return result;
}

// Lightness and two opponent colours, linear in the light.
static vec3 to_opponents(vec3 linear)
{
    vec3 xyz = transform(to_xyz, linear) / white;
    return vec3(116.0f * xyz[1] - 16.0f, 500.0f * (xyz[0] - xyz[1]), 200.0f * (xyz[1] - xyz[2]));
}

static vec3 from_opponents(vec3 c)
{
    float y = (c[0] + 16.0f) / 116.0f;
    vec3 xyz = vec3(y + c[1] / 500.0f, y, y - c[2] / 200.0f);
    return transform(from_xyz, xyz * white);
}

static float lab_curve(float t)
{
    const float d = 6.0f / 29.0f;
    return t > d * d * d ? cbrtf(t) : t / (3.0f * d * d) + 4.0f / 29.0f;
}

// CIELAB, its colours fainter where it is dark (Hunt's effect).
static vec3 to_lab(vec3 linear)
{
    vec3 xyz = transform(to_xyz, linear) / white;
    float x = lab_curve(xyz[0]), y = lab_curve(xyz[1]), z = lab_curve(xyz[2]);
    float lightness = 116.0f * y - 16.0f;
    return vec3(lightness, 0.01f * lightness * 500.0f * (x - y), 0.01f * lightness * 200.0f * (y - z));
}

// Abasi et al., Distance Metrics for Very Large Color Differences, 2020.
static float lab_distance(vec3 a, vec3 b)
{
    vec3 d = a - b;
    return abs1(d[0]) + sqrtf(d[1] * d[1] + d[2] * d[2]);
}

static vec3 clamp_unit(vec3 v)
{
    return vec3(clamp1(v[0], 0.0f, 1.0f), clamp1(v[1], 0.0f, 1.0f), clamp1(v[2], 0.0f, 1.0f));
}

// ------------------------------------------------------------------------------------------------------------- filters

// A filter along one axis.
typedef struct kernel {
    int radius;
    float *weights; // of offsets -radius to radius
    float sum;      // of those above zero, before they were scaled
} kernel;

typedef struct kernels {
    kernel achromatic, red_green, blue_yellow, wide_blue_yellow; // contrast sensitivity
    float wide_share;                                            // of the last in blue and yellow
    kernel smooth, edge, point;                                  // features
    float *memory;
} kernels;

static int gaussian_radius(float deviation)
{
    float radius = ceilf(3.0f * deviation);
    return radius < 1.0f ? 1 : radius > RADIUS_MOST ? RADIUS_MOST : (int)radius;
}

static float *take_weights(float **memory, int radius)
{
    float *weights = *memory;
    *memory += 2 * radius + 1;
    return weights;
}

// exp(-x^2 / (2 deviation^2)) times a polynomial; weights above zero add up to one, those below to minus one.
static kernel make_kernel(float **memory, float deviation, int radius, float constant, float linear, float square)
{
    kernel made = {.radius = radius, .weights = take_weights(memory, radius)};
    float above = 0.0f, below = 0.0f;
    for (int i = -radius; i <= radius; i++) {
        float x = (float)i / deviation;
        float weight = expf(-0.5f * x * x) * (constant + linear * x + square * x * x);
        made.weights[i + radius] = weight;
        above += max1(weight, 0.0f);
        below -= min1(weight, 0.0f);
    }
    for (int i = 0; i <= 2 * radius; i++) {
        float sum = made.weights[i] > 0.0f ? above : below;
        made.weights[i] = sum > 0.0f ? made.weights[i] / sum : 0.0f;
    }
    made.sum = above;
    return made;
}

// The eye's response to contrast is the sum of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b) of the angle x in degrees.
static clast_status make_kernels(clast_context *context, float pixels_per_degree, kernels *made)
{
    const float b[4] = {0.0047f, 0.0053f, 0.04f, 0.025f}; // the last two are blue and yellow's
    const float a[2] = {34.1f, 13.5f};                    // their heights
    float deviations[4];
    for (int i = 0; i < 4; i++) {
        deviations[i] = sqrtf(b[i] / (2.0f * PI * PI)) * pixels_per_degree;
    }
    int radius = gaussian_radius(deviations[2]); // one for all, as in the paper
    float feature = 0.5f * 0.082f * pixels_per_degree;
    int feature_radius = gaussian_radius(feature);
    made->memory = clast_allocate(context, (size_t)(4 * (2 * radius + 1) + 3 * (2 * feature_radius + 1)),
                                  sizeof(float));
    if (made->memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    float *memory = made->memory;
    kernel *sensitivities[4] = {&made->achromatic, &made->red_green, &made->wide_blue_yellow, &made->blue_yellow};
    for (int i = 0; i < 4; i++) {
        *sensitivities[i] = make_kernel(&memory, deviations[i], radius, 1.0f, 0.0f, 0.0f);
    }
    float wide = a[0] / sqrtf(b[2]) * made->wide_blue_yellow.sum * made->wide_blue_yellow.sum;
    float narrow = a[1] / sqrtf(b[3]) * made->blue_yellow.sum * made->blue_yellow.sum;
    made->wide_share = wide / (wide + narrow);
    made->smooth = make_kernel(&memory, feature, feature_radius, 1.0f, 0.0f, 0.0f);
    made->edge = make_kernel(&memory, feature, feature_radius, 0.0f, -1.0f, 0.0f);
    made->point = make_kernel(&memory, feature, feature_radius, -1.0f, 0.0f, 1.0f);
    return CLAST_OK;
}

typedef struct filter_job {
    const float *from;
    float *to;
    const kernel *along;
    uint32_t width, height;
    bool down; // along columns
} filter_job;

static void filter_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const filter_job *job = data;
    int radius = job->along->radius, last = (int)(job->down ? job->height : job->width) - 1;
    for (size_t y = begin; y < end; y++) {
        float *to = job->to + y * job->width;
        memset(to, 0, job->width * sizeof *to);
        for (int k = -radius; k <= radius; k++) {
            float weight = job->along->weights[k + radius];
            int row = (int)y + k;
            row = row < 0 ? 0 : row > last ? last : row;
            const float *from = job->from + (job->down ? (size_t)row : y) * job->width;
            for (uint32_t x = 0; x < job->width; x++) {
                int column = (int)x + k;
                column = column < 0 ? 0 : column > last ? last : column;
                to[x] += weight * from[job->down ? x : (uint32_t)column];
            }
        }
    }
}

// What the filters work on.
typedef struct flip {
    clast_context *context;
    uint32_t width, height;
    kernels kernels;
    float *planes[PLANES]; // of width x height
    float *errors;         // the largest of the exposures so far
} flip;

// Pixels beyond the border are those at it.
static void filter(flip *f, const float *from, const kernel *across, const kernel *down, float *between, float *to)
{
    filter_job rows = {from, between, across, f->width, f->height, false};
    clast_parallel_for(f->context, f->height, ROW_GRAIN, filter_rows, &rows);
    filter_job columns = {between, to, down, f->width, f->height, true};
    clast_parallel_for(f->context, f->height, ROW_GRAIN, filter_rows, &columns);
}

// ---------------------------------------------------------------------------------------------------------- an exposure

// An image as it is shown: linear light in [0, 1].
typedef struct shown {
    const clast_image *image;
    float gain; // integer images: zero, and their own scale holds
} shown;

// Narkowicz's curve, as the paper has it.
static float display_curve(float x)
{
    float y = (x * (0.9036f * x + 0.018f)) / (x * (0.8748f * x + 0.354f) + 0.14f);
    return clamp1(y, 0.0f, 1.0f);
}

static vec3 shown_light(shown of, size_t pixel)
{
    const clast_image *image = of.image;
    vec3 light = splat3(0.0f);
    for (uint32_t c = 0; c < 3; c++) {
        size_t i = pixel * image->channels + (image->channels < 3 ? 0 : c);
        switch (image->type) {
        case CLAST_PIXEL_UNORM8: light[c] = srgb_to_linear(((const uint8_t *)image->pixels)[i] / 255.0f); break;
        case CLAST_PIXEL_UNORM16: light[c] = srgb_to_linear(((const uint16_t *)image->pixels)[i] / 65535.0f); break;
        default: light[c] = clamp1(((const float *)image->pixels)[i], 0.0f, 1e30f); break;
        }
        light[c] = of.gain > 0.0f ? display_curve(min1(light[c] * of.gain, 1e6f)) : light[c];
    }
    return clamp_unit(light);
}

typedef struct pixel_job {
    flip *f;
    shown of;
    float *const *planes; // the image's
    float *const *others; // what they are compared with
} pixel_job;

static void opponent_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const pixel_job *job = data;
    for (size_t i = begin * job->f->width; i < end * job->f->width; i++) {
        vec3 c = to_opponents(shown_light(job->of, i));
        for (int k = 0; k < 3; k++) {
            job->planes[k][i] = c[k];
        }
    }
}

// Planes 0 to 2 of the image become what the eye resolves of its colours, plane 3 the strength of its edges, 4 of its points.
static void see(flip *f, shown of, float *const planes[5], float *const scratch[2])
{
    const kernels *k = &f->kernels;
    size_t count = (size_t)f->width * f->height;
    pixel_job job = {.f = f, .of = of, .planes = planes};
    clast_parallel_for(f->context, f->height, ROW_GRAIN, opponent_rows, &job);
    const kernel *features[2] = {&k->edge, &k->point};
    for (int i = 0; i < 2; i++) {
        filter(f, planes[0], features[i], &k->smooth, scratch[0], planes[3 + i]);
        filter(f, planes[0], &k->smooth, features[i], scratch[0], scratch[1]);
        for (size_t p = 0; p < count; p++) { // of (Y + 16) / 116: the constant falls out
            planes[3 + i][p] = hypotf(planes[3 + i][p], scratch[1][p]) / 116.0f;
        }
    }
    filter(f, planes[0], &k->achromatic, &k->achromatic, scratch[0], scratch[1]);
    memcpy(planes[0], scratch[1], count * sizeof(float));
    filter(f, planes[1], &k->red_green, &k->red_green, scratch[0], scratch[1]);
    memcpy(planes[1], scratch[1], count * sizeof(float));
    filter(f, planes[2], &k->wide_blue_yellow, &k->wide_blue_yellow, scratch[0], scratch[1]);
    filter(f, planes[2], &k->blue_yellow, &k->blue_yellow, scratch[0], planes[2]);
    for (size_t p = 0; p < count; p++) {
        planes[2][p] = mix1(planes[2][p], scratch[1][p], k->wide_share);
    }
}

static vec3 resolved_lab(float *const planes[5], size_t pixel)
{
    return to_lab(clamp_unit(from_opponents(vec3(planes[0][pixel], planes[1][pixel], planes[2][pixel]))));
}

static float largest_colour_error(void)
{
    return powf(lab_distance(to_lab(vec3(0.0f, 1.0f, 0.0f)), to_lab(vec3(0.0f, 0.0f, 1.0f))), 0.7f);
}

// To [0, 1]: small errors take most of it.
static float spread_error(float error, float largest)
{
    const float knee = 0.4f, height = 0.95f;
    float at = error / largest;
    return at < knee ? at * height / knee : height + (at - knee) / (1.0f - knee) * (1.0f - height);
}

static void compare_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const pixel_job *job = data;
    float largest = largest_colour_error();
    for (size_t i = begin * job->f->width; i < end * job->f->width; i++) {
        float distance = lab_distance(resolved_lab(job->planes, i), resolved_lab(job->others, i));
        float colour = spread_error(powf(distance, 0.7f), largest);
        float edge = abs1(job->planes[3][i] - job->others[3][i]), point = abs1(job->planes[4][i] - job->others[4][i]);
        float feature = clamp1(sqrtf(max1(edge, point) * 0.707106781f), 0.0f, 1.0f);
        float error = powf(clamp1(colour, 0.0f, 1.0f), 1.0f - feature);
        job->f->errors[i] = max1(job->f->errors[i], error);
    }
}

static void add_exposure(flip *f, const clast_image *reference, const clast_image *test, float gain)
{
    float *const *planes = f->planes;
    see(f, (shown){reference, gain}, planes, planes + 10);
    see(f, (shown){test, gain}, planes + 5, planes + 10);
    pixel_job job = {.f = f, .planes = planes, .others = planes + 5};
    clast_parallel_for(f->context, f->height, ROW_GRAIN, compare_rows, &job);
}

// ----------------------------------------------------------------------------------------------------------- the whole

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// The exposures at which the reference's brightest pixel, and its median, are shown nearly white. False where it is all black.
static bool find_exposures(flip *f, const clast_image *reference, float *first, float *last)
{
    size_t count = (size_t)f->width * f->height, lit = 0;
    float *values = f->planes[0];
    for (size_t i = 0; i < count; i++) {
        const float *texel = (const float *)reference->pixels + i * reference->channels;
        uint32_t green = reference->channels < 3 ? 0 : 1, blue = reference->channels < 3 ? 0 : 2;
        float value = luminance(vec3(texel[0], texel[green], texel[blue]));
        values[i] = is_finite1(value) ? max1(value, 0.0f) : 0.0f;
        lit += values[i] > 0.0f;
    }
    if (lit == 0) {
        return false;
    }
    qsort(values, count, sizeof *values, ascending);
    // display_curve(nearly_white) = 0.85
    const float nearly_white = 2.11887232f;
    float median = count % 2 != 0 ? values[count / 2] : 0.5f * (values[count / 2 - 1] + values[count / 2]);
    median = median > 0.0f ? median : values[count - lit];
    *first = log2f(nearly_white / values[count - 1]);
    *last = log2f(nearly_white / median);
    return true;
}

static void run(flip *f, const clast_image *reference, const clast_image *test)
{
    float first = 0.0f, last = 0.0f;
    if (reference->type != CLAST_PIXEL_FLOAT || test->type != CLAST_PIXEL_FLOAT) {
        add_exposure(f, reference, test, 0.0f);
        return;
    }
    bool lit = find_exposures(f, reference, &first, &last);
    int count = lit ? (int)min1(ceilf(last - first), 32.0f) : 1;
    count = lit && count < 2 ? 2 : count;
    for (int i = 0; i < count; i++) {
        float share = count > 1 ? (float)i / (float)(count - 1) : 0.0f;
        add_exposure(f, reference, test, exp2f(mix1(first, last, share)));
    }
}

static clast_status check(clast_context *context, const clast_image *a, const clast_image *b)
{
    if (a == NULL || b == NULL || a->pixels == NULL || b->pixels == NULL || a->channels - 1 > 3 ||
        b->channels - 1 > 3 || a->width == 0 || a->height == 0) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "flip: an image has no pixels");
    }
    if (a->width != b->width || a->height != b->height) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "flip: the images have different sizes: %u x %u and %u x %u", a->width, a->height, b->width,
                          b->height);
    }
    return CLAST_OK;
}

clast_status clast_image_flip(clast_context *context, const clast_image *reference, const clast_image *test,
                              double pixels_per_degree, float *errors, double *mean)
{
    if (context == NULL || mean == NULL || !(pixels_per_degree >= 0.0 && pixels_per_degree <= 1e4)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check(context, reference, test);
    size_t pixels = 0;
    if (status == CLAST_OK && !clast_multiply_size(reference->width, reference->height, &pixels)) {
        status = CLAST_ERROR_LIMIT;
    }
    if (status != CLAST_OK) {
        return status;
    }
    flip f = {.context = context, .width = reference->width, .height = reference->height};
    float density = pixels_per_degree > 0.0 ? (float)pixels_per_degree : usual_pixels_per_degree;
    float *own = clast_allocate(context, pixels, (PLANES + 1) * sizeof *own);
    status = own != NULL ? make_kernels(context, density, &f.kernels) : CLAST_ERROR_OUT_OF_MEMORY;
    if (status == CLAST_OK) {
        for (int i = 0; i < PLANES; i++) {
            f.planes[i] = own + (size_t)i * pixels;
        }
        f.errors = errors != NULL ? errors : own + PLANES * pixels;
        memset(f.errors, 0, pixels * sizeof *f.errors);
        run(&f, reference, test);
        double sum = 0.0;
        for (size_t i = 0; i < pixels; i++) {
            sum += (double)f.errors[i];
        }
        *mean = sum / (double)pixels;
    }
    clast_free(context, f.kernels.memory);
    clast_free(context, own);
    return status;
}
