// SPDX-License-Identifier: Apache-2.0
// Clusters that are set one by one, and triangles that are taken as they come: the structures are those of whole batches.
#include "test.h"

#include "accel/meshes.h"
#include "base/isa.h"
#include "base/thread.h"

// A mesh's clusters, of consecutive triangles.
typedef struct pieces {
    clast_clas_desc *descs;
    uint8_t *indices;
    float *vertices;
    uint32_t count;
    size_t own_bytes;
} pieces;

static pieces pieces_of(const mesh *m, uint32_t most)
{
    pieces p = {calloc(m->triangle_count, sizeof *p.descs), malloc(3 * (size_t)m->triangle_count),
                malloc(36 * (size_t)m->triangle_count), 0, 0};
    uint32_t *sources = malloc(12 * (size_t)m->triangle_count), vertices = 0;
    uint16_t *local = malloc(m->vertex_count * sizeof *local);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        local[i] = 256;
    }
    for (uint32_t first = 0; first < m->triangle_count;) {
        clast_clas_desc *desc = &p.descs[p.count++];
        *desc = (clast_clas_desc){
            .indices = p.indices + 3 * (size_t)first, .vertices = p.vertices + 3 * (size_t)vertices, .ordered = 1};
        desc->triangle_count = cluster_cut(m, first, most, local, p.indices + 3 * (size_t)first, sources + vertices,
                                           &desc->vertex_count);
        p.own_bytes += clast_clas_own_bytes(desc->triangle_count);
        vertices += desc->vertex_count;
        first += desc->triangle_count;
    }
    for (uint32_t i = 0; i < vertices; i++) {
        memcpy(p.vertices + 3 * (size_t)i, m->positions + 3 * (size_t)sources[i], 12);
    }
    free(sources);
    free(local);
    return p;
}

static void pieces_free(pieces *p)
{
    free(p->descs);
    free(p->indices);
    free(p->vertices);
}

typedef struct stage {
    clast_context *context;
    clast_template_set *set;
    clast_clas_pool *pool;
    uint32_t first_template;
} stage;

// With a template for each piece, which takes its triangles as they come too.
static stage stage_open(clast_context *context, const pieces *p)
{
    stage s = {.context = context};
    assert_ok(context, clast_template_set_create(context, &s.set));
    assert_ok(context, clast_clas_pool_create(s.set, &s.pool));
    for (uint32_t i = 0; i < p->count; i++) {
        clast_template_desc desc = {p->descs[i].triangle_count, p->descs[i].vertex_count, p->descs[i].indices, NULL};
        uint32_t number;
        assert_ok(context, clast_template_set_add(s.set, &desc, 1, &number));
        s.first_template = i == 0 ? number : s.first_template;
    }
    return s;
}

static void stage_close(stage *s)
{
    clast_clas_pool_destroy(s->pool);
    clast_template_set_destroy(s->set);
}

// All that rays can see of a pool.
static void *bytes_of(stage *s, uint64_t *size)
{
    clast_blas *blas;
    assert_ok(s->context, clast_blas_create(s->pool, &blas));
    assert_ok(s->context, clast_blas_build(blas, NULL, clast_clas_pool_count(s->pool), CLAST_BUILD_BEST));
    assert_ok(s->context, clast_blas_serialise(blas, NULL, 0, size));
    void *bytes = aligned_alloc(64, (*size + 63) / 64 * 64);
    assert_ok(s->context, clast_blas_serialise(blas, bytes, *size, size));
    clast_blas_destroy(blas);
    return bytes;
}

static void assert_same_structures(stage *a, stage *b)
{
    uint64_t sizes[2];
    void *bytes[2] = {bytes_of(a, &sizes[0]), bytes_of(b, &sizes[1])};
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    free(bytes[0]);
    free(bytes[1]);
}

static void check_order(clast_context *context)
{
    const uint32_t sizes[] = {1, 7, 8, 100, 128, 256};
    for (int i = 0; i < 6; i++) {
        mesh m = mesh_torus(40, 20, 1.0f, 0.4f);
        pieces p = pieces_of(&m, sizes[i]);
        stage own = stage_open(context, &p), templates = stage_open(context, &p);
        assert_ok(context, clast_clas_build(own.pool, 0, p.count, p.descs));
        for (uint32_t k = 0; k < p.count; k++) {
            clast_clas_input input = {templates.first_template + k, p.descs[k].vertices};
            assert_ok(context, clast_clas_instantiate(templates.pool, k, 1, &input));
        }
        assert_same_structures(&own, &templates);
        stage_close(&own);
        stage_close(&templates);
        pieces_free(&p);
        mesh_free(&m);
    }
}

static void triangles_that_come_in_order_become_the_blocks_of_a_template(void **state)
{
    (void)state;
    for (clast_isa isa = CLAST_ISA_PLAIN; isa <= clast_isa_best(); isa++) {
        clast_context *context;
        assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 1, .isa = isa}, &context), CLAST_OK);
        check_order(context);
        clast_context_destroy(context);
    }
}

// ------------------------------------------------------------------------------------------------------- one by one

typedef struct set_job {
    stage *s;
    const pieces *p;
    const size_t *places;
    atomic_uint failures;
} set_job;

// Every third cluster is one of a template.
static void set_range(void *data, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    set_job *job = data;
    for (size_t i = begin; i < end; i++) {
        clast_clas_input input = {job->s->first_template + (uint32_t)i, job->p->descs[i].vertices};
        clast_status status = i % 3 == 0 ? clast_clas_set(job->s->pool, i, &input)
                                         : clast_clas_set_own(job->s->pool, i, job->places[i], &job->p->descs[i]);
        atomic_fetch_add(&job->failures, status != CLAST_OK);
    }
}

static void set_all(stage *s, const pieces *p)
{
    uint32_t most = 1;
    size_t *places = calloc(p->count + 1, sizeof *places);
    for (uint32_t i = 0; i < p->count; i++) {
        places[i + 1] = places[i] + clast_clas_own_bytes(p->descs[i].triangle_count);
        most = p->descs[i].triangle_count > most ? p->descs[i].triangle_count : most;
    }
    clast_clas_room room = {p->count, most, places[p->count]};
    assert_ok(s->context, clast_clas_pool_resize(s->pool, &room));
    set_job job = {s, p, places, 0};
    clast_parallel_for(s->context, p->count, 1, set_range, &job);
    assert_int_equal(atomic_load(&job.failures), 0);
    free(places);
}

static void clusters_set_one_by_one_are_those_of_a_batch(void **state)
{
    (void)state;
    clast_context *context;
    assert_int_equal(clast_context_create(&(clast_context_desc){.threads = 4}, &context), CLAST_OK);
    mesh first = mesh_torus(40, 20, 1.0f, 0.4f), second = mesh_octasphere(3);
    pieces large = pieces_of(&first, 128), small = pieces_of(&second, 30);
    stage batch = stage_open(context, &large), single = stage_open(context, &large);
    assert_ok(context, clast_clas_build(batch.pool, 0, large.count, large.descs));
    set_all(&single, &large);
    assert_same_structures(&batch, &single);
    uint64_t bytes = clast_clas_pool_bytes(single.pool);
    stage other = stage_open(context, &small);
    set_all(&other, &small);
    stage_close(&other);
    set_all(&single, &large); // what was there gives way
    assert_same_structures(&batch, &single);
    assert_int_equal(clast_clas_pool_bytes(single.pool), bytes);
    stage_close(&batch);
    stage_close(&single);
    pieces_free(&large);
    pieces_free(&small);
    mesh_free(&first);
    mesh_free(&second);
    clast_context_destroy(context);
}

static void a_pool_that_was_set_may_grow_and_be_fitted_anew(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(4);
    pieces p = pieces_of(&m, 64);
    stage batch = stage_open(context, &p), single = stage_open(context, &p);
    assert_ok(context, clast_clas_build(batch.pool, 0, p.count, p.descs));
    set_all(&single, &p);
    assert_ok(context, clast_clas_pool_reserve_own(single.pool, 3 * (size_t)p.count, 100)); // moves all
    for (size_t i = 0; i < 9 * (size_t)m.triangle_count; i++) {
        p.vertices[i] *= 1.5f;
    }
    assert_ok(context, clast_clas_refit(single.pool, 0, p.count));
    assert_ok(context, clast_clas_refit(batch.pool, 0, p.count));
    assert_same_structures(&batch, &single);
    assert_ok(context, clast_clas_build(batch.pool, p.count, p.count, p.descs));
    assert_ok(context, clast_clas_build(single.pool, p.count, p.count, p.descs));
    assert_same_structures(&batch, &single);
    stage_close(&batch);
    stage_close(&single);
    pieces_free(&p);
    mesh_free(&m);
}

static void corners_are_where_the_vertices_are(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(3);
    pieces p = pieces_of(&m, 50);
    stage s = stage_open(context, &p);
    set_all(&s, &p);
    float corners[3][3];
    for (uint32_t i = 0; i < p.count; i++) {
        const clast_clas_desc *desc = &p.descs[i];
        for (uint32_t t = 0; t < desc->triangle_count; t++) {
            assert_true(clast_clas_corners(s.pool, i, t, corners));
            for (uint32_t k = 0; k < 3; k++) {
                assert_memory_equal(corners[k], desc->vertices + 3 * (size_t)desc->indices[3 * t + k], 12);
            }
        }
        assert_false(clast_clas_corners(s.pool, i, desc->triangle_count, corners));
    }
    assert_false(clast_clas_corners(s.pool, p.count, 0, corners));
    assert_true(corners[0][0] == 0.0f && corners[2][2] == 0.0f);
    assert_false(clast_clas_corners(NULL, 0, 0, corners));
    stage_close(&s);
    pieces_free(&p);
    mesh_free(&m);
}

static void slots_that_were_not_set_are_empty(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(2);
    pieces p = pieces_of(&m, 100);
    stage s = stage_open(context, &p);
    float corners[3][3], lower[3], upper[3];
    clast_clas_room room = {40, 100, p.own_bytes};
    assert_ok(context, clast_clas_pool_resize(s.pool, &room));
    assert_int_equal(clast_clas_pool_count(s.pool), 40);
    assert_false(clast_clas_corners(s.pool, 7, 0, corners));
    clast_blas *blas;
    assert_ok(context, clast_blas_create(s.pool, &blas));
    assert_ok(context, clast_blas_build(blas, NULL, 40, CLAST_BUILD_FAST));
    clast_blas_bounds(blas, lower, upper);
    assert_true(lower[0] > upper[0]);
    clast_blas_destroy(blas);
    stage_close(&s);
    pieces_free(&p);
    mesh_free(&m);
}

// ---------------------------------------------------------------------------------------------------------- memory

static void the_bytes_are_those_foretold_and_few(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_torus(200, 100, 1.0f, 0.4f);
    pieces p = pieces_of(&m, 128);
    stage s = stage_open(context, &p);
    uint64_t before = clast_clas_pool_bytes(s.pool);
    clast_clas_room room = {p.count, 128, p.own_bytes};
    set_all(&s, &p);
    assert_int_equal(clast_clas_pool_bytes(s.pool) - before, clast_clas_room_bytes(&room));
    assert_int_equal(clast_clas_own_bytes(128), 8 + 16 * 32);
    // the slot's two lines, its box and its blocks
    assert_true((double)clast_clas_room_bytes(&room) < 5.4 * (double)m.triangle_count);
    room = (clast_clas_room){100, 0, 0};
    assert_true(clast_clas_room_bytes(&room) == UINT64_MAX);
    stage_close(&s);
    pieces_free(&p);
    mesh_free(&m);
}

static void what_does_not_fit_is_refused(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_octasphere(3);
    pieces p = pieces_of(&m, 200);
    stage s = stage_open(context, &p);
    const clast_clas_room none[] = {{1, 0, 0}, {1, 257, 0}, {SIZE_MAX, 8, 0}, {1, 8, SIZE_MAX}};
    for (int i = 0; i < 4; i++) {
        assert_int_equal(clast_clas_pool_resize(s.pool, &none[i]), CLAST_ERROR_INVALID_ARGUMENT);
    }
    clast_clas_room room = {2, 128, 600};
    assert_ok(context, clast_clas_pool_resize(s.pool, &room));
    clast_clas_input input = {s.first_template, p.descs[0].vertices};
    assert_int_equal(clast_clas_set(s.pool, 0, &input), CLAST_ERROR_INVALID_ARGUMENT); // of 200 triangles
    room.most_triangles = 200;
    assert_ok(context, clast_clas_pool_resize(s.pool, &room));
    assert_ok(context, clast_clas_set(s.pool, 0, &input));
    assert_int_equal(clast_clas_set(s.pool, 2, &input), CLAST_ERROR_INVALID_ARGUMENT);
    input.template_number = 1000000;
    assert_int_equal(clast_clas_set(s.pool, 0, &input), CLAST_ERROR_INVALID_ARGUMENT);
    clast_clas_desc desc = p.descs[0];
    assert_int_equal(clast_clas_set_own(s.pool, 0, 0, &desc), CLAST_ERROR_INVALID_ARGUMENT); // takes 808 bytes
    desc.triangle_count = 100;
    assert_ok(context, clast_clas_set_own(s.pool, 1, 176, &desc));
    assert_int_equal(clast_clas_set_own(s.pool, 1, 184, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_set_own(s.pool, 1, 4, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clas_set_own(s.pool, 2, 0, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    desc.vertex_count = 3;
    assert_int_equal(clast_clas_set_own(s.pool, 1, 0, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    desc = p.descs[0];
    desc.triangle_count = 8;
    desc.vertices = NULL;
    assert_int_equal(clast_clas_set_own(s.pool, 1, 0, &desc), CLAST_ERROR_INVALID_ARGUMENT);
    stage_close(&s);
    pieces_free(&p);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_that_come_in_order_become_the_blocks_of_a_template),
        cmocka_unit_test(clusters_set_one_by_one_are_those_of_a_batch),
        CONTEXT_TEST(a_pool_that_was_set_may_grow_and_be_fitted_anew),
        CONTEXT_TEST(corners_are_where_the_vertices_are),
        CONTEXT_TEST(slots_that_were_not_set_are_empty),
        CONTEXT_TEST(the_bytes_are_those_foretold_and_few),
        CONTEXT_TEST(what_does_not_fit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
