// SPDX-License-Identifier: Apache-2.0
// How much two images differ.
#include <math.h>

#include "load/image.h"

// A pixel's four channels on the scale of the file; grey counts as three, a missing alpha is 1.
static void read_pixel(const clast_image *image, size_t number, double pixel[4])
{
    double values[4] = {0.0};
    for (uint32_t c = 0; c < image->channels; c++) {
        size_t i = number * image->channels + c;
        switch (image->type) {
        case CLAST_PIXEL_UNORM8: values[c] = ((const uint8_t *)image->pixels)[i] / 255.0; break;
        case CLAST_PIXEL_UNORM16: values[c] = ((const uint16_t *)image->pixels)[i] / 65535.0; break;
        default: values[c] = (double)((const float *)image->pixels)[i]; break;
        }
    }
    bool grey = image->channels < 3;
    for (int c = 0; c < 3; c++) {
        pixel[c] = values[grey ? 0 : c];
    }
    pixel[3] = image->channels == 2 || image->channels == 4 ? values[image->channels - 1] : 1.0;
}

// NaN equals NaN, and equal infinities differ by nothing.
static double difference_of(double a, double b)
{
    if (a == b || (isnan(a) && isnan(b))) {
        return 0.0;
    }
    double difference = fabs(a - b);
    return isnan(difference) ? HUGE_VAL : difference;
}

clast_status clast_image_compare(clast_context *context, const clast_image *a, const clast_image *b,
                                 clast_image_difference *difference)
{
    if (context == NULL || difference == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (a == NULL || b == NULL || a->pixels == NULL || b->pixels == NULL || a->channels - 1 > 3 ||
        b->channels - 1 > 3) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT, "compare: an image has no pixels");
    }
    if (a->width != b->width || a->height != b->height) {
        return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                          "compare: the images have different sizes: %u x %u and %u x %u", a->width, a->height,
                          b->width, b->height);
    }
    *difference = (clast_image_difference){0};
    bool alpha = a->channels % 2 == 0 || b->channels % 2 == 0;
    int channels = alpha ? 4 : 3;
    size_t count = (size_t)a->width * a->height;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) {
        double pixel_a[4], pixel_b[4];
        bool differs = false;
        read_pixel(a, i, pixel_a);
        read_pixel(b, i, pixel_b);
        for (int c = 0; c < channels; c++) {
            double one = difference_of(pixel_a[c], pixel_b[c]);
            sum += one * one;
            differs = differs || one != 0.0;
            if (one > difference->maximum) {
                difference->maximum = one;
                difference->maximum_x = (uint32_t)(i % a->width);
                difference->maximum_y = (uint32_t)(i / a->width);
            }
        }
        difference->differing_pixels += differs;
    }
    difference->mean_squared_error = count > 0 ? sum / ((double)count * channels) : 0.0;
    return CLAST_OK;
}
