// SPDX-License-Identifier: Apache-2.0
// What must hold of any mesh's clusters, and meshes to try it on.
#ifndef CLAST_TESTS_GEOMETRY_CLUSTERS_H
#define CLAST_TESTS_GEOMETRY_CLUSTERS_H

#include "test.h"

#include <math.h>
#include <string.h>

#include "clast/geometry.h"

typedef struct mesh {
    float *positions;
    size_t position_count;
    uint32_t *indices;
    size_t triangle_count;
} mesh;

static inline mesh mesh_make(size_t positions, size_t triangles)
{
    return (mesh){
        .positions = calloc(positions + 1, 3 * sizeof(float)),
        .position_count = positions,
        .indices = calloc(triangles + 1, 3 * sizeof(uint32_t)),
        .triangle_count = triangles,
    };
}

static inline void mesh_free(mesh *m)
{
    free(m->positions);
    free(m->indices);
}

// Numbers that are the same everywhere (Marsaglia 2003, xorshift).
static inline uint32_t next_number(uint32_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return *state;
}

static inline float next_unit(uint32_t *state)
{
    return (float)(next_number(state) >> 8) * (1.0f / 16777216.0f);
}

static inline void set_position(mesh *m, size_t i, float x, float y, float z)
{
    m->positions[3 * i] = x;
    m->positions[3 * i + 1] = y;
    m->positions[3 * i + 2] = z;
}

// A hilly sheet of columns * rows quads.
static inline mesh mesh_grid(uint32_t columns, uint32_t rows)
{
    mesh m = mesh_make((size_t)(columns + 1) * (rows + 1), (size_t)columns * rows * 2);
    for (uint32_t y = 0; y <= rows; y++) {
        for (uint32_t x = 0; x <= columns; x++) {
            set_position(&m, (size_t)y * (columns + 1) + x, (float)x, (float)y,
                         3.0f * sinf((float)x * 0.1f) * cosf((float)y * 0.13f));
        }
    }
    uint32_t *corner = m.indices;
    for (uint32_t y = 0; y < rows; y++) {
        for (uint32_t x = 0; x < columns; x++) {
            uint32_t a = y * (columns + 1) + x, b = a + columns + 1;
            uint32_t quad[6] = {a, b, b + 1, a, b + 1, a + 1};
            memcpy(corner, quad, sizeof quad);
            corner += 6;
        }
    }
    return m;
}

// Triangles that share nothing.
static inline mesh mesh_soup(size_t triangles, uint32_t seed)
{
    mesh m = mesh_make(3 * triangles, triangles);
    uint32_t state = seed;
    for (size_t i = 0; i < triangles; i++) {
        float x = next_unit(&state), y = next_unit(&state), z = next_unit(&state);
        for (size_t k = 0; k < 3; k++) {
            float dx = next_unit(&state), dy = next_unit(&state), dz = next_unit(&state);
            set_position(&m, 3 * i + k, x + 0.02f * dx, y + 0.02f * dy, z + 0.02f * dz);
            m.indices[3 * i + k] = (uint32_t)(3 * i + k);
        }
    }
    return m;
}

// Any indices into few or many positions.
static inline mesh mesh_random(size_t positions, size_t triangles, uint32_t seed)
{
    mesh m = mesh_make(positions, triangles);
    uint32_t state = seed;
    for (size_t i = 0; i < 3 * positions; i++) {
        m.positions[i] = next_unit(&state);
    }
    for (size_t i = 0; i < 3 * triangles; i++) {
        m.indices[i] = next_number(&state) % (uint32_t)positions;
    }
    return m;
}

static inline clast_clusterize_desc desc_of(const mesh *m, uint32_t max_triangles, uint32_t max_vertices)
{
    return (clast_clusterize_desc){m->positions,      m->position_count, m->indices,
                                   m->triangle_count, max_triangles,     max_vertices};
}

// Average of how full the clusters are of what limits them.
static inline double cluster_fill(const clast_clusters *c, uint32_t max_triangles, uint32_t max_vertices)
{
    double sum = 0.0;
    for (size_t i = 0; i < c->cluster_count; i++) {
        double triangles = (double)c->clusters[i].triangle_count / max_triangles;
        double vertices = (double)c->clusters[i].vertex_count / max_vertices;
        sum += triangles > vertices ? triangles : vertices;
    }
    return c->cluster_count != 0 ? sum / (double)c->cluster_count : 1.0;
}

static inline void check_cluster(const clast_clusterize_desc *desc, const clast_clusters *c,
                                 const clast_cluster *cluster, uint8_t *seen)
{
    uint8_t used[256] = {0};
    for (uint32_t t = 0; t < cluster->triangle_count; t++) {
        size_t place = (size_t)cluster->first_triangle + t;
        uint32_t triangle = c->triangles[place];
        assert_true(triangle < desc->triangle_count);
        assert_int_equal(seen[triangle]++, 0);
        for (uint32_t k = 0; k < 3; k++) {
            uint8_t local = c->indices[3 * place + k];
            assert_true(local < cluster->vertex_count);
            used[local] = 1;
            assert_int_equal(c->vertices[(size_t)cluster->first_vertex + local],
                             desc->indices[3 * (size_t)triangle + k]);
        }
    }
    for (uint32_t v = 0; v < cluster->vertex_count; v++) {
        assert_int_equal(used[v], 1);
        for (uint32_t w = 0; w < v; w++) {
            assert_int_not_equal(c->vertices[cluster->first_vertex + v], c->vertices[cluster->first_vertex + w]);
        }
    }
}

// Every triangle once, with its corners as they were; limits kept; ranges without gaps; vertices unique and all used.
static inline void check_clusters(const clast_clusterize_desc *desc, const clast_clusters *c)
{
    uint32_t max_triangles = desc->max_triangles != 0 ? desc->max_triangles : 128;
    uint32_t max_vertices = desc->max_vertices != 0 ? desc->max_vertices : 128;
    uint8_t *seen = calloc(desc->triangle_count + 1, 1);
    size_t triangles = 0, vertices = 0;
    for (size_t i = 0; i < c->cluster_count; i++) {
        const clast_cluster *cluster = &c->clusters[i];
        assert_int_equal(cluster->first_triangle, triangles);
        assert_int_equal(cluster->first_vertex, vertices);
        assert_in_range(cluster->triangle_count, 1, max_triangles);
        assert_in_range(cluster->vertex_count, 1, max_vertices);
        check_cluster(desc, c, cluster, seen);
        triangles += cluster->triangle_count;
        vertices += cluster->vertex_count;
    }
    assert_int_equal(triangles, desc->triangle_count);
    assert_int_equal(vertices, c->vertex_count);
    free(seen);
}

static inline bool clusters_equal(const clast_clusters *a, const clast_clusters *b, size_t triangles)
{
    return a->cluster_count == b->cluster_count && a->vertex_count == b->vertex_count &&
           memcmp(a->clusters, b->clusters, a->cluster_count * sizeof *a->clusters) == 0 &&
           memcmp(a->triangles, b->triangles, triangles * sizeof *a->triangles) == 0 &&
           memcmp(a->indices, b->indices, triangles * 3) == 0 &&
           memcmp(a->vertices, b->vertices, a->vertex_count * sizeof *a->vertices) == 0;
}

#endif
