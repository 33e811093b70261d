// SPDX-License-Identifier: Apache-2.0
// The squares of pixels of what is rendered (shared/square.h): which of them go on, and how many samples each has.
#ifndef CLAST_RENDER_SQUARES_H
#define CLAST_RENDER_SQUARES_H

#include "base/context.h"
#include "clast/render.h"
#include "shared/square.h"

typedef struct clast_squares {
    uint32_t across, count;
    uint32_t inset_x, inset_y; // of what is rendered in its first square
    uint32_t width, height;    // in pixels
    uint32_t *active;          // those that go on, neighbours after each other
    uint32_t active_count;
    uint32_t version;  // grows where `active` changes
    uint32_t done;     // the first of the active ones that have the sample under way already
    uint32_t *samples; // that each square has
    float *noise;      // of each as it was measured last; null where no noise is too much
    uint64_t work;     // samples of pixels that were made
    uint64_t expected; // samples of pixels until all squares are below the noise target; 0: not known
} clast_squares;

// What settings.crop says; the whole picture without it. INVALID_ARGUMENT where that does not lie in the picture. The other
// settings are resolved.
clast_status clast_find_area(clast_context *context, const clast_render_settings *settings, clast_render_area *area);

clast_status clast_squares_begin(clast_context *context, const clast_render_area *area, bool by_noise,
                                 clast_squares *squares);
void clast_squares_free(clast_context *context, clast_squares *squares);

// How many of a square's pixels are rendered.
uint32_t clast_square_pixels(const clast_squares *squares, uint32_t square);
// The next `count` active squares have the sample under way.
void clast_squares_advance(clast_squares *squares, uint32_t count);
// All have it: the next sample begins with the first of them.
void clast_squares_end_sample(clast_squares *squares);
// Ends those whose noise is below the target; `most` is the most samples that a square gets.
void clast_squares_settle(clast_squares *squares, double target, uint32_t most);
// Lists as active those of the mask, a byte each.
void clast_squares_choose(clast_squares *squares, const uint8_t *goes_on);

static inline uint32_t clast_square_of_pixel(const clast_squares *squares, uint32_t x, uint32_t y)
{
    return (y + squares->inset_y) / SQUARE_SIDE * squares->across + (x + squares->inset_x) / SQUARE_SIDE;
}

static inline clast_path_pixel clast_pixel_of_square(const clast_squares *squares, uint32_t square, uint32_t within)
{
    return pixel_of_square(square, within, squares->across, squares->inset_x, squares->inset_y);
}

#endif
