// SPDX-License-Identifier: Apache-2.0
// The upper part of the clusterizer: binned surface area heuristic (Wald 2007, "On fast construction of SAH-based
// bounding volume hierarchies") along the longest axis of the centres, over ranges of cells that are parted in place.
// (All three axes were tried: the clusters were no better.) Every step gives the same order of boxes whatever the
// number of threads: chunks have a fixed size, and what is reduced over them (smallest, largest, count) is exact in any
// order.
#include "geometry/cut.h"

#include <math.h>

#include "base/thread.h"

enum { BINS = 32, PARALLEL_CHUNK = 8192 };

typedef struct cut_bins {
    lanes lower[BINS], upper[BINS];
    uint32_t count[BINS], triangles[BINS];
} cut_bins;

// How a centre becomes a bin, and which bins go left.
typedef struct cut_plane {
    uint32_t axis;
    float origin, scale; // a scale of 0 is a range that no axis tells apart
    int32_t last_left;
    uint32_t left_triangles;
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

static cut_plane plane_of(const cut_range *range)
{
    float lower[4], sides[4];
    lanes_store(lower, range->centre_lower);
    lanes_store(sides, lanes_subtract(range->centre_upper, range->centre_lower));
    cut_plane plane = {0};
    for (uint32_t axis = 1; axis < 3; axis++) {
        plane.axis = sides[axis] > sides[plane.axis] ? axis : plane.axis;
    }
    plane.origin = lower[plane.axis];
    // A little less than BINS, so that the last centre stays within them.
    plane.scale = sides[plane.axis] > CUT_FLAT ? (float)BINS * 0.9999f / sides[plane.axis] : 0.0f;
    return plane;
}

static inline int32_t bin_of(const cut_plane *plane, const cut_box *box)
{
    return (int32_t)((box->lower.v[plane->axis] + box->upper.v[plane->axis] - plane->origin) * plane->scale);
}

static void bins_clear(cut_bins *bins)
{
    for (int i = 0; i < BINS; i++) {
        bins->lower[i] = box_none_lower();
        bins->upper[i] = box_none_upper();
        bins->count[i] = 0;
        bins->triangles[i] = 0;
    }
}

static inline void bins_add(cut_bins *bins, const cut_plane *plane, const cut_box *box)
{
    int32_t bin = bin_of(plane, box);
    // What stands in the last lane comes along; it is taken off before any sum.
    bins->lower[bin] = lanes_min(lanes_four(&box->lower), bins->lower[bin]);
    bins->upper[bin] = lanes_max(lanes_four(&box->upper), bins->upper[bin]);
    bins->count[bin]++;
    bins->triangles[bin] += box->upper.number;
}

static void bins_join(cut_bins *bins, const cut_bins *more)
{
    for (int i = 0; i < BINS; i++) {
        bins->lower[i] = lanes_min(bins->lower[i], more->lower[i]);
        bins->upper[i] = lanes_max(bins->upper[i], more->upper[i]);
        bins->count[i] += more->count[i];
        bins->triangles[i] += more->triangles[i];
    }
}

// Neighbours in the array mostly share a bin: two sets of bins, for the two halves, so that one addition need not wait
// for the one before.
static void bins_fill(cut_bins *bins, const cut_plane *plane, const cut_box *boxes, size_t count)
{
    cut_bins second;
    bins_clear(&second);
    size_t half = count / 2;
    for (size_t i = 0; i < half; i++) {
        bins_add(bins, plane, &boxes[i]);
        bins_add(&second, plane, &boxes[half + i]);
    }
    if (count % 2 != 0) {
        bins_add(bins, plane, &boxes[count - 1]);
    }
    bins_join(bins, &second);
}

static float clusters_of(uint32_t triangles, const cut_limits *limits)
{
    return (float)(triangles / limits->triangles + (triangles % limits->triangles != 0));
}

// Finds the cheapest place between two bins. The first and the last bin hold boxes, so there is one.
static void choose_plane(const cut_bins *bins, const cut_limits *limits, cut_plane *plane)
{
    float right[BINS], cost = INFINITY;
    uint32_t right_count[BINS], count = 0;
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (int i = 0; i < BINS; i++) {
        lower = lanes_min(lower, lanes_three(&bins->lower[i]));
        upper = lanes_max(upper, lanes_three(&bins->upper[i]));
    }
    lanes factor = lanes_all(clast_cut_scale(lower, upper));
    lower = box_none_lower();
    upper = box_none_upper();
    for (int i = BINS - 1; i > 0; i--) {
        lower = lanes_min(lower, lanes_three(&bins->lower[i]));
        upper = lanes_max(upper, lanes_three(&bins->upper[i]));
        count += bins->triangles[i];
        right_count[i] = count;
        right[i] = box_half_area(lanes_multiply(lower, factor), lanes_multiply(upper, factor));
    }
    lower = box_none_lower();
    upper = box_none_upper();
    count = 0;
    plane->last_left = 0;
    plane->left_triangles = bins->triangles[0];
    for (int i = 0; i + 1 < BINS; i++) {
        lower = lanes_min(lower, lanes_three(&bins->lower[i]));
        upper = lanes_max(upper, lanes_three(&bins->upper[i]));
        count += bins->triangles[i];
        float left = box_half_area(lanes_multiply(lower, factor), lanes_multiply(upper, factor));
        float here = left * clusters_of(count, limits) + right[i + 1] * clusters_of(right_count[i + 1], limits);
        if (here < cost) {
            cost = here;
            plane->last_left = i;
            plane->left_triangles = count;
        }
    }
}

void clast_cut_halve(const cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair)
{
    // Those of full clusters are best, where each cell is a triangle.
    uint32_t left = range->count / 2 / limits->triangles * limits->triangles, triangles = 0;
    left = left != 0 ? left : range->count / 2;
    for (uint32_t i = range->begin; i < range->begin + left; i++) {
        triangles += boxes[i].upper.number;
    }
    pair->left = pair->right = *range;
    pair->left.count = left;
    pair->left.triangles = triangles;
    pair->right.begin += left;
    pair->right.count -= left;
    pair->right.first += triangles;
    pair->right.triangles -= triangles;
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

static inline bool goes_left(const cut_plane *plane, const cut_box *box)
{
    return bin_of(plane, box) <= plane->last_left;
}

static inline void centres_add(centre_boxes *centres, int side, const cut_box *box)
{
    lanes centre = cut_centre(box);
    centres->lower[side] = lanes_min(centres->lower[side], centre);
    centres->upper[side] = lanes_max(centres->upper[side], centre);
}

// Brings the boxes of the left side to the front, as quicksort does, and gives how many those are.
static size_t part(cut_box *boxes, size_t count, const cut_plane *plane, centre_boxes *centres)
{
    centre_boxes own = *centres;
    size_t left = 0, right = count;
    for (;;) {
        while (left < right && goes_left(plane, &boxes[left])) {
            centres_add(&own, 0, &boxes[left++]);
        }
        while (left < right && !goes_left(plane, &boxes[right - 1])) {
            centres_add(&own, 1, &boxes[--right]);
        }
        if (left >= right) {
            break;
        }
        cut_box kept = boxes[left];
        boxes[left] = boxes[right - 1];
        boxes[right - 1] = kept;
    }
    *centres = own;
    return left;
}

static void pair_from(const cut_range *range, size_t left, uint32_t triangles, const centre_boxes *centres,
                      cut_pair *pair)
{
    pair->left = (cut_range){range->begin, (uint32_t)left,    range->first,
                             triangles,    centres->lower[0], centres->upper[0]};
    pair->right = (cut_range){range->begin + (uint32_t)left,
                              range->count - (uint32_t)left,
                              range->first + triangles,
                              range->triangles - triangles,
                              centres->lower[1],
                              centres->upper[1]};
}

void clast_cut_in_two_alone(cut_box *boxes, const cut_range *range, const cut_limits *limits, cut_pair *pair)
{
    cut_plane plane = plane_of(range);
    if (plane.scale == 0.0f) {
        clast_cut_halve(boxes, range, limits, pair);
        return;
    }
    cut_bins bins;
    bins_clear(&bins);
    bins_fill(&bins, &plane, boxes + range->begin, range->count);
    choose_plane(&bins, limits, &plane);
    centre_boxes centres;
    centres_clear(&centres);
    size_t left = part(boxes + range->begin, range->count, &plane, &centres);
    pair_from(range, left, plane.left_triangles, &centres, pair);
}

// ------------------------------------------------------------------------------------------------------- all threads

// A chunk is parted by one thread. Then its strays are those boxes of the right side that stand before the place where
// the left side of the whole range ends, or those of the left side that stand after it.
typedef struct cut_chunk {
    uint32_t left;
    uint32_t right_strays_before, left_strays_before; // in the chunks before
} cut_chunk;

typedef struct cut_job {
    cut_box *boxes; // of the range
    size_t count;
    cut_plane plane;
    cut_bins *bins;        // one for each worker
    centre_boxes *centres; // one for each worker
    cut_chunk *chunks;
    size_t chunk_count;
    size_t left;
} cut_job;

static void fill_chunk(void *data, size_t begin, size_t end, uint32_t worker)
{
    cut_job *job = data;
    bins_fill(&job->bins[worker], &job->plane, job->boxes + begin, end - begin);
}

static void part_chunk(void *data, size_t begin, size_t end, uint32_t worker)
{
    cut_job *job = data;
    job->chunks[begin / PARALLEL_CHUNK].left = (uint32_t)part(job->boxes + begin, end - begin, &job->plane,
                                                              &job->centres[worker]);
}

typedef struct span {
    size_t begin, end;
} span;

static span right_strays(const cut_job *job, size_t chunk)
{
    size_t begin = chunk * PARALLEL_CHUNK + job->chunks[chunk].left, end = (chunk + 1) * PARALLEL_CHUNK;
    end = end < job->left ? end : job->left;
    return (span){begin, begin < end ? end : begin};
}

static span left_strays(const cut_job *job, size_t chunk)
{
    size_t begin = chunk * PARALLEL_CHUNK, end = begin + job->chunks[chunk].left;
    begin = begin > job->left ? begin : job->left;
    return (span){begin, begin < end ? end : begin};
}

static void count_strays(cut_job *job)
{
    for (size_t i = 0; i < job->chunk_count; i++) {
        job->left += job->chunks[i].left;
    }
    uint32_t right = 0, left = 0;
    for (size_t i = 0; i < job->chunk_count; i++) {
        job->chunks[i].right_strays_before = right;
        job->chunks[i].left_strays_before = left;
        span of_right = right_strays(job, i), of_left = left_strays(job, i);
        right += (uint32_t)(of_right.end - of_right.begin);
        left += (uint32_t)(of_left.end - of_left.begin);
    }
}

// The chunk that holds the left side's stray of this number.
static size_t find_left_stray(const cut_job *job, uint32_t number)
{
    size_t low = 0, high = job->chunk_count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (job->chunks[middle].left_strays_before <= number) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// There are as many strays of each kind: those of the same number change places.
static void swap_strays(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)end;
    (void)worker;
    const cut_job *job = data;
    size_t chunk = begin / PARALLEL_CHUNK;
    span right = right_strays(job, chunk);
    if (right.begin == right.end) {
        return;
    }
    uint32_t number = job->chunks[chunk].right_strays_before;
    size_t other = find_left_stray(job, number);
    span left = left_strays(job, other);
    left.begin += number - job->chunks[other].left_strays_before;
    while (right.begin < right.end) {
        while (left.begin >= left.end) {
            left = left_strays(job, ++other);
        }
        cut_box kept = job->boxes[right.begin];
        job->boxes[right.begin++] = job->boxes[left.begin];
        job->boxes[left.begin++] = kept;
    }
}

static void cut_on_all_threads(clast_context *context, cut_job *job, const cut_range *range, const cut_limits *limits,
                               cut_pair *pair)
{
    uint32_t workers = clast_worker_count(context);
    for (uint32_t i = 0; i < workers; i++) {
        bins_clear(&job->bins[i]);
        centres_clear(&job->centres[i]);
    }
    clast_parallel_for(context, job->count, PARALLEL_CHUNK, fill_chunk, job);
    for (uint32_t i = 1; i < workers; i++) {
        bins_join(&job->bins[0], &job->bins[i]);
    }
    choose_plane(&job->bins[0], limits, &job->plane);
    clast_parallel_for(context, job->count, PARALLEL_CHUNK, part_chunk, job);
    count_strays(job);
    clast_parallel_for(context, job->count, PARALLEL_CHUNK, swap_strays, job);
    for (uint32_t i = 1; i < workers; i++) {
        for (int side = 0; side < 2; side++) {
            job->centres[0].lower[side] = lanes_min(job->centres[0].lower[side], job->centres[i].lower[side]);
            job->centres[0].upper[side] = lanes_max(job->centres[0].upper[side], job->centres[i].upper[side]);
        }
    }
    pair_from(range, job->left, job->plane.left_triangles, &job->centres[0], pair);
}

clast_status clast_cut_in_two(clast_context *context, cut_box *boxes, const cut_range *range, const cut_limits *limits,
                              cut_pair *pair)
{
    cut_plane plane = plane_of(range);
    if (plane.scale == 0.0f) {
        clast_cut_halve(boxes, range, limits, pair);
        return CLAST_OK;
    }
    uint32_t workers = clast_worker_count(context);
    size_t chunk_count = ((size_t)range->count + PARALLEL_CHUNK - 1) / PARALLEL_CHUNK;
    cut_job job = {
        .boxes = boxes + range->begin,
        .count = range->count,
        .plane = plane,
        .bins = clast_allocate(context, workers, sizeof *job.bins),
        .centres = clast_allocate(context, workers, sizeof *job.centres),
        .chunks = clast_allocate(context, chunk_count, sizeof *job.chunks),
        .chunk_count = chunk_count,
    };
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    if (job.bins != NULL && job.centres != NULL && job.chunks != NULL) {
        cut_on_all_threads(context, &job, range, limits, pair);
        status = CLAST_OK;
    }
    clast_free(context, job.bins);
    clast_free(context, job.centres);
    clast_free(context, job.chunks);
    return status;
}
