// SPDX-License-Identifier: Apache-2.0
// Meshes for tests of rays, and a small way from a mesh to a tree over clusters.
#ifndef CLAST_TESTS_ACCEL_MESHES_H
#define CLAST_TESTS_ACCEL_MESHES_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "clast/accel.h"

// ------------------------------------------------------------------------------------------------------ random numbers

typedef struct randoms {
    uint64_t state;
} randoms;

static inline uint32_t random_bits(randoms *r)
{
    r->state += 0x9e3779b97f4a7c15u;
    uint64_t x = r->state;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (uint32_t)((x ^ (x >> 31)) >> 32);
}

// [0, 1)
static inline float random_float(randoms *r)
{
    return (float)(random_bits(r) >> 8) * 0x1p-24f;
}

static inline float random_between(randoms *r, float low, float high)
{
    return low + (high - low) * random_float(r);
}

static inline uint32_t random_below(randoms *r, uint32_t end)
{
    return (uint32_t)((uint64_t)random_bits(r) * end >> 32);
}

// ---------------------------------------------------------------------------------------------------------------- mesh

typedef struct mesh {
    float *positions;
    uint32_t *indices;
    uint32_t vertex_count, triangle_count;
} mesh;

static inline void mesh_free(mesh *m)
{
    free(m->positions);
    free(m->indices);
}

static inline mesh mesh_of(uint32_t vertices, uint32_t triangles)
{
    return (mesh){calloc((size_t)vertices + 1, 12), calloc((size_t)triangles + 1, 12), vertices, triangles};
}

static inline void mesh_quad(uint32_t **corner, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    const uint32_t corners[6] = {a, b, c, a, c, d};
    memcpy(*corner, corners, sizeof corners);
    *corner += 6;
}

// A flat grid in the plane z = 0 over [0, 1]^2, raised by random heights.
static inline mesh mesh_terrain(uint32_t side, float height, uint64_t seed)
{
    mesh m = mesh_of((side + 1) * (side + 1), 2 * side * side);
    randoms r = {seed};
    uint32_t *corner = m.indices;
    for (uint32_t j = 0; j <= side; j++) {
        for (uint32_t i = 0; i <= side; i++) {
            float *p = m.positions + 3 * (size_t)(j * (side + 1) + i);
            p[0] = (float)i / (float)side;
            p[1] = (float)j / (float)side;
            p[2] = height * random_float(&r);
        }
    }
    for (uint32_t j = 0; j < side; j++) {
        for (uint32_t i = 0; i < side; i++) {
            uint32_t a = j * (side + 1) + i;
            mesh_quad(&corner, a, a + 1, a + side + 2, a + side + 1);
        }
    }
    return m;
}

// Triangles that do not know of each other, in [-1, 1]^3.
static inline mesh mesh_soup(uint32_t triangles, float size, uint64_t seed)
{
    mesh m = mesh_of(3 * triangles, triangles);
    randoms r = {seed};
    for (uint32_t i = 0; i < triangles; i++) {
        float centre[3] = {random_between(&r, -1, 1), random_between(&r, -1, 1), random_between(&r, -1, 1)};
        for (uint32_t k = 0; k < 3; k++) {
            m.indices[3 * i + k] = 3 * i + k;
            for (uint32_t axis = 0; axis < 3; axis++) {
                m.positions[9 * (size_t)i + 3 * k + axis] = centre[axis] + random_between(&r, -size, size);
            }
        }
    }
    return m;
}

// A closed torus: columns around, rows across.
static inline mesh mesh_torus(uint32_t columns, uint32_t rows, float radius, float tube)
{
    mesh m = mesh_of(columns * rows, 2 * columns * rows);
    uint32_t *corner = m.indices;
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            float a = 6.2831853f * (float)i / (float)columns, b = 6.2831853f * (float)j / (float)rows;
            float *p = m.positions + 3 * (size_t)(j * columns + i);
            p[0] = (radius + tube * cosf(b)) * cosf(a);
            p[1] = (radius + tube * cosf(b)) * sinf(a);
            p[2] = tube * sinf(b);
        }
    }
    for (uint32_t j = 0; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t right = (i + 1) % columns, up = (j + 1) % rows;
            mesh_quad(&corner, j * columns + i, j * columns + right, up * columns + right, up * columns + i);
        }
    }
    return m;
}

// A closed sphere of radius one by latitude and longitude, with a point at each pole.
static inline mesh mesh_sphere(uint32_t columns, uint32_t rows)
{
    uint32_t south = columns * (rows - 1), north = south + 1;
    mesh m = mesh_of(north + 1, 2 * columns * (rows - 1));
    uint32_t *corner = m.indices;
    for (uint32_t j = 1; j < rows; j++) {
        for (uint32_t i = 0; i < columns; i++) {
            float a = 6.2831853f * (float)i / (float)columns, b = 3.1415927f * (float)j / (float)rows;
            float *p = m.positions + 3 * (size_t)((j - 1) * columns + i);
            p[0] = sinf(b) * cosf(a);
            p[1] = sinf(b) * sinf(a);
            p[2] = -cosf(b);
        }
    }
    m.positions[3 * (size_t)south + 2] = -1.0f;
    m.positions[3 * (size_t)north + 2] = 1.0f;
    for (uint32_t i = 0; i < columns; i++) {
        uint32_t right = (i + 1) % columns, top = (rows - 2) * columns;
        const uint32_t caps[6] = {south, right, i, north, top + i, top + right};
        memcpy(corner, caps, sizeof caps);
        corner += 6;
        for (uint32_t j = 0; j + 2 < rows; j++) {
            mesh_quad(&corner, j * columns + i, j * columns + right, (j + 1) * columns + right, (j + 1) * columns + i);
        }
    }
    return m;
}

// Halves the edges of all triangles; new points go to the sphere around the origin through the edge's ends.
static inline mesh mesh_subdivide(const mesh *m)
{
    uint32_t edges = 3 * m->triangle_count, slots = 4 * edges, next = m->vertex_count;
    mesh fine = mesh_of(m->vertex_count + edges, 4 * m->triangle_count);
    memcpy(fine.positions, m->positions, (size_t)m->vertex_count * 12);
    uint32_t *table = calloc(slots, 12); // lower end, upper end, middle plus one
    uint32_t *corner = fine.indices;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        const uint32_t *v = m->indices + 3 * (size_t)i;
        uint32_t middle[3];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t a = v[k] < v[(k + 1) % 3] ? v[k] : v[(k + 1) % 3], b = v[k] ^ v[(k + 1) % 3] ^ a;
            uint32_t slot = (a * 2654435761u ^ b * 40503u) % slots;
            while (table[3 * slot + 2] != 0 && (table[3 * slot] != a || table[3 * slot + 1] != b)) {
                slot = (slot + 1) % slots;
            }
            if (table[3 * slot + 2] == 0) {
                const float *p = m->positions + 3 * (size_t)a, *q = m->positions + 3 * (size_t)b;
                float sum[3] = {p[0] + q[0], p[1] + q[1], p[2] + q[2]};
                float radius = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
                float scale = radius / sqrtf(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
                for (uint32_t axis = 0; axis < 3; axis++) {
                    fine.positions[3 * (size_t)next + axis] = sum[axis] * scale;
                }
                const uint32_t entry[3] = {a, b, ++next};
                memcpy(table + 3 * (size_t)slot, entry, sizeof entry);
            }
            middle[k] = table[3 * slot + 2] - 1;
        }
        const uint32_t corners[12] = {v[0],      middle[0], middle[2], middle[0], v[1],      middle[1],
                                      middle[2], middle[1], v[2],      middle[0], middle[1], middle[2]};
        memcpy(corner, corners, sizeof corners);
        corner += 12;
    }
    free(table);
    fine.vertex_count = next;
    return fine;
}

// A closed sphere of radius one from an octahedron: many edges lie in the planes of the axes.
static inline mesh mesh_octasphere(uint32_t levels)
{
    static const float points[18] = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
    static const uint32_t faces[24] = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
    mesh m = mesh_of(6, 8);
    memcpy(m.positions, points, sizeof points);
    memcpy(m.indices, faces, sizeof faces);
    for (uint32_t i = 0; i < levels; i++) {
        mesh fine = mesh_subdivide(&m);
        mesh_free(&m);
        m = fine;
    }
    return m;
}

// Moves each vertex along its direction from the origin by up to `amount` of its distance: a mesh that is seen from the
// origin stays so.
static inline void mesh_displace(mesh *m, float amount, uint64_t seed)
{
    randoms r = {seed};
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        float factor = 1.0f + random_between(&r, -amount, amount);
        for (uint32_t axis = 0; axis < 3; axis++) {
            m->positions[3 * (size_t)i + axis] *= factor;
        }
    }
}

static inline void mesh_transform(mesh *m, float scale, float x, float y, float z)
{
    const float offset[3] = {x, y, z};
    for (size_t i = 0; i < 3 * (size_t)m->vertex_count; i++) {
        m->positions[i] = m->positions[i] * scale + offset[i % 3];
    }
}

// ------------------------------------------------------------------------------------------------------------ clusters

// A mesh in clusters of consecutive triangles, as a BLAS.
typedef struct clustered {
    clast_template_set *set;
    clast_clas_pool *pool;
    clast_blas *blas;
    float *vertices;          // of all clusters
    uint32_t *vertex_sources; // their numbers in the mesh
    uint32_t vertex_count;
    uint32_t *first_triangles; // of each cluster, in the mesh
    uint32_t cluster_count;
} clustered;

// Cuts off as many triangles as fit; gives how many. `local` has a number for each vertex of the mesh, or 256.
static inline uint32_t cluster_cut(const mesh *m, uint32_t first, uint32_t most, uint16_t *local, uint8_t *indices,
                                   uint32_t *sources, uint32_t *source_count)
{
    uint32_t count = 0;
    *source_count = 0;
    for (; first + count < m->triangle_count && count < most; count++) {
        const uint32_t *v = m->indices + 3 * (size_t)(first + count);
        if (*source_count + 3 > 256) {
            break;
        }
        for (uint32_t k = 0; k < 3; k++) {
            if (local[v[k]] == 256) {
                local[v[k]] = (uint16_t)*source_count;
                sources[(*source_count)++] = v[k];
            }
            indices[3 * count + k] = (uint8_t)local[v[k]];
        }
    }
    for (uint32_t i = 0; i < *source_count; i++) {
        local[sources[i]] = 256;
    }
    return count;
}

static inline void clustered_gather(clustered *c, const mesh *m)
{
    for (uint32_t i = 0; i < c->vertex_count; i++) {
        memcpy(c->vertices + 3 * (size_t)i, m->positions + 3 * (size_t)c->vertex_sources[i], 12);
    }
}

static inline clast_status clustered_fill(clustered *c, const mesh *m, uint32_t most)
{
    uint8_t *indices = malloc(3 * (size_t)m->triangle_count + 3);
    uint16_t *local = malloc(sizeof *local * ((size_t)m->vertex_count + 1));
    clast_template_desc *descs = calloc((size_t)m->triangle_count + 1, sizeof *descs);
    clast_clas_input *inputs = calloc((size_t)m->triangle_count + 1, sizeof *inputs);
    for (uint32_t i = 0; i < m->vertex_count; i++) {
        local[i] = 256;
    }
    for (uint32_t first = 0; first < m->triangle_count; c->cluster_count++) {
        uint32_t sources = 0;
        clast_template_desc *desc = &descs[c->cluster_count];
        c->first_triangles[c->cluster_count] = first;
        desc->indices = indices + 3 * (size_t)first;
        desc->triangle_count = cluster_cut(m, first, most, local, indices + 3 * (size_t)first,
                                           c->vertex_sources + c->vertex_count, &sources);
        desc->vertex_count = sources;
        desc->rest_positions = inputs[c->cluster_count].vertices = c->vertices + 3 * (size_t)c->vertex_count;
        c->vertex_count += sources;
        first += desc->triangle_count;
    }
    clustered_gather(c, m);
    uint32_t number = 0;
    clast_status status = clast_template_set_add(c->set, descs, c->cluster_count, &number);
    for (uint32_t i = 0; i < c->cluster_count; i++) {
        inputs[i].template_number = number + i;
    }
    if (status == CLAST_OK) {
        status = clast_clas_instantiate(c->pool, 0, c->cluster_count, inputs);
    }
    free(indices);
    free(local);
    free(descs);
    free(inputs);
    return status == CLAST_OK ? clast_blas_build(c->blas, NULL, c->cluster_count, CLAST_BUILD_BEST) : status;
}

static inline clast_status clustered_make(clast_context *context, const mesh *m, uint32_t most, clustered *c)
{
    *c = (clustered){
        .vertices = malloc(36 * (size_t)m->triangle_count + 12),
        .vertex_sources = malloc(12 * (size_t)m->triangle_count + 12),
        .first_triangles = malloc(4 * (size_t)m->triangle_count + 4),
    };
    clast_status status = clast_template_set_create(context, &c->set);
    status = status == CLAST_OK ? clast_clas_pool_create(c->set, &c->pool) : status;
    status = status == CLAST_OK ? clast_blas_create(c->pool, &c->blas) : status;
    return status == CLAST_OK ? clustered_fill(c, m, most) : status;
}

static inline void clustered_free(clustered *c)
{
    clast_blas_destroy(c->blas);
    clast_clas_pool_destroy(c->pool);
    clast_template_set_destroy(c->set);
    free(c->vertices);
    free(c->vertex_sources);
    free(c->first_triangles);
}

static inline clast_tlas_instance instance_of(const clast_blas *blas, uint32_t id)
{
    return (clast_tlas_instance){.blas = blas, .transform = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}, .id = id};
}

#endif
