// SPDX-License-Identifier: Apache-2.0
// The levels of a displacement map: the first is the image, each further one a box filter of the one before. Where a side is
// odd, three texels make one, by how much of each lies in it (Guthe and Heckbert, Non-power-of-two mipmapping, 2005): so no box
// reaches beyond the image, and the wrap modes show in the borders only.
#include <stdatomic.h>

#include "base/thread.h"
#include "source/height_make.h"

enum { ROW_GRAIN = 16 };

// ------------------------------------------------------------------------------------------------------------- layout

clast_status clast_height_lay_out(clast_context *context, const clast_image *image, const clast_texture *texture,
                                  clast_height *height)
{
    clast_height_map *map = &height->map;
    *map = (clast_height_map){.wrap_u = texture->wrap_u, .wrap_v = texture->wrap_v};
    map->is_float = image->type == CLAST_PIXEL_FLOAT;
    map->unit = map->is_float ? 1.0f : 1.0f / 65535.0f;
    uint64_t count = 0, width = image->width, rows = image->height;
    for (bool more = true; more && map->level_count < HEIGHT_LEVELS; map->level_count++) {
        uint32_t level = map->level_count;
        map->firsts[level] = (uint32_t)count;
        map->widths[level] = (uint32_t)width;
        map->heights[level] = (uint32_t)rows;
        uint64_t texels;
        // kernels count texels in 31 bits
        if (__builtin_mul_overflow(width + 2, rows + 2, &texels) || texels > INT32_MAX - count) {
            return clast_fail(context, CLAST_ERROR_LIMIT,
                              "a displacement map of %u x %u texels: with its levels it may have at most %d",
                              image->width, image->height, INT32_MAX);
        }
        count += texels;
        more = width > 1 || rows > 1;
        width = width > 1 ? width / 2 : 1;
        rows = rows > 1 ? rows / 2 : 1;
    }
    height->texel_count = (uint32_t)count;
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- texels

typedef struct level_job {
    const clast_image *image;
    const clast_height *height;
    void *texels;
    uint32_t level; // to be made
    atomic_ullong unsound;
} level_job;

// An image's row becomes the first level's.
static void copy_row(level_job *job, uint32_t y)
{
    const clast_image *image = job->image;
    size_t to = clast_height_place(&job->height->map, 0, 0, y);
    size_t from = (size_t)y * image->width * image->channels;
    unsigned long long unsound = 0;
    for (size_t x = 0; x < image->width; x++, from += image->channels) {
        if (image->type == CLAST_PIXEL_UNORM8) {
            ((uint16_t *)job->texels)[to + x] = (uint16_t)(((const uint8_t *)image->pixels)[from] * 257); // exact
        } else if (image->type == CLAST_PIXEL_UNORM16) {
            ((uint16_t *)job->texels)[to + x] = ((const uint16_t *)image->pixels)[from];
        } else {
            float value = ((const float *)image->pixels)[from];
            bool sound = is_finite1(value);
            ((float *)job->texels)[to + x] = sound ? unsigned_zero(value) : 0.0f;
            unsound += !sound;
        }
    }
    atomic_fetch_add_explicit(&job->unsound, unsound, memory_order_relaxed);
}

// The texels along one axis that make one of the next level, with their weights.
typedef struct tap {
    uint32_t first, count;
    uint32_t weights[3];
    uint32_t sum;
} tap;

static tap tap_of(uint32_t place, uint32_t size)
{
    if (size == 1) {
        return (tap){0, 1, {1, 0, 0}, 1};
    }
    if (size % 2 == 0) {
        return (tap){2 * place, 2, {1, 1, 0}, 2};
    }
    uint32_t half = size / 2;
    return (tap){2 * place, 3, {half - place, half, place + 1}, size};
}

static void mean_integer(const uint16_t *from, size_t pitch, tap x, tap y, uint16_t *to)
{
    uint64_t sum = 0, weight = (uint64_t)x.sum * y.sum; // sums stay below 2^48
    for (uint32_t k = 0; k < y.count; k++) {
        for (uint32_t i = 0; i < x.count; i++) {
            sum += (uint64_t)y.weights[k] * x.weights[i] * from[k * pitch + i];
        }
    }
    *to = (uint16_t)((2 * sum + weight) / (2 * weight));
}

static void mean_float(const float *from, size_t pitch, tap x, tap y, float *to)
{
    double sum = 0.0;
    for (uint32_t k = 0; k < y.count; k++) {
        for (uint32_t i = 0; i < x.count; i++) {
            sum += (double)y.weights[k] * x.weights[i] * (double)from[k * pitch + i];
        }
    }
    *to = (float)(sum / ((double)x.sum * y.sum));
}

// A row of a level, from the level before.
static void shrink_row(level_job *job, uint32_t y)
{
    const clast_height_map *map = &job->height->map;
    uint32_t before = job->level - 1, width = map->widths[before];
    size_t pitch = (size_t)width + 2;
    tap rows = tap_of(y, map->heights[before]);
    size_t to = clast_height_place(map, job->level, 0, y), from = clast_height_place(map, before, 0, rows.first);
    for (uint32_t x = 0; x < map->widths[job->level]; x++) {
        tap columns = tap_of(x, width);
        size_t first = from + columns.first;
        if (map->is_float) {
            mean_float((const float *)job->texels + first, pitch, columns, rows, (float *)job->texels + to + x);
        } else {
            mean_integer((const uint16_t *)job->texels + first, pitch, columns, rows, (uint16_t *)job->texels + to + x);
        }
    }
}

static void make_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    level_job *job = data;
    for (size_t y = begin; y < end; y++) {
        if (job->level == 0) {
            copy_row(job, (uint32_t)y);
        } else {
            shrink_row(job, (uint32_t)y);
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- borders

static void copy_texel(const level_job *job, size_t to, size_t from)
{
    if (job->height->map.is_float) {
        ((float *)job->texels)[to] = ((const float *)job->texels)[from];
    } else {
        ((uint16_t *)job->texels)[to] = ((const uint16_t *)job->texels)[from];
    }
}

// What lies just beyond an end is the other end where coordinates repeat; mirrored and clamped ones meet the end itself.
static void make_border(const level_job *job)
{
    const clast_height_map *map = &job->height->map;
    uint32_t level = job->level;
    int64_t width = map->widths[level], rows = map->heights[level];
    bool turns_u = map->wrap_u == CLAST_WRAP_REPEAT, turns_v = map->wrap_v == CLAST_WRAP_REPEAT;
    for (int64_t y = 0; y < rows; y++) {
        size_t begin = clast_height_place(map, level, 0, y), last = begin + (size_t)width - 1;
        copy_texel(job, begin - 1, turns_u ? last : begin);
        copy_texel(job, last + 1, turns_u ? begin : last);
    }
    for (int64_t x = -1; x <= width; x++) {
        copy_texel(job, clast_height_place(map, level, x, -1),
                   clast_height_place(map, level, x, turns_v ? rows - 1 : 0));
        copy_texel(job, clast_height_place(map, level, x, rows),
                   clast_height_place(map, level, x, turns_v ? 0 : rows - 1));
    }
}

uint64_t clast_height_fill_levels(clast_context *context, const clast_image *image, clast_height *height)
{
    level_job job = {.image = image, .height = height, .texels = (void *)height->texels};
    atomic_init(&job.unsound, 0);
    for (uint32_t level = 0; level < height->map.level_count; level++) {
        job.level = level;
        clast_parallel_for(context, height->map.heights[level], ROW_GRAIN, make_rows, &job);
        make_border(&job);
    }
    return atomic_load(&job.unsound);
}
