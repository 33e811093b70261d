// SPDX-License-Identifier: Apache-2.0
// What the heights of a map are at least and at most over a triangle of texture coordinates: the ranges of squares of texels
// that the triangle, and what filters draw in around it, may touch.
#include "base/thread.h"
#include "source/height_make.h"

// Squares of 2^FINEST texels a side are the smallest whose ranges are kept; below, texels themselves are looked at.
enum { FINEST = 2, ROW_GRAIN = 8, SPAN_MOST = 12 };

static uint32_t side_of(uint32_t texels, uint32_t level)
{
    uint32_t shift = level + FINEST;
    return shift < 31 ? (texels + (1u << shift) - 1) >> shift : 1;
}

size_t clast_height_lay_out_ranges(clast_height *height)
{
    const clast_height_map *map = &height->map;
    size_t count = 0;
    height->range_level_count = 0;
    for (bool more = true; more;) {
        uint32_t level = height->range_level_count++;
        uint32_t across = side_of(map->widths[0], level), down = side_of(map->heights[0], level);
        height->range_firsts[level] = (uint32_t)count;
        count += (size_t)across * down;
        more = across > 1 || down > 1;
    }
    return count;
}

static clast_height_range empty_range(void)
{
    return (clast_height_range){INFINITY, -INFINITY};
}

static void include(clast_height_range *range, clast_height_range other)
{
    range->lower = min1(range->lower, other.lower);
    range->upper = max1(range->upper, other.upper);
}

// ------------------------------------------------------------------------------------------------------------- making

typedef struct range_job {
    const clast_height *height;
    clast_height_range *ranges;
    uint32_t level;
} range_job;

static clast_height_range range_of_texels(const clast_height *height, uint32_t x, uint32_t y)
{
    const clast_height_map *map = &height->map;
    uint32_t right = min_uint(map->widths[0], x + (1u << FINEST)),
             bottom = min_uint(map->heights[0], y + (1u << FINEST));
    clast_height_range range = empty_range();
    for (uint32_t row = y; row < bottom; row++) {
        size_t place = clast_height_place(map, 0, x, row);
        for (uint32_t column = x; column < right; column++, place++) {
            float texel = clast_height_texel(height, place);
            include(&range, (clast_height_range){texel, texel});
        }
    }
    return range;
}

static clast_height_range range_of_four(const range_job *job, uint32_t x, uint32_t y)
{
    const clast_height *height = job->height;
    uint32_t finer = job->level - 1;
    uint32_t across = side_of(height->map.widths[0], finer), down = side_of(height->map.heights[0], finer);
    clast_height_range range = empty_range();
    for (uint32_t row = 2 * y; row < min_uint(down, 2 * y + 2); row++) {
        for (uint32_t column = 2 * x; column < min_uint(across, 2 * x + 2); column++) {
            include(&range, job->ranges[height->range_firsts[finer] + (size_t)row * across + column]);
        }
    }
    return range;
}

static void make_rows(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const range_job *job = data;
    const clast_height *height = job->height;
    uint32_t across = side_of(height->map.widths[0], job->level);
    for (size_t y = begin; y < end; y++) {
        for (uint32_t x = 0; x < across; x++) {
            job->ranges[height->range_firsts[job->level] + y * across + x] =
                job->level == 0 ? range_of_texels(height, x << FINEST, (uint32_t)y << FINEST)
                                : range_of_four(job, x, (uint32_t)y);
        }
    }
}

void clast_height_fill_ranges(clast_context *context, const clast_height *height, clast_height_range *ranges)
{
    range_job job = {height, ranges, 0};
    for (; job.level < height->range_level_count; job.level++) {
        clast_parallel_for(context, side_of(height->map.heights[0], job.level), ROW_GRAIN, make_rows, &job);
    }
}

// ------------------------------------------------------------------------------------------------------------- asking

// A stretch of an axis in texels of the first level, from `lower` to `upper`.
typedef struct stretch {
    double lower, upper;
} stretch;

// A triangle's footprint, in texels of the first level, and how far around it filters reach.
typedef struct footprint {
    double x[3], y[3];
    double reach_x, reach_y;
} footprint;

// A place draws in the texels whose centres are less than one of them away. Those of a further level were made of texels up to
// one of their own length beyond themselves, as boxes of odd sides overlap. Coordinates are rounded when they are blended and
// wrapped.
static double reach_of(uint32_t level, uint32_t size, uint32_t level_size, double largest)
{
    return (level == 0 ? 1.0 : 2.5 * size / level_size) + 0.01 + largest * 0x1p-20 * size;
}

// False where a coordinate is too large, or none, so that nothing is known.
static bool footprint_of(const clast_height *height, const vec2 corners[3], float level_most, footprint *f)
{
    const clast_height_map *map = &height->map;
    clast_height_levels levels = height_levels(*map, level_most);
    double largest_x = 0.0, largest_y = 0.0;
    for (int k = 0; k < 3; k++) {
        f->x[k] = (double)corners[k][0] * map->widths[0];
        f->y[k] = (double)corners[k][1] * map->heights[0];
        largest_x = fmax(largest_x, fabs((double)corners[k][0]));
        largest_y = fmax(largest_y, fabs((double)corners[k][1]));
        if (!(fabsf(corners[k][0]) < 16384.0f) || !(fabsf(corners[k][1]) < 16384.0f)) {
            return false;
        }
    }
    f->reach_x = reach_of(levels.coarser, map->widths[0], map->widths[levels.coarser], largest_x);
    f->reach_y = reach_of(levels.coarser, map->heights[0], map->heights[levels.coarser], largest_y);
    return true;
}

// What of the triangle lies between two rows, along x; without the reach. Empty (lower > upper) where nothing does.
static stretch part_between(const footprint *f, double top, double bottom)
{
    stretch part = {INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++) {
        double x0 = f->x[k], y0 = f->y[k], x1 = f->x[(k + 1) % 3], y1 = f->y[(k + 1) % 3];
        double run = y1 - y0, first = 0.0, last = 1.0;
        if (run != 0.0) {
            double a = (top - y0) / run, b = (bottom - y0) / run;
            first = fmax(0.0, fmin(a, b));
            last = fmin(1.0, fmax(a, b));
        } else if (y0 < top || y0 > bottom) {
            continue;
        }
        if (first <= last) {
            double from = x0 + (x1 - x0) * first, to = x0 + (x1 - x0) * last;
            part.lower = fmin(part.lower, fmin(from, to));
            part.upper = fmax(part.upper, fmax(from, to));
        }
    }
    return part;
}

// A stretch of texels by number, both included.
typedef struct texels {
    uint32_t first, last;
} texels;

// The texels of the image that a stretch of an axis reads, as at most two stretches of them.
static uint32_t fold(stretch along, uint32_t wrap, uint32_t size, texels parts[2])
{
    int64_t first = (int64_t)floor(along.lower), last = (int64_t)floor(along.upper), n = size;
    if (wrap == CLAST_WRAP_CLAMP) {
        int64_t end = n - 1;
        parts[0] = (texels){(uint32_t)(first < 0     ? 0
                                       : first > end ? end
                                                     : first),
                            (uint32_t)(last < 0     ? 0
                                       : last > end ? end
                                                    : last)};
        return 1;
    }
    if (last - first >= n - 1) {
        parts[0] = (texels){0, size - 1};
        return 1;
    }
    uint32_t count = 0;
    while (first <= last) {
        int64_t turn = first >= 0 ? first / n : -((n - 1 - first) / n); // rounded down
        int64_t end = turn * n + n - 1 < last ? turn * n + n - 1 : last;
        uint32_t from = (uint32_t)(first - turn * n), to = (uint32_t)(end - turn * n);
        bool mirrored = wrap == CLAST_WRAP_MIRROR && (turn & 1) != 0;
        parts[count++] = mirrored ? (texels){size - 1 - to, size - 1 - from} : (texels){from, to};
        first = end + 1;
    }
    return count;
}

// All squares of a level that hold any of a rectangle of texels; level < 0 are texels themselves.
static void include_squares(const clast_height *height, int level, texels columns, texels rows,
                            clast_height_range *range)
{
    if (level < 0) {
        for (uint32_t y = rows.first; y <= rows.last; y++) {
            size_t place = clast_height_place(&height->map, 0, columns.first, y);
            for (uint32_t x = columns.first; x <= columns.last; x++, place++) {
                float texel = clast_height_texel(height, place);
                include(range, (clast_height_range){texel, texel});
            }
        }
        return;
    }
    uint32_t shift = (uint32_t)level + FINEST, across = side_of(height->map.widths[0], (uint32_t)level);
    for (uint32_t y = rows.first >> shift; y <= rows.last >> shift; y++) {
        for (uint32_t x = columns.first >> shift; x <= columns.last >> shift; x++) {
            include(range, height->ranges[height->range_firsts[level] + (size_t)y * across + x]);
        }
    }
}

// The finest level of squares of which the footprint is at most SPAN_MOST long; -1 where texels do.
static int level_for(const clast_height *height, const footprint *f)
{
    double left = fmin(f->x[0], fmin(f->x[1], f->x[2])), right = fmax(f->x[0], fmax(f->x[1], f->x[2]));
    double top = fmin(f->y[0], fmin(f->y[1], f->y[2])), bottom = fmax(f->y[0], fmax(f->y[1], f->y[2]));
    double span = fmax(right - left + 2.0 * f->reach_x, bottom - top + 2.0 * f->reach_y);
    int level = -1;
    for (double most = SPAN_MOST; span > most && level + 1 < (int)height->range_level_count; level++) {
        most = ldexp(SPAN_MOST, level + 1 + FINEST);
    }
    return level;
}

static clast_height_range whole_range(const clast_height *height)
{
    return height->ranges[height->range_firsts[height->range_level_count - 1]];
}

clast_height_range clast_height_bounds(const clast_height *height, const vec2 corners[3], float level_most)
{
    const clast_height_map *map = &height->map;
    clast_height_range range = empty_range();
    footprint f;
    if (!footprint_of(height, corners, level_most, &f)) {
        range = whole_range(height);
    } else {
        int level = level_for(height, &f);
        double step = level < 0 ? 1.0 : ldexp(1.0, level + FINEST);
        double top = fmin(f.y[0], fmin(f.y[1], f.y[2])) - f.reach_y,
               bottom = fmax(f.y[0], fmax(f.y[1], f.y[2])) + f.reach_y;
        for (double y = floor(top / step) * step; y <= bottom; y += step) {
            stretch part = part_between(&f, y - f.reach_y, y + step + f.reach_y);
            if (part.lower > part.upper) {
                continue;
            }
            texels columns[2], rows[2];
            uint32_t across = fold((stretch){part.lower - f.reach_x, part.upper + f.reach_x}, map->wrap_u,
                                   map->widths[0], columns);
            uint32_t down = fold((stretch){y, y + step - 1.0}, map->wrap_v, map->heights[0], rows);
            for (uint32_t k = 0; k < across * down; k++) {
                include_squares(height, level, columns[k % across], rows[k / across], &range);
            }
        }
    }
    // filters round what they blend, three times over
    float slack = 1e-6f * max1(abs1(range.lower), abs1(range.upper));
    return (clast_height_range){(range.lower - slack) * map->unit, (range.upper + slack) * map->unit};
}
