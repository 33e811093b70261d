// SPDX-License-Identifier: Apache-2.0
// Clusters fitted to vertices that they share.
#include "test.h"

#include "accel/meshes.h"
#include "accel/structures.h"

static const clast_isa all_sets[] = {
#define SET(name, value, text) name,
    CLAST_ISA_LIST(SET)
#undef SET
};

// Where each cluster's vertices begin. Positions are as many as the mesh has, so that a sanitizer sees what is read beyond.
static uint32_t *first_vertices(const clustered *c)
{
    uint32_t *first = malloc(4 * (size_t)c->cluster_count);
    for (uint32_t i = 0; i < c->cluster_count; i++) {
        first[i] = (uint32_t)((clast_clas_vertices(clast_pool_slot(c->pool, i)) - c->vertices) / 3);
    }
    return first;
}

static float *exact_positions(const mesh *m)
{
    float *positions = malloc(12 * (size_t)m->vertex_count);
    memcpy(positions, m->positions, 12 * (size_t)m->vertex_count);
    return positions;
}

static void gathering_is_copying_and_fitting(void **state)
{
    (void)state;
    for (size_t set = 0; set < sizeof all_sets / sizeof *all_sets; set++) {
        clast_context *context;
        if (clast_context_create(&(clast_context_desc){.isa = all_sets[set], .threads = 2}, &context) != CLAST_OK) {
            continue; // the machine lacks it
        }
        mesh m = mesh_terrain(50, 0.2f, 4);
        clustered a, b;
        assert_ok(context, clustered_make(context, &m, 100, &a));
        assert_ok(context, clustered_make(context, &m, 100, &b));
        mesh_transform(&m, 1.7f, -0.3f, 0.0f, 4.0f);
        uint32_t *first = first_vertices(&a);
        float *positions = exact_positions(&m);
        clast_clas_gather gather = {positions, m.vertex_count, a.vertex_sources, first, a.vertices};
        assert_ok(context, clast_clas_refit_gathered(a.pool, 0, a.cluster_count, &gather));
        clustered_gather(&b, &m);
        assert_ok(context, clast_clas_refit(b.pool, 0, b.cluster_count));
        assert_memory_equal(a.vertices, b.vertices, 12 * (size_t)a.vertex_count);
        assert_memory_equal(a.pool->boxes, b.pool->boxes, a.cluster_count * sizeof(clast_box));
        for (uint32_t i = 0; i < a.cluster_count; i++) {
            const clast_clas *x = clast_pool_slot(a.pool, i), *y = clast_pool_slot(b.pool, i);
            assert_memory_equal(x->groups, y->groups, sizeof x->groups[0]);
            assert_memory_equal(x->lower, y->lower, sizeof x->lower);
        }
        free(positions);
        free(first);
        clustered_free(&a);
        clustered_free(&b);
        mesh_free(&m);
        clast_context_destroy(context);
    }
}

static void only_the_clusters_named_are_touched(void **state)
{
    mesh m = mesh_terrain(20, 0.2f, 4);
    clustered c;
    assert_ok(*state, clustered_make(*state, &m, 50, &c));
    uint32_t *first = first_vertices(&c), end = first[3];
    float *before = malloc(12 * (size_t)c.vertex_count);
    memcpy(before, c.vertices, 12 * (size_t)c.vertex_count);
    mesh_transform(&m, 2.0f, 1.0f, 1.0f, 1.0f);
    clast_clas_gather gather = {m.positions, m.vertex_count, c.vertex_sources, first, c.vertices};
    assert_ok(*state, clast_clas_refit_gathered(c.pool, 1, 2, &gather));
    assert_memory_equal(before, c.vertices, 12 * (size_t)first[1]);
    assert_memory_not_equal(before + 3 * first[1], c.vertices + 3 * first[1], 12 * (size_t)(end - first[1]));
    assert_memory_equal(before + 3 * end, c.vertices + 3 * end, 12 * (size_t)(c.vertex_count - end));
    free(before);
    free(first);
    clustered_free(&c);
    mesh_free(&m);
}

static void numbers_out_of_range_are_refused(void **state)
{
    mesh m = mesh_terrain(20, 0.2f, 4);
    clustered c;
    assert_ok(*state, clustered_make(*state, &m, 50, &c));
    uint32_t *first = first_vertices(&c);
    clast_clas_gather gather = {m.positions, m.vertex_count, c.vertex_sources, first, c.vertices};
    c.vertex_sources[first[5]] = m.vertex_count;
    assert_int_equal(clast_clas_refit_gathered(c.pool, 0, c.cluster_count, &gather), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(*state, clast_clas_refit_gathered(c.pool, 0, 5, &gather));
    c.vertex_sources[first[5]] = m.vertex_count - 1;
    assert_ok(*state, clast_clas_refit_gathered(c.pool, 0, c.cluster_count, &gather));
    first[2]++; // not where the cluster's vertices are
    assert_int_equal(clast_clas_refit_gathered(c.pool, 0, c.cluster_count, &gather), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_refit_gathered(c.pool, 0, c.cluster_count + 1, &gather), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_refit_gathered(c.pool, 0, 0, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    free(first);
    clustered_free(&c);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gathering_is_copying_and_fitting),
        CONTEXT_TEST(only_the_clusters_named_are_touched),
        CONTEXT_TEST(numbers_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
