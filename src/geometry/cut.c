// SPDX-License-Identifier: Apache-2.0
// The upper part of the clusterizer: binned surface area heuristic (Wald 2007, "On fast construction of SAH-based bounding
// volume hierarchies"), over ranges that are parted in place. Every step gives the same order of boxes whatever the number
// of threads: chunks have a fixed size, and what is reduced over them (smallest, largest, count) is exact in any order.
#include "geometry/cut.h"

#include <math.h>
#include <stdatomic.h>

#include "base/thread.h"

enum { BINS = 16, PARALLEL_CHUNK = 8192 };

typedef struct cut_bins {
    lanes lower[3][BINS], upper[3][BINS];
    uint32_t count[3][BINS];
} cut_bins;

// How centres become bins.
typedef struct binning {
    lanes origin, scale;
    bool flat[3];
} binning;

typedef struct cut_plane {
    uint32_t axis; // 3 is none
    int32_t last;  // the last bin of the left side
} cut_plane;

float clast_cut_scale(lanes lower, lanes upper)
{
    float sides[4], longest = 0.0f;
    lanes_store(sides, lanes_subtract(upper, lower));
    for (int axis = 0; axis < 3; axis++) {
        longest = sides[axis] > longest ? sides[axis] : longest;
    }
    return longest > CUT_FLAT ? 1.0f / longest : 1.0f;
}

void clast_cut_measure(const cut_box *boxes, cut_range *range)
{
    range->centre_lower = box_none_lower();
    range->centre_upper = box_none_upper();
    for (uint32_t i = 0; i < range->count; i++) {
        lanes centre = cut_centre(&boxes[range->begin + i]);
        range->centre_lower = lanes_min(range->centre_lower, centre);
        range->centre_upper = lanes_max(range->centre_upper, centre);
    }
}

static binning binning_of(const cut_range *range)
{
    float scale[4] = {0.0f, 0.0f, 0.0f, 0.0f}, sides[4];
    binning result = {.origin = range->centre_lower};
    lanes_store(sides, lanes_subtract(range->centre_upper, range->centre_lower));
    for (int axis = 0; axis < 3; axis++) {
        result.flat[axis] = !(sides[axis] > CUT_FLAT);
        scale[axis] = result.flat[axis] ? 0.0f : (float)BINS * 0.99999f / sides[axis];
    }
    result.scale = lanes_load(scale);
    return result;
}

static inline void bins_of(const binning *binning, lanes centre, int32_t bins[4])
{
    lanes_truncate(bins, lanes_multiply(lanes_subtract(centre, binning->origin), binning->scale));
}

static void bins_clear(cut_bins *bins)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < BINS; i++) {
            bins->lower[axis][i] = box_none_lower();
            bins->upper[axis][i] = box_none_upper();
            bins->count[axis][i] = 0;
        }
    }
}

static void bins_fill(cut_bins *bins, const binning *binning, const cut_box *boxes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        lanes lower = lanes_three(boxes[i].lower), upper = lanes_three(boxes[i].upper);
        int32_t place[4];
        bins_of(binning, lanes_add(lower, upper), place);
        for (int axis = 0; axis < 3; axis++) {
            int32_t bin = place[axis];
            bins->lower[axis][bin] = lanes_min(bins->lower[axis][bin], lower);
            bins->upper[axis][bin] = lanes_max(bins->upper[axis][bin], upper);
            bins->count[axis][bin]++;
        }
    }
}

static void bins_join(cut_bins *bins, const cut_bins *more)
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < BINS; i++) {
            bins->lower[axis][i] = lanes_min(bins->lower[axis][i], more->lower[axis][i]);
            bins->upper[axis][i] = lanes_max(bins->upper[axis][i], more->upper[axis][i]);
            bins->count[axis][i] += more->count[axis][i];
        }
    }
}

static float clusters_of(uint32_t triangles, const cut_limits *limits)
{
    return (float)(triangles / limits->triangles + (triangles % limits->triangles != 0));
}

// The cheapest plane of one axis, if it is cheaper than *cost.
static void best_of_axis(const cut_bins *bins, int axis, float scale, const cut_limits *limits, float *cost, cut_plane *plane)
{
    float right[BINS];
    uint32_t right_count[BINS], count = 0;
    lanes factor = lanes_all(scale), lower = box_none_lower(), upper = box_none_upper();
    for (int i = BINS - 1; i > 0; i--) {
        lower = lanes_min(lower, bins->lower[axis][i]);
        upper = lanes_max(upper, bins->upper[axis][i]);
        count += bins->count[axis][i];
        right_count[i] = count;
        right[i] = count != 0 ? box_half_area(lanes_multiply(lower, factor), lanes_multiply(upper, factor)) : 0.0f;
    }
    lower = box_none_lower();
    upper = box_none_upper();
    count = 0;
    for (int i = 0; i + 1 < BINS; i++) {
        lower = lanes_min(lower, bins->lower[axis][i]);
        upper = lanes_max(upper, bins->upper[axis][i]);
        count += bins->count[axis][i];
        if (count == 0 || right_count[i + 1] == 0) {
            continue;
        }
        float left = box_half_area(lanes_multiply(lower, factor), lanes_multiply(upper, factor));
        float here = left * clusters_of(count, limits) + right[i + 1] * clusters_of(right_count[i + 1], limits);
        if (here < *cost) {
            *cost = here;
            *plane = (cut_plane){(uint32_t)axis, i};
        }
    }
}

static cut_plane best_plane(const cut_bins *bins, const binning *binning, const cut_limits *limits)
{
    cut_plane plane = {3, 0};
    float cost = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        if (binning->flat[axis]) {
            continue;
        }
        lanes lower = box_none_lower(), upper = box_none_upper();
        for (int i = 0; i < BINS; i++) {
            lower = lanes_min(lower, bins->lower[axis][i]);
            upper = lanes_max(upper, bins->upper[axis][i]);
        }
        best_of_axis(bins, axis, clast_cut_scale(lower, upper), limits, &cost, &plane);
    }
    return plane;
}

// Without a plane that tells the centres apart, any halves are as good.
static void halve(const cut_range *range, cut_pair *pair)
{
    uint32_t left = range->count / 2;
    pair->left = pair->right = *range;
    pair->left.count = left;
    pair->right.begin += left;
    pair->right.count -= left;
}

// ----------------------------------------------------------------------------------------------------------- parting

typedef struct centre_boxes {
    lanes lower[2], upper[2]; // of the left and the right side
} centre_boxes;

static void centres_clear(centre_boxes *centres)
{
    centres->lower[0] = centres->lower[1] = box_none_lower();
    centres->upper[0] = centres->upper[1] = box_none_upper();
}

static inline bool goes_left(const binning *binning, const cut_plane *plane, const cut_box *box, centre_boxes *centres)
{
    int32_t bins[4];
    lanes centre = cut_centre(box);
    bins_of(binning, centre, bins);
    bool left = bins[plane->axis] <= plane->last;
    centres->lower[!left] = lanes_min(centres->lower[!left], centre);
    centres->upper[!left] = lanes_max(centres->upper[!left], centre);
    return left;
}

// Brings the boxes of the left side to the front, as quicksort does, and gives how many those are.
static size_t part(cut_box *boxes, size_t count, const binning *binning, const cut_plane *plane, centre_boxes *centres)
{
    size_t left = 0, right = count;
    while (left < right) {
        if (goes_left(binning, plane, &boxes[left], centres)) {
            left++;
            continue;
        }
        bool found = false;
        while (!found && --right > left) {
            found = goes_left(binning, plane, &boxes[right], centres);
        }
        if (found) {
            cut_box kept = boxes[left];
            boxes[left] = boxes[right];
            boxes[right] = kept;
            left++;
        }
    }
    return left;
}

static void pair_from(const cut_range *range, size_t left, const centre_boxes *centres, cut_pair *pair)
{
    pair->left = (cut_range){range->begin, (uint32_t)left, centres->lower[0], centres->upper[0]};
    pair->right = (cut_range){range->begin + (uint32_t)left, range->count - (uint32_t)left, centres->lower[1], centres->upper[1]};
}

void clast_cut_in_two_alone(cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair)
{
    binning binning = binning_of(range);
    cut_bins bins;
    bins_clear(&bins);
    bins_fill(&bins, &binning, boxes + range->begin, range->count);
    cut_plane plane = best_plane(&bins, &binning, limits);
    if (plane.axis == 3) {
        halve(range, pair);
        return;
    }
    centre_boxes centres;
    centres_clear(&centres);
    size_t left = part(boxes + range->begin, range->count, &binning, &plane, &centres);
    pair_from(range, left, &centres, pair);
}

// ------------------------------------------------------------------------------------------------------- all threads

typedef struct cut_job {
    cut_box *boxes; // of the range
    size_t count;
    binning binning;
    cut_plane plane;
    cut_bins *bins;         // one for each worker
    centre_boxes *centres;  // one for each worker
    uint32_t *chunk_left;   // for each chunk, how many of its boxes go left
    size_t left;
} cut_job;

static void fill_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    cut_job *job = data;
    bins_fill(&job->bins[worker], &job->binning, job->boxes + begin, end - begin);
}

static void part_chunk(void *data, size_t begin, size_t end, uint32_t worker)
{
    cut_job *job = data;
    job->chunk_left[begin / PARALLEL_CHUNK] =
        (uint32_t)part(job->boxes + begin, end - begin, &job->binning, &job->plane, &job->centres[worker]);
}

// Finds boxes on the wrong side of job->left, chunk by chunk: those of the right side before it, or of the left side after.
typedef struct stray {
    const cut_job *job;
    bool left_side; // looks for boxes of the left side
    size_t chunk, begin, end;
} stray;

static void stray_chunk(stray *stray)
{
    const cut_job *job = stray->job;
    size_t first = stray->chunk * PARALLEL_CHUNK;
    size_t middle = first + job->chunk_left[stray->chunk];
    size_t last = first + PARALLEL_CHUNK < job->count ? first + PARALLEL_CHUNK : job->count;
    stray->begin = stray->left_side ? first : middle;
    stray->end = stray->left_side ? middle : last;
    if (stray->left_side && stray->begin < job->left) {
        stray->begin = job->left;
    }
    if (!stray->left_side && stray->end > job->left) {
        stray->end = job->left;
    }
}

static void stray_next(stray *stray)
{
    while (stray->begin >= stray->end && (stray->chunk + 1) * PARALLEL_CHUNK < stray->job->count) {
        stray->chunk++;
        stray_chunk(stray);
    }
}

// After all chunks have been parted: as many boxes stand too far left as stand too far right. Swaps them. One thread:
// it moves half of the boxes at most, and reads them in order.
static void swap_strays(const cut_job *job)
{
    stray right = {.job = job, .left_side = false};
    stray left = {.job = job, .left_side = true, .chunk = job->left / PARALLEL_CHUNK};
    if (job->left >= job->count) {
        return;
    }
    stray_chunk(&right);
    stray_chunk(&left);
    for (;;) {
        stray_next(&right);
        stray_next(&left);
        if (right.begin >= right.end || left.begin >= left.end) {
            return;
        }
        cut_box kept = job->boxes[right.begin];
        job->boxes[right.begin++] = job->boxes[left.begin];
        job->boxes[left.begin++] = kept;
    }
}

static void cut_on_all_threads(clast_context *context, cut_job *job, const cut_range *range, const cut_limits *limits, cut_pair *pair)
{
    uint32_t workers = clast_worker_count(context);
    for (uint32_t i = 0; i < workers; i++) {
        bins_clear(&job->bins[i]);
        centres_clear(&job->centres[i]);
    }
    clast_parallel_for(context, job->count, PARALLEL_CHUNK, fill_range, job);
    for (uint32_t i = 1; i < workers; i++) {
        bins_join(&job->bins[0], &job->bins[i]);
    }
    job->plane = best_plane(&job->bins[0], &job->binning, limits);
    if (job->plane.axis == 3) {
        halve(range, pair);
        return;
    }
    clast_parallel_for(context, job->count, PARALLEL_CHUNK, part_chunk, job);
    for (size_t chunk = 0; chunk * PARALLEL_CHUNK < job->count; chunk++) {
        job->left += job->chunk_left[chunk];
    }
    swap_strays(job);
    for (uint32_t i = 1; i < workers; i++) {
        for (int side = 0; side < 2; side++) {
            job->centres[0].lower[side] = lanes_min(job->centres[0].lower[side], job->centres[i].lower[side]);
            job->centres[0].upper[side] = lanes_max(job->centres[0].upper[side], job->centres[i].upper[side]);
        }
    }
    pair_from(range, job->left, &job->centres[0], pair);
}

clast_status clast_cut_in_two(clast_context *context, cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair)
{
    uint32_t workers = clast_worker_count(context);
    cut_job job = {
        .boxes = boxes + range->begin,
        .count = range->count,
        .binning = binning_of(range),
        .bins = clast_allocate(context, workers, sizeof *job.bins),
        .centres = clast_allocate(context, workers, sizeof *job.centres),
        .chunk_left = clast_allocate(context, range->count / PARALLEL_CHUNK + 1, sizeof *job.chunk_left),
    };
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (job.bins != NULL && job.centres != NULL && job.chunk_left != NULL) {
        cut_on_all_threads(context, &job, range, limits, pair);
        status = CLAST_OK;
    }
    clast_free(context, job.bins);
    clast_free(context, job.centres);
    clast_free(context, job.chunk_left);
    return status;
}
