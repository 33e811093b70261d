// SPDX-License-Identifier: Apache-2.0
// A picture as squares of pixels: what is rendered goes square by square, and where a noise target is set, each square goes on
// until its noise is below it. Squares are those of the whole picture also where only a part of it is rendered, so that its
// pixels go the same way.
#ifndef CLAST_SHARED_SQUARE_H
#define CLAST_SHARED_SQUARE_H

#include "shared/records.h"

LIMIT(SQUARE_SIDE, 8u, "pixels of a square's side")
LIMIT(SQUARE_PIXELS, 64u, "pixels of a square")
LIMIT(ROUND_SAMPLES, 16u, "samples between two looks at the noise")

// A pixel of what is rendered.
RECORD(clast_path_pixel)
{
    uint x;
    uint y;
};
RECORD_SIZE(clast_path_pixel, 8)

// What is rendered begins so many pixels inside of its first square.
FN uint square_inset(uint first_pixel) { return first_pixel % SQUARE_SIDE; }

// A pixel of a square. It may lie outside of what is rendered: then x or y is not below the width or the height.
FN clast_path_pixel pixel_of_square(uint square, uint within, uint squares_across, uint inset_x, uint inset_y)
{
    clast_path_pixel pixel;
    pixel.x = square % squares_across * SQUARE_SIDE + within % SQUARE_SIDE - inset_x;
    pixel.y = square / squares_across * SQUARE_SIDE + within / SQUARE_SIDE - inset_y;
    return pixel;
}

// Whether a sample counts for a pixel's half: the first half of each round, which is a net of its own.
FN bool is_of_half(uint sample_number) { return sample_number % ROUND_SAMPLES < ROUND_SAMPLES / 2u; }

TABLE float NOISE_DARKEST = 1e-4f; // that an eye tells from black

// The noise of a pixel, from the sums of all samples and of half of them, whose means differ as much as the mean of
// all does from the truth: Dammertz, Hanika, Keller and Lensch, A Hierarchical Automatic Stopping Condition for Monte Carlo
// Global Illumination, WSCG 2010. That of a square is the mean. Noise is taken as an eye sees it: of the square root of the
// radiance, where white is one, and of half its logarithm above.
FN float pixel_noise(vec3 sum, vec3 half_sum, float samples, float gain)
{
    float scale = rough_divide(gain, samples);
    vec3 mean = sum * scale;
    vec3 difference = mean - half_sum * (2.0f * scale);
    float brightness = max1((mean[0] + mean[1] + mean[2]) * 0.333333333f, NOISE_DARKEST);
    float slope = rough_divide(0.5f, brightness < 1.0f ? rough_sqrt(brightness) : brightness);
    return rough_sqrt(dot3(difference, difference) * 0.333333333f) * slope;
}

#endif
