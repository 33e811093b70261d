// SPDX-License-Identifier: Apache-2.0
// Clusters that a device fits: the same bits as a plain loop, and boxes that hold their triangles.
#include "test.h"

#include "accel/meshes.h"
#include "vulkan/device_scene.h"
#include "vulkan/test_device.h"
#include "vulkan/topologies.h"

static test_device device;

// ---------------------------------------------------------------------------------------------------------- reference

typedef struct extent {
    vec3 lower, upper;
} extent;

static extent nothing(void)
{
    return (extent){splat3(INFINITY), splat3(-INFINITY)};
}

static void extend(extent *e, vec3 v)
{
    e->lower = min3(e->lower, v);
    e->upper = max3(e->upper, v);
}

// A pair's corners, as two triangles; gives how many these are.
static uint32_t corners_of(clast_pair pair, uint32_t corners[2][3])
{
    for (uint32_t k = 0; k < 3; k++) {
        corners[0][k] = pair_corner(pair.first, k);
        corners[1][k] = pair_corner(pair.second, k);
    }
    if (pair_is_lone(pair)) {
        return 1;
    }
    if (pair_is_fan(pair)) {
        corners[1][0] = corners[0][0];
        corners[1][1] = corners[0][2];
    }
    return 2;
}

static extent extent_of(clast_pair pair, const float *vertices, bool *unsound)
{
    extent e = nothing();
    uint32_t corners[2][3], count = corners_of(pair, corners);
    for (uint32_t t = 0; t < count; t++) {
        vec3 v[3];
        for (uint32_t k = 0; k < 3; k++) {
            const float *p = vertices + 3 * (size_t)corners[t][k];
            v[k] = vec3(p[0], p[1], p[2]);
        }
        bool sound = is_sound3(v[0]) && is_sound3(v[1]) && is_sound3(v[2]);
        *unsound = *unsound || !sound;
        for (uint32_t k = 0; sound && k < 3; k++) {
            extend(&e, v[k]);
        }
    }
    return e;
}

typedef struct fitted {
    clast_cluster_head head;
    uint32_t words[CLUSTER_NODES][12];
    clast_box box;
} fitted;

static uint32_t steps_of(const fitted *f, const extent *e, uint32_t axis, bool upper)
{
    if (!(e->lower[0] <= e->upper[0])) {
        return upper ? 0 : 255;
    }
    uint32_t exponent = exponent_of_axis(f->head.exponents, axis);
    float base = f->head.lower.v[axis];
    return (uint32_t)(upper ? box_quantise_up(e->upper[axis], base, exponent)
                            : box_quantise_down(e->lower[axis], base, exponent));
}

static void set_side(fitted *f, uint32_t node, uint32_t child, const extent *e)
{
    for (uint32_t axis = 0; axis < 3; axis++) {
        for (uint32_t upper = 0; upper < 2; upper++) {
            f->words[node][4 * axis + 2 * upper + child / 4] |= steps_of(f, e, axis, upper != 0) << (8 * (child % 4));
        }
    }
}

static uint32_t order_of(const fitted *f, uint32_t node)
{
    uint32_t sides[3];
    for (uint32_t bit = 0; bit < 3; bit++) {
        vec3 difference = splat3(0.0f);
        for (uint32_t axis = 0; axis < 3; axis++) {
            const uint32_t *w = &f->words[node][4 * axis];
            difference[axis] = centre_differences(w[0], w[1], w[2], w[3])[bit] *
                               power_of_two(exponent_of_axis(f->head.exponents, axis));
        }
        sides[bit] = side_of(difference);
    }
    return order_sides(sides[0], sides[1], sides[2]);
}

static extent extent_of_leaf(const extent *pairs, uint32_t pair_count, uint32_t shift, uint32_t leaf)
{
    extent e = nothing();
    for (uint32_t i = leaf << shift; i < (leaf + 1) << shift && i < pair_count; i++) {
        if (pairs[i].lower[0] <= pairs[i].upper[0]) {
            extend(&e, pairs[i].lower);
            extend(&e, pairs[i].upper);
        }
    }
    return e;
}

static void fit_nodes(fitted *f, const extent *pairs, uint32_t counts)
{
    uint32_t leaves = cluster_leaves(counts), nodes = cluster_nodes(counts);
    for (uint32_t i = 0; i < TREE_CHILDREN * CLUSTER_NODES; i++) {
        uint32_t node = i / TREE_CHILDREN, first = nodes > 1 ? TREE_CHILDREN : 0;
        extent e = nothing();
        if (node >= nodes) {
            continue;
        }
        if (i >= first) {
            e = i - first < leaves ? extent_of_leaf(pairs, cluster_pairs(counts), cluster_shift(counts), i - first) : e;
        } else {
            for (uint32_t k = 0; k < TREE_CHILDREN && i * TREE_CHILDREN + k < leaves; k++) {
                extent leaf = extent_of_leaf(pairs, cluster_pairs(counts), cluster_shift(counts),
                                             i * TREE_CHILDREN + k);
                if (leaf.lower[0] <= leaf.upper[0]) {
                    extend(&e, leaf.lower);
                    extend(&e, leaf.upper);
                }
            }
        }
        set_side(f, node, i % TREE_CHILDREN, &e);
    }
    for (uint32_t node = 0; node < nodes; node++) {
        f->head.orders[node / 2] |= order_of(f, node) << (16 * (node % 2));
    }
}

// Of pairs over vertices.
static fitted fit_plainly(const clast_pair *pairs, uint32_t counts, const float *vertices)
{
    fitted f = {.head.counts = counts};
    extent extents[CLAST_PAIRS_MOST], all = nothing();
    bool unsound = false;
    for (uint32_t i = 0; i < cluster_pairs(counts); i++) {
        extents[i] = extent_of(pairs[i], vertices, &unsound);
        if (extents[i].lower[0] <= extents[i].upper[0]) {
            extend(&all, extents[i].lower);
            extend(&all, extents[i].upper);
        }
    }
    f.head.counts |= unsound ? CLUSTER_UNSOUND : 0;
    bool empty = !(all.lower[0] <= all.upper[0]);
    f.box = (clast_box){store3(all.lower), store3(all.upper)};
    all.lower = empty ? splat3(0.0f) : all.lower + splat3(0.0f);
    all.upper = empty ? splat3(0.0f) : all.upper + splat3(0.0f);
    if (!empty) {
        f.box = (clast_box){store3(all.lower), store3(all.upper)};
    }
    f.head.lower = store3(all.lower);
    f.head.exponents = box_exponents(all.upper - all.lower);
    fit_nodes(&f, extents, counts);
    return f;
}

// -------------------------------------------------------------------------------------------------------------- tests

enum { CLUSTERS = 60 };

// Clusters of templates of all sorts, and vertices for them.
typedef struct sample_set {
    clast_template_set *set;
    clast_device_cluster clusters[CLUSTERS];
    float *vertices;
    uint32_t vertex_count, space;
} sample_set;

static void add_random_template(clast_template_set *set, randoms *r, uint32_t i, uint32_t *number)
{
    uint8_t indices[3 * TEMPLATE_TRIANGLES];
    float rest[3 * TEMPLATE_VERTICES];
    uint32_t triangles = i == 0 ? 1 : i == 1 ? 256 : 1 + random_below(r, 256), vertices = 1 + random_below(r, 256);
    for (uint32_t k = 0; k < 3 * triangles; k++) {
        indices[k] = (uint8_t)random_below(r, vertices);
    }
    for (uint32_t k = 0; k < 3 * vertices; k++) {
        rest[k] = random_between(r, -1, 1);
    }
    clast_template_desc desc = {triangles, vertices, indices, i % 2 == 0 ? rest : NULL};
    assert_ok(device.context, clast_template_set_add(set, &desc, 1, number));
}

static void add_grid_template(clast_template_set *set, randoms *r, uint32_t *number)
{
    assert_ok(device.context,
              clast_template_set_add_grid(set, 1 + random_below(r, 11), 1 + random_below(r, 11), number));
}

// Soups, flat ones, tiny and huge ones, those with vertices that are no numbers, and those with nothing else.
static float coordinate(randoms *r, uint32_t kind, uint32_t axis)
{
    float x = random_between(r, -1, 1);
    switch (kind % 8) {
    case 1: return axis == 2 ? 0.0f : x;
    case 2: return x * 1e-15f;
    case 3: return x * 1e18f + 1e18f;
    case 4: return random_below(r, 40) == 0 ? NAN : random_below(r, 40) == 0 ? INFINITY : x;
    case 5: return random_below(r, 2) == 0 ? 1e37f : x;
    case 6: return axis == 0 ? -0.0f : 0.0f;
    case 7: return kind < 16 ? NAN : x + 1e6f;
    default: return x;
    }
}

static sample_set make_samples(uint64_t seed)
{
    sample_set s = {.vertices = malloc(CLUSTERS * (size_t)TEMPLATE_VERTICES * 12)};
    randoms r = {seed};
    assert_ok(device.context, clast_template_set_create(device.context, &s.set));
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        uint32_t number;
        if (i % 3 == 0) {
            add_grid_template(s.set, &r, &number);
        } else {
            add_random_template(s.set, &r, i - 1, &number);
        }
        s.clusters[i] = (clast_device_cluster){number, s.vertex_count, s.space};
        for (uint32_t k = 0; k < 3 * clast_template_vertex_count(s.set, number); k++) {
            s.vertices[3 * s.vertex_count + k] = coordinate(&r, i, k % 3);
        }
        s.vertex_count += clast_template_vertex_count(s.set, number);
        s.space += cluster_space(triangles_counts(clast_template_triangle_count(s.set, number)), false);
    }
    return s;
}

static void free_samples(sample_set *s)
{
    clast_template_set_destroy(s->set);
    free(s->vertices);
}

// What a device made of them.
typedef struct results {
    uint8_t *clusters;
    clast_box boxes[CLUSTERS];
    float *vertices;
    uint32_t fault;
} results;

static void free_results(results *r)
{
    free(r->clusters);
    free(r->vertices);
}

// Fits samples, with vertices as they are, or from shared ones by numbers.
static results fit_samples(const sample_set *s, const float *positions, uint32_t position_count,
                           const uint32_t *numbers)
{
    results out = {.clusters = calloc(s->space, CLUSTER_UNIT), .vertices = calloc(s->vertex_count, 12)};
    clast_topologies topologies = {0};
    clast_gpu_buffer inputs = {0}, vertices = {0}, clusters = {0}, boxes = {0}, shared = {0}, indices = {0},
                     fault = {0};
    clast_gpu_commands *commands;
    assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
    assert_ok(device.context, clast_topologies_update(&topologies, commands, s->set));
    assert_ok(device.context, device_upload(commands, s->clusters, sizeof s->clusters, &inputs));
    assert_ok(device.context, device_upload(commands, s->vertices, (size_t)s->vertex_count * 12, &vertices));
    assert_ok(device.context, device_upload(commands, out.clusters, (size_t)s->space * CLUSTER_UNIT, &clusters));
    assert_ok(device.context, device_upload(commands, out.boxes, sizeof out.boxes, &boxes));
    assert_ok(device.context, device_upload(commands, &out.fault, sizeof out.fault, &fault));
    assert_ok(device.context, device_upload(commands, positions, (size_t)position_count * 12, &shared));
    assert_ok(device.context, device_upload(commands, numbers, numbers != NULL ? s->vertex_count * 4 : 0, &indices));
    clast_gpu_barrier(commands);
    clast_gpu_fit_clusters(commands, &(clast_gpu_fit){.templates = topologies.templates.address,
                                                      .inputs = inputs.address,
                                                      .vertices = vertices.address,
                                                      .clusters = clusters.address,
                                                      .boxes = boxes.address,
                                                      .positions = numbers != NULL ? shared.address : 0,
                                                      .numbers = indices.address,
                                                      .faults = fault.address,
                                                      .position_count = position_count,
                                                      .count = CLUSTERS});
    clast_gpu_read(commands, &clusters, 0, out.clusters, (size_t)s->space * CLUSTER_UNIT);
    clast_gpu_read(commands, &boxes, 0, out.boxes, sizeof out.boxes);
    clast_gpu_read(commands, &vertices, 0, out.vertices, (size_t)s->vertex_count * 12);
    clast_gpu_read(commands, &fault, 0, &out.fault, sizeof out.fault);
    assert_ok(device.context, clast_gpu_finish(commands));
    clast_gpu_buffer *const all[] = {&inputs, &vertices, &clusters, &boxes, &shared, &indices, &fault};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) {
        clast_gpu_free(device.gpu, all[i]);
    }
    clast_topologies_free(device.gpu, &topologies);
    return out;
}

static void assert_fitted_plainly(const sample_set *s, const results *r, uint32_t i, const float *vertices)
{
    const clast_template *topology = s->set->templates[s->clusters[i].template_number];
    uint32_t counts = triangles_counts(topology->triangle_count);
    clast_pair pairs[CLAST_PAIRS_MOST];
    clast_pairs_of_template(topology, pairs);
    fitted wanted = fit_plainly(pairs, counts, vertices + 3 * (size_t)s->clusters[i].first_vertex);
    const uint8_t *made = r->clusters + (size_t)s->clusters[i].place * CLUSTER_UNIT;
    clast_cluster_head head;
    memcpy(&head, made, sizeof head);
    assert_memory_equal(&head.lower, &wanted.head.lower, sizeof head.lower);
    assert_int_equal(head.exponents, wanted.head.exponents);
    assert_int_equal(head.cluster, i);
    assert_int_equal(head.counts, wanted.head.counts);
    assert_memory_equal(made + CLUSTER_HEAD_BYTES, wanted.words, (size_t)cluster_nodes(counts) * CLUSTER_NODE_BYTES);
    assert_memory_equal(head.orders, wanted.head.orders, sizeof head.orders);
    assert_memory_equal(&r->boxes[i], &wanted.box, sizeof wanted.box);
}

static void boxes_are_those_of_a_plain_loop(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        sample_set s = make_samples(seed);
        results r = fit_samples(&s, NULL, 0, NULL);
        for (uint32_t i = 0; i < CLUSTERS; i++) {
            assert_fitted_plainly(&s, &r, i, s.vertices);
        }
        free_results(&r);
        free_samples(&s);
    }
}

// Each triangle lies in the box of its leaf, and of the node above, decoded in real numbers.
static void boxes_hold_their_triangles(void **state)
{
    (void)state;
    sample_set s = make_samples(9);
    results r = fit_samples(&s, NULL, 0, NULL);
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        const clast_template *topology = s.set->templates[s.clusters[i].template_number];
        uint32_t counts = triangles_counts(topology->triangle_count), nodes = cluster_nodes(counts);
        const uint8_t *made = r.clusters + (size_t)s.clusters[i].place * CLUSTER_UNIT;
        const uint8_t *sides = made + CLUSTER_HEAD_BYTES;
        clast_cluster_head head;
        memcpy(&head, made, sizeof head);
        clast_pair pairs[CLAST_PAIRS_MOST];
        clast_pairs_of_template(topology, pairs);
        for (uint32_t p = 0; p < cluster_pairs(counts); p++) {
            bool unsound = false;
            extent e = extent_of(pairs[p], s.vertices + 3 * (size_t)s.clusters[i].first_vertex, &unsound);
            uint32_t leaf = p >> cluster_shift(counts);
            for (uint32_t axis = 0; axis < 3 && e.lower[0] <= e.upper[0]; axis++) {
                double step = ldexp(1.0, (int)exponent_of_axis(head.exponents, axis) - 127), base = head.lower.v[axis];
                const uint8_t *in_leaf = sides + (nodes > 1 ? 1 + leaf / 8 : 0) * CLUSTER_NODE_BYTES + 16 * axis +
                                         leaf % 8;
                const uint8_t *in_root = sides + 16 * axis + (nodes > 1 ? leaf / 8 : leaf % 8);
                assert_true(base + in_leaf[0] * step <= (double)e.lower[axis]);
                assert_true(base + in_leaf[8] * step >= (double)e.upper[axis]);
                assert_true(in_root[0] <= in_leaf[0] && in_root[8] >= in_leaf[8]);
            }
        }
    }
    free_results(&r);
    free_samples(&s);
}

static void every_triangle_is_in_one_pair(void **state)
{
    (void)state;
    sample_set s = make_samples(3);
    for (uint32_t n = 0; n < clast_template_set_count(s.set); n++) {
        const clast_template *topology = s.set->templates[n];
        uint32_t counts = triangles_counts(topology->triangle_count), seen[TEMPLATE_TRIANGLES] = {0};
        clast_pair pairs[CLAST_PAIRS_MOST];
        clast_pairs_of_template(topology, pairs);
        assert_true(cluster_leaves(counts) <= 64 && cluster_nodes(counts) <= CLUSTER_NODES);
        for (uint32_t p = 0; p < cluster_pairs(counts); p++) {
            uint32_t corners[2][3], count = corners_of(pairs[p], corners);
            const uint32_t turns[2] = {pair_is_fan(pairs[p]) ? pair_first_turn(pairs[p]) : 0,
                                       pair_is_fan(pairs[p]) ? pair_second_turn(pairs[p]) : 0};
            for (uint32_t t = 0; t < count; t++) {
                uint32_t triangle = (t == 0 ? pairs[p].first : pairs[p].second) >> 24, wanted[3];
                clast_template_triangle(s.set, n, triangle, wanted);
                seen[triangle]++;
                for (uint32_t k = 0; k < 3; k++) {
                    assert_int_equal(corners[t][(k + turns[t]) % 3], wanted[k]);
                }
            }
        }
        for (uint32_t t = 0; t < topology->triangle_count; t++) {
            uint32_t c[3];
            clast_template_triangle(s.set, n, t, c);
            bool point = c[0] == c[1] || c[1] == c[2] || c[2] == c[0]; // may be left out
            assert_true(seen[t] == 1 || (point && seen[t] == 0));
        }
    }
    free_samples(&s);
}

// Nearly all triangles of grids and of meshes share their pair with a neighbour.
static void neighbours_become_pairs(void **state)
{
    (void)state;
    clast_template_set *set;
    assert_ok(device.context, clast_template_set_create(device.context, &set));
    for (uint32_t side = 1; side <= 11; side++) {
        uint32_t number;
        assert_ok(device.context, clast_template_set_add_grid(set, side, 12 - side, &number));
        clast_pair pairs[CLAST_PAIRS_MOST];
        clast_pairs_of_template(set->templates[number], pairs);
        for (uint32_t p = 0; p < side * (12 - side); p++) {
            assert_true(pair_is_fan(pairs[p]) && !pair_is_lone(pairs[p]));
            assert_int_equal((pairs[p].first ^ pairs[p].second) >> 24, 1); // a quad
        }
    }
    clast_template_set_destroy(set);
}

static void shared_vertices_are_gathered_first(void **state)
{
    (void)state;
    sample_set s = make_samples(4);
    float positions[3 * 1000];
    uint32_t *numbers = malloc(s.vertex_count * sizeof *numbers);
    randoms r = {77};
    for (size_t i = 0; i < sizeof positions / sizeof *positions; i++) {
        positions[i] = random_between(&r, -5, 5);
    }
    for (uint32_t i = 0; i < s.vertex_count; i++) {
        numbers[i] = random_below(&r, 1000);
    }
    float *gathered = malloc((size_t)s.vertex_count * 12);
    for (uint32_t i = 0; i < s.vertex_count; i++) {
        memcpy(gathered + 3 * (size_t)i, positions + 3 * (size_t)numbers[i], 12);
    }
    results made = fit_samples(&s, positions, 1000, numbers);
    assert_int_equal(made.fault, 0);
    assert_memory_equal(made.vertices, gathered, (size_t)s.vertex_count * 12);
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        assert_fitted_plainly(&s, &made, i, gathered);
    }
    free_results(&made);
    numbers[s.clusters[7].first_vertex] = 1000; // one too far
    made = fit_samples(&s, positions, 1000, numbers);
    assert_int_equal(made.fault, 1);
    uint8_t zeros[CLUSTER_HEAD_BYTES] = {0};
    assert_memory_equal(made.clusters + (size_t)s.clusters[7].place * CLUSTER_UNIT, zeros, sizeof zeros);
    assert_fitted_plainly(&s, &made, 6, gathered);
    assert_fitted_plainly(&s, &made, 8, gathered);
    free_results(&made);
    free(numbers);
    free(gathered);
    free_samples(&s);
}

// The device's set grows with the processor's, and starts anew with another.
static void topologies_follow_their_set(void **state)
{
    (void)state;
    clast_topologies topologies = {0};
    randoms r = {5};
    for (uint32_t set_number = 0; set_number < 2; set_number++) {
        clast_template_set *set;
        assert_ok(device.context, clast_template_set_create(device.context, &set));
        for (uint32_t round = 0, number; round < 5; round++) {
            for (uint32_t i = 0; i < 1 + 10 * round; i++) {
                add_random_template(set, &r, 2 + i, &number);
            }
            clast_gpu_commands *commands;
            uint32_t count = clast_template_set_count(set);
            clast_device_template *back = malloc(count * sizeof *back);
            assert_ok(device.context, clast_gpu_begin(device.gpu, &commands));
            assert_ok(device.context, clast_topologies_update(&topologies, commands, set));
            clast_gpu_read(commands, &topologies.templates, 0, back, count * sizeof *back);
            assert_ok(device.context, clast_gpu_finish(commands));
            assert_int_equal(topologies.count, count);
            for (uint32_t i = 0; i < count; i++) {
                assert_int_equal(back[i].counts, triangles_counts(clast_template_triangle_count(set, i)));
                assert_int_equal(back[i].vertices, clast_template_vertex_count(set, i));
                assert_true(load_address(back[i].pairs) != 0 && load_address(back[i].pairs) % 8 == 0);
            }
            free(back);
        }
        if (set_number == 1) {
            clast_topologies_free(device.gpu, &topologies);
        } else {
            topologies.set = NULL; // about to be destroyed
        }
        clast_template_set_destroy(set);
    }
}

int main(void)
{
    device = test_device_open();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_are_those_of_a_plain_loop),    cmocka_unit_test(boxes_hold_their_triangles),
        cmocka_unit_test(every_triangle_is_in_one_pair),      cmocka_unit_test(neighbours_become_pairs),
        cmocka_unit_test(shared_vertices_are_gathered_first), cmocka_unit_test(topologies_follow_their_set),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    return test_device_close(&device) ? failed : 1;
}
