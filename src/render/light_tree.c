// SPDX-License-Identifier: Apache-2.0
// Builds the tree over lights, from the top down. Ranges of lights are split where that costs the least by the surface area
// orientation heuristic (Conty Estevez and Kulla 2018): a side's power, times the square of its size, times how widely its lights
// shine. Large ranges are looked at on all threads in chunks of a fixed size, small ones are a task each, so that nothing depends
// on the number of threads.
#include "render/light_tree.h"

#include "base/thread.h"
#include "render/light_bounds.h"

// Where there are few lights, all are weighed; of many, the same time is better spent on turns.
enum { LEAF_LIGHTS = 4 };

enum { BINS = 16, TASK_LIGHTS = 4096, CHUNK_LIGHTS = 4096, STACK_MOST = 2 * LIGHT_TREE_LEVELS + 2 };

// The lights of [begin, end), and where their node's split is to be told: splits[parent][side].
typedef struct range {
    uint32_t begin, end, parent, side, level;
} range;

typedef struct build {
    clast_context *context;
    const clast_light_sources *sources;
    float scale;
    clast_light_item *items;
    uint32_t count;
    uint32_t (*splits)
        [2]; // by the place of a split: those of its two sides. Splits of different nodes are in different places
    range *tasks;
    size_t task_count, task_capacity;
} build;

// ------------------------------------------------------------------------------------------------------------- binning

typedef struct bin {
    clast_light_box box;
    vec3 axis; // sum of directions by power, all on one side where they have two
    float power;
    uint32_t count;
} bin;

typedef struct binning {
    const build *build;
    range of;
    vec3 low, step; // bin = (centre - low) * step
    vec3 side;      // which of its two directions counts
    bin (*bins)[3][BINS];
} binning;

static vec3 item_centre(const clast_light_item *item)
{
    return (load3(item->box.lower) + load3(item->box.upper)) * 0.5f;
}

static uint32_t bin_of(const binning *b, vec3 centre, int axis)
{
    return to_uint(clamp1((centre[axis] - b->low[axis]) * b->step[axis], 0.0f, (float)(BINS - 1)));
}

static void add_box(clast_light_box *box, const clast_light_box *other)
{
    box->lower = store3(min3(load3(box->lower), load3(other->lower)));
    box->upper = store3(max3(load3(box->upper), load3(other->upper)));
}

static void clear_bins(bin bins[3][BINS])
{
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < BINS; i++) {
            bins[axis][i] = (bin){.box = clast_light_no_box(), .axis = splat3(0.0f)};
        }
    }
}

static void add_item(const binning *b, const clast_light_item *item, bin bins[3][BINS])
{
    vec3 direction = load3(item->axis);
    direction = item->two_sided && dot3(direction, b->side) < 0.0f ? direction * -1.0f : direction;
    vec3 centre = item_centre(item);
    for (int axis = 0; axis < 3; axis++) {
        bin *into = &bins[axis][bin_of(b, centre, axis)];
        add_box(&into->box, &item->box);
        into->axis = into->axis + direction * item->power;
        into->power += item->power;
        into->count++;
    }
}

static void add_bin(bin *to, const bin *from)
{
    add_box(&to->box, &from->box);
    to->axis = to->axis + from->axis;
    to->power += from->power;
    to->count += from->count;
}

static void bin_chunks(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const binning *b = data;
    for (size_t chunk = begin; chunk < end; chunk++) {
        uint32_t first = b->of.begin + (uint32_t)chunk * CHUNK_LIGHTS,
                 last = b->of.end - first > CHUNK_LIGHTS ? first + CHUNK_LIGHTS : b->of.end;
        clear_bins(b->bins[chunk]);
        for (uint32_t i = first; i < last; i++) {
            add_item(b, &b->build->items[i], b->bins[chunk]);
        }
    }
}

// How widely lights shine that are this much alike: from a half to a whole sphere.
static float spread_of(const bin *side)
{
    float length = side->power > 0.0f ? min1(length3(side->axis) / side->power, 1.0f) : 0.0f;
    return 2.0f - length;
}

static float cost_of(const bin *side)
{
    vec3 size = load3(side->box.upper) - load3(side->box.lower);
    return side->power * spread_of(side) * dot3(size, size);
}

typedef struct split {
    int axis; // -1: there is none
    uint32_t bin;
    float cost;
} split;

static void look_along(const bin bins[BINS], int axis, float stretch, split *best)
{
    float after[BINS];
    bin sum = {.box = clast_light_no_box(), .axis = splat3(0.0f)};
    for (uint32_t i = BINS; i-- > 1;) {
        add_bin(&sum, &bins[i]);
        after[i] = sum.count != 0 ? cost_of(&sum) : -1.0f;
    }
    sum = (bin){.box = clast_light_no_box(), .axis = splat3(0.0f)};
    for (uint32_t i = 1; i < BINS; i++) {
        add_bin(&sum, &bins[i - 1]);
        float cost = sum.count != 0 && after[i] >= 0.0f ? (cost_of(&sum) + after[i]) * stretch : INFINITY;
        if (cost < best->cost) {
            *best = (split){axis, i, cost};
        }
    }
}

static split best_split(const bin bins[3][BINS], vec3 size)
{
    split best = {-1, 0, INFINITY};
    for (int axis = 0; axis < 3; axis++) {
        if (size[axis] > 0.0f) {
            // Slices of what is long the other way stay long.
            look_along(bins[axis], axis, min1(largest3(size) / size[axis], 1e6f), &best);
        }
    }
    return best;
}

// ---------------------------------------------------------------------------------------------------------- splitting

static void swap_items(clast_light_item *a, clast_light_item *b)
{
    clast_light_item kept = *a;
    *a = *b;
    *b = kept;
}

// Brings those of the lower bins to the front; gives where the others begin.
static uint32_t part_items(const binning *b, split at)
{
    clast_light_item *items = b->build->items;
    uint32_t low = b->of.begin, high = b->of.end;
    while (low < high) {
        if (bin_of(b, item_centre(&items[low]), at.axis) < at.bin) {
            low++;
        } else {
            swap_items(&items[low], &items[--high]);
        }
    }
    return low;
}

static void bound_centres(const build *build, range of, vec3 *low, vec3 *high)
{
    *low = splat3(INFINITY);
    *high = splat3(-INFINITY);
    for (uint32_t i = of.begin; i < of.end; i++) {
        vec3 centre = item_centre(&build->items[i]);
        *low = min3(*low, centre);
        *high = max3(*high, centre);
    }
}

// Whether a range has so many lights that, from its level on, each turn must halve them.
static bool must_halve(range of)
{
    uint32_t turns = LIGHT_TREE_LEVELS - of.level; // one is taken now
    uint64_t most = turns >= 29 ? UINT64_MAX : (uint64_t)LEAF_LIGHTS << (turns - 1);
    return (uint64_t)(of.end - of.begin) > most / 2;
}

// Where a range is split: between its ends. Of lights that lie at one place, halves are as good as any.
static uint32_t split_range(const build *build, range of, bin (*bins)[3][BINS])
{
    vec3 high;
    binning b = {.build = build, .of = of, .side = load3(build->items[of.begin].axis), .bins = bins};
    bound_centres(build, of, &b.low, &high);
    vec3 size = high - b.low;
    uint32_t half = of.begin + (of.end - of.begin) / 2;
    if (must_halve(of) || !(largest3(size) > 0.0f)) {
        return half;
    }
    for (int axis = 0; axis < 3; axis++) {
        b.step[axis] = size[axis] > 0.0f ? min1((float)BINS / size[axis], 3e38f) : 0.0f;
    }
    size_t chunks = ((size_t)(of.end - of.begin) + CHUNK_LIGHTS - 1) / CHUNK_LIGHTS;
    if (chunks > 1) {
        clast_parallel_for(build->context, chunks, 1, bin_chunks, &b);
    } else {
        bin_chunks(&b, 0, 1, 0);
    }
    for (size_t chunk = 1; chunk < chunks; chunk++) {
        for (int axis = 0; axis < 3; axis++) {
            for (int i = 0; i < BINS; i++) {
                add_bin(&bins[0][axis][i], &bins[chunk][axis][i]);
            }
        }
    }
    split at = best_split((const bin(*)[BINS])bins[0], size);
    uint32_t place = at.axis >= 0 ? part_items(&b, at) : half;
    return place > of.begin && place < of.end ? place : half;
}

static bool is_leaf(range of)
{
    return of.end - of.begin <= (of.level == 0 ? LIGHT_LEAF_MOST : LEAF_LIGHTS);
}

// Splits a range and puts its two sides on the stack.
static uint32_t split_onto(const build *build, range of, bin (*bins)[3][BINS], range *stack, uint32_t depth)
{
    uint32_t place = split_range(build, of, bins);
    build->splits[of.parent][of.side] = place;
    stack[depth] = (range){place, of.end, place, 1, of.level + 1};
    stack[depth + 1] = (range){of.begin, place, place, 0, of.level + 1};
    return depth + 2;
}

static void split_tasks(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const build *build = data;
    bin bins[1][3][BINS];
    for (size_t task = begin; task < end; task++) {
        range stack[STACK_MOST];
        stack[0] = build->tasks[task];
        uint32_t depth = 1;
        while (depth != 0) {
            range of = stack[--depth];
            if (!is_leaf(of)) {
                depth = split_onto(build, of, bins, stack, depth);
            }
        }
    }
}

// Large ranges are split one after the other, until they are small enough to be tasks.
static clast_status split_all(build *build)
{
    size_t chunks = ((size_t)build->count + CHUNK_LIGHTS - 1) / CHUNK_LIGHTS;
    bin(*bins)[3][BINS] = clast_allocate(build->context, chunks, sizeof *bins);
    if (bins == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_status status = CLAST_OK;
    range stack[STACK_MOST];
    stack[0] = (range){.end = build->count};
    uint32_t depth = 1;
    while (depth != 0 && status == CLAST_OK) {
        range of = stack[--depth];
        if (of.end - of.begin > TASK_LIGHTS) {
            depth = split_onto(build, of, bins, stack, depth);
            continue;
        }
        status = CLAST_RESERVE(build->context, build->tasks, build->task_capacity, build->task_count + 1);
        if (status == CLAST_OK) {
            build->tasks[build->task_count++] = of;
        }
    }
    clast_free(build->context, bins);
    if (status == CLAST_OK) {
        clast_parallel_for(build->context, build->task_count, 1, split_tasks, build);
    }
    return status;
}

// --------------------------------------------------------------------------------------------------------------- nodes

// A node on its way: what is around it, and its lights or its children.
typedef struct wide_node {
    clast_light_cover cover;
    uint32_t first, count; // count 0: children
} wide_node;

typedef struct placed_range {
    range of;
    uint32_t node, trail;
} placed_range;

static void place_leaf(const build *build, clast_light_tree *tree, range of, uint32_t trail)
{
    for (uint32_t i = of.begin; i < of.end; i++) {
        tree->trails[build->items[i].number] = trail;
        tree->places[build->items[i].number] = i;
    }
}

// Numbers nodes in the order of their parents, and tells lights where they are.
static uint32_t place_nodes(const build *build, clast_light_tree *tree, wide_node *nodes)
{
    placed_range stack[STACK_MOST];
    stack[0] = (placed_range){.of = {.end = build->count}};
    uint32_t depth = 1, node_count = 1;
    while (depth != 0) {
        placed_range at = stack[--depth];
        range of = at.of;
        if (is_leaf(of)) {
            nodes[at.node].first = of.begin;
            nodes[at.node].count = of.end - of.begin;
            place_leaf(build, tree, of, at.trail);
            continue;
        }
        uint32_t place = build->splits[of.parent][of.side];
        nodes[at.node].first = node_count;
        nodes[at.node].count = 0;
        stack[depth++] = (placed_range){
            {place, of.end, place, 1, of.level + 1}, node_count + 1, at.trail | 1u << of.level};
        stack[depth++] = (placed_range){{of.begin, place, place, 0, of.level + 1}, node_count, at.trail};
        node_count += 2;
    }
    return node_count;
}

// Children have larger numbers than their parent.
static void cover_nodes(const build *build, wide_node *nodes, uint32_t node_count)
{
    for (uint32_t i = node_count; i-- > 0;) {
        wide_node *node = &nodes[i];
        if (node->count == 0) {
            node->cover = nodes[node->first].cover;
            clast_light_cover_add(&node->cover, &nodes[node->first + 1].cover);
            continue;
        }
        node->cover = clast_light_cover_of(build->sources, &build->items[node->first], build->scale);
        for (uint32_t k = 1; k < node->count; k++) {
            clast_light_cover next = clast_light_cover_of(build->sources, &build->items[node->first + k], build->scale);
            clast_light_cover_add(&node->cover, &next);
        }
    }
}

static void pack_nodes(const build *build, clast_light_tree *tree, const wide_node *nodes)
{
    double total = nodes[0].cover.power;
    for (uint32_t i = 0; i < tree->node_count; i++) {
        tree->nodes[i] = clast_light_cover_pack(&nodes[i].cover, total);
        tree->nodes[i].bounds |= nodes[i].count << 20;
        tree->nodes[i].first = nodes[i].first;
    }
    for (uint32_t i = 0; i < tree->count; i++) {
        float power = (float)((double)build->items[i].power / total);
        tree->entries[i] = (clast_light_entry){build->items[i].number, max1(power, CLAST_LIGHT_POWER_LEAST)};
    }
    tree->strength = (float)(total < 1e30 ? total : 1e30);
}

static clast_status make_nodes(const build *build, clast_light_tree *tree)
{
    clast_context *context = build->context;
    // Every turn parts lights, so there are at most as many leaves as lights.
    wide_node *nodes = clast_allocate(context, 2 * (size_t)build->count, sizeof *nodes);
    tree->entries = clast_allocate(context, build->count, sizeof *tree->entries);
    if (nodes == NULL || tree->entries == NULL) {
        clast_free(context, nodes);
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    tree->node_count = place_nodes(build, tree, nodes);
    tree->nodes = clast_allocate(context, tree->node_count, sizeof *tree->nodes);
    if (tree->nodes != NULL) {
        tree->count = build->count;
        cover_nodes(build, nodes, tree->node_count);
        pack_nodes(build, tree, nodes);
    }
    clast_free(context, nodes);
    return tree->nodes != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// ------------------------------------------------------------------------------------------------------------ creation

static clast_status build_tree(build *build, clast_light_tree *tree)
{
    clast_context *context = build->context;
    size_t numbers = tree->number_count;
    build->items = clast_allocate(context, numbers, sizeof *build->items);
    build->splits = clast_allocate(context, numbers, sizeof *build->splits);
    tree->trails = clast_allocate_zeroed(context, numbers, sizeof *tree->trails);
    tree->places = clast_allocate(context, numbers, sizeof *tree->places);
    if (build->items == NULL || build->splits == NULL || tree->trails == NULL || tree->places == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    memset(tree->places, 0xff, numbers * sizeof *tree->places); // CLAST_NONE
    build->scale = clast_light_scale(build->sources);
    tree->scale = build->scale;
    build->count = clast_light_items(context, build->sources, build->scale, build->items);
    if (build->count == 0) {
        return CLAST_OK;
    }
    clast_status status = split_all(build);
    return status == CLAST_OK ? make_nodes(build, tree) : status;
}

clast_status clast_light_tree_create(clast_context *context, const clast_light_sources *sources, clast_light_tree *tree)
{
    *tree = (clast_light_tree){.scale = 1.0f};
    size_t most = INT32_MAX; // as nodes, which are twice as many, have numbers of 32 bits
    if (sources->emitter_count > most || sources->punctual_count > most - sources->emitter_count) {
        return clast_fail(context, CLAST_ERROR_LIMIT,
                          "the frame has %zu emissive triangles and %zu lights; at most 2^31 - 1 are possible",
                          sources->emitter_count, sources->punctual_count);
    }
    tree->number_count = (uint32_t)(sources->emitter_count + sources->punctual_count);
    if (tree->number_count == 0) {
        return CLAST_OK;
    }
    build build = {.context = context, .sources = sources};
    clast_status status = build_tree(&build, tree);
    clast_free(context, build.items);
    clast_free(context, build.splits);
    clast_free(context, build.tasks);
    return status;
}

void clast_light_tree_destroy(clast_context *context, clast_light_tree *tree)
{
    clast_free(context, tree->nodes);
    clast_free(context, tree->entries);
    clast_free(context, tree->trails);
    clast_free(context, tree->places);
}
