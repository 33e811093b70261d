// SPDX-License-Identifier: Apache-2.0
#include "geometry/cells.h"

#include <stdatomic.h>

#include "base/thread.h"

enum {
    CHUNK = 32768,  // triangles
    CELL_MOST = 24, // triangles of a cell
    CODE_BITS_MOST = 32,
    AXIS_BITS_MOST = 16, // two tables of 8 bits
    BUCKET_BITS = 11,    // the upper bits of a code, by which triangles are spread over buckets
    BUCKETS_MOST = 1 << BUCKET_BITS,
    DIGITS_MOST = 1 << 11,
    INSERTION_MOST = 24, // triangles of a bucket that is sorted by insertion
    CODE_DEPTH = CODE_BITS_MOST + 1,
};

// How a centre becomes a code. The bits of the axes are mixed so that cells are as round as they can be (Vinkler et al.
// 2017, "Extended Morton codes"): each bit halves the side that is longest.
typedef struct encoder {
    lanes origin, scale;
    int32_t most[3];             // the largest value of an axis
    uint32_t spread[3][2][256];  // for each axis, where the bits of its value's lower and upper byte go
    uint32_t bits, bucket_shift; // of a code; below those that choose a bucket
} encoder;

typedef struct cell_job {
    const clast_clusterize_desc *desc;
    cells *made;
    uint64_t *unsorted;
    lanes *centres; // for each worker, lower and upper, and marks of what is not tame
    atomic_bool out_of_range;
    encoder code;
    uint32_t *places; // [chunk][bucket]: how many triangles, then where they go
    uint32_t bucket_count;
    uint32_t *first;       // for each bucket, its first triangle, and the end
    uint32_t *first_cells; // for each bucket, how many cells, then its first
} cell_job;

// ----------------------------------------------------------------------------------------------------------- centres

static inline lanes centre_of(const cell_job *job, size_t triangle, bool tame)
{
    lanes_box box = steering_box(job->desc->positions, job->desc->indices + 3 * triangle, tame);
    return lanes_add(box.lower, box.upper);
}

// At first in the hope that all corners are tame; marks of what is not stand behind the centres' box.
static inline bool bound_range(cell_job *job, size_t begin, size_t end, bool tame, lanes centres[3])
{
    const clast_clusterize_desc *desc = job->desc;
    lanes lower = centres[0], upper = centres[1], wild = centres[2];
    for (size_t i = begin; i < end; i++) {
        const uint32_t *corner = desc->indices + 3 * i;
        if (corner[0] >= desc->position_count || corner[1] >= desc->position_count ||
            corner[2] >= desc->position_count) {
            return false;
        }
        lanes_box box = steering_box(desc->positions, corner, tame);
        lanes centre = lanes_add(box.lower, box.upper);
        lower = lanes_min(lower, centre);
        upper = lanes_max(upper, centre);
        for (int k = 0; k < 3 && tame; k++) { // not by the box: a minimum may lose what is no number
            wild = lanes_either(wild, lanes_wild(steering(desc->positions, corner[k], true), CUT_FAR));
        }
    }
    centres[0] = lower;
    centres[1] = upper;
    centres[2] = wild;
    return true;
}

static void bound_centres(void *data, size_t begin, size_t end, uint32_t worker)
{
    cell_job *job = data;
    lanes *centres = job->centres + 3 * (size_t)worker;
    if (!(job->made->tame ? bound_range(job, begin, end, true, centres)
                          : bound_range(job, begin, end, false, centres))) {
        atomic_store(&job->out_of_range, true);
    }
}

// The first of the triangles at fault, whatever thread came upon which.
static clast_status refuse_index(clast_context *context, const clast_clusterize_desc *desc)
{
    size_t i = 0;
    while (i + 1 < 3 * desc->triangle_count && desc->indices[i] < desc->position_count) {
        i++;
    }
    return clast_fail(context, CLAST_ERROR_INVALID_ARGUMENT,
                      "clusterize: triangle %zu has index %u, expected below %zu", i / 3, desc->indices[i],
                      desc->position_count);
}

static void clear_centres(clast_context *context, cell_job *job)
{
    for (uint32_t i = 0; i < clast_worker_count(context); i++) {
        job->centres[3 * i] = box_none_lower();
        job->centres[3 * i + 1] = box_none_upper();
        job->centres[3 * i + 2] = lanes_all(0.0f);
    }
}

static void join_centres(clast_context *context, cell_job *job)
{
    for (uint32_t i = 1; i < clast_worker_count(context); i++) {
        job->centres[0] = lanes_min(job->centres[0], job->centres[3 * i]);
        job->centres[1] = lanes_max(job->centres[1], job->centres[3 * i + 1]);
        job->centres[2] = lanes_either(job->centres[2], job->centres[3 * i + 2]);
    }
}

static clast_status bound_all(clast_context *context, cell_job *job)
{
    job->centres = clast_allocate(context, clast_worker_count(context), 3 * sizeof *job->centres);
    if (job->centres == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (int tame = 1; tame >= 0; tame--) {
        job->made->tame = tame != 0;
        clear_centres(context, job);
        clast_parallel_for(context, job->desc->triangle_count, CHUNK, bound_centres, job);
        if (atomic_load(&job->out_of_range)) {
            return refuse_index(context, job->desc);
        }
        join_centres(context, job);
        if (!lanes_any(job->centres[2])) {
            break;
        }
    }
    return CLAST_OK;
}

// ------------------------------------------------------------------------------------------------------------- codes

// Bits that leave a few triangles of a surface in each cell: n triangles of a sheet stand in sqrt(n) rows.
static uint32_t code_bits_for(size_t count)
{
    uint32_t bits = 0;
    while (count >> bits > 1) {
        bits++;
    }
    bits = bits + bits / 2;
    return bits < 8 ? 8 : bits > CODE_BITS_MOST ? CODE_BITS_MOST : bits;
}

static void fill_spread(encoder *code, uint32_t axis, uint32_t axis_bits, const uint8_t goes_to[AXIS_BITS_MOST])
{
    for (uint32_t value = 0; value < 512; value++) {
        uint32_t spread = 0, shift = value < 256 ? 0 : 8;
        for (uint32_t bit = 0; bit < 8 && shift + bit < axis_bits; bit++) {
            spread |= (value >> bit & 1) << goes_to[shift + bit];
        }
        code->spread[axis][value / 256][value % 256] = spread;
    }
}

static void make_encoder(encoder *code, lanes lower, lanes upper, size_t count)
{
    float sides[4], left[3], scale[4] = {0.0f, 0.0f, 0.0f, 0.0f};
    uint8_t order[CODE_BITS_MOST]; // the axis of each bit, the uppermost first
    uint32_t axis_bits[3] = {0, 0, 0}, wanted = code_bits_for(count);
    lanes_store(sides, lanes_subtract(upper, lower));
    memcpy(left, sides, sizeof left);
    code->bits = 0;
    while (code->bits < wanted) {
        uint32_t longest = left[1] > left[0] ? 1 : 0;
        longest = left[2] > left[longest] ? 2 : longest;
        if (!(left[longest] > CUT_FLAT)) {
            break;
        }
        order[code->bits++] = (uint8_t)longest;
        left[longest] = ++axis_bits[longest] < AXIS_BITS_MOST ? left[longest] * 0.5f : 0.0f;
    }
    for (uint32_t axis = 0; axis < 3; axis++) {
        uint8_t goes_to[AXIS_BITS_MOST];
        uint32_t found = axis_bits[axis];
        for (uint32_t bit = 0; bit < code->bits; bit++) {
            if (order[bit] == axis) {
                goes_to[--found] = (uint8_t)(code->bits - 1 - bit);
            }
        }
        fill_spread(code, axis, axis_bits[axis], goes_to);
        scale[axis] = axis_bits[axis] != 0 ? (float)(1u << axis_bits[axis]) / sides[axis] : 0.0f;
        code->most[axis] = (int32_t)(1u << axis_bits[axis]) - 1;
    }
    code->origin = lower;
    code->scale = lanes_load(scale);
    code->bucket_shift = code->bits > BUCKET_BITS ? code->bits - BUCKET_BITS : 0;
}

static inline uint32_t code_of(const encoder *code, lanes centre)
{
    int32_t at[4];
    lanes_truncate(at, lanes_multiply(lanes_subtract(centre, code->origin), code->scale));
    uint32_t result = 0;
    for (int axis = 0; axis < 3; axis++) {
        uint32_t value = (uint32_t)(at[axis] < code->most[axis] ? at[axis] : code->most[axis]);
        result |= code->spread[axis][0][value & 255] | code->spread[axis][1][value >> 8];
    }
    return result;
}

static void make_codes(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cell_job *job = data;
    uint32_t *places = job->places + begin / CHUNK * job->bucket_count;
    memset(places, 0, job->bucket_count * sizeof *places);
    bool tame = job->made->tame;
    for (size_t i = begin; i < end; i++) {
        uint32_t code = code_of(&job->code, centre_of(job, i, tame));
        job->unsorted[i] = (uint64_t)code << 32 | i;
        places[code >> job->code.bucket_shift]++;
    }
}

static void spread_codes(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cell_job *job = data;
    uint32_t *places = job->places + begin / CHUNK * job->bucket_count;
    uint32_t shift = 32 + job->code.bucket_shift;
    for (size_t i = begin; i < end; i++) {
        uint64_t entry = job->unsorted[i];
        job->made->order[places[entry >> shift]++] = entry;
    }
}

static void place_buckets(cell_job *job)
{
    size_t chunks = (job->desc->triangle_count + CHUNK - 1) / CHUNK;
    uint32_t sum = 0;
    for (uint32_t bucket = 0; bucket < job->bucket_count; bucket++) {
        job->first[bucket] = sum;
        for (size_t chunk = 0; chunk < chunks; chunk++) {
            uint32_t here = job->places[chunk * job->bucket_count + bucket];
            job->places[chunk * job->bucket_count + bucket] = sum;
            sum += here;
        }
    }
    job->first[job->bucket_count] = sum;
}

// Everything in one block of memory, which is large sooner: large blocks are cheaper to touch for the first time.
static clast_status make_room(clast_context *context, cell_job *job)
{
    size_t count = job->desc->triangle_count, chunks = (count + CHUNK - 1) / CHUNK;
    size_t words = 2 * count + (chunks * job->bucket_count + 2 * ((size_t)job->bucket_count + 1) + 1) / 2;
    uint64_t *memory = clast_allocate(context, words, sizeof *memory); // less than 2^35 words, so far
    if (memory == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    job->made->order = memory;
    job->made->spare = job->unsorted = memory + count;
    job->places = (uint32_t *)(void *)(memory + 2 * count);
    job->first = job->places + chunks * job->bucket_count;
    job->first_cells = job->first + job->bucket_count + 1;
    return CLAST_OK;
}

static clast_status spread_all(clast_context *context, cell_job *job)
{
    size_t count = job->desc->triangle_count;
    make_encoder(&job->code, job->centres[0], job->centres[1], count);
    job->bucket_count = 1u << (job->code.bits - job->code.bucket_shift);
    clast_status status = make_room(context, job);
    if (status != CLAST_OK) {
        return status;
    }
    clast_parallel_for(context, count, CHUNK, make_codes, job);
    place_buckets(job);
    clast_parallel_for(context, count, CHUNK, spread_codes, job);
    return CLAST_OK;
}

// ----------------------------------------------------------------------------------------------------------- sorting

static void sort_by_insertion(uint64_t *entries, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint64_t kept = entries[i];
        uint32_t place = i;
        for (; place > 0 && entries[place - 1] > kept; place--) {
            entries[place] = entries[place - 1];
        }
        entries[place] = kept;
    }
}

// One stable pass of radix sort by `bits` bits at `shift`.
static void sort_pass(const uint64_t *from, uint64_t *to, uint32_t count, uint32_t shift, uint32_t bits)
{
    uint32_t places[DIGITS_MOST], digits = 1u << bits;
    memset(places, 0, digits * sizeof places[0]);
    for (uint32_t i = 0; i < count; i++) {
        places[from[i] >> shift & (digits - 1)]++;
    }
    for (uint32_t digit = 0, sum = 0; digit < digits; digit++) {
        uint32_t here = places[digit];
        places[digit] = sum;
        sum += here;
    }
    for (uint32_t i = 0; i < count; i++) {
        to[places[from[i] >> shift & (digits - 1)]++] = from[i];
    }
}

static void sort_bucket(uint64_t *entries, uint64_t *other, uint32_t count, uint32_t bits)
{
    if (count <= INSERTION_MOST) {
        sort_by_insertion(entries, count); // triangles stand in order: the same as a stable sort by codes
    } else if (bits != 0) {
        sort_pass(entries, other, count, 32, bits / 2);
        sort_pass(other, entries, count, 32 + bits / 2, bits - bits / 2);
    }
}

// ------------------------------------------------------------------------------------------------------------- cells

// Writes where the cells of sorted entries begin, relative to them, and gives how many those are. A cell is all that
// begins with the same bits, where that is little enough. Where more triangles have one code, each becomes a cell of
// its own.
static uint32_t find_cells(const uint64_t *entries, uint32_t count, uint32_t *begins)
{
    uint32_t ends[CODE_DEPTH + 1], waiting = 0, begin = 0, found = 0;
    ends[waiting++] = count;
    while (waiting != 0) {
        uint32_t end = ends[waiting - 1];
        uint32_t differing = (uint32_t)((entries[begin] ^ entries[end - 1]) >> 32);
        if (end - begin <= CELL_MOST) {
            begins[found++] = begin;
            begin = end;
            waiting--;
        } else if (differing == 0) {
            for (; begin < end; begin++) {
                begins[found++] = begin;
            }
            waiting--;
        } else {
            uint64_t bit = (uint64_t)1 << (63 - __builtin_clz(differing));
            uint32_t low = begin, size = end - begin; // the first entry with that bit lies in (low, low + size)
            while (size > 1) {
                uint32_t half = size / 2;
                low = (entries[low + half] & bit) == 0 ? low + half : low;
                size -= half;
            }
            ends[waiting++] = low + 1;
        }
    }
    return found;
}

// Cells of a bucket, found: their beginnings stand where the unsorted triangles were.
static void sort_buckets(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cell_job *job = data;
    for (size_t bucket = begin; bucket < end; bucket++) {
        uint32_t first = job->first[bucket], count = job->first[bucket + 1] - first;
        uint64_t *entries = job->made->order + first, *other = job->unsorted + first;
        job->first_cells[bucket] = 0;
        if (count != 0) {
            sort_bucket(entries, other, count, job->code.bucket_shift);
            job->first_cells[bucket] = find_cells(entries, count, (uint32_t *)(void *)other);
        }
    }
}

// `end` is where the bucket ends.
static void bound_cell(const cell_job *job, uint32_t begin, uint32_t count, size_t end, cut_box *cell)
{
    bool tame = job->made->tame;
    const uint64_t *order = job->made->order;
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t i = begin; i < begin + count; i++) {
        cells_prefetch(job->desc, (uint32_t)order[i + CELLS_LATER < end ? i + CELLS_LATER : end - 1],
                       (uint32_t)order[i + CELLS_SOON < end ? i + CELLS_SOON : end - 1]);
        lanes_box box = steering_box(job->desc->positions, job->desc->indices + 3 * (size_t)(uint32_t)order[i], tame);
        lower = lanes_min(lower, box.lower);
        upper = lanes_max(upper, box.upper);
    }
    lanes_store(&cell->lower, lower);
    lanes_store(&cell->upper, upper);
    cell->lower.number = begin;
    cell->upper.number = count;
}

static void bound_cells(void *data, size_t begin, size_t end, uint32_t worker)
{
    cell_job *job = data;
    lanes *centres = job->centres + 3 * (size_t)worker;
    for (size_t bucket = begin; bucket < end; bucket++) {
        uint32_t first = job->first[bucket], last = job->first[bucket + 1];
        const uint32_t *begins = (const uint32_t *)(void *)(job->unsorted + first);
        uint32_t count = job->first_cells[bucket + 1] - job->first_cells[bucket];
        cut_box *boxes = job->made->boxes + job->first_cells[bucket];
        for (uint32_t i = 0; i < count; i++) {
            uint32_t from = first + begins[i], to = i + 1 < count ? first + begins[i + 1] : last;
            bound_cell(job, from, to - from, last, &boxes[i]);
            lanes centre = cut_centre(&boxes[i]);
            centres[0] = lanes_min(centres[0], centre);
            centres[1] = lanes_max(centres[1], centre);
        }
    }
}

static clast_status make_cells(clast_context *context, cell_job *job)
{
    enum { BUCKET_GRAIN = 8 };
    clast_parallel_for(context, job->bucket_count, BUCKET_GRAIN, sort_buckets, job);
    uint32_t sum = 0;
    for (uint32_t bucket = 0; bucket < job->bucket_count; bucket++) {
        uint32_t here = job->first_cells[bucket];
        job->first_cells[bucket] = sum;
        sum += here;
    }
    job->first_cells[job->bucket_count] = sum;
    job->made->count = sum;
    job->made->boxes = clast_allocate(context, sum, sizeof *job->made->boxes);
    if (job->made->boxes == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clear_centres(context, job);
    clast_parallel_for(context, job->bucket_count, BUCKET_GRAIN, bound_cells, job);
    join_centres(context, job);
    job->made->whole = (cut_range){0, sum, 0, (uint32_t)job->desc->triangle_count, job->centres[0], job->centres[1]};
    return CLAST_OK;
}

clast_status clast_cells_make(clast_context *context, const clast_clusterize_desc *desc, cells *made)
{
    *made = (cells){0};
    cell_job job = {.desc = desc, .made = made};
    clast_status status = bound_all(context, &job);
    status = status == CLAST_OK ? spread_all(context, &job) : status;
    status = status == CLAST_OK ? make_cells(context, &job) : status;
    clast_free(context, job.centres);
    return status;
}

void clast_cells_free(clast_context *context, cells *made)
{
    clast_free(context, made->boxes);
    clast_free(context, made->order); // and all that stands behind it
    *made = (cells){0};
}
