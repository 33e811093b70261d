// SPDX-License-Identifier: Apache-2.0
// Clusters with triangles of their own: hit as those of templates, and built again in place.
#include "test.h"

#include "accel/meshes.h"

// A mesh's clusters as clast_clas_build takes them, in clusters of consecutive triangles.
typedef struct own_clusters {
    clast_clas_desc *descs;
    uint8_t *indices;
    float *vertices;
    uint32_t count;
} own_clusters;

static own_clusters own_clusters_of(const mesh *m, uint32_t most)
{
    own_clusters own = {calloc(m->triangle_count, sizeof *own.descs), malloc(3 * (size_t)m->triangle_count),
                        malloc(36 * (size_t)m->triangle_count), 0};
    uint32_t *sources = malloc(12 * (size_t)m->triangle_count);
    uint16_t *local = malloc(m->vertex_count * sizeof *local);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        local[i] = 256;
    }
    uint32_t vertices = 0;
    for (uint32_t first = 0; first < m->triangle_count;) {
        clast_clas_desc *desc = &own.descs[own.count++];
        desc->indices = own.indices + 3 * (size_t)first;
        desc->vertices = own.vertices + 3 * (size_t)vertices;
        desc->triangle_count = cluster_cut(m, first, most, local, own.indices + 3 * (size_t)first, sources + vertices,
                                           &desc->vertex_count);
        vertices += desc->vertex_count;
        first += desc->triangle_count;
    }
    for (uint32_t i = 0; i < vertices; i++) {
        memcpy(own.vertices + 3 * (size_t)i, m->positions + 3 * (size_t)sources[i], 12);
    }
    free(sources);
    free(local);
    return own;
}

static void own_clusters_free(own_clusters *own)
{
    free(own->descs);
    free(own->indices);
    free(own->vertices);
}

typedef struct stage {
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    clast_tlas *tlas;
} stage;

static void stage_begin(clast_context *context, stage *s)
{
    assert_ok(context, clast_template_set_create(context, &s->set));
    assert_ok(context, clast_clas_pool_create(s->set, &s->pool));
    assert_ok(context, clast_blas_create(s->pool, &s->blas));
    assert_ok(context, clast_tlas_create(context, &s->tlas));
}

static void stage_end(stage *s)
{
    clast_tlas_destroy(s->tlas);
    clast_blas_destroy(s->blas);
    clast_clas_pool_destroy(s->pool);
    clast_template_set_destroy(s->set);
}

static void build_trees(clast_context *context, stage *s)
{
    clast_tlas_instance instance = instance_of(s->blas, 0);
    assert_ok(context, clast_blas_build(s->blas, NULL, clast_clas_pool_count(s->pool), CLAST_BUILD_BEST));
    assert_ok(context, clast_tlas_build(s->tlas, &instance, 1, CLAST_BUILD_BEST));
}

// As the mesh's clusters of templates are.
static void assert_hit_like(clast_context *context, const stage *s, const mesh *m, uint32_t most)
{
    clustered c;
    clast_tlas *tlas;
    assert_ok(context, clustered_make(context, m, most, &c));
    clast_tlas_instance instance = instance_of(c.blas, 0);
    assert_ok(context, clast_tlas_create(context, &tlas));
    assert_ok(context, clast_tlas_build(tlas, &instance, 1, CLAST_BUILD_BEST));
    randoms r = {3};
    uint32_t hits = 0;
    for (int i = 0; i < 1000; i++) {
        clast_ray ray = {{random_between(&r, -2, 2), random_between(&r, -2, 2), random_between(&r, -2, 2)},
                         0,
                         {random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1)},
                         INFINITY};
        clast_hit hit[2];
        memset(hit, 0, sizeof hit);
        clast_trace_closest(s->tlas, &ray, 1, NULL, &hit[0]);
        clast_trace_closest(tlas, &ray, 1, NULL, &hit[1]);
        assert_int_equal(hit[0].instance, hit[1].instance);
        if (hit[0].instance != CLAST_NONE) {
            assert_memory_equal(&hit[0], &hit[1], sizeof hit[0]);
            hits++;
        }
    }
    assert_true(hits > 50);
    clast_tlas_destroy(tlas);
    clustered_free(&c);
}

static void own_triangles_are_hit_like_those_of_templates(void **state)
{
    clast_context *context = *state;
    const uint32_t sizes[] = {7, 64, 128, 256};
    for (int i = 0; i < 4; i++) {
        mesh m = mesh_torus(40, 20, 1.0f, 0.4f);
        own_clusters own = own_clusters_of(&m, sizes[i]);
        stage s;
        stage_begin(context, &s);
        assert_ok(context, clast_clas_build(s.pool, 0, own.count, own.descs));
        build_trees(context, &s);
        assert_hit_like(context, &s, &m, sizes[i]);
        stage_end(&s);
        own_clusters_free(&own);
        mesh_free(&m);
    }
}

static void the_indices_may_be_freed(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(3);
    own_clusters own = own_clusters_of(&m, 100);
    stage s;
    stage_begin(context, &s);
    assert_ok(context, clast_clas_build(s.pool, 0, own.count, own.descs));
    memset(own.indices, 0, 3 * (size_t)m.triangle_count);
    build_trees(context, &s);
    assert_hit_like(context, &s, &m, 100);
    stage_end(&s);
    own_clusters_free(&own);
    mesh_free(&m);
}

// Streaming: small clusters first, then larger ones one by one, which makes the pool grow in all ways; then others in their
// place.
static void slots_are_built_again(void **state)
{
    clast_context *context = *state;
    mesh first = mesh_octasphere(2), second = mesh_torus(40, 20, 1.0f, 0.4f);
    own_clusters small = own_clusters_of(&first, 5), large = own_clusters_of(&second, 250);
    stage s;
    stage_begin(context, &s);
    assert_ok(context, clast_clas_build(s.pool, 0, small.count, small.descs));
    build_trees(context, &s);
    assert_hit_like(context, &s, &first, 5);
    for (uint32_t i = 0; i < large.count; i++) {
        assert_ok(context, clast_clas_build(s.pool, i, 1, &large.descs[i]));
    }
    clast_clas_pool_truncate(s.pool, large.count);
    build_trees(context, &s);
    assert_hit_like(context, &s, &second, 250);
    uint64_t bytes = clast_clas_pool_bytes(s.pool);
    for (int i = 0; i < 10; i++) {
        assert_ok(context, clast_clas_build(s.pool, 0, large.count, large.descs));
        assert_ok(context, clast_clas_build(s.pool, 0, small.count, small.descs));
    }
    build_trees(context, &s);
    assert_hit_like(context, &s, &first, 5);
    assert_true(clast_clas_pool_bytes(s.pool) <= bytes * small.count); // no more for each time
    bytes = clast_clas_pool_bytes(s.pool);
    assert_ok(context, clast_clas_build(s.pool, 0, large.count, large.descs));
    assert_int_equal(clast_clas_pool_bytes(s.pool), bytes);
    stage_end(&s);
    own_clusters_free(&small);
    own_clusters_free(&large);
    mesh_free(&first);
    mesh_free(&second);
}

static void both_kinds_share_a_pool(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(4);
    own_clusters own = own_clusters_of(&m, 60);
    stage s;
    stage_begin(context, &s);
    uint32_t number;
    clast_template_desc *descs = calloc(own.count, sizeof *descs);
    for (uint32_t i = 0; i < own.count; i++) {
        const clast_clas_desc *from = &own.descs[i];
        descs[i] = (clast_template_desc){from->triangle_count, from->vertex_count, from->indices, from->vertices};
    }
    assert_ok(context, clast_template_set_add(s.set, descs, own.count, &number));
    for (uint32_t i = 0; i < own.count; i++) { // one of each in turn, and each slot was the other before
        clast_clas_input input = {number + i, own.descs[i].vertices};
        for (int turn = 0; turn < 2; turn++) {
            if ((i + (uint32_t)turn) % 2 == 0) {
                assert_ok(context, clast_clas_instantiate(s.pool, i, 1, &input));
            } else {
                assert_ok(context, clast_clas_build(s.pool, i, 1, &own.descs[i]));
            }
        }
    }
    build_trees(context, &s);
    assert_hit_like(context, &s, &m, 60);
    assert_ok(context, clast_clas_refit(s.pool, 0, own.count));
    assert_ok(context, clast_clas_pool_reserve(s.pool, 1000)); // moves all
    build_trees(context, &s);
    assert_hit_like(context, &s, &m, 60);
    stage_end(&s);
    free(descs);
    own_clusters_free(&own);
    mesh_free(&m);
}

static void what_is_no_cluster_is_refused(void **state)
{
    clast_context *context = *state;
    stage s;
    stage_begin(context, &s);
    const float vertices[9] = {0};
    const uint8_t indices[3] = {0, 1, 2}, beyond[3] = {0, 1, 3};
    const clast_clas_desc good = {1, 3, indices, vertices, 0};
    const clast_clas_desc bad[] = {
        {0, 3, indices, vertices, 0},   {257, 3, indices, vertices, 0}, {1, 0, indices, vertices, 0},
        {1, 257, indices, vertices, 0}, {1, 3, NULL, vertices, 0},      {1, 3, indices, NULL, 0},
        {1, 3, beyond, vertices, 0},
    };
    assert_ok(context, clast_clas_build(s.pool, 0, 1, &good));
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        clast_clas_desc two[2] = {good, bad[i]};
        assert_int_equal(clast_clas_build(s.pool, 1, 2, two), CLAST_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(clast_context_error(context), "cluster 1"));
        assert_int_equal(clast_clas_pool_count(s.pool), 1);
    }
    assert_int_equal(clast_clas_build(s.pool, SIZE_MAX, 1, &good), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_build(s.pool, 0, 1, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_build(NULL, 0, 1, &good), CLAST_ERROR_INVALID_ARGUMENT);
    assert_ok(context, clast_clas_build(s.pool, 0, 0, NULL));
    stage_end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(own_triangles_are_hit_like_those_of_templates),
        CONTEXT_TEST(the_indices_may_be_freed),
        CONTEXT_TEST(slots_are_built_again),
        CONTEXT_TEST(both_kinds_share_a_pool),
        CONTEXT_TEST(what_is_no_cluster_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
