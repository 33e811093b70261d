// SPDX-License-Identifier: Apache-2.0
// FLIP against the paper's formulas as they stand there, in double precision, with filters in the plane.
#include "test.h"

#include <math.h>
#include <string.h>

#include "clast/image.h"

enum { WIDTH = 24, HEIGHT = 18, PIXELS = WIDTH * HEIGHT };
static const double pi = 3.14159265358979323846;

typedef struct colour {
    double v[3];
} colour;

static double to_linear(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

static colour multiply(const double m[3][3], colour c)
{
    colour r;
    for (int i = 0; i < 3; i++) {
        r.v[i] = m[i][0] * c.v[0] + m[i][1] * c.v[1] + m[i][2] * c.v[2];
    }
    return r;
}

// The exact primaries of Rec. 709, as fractions.
static const double xyz_of[3][3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                                    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                                    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};
static const double rgb_of[3][3] = {{3.241003275, -1.537398934, -0.498615861},
                                    {-0.969224334, 1.875930071, 0.041554224},
                                    {0.055639423, -0.204011202, 1.057148933}};

static colour white(void)
{
    return multiply(xyz_of, (colour){{1.0, 1.0, 1.0}});
}

static colour opponents(colour linear)
{
    colour xyz = multiply(xyz_of, linear), w = white();
    double x = xyz.v[0] / w.v[0], y = xyz.v[1] / w.v[1], z = xyz.v[2] / w.v[2];
    return (colour){{116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)}};
}

static double curve(double t)
{
    double d = 6.0 / 29.0;
    return t > d * d * d ? cbrt(t) : t / (3.0 * d * d) + 4.0 / 29.0;
}

static colour hunt_lab(colour linear)
{
    colour xyz = multiply(xyz_of, linear), w = white();
    double x = curve(xyz.v[0] / w.v[0]), y = curve(xyz.v[1] / w.v[1]), z = curve(xyz.v[2] / w.v[2]);
    double l = 116.0 * y - 16.0;
    return (colour){{l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)}};
}

static double hyab(colour a, colour b)
{
    return fabs(a.v[0] - b.v[0]) + hypot(a.v[1] - b.v[1], a.v[2] - b.v[2]);
}

static double clamp(double x)
{
    return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

static int bounded(int x, int size)
{
    return x < 0 ? 0 : x >= size ? size - 1 : x;
}

typedef double weight_function(int x, int y, double deviation);

static double edge_weight(int x, int y, double s)
{
    return -x * exp(-(x * x + y * y) / (2.0 * s * s));
}

static double point_weight(int x, int y, double s)
{
    return (x * x / (s * s) - 1.0) * exp(-(x * x + y * y) / (2.0 * s * s));
}

static double feature(const colour *image, int px, int py, double s, weight_function *weight, bool down)
{
    int radius = (int)ceil(3.0 * s);
    double above = 0.0, below = 0.0, sum_above = 0.0, sum_below = 0.0;
    for (int y = -radius; y <= radius; y++) {
        for (int x = -radius; x <= radius; x++) {
            double w = down ? weight(y, x, s) : weight(x, y, s);
            double value = image[bounded(py + y, HEIGHT) * WIDTH + bounded(px + x, WIDTH)].v[0];
            value = (value + 16.0) / 116.0;
            *(w > 0.0 ? &above : &below) += fabs(w);
            *(w > 0.0 ? &sum_above : &sum_below) += w * value;
        }
    }
    return sum_above / above + sum_below / below;
}

static colour resolve(const colour *image, int px, int py, double density)
{
    static const double a1[3] = {1.0, 1.0, 34.1}, b1[3] = {0.0047, 0.0053, 0.04};
    int radius = (int)ceil(3.0 * sqrt(0.04 / (2.0 * pi * pi)) * density);
    double sums[3] = {0.0}, totals[3] = {0.0};
    for (int y = -radius; y <= radius; y++) {
        for (int x = -radius; x <= radius; x++) {
            double square = (x * x + y * y) / (density * density);
            const colour *at = &image[bounded(py + y, HEIGHT) * WIDTH + bounded(px + x, WIDTH)];
            for (int c = 0; c < 3; c++) {
                double w = a1[c] * sqrt(pi / b1[c]) * exp(-pi * pi * square / b1[c]);
                w += c == 2 ? 13.5 * sqrt(pi / 0.025) * exp(-pi * pi * square / 0.025) : 0.0;
                sums[c] += w * at->v[c];
                totals[c] += w;
            }
        }
    }
    colour w = white();
    double y = (sums[0] / totals[0] + 16.0) / 116.0;
    colour xyz = {{(y + sums[1] / totals[1] / 500.0) * w.v[0], y * w.v[1], (y - sums[2] / totals[2] / 200.0) * w.v[2]}};
    colour linear = multiply(rgb_of, xyz);
    return hunt_lab((colour){{clamp(linear.v[0]), clamp(linear.v[1]), clamp(linear.v[2])}});
}

static double expected_error(const colour *a, const colour *b, int x, int y, double density)
{
    double s = 0.5 * 0.082 * density;
    double largest = pow(hyab(hunt_lab((colour){{0.0, 1.0, 0.0}}), hunt_lab((colour){{0.0, 0.0, 1.0}})), 0.7);
    double e = pow(hyab(resolve(a, x, y, density), resolve(b, x, y, density)), 0.7);
    double limit = 0.4 * largest;
    e = e < limit ? 0.95 / limit * e : 0.95 + (e - limit) / (largest - limit) * 0.05;
    double features[2];
    weight_function *weights[2] = {edge_weight, point_weight};
    for (int i = 0; i < 2; i++) {
        double in_a = hypot(feature(a, x, y, s, weights[i], false), feature(a, x, y, s, weights[i], true));
        double in_b = hypot(feature(b, x, y, s, weights[i], false), feature(b, x, y, s, weights[i], true));
        features[i] = fabs(in_a - in_b);
    }
    double f = sqrt(fmax(features[0], features[1]) / sqrt(2.0));
    return pow(e, 1.0 - f);
}

static void make_pictures(uint8_t *a, uint8_t *b)
{
    uint32_t state = 12345;
    for (int i = 0; i < 3 * PIXELS; i++) {
        int x = i / 3 % WIDTH, y = i / 3 / WIDTH;
        state = state * 1664525u + 1013904223u;
        a[i] = (uint8_t)(10 * x + (i % 3) * 3 * y);
        b[i] = (uint8_t)(x > 12 && y < 9 ? 255 - a[i] : y > 14 ? (int)(state >> 24) : a[i]);
    }
}

static void errors_are_those_of_the_papers_formulas(void **state)
{
    uint8_t a[3 * PIXELS], b[3 * PIXELS];
    make_pictures(a, b);
    static colour in_a[PIXELS], in_b[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        colour linear_a, linear_b;
        for (int c = 0; c < 3; c++) {
            linear_a.v[c] = to_linear(a[3 * i + c] / 255.0);
            linear_b.v[c] = to_linear(b[3 * i + c] / 255.0);
        }
        in_a[i] = opponents(linear_a);
        in_b[i] = opponents(linear_b);
    }
    const clast_image image_a = {WIDTH, HEIGHT, 3, CLAST_PIXEL_UNORM8, a};
    const clast_image image_b = {WIDTH, HEIGHT, 3, CLAST_PIXEL_UNORM8, b};
    const double densities[] = {67.0, 30.0};
    for (int d = 0; d < 2; d++) {
        float errors[PIXELS];
        double mean, sum = 0.0;
        assert_ok(*state, clast_image_flip(*state, &image_a, &image_b, densities[d], errors, &mean));
        for (int i = 0; i < PIXELS; i++) {
            double expected = expected_error(in_a, in_b, i % WIDTH, i / WIDTH, densities[d]);
            assert_true(fabs((double)errors[i] - expected) < 2e-3);
            sum += expected;
        }
        assert_true(fabs(mean - sum / PIXELS) < 2e-4);
    }
}

static void equal_pictures_have_no_errors_and_opposite_ones_many(void **state)
{
    uint8_t green[3 * PIXELS] = {0}, blue[3 * PIXELS] = {0};
    for (int i = 0; i < PIXELS; i++) {
        green[3 * i + 1] = 255;
        blue[3 * i + 2] = 255;
    }
    const clast_image a = {WIDTH, HEIGHT, 3, CLAST_PIXEL_UNORM8, green};
    const clast_image b = {WIDTH, HEIGHT, 3, CLAST_PIXEL_UNORM8, blue};
    double mean;
    assert_ok(*state, clast_image_flip(*state, &a, &a, 0.0, NULL, &mean));
    assert_true(mean == 0.0);
    assert_ok(*state, clast_image_flip(*state, &a, &b, 0.0, NULL, &mean));
    assert_true(fabs(mean - 1.0) < 1e-4); // the most that the measure can give
}

static void of_float_pictures_every_exposure_counts(void **state)
{
    float a[PIXELS], b[PIXELS];
    for (int i = 0; i < PIXELS; i++) {
        int x = i % WIDTH, y = i / WIDTH;
        a[i] = b[i] = x < 14 ? 0.001f : 1000.0f; // the median is dark
        // the dark ones can be seen at exposures at which the other half is white
        b[i] = x < 6 && y < 6 ? 0.003f : x > 17 && y > 11 ? 300.0f : a[i];
    }
    const clast_image in_a = {WIDTH, HEIGHT, 1, CLAST_PIXEL_FLOAT, a}, in_b = {WIDTH, HEIGHT, 1, CLAST_PIXEL_FLOAT, b};
    float errors[PIXELS];
    double mean;
    assert_ok(*state, clast_image_flip(*state, &in_a, &in_b, 0.0, errors, &mean));
    assert_true(errors[2 * WIDTH + 2] > 0.05f && errors[PIXELS - 3] > 0.05f);
    assert_true(errors[WIDTH * (HEIGHT - 1) + 1] < 1e-3f);
    b[7] = NAN;
    assert_ok(*state, clast_image_flip(*state, &in_a, &in_b, 0.0, errors, &mean));
    assert_true(isfinite(mean));
}

static void what_cannot_be_compared_is_refused(void **state)
{
    const uint8_t pixels[4] = {0};
    const clast_image a = {2, 1, 1, CLAST_PIXEL_UNORM8, pixels}, b = {1, 2, 1, CLAST_PIXEL_UNORM8, pixels};
    double mean;
    assert_int_equal(clast_image_flip(*state, &a, &b, 0.0, NULL, &mean), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(*state), "2 x 1 and 1 x 2"));
    assert_int_equal(clast_image_flip(*state, &a, NULL, 0.0, NULL, &mean), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_image_flip(*state, &a, &a, -1.0, NULL, &mean), CLAST_ERROR_INVALID_ARGUMENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(errors_are_those_of_the_papers_formulas),
        CONTEXT_TEST(equal_pictures_have_no_errors_and_opposite_ones_many),
        CONTEXT_TEST(of_float_pictures_every_exposure_counts),
        CONTEXT_TEST(what_cannot_be_compared_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
