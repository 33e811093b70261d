// SPDX-License-Identifier: Apache-2.0
// Rays that have nothing in common, many at a time on one thread. Rays alone wait for memory most of the time: for the
// cluster that they come to, for the block that they meet there, for its vertices. Here a ray that has to wait asks for
// its cache lines, and others go on; all that are at the same stage take it one after the other, so that its code is
// foreseen.
//
// Each ray does what it would do alone (traverse.kernel.c), in the same order: even the steps are the same. Its stacks
// are short; a ray that would need more is traced alone.
#include "accel/batch.h"
#include "accel/ray_stack.h"

enum { FLIGHTS = 32, STREAM_STACK = 56 };

typedef struct short_stack {
    uint32_t height;
    int32_t keys[STREAM_STACK + TREE_WIDTH];
    uint32_t children[STREAM_STACK + TREE_WIDTH];
} short_stack;

// A ray on its way.
typedef struct flight {
    traversal w;
    uint32_t number;
    uint32_t child;  // of the BLAS: where it goes; in a cluster, the slot
    bool overflowed; // it needs more stack
    // in a cluster
    const clast_clas *clas;
    const clast_block *block; // the next to test
    uint32_t first;           // block of the group that `blocks` tells of
    block_hits blocks;
    // above instances
    clast_floats4 direction;
    int exponent;
    space world;
    short_stack stack, upper;
} flight;

// Flights, by number.
typedef struct flight_list {
    uint32_t count;
    uint8_t flights[FLIGHTS];
} flight_list;

typedef struct stream {
    const clast_batch *batch;
    const uint32_t *numbers;
    uint32_t count, started;
    flight_list idle;
    flight_list walking;  // through nodes
    flight_list entering; // a cluster's group of blocks
    flight_list testing;  // a block
    flight flights[FLIGHTS];
} stream;

CLAST_LANES void add_flight(flight_list *list, uint32_t number)
{
    list->flights[list->count++] = (uint8_t)number;
}

// -------------------------------------------------------------------------------------------------------------- stacks

// Where there is room.
CLAST_LANES bool push_nodes(flight *f, short_stack *stack, const clast_node *node, const box_hits *hits,
                            uint32_t *child)
{
    if (__builtin_expect(stack->height > STREAM_STACK, 0)) {
        f->overflowed = true;
        return false;
    }
    *child = push_children(stack->keys, stack->children, &stack->height, node, hits);
    return true;
}

CLAST_LANES bool pop_node(short_stack *stack, float cull, uint32_t *child)
{
    return pop_child(stack->keys, stack->children, &stack->height, cull, child);
}

// ----------------------------------------------------------------------------------------------------------- instances

static bool enter_placement(flight *f, const clast_tlas *tlas, uint32_t number)
{
    f->stack.height = 0;
    f->child = 0;
    return enter_instance(&f->w, &tlas->placements[number], f->direction, f->exponent);
}

// Down from a child of the TLAS to the next instance; false where there is none below it.
static bool descend(flight *f, const clast_tlas *tlas, uint32_t child, float limit)
{
    while ((child & CLAST_CHILD_ITEM) == 0) {
        const clast_node *node = &tlas->tree.nodes[child];
        f->w.steps++;
        box_hits hits = test_node(&f->world, node, limit);
        if (hits.bits == 0 || !push_nodes(f, &f->upper, node, &hits, &child)) {
            return false;
        }
    }
    return enter_placement(f, tlas, child & ~CLAST_CHILD_ITEM);
}

// To the next instance; false where there is none.
static __attribute__((noinline)) bool next_placement(flight *f, const clast_tlas *tlas)
{
    if (tlas->placement_count == 1) {
        return false;
    }
    float limit = distance_in(&f->world, f->w.best.t), cull = cull_limit(limit);
    uint32_t child;
    while (!f->overflowed && pop_node(&f->upper, cull, &child)) {
        if (descend(f, tlas, child, limit)) {
            return true;
        }
    }
    return false;
}

static bool begin_flight(flight *f, const clast_batch *batch, uint32_t number)
{
    const clast_tlas *tlas = batch->tlas;
    f->w.ray = &batch->rays[number];
    f->w.filter = batch->filter;
    f->w.any = false;
    f->number = number;
    f->overflowed = false;
    if (!begin_ray(&f->w, tlas, &f->direction, &f->exponent)) {
        return false;
    }
    if (tlas->placement_count == 1) {
        return enter_placement(f, tlas, 0);
    }
    clast_floats4 origin = load_three4(f->w.ray->origin);
    float reach = reach_of(origin, &tlas->tree.boxes[0]),
          pad = min1(reach * PAD_WORLD * tlas->spread, BOX_COORDINATE_MOST);
    f->world = make_space(origin, f->direction, largest_lane(abs4(f->direction)), f->exponent, reach, pad,
                          f->w.ray->t_min);
    f->upper.height = 1;
    f->upper.keys[0] = (int32_t)floatBitsToUint(-INFINITY);
    f->upper.children[0] = 0;
    return next_placement(f, tlas);
}

static void end_flight(const flight *f, const clast_batch *batch)
{
    clast_hit *hit = &batch->hits[f->number];
    if (__builtin_expect(f->overflowed, 0)) {
        CLAST_KERNEL(clast_closest)(batch->tlas, f->w.ray, 1, batch->filter, hit);
    } else {
        store_hit(&f->w, hit);
    }
}

// --------------------------------------------------------------------------------------------------------------- nodes

CLAST_LANES void fetch_child(const clast_blas *blas, uint32_t child)
{
    const uint8_t *at = (child & CLAST_CHILD_ITEM) != 0
                            ? (const uint8_t *)clast_pool_slot(blas->pool, child & ~CLAST_CHILD_ITEM)
                            : (const uint8_t *)&blas->tree.nodes[child];
    __builtin_prefetch(at);
    __builtin_prefetch(at + 64);
}

// From f->child on to a cluster; false where there is none left in this instance.
CLAST_LANES bool find_cluster(flight *f)
{
    const clast_blas *blas = f->w.placement->blas;
    const clast_node *nodes = blas->tree.nodes;
    const space s = f->w.object;
    uint32_t child = f->child, steps = 0;
    bool found = true;
    while (found && (child & CLAST_CHILD_ITEM) == 0) {
        const clast_node *node = &nodes[child];
        steps++;
        box_hits hits = test_node(&s, node, f->w.limit);
        found = hits.bits != 0 ? push_nodes(f, &f->stack, node, &hits, &child) : pop_node(&f->stack, f->w.cull, &child);
    }
    f->w.steps += steps + found;
    f->child = child & ~CLAST_CHILD_ITEM;
    f->first = 0;
    return found;
}

// From f->child on to a cluster, in this instance or another; false where there is none.
CLAST_LANES bool walk(flight *f, const clast_tlas *tlas)
{
    while (!find_cluster(f)) {
        if (f->overflowed || !next_placement(f, tlas)) {
            return false;
        }
    }
    f->clas = clast_pool_slot(f->w.placement->blas->pool, f->child);
    __builtin_prefetch(f->clas);
    __builtin_prefetch((const uint8_t *)f->clas + 64);
    return true;
}

static void walk_all(stream *s)
{
    for (uint32_t i = 0; i < s->walking.count; i++) {
        uint32_t number = s->walking.flights[i];
        flight *f = &s->flights[number];
        if (walk(f, s->batch->tlas)) {
            add_flight(&s->entering, number);
        } else {
            end_flight(f, s->batch);
            add_flight(&s->idle, number);
        }
    }
    s->walking.count = 0;
}

// ------------------------------------------------------------------------------------------------------------ clusters

// To the nearest block that is left of the group; false where none is.
CLAST_LANES bool next_block(flight *f)
{
    if (f->blocks.count == 0) {
        return false;
    }
    int32_t nearest = take_nearest(&f->blocks);
    if (distance_of_key(nearest) > f->w.cull) {
        return false;
    }
    f->block = &clast_clas_topology(f->clas)->blocks[f->first + ((uint32_t)nearest & KEY_LANES)];
    __builtin_prefetch(f->block);
    return true;
}

// After a group: to the next one of the cluster, or to what waits on the stack.
static void leave_group(stream *s, uint32_t number)
{
    flight *f = &s->flights[number];
    f->first += CLUSTER_WIDTH;
    if (f->first < f->clas->block_count) {
        add_flight(&s->entering, number);
    } else if (pop_node(&f->stack, f->w.cull, &f->child)) {
        fetch_child(f->w.placement->blas, f->child);
        add_flight(&s->walking, number);
    } else if (next_placement(f, s->batch->tlas)) {
        add_flight(&s->walking, number);
    } else {
        end_flight(f, s->batch);
        add_flight(&s->idle, number);
    }
}

static void enter_all(stream *s)
{
    flight_list entering = s->entering;
    s->entering.count = 0;
    for (uint32_t i = 0; i < entering.count; i++) {
        flight *f = &s->flights[entering.flights[i]];
        grid g = make_grid(&f->w.object, f->clas->lower);
        f->blocks = test_group(&f->w.object, &g, f->clas, f->first, f->w.limit);
        if (next_block(f)) {
            add_flight(&s->testing, entering.flights[i]);
        } else {
            leave_group(s, entering.flights[i]);
        }
    }
}

static void test_all(stream *s)
{
    flight_list testing = s->testing;
    s->testing.count = 0;
    for (uint32_t i = 0; i < testing.count; i++) {
        const flight *f = &s->flights[testing.flights[i]];
        const float *vertices = clast_clas_vertices(f->clas);
        const uint8_t *corners = f->block->corners[0];
        for (uint32_t k = 0; k < 3 * BLOCK_TRIANGLES; k++) {
            __builtin_prefetch(vertices + 3 * (uint32_t)corners[k]);
        }
    }
    for (uint32_t i = 0; i < testing.count; i++) {
        uint32_t number = testing.flights[i];
        flight *f = &s->flights[number];
        (void)test_block(&f->w, f->child, f->clas, f->block); // the search for a nearest hit is never over
        if (next_block(f)) {
            add_flight(&s->testing, number);
        } else {
            leave_group(s, number);
        }
    }
}

static void start_flights(stream *s)
{
    while (s->idle.count > 0 && s->started < s->count) {
        uint32_t number = s->idle.flights[s->idle.count - 1];
        flight *f = &s->flights[number];
        if (begin_flight(f, s->batch, s->numbers[s->started++])) {
            s->idle.count--;
            add_flight(&s->walking, number);
        } else {
            end_flight(f, s->batch);
        }
    }
}

void CLAST_KERNEL(clast_stream)(const clast_batch *batch, const uint32_t *numbers, uint32_t count)
{
    stream s;
    s.batch = batch;
    s.numbers = numbers;
    s.count = count;
    s.started = 0;
    s.idle.count = s.walking.count = s.entering.count = s.testing.count = 0;
    for (uint32_t i = 0; i < FLIGHTS; i++) {
        add_flight(&s.idle, i);
    }
    do {
        start_flights(&s);
        walk_all(&s);
        enter_all(&s);
        test_all(&s);
    } while (s.idle.count < FLIGHTS || s.started < s.count);
}
