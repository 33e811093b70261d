// SPDX-License-Identifier: Apache-2.0
// Memory that runs out at any moment: an error, nothing lost, nothing left over, and what was there still works.
#include "test.h"

#include "accel/meshes.h"
#include "accel/tap.h"

// All calls that allocate, in turn; the first failure ends it.
static clast_status build_all(clast_context *context, const mesh *m)
{
    clustered c = {0};
    clast_tlas *tlas = NULL;
    uint32_t grid;
    clast_status status = clustered_make(context, m, 64, &c);
    status = status == CLAST_OK ? clast_template_set_add_grid(c.set, 11, 11, &grid) : status;
    status = status == CLAST_OK ? clast_clas_pool_reserve(c.pool, 1000) : status;
    status = status == CLAST_OK ? clast_tlas_create(context, &tlas) : status;
    clast_tlas_instance instances[3] = {instance_of(c.blas, 0), instance_of(c.blas, 1), instance_of(c.blas, 2)};
    status = status == CLAST_OK ? clast_tlas_build(tlas, instances, 3, CLAST_BUILD_BEST) : status;
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    return status;
}

// The same mesh as clusters of their own, with all that can be reserved; stored, and used from there.
static clast_status store_all(clast_context *context, const mesh *m)
{
    clustered c = {0};
    clast_tlas *tlas = NULL;
    clast_blas *mapped = NULL;
    void *memory = NULL;
    uint64_t size = 0;
    const uint8_t corners[3] = {0, 1, 2};
    clast_status status = clustered_make(context, m, 64, &c);
    const clast_clas_desc own = {1, 3, corners, c.vertices, 0};
    status = status == CLAST_OK ? clast_clas_build(c.pool, 1, 1, &own) : status;
    status = status == CLAST_OK ? clast_clas_pool_reserve_own(c.pool, 100, 256) : status;
    status = status == CLAST_OK ? clast_blas_reserve(c.blas, 20) : status;
    status = status == CLAST_OK ? clast_blas_build(c.blas, NULL, c.cluster_count, CLAST_BUILD_FAST) : status;
    status = status == CLAST_OK ? clast_blas_serialise(c.blas, NULL, 0, &size) : status;
    if (status == CLAST_OK) {
        assert_int_equal(posix_memalign(&memory, 64, (size_t)size), 0);
        status = clast_blas_serialise(c.blas, memory, (size_t)size, &size);
    }
    status = status == CLAST_OK ? clast_blas_map(context, memory, (size_t)size, true, &mapped) : status;
    status = status == CLAST_OK ? clast_tlas_create(context, &tlas) : status;
    clast_tlas_instance instances[2] = {instance_of(mapped, 0), instance_of(mapped, 1)};
    status = status == CLAST_OK ? clast_tlas_build(tlas, instances, 2, CLAST_BUILD_FAST) : status;
    status = status == CLAST_OK ? clast_tlas_reserve(tlas, 1) : status;
    status = status == CLAST_OK ? clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST) : status;
    status = status == CLAST_OK ? clast_tlas_update(tlas, NULL, instances, 1) : status;
    clast_tlas_destroy(tlas);
    clast_blas_destroy(mapped);
    free(memory);
    clustered_free(&c);
    return status;
}

// Runs it again and again, each time with the next allocation failing, until none does.
static void fail_each(clast_status (*run)(clast_context *context, const mesh *m))
{
    mesh m = mesh_terrain(30, 0.1f, 1);
    for (uint32_t failing = 0;; failing++) {
        tap t = {.left = UINT32_MAX};
        clast_context *context;
        clast_context_desc desc = {.memory = {tapped, &t}, .threads = 2};
        assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
        t.left = failing;
        clast_status status = run(context, &m);
        clast_context_destroy(context);
        assert_int_equal(t.held, 0);
        if (status == CLAST_OK) {
            assert_true(failing > 12);
            break;
        }
        assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
    }
    mesh_free(&m);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    fail_each(build_all);
}

static void every_allocation_may_fail_where_memory_is_reserved_and_trees_are_stored(void **state)
{
    (void)state;
    fail_each(store_all);
}

static void a_failed_reserve_leaves_what_was_there(void **state)
{
    (void)state;
    mesh m = mesh_terrain(30, 0.1f, 1);
    tap t = {.left = UINT32_MAX};
    clast_context *context;
    clast_context_desc desc = {.memory = {tapped, &t}, .threads = 1};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, &m, 64, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instances[2] = {instance_of(c.blas, 0), instance_of(c.blas, 1)};
    assert_ok(context, clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST));
    clast_ray ray = {{0.3f, 0.4f, 1}, 0, {0, 0, -1}, INFINITY};
    clast_hit hit;
    t.left = 0;
    assert_int_equal(clast_clas_pool_reserve(c.pool, 100000), CLAST_ERROR_OUT_OF_MEMORY);
    t.left = 0;
    assert_int_equal(clast_blas_reserve(c.blas, 100000), CLAST_ERROR_OUT_OF_MEMORY);
    t.left = 0;
    assert_int_equal(clast_tlas_reserve(tlas, 100000), CLAST_ERROR_OUT_OF_MEMORY);
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    assert_int_equal(hit.instance, 0);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    clast_context_destroy(context);
    assert_int_equal(t.held, 0);
    mesh_free(&m);
}

static void a_failed_build_leaves_an_empty_tree(void **state)
{
    (void)state;
    mesh m = mesh_terrain(30, 0.1f, 1);
    tap t = {.left = UINT32_MAX};
    clast_context *context;
    clast_context_desc desc = {.memory = {tapped, &t}, .threads = 1};
    assert_int_equal(clast_context_create(&desc, &context), CLAST_OK);
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, &m, 64, &c));
    assert_ok(context, clast_tlas_create(context, &tlas));
    clast_tlas_instance instances[2] = {instance_of(c.blas, 0), instance_of(c.blas, 1)};
    assert_ok(context, clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST));
    t.left = 0;
    clast_ray ray = {{0.3f, 0.4f, 1}, 0, {0, 0, -1}, INFINITY};
    clast_hit hit;
    assert_int_equal(clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST), CLAST_ERROR_OUT_OF_MEMORY);
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    assert_int_equal(hit.instance, CLAST_NONE);
    t.left = 0;
    assert_int_equal(clast_blas_build(c.blas, NULL, c.cluster_count, CLAST_BUILD_BEST), CLAST_ERROR_OUT_OF_MEMORY);
    t.left = UINT32_MAX;
    assert_ok(context, clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST));
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    assert_int_equal(hit.instance, CLAST_NONE);
    assert_ok(context, clast_blas_build(c.blas, NULL, c.cluster_count, CLAST_BUILD_BEST));
    assert_ok(context, clast_tlas_build(tlas, instances, 2, CLAST_BUILD_BEST));
    clast_trace_closest(tlas, &ray, 1, NULL, &hit);
    assert_int_equal(hit.instance, 0);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
    clast_context_destroy(context);
    assert_int_equal(t.held, 0);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(every_allocation_may_fail_where_memory_is_reserved_and_trees_are_stored),
        cmocka_unit_test(a_failed_reserve_leaves_what_was_there),
        cmocka_unit_test(a_failed_build_leaves_an_empty_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
