// SPDX-License-Identifier: Apache-2.0
// Instances that move, vanish, appear and change: an updated tree answers as one built from what is there now.
#include "test.h"

#include "accel/meshes.h"
#include "accel/structures.h"

enum { INSTANCES = 300, KINDS = 3 };

typedef struct stage {
    mesh meshes[KINDS];
    clustered c[KINDS];
    clast_tlas_instance instances[INSTANCES];
    clast_tlas *tlas;
    randoms r;
} stage;

static clast_tlas_instance random_instance(stage *s, uint32_t id)
{
    clast_tlas_instance instance = instance_of(s->c[random_below(&s->r, KINDS)].blas, id);
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            instance.transform[i][k] = random_between(&s->r, -0.3f, 0.3f) + (i == k ? 0.5f : 0.0f);
        }
        instance.transform[i][3] = random_between(&s->r, -8, 8);
    }
    uint32_t kind = random_below(&s->r, 10);
    if (kind == 0) {
        instance.blas = NULL;
    } else if (kind == 1) {
        memset(instance.transform[1], 0, sizeof instance.transform[1]); // flat
    } else if (kind == 2) {
        instance.transform[0][3] = NAN;
    }
    return instance;
}

static void stage_begin(clast_context *context, stage *s)
{
    s->r = (randoms){5};
    s->meshes[0] = mesh_octasphere(2);
    s->meshes[1] = mesh_torus(16, 8, 1.0f, 0.3f);
    s->meshes[2] = mesh_soup(50, 0.3f, 1);
    for (int i = 0; i < KINDS; i++) {
        assert_ok(context, clustered_make(context, &s->meshes[i], 64, &s->c[i]));
    }
    for (uint32_t i = 0; i < INSTANCES; i++) {
        s->instances[i] = random_instance(s, i);
    }
    assert_ok(context, clast_tlas_create(context, &s->tlas));
    assert_ok(context, clast_tlas_build(s->tlas, s->instances, INSTANCES, CLAST_BUILD_BEST));
}

static void stage_end(stage *s)
{
    clast_tlas_destroy(s->tlas);
    for (int i = 0; i < KINDS; i++) {
        clustered_free(&s->c[i]);
        mesh_free(&s->meshes[i]);
    }
}

static clast_ray random_ray(randoms *r)
{
    return (clast_ray){{random_between(r, -9, 9), random_between(r, -9, 9), random_between(r, -9, 9)},
                       0,
                       {random_between(r, -1, 1), random_between(r, -1, 1), random_between(r, -1, 1)},
                       INFINITY};
}

static void assert_answers_as_built(clast_context *context, stage *s)
{
    clast_tlas *fresh;
    assert_ok(context, clast_tlas_create(context, &fresh));
    assert_ok(context, clast_tlas_build(fresh, s->instances, INSTANCES, CLAST_BUILD_BEST));
    uint32_t hits = 0;
    for (int i = 0; i < 300; i++) {
        clast_ray ray = random_ray(&s->r);
        clast_hit hit[2];
        memset(hit, 0, sizeof hit);
        clast_trace_closest(s->tlas, &ray, 1, NULL, &hit[0]);
        clast_trace_closest(fresh, &ray, 1, NULL, &hit[1]);
        assert_int_equal(hit[0].instance, hit[1].instance);
        if (hit[0].instance != CLAST_NONE) {
            hit[0].steps = hit[1].steps = 0; // the trees differ
            assert_memory_equal(&hit[0], &hit[1], sizeof hit[0]);
            hits++;
        }
    }
    assert_true(hits > 30);
    float bounds[4][3];
    clast_tlas_bounds(s->tlas, bounds[0], bounds[1]);
    clast_tlas_bounds(fresh, bounds[2], bounds[3]);
    assert_memory_equal(bounds[0], bounds[2], sizeof bounds / 2);
    clast_tlas_destroy(fresh);
}

// Changes some instances, each once, in any order.
static void change_some(clast_context *context, stage *s, uint32_t count)
{
    uint32_t numbers[INSTANCES];
    clast_tlas_instance changed[INSTANCES];
    for (uint32_t i = 0; i < INSTANCES; i++) {
        numbers[i] = i;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t other = i + random_below(&s->r, INSTANCES - i), number = numbers[other];
        numbers[other] = numbers[i];
        numbers[i] = number;
        changed[i] = s->instances[number] = random_instance(s, number);
    }
    assert_ok(context, clast_tlas_update(s->tlas, numbers, changed, count));
}

static void updated_trees_answer_as_built_ones(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    const uint32_t counts[] = {1, 2, 5, 20, 74, 75, 200, 300, 0, 1, 60};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        change_some(context, &s, counts[i]);
        assert_answers_as_built(context, &s);
    }
    stage_end(&s);
}

static void updating_all_needs_no_numbers(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        s.instances[i] = random_instance(&s, i);
    }
    assert_ok(context, clast_tlas_update(s.tlas, NULL, s.instances, INSTANCES));
    assert_answers_as_built(context, &s);
    stage_end(&s);
}

// Few are followed up the tree, many are not: the same boxes either way.
static void following_what_moved_gives_the_boxes_of_fitting_all(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    clast_tlas *other;
    assert_ok(context, clast_tlas_create(context, &other));
    assert_ok(context, clast_tlas_build(other, s.instances, INSTANCES, CLAST_BUILD_BEST));
    for (uint32_t i = 0; i < 20; i++) {
        change_some(context, &s, 1 + 3 * i);
        assert_ok(context, clast_tlas_update(other, NULL, s.instances, INSTANCES));
        assert_memory_equal(s.tlas->tree.nodes, other->tree.nodes, s.tlas->tree.node_count * sizeof(clast_node));
        assert_memory_equal(s.tlas->tree.boxes, other->tree.boxes, s.tlas->tree.node_count * sizeof(clast_box));
    }
    clast_tlas_destroy(other);
    stage_end(&s);
}

static void everything_may_vanish_and_appear(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    clast_tlas_instance nothing[INSTANCES];
    memcpy(nothing, s.instances, sizeof nothing);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        nothing[i].blas = NULL;
    }
    for (int begin = 0; begin < 2; begin++) { // all at once, and in an empty build
        if (begin == 0) {
            assert_ok(context, clast_tlas_update(s.tlas, NULL, nothing, INSTANCES));
        } else {
            assert_ok(context, clast_tlas_build(s.tlas, nothing, INSTANCES, CLAST_BUILD_FAST));
        }
        float lower[3], upper[3];
        clast_tlas_bounds(s.tlas, lower, upper);
        assert_true(lower[0] > upper[0]);
        clast_ray ray = random_ray(&s.r);
        clast_hit hit;
        clast_trace_closest(s.tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, CLAST_NONE);
        for (uint32_t i = 0; i < INSTANCES; i++) { // one by one
            assert_ok(context, clast_tlas_update(s.tlas, &i, &s.instances[i], 1));
        }
        assert_answers_as_built(context, &s);
    }
    stage_end(&s);
}

static void a_single_instance_may_vanish(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    clast_tlas_instance there = instance_of(s.c[0].blas, 4), gone = instance_of(NULL, 4);
    clast_ray ray = {{0, 0, 5}, 0, {0, 0, -1}, INFINITY};
    clast_hit hit;
    assert_ok(context, clast_tlas_build(s.tlas, &there, 1, CLAST_BUILD_BEST));
    for (int i = 0; i < 3; i++) {
        assert_ok(context, clast_tlas_update(s.tlas, NULL, &gone, 1));
        clast_trace_closest(s.tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, CLAST_NONE);
        assert_ok(context, clast_tlas_update(s.tlas, NULL, &there, 1));
        clast_trace_closest(s.tlas, &ray, 1, NULL, &hit);
        assert_int_equal(hit.instance, 4);
    }
    stage_end(&s);
}

static void what_cannot_be_is_refused_and_changes_nothing(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    clast_tlas_instance two[2] = {instance_of(s.c[0].blas, 1), instance_of(s.c[1].blas, 2)};
    const uint32_t beyond[2] = {3, INSTANCES}, twice[2] = {7, 7}, good[2] = {3, 4};
    assert_int_equal(clast_tlas_update(s.tlas, beyond, two, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_tlas_update(s.tlas, twice, two, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "7"));
    assert_int_equal(clast_tlas_update(s.tlas, NULL, s.instances, INSTANCES + 1), CLAST_ERROR_INVALID_ARGUMENT);
    two[1].id = CLAST_NONE;
    assert_int_equal(clast_tlas_update(s.tlas, good, two, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_tlas_update(s.tlas, good, NULL, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_tlas_update(NULL, good, two, 2), CLAST_ERROR_INVALID_ARGUMENT);
    assert_answers_as_built(context, &s);
    for (size_t i = 0; i < (INSTANCES + 63) / 64; i++) {
        assert_int_equal(s.tlas->marks[i], 0);
    }
    stage_end(&s);
}

// What boxes are widened by: never less than the worst map needs, and all of the others' as long as they stay.
static void the_worst_map_is_remembered(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    for (uint32_t i = 0; i < INSTANCES; i++) {
        s.instances[i] = instance_of(s.c[0].blas, i);
    }
    assert_ok(context, clast_tlas_build(s.tlas, s.instances, INSTANCES, CLAST_BUILD_BEST));
    assert_true(s.tlas->spread < 10.0f);
    clast_tlas_instance bad = s.instances[9], good = s.instances[9];
    bad.transform[0][1] = 1000.0f; // a shear
    const uint32_t nine = 9, ten = 10;
    assert_ok(context, clast_tlas_update(s.tlas, &nine, &bad, 1));
    float spread = s.tlas->spread;
    assert_true(spread > 1000.0f);
    assert_ok(context, clast_tlas_update(s.tlas, &ten, &s.instances[10], 1));
    assert_true(s.tlas->spread == spread);
    s.instances[9] = good;
    assert_ok(context, clast_tlas_update(s.tlas, NULL, s.instances, INSTANCES));
    assert_true(s.tlas->spread < 10.0f);
    stage_end(&s);
}

static void threads_change_no_bit(void **state)
{
    (void)state;
    enum { MANY = 20000 };
    clast_tlas_instance *instances = calloc(MANY, sizeof *instances);
    uint32_t *numbers = calloc(MANY, sizeof *numbers);
    mesh m = mesh_octasphere(1);
    clast_context *contexts[2];
    clustered c[2];
    clast_tlas *tlas[2];
    for (int k = 0; k < 2; k++) {
        randoms r = {8};
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1 + 3 * (uint32_t)k}, &contexts[k]),
                         CLAST_OK);
        assert_ok(contexts[k], clustered_make(contexts[k], &m, 64, &c[k]));
        assert_ok(contexts[k], clast_tlas_create(contexts[k], &tlas[k]));
        for (uint32_t i = 0; i < MANY; i++) {
            instances[i] = instance_of(c[k].blas, i);
            for (int axis = 0; axis < 3; axis++) {
                instances[i].transform[axis][3] = random_between(&r, -50, 50);
            }
        }
        assert_ok(contexts[k], clast_tlas_build(tlas[k], instances, MANY, CLAST_BUILD_BEST));
        for (uint32_t step = 0; step < 5; step++) {
            uint32_t count = 0;
            for (uint32_t i = step; i < MANY; i += 1 + random_below(&r, 12 + step)) {
                numbers[count] = i;
                instances[count] = instance_of(c[k].blas, i);
                instances[count++].transform[0][3] = random_between(&r, -60, 60);
            }
            assert_ok(contexts[k], clast_tlas_update(tlas[k], numbers, instances, count));
        }
    }
    assert_int_equal(tlas[0]->tree.node_count, tlas[1]->tree.node_count);
    assert_memory_equal(tlas[0]->tree.nodes, tlas[1]->tree.nodes, tlas[0]->tree.node_count * sizeof(clast_node));
    for (int k = 0; k < 2; k++) {
        clast_tlas_destroy(tlas[k]);
        clustered_free(&c[k]);
        clast_context_destroy(contexts[k]);
    }
    mesh_free(&m);
    free(instances);
    free(numbers);
}

// Where a BLAS lies is the only thing that may differ.
static void assert_same_placements(const clast_tlas *a, const clast_tlas *b)
{
    for (uint32_t i = 0; i < a->placement_count; i++) {
        clast_placement one = a->placements[i], other = b->placements[i];
        assert_int_equal(one.blas != NULL, other.blas != NULL);
        one.blas = other.blas = NULL;
        assert_memory_equal(&one, &other, offsetof(clast_placement, is_identity) + 1); // and a gap
    }
    assert_memory_equal(a->boxes, b->boxes, a->placement_count * sizeof *a->boxes);
    assert_memory_equal(a->tree.nodes, b->tree.nodes, a->tree.node_count * sizeof *a->tree.nodes);
    assert_true(a->spread == b->spread);
}

static void instruction_sets_change_no_bit(void **state)
{
    stage plain, s;
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.isa = CLAST_ISA_PLAIN}, &context), CLAST_OK);
    stage_begin(context, &plain);
#define COMPARE(name, value, text) \
    clast_context *context_##name; \
    if (clast_context_create(&(clast_context_desc){.isa = name}, &context_##name) == CLAST_OK) { \
        stage_begin(context_##name, &s); \
        assert_same_placements(s.tlas, plain.tlas); \
        for (uint32_t count = 1; count < 20; count++) { \
            plain.r = s.r = (randoms){count}; \
            change_some(context_##name, &s, count); \
            change_some(context, &plain, count); \
            assert_same_placements(s.tlas, plain.tlas); \
        } \
        stage_end(&s); \
        stage_end(&plain); \
        stage_begin(context, &plain); \
        clast_context_destroy(context_##name); \
    }
    CLAST_ISA_LIST(COMPARE)
    stage_end(&plain);
    clast_context_destroy(context);
    (void)state;
}

// What the map's condition number says of hits beside their boxes is true: points of the object's box, mapped exactly, lie
// in the box in the world.
static void boxes_hold_what_they_place(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    uint32_t seen = 0;
    for (uint32_t i = 0; i < INSTANCES; i++) {
        const clast_tlas_instance *instance = &s.instances[i];
        if (s.tlas->placements[i].blas == NULL) {
            assert_true(s.tlas->boxes[i].lower.v[0] > s.tlas->boxes[i].upper.v[0]);
            continue;
        }
        clast_box object = s.tlas->placements[i].blas->tree.boxes[0], world = s.tlas->boxes[i];
        for (uint32_t corner = 0; corner < 8; corner++) {
            for (int axis = 0; axis < 3; axis++) {
                double x = (double)instance->transform[axis][3];
                for (int k = 0; k < 3; k++) {
                    x += (double)instance->transform[axis][k] *
                         (double)((corner >> k & 1) != 0 ? object.upper.v[k] : object.lower.v[k]);
                }
                assert_true((double)world.lower.v[axis] < x && (double)world.upper.v[axis] > x);
            }
        }
        seen++;
    }
    assert_true(seen > INSTANCES / 2);
    stage_end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(updated_trees_answer_as_built_ones),
        CONTEXT_TEST(updating_all_needs_no_numbers),
        CONTEXT_TEST(following_what_moved_gives_the_boxes_of_fitting_all),
        CONTEXT_TEST(everything_may_vanish_and_appear),
        CONTEXT_TEST(a_single_instance_may_vanish),
        CONTEXT_TEST(what_cannot_be_is_refused_and_changes_nothing),
        CONTEXT_TEST(the_worst_map_is_remembered),
        cmocka_unit_test(threads_change_no_bit),
        CONTEXT_TEST(instruction_sets_change_no_bit),
        CONTEXT_TEST(boxes_hold_what_they_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
