// SPDX-License-Identifier: Apache-2.0
// A program of the build: writes the table of patterns as a C file. It can also tell how well shaped they are, beside naive
// ones, and draw them.
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "geometry/generate/pattern_cut.h"

typedef struct table {
    clast_pattern_shape shapes[PATTERN_COUNT];
} table;

static void make_table(table *made)
{
    for (uint32_t x = 1; x <= PATTERN_SEGMENTS; x++) {
        for (uint32_t y = 1; y <= x; y++) {
            for (uint32_t z = 1; z <= y; z++) {
                uint32_t factors = pattern_factors(x, y, z);
                clast_pattern_cut(&made->shapes[pattern_number(factors)], factors);
            }
        }
    }
    clast_pattern_shapes_mirror(made->shapes);
}

static bool check_table(const table *made)
{
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        const clast_pattern_shape *shape = &made->shapes[i];
        const char *fault = clast_pattern_shape_fault(shape);
        if (fault != NULL) {
            fprintf(stderr, "pattern %u %u %u: %s\n", pattern_factor(shape->factors, 0),
                    pattern_factor(shape->factors, 1), pattern_factor(shape->factors, 2), fault);
            return false;
        }
    }
    uint32_t first, second;
    const char *fault = clast_pattern_shapes_fault(made->shapes, &first, &second);
    if (fault != NULL) {
        fprintf(stderr, "patterns number %u and %u: %s\n", first, second, fault);
    }
    return fault == NULL;
}

// ------------------------------------------------------------------------------------------------------------- C file

static void write_words(FILE *file, const uint32_t *words, uint32_t count, uint32_t *written)
{
    for (uint32_t i = 0; i < count; i++, ++*written) {
        fprintf(file, "%s0x%08x,", *written % 12 == 0 ? "\n    " : " ", words[i]);
    }
}

static void write_table(FILE *file, const table *made)
{
    uint32_t vertices = 0, triangles = 0, written = 0;
    uint64_t hash = 0;
    fprintf(
        file,
        "// SPDX-License-Identifier: Apache-2.0\n// Written by pattern_generate.\n#include \"geometry/pattern.h\"\n\n");
    fprintf(file, "static const clast_pattern patterns[] = {\n");
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        const clast_pattern_shape *shape = &made->shapes[i];
        fprintf(file, "    {%u, %u, 0x%08x},\n", vertices, triangles,
                pattern_counts(shape->factors, shape->triangle_count, shape->vertex_count));
        vertices += shape->vertex_count;
        triangles += shape->triangle_count;
        hash = clast_pattern_shape_hash(hash, shape);
    }
    fprintf(file, "};\n\nstatic const uint32_t vertices[] = {");
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        write_words(file, made->shapes[i].vertices, made->shapes[i].vertex_count, &written);
    }
    fprintf(file, "\n};\n\nstatic const uint32_t triangles[] = {");
    written = 0;
    for (uint32_t i = 0; i < PATTERN_COUNT; i++) {
        write_words(file, made->shapes[i].triangles, made->shapes[i].triangle_count, &written);
    }
    fprintf(file, "\n};\n\nconst clast_pattern_table clast_patterns = {\n");
    fprintf(file, "    patterns, vertices, triangles, %u, %u, 0x%016" PRIx64 "u,\n};\n", vertices, triangles, hash);
}

// ------------------------------------------------------------------------------------------------------------ report

// How well shaped triangles are: angles in degrees, and mean ratios, 1 for an equilateral triangle.
typedef struct quality {
    double least_angle, least_ratio; // of all triangles
    double sum_angle, sum_ratio;     // of the triangles' smallest angles and ratios
    double sum_pattern_angle;        // of the patterns' smallest angles
    uint32_t triangles, patterns;
} quality;

// A point of a triangle whose sides are this long.
static void place(const double sides[3], uint32_t vertex, double point[2])
{
    double x = (sides[0] * sides[0] + sides[2] * sides[2] - sides[1] * sides[1]) / (2.0 * sides[0]);
    double y = sqrt(sides[2] * sides[2] - x * x);
    clast_weights weights = weights_of(vertex);
    point[0] = (weights.of[1] * sides[0] + weights.of[2] * x) / WEIGHT_ONE;
    point[1] = weights.of[2] * y / WEIGHT_ONE;
}

static double measure_triangle(const double sides[3], const uint32_t vertices[3], quality *sum)
{
    double p[3][2], square[3], total = 0.0, least = M_PI;
    for (int k = 0; k < 3; k++) {
        place(sides, vertices[k], p[k]);
    }
    for (int k = 0; k < 3; k++) {
        double x = p[(k + 1) % 3][0] - p[k][0], y = p[(k + 1) % 3][1] - p[k][1];
        square[k] = x * x + y * y;
        total += square[k];
    }
    double area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    for (int k = 0; k < 3; k++) {
        double between = square[k] + square[(k + 1) % 3] - square[(k + 2) % 3];
        double angle = atan2(2.0 * area, between);
        least = angle < least ? angle : least;
    }
    double ratio = 2.0 * sqrt(3.0) * area / total;
    sum->least_ratio = ratio < sum->least_ratio ? ratio : sum->least_ratio;
    sum->sum_ratio += ratio;
    sum->sum_angle += least;
    sum->triangles++;
    return least;
}

static void measure_shape(const double sides[3], const clast_pattern_shape *shape, quality *sum)
{
    double least = M_PI;
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        uint32_t vertices[3];
        for (uint32_t k = 0; k < 3; k++) {
            vertices[k] = shape->vertices[shape->triangles[i] >> (8 * k) & 255u];
        }
        double angle = measure_triangle(sides, vertices, sum);
        least = angle < least ? angle : least;
    }
    sum->least_angle = least < sum->least_angle ? least : sum->least_angle;
    sum->sum_pattern_angle += least;
    sum->patterns++;
}

// What is compared with: the centre joined to all points of the edges.
static void make_fan(uint32_t factors, clast_pattern_shape *fan)
{
    clast_pattern_shape_begin(fan, factors);
    uint32_t centre = fan->vertex_count++, last = 0;
    fan->vertices[centre] = (WEIGHT_ONE / 3) | (WEIGHT_ONE / 3) << 16;
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t begin = pattern_edge_begin(factors, edge), segments = pattern_factor(factors, edge);
        for (uint32_t step = 1; step <= segments; step++) {
            uint32_t next = step == segments ? (edge + 1) % 3 : begin + step - 1;
            fan->triangles[fan->triangle_count++] = last | next << 8 | centre << 16;
            last = next;
        }
    }
}

static void print_quality(const char *where, const char *what, const quality *sum)
{
    const double degrees = 180.0 / M_PI;
    printf("%-26s %-8s %5u %6u %8.1f %8.1f %8.1f %8.3f %8.3f\n", where, what, sum->patterns, sum->triangles,
           sum->least_angle * degrees, sum->sum_pattern_angle * degrees / sum->patterns,
           sum->sum_angle * degrees / sum->triangles, sum->least_ratio, sum->sum_ratio / sum->triangles);
}

static void report(const table *made)
{
    printf("%-26s %-8s %5s %6s %8s %8s %8s %8s %8s\n", "in a triangle", "", "keys", "tris", "angle", "pattern", "mean",
           "ratio", "mean");
    for (int equilateral = 1; equilateral >= 0; equilateral--) {
        quality own = {.least_angle = M_PI, .least_ratio = 1.0}, naive = own;
        for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
            uint32_t factors = made->shapes[i].factors;
            double sides[3] = {1.0, 1.0, 1.0};
            for (uint32_t edge = 0; edge < 3 && !equilateral; edge++) {
                sides[edge] = pattern_factor(factors, edge);
            }
            if (sides[0] < sides[1] + sides[2]) {
                clast_pattern_shape fan;
                make_fan(factors, &fan);
                measure_shape(sides, &made->shapes[i], &own);
                measure_shape(sides, &fan, &naive);
            }
        }
        const char *where = equilateral ? "with equal sides" : "with sides as the counts";
        print_quality(where, "own", &own);
        print_quality(where, "fan", &naive);
    }
}

// ------------------------------------------------------------------------------------------------------------ picture

enum { PICTURE_COLUMNS = 22, PICTURE_SIDE = 200, PICTURE_GAP = 20 };

static void draw_shape(FILE *file, const clast_pattern_shape *shape, bool equilateral, double left, double top)
{
    double sides[3] = {1.0, 1.0, 1.0};
    for (uint32_t edge = 0; edge < 3 && !equilateral; edge++) {
        sides[edge] = pattern_factor(shape->factors, edge);
    }
    double scale = PICTURE_SIDE / sides[0];
    fprintf(file, "<path d=\"");
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            double point[2];
            place(sides, shape->vertices[shape->triangles[i] >> (8 * k) & 255u], point);
            fprintf(file, "%c%.2f %.2f", k == 0 ? 'M' : 'L', left + point[0] * scale, top - point[1] * scale);
        }
        fprintf(file, "Z");
    }
    fprintf(file, "\"/>\n<text x=\"%.0f\" y=\"%.0f\">%u %u %u</text>\n", left, top + 12.0,
            pattern_factor(shape->factors, 0), pattern_factor(shape->factors, 1), pattern_factor(shape->factors, 2));
}

static void draw_table(FILE *file, const table *made, bool equilateral)
{
    uint32_t rows = (PATTERN_ORDERED + PICTURE_COLUMNS - 1) / PICTURE_COLUMNS, side = PICTURE_SIDE + PICTURE_GAP;
    fprintf(
        file,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%u\" height=\"%u\">\n<rect width=\"100%%\" height=\"100%%\" "
        "fill=\"white\"/>\n<g fill=\"none\" stroke=\"black\" font-size=\"12\">\n",
        PICTURE_COLUMNS * side + PICTURE_GAP, rows * side + PICTURE_GAP);
    uint32_t drawn = 0;
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        uint32_t factors = made->shapes[i].factors;
        if (equilateral || pattern_factor(factors, 0) < pattern_factor(factors, 1) + pattern_factor(factors, 2)) {
            draw_shape(file, &made->shapes[i], equilateral, drawn % PICTURE_COLUMNS * side + PICTURE_GAP,
                       (drawn / PICTURE_COLUMNS + 1) * side);
            drawn++;
        }
    }
    fprintf(file, "</g>\n</svg>\n");
}

// --------------------------------------------------------------------------------------------------------------- main

static const char usage[] = "usage: pattern_generate --table FILE.c | --report | --picture FILE.svg [--as-counts]\n";

int main(int count, char **arguments)
{
    static table made;
    bool reports = count == 2 && strcmp(arguments[1], "--report") == 0;
    bool writes = count == 3 && strcmp(arguments[1], "--table") == 0;
    bool as_counts = count == 4 && strcmp(arguments[3], "--as-counts") == 0;
    bool draws = (count == 3 || as_counts) && strcmp(arguments[1], "--picture") == 0;
    if (!reports && !writes && !draws) {
        fputs(usage, stderr);
        return 2;
    }
    make_table(&made);
    if (!check_table(&made)) {
        return 1;
    }
    if (reports) {
        report(&made);
        return fflush(stdout) == 0 ? 0 : 1;
    }
    FILE *file = fopen(arguments[2], "w");
    if (file != NULL && writes) {
        write_table(file, &made);
    } else if (file != NULL) {
        draw_table(file, &made, !as_counts);
    }
    bool failed = file == NULL || ferror(file) != 0;
    if ((file != NULL && fclose(file) != 0) || failed) {
        fprintf(stderr, "%s: %s\n", arguments[2], strerror(errno));
        return 1;
    }
    return 0;
}
