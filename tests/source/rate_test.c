// SPDX-License-Identifier: Apache-2.0
// Segments and levels counted many at once, beside the shared formulas one by one: the same for every instruction set.
#include "test.h"

#include <math.h>
#include <string.h>

#include "source/rate.h"

enum { ROUNDS = 1500, EDGES = 384, ACROSS = 23, DOWN = 12 };

static const clast_isa all_sets[] = {
#define SET(name, value, text) name,
    CLAST_ISA_LIST(SET)
#undef SET
};

static uint32_t random_state = 7;

static float between(float low, float high)
{
    random_state = random_state * 1664525u + 1013904223u;
    return low + (high - low) * (float)(random_state >> 8) * 0x1p-24f;
}

static uint32_t below(uint32_t end)
{
    return min_uint((uint32_t)between(0.0f, (float)end), end - 1);
}

typedef struct cluster {
    clast_rate_points points;
    uint32_t point_count, edge_count, apart[EDGES];
    clast_rate_edge edges[EDGES];
    clast_rate_site sites[RATE_POINTS], middles[EDGES];
    uint16_t levels[RATE_POINTS];
    uint32_t factors[EDGES + 1];
} cluster;

static float special(void)
{
    static const float specials[] = {0.0f, -0.0f, 1e-20f, -1e15f, 1e20f, 1e-38f, -1.0f, 1e30f};
    return specials[below(sizeof specials / sizeof *specials)];
}

static void make_cluster(cluster *c)
{
    bool odd = below(5) == 0;
    float spread = powf(2.0f, between(-8.0f, 4.0f));
    c->point_count = 1 + below(RATE_POINTS);
    for (uint32_t i = 0; i < RATE_POINTS; i++) {
        for (int k = 0; k < 3; k++) {
            c->points.positions[k][i] = odd && below(4) == 0 ? special() : between(-spread, spread);
            c->points.normals[k][i] = odd && below(4) == 0 ? 0.0f : between(-1.0f, 1.0f);
        }
        c->points.heights[i] = between(-0.1f, 0.1f) * spread;
        c->points.density_squares[i] = odd && below(3) == 0 ? special() : powf(2.0f, between(-2.0f, 20.0f));
        c->points.shortest_squares[i] = powf(2.0f, between(-20.0f, 2.0f));
    }
    c->edge_count = 1 + below(EDGES);
    for (uint32_t i = 0; i < c->edge_count; i++) {
        uint32_t a = below(c->point_count), b = below(8) == 0 ? a : below(c->point_count);
        c->edges[i] = (clast_rate_edge){a | b << 8 | below(65536) << 16, between(-0.1f, 0.1f) * spread};
        c->apart[i] = 1 + below(below(2) == 0 ? 4 : WEIGHT_ONE);
        for (int k = 0; k < 16; k++) {
            c->middles[i].of[k] = between(-spread, spread);
        }
    }
}

// Depths of places, which never fall; now and then there is nothing.
static float depths[ACROSS * DOWN][OCCLUSION_DEPTHS];

static void hide_some(clast_source_view *view)
{
    float far_away = powf(2.0f, between(-3.0f, 6.0f));
    for (uint32_t i = 0; i < ACROSS * DOWN; i++) {
        float depth = between(0.0f, far_away);
        for (uint32_t k = 0; k < OCCLUSION_DEPTHS; k++) {
            depths[i][k] = depth;
            depth = below(40) == 0 ? 1e30f : depth + (below(4) == 0 ? between(0.0f, 0.3f * far_away) : 0.0f);
        }
    }
    view->places = (packed2){{(float)ACROSS - between(0.0f, 1.0f), (float)DOWN - between(0.0f, 1.0f)}};
    view->places_across = ACROSS;
    view->places_down = DOWN;
    view->deviation = below(3) == 0 ? 0.0f : between(0.0f, 0.2f * far_away);
    view->depths = store_address((uint64_t)(uintptr_t)depths);
}

static clast_rate_view make_view(void)
{
    clast_source_view view = {
        .eye = {{between(-9, 9), between(-9, 9), between(-9, 9)}},
        .pixels = between(10.0f, 2000.0f),
        .rate = between(0.1f, 2.0f),
        .extent = {{between(0.01f, 1.0f), between(0.01f, 1.0f)}},
        .near_plane = below(2) == 0 ? 0.0f : between(0.001f, 1.0f),
        .projection = below(4) == 0 ? CLAST_PROJECTION_ORTHOGRAPHIC : CLAST_PROJECTION_PERSPECTIVE,
        .metric = below(4),
        .segment = between(0.5f, 10.0f),
        .hidden_fraction = between(0.0f, 1.0f),
        .alone = below(3) != 0,
        .hidden = below(5) == 0,
    };
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 4; k++) {
            view.to_camera.rows[row].v[k] = between(-1.0f, 1.0f) * (k == 3 ? 5.0f : 1.0f);
        }
    }
    if (below(4) == 0) { // all there is lies within the picture
        view.extent = (packed2){{100.0f, 100.0f}};
        view.to_camera.rows[2] = (packed4){{0.01f, 0.01f, 0.01f, 50.0f}};
    }
    if (below(3) != 0) {
        hide_some(&view);
    }
    return rate_view(view, below(2));
}

// ---------------------------------------------------------------------------------------------------------- one by one

static vec3 three(const float arrays[3][RATE_POINTS], uint32_t i)
{
    return vec3(arrays[0][i], arrays[1][i], arrays[2][i]);
}

static clast_rate_point point_of(clast_rate_view view, const cluster *c, uint32_t i)
{
    vec3 normal = three(c->points.normals, i);
    return rate_point(view, displaced_point(three(c->points.positions, i), normal, c->points.heights[i]), normal);
}

static uint32_t level_of(clast_rate_view view, const cluster *c, uint32_t i)
{
    vec3 camera = transform_point(view.to_camera, three(c->points.positions, i));
    float level = vertex_level(view, camera, c->points.density_squares[i], c->points.shortest_squares[i]);
    return (uint32_t)(level * (float)HEIGHT_LEVEL_STEPS);
}

static clast_rate_point middle_of(clast_rate_view view, const cluster *c, const clast_rate_edges *job, uint32_t i)
{
    if (job->middles != NULL) {
        const float *of = job->middles[i].of;
        return (clast_rate_point){{{of[6], of[7], of[8]}}, {{of[9], of[10]}}, of[11]};
    }
    uint32_t a = c->edges[i].ends & 255, b = c->edges[i].ends >> 8 & 255;
    vec3 pa = three(c->points.positions, a), pb = three(c->points.positions, b);
    vec3 na = three(c->points.normals, a), nb = three(c->points.normals, b);
    vec3 normal = (na + nb) * 0.5f, position = (pa + pb) * 0.5f;
    if (job->curved) {
        position = (pa + pb) * 0.125f + curved_edge_term(pa, pb, na, nb, 0.5f, 0.5f) * 3.0f;
    }
    return rate_point(view, displaced_point(position, normal, c->edges[i].height * job->scale), normal);
}

static uint32_t factor_of(clast_rate_view view, const cluster *c, const clast_rate_edges *job, uint32_t i)
{
    uint32_t a = c->edges[i].ends & 255, b = c->edges[i].ends >> 8 & 255;
    if (a == b) {
        return 1;
    }
    clast_rate_point middle = middle_of(view, c, job, i);
    clast_rate_point from = point_of(view, c, a), to = point_of(view, c, b);
    float wanted = edge_wanted(view, from, middle, to, clast_rate_open(&view, from, middle, to));
    return edge_factor(wanted, job->apart != NULL ? job->apart[i] : WEIGHT_ONE);
}

static void assert_same(cluster *c, clast_rate_view view, const clast_rate_kernels *kernels, const char *set)
{
    clast_rate_edges job = {.sites = c->sites, .edges = c->edges, .count = c->edge_count};
    job.scale = between(-2.0f, 2.0f);
    job.curved = below(2) == 0;
    job.apart = below(2) == 0 ? c->apart : NULL;
    job.middles = below(2) == 0 ? c->middles : NULL;
    kernels->points(&view, &c->points, c->point_count, c->sites, c->levels);
    c->factors[c->edge_count] = 12345;
    kernels->edges(&view, &job, c->factors);
    assert_int_equal(c->factors[c->edge_count], 12345);
    for (uint32_t i = 0; i < c->point_count; i++) {
        if (c->levels[i] != level_of(view, c, i)) {
            fail_msg("%s: point %u has level %u instead of %u", set, i, c->levels[i], level_of(view, c, i));
        }
    }
    for (uint32_t i = 0; i < c->edge_count; i++) {
        uint32_t wanted = factor_of(view, c, &job, i);
        if (c->factors[i] != wanted) {
            fail_msg("%s: edge %u of %u has %u segments instead of %u", set, i, c->edge_count, c->factors[i], wanted);
        }
    }
}

static void many_edges_have_the_segments_of_single_ones(void **state)
{
    (void)state;
    cluster *c = aligned_alloc(64, (sizeof *c + 63) / 64 * 64);
    memset(c, 0, sizeof *c);
    for (uint32_t round = 0; round < ROUNDS; round++) {
        make_cluster(c);
        clast_rate_view view = make_view();
        for (size_t i = 0; i < sizeof all_sets / sizeof *all_sets && all_sets[i] <= clast_isa_best(); i++) {
            assert_same(c, view, clast_rate_kernels_of(all_sets[i]), clast_isa_text(all_sets[i]));
        }
    }
    free(c);
}

// Sites hold what single points come to, to the bit.
static void sites_have_the_bits_of_single_points(void **state)
{
    (void)state;
    cluster *c = aligned_alloc(64, (sizeof *c + 63) / 64 * 64);
    memset(c, 0, sizeof *c);
    make_cluster(c);
    for (int round = 0; round < 50; round++) {
        clast_rate_view view = make_view();
        for (size_t i = 0; i < sizeof all_sets / sizeof *all_sets && all_sets[i] <= clast_isa_best(); i++) {
            clast_rate_kernels_of(all_sets[i])->points(&view, &c->points, c->point_count, c->sites, c->levels);
            for (uint32_t k = 0; k < c->point_count; k++) {
                clast_rate_point wanted = point_of(view, c, k);
                assert_memory_equal(&c->sites[k].of[RATE_CAMERA], &wanted.camera, sizeof wanted.camera);
                assert_memory_equal(&c->sites[k].of[RATE_SCREEN], &wanted.screen, sizeof wanted.screen);
                assert_memory_equal(&c->sites[k].of[RATE_FACING], &wanted.facing, sizeof wanted.facing);
            }
        }
    }
    free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_edges_have_the_segments_of_single_ones),
        cmocka_unit_test(sites_have_the_bits_of_single_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
