// SPDX-License-Identifier: Apache-2.0
#include "geometry/pattern_shape.h"

#include <string.h>

#include "geometry/blocks.h"

enum { NO_SIDE = 0, INNER_SIDE = 1, BORDER_SIDE = 2 };

void clast_pattern_shape_begin(clast_pattern_shape *shape, uint32_t factors)
{
    shape->factors = factors;
    shape->triangle_count = 0;
    shape->vertex_count = pattern_edge_begin(factors, 3);
    for (uint32_t edge = 0; edge < 3; edge++) {
        uint32_t segments = pattern_factor(factors, edge), begin = pattern_edge_begin(factors, edge);
        shape->vertices[edge] = weights_word(pattern_edge_point(edge, segments, 0));
        for (uint32_t step = 1; step < segments; step++) {
            shape->vertices[begin + step - 1] = weights_word(pattern_edge_point(edge, segments, step));
        }
    }
}

// Where an edge's point is among the vertices; steps 0 and `segments` are its corners.
static uint32_t edge_vertex(uint32_t factors, uint32_t edge, uint32_t step)
{
    if (step == 0) {
        return edge;
    }
    if (step == pattern_factor(factors, edge)) {
        return (edge + 1) % 3;
    }
    return pattern_edge_begin(factors, edge) + step - 1;
}

static uint32_t corner_of(const clast_pattern_shape *shape, uint32_t triangle, uint32_t corner)
{
    return shape->triangles[triangle] >> (8 * corner) & 255u;
}

// ------------------------------------------------------------------------------------------------------------ checks

static const char *points_fault(const clast_pattern_shape *shape)
{
    uint32_t around = pattern_edge_begin(shape->factors, 3);
    if (shape->vertex_count < around || shape->vertex_count > PATTERN_VERTICES) {
        return "it has more vertices than are possible";
    }
    if (shape->triangle_count > PATTERN_TRIANGLES ||
        shape->triangle_count != pattern_triangles_of(shape->factors, shape->vertex_count - around)) {
        return "its triangles are not as many as its points need";
    }
    for (uint32_t i = around; i < shape->vertex_count; i++) {
        uint32_t second = shape->vertices[i] & 65535u, third = shape->vertices[i] >> 16;
        if (second == 0 || third == 0 || second + third >= WEIGHT_ONE) {
            return "a point lies not within the triangle";
        }
    }
    return NULL;
}

static const char *corners_fault(const clast_pattern_shape *shape)
{
    bool used[PATTERN_VERTICES] = {false};
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        uint32_t corner[3];
        for (uint32_t k = 0; k < 3; k++) {
            corner[k] = corner_of(shape, i, k);
            if (corner[k] >= shape->vertex_count) {
                return "a triangle's corner is none of its vertices";
            }
            used[corner[k]] = true;
        }
        const uint32_t *vertices = shape->vertices;
        if (clast_pattern_area(vertices[corner[0]], vertices[corner[1]], vertices[corner[2]]) <= 0) {
            return "a triangle has no area, or goes clockwise";
        }
    }
    for (uint32_t i = 0; i < shape->vertex_count; i++) {
        if (!used[i]) {
            return "a vertex belongs to no triangle";
        }
    }
    return NULL;
}

static const char *sides_fault(const clast_pattern_shape *shape)
{
    uint8_t sides[PATTERN_VERTICES][PATTERN_VERTICES] = {{NO_SIDE}}; // by the vertices from and to which they go
    for (uint32_t edge = 0; edge < 3; edge++) {
        for (uint32_t step = 0; step < pattern_factor(shape->factors, edge); step++) {
            sides[edge_vertex(shape->factors, edge, step + 1)][edge_vertex(shape->factors, edge, step)] = BORDER_SIDE;
        }
    }
    for (uint32_t i = 0; i < 3 * shape->triangle_count; i++) {
        uint8_t *side = &sides[corner_of(shape, i / 3, i % 3)][corner_of(shape, i / 3, (i + 1) % 3)];
        if (*side != NO_SIDE) {
            return "two triangles lie on one side of a line";
        }
        *side = INNER_SIDE;
    }
    for (uint32_t a = 0; a < shape->vertex_count; a++) {
        for (uint32_t b = 0; b < shape->vertex_count; b++) {
            if ((sides[a][b] != NO_SIDE) != (sides[b][a] != NO_SIDE)) {
                return "a triangle's side is neither another's nor an edge's segment";
            }
        }
    }
    return NULL;
}

const char *clast_pattern_shape_fault(const clast_pattern_shape *shape)
{
    const char *fault = points_fault(shape);
    fault = fault != NULL ? fault : corners_fault(shape);
    return fault != NULL ? fault : sides_fault(shape);
}

static uint32_t inside_count(const clast_pattern_shape *shape)
{
    return shape->vertex_count - pattern_edge_begin(shape->factors, 3);
}

const char *clast_pattern_shapes_fault(const clast_pattern_shape *shapes, uint32_t *first, uint32_t *second)
{
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        uint32_t factors = shapes[i].factors;
        *first = *second = i;
        if (pattern_factor(factors, 0) <= 2 && inside_count(&shapes[i]) != 0) {
            return "there may be no points inside up to 2 segments an edge";
        }
        for (uint32_t edge = 0; edge < 3; edge++) {
            uint32_t next = edge == 2 ? 0 : pattern_factor(factors, edge + 1); // counts stay in order
            if (pattern_factor(factors, edge) > 1 && pattern_factor(factors, edge) > next) {
                *second = pattern_number(factors - (1u << (4 * edge)));
                if (inside_count(&shapes[*second]) > inside_count(&shapes[i])) {
                    return "it has fewer points inside than one of fewer segments";
                }
            }
        }
    }
    return NULL;
}

// ------------------------------------------------------------------------------------------------------------- orders

// The box around a triangle of the pattern in an equilateral triangle.
static step_box box_around(const clast_pattern_shape *shape, uint32_t triangle)
{
    const float scale = STEP_BOX_STEPS / (float)WEIGHT_ONE, height = 0.8660254f;
    lanes lower = box_none_lower(), upper = box_none_upper();
    for (uint32_t k = 0; k < 3; k++) {
        clast_weights weights = weights_of(shape->vertices[corner_of(shape, triangle, k)]);
        float x = (float)weights.of[1] + 0.5f * (float)weights.of[2], y = (float)weights.of[2] * height;
        const float point[4] = {x * scale, y * scale, 0.0f, 0.0f};
        lower = lanes_min(lower, lanes_load(point));
        upper = lanes_max(upper, lanes_load(point));
    }
    return step_box_from(lower, upper);
}

// So that it does not matter how they stood before.
static void sort_words(uint32_t *words, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint32_t word = words[i], at = i;
        for (; at > 0 && words[at - 1] > word; at--) {
            words[at] = words[at - 1];
        }
        words[at] = word;
    }
}

void clast_pattern_shape_order(clast_pattern_shape *shape)
{
    sort_words(shape->triangles, shape->triangle_count);
    SORTED_ROOM(PATTERN_TRIANGLES) room;
    sorted_boxes sorted = SORTED_IN(&room);
    uint16_t order[PATTERN_TRIANGLES];
    uint32_t triangles[PATTERN_TRIANGLES];
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        sorted.box[i] = box_around(shape, i);
    }
    clast_boxes_sort(&sorted, shape->triangle_count);
    clast_boxes_order_blocks(&sorted, 0, shape->triangle_count, order);
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        triangles[i] = shape->triangles[order[i]];
    }
    memcpy(shape->triangles, triangles, shape->triangle_count * sizeof *triangles);
}

// ------------------------------------------------------------------------------------------------------- whole tables

static uint32_t mirrored_factors(uint32_t factors)
{
    return pattern_factors(pattern_factor(factors, 0), pattern_factor(factors, 2), pattern_factor(factors, 1));
}

// Edge 0 stays, seen from its other end; edges 1 and 2 exchange, likewise.
static uint32_t mirrored_vertex(uint32_t factors, uint32_t vertex)
{
    static const uint8_t other_edge[3] = {0, 2, 1}, other_corner[3] = {1, 0, 2};
    if (vertex < 3) {
        return other_corner[vertex];
    }
    for (uint32_t edge = 0; edge < 3; edge++) {
        if (vertex < pattern_edge_begin(factors, edge + 1)) {
            uint32_t step = vertex - pattern_edge_begin(factors, edge) + 1;
            return edge_vertex(mirrored_factors(factors), other_edge[edge], pattern_factor(factors, edge) - step);
        }
    }
    return vertex; // those inside follow in the same order
}

static void mirror_shape(const clast_pattern_shape *shape, clast_pattern_shape *image)
{
    uint32_t factors = shape->factors;
    clast_pattern_shape_begin(image, mirrored_factors(factors));
    for (uint32_t i = image->vertex_count; i < shape->vertex_count; i++) {
        clast_weights weights = weights_of(shape->vertices[i]);
        clast_weights exchanged = {{weights.of[1], weights.of[0], weights.of[2]}};
        image->vertices[i] = weights_word(exchanged);
    }
    image->vertex_count = shape->vertex_count;
    image->triangle_count = shape->triangle_count;
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        uint32_t a = mirrored_vertex(factors, corner_of(shape, i, 0));
        uint32_t b = mirrored_vertex(factors, corner_of(shape, i, 1));
        image->triangles[i] = b | a << 8 | mirrored_vertex(factors, corner_of(shape, i, 2)) << 16;
    }
}

void clast_pattern_shapes_mirror(clast_pattern_shape *shapes)
{
    for (uint32_t i = 0; i < PATTERN_ORDERED; i++) {
        uint32_t image = pattern_number(mirrored_factors(shapes[i].factors));
        if (image >= PATTERN_ORDERED && pattern_factor(shapes[i].factors, 0) > pattern_factor(shapes[i].factors, 1)) {
            mirror_shape(&shapes[i], &shapes[image]);
        }
    }
}

static uint64_t mix_word(uint64_t hash, uint32_t word)
{
    hash ^= word;
    hash = (hash ^ hash >> 33) * 0xff51afd7ed558ccdu;
    hash = (hash ^ hash >> 33) * 0xc4ceb9fe1a85ec53u;
    return hash ^ hash >> 33;
}

uint64_t clast_pattern_shape_hash(uint64_t hash, const clast_pattern_shape *shape)
{
    hash = mix_word(hash, shape->factors | shape->triangle_count << 12 | shape->vertex_count << 20);
    for (uint32_t i = 0; i < shape->vertex_count; i++) {
        hash = mix_word(hash, shape->vertices[i]);
    }
    for (uint32_t i = 0; i < shape->triangle_count; i++) {
        hash = mix_word(hash, shape->triangles[i]);
    }
    return hash;
}
