// SPDX-License-Identifier: Apache-2.0
// The binary tree: ranges of items are cut between bins, by the surface area heuristic (Wald, On fast Construction of SAH-based
// Bounding Volume Hierarchies, 2007), here in integers: an item's box is one vector of words, and all sums are exact.
#include <math.h>
#include <string.h>

#include "accel/tree_build.h"
#include "base/simd.h"
#include "base/thread.h"
#include "shared/dialect.h"
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

enum { MOST_BINS = 32, FEW_ITEMS = 32, FEW_BINS = 8, FETCH_AHEAD = 16 };

// ------------------------------------------------------------------------------------------------------------- vectors

static inline clast_words8 max_words(clast_words8 a, clast_words8 b)
{
#if defined(__SSE2__)
    return (clast_words8)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
    clast_words8 more = a > b;
    return (a & more) | (b & ~more);
#endif
}

static inline clast_words8 no_words(void)
{
    return (clast_words8){INT16_MIN, INT16_MIN, INT16_MIN, INT16_MIN, INT16_MIN, INT16_MIN, INT16_MIN, INT16_MIN};
}

#define SWAP_HALVES(v) __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3)

// Twice the centre: negated, then as it is.
static inline clast_words8 centre_of(clast_words8 item)
{
    typedef uint16_t sides8 __attribute__((vector_size(16))); // the fourth lanes are numbers, whose sums may wrap
    return (clast_words8)((sides8)item - (sides8)SWAP_HALVES(item));
}

// Half a box's surface in grid steps, sides counted one longer than they are: so that lines and points have some, too.
static inline uint32_t area_of(clast_words8 box)
{
    // Without signs: of an empty box's sides the sum wraps to none.
    typedef uint16_t sizes8 __attribute__((vector_size(16)));
    sizes8 sizes = (sizes8)box + (sizes8)SWAP_HALVES(box);
    uint64_t sides;
    memcpy(&sides, &sizes, sizeof sides);
    uint32_t x = (uint32_t)(sides & 0xffff) + 1, y = (uint32_t)(sides >> 16 & 0xffff) + 1,
             z = (uint32_t)(sides >> 32 & 0xffff) + 1;
    return x * (y + z) + y * z;
}

// --------------------------------------------------------------------------------------------------------------- items

static uint32_t number_of(const clast_build_item *item)
{
    return item->number_low | (uint32_t)item->number_high << 16;
}

static void quantise_item(const clast_tree_builder *b, clast_build_item *item, uint32_t number, const float base[3],
                          float scale)
{
    const clast_box *box = &b->boxes[number];
    bool empty = clast_box_is_empty(box);
    for (int axis = 0; axis < 3; axis++) {
        float lower = empty ? base[axis] : box->lower.v[axis], upper = empty ? base[axis] : box->upper.v[axis];
        item->minus_lower[axis] = (int16_t) - (int32_t)min1((lower - base[axis]) * scale, GRID_MOST);
        item->upper[axis] = (int16_t)min1((upper - base[axis]) * scale, GRID_MOST);
    }
    item->number_low = (uint16_t)number;
    item->number_high = (uint16_t)(number >> 16);
}

static void box_include(clast_box *to, const clast_box *box)
{
    for (int axis = 0; axis < 3; axis++) {
        to->lower.v[axis] = min1(to->lower.v[axis], box->lower.v[axis]);
        to->upper.v[axis] = max1(to->upper.v[axis], box->upper.v[axis]);
    }
}

static float longest_side(const clast_box *box)
{
    float size = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        size = max1(size, box->upper.v[axis] - box->lower.v[axis]);
    }
    return size;
}

static float scale_for(float extent)
{
    return extent > 1e-33f ? (float)GRID_MOST / extent : 0.0f;
}

static void bound_part(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_tree_builder *b = data;
    clast_box box = clast_box_empty();
    for (size_t i = begin; i < end; i++) {
        box_include(&box, &b->boxes[b->numbers != NULL ? b->numbers[i] : i]);
    }
    b->parts[begin / ITEM_GRAIN] = box;
}

static void fill_part(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_tree_builder *b = data;
    float scale = scale_for(b->extent);
    for (size_t i = begin; i < end; i++) {
        quantise_item(b, &b->order[i], b->numbers != NULL ? b->numbers[i] : (uint32_t)i, b->whole.lower.v, scale);
    }
}

static void fill_items(clast_tree_builder *b)
{
    clast_parallel_for(b->context, b->count, ITEM_GRAIN, bound_part, b);
    b->whole = clast_box_empty();
    for (uint32_t i = 0; i <= (b->count - 1) / ITEM_GRAIN; i++) {
        box_include(&b->whole, &b->parts[i]);
    }
    if (clast_box_is_empty(&b->whole)) {
        memset(&b->whole, 0, sizeof b->whole);
    }
    b->extent = longest_side(&b->whole);
    clast_parallel_for(b->context, b->count, ITEM_GRAIN, fill_part, b);
}

// A grid over a range alone, for ranges that cover few steps of the whole's.
static void refine_grid(const clast_tree_builder *b, clast_build_range *range)
{
    clast_box box = clast_box_empty();
    for (uint32_t i = range->begin; i < range->end; i++) {
        if (i + FETCH_AHEAD < range->end) {
            __builtin_prefetch(&b->boxes[number_of(&b->order[i + FETCH_AHEAD])]);
        }
        box_include(&box, &b->boxes[number_of(&b->order[i])]);
    }
    if (clast_box_is_empty(&box)) {
        return;
    }
    float extent = longest_side(&box), scale = scale_for(extent);
    for (uint32_t i = range->begin; i < range->end; i++) {
        quantise_item(b, &b->order[i], number_of(&b->order[i]), box.lower.v, scale);
    }
    float share = b->extent > 0.0f ? extent / b->extent : 0.0f;
    range->unit *= share * share;
}

// ---------------------------------------------------------------------------------------------------------------- cuts

typedef struct item_bins {
    clast_words8 boxes[3][MOST_BINS];
    uint32_t counts[3][MOST_BINS];
} item_bins;

// A centre's bin on each axis is (centre - base) * scale.
typedef struct bin_map {
    clast_ints4 base;
    clast_floats4 scale;
} bin_map;

// What a range covers.
typedef struct range_extent {
    clast_words8 box, centres;
} range_extent;

static range_extent extent_of(const clast_tree_builder *b, const clast_build_range *range)
{
    range_extent e = {no_words(), no_words()};
    for (uint32_t i = range->begin; i < range->end; i++) {
        clast_words8 item = b->order[i].lanes;
        e.box = max_words(e.box, item);
        e.centres = max_words(e.centres, centre_of(item));
    }
    return e;
}

#define UPPER_WORDS(v) __builtin_convertvector(__builtin_shufflevector(v, v, 4, 5, 6, 7), clast_ints4)

static inline clast_ints4 bins_of(const bin_map *map, clast_words8 centre)
{
    clast_floats4 place = __builtin_convertvector(UPPER_WORDS(centre) - map->base, clast_floats4);
    return __builtin_convertvector(place * map->scale, clast_ints4);
}

static bin_map make_map(clast_words8 centres, uint32_t bins)
{
    bin_map map = {{0, 0, 0, 0}, {0.0f, 0.0f, 0.0f, 0.0f}};
    for (int axis = 0; axis < 3; axis++) {
        int32_t size = centres[axis] + centres[4 + axis];
        map.base[axis] = -centres[axis];
        map.scale[axis] = size > 0 ? (float)bins * (1.0f - 0x1p-20f) / (float)size
                                   : 0.0f; // the last one's bin is there
    }
    return map;
}

static void fill_bins(const clast_tree_builder *b, const clast_build_range *range, const bin_map *map, uint32_t bins,
                      item_bins *filled)
{
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < bins; i++) {
            filled->boxes[axis][i] = no_words();
            filled->counts[axis][i] = 0;
        }
    }
    for (uint32_t i = range->begin; i < range->end; i++) {
        clast_words8 item = b->order[i].lanes, centre = centre_of(item);
        clast_ints4 places = bins_of(map, centre);
        for (int axis = 0; axis < 3; axis++) {
            uint32_t bin = (uint32_t)places[axis];
            filled->boxes[axis][bin] = max_words(filled->boxes[axis][bin], item);
            filled->counts[axis][bin]++;
        }
    }
}

// The cheapest cut between bins: axis, and the first bin on its right; 0 where there is none.
typedef struct bin_cut {
    uint64_t cost;
    int axis;
    uint32_t bin;
} bin_cut;

static void try_cuts(const item_bins *filled, uint32_t bins, int axis, bin_cut *best)
{
    uint64_t right_costs[MOST_BINS];
    clast_words8 box = no_words();
    uint32_t count = 0;
    for (uint32_t i = bins - 1; i > 0; i--) {
        box = max_words(box, filled->boxes[axis][i]);
        count += filled->counts[axis][i];
        right_costs[i] = (uint64_t)area_of(box) * count;
    }
    uint32_t right_count = count;
    box = no_words();
    count = 0;
    for (uint32_t i = 1; i < bins && right_count != 0; i++) {
        uint32_t here = filled->counts[axis][i - 1];
        box = max_words(box, filled->boxes[axis][i - 1]);
        count += here;
        if (here != 0) { // else the cut is that before
            uint64_t cost = (uint64_t)area_of(box) * count + right_costs[i];
            if (cost < best->cost) {
                *best = (bin_cut){cost, axis, i};
            }
        }
        right_count -= filled->counts[axis][i];
    }
}

// Brings the items on the left of a cut to the front, in order; gives where the right begins.
static uint32_t part_range(clast_tree_builder *b, const clast_build_range *range, const bin_map *map,
                           const bin_cut *cut)
{
    clast_build_item *order = b->order, *spare = b->spare + range->begin;
    uint32_t left = range->begin, right = 0;
    for (uint32_t i = range->begin; i < range->end; i++) {
        clast_build_item item = order[i];
        bool is_right = (uint32_t)bins_of(map, centre_of(item.lanes))[cut->axis] >= cut->bin;
        order[left] = item;
        spare[right] = item;
        left += !is_right;
        right += is_right;
    }
    memcpy(order + left, spare, right * sizeof *order);
    return left;
}

// Where to cut a range of two items or more. Halves where no cut between bins tells items apart, and far down, so that no
// input makes a deep tree.
static uint32_t cut_range(clast_tree_builder *b, const clast_build_range *range, clast_words8 centres)
{
    uint32_t count = range->end - range->begin, half = range->begin + count / 2;
    if (range->depth >= TREE_DEPTH_HEURISTIC || count == 2) {
        return half;
    }
    uint32_t bins = count <= FEW_ITEMS && b->bins > FEW_BINS ? b->bins / 2 : b->bins;
    bin_map map = make_map(centres, bins);
    item_bins filled;
    fill_bins(b, range, &map, bins, &filled);
    bin_cut best = {UINT64_MAX, 0, 0};
    for (int axis = 0; axis < 3; axis++) {
        try_cuts(&filled, bins, axis, &best);
    }
    return best.bin != 0 ? part_range(b, range, &map, &best) : half;
}

// -------------------------------------------------------------------------------------------------------------- ranges

static int32_t longest_steps(clast_words8 box)
{
    int32_t longest = 0;
    for (int axis = 0; axis < 3; axis++) {
        int32_t steps = box[axis] + box[4 + axis];
        longest = steps > longest ? steps : longest;
    }
    return longest;
}

// Makes a range's node. False where it is a leaf; else gives the halves, of which the right one's node is not told yet.
static bool split_range(clast_tree_builder *b, const clast_build_range *range, clast_build_range *left,
                        clast_build_range *right)
{
    range_extent e = extent_of(b, range);
    clast_binary_node *node = &b->nodes[range->node];
    *node = (clast_binary_node){(float)area_of(e.box) * range->unit, 0, range->begin, range->end - range->begin};
    if (node->count <= b->leaf_items) {
        return false;
    }
    uint32_t middle = cut_range(b, range, e.centres);
    *left = (clast_build_range){range->begin, middle, range->node + 1, range->depth + 1, 0, range->unit};
    *right = (clast_build_range){middle, range->end, 0, range->depth + 1, 0, range->unit};
    return true;
}

static void build_subtree(clast_tree_builder *b, clast_build_range *subtree)
{
    struct {
        clast_build_range range;
        uint32_t parent;
    } stack[TREE_DEPTH + 1];
    uint32_t waiting = 0, next = subtree->node + 1;
    if (longest_steps(extent_of(b, subtree).box) < b->least_steps) {
        refine_grid(b, subtree);
    }
    clast_build_range range = *subtree;
    for (;;) {
        clast_build_range left, right;
        if (split_range(b, &range, &left, &right)) {
            stack[waiting].parent = range.node;
            stack[waiting++].range = right;
            range = left;
        } else if (waiting > 0) {
            range = stack[--waiting].range;
            range.node = next;
            b->nodes[stack[waiting].parent].right = next;
        } else {
            break;
        }
        next++;
    }
    for (uint32_t i = next; i-- > subtree->node;) {
        clast_tree_costs(b, i);
    }
}

static void split_job(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_tree_builder *b = data;
    for (size_t i = begin; i < end; i++) {
        const clast_build_range *range = &b->ranges[i];
        clast_build_range *halves = &b->next_ranges[2 * i];
        if (range->end - range->begin > b->subtree_items && split_range(b, range, &halves[0], &halves[1])) {
            // The left half may take as many nodes as it could ever need.
            halves[1].node = range->node + 2 * (halves[0].end - halves[0].begin);
            b->nodes[range->node].right = halves[1].node;
        } else {
            halves[0] = *range;
            halves[1].begin = halves[1].end = 0;
        }
    }
}

// Splits all large ranges once, in parallel. False where none is large.
static bool split_ranges(clast_tree_builder *b)
{
    clast_parallel_for(b->context, b->range_count, 1, split_job, b);
    uint32_t count = 0, range_count = b->range_count;
    for (uint32_t i = 0; i < range_count; i++) {
        if (b->next_ranges[2 * i + 1].end != 0) {
            b->tops[b->top_count++] = b->ranges[i].node;
        }
    }
    for (uint32_t i = 0; i < 2 * range_count; i++) {
        if (b->next_ranges[i].end != 0) {
            b->ranges[count++] = b->next_ranges[i];
        }
    }
    b->range_count = count;
    return count != range_count;
}

void clast_tree_split_begin(clast_tree_builder *b)
{
    fill_items(b);
    b->ranges[0] = (clast_build_range){0, b->count, 0, 0, 0, 1.0f / ((float)GRID_MOST * (float)GRID_MOST)};
    b->range_count = 1;
    b->top_count = 0;
}

bool clast_tree_split_large(clast_tree_builder *b)
{
    return b->range_count <= MOST_SUBTREES / 2 && split_ranges(b);
}

typedef struct subtree_list {
    clast_tree_builder *b;
    uint32_t first;
} subtree_list;

static void subtree_job(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const subtree_list *list = data;
    for (size_t i = begin; i < end; i++) {
        build_subtree(list->b, &list->b->ranges[list->first + i]);
    }
}

void clast_tree_split_subtrees(clast_tree_builder *b, uint32_t first, uint32_t count)
{
    subtree_list list = {b, first};
    clast_parallel_for(b->context, count, 1, subtree_job, &list);
}

void clast_tree_split_end(clast_tree_builder *b)
{
    while (b->top_count > 0) {
        clast_tree_costs(b, b->tops[--b->top_count]);
    }
}

void clast_tree_split(clast_tree_builder *b)
{
    clast_tree_split_begin(b);
    while (clast_tree_split_large(b)) {
    }
    clast_tree_split_subtrees(b, 0, b->range_count);
    clast_tree_split_end(b);
}
