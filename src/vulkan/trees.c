// SPDX-License-Identifier: Apache-2.0
// The order of the kernels shaders/accel/tree_*.comp. For a sorted tree: boxes around all items, codes of where items are, a
// sort, a binary tree, its nodes gathered into eights. Trees in stored order take one kernel for three levels.
#include "vulkan/trees.h"

#include <string.h>

#include "base/size.h"
#include "vulkan/sort.h"

enum {
    GROUP_ITEMS = 256, // of kernels with an invocation for each item
    BOUNDS_ITEMS = 2048,
    PAIRS_ITEMS = 32,
    QUEUE_SHARE = 64, // a group for so many items, at most QUEUE_GROUPS
    QUEUE_GROUPS = 2048,
    REFIT_ITEMS = 48, // a group of eight teams for so many items
    CODE_BITS = 30,   // of where an item is
    CODE_BITS_LEAST = 24,
    KEY_BITS = 32,
    ALIGNMENT = 256,
};

// The push constants of shaders/accel/tree_jobs.glsl.
typedef struct tree_push {
    uint64_t jobs, work, keys, order, pairs, slots, ranges, queue;
    uint32_t job_count, item_count, group_count, phase, code_bits;
} tree_push;
_Static_assert(sizeof(tree_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

// Those of shaders/accel/tree_stored.comp.
typedef struct stored_push {
    uint64_t jobs, work, order, boxes, boxes_before;
    uint32_t job_count, group_count, phase, only_deep;
    clast_tree_job only;
} stored_push;
_Static_assert(sizeof(stored_push) <= CLAST_GPU_PUSH_BYTES, "push constants");

struct clast_gpu_trees {
    clast_gpu *gpu;
    clast_tree_job *jobs;   // of this build
    clast_tree_work *works; // as it begins: one more than there are jobs
    size_t job_capacity, work_capacity;
    clast_gpu_buffer job_buffer, work;
};

// Those of shaders/accel/tree_refit.comp.
typedef struct refit_push {
    uint64_t jobs;
    uint32_t job_count, group_count;
    clast_tree_job only;
} refit_push;

// A build.
typedef struct build {
    clast_gpu_trees *trees;
    clast_gpu_commands *commands;
    uint32_t job_count;
    uint64_t items;
    uint32_t groups[TREE_PHASES]; // of each phase in stored order
    tree_push push;
    stored_push stored;
    clast_gpu_sort_desc sort;
} build;

clast_status clast_gpu_trees_create(clast_gpu *gpu, clast_gpu_trees **trees)
{
    *trees = clast_allocate_zeroed(clast_gpu_context(gpu), 1, sizeof **trees);
    if (*trees == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    (*trees)->gpu = gpu;
    return CLAST_OK;
}

void clast_gpu_trees_destroy(clast_gpu_trees *trees)
{
    if (trees != NULL) {
        clast_context *context = clast_gpu_context(trees->gpu);
        clast_gpu_free(trees->gpu, &trees->job_buffer);
        clast_gpu_free(trees->gpu, &trees->work);
        clast_free(context, trees->jobs);
        clast_free(context, trees->works);
        clast_free(context, trees);
    }
}

uint64_t clast_gpu_trees_bytes(const clast_gpu_trees *trees)
{
    return trees != NULL ? trees->job_buffer.bytes + trees->work.bytes : 0;
}

// ---------------------------------------------------------------------------------------------------------------- jobs

// Work groups of a tree in stored order: none from the phase on in which nothing is left to join.
static uint32_t phase_groups(uint32_t count, uint32_t phase)
{
    uint32_t inputs = level_nodes(count, 3 * phase);
    if (phase > 0 && inputs <= 1) {
        return 0;
    }
    return inputs != 0 ? (inputs + TREE_PHASE_ITEMS - 1) / TREE_PHASE_ITEMS : 1;
}

static clast_status make_jobs(build *b, const clast_gpu_tree *list)
{
    clast_gpu_trees *trees = b->trees;
    clast_context *context = clast_gpu_context(trees->gpu);
    if (CLAST_RESERVE(context, trees->jobs, trees->job_capacity, b->job_count) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    for (uint32_t i = 0; i < b->job_count; i++) {
        clast_tree_job *job = &trees->jobs[i];
        *job = (clast_tree_job){.boxes = store_address(list[i].boxes),
                                .items = store_address(list[i].items),
                                .nodes = store_address(list[i].nodes),
                                .bounds = store_address(list[i].bounds),
                                .kept = store_address(list[i].kept),
                                .count = list[i].count,
                                .first = (uint32_t)b->items};
        for (uint32_t phase = 0; phase < TREE_PHASES; phase++) {
            job->first_groups[phase] = b->groups[phase];
            b->groups[phase] += phase_groups(list[i].count, phase);
        }
        b->items += list[i].count;
        if (b->items >= UINT64_C(1) << TREE_ITEMS_BITS) {
            return clast_fail(context, CLAST_ERROR_LIMIT, "vulkan: trees over 2^%d boxes or more", TREE_ITEMS_BITS);
        }
    }
    return CLAST_OK;
}

// Jobs and, behind them, what is known of each: nothing. That is wanted where trees are sorted.
static clast_status upload_jobs(build *b, bool sorted)
{
    clast_gpu_trees *trees = b->trees;
    uint64_t job_bytes = b->job_count * sizeof *trees->jobs, work_count = sorted ? b->job_count + UINT64_C(1) : 0;
    uint64_t work_bytes = work_count * sizeof *trees->works;
    clast_status status = clast_gpu_reserve(trees->gpu, CLAST_GPU_DEVICE, job_bytes + work_bytes, "tree jobs",
                                            &trees->job_buffer);
    if (status == CLAST_OK) {
        status = CLAST_RESERVE(clast_gpu_context(trees->gpu), trees->works, trees->work_capacity, work_count);
    }
    if (status != CLAST_OK) {
        return status;
    }
    clast_gpu_write(b->commands, &trees->job_buffer, 0, trees->jobs, job_bytes);
    if (sorted) {
        for (uint64_t i = 0; i < work_count; i++) {
            trees->works[i] = (clast_tree_work){.lower = {CLAST_NONE, CLAST_NONE, CLAST_NONE}};
        }
        clast_gpu_write(b->commands, &trees->job_buffer, job_bytes, trees->works, work_bytes);
    }
    clast_gpu_barrier(b->commands);
    b->push.jobs = trees->job_buffer.address;
    b->push.work = b->push.jobs + job_bytes;
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------------- memory

// Takes a piece of the working memory, which begins at `base`: adds to what is taken.
static uint64_t take(uint64_t base, uint64_t *used, uint64_t bytes)
{
    uint64_t address = base + *used;
    *used += (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    return address;
}

static uint64_t take_all(build *b, clast_gpu_tree_order order, uint64_t base)
{
    uint64_t used = 0, items = b->items;
    uint64_t groups = (uint64_t)b->groups[0] + b->groups[1] + b->groups[2];
    b->stored.boxes = take(base, &used, groups * sizeof(clast_box));
    if (order == CLAST_GPU_TREE_SORTED) {
        uint64_t key_bytes = (b->sort.wide ? sizeof(uint64_t) : sizeof(uint32_t)) * items;
        b->sort.keys = take(base, &used, key_bytes);
        b->sort.spare_keys = take(base, &used, key_bytes);
        b->sort.values = take(base, &used, items * sizeof(uint32_t));
        b->sort.spare_values = take(base, &used, items * sizeof(uint32_t));
        b->sort.scratch = take(base, &used, CLAST_GPU_SORT_SCRATCH);
        b->push.pairs = take(base, &used, items * sizeof(clast_tree_pair));
        b->push.slots = take(base, &used, items * 2 * sizeof(uint32_t));
        b->push.ranges = take(base, &used, items * sizeof(uint32_t));
        b->push.queue = take(base, &used, items * 2 * sizeof(uint32_t));
    }
    return used;
}

static clast_status reserve_work(build *b, clast_gpu_tree_order order)
{
    clast_gpu_trees *trees = b->trees;
    clast_status status = clast_gpu_reserve(trees->gpu, CLAST_GPU_DEVICE, take_all(b, order, 0), "tree building",
                                            &trees->work);
    if (status == CLAST_OK) {
        take_all(b, order, trees->work.address);
    }
    return status;
}

// ------------------------------------------------------------------------------------------------------------- kernels

static bool teams_together(const build *b)
{
    return clast_gpu_features_of(b->trees->gpu)->subgroup_least >= TREE_CHILDREN;
}

static void run(build *b, clast_shader shader, uint32_t groups, uint32_t constant)
{
    b->push.group_count = groups;
    clast_gpu_run(b->commands, &(clast_gpu_call){.shader = shader,
                                                 .constants = {constant},
                                                 .constant_count = 1,
                                                 .push = &b->push,
                                                 .push_bytes = sizeof b->push,
                                                 .groups = groups});
}

static uint32_t groups_for(uint64_t work, uint32_t each)
{
    return (uint32_t)((work + each - 1) / each);
}

// Over the order of a sort where `only_deep`: trees whose other tree is too deep for rays.
static void build_stored(build *b, bool only_deep)
{
    b->stored.jobs = b->push.jobs;
    b->stored.work = b->push.work;
    b->stored.order = b->push.order;
    b->stored.job_count = b->job_count;
    b->stored.only_deep = only_deep;
    b->stored.only = b->trees->jobs[0];
    for (uint32_t phase = 0; phase < TREE_PHASES && b->groups[phase] != 0; phase++) {
        if (phase != 0) {
            clast_gpu_barrier(b->commands);
            b->stored.boxes_before = b->stored.boxes;
            b->stored.boxes += b->groups[phase - 1] * sizeof(clast_box);
        }
        b->stored.phase = phase;
        b->stored.group_count = b->groups[phase];
        clast_gpu_run(b->commands, &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_TREE_STORED,
                                                     .constants = {teams_together(b)},
                                                     .constant_count = 1,
                                                     .push = &b->stored,
                                                     .push_bytes = sizeof b->stored,
                                                     .groups = b->groups[phase]});
    }
}

// Which bits of keys tell the place, and which the tree.
static void choose_keys(build *b)
{
    uint32_t job_bits = 0;
    while (b->job_count > UINT32_C(1) << job_bits) {
        job_bits++;
    }
    uint32_t left = KEY_BITS - job_bits;
    b->sort.wide = left < CODE_BITS_LEAST;
    b->push.code_bits = b->sort.wide || left > CODE_BITS ? CODE_BITS : left;
    b->sort.bits = b->push.code_bits + job_bits;
    b->sort.count = b->items;
    b->sort.numbered = true;
}

static void run_pairs(build *b, uint32_t key_words)
{
    const clast_gpu_features *features = clast_gpu_features_of(b->trees->gpu);
    bool can_ask = features->subgroup_control && features->subgroup_least <= PAIRS_ITEMS &&
                   features->subgroup_most >= PAIRS_ITEMS;
    clast_gpu_run(b->commands,
                  &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_TREE_PAIRS,
                                    .constants = {key_words, can_ask || features->subgroup_least >= PAIRS_ITEMS},
                                    .constant_count = 2,
                                    .push = &b->push,
                                    .push_bytes = sizeof b->push,
                                    .groups = groups_for(b->items, PAIRS_ITEMS),
                                    .subgroup = can_ask ? PAIRS_ITEMS : 0});
}

static void build_sorted(build *b)
{
    uint32_t items = (uint32_t)b->items, key_words = b->sort.wide ? 2 : 1;
    run(b, CLAST_SHADER_ACCEL_TREE_BOUNDS, groups_for(items, BOUNDS_ITEMS), 0);
    clast_gpu_barrier(b->commands);
    b->push.keys = b->sort.keys;
    run(b, CLAST_SHADER_ACCEL_TREE_CODES, groups_for(items, GROUP_ITEMS), key_words);
    bool spare = clast_gpu_sort(b->commands, &b->sort);
    b->push.keys = spare ? b->sort.spare_keys : b->sort.keys;
    b->push.order = spare ? b->sort.spare_values : b->sort.values;
    clast_gpu_barrier(b->commands);
    run_pairs(b, key_words);
    clast_gpu_barrier(b->commands);
    b->push.phase = 0;
    run(b, CLAST_SHADER_ACCEL_TREE_WIDEN, b->job_count, teams_together(b));
    clast_gpu_barrier(b->commands);
    b->push.phase = 1;
    uint32_t groups = groups_for(items, QUEUE_SHARE);
    run(b, CLAST_SHADER_ACCEL_TREE_WIDEN, groups < QUEUE_GROUPS ? groups : QUEUE_GROUPS, teams_together(b));
    clast_gpu_barrier(b->commands);
    build_stored(b, true);
}

clast_status clast_gpu_trees_build(clast_gpu_trees *trees, clast_gpu_commands *commands, const clast_gpu_tree *list,
                                   uint32_t count, clast_gpu_tree_order order)
{
    if (count == 0) {
        return CLAST_OK;
    }
    build b = {.trees = trees, .commands = commands, .job_count = count};
    clast_status status = make_jobs(&b, list);
    if (status == CLAST_OK) {
        order = b.items == 0 ? CLAST_GPU_TREE_STORED : order;
        choose_keys(&b);
        status = reserve_work(&b, order);
    }
    clast_gpu_barrier(commands); // earlier builds have done with the working memory
    if (status == CLAST_OK && (count > 1 || order == CLAST_GPU_TREE_SORTED)) {
        status = upload_jobs(&b, order == CLAST_GPU_TREE_SORTED);
    }
    if (status != CLAST_OK) {
        clast_gpu_note(commands, status);
        return status;
    }
    b.push.job_count = count;
    b.push.item_count = (uint32_t)b.items;
    if (order == CLAST_GPU_TREE_SORTED) {
        build_sorted(&b);
    } else {
        build_stored(&b, false);
    }
    return CLAST_OK;
}

// --------------------------------------------------------------------------------------------------------------- refit

clast_status clast_gpu_trees_refit(clast_gpu_trees *trees, clast_gpu_commands *commands, const clast_gpu_tree *list,
                                   uint32_t count)
{
    if (count == 0) {
        return CLAST_OK;
    }
    build b = {.trees = trees, .commands = commands, .job_count = count};
    clast_status status = make_jobs(&b, list);
    uint32_t groups = 0;
    for (uint32_t i = 0; status == CLAST_OK && i < count; i++) {
        uint32_t own = groups_for(list[i].count, REFIT_ITEMS);
        trees->jobs[i].first_groups[0] = groups;
        trees->jobs[i].first_groups[1] = own;
        groups += own;
    }
    clast_gpu_barrier(commands);
    if (status == CLAST_OK && count > 1) {
        status = upload_jobs(&b, false);
    }
    if (status != CLAST_OK) {
        clast_gpu_note(commands, status);
        return status;
    }
    if (groups == 0) {
        return CLAST_OK;
    }
    refit_push push = {b.push.jobs, count, groups, trees->jobs[0]};
    clast_gpu_run(commands, &(clast_gpu_call){.shader = CLAST_SHADER_ACCEL_TREE_REFIT,
                                              .constants = {teams_together(&b)},
                                              .constant_count = 1,
                                              .push = &push,
                                              .push_bytes = sizeof push,
                                              .groups = groups});
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------------- shapes

uint64_t clast_gpu_tree_shape_bytes(const clast_tree *tree)
{
    return sizeof(clast_tree_kept) + tree->node_count * (sizeof(clast_tree_kept_node) + sizeof(uint32_t));
}

clast_status clast_gpu_tree_shape(clast_context *context, const clast_tree *tree, void *memory)
{
    if (tree->node_count == 0 || tree->level_count > TREE_LEVELS) {
        return clast_fail(context, CLAST_ERROR_UNSUPPORTED, "a tree of %u levels; devices trace through 1 to %u",
                          tree->level_count, TREE_LEVELS);
    }
    clast_tree_kept *head = memory;
    clast_tree_kept_node *nodes = (clast_tree_kept_node *)(head + 1);
    uint32_t *bottoms = (uint32_t *)(nodes + tree->node_count);
    *head = (clast_tree_kept){.room = tree->node_count};
    nodes[0].parent = CLAST_NONE;
    for (uint32_t i = 0; i < tree->node_count; i++) { // parents come before their children
        const clast_node *from = &tree->nodes[i];
        bool is_bottom = true;
        nodes[i].box = tree->boxes[i];
        nodes[i].arrivals = 0;
        for (uint32_t k = 0; k < TREE_CHILDREN; k++) {
            bool there = k < from->child_count;
            nodes[i].children[k] = there ? from->children[k] : CLAST_NONE;
            if (there && (from->children[k] & CHILD_ITEM) == 0) {
                nodes[from->children[k]].parent = i;
                is_bottom = false;
            }
        }
        if (is_bottom) {
            bottoms[head->bottoms++] = i;
        }
    }
    return CLAST_OK;
}
