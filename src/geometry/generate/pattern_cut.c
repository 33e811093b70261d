// SPDX-License-Identifier: Apache-2.0
// A pattern's triangles shall be well shaped where they are seen: edges have segments because they are long, so the shape
// that counts is that of a triangle whose sides are as long as their counts. Lengths in it are exact integers: the square of a
// difference d of weights is -(s0 d0 d1 + s1 d1 d2 + s2 d2 d0), with the squares of the sides. Where there is no such triangle,
// or a very thin one, the sides' squares grow by one number until it is thick enough: that blends it with an equilateral one.
//
// Points are put inside one by one, in one of the largest triangles. After each, sides are exchanged between the two triangles
// they part (flips) and points are moved, as long as the sum of the triangles' faults falls (Freitag and Ollivier-Gooch 1997,
// "Tetrahedral mesh improvement using swapping and smoothing"). A fault is the inverse of a triangle's mean ratio, area over
// the sum of its sides' squares, to a power that makes one bad triangle worse than several middling ones. The best of a few
// tries is kept. Where all counts are the same, the points are those of a lattice.
#include "geometry/generate/pattern_cut.h"

#include <string.h>

enum {
    NO_TRIANGLE = 255,
    LARGEST_STEP = 2048, // of moving a point, in weights
    COARSE_STEP = 256,   // the last one while there are points to come
    SWEEPS_MOST = 64,
    LEAST_TRIES = 4,
    MORE_TRIES = 40,  // shared among the points: few are tried at more places
    SQUARE_UNIT = 16, // the square of a side of one segment
};
static const uint64_t fault_one = 1u << 12;     // of an equilateral triangle
static const uint64_t inverse_most = 1u << 22;  // of its mean ratio
static const uint64_t fault_worst = 1ull << 52; // of one without area

typedef struct cut {
    uint32_t around, vertex_count, triangle_count;
    int64_t squares[3]; // of the sides
    uint64_t area_root; // the root of 48 times the square of the area
    int32_t weights[PATTERN_VERTICES][3];
    uint8_t corners[PATTERN_TRIANGLES][3];
    uint8_t on_left[PATTERN_VERTICES][PATTERN_VERTICES]; // the triangle that has a side in this direction
} cut;

// ----------------------------------------------------------------------------------------------------------- measures

static uint64_t root_of(uint64_t square)
{
    uint64_t root = 0;
    for (uint64_t bit = 1ull << 31; bit != 0; bit >>= 1) {
        if ((root | bit) * (root | bit) <= square) {
            root |= bit;
        }
    }
    return root;
}

// 16 times the square of the area of a triangle, from its sides' squares (Heron); not positive where there is none.
static int64_t area_square(const int64_t s[3])
{
    return 2 * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) - (s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
}

// Sides as long as their counts, in a triangle whose mean ratio is at least a half.
static void choose_metric(cut *c, uint32_t factors)
{
    for (uint32_t edge = 0; edge < 3; edge++) {
        int64_t count = pattern_factor(factors, edge);
        c->squares[edge] = SQUARE_UNIT * count * count;
    }
    for (;;) {
        int64_t area = area_square(c->squares), sum = c->squares[0] + c->squares[1] + c->squares[2];
        if (area > 0 && 12 * area >= sum * sum) {
            c->area_root = root_of(3 * (uint64_t)area);
            return;
        }
        for (uint32_t edge = 0; edge < 3; edge++) {
            c->squares[edge]++;
        }
    }
}

static int64_t length_square(const cut *c, uint32_t a, uint32_t b)
{
    int64_t d[3];
    for (uint32_t k = 0; k < 3; k++) {
        d[k] = c->weights[a][k] - c->weights[b][k];
    }
    return -(c->squares[0] * d[0] * d[1] + c->squares[1] * d[1] * d[2] + c->squares[2] * d[2] * d[0]);
}

// Twice the area, the whole being WEIGHT_ONE squared.
static int64_t area_of(const cut *c, uint32_t i, uint32_t j, uint32_t k)
{
    const int32_t *p = c->weights[i], *q = c->weights[j], *r = c->weights[k];
    return (int64_t)(q[1] - p[1]) * (r[2] - p[2]) - (int64_t)(q[2] - p[2]) * (r[1] - p[1]);
}

static uint64_t fault_of(const cut *c, uint32_t i, uint32_t j, uint32_t k)
{
    int64_t area = area_of(c, i, j, k);
    if (area <= 0) {
        return fault_worst;
    }
    uint64_t sum = (uint64_t)(length_square(c, i, j) + length_square(c, j, k) + length_square(c, k, i));
    uint64_t inverse = sum * fault_one / ((uint64_t)area * c->area_root);
    inverse = inverse < inverse_most ? inverse : inverse_most;
    return (inverse * inverse / fault_one) * inverse / fault_one;
}

// ---------------------------------------------------------------------------------------------------------- triangles

static void set_triangle(cut *c, uint32_t triangle, uint32_t i, uint32_t j, uint32_t k)
{
    const uint8_t corners[3] = {(uint8_t)i, (uint8_t)j, (uint8_t)k};
    memcpy(c->corners[triangle], corners, sizeof corners);
    c->on_left[i][j] = c->on_left[j][k] = c->on_left[k][i] = (uint8_t)triangle;
}

static uint32_t opposite_of(const cut *c, uint32_t i, uint32_t j)
{
    const uint8_t *corners = c->corners[c->on_left[i][j]];
    return (uint32_t)corners[0] + corners[1] + corners[2] - i - j;
}

// Puts a vertex on the side from i to j, which is a border.
static void part_border(cut *c, uint32_t i, uint32_t j, uint32_t vertex)
{
    uint32_t triangle = c->on_left[i][j], opposite = opposite_of(c, i, j);
    c->on_left[i][j] = NO_TRIANGLE;
    set_triangle(c, triangle, i, vertex, opposite);
    set_triangle(c, c->triangle_count++, vertex, j, opposite);
}

static void part_triangle(cut *c, uint32_t triangle)
{
    uint32_t vertex = c->vertex_count++;
    uint32_t i = c->corners[triangle][0], j = c->corners[triangle][1], k = c->corners[triangle][2];
    int32_t *weights = c->weights[vertex];
    for (uint32_t n = 1; n < 3; n++) {
        weights[n] = (c->weights[i][n] + c->weights[j][n] + c->weights[k][n]) / 3;
    }
    weights[0] = (int32_t)WEIGHT_ONE - weights[1] - weights[2];
    set_triangle(c, triangle, i, j, vertex);
    set_triangle(c, c->triangle_count++, j, k, vertex);
    set_triangle(c, c->triangle_count++, k, i, vertex);
}

static void begin_empty(cut *c, const clast_pattern_shape *shape)
{
    memset(c->on_left, NO_TRIANGLE, sizeof c->on_left);
    c->around = c->vertex_count = shape->vertex_count;
    c->triangle_count = 0;
    for (uint32_t i = 0; i < shape->vertex_count; i++) {
        clast_weights weights = weights_of(shape->vertices[i]);
        for (uint32_t k = 0; k < 3; k++) {
            c->weights[i][k] = (int32_t)weights.of[k];
        }
    }
}

static void begin(cut *c, const clast_pattern_shape *shape)
{
    begin_empty(c, shape);
    choose_metric(c, shape->factors);
    set_triangle(c, c->triangle_count++, 0, 1, 2);
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t first = pattern_edge_begin(shape->factors, edge), end = pattern_edge_begin(shape->factors, edge + 1);
        for (uint32_t vertex = first; vertex < end; vertex++) {
            part_border(c, vertex == first ? edge : vertex - 1, (edge + 1) % 3, vertex);
        }
    }
}

// -------------------------------------------------------------------------------------------------------- improvements

// Exchanges the side from i to j for the other diagonal of its two triangles, where that is better.
static bool flip(cut *c, uint32_t i, uint32_t j)
{
    uint32_t left = c->on_left[i][j], right = c->on_left[j][i];
    uint32_t k = opposite_of(c, i, j), m = opposite_of(c, j, i);
    uint64_t before = fault_of(c, i, j, k) + fault_of(c, j, i, m);
    if (fault_of(c, i, m, k) + fault_of(c, m, j, k) >= before) {
        return false;
    }
    c->on_left[i][j] = c->on_left[j][i] = NO_TRIANGLE;
    set_triangle(c, left, i, m, k);
    set_triangle(c, right, m, j, k);
    return true;
}

static bool flip_all(cut *c)
{
    bool any = false;
    for (uint32_t triangle = 0; triangle < c->triangle_count; triangle++) {
        for (uint32_t side = 0; side < 3; side++) {
            uint32_t i = c->corners[triangle][side], j = c->corners[triangle][(side + 1) % 3];
            if (c->on_left[j][i] != NO_TRIANGLE) {
                any |= flip(c, i, j);
            }
        }
    }
    return any;
}

// The sum of the faults of a point's triangles, whose other corners are `sides`.
static uint64_t fault_around(const cut *c, uint32_t vertex, uint8_t (*sides)[2], uint32_t count)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        sum += fault_of(c, sides[i][0], sides[i][1], vertex);
    }
    return sum;
}

static uint32_t sides_around(const cut *c, uint32_t vertex, uint8_t (*sides)[2])
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->triangle_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            if (c->corners[i][k] == vertex) {
                sides[count][0] = c->corners[i][(k + 1) % 3];
                sides[count++][1] = c->corners[i][(k + 2) % 3];
            }
        }
    }
    return count;
}

// Moves a point by `step` along the side that is best, if any is.
static bool move(cut *c, uint32_t vertex, int32_t step)
{
    uint8_t sides[PATTERN_TRIANGLES][2];
    uint32_t count = sides_around(c, vertex, sides);
    uint64_t best = fault_around(c, vertex, sides, count);
    int32_t here[3], *weights = c->weights[vertex];
    int32_t found[3];
    memcpy(here, weights, sizeof here);
    memcpy(found, weights, sizeof found);
    for (uint32_t direction = 0; direction < 6; direction++) {
        uint32_t from = direction / 2, to = (from + 1 + direction % 2) % 3;
        memcpy(weights, here, sizeof here);
        weights[from] -= step;
        weights[to] += step;
        uint64_t fault = fault_around(c, vertex, sides, count);
        if (fault < best) {
            best = fault;
            memcpy(found, weights, sizeof found);
        }
    }
    memcpy(weights, found, sizeof found);
    return memcmp(found, here, sizeof here) != 0;
}

static bool move_all(cut *c, int32_t step)
{
    bool any = false;
    for (uint32_t vertex = c->around; vertex < c->vertex_count; vertex++) {
        any |= move(c, vertex, step);
    }
    return any;
}

static void improve(cut *c, int32_t last_step)
{
    for (int32_t step = LARGEST_STEP; step >= last_step; step /= 2) {
        for (uint32_t sweep = 0; sweep < SWEEPS_MOST; sweep++) {
            bool flipped = flip_all(c);
            if (!move_all(c, step) && !flipped) {
                break;
            }
        }
    }
}

// Marsaglia 2003, xorshift.
static uint32_t next_number(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

// The largest one, or now and then another of more than half its size.
static uint32_t large_triangle(const cut *c, uint32_t *numbers)
{
    uint32_t largest = 0;
    int64_t most = 0;
    for (uint32_t i = 0; i < c->triangle_count; i++) {
        int64_t area = area_of(c, c->corners[i][0], c->corners[i][1], c->corners[i][2]);
        area *= 128 + (next_number(numbers) & 127);
        if (area > most) {
            most = area;
            largest = i;
        }
    }
    return largest;
}

// ------------------------------------------------------------------------------------------------------------ lattice

// The point of a lattice of n segments a side that is i steps towards corner 1 and j towards corner 2: the edges' points are
// there, others are made.
static uint32_t lattice_point(cut *c, uint32_t n, uint32_t i, uint32_t j)
{
    int32_t second = (int32_t)pattern_edge_weight(n, i), third = (int32_t)pattern_edge_weight(n, j);
    for (uint32_t vertex = 0; vertex < c->vertex_count; vertex++) {
        if (c->weights[vertex][1] == second && c->weights[vertex][2] == third) {
            return vertex;
        }
    }
    const int32_t weights[3] = {(int32_t)WEIGHT_ONE - second - third, second, third};
    memcpy(c->weights[c->vertex_count], weights, sizeof weights);
    return c->vertex_count++;
}

static void cut_lattice(cut *c, const clast_pattern_shape *shape)
{
    begin_empty(c, shape);
    uint32_t n = pattern_factor(shape->factors, 0);
    for (uint32_t j = 0; j < n; j++) {
        for (uint32_t i = 0; i + j < n; i++) {
            uint32_t a = lattice_point(c, n, i, j), b = lattice_point(c, n, i + 1, j),
                     d = lattice_point(c, n, i, j + 1);
            set_triangle(c, c->triangle_count++, a, b, d);
            if (i + j + 2 <= n) {
                set_triangle(c, c->triangle_count++, b, lattice_point(c, n, i + 1, j + 1), d);
            }
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- counts

// As many points as make triangles of the size of an equilateral one with sides of one segment, where sides are as long as
// their counts. Euler's formula wants `around - 2 + 2 * inside` triangles; rounded.
static uint32_t inside_by_area(const int64_t count[3])
{
    const int64_t squares[3] = {count[0] * count[0], count[1] * count[1], count[2] * count[2]};
    int64_t area = area_square(squares), around = count[0] + count[1] + count[2];
    uint32_t inside = 0;
    for (int64_t least = around - 1; area > 0 && area >= 3 * least * least; least += 2) { // triangles at inside + 1/2
        inside++;
    }
    return inside;
}

// At least as many as where counts are smaller: a triangle that is longer than its other sides reach has no area.
uint32_t clast_pattern_inside(uint32_t factors)
{
    uint32_t most = 0;
    int64_t count[3];
    for (count[0] = 1; count[0] <= pattern_factor(factors, 0); count[0]++) {
        for (count[1] = 1; count[1] <= pattern_factor(factors, 1); count[1]++) {
            for (count[2] = 1; count[2] <= pattern_factor(factors, 2); count[2]++) {
                uint32_t inside = inside_by_area(count);
                most = inside > most ? inside : most;
            }
        }
    }
    return most;
}

static uint64_t fault_of_all(const cut *c)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < c->triangle_count; i++) {
        sum += fault_of(c, c->corners[i][0], c->corners[i][1], c->corners[i][2]);
    }
    return sum;
}

static void cut_freely(cut *best, const clast_pattern_shape *shape, uint32_t inside)
{
    uint32_t numbers = shape->factors;
    uint64_t least = UINT64_MAX;
    uint32_t tries = inside != 0 ? LEAST_TRIES + MORE_TRIES / inside : 1;
    for (uint32_t i = 0; i < tries; i++) {
        cut c;
        begin(&c, shape);
        for (uint32_t points = 0; points < inside; points++) {
            part_triangle(&c, large_triangle(&c, &numbers));
            improve(&c, COARSE_STEP);
        }
        improve(&c, 1);
        uint64_t fault = fault_of_all(&c);
        if (fault < least) {
            least = fault;
            *best = c;
        }
    }
}

static void store(const cut *c, clast_pattern_shape *shape)
{
    for (uint32_t i = c->around; i < c->vertex_count; i++) {
        shape->vertices[i] = (uint32_t)c->weights[i][1] | (uint32_t)c->weights[i][2] << 16;
    }
    for (uint32_t i = 0; i < c->triangle_count; i++) {
        shape->triangles[i] = c->corners[i][0] | (uint32_t)c->corners[i][1] << 8 | (uint32_t)c->corners[i][2] << 16;
    }
    shape->vertex_count = c->vertex_count;
    shape->triangle_count = c->triangle_count;
    clast_pattern_shape_order(shape);
}

void clast_pattern_cut(clast_pattern_shape *shape, uint32_t factors)
{
    cut c;
    clast_pattern_shape_begin(shape, factors);
    if (pattern_factor(factors, 0) == pattern_factor(factors, 2)) {
        cut_lattice(&c, shape);
    } else {
        cut_freely(&c, shape, clast_pattern_inside(factors));
    }
    store(&c, shape);
}
