// SPDX-License-Identifier: Apache-2.0
// Whether a mesh is closed.
#ifndef CLAST_TESTS_CLOSED_H
#define CLAST_TESTS_CLOSED_H

#include "test.h"

#include "clast/geometry.h"
#include "clast/scene.h"

// Each side of a triangle is another's, the other way round: by positions.
static inline void assert_closed(clast_context *context, const clast_mesh *mesh, bool by_index)
{
    uint32_t *remap = malloc(mesh->vertex_count * sizeof *remap);
    size_t unique, sides = 3 * (size_t)mesh->triangle_count;
    assert_ok(context, clast_weld_positions(context, mesh->positions, mesh->vertex_count, remap, &unique));
    if (by_index) {
        assert_int_equal(unique, mesh->vertex_count);
    }
    uint64_t *ways = malloc(sides * sizeof *ways); // an open hash table of sides
    size_t size = 1;
    while (size < 2 * sides) {
        size *= 2;
    }
    uint64_t *table = calloc(size, sizeof *table);
    for (size_t i = 0; i < sides; i++) {
        uint32_t a = remap[mesh->indices[i]], b = remap[mesh->indices[i - i % 3 + (i + 1) % 3]];
        assert_int_not_equal(a, b);
        ways[i] = ((uint64_t)a << 32 | b) + 1;
        size_t at = (ways[i] * 0x9e3779b97f4a7c15u) >> 20 & (size - 1);
        while (table[at] != 0) {
            assert_true(table[at] != ways[i]); // no side twice
            at = (at + 1) & (size - 1);
        }
        table[at] = ways[i];
    }
    for (size_t i = 0; i < sides; i++) {
        uint64_t back = ((ways[i] - 1) << 32 | (ways[i] - 1) >> 32) + 1;
        size_t at = (back * 0x9e3779b97f4a7c15u) >> 20 & (size - 1);
        while (table[at] != back) {
            assert_true(table[at] != 0);
            at = (at + 1) & (size - 1);
        }
    }
    free(table);
    free(ways);
    free(remap);
}

#endif
