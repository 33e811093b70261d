// SPDX-License-Identifier: Apache-2.0
// Trees that a device builds: what they hold, how good they are beside the processor's, and that they do not change.
#include <math.h>
#include <string.h>

#include "accel/structures.h"
#include "test.h"
#include "vulkan/test_device.h"
#include "vulkan/trees.h"

static test_device device;
static clast_gpu_trees *trees;

// --------------------------------------------------------------------------------------------------------------- boxes

static float random_unit(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (float)(*seed >> 40) / 16777216.0f;
}

static clast_box box_around(float x, float y, float z, float size)
{
    return (clast_box){{{x - size, y - size, z - size}}, {{x + size, y + size, z + size}}};
}

typedef clast_box (*box_maker)(uint32_t i, uint32_t count, uint64_t *seed);

static clast_box make_uniform(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)i;
    (void)count;
    float x = random_unit(seed), y = random_unit(seed), z = random_unit(seed);
    return box_around(x, y, z, 0.02f * random_unit(seed));
}

// Tiles of a hilly surface in the order of a curve.
static clast_box make_surface(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)seed;
    uint32_t side = 1, x = 0, y = 0;
    while (side * side < count) {
        side *= 2;
    }
    for (uint32_t bit = 0; bit < 15; bit++) {
        x |= (i >> (2 * bit) & 1) << bit;
        y |= (i >> (2 * bit + 1) & 1) << bit;
    }
    float u = ((float)x + 0.5f) / (float)side, v = ((float)y + 0.5f) / (float)side;
    return box_around(u, 0.1f * sinf(9.0f * u) * cosf(7.0f * v), v, 0.55f / (float)side);
}

static clast_box make_equal(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)i;
    (void)count;
    (void)seed;
    return box_around(1.0f, -2.0f, 3.0f, 0.0f);
}

// Points that halve their distance: trees by codes and by area become deep.
static clast_box make_halving(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)count;
    (void)seed;
    return box_around(ldexpf(1.0f, -(int)(i % 120)), 0.0f, 0.0f, 0.0f);
}

// The same in small steps, most of them too small for codes: each joins the one that is nearer to the end, one by one.
static clast_box make_chain(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)seed;
    return box_around(exp2f(-110.0f * (float)i / (float)count), 0.0f, 0.0f, 0.0f);
}

static clast_box make_huge(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)i;
    (void)count;
    float x = random_unit(seed) - 0.5f, y = random_unit(seed) - 0.5f;
    return box_around(1.2e36f * x, 1.2e36f * y, 0.0f, 6e35f * random_unit(seed));
}

static clast_box make_dust(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)count;
    return box_around(1e-37f * random_unit(seed), 1e-37f * (float)i, 0.0f, 1e-38f);
}

// Some empty, some that are no boxes.
static clast_box make_broken(uint32_t i, uint32_t count, uint64_t *seed)
{
    clast_box box = make_uniform(i, count, seed);
    switch (i % 7) {
    case 1: return (clast_box){{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    case 3: box.upper.v[1] = NAN; break;
    case 4: box.lower.v[2] = -INFINITY; break;
    case 5: box.upper.v[0] = box.lower.v[0] - 1.0f; break;
    default: break;
    }
    return box;
}

static clast_box make_all_empty(uint32_t i, uint32_t count, uint64_t *seed)
{
    (void)i;
    (void)count;
    (void)seed;
    return (clast_box){{{1.0f, 1.0f, 1.0f}}, {{-1.0f, -1.0f, -1.0f}}};
}

static bool is_sound_box(const clast_box *box)
{
    bool sound = true;
    for (int axis = 0; axis < 3; axis++) {
        sound = sound && box->lower.v[axis] <= box->upper.v[axis] && fabsf(box->lower.v[axis]) <= BOX_COORDINATE_MOST &&
                fabsf(box->upper.v[axis]) <= BOX_COORDINATE_MOST;
    }
    return sound;
}

static void add_box(clast_box *sum, const clast_box *box)
{
    for (int axis = 0; axis < 3; axis++) {
        sum->lower.v[axis] = min1(sum->lower.v[axis], box->lower.v[axis]);
        sum->upper.v[axis] = max1(sum->upper.v[axis], box->upper.v[axis]);
    }
}

// ------------------------------------------------------------------------------------------------------------ building

// Some trees that are built together. Their boxes and nodes are one array each.
typedef struct test_trees {
    uint32_t count, items;
    uint32_t *counts, *firsts, *refs;
    clast_box *boxes, *bounds;
    clast_tree_node *nodes; // a tree's at firsts[i] + i
} test_trees;

static void *allocate(size_t count, size_t bytes)
{
    void *memory = calloc(count + 1, bytes);
    assert_non_null(memory);
    return memory;
}

static test_trees make_trees(const uint32_t *counts, uint32_t count, box_maker make)
{
    test_trees t = {.count = count};
    t.counts = allocate(count, sizeof *t.counts);
    t.firsts = allocate(count, sizeof *t.firsts);
    t.bounds = allocate(count, sizeof *t.bounds);
    for (uint32_t i = 0; i < count; i++) {
        t.counts[i] = counts[i];
        t.firsts[i] = t.items;
        t.items += counts[i];
    }
    t.refs = allocate(t.items, sizeof *t.refs);
    t.boxes = allocate(t.items, sizeof *t.boxes);
    t.nodes = allocate(t.items + count, sizeof *t.nodes);
    for (uint32_t i = 0; i < count; i++) {
        uint64_t seed = i + 1;
        for (uint32_t k = 0; k < counts[i]; k++) {
            t.boxes[t.firsts[i] + k] = make(k, counts[i], &seed);
            t.refs[t.firsts[i] + k] = 3 * k + i; // what children say
        }
    }
    return t;
}

static void free_trees(test_trees *t)
{
    free(t->counts);
    free(t->firsts);
    free(t->refs);
    free(t->boxes);
    free(t->bounds);
    free(t->nodes);
}

// Then fits them to `moved`, where it is not null. A shape is fitted, and nothing built.
static void run_trees(test_trees *t, clast_gpu_tree_order order, const clast_box *moved, const void *shape,
                      uint64_t shape_bytes)
{
    uint64_t box_bytes = t->items * sizeof *t->boxes, node_bytes = (t->items + t->count) * sizeof *t->nodes;
    uint64_t bound_bytes = t->count * sizeof *t->bounds;
    uint64_t kept_bytes = clast_gpu_tree_kept_bytes(t->items) + t->count * 256u;
    clast_gpu_buffer boxes, refs, nodes, bounds, kept;
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, kept_bytes, "kept", &kept));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, box_bytes, "boxes", &boxes));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, t->items * 4u, "items", &refs));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, node_bytes, "nodes", &nodes));
    assert_ok(device.context, clast_gpu_allocate(device.gpu, CLAST_GPU_DEVICE, bound_bytes, "bounds", &bounds));
    clast_gpu_tree *list = allocate(t->count, sizeof *list);
    uint64_t kept_used = 0;
    for (uint32_t i = 0; i < t->count; i++) {
        list[i] = (clast_gpu_tree){.boxes = boxes.address + t->firsts[i] * sizeof *t->boxes,
                                   .items = refs.address + t->firsts[i] * sizeof *t->refs,
                                   .nodes = nodes.address + (t->firsts[i] + i) * sizeof *t->nodes,
                                   .bounds = bounds.address + i * sizeof *t->bounds,
                                   .kept = moved != NULL ? kept.address + kept_used : 0,
                                   .count = t->counts[i]};
        kept_used += (clast_gpu_tree_kept_bytes(t->counts[i]) + 15) / 16 * 16;
    }
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    clast_gpu_write(commands, &boxes, 0, t->boxes, box_bytes);
    clast_gpu_write(commands, &refs, 0, t->refs, t->items * sizeof *t->refs);
    clast_gpu_fill(commands, &nodes, 0, node_bytes, 0xabababab);
    if (shape != NULL) {
        clast_gpu_write(commands, &kept, 0, shape, shape_bytes);
    } else {
        assert_ok(device.context, clast_gpu_trees_build(trees, commands, list, t->count, order));
    }
    for (int round = 0; moved != NULL && round < 2; round++) { // the second changes nothing
        clast_gpu_barrier(commands);
        clast_gpu_write(commands, &boxes, 0, moved, box_bytes);
        assert_ok(device.context, clast_gpu_trees_refit(trees, commands, list, t->count));
    }
    clast_gpu_read(commands, &nodes, 0, t->nodes, node_bytes);
    clast_gpu_read(commands, &bounds, 0, t->bounds, bound_bytes);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_free(device.gpu, &boxes);
    clast_gpu_free(device.gpu, &refs);
    clast_gpu_free(device.gpu, &nodes);
    clast_gpu_free(device.gpu, &bounds);
    clast_gpu_free(device.gpu, &kept);
    free(list);
}

static void build(test_trees *t, clast_gpu_tree_order order)
{
    run_trees(t, order, NULL, NULL, 0);
}

static void build_and_fit(test_trees *t, clast_gpu_tree_order order, const clast_box *moved)
{
    run_trees(t, order, moved, NULL, 0);
}

static void fit_shape(test_trees *t, const void *shape, uint64_t bytes)
{
    run_trees(t, CLAST_GPU_TREE_STORED, t->boxes, shape, bytes);
}

// ------------------------------------------------------------------------------------------------------------ checking

typedef struct checker {
    const test_trees *trees;
    uint32_t tree;
    uint8_t *seen; // items
    double area;   // of nodes, halved
    uint32_t nodes, children, levels;
} checker;

static double half_area_of(const clast_box *box)
{
    double x = (double)box->upper.v[0] - (double)box->lower.v[0], y = (double)box->upper.v[1] - (double)box->lower.v[1],
           z = (double)box->upper.v[2] - (double)box->lower.v[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
}

static uint32_t byte_of(const clast_tree_node *node, uint32_t axis, uint32_t upper, uint32_t child)
{
    return node->sides[4 * axis + 2 * upper + child / 4] >> (8 * (child % 4)) & 255u;
}

// Whether a child's box holds what it must, to the last bit.
static void check_child_box(const clast_tree_node *node, uint32_t child, const clast_box *box)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        uint32_t lower = byte_of(node, axis, 0, child), upper = byte_of(node, axis, 1, child);
        if (clast_box_is_empty(box)) {
            assert_int_equal(lower, 255);
            assert_int_equal(upper, 0);
            continue;
        }
        double step = (double)power_of_two(exponent_of_axis(node->exponents, axis)), base = (double)node->lower.v[axis];
        assert_true(base + (double)lower * step <= (double)box->lower.v[axis]);
        assert_true(base + (double)upper * step >= (double)box->upper.v[axis]);
    }
}

static clast_box check_node(checker *c, uint32_t number, uint32_t level);

static clast_box check_child(checker *c, uint32_t child, uint32_t level)
{
    if ((child & CHILD_ITEM) == 0) {
        return check_node(c, child, level + 1);
    }
    uint32_t ref = (child & ~CHILD_ITEM) - c->tree, item = ref / 3;
    assert_true(ref % 3 == 0 && item < c->trees->counts[c->tree]);
    assert_int_equal(c->seen[item]++, 0);
    const clast_box *box = &c->trees->boxes[c->trees->firsts[c->tree] + item];
    return is_sound_box(box) ? *box : clast_box_empty();
}

static clast_box check_node(checker *c, uint32_t number, uint32_t level)
{
    assert_true(number < c->trees->counts[c->tree] || number == 0);
    assert_true(level < TREE_LEVELS);
    const clast_tree_node *node = &c->trees->nodes[c->trees->firsts[c->tree] + c->tree + number];
    c->levels = level + 1 > c->levels ? level + 1 : c->levels;
    c->nodes++;
    clast_box whole = clast_box_empty();
    uint32_t there = 1;
    while (there < TREE_CHILDREN && node->children[there] != node->children[0]) {
        there++;
    }
    for (uint32_t i = 0; i < TREE_CHILDREN; i++) {
        clast_box box = clast_box_empty();
        if (i < there) {
            box = check_child(c, node->children[i], level);
        } else {
            assert_int_equal(node->children[i], node->children[0]);
        }
        check_child_box(node, i, &box);
        add_box(&whole, &box);
    }
    for (int axis = 0; axis < 3; axis++) {
        assert_true(order_axis(node->exponents >> 24, (uint32_t)axis) < 3);
        assert_true(clast_box_is_empty(&whole) || node->lower.v[axis] == whole.lower.v[axis]);
    }
    c->children += there;
    c->area += half_area_of(&whole);
    return whole;
}

// Every item is reached once, every box holds what is below it. Gives what was found on the way.
static checker check_tree(const test_trees *t, uint32_t tree)
{
    checker c = {.trees = t, .tree = tree, .seen = allocate(t->counts[tree], 1)};
    clast_box whole = clast_box_empty();
    if (t->counts[tree] != 0) {
        whole = check_node(&c, 0, 0);
        for (uint32_t i = 0; i < t->counts[tree]; i++) {
            assert_int_equal(c.seen[i], 1);
        }
    }
    if (clast_box_is_empty(&whole)) {
        assert_true(clast_box_is_empty(&t->bounds[tree]));
    } else {
        assert_memory_equal(&whole, &t->bounds[tree], sizeof whole);
    }
    free(c.seen);
    return c;
}

static void check_trees(const uint32_t *counts, uint32_t count, box_maker make)
{
    for (int order = 0; order <= CLAST_GPU_TREE_SORTED; order++) {
        test_trees t = make_trees(counts, count, make);
        build(&t, (clast_gpu_tree_order)order);
        for (uint32_t i = 0; i < count; i++) {
            check_tree(&t, i);
        }
        free_trees(&t);
    }
}

// --------------------------------------------------------------------------------------------------------------- tests

static void every_item_is_reached_once_at_any_count(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 2, 7, 8, 9, 0, 63, 64, 65, 511, 512, 513, 1000, 4097, 1, 0};
    check_trees(counts, sizeof counts / sizeof *counts, make_uniform);
    const uint32_t one[] = {33000};
    check_trees(one, 1, make_uniform);
    check_trees(one, 1, make_surface);
    const uint32_t many[] = {3, 263000}; // more than two kernels of three levels can join
    check_trees(many, 2, make_surface);
}

static void boxes_may_be_alike_or_broken(void **state)
{
    (void)state;
    const box_maker makers[] = {make_equal,  make_halving,   make_chain, make_huge,
                                make_broken, make_all_empty, make_dust};
    // devices of other kinds may take numbers for zero that are as small as dust's differences
    size_t count = sizeof makers / sizeof *makers - (clast_gpu_features_of(device.gpu)->is_software ? 0 : 1);
    for (size_t i = 0; i < count; i++) {
        const uint32_t counts[] = {1, 9, 100, 3000};
        check_trees(counts, 4, makers[i]);
    }
}

static void many_small_trees_are_built_together(void **state)
{
    (void)state;
    enum { TREES = 700 };
    uint32_t counts[TREES];
    for (uint32_t i = 0; i < TREES; i++) {
        counts[i] = i % 23;
    }
    check_trees(counts, TREES, make_uniform);
}

static void no_items_make_no_tree(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 0};
    check_trees(counts, 2, make_uniform);
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_gpu_trees_build(trees, commands, NULL, 0, CLAST_GPU_TREE_SORTED));
    assert_ok(device.context, clast_gpu_finish(commands));
}

static void too_many_items_are_refused(void **state)
{
    (void)state;
    const clast_gpu_tree list[2] = {{.count = UINT32_MAX}, {.count = 5}};
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_int_equal(clast_gpu_trees_build(trees, commands, list, 2, CLAST_GPU_TREE_SORTED), CLAST_ERROR_LIMIT);
    assert_int_equal(clast_gpu_finish(commands), CLAST_ERROR_LIMIT);
}

static void trees_in_stored_order_take_what_is_told(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 8, 9, 64, 65, 513, 4097};
    test_trees t = make_trees(counts, sizeof counts / sizeof *counts, make_uniform);
    build(&t, CLAST_GPU_TREE_STORED);
    for (uint32_t i = 1; i < t.count; i++) {
        checker c = check_tree(&t, i);
        assert_int_equal(clast_gpu_tree_stored_bytes(t.counts[i]), c.nodes * sizeof(clast_tree_node));
    }
    assert_int_equal(clast_gpu_tree_stored_bytes(0), sizeof(clast_tree_node));
    free_trees(&t);
}

static void the_same_boxes_give_the_same_nodes(void **state)
{
    (void)state;
    const uint32_t counts[] = {5000, 17, 12000};
    test_trees a = make_trees(counts, 3, make_uniform), b = make_trees(counts, 3, make_uniform);
    build(&a, CLAST_GPU_TREE_SORTED);
    build(&b, CLAST_GPU_TREE_SORTED);
    assert_memory_equal(a.nodes, b.nodes, (a.items + a.count) * sizeof *a.nodes);
    free_trees(&a);
    free_trees(&b);
}

static void trees_are_fitted_to_boxes_that_moved(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 0, 8, 9, 700, 20000};
    const box_maker makers[] = {make_uniform, make_halving, make_broken};
    for (size_t k = 0; k < 2 * sizeof makers / sizeof *makers; k++) {
        test_trees t = make_trees(counts, 6, makers[k / 2]);
        clast_box *moved = allocate(t.items, sizeof *moved);
        uint64_t seed = 5;
        for (uint32_t i = 0; i < t.items; i++) {
            moved[i] = make_uniform(i, t.items, &seed);
        }
        build_and_fit(&t, (clast_gpu_tree_order)(k % 2), moved);
        memcpy(t.boxes, moved, t.items * sizeof *moved);
        for (uint32_t i = 0; i < t.count; i++) {
            check_tree(&t, i);
        }
        free(moved);
        free_trees(&t);
    }
}

static clast_tree processor_tree(const test_trees *t, clast_build how)
{
    clast_context *context = device.context;
    clast_arena arena = {clast_allocate(context, clast_tree_scratch(t->items), 1), 0};
    assert_non_null(arena.memory);
    clast_tree tree = {0};
    assert_ok(context, clast_tree_build(context, &tree, t->boxes, NULL, t->items, how, &arena));
    clast_free(context, arena.memory);
    return tree;
}

static void trees_of_the_processor_are_fitted(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 8, 9, 5000};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        test_trees t = make_trees(&counts[i], 1, make_uniform);
        clast_tree tree = processor_tree(&t, CLAST_BUILD_BEST);
        uint64_t bytes = clast_gpu_tree_shape_bytes(&tree);
        void *shape = allocate(bytes, 1);
        assert_ok(device.context, clast_gpu_tree_shape(device.context, &tree, shape));
        uint64_t seed = 77;
        for (uint32_t k = 0; k < t.items; k++) {
            t.boxes[k] = make_uniform(k, t.items, &seed);
        }
        fit_shape(&t, shape, bytes);
        checker c = check_tree(&t, 0);
        assert_int_equal(c.nodes, tree.node_count);
        clast_tree_free(device.context, &tree);
        free(shape);
        free_trees(&t);
    }
    clast_tree none = {0};
    assert_int_equal(clast_gpu_tree_shape(device.context, &none, NULL), CLAST_ERROR_UNSUPPORTED);
}

// The area of the nodes of the processor's tree.
static double processor_area(const test_trees *t, clast_build how)
{
    clast_context *context = device.context;
    clast_tree tree = processor_tree(t, how);
    double area = 0;
    for (uint32_t i = 0; i < tree.node_count; i++) {
        area += half_area_of(&tree.boxes[i]);
    }
    clast_tree_free(context, &tree);
    return area;
}

static void check_quality(const char *name, box_maker make, uint32_t count, clast_gpu_tree_order order, double most)
{
    test_trees t = make_trees(&count, 1, make);
    build(&t, order);
    checker c = check_tree(&t, 0);
    double fast = processor_area(&t, CLAST_BUILD_FAST), best = processor_area(&t, CLAST_BUILD_BEST);
    printf("%s, %u items: cost %.3f of FAST, %.3f of BEST; %.2f children a node, %u levels\n", name, count,
           c.area / fast, c.area / best, (double)c.children / c.nodes, c.levels);
    assert_true(c.area <= most * fast);
    free_trees(&t);
}

static void trees_are_about_as_good_as_the_processors(void **state)
{
    (void)state;
    check_quality("uniform, sorted", make_uniform, 20000, CLAST_GPU_TREE_SORTED, 1.3);
    check_quality("surface, sorted", make_surface, 16384, CLAST_GPU_TREE_SORTED, 1.3);
    check_quality("surface, stored", make_surface, 16384, CLAST_GPU_TREE_STORED, 1.6);
    check_quality("surface, stored", make_surface, 32768, CLAST_GPU_TREE_STORED, 1.6);
}

int main(void)
{
    device = test_device_open();
    if (clast_gpu_trees_create(device.gpu, &trees) != CLAST_OK) {
        return 1;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_reached_once_at_any_count),
        cmocka_unit_test(boxes_may_be_alike_or_broken),
        cmocka_unit_test(many_small_trees_are_built_together),
        cmocka_unit_test(no_items_make_no_tree),
        cmocka_unit_test(too_many_items_are_refused),
        cmocka_unit_test(trees_in_stored_order_take_what_is_told),
        cmocka_unit_test(the_same_boxes_give_the_same_nodes),
        cmocka_unit_test(trees_are_fitted_to_boxes_that_moved),
        cmocka_unit_test(trees_of_the_processor_are_fitted),
        cmocka_unit_test(trees_are_about_as_good_as_the_processors),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    clast_gpu_trees_destroy(trees);
    return test_device_close(&device) ? failures : 1;
}
