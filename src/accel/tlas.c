// SPDX-License-Identifier: Apache-2.0
// Trees over instances. Each instance has a place in the tree, whether anything of it can be hit or not, so that one call may
// move it, the next make it vanish, and another let it appear.
#include <stdatomic.h>
#include <string.h>

#include "accel/structures.h"
#include "base/prefetch.h"
#include "base/thread.h"

enum {
    PLACE_GRAIN = 128,
    MARK_GRAIN = 8,  // words of marks
    NODE_AHEAD = 12, // nodes that are fetched before they are fitted, and what they are fitted to
    BOXES_AHEAD = 6,
    UPDATE_SHARE = 4, // from a part of so many instances on, all nodes are fitted
    WORD_BITS = 64,
};

clast_status clast_tlas_create(clast_context *context, clast_tlas **tlas)
{
    if (context == NULL || tlas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    *tlas = clast_allocate_zeroed(context, 1, sizeof **tlas);
    if (*tlas == NULL) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    (*tlas)->context = context;
    return CLAST_OK;
}

// -------------------------------------------------------------------------------------------------------------- memory

static void clear(clast_tlas *tlas)
{
    tlas->tree.node_count = 0;
    tlas->tree.level_count = 0;
    tlas->placement_count = 0;
    tlas->visible = false;
}

// Gives up all memory but what is reserved.
static void free_arrays(clast_tlas *tlas)
{
    clear(tlas);
    clast_free(tlas->context, tlas->memory);
    if (!tlas->tree.placed) {
        clast_free(tlas->context, tlas->parents);
    }
    clast_tree_free(tlas->context, &tlas->tree);
    tlas->memory = NULL;
    tlas->parents = NULL;
    tlas->placement_capacity = tlas->parent_capacity = 0;
}

void clast_tlas_destroy(clast_tlas *tlas)
{
    if (tlas != NULL) {
        free_arrays(tlas);
        clast_reserve_free(tlas->context, &tlas->reserve);
        clast_free(tlas->context, tlas);
    }
}

static size_t mark_words(size_t count)
{
    return (count + WORD_BITS - 1) / WORD_BITS;
}

static void take_placements(clast_tlas *tlas, size_t count, clast_arena *arena)
{
    tlas->placements = clast_arena_take(arena, count, sizeof *tlas->placements);
    tlas->boxes = clast_arena_take(arena, count, sizeof *tlas->boxes);
    tlas->leaves = clast_arena_take(arena, count, sizeof *tlas->leaves);
    tlas->marks = clast_arena_take(arena, mark_words(count), sizeof *tlas->marks); // there are fewer nodes
    tlas->placement_capacity = count;
}

// All that a build over at most `count` instances needs, but for working memory.
static void take_all(clast_tlas *tlas, size_t count, clast_arena *arena)
{
    take_placements(tlas, count, arena);
    clast_tree_place(&tlas->tree, count, arena);
    tlas->parent_capacity = tlas->tree.node_capacity;
    tlas->parents = clast_arena_take(arena, tlas->parent_capacity, sizeof *tlas->parents);
}

uint64_t clast_tlas_memory(size_t count)
{
    if (count >= CLAST_CHILD_ITEM) {
        return UINT64_MAX;
    }
    clast_tlas counted = {0};
    clast_arena arena = {NULL, 0};
    take_all(&counted, count, &arena);
    return arena.used + clast_tree_scratch(count);
}

clast_status clast_tlas_reserve(clast_tlas *tlas, size_t count)
{
    if (tlas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = clast_reserve_fit(tlas->context, &tlas->reserve, clast_tlas_memory(count));
    if (status == CLAST_OK) {
        free_arrays(tlas);
    }
    return status;
}

clast_status clast_tlas_use_memory(clast_tlas *tlas, void *memory, size_t bytes)
{
    if (tlas == NULL) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = clast_reserve_borrow(tlas->context, &tlas->reserve, memory, bytes);
    if (status == CLAST_OK) {
        free_arrays(tlas);
    }
    return status;
}

// Memory for a build, in which the arena is what is left for work. `*temporary` is to be freed afterwards.
static clast_status make_room(clast_tlas *tlas, size_t count, clast_arena *arena, void **temporary)
{
    *temporary = NULL;
    if (tlas->reserve.memory != NULL) {
        clast_status status = clast_reserve_fit(tlas->context, &tlas->reserve, clast_tlas_memory(count));
        if (status == CLAST_OK) {
            *arena = (clast_arena){tlas->reserve.memory, 0};
            take_all(tlas, count, arena);
        }
        return status;
    }
    if (count > tlas->placement_capacity) {
        clast_tlas counted = {0};
        clast_arena kept = {NULL, 0};
        take_placements(&counted, count, &kept);
        kept = (clast_arena){clast_allocate(tlas->context, kept.used, 1), 0};
        if (kept.memory == NULL) {
            return CLAST_ERROR_OUT_OF_MEMORY;
        }
        clast_free(tlas->context, tlas->memory);
        tlas->memory = kept.memory;
        take_placements(tlas, count, &kept);
    }
    *temporary = clast_allocate(tlas->context, clast_tree_scratch(count), 1);
    *arena = (clast_arena){*temporary, 0};
    return *temporary != NULL ? CLAST_OK : CLAST_ERROR_OUT_OF_MEMORY;
}

// ------------------------------------------------------------------------------------------------------------- placing

typedef struct place_job {
    clast_tlas *tlas;
    const clast_tlas_instance *instances;
    const uint32_t *numbers; // null: one after the other
    bool marking;            // of the nodes in which they are
    // Of floats that are not negative, the larger one has the larger bits.
    _Atomic uint32_t spread;
    _Atomic size_t refused; // the first instance that cannot be
} place_job;

static const clast_accel_kernels *kernels_of(const clast_tlas *tlas)
{
    return clast_accel_kernels_of(clast_context_isa(tlas->context));
}

// Sets a bit that other threads may be beside.
static void set_mark(uint64_t *marks, uint32_t number)
{
    __atomic_fetch_or(&marks[number / WORD_BITS], UINT64_C(1) << number % WORD_BITS, __ATOMIC_RELAXED);
}

static void place_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    place_job *job = data;
    clast_tlas *tlas = job->tlas;
    const uint32_t *numbers = job->numbers != NULL ? job->numbers + begin : NULL;
    float spread = kernels_of(tlas)->place(job->instances + begin, numbers, begin, end - begin, tlas->placements,
                                           tlas->boxes);
    for (size_t i = begin; i < end; i++) {
        if (job->marking) {
            set_mark(tlas->marks, tlas->leaves[job->numbers != NULL ? job->numbers[i] : i]);
        }
        if (job->instances[i].id == CLAST_NONE) {
            size_t first = atomic_load(&job->refused);
            while (i < first && !atomic_compare_exchange_weak(&job->refused, &first, i)) {
            }
        }
    }
    uint32_t bits = floatBitsToUint(spread), most = atomic_load(&job->spread);
    while (bits > most && !atomic_compare_exchange_weak(&job->spread, &most, bits)) {
    }
}

static clast_status refuse_id(clast_tlas *tlas, size_t place)
{
    return clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT,
                      "instance %zu has the id %u, which says that nothing was hit", place, CLAST_NONE);
}

// -------------------------------------------------------------------------------------------------------------- build

// Tells children where they are.
static void link_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    clast_tlas *tlas = data;
    for (size_t i = begin; i < end; i++) {
        const clast_node *node = &tlas->tree.nodes[i];
        for (uint32_t k = 0; k < node->child_count; k++) {
            uint32_t child = node->children[k];
            if ((child & CLAST_CHILD_ITEM) != 0) {
                tlas->leaves[child & ~CLAST_CHILD_ITEM] = (uint32_t)i;
            } else {
                tlas->parents[child] = (uint32_t)i;
            }
        }
    }
}

static clast_status link_all(clast_tlas *tlas)
{
    if (CLAST_RESERVE(tlas->context, tlas->parents, tlas->parent_capacity, tlas->tree.node_count) != CLAST_OK) {
        return CLAST_ERROR_OUT_OF_MEMORY;
    }
    clast_parallel_for(tlas->context, tlas->tree.node_count, PLACE_GRAIN, link_range, tlas);
    memset(tlas->marks, 0, mark_words(tlas->placement_count) * sizeof *tlas->marks);
    return CLAST_OK;
}

static clast_status build_tree(clast_tlas *tlas, const clast_tlas_instance *instances, size_t count, clast_build build,
                               clast_arena *arena)
{
    place_job job = {.tlas = tlas, .instances = instances, .spread = floatBitsToUint(1.0f), .refused = count};
    clast_parallel_for(tlas->context, count, PLACE_GRAIN, place_range, &job);
    if (job.refused < count) {
        return refuse_id(tlas, job.refused);
    }
    tlas->spread = uintBitsToFloat(job.spread);
    tlas->placement_count = count;
    clast_status status = clast_tree_build(tlas->context, &tlas->tree, tlas->boxes, NULL, count, build, arena);
    return status == CLAST_OK ? link_all(tlas) : status;
}

static void see_what_is_there(clast_tlas *tlas)
{
    clast_box box = clast_tree_bounds(&tlas->tree);
    tlas->visible = !clast_box_is_empty(&box);
}

clast_status clast_tlas_build(clast_tlas *tlas, const clast_tlas_instance *instances, size_t count, clast_build build)
{
    if (tlas == NULL || (instances == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    if (count >= CLAST_CHILD_ITEM) {
        return clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT,
                          "a TLAS over %zu instances; less than 2^31 are possible", count);
    }
    clear(tlas);
    if (count == 0) {
        return CLAST_OK;
    }
    clast_arena arena;
    void *temporary;
    clast_status status = make_room(tlas, count, &arena, &temporary);
    if (status == CLAST_OK) {
        status = build_tree(tlas, instances, count, build, &arena);
    }
    clast_free(tlas->context, temporary);
    if (status == CLAST_OK) {
        see_what_is_there(tlas);
    } else {
        clear(tlas);
    }
    return status;
}

// -------------------------------------------------------------------------------------------------------------- update

// Nothing is changed where it fails.
static clast_status check_update(clast_tlas *tlas, const uint32_t *numbers, const clast_tlas_instance *instances,
                                 size_t count)
{
    if (count > tlas->placement_count) {
        return clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT, "%zu instances of a TLAS of %zu", count,
                          tlas->placement_count);
    }
    clast_status status = CLAST_OK;
    size_t checked = 0;
    for (; checked < count && status == CLAST_OK; checked++) {
        uint32_t number = numbers != NULL ? numbers[checked] : (uint32_t)checked;
        uint64_t bit = UINT64_C(1) << number % WORD_BITS;
        if (number >= tlas->placement_count) {
            status = clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT, "instance %u of a TLAS of %zu", number,
                                tlas->placement_count);
            break;
        }
        if ((tlas->marks[number / WORD_BITS] & bit) != 0) {
            status = clast_fail(tlas->context, CLAST_ERROR_INVALID_ARGUMENT, "instance %u is there twice", number);
            break;
        }
        status = instances[checked].id == CLAST_NONE ? refuse_id(tlas, checked) : CLAST_OK;
        tlas->marks[number / WORD_BITS] |= bit;
    }
    for (size_t i = 0; i < checked; i++) {
        tlas->marks[(numbers != NULL ? numbers[i] : i) / WORD_BITS] = 0;
    }
    return status;
}

typedef struct level_job {
    clast_tlas *tlas;
    uint32_t begin, end; // of the level's nodes
    uint32_t first_word;
    clast_refit_kernel refit;
} level_job;

// Of a word's bits, those of nodes [begin, end).
static uint64_t level_bits(const level_job *job, uint32_t word)
{
    uint64_t bits = ~UINT64_C(0);
    if (word == job->begin / WORD_BITS) {
        bits &= ~UINT64_C(0) << job->begin % WORD_BITS;
    }
    if (word == (job->end - 1) / WORD_BITS) {
        bits &= ~UINT64_C(0) >> (WORD_BITS - 1 - (job->end - 1) % WORD_BITS);
    }
    return bits;
}

// Takes this level's bits out of the words [begin, end): a word may hold the ends of two levels, and others are set at the
// same time.
static uint32_t take_marked(const level_job *job, size_t begin, size_t end, uint32_t *marked)
{
    uint32_t count = 0;
    for (size_t i = begin; i < end; i++) {
        uint32_t word = job->first_word + (uint32_t)i;
        uint64_t own = level_bits(job, word);
        uint64_t bits = __atomic_fetch_and(&job->tlas->marks[word], ~own, __ATOMIC_RELAXED) & own;
        for (; bits != 0; bits &= bits - 1) {
            marked[count++] = word * WORD_BITS + (uint32_t)__builtin_ctzll(bits);
        }
    }
    return count;
}

// What a node is fitted to lies all over memory.
CLAST_FETCHES void prefetch_boxes(const clast_tlas *tlas, uint32_t number)
{
    const clast_node *node = &tlas->tree.nodes[number];
    for (uint32_t i = 0; i < node->child_count; i++) {
        uint32_t child = node->children[i];
        __builtin_prefetch((child & CLAST_CHILD_ITEM) != 0 ? &tlas->boxes[child & ~CLAST_CHILD_ITEM]
                                                           : &tlas->tree.boxes[child]);
    }
}

CLAST_FETCHES void prefetch_node(const clast_tlas *tlas, uint32_t number)
{
    __builtin_prefetch(&tlas->tree.nodes[number], 1);
    __builtin_prefetch((const char *)&tlas->tree.nodes[number] + sizeof(clast_node) - 1, 1);
    __builtin_prefetch(&tlas->tree.boxes[number], 1);
    __builtin_prefetch(&tlas->parents[number]);
}

static void level_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const level_job *job = data;
    clast_tlas *tlas = job->tlas;
    uint32_t marked[MARK_GRAIN * WORD_BITS];
    uint32_t count = take_marked(job, begin, end, marked);
    for (uint32_t i = 0; i < count + NODE_AHEAD; i++) {
        if (i < count) {
            prefetch_node(tlas, marked[i]);
        }
        if (i >= NODE_AHEAD - BOXES_AHEAD && i - (NODE_AHEAD - BOXES_AHEAD) < count) {
            prefetch_boxes(tlas, marked[i - (NODE_AHEAD - BOXES_AHEAD)]);
        }
        if (i < NODE_AHEAD) {
            continue;
        }
        uint32_t number = marked[i - NODE_AHEAD];
        clast_box before = tlas->tree.boxes[number];
        job->refit(&tlas->tree, tlas->boxes, number, number + 1);
        if (number != 0 && memcmp(&before, &tlas->tree.boxes[number], sizeof before) != 0) {
            set_mark(tlas->marks, tlas->parents[number]);
        }
    }
}

// Fits the marked nodes and those above them whose boxes change, each once: level by level, the lowest first.
static void refit_marked_nodes(clast_tlas *tlas)
{
    const clast_tree *tree = &tlas->tree;
    for (uint32_t level = tree->level_count; level-- > 0;) {
        level_job job = {tlas, tree->levels[level], tree->levels[level + 1], tree->levels[level] / WORD_BITS,
                         kernels_of(tlas)->refit_nodes};
        uint32_t words = (job.end - 1) / WORD_BITS + 1 - job.first_word;
        clast_parallel_for(tlas->context, words, MARK_GRAIN, level_range, &job);
    }
}

clast_status clast_tlas_update(clast_tlas *tlas, const uint32_t *numbers, const clast_tlas_instance *instances,
                               size_t count)
{
    if (tlas == NULL || (instances == NULL && count != 0)) {
        return CLAST_ERROR_INVALID_ARGUMENT;
    }
    clast_status status = check_update(tlas, numbers, instances, count);
    if (status != CLAST_OK || count == 0) {
        return status;
    }
    bool all = count == tlas->placement_count, few = count < tlas->placement_count / UPDATE_SHARE;
    place_job job = {.tlas = tlas,
                     .instances = instances,
                     .numbers = numbers,
                     .marking = few,
                     // Others may have the largest condition number: it stays, until all are replaced.
                     .spread = floatBitsToUint(all ? 1.0f : tlas->spread),
                     .refused = count};
    clast_parallel_for(tlas->context, count, PLACE_GRAIN, place_range, &job);
    tlas->spread = uintBitsToFloat(job.spread);
    if (few) {
        refit_marked_nodes(tlas);
    } else {
        clast_tree_refit(tlas->context, &tlas->tree, tlas->boxes);
    }
    see_what_is_there(tlas);
    return CLAST_OK;
}

void clast_tlas_bounds(const clast_tlas *tlas, float lower[3], float upper[3])
{
    clast_box box = tlas != NULL ? clast_tree_bounds(&tlas->tree) : clast_box_empty();
    memcpy(lower, box.lower.v, sizeof box.lower.v);
    memcpy(upper, box.upper.v, sizeof box.upper.v);
}

uint64_t clast_tlas_bytes(const clast_tlas *tlas)
{
    if (tlas == NULL) {
        return 0;
    }
    if (tlas->reserve.memory != NULL) {
        return sizeof *tlas + tlas->reserve.bytes;
    }
    clast_tlas counted = {0};
    clast_arena kept = {NULL, 0};
    take_placements(&counted, tlas->placement_capacity, &kept);
    return sizeof *tlas + clast_tree_bytes(&tlas->tree) + kept.used + tlas->parent_capacity * sizeof *tlas->parents;
}
