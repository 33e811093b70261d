// SPDX-License-Identifier: Apache-2.0
// The boxes of clusters, beside a plain way to the same bytes, for every instruction set.
#include "test.h"

#include "accel/meshes.h"
#include "accel/structures.h"
#include "shared/box.h"

enum { ROUNDS = 400 };

static const clast_isa all_sets[] = {
#define SET(name, value, text) name,
    CLAST_ISA_LIST(SET)
#undef SET
};

static bool is_sound(const float *v)
{
    bool sound = true;
    for (int axis = 0; axis < 3; axis++) {
        sound = sound && fabsf(v[axis]) <= BOX_COORDINATE_MOST; // false for NaN
    }
    return sound;
}

static bool is_sound_triangle(const clast_block *block, uint32_t lane, const float *vertices)
{
    return is_sound(vertices + 3 * block->corners[0][lane]) && is_sound(vertices + 3 * block->corners[1][lane]) &&
           is_sound(vertices + 3 * block->corners[2][lane]);
}

static void include_block(clast_box *box, const clast_block *block, const float *vertices)
{
    for (uint32_t i = 0; i < 3 * BLOCK_TRIANGLES; i++) {
        const float *v = vertices + 3 * block->corners[i / BLOCK_TRIANGLES][i % BLOCK_TRIANGLES];
        for (int axis = 0; axis < 3 && is_sound_triangle(block, i % BLOCK_TRIANGLES, vertices); axis++) {
            box->lower.v[axis] = fminf(box->lower.v[axis], unsigned_zero(v[axis]));
            box->upper.v[axis] = fmaxf(box->upper.v[axis], unsigned_zero(v[axis]));
        }
    }
}

// One block's side, as it must be: inside out for a block where nothing can be hit, and for one that is not there.
static uint8_t side_of(const clast_template *t, uint32_t b, const float *vertices, const clast_clas *clas, int axis,
                       int side)
{
    clast_box box = clast_box_empty();
    if (b < t->block_count) {
        include_block(&box, &t->blocks[b], vertices);
    }
    if (clast_box_is_empty(&box)) {
        return side == 0 ? 255 : 0;
    }
    return side == 0 ? (uint8_t)box_quantise_down(box.lower.v[axis], clas->lower[axis], clas->exponents[axis])
                     : (uint8_t)box_quantise_up(box.upper.v[axis], clas->lower[axis], clas->exponents[axis]);
}

static void assert_fits(const clast_clas_pool *pool, size_t slot)
{
    const clast_clas *clas = clast_pool_slot(pool, slot);
    const clast_template *t = clast_clas_topology(clas);
    const float *vertices = clast_clas_vertices(clas);
    clast_box all = clast_box_empty();
    for (uint32_t b = 0; b < t->block_count; b++) {
        include_block(&all, &t->blocks[b], vertices);
    }
    assert_memory_equal(&all, &pool->boxes[slot], sizeof all);
    assert_memory_equal(&all.lower, clas->lower, sizeof all.lower);
    assert_int_equal(clas->block_count, clast_box_is_empty(&all) ? 0 : t->block_count);
    for (int axis = 0; axis < 3; axis++) {
        float size = all.upper.v[axis] - all.lower.v[axis];
        assert_int_equal(clas->exponents[axis], size >= 0.0f ? box_exponent(size) : BOX_STEP_LEAST);
        for (uint32_t b = 0; b < (clas->block_count + 15u) / 16 * 16; b++) {
            for (int side = 0; side < 2; side++) {
                assert_int_equal(clas->groups[b / 16][axis][side][b % 16], side_of(t, b, vertices, clas, axis, side));
            }
        }
    }
}

// ---------------------------------------------------------------------------------------------------------- clusters

typedef struct cluster {
    uint8_t indices[3 * TEMPLATE_TRIANGLES];
    float *vertices; // as many as the cluster has, so that a sanitizer sees what is read beyond
    clast_template_desc desc;
} cluster;

static void make_cluster(randoms *r, cluster *c)
{
    uint32_t most = random_below(r, 3) == 0 ? TEMPLATE_VERTICES : CLUSTER_VERTICES;
    uint32_t vertices = 1 + random_below(r, most), triangles = 1 + random_below(r, TEMPLATE_TRIANGLES);
    bool all_used = random_below(r, 8) != 0 && vertices <= 3 * triangles;
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        c->indices[i] = (uint8_t)(all_used && i < vertices ? i : random_below(r, vertices));
    }
    c->vertices = malloc(12 * (size_t)vertices);
    c->desc = (clast_template_desc){triangles, vertices, c->indices, NULL};
}

static float special_float(randoms *r)
{
    static const float specials[] = {NAN,    INFINITY, -INFINITY, 0.0f,   -0.0f,   1e-44f, 3e38f,
                                     -2e36f, 0x1p120f, -0x1p120f, 1e-38f, -1e-20f, 1.0f,   1e20f};
    return specials[random_below(r, sizeof specials / sizeof *specials)];
}

// Of all sizes; now and then flat, or with values that are not finite.
static void place_vertices(cluster *c, randoms *r)
{
    float scale = ldexpf(1.0f, (int)random_below(r, 220) - 110), offset[3];
    bool shifted = random_below(r, 2) == 0, flat = random_below(r, 8) == 0;
    uint32_t specials = random_below(r, 3) == 0 ? 1 + random_below(r, 20) : 0;
    for (int axis = 0; axis < 3; axis++) {
        offset[axis] = shifted ? 50.0f * scale * random_between(r, -1, 1) : 0.0f;
    }
    for (uint32_t i = 0; i < 3 * c->desc.vertex_count; i++) {
        c->vertices[i] = flat && i % 3 == 1 ? -0.0f : offset[i % 3] + scale * random_between(r, -1, 1);
    }
    while (specials-- > 0) {
        c->vertices[random_below(r, 3 * c->desc.vertex_count)] = special_float(r);
    }
}

static void check_cluster(clast_template_set *set, clast_clas_pool *pool, cluster *c, randoms *r)
{
    uint32_t number;
    assert_int_equal(clast_template_set_add(set, &c->desc, 1, &number), CLAST_OK);
    place_vertices(c, r);
    clast_clas_input input = {number, c->vertices};
    assert_int_equal(clast_clas_instantiate(pool, 0, 1, &input), CLAST_OK);
    assert_fits(pool, 0);
    for (int i = 0; i < 4; i++) {
        place_vertices(c, r);
        assert_int_equal(clast_clas_refit(pool, 0, 1), CLAST_OK);
        assert_fits(pool, 0);
    }
}

static void check_random_clusters(clast_context *context)
{
    clast_template_set *set;
    clast_clas_pool *pool;
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_clas_pool_create(set, &pool));
    randoms r = {11};
    for (int i = 0; i < ROUNDS; i++) {
        cluster c;
        make_cluster(&r, &c);
        check_cluster(set, pool, &c, &r);
        free(c.vertices);
    }
    clast_clas_pool_destroy(pool);
    clast_template_set_destroy(set);
}

static void every_instruction_set_fits_the_same_boxes(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof all_sets / sizeof *all_sets; i++) {
        clast_context *context;
        if (clast_context_create(&(clast_context_desc){.isa = all_sets[i], .threads = 1}, &context) == CLAST_OK) {
            check_random_clusters(context);
            clast_context_destroy(context);
        }
    }
}

static void grids_of_all_sizes_fit(void **state)
{
    clast_context *context = *state;
    clast_template_set *set;
    clast_clas_pool *pool;
    assert_ok(context, clast_template_set_create(context, &set));
    assert_ok(context, clast_clas_pool_create(set, &pool));
    randoms r = {12};
    for (uint32_t i = 0; i < GRID_SEGMENTS * GRID_SEGMENTS; i++) {
        cluster c = {.desc.vertex_count = (2 + i % GRID_SEGMENTS) * (2 + i / GRID_SEGMENTS)};
        c.vertices = malloc(12 * (size_t)c.desc.vertex_count);
        uint32_t number;
        assert_ok(context, clast_template_set_add_grid(set, 1 + i % GRID_SEGMENTS, 1 + i / GRID_SEGMENTS, &number));
        place_vertices(&c, &r);
        clast_clas_input input = {number, c.vertices};
        assert_ok(context, clast_clas_instantiate(pool, 0, 1, &input));
        assert_fits(pool, 0);
        free(c.vertices);
    }
    clast_clas_pool_destroy(pool);
    clast_template_set_destroy(set);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_instruction_set_fits_the_same_boxes),
        CONTEXT_TEST(grids_of_all_sizes_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
