// SPDX-License-Identifier: Apache-2.0
// The table of patterns: what must hold of each, of neighbours, and of tables that others make.
#include <math.h>
#include <string.h>

#include "test.h"

#include "geometry/pattern.h"

// Another table than this is another picture: of the library's own one, on every machine.
#define OWN_HASH 0x257512d8d043892du

enum { SEGMENTS = PATTERN_SEGMENTS };

// A triple, and its pattern as the triangle sees it.
typedef struct seen {
    uint32_t count[3];
    uint32_t vertex_count, triangle_count;
    uint32_t weights[PATTERN_VERTICES][3];
    uint32_t corners[PATTERN_TRIANGLES][3];
    uint32_t edges[3][SEGMENTS + 1]; // vertices along each edge, from corner k to corner k + 1
} seen;

static void see(uint32_t x, uint32_t y, uint32_t z, seen *s)
{
    const clast_pattern_table *table = &clast_patterns;
    clast_pattern_use use = pattern_use(pattern_factors(x, y, z));
    const clast_pattern *pattern = &table->patterns[use.number];
    *s = (seen){.count = {x, y, z}};
    s->vertex_count = pattern_vertices(*pattern);
    s->triangle_count = pattern_triangles(*pattern);
    assert_in_range(s->vertex_count, 3, PATTERN_VERTICES);
    assert_in_range(s->triangle_count, 1, PATTERN_TRIANGLES);
    for (uint32_t i = 0; i < s->vertex_count; i++) {
        clast_weights weights = weights_of(table->vertices[pattern->first_vertex + i]);
        memcpy(s->weights[i], pattern_unrotate(weights, use.rotation).of, sizeof s->weights[i]);
    }
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            s->corners[i][k] = table->triangles[pattern->first_triangle + i] >> (8 * k) & 255u;
            assert_true(s->corners[i][k] < s->vertex_count);
        }
    }
    for (uint32_t k = 0; k < 3; k++) { // the pattern's edge k is the triangle's edge k + rotation
        uint32_t edge = (k + use.rotation) % 3, begin = pattern_edge_begin(pattern_own_factors(*pattern), k);
        assert_int_equal(pattern_factor(pattern_own_factors(*pattern), k), s->count[edge]);
        s->edges[edge][0] = k;
        for (uint32_t step = 1; step < s->count[edge]; step++) {
            s->edges[edge][step] = begin + step - 1;
        }
        s->edges[edge][s->count[edge]] = (k + 1) % 3;
    }
}

typedef void (*triple_check)(const seen *s);

static void for_all_triples(triple_check check)
{
    seen s;
    for (uint32_t i = 0; i < SEGMENTS * SEGMENTS * SEGMENTS; i++) {
        see(i % SEGMENTS + 1, i / SEGMENTS % SEGMENTS + 1, i / (SEGMENTS * SEGMENTS) + 1, &s);
        check(&s);
    }
}

static int64_t area_of(const seen *s, uint32_t i, uint32_t j, uint32_t k)
{
    int64_t p[3][2];
    const uint32_t vertices[3] = {i, j, k};
    for (int n = 0; n < 3; n++) {
        p[n][0] = s->weights[vertices[n]][1];
        p[n][1] = s->weights[vertices[n]][2];
    }
    return (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
}

// ------------------------------------------------------------------------------------------------------------ numbers

static void rotations_of_a_triple_share_a_pattern(void **state)
{
    (void)state;
    uint32_t uses[PATTERN_COUNT] = {0};
    for (uint32_t i = 0; i < SEGMENTS * SEGMENTS * SEGMENTS; i++) {
        uint32_t x = i % SEGMENTS + 1, y = i / SEGMENTS % SEGMENTS + 1, z = i / (SEGMENTS * SEGMENTS) + 1;
        clast_pattern_use use = pattern_use(pattern_factors(x, y, z));
        assert_true(use.number < PATTERN_COUNT && use.rotation < 3);
        assert_int_equal(pattern_use(pattern_factors(y, z, x)).number, use.number);
        uses[use.number]++;
        uint32_t mirrored = pattern_use(pattern_factors(x, z, y)).number;
        bool differ = x != y && y != z && z != x;
        assert_true((mirrored == use.number) == !differ);
        assert_true(mirrored < PATTERN_ORDERED || use.number < PATTERN_ORDERED);
    }
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        assert_true(uses[i] == 3 || (uses[i] == 1 && clast_patterns.patterns[i].counts % 16 ==
                                                         (clast_patterns.patterns[i].counts >> 8) % 16));
    }
}

// ------------------------------------------------------------------------------------------------------------- edges

static void check_edges(const seen *s)
{
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t n = s->count[edge], second = (edge + 1) % 3, opposite = (edge + 2) % 3;
        for (uint32_t step = 0; step <= n; step++) {
            const uint32_t *weights = s->weights[s->edges[edge][step]];
            uint32_t nearest = (uint32_t)lround(32768.0 * step / n); // nowhere is it half way
            assert_int_equal(weights[second], nearest);
            assert_int_equal(weights[edge], 32768 - nearest);
            assert_int_equal(weights[opposite], 0);
            const uint32_t *other_way = s->weights[s->edges[edge][n - step]];
            assert_int_equal(weights[second] + other_way[second], 32768);
        }
    }
}

static void neighbours_have_the_same_points_on_their_edge(void **state)
{
    (void)state;
    for_all_triples(check_edges);
}

static void edge_points_are_had_from_the_count_alone(void **state)
{
    (void)state;
    for (uint32_t edge = 0; edge < 3; edge++) {
        for (uint32_t n = 1; n <= SEGMENTS; n++) {
            uint32_t factors = pattern_factors(edge == 0 ? n : 3, edge == 1 ? n : 3, edge == 2 ? n : 3);
            seen s;
            see(pattern_factor(factors, 0), pattern_factor(factors, 1), pattern_factor(factors, 2), &s);
            for (uint32_t step = 0; step <= n; step++) {
                clast_weights point = pattern_edge_point(edge, n, step);
                assert_memory_equal(point.of, s.weights[s.edges[edge][step]], sizeof point.of);
            }
        }
    }
}

// ------------------------------------------------------------------------------------------------------------- cover

static void check_cover(const seen *s)
{
    uint32_t around = s->count[0] + s->count[1] + s->count[2];
    assert_int_equal(s->triangle_count, 2 * s->vertex_count - around - 2);
    uint8_t sides[PATTERN_VERTICES][PATTERN_VERTICES] = {{0}};
    int64_t sum = 0;
    for (uint32_t i = 0; i < s->triangle_count; i++) {
        int64_t area = area_of(s, s->corners[i][0], s->corners[i][1], s->corners[i][2]);
        assert_true(area > 0);
        sum += area;
        for (uint32_t k = 0; k < 3; k++) {
            uint8_t *side = &sides[s->corners[i][k]][s->corners[i][(k + 1) % 3]];
            assert_int_equal(*side, 0);
            *side = 1;
        }
    }
    assert_int_equal(sum, 1 << 30);
    uint32_t border = 0;
    for (uint32_t edge = 0; edge < 3; edge++) {
        for (uint32_t step = 0; step < s->count[edge]; step++) {
            uint32_t a = s->edges[edge][step], b = s->edges[edge][step + 1];
            assert_int_equal(sides[a][b], 1);
            assert_int_equal(sides[b][a], 0);
            border++;
        }
    }
    uint32_t alone = 0;
    for (uint32_t a = 0; a < s->vertex_count; a++) {
        uint32_t used = 0;
        for (uint32_t b = 0; b < s->vertex_count; b++) {
            alone += sides[a][b] && !sides[b][a];
            used += sides[a][b];
        }
        assert_true(used > 0);
        assert_int_equal(s->weights[a][0] + s->weights[a][1] + s->weights[a][2], 32768);
    }
    assert_int_equal(alone, border);
}

static void triangles_cover_the_whole_and_share_their_sides(void **state)
{
    (void)state;
    for_all_triples(check_cover);
}

// A point that lies on no side is in one triangle.
static void check_points(const seen *s)
{
    uint32_t number = 1 + s->count[0] + 16 * s->count[1] + 256 * s->count[2];
    for (uint32_t i = 0; i < 20; i++) {
        number = number * 1664525u + 1013904223u;
        int64_t x = 1 + (number >> 8) % 32766, y = 1 + (int64_t)((number >> 4) * 7919u >> 9) % (32767 - x);
        uint32_t inside = 0, touching = 0;
        for (uint32_t t = 0; t < s->triangle_count; t++) {
            int64_t least = INT64_MAX;
            for (uint32_t k = 0; k < 3; k++) {
                const uint32_t *a = s->weights[s->corners[t][k]], *b = s->weights[s->corners[t][(k + 1) % 3]];
                int64_t side = ((int64_t)b[1] - a[1]) * (y - a[2]) - ((int64_t)b[2] - a[2]) * (x - a[1]);
                least = side < least ? side : least;
            }
            inside += least > 0;
            touching += least == 0;
        }
        assert_true(touching > 0 ? inside == 0 : inside == 1);
    }
}

static void each_point_is_in_one_triangle(void **state)
{
    (void)state;
    for_all_triples(check_points);
}

// ------------------------------------------------------------------------------------------------------------- counts

static uint32_t triangles_of(uint32_t x, uint32_t y, uint32_t z)
{
    return pattern_triangles(*clast_pattern_of(&clast_patterns, pattern_factors(x, y, z)));
}

static uint32_t vertices_of(uint32_t x, uint32_t y, uint32_t z)
{
    return pattern_vertices(*clast_pattern_of(&clast_patterns, pattern_factors(x, y, z)));
}

static void check_growth(const seen *s)
{
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t more[3] = {s->count[0], s->count[1], s->count[2]};
        if (++more[edge] <= SEGMENTS) {
            assert_true(triangles_of(more[0], more[1], more[2]) > s->triangle_count);
            assert_true(vertices_of(more[0], more[1], more[2]) > s->vertex_count);
        }
    }
}

static void more_segments_are_more_triangles(void **state)
{
    (void)state;
    for_all_triples(check_growth);
}

static void few_segments_are_few_triangles(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= SEGMENTS; n++) {
        assert_int_equal(triangles_of(n, n, n), n * n);
        assert_int_equal(vertices_of(n, n, n), (n + 1) * (n + 2) / 2);
        assert_int_equal(triangles_of(n, 1, 1), n);
    }
    assert_int_equal(triangles_of(2, 2, 1), 3);
    assert_int_equal(triangles_of(3, 2, 2), 5);
    assert_int_equal(triangles_of(11, 11, 1), 21);
}

// ------------------------------------------------------------------------------------------------------------- shapes

// The mean ratio of a triangle of the pattern where its edges are as long as their counts: 1 where it is equilateral.
static double ratio_of(const seen *s, const uint32_t corners[3])
{
    double squares[3], sum = 0.0, product = 0.0, squared = 0.0;
    for (int k = 0; k < 3; k++) {
        squares[k] = (double)s->count[k] * s->count[k];
    }
    for (int k = 0; k < 3; k++) {
        double d[3];
        for (int n = 0; n < 3; n++) {
            d[n] = ((double)s->weights[corners[k]][n] - s->weights[corners[(k + 1) % 3]][n]) / 32768.0;
            product += k == 0 ? squares[n] * squares[(n + 1) % 3] : 0.0;
            squared += k == 0 ? squares[n] * squares[n] : 0.0;
        }
        sum -= squares[0] * d[0] * d[1] + squares[1] * d[1] * d[2] + squares[2] * d[2] * d[0];
    }
    double area = sqrt(2.0 * product - squared) / 4.0 * (double)area_of(s, corners[0], corners[1], corners[2]) /
                  (1 << 30);
    return 4.0 * sqrt(3.0) * area / sum;
}

static void triangles_are_well_shaped_where_edges_are_as_long_as_their_counts(void **state)
{
    (void)state;
    double sum = 0.0, least = 1.0;
    uint32_t count = 0;
    seen s;
    for (uint32_t x = 1; x <= SEGMENTS; x++) {
        for (uint32_t y = 1; y <= x; y++) {
            for (uint32_t z = x - y + 1; z <= y; z++) {
                see(x, y, z, &s);
                for (uint32_t i = 0; i < s.triangle_count; i++) {
                    double ratio = ratio_of(&s, s.corners[i]);
                    least = ratio < least ? ratio : least;
                    sum += ratio;
                    count++;
                }
            }
        }
    }
    assert_true(sum / count > 0.94); // a fan around the centre comes to 0.40 and 0.01
    assert_true(least > 0.15);       // 11 11 1 itself has a corner of 5 degrees
}

static double block_spread(const seen *s, uint32_t stride)
{
    double sum = 0.0;
    for (uint32_t block = 0; block < s->triangle_count / 8; block++) {
        uint32_t lower[2] = {32768, 32768}, upper[2] = {0, 0};
        for (uint32_t i = 0; i < 24; i++) {
            uint32_t triangle = (8 * block + i / 3) * stride % s->triangle_count;
            for (int axis = 0; axis < 2; axis++) {
                uint32_t weight = s->weights[s->corners[triangle][i % 3]][axis + 1];
                lower[axis] = weight < lower[axis] ? weight : lower[axis];
                upper[axis] = weight > upper[axis] ? weight : upper[axis];
            }
        }
        sum += (double)(upper[0] - lower[0]) + (double)(upper[1] - lower[1]);
    }
    return sum;
}

static void each_eight_triangles_are_close_together(void **state)
{
    (void)state;
    seen s;
    for (uint32_t n = 8; n <= SEGMENTS; n++) {
        see(n, n, n, &s);
        assert_true(block_spread(&s, 1) < 0.6 * block_spread(&s, 13));
    }
}

// ------------------------------------------------------------------------------------------------------------- tables

static void read_shapes(clast_pattern_shape *shapes)
{
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        const clast_pattern *pattern = &clast_patterns.patterns[i];
        clast_pattern_shape *shape = &shapes[i];
        shape->factors = pattern_own_factors(*pattern);
        shape->vertex_count = pattern_vertices(*pattern);
        shape->triangle_count = pattern_triangles(*pattern);
        memcpy(shape->vertices, clast_patterns.vertices + pattern->first_vertex,
               sizeof(uint32_t) * shape->vertex_count);
        memcpy(shape->triangles, clast_patterns.triangles + pattern->first_triangle,
               sizeof(uint32_t) * shape->triangle_count);
    }
}

static void the_own_table_is_the_same_on_every_machine(void **state)
{
    (void)state;
    assert_int_equal(clast_patterns.hash, OWN_HASH);
}

static void a_table_of_the_same_patterns_is_the_same(void **state)
{
    clast_context *context = *state;
    static clast_pattern_shape shapes[PATTERN_COUNT];
    read_shapes(shapes);
    clast_pattern_shape *last = &shapes[pattern_number(pattern_factors(11, 10, 9))];
    for (uint32_t i = 0; i < 3; i++) { // in another order
        uint32_t kept = last->triangles[i];
        last->triangles[i] = last->triangles[i + 3];
        last->triangles[i + 3] = kept;
    }
    clast_pattern_table *table;
    assert_ok(context, clast_pattern_table_create(context, "table", shapes, &table));
    assert_int_equal(table->vertex_count, clast_patterns.vertex_count);
    assert_int_equal(table->triangle_count, clast_patterns.triangle_count);
    assert_memory_equal(table->patterns, clast_patterns.patterns, PATTERN_COUNT * sizeof *table->patterns);
    assert_memory_equal(table->vertices, clast_patterns.vertices, table->vertex_count * sizeof(uint32_t));
    assert_memory_equal(table->triangles, clast_patterns.triangles, table->triangle_count * sizeof(uint32_t));
    assert_int_equal(table->hash, clast_patterns.hash);
    clast_pattern_table_free(context, table);
}

static void refuse(clast_context *context, clast_pattern_shape *shapes, const char *words)
{
    clast_pattern_table *table = NULL;
    assert_int_equal(clast_pattern_table_create(context, "table", shapes, &table), CLAST_ERROR_MALFORMED);
    if (strstr(clast_context_error(context), words) == NULL) {
        fail_msg("expected \"%s\", got \"%s\"", words, clast_context_error(context));
    }
    assert_null(table);
    read_shapes(shapes);
}

// All of its vertices belong to others too.
static uint32_t triangle_without_corners(const clast_pattern_shape *shape)
{
    for (uint32_t i = 0;; i++) {
        uint32_t word = shape->triangles[i];
        if ((word & 255u) > 2 && (word >> 8 & 255u) > 2 && word >> 16 > 2) {
            return i;
        }
    }
}

static void faults_of_a_table_are_named(void **state)
{
    clast_context *context = *state;
    static clast_pattern_shape shapes[PATTERN_COUNT];
    read_shapes(shapes);
    clast_pattern_shape *some = &shapes[pattern_number(pattern_factors(5, 4, 4))];
    uint32_t inside = pattern_edge_begin(some->factors, 3);
    some->vertices[inside] = 20000 | 12768u << 16;
    refuse(context, shapes, "table: pattern 5 4 4: a point lies not within the triangle");
    some->vertices[inside] = 0;
    refuse(context, shapes, "pattern 5 4 4: a point lies not within the triangle");
    some->triangle_count--;
    refuse(context, shapes, "pattern 5 4 4: its triangles are not as many as its points need");
    some->triangles[3] = some->vertex_count | (some->triangles[3] & 0xffff00u);
    refuse(context, shapes, "pattern 5 4 4: a triangle's corner is none of its vertices");
    some->triangles[3] = (some->triangles[3] >> 8 & 255u) | (some->triangles[3] & 255u) << 8 |
                         (some->triangles[3] & 0xff0000u);
    refuse(context, shapes, "pattern 5 4 4: a triangle has no area, or goes clockwise");
    uint32_t middle = triangle_without_corners(some);
    some->triangles[middle] = some->triangles[middle == 0 ? 1 : 0];
    refuse(context, shapes, "pattern 5 4 4: two triangles lie on one side of a line");
    some->triangles[middle] = 0 | 1 << 8 | 2 << 16;
    refuse(context, shapes, "pattern 5 4 4: a triangle's side is neither another's nor an edge's segment");
    some->vertices[inside] = some->vertices[inside + 1];
    refuse(context, shapes, "pattern 5 4 4: a triangle has no area, or goes clockwise");
    some->vertices[inside] = 1 | 1u << 16; // turns some of its triangles over
    refuse(context, shapes, "pattern 5 4 4: a triangle has no area, or goes clockwise");

    clast_pattern_shape *small = &shapes[pattern_number(pattern_factors(2, 1, 1))];
    small->vertices[small->vertex_count++] = 10923 | 10923u << 16;
    small->triangle_count = 4;
    small->triangles[0] = 0 | 3 << 8 | 4 << 16;
    small->triangles[1] = 3 | 1 << 8 | 4 << 16;
    small->triangles[2] = 1 | 2 << 8 | 4 << 16;
    small->triangles[3] = 2 | 0 << 8 | 4 << 16;
    refuse(context, shapes, "pattern 2 1 1: there may be no points inside up to 2 segments an edge");

    // A sound pattern that has one point more than the next.
    clast_pattern_shape *more = &shapes[pattern_number(pattern_factors(3, 1, 1))];
    clast_pattern_shape_begin(more, pattern_factors(3, 1, 1));
    more->vertices[more->vertex_count++] = 10923 | 10923u << 16;
    const uint8_t corners[5][3] = {{0, 3, 5}, {3, 4, 5}, {4, 1, 5}, {1, 2, 5}, {2, 0, 5}};
    for (uint32_t i = 0; i < 5; i++) {
        more->triangles[more->triangle_count++] = corners[i][0] | corners[i][1] << 8 | corners[i][2] << 16;
    }
    refuse(context, shapes, "pattern 3 2 1: it has fewer points inside than one of fewer segments, 3 1 1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rotations_of_a_triple_share_a_pattern),
        cmocka_unit_test(neighbours_have_the_same_points_on_their_edge),
        cmocka_unit_test(edge_points_are_had_from_the_count_alone),
        cmocka_unit_test(triangles_cover_the_whole_and_share_their_sides),
        cmocka_unit_test(each_point_is_in_one_triangle),
        cmocka_unit_test(more_segments_are_more_triangles),
        cmocka_unit_test(few_segments_are_few_triangles),
        cmocka_unit_test(triangles_are_well_shaped_where_edges_are_as_long_as_their_counts),
        cmocka_unit_test(each_eight_triangles_are_close_together),
        cmocka_unit_test(the_own_table_is_the_same_on_every_machine),
        CONTEXT_TEST(a_table_of_the_same_patterns_is_the_same),
        CONTEXT_TEST(faults_of_a_table_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
