// SPDX-License-Identifier: Apache-2.0
// Memory that is known beforehand: what was reserved is enough, the caller's is used, and nothing is allocated while things move.
#include "test.h"

#include "accel/meshes.h"

// Counts what is asked of the allocator.
typedef struct tap {
    uint32_t calls;
    int64_t held;
} tap;

static void *tapped(void *user, void *pointer, size_t old_size, size_t new_size)
{
    tap *t = user;
    t->calls++;
    t->held += (int64_t)new_size - (int64_t)(pointer != NULL ? old_size : 0);
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    return realloc(pointer, new_size);
}

enum { INSTANCES = 500, GRID = 8, GRID_VERTICES = 81, CLUSTERS = 150 };

typedef struct stage {
    tap tap;
    clast_context *context;
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_tlas *tlas;
    clast_clas_input inputs[CLUSTERS];
    float (*vertices)[GRID_VERTICES][3];
    clast_tlas_instance instances[INSTANCES];
} stage;

static void move_vertices(stage *s, float phase)
{
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        for (uint32_t k = 0; k < GRID_VERTICES; k++) {
            float *p = s->vertices[i][k];
            p[0] = (float)(i % 10) + (float)(k % 9) / 8.0f;
            p[1] = (float)(i / 10) + (float)(k / 9) / 8.0f;
            p[2] = sinf(phase + p[0] + 2.0f * p[1]);
        }
    }
}

static void move_instances(stage *s, float phase)
{
    for (uint32_t i = 0; i < INSTANCES; i++) {
        s->instances[i] = instance_of(s->blas, i);
        s->instances[i].transform[0][3] = 20.0f * (float)(i % 25) + sinf(phase + (float)i);
        s->instances[i].transform[1][3] = 20.0f * (float)(i / 25);
    }
}

static stage *stage_make(uint32_t threads)
{
    stage *s = calloc(1, sizeof *s);
    clast_context_desc desc = {.memory = {tapped, &s->tap}, .threads = threads};
    uint32_t number;
    assert_int_equal(clast_context_create(&desc, &s->context), CLAST_OK);
    assert_ok(s->context, clast_template_set_create(s->context, &s->set));
    assert_ok(s->context, clast_template_set_add_grid(s->set, GRID, GRID, &number));
    assert_ok(s->context, clast_clas_pool_create(s->set, &s->pool));
    assert_ok(s->context, clast_blas_create(s->pool, &s->blas));
    assert_ok(s->context, clast_tlas_create(s->context, &s->tlas));
    s->vertices = calloc(CLUSTERS, sizeof *s->vertices);
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        s->inputs[i] = (clast_clas_input){number, s->vertices[i][0]};
    }
    move_vertices(s, 0.0f);
    move_instances(s, 0.0f);
    return s;
}

static void stage_free(stage *s)
{
    clast_tlas_destroy(s->tlas);
    clast_blas_destroy(s->blas);
    clast_clas_pool_destroy(s->pool);
    clast_template_set_destroy(s->set);
    clast_context_destroy(s->context);
    assert_int_equal(s->tap.held, 0);
    free(s->vertices);
    free(s);
}

// All that an engine does in a frame.
static clast_status run_frame(stage *s, float phase, clast_build build)
{
    static const uint32_t some[3] = {4, 400, 17};
    move_vertices(s, phase);
    move_instances(s, phase);
    clast_status status = clast_clas_instantiate(s->pool, 0, CLUSTERS, s->inputs);
    status = status == CLAST_OK ? clast_clas_refit(s->pool, 3, 50) : status;
    status = status == CLAST_OK ? clast_blas_build(s->blas, NULL, CLUSTERS, build) : status;
    status = status == CLAST_OK ? clast_blas_refit(s->blas) : status;
    status = status == CLAST_OK ? clast_tlas_build(s->tlas, s->instances, INSTANCES, build) : status;
    status = status == CLAST_OK ? clast_tlas_update(s->tlas, some, s->instances, 3) : status;
    return status == CLAST_OK ? clast_tlas_update(s->tlas, NULL, s->instances, INSTANCES) : status;
}

static void assert_hits(const stage *s)
{
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 100; i++) {
        clast_ray ray = {{(float)i * 4.9f, (float)i * 3.7f, 50}, 0, {0, 0, -1}, INFINITY};
        clast_hit hit;
        clast_trace_closest(s->tlas, &ray, 1, NULL, &hit);
        hits += hit.instance != CLAST_NONE;
    }
    assert_true(hits > 20);
}

static void updates_within_a_reserve_allocate_nothing(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        stage *s = stage_make(threads);
        assert_ok(s->context, clast_clas_pool_reserve(s->pool, CLUSTERS));
        assert_ok(s->context, clast_blas_reserve(s->blas, CLUSTERS));
        assert_ok(s->context, clast_tlas_reserve(s->tlas, INSTANCES));
        uint32_t calls = s->tap.calls;
        for (uint32_t frame = 0; frame < 6; frame++) {
            assert_ok(s->context,
                      run_frame(s, 0.1f * (float)frame, frame % 2 == 0 ? CLAST_BUILD_BEST : CLAST_BUILD_FAST));
            assert_int_equal(s->tap.calls, calls);
        }
        assert_hits(s);
        stage_free(s);
    }
}

static void updates_in_kept_shape_need_no_reserve(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    static uint32_t positions[CLUSTERS * GRID_VERTICES], first[CLUSTERS];
    for (uint32_t i = 0; i < CLUSTERS * GRID_VERTICES; i++) {
        positions[i] = i;
        first[i / GRID_VERTICES] = i / GRID_VERTICES * GRID_VERTICES;
    }
    float(*mesh)[GRID_VERTICES][3] = calloc(CLUSTERS, sizeof *mesh);
    memcpy(mesh, s->vertices, CLUSTERS * sizeof *mesh);
    const clast_clas_gather gather = {mesh[0][0], CLUSTERS * GRID_VERTICES, positions, first, s->vertices[0][0]};
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    uint32_t calls = s->tap.calls;
    for (uint32_t frame = 0; frame < 5; frame++) {
        const uint32_t numbers[2] = {3, 9};
        move_vertices(s, (float)frame);
        assert_ok(s->context, clast_clas_instantiate(s->pool, 0, CLUSTERS, s->inputs));
        assert_ok(s->context, clast_clas_refit(s->pool, 0, CLUSTERS));
        assert_ok(s->context, clast_clas_refit_gathered(s->pool, 0, CLUSTERS, &gather));
        assert_ok(s->context, clast_blas_refit(s->blas));
        assert_ok(s->context, clast_tlas_update(s->tlas, numbers, s->instances, 2));
        assert_ok(s->context, clast_tlas_update(s->tlas, NULL, s->instances, INSTANCES));
    }
    assert_int_equal(s->tap.calls, calls);
    assert_hits(s);
    free(mesh);
    stage_free(s);
}

static void own_clusters_within_a_reserve_allocate_nothing(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    uint8_t indices[3 * 256];
    for (uint32_t i = 0; i < sizeof indices; i++) {
        indices[i] = (uint8_t)(i * 7 % GRID_VERTICES);
    }
    assert_ok(s->context, clast_clas_pool_reserve_own(s->pool, CLUSTERS, 256));
    assert_int_equal(clast_clas_pool_memory(s->set, CLUSTERS, 256) + 1024 > clast_clas_pool_bytes(s->pool), 1);
    uint32_t calls = s->tap.calls;
    for (uint32_t i = 0; i < CLUSTERS; i++) {
        clast_clas_desc desc = {1 + i % 256, GRID_VERTICES, indices, s->vertices[i][0], 0};
        assert_ok(s->context, clast_clas_build(s->pool, i, 1, &desc));
        desc.triangle_count = 256;
        assert_ok(s->context, clast_clas_build(s->pool, i / 2, 1, &desc));
        assert_ok(s->context, clast_clas_instantiate(s->pool, i / 3, 1, &s->inputs[i]));
    }
    assert_int_equal(s->tap.calls, calls);
    stage_free(s);
}

static void working_memory_is_not_kept_without_a_reserve(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    assert_true(clast_blas_bytes(s->blas) < clast_blas_memory(CLUSTERS) / 4);
    assert_true(clast_tlas_bytes(s->tlas) < clast_tlas_memory(INSTANCES) * 3 / 4);
    stage_free(s);
}

// Memory of the caller's with rubbish in it.
typedef struct given {
    uint8_t *pool, *blas, *tlas;
    size_t pool_bytes, blas_bytes, tlas_bytes;
} given;

static uint8_t *rubbish(size_t bytes)
{
    uint8_t *memory = NULL;
    assert_int_equal(posix_memalign((void **)&memory, 64, bytes), 0);
    memset(memory, 0xa5, bytes);
    return memory;
}

static given give_memory(stage *s)
{
    given g = {.pool_bytes = (size_t)clast_clas_pool_memory(s->set, CLUSTERS, 0),
               .blas_bytes = (size_t)clast_blas_memory(CLUSTERS),
               .tlas_bytes = (size_t)clast_tlas_memory(INSTANCES)};
    g.pool = rubbish(g.pool_bytes);
    g.blas = rubbish(g.blas_bytes);
    g.tlas = rubbish(g.tlas_bytes);
    assert_ok(s->context, clast_clas_pool_use_memory(s->pool, g.pool, g.pool_bytes, 0));
    assert_ok(s->context, clast_blas_use_memory(s->blas, g.blas, g.blas_bytes));
    assert_ok(s->context, clast_tlas_use_memory(s->tlas, g.tlas, g.tlas_bytes));
    return g;
}

static void given_free(given *g)
{
    free(g->pool);
    free(g->blas);
    free(g->tlas);
}

static void the_callers_memory_is_enough_and_all_that_is_used(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    given g = give_memory(s);
    uint32_t calls = s->tap.calls;
    for (uint32_t frame = 0; frame < 4; frame++) {
        assert_ok(s->context, run_frame(s, (float)frame, frame % 2 == 0 ? CLAST_BUILD_FAST : CLAST_BUILD_BEST));
    }
    assert_int_equal(s->tap.calls, calls);
    assert_hits(s);
    stage_free(s);
    given_free(&g);
}

static void memory_makes_no_difference_to_hits(void **state)
{
    (void)state;
    stage *stages[2] = {stage_make(1), stage_make(2)};
    given g = give_memory(stages[1]);
    for (int i = 0; i < 2; i++) {
        assert_ok(stages[i]->context, run_frame(stages[i], 1.5f, CLAST_BUILD_BEST));
    }
    randoms r = {1};
    for (uint32_t i = 0; i < 300; i++) {
        clast_ray ray = {{random_between(&r, 0, 500), random_between(&r, 0, 400), 20},
                         0,
                         {random_between(&r, -1, 1), random_between(&r, -1, 1), -1},
                         INFINITY};
        clast_hit hits[2];
        memset(hits, 0, sizeof hits);
        for (int k = 0; k < 2; k++) {
            clast_trace_closest(stages[k]->tlas, &ray, 1, NULL, &hits[k]);
        }
        assert_int_equal(hits[0].instance, hits[1].instance);
        assert_int_equal(hits[0].steps, hits[1].steps);
        assert_true(hits[0].instance == CLAST_NONE || hits[0].t == hits[1].t);
    }
    stage_free(stages[0]);
    stage_free(stages[1]);
    given_free(&g);
}

static void assert_both_numbers(const stage *s, uint64_t needed, uint64_t given_bytes)
{
    char text[2][32];
    snprintf(text[0], sizeof text[0], "%llu", (unsigned long long)needed);
    snprintf(text[1], sizeof text[1], "%llu", (unsigned long long)given_bytes);
    assert_non_null(strstr(clast_context_error(s->context), text[0]));
    assert_non_null(strstr(clast_context_error(s->context), text[1]));
}

static void what_does_not_fit_the_callers_memory_says_so(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    given g = give_memory(s);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    uint32_t calls = s->tap.calls;
    // one byte less
    assert_ok(s->context, clast_blas_use_memory(s->blas, g.blas, g.blas_bytes - 1));
    assert_int_equal(clast_blas_build(s->blas, NULL, CLUSTERS, CLAST_BUILD_BEST), CLAST_ERROR_OUT_OF_MEMORY);
    assert_both_numbers(s, g.blas_bytes, g.blas_bytes - 1);
    float lower[3], upper[3];
    clast_blas_bounds(s->blas, lower, upper);
    assert_true(lower[0] > upper[0]);
    assert_ok(s->context, clast_blas_build(s->blas, NULL, CLUSTERS / 2, CLAST_BUILD_BEST));
    assert_ok(s->context, clast_tlas_use_memory(s->tlas, g.tlas, g.tlas_bytes - 1));
    assert_int_equal(clast_tlas_build(s->tlas, s->instances, INSTANCES, CLAST_BUILD_BEST), CLAST_ERROR_OUT_OF_MEMORY);
    assert_both_numbers(s, g.tlas_bytes, g.tlas_bytes - 1);
    clast_tlas_bounds(s->tlas, lower, upper);
    assert_true(lower[0] > upper[0]);
    assert_ok(s->context, clast_tlas_build(s->tlas, s->instances, INSTANCES - 70, CLAST_BUILD_BEST));
    // one slot more
    assert_int_equal(clast_clas_instantiate(s->pool, CLUSTERS, 1, s->inputs), CLAST_ERROR_OUT_OF_MEMORY);
    assert_both_numbers(s, clast_clas_pool_memory(s->set, CLUSTERS + 1, 0), g.pool_bytes);
    assert_int_equal(clast_clas_pool_count(s->pool), CLUSTERS);
    assert_int_equal(clast_clas_pool_reserve(s->pool, CLUSTERS + 1), CLAST_ERROR_OUT_OF_MEMORY);
    // own triangles, for which there is no room
    const uint8_t indices[3] = {0, 1, 2};
    const clast_clas_desc own = {1, 3, indices, s->vertices[0][0], 0};
    assert_int_equal(clast_clas_build(s->pool, 0, 1, &own), CLAST_ERROR_OUT_OF_MEMORY);
    assert_ok(s->context, clast_clas_pool_use_memory(s->pool, g.pool, g.pool_bytes - 1, 0));
    assert_int_equal(clast_clas_instantiate(s->pool, 0, CLUSTERS, s->inputs), CLAST_ERROR_OUT_OF_MEMORY);
    assert_ok(s->context, clast_clas_instantiate(s->pool, 0, CLUSTERS - 1, s->inputs));
    assert_int_equal(s->tap.calls, calls);
    stage_free(s);
    given_free(&g);
}

static void own_triangles_fit_the_callers_memory(void **state)
{
    (void)state;
    stage *s = stage_make(1);
    const uint8_t indices[9] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    const clast_clas_desc own = {3, 9, indices, s->vertices[0][0], 0};
    size_t bytes = (size_t)clast_clas_pool_memory(s->set, 10, 3);
    uint8_t *memory = rubbish(bytes);
    assert_ok(s->context, clast_clas_pool_use_memory(s->pool, memory, bytes, 3));
    for (uint32_t i = 0; i < 10; i++) {
        assert_ok(s->context, clast_clas_build(s->pool, i, 1, &own));
    }
    assert_int_equal(clast_clas_build(s->pool, 10, 1, &own), CLAST_ERROR_OUT_OF_MEMORY);
    stage_free(s);
    free(memory);
}

static void more_than_the_reserve_is_taken_from_the_context(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    assert_ok(s->context, clast_blas_reserve(s->blas, 10));
    assert_ok(s->context, clast_tlas_reserve(s->tlas, 10));
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    assert_hits(s);
    uint64_t bytes = clast_tlas_bytes(s->tlas);
    assert_true(bytes >= clast_tlas_memory(INSTANCES));
    assert_ok(s->context, clast_tlas_reserve(s->tlas, 10)); // it has more
    assert_int_equal(clast_tlas_bytes(s->tlas), bytes);
    stage_free(s);
}

static void the_callers_memory_can_be_given_up(void **state)
{
    (void)state;
    stage *s = stage_make(2);
    given g = give_memory(s);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    assert_ok(s->context, clast_clas_pool_use_memory(s->pool, NULL, 0, 0));
    assert_ok(s->context, clast_blas_use_memory(s->blas, NULL, 0));
    assert_ok(s->context, clast_tlas_use_memory(s->tlas, NULL, 0));
    given_free(&g);
    assert_int_equal(clast_clas_pool_count(s->pool), 0);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    assert_hits(s);
    // and from the context's to the caller's, with things there
    g = give_memory(s);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST));
    assert_hits(s);
    stage_free(s);
    given_free(&g);
}

static void memory_that_is_not_aligned_is_refused(void **state)
{
    (void)state;
    stage *s = stage_make(1);
    uint8_t *memory = rubbish(4096);
    assert_int_equal(clast_clas_pool_use_memory(s->pool, memory + 8, 4000, 0), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_blas_use_memory(s->blas, memory + 8, 4000), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_tlas_use_memory(s->tlas, memory + 8, 4000), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(s->context, run_frame(s, 0.0f, CLAST_BUILD_BEST)); // as it was
    stage_free(s);
    free(memory);
}

static void little_needs_little(void **state)
{
    (void)state;
    assert_true(clast_blas_memory(2) < 4096 && clast_tlas_memory(2) < 4096);
    for (size_t count = 1; count < 5000; count += count / 3 + 1) {
        assert_true(clast_blas_memory(count) < 1024 * count);
        assert_true(clast_blas_memory(count) < clast_blas_memory(count + count / 3 + 1));
    }
}

static void sizes_are_told_of_what_can_be(void **state)
{
    (void)state;
    stage *s = stage_make(1);
    const size_t many = (size_t)1 << 31;
    assert_true(clast_blas_memory(many) == UINT64_MAX && clast_tlas_memory(many) == UINT64_MAX);
    assert_true(clast_clas_pool_memory(s->set, many + 1, 0) == UINT64_MAX);
    assert_true(clast_clas_pool_memory(s->set, 1, 257) == UINT64_MAX);
    assert_true(clast_clas_pool_memory(NULL, 1, 0) == UINT64_MAX);
    assert_true(clast_blas_memory(many - 1) > many && clast_tlas_memory(many - 1) > many);
    assert_int_equal(clast_blas_reserve(s->blas, many), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(clast_tlas_reserve(s->tlas, many), CLAST_ERROR_OUT_OF_MEMORY);
    assert_int_equal(clast_clas_pool_reserve(s->pool, many + 1), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_pool_reserve_own(s->pool, 1, 257), CLAST_ERROR_INVALID_ARGUMENT);
    stage_free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(updates_within_a_reserve_allocate_nothing),
        cmocka_unit_test(updates_in_kept_shape_need_no_reserve),
        cmocka_unit_test(own_clusters_within_a_reserve_allocate_nothing),
        cmocka_unit_test(working_memory_is_not_kept_without_a_reserve),
        cmocka_unit_test(the_callers_memory_is_enough_and_all_that_is_used),
        cmocka_unit_test(memory_makes_no_difference_to_hits),
        cmocka_unit_test(what_does_not_fit_the_callers_memory_says_so),
        cmocka_unit_test(own_triangles_fit_the_callers_memory),
        cmocka_unit_test(more_than_the_reserve_is_taken_from_the_context),
        cmocka_unit_test(the_callers_memory_can_be_given_up),
        cmocka_unit_test(memory_that_is_not_aligned_is_refused),
        cmocka_unit_test(little_needs_little),
        cmocka_unit_test(sizes_are_told_of_what_can_be),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
