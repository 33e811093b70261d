// SPDX-License-Identifier: Apache-2.0
#include "render/squares.h"

#include <string.h>

// Squares that follow each other are close to each other: their rays are traced together.
enum { BLOCK_ACROSS = 4, BLOCK_DOWN = 2 };

static void list_all(clast_squares *squares)
{
    uint32_t down = squares->count / squares->across, count = 0;
    for (uint32_t y = 0; y < down; y += BLOCK_DOWN) {
        for (uint32_t x = 0; x < squares->across; x += BLOCK_ACROSS) {
            for (uint32_t i = 0; i < BLOCK_ACROSS * BLOCK_DOWN; i++) {
                uint32_t column = x + i % BLOCK_ACROSS, row = y + i / BLOCK_ACROSS;
                if (column < squares->across && row < down) {
                    squares->active[count++] = row * squares->across + column;
                }
            }
        }
    }
    squares->active_count = count;
}

clast_status clast_squares_begin(clast_context *context, const clast_render_area *area, bool by_noise,
                                 clast_squares *squares)
{
    squares->width = area->width;
    squares->height = area->height;
    squares->inset_x = square_inset(area->x);
    squares->inset_y = square_inset(area->y);
    squares->across = (squares->inset_x + area->width + SQUARE_SIDE - 1) / SQUARE_SIDE;
    uint32_t down = (squares->inset_y + area->height + SQUARE_SIDE - 1) / SQUARE_SIDE;
    squares->count = squares->across * down; // at most 8193 * 8193
    squares->active = clast_allocate(context, squares->count, sizeof *squares->active);
    squares->samples = clast_allocate_zeroed(context, squares->count, sizeof *squares->samples);
    squares->noise = by_noise ? clast_allocate_zeroed(context, squares->count, sizeof *squares->noise) : NULL;
    if (squares->active == NULL || squares->samples == NULL || (by_noise && squares->noise == NULL)) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    list_all(squares);
    return CLAST_OK;
}

void clast_squares_free(clast_context *context, clast_squares *squares)
{
    clast_free(context, squares->active);
    clast_free(context, squares->samples);
    clast_free(context, squares->noise);
    *squares = (clast_squares){0};
}

// Of the pixels from `first` on, those of a range.
static uint32_t overlap(uint32_t first, uint32_t begin, uint32_t end)
{
    uint32_t low = first > begin ? first : begin, high = first + SQUARE_SIDE < end ? first + SQUARE_SIDE : end;
    return high - low;
}

uint32_t clast_square_pixels(const clast_squares *squares, uint32_t square)
{
    uint32_t x = square % squares->across * SQUARE_SIDE, y = square / squares->across * SQUARE_SIDE;
    return overlap(x, squares->inset_x, squares->inset_x + squares->width) *
           overlap(y, squares->inset_y, squares->inset_y + squares->height);
}

void clast_squares_advance(clast_squares *squares, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t square = squares->active[squares->done + i];
        squares->samples[square]++;
        squares->work += clast_square_pixels(squares, square);
    }
    squares->done += count;
}

void clast_squares_end_sample(clast_squares *squares)
{
    squares->done = 0;
}

// Noise falls with the root of the number of samples.
static uint64_t samples_left(double noise, double target, uint32_t samples, uint32_t most)
{
    double wanted = (double)samples * (noise / target) * (noise / target);
    wanted = wanted < (double)most ? wanted : (double)most;
    return wanted > (double)samples ? (uint64_t)wanted - samples : 0;
}

void clast_squares_settle(clast_squares *squares, double target, uint32_t most)
{
    uint32_t count = 0;
    squares->expected = squares->work;
    for (uint32_t i = 0; i < squares->active_count; i++) {
        uint32_t square = squares->active[i];
        double noise = (double)squares->noise[square];
        if (noise > target) {
            squares->active[count++] = square;
            squares->expected += clast_square_pixels(squares, square) *
                                 samples_left(noise, target, squares->samples[square], most);
        }
    }
    squares->version += count != squares->active_count;
    squares->active_count = count;
}

void clast_squares_choose(clast_squares *squares, const uint8_t *goes_on)
{
    list_all(squares);
    uint32_t count = 0;
    for (uint32_t i = 0; i < squares->active_count; i++) {
        uint32_t square = squares->active[i];
        if (goes_on[square] != 0) {
            squares->active[count++] = square;
        }
    }
    squares->active_count = count;
    squares->version++;
}
