// SPDX-License-Identifier: Apache-2.0
#include "geometry/clusters.h"

#include <float.h>

// Clusters of a mesh, checked; gives how full they are.
static double fill_of(clast_context *context, const mesh *m, uint32_t max_triangles, uint32_t max_vertices)
{
    clast_clusterize_desc desc = desc_of(m, max_triangles, max_vertices);
    clast_clusters clusters;
    assert_ok(context, clast_clusterize(context, &desc, &clusters));
    check_clusters(&desc, &clusters);
    double fill = cluster_fill(&clusters, max_triangles != 0 ? max_triangles : 128,
                               max_vertices != 0 ? max_vertices : 128);
    clast_clusters_free(context, &clusters);
    return fill;
}

static void a_sheet_fills_its_clusters(void **state)
{
    mesh m = mesh_grid(300, 200);
    double fill = fill_of(*state, &m, 0, 0);
    assert_true(fill > 0.95);
    mesh_free(&m);
}

static void a_soup_fills_its_clusters_with_vertices(void **state)
{
    mesh m = mesh_soup(30000, 7);
    double fill = fill_of(*state, &m, 0, 0);
    assert_true(fill > 0.93); // 42 triangles have 126 vertices
    mesh_free(&m);
}

static void strips_fill_their_clusters(void **state)
{
    mesh m = mesh_grid(20000, 1);
    double fill = fill_of(*state, &m, 0, 0);
    assert_true(fill > 0.93);
    mesh_free(&m);
}

static void other_limits_are_kept_and_filled(void **state)
{
    static const uint32_t limits[][2] = {{64, 64},  {128, 64}, {128, 42}, {256, 256},
                                         {32, 256}, {96, 60},  {1, 3},    {2, 256}};
    mesh m = mesh_grid(120, 100);
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++) {
        double fill = fill_of(*state, &m, limits[i][0], limits[i][1]);
        assert_true(fill > 0.85);
    }
    mesh_free(&m);
}

static void three_vertices_are_a_limit_like_any(void **state)
{
    mesh m = mesh_random(5, 3000, 3);
    fill_of(*state, &m, 256, 3);
    mesh_free(&m);
}

static void few_triangles_are_one_cluster(void **state)
{
    clast_context *context = *state;
    for (size_t triangles = 0; triangles <= 3; triangles++) {
        mesh m = mesh_random(9, triangles, 11);
        clast_clusterize_desc desc = desc_of(&m, 0, 0);
        clast_clusters clusters;
        assert_ok(context, clast_clusterize(context, &desc, &clusters));
        check_clusters(&desc, &clusters);
        assert_int_equal(clusters.cluster_count, triangles != 0);
        clast_clusters_free(context, &clusters);
        mesh_free(&m);
    }
}

static void random_meshes_keep_every_triangle(void **state)
{
    uint32_t numbers = 2024;
    for (int i = 0; i < 60; i++) {
        size_t triangles = 1 + next_number(&numbers) % (i % 10 == 0 ? 40000 : 3000);
        size_t positions = 1 + next_number(&numbers) % (i % 3 == 0 ? 50 : 5000);
        mesh m = mesh_random(positions, triangles, next_number(&numbers) | 1);
        fill_of(*state, &m, 1 + next_number(&numbers) % 256, 3 + next_number(&numbers) % 254);
        mesh_free(&m);
    }
}

static void triangles_in_one_place_are_cut_all_the_same(void **state)
{
    mesh m = mesh_random(3000, 80000, 5);
    for (size_t i = 0; i < 3 * m.position_count; i++) {
        m.positions[i] = 0.25f;
    }
    fill_of(*state, &m, 0, 0);
    mesh_free(&m);
}

static void copies_of_one_triangle_share_three_vertices(void **state)
{
    mesh m = mesh_random(3, 50000, 9);
    for (size_t i = 0; i < m.triangle_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            m.indices[3 * i + k] = k;
        }
    }
    double fill = fill_of(*state, &m, 0, 0);
    assert_true(fill > 0.95);
    mesh_free(&m);
}

static void positions_that_are_no_numbers_do_no_harm(void **state)
{
    mesh m = mesh_grid(200, 150);
    uint32_t numbers = 77;
    static const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 0.0f, -0.0f, FLT_MIN, 1e-45f};
    for (size_t i = 0; i < 20000; i++) {
        m.positions[next_number(&numbers) % (3 * m.position_count)] = odd[next_number(&numbers) % 9];
    }
    fill_of(*state, &m, 0, 0);
    for (size_t i = 0; i < 3 * m.position_count; i++) {
        m.positions[i] = NAN;
    }
    fill_of(*state, &m, 0, 0);
    mesh_free(&m);
}

// Each place is half as far as the one before: a cut of equal widths takes a few triangles off at a time.
static void places_that_crowd_towards_a_point_are_cut(void **state)
{
    mesh m = mesh_soup(60000, 21);
    for (size_t i = 0; i < m.position_count; i++) {
        float scale = ldexpf(1.0f, -(int)(i / 3 % 120));
        for (size_t k = 0; k < 3; k++) {
            m.positions[3 * i + k] *= scale;
        }
    }
    fill_of(*state, &m, 0, 0);
    mesh_free(&m);
}

// Scaling by a power of two and back changes no bit, so the cut must be the same; sizes within what steers the cut.
static void the_scale_of_a_mesh_does_not_matter(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_grid(100, 80);
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_clusters first, other;
    assert_ok(context, clast_clusterize(context, &desc, &first));
    static const int exponents[] = {-60, -10, 10, 60, 100};
    for (size_t e = 0; e < sizeof exponents / sizeof exponents[0]; e++) {
        mesh scaled = mesh_grid(100, 80);
        for (size_t i = 0; i < 3 * m.position_count; i++) {
            scaled.positions[i] = ldexpf(m.positions[i], exponents[e]);
        }
        desc.positions = scaled.positions;
        assert_ok(context, clast_clusterize(context, &desc, &other));
        assert_true(clusters_equal(&first, &other, m.triangle_count));
        clast_clusters_free(context, &other);
        mesh_free(&scaled);
    }
    clast_clusters_free(context, &first);
    mesh_free(&m);
}

static void the_number_of_threads_changes_nothing(void **state)
{
    (void)state;
    static const uint32_t threads[] = {1, 2, 5};
    mesh meshes[] = {mesh_grid(400, 300), mesh_soup(150000, 3), mesh_random(20000, 100000, 4)};
    for (size_t i = 0; i < 3; i++) {
        clast_clusterize_desc desc = desc_of(&meshes[i], 0, 0);
        clast_clusters first = {0};
        clast_context *contexts[3];
        for (size_t t = 0; t < 3; t++) {
            clast_clusters clusters;
            assert_int_equal(clast_context_create(&(clast_context_desc){.threads = threads[t]}, &contexts[t]),
                             CLAST_OK);
            assert_ok(contexts[t], clast_clusterize(contexts[t], &desc, &clusters));
            if (t == 0) {
                first = clusters;
                check_clusters(&desc, &clusters);
                continue;
            }
            assert_true(clusters_equal(&first, &clusters, desc.triangle_count));
            clast_clusters_free(contexts[t], &clusters);
        }
        clast_clusters_free(contexts[0], &first);
        for (size_t t = 0; t < 3; t++) {
            clast_context_destroy(contexts[t]);
        }
        mesh_free(&meshes[i]);
    }
}

// Numbers that a multiplication, as hash tables have it, sends to few places: their table must give way.
static void vertices_made_to_collide_are_numbered(void **state)
{
    mesh m = mesh_random(300000, 6000, 31);
    uint32_t used[4096], count = 0, numbers = 5;
    for (uint32_t i = 0; i < m.position_count && count < 4096; i++) {
        if (((i + 1) * 0x9e3779b1u) >> 20 < 32) {
            used[count++] = i;
        }
    }
    assert_true(count > 1000);
    for (size_t i = 0; i < 3 * m.triangle_count; i++) {
        m.indices[i] = used[next_number(&numbers) % count];
    }
    fill_of(*state, &m, 0, 0);
    mesh_free(&m);
}

// All but one triangle in one corner of the box: Morton codes tell them apart no more.
static void a_small_dense_part_of_a_large_mesh_is_cut_well(void **state)
{
    mesh m = mesh_grid(200, 200);
    double fill = fill_of(*state, &m, 0, 0);
    for (size_t i = 0; i + 3 < m.position_count; i++) {
        for (size_t k = 0; k < 3; k++) {
            m.positions[3 * i + k] *= 1e-7f;
        }
    }
    assert_true(fill_of(*state, &m, 0, 0) > fill - 0.01);
    mesh_free(&m);
}

static bool stop_at_once(void *user, const char *stage, uint64_t done, uint64_t total)
{
    (void)user;
    (void)stage;
    return done >= total; // never
}

static void a_large_mesh_can_be_cancelled(void **state)
{
    (void)state;
    mesh m = mesh_grid(512, 260);
    clast_context *context;
    clast_context_desc hooks = {.progress = {stop_at_once, NULL}};
    assert_int_equal(clast_context_create(&hooks, &context), CLAST_OK);
    uint64_t before = clast_context_memory(context);
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_clusters clusters;
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_CANCELLED);
    assert_null(clusters.clusters);
    assert_int_equal(clast_context_memory(context), before);
    clast_context_destroy(context);
    mesh_free(&m);
}

static double area_of_box(const float lower[3], const float upper[3])
{
    double x = upper[0] - lower[0], y = upper[1] - lower[1], z = upper[2] - lower[2];
    return x * y + y * z + z * x;
}

// The boxes of blocks of eight triangles, summed up, in the order that clusters give or in the mesh's.
static double block_area(const mesh *m, const uint32_t *order)
{
    double sum = 0.0;
    for (size_t begin = 0; begin < m->triangle_count; begin += 8) {
        float lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (size_t i = begin; i < begin + 8 && i < m->triangle_count; i++) {
            for (size_t k = 0; k < 9; k++) {
                float x = m->positions[3 * (size_t)m->indices[3 * (size_t)order[i] + k / 3] + k % 3];
                lower[k % 3] = fminf(lower[k % 3], x);
                upper[k % 3] = fmaxf(upper[k % 3], x);
            }
        }
        sum += area_of_box(lower, upper);
    }
    return sum;
}

// 8 triangles of a flat grid are 2 x 2 quads at best; the bound allows twice their area.
static void blocks_of_eight_triangles_are_compact(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_grid(256, 256);
    for (size_t i = 0; i < m.position_count; i++) {
        m.positions[3 * i + 2] = 0.0f;
    }
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_clusters clusters;
    assert_ok(context, clast_clusterize(context, &desc, &clusters));
    assert_true(block_area(&m, clusters.triangles) < 2.0 * 4.0 * (double)m.triangle_count / 8.0);
    clast_clusters_free(context, &clusters);
    mesh_free(&m);
}

static void an_index_out_of_range_is_refused_by_its_triangle(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_grid(200, 200);
    m.indices[3 * 70000 + 1] = UINT32_MAX;
    m.indices[3 * 40001 + 2] = (uint32_t)m.position_count;
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_clusters clusters;
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(clast_context_error(context), "triangle 40001 has index 40401, expected below 40401"));
    assert_null(clusters.clusters);
    mesh_free(&m);
}

static void wrong_arguments_are_refused(void **state)
{
    clast_context *context = *state;
    mesh m = mesh_grid(2, 2);
    clast_clusters clusters;
    clast_clusterize_desc desc = desc_of(&m, 257, 0);
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    desc = desc_of(&m, 0, 2);
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    desc = desc_of(&m, 0, 257);
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    desc = desc_of(&m, 0, 0);
    desc.indices = NULL;
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    desc = desc_of(&m, 0, 0);
    desc.positions = NULL;
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    desc = desc_of(&m, 0, 0);
    desc.triangle_count = (size_t)UINT32_MAX;
    assert_int_equal(clast_clusterize(context, &desc, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clusterize(context, NULL, &clusters), CLAST_ERROR_INVALID_ARGUMENT);
    assert_int_equal(clast_clusterize(context, &desc, NULL), CLAST_ERROR_INVALID_ARGUMENT);
    mesh_free(&m);
}

// Memory that runs out after so many blocks.
static long blocks_left;

static void *counted_reallocate(void *user, void *pointer, size_t old_size, size_t new_size)
{
    (void)user;
    (void)old_size;
    if (new_size == 0) {
        free(pointer);
        return NULL;
    }
    return blocks_left-- > 0 ? realloc(pointer, new_size) : NULL;
}

static void memory_that_runs_out_is_reported_and_freed(void **state)
{
    (void)state;
    mesh m = mesh_grid(300, 300);
    uint32_t *remap = malloc(m.position_count * sizeof *remap);
    blocks_left = 1000;
    clast_context *context;
    clast_context_desc hooks = {.memory = {counted_reallocate, NULL}, .threads = 2};
    assert_int_equal(clast_context_create(&hooks, &context), CLAST_OK);
    uint64_t before = clast_context_memory(context);
    clast_clusterize_desc desc = desc_of(&m, 0, 0);
    clast_status status = CLAST_ERROR_OUT_OF_MEMORY;
    long tried = 0;
    for (; status != CLAST_OK; tried++) {
        blocks_left = tried;
        clast_clusters clusters;
        size_t unique;
        status = clast_weld_positions(context, m.positions, m.position_count, remap, &unique);
        if (status == CLAST_OK) {
            status = clast_clusterize(context, &desc, &clusters);
        }
        if (status == CLAST_OK) {
            clast_clusters_free(context, &clusters);
        } else {
            assert_int_equal(status, CLAST_ERROR_OUT_OF_MEMORY);
        }
        assert_int_equal(clast_context_memory(context), before);
    }
    assert_true(tried > 10);
    clast_context_destroy(context);
    free(remap);
    mesh_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        CONTEXT_TEST(a_sheet_fills_its_clusters),
        CONTEXT_TEST(a_soup_fills_its_clusters_with_vertices),
        CONTEXT_TEST(strips_fill_their_clusters),
        CONTEXT_TEST(other_limits_are_kept_and_filled),
        CONTEXT_TEST(three_vertices_are_a_limit_like_any),
        CONTEXT_TEST(few_triangles_are_one_cluster),
        CONTEXT_TEST(random_meshes_keep_every_triangle),
        CONTEXT_TEST(triangles_in_one_place_are_cut_all_the_same),
        CONTEXT_TEST(copies_of_one_triangle_share_three_vertices),
        CONTEXT_TEST(positions_that_are_no_numbers_do_no_harm),
        CONTEXT_TEST(places_that_crowd_towards_a_point_are_cut),
        CONTEXT_TEST(vertices_made_to_collide_are_numbered),
        CONTEXT_TEST(a_small_dense_part_of_a_large_mesh_is_cut_well),
        CONTEXT_TEST(the_scale_of_a_mesh_does_not_matter),
        CONTEXT_TEST(blocks_of_eight_triangles_are_compact),
        CONTEXT_TEST(an_index_out_of_range_is_refused_by_its_triangle),
        CONTEXT_TEST(wrong_arguments_are_refused),
        cmocka_unit_test(the_number_of_threads_changes_nothing),
        cmocka_unit_test(a_large_mesh_can_be_cancelled),
        cmocka_unit_test(memory_that_runs_out_is_reported_and_freed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
