// SPDX-License-Identifier: Apache-2.0
// Trees over boxes: what they hold, that they do not depend on threads, and the kernels that fit them.
#include "test.h"

#include <math.h>
#include <string.h>

#include "accel/meshes.h"
#include "accel/structures.h"
#include "base/context.h"
#include "shared/box.h"

enum { RAYS = 4000 };

static const clast_isa all_sets[] = {
#define SET(name, value, text) name,
    CLAST_ISA_LIST(SET)
#undef SET
};

// --------------------------------------------------------------------------------------------------------------- boxes

typedef void (*box_maker)(randoms *r, uint32_t i, clast_box *box);

static void set_box(clast_box *box, const float centre[3], float size)
{
    for (int axis = 0; axis < 3; axis++) {
        box->lower.v[axis] = centre[axis] - size;
        box->upper.v[axis] = centre[axis] + size;
    }
}

static void make_uniform(randoms *r, uint32_t i, clast_box *box)
{
    (void)i;
    const float centre[3] = {random_float(r), random_float(r), random_float(r)};
    set_box(box, centre, 0.05f * random_float(r));
}

static void make_equal(randoms *r, uint32_t i, clast_box *box)
{
    (void)r;
    (void)i;
    const float centre[3] = {1.0f, 2.0f, 3.0f};
    set_box(box, centre, 0.5f);
}

// Points that halve their distance: a cut by surface area takes few of them at a time.
static void make_halving(randoms *r, uint32_t i, clast_box *box)
{
    (void)r;
    const float centre[3] = {ldexpf(1.0f, -(int)(i % 120)), 0.0f, 0.0f};
    set_box(box, centre, 0.0f);
}

static void make_line(randoms *r, uint32_t i, clast_box *box)
{
    (void)r;
    const float centre[3] = {-0.0f, 1e-3f * (float)i, 0.0f};
    set_box(box, centre, 0.0f);
}

static void make_dust(randoms *r, uint32_t i, clast_box *box)
{
    const float centre[3] = {1e-38f * random_float(r), 1e-38f * random_float(r), 1e-38f * (float)i};
    set_box(box, centre, 0.0f);
}

static void make_huge(randoms *r, uint32_t i, clast_box *box)
{
    (void)i;
    const float centre[3] = {random_between(r, -6e35f, 6e35f), random_between(r, -6e35f, 6e35f), 0.0f};
    set_box(box, centre, 6e35f * random_float(r));
}

// Half of them in a corner, a millionth of the whole; some empty.
static void make_crowded(randoms *r, uint32_t i, clast_box *box)
{
    make_uniform(r, i, box);
    for (int axis = 0; axis < 3 && i % 2 == 0; axis++) {
        box->lower.v[axis] *= 1e-6f;
        box->upper.v[axis] *= 1e-6f;
    }
    if (i % 7 == 3) {
        *box = clast_box_empty();
    }
}

static void make_empty(randoms *r, uint32_t i, clast_box *box)
{
    (void)r;
    (void)i;
    *box = clast_box_empty();
}

static const box_maker makers[] = {make_uniform, make_equal, make_halving, make_line,
                                   make_dust,    make_huge,  make_crowded, make_empty};
enum { MAKERS = sizeof makers / sizeof *makers };

static clast_box *make_boxes(box_maker maker, uint32_t count, uint64_t seed)
{
    clast_box *boxes = malloc((count + 1) * sizeof *boxes);
    randoms r = {seed};
    for (uint32_t i = 0; i < count; i++) {
        maker(&r, i, &boxes[i]);
    }
    return boxes;
}

static clast_tree build(clast_context *context, const clast_box *boxes, const uint32_t *numbers, uint32_t count,
                        clast_build how)
{
    clast_tree tree = {0};
    clast_arena scratch = {malloc(clast_tree_scratch(count) + ARENA_ALIGNMENT), 0};
    uint8_t *memory = scratch.memory;
    scratch.memory += ARENA_ALIGNMENT - (uintptr_t)memory % ARENA_ALIGNMENT;
    assert_ok(context, clast_tree_build(context, &tree, boxes, numbers, count, how, &scratch));
    assert_true(scratch.used <= clast_tree_scratch(count));
    free(memory);
    return tree;
}

// --------------------------------------------------------------------------------------------------------------- shape

static void assert_child_within(const clast_node *node, uint32_t lane, const clast_box *box)
{
    for (int axis = 0; axis < 3 && !clast_box_is_empty(box); axis++) {
        float step = power_of_two(node->exponents[axis]);
        assert_true(box_decode(node->lower[axis], node->boxes[axis][0][lane], step) <= box->lower.v[axis]);
        assert_true(box_decode(node->lower[axis], node->boxes[axis][1][lane], step) >= box->upper.v[axis]);
    }
}

// That children lie within, that each item and each node is there once, and that levels are what they say.
static void assert_sound_tree(const clast_tree *tree, const clast_box *boxes, const uint32_t *numbers, uint32_t count)
{
    uint32_t next = 1, items = 0;
    uint8_t *seen = calloc(count, 1);
    assert_in_range(tree->level_count, 1, TREE_DEPTH);
    assert_int_equal(tree->levels[0], 0);
    assert_int_equal(tree->levels[tree->level_count], tree->node_count);
    for (uint32_t level = 0, i = 0; level < tree->level_count; level++) {
        assert_int_equal(next, level + 1 < tree->level_count ? tree->levels[level + 1] : tree->node_count);
        for (; i < tree->levels[level + 1]; i++) {
            const clast_node *node = &tree->nodes[i];
            assert_in_range(node->child_count, count > 1 ? 2 : 1, TREE_WIDTH);
            for (uint32_t k = 0; k < node->child_count; k++) {
                uint32_t child = node->children[k] & ~CLAST_CHILD_ITEM;
                if ((node->children[k] & CLAST_CHILD_ITEM) != 0) {
                    assert_child_within(node, k, &boxes[child]);
                    uint32_t place = 0;
                    for (; numbers != NULL && numbers[place] != child; place++) {
                    }
                    assert_int_equal(seen[numbers != NULL ? place : child]++, 0);
                    items++;
                } else {
                    assert_child_within(node, k, &tree->boxes[child]);
                    assert_int_equal(child, next++);
                }
            }
        }
    }
    assert_int_equal(items, count);
    free(seen);
}

static void every_item_is_in_the_tree_once(void **state)
{
    static const uint32_t counts[] = {1, 2, 3, 8, 9, 10, 63, 500, 3000, 20000};
    for (uint32_t i = 0; i < MAKERS * sizeof counts / sizeof *counts; i++) {
        uint32_t count = counts[i / MAKERS];
        clast_box *boxes = make_boxes(makers[i % MAKERS], count, i);
        for (int how = CLAST_BUILD_BEST; how <= CLAST_BUILD_FAST; how++) {
            clast_tree tree = build(*state, boxes, NULL, count, (clast_build)how);
            assert_sound_tree(&tree, boxes, NULL, count);
            clast_tree_free(*state, &tree);
        }
        free(boxes);
    }
}

static void some_items_can_be_picked(void **state)
{
    const uint32_t numbers[] = {70, 3, 512, 11, 12, 999, 600, 601, 602, 603, 4};
    const uint32_t count = sizeof numbers / sizeof *numbers;
    clast_box *boxes = make_boxes(make_uniform, 1000, 3);
    for (int how = CLAST_BUILD_BEST; how <= CLAST_BUILD_FAST; how++) {
        clast_tree tree = build(*state, boxes, numbers, count, (clast_build)how);
        assert_sound_tree(&tree, boxes, numbers, count);
        clast_tree_free(*state, &tree);
    }
    free(boxes);
}

static void threads_do_not_change_a_tree(void **state)
{
    static const uint32_t threads[] = {1, 2, 5};
    (void)state;
    const uint32_t count = 30000;
    clast_box *boxes = make_boxes(make_crowded, count, 5);
    for (int how = CLAST_BUILD_BEST; how <= CLAST_BUILD_FAST; how++) {
        clast_context *contexts[3];
        clast_tree trees[3];
        for (int i = 0; i < 3; i++) {
            assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads[i]}, &contexts[i]),
                             CLAST_OK);
            trees[i] = build(contexts[i], boxes, NULL, count, (clast_build)how);
            assert_int_equal(trees[i].node_count, trees[0].node_count);
            assert_memory_equal(trees[i].nodes, trees[0].nodes, trees[0].node_count * sizeof(clast_node));
            assert_memory_equal(trees[i].boxes, trees[0].boxes, trees[0].node_count * sizeof(clast_box));
        }
        for (int i = 0; i < 3; i++) {
            clast_tree_free(contexts[i], &trees[i]);
            clast_context_destroy(contexts[i]);
        }
    }
    free(boxes);
}

// ------------------------------------------------------------------------------------------------------------- kernels

static void assert_fitted_alike(clast_context *context, const clast_tree *tree, const clast_box *boxes)
{
    clast_tree plain = *tree;
    plain.nodes = malloc(tree->node_count * sizeof *plain.nodes);
    plain.boxes = malloc(tree->node_count * sizeof *plain.boxes);
    memcpy(plain.nodes, tree->nodes, tree->node_count * sizeof *plain.nodes);
    for (uint32_t i = plain.node_count; i-- > 0;) {
        clast_tree_refit_node(&plain, boxes, i);
    }
    clast_tree fitted = *tree;
    clast_tree_refit(context, &fitted, boxes);
    assert_memory_equal(fitted.nodes, plain.nodes, plain.node_count * sizeof *plain.nodes);
    assert_memory_equal(fitted.boxes, plain.boxes, plain.node_count * sizeof *plain.boxes);
    free(plain.nodes);
    free(plain.boxes);
}

static void every_instruction_set_fits_nodes_alike(void **state)
{
    (void)state;
    for (size_t set = 0; set < sizeof all_sets / sizeof *all_sets; set++) {
        clast_context *context;
        if (clast_context_create(&(clast_context_desc){.isa = all_sets[set], .threads = 3}, &context) != CLAST_OK) {
            continue; // the machine lacks it
        }
        for (int i = 0; i < MAKERS; i++) {
            const uint32_t count = 4000;
            clast_box *boxes = make_boxes(makers[i], count, 6);
            clast_tree tree = build(context, boxes, NULL, count, CLAST_BUILD_FAST);
            assert_fitted_alike(context, &tree, boxes);
            for (int other = 0; other < MAKERS; other++) { // the same tree over other boxes
                clast_box *moved = make_boxes(makers[other], count, 7);
                assert_fitted_alike(context, &tree, moved);
                free(moved);
            }
            clast_tree_free(context, &tree);
            free(boxes);
        }
        clast_context_destroy(context);
    }
}

// ---------------------------------------------------------------------------------------------------------------- rays

static clast_hit *trace(clast_context *context, clustered *c, clast_build how, const clast_ray *rays)
{
    clast_tlas *tlas;
    clast_hit *hits = calloc(RAYS, sizeof *hits);
    clast_tlas_instance instance = instance_of(c->blas, 0);
    assert_ok(context, clast_blas_build(c->blas, NULL, c->cluster_count, how));
    assert_ok(context, clast_tlas_create(context, &tlas));
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, how));
    clast_trace_closest(tlas, rays, RAYS, NULL, hits);
    clast_tlas_destroy(tlas);
    return hits;
}

static void both_ways_to_build_give_the_same_hits(void **state)
{
    clustered c;
    mesh m = mesh_octasphere(5);
    mesh_displace(&m, 0.4f, 8);
    assert_ok(*state, clustered_make(*state, &m, 40, &c));
    clast_ray *rays = malloc(RAYS * sizeof *rays);
    randoms r = {9};
    for (uint32_t i = 0; i < RAYS; i++) {
        rays[i] = (clast_ray){.t_max = INFINITY};
        for (int axis = 0; axis < 3; axis++) {
            rays[i].origin[axis] = random_between(&r, -1.5f, 1.5f);
            rays[i].direction[axis] = random_between(&r, -1, 1);
        }
    }
    clast_hit *best = trace(*state, &c, CLAST_BUILD_BEST, rays), *fast = trace(*state, &c, CLAST_BUILD_FAST, rays);
    uint32_t found = 0;
    for (uint32_t i = 0; i < RAYS; i++) {
        assert_int_equal(best[i].instance, fast[i].instance);
        if (best[i].instance != CLAST_NONE) {
            best[i].steps = fast[i].steps = 0;
            assert_memory_equal(&best[i], &fast[i], sizeof *best);
            found++;
        }
    }
    assert_true(found > RAYS / 4);
    free(best);
    free(fast);
    free(rays);
    clustered_free(&c);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(every_item_is_in_the_tree_once),        CONTEXT_TEST(some_items_can_be_picked),
        cmocka_unit_test(threads_do_not_change_a_tree),      cmocka_unit_test(every_instruction_set_fits_nodes_alike),
        CONTEXT_TEST(both_ways_to_build_give_the_same_hits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
