// SPDX-License-Identifier: Apache-2.0
#include "test.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#include "base/thread.h"

enum { COUNT = 100003, GRAIN = 1000, WORKERS_MOST = 16 };

typedef struct visits {
    clast_context *context;
    atomic_uint *seen;
    atomic_uint wrong;
    atomic_uint running[WORKERS_MOST];
    size_t grain;
} visits;

static void visit(void *data, size_t begin, size_t end, uint32_t worker)
{
    visits *v = data;
    bool fits = worker < clast_worker_count(v->context) && begin % v->grain == 0 && begin < end &&
                end - begin <= v->grain;
    if (!fits || atomic_fetch_add(&v->running[worker], 1) != 0) {
        atomic_fetch_add(&v->wrong, 1);
        return;
    }
    for (size_t i = begin; i < end; i++) {
        atomic_fetch_add(&v->seen[i], 1);
    }
    atomic_fetch_sub(&v->running[worker], 1);
}

static void visit_all(clast_context *context, size_t count, size_t grain)
{
    visits v = {.context = context, .seen = calloc(count + 1, sizeof *v.seen), .grain = grain != 0 ? grain : 1};
    clast_parallel_for(context, count, grain, visit, &v);
    assert_int_equal(atomic_load(&v.wrong), 0);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(atomic_load(&v.seen[i]), 1);
    }
    free(v.seen);
}

static clast_context *context_of(uint32_t threads)
{
    clast_context *context = NULL;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads}, &context), CLAST_OK);
    return context;
}

// With chunks that begin where the grain says, and workers that no two threads share.
static void every_element_is_visited_once(void **state)
{
    (void)state;
    static const uint32_t threads[] = {1, 2, 5, 16};
    for (size_t t = 0; t < 4; t++) {
        clast_context *context = context_of(threads[t]);
        assert_int_equal(clast_worker_count(context), threads[t]);
        visit_all(context, COUNT, GRAIN);
        visit_all(context, GRAIN, GRAIN);
        visit_all(context, GRAIN + 1, GRAIN);
        visit_all(context, 1, 7);
        visit_all(context, 0, 7);
        visit_all(context, 300, 0);
        visit_all(context, 5, SIZE_MAX);
        clast_context_destroy(context);
    }
}

static void many_short_jobs_follow_each_other(void **state)
{
    (void)state;
    clast_context *context = context_of(4);
    for (int i = 0; i < 2000; i++) {
        visit_all(context, 8, 1);
    }
    clast_context_destroy(context);
}

// ------------------------------------------------------------------------------------------------------------- nested

typedef struct nest {
    clast_context *context;
    atomic_uint sum;
} nest;

static void add_inside(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    nest *n = data;
    atomic_fetch_add(&n->sum, (unsigned)(end - begin));
}

static void call_inside(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    nest *n = data;
    for (size_t i = begin; i < end; i++) {
        clast_parallel_for(n->context, 100, 10, add_inside, n);
    }
}

static void a_call_from_inside_runs_to_its_end(void **state)
{
    nest n = {.context = *state};
    clast_parallel_for(*state, 50, 1, call_inside, &n);
    assert_int_equal(atomic_load(&n.sum), 5000);
}

// ------------------------------------------------------------------------------------------------- several callers

static void *call_from_outside(void *data)
{
    nest *n = data;
    for (int i = 0; i < 200; i++) {
        clast_parallel_for(n->context, 100, 10, add_inside, n);
    }
    return NULL;
}

static void call_from_three_threads(clast_context *contexts[3])
{
    nest nests[3] = {{contexts[0], 0}, {contexts[1], 0}, {contexts[2], 0}};
    pthread_t threads[3];
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(pthread_create(&threads[i], NULL, call_from_outside, &nests[i]), 0);
    }
    for (size_t i = 0; i < 3; i++) {
        pthread_join(threads[i], NULL);
        assert_int_equal(atomic_load(&nests[i].sum), 20000);
    }
}

static void several_threads_may_call_at_once(void **state)
{
    clast_context *same[3] = {*state, *state, *state};
    call_from_three_threads(same);
}

static void contexts_work_beside_each_other(void **state)
{
    (void)state;
    clast_context *different[3] = {context_of(2), context_of(3), context_of(1)};
    call_from_three_threads(different);
    for (size_t i = 0; i < 3; i++) {
        clast_context_destroy(different[i]);
    }
}

// What the workers wrote is seen by the caller, and what the caller wrote by the workers, without further locks.
static void write_squares(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    uint64_t *numbers = data;
    for (size_t i = begin; i < end; i++) {
        numbers[i] = numbers[i] * numbers[i];
    }
}

static void plain_memory_is_handed_over(void **state)
{
    uint64_t *numbers = malloc(COUNT * sizeof *numbers);
    for (int round = 0; round < 20; round++) {
        for (size_t i = 0; i < COUNT; i++) {
            numbers[i] = i + (size_t)round;
        }
        clast_parallel_for(*state, COUNT, GRAIN, write_squares, numbers);
        for (size_t i = 0; i < COUNT; i++) {
            assert_int_equal(numbers[i], (i + (size_t)round) * (i + (size_t)round));
        }
    }
    free(numbers);
}

static void the_clock_goes_forwards(void **state)
{
    (void)state;
    double before = clast_clock();
    for (int i = 0; i < 1000; i++) {
        double now = clast_clock();
        assert_true(now >= before);
        before = now;
    }
    assert_true(clast_process_memory_peak() > 0);
    assert_in_range(clast_processor_count(), 1, 1024);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_element_is_visited_once),   cmocka_unit_test(many_short_jobs_follow_each_other),
        CONTEXT_TEST(a_call_from_inside_runs_to_its_end),  CONTEXT_TEST(several_threads_may_call_at_once),
        cmocka_unit_test(contexts_work_beside_each_other), CONTEXT_TEST(plain_memory_is_handed_over),
        cmocka_unit_test(the_clock_goes_forwards),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
